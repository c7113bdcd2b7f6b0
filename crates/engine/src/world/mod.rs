//! The state of the system: all bodies, their motions, and their windings.

pub(crate) mod body;
pub(crate) mod centre_of_mass;
pub(crate) mod coincident_walls;
pub(crate) mod contact_event;
pub(crate) mod counters;
pub(crate) mod drives;
pub(crate) mod heat;
pub(crate) mod index_or_none;
pub(crate) mod near_pairs;
pub(crate) mod pair_table;
pub(crate) mod pistons;
pub(crate) mod reaction_record;
pub(crate) mod report;
pub(crate) mod rounding_bound;
pub(crate) mod shear;
pub(crate) mod tag_classes;
pub(crate) mod tags;
pub(crate) mod tethers;
pub(crate) mod view;
pub(crate) mod wall;
pub(crate) mod wall_table;
pub(crate) mod wells;
pub(crate) mod wrapped;

use std::{collections::BTreeMap, sync::Arc};

use carom_geometry::PeriodicBox;
use carom_kinematics::{DragClock, EpochTime, Motion, Orientation, kinetic_energy};
use glam::DVec2;

use crate::world::{
    body::{Body, BodyKey, BodyKind, BodyName},
    counters::Ledger,
    drives::Oscillation,
    heat::exact_sum,
    pair_table::PairTable,
    pistons::Piston,
    tags::{TagNames, Tags},
    tethers::Tethers,
    wall_table::WallTable,
    wells::Shells,
};

/// Number of earlier bodies with which a new one is compared, to share a description. Smaller: the
/// bodies of a mixture share less.
const LAST_FEW: usize = 16;

/// All bodies and their motions. Bodies are in order of insertion; times are offsets from the start
/// of the epoch.
#[derive(Debug, Clone)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is found once and read in another loop"
)]
pub struct World {
    pub(crate) bounds: PeriodicBox,
    pub(crate) bodies: Vec<Body>,
    pub(crate) motions: Vec<Motion>,
    /// Number of boxes that each body has crossed, per axis.
    pub(crate) windings: Vec<[i64; 2]>,
    /// Time of each body's last contact, as an offset in the epoch, −∞ if there was none; empty
    /// without a guard.
    pub(crate) last_contacts: Vec<f64>,
    /// Axis of each round body that self-propulsion drives, in the order of the bodies; shorter
    /// than the list of bodies if the last ones have none. Schedulers do not hold the orientations
    /// of discs.
    pub(crate) axes: Vec<Option<Orientation>>,
    /// Walls that oscillate, in the order of the bodies; shorter than the list of bodies if the
    /// last ones do not, and empty if none does.
    pub(crate) oscillations: Vec<Option<Oscillation>>,
    /// Acceleration of all free bodies (length per time squared).
    pub(crate) gravity: DVec2,
    /// Shear rate: by how much the box above is faster for each unit of height (1/time). The tilt
    /// of `bounds` is that at the start of the epoch.
    pub(crate) shear_rate: f64,
    /// Work of the shear where bodies have passed through the seam, which the ledger does not hold
    /// yet.
    pub(crate) work_of_shear: f64,
    /// Walls with a mass, in the order of the bodies.
    pub(crate) pistons: Vec<Piston>,
    /// Walls whose velocity changes at given times.
    pub(crate) wall_tables: Vec<WallTable>,
    /// Bodies tied to each other.
    pub(crate) tethers: Tethers,
    /// Discs within the ranges of their wells.
    pub(crate) shells: Shells,
    /// Start of the epoch.
    pub(crate) epoch: EpochTime,
    pub(crate) next_id: u64,
    /// Seed and replica of the scene, for walls that have a temperature.
    pub(crate) random_key: [u64; 2],
    /// The clock of the drag of all bodies. Motions and offsets are those of this clock, with the
    /// true velocities at the start of the epoch.
    pub(crate) clock: DragClock,
    /// The last time to which a run with drag was asked to go, and its offset: the clock would
    /// return it with a rounding.
    pub(crate) stop: Option<(f64, EpochTime)>,
    /// Whether any body is such a wall; without one, contacts with it are not looked for.
    pub(crate) has_thermal_walls: bool,
    /// Whether bodies may react at contacts.
    pub(crate) has_reactions: bool,
    /// Whether either holds; without, contacts are resolved by impulses alone.
    pub(crate) has_special_contacts: bool,
    /// Which pairs of bodies see each other, and at which distance.
    pub(crate) pairs: PairTable,
    /// Whether some rule of elasticity is rough, so that discs may have spins.
    pub(crate) has_rough_contacts: bool,
    /// Whether discs turn, by rough contacts or since they have had some: schedulers then hold
    /// their spins.
    pub(crate) keeps_spins: bool,
}

