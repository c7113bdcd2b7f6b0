//! When an epoch has to end, before the fastest body has used up the digits of its place or angle, and when that is too soon.

use carom_kinematics::HALF_ULP;
use glam::DVec2;

use crate::{BodyName, RunError, TagNames, World};

/// Turns of the fastest rotor after which an epoch ends. Smaller: more epochs. Larger: angles lose digits.
const TURNS_PER_EPOCH: f64 = 64.0;

/// Mean free paths after which an epoch may end: an epoch costs a prediction of every body. Fewer: that. More: places lose
/// digits.
const FREE_PATHS_PER_EPOCH: f64 = 32.0;

/// Sides of the box after which an epoch ends however few contacts there are. Smaller: a thin gas begins more epochs than it has
/// contacts. Larger: places lose digits.
const MOST_SIDES_PER_EPOCH: f64 = 8.0;

/// An epoch older than this many stretches of a body that has become so much faster ends with the contact that made it so:
/// at such a speed, the rounding of the time itself would be too coarse. Larger: places lose digits. Smaller: more epochs.
const STALE_STRETCHES: f64 = 4.0;

/// Epochs without a contact before a run is asked whether it gets anywhere. Fewer: a dilute scene is refused although no place
/// is off by more than 2⁻³⁶ of the side. More: it takes longer until one that gets nowhere has its name.
const EPOCHS_OF_PATIENCE: f64 = (1 << 16) as f64;

/// A body that goes less far than this share of the side up to the time asked for need not be seen to move. Smaller: bodies at
/// rest but for a rounding of their velocity end runs. Larger: bodies may stand still that ought to move.
const UNSEEN: f64 = 1.0 / (1u64 << 36) as f64;

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
    /// How far the fastest body may go (length).
    way: f64,
}

impl Limits {
    /// For bodies of so much speed and spin at most, and after so many contacts at the latest.
    pub fn new(world: &World, fastest_squared: f64, fastest_spin: f64, contacts: u64) -> Self {
        let way = way_per_epoch(world);
        let time = stretch(way, fastest_squared, fastest_spin);
        Self { time, contacts_left: contacts, fastest_squared, fastest_spin, way }
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
        let stretch = stretch(self.way, self.fastest_squared, self.fastest_spin);
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

/// How many sides of the box the fastest body goes in an epoch at most: one, or more in a thin gas.
pub(crate) fn sides_per_epoch(world: &World) -> f64 {
    if world.is_billiard() {
        return MOST_SIDES_PER_EPOCH;
    }
    let sides = world.bounds.sides();
    let (mut moving, mut largest) = (0_u32, 0.0_f64);
    for body in world.bodies.iter().filter(|body| !body.is_fixed()) {
        moving += 1;
        largest = largest.max(body.reach());
    }
    // 1 / (√8 n σ), with the diameter σ of the largest: the kinetic theory of n discs in a unit of area.
    let free_path = sides.x * sides.y / (8.0_f64.sqrt() * f64::from(moving) * (2.0 * largest));
    (FREE_PATHS_PER_EPOCH * free_path / sides.min_element()).clamp(1.0, MOST_SIDES_PER_EPOCH)
}

/// How far the fastest body goes in an epoch at most (length).
fn way_per_epoch(world: &World) -> f64 {
    sides_per_epoch(world) * world.bounds.sides().min_element()
}

/// Refuses a run in which a fast body makes the epochs so short that another no longer moves, or nearly so.
///
/// A place is rounded once an epoch, so that k epochs without a contact leave it uncertain by k u × side. Where that is more
/// than the way of the body in one epoch, the run neither resolves its motion nor comes to its end in any
/// reasonable number of epochs. The epoch has just begun, and lasts `stretch`; the last contact was at `last_contact` (an
/// offset in the epoch, hence not positive), and the run is to go on for `remaining`.
pub(crate) fn refuse_outpaced(
    world: &World,
    names: &TagNames,
    stretch: f64,
    last_contact: f64,
    remaining: f64,
) -> Result<(), RunError> {
    let epochs = -last_contact / stretch;
    if !(epochs >= EPOCHS_OF_PATIENCE && stretch < remaining) {
        return Ok(());
    }
    let side = world.bounds.sides().min_element();
    let rounding = epochs * HALF_ULP * side;
    let way = |index: usize| world.motions[index].velocity.length() * stretch;
    let outpaced = |&index: &usize| {
        let going = way(index) * ((remaining - last_contact) / stretch);
        way(index) > 0.0 && way(index) < rounding && going > UNSEEN * side
    };
    let all = 0..world.motions.len();
    let way_per_epoch = way_per_epoch(world);
    let slowest = all.clone().filter(outpaced).min_by(|&one, &other| way(one).total_cmp(&way(other)));
    let Some(slow) = slowest else { return Ok(()) };
    let shortest = |&one: &usize, &other: &usize| {
        let of = |index: usize| {
            let motion = &world.motions[index];
            self::stretch(way_per_epoch, motion.velocity.length_squared(), motion.angular_velocity.abs())
        };
        of(one).total_cmp(&of(other))
    };
    let fast = all.min_by(shortest).unwrap_or(slow);
    let motion = &world.motions[fast];
    Err(RunError::Outpaced {
        time: world.epoch,
        body: BodyName::new(&world.bodies[fast], names),
        speed: motion.velocity.length(),
        spin: motion.angular_velocity,
        outpaced: Box::new(BodyName::new(&world.bodies[slow], names)),
        way: way(slow),
    })
}

/// How long a body of this speed and spin may fly before it has gone so far, or its angle has used up digits (time).
fn stretch(way: f64, speed_squared: f64, spin: f64) -> f64 {
    (way / speed_squared.sqrt()).min(TURNS_PER_EPOCH * std::f64::consts::TAU / spin)
}
