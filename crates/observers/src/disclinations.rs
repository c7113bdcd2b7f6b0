//! Disclinations: bodies whose number of neighbours is not six.
//!
//! Neighbours are the bodies whose Voronoi cells share an edge. A body with z of them has the
//! charge 6 − z (D. R. Nelson, Defects and Geometry in Condensed Matter Physics, 2002): +1 with
//! five, −1 with seven. In a periodic box without walls the charges of all bodies add up to 0
//! (Euler), except where more than three cells meet in one point. A pair 5–7 is a dislocation. For
//! independent, uniform positions ⟨(6 − z)²⟩ = 1.7808, and z = 3 has the share 0.01124 (P. Calka,
//! Adv. Appl. Probab. 35 (2003) 551).
//!
//! Bodies whose cell is bounded by a wall have fewer neighbours and are no defects: they do not
//! count.

use carom_engine::{Observer, View};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{Group, hexatic_order::bonds_between_walls};

/// Number of neighbours of a body without defect.
const REGULAR: usize = 6;

/// The numbers of neighbours that are counted one by one: from 3 to 10; the first and the last hold
/// those beyond.
const MIN_NEIGHBOURS: usize = 3;
const COUNTED: usize = 8;

/// Disclinations of a group at each sample; fixed discs and molecules count, walls do not.
///
/// Samples without bodies are omitted, and those of a few bodies in an extremely narrow box (more
/// than a million images). A sample costs about a microsecond a body.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Disclinations, Group};
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 400")?;
/// let mut simulation = Simulation::new(&scene)?;
/// simulation.run_until(3.0)?;
/// let mut defects = Disclinations::new(Group::All);
/// defects.sample(&simulation.view());
/// let point = defects.series()[0];
/// assert_eq!((point.charge, point.counted), (0, 400));
/// // A gas: nearly independent positions.
/// assert!(point.five > 60 && point.seven > 40);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[doc(alias = "defects")]
#[doc(alias = "coordination number")]
pub struct Disclinations {
    group: Group,
    series: Vec<DefectPoint>,
    last: Vec<CountedBody>,
    /// End points of the walls at the last sample.
    walls: Vec<[DVec2; 2]>,
    /// Sides of the box at the last sample (length).
    sides: DVec2,
    /// Bodies with so many neighbours, from [`MIN_NEIGHBOURS`] on, over all samples.
    counts: [u64; COUNTED],
    /// Σ (6 − z)² over all bodies and samples.
    squares: f64,
}

/// The disclinations at one time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct DefectPoint {
    /// Time of the sample.
    pub time: f64,
    /// Bodies with five neighbours.
    pub five: u64,
    /// Bodies with seven neighbours.
    pub seven: u64,
    /// Bodies with fewer than five, or more than seven.
    pub others: u64,
    /// Σ (6 − z).
    pub charge: i64,
    /// Bodies that count: those whose cell is not bounded by a wall.
    pub counted: u64,
}

/// A body at the last sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CountedBody {
    /// Number of the body, in order of insertion.
    pub id: u64,
    /// Its centre of mass (length).
    pub place: DVec2,
    /// Its bounding radius (length).
    pub radius: f64,
    /// Number of its neighbours; `None` next to a wall, and for a body at the place of another.
    pub neighbours: Option<u64>,
}

impl CountedBody {
    /// 6 − z; 0 for a body that does not count.
    pub fn charge(&self) -> i64 {
        self.neighbours
            .map_or(0, |neighbours| REGULAR as i64 - neighbours as i64)
    }
}

impl Disclinations {
    /// Disclinations of the bodies of a group, with neighbours in this group only.
    pub fn new(group: Group) -> Self {
        Self {
            group,
            ..Self::default()
        }
    }

    /// The samples so far.
    pub fn series(&self) -> &[DefectPoint] {
        &self.series
    }

    /// All bodies of the group at the last sample.
    pub fn last(&self) -> &[CountedBody] {
        &self.last
    }

    /// The end points of the walls at the last sample (length).
    pub fn walls(&self) -> &[[DVec2; 2]] {
        &self.walls
    }

    /// The sides of the box at the last sample (length).
    pub fn sides(&self) -> DVec2 {
        self.sides
    }

    /// The numbers of neighbours of [`sums`](Self::sums).
    pub fn neighbours() -> impl Iterator<Item = usize> {
        MIN_NEIGHBOURS..MIN_NEIGHBOURS + COUNTED
    }

    /// [Σx, Σw] over all samples so far, w = 1 for each body that counts: whether it has a number
    /// of neighbours, for each of [`neighbours`](Self::neighbours), the first and the last with
    /// those beyond; whether that number is not six; (6 − z)².
    pub fn sums(&self) -> Vec<[f64; 2]> {
        let bodies = self.counts.iter().sum::<u64>() as f64;
        let defects = bodies - self.counts[REGULAR - MIN_NEIGHBOURS] as f64;
        let shares = self.counts.iter().map(|&count| count as f64);
        shares
            .chain([defects, self.squares])
            .map(|sum| [sum, bodies])
            .collect()
    }
}

impl Observer for Disclinations {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let members: Vec<_> = self.group.molecules(view).collect();
        let places: Vec<DVec2> = members.iter().map(|body| body.motion.position).collect();
        let Some((bonds, is_at_wall)) = bonds_between_walls(&places, view) else {
            return;
        };
        let neighbours = bonds
            .iter()
            .zip(is_at_wall)
            .map(|(bonds, is_at_wall)| (!is_at_wall && !bonds.is_empty()).then_some(bonds.len()));
        let body = |(body, neighbours): (&carom_engine::BodyView<'_>, Option<usize>)| CountedBody {
            id: body.body.id(),
            place: body.motion.position,
            radius: body.body.molecule().bounding_radius(),
            neighbours: neighbours.map(|neighbours| neighbours as u64),
        };
        self.last = members.iter().zip(neighbours).map(body).collect();
        let walls = view.bodies().flat_map(|body| body.wall_segments());
        self.walls = walls.collect();
        self.sides = view.bounds().sides();
        self.count(view.time().to_f64());
    }
}

