//! A run whose stages are written while it continues: each edit begins a stage at the present time.
//!
//! The scene with the stages so far is an ordinary scene: its text is the list of the edits with
//! their instants, to the bit, and `carom run` makes the same contacts. A saved run is the folder
//! of a run of that scene with a checkpoint at the end of an epoch, so that `carom run
//! DIR/config.toml --out DIR --resume` continues from it. The measures of that run begin at the
//! checkpoint. What a program has measured before is saved in a folder inside, [`MEASURED`]; the
//! run puts the rows of series that it measures too before its own.

use std::{
    ffi::OsString,
    fs::{self, File},
    io,
    iter::Peekable,
    ops::ControlFlow,
    path::{Path, PathBuf},
    time::Duration,
};

use anyhow::{Context, Result, bail, ensure};
use carom::{
    Checkpoint, EpochTime, Observer, Scene, View,
    engine::{ElasticitySpec, MeasureParameter, MeasureSpec, RunSpec, StageSpec, ThermostatSpec},
    geometry::MAX_MAGNITUDE,
};
use carom_methods::{AnySimulation, Method};

pub use super::measured_before::{MEASURED, MeasuredBefore, NamedFile};
use super::{
    START, describe,
    measured_before::{ContinuedMeasure, EarlierFiles},
    outcome::PICTURE,
    scene_file::{self, MAX_SAMPLES, tags},
};
use crate::schedule::{
    Schedule, ScheduledStep, What,
    pieces::Pieces,
    spans, stage_edits,
    stages::{self, MAX_ACTIONS},
};
use crate::{
    append_file::Length,
    clock::{Instant, ThreadTime},
    command_line::command,
    file_names::PICTURES,
    interruption::Signals,
    manifest::Manifest,
    measures::{Measures, Request, Span, requests},
    memory::{self, Demand},
    output::{Existing, Folder, MANIFEST},
    picture_of,
    resumable::{self, CHECKPOINT, Done},
    whole_file::write_lasting,
};

/// End of the last stage while the run continues (time).
const NO_END: f64 = MAX_MAGNITUDE;

/// Latest time of a run, in units of the end that its scene names, and as a share of the largest
/// time of all. Without it a gas that loses energy, whose time continues exponentially, would reach
/// times at which no scene file can name an end, and the run could not be saved.
const MAX_OVERRUN: f64 = 1e30;
const MAX_TIME_SHARE: f64 = 1e-20;

/// An edit and an action of a thermostat are at least this share of the thermostat's interval
/// apart, so that rounding cannot change their order.
const MIN_TIME_APART: f64 = 1e-6;

/// A stage is renewed after this share of the actions of a thermostat that it may have; at half of
/// them the run could not be saved.
const RENEWED_AFTER: f64 = 0.25;

/// Largest number of moves of the instant of an edit: past an action of each thermostat, and the
/// start of a stage of the scene.
const MAX_MOVES: usize = 1000;

/// Why a saved scene has no `run.stop`.
const NO_STOP: &str = "run.stop: a run that is edited while it continues does not end by it";

/// Why a saved run measures nothing.
const NOTHING_MEASURED: &str =
    "all measures: less than a sample interval is left of the stages that are measured";

/// Largest number of parts into which the sample interval of a scene is divided, so that the
/// intervals of added measures are multiples of a part. Larger: many samples for one of few digits.
/// Smaller: more intervals are rounded.
const MAX_PARTS: u32 = 1000;

/// Two intervals are equal if they differ by at most this share: rounding.
const SAME_INTERVAL: f64 = 1e-9;

/// An interval that is no multiple of a part of another is changed by at most this share, if there
/// are parts for that. Larger: measures are sampled at other times than was asked for. Smaller:
/// more samples.
const NEAR_INTERVAL: f64 = 0.01;

/// Largest number of names that are tried for an added measure.
const MAX_NAMES: u32 = 100;

/// Why a saved run is not the run of its scene from the beginning.
const WITHIN_EPOCH: &str = "the bits of a run of the saved scene from its beginning: the state was saved within an \
                            epoch, which takes too long; a resumed run continues from it";

/// Largest number of looks for the end of an epoch, each twice as far ahead: enough for any speed
/// in range.
const MAX_LOOKS: u32 = 400;

/// Longest search for the end of an epoch (by the clock). Longer: an interrupted program does not
/// end within seconds. Shorter: fewer saved runs of large systems have the bits of their scenes.
const MAX_SEARCH: Duration = Duration::from_secs(5);

/// Duration of a piece of a run between two checks of its limit. Longer: the run ends later after a
/// signal. Shorter: large systems are slower, because each piece stores all motions at its end.
const PIECE: Duration = Duration::from_millis(100);

/// How long one call of a method of [`InteractiveRun`] may run. A call that is cut short has run
/// part of its way, and the next one continues from there with the bits of an uncut call.
#[derive(Debug, Clone)]
pub struct CallLimit {
    /// A signal cuts the call short.
    pub signals: Signals,
    /// Longest duration by the clock, exceeded by one piece at most.
    pub longest: Duration,
}

