//! The bond-orientational order ψₙ of the centres of mass.
//!
//! ψₙ of a body is the mean of exp(niθ) over its neighbours, θ the direction to the neighbour (n =
//! 6: Halperin & Nelson 1978). [`Neighbours`] are the k nearest bodies, or those whose Voronoi
//! cells share an edge, each with the same weight or with the length of the edge (W. Mickel et al.,
//! J. Chem. Phys. 138 (2013) 044501). With the six nearest |ψ₆| is 1 in a triangular lattice and 0
//! in a square one, where the four nearest and the four next bodies both cancel. For independent,
//! uniform positions the directions to the k nearest are independent, so that ⟨|ψₙ|²⟩ = 1/k.
//!
//! The global order |Σ ψₙ| / N is of the order of 1/√N without long-range order.

use carom_engine::{Observer, View};
use carom_geometry::PeriodicBox;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{Group, cell_list::CellList, delaunay};

/// The neighbours of a body in bond-orientational order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Neighbours {
    /// So many nearest bodies, each in its nearest image, and all others as near as the last of
    /// them; at least 1. Walls between them make no difference.
    Nearest(usize),
    /// Bodies whose Voronoi cells share an edge, with equal weights. Walls bound the cells.
    #[doc(alias = "voronoi")]
    Delaunay,
    /// Bodies whose Voronoi cells share an edge, weighted by its length. Walls bound the cells.
    Voronoi,
}

/// The rule of ψ₆ in maps and pictures.
const HEXATIC: (u32, Neighbours) = (6, Neighbours::Nearest(6));

/// Bond-orientational order of a group at each sample; fixed discs and molecules count, walls do
/// not.
///
/// With the k nearest, samples with no more than k bodies in the group are omitted. A sample costs
/// a search of a few cells for each body of a homogeneous system; at worst, with nearly all bodies
/// in one small part of the box, each pair of bodies is compared. A Delaunay triangulation costs
/// about a microsecond a body; samples of a few bodies in an extremely narrow box (more than a
/// million images) are omitted.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Group, HexaticOrder};
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 400")?;
/// let mut simulation = Simulation::new(&scene)?;
/// simulation.run_until(3.0)?;
/// let mut order = HexaticOrder::new(Group::All);
/// order.sample(&simulation.view());
/// // A dilute gas has no order beyond that of the nearest neighbours.
/// let point = order.series()[0];
/// assert!((point.local_square - 1.0 / 6.0).abs() < 0.05);
/// assert!(point.global < 0.15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "psi6")]
#[doc(alias = "bond order")]
pub struct HexaticOrder {
    group: Group,
    /// n.
    symmetry: u32,
    neighbours: Neighbours,
    series: Vec<HexaticPoint>,
    /// Σ over the samples of local, local_square and global order.
    sums: [f64; 3],
}

/// The order at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct HexaticPoint {
    /// Time of the sample.
    pub time: f64,
    /// Mean of |ψₙ| over the bodies, from 0 to 1.
    pub local: f64,
    /// Mean of |ψₙ|² over the bodies, from 0 to 1.
    pub local_square: f64,
    /// |mean of ψₙ over the bodies|, from 0 to 1.
    pub global: f64,
}

impl HexaticOrder {
    /// ψ₆ of the bodies of a group, with the six nearest neighbours, in this group only.
    pub fn new(group: Group) -> Self {
        let (symmetry, neighbours) = HEXATIC;
        Self::with_neighbours(group, symmetry, neighbours)
    }

    /// ψₙ of the bodies of a group, n = `symmetry`, with neighbours in this group only.
    pub fn with_neighbours(group: Group, symmetry: u32, neighbours: Neighbours) -> Self {
        Self {
            group,
            symmetry,
            neighbours,
            series: Vec::new(),
            sums: [0.0; 3],
        }
    }

    /// n.
    pub fn symmetry(&self) -> u32 {
        self.symmetry
    }

    /// The rule of the neighbours.
    pub fn neighbours(&self) -> Neighbours {
        self.neighbours
    }

    /// The samples so far.
    pub fn series(&self) -> &[HexaticPoint] {
        &self.series
    }

    /// [Σx, Σw] over all samples so far, w = 1 for each sample: local order, mean square of the
    /// local order, global order.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        self.sums
            .map(|sum| [sum, self.series.len() as f64])
            .to_vec()
    }
}

