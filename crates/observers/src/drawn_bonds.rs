//! The bonds that pages draw between bodies.

use carom_engine::View;

/// For each bond between two drawn bodies, their numbers, and the points of both in their frames,
/// x and y of the first and then of the second (length). `number_of` gives the number of a body by
/// its name ([`Body::id`](carom_engine::Body::id)), `None` if it is not drawn.
///
/// ```
/// use carom_engine::{Scene, Simulation};
/// use carom_observers::drawn_bonds;
///
/// let scene = Scene::from_toml(
///     "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 3\n\
///      chain = { members = 3, tether = { max = 0.03 } }",
/// )?;
/// let simulation = Simulation::new(&scene)?;
/// let bonds = drawn_bonds(&simulation.view(), |name| (name < 2).then_some(name as u32));
/// assert_eq!(bonds, [([0, 1], [0.0; 4])]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn drawn_bonds(
    view: &View<'_>,
    number_of: impl Fn(u64) -> Option<u32>,
) -> Vec<([u32; 2], [f64; 4])> {
    let bonds = view.bonds().filter_map(|bond| {
        let [a, b] = bond.bodies.map(|key| number_of(key.id()));
        let [from, to] = bond.bond.tether.points();
        Some(([a?, b?], [from.x, from.y, to.x, to.y]))
    });
    bonds.collect()
}