impl Default for CallLimit {
    /// No limit.
    fn default() -> Self {
        Self {
            signals: Signals::default(),
            longest: Duration::MAX,
        }
    }
}

impl CallLimit {
    /// Whether a call that began then must end.
    fn is_over(&self, begun: Instant) -> bool {
        begun.elapsed() >= self.longest || self.signals.check().is_err()
    }
}

/// A simulation with the scene that describes it up to the present.
///
/// A clone is a bookmark: it holds the state and the scene of its time.
#[derive(Debug, Clone)]
pub struct InteractiveRun {
    simulation: AnySimulation,
    /// The scene with the stages so far. The last stage has no end.
    scene: Scene,
    /// The end of the run that the scene names (time).
    until: f64,
    schedule: Peekable<Schedule>,
    /// Index of the present stage.
    stage: usize,
    /// Number of steps of the schedule so far.
    done: u64,
    /// Number of draws of random numbers by thermostats so far.
    actions: u64,
    limit: CallLimit,
    pieces: Pieces,
    /// Processor time of the simulation since its start (seconds).
    seconds: f64,
    /// Measures besides those of the scene, with the time between their samples: a saved run
    /// measures them too.
    watched: Vec<(MeasureSpec, f64)>,
}

/// A run that has been saved.
#[derive(Debug, Clone)]
pub struct Saved {
    /// The time of its checkpoint.
    pub time: f64,
    /// The command that continues from it.
    pub command: String,
    /// The time from which on it measures; `None` if it measures nothing.
    pub measures_from: Option<f64>,
    /// What the saved scene leaves out, with the reason, such as a measure whose bodies are no
    /// longer there.
    pub left_out: Vec<String>,
}

impl InteractiveRun {
    /// Builds the simulation of a scene and makes the edits of its first stage.
    ///
    /// # Errors
    /// The scene is invalid, or does not fit into the memory.
    pub fn new(scene: &Scene) -> Result<Self> {
        Self::new_within(scene, CallLimit::default())
    }

    /// Builds the simulation of a scene and makes the edits of its first stage. The limit holds for
    /// each later call.
    ///
    /// # Errors
    /// Those of [`Self::new`]; a signal has been received.
    pub fn new_within(scene: &Scene, limit: CallLimit) -> Result<Self> {
        scene_file::validate(scene)?;
        Demand::new(scene)?.refuse_unless_fits(memory::available())?;
        let method = Method::try_from(&scene.method).context("[method]")?;
        let mut simulation =
            AnySimulation::with_progress(scene, &method, &mut |_| match limit.signals.check() {
                Ok(()) => ControlFlow::Continue(()),
                Err(_) => ControlFlow::Break(()),
            })?;
        let actions = stage_edits::prepare(&mut simulation, scene, 0)?;
        let (until, mut scene) = (scene.run.until, scene.clone());
        end_at(&mut scene, NO_END);
        let schedule = Schedule::changes(&scene, 0).peekable();
        let pieces = Pieces::new(&simulation.view(), PIECE);
        let mut run = Self {
            simulation,
            scene,
            until,
            schedule,
            stage: 0,
            done: 0,
            actions,
            limit,
            pieces,
            seconds: 0.0,
            watched: Vec::new(),
        };
        // Thermostats of the first stage act at time 0.
        ensure!(
            run.advance(EpochTime::ZERO, &mut ())?,
            "the run was interrupted at its start"
        );
        Ok(run)
    }

    /// Sets the measures that a saved run has besides those of the scene, with the time between
    /// their samples, which they keep there. They begin anew in that run.
    pub fn set_watched(&mut self, watched: Vec<(MeasureSpec, f64)>) {
        self.watched = watched;
    }

