//! Connections of the bodies of a cluster by bonds and by the wells of discs.

use std::collections::HashMap;

use carom_engine::{BodyKey, BodyView, View};
use carom_geometry::PeriodicBox;
use serde::{Deserialize, Serialize};

use crate::disjoint_sets::DisjointSets;

/// What connects two bodies that need not touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Bonding {
    /// A tether between points of both.
    Bonds,
    /// The range of a well, where the energy of the pair is below 0: a pair on a shoulder is not
    /// connected.
    Wells,
    /// A tether or a well.
    #[default]
    BondsOrWells,
}

impl Bonding {
    /// The pairs of bodies that are connected now.
    fn pairs<'a>(self, view: &View<'a>) -> impl Iterator<Item = [BodyKey; 2]> + use<'a> {
        let has_bonds = self != Self::Wells;
        let has_wells = self != Self::Bonds && view.has_wells();
        let bonds = has_bonds.then(|| view.bonds().map(|bond| bond.bodies));
        let attracted = has_wells.then(|| {
            let pairs = view.pairs_in_wells().filter(|pair| pair.energy < 0.0);
            pairs.map(|pair| pair.bodies)
        });
        bonds
            .into_iter()
            .flatten()
            .chain(attracted.into_iter().flatten())
    }

    /// Connects the members of a group, which are a part of the bodies of the view. Pairs with a
    /// body that is no member are left out.
    pub(crate) fn sets(self, members: &[BodyView<'_>], view: &View<'_>) -> DisjointSets {
        let mut sets = DisjointSets::new(members.len());
        let keys = members.iter().map(|member| member.body.key());
        let places: HashMap<BodyKey, usize> = keys.zip(0..).collect();
        let bounds = view.bounds();
        for pair in self.pairs(view) {
            let [Some(&one), Some(&other)] = pair.map(|key| places.get(&key)) else {
                continue;
            };
            let image = nearest_image([&members[one], &members[other]], &bounds);
            sets.connect(one, other, image);
        }
        sets
    }
}

/// The image of the second body that is nearest to the first (boxes).
fn nearest_image([one, other]: [&BodyView<'_>; 2], bounds: &PeriodicBox) -> [i64; 2] {
    let apart = other.motion.position - one.motion.position;
    let shift = bounds.nearest_image(apart) - apart;
    // The middle of the box is farther from its border than any rounding.
    let (_, image) = bounds.wrap(shift + 0.5 * bounds.sides());
    image
}