impl World {
    pub(crate) fn new(bounds: PeriodicBox) -> Self {
        Self {
            bounds,
            bodies: Vec::new(),
            motions: Vec::new(),
            windings: Vec::new(),
            last_contacts: Vec::new(),
            axes: Vec::new(),
            oscillations: Vec::new(),
            gravity: DVec2::ZERO,
            shear_rate: 0.0,
            work_of_shear: 0.0,
            pistons: Vec::new(),
            wall_tables: Vec::new(),
            tethers: Tethers::default(),
            shells: Shells::default(),
            epoch: EpochTime::ZERO,
            next_id: 0,
            random_key: [0; 2],
            clock: DragClock::FREE,
            stop: None,
            has_thermal_walls: false,
            has_reactions: false,
            has_special_contacts: false,
            pairs: PairTable::default(),
            has_rough_contacts: false,
            keeps_spins: false,
        }
    }

    /// The names of bodies in error messages, by their indices.
    pub(crate) fn naming<'a>(&'a self, tags: &'a TagNames) -> impl Fn(usize) -> String + 'a {
        |index| BodyName::new(&self.bodies[index], tags).to_string()
    }

    /// The periodic box, with its tilt at the start of the epoch.
    pub fn bounds(&self) -> &PeriodicBox {
        &self.bounds
    }

    /// The bodies, in order of insertion.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Inverse masses of two bodies (1/mass).
    #[inline]
    pub(crate) fn inverse_masses(&self, bodies: [u32; 2]) -> [f64; 2] {
        bodies.map(|body| self.bodies[body as usize].kind.inertia.inverse_mass)
    }

    /// The motions, in the order of [`Self::bodies`]; times are offsets from the epoch's start.
    pub fn motions(&self) -> &[Motion] {
        &self.motions
    }

    /// Number of boxes that each body has crossed along each axis since it was added, in the order
    /// of [`Self::bodies`].
    pub fn windings(&self) -> &[[i64; 2]] {
        &self.windings
    }

    /// Time of each body's last contact, in the order of [`Self::bodies`], as an offset from the
    /// epoch's start; −∞ if there was none. Empty without a guard against inelastic collapse.
    pub fn last_contacts(&self) -> &[f64] {
        &self.last_contacts
    }

    /// Start of the epoch.
    pub fn epoch(&self) -> EpochTime {
        self.epoch
    }

    /// The time at an offset in the epoch.
    pub(crate) fn time_at(&self, offset: f64) -> EpochTime {
        match self.stop {
            Some((stop, time)) if stop == offset => time,
            _ => self.epoch.after(self.clock.duration(offset)),
        }
    }

    /// The offset in the epoch at a time.
    pub(crate) fn offset_at(&self, time: EpochTime) -> f64 {
        self.clock.reading(time.since(self.epoch))
    }

    /// Index of a body in the order of [`Self::bodies`]; `None` if it is not in the system.
    pub fn index(&self, key: BodyKey) -> Option<usize> {
        self.bodies.binary_search_by_key(&key, Body::key).ok()
    }