    /// The system at the present time.
    pub fn view(&self) -> View<'_> {
        self.simulation.view()
    }

    /// The scene with the stages so far; its end is that of an endless run.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The end of the run that the scene file names (time).
    pub fn until(&self) -> f64 {
        self.until
    }

    /// The elasticity in force.
    pub fn elasticity(&self) -> &ElasticitySpec {
        let mut begun = self.scene.stage.iter().take(self.stage + 1).rev();
        begun
            .find_map(|stage| stage.elasticity.as_ref())
            .unwrap_or(&self.scene.elasticity)
    }

    /// The index of the present stage.
    pub fn stage(&self) -> usize {
        self.stage
    }

    /// The thermostats in force.
    pub fn thermostats(&self) -> &[ThermostatSpec] {
        self.scene
            .stage
            .get(self.stage)
            .map_or(&[], |stage| &stage.thermostat)
    }

    /// Runs to `until`, with the starts of stages and the actions of thermostats on the way;
    /// returns whether `until` has been reached within the limit of a call.
    ///
    /// # Errors
    /// The run cannot continue, `until` is later than a run can be saved, or an edit of the scene
    /// is refused.
    pub fn advance(&mut self, until: EpochTime, observer: &mut dyn Observer) -> Result<bool> {
        let begun = Instant::now();
        let latest = self.latest();
        ensure!(
            until.to_f64() <= latest,
            "the run has reached its latest time, {latest:e}"
        );
        loop {
            let step = self.due(until);
            let target = step.map_or(until, |step| EpochTime::from(step.time));
            while !self.run_piece(target, observer)? {
                if self.limit.is_over(begun) {
                    return Ok(false);
                }
            }
            let Some(step) = step else { return Ok(true) };
            self.take(step, observer)?;
            if self.limit.is_over(begun) {
                return Ok(false);
            }
        }
    }

    /// Runs towards `until`, to the end of the epoch at most, and for about [`PIECE`]; returns
    /// whether `until` has been reached.
    fn run_piece(&mut self, until: EpochTime, observer: &mut dyn Observer) -> Result<bool> {
        let (begun, clock) = (Instant::now(), ThreadTime::now());
        let target = self.pieces.end(self.simulation.time(), until);
        let reached = self.simulation.observe_epoch(target, observer)?;
        self.seconds += clock.elapsed().as_secs_f64();
        let last = begun.elapsed();
        // The end of an epoch cuts a piece short: then its duration is no reason for longer ones.
        if reached || last > PIECE {
            self.pieces.has_taken(last);
        }
        Ok(reached && target == until)
    }

    /// The latest time of the run.
    fn latest(&self) -> f64 {
        (MAX_OVERRUN * self.until)
            .min(MAX_TIME_SHARE * NO_END)
            .max(self.until)
    }

    /// Runs through the next contact, if it happens no later than `until`; returns whether there
    /// was a contact. Without one the run is at `until`, or where the limit of a call ended it.
    ///
    /// # Errors
    /// Those of [`Self::advance`].
    pub fn step(&mut self, until: f64, observer: &mut dyn Observer) -> Result<bool> {
        let begun = Instant::now();
        loop {
            let step = self.due(EpochTime::from(until));
            let target = self.not_past(step.map_or(until, |step| step.time));
            loop {
                let (now, clock) = (self.simulation.time().to_f64(), Instant::now());
                let end = (now + self.pieces.length()).max(now.next_up()).min(target);
                let processor = ThreadTime::now();
                let has_hit = self.simulation.step(end, observer)?;
                self.seconds += processor.elapsed().as_secs_f64();
                if has_hit {
                    return Ok(true);
                }
                self.pieces.has_taken(clock.elapsed());
                if end >= target {
                    break;
                }
                if self.limit.is_over(begun) {
                    return Ok(false);
                }
            }
            let Some(step) = step else { return Ok(false) };
            self.take(step, observer)?;
            if self.limit.is_over(begun) {
                return Ok(false);
            }
        }
    }

    /// This time, or the present if it is past: instants of one time differ by the rounding of the
    /// schedule.
    fn not_past(&self, time: f64) -> f64 {
        let now = self.simulation.time().to_f64();
        if time < now { now } else { time }
    }

    /// The next step of the schedule, if it is not after `until`.
    fn due(&mut self, until: EpochTime) -> Option<ScheduledStep> {
        self.schedule
            .peek()
            .copied()
            .filter(|step| EpochTime::from(step.time) <= until)
    }

    /// Takes a step of the schedule at the present time.
    fn take(&mut self, step: ScheduledStep, observer: &mut dyn Observer) -> Result<()> {
        observer.pause(&self.simulation.view());
        let actions =
            stage_edits::change(&mut self.simulation, &self.scene, step.what, self.actions);
        observer.start(&self.simulation.view());
        self.actions += actions?;
        if let What::Stage(stage) = step.what {
            self.stage = stage;
        }
        self.pieces = Pieces::new(&self.simulation.view(), PIECE);
        self.schedule.next();
        self.done += 1;
        Ok(())
    }

    /// Begins a stage with these edits, all or none, and returns its start: the present time, or a
    /// little later, so that the instant is a number of the scene file and no thermostat acts at
    /// it. The stage has the thermostats `hold`, or continues with those in force.
    ///
    /// # Errors
    /// The edit that is refused, with its entry; then neither the system nor the scene is changed.
    /// The run to the time of the edit exceeds the limit of a call; it has then gone part of the
    /// way.
    pub fn edit(
        &mut self,
        edit: &StageSpec,
        hold: Option<&[ThermostatSpec]>,
        observer: &mut dyn Observer,
    ) -> Result<f64> {
        ensure!(
            edit.until == 0.0 && edit.measure && edit.thermostat.is_empty(),
            "an edit begins now and lasts until the next: it has no `until`, `measure` or `thermostat`"
        );
        let start = self.settle(observer)?;
        // On a clone: a refused edit must not use up numbers of bodies.
        let mut edited = self.clone();
        let present = edited.start_stage(start, edit, hold);
        let shown = edited.ending_after(start)?;
        stages::check(&shown)?;
        stages::refuse_unknown_tags(&shown, tags(&shown))?;
        edited.actions += stage_edits::start(
            &mut edited.simulation,
            &edited.scene,
            present,
            edited.actions,
        )?;
        edited.stage = present;
        edited.schedule = Schedule::changes(&edited.scene, present).peekable();
        let begun = edited.schedule.next();
        debug_assert_eq!(begun.map(|step| step.what), Some(What::Stage(present)));
        edited.done = self.done + 1;
        // No contact happens: the thermostats act at the start of the stage.
        edited.limit = CallLimit::default();
        edited.advance(EpochTime::from(start), &mut ())?;
        edited.limit = self.limit.clone();
        edited.pieces = Pieces::new(&edited.simulation.view(), PIECE);
        observer.pause(&self.simulation.view());
        observer.start(&edited.simulation.view());
        *self = edited;
        Ok(start)
    }

    /// Begins a stage without edits if a thermostat has acted so often in the present one that a
    /// scene file could soon not name its end; returns whether it has.
    ///
    /// # Errors
    /// Those of [`Self::edit`].
    pub fn renew(&mut self, observer: &mut dyn Observer) -> Result<bool> {
        let (start, _) = spans(&self.scene.stage).nth(self.stage).unwrap_or_default();
        let lasts = self.simulation.time().to_f64() - start;
        let most = RENEWED_AFTER * MAX_ACTIONS;
        let is_long = self
            .thermostats()
            .iter()
            .any(|thermostat| lasts > most * thermostat.every);
        if is_long {
            self.edit(&StageSpec::default(), None, observer)?;
        }
        Ok(is_long)
    }

    /// Whether stages of the scene or thermostats still change the system.
    pub fn has_changes_ahead(&self) -> bool {
        self.stage + 1 < self.scene.stage.len() || !self.thermostats().is_empty()
    }

    /// Runs to the next time at which a stage can begin, and returns it.
    fn settle(&mut self, observer: &mut dyn Observer) -> Result<f64> {
        let now = self.simulation.time();
        let mut time = now.to_f64();
        if EpochTime::from(time) < now {
            time = time.next_up();
        }
        let begun = Instant::now();
        for _ in 0..MAX_MOVES {
            let reached = self.advance(EpochTime::from(time), observer)?;
            ensure!(
                reached && !self.limit.is_over(begun),
                "an edit can be made at t = {time:e}, but the run has come only to t = {:e} in {:.1} s: let it run \
                 on, and try again",
                self.simulation.time().to_f64(),
                begun.elapsed().as_secs_f64()
            );
            // Which may have begun a stage of the scene.
            match self.next_free(time) {
                free if free == time => return Ok(time),
                free => time = free,
            }
        }
        bail!("thermostats act too often for an edit between them")
    }

    /// This time, or a later one that the present stage leaves free.
    fn next_free(&self, time: f64) -> f64 {
        let span = spans(&self.scene.stage).nth(self.stage);
        let (start, end) = span.unwrap_or((0.0, NO_END));
        if time <= start {
            return start.next_up();
        }
        for thermostat in self.thermostats() {
            let steps = (time - start) / thermostat.every;
            // The action at the start of the stage is before any later edit without rounding.
            if steps.round() >= 1.0 && (steps - steps.round()).abs() < MIN_TIME_APART {
                return time
                    .next_up()
                    .max(start + (steps.round() + 2.0 * MIN_TIME_APART) * thermostat.every);
            }
        }
        // The scene itself begins a stage there.
        if time < end && time + MIN_TIME_APART * (end - start) >= end && end < NO_END {
            end
        } else {
            time
        }
    }

    /// Puts a stage behind the present one, which ends at `start`; returns its index.
    fn start_stage(
        &mut self,
        start: f64,
        edit: &StageSpec,
        hold: Option<&[ThermostatSpec]>,
    ) -> usize {
        if self.scene.stage.is_empty() {
            self.scene.run.measure_from = 0.0.into();
            self.scene.stage.push(StageSpec {
                until: NO_END,
                ..StageSpec::default()
            });
        }
        let present = &mut self.scene.stage[self.stage];
        let StageSpec {
            until,
            measure,
            thermostat,
            ..
        } = present.clone();
        present.until = start;
        let thermostat = hold.map_or(thermostat, <[_]>::to_vec);
        self.scene.stage.insert(
            self.stage + 1,
            StageSpec {
                until,
                measure,
                thermostat,
                ..edit.clone()
            },
        );
        self.stage + 1
    }

    /// Writes the run into an empty folder or a new one, as `carom run` would have left it at the
    /// end of the present epoch. The run itself does not change. The files are written into a
    /// folder beside it, `path` with the ending `.part`, which is then renamed: `path` never holds
    /// a part of a run.
    ///
    /// # Errors
    /// A file cannot be written, or `path` holds files; a thermostat has acted more often than a
    /// scene file allows (see [`Self::renew`]); the run cannot continue.
    pub fn save(&self, path: &Path) -> Result<Saved> {
        self.save_with(path, &MeasuredBefore::default())
    }

    /// Writes the run like [`Self::save`], and `measured` into a folder inside, [`MEASURED`]. Its
    /// series in time continue in the saved run.
    ///
    /// # Errors
    /// Those of [`Self::save`].
    pub fn save_with(&self, path: &Path, measured: &MeasuredBefore) -> Result<Saved> {
        let (saved, scene, files) = self.saved_at(path, measured)?;
        claim(path)?;
        let aside = beside(path);
        let written = write(&aside, &scene, &saved.command, &files).and_then(|()| {
            publish(&aside, path).with_context(|| format!("cannot write {}", path.display()))
        });
        if written.is_err() {
            // A partial run is useless; failures to remove it are ignored, and files of others
            // stay.
            let _ = fs::remove_dir_all(&aside);
            let _ = fs::remove_dir(path);
        }
        written?;
        Ok(saved)
    }

    /// The files that [`Self::save_with`] would write, by name, without writing any. `path` is the
    /// folder of the command that continues from them.
    ///
    /// # Errors
    /// A thermostat has acted more often than a scene file allows (see [`Self::renew`]); the run
    /// cannot continue.
    pub fn files(&self, path: &Path, measured: &MeasuredBefore) -> Result<(Saved, Vec<NamedFile>)> {
        let (saved, scene, SavedFiles { run, inner }) = self.saved_at(path, measured)?;
        let listed = run.iter().map(|(name, _)| name.clone());
        let listed = listed.filter(|name| name != CHECKPOINT);
        let names = listed.chain([MANIFEST.to_owned()]).collect();
        let manifest = Manifest::new(&saved.command, &[&scene], None).text_with(names)?;
        let inner = inner
            .into_iter()
            .map(|(name, content)| (format!("{MEASURED}/{name}"), content));
        let files = std::iter::once((MANIFEST.to_owned(), manifest.into_bytes()))
            .chain(run)
            .chain(inner);
        Ok((saved, files.collect()))
    }

    /// The run at the end of the present epoch: what it is called in the folder `path`, its scene,
    /// and its files.
    fn saved_at(
        &self,
        path: &Path,
        measured: &MeasuredBefore,
    ) -> Result<(Saved, Scene, SavedFiles)> {
        let mut ahead = self.clone();
        let (state, mut left_out) = match ahead.run_to_end_of_epoch()? {
            Some(state) => (state, Vec::new()),
            None => (
                ahead.simulation.end_epoch_here(),
                vec![WITHIN_EPOCH.to_owned()],
            ),
        };
        let time = state.time();
        let mut scene = ahead.ending_after(time.to_f64())?;
        let (unkept, mut continued) = add_measures(&mut scene, &self.watched);
        left_out.extend(unkept);
        left_out.extend(leave_out_measures(&mut scene, &ahead.simulation.view()));
        left_out.extend(self.scene.run.stop.as_ref().map(|_| NO_STOP.to_owned()));
        let is_measured = |scene: &Scene| scene.stage.iter().any(|stage| stage.measure);
        if is_measured(&self.scene) && !is_measured(&scene) {
            left_out.push(NOTHING_MEASURED.to_owned());
        }
        scene_file::validate(&scene)?;
        let requests = requests(&scene)?;
        for measure in &mut continued {
            *measure = measure.take().filter(|measure| measure.is_among(&requests));
        }
        let EarlierFiles { inner, growing } = measured.saved_files(&continued)?;
        let scene_file = path.join("config.toml");
        let command = command([
            "run".as_ref(),
            scene_file.as_os_str(),
            "--out".as_ref(),
            path.as_os_str(),
            "--resume".as_ref(),
        ]);
        let run = ahead.files_of(&scene, &state, self.seconds_until(&ahead), growing)?;
        let (from, _) = stages::window(&scene);
        let measures_any = !scene.run.observe.is_empty() || !scene.measure.is_empty();
        let measures_from = (measures_any && from.is_finite()).then(|| from.max(time.to_f64()));
        let saved = Saved {
            time: time.to_f64(),
            command,
            measures_from,
            left_out,
        };
        Ok((saved, scene, SavedFiles { run, inner }))
    }

    /// The processor time for the collisions until a later state, at the rate so far (seconds). The
    /// time that the way there took would differ between two saves of one state.
    fn seconds_until(&self, ahead: &Self) -> f64 {
        let [now, then] = [self, ahead].map(|run| run.view().counters().collisions);
        if now == 0 {
            self.seconds
        } else {
            self.seconds * then as f64 / now as f64
        }
    }

    /// The files of the run of `scene` without the manifest, in the order in which they are
    /// written; the last is a checkpoint of this state, which took this processor time (seconds).
    /// The run appends to the files `growing`.
    fn files_of(
        &self,
        scene: &Scene,
        state: &Checkpoint,
        seconds: f64,
        growing: Vec<NamedFile>,
    ) -> Result<Vec<NamedFile>> {
        let view = self.simulation.view();
        let mut measures = Measures::new(scene, &view)?;
        measures.start(&view);
        let done = self.done_of(scene, state.time());
        let mut files = Vec::new();
        if let Some(frame) = &scene.start.snapshot {
            files.push((START.to_owned(), frame.as_bytes().to_vec()));
        }
        files.push(("config.toml".to_owned(), scene.to_toml().into_bytes()));
        files.push((
            PICTURES[0].to_owned(),
            picture_of(&view, PICTURE).into_bytes(),
        ));
        let length = |(name, rows): &NamedFile| Length::of_earlier_rows(name, rows);
        let lengths = growing.iter().map(length).collect();
        files.extend(growing);
        let (what, until) = (describe(scene, None), scene.run.until);
        let checkpoint =
            resumable::encode_going(&what, until, done, state, seconds, &measures, lengths)?;
        files.push((CHECKPOINT.to_owned(), checkpoint));
        Ok(files)
    }

    /// Runs to the end of the epoch, or through the edit that ends it, and returns the state;
    /// `None`
    /// if that takes too long.
    fn run_to_end_of_epoch(&mut self) -> Result<Option<Checkpoint>> {
        let begun = Instant::now();
        let mut span = self.until;
        for _ in 0..MAX_LOOKS {
            let far = self.simulation.time().after(span);
            let step = self.due(far);
            let target = step.map_or(far, |step| EpochTime::from(step.time));
            loop {
                if let Some(state) = self.simulation.checkpoint() {
                    return Ok(Some(state));
                }
                if begun.elapsed() > MAX_SEARCH {
                    return Ok(None);
                }
                if self.run_piece(target, &mut ())? {
                    break;
                }
            }
            if let Some(step) = step {
                self.take(step, &mut ())?;
            }
            span = (2.0 * span).min(NO_END);
        }
        // Nothing moves: the end of an epoch changes no bit.
        Ok(Some(self.simulation.end_epoch_here()))
    }

    /// The scene with an end after `time`, as a file describes it. Only what follows the present is
    /// measured, if that is as long as a sample interval; no rule ends the run before.
    fn ending_after(&self, time: f64) -> Result<Scene> {
        let mut scene = self.scene.clone();
        let run = &mut scene.run;
        let until = if time < self.until {
            self.until
        } else {
            time + self.until
        };
        let mut until = until.max(time * (1.0 + 1e-9));
        let (start, _) = spans(&scene.stage).last().unwrap_or_default();
        if !scene.stage.is_empty() {
            // The last stage is measured. Below, the interval of samples may be lengthened to the
            // shortest for this end.
            let interval = run.sample_interval.max(until / (0.4 * MAX_SAMPLES));
            until = until.max(start + 1.5 * interval);
        }
        for thermostat in scene
            .stage
            .last()
            .map_or(&[][..], |stage| &stage.thermostat)
        {
            until = until.min(start + 0.5 * MAX_ACTIONS * thermostat.every);
        }
        ensure!(
            until > time,
            "a thermostat has acted more than {:e} times since the last edit: make an edit first",
            0.5 * MAX_ACTIONS
        );
        // Longer than the scene file says: fewer samples.
        let shortest = shortest_interval(until);
        run.sample_interval = run.sample_interval.max(shortest);
        run.snapshot_interval = run.snapshot_interval.map(|interval| interval.max(shortest));
        run.check_interval = run.check_interval.map(|interval| interval.max(shortest));
        run.animation_from = run.animation_from.max(time.next_up());
        run.animation &= run.animation_from < until;
        if !run.animation {
            run.animation_from = 0.0;
        }
        for stage in scene.stage.iter_mut().take(self.stage) {
            stage.measure = false;
        }
        end_at(&mut scene, until);
        scene.run.stop = None;
        if !scene.stage.is_empty() && !stages::is_sampled(&scene) {
            // No edit is refused because the measured stages are nearly over.
            scene
                .stage
                .iter_mut()
                .for_each(|stage| stage.measure = false);
        }
        Ok(scene)
    }

    /// The steps of the finite scene that lie behind a checkpoint at `time`: all up to the last
    /// change, and later observations up to `time`.
    fn done_of(&self, scene: &Scene, time: EpochTime) -> Done {
        let mut done = Done {
            actions: self.actions,
            ..Done::default()
        };
        let mut changes = 0;
        for step in Schedule::new(scene) {
            let is_change = matches!(step.what, What::Stage(_) | What::Thermostat { .. });
            let is_behind = changes < self.done || !is_change && EpochTime::from(step.time) <= time;
            if !is_behind {
                break;
            }
            changes += u64::from(is_change);
            if step.what == What::Sample {
                done.samples += 1;
            } else {
                done.steps += 1;
            }
        }
        done
    }
}

