//! The owner of the simulation: it runs it in pieces, makes what commands request between them, and
//! sends frames, the state of the run, and measures.

use std::{sync::Arc, time::Duration};

use anyhow::{Context, Result, anyhow, ensure};
use carom::{
    BodyKey, CollisionReport, EpochTime, Observer, Scene, View,
    engine::{Body, StageSpec},
};
use carom_methods::Method;
#[cfg(feature = "server")]
use carom_runs::run::interactive::MeasuredBefore;
use carom_runs::{
    clock::{Instant, ThreadTime},
    interruption::Signals,
    measures::{SingleMeasure, Tracked},
    run::interactive::{CallLimit, InteractiveRun},
};
use serde_json::{Value, json};

#[cfg(feature = "server")]
use crate::run_store::RunState;
use crate::{
    body_list::BodyList,
    follower::Follower,
    frame::{self, FrameLabel},
    gallery,
    heating::Heating,
    measured_files::measured_before,
    pace::{FRAME, Pace},
    protocol::{
        LiveAnswer, LiveCommand, LiveEdit, LiveRequest, MAX_CONTACTS, MAX_EDITS, MeasureRequest,
        SceneText, VisibleWindow,
    },
    report::{self, MeasuredNow, StateWatch},
    rules,
    run_store::RunStore,
    viewers::{Viewer, Viewers, json as text_of},
};

/// Longest pause without a look at signals.
const LOOK: Duration = Duration::from_millis(20);

/// Longest time in which samples are taken without a look at commands.
const MAX_SAMPLING_TIME: Duration = Duration::from_millis(50);

/// Time between two reports of the state, and of the measures.
const STATUS: Duration = Duration::from_millis(250);
const MEASURES: Duration = Duration::from_millis(500);

/// Largest share of the time that reports of the state, and of the measures, take.
const SHARE_OF_REPORTS: f64 = 0.015;

/// Most measures at one time, and samples of each: they bound the memory.
const MAX_MEASURES: usize = 16;
const MAX_SAMPLES: u64 = 200_000;

/// Longest time of one call of the engine, of steps from contact to contact, and of the way to the
/// time of an edit. Longer: pages stand still. Shorter: fewer steps at one time.
const MAX_CALL: Duration = Duration::from_secs(2);

/// A request, and the page that it came from.
#[derive(Debug)]
pub struct Message {
    /// Number of the page.
    pub viewer: u64,
    /// What it requests.
    pub request: LiveRequest,
}

/// What observes the run.
#[derive(Default)]
struct Watching {
    measures: Vec<MeasuredNow>,
    /// The body that each page has chosen, by the number of the page.
    followers: Vec<(u64, Follower)>,
}

impl Watching {
    fn active(&self) -> impl Iterator<Item = &Tracked> {
        self.measures
            .iter()
            .map(|measured| &measured.tracked)
            .filter(|tracked| tracked.is_active)
    }

    fn followers(&mut self) -> impl Iterator<Item = &mut Follower> {
        self.followers.iter_mut().map(|(_, follower)| follower)
    }

    /// What this page has chosen.
    fn follower_of(&self, viewer: u64) -> Option<&Follower> {
        self.followers
            .iter()
            .find(|(of, _)| *of == viewer)
            .map(|(_, follower)| follower)
    }

    /// The number of the body that this page has chosen.
    fn chosen_by(&self, viewer: u64) -> Option<BodyKey> {
        self.follower_of(viewer).and_then(Follower::chosen)
    }

    /// The time of the next sample, but not after `until`.
    fn next_sample(&self, until: EpochTime) -> EpochTime {
        self.active()
            .map(Tracked::time)
            .fold(until, |first, time| if time < first { time } else { first })
    }

    /// Takes the samples that are due.
    fn sample(&mut self, view: &View<'_>) {
        for MeasuredNow { tracked, .. } in &mut self.measures {
            if tracked.is_due(view.time()) {
                tracked.sample(view);
                tracked.is_active = tracked.samples() < MAX_SAMPLES;
            }
        }
    }
}