    /// Kinetic energy of all bodies (mass × length² / time²), at the velocities of the epoch's
    /// clock.
    ///
    /// Of many equal energies a plain sum would have roundings of one sign, and its error would
    /// pass for a drift.
    pub fn energy(&self) -> f64 {
        exact_sum(self.energies())
    }

    /// Kinetic energy of each body at the velocities of the motions (mass × length² / time²): those
    /// of the clock of the drag and of the falling frame.
    pub(crate) fn energies(&self) -> impl Iterator<Item = f64> {
        let bodies = self.motions.iter().zip(&self.bodies);
        bodies.map(|(motion, body)| kinetic_energy(motion, &body.kind.inertia))
    }

    /// Whether motions within an epoch are those of a clock or a frame of their own.
    pub(crate) fn has_own_frame(&self) -> bool {
        !self.clock.is_free() || self.accelerates() || self.is_sheared()
    }

    /// Books what drag, gravity and shear have done in this epoch up to `offset`, at which the
    /// motions are the present ones.
    pub(crate) fn book_flight(&self, ledger: &mut Ledger, offset: f64) {
        if !self.clock.is_free() {
            ledger.book_drag(self.energy(), self.clock.slowing(offset));
        }
        // An epoch that has not begun has no sum of its start.
        if self.accelerates() && offset != 0.0 {
            ledger.book_gravity(self.negative_potential_energy(offset));
        }
        ledger.sheared += self.work_of_shear;
    }

    /// Kinetic energy of each body at an offset in the epoch, with drag or gravity too (mass ×
    /// length² / time²).
    pub(crate) fn energies_at(&self, offset: f64) -> impl Iterator<Item = f64> {
        let slowing = self.clock.slowing(offset);
        let bodies = self.motions.iter().zip(&self.bodies).enumerate();
        bodies.map(move |(index, (motion, body))| {
            let motion = if self.accelerates() {
                self.motion_at(index as u32, motion, offset)
            } else {
                *motion
            };
            kinetic_energy(&motion, &body.kind.inertia) * (slowing * slowing)
        })
    }

    /// The largest contact distance of two bodies that can collide, or of a centre and the line of
    /// a wall (length); 0 if there are none.
    pub fn largest_reach(&self) -> f64 {
        self.farthest_reaching().map_or(0.0, |(reach, _)| reach)
    }

    /// The two bodies with the largest contact distance, and that distance (length): the largest
    /// moving body and the largest other body. A single moving body is paired with itself, with its
    /// bounding radius as distance. With rules for pairs of tags, the distance is an upper bound.
    pub(crate) fn farthest_reaching(&self) -> Option<(f64, [usize; 2])> {
        let radius = |index: usize| self.bodies[index].reach();
        let is_free = |index: usize| self.bodies[index].is_free();
        // The first of several bodies of the same size.
        let largest = |skip: Option<usize>, fixed_too: bool| {
            (0..self.bodies.len())
                .filter(|&index| Some(index) != skip && (fixed_too || is_free(index)))
                .reduce(|best, index| {
                    if radius(index) > radius(best) {
                        index
                    } else {
                        best
                    }
                })
        };
        let first = largest(None, false)?;
        Some(match largest(Some(first), true) {
            Some(second) => {
                let factor = self.pairs.largest_factor();
                (factor * (radius(first) + radius(second)), [first, second])
            }
            None => (radius(first), [first; 2]),
        })
    }

    /// The two bodies with the smallest contact distance of two atoms, and that distance (length):
    /// the moving body with the smallest atom, and the other body with the smallest atom. `None` if
    /// no two bodies can collide.
    pub(crate) fn closest_touching(&self) -> Option<(f64, [usize; 2])> {
        if self.pairs.has_rules() {
            return self.closest_by_tags();
        }
        let atom = |index: usize| self.bodies[index].smallest_reach();
        let smallest = |skip: Option<usize>, fixed_too: bool| {
            (0..self.bodies.len())
                .filter(|&index| Some(index) != skip && (fixed_too || self.bodies[index].is_free()))
                .map(|index| (atom(index), index))
                .reduce(|best, other| if other.0 < best.0 { other } else { best })
        };
        let (first_radius, first) = smallest(None, false)?;
        let (second_radius, second) = smallest(Some(first), true)?;
        Some((first_radius + second_radius, [first, second]))
    }

