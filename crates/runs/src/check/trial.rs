//! A trial run of about a second, and the estimate of the whole run from it.

use anyhow::Result;
use carom::{
    EpochTime, Observer as _, Scene,
    engine::{RunSpec, TileUse, Tiling},
    kinematics::DragClock,
    observers::write_extended_xyz,
};
use carom_methods::AnySimulation;
use serde::Serialize;

use super::{actions::Actions, collisions::ExpectedCollisions, contents::CheckedContents};
use crate::clock::ProcessTime;
use crate::{checkpoint_file::encode, measures::Measures, sampling_times::sampling_count};

/// Processor time of the trial (seconds).
const TRIAL_SECONDS: f64 = 1.0;

/// A trial that has taken so long ends with a tenth of the run (seconds of processor time, share).
/// Less: a fluctuation at the start decides. More: a check of a short run takes as long as the run.
const MIN_SECONDS: f64 = 0.1;
const MAX_SHARE: f64 = 0.1;

/// Contacts of the trial if measures watch them: some keep every contact in memory.
const MAX_WATCHED: u64 = 300_000;

/// Contacts one by one at the start of the trial, which give the length of its first stretch
/// (time).
const FIRST_CONTACTS: u64 = 64;

/// Contacts from which the rate at the start is taken. Fewer: it has an error of more than some per
/// cent. More: a gas that cools has cooled.
const EARLY_CONTACTS: u64 = 1000;

/// A stretch of the trial that takes longer is not lengthened (seconds of processor time).
const STRETCH_SECONDS: f64 = 0.05;

/// The rest of the run has at least this number of windows, if some of it is tried in tiles. Fewer:
/// the trial of a short run takes as long as the run.
const MIN_WINDOWS: f64 = 10.0;

/// Contacts of a body after which the rate of the trial is that of the run. Fewer: the order of the
/// start, such as a lattice, is felt.
const MIN_COLLISIONS: f64 = 10.0;

/// Epochs after which their mean time is measured.
const MEASURED_EPOCHS: u64 = 4;

/// Contacts of a body in an epoch of the default scheduler, each of which is shared by two.
const CONTACTS_PER_EPOCH: f64 = 64.0;

/// The trial.
#[derive(Debug, Clone, Copy)]
pub(super) struct Trial {
    /// Contacts, epochs, simulated time and processor time (seconds) after the first step.
    contacts: u64,
    epochs: u64,
    simulated: f64,
    seconds: f64,
    /// Contacts and processor time (seconds) of the part that runs as the run does: in tiles, if it
    /// uses them.
    pace: [f64; 2],
    /// Processor time of the first step, which predicts all bodies (seconds).
    first: f64,
    /// Processor time of a sample of all measures (seconds).
    sample: f64,
    is_whole: bool,
    until: f64,
    /// Samples of past times at the end of the run (bytes).
    lags: u64,
    /// Contacts and simulated time (time) of its first part.
    early: [f64; 2],
}

/// What the run will take.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct TrialEstimate {
    /// Contacts in the trial, and the simulated time that they took.
    pub(super) trial_collisions: u64,
    pub(super) trial_time: f64,
    /// Whether the trial has reached the end of the run.
    pub(super) is_whole_run: bool,
    /// Contacts of the run at the rate of the trial; `None` if no time has passed in it.
    pub(super) collisions: Option<f64>,
    /// Contacts of the run, counted for each body that moves: twice, but once with a fixed body.
    pub(super) collisions_of_moving: Option<f64>,
    /// Contacts per time at the start, counted in the same way; `None` without contacts there.
    pub(super) early_rate_of_moving: Option<f64>,
    /// Processor time of the run, of which for samples and snapshots (seconds).
    pub(super) seconds: Option<f64>,
    pub(super) sample_seconds: f64,
    /// Contacts per second of processor time.
    pub(super) collisions_per_second: f64,
    /// Wall time of an epoch: a signal is answered, and a checkpoint written, at its end (seconds).
    pub(super) epoch_seconds: f64,
    /// Whether that is the mean of the trial; else it is the longest possible.
    pub(super) is_epoch_measured: bool,
    /// Bodies, their events and the measures at the start in memory (bytes).
    pub(super) memory: u64,
    /// A checkpoint at the start of the run (bytes).
    pub(super) checkpoint: u64,
    /// Series and blocks of the measures at the end of the run, in memory and in the checkpoint
    /// (bytes).
    pub(super) series: u64,
    /// All snapshots (bytes); 0 without.
    pub(super) snapshots: u64,
    /// The actions of thermostats.
    pub(super) actions: Option<Actions>,
}

