//! Limits of an epoch: it ends before the fastest body's position or angle loses too many digits.
//! Also the refusal of runs whose epochs would be too short.

#![allow(
    clippy::inline_always,
    reason = "compiled with the instructions of the caller"
)]

use carom_kinematics::{DragClock, HALF_ULP, Motion};
use glam::DVec2;

use crate::{
    scene::{
        error::{RunError, SceneError},
        least_speed::MIN_SPEED,
    },
    world::{World, body::BodyName, tags::TagNames},
};

/// Turns of the fastest rotor after which an epoch ends. Smaller: more epochs. Larger: angles lose
/// digits.
const TURNS_PER_EPOCH: f64 = 64.0;

/// Mean free paths of the fastest body after which an epoch may end. Smaller: more epochs, each of
/// which costs a prediction of every body. Larger: positions lose digits.
const FREE_PATHS_PER_EPOCH: f64 = 32.0;

/// Sides of the box after which an epoch ends for any number of contacts. Smaller: a few small
/// bodies begin more epochs than they have contacts. Larger: gaps at contacts approach the
/// guaranteed bound of sixteen roundings of the side.
const MAX_SIDES_PER_EPOCH: f64 = 4.0;

/// Sides of the box after which an epoch ends if only one body moves. Larger than
/// `MAX_SIDES_PER_EPOCH`, since the body may fly many sides between contacts, and half as many
/// terms are rounded.
const SIDES_PER_EPOCH_OF_BILLIARD: f64 = 8.0;

/// An epoch ends with a contact that makes a body so fast that the epoch is older than this many
/// stretches of the body: at such a speed, the rounding of the time itself is too coarse. Larger:
/// positions lose digits. Smaller: more epochs.
const STALE_STRETCHES: f64 = 4.0;

/// Epochs without a contact before a run is checked for time scales too far apart. Fewer: a dilute
/// scene is refused although no position has an error above 2⁻³⁶ of the side. More: the error is
/// returned later.
const EPOCHS_OF_PATIENCE: f64 = (1 << 16) as f64;

/// Speed of the fastest body over that of the slowest that moves, above which a run without
/// contacts ends as [`RunError::TimeScalesTooFarApart`]: 2³⁷. The slow body then travels less in an
/// epoch than the rounding of its position in the epochs that a run waits for a contact.
pub const MAX_SPEED_RATIO: f64 = 1.0 / (EPOCHS_OF_PATIENCE * HALF_ULP);

/// Turns of the fastest rotor while the slowest body travels one side of the box, above which a run
/// without contacts ends as [`RunError::TimeScalesTooFarApart`]: 2⁴³.
pub const MAX_TURNS: f64 = TURNS_PER_EPOCH * MAX_SPEED_RATIO;

/// A body that travels less than this share of the side until the target time may appear at rest.
/// Smaller: bodies at rest apart from a rounding of their velocity end runs. Larger: bodies that
/// should move may stand still.
const UNSEEN: f64 = 1.0 / (1u64 << 36) as f64;

/// Centres of two bodies at their contact (length), their indices in [`World::bodies`] and the
/// offset in the epoch (time).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ContactPlaces {
    pub bodies: [u32; 2],
    pub time: f64,
    pub places: [DVec2; 2],
}

/// The end of an epoch, in time and in contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Limits {
    /// Latest end of the epoch (offset in it, time); the fastest body travels [`sides_per_epoch`]
    /// until then.
    time: f64,
    contacts_left: u64,
    /// Square of the speed at which `time` was set.
    fastest_squared: f64,
    /// Magnitude of the angular velocity at which `time` was set.
    fastest_spin: f64,
    /// The longest path of the fastest body in an epoch (length).
    way: f64,
    /// Bound on the rounding of a separation in this epoch (length). It takes a look at all bodies,
    /// so it is not computed for each contact.
    separation_error: f64,
    /// The contact that makes the epoch stale. A scheduler may store a flight as its position
    /// x₀ = x − v t at the start of the epoch, which is rounded by u v t: for a body this fast that
    /// exceeds the permitted error of a position.
    stale: Option<ContactPlaces>,
}

