//! A read-only view of all bodies at one time.

use carom_geometry::PeriodicBox;
use carom_kinematics::{Drive, EpochTime, Motion, Orientation, kinetic_energy, momentum};
use glam::DVec2;

use crate::world::{
    World,
    body::{Body, BodyKey},
    counters::{Counters, Ledger},
    heat::{HeatByTag, exact_sum},
    reaction_record::ReactionRecord,
    tags::{Tag, TagNames},
    wall::StandingWall,
};

/// All bodies at one time. A view, at any time and any number of times, changes no bit of the run.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    pub(crate) world: &'a World,
    pub(crate) names: &'a TagNames,
    pub(crate) counters: &'a Counters,
    pub(crate) ledger: &'a Ledger,
    pub(crate) heat: &'a HeatByTag,
    pub(crate) reactions: &'a [ReactionRecord],
    /// Offset from the start of the epoch (time).
    pub(crate) offset: f64,
}

/// One body in a view.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct BodyView<'a> {
    /// The body.
    pub body: &'a Body,
    /// Its motion at the time of the view, with the position in the box.
    pub motion: Motion,
    /// Number of boxes that the body has crossed along each axis since it was added:
    /// `position + winding × sides` has no jumps.
    pub winding: [i64; 2],
}

impl<'a> View<'a> {
    /// The time of the view.
    pub fn time(&self) -> EpochTime {
        self.world.time_at(self.offset)
    }

    /// The periodic box; under shear with its present tilt.
    pub fn bounds(&self) -> PeriodicBox {
        self.world.bounds_at(self.offset)
    }

    /// The shear rate (1/time); 0 without shear.
    pub fn shear_rate(&self) -> f64 {
        self.world.shear_rate
    }

    /// Whether the images above and below move, or are displaced by an earlier shear.
    pub fn is_sheared(&self) -> bool {
        self.world.is_sheared()
    }

    /// Counts of events so far.
    pub fn counters(&self) -> &'a Counters {
        self.counters
    }

    /// The energy lost and put in so far.
    pub fn ledger(&self) -> Ledger {
        let mut ledger = *self.ledger;
        self.world.book_flight(&mut ledger, self.offset);
        ledger
    }

    /// The energy that thermostats have given to the bodies of each tag so far.
    pub fn heat(&self) -> &'a HeatByTag {
        self.heat
    }

    /// The reactions that are or have been in force, in the order in which they were given, and
    /// what they have done so far.
    pub fn reactions(&self) -> &'a [ReactionRecord] {
        self.reactions
    }

    /// Names of the tags.
    pub fn tag_names(&self) -> &'a TagNames {
        self.names
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.world.bodies.len()
    }

    /// Whether there is no body.
    pub fn is_empty(&self) -> bool {
        self.world.bodies.is_empty()
    }

    /// The bodies, in order of insertion.
    pub fn bodies(&self) -> impl ExactSizeIterator<Item = BodyView<'a>> + use<'a> {
        let Self { world, offset, .. } = *self;
        (0..world.bodies.len()).map(move |index| body_at(world, index, offset))
    }

    /// The bodies that carry a tag.
    pub fn tagged(&self, tag: Tag) -> impl Iterator<Item = BodyView<'a>> + use<'a> {
        let Self { world, offset, .. } = *self;
        // Positions are computed only for the bodies that carry the tag.
        let tagged = (0..world.bodies.len()).filter(move |&index| world.bodies[index].has_tag(tag));
        tagged.map(move |index| body_at(world, index, offset))
    }

    /// The body with this handle; `None` if it is not in the system.
    pub fn body(&self, key: BodyKey) -> Option<BodyView<'a>> {
        self.world
            .index(key)
            .map(|index| body_at(self.world, index, self.offset))
    }

    /// The axis along which self-propulsion drives a round body ([`SelfPropulsion`]); `None` if it
    /// has not done so.
    ///
    /// [`SelfPropulsion`]: crate::SelfPropulsion
    pub fn axis(&self, key: BodyKey) -> Option<Orientation> {
        self.world.axis(self.world.index(key)?)
    }

    /// The drag γ of all bodies (1/time); 0 if there is none.
    pub fn drag(&self) -> f64 {
        self.world.clock.drag()
    }

    /// The oscillation of a wall, whose time 0 is that of the view; `None` for other bodies.
    pub fn oscillation(&self, key: BodyKey) -> Option<Drive> {
        let drive = self.world.oscillation(self.world.index(key)?)?;
        Some(drive.restarted(self.offset))
    }

    /// The acceleration of all free bodies by gravity (length per time squared).
    pub fn gravity(&self) -> DVec2 {
        self.world.gravity
    }

    /// Whether rules for pairs of tags affect bodies: some do not see each other
    /// ([`TransparentSpec`](crate::TransparentSpec)), or touch at another distance than the sum of
    /// their radii ([`DiameterSpec`](crate::DiameterSpec)), or have wells
    /// ([`WellSpec`](crate::WellSpec)).
    pub fn has_pair_rules(&self) -> bool {
        self.world.pairs.is_active()
    }

    /// The constant part of the acceleration of a piston along its axis (length per time squared)
    /// and the two places of its stops (length); `None` for any other body.
    pub fn piston(&self, key: BodyKey) -> Option<(f64, [f64; 2])> {
        let index = self.world.index(key)?;
        let (piston, axis) = (
            self.world.piston(index)?,
            self.world.bodies[index].axis_of_piston()?,
        );
        Some((self.world.acceleration(index)[axis], piston.stops))
    }

    /// The angular frequency of a piston on a spring (radians per time), and the place on its axis
    /// about which it oscillates (length); `None` for any other body.
    pub fn spring(&self, key: BodyKey) -> Option<[f64; 2]> {
        let index = self.world.index(key)?;
        let piston = self.world.piston(index)?;
        let axis = self.world.bodies[index].axis_of_piston()?;
        let constant = self.world.acceleration(index)[axis];
        (piston.stiffness > 0.0).then(|| [piston.frequency(), piston.balance(constant)])
    }

    /// Kinetic energy of all bodies (mass × length² / time²).
    pub fn energy(&self) -> f64 {
        if self.world.accelerates() {
            return exact_sum(self.world.energies_at(self.offset));
        }
        let slowing = self.world.clock.slowing(self.offset);
        self.world.energy() * (slowing * slowing)
    }

    /// Total momentum (mass × length / time).
    pub fn momentum(&self) -> DVec2 {
        self.bodies()
            .map(|view| momentum(&view.motion, view.body.inertia()))
            .sum()
    }
}