impl Observer for Watching {
    fn watches_any(&self) -> bool {
        self.followers
            .iter()
            .any(|(_, follower)| follower.watches_any())
            || self.active().any(|tracked| tracked.measure.watches_any())
    }

    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.followers
            .iter()
            .any(|(_, follower)| follower.watches(bodies))
            || self.active().any(|tracked| tracked.measure.watches(bodies))
    }

    fn start(&mut self, view: &View<'_>) {
        self.followers().for_each(|follower| follower.start(view));
        for MeasuredNow { tracked, .. } in &mut self.measures {
            tracked.measure.start(view);
        }
    }

    fn pause(&mut self, view: &View<'_>) {
        for MeasuredNow { tracked, .. } in &mut self.measures {
            tracked.measure.pause(view);
        }
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.followers()
            .for_each(|follower| follower.collision(report));
        for MeasuredNow { tracked, .. } in &mut self.measures {
            if tracked.is_active {
                tracked.measure.collision(report);
            }
        }
    }
}

/// An open scene.
struct Bench {
    name: String,
    /// The scene file.
    text: String,
    run: InteractiveRun,
    bookmark: Option<InteractiveRun>,
    watching: Watching,
    pace: Pace,
    watch: StateWatch,
    body_list: BodyList,
    /// The stage to which the list of bodies belongs.
    stage: usize,
    is_playing: bool,
    /// Why the run cannot continue.
    error: Option<String>,
}

impl Bench {
    fn new(name: String, scene: &Scene, version: u32, signals: Signals) -> Result<Self> {
        let limit = CallLimit {
            signals,
            longest: MAX_CALL,
        };
        let run = InteractiveRun::new_within(scene, limit)
            .with_context(|| format!("the scene {name:?}"))?;
        let view = run.view();
        let (pace, watch) = (Pace::new(&view, None), StateWatch::new(&view));
        let body_list = BodyList::new(version, &name, method(scene), &view);
        let stage = run.stage();
        Ok(Self {
            name,
            text: scene.to_toml(),
            run,
            bookmark: None,
            watching: Watching::default(),
            pace,
            watch,
            body_list,
            stage,
            is_playing: false,
            error: None,
        })
    }

    fn now(&self) -> f64 {
        self.run.view().time().to_f64()
    }

    /// What distinguishes this state of the run from others.
    #[cfg(feature = "server")]
    fn state(&self) -> RunState {
        let view = self.run.view();
        (
            view.time(),
            view.counters().collisions,
            self.body_list.version,
        )
    }

    /// The bodies, or the run itself, have changed.
    fn has_changed(&mut self) {
        let view = self.run.view();
        self.body_list = BodyList::new(
            self.body_list.version + 1,
            &self.name,
            method(self.run.scene()),
            &view,
        );
        self.pace.restart(&view);
        self.stage = self.run.stage();
        for measured in &mut self.watching.measures {
            measured.tracked.is_disturbed = true;
        }
    }

    /// Runs one piece, for a frame that is due then; returns whether the run is ahead of its clock.
    fn run_piece(&mut self, next_frame: Instant) -> bool {
        let (begun, now) = (Instant::now(), self.now());
        let target = self
            .pace
            .target(now, next_frame.saturating_duration_since(begun));
        if target <= now {
            return true;
        }
        let collisions = self.run.view().counters().collisions;
        let ran = self
            .run_to(EpochTime::from(target))
            .and_then(|()| self.run.renew(&mut self.watching));
        let wall = begun.elapsed();
        self.watch.has_run(wall);
        self.pace.has_taken(self.now() - now, wall);
        let view = self.run.view();
        let rests = view.counters().collisions == collisions
            && !self.run.has_changes_ahead()
            && view.bodies().all(|body| body.energy() == 0.0);
        match ran {
            Err(error) => self.stop(&error),
            Ok(_) if rests => self.stop(&anyhow!("no body moves")),
            Ok(_) => {}
        }
        false
    }

    /// Runs to a time, or less far if that takes long.
    fn run_to(&mut self, target: EpochTime) -> Result<()> {
        let begun = Instant::now();
        loop {
            let end = self.watching.next_sample(target);
            if !self.run.advance(end, &mut self.watching)? {
                return Ok(());
            }
            self.watching.sample(&self.run.view());
            if end >= target || begun.elapsed() > MAX_SAMPLING_TIME {
                return Ok(());
            }
        }
    }

