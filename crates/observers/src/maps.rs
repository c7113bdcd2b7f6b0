//! Maps of the whole box, for systems of too many bodies to draw one by one: the area fraction and
//! the hexagonal order in the cells of a grid.

use carom_engine::{BodyView, View};
use glam::DVec2;

use crate::hexatic_order::complex_orders;

/// Mean number of bodies in a cell. Fewer: noise. More: a coarser map.
const BODIES_PER_CELL: f64 = 16.0;

/// A quantity in the cells of a grid that covers the box.
#[derive(Debug, Clone, PartialEq)]
pub struct BoxMap<T> {
    /// Columns and rows.
    pub counts: [usize; 2],
    /// Row by row from the lower left corner.
    pub values: Vec<T>,
}

/// The area fraction in cells of about sixteen bodies, with at most `most` cells along a side: the
/// areas of all bodies whose centre of mass is in a cell, over its area. Walls do not count.
///
/// ```
/// use carom_engine::{Scene, Simulation};
/// use carom_observers::density_map;
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.005\nmass = 1.0\nenergy = 1.0\ncount = 1600")?;
/// let map = density_map(&Simulation::new(&scene)?.view(), 100);
/// let mean = map.values.iter().sum::<f64>() / map.values.len() as f64;
/// assert_eq!(map.counts, [10, 10]);
/// assert!((mean - 1600.0 * std::f64::consts::PI * 0.005f64.powi(2)).abs() < 1e-12);
/// # Ok::<(), carom_engine::SceneError>(())
/// ```
pub fn density_map(view: &View<'_>, most: usize) -> BoxMap<f64> {
    let bodies = || view.bodies().filter(|body| !body.body.is_wall());
    let mut map = BoxMap::empty(view, bodies().count(), most, 0.0);
    let cell_area = view.bounds().area() / map.values.len() as f64;
    for body in bodies() {
        let cell = map.cell(view, &body);
        map.values[cell] += body.body.molecule().area() / cell_area;
    }
    map
}

/// The mean of ψ₆ in cells of about sixteen bodies (real and imaginary part, see
/// [`HexaticOrder`](crate::HexaticOrder)), with at most `most` cells along a side. Its magnitude is
/// near 1 in a crystal and 0 where directions differ; its argument is six times the direction of
/// the crystal. Walls do not count; all is 0 for fewer than seven bodies.
///
/// ```
/// use carom_engine::{Scene, Simulation};
/// use carom_observers::order_map;
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.005\nmass = 1.0\nenergy = 1.0\ncount = 1600")?;
/// let map = order_map(&Simulation::new(&scene)?.view(), 5);
/// assert!(map.counts == [5, 5] && map.values.iter().all(|order| order.length() <= 1.0));
/// # Ok::<(), carom_engine::SceneError>(())
/// ```
pub fn order_map(view: &View<'_>, most: usize) -> BoxMap<DVec2> {
    let orders = complex_orders(view);
    let mut map = BoxMap::empty(view, orders.len(), most, DVec2::ZERO);
    let mut numbers = vec![0.0_f64; map.values.len()];
    for (body, order) in view
        .bodies()
        .filter(|body| !body.body.is_wall())
        .zip(orders)
    {
        let cell = map.cell(view, &body);
        map.values[cell] += order;
        numbers[cell] += 1.0;
    }
    map.values
        .iter_mut()
        .zip(numbers)
        .for_each(|(sum, number)| *sum /= number.max(1.0));
    map
}

impl<T: Clone> BoxMap<T> {
    fn empty(view: &View<'_>, bodies: usize, most: usize, value: T) -> Self {
        let sides = view.bounds().sides();
        let requested = (bodies as f64 / BODIES_PER_CELL).max(1.0);
        // Square cells.
        let shorter = (requested * sides.min_element() / sides.max_element()).sqrt();
        let along = |side: f64| shorter * (side / sides.min_element());
        let scale = (most.max(1) as f64 / along(sides.max_element())).min(1.0);
        let counts = sides
            .to_array()
            .map(|side| (scale * along(side)).round().max(1.0) as usize);
        Self {
            counts,
            values: vec![value; counts[0] * counts[1]],
        }
    }

    /// The cell of a body's centre of mass.
    fn cell(&self, view: &View<'_>, body: &BodyView<'_>) -> usize {
        let place = body.motion.position / view.bounds().sides();
        let [column, row] = [0, 1].map(|axis| {
            let cell = (place[axis] * self.counts[axis] as f64).max(0.0) as usize;
            cell.min(self.counts[axis] - 1)
        });
        row * self.counts[0] + column
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_engine::{AtomSpec, MoleculeSpec, Scene, Simulation};

    /// A triangular lattice of 24 × 28 discs, whose rows are along x or along y.
    fn crystal(is_turned: bool) -> Simulation {
        let row = 0.75_f64.sqrt();
        let disc = |column: usize, line: usize| {
            let place = [
                column as f64 + 0.5 * (line % 2) as f64 + 0.2,
                row * line as f64 + 0.3,
            ];
            let at = if is_turned {
                [place[1], place[0]]
            } else {
                place
            };
            let atoms = vec![AtomSpec {
                at: [0.0; 2],
                radius: 0.45,
                mass: 1.0,
            }];
            MoleculeSpec {
                atoms,
                at,
                ..MoleculeSpec::default()
            }
        };
        let molecule = (0..28)
            .flat_map(|line| (0..24).map(move |column| disc(column, line)))
            .collect();
        let mut scene = Scene {
            molecule,
            ..Scene::default()
        };
        let sides = [24.0, 28.0 * row];
        scene.bounds.sides = if is_turned {
            [sides[1], sides[0]]
        } else {
            sides
        };
        Simulation::new(&scene).unwrap()
    }

    #[test]
    fn a_crystal_has_order_in_its_own_direction_everywhere() {
        for (is_turned, direction) in [(false, 1.0), (true, -1.0)] {
            let map = order_map(&crystal(is_turned).view(), 100);
            // Rows along y are turned by 30°, six times of which is half a turn.
            assert!(
                map.values
                    .iter()
                    .all(|order| (*order - direction * DVec2::X).length() < 1e-9)
            );
        }
    }

    #[test]
    fn dense_halves_are_denser() {
        let atoms = vec![AtomSpec {
            at: [0.0; 2],
            radius: 0.02,
            mass: 1.0,
        }];
        let disc = |k: u32| {
            let at = [
                0.04 * f64::from(k % 12) + 0.03,
                0.04 * f64::from(k / 12) + 0.03,
            ];
            MoleculeSpec {
                atoms: atoms.clone(),
                at,
                ..MoleculeSpec::default()
            }
        };
        let scene = Scene {
            molecule: (0..12 * 24).map(disc).collect(),
            ..Scene::default()
        };
        let map = density_map(&Simulation::new(&scene).unwrap().view(), 4);
        assert_eq!(map.counts, [4, 4]);
        for (cell, fraction) in map.values.iter().enumerate() {
            assert_eq!(*fraction > 0.5, cell % 4 < 2, "{cell}: {fraction}");
        }
    }
}
