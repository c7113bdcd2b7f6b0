//! When an epoch has to end: before the fastest body has used up the digits of its place, or the fastest rotor of its angle.

use glam::DVec2;

use crate::{BodyName, RunError, TagNames, World};

/// Turns of the fastest rotor after which an epoch ends. Smaller: more epochs. Larger: angles lose digits.
const TURNS_PER_EPOCH: f64 = 64.0;

/// Sides of the box after which an epoch ends in which one body alone moves. Among others a body meets many within one side;
/// alone it may fly several sides from contact to contact, and would begin more epochs than it has contacts. Smaller: that.
/// Larger: places lose digits.
const SIDES_PER_EPOCH_OF_BILLIARD: f64 = 8.0;

/// An epoch older than this many stretches of a body that has become so much faster ends with the contact that made it so:
/// at such a speed, the rounding of the time itself would be too coarse. Larger: places lose digits. Smaller: more epochs.
const STALE_STRETCHES: f64 = 4.0;

/// The end of an epoch, in time and in contacts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// When it ends at the latest: the fastest body has gone [`sides_per_epoch`] by then.
    time: f64,
    contacts_left: u64,
    /// Square of the speed at which `time` was set.
    fastest_squared: f64,
    /// Magnitude of the spin at which `time` was set.
    fastest_spin: f64,
}

impl Limits {
    /// For bodies of so much speed and spin at most, and after so many contacts at the latest.
    pub fn new(world: &World, fastest_squared: f64, fastest_spin: f64, contacts: u64) -> Self {
        let time = stretch(world, fastest_squared, fastest_spin);
        Self { time, contacts_left: contacts, fastest_squared, fastest_spin }
    }

    /// When the epoch ends at the latest (offset in it, time).
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call costs as much as the work")]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Whether none of these velocities is beyond what the limits were set for.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call costs as much as the work")]
    pub fn hold(&self, [a, b]: [DVec2; 2]) -> bool {
        // NaN is beyond any.
        (a.length_squared() <= self.fastest_squared) & (b.length_squared() <= self.fastest_squared)
    }

    /// Shortens the epoch if one of two bodies is now faster than any was before, and refuses what is too fast.
    #[inline(never)]
    pub fn accept(
        &mut self,
        world: &World,
        names: &TagNames,
        bodies: [u32; 2],
        now: f64,
        velocities: [DVec2; 2],
        spin: f64,
    ) -> Result<(), RunError> {
        if self.hold(velocities) & (spin <= self.fastest_spin) {
            return Ok(());
        }
        let speed_squared = velocities[0].length_squared().max(velocities[1].length_squared());
        self.fastest_squared = self.fastest_squared.max(speed_squared);
        self.fastest_spin = self.fastest_spin.max(spin);
        let stretch = stretch(world, self.fastest_squared, self.fastest_spin);
        self.time = self.time.min(now + stretch);
        if now > STALE_STRETCHES * stretch {
            self.contacts_left = 1;
        }
        for (body, velocity) in bodies.into_iter().zip(velocities) {
            let body = &world.bodies[body as usize];
            let speed = velocity.length() + spin * body.kind.molecule.bounding_radius();
            if !(speed <= carom_geometry::LARGEST && spin.is_finite()) {
                let (time, body) = (world.epoch.after(now), BodyName::new(body, names));
                return Err(RunError::BlowUp { time, body, speed });
            }
        }
        Ok(())
    }

    /// Counts a contact; tells whether the epoch ends with it.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call costs as much as the work")]
    pub fn count_contact(&mut self) -> bool {
        self.contacts_left -= 1;
        self.contacts_left == 0
    }
}

/// How many sides of the box the fastest body goes in an epoch at most.
pub(crate) fn sides_per_epoch(world: &World) -> f64 {
    if world.is_billiard() { SIDES_PER_EPOCH_OF_BILLIARD } else { 1.0 }
}

/// How long a body of this speed and spin may fly before its place or angle has used up digits (time).
fn stretch(world: &World, speed_squared: f64, spin: f64) -> f64 {
    let way = sides_per_epoch(world) * world.bounds.sides().min_element();
    (way / speed_squared.sqrt()).min(TURNS_PER_EPOCH * std::f64::consts::TAU / spin)
}
