//! The state of the system: every body, its motion, and which periodic image of it is in the box.

use std::sync::Arc;

use carom_geometry::PeriodicBox;
use carom_kinematics::{EpochTime, Motion, kinetic_energy};

use crate::{Body, BodyKey, body::BodyKind};

/// Bodies that a new one is compared with. Fewer: the bodies of a mixture share less.
const LAST_FEW: usize = 16;

/// All bodies and their motions. Bodies stand in order of insertion; their times are offsets from the
/// start of the epoch.
#[derive(Debug, Clone)]
pub struct World {
    pub(crate) bounds: PeriodicBox,
    pub(crate) bodies: Vec<Body>,
    pub(crate) motions: Vec<Motion>,
    /// How many boxes each body has left behind, per axis.
    pub(crate) windings: Vec<[i64; 2]>,
    /// When each body last had a contact, as an offset in the epoch, −∞ if never; empty where no guard asks for it.
    pub(crate) last_contacts: Vec<f64>,
    /// Start of the epoch.
    pub(crate) epoch: EpochTime,
    pub(crate) next_id: u64,
}

impl World {
    pub(crate) fn new(bounds: PeriodicBox) -> Self {
        Self {
            bounds,
            bodies: Vec::new(),
            motions: Vec::new(),
            windings: Vec::new(),
            last_contacts: Vec::new(),
            epoch: EpochTime::ZERO,
            next_id: 0,
        }
    }

    /// The periodic box.
    pub fn bounds(&self) -> &PeriodicBox {
        &self.bounds
    }

    /// The bodies, in order of insertion.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// The motions, in the order of [`Self::bodies`]; times are offsets from the epoch's start.
    pub fn motions(&self) -> &[Motion] {
        &self.motions
    }

    /// How many boxes each body has left behind since it was added, in the order of
    /// [`Self::bodies`].
    pub fn windings(&self) -> &[[i64; 2]] {
        &self.windings
    }

    /// When each body last had a contact, in the order of [`Self::bodies`], as an offset from the epoch's start (time); −∞
    /// for one that never had. Empty where nothing guards against inelastic collapse.
    pub fn last_contacts(&self) -> &[f64] {
        &self.last_contacts
    }

    /// Start of the epoch.
    pub fn epoch(&self) -> EpochTime {
        self.epoch
    }

    /// Place of a body in the order of [`Self::bodies`].
    pub fn index(&self, key: BodyKey) -> Option<usize> {
        self.bodies.binary_search_by_key(&key, Body::key).ok()
    }

    /// Kinetic energy of all bodies (mass × length² / time²).
    pub fn energy(&self) -> f64 {
        self.motions
            .iter()
            .zip(&self.bodies)
            .map(|(motion, body)| kinetic_energy(motion, &body.kind.inertia))
            .sum()
    }

    /// The largest distance from centre to centre at which two bodies that can collide may touch
    /// (length), or from a centre to the line of a wall; 0 if there are none.
    pub fn largest_reach(&self) -> f64 {
        self.farthest_reaching().map_or(0.0, |(reach, _)| reach)
    }

    /// The two bodies that can touch from farthest away, and that distance (length): the largest that moves, and the
    /// largest other. One that moves and is alone reaches itself, with its bounding radius for a distance.
    pub(crate) fn farthest_reaching(&self) -> Option<(f64, [usize; 2])> {
        let radius = |index: usize| self.bodies[index].reach();
        // The first of several as large.
        let largest = |skip: Option<usize>, fixed_too: bool| {
            (0..self.bodies.len())
                .filter(|&index| Some(index) != skip && (fixed_too || !self.bodies[index].is_fixed()))
                .reduce(|best, index| if radius(index) > radius(best) { index } else { best })
        };
        let first = largest(None, false)?;
        Some(match largest(Some(first), true) {
            Some(second) => (radius(first) + radius(second), [first, second]),
            None => (radius(first), [first; 2]),
        })
    }

    /// The two bodies of which atoms touch at the smallest distance of their centres, and that distance (length): the body
    /// with the smallest atom of those that move, and that of the others. None where there is nothing to meet.
    pub(crate) fn closest_touching(&self) -> Option<(f64, [usize; 2])> {
        let atom = |index: usize| self.bodies[index].smallest_reach();
        let smallest = |skip: Option<usize>, fixed_too: bool| {
            (0..self.bodies.len())
                .filter(|&index| Some(index) != skip && (fixed_too || !self.bodies[index].is_fixed()))
                .map(|index| (atom(index), index))
                .reduce(|best, other| if other.0 < best.0 { other } else { best })
        };
        let (first_radius, first) = smallest(None, false)?;
        let (second_radius, second) = smallest(Some(first), true)?;
        Some((first_radius + second_radius, [first, second]))
    }

    /// The largest bounding radius of a body that moves (length).
    pub(crate) fn largest_moving_radius(&self) -> f64 {
        let moving = self.bodies.iter().filter(|body| !body.is_fixed());
        moving.map(|body| body.kind.molecule.bounding_radius()).fold(0.0, f64::max)
    }