impl Trial {
    /// Runs until the end, for a tenth of the run, for [`TRIAL_SECONDS`], or for [`MAX_WATCHED`]
    /// contacts that are watched; then, if the run is in tiles, for one window of them.
    ///
    /// Contacts one by one and short stretches cost too much in tiles: a window of them stores all
    /// bodies. So the first part is in order, which gives the same contacts.
    ///
    /// # Errors
    /// The run fails.
    pub(super) fn run(
        simulation: &mut AnySimulation,
        measures: &mut Measures,
        run: &RunSpec,
        tiling: &Tiling,
    ) -> Result<Self> {
        simulation.set_tiling(&Tiling::NONE);
        let lags = bytes_of_lags(simulation, measures, run)?;
        measures.check(&simulation.view());
        let end = EpochTime::from(run.until);
        let clock = ProcessTime::now();
        let is_whole = step(simulation, measures, end)?;
        let first = clock.elapsed().as_secs_f64();
        let bounds = TrialBounds::new(simulation, measures, end);
        let epochs_before = simulation.view().counters().epochs;
        let in_order = bounds.run_in_order(simulation, measures, is_whole)?;
        let mut seconds = in_order.seconds;
        let mut pace = [bounds.contacts(simulation) as f64, seconds];
        simulation.set_tiling(tiling);
        if !in_order.is_whole
            && let Some(window) = bounds.run_window(simulation, measures, tiling, in_order.stop)?
        {
            seconds += window[1];
            pace = window;
        }
        let simulated = simulation.time().since(bounds.start);
        let contacts = bounds.contacts(simulation);
        let epochs = simulation.view().counters().epochs - epochs_before;
        let clock = ProcessTime::now();
        measures.sample(&simulation.view());
        let sample = clock.elapsed().as_secs_f64();
        Ok(Self {
            contacts,
            epochs,
            simulated,
            seconds,
            pace,
            first,
            sample,
            is_whole: in_order.is_whole,
            until: run.until,
            lags,
            early: in_order.early,
        })
    }

    /// The number of contacts of the whole run: that of theory, where it predicts it and the trial
    /// was too short to forget the start; else at the rate of the trial.
    fn collisions(&self, simulation: &AnySimulation, expected: &ExpectedCollisions) -> Option<f64> {
        let all = simulation.view().counters().collisions as f64;
        if self.is_whole {
            return Some(all);
        }
        let of_each = 2.0 * self.contacts as f64 / simulation.view().len() as f64;
        let of_theory = expected
            .number
            .filter(|_| expected.is_prediction && of_each < MIN_COLLISIONS);
        let whole = self.whole_over_trial(simulation)?;
        of_theory.or(Some(self.contacts as f64 * whole))
    }

    /// Contacts per second of processor time.
    fn speed(&self) -> f64 {
        self.pace[0] / self.pace[1].max(1e-9)
    }

    /// The whole run over the trial, in the time without drag that gives the same paths; `None` if
    /// the trial made no progress.
    fn whole_over_trial(&self, simulation: &AnySimulation) -> Option<f64> {
        let clock = DragClock::new(simulation.view().drag());
        (self.simulated > 0.0).then(|| clock.reading(self.until) / clock.reading(self.simulated))
    }

    /// The longest wall time of an epoch, or the mean (seconds).
    fn epoch(&self, moving: usize) -> (f64, bool) {
        if self.epochs >= MEASURED_EPOCHS {
            return (self.seconds / self.epochs as f64, true);
        }
        let contacts = 0.5 * CONTACTS_PER_EPOCH * moving as f64;
        let each = if self.contacts == 0 {
            0.0
        } else {
            1.0 / self.speed()
        };
        (self.first + contacts * each, false)
    }

