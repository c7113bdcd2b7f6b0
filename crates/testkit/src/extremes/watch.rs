//! What is logged of every run: overlaps, energy, momentum, and whether each single collision makes sense.

use anyhow::Result;
use carom::{CollisionReport, EpochTime, Observer, Scene};
use glam::DVec2;

use super::{Engine, Finding, engine::Run};

/// Looks at each collision.
#[derive(Debug, Clone)]
pub struct Watch {
    /// Time of each of the first collisions (time), for closed forms to be compared with.
    pub times: Vec<f64>,
    /// Atoms of each of the first collisions.
    pub atoms: Vec<[Option<u32>; 2]>,
    /// Bodies of each of the first collisions.
    pub bodies: Vec<[u64; 2]>,
    begun: EpochTime,
    last: Option<EpochTime>,
    /// Smallest time from one collision to the next that is not 0.
    pub smallest_interval: f64,
    /// Collisions at the very instant of the one before.
    pub at_once: usize,
    /// Collisions before the one before.
    pub backwards: usize,
    /// Largest speed of approach after a collision, less what the elasticity asks for, over the speeds involved.
    pub response_error: f64,
    /// Largest speed of parting before a collision, over the speeds involved.
    pub parting: f64,
    /// Largest change of the angular momentum of one body about the point of contact, over that of its spin.
    pub angular_error: f64,
}

/// Of so many collisions times and bodies are kept.
const KEPT: usize = 10_000;

impl Default for Watch {
    fn default() -> Self {
        Self::since(EpochTime::ZERO)
    }
}

impl Watch {
    /// Times count from here.
    pub fn since(begun: EpochTime) -> Self {
        Self {
            times: Vec::new(),
            atoms: Vec::new(),
            bodies: Vec::new(),
            begun,
            last: None,
            smallest_interval: f64::INFINITY,
            at_once: 0,
            backwards: 0,
            response_error: 0.0,
            parting: 0.0,
            angular_error: 0.0,
        }
    }
}

impl Observer for Watch {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        if self.times.len() < KEPT {
            self.times.push(report.time.since(self.begun));
            self.atoms.push([report.sides[0].atom, report.sides[1].atom]);
            self.bodies.push([report.sides[0].body.id(), report.sides[1].body.id()]);
        }
        if let Some(last) = self.last {
            let interval = report.time.since(last);
            if interval > 0.0 {
                self.smallest_interval = self.smallest_interval.min(interval);
            }
            self.at_once += usize::from(interval == 0.0);
            self.backwards += usize::from(interval < 0.0);
        }
        self.last = Some(report.time);
        let [a, b] = &report.sides;
        let closing = |before: bool| {
            let [one, two] = [a, b].map(|side| if before { side.before } else { side.after });
            report.normal.dot(one.velocity_of(a.arm) - two.velocity_of(b.arm))
        };
        // What a rounding of places, arms and velocities is a share of.
        let speed = |side: &carom::engine::Side<'_>| {
            let of = |m: &carom::Motion| m.velocity.length() + m.angular_velocity.abs() * side.arm.length();
            of(&side.before) + of(&side.after)
        };
        let scale = speed(a) + speed(b);
        let [before, after] = [closing(true), closing(false)];
        self.parting = self.parting.max(-before / scale);
        let wanted = -report.elasticity.coefficient() * before.max(0.0);
        if before > 0.0 {
            self.response_error = self.response_error.max((after - wanted).abs() / scale);
        }
        for side in [a, b] {
            let (arm, impulse) = (side.arm, side.momentum_change());
            let size = arm.length() * impulse.length();
            if size > 0.0 && !side.body.is_locked() {
                let error = (arm.perp_dot(impulse) - side.angular_momentum_change()).abs();
                // The spin is rounded as a whole, however little of it changes.
                let moment = 1.0 / side.body.inertia().inverse_moment;
                let spin = moment * (side.before.angular_velocity.abs() + side.after.angular_velocity.abs());
                self.angular_error = self.angular_error.max(error / (size + spin));
            }
        }
    }
}

/// What a run has shown.
#[derive(Debug, Clone)]
pub struct Survey {
    /// Each collision.
    pub watch: Watch,
    /// Collisions.
    pub collisions: u64,
    /// Largest number of overlapping pairs at a sample.
    pub overlapping: usize,
    /// Largest relative difference of energy and booked energy.
    pub energy: f64,
    /// Largest change of the total momentum over the sum of its magnitudes; 0 where something is fixed.
    pub momentum: f64,
}

/// Samples in a survey, roughly.
const SAMPLES: u64 = 64;

/// Slices of time at most, should nothing ever collide.
const MOST_SLICES: usize = 4096;

