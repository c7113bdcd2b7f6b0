//! The gaps between the atoms of two molecules in free flight, as curves over time.

use carom_kinematics::RelativeMotion;
use glam::DVec2;

use crate::encounters::EncounterRecord;

/// Most times of a curve. More: sharper curves in a larger file.
const MAX_TIMES: usize = 4000;

/// Fewest times of a curve.
const MIN_TIMES: usize = 400;

/// Times in each turn of the faster molecule.
const TIMES_A_TURN: f64 = 120.0;

/// Most evaluations of atom pairs for one set of curves. More: molecules of a thousand atoms take
/// many seconds.
const MAX_EVALUATIONS: usize = 40_000_000;

/// The molecules of an encounter in flight.
pub(super) struct Gaps<'a> {
    encounter: &'a EncounterRecord,
    motion: RelativeMotion,
}

/// The gaps over a stretch of time.
pub(super) struct Curves {
    pub(super) times: Vec<f64>,
    /// The least gap of all atom pairs (length).
    pub(super) least: Vec<f64>,
    /// The atom pairs with the smallest gaps, and their smallest gap, in ascending order.
    pub(super) nearest: Vec<([u32; 2], f64)>,
}

impl<'a> Gaps<'a> {
    pub(super) fn new(encounter: &'a EncounterRecord) -> Self {
        Self {
            encounter,
            motion: encounter.pair_at(0.0),
        }
    }

    /// From the centre of A to that of B (length).
    pub(super) fn separation(&self, time: f64) -> DVec2 {
        self.motion.separation + self.motion.velocity * time
    }

    /// The gap between the bounding circles (length).
    pub(super) fn of_circles(&self, time: f64) -> f64 {
        let [a, b] = self
            .encounter
            .molecules
            .each_ref()
            .map(carom_geometry::Molecule::bounding_radius);
        self.separation(time).length() - (a + b)
    }

    /// The gap between an atom of A and an atom of B (length).
    pub(super) fn of_pair(&self, [a, b]: [u32; 2], time: f64) -> f64 {
        let [places_a, places_b] = self.atoms(time);
        let ((place_a, radius_a), (place_b, radius_b)) =
            (places_a[a as usize], places_b[b as usize]);
        (place_b - place_a).length() - (radius_a + radius_b)
    }

    /// Centres and radii of the atoms of both molecules at a time, relative to the centre of A.
    pub(super) fn atoms(&self, time: f64) -> [Vec<(DVec2, f64)>; 2] {
        let centres = [DVec2::ZERO, self.separation(time)];
        [0, 1].map(|body| {
            let spin = self.motion.angular_velocity[body];
            let rotation = self.motion.orientation[body].turned(spin, time).cos_sin();
            let atoms = self.encounter.molecules[body].atoms();
            atoms
                .iter()
                .map(|atom| {
                    (
                        centres[body] + rotation.rotate(atom.offset()),
                        atom.radius(),
                    )
                })
                .collect()
        })
    }

    /// The number of turns of the faster molecule in a stretch of time.
    pub(super) fn turns(&self, from: f64, to: f64) -> f64 {
        let [a, b] = self.motion.angular_velocity.map(f64::abs);
        a.max(b) * (to - from) / std::f64::consts::TAU
    }

    /// Times close enough for smooth curves from `from` to `to`.
    pub(super) fn times(&self, from: f64, to: f64) -> Vec<f64> {
        let requested = (self.turns(from, to) * TIMES_A_TURN) as usize;
        let pairs = self
            .encounter
            .molecules
            .each_ref()
            .map(|molecule| molecule.atoms().len());
        let affordable = (MAX_EVALUATIONS / (pairs[0] * pairs[1]).max(1)).clamp(2, MAX_TIMES);
        let count = requested.max(MIN_TIMES).min(affordable);
        (0..=count)
            .map(|index| from + (to - from) * (index as f64 / count as f64))
            .collect()
    }

    /// The curves from `from` to `to`, with the `most` nearest pairs.
    pub(super) fn curves(&self, from: f64, to: f64, most: usize) -> Curves {
        let times = self.times(from, to);
        let [count_a, count_b] = self
            .encounter
            .molecules
            .each_ref()
            .map(|molecule| molecule.atoms().len());
        let mut smallest = vec![f64::INFINITY; count_a * count_b];
        let mut least = Vec::with_capacity(times.len());
        for &time in &times {
            let [atoms_a, atoms_b] = self.atoms(time);
            let mut now = f64::INFINITY;
            for (row, &(place_a, radius_a)) in smallest.chunks_exact_mut(count_b).zip(&atoms_a) {
                for (smallest, &(place_b, radius_b)) in row.iter_mut().zip(&atoms_b) {
                    let gap = (place_b - place_a).length() - (radius_a + radius_b);
                    *smallest = smallest.min(gap);
                    now = now.min(gap);
                }
            }
            least.push(now);
        }
        let mut nearest: Vec<([u32; 2], f64)> = (0..smallest.len())
            .map(|index| {
                (
                    [(index / count_b) as u32, (index % count_b) as u32],
                    smallest[index],
                )
            })
            .collect();
        nearest.sort_by(|one, other| one.1.total_cmp(&other.1));
        nearest.truncate(most);
        Curves {
            times,
            least,
            nearest,
        }
    }
}
