//! The gaps between the atoms and edges of two molecules in free flight, as curves over time.

use carom_detection::{Part, Touch};
use carom_geometry::{Edge, Molecule};
use carom_kinematics::RelativeMotion;
use glam::DVec2;

use crate::encounters::EncounterRecord;

/// Most times of a curve. More: sharper curves in a larger file.
const MAX_TIMES: usize = 4000;

/// Fewest times of a curve.
const MIN_TIMES: usize = 400;

/// Times in each turn of the faster molecule.
const TIMES_A_TURN: f64 = 120.0;

/// Most evaluations of pairs for one set of curves. More: molecules of a thousand atoms take
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
    /// The least gap of all pairs (length).
    pub(super) least: Vec<f64>,
    /// The pairs with the smallest gaps, and their smallest gap, in ascending order.
    pub(super) nearest: Vec<(Touch, f64)>,
}

/// A molecule at one time, relative to the centre of A.
struct Pose<'a> {
    molecule: &'a Molecule,
    centre: DVec2,
    rotation: DVec2,
    /// Centres and radii of the atoms (length).
    atoms: Vec<(DVec2, f64)>,
}

impl Pose<'_> {
    /// The gap between an edge of this molecule and a disc (length). Beyond the ends of the edge it
    /// is that of a disc as thick as the edge there.
    fn gap_of_edge(&self, edge: &Edge, (place, radius): (DVec2, f64)) -> f64 {
        let back = DVec2::new(self.rotation.x, -self.rotation.y);
        let nearest = edge.nearest(back.rotate(place - self.centre));
        nearest.distance - (edge.radius() + radius)
    }
}

/// The gap between two discs (length).
fn gap_of_discs((place_a, radius_a): (DVec2, f64), (place_b, radius_b): (DVec2, f64)) -> f64 {
    (place_b - place_a).length() - (radius_a + radius_b)
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
            .map(Molecule::bounding_radius);
        self.separation(time).length() - (a + b)
    }

    /// The gap between a part of A and a part of B (length); NaN for bounding circles.
    pub(super) fn of_pair(&self, pair: Touch, time: f64) -> f64 {
        let [a, b] = self.poses(time);
        match pair {
            Touch::Atoms(of_a, of_b) => {
                gap_of_discs(a.atoms[of_a as usize], b.atoms[of_b as usize])
            }
            Touch::EdgeOfA {
                edge,
                part: Part::Atom(atom),
            } => a.gap_of_edge(&a.molecule.edges()[edge as usize], b.atoms[atom as usize]),
            Touch::EdgeOfB {
                edge,
                part: Part::Atom(atom),
            } => b.gap_of_edge(&b.molecule.edges()[edge as usize], a.atoms[atom as usize]),
            _ => f64::NAN,
        }
    }

    /// Centres and radii of the atoms of both molecules at a time, relative to the centre of A.
    pub(super) fn atoms(&self, time: f64) -> [Vec<(DVec2, f64)>; 2] {
        self.poses(time).map(|pose| pose.atoms)
    }

    /// Cosine and sine of the orientations of both molecules at a time.
    pub(super) fn rotations(&self, time: f64) -> [DVec2; 2] {
        [0, 1].map(|body| {
            let spin = self.motion.angular_velocity[body];
            self.motion.orientation[body].turned(spin, time).cos_sin()
        })
    }

    fn poses(&self, time: f64) -> [Pose<'a>; 2] {
        let centres = [DVec2::ZERO, self.separation(time)];
        let rotations = self.rotations(time);
        [0, 1].map(|body| {
            let (centre, rotation) = (centres[body], rotations[body]);
            let molecule = &self.encounter.molecules[body];
            let atoms = molecule
                .atoms()
                .iter()
                .map(|atom| (centre + rotation.rotate(atom.offset()), atom.radius()))
                .collect();
            Pose {
                molecule,
                centre,
                rotation,
                atoms,
            }
        })
    }

    /// All pairs of atoms, then those of an edge of A and an atom of B, then the opposite.
    pub(super) fn pairs(&self) -> Vec<Touch> {
        let [a, b] = &self.encounter.molecules;
        let numbers = |count: usize| 0..count as u32;
        let [atoms_a, atoms_b] = [a, b].map(|molecule| molecule.atoms().len());
        let [edges_a, edges_b] = [a, b].map(|molecule| molecule.edges().len());
        let atoms = numbers(atoms_a)
            .flat_map(|of_a| numbers(atoms_b).map(move |of_b| Touch::Atoms(of_a, of_b)));
        let of_a = numbers(edges_a).flat_map(|edge| {
            numbers(atoms_b).map(move |atom| Touch::EdgeOfA {
                edge,
                part: Part::Atom(atom),
            })
        });
        let of_b = numbers(edges_b).flat_map(|edge| {
            numbers(atoms_a).map(move |atom| Touch::EdgeOfB {
                edge,
                part: Part::Atom(atom),
            })
        });
        atoms.chain(of_a).chain(of_b).collect()
    }

    /// The gaps of all pairs at a time, in the order of [`Self::pairs`].
    fn all_gaps(&self, time: f64, gaps: &mut Vec<f64>) {
        let [a, b] = self.poses(time);
        gaps.clear();
        for &of_a in &a.atoms {
            gaps.extend(b.atoms.iter().map(|&of_b| gap_of_discs(of_a, of_b)));
        }
        for (edged, other) in [(&a, &b), (&b, &a)] {
            for edge in edged.molecule.edges() {
                gaps.extend(
                    other
                        .atoms
                        .iter()
                        .map(|&atom| edged.gap_of_edge(edge, atom)),
                );
            }
        }
    }

    /// The number of turns of the faster molecule in a stretch of time.
    pub(super) fn turns(&self, from: f64, to: f64) -> f64 {
        let [a, b] = self.motion.angular_velocity.map(f64::abs);
        a.max(b) * (to - from) / std::f64::consts::TAU
    }

    /// Times close enough for smooth curves from `from` to `to`.
    pub(super) fn times(&self, from: f64, to: f64) -> Vec<f64> {
        let requested = (self.turns(from, to) * TIMES_A_TURN) as usize;
        let affordable = (MAX_EVALUATIONS / self.pairs().len().max(1)).clamp(2, MAX_TIMES);
        let count = requested.max(MIN_TIMES).min(affordable);
        (0..=count)
            .map(|index| from + (to - from) * (index as f64 / count as f64))
            .collect()
    }

    /// The curves from `from` to `to`, with the `most` nearest pairs.
    pub(super) fn curves(&self, from: f64, to: f64, most: usize) -> Curves {
        let times = self.times(from, to);
        let pairs = self.pairs();
        let mut smallest = vec![f64::INFINITY; pairs.len()];
        let mut least = Vec::with_capacity(times.len());
        let mut gaps = Vec::with_capacity(pairs.len());
        for &time in &times {
            self.all_gaps(time, &mut gaps);
            for (smallest, gap) in smallest.iter_mut().zip(&gaps) {
                *smallest = smallest.min(*gap);
            }
            least.push(gaps.iter().copied().fold(f64::INFINITY, f64::min));
        }
        let mut nearest: Vec<(Touch, f64)> = pairs.into_iter().zip(smallest).collect();
        nearest.sort_by(|one, other| one.1.total_cmp(&other.1));
        nearest.truncate(most);
        Curves {
            times,
            least,
            nearest,
        }
    }
}
