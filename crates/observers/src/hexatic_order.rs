//! The bond-orientational order ψ₆ of the centres of mass.
//!
//! ψ₆ of a body is the mean of exp(6iθ) over its neighbours, θ the direction to the neighbour
//! (Halperin & Nelson 1978). Neighbours are the six nearest bodies, each in its nearest image, and
//! all others as near as the sixth. (Neighbours from a Voronoi construction give other values in a
//! fluid, and the same in a triangular lattice.) |ψ₆| is 1 in a triangular lattice and 0 in a
//! square one, where the four nearest and the four next bodies both cancel. For independent,
//! uniform positions the directions to the six nearest are independent, so that ⟨|ψ₆|²⟩ = 1/6.
//!
//! The global order |Σ ψ₆| / N is of the order of 1/√N without long-range order.

use carom_engine::{Observer, View};
use carom_geometry::PeriodicBox;
use glam::{DVec2, Vec2Swizzles};
use serde::{Deserialize, Serialize};

use crate::Group;

/// The number of nearest neighbours.
const NEIGHBOURS: usize = 6;

/// The largest relative difference of the squares of distances that are taken as equal: far above
/// their rounding, far below any spread in a fluid.
const AS_NEAR: f64 = 1e-9;

/// Bodies per cell of the search. About nine cells, with 18 bodies, hold the six nearest.
const BODIES_PER_CELL: f64 = 2.0;

/// Bond-orientational order of a group at each sample; fixed discs and molecules count, walls do
/// not.
///
/// Samples with fewer than seven bodies in the group are omitted. A sample costs a search of a few
/// cells for each body of a homogeneous system; at worst, with nearly all bodies in one small part
/// of the box, each pair of bodies is compared.
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
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[doc(alias = "psi6")]
pub struct HexaticOrder {
    group: Group,
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
    /// Mean of |ψ₆| over the bodies, from 0 to 1.
    pub local: f64,
    /// Mean of |ψ₆|² over the bodies, from 0 to 1.
    pub local_square: f64,
    /// |mean of ψ₆ over the bodies|, from 0 to 1.
    pub global: f64,
}

impl HexaticOrder {
    /// Order of the bodies of a group, with neighbours in this group only.
    pub fn new(group: Group) -> Self {
        Self {
            group,
            ..Self::default()
        }
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
        let members = view
            .bodies()
            .filter(|view| !view.body.is_wall() && self.group.contains(view.body));
        let places: Vec<DVec2> = members.map(|view| view.motion.position).collect();
        if places.len() <= NEIGHBOURS {
            return;
        }
        let orders = orders(&places, view.bounds());
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
    let bodies = view.bodies().filter(|view| !view.body.is_wall());
    let places: Vec<DVec2> = bodies.map(|view| view.motion.position).collect();
    if places.len() <= NEIGHBOURS {
        return vec![DVec2::ZERO; places.len()];
    }
    orders(&places, view.bounds())
}

/// ψ₆ of each body, real and imaginary part; more than six bodies.
fn orders(places: &[DVec2], bounds: &PeriodicBox) -> Vec<DVec2> {
    let grid = Grid::new(places, bounds);
    let mut found = Vec::new();
    let order = |index| {
        grid.nearest(index, &mut found);
        let sum: DVec2 = found
            .iter()
            .map(|&(_, displacement)| sixth_power(displacement.normalize_or_zero()))
            .sum();
        sum / found.len() as f64
    };
    (0..places.len()).map(order).collect()
}

/// z⁶ of a complex number.
fn sixth_power(z: DVec2) -> DVec2 {
    let square = z.rotate(z);
    square.rotate(square).rotate(square)
}

/// A cell list of positions.
struct Grid<'a> {
    places: &'a [DVec2],
    sides: DVec2,
    cells: [usize; 2],
    /// The indices of the bodies in the order of their cells.
    members: Vec<usize>,
    /// The index in `members` of the first body of each cell; one more entry than cells.
    begins: Vec<usize>,
}