impl Disclinations {
    /// Counts the bodies of the last sample.
    fn count(&mut self, time: f64) {
        let mut point = DefectPoint {
            time,
            five: 0,
            seven: 0,
            others: 0,
            charge: 0,
            counted: 0,
        };
        for body in self.last.iter().filter(|body| body.neighbours.is_some()) {
            let charge = body.charge();
            point.counted += 1;
            point.charge += charge;
            match charge {
                0 => {}
                1 => point.five += 1,
                -1 => point.seven += 1,
                _ => point.others += 1,
            }
            let place = (REGULAR - MIN_NEIGHBOURS) as i64 - charge;
            self.counts[place.clamp(0, COUNTED as i64 - 1) as usize] += 1;
            self.squares += (charge * charge) as f64;
        }
        self.series.push(point);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{discs_at, random_points, triangular_lattice};
    use carom_engine::{Scene, Simulation};

    /// Points in a box, with walls in TOML.
    fn defects_of(sides: [f64; 2], places: &[DVec2], walls: &str) -> Disclinations {
        let mut scene = discs_at(sides, 1e-6, places.iter().copied());
        scene.wall = Scene::from_toml(walls).unwrap().wall;
        let mut defects = Disclinations::new(Group::All);
        defects.sample(&Simulation::new(&scene).unwrap().view());
        defects
    }

    #[test]
    fn a_triangular_lattice_has_none_and_planted_pairs_are_found() {
        let (sides, mut places) = triangular_lattice(12, 14);
        let defects = defects_of(sides, &places, "");
        let point = defects.series()[0];
        assert_eq!((point.five, point.seven, point.others), (0, 0, 0));
        assert_eq!((point.counted, point.charge), (168, 0));
        // The bond between two neighbours in a row turns by a quarter: two dislocations, each a
        // pair 5-7. The ends of the bond lose a neighbour each, and the bodies above and below,
        // which come to touch, gain one.
        let (left, right) = (5 + 12 * 6, 6 + 12 * 6);
        places[left].x -= 0.25;
        places[right].x += 0.25;
        for near in [12 * 5, 12 * 7] {
            let middle = 0.5 * (places[left] + places[right]);
            let nearest = (near..near + 12)
                .min_by(|&one, &other| {
                    let apart = |index: usize| places[index].distance(middle);
                    apart(one).total_cmp(&apart(other))
                })
                .unwrap();
            let towards = middle - places[nearest];
            places[nearest] += 0.3 * towards;
        }
        let defects = defects_of(sides, &places, "");
        let point = defects.series()[0];
        assert_eq!((point.five, point.seven, point.others), (2, 2, 0));
        let of_charge = |charge: i64| -> Vec<u64> {
            let found = defects.last().iter().filter(|body| body.charge() == charge);
            found.map(|body| body.id).collect()
        };
        assert_eq!(of_charge(1), [left as u64, right as u64]);
        assert_eq!(of_charge(-1).len(), 2);
        assert_eq!(defects.sums()[2], [2.0, 168.0]);
        assert_eq!(defects.sums()[8..], [[4.0, 168.0], [4.0, 168.0]]);
    }

    #[test]
    fn bodies_next_to_walls_do_not_count() {
        let (sides, places) = triangular_lattice(12, 14);
        let below = "[[wall]]\ny = 0.001\n";
        let defects = defects_of(sides, &places, below);
        let point = defects.series()[0];
        assert_eq!((point.five, point.seven, point.others), (0, 0, 0));
        assert_eq!(point.counted, 168 - 2 * 12);
        let next_to_wall = defects
            .last()
            .iter()
            .filter(|body| body.neighbours.is_none());
        assert!(
            next_to_wall
                .clone()
                .all(|body| !(12..156).contains(&body.id))
        );
        assert_eq!(next_to_wall.count(), 24);
    }

    #[test]
    fn random_positions_have_the_squares_of_a_poisson_voronoi_tessellation() {
        let mut defects = Disclinations::new(Group::All);
        let mut squares = Vec::new();
        for seed in 0..40 {
            let scene = random_points(400, [0.5, 2.0], seed);
            let before = defects.squares;
            defects.sample(&Simulation::new(&scene).unwrap().view());
            squares.push((defects.squares - before) / 400.0);
        }
        assert!(defects.series().iter().all(|point| point.charge == 0));
        let (mean, error) = carom_tables::block_sums::mean_of_series(squares).unwrap();
        assert!(
            (mean - 1.7808).abs() < 4.0 * error && error < 0.03,
            "{mean} ± {error}"
        );
        let [triangles, bodies] = defects.sums()[0];
        let share = triangles / bodies;
        assert!((share - 0.01124).abs() < 0.004, "{share}");
    }

    #[test]
    fn few_bodies_and_narrow_boxes_have_numbers() {
        for (count, sides) in [
            (0, [1.0; 2]),
            (1, [1.0; 2]),
            (2, [1.0, 0.02]),
            (3, [0.01, 1.0]),
        ] {
            let mut defects = Disclinations::new(Group::All);
            defects.sample(
                &Simulation::new(&random_points(count, sides, 1))
                    .unwrap()
                    .view(),
            );
            assert_eq!(defects.series().len(), usize::from(count > 0));
            assert_eq!(defects.last().len(), count);
            assert!(defects.sums().iter().flatten().all(|sum| sum.is_finite()));
        }
    }
}
