//! One measure of a simulation that a program runs itself, without a run folder.

use anyhow::{Result, bail, ensure};
use carom::{
    CollisionReport, Observer, Scene, View,
    engine::{Body, MeasureSpec, RunSpec},
};
use carom_tables::Totals;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _, ser::Error as _};

use super::{
    HardDiscs, Span,
    entry::{Entry, Head},
    request::requests,
};
use crate::{
    record::{Record, RunRecord},
    run_totals::allowed_drift_now,
};

/// A measure of a simulation that a program runs itself: the program calls [`Observer::sample`] at
/// the times k · [`interval`](Self::interval), [`Observer::pause`] before each edit,
/// and [`Observer::start`] after it.
///
/// ```
/// use carom::{Scene, engine::MeasureSpec};
/// use carom_methods::AnySimulation;
/// use carom_runs::measures::SingleMeasure;
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100")?;
/// let mut simulation = AnySimulation::new(&scene)?;
/// let spec = MeasureSpec { kind: "pressure".to_owned(), ..MeasureSpec::default() };
/// let mut pressure = SingleMeasure::new(&spec, 0.1, &scene, &simulation.view())?;
/// simulation.sample_every(pressure.interval(), 2.0, &mut pressure)?;
/// let record = pressure.record(&scene, &simulation.view(), None);
/// let results = carom_runs::merge::merged(&record);
/// assert!(results.figures.iter().any(|figure| figure.name == "pressure" && figure.value > 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct SingleMeasure {
    entry: Entry,
    /// The scene with this measure alone, which identifies its results.
    scene: Scene,
}

impl SingleMeasure {
    /// Prepares a measure with a sample every `interval` (time, positive). Its first sample starts
    /// it.
    ///
    /// # Errors
    /// The interval is out of range; the measure is unknown, has invalid parameters, or writes
    /// every contact to a file; no body carries its tag, or a body is not unique.
    pub fn new(spec: &MeasureSpec, interval: f64, scene: &Scene, view: &View<'_>) -> Result<Self> {
        ensure!(
            interval.is_finite() && interval > 0.0,
            "the interval between samples must be positive and finite, but is {interval:?}"
        );
        let run = RunSpec {
            sample_interval: interval,
            ..RunSpec::default()
        };
        let (measure, stage) = (vec![spec.clone()], Vec::new());
        let scene = Scene {
            run,
            measure,
            stage,
            ..scene.clone()
        };
        let requests = requests(&scene)?;
        let Some(request) = requests.first() else {
            bail!("there is no measure")
        };
        ensure!(
            request.kind.span != Span::EveryContact,
            "'{}' writes every contact to a file of a run; it has no table",
            request.kind.name
        );
        let entry = Entry::new(request, true, &scene, view)?;
        Ok(Self { entry, scene })
    }

    /// Time between two samples.
    pub fn interval(&self) -> f64 {
        self.scene.run.sample_interval
    }

    /// The results so far, which those of other replicas can be merged with. `rules` has the
    /// elasticity in force; `disturbed` is the reason why no theory of a gas that is left alone
    /// holds, if there is one.
    pub fn record(&self, rules: &Scene, view: &View<'_>, disturbed: Option<&str>) -> Record {
        let hard_discs = match disturbed {
            Some(reason) => Err(reason.to_owned()),
            None => HardDiscs::new(view, &rules.elasticity),
        };
        let judged = Scene {
            elasticity: rules.elasticity.clone(),
            ..self.scene.clone()
        };
        let results = self.entry.results(&judged, &hard_discs);
        let totals = Totals {
            collisions: view.counters().collisions,
            simulated_time: view.time().to_f64(),
            allowed_drift: allowed_drift_now(view),
            ..results.totals
        };
        let (note, figures) = (String::new(), Vec::new());
        Record::new(
            &self.scene,
            RunRecord {
                totals,
                note,
                figures,
                measures: results.records,
            },
        )
    }
}

impl Observer for SingleMeasure {
    fn watches_any(&self) -> bool {
        self.entry.watches_any()
    }

    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.entry.watches(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        self.entry.start(view);
    }

    fn pause(&mut self, view: &View<'_>) {
        self.entry.pause(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        // Other observers of the run may have requested this report.
        if self.watches(report.sides.each_ref().map(|side| side.body)) {
            self.entry.collision(report);
        }
    }

    fn sample(&mut self, view: &View<'_>) {
        self.entry.sample(view);
    }
}

/// A measure is stored as its head, its encoded state and its scene as text.
impl Serialize for SingleMeasure {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let state = self.entry.measure.save().map_err(S::Error::custom)?;
        (&self.entry.head, state, self.scene.to_toml()).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for SingleMeasure {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (head, state, scene) = <(Head, Vec<u8>, String)>::deserialize(deserializer)?;
        let entry = Entry::resume(head, &state).map_err(D::Error::custom)?;
        Ok(Self {
            entry,
            scene: Scene::from_toml(&scene).map_err(D::Error::custom)?,
        })
    }
}