impl<'a> Grid<'a> {
    fn new(places: &'a [DVec2], bounds: &PeriodicBox) -> Self {
        let sides = bounds.sides();
        // Square cells, except in boxes so narrow that one cell is as wide as the box.
        let requested = (places.len() as f64 / BODIES_PER_CELL).max(1.0);
        let shape = (requested * sides / sides.yx()).map(f64::sqrt).floor();
        let cells = shape
            .clamp(DVec2::ONE, DVec2::splat(requested.floor()))
            .to_array()
            .map(|n| n as usize);
        let mut grid = Self {
            places,
            sides,
            cells,
            members: Vec::new(),
            begins: vec![0; cells[0] * cells[1] + 1],
        };
        grid.members = (0..places.len()).collect();
        let cell_of: Vec<usize> = (0..places.len())
            .map(|index| {
                let [x, y] = grid.cell(index);
                x + y * cells[0]
            })
            .collect();
        grid.members.sort_by_key(|&index| cell_of[index]);
        for &cell in &cell_of {
            grid.begins[cell + 1] += 1;
        }
        for cell in 1..grid.begins.len() {
            grid.begins[cell] += grid.begins[cell - 1];
        }
        grid
    }

    /// Column and row of a body.
    fn cell(&self, index: usize) -> [usize; 2] {
        let place = self.places[index] / self.sides;
        let axis = |place: f64, cells: usize| ((place * cells as f64) as usize).min(cells - 1);
        [axis(place.x, self.cells[0]), axis(place.y, self.cells[1])]
    }

    /// Collects the squared distances and displacements to the neighbours of a body. The search
    /// goes in rings of cells until no body farther out can be a neighbour.
    fn nearest(&self, index: usize, found: &mut Vec<(f64, DVec2)>) {
        found.clear();
        let [columns, rows] = self.cells;
        let size = self.sides / DVec2::new(columns as f64, rows as f64);
        let last_ring = columns.max(rows) / 2;
        let mut limit = f64::INFINITY;
        for ring in 0..=last_ring {
            self.collect_ring(index, ring, found);
            // Cells in later rings are at least this far away.
            let reached = ring as f64 * size.min_element();
            if found.len() >= NEIGHBOURS {
                found
                    .select_nth_unstable_by(NEIGHBOURS - 1, |one, other| one.0.total_cmp(&other.0));
                limit = found[NEIGHBOURS - 1].0 * (1.0 + AS_NEAR);
                if limit <= reached * reached {
                    break;
                }
            }
        }
        found.retain(|&(squared, _)| squared <= limit);
    }

    /// Adds the bodies in the cells `ring` columns or rows away, and no farther.
    fn collect_ring(&self, index: usize, ring: usize, found: &mut Vec<(f64, DVec2)>) {
        let [columns, rows] = self.cells;
        let [column, row] = self.cell(index);
        for (y, up) in near(row, rows, ring) {
            for (x, across) in near(column, columns, ring) {
                if up.max(across) != ring {
                    continue;
                }
                let cell = x + y * columns;
                for &other in &self.members[self.begins[cell]..self.begins[cell + 1]] {
                    if other != index {
                        let displacement = self.places[other] - self.places[index];
                        let nearest =
                            displacement - self.sides * (displacement / self.sides).round();
                        found.push((nearest.length_squared(), nearest));
                    }
                }
            }
        }
    }
}

/// The columns (or rows) up to `ring` away from one, each once, and how far they are.
fn near(at: usize, cells: usize, ring: usize) -> impl Iterator<Item = (usize, usize)> {
    let below = ring.min((cells - 1) / 2);
    let above = ring.min(cells / 2);
    let steps = (1..=below).map(move |step| ((at + cells - step) % cells, step));
    steps.chain((0..=above).map(move |step| ((at + step) % cells, step)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::random_points;
    use carom_engine::{BumperSpec, Scene, Simulation};

    fn order_of(sides: [f64; 2], places: impl Iterator<Item = [f64; 2]>) -> HexaticPoint {
        let mut scene = Scene::default();
        scene.bounds.sides = sides;
        // A wall does not count.
        scene.wall = Scene::from_toml("[[wall]]\nx = 0.9").unwrap().wall;
        scene.bumper = places
            .map(|at| BumperSpec {
                radius: 0.01,
                at,
                tags: vec![],
            })
            .collect();
        let mut order = HexaticOrder::new(Group::All);
        order.sample(&Simulation::new(&scene).unwrap().view());
        order.series()[0]
    }

    #[test]
    fn a_triangular_lattice_has_order_one() {
        let height = 0.75f64.sqrt();
        let place = |site: u32| {
            let [x, y] = [f64::from(site % 8), f64::from(site / 8)];
            [x + 0.5 * (y % 2.0) + 0.1, height * y]
        };
        let point = order_of([8.0, 10.0 * height], (0..80).map(place));
        assert!(
            (point.local - 1.0).abs() < 1e-12 && (point.global - 1.0).abs() < 1e-12,
            "{point:?}"
        );
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
            let found = orders(&places, bounds);
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
