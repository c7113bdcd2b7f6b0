//! Tangent vectors: small deviations of the state of all bodies, carried through flights and
//! contacts.
//!
//! Each vector has the deviations of all coordinates. Those of a body are kept at the time of its
//! last contact, as the engine keeps its motion (subjective time).

use std::{collections::BTreeMap, f64::consts::PI, ops::Range};

use carom_engine::{BodyView, View};
use carom_kinematics::EpochTime;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::contact_map::{BodyDeviation, ContactMap};

/// The vectors are made orthonormal again once the first has grown by this factor. The last, which
/// shrinks by as much, is then known to 10⁻¹² of its length.
const MAX_GROWTH: f64 = 100.0;

/// With less than this share of the relative velocity along the normal, a contact may stretch so
/// much that the vectors must be made orthonormal before it.
const GRAZING: f64 = 0.1;

/// A vector of which less than this share is left after its components along the earlier ones are
/// removed is rounding alone.
const RANK_TOLERANCE: f64 = 1e-13;

/// Orthonormal vectors that deviate from one another as they follow the bodies.
///
/// Lengths and orthogonality are those of Σ [m δr²/τ² + I δθ²/τ² + m δv² + I δω²]. The exponents
/// do not depend on the norm; in this one, with coordinates and momenta alike, those of a system
/// without losses pair at any time.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct TangentSpace {
    bodies: BTreeMap<u64, BodyRows>,
    /// Number of vectors.
    count: usize,
    /// The row of a coordinate has its component in each vector. The rows of a body follow one
    /// another: coordinates, then velocities.
    rows: Vec<f64>,
    /// Weight of each row in the norm.
    weights: Vec<f64>,
    /// Square of the norm of the first vector, with each body at its own time.
    squared_norm: f64,
    /// ln of the growth of each vector, since it was last taken.
    logs: Vec<f64>,
    /// Vectors that were rounding alone, and were replaced.
    replaced: u64,
}

/// Where the deviations of a body are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct BodyRows {
    first: usize,
    /// Whether it has an orientation.
    turns: bool,
    /// The time of its deviations.
    since: EpochTime,
}

impl BodyRows {
    fn range(self) -> Range<usize> {
        self.first..self.first + 2 * self.coordinates()
    }

    fn coordinates(self) -> usize {
        if self.turns { 3 } else { 2 }
    }
}

/// Number of components of a vector: coordinates and velocities of the free bodies.
pub(super) fn dimension(view: &View<'_>) -> usize {
    view.bodies().map(|body| 2 * coordinates(&body)).sum()
}

fn coordinates(body: &BodyView<'_>) -> usize {
    match (body.body.is_free(), body.body.can_turn()) {
        (false, _) => 0,
        (true, false) => 2,
        (true, true) => 3,
    }
}

impl TangentSpace {
    /// Orthonormal vectors, at most as many as there are components.
    pub(super) fn new(view: &View<'_>, count: usize) -> Self {
        let dimension = dimension(view);
        let count = count.min(dimension);
        let mut space = Self {
            bodies: BTreeMap::new(),
            count,
            rows: vec![0.0; dimension * count],
            weights: Vec::with_capacity(dimension),
            squared_norm: 1.0,
            logs: vec![0.0; count],
            replaced: 0,
        };
        let rate = rate(view);
        for body in view.bodies().filter(|body| body.body.is_free()) {
            let rows = BodyRows {
                first: space.weights.len(),
                turns: body.body.can_turn(),
                since: view.time(),
            };
            let inertia = body.body.inertia();
            let [mass, moment] =
                [inertia.inverse_mass, inertia.inverse_moment].map(|inverse| inverse.powf(-0.5));
            let of_velocities = &[mass, mass, moment][..rows.coordinates()];
            space
                .weights
                .extend(of_velocities.iter().map(|weight| weight * rate));
            space.weights.extend(of_velocities);
            space.bodies.insert(body.body.id(), rows);
        }
        space.set_initial_vectors();
        space
    }