    /// Runs through so many contacts, or fewer if that takes long or a signal is received; returns
    /// how many there were.
    fn step(&mut self, contacts: u32, signals: &Signals) -> Result<u32> {
        let begun = Instant::now();
        let last = self.now() + self.run.until();
        for done in 0..contacts {
            loop {
                let end = self.watching.next_sample(EpochTime::from(last));
                let has_hit = self.run.step(end.to_f64(), &mut self.watching)?;
                let is_over = begun.elapsed() > MAX_CALL || signals.check().is_err();
                if has_hit && !is_over {
                    break;
                }
                if is_over {
                    return Ok(done + u32::from(has_hit));
                }
                // The time of a sample need not be one number.
                if self.run.advance(end, &mut self.watching)? {
                    self.watching.sample(&self.run.view());
                }
                if end >= EpochTime::from(last) {
                    return Ok(done);
                }
            }
        }
        Ok(contacts)
    }

    /// Stops, and runs through so many contacts.
    fn pass_contacts(&mut self, contacts: u32, signals: &Signals) -> Result<Value> {
        ensure!(
            (1..=MAX_CONTACTS).contains(&contacts),
            "a step has from 1 to {MAX_CONTACTS} contacts, not {contacts}"
        );
        self.is_playing = false;
        let (begun, last) = (Instant::now(), self.now() + self.run.until());
        let done = self
            .step(contacts, signals)
            .inspect_err(|error| self.stop(error))?;
        let (now, seconds) = (self.now(), begun.elapsed().as_secs_f64());
        ensure!(
            done > 0 || now >= last,
            "there was no contact until t = {now}, in {seconds:.1} s: try again"
        );
        ensure!(done > 0, "there was no contact until t = {now}");
        Ok(json!({ "contacts": done, "time": self.now() }))
    }

    /// Chooses the body whose contacts a page shows.
    fn choose(&mut self, viewer: u64, id: Option<u64>) -> Result<Value> {
        let (view, key) = (self.run.view(), id.map(BodyKey::of_id));
        let is_there = key.is_none_or(|key| view.body(key).is_some());
        ensure!(is_there, "there is no body {}", id.unwrap_or(0));
        self.watching.followers.retain(|(of, _)| *of != viewer);
        if key.is_some() {
            let mut follower = Follower::default();
            follower.choose(key, &view);
            self.watching.followers.push((viewer, follower));
        }
        Ok(key.map_or(Value::Null, |key| about(&view, key)))
    }

    /// Makes an edit; returns its time, and sentences for the user.
    fn edit(&mut self, edit: &LiveEdit) -> Result<(f64, Vec<String>)> {
        let elasticity = rules::elasticity(&self.run, edit)?;
        let hold = rules::thermostats(&self.run, edit)?;
        let stage = StageSpec {
            elasticity,
            ..edit.stage.clone()
        };
        let Heating { stage, notes } = Heating::new(&self.run, &stage, hold.as_deref())?;
        let time = self.run.edit(&stage, hold.as_deref(), &mut self.watching)?;
        Ok((time, notes))
    }

    /// Goes back to the bookmark.
    fn go_back(&mut self) -> Result<Value> {
        self.run = self.bookmark.clone().context("there is no bookmark")?;
        // Measures of a course that has not happened mean nothing.
        self.watching.measures.clear();
        self.keep_measures();
        let view = self.run.view();
        self.watching
            .followers()
            .for_each(|follower| follower.restart(&view));
        self.watch = StateWatch::new(&self.run.view());
        self.error = None;
        self.has_changed();
        Ok(json!({ "time": self.now() }))
    }

    /// Lets a saved run have the present measures.
    fn keep_measures(&mut self) {
        let watched = self.watching.measures.iter();
        let watched = watched.map(|one| (one.spec.clone(), one.tracked.measure.interval()));
        self.run.set_watched(watched.collect());
    }

    fn stop(&mut self, error: &anyhow::Error) {
        self.is_playing = false;
        self.error = Some(format!("{error:#}"));
    }
}

/// The run of an open scene, as it is saved.
#[cfg(feature = "server")]
#[derive(Clone, Copy)]
pub struct OpenRun<'a>(&'a Bench);