impl Observer for HexaticOrder {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let members = self.group.molecules(view);
        let places: Vec<DVec2> = members.map(|view| view.motion.position).collect();
        let rule = (self.symmetry, self.neighbours);
        let Some(orders) = orders(&places, view, rule) else {
            return;
        };
        let count = orders.len() as f64;
        let point = HexaticPoint {
            time: view.time().to_f64(),
            local: orders.iter().map(|psi| psi.length()).sum::<f64>() / count,
            local_square: orders.iter().map(|psi| psi.length_squared()).sum::<f64>() / count,
            global: orders.iter().sum::<DVec2>().length() / count,
        };
        for (sum, value) in
            self.sums
                .iter_mut()
                .zip([point.local, point.local_square, point.global])
        {
            *sum += value;
        }
        self.series.push(point);
    }
}

/// |ψ₆| of each body that is not a wall, in their order, with neighbours among all of them; 0 for
/// all of fewer than seven.
pub fn local_orders(view: &View<'_>) -> Vec<f64> {
    complex_orders(view)
        .iter()
        .map(|psi| psi.length())
        .collect()
}

/// ψ₆ of each body that is not a wall, real and imaginary part; 0 for all of fewer than seven.
pub(crate) fn complex_orders(view: &View<'_>) -> Vec<DVec2> {
    let bodies = Group::All.molecules(view);
    let places: Vec<DVec2> = bodies.map(|view| view.motion.position).collect();
    orders(&places, view, HEXATIC).unwrap_or_else(|| vec![DVec2::ZERO; places.len()])
}

/// ψₙ of each body, real and imaginary part; `None` without enough neighbours.
pub(crate) fn orders(
    places: &[DVec2],
    view: &View<'_>,
    (symmetry, neighbours): (u32, Neighbours),
) -> Option<Vec<DVec2>> {
    match neighbours {
        Neighbours::Nearest(count) => {
            let count = count.max(1);
            (places.len() > count)
                .then(|| orders_of_nearest(places, &view.bounds(), symmetry, count))
        }
        Neighbours::Delaunay => orders_of_cells(places, view, symmetry, |_| 1.0),
        Neighbours::Voronoi => orders_of_cells(places, view, symmetry, |bond| bond.edge),
    }
}

/// ψₙ of each body with its nearest neighbours; more than `count` bodies.
fn orders_of_nearest(
    places: &[DVec2],
    bounds: &PeriodicBox,
    symmetry: u32,
    count: usize,
) -> Vec<DVec2> {
    let cells = CellList::for_nearest(places, bounds);
    let mut found = Vec::new();
    let order = |index| {
        cells.nearest(index, count, &mut found);
        let sum: DVec2 = found
            .iter()
            .map(|&(_, displacement)| power(displacement.normalize_or_zero(), symmetry))
            .sum();
        sum / found.len() as f64
    };
    (0..places.len()).map(order).collect()
}

/// ψₙ of each body with the neighbours of its Voronoi cell; 0 for a body without any.
fn orders_of_cells(
    places: &[DVec2],
    view: &View<'_>,
    symmetry: u32,
    weight: fn(&delaunay::DelaunayBond) -> f64,
) -> Option<Vec<DVec2>> {
    let (bonds, _) = bonds_between_walls(places, view)?;
    let order = |bonds: &Vec<delaunay::DelaunayBond>| {
        let (mut sum, mut total) = (DVec2::ZERO, 0.0);
        for bond in bonds {
            sum += weight(bond) * power(bond.displacement.normalize_or_zero(), symmetry);
            total += weight(bond);
        }
        if total > 0.0 { sum / total } else { sum }
    };
    Some(bonds.iter().map(order).collect())
}

/// The neighbours of each body by their Voronoi cells, which walls bound, and whether a wall bounds
/// its cell.
pub(crate) fn bonds_between_walls(
    places: &[DVec2],
    view: &View<'_>,
) -> Option<(Vec<Vec<delaunay::DelaunayBond>>, Vec<bool>)> {
    let mut bonds = delaunay::bonds(places, &view.bounds())?;
    let walls: Vec<[DVec2; 2]> = view
        .bodies()
        .flat_map(|body| body.wall_segments())
        .collect();
    let sides = view.bounds().sides();
    let is_at_wall = delaunay::cut_by_walls(&mut bonds, places, &walls, sides);
    Some((bonds, is_at_wall))
}