    /// Processor time of the run between its samples, with this number of contacts and this time of
    /// an epoch (seconds).
    fn contacts_seconds(
        &self,
        simulation: &AnySimulation,
        collisions: Option<f64>,
        epoch_seconds: f64,
    ) -> Option<f64> {
        if self.is_whole {
            return Some(self.seconds);
        }
        let number = collisions?;
        let all = if self.contacts == 0 {
            self.seconds * self.whole_over_trial(simulation).unwrap_or_default()
        } else {
            number / self.speed()
        };
        // An epoch begins with a prediction of all bodies, which a short trial leaves out.
        let epochs = if self.epochs > 0 {
            0.0
        } else {
            all / epoch_seconds
        };
        Some(all + epochs * self.first)
    }

    /// The estimate for the whole run. The simulation is the one of the trial.
    ///
    /// # Errors
    /// An action of a thermostat fails, or the state cannot be encoded.
    pub(super) fn estimate(
        &self,
        simulation: &mut AnySimulation,
        measures: &Measures,
        scene: &Scene,
        contents: &CheckedContents,
        expected: &ExpectedCollisions,
    ) -> Result<TrialEstimate> {
        let collisions = self.collisions(simulation, expected);
        let counters = simulation.view().counters();
        let of_moving = if counters.collisions > 0 {
            counters.collisions_of_moving() as f64 / counters.collisions as f64
        } else {
            2.0
        };
        let actions = Actions::new(simulation, scene)?;
        let of_measures = encode(measures)?.len();
        let memory = (simulation.heap_bytes() + of_measures) as u64;
        let (epoch_seconds, is_epoch_measured) = self.epoch(contents.moving);
        let (snapshots, snapshot_seconds) = snapshots(simulation, scene)?;
        let sample_seconds = contents.samples as f64 * self.sample + snapshot_seconds;
        let more = sample_seconds + actions.map_or(0.0, |actions| actions.seconds);
        let contacts_seconds = self.contacts_seconds(simulation, collisions, epoch_seconds);
        let state = encode(&simulation.end_epoch_here())?.len() + of_measures;
        Ok(TrialEstimate {
            trial_collisions: self.contacts,
            trial_time: self.simulated,
            is_whole_run: self.is_whole,
            collisions,
            collisions_of_moving: collisions.map(|number| number * of_moving),
            early_rate_of_moving: (self.early[0] > 0.0 && self.early[1] > 0.0)
                .then(|| self.early[0] / self.early[1] * of_moving),
            seconds: contacts_seconds.map(|seconds| self.first + seconds + more),
            sample_seconds,
            collisions_per_second: self.speed(),
            epoch_seconds,
            is_epoch_measured,
            memory,
            checkpoint: state as u64,
            series: measures
                .bytes_at_end(&scene.run)
                .saturating_add(measures.bytes_of_blocks(&scene.run))
                .saturating_add(self.lags),
            snapshots,
            actions,
        })
    }
}

/// Runs to the next contact, or to the end of an epoch; returns whether the end of the run is
/// reached.
fn step(simulation: &mut AnySimulation, measures: &mut Measures, end: EpochTime) -> Result<bool> {
    // At most one epoch, so that the clock is read again soon at any speed.
    let contacts = simulation.observe_contacts(end, 1, measures)?;
    Ok(contacts == 0 && simulation.time() >= end)
}

/// Starts the measures and takes their first sample; returns the size of the samples of past times
/// at the end of the run (bytes).
fn bytes_of_lags(
    simulation: &AnySimulation,
    measures: &mut Measures,
    run: &RunSpec,
) -> Result<u64> {
    measures.start(&simulation.view());
    let before = measures.sizes()?;
    measures.sample(&simulation.view());
    let after = measures.sizes()?.into_iter();
    let grown = after
        .zip(before)
        .map(|(after, before)| after.saturating_sub(before));
    Ok(measures.bytes_of_lags(&grown.collect::<Vec<_>>(), run))
}

/// The first part of a trial, which runs in order.
struct InOrder {
    is_whole: bool,
    /// Contacts and simulated time (time) at its start.
    early: [f64; 2],
    /// Processor time (seconds).
    seconds: f64,
    /// Processor time of a stop (seconds).
    stop: f64,
}

/// What ends a trial.
struct TrialBounds {
    /// The end of the run.
    end: EpochTime,
    /// Most contacts.
    most: u64,
    /// Collisions before the first of them.
    before: u64,
    /// The time after the first step.
    start: EpochTime,
    /// The time at which a tenth of the run is done.
    enough: EpochTime,
    /// Begins after the first step.
    clock: ProcessTime,
}

