//! Tethers between bodies: which two bodies each of them ties, and the next event of one.

use carom_detection::{Outcome, Tether, TetherError};
use carom_kinematics::Motion;
use carom_response::Elasticity;
use glam::DVec2;

use crate::world::{
    World,
    body::BodyKey,
    contact_event::TouchingParts,
    rounding_bound::rounding_bound,
    view::{View, body_at},
};

/// A tether of two bodies of the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bond {
    /// The two bodies by their index, the one inserted earlier first.
    pub bodies: [u32; 2],
    /// The points and the bounds on their distance.
    pub tether: Tether,
    /// The elasticity of the tether at both of its bounds.
    pub elasticity: Elasticity,
}

impl Bond {
    /// How much more than its longest length a length is, or less than its shortest (length);
    /// negative between the bounds.
    pub fn excess(&self, length: f64) -> f64 {
        let [shortest, longest] = self.tether.bounds();
        let short = if shortest > 0.0 {
            shortest - length
        } else {
            f64::NEG_INFINITY
        };
        (length - longest).max(short)
    }
}

/// The end of a bond at one of its bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BondEnd {
    /// The bond, by its index in [`World::bonds`].
    pub bond: u32,
    /// The body at the other end.
    pub partner: u32,
}

/// All bonds, and those of each body.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Tethers {
    bonds: Vec<Bond>,
    /// Place in `ends` of the first end at each body, and at none after the last; empty without a
    /// bond. Bodies beyond the list have no bond.
    first: Vec<u32>,
    ends: Vec<BondEnd>,
}

impl Tethers {
    pub fn new(bonds: Vec<Bond>) -> Self {
        let bodies = bonds.iter().map(|bond| bond.bodies[1] as usize + 1).max();
        let mut first = vec![0; bodies.map_or(0, |count| count + 1)];
        for body in bonds.iter().flat_map(|bond| bond.bodies) {
            first[body as usize + 1] += 1;
        }
        for body in 1..first.len() {
            first[body] += first[body - 1];
        }
        let nothing = BondEnd {
            bond: 0,
            partner: 0,
        };
        let mut ends = vec![nothing; 2 * bonds.len()];
        let mut next = first.clone();
        for (number, bond) in (0..).zip(&bonds) {
            for (body, partner) in [(0, 1), (1, 0)] {
                let place = &mut next[bond.bodies[body] as usize];
                ends[*place as usize] = BondEnd {
                    bond: number,
                    partner: bond.bodies[partner],
                };
                *place += 1;
            }
        }
        Self { bonds, first, ends }
    }

    #[inline]
    pub fn is_empty(&self) -> bool {
        self.bonds.is_empty()
    }

    pub fn bonds(&self) -> &[Bond] {
        &self.bonds
    }

    #[inline]
    fn ends_at(&self, body: u32) -> &[BondEnd] {
        let place = body as usize;
        match self.first.get(place..=place + 1) {
            Some(&[begin, end]) => &self.ends[begin as usize..end as usize],
            _ => &[],
        }
    }

    /// The bonds that are left when only some bodies remain: `number` gives the new index of each.
    pub fn renumbered(&self, number: impl Fn(u32) -> Option<u32>) -> Self {
        let bonds = self.bonds.iter().filter_map(|bond| {
            let [Some(a), Some(b)] = bond.bodies.map(&number) else {
                return None;
            };
            Some(Bond {
                bodies: [a, b],
                ..*bond
            })
        });
        Self::new(bonds.collect())
    }

    /// The bonds while gases grow: elastic, with lengths times a factor for each, above 0, and no
    /// shortest length unless it is 1.
    ///
    /// # Errors
    /// A length is out of range.
    pub fn grown(&self, factor: impl Fn([u32; 2]) -> f64) -> Result<Self, TetherError> {
        let bonds = self.bonds.iter().map(|bond| {
            let ([shortest, longest], factor) = (bond.tether.bounds(), factor(bond.bodies));
            let bounds = if factor == 1.0 {
                [shortest, longest]
            } else {
                [0.0, factor * longest]
            };
            Ok(Bond {
                tether: Tether::new(bond.tether.points(), bounds)?,
                elasticity: Elasticity::ELASTIC,
                ..*bond
            })
        });
        Ok(Self::new(bonds.collect::<Result<_, _>>()?))
    }

    pub fn heap_bytes(&self) -> usize {
        self.bonds.capacity() * size_of::<Bond>()
            + self.first.capacity() * size_of::<u32>()
            + self.ends.capacity() * size_of::<BondEnd>()
    }
}

/// A bond in a view.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct BondView<'a> {
    /// The bond.
    pub bond: &'a Bond,
    /// Its two bodies, the one inserted earlier first.
    pub bodies: [BodyKey; 2],
    /// The place of its point on the first body, whose centre is in the box (length).
    pub from: DVec2,
    /// The vector from there to its point on the second body (length).
    pub span: DVec2,
    /// The distance of its points (length).
    pub length: f64,
}

