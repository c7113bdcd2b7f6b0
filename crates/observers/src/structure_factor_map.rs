//! The structure factor over the plane of wave vectors, S(k_x, k_y), as a diffraction pattern.
//!
//! S(k) = ⟨|Σ exp(i k·x)|²⟩ / N at each wave vector of the box, k = 2π (n_x / Lx, n_y / Ly), as of
//! [`StructureFactor`](crate::StructureFactor) before its mean over directions: rings in a liquid,
//! six arcs in a hexatic phase, six peaks in a crystal of discs. S(−k) = S(k), so that half of the
//! plane is computed. The value at k = 0 does not depend on the places and is left out.
//!
//! In a sheared box with the tilt b the wave vectors are 2π (n_x / Lx, (n_y − n_x b / Lx) / Ly): in
//! each column of the map they are displaced along k_y. A place of the map then has that whose k_y
//! is nearest, at most π / Ly away.

use carom_engine::{Observer, View};
use carom_geometry::{GeometryError, PeriodicBox, check_positive};
use glam::DVec2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{Group, structure_factor::products_of_waves};

/// The most wave vectors of a map. The cost of a sample is the number of bodies times half of them.
const MAX_VECTORS: f64 = 40_000.0;

/// The largest component may be rounded below that of a wave vector of the box by this share.
const ROUNDING: f64 = 1e-12;

/// Structure factor of two groups, or of one with itself, at each wave vector; fixed discs and
/// molecules count, walls do not. Under shear a place of the map has the wave vector of the present
/// images that is nearest to it along k_y.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Group, StructureFactorMap};
/// use std::f64::consts::TAU;
///
/// // Two discs half a box apart along x.
/// let scene = Scene::from_toml(r#"
///     [[bumper]]
///     radius = 0.1
///     at = [0.2, 0.5]
///     [[bumper]]
///     radius = 0.1
///     at = [0.7, 0.5]
/// "#)?;
/// let simulation = Simulation::new(&scene)?;
/// let bounds = simulation.view().bounds();
/// let mut map = StructureFactorMap::new([Group::All; 2], &bounds, 2.0 * TAU)?;
/// map.sample(&simulation.view());
/// // Five columns and rows: waves of even n_x add up, those of odd n_x cancel.
/// let points = map.points();
/// assert_eq!((map.counts(), points[12].s), ([5, 5], None));
/// assert!((points[0].s.expect("a value") - 2.0).abs() < 1e-12);
/// assert!(points[1].s.expect("a value") < 1e-12);
/// assert_eq!(points[1].wave_vector, [-TAU, -2.0 * TAU]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "diffraction pattern")]
pub struct StructureFactorMap {
    groups: [Group; 2],
    bounds: PeriodicBox,
    /// The largest n_x and n_y.
    largest: [i64; 2],
    /// (n_x, n_y) of half the plane: n_y = 0 and n_x > 0, then rows of n_y > 0.
    vectors: Vec<[i64; 2]>,
    /// Σ over the samples of S at each of the vectors.
    sums: Vec<f64>,
    samples: u64,
    passed_over: u64,
}

/// The structure factor at one wave vector.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StructureMapPoint {
    /// (k_x, k_y) (1 / length).
    pub wave_vector: [f64; 2],
    /// S; `None` at k = 0 and before the first sample.
    pub s: Option<f64>,
}

/// A largest component of the wave vectors that is out of range.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum StructureMapError {
    /// It is not positive and finite.
    #[error(transparent)]
    NotPositive(#[from] GeometryError),
    /// It is smaller than 2π by the shorter side, so that a row or column is all of the map.
    #[error("the largest component of the wave vectors must be at least {least}, but is {largest}")]
    TooSmall {
        /// The given component (1 / length).
        largest: f64,
        /// 2π by the shorter side of the box (1 / length).
        least: f64,
    },
    /// The map has too many wave vectors.
    #[error(
        "a map has at most {MAX_VECTORS} wave vectors, but those with components up to {largest} are {vectors}"
    )]
    TooMany {
        /// The given component (1 / length).
        largest: f64,
        /// The number of wave vectors.
        vectors: f64,
    },
}