#[cfg(feature = "server")]
impl<'a> OpenRun<'a> {
    /// The run.
    pub fn run(self) -> &'a InteractiveRun {
        &self.0.run
    }

    /// What distinguishes its state.
    pub fn state(self) -> RunState {
        self.0.state()
    }

    /// What was measured so far; nothing if it cannot be encoded.
    pub fn measured(self) -> MeasuredBefore {
        measured_before(&self.0.watching.measures, &self.0.run).unwrap_or_default()
    }
}

/// The method of a scene in words, if it is not exact.
fn method(scene: &Scene) -> Option<String> {
    let method = Method::try_from(&scene.method).ok()?;
    (!method.is_exact()).then(|| method.to_string())
}

/// What a page has received last.
#[derive(Debug, Default)]
struct Sent {
    viewer: u64,
    body_list: u32,
    /// Time, collisions, list of bodies, window and chosen body of its last frame.
    frame: Option<(EpochTime, u64, u32, u64, Option<BodyKey>)>,
}

/// The laboratory: at most one open scene, and what the pages have received.
pub struct Laboratory<S> {
    viewers: Arc<Viewers>,
    signals: Signals,
    /// Where runs are saved.
    pub store: S,
    bench: Option<Bench>,
    /// Version of the last list of bodies of any scene.
    version: u32,
    measures_so_far: u64,
    sent: Vec<Sent>,
    next_frame: Instant,
    next_status: Instant,
    next_measures: Instant,
}

impl<S: RunStore> Laboratory<S> {
    /// A laboratory for these pages.
    pub fn new(viewers: Arc<Viewers>, store: S, signals: Signals) -> Self {
        let now = Instant::now();
        Self {
            viewers,
            signals,
            store,
            bench: None,
            version: 0,
            measures_so_far: 0,
            sent: Vec::new(),
            next_frame: now,
            next_status: now,
            next_measures: now,
        }
    }

    /// Opens a scene.
    ///
    /// # Errors
    /// It is invalid.
    pub fn open(&mut self, name: String, scene: &Scene) -> Result<()> {
        let bench = Bench::new(name, scene, self.version + 1, self.signals.clone())?;
        self.bench = Some(bench);
        Ok(())
    }

    /// Runs one piece of the open scene; returns the time until there is something to do besides
    /// commands.
    pub fn run_piece(&mut self) -> Duration {
        let is_ahead = match &mut self.bench {
            Some(bench) if bench.is_playing => bench.run_piece(self.next_frame),
            _ => true,
        };
        if is_ahead {
            self.pause()
        } else {
            Duration::ZERO
        }
    }

    /// Sends what is due to all pages, after a piece and the commands that came meanwhile.
    pub fn report(&mut self) {
        // Stages of the scene begin in pieces and in steps.
        if let Some(bench) = &mut self.bench
            && bench.run.stage() != bench.stage
        {
            bench.has_changed();
        }
        self.publish();
    }

    /// The run, if a scene is open, and where it is saved.
    #[cfg(feature = "server")]
    pub fn run_and_store(&mut self) -> (Option<OpenRun<'_>>, &mut S) {
        (self.bench.as_ref().map(OpenRun), &mut self.store)
    }

    /// Time until there is something to do besides commands.
    fn pause(&self) -> Duration {
        self.next_frame
            .saturating_duration_since(Instant::now())
            .clamp(Duration::from_micros(500), LOOK)
    }

    /// Executes a request and answers it.
    pub fn obey(&mut self, Message { viewer, request }: Message) {
        // A reader chooses a body; what all pages show remains.
        let is_writer = self.viewers.is_writer(viewer);
        let is_choice = matches!(request.command, LiveCommand::Choose(_));
        let result = self
            .execute(viewer, request.command)
            .map_err(|error| format!("{error:#}"));
        if let Some(viewer) = self.viewers.get(viewer) {
            if is_choice {
                viewer.has_chosen();
            }
            // A status that waits is older than the answer, and must not follow it.
            viewer.drop_status();
            viewer.answer(&LiveAnswer::new(request.id, result));
        }
        if !is_writer {
            return;
        }
        // What has changed is shown at once.
        let now = Instant::now();
        (self.next_frame, self.next_status) = (now, now);
        if let Some(bench) = &self.bench {
            self.version = self.version.max(bench.body_list.version);
        }
    }

    fn bench(&mut self) -> Result<&mut Bench> {
        self.bench.as_mut().context("no scene is open")
    }