    /// The two bodies of [`Self::closest_touching`] where rules for pairs of tags apply.
    fn closest_by_tags(&self) -> Option<(f64, [usize; 2])> {
        // Of each set of tags the two smallest bodies that move, and the two smallest fixed ones.
        let mut groups: BTreeMap<(&Tags, bool), Vec<(f64, usize)>> = BTreeMap::new();
        for (index, body) in self.bodies.iter().enumerate() {
            let smallest = groups
                .entry((&body.kind.tags, !body.is_free()))
                .or_default();
            smallest.push((body.smallest_reach(), index));
            smallest.sort_by(|one, other| one.0.total_cmp(&other.0));
            smallest.truncate(2);
        }
        let smallest = || {
            groups
                .iter()
                .flat_map(|(group, list)| list.iter().map(move |one| (group, one)))
        };
        let mut closest: Option<(f64, [usize; 2])> = None;
        let moving = smallest().filter(|((_, is_fixed), _)| !is_fixed);
        for ((tags, _), &(radius, index)) in moving {
            for ((other_tags, _), &(other_radius, other)) in
                smallest().filter(|(_, one)| one.1 != index)
            {
                let reach = self.pairs.factor_of_tags(tags, other_tags) * (radius + other_radius);
                if reach > 0.0 && closest.is_none_or(|(least, _)| reach < least) {
                    closest = Some((reach, [index, other]));
                }
            }
        }
        closest
    }

    /// The factor on the sum of the radii of two discs at their next contact: 1 unless a
    /// [`DiameterSpec`](crate::DiameterSpec) applies, or they are outside their well, whose range
    /// they reach first ([`WellSpec`](crate::WellSpec)). It is 0 for two bodies that do not see
    /// each other ([`TransparentSpec`](crate::TransparentSpec)), and for two discs in their well,
    /// whose events are those of [`Self::first_step`]. Schedulers must leave out both. The bodies
    /// are indices in the order of [`Self::bodies`].
    #[inline]
    pub fn pair_factor(&self, bodies: [u32; 2]) -> f64 {
        if self.has_wells() && self.shells.of_pair(bodies).is_some() {
            return 0.0;
        }
        let [one, other] = bodies.map(|body| self.bodies[body as usize].kind.tag_class as usize);
        self.pairs.factor_outside_well(one, other)
    }

    /// The indices of the walls that move, in the order of [`Self::bodies`].
    pub(crate) fn moving_walls(&self) -> impl Iterator<Item = usize> {
        let bodies = self.bodies.iter().zip(&self.motions).enumerate();
        let oscillates = |index: usize| self.oscillation(index).is_some();
        bodies
            .filter(move |(index, (body, motion))| {
                body.is_fixed() && (!motion.is_at_rest() || oscillates(*index))
            })
            .map(|(index, _)| index)
    }

    /// The largest bounding radius of a body that moves (length).
    pub(crate) fn largest_moving_radius(&self) -> f64 {
        let moving = self.bodies.iter().filter(|body| body.is_free());
        moving
            .map(|body| body.kind.molecule.bounding_radius())
            .fold(0.0, f64::max)
    }

    /// Whether exactly one body moves and all others are fixed: a billiard.
    pub(crate) fn is_billiard(&self) -> bool {
        self.bodies
            .iter()
            .filter(|body| !body.is_fixed())
            .take(2)
            .count()
            == 1
    }