impl Limits {
    /// Limits for bodies of at most this speed and angular velocity, and for at most this many
    /// contacts, with this rounding of separations (length).
    pub fn new(
        world: &World,
        separation_error: f64,
        fastest_squared: f64,
        fastest_spin: f64,
        contacts: u64,
    ) -> Self {
        let way = way_per_epoch(world);
        let longest = longest_epoch(world.clock);
        let time = stretch(way, fastest_squared, fastest_spin).min(longest);
        let contacts_left = contacts;
        Self {
            time,
            contacts_left,
            fastest_squared,
            fastest_spin,
            way,
            separation_error,
            stale: None,
        }
    }

    /// Bound on the rounding of a separation in this epoch (length).
    pub fn separation_error(&self) -> f64 {
        self.separation_error
    }

    /// The contact with which the epoch ends, if it makes a body too fast for the rest of the
    /// epoch.
    pub fn stale_contact(&self) -> Option<&ContactPlaces> {
        self.stale.as_ref()
    }

    /// Ends the epoch at `time` (offset in it) at the latest.
    pub fn end_by(&mut self, time: f64) {
        self.time = self.time.min(time);
    }

    /// Latest end of the epoch (offset in it, time).
    #[inline(always)]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Whether neither velocity exceeds the speed for which the limits were set.
    #[inline(always)]
    pub fn within(&self, a: DVec2, b: DVec2) -> bool {
        // False for NaN.
        (a.length_squared() <= self.fastest_squared) & (b.length_squared() <= self.fastest_squared)
    }

    /// Whether neither velocity exceeds the speed for which the limits were set, nor the magnitude
    /// `spin` of the faster rotation the angular velocity (1/time).
    #[inline(always)]
    pub fn permit(&self, [a, b]: [DVec2; 2], spin: f64) -> bool {
        self.within(a, b) & (spin <= self.fastest_spin)
    }

    /// Raises the speed and the angular velocity for which the limits are set to those of two
    /// bodies.
    #[inline(always)]
    pub fn raise(&mut self, [a, b]: [DVec2; 2], spin: f64) {
        self.fastest_squared = self
            .fastest_squared
            .max(a.length_squared())
            .max(b.length_squared());
        self.fastest_spin = self.fastest_spin.max(spin);
    }

    /// Shortens the epoch if one of two bodies in contact is now faster than any body before.
    ///
    /// # Errors
    /// [`RunError::BlowUp`] if a body is too fast to compute with.
    #[inline(never)]
    pub fn accept(
        &mut self,
        world: &World,
        names: &TagNames,
        contact: ContactPlaces,
        velocities: [DVec2; 2],
        spin: f64,
    ) -> Result<(), RunError> {
        if self.permit(velocities, spin) {
            return Ok(());
        }
        let ContactPlaces {
            bodies,
            time: now,
            places: _,
        } = contact;
        self.raise(velocities, spin);
        let stretch = stretch(self.way, self.fastest_squared, self.fastest_spin);
        self.time = self.time.min(now + stretch);
        if now > STALE_STRETCHES * stretch {
            self.contacts_left = 1;
            self.stale = Some(contact);
        }
        for (body, velocity) in bodies.into_iter().zip(velocities) {
            let body = &world.bodies[body as usize];
            let speed = velocity.length() + spin * body.kind.molecule.bounding_radius();
            if !(speed <= carom_geometry::MAX_MAGNITUDE && spin.is_finite()) {
                let (time, body) = (world.time_at(now), BodyName::new(body, names));
                return Err(RunError::BlowUp { time, body, speed });
            }
        }
        Ok(())
    }

    /// Ends the epoch with the present contact.
    pub fn end_with_contact(&mut self) {
        self.contacts_left = 1;
    }

    /// Contacts until the epoch ends.
    pub fn contacts_left(&self) -> u64 {
        self.contacts_left
    }

    /// Counts contacts with which the epoch does not end, or with the last of which it does.
    pub fn count_contacts(&mut self, contacts: u64) {
        self.contacts_left -= contacts;
    }