    /// Executes a command; returns what the page needs to know.
    fn execute(&mut self, viewer: u64, command: LiveCommand) -> Result<Value> {
        match command {
            // The server answers these.
            LiveCommand::View(_) | LiveCommand::Seen(_) => Ok(Value::Null),
            LiveCommand::Open(name) => {
                let (text, scene) = gallery::scene(&name)?;
                self.start_scene(name, &scene, text.to_owned())
            }
            LiveCommand::Scene(SceneText { name, text }) => {
                let scene = Scene::from_toml(&text)?;
                self.start_scene(name, &scene, text)
            }
            LiveCommand::Play(play) => {
                let bench = self.bench()?;
                let now = bench.now();
                bench.pace.start(now);
                bench.is_playing = play;
                bench.error = bench.error.take().filter(|_| !play);
                Ok(Value::Null)
            }
            LiveCommand::Speed(speed) => self.set_speed(speed),
            LiveCommand::Source(_) => {
                let bench = self.bench()?;
                Ok(json!({ "name": bench.name, "text": bench.text }))
            }
            LiveCommand::Step(contacts) => {
                let signals = self.signals.clone();
                self.bench()?.pass_contacts(contacts, &signals)
            }
            LiveCommand::Edit(edits) => self.edit(&edits),
            LiveCommand::Choose(id) => self.bench()?.choose(viewer, id),
            LiveCommand::Bookmark(_) => {
                let bench = self.bench()?;
                bench.bookmark = Some(bench.run.clone());
                Ok(json!({ "time": bench.now() }))
            }
            LiveCommand::Back(_) => self.bench()?.go_back(),
            LiveCommand::Measure(request) => self.measure(&request),
            LiveCommand::EndMeasure(id) => self.end_measure(id),
            LiveCommand::Save(_) => self.save(),
        }
    }

    /// Saves the run with what was measured so far.
    fn save(&mut self) -> Result<Value> {
        let bench = self.bench.as_ref().context("no scene is open")?;
        let measures = &bench.watching.measures;
        let measured = measured_before(measures, &bench.run)?;
        let mut saved = self.store.save(&bench.run, &measured)?;
        // The saved run has the end of the epoch.
        saved["shown"] = bench.now().into();
        saved["measures"] = measures.len().into();
        Ok(saved)
    }

    /// Opens the scene of a text and runs it.
    fn start_scene(&mut self, name: String, scene: &Scene, text: String) -> Result<Value> {
        self.open(name, scene)?;
        let bench = self.bench()?;
        bench.text = text;
        bench.is_playing = true;
        bench.pace.start(0.0);
        Ok(Value::Null)
    }

    /// Sets the simulated time for each second; `None` for as fast as it runs.
    fn set_speed(&mut self, speed: Option<f64>) -> Result<Value> {
        let is_valid = speed.is_none_or(|speed| speed.is_finite() && speed > 0.0);
        ensure!(
            is_valid,
            "the speed must be positive and finite, but is {speed:?}"
        );
        let bench = self.bench()?;
        let now = bench.now();
        bench.pace.set_speed(speed, now);
        Ok(Value::Null)
    }

    /// Ends the measure of this number.
    fn end_measure(&mut self, id: u64) -> Result<Value> {
        let bench = self.bench()?;
        let before = bench.watching.measures.len();
        bench.watching.measures.retain(|measured| measured.id != id);
        ensure!(
            bench.watching.measures.len() < before,
            "there is no measure {id}"
        );
        bench.keep_measures();
        self.next_measures = Instant::now();
        Ok(Value::Null)
    }

    fn edit(&mut self, edits: &[LiveEdit]) -> Result<Value> {
        ensure!(
            (1..=MAX_EDITS).contains(&edits.len()),
            "a request has from 1 to {MAX_EDITS} edits, not {}",
            edits.len()
        );
        let bench = self.bench()?;
        let (mut times, mut notes) = (Vec::new(), Vec::new());
        let mut made = Ok(());
        for edit in edits {
            match bench.edit(edit) {
                Ok((time, more)) => {
                    times.push(time);
                    notes.extend(more);
                }
                Err(error) => {
                    made = Err(error);
                    break;
                }
            }
        }
        if !times.is_empty() {
            bench.error = None;
            bench.has_changed();
        }
        made?;
        Ok(json!({ "times": times, "notes": notes }))
    }

