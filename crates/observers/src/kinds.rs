//! Kinds of bodies, to distinguish them in a picture or a table.

use std::collections::BTreeMap;

use carom_engine::{Body, Tag, View};

/// The common properties of a kind: fixed or not, tags, number of atoms, size, mass.
type Likeness<'a> = (bool, &'a [Tag], usize, u64, u64);

/// The kind of each body of a view, in its order, numbered 0, 1, … in order of appearance.
///
/// Bodies of one kind have the same tags, number of atoms, size and mass, and all or none of them
/// are fixed.
pub fn kinds(view: &View<'_>) -> Vec<usize> {
    let mut known: BTreeMap<Likeness<'_>, usize> = BTreeMap::new();
    view.bodies()
        .map(|view| {
            let next = known.len();
            *known.entry(likeness(view.body)).or_insert(next)
        })
        .collect()
}

fn likeness(body: &Body) -> Likeness<'_> {
    let molecule = body.molecule();
    let size = molecule.bounding_radius().to_bits();
    (body.is_fixed(), body.tags(), molecule.atoms().len(), size, molecule.mass().to_bits())
}