    /// Memory used on the heap (bytes), without shapes.
    pub(crate) fn heap_bytes(&self) -> usize {
        self.bodies.capacity() * size_of::<Body>()
            + self.motions.capacity() * size_of::<Motion>()
            + self.windings.capacity() * size_of::<[i64; 2]>()
            + self.last_contacts.capacity() * size_of::<f64>()
            + self.axes.capacity() * size_of::<Option<Orientation>>()
            + self.oscillations.capacity() * size_of::<Option<Oscillation>>()
            + self.pistons.capacity() * size_of::<Piston>()
            + self.tethers.heap_bytes()
            + self.shells.heap_bytes()
    }

    pub(crate) fn insert(&mut self, kind: BodyKind, motion: Motion) -> BodyKey {
        // Keys ascend in order of insertion, as the binary search for a body requires.
        let key = BodyKey(self.next_id);
        self.push_body(key, kind);
        let (position, winding) = self.bounds.wrap(motion.position);
        self.motions.push(Motion { position, ..motion });
        self.windings.push(winding);
        self.next_id += 1;
        key
    }

    /// Adds a body. It shares its description with one of the last few bodies if they are equal, so
    /// that descriptions stay in the caches.
    pub(crate) fn push_body(&mut self, key: BodyKey, kind: BodyKind) {
        let shared = self
            .bodies
            .iter()
            .rev()
            .take(LAST_FEW)
            .find(|before| before.kind.is_like(&kind));
        let kind = shared.map_or_else(|| Arc::new(kind), |before| Arc::clone(&before.kind));
        self.bodies.push(Body { key, kind });
    }

    /// Number of different descriptions of the bodies.
    #[cfg(test)]
    pub(crate) fn count_kinds(&self) -> usize {
        let kinds: std::collections::HashSet<_> = self
            .bodies
            .iter()
            .map(|body| Arc::as_ptr(&body.kind))
            .collect();
        kinds.len()
    }

    /// Releases memory reserved for growth.
    pub(crate) fn shrink(&mut self) {
        self.bodies.shrink_to_fit();
        self.motions.shrink_to_fit();
        self.windings.shrink_to_fit();
    }

    /// Keeps the bodies whose indices satisfy `keeps`, in order of insertion.
    pub(crate) fn keep_bodies(&mut self, keeps: impl Fn(usize) -> bool) {
        fn keep<T>(list: &mut Vec<T>, keeps: impl Fn(usize) -> bool) {
            let mut places = 0..;
            list.retain(|_| places.next().is_some_and(&keeps));
        }
        if !self.tethers.is_empty() || self.has_wells() {
            let mut left = 0;
            let numbers: Vec<Option<u32>> = (0..self.bodies.len())
                .map(|index| {
                    let number = keeps(index).then_some(left);
                    left += u32::from(number.is_some());
                    number
                })
                .collect();
            self.tethers = self.tethers.renumbered(|body| numbers[body as usize]);
            self.shells = self.shells.renumbered(|body| numbers[body as usize]);
        }
        keep(&mut self.bodies, &keeps);
        keep(&mut self.motions, &keeps);
        keep(&mut self.windings, &keeps);
        keep(&mut self.last_contacts, &keeps);
        keep(&mut self.axes, &keeps);
        keep(&mut self.oscillations, &keeps);
        self.clear_ended_oscillations();
        self.drop_removed_pistons();
        let bodies = &self.bodies;
        self.wall_tables
            .retain(|table| bodies.binary_search_by_key(&table.key, Body::key).is_ok());
    }

    /// Removes the body added last, and makes its key available again.
    pub(crate) fn take_back_last(&mut self) {
        self.bodies.pop();
        self.motions.pop();
        self.windings.pop();
        self.axes.truncate(self.bodies.len());
        self.oscillations.truncate(self.bodies.len());
        self.drop_removed_pistons();
        self.next_id -= 1;
    }

    /// The axis of a round body that self-propulsion drives.
    pub(crate) fn axis(&self, index: usize) -> Option<Orientation> {
        self.axes.get(index).copied().flatten()
    }

    /// Sets the axis of a body.
    pub(crate) fn set_axis(&mut self, index: usize, axis: Orientation) {
        if self.axes.len() <= index {
            self.axes.resize(self.bodies.len(), None);
        }
        self.axes[index] = Some(axis);
    }