/// The files of a saved run.
struct SavedFiles {
    /// In its folder, without the manifest.
    run: Vec<NamedFile>,
    /// In the folder [`MEASURED`] inside.
    inner: Vec<NamedFile>,
}

/// Writes the files of a run, with its manifest, into a new folder.
fn write(path: &Path, scene: &Scene, command: &str, files: &SavedFiles) -> Result<()> {
    let (folder, _lock) = Folder::claim(path, Existing::Refuse)?;
    Manifest::write_new(&folder, command, &[scene])?;
    if !files.inner.is_empty() {
        // Not listed: a run that continues here removes and replaces what is.
        let inner = folder.unlisted(MEASURED)?;
        for (name, content) in &files.inner {
            inner.write_lasting(name, content)?;
        }
    }
    for (name, content) in &files.run {
        if name == CHECKPOINT {
            // A state is not listed.
            write_lasting(&path.join(name), &[content])?;
        } else {
            folder.write_lasting(name, content)?;
        }
    }
    Ok(())
}

/// Creates a folder, or takes an empty one.
fn claim(path: &Path) -> Result<()> {
    if let Some(parent) = path.parent() {
        fs::create_dir_all(parent)
            .with_context(|| format!("cannot create the folder {}", parent.display()))?;
    }
    match fs::create_dir(path) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            let is_empty = fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_none());
            ensure!(
                is_empty,
                "{} holds files already: nothing is overwritten",
                path.display()
            );
            Ok(())
        }
        created => created.with_context(|| format!("cannot create the folder {}", path.display())),
    }
}