impl StructureFactorMap {
    /// S at all wave vectors of this box with |k_x| and |k_y| up to `largest` (1 / length).
    ///
    /// # Errors
    /// [`StructureMapError`] if `largest` is not positive and finite, less than 2π by the shorter
    /// side of the box, or so large that there are more than 40 000 wave vectors.
    pub fn new(
        groups: [Group; 2],
        bounds: &PeriodicBox,
        largest: f64,
    ) -> Result<Self, StructureMapError> {
        check_positive("the largest component of the wave vectors", largest)?;
        let unit = bounds.sides().recip() * std::f64::consts::TAU;
        let most = (largest * (1.0 + ROUNDING) / unit).floor();
        if most.min_element() < 1.0 {
            let least = unit.max_element();
            return Err(StructureMapError::TooSmall { largest, least });
        }
        let vectors = (2.0 * most + 1.0).element_product();
        if vectors > MAX_VECTORS {
            return Err(StructureMapError::TooMany { largest, vectors });
        }
        let [across, up] = most.to_array().map(|most| most as i64);
        let half_plane = (0..=up).flat_map(|y| (-across..=across).map(move |x| [x, y]));
        let vectors: Vec<[i64; 2]> = half_plane.filter(|&[x, y]| y > 0 || x > 0).collect();
        Ok(Self {
            groups,
            bounds: *bounds,
            largest: [across, up],
            sums: vec![0.0; vectors.len()],
            vectors,
            samples: 0,
            passed_over: 0,
        })
    }

    /// The largest component for which a map of this box has at most so many wave vectors, but at
    /// least that of the shortest wave vector along the shorter side (1 / length).
    pub fn largest_within(bounds: &PeriodicBox, vectors: f64) -> f64 {
        let unit = bounds.sides().recip() * std::f64::consts::TAU;
        let most = vectors.clamp(9.0, MAX_VECTORS);
        // (2 k/u_x + 1) (2 k/u_y + 1) = most.
        let (product, sum) = (
            4.0 / unit.element_product(),
            2.0 * unit.recip().element_sum(),
        );
        let root = (sum * sum + 4.0 * product * (most - 1.0)).sqrt();
        ((root - sum) / (2.0 * product)).max(unit.max_element())
    }

    /// Columns and rows of the map.
    pub fn counts(&self) -> [usize; 2] {
        self.largest.map(|largest| 2 * largest as usize + 1)
    }

    /// S at each wave vector, in ascending order of k_y and, in a row, of k_x.
    pub fn points(&self) -> Vec<StructureMapPoint> {
        let unit = self.bounds.sides().recip() * std::f64::consts::TAU;
        let samples = self.samples as f64;
        self.grid()
            .map(|([x, y], index)| StructureMapPoint {
                wave_vector: (unit * DVec2::new(x as f64, y as f64)).to_array(),
                s: index
                    .filter(|_| self.samples > 0)
                    .map(|index| self.sums[index] / samples),
            })
            .collect()
    }

    /// [Σx, Σw] of each wave vector of half the plane over all samples so far: x is S in one
    /// sample, and w is 1.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        let samples = self.samples as f64;
        self.sums.iter().map(|&sum| [sum, samples]).collect()
    }

    /// The place in [`sums`](Self::sums) of each of the [`points`](Self::points); `None` at k = 0.
    pub fn places(&self) -> Vec<Option<usize>> {
        self.grid().map(|(_, index)| index).collect()
    }

    /// The number of samples skipped because their box differs from that of the constructor, or
    /// because a group was empty.
    pub fn passed_over(&self) -> u64 {
        self.passed_over
    }

    /// (n_x, n_y) row by row, and the index of the vector or its opposite in half the plane.
    fn grid(&self) -> impl Iterator<Item = ([i64; 2], Option<usize>)> {
        let [across, up] = self.largest;
        let columns = 2 * across + 1;
        let index = move |[x, y]: [i64; 2]| {
            let [x, y] = if y < 0 || y == 0 && x < 0 {
                [-x, -y]
            } else {
                [x, y]
            };
            // The row n_y = 0 has its right half only.
            usize::try_from(y * columns + x - 1).ok()
        };
        let rows = -up..=up;
        rows.flat_map(move |y| (-across..=across).map(move |x| [x, y]))
            .map(move |vector| (vector, index(vector)))
    }
}