    fn measure(&mut self, MeasureRequest { spec, interval }: &MeasureRequest) -> Result<Value> {
        let id = self.measures_so_far + 1;
        let bench = self.bench()?;
        ensure!(
            bench.watching.measures.len() < MAX_MEASURES,
            "there are {MAX_MEASURES} measures: end one of them first"
        );
        let scene = Scene {
            elasticity: bench.run.elasticity().clone(),
            ..bench.run.scene().clone()
        };
        let interval = interval.unwrap_or(scene.run.sample_interval);
        let measure = SingleMeasure::new(spec, interval, &scene, &bench.run.view())?;
        let tracked = Tracked::new(measure, &bench.run.view());
        let name = spec
            .of
            .as_ref()
            .map_or_else(|| spec.kind.clone(), |of| format!("{}:{of}", spec.kind));
        let begun = bench.now();
        bench.watching.measures.push(MeasuredNow {
            id,
            name: name.clone(),
            spec: spec.clone(),
            begun,
            tracked,
        });
        bench.keep_measures();
        self.measures_so_far = id;
        self.next_measures = Instant::now();
        Ok(json!({ "id": id, "name": name, "interval": interval, "begun": begun }))
    }

    /// Sends what is due to all pages.
    fn publish(&mut self) {
        let now = Instant::now();
        let tolerance = self
            .bench
            .as_ref()
            .map_or(Duration::ZERO, |bench| bench.pace.tolerance());
        if now + tolerance >= self.next_frame {
            self.publish_frames();
            let interval = self
                .bench
                .as_ref()
                .map_or(FRAME, |bench| bench.pace.interval());
            // At regular times, except after a delay. Many pages may take longer than an interval.
            let (next, now) = (self.next_frame + interval, Instant::now());
            self.next_frame = if next > now { next } else { now + interval };
        }
        if now >= self.next_status {
            self.publish_status();
            self.next_status = Instant::now() + STATUS.max(now.elapsed().div_f64(SHARE_OF_REPORTS));
        }
        if now >= self.next_measures
            && let Some(bench) = &self.bench
        {
            let Bench { run, watching, .. } = bench;
            let results = report::results(&watching.measures, run);
            let text = text_of(&json!({ "measures": results }));
            self.viewers
                .all()
                .iter()
                .for_each(|viewer| viewer.send_measures(text.clone()));
            let cost = now.elapsed();
            self.next_measures = Instant::now() + MEASURES.max(cost.div_f64(SHARE_OF_REPORTS));
        }
    }

    fn publish_status(&mut self) {
        let mut status = json!({});
        if let Some(bench) = &mut self.bench {
            status = bench.watch.status(&bench.run);
            status["playing"] = bench.is_playing.into();
            status["speed"] = bench.pace.speed().into();
            status["bookmark"] = bench
                .bookmark
                .as_ref()
                .map(|run| run.view().time().to_f64())
                .into();
            status["error"] = bench.error.clone().into();
            status["saved"] = self.store.status();
        }
        let mut message = json!({ "status": status });
        for viewer in self.viewers.all() {
            if let Some(bench) = &self.bench {
                let chosen = bench.watching.chosen_by(viewer.id);
                message["status"]["chosen"] =
                    chosen.map_or(Value::Null, |key| about(&bench.run.view(), key));
            }
            viewer.send_status(text_of(&message));
        }
    }

    fn publish_frames(&mut self) {
        let Some(bench) = &mut self.bench else { return };
        self.version = self.version.max(bench.body_list.version);
        let viewers = self.viewers.all();
        let is_here = |id: u64| viewers.iter().any(|viewer| viewer.id == id);
        self.sent.retain(|sent| is_here(sent.viewer));
        bench
            .watching
            .followers
            .retain(|(viewer, _)| is_here(*viewer));
        // Not by the clock: on a busy machine another program would count.
        let begun = ThreadTime::now();
        let mut frames = 0;
        for viewer in &viewers {
            let known = self.sent.iter().position(|sent| sent.viewer == viewer.id);
            let index = known.unwrap_or_else(|| {
                self.sent.push(Sent {
                    viewer: viewer.id,
                    ..Sent::default()
                });
                self.sent.len() - 1
            });
            let sent = &mut self.sent[index];
            if sent.body_list != bench.body_list.version {
                viewer.send_body_list(Arc::clone(&bench.body_list.bytes));
                sent.body_list = bench.body_list.version;
            }
            frames += usize::from(send_frame(bench, viewer, sent));
        }
        if frames > 0 {
            bench.pace.has_sent(begun.elapsed(), frames);
        }
    }
}