    /// Whether one body moves and all others are fixed: a billiard.
    pub(crate) fn is_billiard(&self) -> bool {
        self.bodies.iter().filter(|body| !body.is_fixed()).take(2).count() == 1
    }

    /// Memory kept on the heap (bytes), shapes not included.
    pub(crate) fn heap_bytes(&self) -> usize {
        self.bodies.capacity() * size_of::<Body>()
            + self.motions.capacity() * size_of::<Motion>()
            + self.windings.capacity() * size_of::<[i64; 2]>()
            + self.last_contacts.capacity() * size_of::<f64>()
    }

    pub(crate) fn insert(&mut self, kind: BodyKind, motion: Motion) -> BodyKey {
        // Keys ascend in order of insertion: that is how a body is found again.
        let key = BodyKey(self.next_id);
        self.push_body(key, kind);
        let (position, winding) = self.bounds.wrap(motion.position);
        self.motions.push(Motion { position, ..motion });
        self.windings.push(winding);
        self.next_id += 1;
        key
    }

    /// Adds a body, which shares its kind with one of the last few if they are alike: what is shared stays in the caches.
    pub(crate) fn push_body(&mut self, key: BodyKey, kind: BodyKind) {
        let shared = self.bodies.iter().rev().take(LAST_FEW).find(|before| before.kind.is_like(&kind));
        let kind = shared.map_or_else(|| Arc::new(kind), |before| Arc::clone(&before.kind));
        self.bodies.push(Body { key, kind });
    }

    /// How many descriptions the bodies have among them.
    #[cfg(test)]
    pub(crate) fn count_kinds(&self) -> usize {
        let kinds: std::collections::HashSet<_> =
            self.bodies.iter().map(|body| Arc::as_ptr(&body.kind)).collect();
        kinds.len()
    }

    /// Gives back the memory that growing has left over.
    pub(crate) fn shrink(&mut self) {
        self.bodies.shrink_to_fit();
        self.motions.shrink_to_fit();
        self.windings.shrink_to_fit();
    }

    /// Keeps the bodies at the places for which this holds. They keep their order, so that order stays that of insertion.
    pub(crate) fn keep_bodies(&mut self, keeps: impl Fn(usize) -> bool) {
        fn keep<T>(list: &mut Vec<T>, keeps: impl Fn(usize) -> bool) {
            let mut places = 0..;
            list.retain(|_| places.next().is_some_and(&keeps));
        }
        keep(&mut self.bodies, &keeps);
        keep(&mut self.motions, &keeps);
        keep(&mut self.windings, &keeps);
        keep(&mut self.last_contacts, &keeps);
    }

    /// Takes back the body added last, as if it had never been there.
    pub(crate) fn take_back_last(&mut self) {
        self.bodies.pop();
        self.motions.pop();
        self.windings.pop();
        self.next_id -= 1;
    }

    /// Keeps the times of last contacts from now on, or no longer; bodies that are new have had none.
    pub(crate) fn keep_last_contacts(&mut self, wanted: bool) {
        let count = if wanted { self.bodies.len() } else { 0 };
        self.last_contacts.resize(count, f64::NEG_INFINITY);
    }

    /// Brings every moving body to `offset` in the epoch and begins a new epoch there.
    pub(crate) fn rebase(&mut self, offset: f64) {
        for ((motion, body), winding) in self.motions.iter_mut().zip(&self.bodies).zip(&mut self.windings) {
            if body.is_fixed() {
                continue;
            }
            let here = motion.at(offset);
            let (position, image) = self.bounds.wrap(here.position);
            *motion = Motion { position, time: 0.0, ..here };
            winding[0] += image[0];
            winding[1] += image[1];
        }
        for time in &mut self.last_contacts {
            *time -= offset;
        }
        self.epoch = self.epoch.new_epoch(offset);
    }
}

#[cfg(test)]
mod tests {
    use crate::{CellScheduler, GasSpec, MoleculeSpec, Scene, Simulation};
    use carom_detection::Exact;
    use carom_response::Impact;

    /// How many descriptions the bodies of a scene have among them.
    fn kinds(scene: &Scene) -> usize {
        let simulation = Simulation::<Exact, Impact, CellScheduler>::new(scene).unwrap();
        simulation.world.count_kinds()
    }

    #[test]
    fn like_bodies_share_their_description_however_they_are_listed() {
        let disc = |number: u32, radius: f64| MoleculeSpec {
            shape: Some("disc".to_owned()),
            atom_radius: Some(radius),
            atom_mass: Some(1.0),
            at: [f64::from(number % 10) * 0.1, f64::from(number / 10) * 0.1],
            ..MoleculeSpec::default()
        };
        let molecule =
            (0..100).map(|number| disc(number, if number % 3 == 0 { 0.03 } else { 0.02 })).collect();
        assert_eq!(kinds(&Scene { molecule, ..Scene::default() }), 2);
        let gas = |radius| GasSpec {
            radius: Some(radius),
            mass: Some(1.0),
            count: Some(200),
            energy: 1.0,
            ..GasSpec::default()
        };
        assert!(kinds(&Scene { gas: vec![gas(0.01), gas(0.02)], ..Scene::default() }) <= 4);
    }
}