impl<'a> View<'a> {
    /// The bonds between bodies.
    pub fn bonds(&self) -> impl ExactSizeIterator<Item = BondView<'a>> + use<'a> {
        let Self { world, offset, .. } = *self;
        world.bonds().iter().map(move |bond| {
            let [a, b] = bond
                .bodies
                .map(|body| body_at(world, body as usize, offset));
            let motions = [&a.motion, &b.motion];
            let (span, arms) = World::span_of_bond(bond, motions, world.nearest_shift(motions));
            BondView {
                bond,
                bodies: [a.body.key(), b.body.key()],
                from: a.motion.position + arms[0],
                span,
                length: span.length(),
            }
        })
    }
}

impl World {
    /// All bonds between bodies.
    pub fn bonds(&self) -> &[Bond] {
        self.tethers.bonds()
    }

    /// The bonds of a body (index in the order of [`Self::bodies`]).
    #[inline]
    pub fn bonds_of(&self, body: u32) -> &[BondEnd] {
        self.tethers.ends_at(body)
    }

    /// Whether a bond ties a disc that moves at another point than its centre, so that its
    /// orientation matters.
    pub(crate) fn ties_discs_beside_their_centres(&self) -> bool {
        self.bonds().iter().any(|bond| {
            let ends = bond.bodies.into_iter().zip(bond.tether.points());
            ends.into_iter().any(|(body, point)| {
                let body = &self.bodies[body as usize];
                point != DVec2::ZERO && body.is_free() && body.molecule().is_disc()
            })
        })
    }

    /// Whether any two bodies are tethered.
    #[inline]
    pub fn is_tethered(&self) -> bool {
        !self.tethers.is_empty()
    }

    /// The image of the second body, in boxes, whose centre is nearest to that of the first: the
    /// one that a tether between them holds. Both places are at one time.
    #[inline]
    pub fn nearest_image(&self, [a, b]: [DVec2; 2]) -> [i64; 2] {
        let nearest = |apart: f64| {
            // Both are in the box or near it: `round` is a call where it is no instruction.
            if apart.abs() < 1.5 {
                i64::from(apart >= 0.5) - i64::from(apart <= -0.5)
            } else {
                apart.round() as i64
            }
        };
        let apart = (a - b) / self.bounds.sides();
        [nearest(apart.x), nearest(apart.y)]
    }

    /// Whether the centres of two bodies, with these places and an image of the second, certainly
    /// stay between two distances (length) up to a horizon (time): they are farther from both than
    /// they move. A shortest distance of 0 is no bound.
    #[inline]
    pub(crate) fn stay_between(
        &self,
        [shortest, longest]: [f64; 2],
        [a, b]: [&Motion; 2],
        places: [DVec2; 2],
        image: [i64; 2],
        horizon: f64,
    ) -> bool {
        let between = (places[1] - places[0]) + self.bounds.shift(image);
        let squared = between.length_squared();
        let way = (b.velocity - a.velocity).length() * horizon;
        // More than the rounding of all of them.
        let margin = 1e-9 * longest + rounding_bound(self.bounds.sides(), longest);
        let (outer, inner) = (longest - (way + margin), shortest + (way + margin));
        let is_far = shortest == 0.0 || squared > inner * inner;
        outer > 0.0 && squared < outer * outer && is_far
    }

    /// The shift of the second body to its nearest image (length).
    pub(crate) fn nearest_shift(&self, motions: [&Motion; 2]) -> DVec2 {
        self.bounds
            .shift(self.nearest_image(motions.map(|motion| motion.position)))
    }

    /// The first event of a bond from `now` (offset in the epoch) up to `horizon` (time from now),
    /// with the present motions of its two bodies, and the image of the second that it holds.
    pub fn first_bond_event(
        &self,
        bond: u32,
        motions: [&Motion; 2],
        now: f64,
        horizon: f64,
    ) -> (Outcome<TouchingParts>, [i64; 2]) {
        let Bond { bodies, tether, .. } = &self.tethers.bonds[bond as usize];
        let here = motions.map(|motion| motion.position_at(now));
        let image = self.nearest_image(here);
        let ties_centres = tether.points() == [DVec2::ZERO; 2];
        if ties_centres && self.stay_between(tether.bounds(), motions, here, image, horizon) {
            return (Outcome::Free, image);
        }
        let relative = self.relative_motion(*bodies, motions, image, now);
        let outcome = tether.first_event(&relative, horizon);
        (outcome.map(|bound| TouchingParts::Bond(bond, bound)), image)
    }

    /// The vector between the points of a bond from its first to its second body (length), and the
    /// arms of the points (length), with motions at one time.
    pub(crate) fn span_of_bond(
        bond: &Bond,
        motions: [&Motion; 2],
        shift: DVec2,
    ) -> (DVec2, [DVec2; 2]) {
        let points = bond.tether.points();
        let arms = [0, 1].map(|n| motions[n].orientation.cos_sin().rotate(points[n]));
        let between = (motions[1].position - motions[0].position) + (arms[1] - arms[0]) + shift;
        (between, arms)
    }

    /// How much longer than its longest length a bond is, or shorter than its shortest (length);
    /// negative between its bounds. Motions are those stored at the start of an epoch.
    pub(crate) fn excess_of_bond(&self, bond: &Bond) -> f64 {
        let [a, b] = bond.bodies.map(|body| &self.motions[body as usize]);
        let (between, _) = Self::span_of_bond(bond, [a, b], self.nearest_shift([a, b]));
        bond.excess(between.length())
    }
}