/// Sends a frame to a page that shows something else than the present state, and can take it;
/// returns whether it has.
fn send_frame(bench: &Bench, viewer: &Viewer, sent: &mut Sent) -> bool {
    let view = bench.run.view();
    let (Some(window), window_number) = viewer.window() else {
        return false;
    };
    let follower = bench.watching.follower_of(viewer.id);
    let chosen = follower.and_then(Follower::chosen);
    let shown = (
        view.time(),
        view.counters().collisions,
        bench.body_list.version,
        window_number,
        chosen,
    );
    if sent.frame == Some(shown) {
        return false;
    }
    let Some(number) = viewer.next_frame() else {
        return false;
    };
    let kicks = follower.map_or_else(Vec::new, |follower| follower.kicks(view.time()));
    let window: &VisibleWindow = &window;
    viewer.send_frame(frame::encode(
        &view,
        FrameLabel {
            number,
            body_list: &bench.body_list,
        },
        window,
        &kicks,
    ));
    sent.frame = Some(shown);
    true
}

/// A body in words.
fn about(view: &View<'_>, key: BodyKey) -> Value {
    let Some(body) = view.body(key) else {
        return Value::Null;
    };
    let tags: Vec<&str> = body
        .body
        .tags()
        .iter()
        .map(|&tag| view.tag_names().name(tag))
        .collect();
    json!({
        "id": key.id(),
        "tags": tags,
        "mass": body.body.inertia().inverse_mass.recip(),
        "energy": body.energy(),
        "speed": body.motion.velocity.length(),
        "atoms": body.body.molecule().atoms().len(),
        "edges": body.body.molecule().edges().len(),
        "fixed": body.body.is_fixed(),
        "locked": body.body.is_locked(),
    })
}

#[cfg(all(test, feature = "server"))]
mod tests {
    use super::*;
    use crate::{protocol::BodyColour, saved_runs::SavedRuns};

    /// A laboratory with its folder.
    fn laboratory() -> (tempfile::TempDir, Laboratory<SavedRuns>) {
        let root = tempfile::tempdir().unwrap();
        let saved_runs =
            SavedRuns::open(&root.path().join("saved"), Duration::from_secs(30)).unwrap();
        let laboratory = Laboratory::new(Arc::default(), saved_runs, Signals::default());
        (root, laboratory)
    }

    /// Interval of frames after some rounds with so many pages.
    fn interval_with(pages: usize, run: &mut Laboratory<SavedRuns>) -> Duration {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .build()
            .unwrap();
        let window = VisibleWindow {
            centre: [0.5; 2],
            half: [0.6; 2],
            colour: BodyColour::Speed,
            follow: None,
        };
        let viewers: Vec<_> = (0..pages).map(|_| run.viewers.join().unwrap()).collect();
        for number in 1..=24 {
            // A frame is sent where a page shows another window than before.
            for viewer in &viewers {
                viewer.set_window(window);
            }
            run.publish_frames();
            for viewer in &viewers {
                while runtime.block_on(async {
                    tokio::select! { biased; got = viewer.next() => got.is_some(), () = std::future::ready(()) => false }
                }) {}
                viewer.has_seen(number);
            }
        }
        for viewer in &viewers {
            run.viewers.leave(viewer.id);
        }
        run.bench.as_ref().unwrap().pace.interval()
    }

    #[test]
    fn frames_of_several_pages_take_no_larger_share_than_those_of_one() {
        let gas = "[[gas]]\nradius = 1e-4\nmass = 1.0\nenergy = 1.0\ncount = 100000";
        let (_root, mut laboratory) = laboratory();
        laboratory
            .open("gas".to_owned(), &Scene::from_toml(gas).unwrap())
            .unwrap();
        let one = interval_with(1, &mut laboratory);
        let eight = interval_with(8, &mut laboratory);
        assert!(one > FRAME && eight > 3 * one, "{one:?} {eight:?}");
    }
}