/// The folder in which a run is written before it is complete; one that a killed program has left
/// there is removed.
fn beside(path: &Path) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(".part");
    let aside = PathBuf::from(name);
    // If it cannot be removed, the run cannot be written there, which is reported.
    let _ = fs::remove_dir_all(&aside);
    aside
}

/// Renames a complete folder to an empty one.
fn publish(aside: &Path, path: &Path) -> io::Result<()> {
    if cfg!(windows) {
        // Only POSIX systems replace an empty folder.
        fs::remove_dir(path)?;
    }
    fs::rename(aside, path)?;
    // Flushes the folder entry too, where folders can be opened.
    if let Some(Ok(folder)) = path.parent().map(File::open) {
        folder.sync_all()?;
    }
    Ok(())
}

/// Removes the measures that cannot begin with these bodies; returns each with the reason.
fn leave_out_measures(scene: &mut Scene, view: &View<'_>) -> Vec<String> {
    let alone = Scene {
        run: RunSpec {
            observe: Vec::new(),
            ..scene.run.clone()
        },
        measure: Vec::new(),
        ..scene.clone()
    };
    let mut left_out = Vec::new();
    let mut can_begin = |only: &Scene| {
        let begun = Measures::new(only, view);
        left_out.extend(begun.as_ref().err().map(|error| format!("{error:#}")));
        begun.is_ok()
    };
    scene.run.observe.retain(|name| {
        let run = RunSpec {
            observe: vec![name.clone()],
            ..alone.run.clone()
        };
        can_begin(&Scene {
            run,
            ..alone.clone()
        })
    });
    scene.measure.retain(|spec| {
        can_begin(&Scene {
            measure: vec![spec.clone()],
            ..alone.clone()
        })
    });
    left_out
}