    /// Counts a contact; returns whether the epoch ends with it.
    #[inline(always)]
    pub fn count_contact(&mut self) -> bool {
        self.contacts_left -= 1;
        self.contacts_left == 0
    }
}

/// The longest epoch of a clock of drag (offset, time): it ends when all velocities have halved.
/// Longer: the clock comes near its end, where its readings resolve no time.
pub(crate) fn longest_epoch(clock: DragClock) -> f64 {
    // ∞ without drag.
    0.5 / clock.drag()
}

/// The longest path of the fastest body in an epoch, in sides of the box: one, or more for a dilute
/// scene.
pub(crate) fn sides_per_epoch(world: &World) -> f64 {
    if world.is_billiard() {
        return SIDES_PER_EPOCH_OF_BILLIARD;
    }
    let sides = world.bounds.sides();
    let moving = world.bodies.iter().filter(|body| body.is_free());
    let largest = moving.map(crate::Body::reach).fold(0.0, f64::max);
    // 1 / (√8 n σ) for n discs of diameter σ in a unit of area, all as large as the largest that
    // moves.
    let free_path =
        sides.x * sides.y / (8.0_f64.sqrt() * world.bodies.len() as f64 * (2.0 * largest));
    (FREE_PATHS_PER_EPOCH * free_path / sides.min_element()).clamp(1.0, MAX_SIDES_PER_EPOCH)
}

/// The longest path of the fastest body in an epoch (length).
fn way_per_epoch(world: &World) -> f64 {
    sides_per_epoch(world) * world.bounds.sides().min_element()
}

/// Refuses a body of an entry that moves or turns at less than [`MIN_SPEED`].
pub(crate) fn refuse_slow(entry: &str, motion: &Motion, radius: f64) -> Result<(), SceneError> {
    let speeds = [
        // `hypot`, since the sum of squares may underflow to 0.
        ("the speed", motion.velocity.x.hypot(motion.velocity.y)),
        (
            "the rim speed (angular velocity times bounding radius)",
            motion.angular_velocity.abs() * radius,
        ),
    ];
    let moves = [
        motion.velocity != DVec2::ZERO,
        motion.angular_velocity != 0.0,
    ];
    for ((quantity, speed), moves) in speeds.into_iter().zip(moves) {
        if moves && speed < MIN_SPEED {
            return Err(SceneError::TooSlow {
                entry: entry.to_owned(),
                quantity,
                speed,
            });
        }
    }
    Ok(())
}

/// The fastest body and its speed of centre or rim (length per time), if some body moves but all at
/// less than [`MIN_SPEED`].
pub(crate) fn too_slow(world: &World) -> Option<(usize, f64)> {
    let speed = |index: usize| {
        let motion = &world.motions[index];
        let rim =
            motion.angular_velocity.abs() * world.bodies[index].kind.molecule.bounding_radius();
        // Not the length of the velocity, whose square may underflow to 0.
        motion.velocity.abs().max_element().max(rim)
    };
    let moving = (0..world.bodies.len()).filter(|&index| !world.bodies[index].is_fixed());
    let fastest = moving
        .map(|index| (index, speed(index)))
        .max_by(|one, other| one.1.total_cmp(&other.1))?;
    (fastest.1 > 0.0 && fastest.1 < MIN_SPEED).then_some(fastest)
}