impl TrialBounds {
    /// The bounds from the present state on.
    fn new(simulation: &AnySimulation, measures: &Measures, end: EpochTime) -> Self {
        let clock = ProcessTime::now();
        let most = if measures.watching().is_empty() {
            u64::MAX
        } else {
            MAX_WATCHED
        };
        let before = simulation.view().counters().collisions;
        let now = simulation.time();
        Self {
            end,
            most,
            before,
            start: now,
            enough: now.after(MAX_SHARE * end.since(now)),
            clock,
        }
    }

    /// Contacts so far.
    fn contacts(&self, simulation: &AnySimulation) -> u64 {
        simulation.view().counters().collisions - self.before
    }

    /// Contacts and simulated time (time) so far.
    fn so_far(&self, simulation: &AnySimulation) -> [f64; 2] {
        let simulated = simulation.time().since(self.start);
        [self.contacts(simulation) as f64, simulated]
    }

    /// Whether the trial may continue.
    fn allow(&self, simulation: &AnySimulation) -> bool {
        let seconds = self.clock.elapsed().as_secs_f64();
        let has_enough = simulation.time() >= self.enough && seconds >= MIN_SECONDS;
        self.contacts(simulation) < self.most && seconds < TRIAL_SECONDS && !has_enough
    }

    /// Whether the contacts of a window of tiles may be added, some two or four a body.
    fn allow_more(&self, simulation: &AnySimulation) -> bool {
        let more = 4 * simulation.view().len() as u64;
        self.contacts(simulation).saturating_add(more) < self.most
    }

    /// Runs in order, contact by contact and then in stretches, as far as the trial may continue.
    /// `is_whole` tells whether the end of the run is reached already.
    fn run_in_order(
        &self,
        simulation: &mut AnySimulation,
        measures: &mut Measures,
        mut is_whole: bool,
    ) -> Result<InOrder> {
        while !is_whole && self.contacts(simulation) < FIRST_CONTACTS && self.allow(simulation) {
            is_whole = step(simulation, measures, self.end)?;
        }
        let mut early = self.so_far(simulation);
        // A stop stores the motions of all bodies, which a run does at its samples only.
        let mut seconds = self.clock.elapsed().as_secs_f64();
        simulation.observe_until(simulation.time().to_f64(), measures)?;
        let stop = self.clock.elapsed().as_secs_f64() - seconds;
        // It doubles, so that a stretch takes at most about twice as long as all before it. If all
        // contacts so far are at one instant, it begins at the least number.
        let mut stretch = simulation.time().since(self.start).max(f64::MIN_POSITIVE);
        while !is_whole && self.allow(simulation) {
            let now = self.clock.elapsed().as_secs_f64();
            is_whole = self.advance(simulation, measures, stretch)?;
            if early[0] < EARLY_CONTACTS as f64 {
                early = self.so_far(simulation);
            }
            let taken = (self.clock.elapsed().as_secs_f64() - now - stop).max(0.0);
            seconds += taken;
            if taken < STRETCH_SECONDS {
                stretch *= 2.0;
            }
        }
        Ok(InOrder {
            is_whole,
            early,
            seconds,
            stop,
        })
    }

    /// Runs for a window of tiles, and returns its contacts and its processor time without that of
    /// a stop (seconds). `None` if the run is not in tiles, or if the trial would take as long as
    /// the run.
    fn run_window(
        &self,
        simulation: &mut AnySimulation,
        measures: &mut Measures,
        tiling: &Tiling,
        stop: f64,
    ) -> Result<Option<[f64; 2]>> {
        if !matches!(simulation.tile_use(), TileUse::Tiles(_)) {
            return Ok(None);
        }
        // Tiles know the length of their windows only once they run.
        let [before, simulated] = self.so_far(simulation);
        let rate = before / simulated;
        let window = 0.5 * simulation.view().len() as f64 / rate * tiling.window;
        let is_short = MIN_WINDOWS * window <= self.end.since(simulation.time());
        if !is_short || !self.allow_more(simulation) {
            return Ok(None);
        }
        let clock = ProcessTime::now();
        simulation.observe_until(simulation.time().to_f64() + window, measures)?;
        let taken = (clock.elapsed().as_secs_f64() - stop).max(0.0);
        Ok(Some([self.contacts(simulation) as f64 - before, taken]))
    }