/// The shortest interval of samples in a saved scene that ends at `until` (time).
fn shortest_interval(until: f64) -> f64 {
    until / (0.5 * MAX_SAMPLES)
}

/// Adds measures to a scene, each with the time between its samples; those that it has already are
/// left out. The sample interval of the scene is divided where that is needed, and its own measures
/// keep theirs. Returns what cannot be kept, with the reason, and for each measure the one that
/// stands for it in the scene.
fn add_measures(
    scene: &mut Scene,
    measures: &[(MeasureSpec, f64)],
) -> (Vec<String>, Vec<Option<ContinuedMeasure>>) {
    let intervals: Vec<f64> = measures
        .iter()
        .map(|(spec, interval)| interval * samples_apart(spec))
        .collect();
    let most = (scene.run.sample_interval / shortest_interval(scene.run.until)) as u32;
    let parts = parts(
        scene.run.sample_interval,
        &intervals,
        most.clamp(1, MAX_PARTS),
    );
    if let Err(error) = divide_samples(scene, parts) {
        let reason = format!("the added measures: {error:#}");
        return (vec![reason], vec![None; measures.len()]);
    }
    let (mut left_out, mut continued) = (Vec::new(), Vec::new());
    for ((spec, _), interval) in measures.iter().zip(intervals) {
        let name = match &spec.of {
            Some(of) => format!("{}:{of}", spec.kind),
            None => spec.kind.clone(),
        };
        let every = (interval / scene.run.sample_interval).round().max(1.0);
        let mut spec = spec.clone();
        spec.parameters.remove("interval");
        spec.parameters
            .insert("every".to_owned(), MeasureParameter::Number(every));
        match add_measure(scene, spec) {
            Ok(measure) => continued.push(Some(measure)),
            Err(error) => {
                left_out.push(format!("{name}: {error:#}"));
                continued.push(None);
                continue;
            }
        }
        let saved = every * scene.run.sample_interval;
        if (saved / interval - 1.0).abs() > SAME_INTERVAL {
            left_out.push(format!(
                "{name}: its sample interval of {interval}; it is {saved} in the saved run, a multiple of \
                 run.sample_interval"
            ));
        }
    }
    (left_out, continued)
}