/// Refuses a run in which a fast body makes the epochs so short that the motion of another body is
/// lost in rounding.
///
/// A position is rounded once an epoch, so its error after k epochs without a contact is
/// k u × side. Where that exceeds the path of the body in one epoch, the run does not resolve the
/// motion of the body and does not end in any reasonable number of epochs. The epoch has just begun
/// and lasts `stretch`; the last contact was at `last_contact` (offset in the epoch, not positive),
/// and the run must continue for `remaining`.
pub(crate) fn refuse_time_scales_too_far_apart(
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
    let slowest = all
        .clone()
        .filter(outpaced)
        .min_by(|&one, &other| way(one).total_cmp(&way(other)));
    let Some(slow) = slowest else { return Ok(()) };
    let shortest = |&one: &usize, &other: &usize| {
        let of = |index: usize| {
            let motion = &world.motions[index];
            self::stretch(
                way_per_epoch,
                motion.velocity.length_squared(),
                motion.angular_velocity.abs(),
            )
        };
        of(one).total_cmp(&of(other))
    };
    let fast = all.min_by(shortest).unwrap_or(slow);
    let motion = &world.motions[fast];
    Err(RunError::TimeScalesTooFarApart {
        time: world.epoch,
        body: BodyName::new(&world.bodies[fast], names),
        speed: motion.velocity.length(),
        spin: motion.angular_velocity,
        outpaced: Box::new(BodyName::new(&world.bodies[slow], names)),
        way: way(slow),
    })
}

/// The time in which a body of this speed and angular velocity travels the path `way`, or turns so
/// often that its angle loses too many digits.
fn stretch(way: f64, speed_squared: f64, spin: f64) -> f64 {
    (way / speed_squared.sqrt()).min(TURNS_PER_EPOCH * std::f64::consts::TAU / spin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        run::simulation::Simulation,
        scene::{BumperSpec, MoleculeSpec, Scene, atom_spec::AtomSpec, gas_spec::GasSpec},
    };

    fn gas(radius: f64, count: usize) -> Scene {
        let gas = GasSpec {
            radius: Some(radius.into()),
            mass: Some(1.0.into()),
            energy: 1.0,
            count: Some(count),
            ..GasSpec::default()
        };
        Scene {
            gas: vec![gas],
            ..Scene::default()
        }
    }

    fn sides(scene: &Scene) -> f64 {
        let simulation: Simulation = Simulation::new(scene).unwrap();
        sides_per_epoch(simulation.view().world)
    }

    #[test]
    fn an_epoch_is_longer_in_a_dilute_gas() {
        // The mean free path of the thesis's gas is 1/90 of a side.
        assert_eq!(sides(&gas(0.01, 1592)), 1.0);
        // 32 / (√8 2000 0.002): the gas of the thesis's test 1.
        let thin = sides(&gas(0.001, 2000));
        assert!((thin - 2.828_427_124_746_19).abs() < 1e-12, "{thin}");
        assert_eq!(sides(&gas(0.001, 50)), MAX_SIDES_PER_EPOCH);
    }

    #[test]
    fn fixed_bodies_shorten_an_epoch_and_a_single_moving_body_has_the_longest() {
        let disc = |radius, x| {
            let atoms = vec![AtomSpec {
                at: [0.0; 2],
                radius,
                mass: 1.0,
            }];
            MoleculeSpec {
                atoms,
                at: [x, 0.5],
                velocity: [1.0, 0.0],
                ..MoleculeSpec::default()
            }
        };
        let bumpers = (0..200).map(|n| {
            let at = [
                0.05 * f64::from(n % 20) + 0.02,
                0.05 * f64::from(n / 20) + 0.52,
            ];
            BumperSpec {
                tags: Vec::new(),
                at,
                radius: 0.005,
            }
        });
        let bumper: Vec<BumperSpec> = bumpers.collect();
        let one = Scene {
            molecule: vec![disc(0.01, 0.1)],
            ..Scene::default()
        };
        let two = Scene {
            molecule: vec![disc(0.01, 0.1), disc(0.01, 0.2)],
            ..Scene::default()
        };
        assert_eq!(sides(&one), SIDES_PER_EPOCH_OF_BILLIARD);
        assert_eq!(sides(&two), MAX_SIDES_PER_EPOCH);
        let among = sides(&Scene { bumper, ..two });
        assert!(
            (among - 32.0 / (8.0_f64.sqrt() * 202.0 * 0.02)).abs() < 1e-12,
            "{among}"
        );
        let none = Scene {
            bumper: vec![BumperSpec {
                tags: Vec::new(),
                at: [0.5; 2],
                radius: 0.1,
            }],
            ..Scene::default()
        };
        assert_eq!(sides(&none), MAX_SIDES_PER_EPOCH);
    }
}