impl BodyView<'_> {
    /// Kinetic energy (mass × length² / time²); 0 for a fixed body.
    pub fn energy(&self) -> f64 {
        kinetic_energy(&self.motion, self.body.inertia())
    }

    /// Position without periodic jumps since the body was added (length).
    pub fn unwrapped(&self, bounds: &PeriodicBox) -> DVec2 {
        self.motion.position + bounds.shift(self.winding)
    }

    /// The end points of a straight wall, in the image whose middle is in the box (length); `None`
    /// for other bodies.
    pub fn wall(&self) -> Option<[DVec2; 2]> {
        let is_straight = self.body.molecule().wall_edge()?.bend().is_none();
        let mut segments = self.wall_segments();
        segments.next().filter(|_| is_straight)
    }

    /// The straight pieces by which a wall is drawn, from end to end (length): one for a straight
    /// wall, and those of a polygon through points of an arc; none for other bodies.
    pub fn wall_segments(&self) -> impl Iterator<Item = [DVec2; 2]> + use<> {
        let line = StandingWall::new(self.body, &self.motion).map(|wall| wall.line());
        let line = line.unwrap_or_default();
        let next: Vec<DVec2> = line.iter().skip(1).copied().collect();
        line.into_iter().zip(next).map(|(from, to)| [from, to])
    }

    /// Centre and radius (length) of each atom, or of the end points of a wall, in the image of the
    /// body that is in the box.
    pub fn atoms(&self) -> impl Iterator<Item = (DVec2, f64)> + '_ {
        let rotation = self.motion.orientation.cos_sin();
        let place = move |offset| self.motion.position + rotation.rotate(offset);
        self.body
            .molecule()
            .atoms()
            .iter()
            .map(move |atom| (place(atom.offset()), atom.radius()))
    }
}

pub(crate) fn body_at(world: &World, index: usize, offset: f64) -> BodyView<'_> {
    let motion = world
        .motion_at(index as u32, &world.motions[index], offset)
        .slowed(world.clock.slowing(offset));
    let (motion, image) = world.wrapped_at(&motion, offset);
    let winding = world.windings[index];
    BodyView {
        body: &world.bodies[index],
        motion,
        winding: [winding[0] + image[0], winding[1] + image[1]],
    }
}