/// Samples of a run for one sample of a measure.
fn samples_apart(spec: &MeasureSpec) -> f64 {
    match spec.parameters.get("every") {
        Some(MeasureParameter::Number(every)) => *every,
        _ => 1.0,
    }
}

/// The smallest number of parts of an interval, up to `most`, of which all the others are
/// multiples: up to rounding, or else nearly. `most` if there is none.
fn parts(interval: f64, others: &[f64], most: u32) -> u32 {
    let fits = |parts: u32, share: f64| {
        others.iter().all(|other| {
            let ratio = other * f64::from(parts) / interval;
            ratio.round() >= 1.0 && (ratio - ratio.round()).abs() <= share * ratio
        })
    };
    let find = |share: f64| (1..=most).find(|&parts| fits(parts, share));
    find(SAME_INTERVAL)
        .or_else(|| find(NEAR_INTERVAL))
        .unwrap_or(most)
}

/// Divides the sample interval of a scene; its measures, snapshots and checks keep their times.
///
/// # Errors
/// A measure of the scene is invalid.
fn divide_samples(scene: &mut Scene, parts: u32) -> Result<()> {
    if parts == 1 {
        return Ok(());
    }
    let requests = requests(scene)?;
    let is_sampled = |request: &Request| request.kind.span != Span::EveryContact;
    let (of_names, of_specs) = requests.split_at(scene.run.observe.len());
    let names = std::mem::take(&mut scene.run.observe);
    let mut measures = Vec::new();
    for (name, request) in names.into_iter().zip(of_names) {
        if is_sampled(request) {
            let tags = request.tags.join(",");
            measures.push(MeasureSpec {
                kind: request.kind.name.to_owned(),
                of: (!tags.is_empty()).then_some(tags),
                ..MeasureSpec::default()
            });
        } else {
            scene.run.observe.push(name);
        }
    }
    let sampled = of_names.iter().filter(|request| is_sampled(request));
    let requests: Vec<&Request> = sampled.chain(of_specs).collect();
    measures.append(&mut scene.measure);
    for (spec, request) in measures.iter_mut().zip(requests) {
        if is_sampled(request) && !spec.parameters.contains_key("interval") {
            let every = f64::from(parts) * samples_apart(spec);
            let every = MeasureParameter::Number(every);
            spec.parameters.insert("every".to_owned(), every);
        }
    }
    scene.measure = measures;
    let run = &mut scene.run;
    let interval = run.sample_interval;
    if run.snapshots.is_some() {
        run.snapshot_interval.get_or_insert(interval);
    }
    run.check_interval.get_or_insert(interval);
    run.sample_interval = interval / f64::from(parts);
    Ok(())
}