/// zⁿ of a complex number, by repeated squaring.
pub(crate) fn power(z: DVec2, n: u32) -> DVec2 {
    let (mut result, mut square, mut left) = (DVec2::X, z, n);
    while left > 0 {
        if left % 2 == 1 {
            result = square.rotate(result);
        }
        square = square.rotate(square);
        left /= 2;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{discs_at, moving_with_the_flow, random_points, triangular_lattice};
    use carom_engine::{Scene, Simulation};

    fn order_of(sides: [f64; 2], places: impl Iterator<Item = [f64; 2]>) -> HexaticPoint {
        let mut scene = discs_at(sides, 0.01, places.map(DVec2::from));
        // A wall does not count.
        scene.wall = Scene::from_toml("[[wall]]\nx = 0.9").unwrap().wall;
        let mut order = HexaticOrder::new(Group::All);
        order.sample(&Simulation::new(&scene).unwrap().view());
        order.series()[0]
    }

    #[test]
    fn a_triangular_lattice_has_order_one() {
        let (sides, places) = triangular_lattice(8, 10);
        let point = order_of(sides, places.into_iter().map(|place| place.to_array()));
        assert!(
            (point.local - 1.0).abs() < 1e-12 && (point.global - 1.0).abs() < 1e-12,
            "{point:?}"
        );
    }

    /// In a flow of the rate 0.5 the rows of a triangular lattice, 0.75^½ apart, are displaced by
    /// one distance each at the time 2/0.75^½: it is a triangular lattice again, in a tilted box.
    #[test]
    fn a_triangular_lattice_in_a_flow_has_order_one_when_rows_fit_again() {
        let (sides, places) = triangular_lattice(8, 10);
        let mut simulation = Simulation::new(&moving_with_the_flow(sides, &places)).unwrap();
        let rules = [
            Neighbours::Nearest(6),
            Neighbours::Delaunay,
            Neighbours::Voronoi,
        ];
        let back = 2.0 / 0.75_f64.sqrt();
        for (time, is_triangular) in [(0.0, true), (0.4 * back, false), (back, true)] {
            simulation.run_until(time).unwrap();
            for rule in rules {
                let mut order = HexaticOrder::with_neighbours(Group::All, 6, rule);
                order.sample(&simulation.view());
                let HexaticPoint { local, global, .. } = order.series()[0];
                let is_ordered = (local - 1.0).abs() < 1e-9 && (global - 1.0).abs() < 1e-9;
                assert_eq!(
                    is_ordered, is_triangular,
                    "{time} {rule:?}: {local} {global}"
                );
            }
        }
    }

    #[test]
    fn a_square_lattice_has_none_and_a_stretched_one_by_hand() {
        let place = |site: u32| [f64::from(site % 7) + 0.3, f64::from(site / 7) + 0.2];
        let point = order_of([7.0, 7.0], (0..49).map(place));
        assert!(point.local < 1e-12 && point.global < 1e-12, "{point:?}");
        // Rows 1.6 apart. The six nearest: two at distance 1 with exp(6iθ) = 1, two at 1.6 with −1,
        // and of the bodies at √(1 + 1.6²) = 1.89 all four, whose terms are 4 Re (1 + 1.6i)⁶ /
        // 1.89⁶; two more at 2 are not as near.
        let point = order_of(
            [7.0, 8.0],
            (0..35).map(|site| {
                let [x, y] = place(site);
                [x, 1.6 * y]
            }),
        );
        let (a, b) = (1.0, 1.6f64 * 1.6);
        let real = a - 15.0 * b + 15.0 * b * b - b * b * b;
        let expected = (4.0 * real / (1.0 + b).powi(3) / 8.0).abs();
        assert!(
            (point.local - expected).abs() < 1e-12,
            "{point:?} {expected}"
        );
        assert!((point.global - expected).abs() < 1e-12);
    }

    #[test]
    fn random_positions_have_the_order_of_six_random_directions() {
        let mut order = HexaticOrder::new(Group::All);
        for replica in 0..20 {
            let scene = random_points(500, [0.5, 2.0], replica);
            order.sample(&Simulation::new(&scene).unwrap().view());
        }
        let squares = order.series().iter().map(|point| point.local_square);
        let (mean, error) = carom_tables::block_sums::mean_of_series(squares).unwrap();
        assert!(
            (mean - 1.0 / 6.0).abs() < 5.0 * error && error < 0.003,
            "{mean} ± {error}"
        );
        assert!(order.series().iter().all(|point| point.global < 0.15));
        let [_, [sum, samples], _] = order.sums()[..] else {
            panic!("three sums")
        };
        assert!((sum / samples - mean).abs() < 1e-14 && samples == 20.0);
    }

    fn order_by(places: &[DVec2], sides: [f64; 2], n: u32, rule: Neighbours) -> Option<Vec<DVec2>> {
        let scene = discs_at(sides, 1e-9, places.iter().copied());
        orders(places, &Simulation::new(&scene).unwrap().view(), (n, rule))
    }

    #[test]
    fn each_rule_has_its_order_in_lattices_by_hand() {
        // A rectangular lattice with distances 1 and 2: edges of the cells 2 along x and 1 along y.
        let places: Vec<DVec2> = (0..24)
            .map(|site| DVec2::new(f64::from(site % 6) + 0.25, 2.0 * f64::from(site / 6) + 0.5))
            .collect();
        let sides = [6.0, 8.0];
        for (n, rule, expected) in [
            (2, Neighbours::Nearest(2), 1.0),
            (2, Neighbours::Delaunay, 0.0),
            (2, Neighbours::Voronoi, (4.0 - 2.0) / 6.0),
            (4, Neighbours::Voronoi, 1.0),
            (1, Neighbours::Voronoi, 0.0),
        ] {
            for psi in order_by(&places, sides, n, rule).unwrap() {
                assert!(
                    (psi - DVec2::X * expected).length() < 1e-9,
                    "{n} {rule:?}: {psi}"
                );
            }
        }
    }

    #[test]
    fn the_nearest_of_random_positions_have_one_by_their_number_as_mean_square() {
        for (n, count) in [(6, 6), (4, 4), (3, 5), (6, 1)] {
            let mut order =
                HexaticOrder::with_neighbours(Group::All, n, Neighbours::Nearest(count));
            for replica in 0..10 {
                let scene = random_points(500, [0.5, 2.0], replica);
                order.sample(&Simulation::new(&scene).unwrap().view());
            }
            let squares = order.series().iter().map(|point| point.local_square);
            let (mean, error) = carom_tables::block_sums::mean_of_series(squares).unwrap();
            let expected = 1.0 / count as f64;
            assert!(
                (mean - expected).abs() < 5.0 * error + 1e-12,
                "{n} {count}: {mean} ± {error}"
            );
        }
    }

    #[test]
    fn few_bodies_and_bodies_in_a_line_have_numbers_or_none() {
        let line: Vec<DVec2> = (0..8)
            .map(|k| DVec2::new(0.1 * f64::from(k), 0.5))
            .collect();
        let rules = [
            Neighbours::Nearest(6),
            Neighbours::Delaunay,
            Neighbours::Voronoi,
        ];
        for rule in rules {
            for count in [0, 1, 2, 3, 8] {
                for sides in [[1.0, 1.0], [1.0, 0.01]] {
                    let places: Vec<DVec2> = line[..count]
                        .iter()
                        .map(|place| *place * DVec2::new(1.0, sides[1]))
                        .collect();
                    let found = order_by(&places, sides, 6, rule);
                    let is_enough = if rule == rules[0] {
                        count > 6
                    } else {
                        count > 0
                    };
                    assert_eq!(found.is_some(), is_enough, "{rule:?} {count}");
                    assert!(
                        found
                            .iter()
                            .flatten()
                            .all(|psi| psi.length() <= 1.0 + 1e-12)
                    );
                }
            }
        }
    }

    #[test]
    fn the_search_in_cells_agrees_with_all_pairs() {
        for (sides, count) in [
            ([1.0, 1.0], 7),
            ([1.0, 1.0], 60),
            ([0.1, 7.0], 40),
            ([3.0, 1.0], 300),
        ] {
            let scene = random_points(count, sides, 1);
            let simulation = Simulation::new(&scene).unwrap();
            let places: Vec<DVec2> = simulation
                .view()
                .bodies()
                .map(|view| view.motion.position)
                .collect();
            let bounds = simulation.view().bounds();
            let found = orders(&places, &simulation.view(), HEXATIC).unwrap();
            for (index, psi) in found.iter().enumerate() {
                let others = places
                    .iter()
                    .enumerate()
                    .filter(|(other, _)| *other != index);
                let mut near: Vec<DVec2> = others
                    .map(|(_, place)| {
                        let d = *place - places[index];
                        d - bounds.sides() * (d / bounds.sides()).round()
                    })
                    .collect();
                near.sort_by(|one, other| one.length_squared().total_cmp(&other.length_squared()));
                let sum: DVec2 = near[..6]
                    .iter()
                    .map(|d| {
                        let six = 6.0 * d.y.atan2(d.x);
                        DVec2::new(six.cos(), six.sin())
                    })
                    .sum();
                assert!(
                    (*psi - sum / 6.0).length() < 1e-12,
                    "body {index} of {count} in {sides:?}"
                );
            }
        }
    }
}