    /// Starts or stops keeping the times of last contacts; new bodies have −∞.
    pub(crate) fn keep_last_contacts(&mut self, requested: bool) {
        let count = if requested { self.bodies.len() } else { 0 };
        self.last_contacts.resize(count, f64::NEG_INFINITY);
    }

    /// Moves all bodies to `offset` in the epoch and begins a new epoch there.
    pub(crate) fn rebase(&mut self, offset: f64) {
        let slowing = self.clock.slowing(offset);
        let fallen = self.accelerates().then(|| self.falling_frame(offset));
        let of_pistons: Vec<_> = self
            .pistons()
            .map(|piston| (piston, self.frame_of(piston, offset)))
            .collect();
        for body in 0..self.oscillations.len() {
            if let Some(motion) = self.restart_oscillation(body, offset) {
                self.motions[body] = motion;
            }
        }
        for index in 0..self.bodies.len() {
            let (body, motion) = (&self.bodies[index], &self.motions[index]);
            if body.is_fixed() && motion.is_at_rest() && motion.time == 0.0 {
                continue;
            }
            let mut here = motion.at(offset).slowed(slowing);
            if let Some(fallen) = fallen.as_ref().filter(|_| !body.is_fixed()) {
                let piston = of_pistons.iter().find(|(piston, _)| *piston == index);
                let frame = piston.map_or(fallen, |(_, frame)| frame);
                here.position += frame.position;
                here.velocity += frame.velocity;
            }
            let (wrapped, image) = self.wrapped_at(&here, offset);
            if image[1] != 0 && self.shear_rate != 0.0 {
                self.work_of_shear += Self::gained(body, &here, &wrapped);
            }
            self.motions[index] = Motion {
                time: 0.0,
                ..wrapped
            };
            let winding = &mut self.windings[index];
            winding[0] += image[0];
            winding[1] += image[1];
        }
        self.bounds = self.bounds_at(offset);
        self.fold_tilt();
        for table in &mut self.wall_tables {
            table.begins -= offset;
        }
        for time in &mut self.last_contacts {
            *time = self.clock.restarted(*time, offset);
        }
        self.epoch = if self.clock.is_free() {
            self.epoch.new_epoch(offset)
        } else {
            self.time_at(offset).new_epoch(0.0)
        };
        self.stop = None;
    }
}

#[cfg(test)]
mod tests {
    use crate::{
        cells::CellScheduler,
        run::simulation::Simulation,
        scene::{MoleculeSpec, Scene, gas_spec::GasSpec},
    };
    use carom_detection::Exact;
    use carom_response::Impact;

    /// Number of different descriptions of the bodies of a scene.
    fn kinds(scene: &Scene) -> usize {
        let simulation = Simulation::<Exact, Impact, CellScheduler>::new(scene).unwrap();
        simulation.world.count_kinds()
    }

    #[test]
    fn equal_bodies_share_their_description_in_any_order() {
        let disc = |number: u32, radius: f64| MoleculeSpec {
            shape: Some("disc".to_owned()),
            atom_radius: Some(radius),
            atom_mass: Some(1.0),
            at: [f64::from(number % 10) * 0.1, f64::from(number / 10) * 0.1],
            ..MoleculeSpec::default()
        };
        let molecule = (0..100)
            .map(|number| disc(number, if number % 3 == 0 { 0.03 } else { 0.02 }))
            .collect();
        assert_eq!(
            kinds(&Scene {
                molecule,
                ..Scene::default()
            }),
            2
        );
        let gas = |radius| GasSpec {
            radius: Some(radius),
            mass: Some(1.0.into()),
            count: Some(200),
            energy: 1.0,
            ..GasSpec::default()
        };
        assert!(
            kinds(&Scene {
                gas: vec![gas(0.01.into()), gas(0.02.into())],
                ..Scene::default()
            }) <= 4
        );
    }
}
