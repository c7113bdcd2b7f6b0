//! Check of all invariants by brute force, for tests, after each event.

use carom_detection::{Detection, DiscLanes, Exact};
use carom_kinematics::EpochTime;
use carom_response::Response;
use thiserror::Error;

use crate::{
    run::simulation::{Epoch, Simulation},
    scene::error::RunError,
    scheduler::Scheduler,
};

/// A violated invariant.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Violation {
    /// Bodies overlap by more than rounding.
    #[error("at time {time} {pairs} pairs of bodies overlap, the deepest by {depth:e}")]
    Overlap {
        /// Time of the check.
        time: EpochTime,
        /// Number of overlapping pairs.
        pairs: usize,
        /// Depth of the deepest overlap (length).
        depth: f64,
    },
    /// A contact lies before the earliest event of the scheduler.
    #[error(
        "bodies {first} and {second} touch {time:e} from now, before the next contact in {next:e}"
    )]
    Missed {
        /// Index of the first body.
        first: usize,
        /// Index of the second body.
        second: usize,
        /// Time until their contact.
        time: f64,
        /// Time until the scheduler's next contact.
        next: f64,
    },
    /// Two discs are not in the shell of their well that is on record.
    #[error(
        "discs {first} and {second} are {distance} apart, outside the shell of their well on record"
    )]
    Shell {
        /// Index of the first disc.
        first: usize,
        /// Index of the second disc.
        second: usize,
        /// Their distance (length).
        distance: f64,
    },
    /// The kinetic energy disagrees with the ledger.
    #[error("the kinetic energy is {energy}, but the ledger gives {booked}")]
    Energy {
        /// Kinetic energy.
        energy: f64,
        /// Initial energy, less losses, plus what was put in.
        booked: f64,
    },
}

impl<D: Detection + Clone, R: Response + Clone, S: Scheduler + Clone> Simulation<D, R, S> {
    /// Checks by brute force, with the exact detector and all pairs in all images, that no bodies
    /// overlap, that no contact before `horizon` (time from now) precedes the next contact of this
    /// simulation, that all discs are in the shells of their wells that are on record, and that the
    /// energy agrees with the ledger, to 10⁻⁹ of the present and the initial energy. After edits
    /// have put in and taken out 10⁶ times as much, rounding alone may exceed this. The search for
    /// contacts ends where the first piston reaches a stop, and where the velocity of a wall with a
    /// table changes.
    ///
    /// The cost is O(N²) for N bodies.
    ///
    /// # Errors
    /// The first [`Violation`] found.
    pub fn check_invariants(&self, horizon: f64) -> Result<(), Violation> {
        if self.world.has_springs() && matches!(self.epoch, Epoch::ToBegin) {
            // Between epochs the oscillations of pistons on springs are those of the last one.
            let mut begun = self.clone();
            begun.world.start_swings();
            return begun.check_state(horizon);
        }
        self.check_state(horizon)
    }

    fn check_state(&self, horizon: f64) -> Result<(), Violation> {
        let view = self.view();
        let overlaps = view.overlaps();
        if overlaps.pairs > 0 {
            let (pairs, depth) = (overlaps.pairs, overlaps.deepest_length);
            return Err(Violation::Overlap {
                time: self.time(),
                pairs,
                depth,
            });
        }
        let (energy, booked) = (view.energy(), view.ledger().booked());
        if (energy - booked).abs() > 1e-9 * (energy.abs() + self.ledger.initial.abs()) {
            return Err(Violation::Energy { energy, booked });
        }
        if let Some((first, second, distance)) = self.world.first_outside_shell(self.offset) {
            return Err(Violation::Shell {
                first,
                second,
                distance,
            });
        }
        let mut ahead = self.clone();
        let begun = ahead.counters.collisions;
        let now = self.time();
        // The brute-force search leaves out the stops of pistons and later pieces of tables.
        let until_change = self.world.next_change_of_walls() - self.offset;
        let horizon = horizon.min(self.time_to_first_stop()).min(until_change);
        let until = now.after(horizon).to_f64();
        let next = match ahead.step(until, &mut ()) {
            Ok(_) if ahead.counters.collisions > begun => ahead.time().since(now),
            Err(RunError::WallsMeet { time, .. }) => time.since(now),
            _ => horizon,
        };
        // Motions are those of the clock of the drag.
        let clock = self.world.clock;
        let reading = |time: f64| {
            if clock.is_free() {
                time
            } else {
                clock.reading(clock.duration(self.offset) + time) - self.offset
            }
        };
        match self.soonest_by_brute_force(reading(horizon)) {
            // The two times are computed from different origins, so they agree to the rounding of
            // the offset.
            Some((first, second, soonest))
                if soonest < reading(next) - 1e-12 * (horizon + self.offset) =>
            {
                Err(Violation::Missed {
                    first,
                    second,
                    time: clock.duration(self.offset + soonest) - clock.duration(self.offset),
                    next,
                })
            }
            _ => Ok(()),
        }
    }