    /// Whether these are the vectors of the bodies in this view.
    pub(super) fn matches(&self, view: &View<'_>) -> bool {
        let mut free = view.bodies().filter(|body| body.body.is_free());
        let is_known = |body: BodyView<'_>| {
            let rows = self.bodies.get(&body.body.id());
            rows.is_some_and(|rows| rows.turns == body.body.can_turn())
        };
        self.weights.len() == dimension(view) && free.all(is_known)
    }

    /// Number of vectors so far that were rounding alone, and were replaced.
    pub(super) fn replaced(&self) -> u64 {
        self.replaced
    }

    /// Orthonormal vectors of which the i-th and the (D + 1 − i)-th have coordinates and momenta
    /// exchanged, with one sign changed: exact flights and elastic contacts keep that.
    ///
    /// The columns of a unitary matrix are such: real parts as coordinates, imaginary ones as
    /// momenta. That of the discrete Fourier transform, with a further phase for each coordinate,
    /// has no direction that a system prefers.
    fn set_initial_vectors(&mut self) {
        let half = self.weights.len() / 2;
        let bodies: Vec<BodyRows> = self.bodies.values().copied().collect();
        let pairs = bodies.iter().flat_map(|rows| {
            let count = rows.coordinates();
            (0..count).map(move |n| [rows.first + n, rows.first + count + n])
        });
        let length = (half as f64).sqrt().recip();
        for (index, [coordinate, momentum]) in pairs.enumerate() {
            for column in 0..self.count {
                let of_pair = column.min(2 * half - 1 - column);
                let turns = (of_pair * index % half) as f64 / half as f64;
                let (sine, cosine) = libm::sincos(2.0 * PI * turns + (index * index) as f64);
                let pair = if column < half {
                    [cosine, sine]
                } else {
                    [sine, -cosine]
                };
                for (row, value) in [coordinate, momentum].into_iter().zip(pair) {
                    self.rows[row * self.count + column] = length * value / self.weights[row];
                }
            }
        }
    }

    /// Carries the deviations of two bodies, by number, through their contact at this time, given
    /// its derivative.
    pub(super) fn apply_contact(&mut self, bodies: [u64; 2], time: EpochTime, map: &ContactMap) {
        if map.approach() < GRAZING && self.stretches(bodies, map.approach()) {
            self.orthonormalise(time);
        }
        let places = bodies.map(|id| {
            let rows = self.bodies.get_mut(&id)?;
            let flight = time.since(std::mem::replace(&mut rows.since, time));
            Some((*rows, flight))
        });
        let share_before = self.share_of(bodies, 0);
        for column in 0..self.count {
            let before = places.map(|place| {
                place.map_or_else(BodyDeviation::default, |(rows, flight)| {
                    self.deviation(rows, column, flight)
                })
            });
            let after = map.apply(before);
            for (place, deviation) in places.iter().zip(after) {
                if let Some((rows, _)) = place {
                    self.set(*rows, column, &deviation);
                }
            }
        }
        self.squared_norm += self.share_of(bodies, 0) - share_before;
        if self.squared_norm > MAX_GROWTH * MAX_GROWTH {
            self.orthonormalise(time);
        }
    }

    /// Whether a contact of these bodies with a small share `approach` of the relative velocity
    /// along the normal may stretch a vector by more than the allowed growth: about their share of
    /// it over `approach`.
    fn stretches(&self, bodies: [u64; 2], approach: f64) -> bool {
        let allowed = (MAX_GROWTH * approach).powi(2);
        (0..self.count).any(|column| self.share_of(bodies, column) > allowed)
    }

    /// The share of two bodies in the square of the norm of a vector.
    fn share_of(&self, bodies: [u64; 2], column: usize) -> f64 {
        let known = bodies.iter().filter_map(|id| self.bodies.get(id));
        let square = |row: usize| {
            let term = self.weights[row] * self.at(row, column);
            term * term
        };
        known.flat_map(|rows| rows.range()).map(square).sum()
    }

    /// Makes the vectors orthonormal at this time, and takes ln of the growth of each since the
    /// last call.
    pub(super) fn take_growth(&mut self, time: EpochTime) -> Vec<f64> {
        self.orthonormalise(time);
        std::mem::replace(&mut self.logs, vec![0.0; self.count])
    }

    /// The first vector, body by body: place, orientation, velocity, angular velocity.
    #[cfg(test)]
    pub(super) fn first_vector(&self) -> Vec<[f64; 6]> {
        let of = |rows: &BodyRows| {
            let BodyDeviation {
                position,
                angle,
                velocity,
                spin,
            } = self.deviation(*rows, 0, 0.0);
            [position.x, position.y, angle, velocity.x, velocity.y, spin]
        };
        self.bodies.values().map(of).collect()
    }

    /// Component of a vector, by its row.
    fn at(&self, row: usize, column: usize) -> f64 {
        self.rows[row * self.count + column]
    }

    /// The deviation of a body in one vector after a free flight.
    fn deviation(&self, rows: BodyRows, column: usize, flight: f64) -> BodyDeviation {
        let (first, coordinates) = (rows.first, rows.coordinates());
        let at = |row: usize| self.at(first + row, column);
        let velocity = DVec2::new(at(coordinates), at(coordinates + 1));
        let [angle, spin] = if rows.turns { [at(2), at(5)] } else { [0.0; 2] };
        BodyDeviation {
            position: DVec2::new(at(0), at(1)) + flight * velocity,
            angle: angle + flight * spin,
            velocity,
            spin,
        }
    }

    fn set(&mut self, rows: BodyRows, column: usize, to: &BodyDeviation) {
        let (place, velocity) = (to.position, to.velocity);
        let with_angle = [place.x, place.y, to.angle, velocity.x, velocity.y, to.spin];
        let without = [place.x, place.y, velocity.x, velocity.y];
        let values: &[f64] = if rows.turns { &with_angle } else { &without };
        for (row, value) in rows.range().zip(values) {
            self.rows[row * self.count + column] = *value;
        }
    }

    /// Gram and Schmidt, vector by vector, with the components removed one after the other.
    fn orthonormalise(&mut self, time: EpochTime) {
        let flights: Vec<(BodyRows, f64)> = self
            .bodies
            .values_mut()
            .map(|rows| (*rows, time.since(std::mem::replace(&mut rows.since, time))))
            .collect();
        for (rows, flight) in flights {
            for column in 0..self.count {
                let deviation = self.deviation(rows, column, flight);
                self.set(rows, column, &deviation);
            }
        }
        self.squared_norm = 1.0;
        let dimension = self.weights.len();
        let weighted = |column: usize| -> Vec<f64> {
            let rows = self.weights.iter().enumerate();
            rows.map(|(row, weight)| weight * self.at(row, column))
                .collect()
        };
        let mut vectors: Vec<Vec<f64>> = (0..self.count).map(weighted).collect();
        for index in 0..self.count {
            let (earlier, rest) = vectors.split_at_mut(index);
            let vector = &mut rest[0];
            let before = norm(vector);
            let left = remove_components(vector, earlier);
            self.logs[index] += left.max(f64::MIN_POSITIVE).ln();
            if left <= RANK_TOLERANCE * before {
                self.replaced += 1;
                replace(vector, earlier, dimension);
            }
        }
        for (column, vector) in vectors.iter().enumerate() {
            for (row, (value, weight)) in vector.iter().zip(&self.weights).enumerate() {
                self.rows[row * self.count + column] = value / weight;
            }
        }
    }
}