/// Adds a measure to a scene, under a name of its own if another one would write the same files;
/// one that the scene has already is left out. Returns the measure that stands for it.
///
/// # Errors
/// The measure is invalid in this scene.
fn add_measure(scene: &mut Scene, spec: MeasureSpec) -> Result<ContinuedMeasure> {
    let base = [spec.name.as_deref(), spec.of.as_deref()]
        .into_iter()
        .flatten()
        .next()
        .map_or_else(String::new, |word| format!("{}-", word.replace(',', "-")));
    let name = spec.name.clone();
    let last = scene.measure.len();
    scene.measure.push(spec);
    let refused = match requests(scene) {
        Ok(requests) => {
            let added = &requests[requests.len() - 1];
            return Ok(ContinuedMeasure::new(name, added, added));
        }
        Err(error) => error,
    };
    for number in 1..=MAX_NAMES {
        scene.measure[last].name = Some(format!("{base}live-{number}"));
        let Ok(requests) = requests(scene) else {
            continue;
        };
        let Some((added, others)) = requests.split_last() else {
            continue;
        };
        let same = others.iter().find(|other| has_same_results(added, other));
        let measure = ContinuedMeasure::new(name, added, same.unwrap_or(added));
        if same.is_some() {
            scene.measure.pop();
        }
        return Ok(measure);
    }
    scene.measure.pop();
    Err(refused)
}

/// Whether two measures differ in their names alone.
fn has_same_results(one: &Request, other: &Request) -> bool {
    let given = |request: &Request| {
        let mut given = request.given.clone();
        given.retain(|key, _| key != "every" && key != "interval");
        given
    };
    one.kind.name == other.kind.name
        && one.tags == other.tags
        && one.every == other.every
        && given(one) == given(other)
}

/// Ends the run and its last stage at `until`.
fn end_at(scene: &mut Scene, until: f64) {
    scene.run.until = until;
    if let Some(last) = scene.stage.last_mut() {
        last.until = until;
    }
}