    /// The time until the first piston reaches one of its stops; infinite if none does.
    fn time_to_first_stop(&self) -> f64 {
        let pistons = self.world.pistons();
        let times = pistons.map(|piston| {
            let motion = &self.world.motions[piston];
            self.world.stop_time(piston as u32, motion, self.offset) - self.offset
        });
        times.fold(f64::INFINITY, f64::min)
    }

    /// The bodies of the first contact within `horizon` and its time from now; `None` without one.
    fn soonest_by_brute_force(&self, horizon: f64) -> Option<(usize, usize, f64)> {
        let world = &self.world;
        let (mut soonest, mut limit) = (None, horizon);
        for (number, bond) in (0..).zip(world.bonds()) {
            let motions = bond.bodies.map(|body| &world.motions[body as usize]);
            let (outcome, _) = world.first_bond_event(number, motions, self.offset, limit);
            if let Some(contact) = outcome.contact() {
                (soonest, limit) = (Some(bond.bodies), contact.time);
            }
        }
        for (bodies, _) in world.shells.pairs() {
            let motions = bodies.map(|body| &world.motions[body as usize]);
            let (outcome, _) = world.first_step(bodies, motions, self.offset, limit);
            if let Some(contact) = outcome.contact() {
                (soonest, limit) = (Some(bodies), contact.time);
            }
        }
        let count = world.bodies.len() as u32;
        for bodies in (0..count).flat_map(|i| (0..i).map(move |j| [i, j])) {
            let pair = bodies.map(|body| &world.bodies[body as usize]);
            if pair.iter().all(|body| body.is_fixed()) || pair.iter().all(|body| body.is_wall()) {
                continue;
            }
            for image in (0..25).map(|step| [step % 5 - 2, step / 5 - 2]) {
                if let Some(time) = self.first_contact_in_image(bodies, image, limit) {
                    (soonest, limit) = (Some(bodies), time);
                }
            }
        }
        soonest.map(|[i, j]| (i as usize, j as usize, limit))
    }

    /// The time from now until the first contact of two bodies in an image; `None` without one
    /// within `limit`.
    fn first_contact_in_image(&self, bodies: [u32; 2], image: [i64; 2], limit: f64) -> Option<f64> {
        let (world, exact) = (&self.world, Exact::default());
        let factor = world.pair_factor(bodies);
        if factor == 0.0 {
            return None;
        }
        let motions = bodies.map(|body| &world.motions[body as usize]);
        let [a, b] = bodies.map(|body| world.bodies[body as usize].kind.molecule.outline());
        let pair = world.relative_motion(bodies, motions, image, self.offset);
        if factor != 1.0 {
            let reach = factor * (a.bounding_radius + b.bounding_radius);
            let speed = motions[0].velocity.abs().element_sum();
            let mut lanes = DiscLanes::empty(pair.separation_error, speed);
            lanes.set(0, pair.separation, pair.velocity, reach);
            let time = exact.disc_contacts(&lanes)[0];
            return (time < limit).then_some(time);
        }
        let times = [0.0, limit];
        let answer = world.first_contact(&exact, bodies, [a, b], &pair, self.offset, times);
        answer.outcome.contact().map(|contact| contact.time)
    }
}