/// A typical speed over the distance between bodies, fixed ones too (1/time): 1/τ of the norm.
///
/// That distance is between the radius of a body and the free path: flights and contacts stretch
/// deviations about equally.
fn rate(view: &View<'_>) -> f64 {
    let free = || view.bodies().filter(|body| body.body.is_free());
    let mass: f64 = free().map(|body| body.body.mass()).sum();
    let energy: f64 = free().map(|body| body.energy()).sum();
    let distance = (view.bounds().area() / view.len() as f64).sqrt();
    let rate = (2.0 * energy / mass).sqrt() / distance;
    if rate.is_normal() { rate } else { 1.0 }
}

/// Removes the components along orthonormal vectors and normalises what is left; its norm.
fn remove_components(vector: &mut [f64], orthonormal: &[Vec<f64>]) -> f64 {
    for other in orthonormal {
        let component = dot(vector, other);
        for (value, along) in vector.iter_mut().zip(other) {
            *value -= component * along;
        }
    }
    let length = norm(vector);
    if length > 0.0 {
        for value in &mut *vector {
            *value /= length;
        }
    }
    length
}

/// A unit vector orthogonal to the others, from that axis of which most is left.
fn replace(vector: &mut [f64], orthonormal: &[Vec<f64>], dimension: usize) {
    let left = |axis: &usize| -> f64 {
        orthonormal
            .iter()
            .map(|other| -other[*axis] * other[*axis])
            .sum()
    };
    let axis = (0..dimension).max_by(|a, b| left(a).total_cmp(&left(b)));
    vector.fill(0.0);
    vector[axis.unwrap_or(0)] = 1.0;
    // Twice: the first pass leaves rounding.
    remove_components(vector, orthonormal);
    remove_components(vector, orthonormal);
}

fn norm(vector: &[f64]) -> f64 {
    dot(vector, vector).sqrt()
}

/// Sum of products in eight interleaved parts, which the processor adds at once.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    const PARTS: usize = 8;
    let mut sums = [0.0; PARTS];
    let (chunks, others) = (a.chunks_exact(PARTS), b.chunks_exact(PARTS));
    let rest = chunks.remainder().iter().zip(others.remainder());
    let rest: f64 = rest.map(|(x, y)| x * y).sum();
    for (chunk, other) in chunks.zip(others) {
        for (sum, (x, y)) in sums.iter_mut().zip(chunk.iter().zip(other)) {
            *sum += x * y;
        }
    }
    sums.iter().sum::<f64>() + rest
}