impl Observer for StructureFactorMap {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let tilt = view.bounds().tilt();
        let products = if tilt == 0.0 {
            products_of_waves(view, &self.bounds, self.groups, &self.vectors)
        } else {
            let turns = tilt / self.bounds.sides().x;
            let tilted: Vec<[i64; 2]> = self
                .vectors
                .iter()
                .map(|&[x, y]| [x, y + (turns * x as f64).round() as i64])
                // k and −k have one product.
                .map(|[x, y]| if y < 0 { [-x, -y] } else { [x, y] })
                .collect();
            products_of_waves(view, &self.bounds, self.groups, &tilted)
        };
        let Some(products) = products else {
            self.passed_over += 1;
            return;
        };
        for (sum, product) in self.sums.iter_mut().zip(products) {
            *sum += product;
        }
        self.samples += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        StructureFactor,
        test_scenes::{discs_at, moving_with_the_flow, random_points, triangular_lattice},
    };
    use carom_engine::Simulation;
    use std::f64::consts::TAU;

    #[test]
    fn means_over_directions_are_those_of_the_shells() {
        let mut scene = random_points(90, [1.0, 1.5], 4);
        for (index, bumper) in scene.bumper.iter_mut().enumerate() {
            bumper.tags = vec![["a", "b", "b"][index % 3].to_owned()];
        }
        let simulation = Simulation::new(&scene).unwrap();
        let bounds = simulation.view().bounds();
        let [a, b] = ["a", "b"].map(|name| Group::from(simulation.find_tag(name).unwrap()));
        for groups in [[Group::All; 2], [a, b]] {
            let mut map = StructureFactorMap::new(groups, &bounds, 10.0 * TAU).unwrap();
            let mut structure = StructureFactor::new(groups, &bounds, 60).unwrap();
            for _ in 0..2 {
                map.sample(&simulation.view());
                structure.sample(&simulation.view());
            }
            let points = map.points();
            assert_eq!((map.counts(), points.len()), ([21, 31], 21 * 31));
            for shell in structure.points() {
                assert!(shell.wave_number < 10.0 * TAU);
                let is_of = |point: &&StructureMapPoint| {
                    let length = DVec2::from(point.wave_vector).length();
                    (length / shell.wave_number - 1.0).abs() < 1e-9
                };
                let of_shell: Vec<f64> = points
                    .iter()
                    .filter(is_of)
                    .map(|point| point.s.unwrap())
                    .collect();
                assert_eq!(of_shell.len(), 2 * shell.vectors);
                let mean = of_shell.iter().sum::<f64>() / of_shell.len() as f64;
                assert!((mean - shell.s).abs() < 1e-12, "{mean} {shell:?}");
            }
            // The waves of single bodies, and the opposite vector.
            for (index, point) in points.iter().enumerate() {
                let opposite = points[points.len() - 1 - index];
                assert_eq!(point.s, opposite.s);
                let Some(s) = point.s else {
                    assert_eq!(point.wave_vector, [0.0; 2]);
                    continue;
                };
                let [one, other] = groups.map(|group| {
                    let view = simulation.view();
                    let members = view.bodies().filter(|body| group.contains(body.body));
                    let waves: Vec<DVec2> = members
                        .map(|body| DVec2::from(point.wave_vector).dot(body.motion.position))
                        .map(DVec2::from_angle)
                        .collect();
                    waves.iter().sum::<DVec2>() / (waves.len() as f64).sqrt()
                });
                assert!((s - one.dot(other)).abs() < 1e-11, "{point:?}");
            }
            let sums = map.sums();
            for (point, place) in points.iter().zip(map.places()) {
                assert_eq!(point.s, place.map(|place| sums[place][0] / sums[place][1]));
            }
            assert_eq!(map.passed_over(), 0);
        }
    }

    #[test]
    fn a_triangular_lattice_has_six_peaks() {
        let (sides, places) = triangular_lattice(8, 10);
        let scene = discs_at(sides, 0.01, places);
        let simulation = Simulation::new(&scene).unwrap();
        let bounds = simulation.view().bounds();
        // The shortest reciprocal vectors have the length 4π/√3 for a lattice constant of 1, the
        // next √3 times that.
        let shortest = 2.0 * TAU / 3f64.sqrt();
        let mut map = StructureFactorMap::new([Group::All; 2], &bounds, 1.2 * shortest).unwrap();
        map.sample(&simulation.view());
        let (peaks, others): (Vec<_>, Vec<_>) = map
            .points()
            .into_iter()
            .filter(|point| point.s.is_some())
            .partition(|point| point.s > Some(1.0));
        assert_eq!(peaks.len(), 6);
        for peak in peaks {
            assert!((peak.s.unwrap() - 80.0).abs() < 1e-9, "{peak:?}");
            let vector = DVec2::from(peak.wave_vector);
            assert!((vector.length() - shortest).abs() < 1e-9 * shortest);
            // 30°, 90°, …
            let sixths = (vector.y.atan2(vector.x) / TAU * 6.0 - 0.5).rem_euclid(1.0);
            assert!(sixths.min(1.0 - sixths) < 1e-9, "{peak:?}");
        }
        assert!(others.iter().all(|point| point.s < Some(1e-20)));
    }

    #[test]
    fn components_out_of_range_are_refused_with_their_values() {
        let bounds = PeriodicBox::new(DVec2::new(1.0, 2.0)).unwrap();
        let error = |largest: f64| {
            StructureFactorMap::new([Group::All; 2], &bounds, largest)
                .err()
                .map_or_else(String::new, |error| error.to_string())
        };
        assert_eq!(error(TAU), "");
        assert!(error(4.0).contains("at least 6.28"), "{}", error(4.0));
        assert!(
            error(71.0 * TAU).contains("at most 40000"),
            "{}",
            error(71.0 * TAU)
        );
        for refused in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(!error(refused).is_empty());
        }
        for vectors in [1.0, 15.0, 1000.0, 1e4, 1e9] {
            let largest = StructureFactorMap::largest_within(&bounds, vectors);
            let map = StructureFactorMap::new([Group::All; 2], &bounds, largest).unwrap();
            let [columns, rows] = map.counts();
            assert!((columns * rows) as f64 <= vectors.max(15.0), "{vectors}");
        }
        let most = StructureFactorMap::largest_within(&bounds, 1e4);
        assert!(
            StructureFactorMap::new([Group::All; 2], &bounds, 1.1 * most)
                .unwrap()
                .sums
                .len()
                > 4500
        );
    }

    /// Discs of a square lattice that move with the flow: the columns of the map have the peaks of
    /// the sheared lattice in the nearest rows.
    #[test]
    fn a_map_under_shear_has_the_peaks_of_the_sheared_lattice() {
        let site = |site: u32| DVec2::new(f64::from(site % 6), f64::from(site / 6));
        let places: Vec<DVec2> = (0..36).map(|k| 0.5 * site(k) + 0.1).collect();
        let scene = moving_with_the_flow([3.0, 3.0], &places);
        let mut simulation = Simulation::new(&scene).unwrap();
        let bounds = simulation.view().bounds();
        let unit = TAU / 3.0;
        for time in [0.9, 1.4, 2.3] {
            simulation.run_until(time).unwrap();
            let mut map = StructureFactorMap::new([Group::All; 2], &bounds, 9.0 * unit).unwrap();
            map.sample(&simulation.view());
            let slope = 0.5 * time;
            for point in map.points() {
                let [x, y] = point.wave_vector.map(|k| (k / unit).round());
                // Peaks at n_x = 6 p and k_y = (6 q − 6 p slope) 2π/Ly.
                let exact = |q: i32| 6.0 * f64::from(q) - x * slope;
                let is_peak = x % 6.0 == 0.0 && (-9..=9).any(|q| (exact(q) - y).abs() < 0.5);
                match point.s {
                    Some(s) if is_peak => assert!((s - 36.0).abs() < 1e-6, "{point:?} {time}"),
                    Some(s) => assert!(s < 1e-6, "{point:?} {time}"),
                    None => assert_eq!([x, y], [0.0; 2]),
                }
            }
        }
    }
}