/// A slice is cut short at so many times the collisions that it was meant for.
const MANY: f64 = 8.0;

/// Runs on until there have been so many more collisions, and looks at the whole now and then.
///
/// # Errors
/// The run cannot go on.
pub fn run_collisions<E: Engine, O: Observer>(
    run: &mut Run<E>,
    collisions: u64,
    observer: &mut O,
    mut look: impl FnMut(&Run<E>),
) -> Result<()> {
    let begun = run.view().counters().collisions;
    let fastest = run.view().bodies().map(|body| body.motion.velocity.length()).fold(0.0, f64::max);
    let spin = run.view().bodies().map(|body| body.motion.angular_velocity.abs()).fold(0.0, f64::max);
    let side = run.view().bounds().sides().min_element();
    // Where discs are packed to 1e-9 of their size, millions of contacts would pass in a first slice any longer.
    let mut slice = 1e-14 * (side / fastest).min(1e3 / spin);
    for _ in 0..MOST_SLICES {
        let before = run.view().counters().collisions;
        if before - begun >= collisions || !slice.is_finite() {
            break;
        }
        let until = run.time().after(slice);
        // As many collisions to the next look as there shall be, without jumps.
        let wanted = (collisions / SAMPLES).max(1) as f64;
        let so_far = |run: &Run<E>| run.view().counters().collisions - before;
        while !run.observe_epoch(until, observer)? {
            // A molecule of extreme spin heats a cold gas at once: millions of contacts would follow in the rest of a slice.
            if so_far(run) as f64 > MANY * wanted {
                break;
            }
        }
        look(run);
        let new = so_far(run);
        slice *= if new == 0 { 4.0 } else { (wanted / new as f64).clamp(0.25, 4.0) };
    }
    Ok(())
}

/// Runs a scene for so many collisions.
///
/// # Errors
/// It cannot be built, or the run cannot go on.
pub fn survey<E: Engine>(scene: &Scene, collisions: u64) -> Result<Survey> {
    let mut run = E::simulate(scene)?;
    survey_of::<E>(&mut run, collisions)
}

/// Runs on for so many collisions.
///
/// # Errors
/// The run cannot go on.
pub fn survey_of<E: Engine>(run: &mut Run<E>, collisions: u64) -> Result<Survey> {
    let mut watch = Watch::since(run.time());
    let (mut overlapping, mut energy, mut momentum) = (0, 0.0f64, 0.0f64);
    let free = run.view().bodies().all(|body| !body.body.is_fixed());
    let start = run.view().momentum();
    run_collisions::<E, _>(run, collisions, &mut watch, |run| {
        let view = run.view();
        let overlaps = view.overlaps();
        overlapping = overlapping.max(overlaps.pairs);
        energy = energy.max((view.energy() / view.ledger().booked() - 1.0).abs());
        if free {
            let size: f64 =
                view.bodies().map(|body| body.body.molecule().mass() * body.motion.velocity.length()).sum();
            momentum = momentum.max((view.momentum() - start).length() / size);
        }
    })?;
    let collisions = run.view().counters().collisions;
    Ok(Survey { watch, collisions, overlapping, energy, momentum })
}

impl Survey {
    /// What must hold in any run.
    pub fn findings(&self, name: &str) -> Vec<Finding> {
        let named = |what: &str| if name.is_empty() { what.to_owned() } else { format!("{name}: {what}") };
        let watch = &self.watch;
        vec![
            Finding::never(named("overlapping pairs"), self.overlapping),
            Finding::new(named("energy drift, relative"), self.energy, 1e-12),
            Finding::new(named("drift of the momentum, relative"), self.momentum, 1e-12),
            Finding::never(named("collisions before the one before"), watch.backwards),
            Finding::new(named("speed of parting before a contact, relative"), watch.parting, 1e-6),
            Finding::new(named("speed after a contact, relative error"), watch.response_error, 1e-13),
            Finding::new(
                named("angular momentum about a contact, relative error"),
                watch.angular_error,
                1e-13,
            ),
            Finding::never(named("runs without collisions"), usize::from(self.collisions == 0)),
        ]
    }
}

/// Velocity of the body inserted as number `index`.
pub fn velocity<E: Engine>(run: &Run<E>, index: usize) -> DVec2 {
    run.view().bodies().nth(index).map_or(DVec2::NAN, |body| body.motion.velocity)
}

/// Place of the body inserted as number `index`, in the box.
pub fn place<E: Engine>(run: &Run<E>, index: usize) -> DVec2 {
    run.view().bodies().nth(index).map_or(DVec2::NAN, |body| body.motion.position)
}