    /// Runs for a stretch of time, as far as the trial may continue; returns whether the end of the
    /// run is reached.
    fn advance(
        &self,
        simulation: &mut AnySimulation,
        measures: &mut Measures,
        stretch: f64,
    ) -> Result<bool> {
        let limit = simulation.time().after(stretch);
        let limit = if limit < self.end { limit } else { self.end };
        // Epochs become shorter when a small molecule begins to turn fast, so the clock is read at
        // the end of each.
        let mut is_there = false;
        while !is_there && self.allow(simulation) {
            is_there = simulation.observe_epoch(limit, measures)?;
        }
        Ok(is_there && limit == self.end)
    }
}

/// Size of all snapshots of a run (bytes), and the processor time to write them (seconds).
fn snapshots(simulation: &AnySimulation, scene: &Scene) -> Result<(u64, f64)> {
    if scene.run.snapshots.is_none() {
        return Ok((0, 0.0));
    }
    let interval = scene
        .run
        .snapshot_interval
        .unwrap_or(scene.run.sample_interval);
    let count = sampling_count(0.0, scene.run.until, interval) + 1;
    let clock = ProcessTime::now();
    let mut frame = Vec::new();
    write_extended_xyz(&simulation.view(), &mut frame)?;
    Ok((
        count * frame.len() as u64,
        count as f64 * clock.elapsed().as_secs_f64(),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(text: &str) -> Scene {
        Scene::from_toml(text).unwrap()
    }

    fn trial(scene: &Scene, until: f64) -> Trial {
        let mut simulation = AnySimulation::new(scene).unwrap();
        let mut measures = Measures::new(scene, &simulation.view()).unwrap();
        Trial::run(
            &mut simulation,
            &mut measures,
            &run_to(until),
            &Tiling::NONE,
        )
        .unwrap()
    }

    fn run_to(until: f64) -> RunSpec {
        RunSpec {
            until,
            ..RunSpec::default()
        }
    }

    /// The samples of a correlation are kept for as many decades of lags as the run is long.
    #[test]
    fn the_memory_of_lags_is_foreseen() {
        let scene = scene(
            "[[gas]]\nradius = 0.002\nmass = 1.0\nenergy = 1.0\ncount = 2000\n\
             [run]\nuntil = 2.0\nsample_interval = 0.01\nobserve = [\"correlation\"]\n",
        );
        let mut simulation = AnySimulation::new(&scene).unwrap();
        let mut measures = Measures::new(&scene, &simulation.view()).unwrap();
        let trial = Trial::run(&mut simulation, &mut measures, &scene.run, &Tiling::NONE).unwrap();
        let mut run = AnySimulation::new(&scene).unwrap();
        let mut measures = Measures::new(&scene, &run.view()).unwrap();
        let before: u64 = measures.sizes().unwrap().iter().sum();
        measures.start(&run.view());
        measures.sample(&run.view());
        for sample in 1..=200 {
            let time = 0.01 * f64::from(sample);
            run.observe_until(time, &mut measures).unwrap();
            measures.sample(&run.view());
        }
        let found = measures.sizes().unwrap().iter().sum::<u64>() - before;
        let ratio = trial.lags as f64 / found as f64;
        assert!((0.8..1.2).contains(&ratio), "{ratio}: {found}");
    }

    /// A number of collisions that no theory predicts.
    fn unknown() -> ExpectedCollisions {
        ExpectedCollisions {
            number: None,
            is_prediction: false,
            source: String::new(),
        }
    }

    /// From a lattice, contacts are rare at first, and a trial of a large gas does not get beyond.
    #[test]
    fn a_trial_that_stays_on_the_lattice_leaves_the_number_to_theory() {
        let scene = scene(
            "[[gas]]\nradius = 0.001\nmass = 1.0\ntemperature = 1.0\nvelocities = \"maxwell\"\n\
             area_fraction = 0.5\n",
        );
        let mut simulation = AnySimulation::new(&scene).unwrap();
        let mut measures = Measures::new(&scene, &simulation.view()).unwrap();
        let expected = ExpectedCollisions::new(&scene, &simulation.view());
        let tiling = Tiling {
            least_bodies: 1,
            ..Tiling::with_threads(2)
        };
        let trial = Trial::run(&mut simulation, &mut measures, &run_to(1.0), &tiling).unwrap();
        let found = trial.collisions(&simulation, &expected).unwrap();
        assert!(
            (found / expected.number.unwrap() - 1.0).abs() < 0.1,
            "{trial:?}"
        );
        // A window of tiles is tried at the end, at about the speed of the rest.
        let in_order = trial.contacts as f64 - trial.pace[0];
        assert!(in_order > 0.0 && trial.pace[0] > 1e4, "{trial:?}");
    }

    /// The first contact of the tee makes it turn 10¹¹ times as fast as the gas moves, after which
    /// an epoch takes 10⁻¹¹ of a free time.
    #[test]
    fn a_trial_ends_although_epochs_become_short_on_the_way() {
        let tiny = scene(
            "[[molecule]]\nshape = \"tee\"\natom_radius = 1.1315705652041742e-11\natom_mass = 1.0\n\
             at = [0.5, 0.5]\n[[gas]]\nradius = 0.01\nmass = 1.0\ntemperature = 1.0\n\
             velocities = \"maxwell\"\ncount = 120\n",
        );
        let trial = trial(&tiny, 10.0);
        assert!(
            !trial.is_whole && trial.simulated < 10.0 && trial.epochs > 1000,
            "{trial:?}"
        );
    }

    #[test]
    fn a_short_run_is_counted_in_full_and_a_long_run_is_extrapolated() {
        let scene = scene(
            "[box]\nseed = 5\n[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 200\n",
        );
        let mut simulation = AnySimulation::new(&scene).unwrap();
        let mut measures = Measures::new(&scene, &simulation.view()).unwrap();
        let short =
            Trial::run(&mut simulation, &mut measures, &run_to(0.5), &Tiling::NONE).unwrap();
        let mut run = AnySimulation::new(&scene).unwrap();
        run.run_until(0.5).unwrap();
        assert!(short.is_whole);
        assert_eq!(
            short.collisions(&simulation, &unknown()),
            Some(run.view().counters().collisions as f64)
        );
        let long = trial(&scene, 1e9);
        assert!(
            !long.is_whole && long.simulated < 1e9 && long.epochs > 0,
            "{long:?}"
        );
    }

    /// The fastest gases that a scene can have, and a body that meets no other.
    #[test]
    fn a_trial_with_drag_is_extrapolated_to_the_end_of_all_paths() {
        let scene = scene(
            "[box]\nseed = 5\ndrag = 1e-6\n[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 200\n",
        );
        let trial = trial(&scene, 1e9);
        assert!(!trial.is_whole && trial.simulated < 1e4, "{trial:?}");
        let found = trial
            .collisions(&AnySimulation::new(&scene).unwrap(), &unknown())
            .unwrap();
        // All paths are those of a time of 1/γ at the initial rate.
        let expected = trial.contacts as f64 / trial.simulated * 1e6;
        assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
    }

    #[test]
    fn the_trial_of_a_fast_system_is_bounded() {
        let gas = |entries: &str| {
            format!(
                "[box]\nseed = 5\n[[gas]]\nradius = 0.01\n{entries}\n[run]\nuntil = 1000.0\nobserve = [\"pressure\"]\n"
            )
        };
        for entries in [
            "mass = 1e-26\nenergy = 1.0\ncount = 200",
            "mass = 1.0\ntemperature = 1e60\ncount = 200",
            "mass = 1e-30\nenergy = 1.0\ncount = 1",
        ] {
            let scene = scene(&gas(entries));
            let trial = trial(&scene, scene.run.until);
            assert!(
                !trial.is_whole && trial.contacts < 3 * MAX_WATCHED,
                "{entries}: {trial:?}"
            );
        }
    }

    #[test]
    fn watched_contacts_bound_the_trial() {
        let gas =
            "[box]\nseed = 5\n[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 2000\n";
        let watched = trial(
            &scene(&format!(
                "{gas}[run]\nuntil = 1e6\nobserve = [\"pressure\"]\n"
            )),
            1e6,
        );
        assert!(watched.contacts < 3 * MAX_WATCHED, "{watched:?}");
    }
}
