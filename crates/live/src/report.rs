//! What a page shows besides the bodies: totals of the run, tags, and the results of measures.

use std::{collections::BTreeMap, time::Duration};

use carom::{
    Scene, View,
    engine::{Ledger, MeasureSpec, Tag},
};
use carom_runs::{
    clock::{Instant, ThreadTime},
    measures::{Results, Tracked},
    run::interactive::InteractiveRun,
};
use carom_tables::{Figure, Guide, Role, Table, named};
use serde::Serialize;
use serde_json::{Value, json};

/// Largest number of rows of a table that is sent; of more, each k-th.
const MAX_ROWS: usize = 240;

/// Largest share of the time that checks for overlaps take.
const SHARE_OF_CHECKS: f64 = 0.01;

/// Shortest time between two checks.
const CHECK: Duration = Duration::from_secs(1);

/// What was seen so far of overlaps and energy.
#[derive(Debug)]
pub struct StateWatch {
    overlapping_pairs: usize,
    deepest: f64,
    drift: f64,
    exchange: Exchange,
    next_check: Instant,
    /// Collisions at the last status, and the time that the engine has run since (seconds).
    collisions: u64,
    seconds: f64,
    rate: f64,
    /// Processor time of this thread.
    clock: ThreadTime,
}

/// Energy exchanged so far. Each exchange is recorded to a rounding of the energy at its time,
/// which may be far larger than what remains in a gas that has lost nearly all of it.
#[derive(Debug, Default)]
struct Exchange {
    /// Energy lost in contacts, put in by edits and thermostats, received from heated walls and
    /// from walls that move, taken by drag, and gained by falling, by shear and in wells, at the
    /// last look.
    last: [f64; 8],
    /// Sum of the magnitudes of the changes between two looks.
    sum: f64,
}

impl Exchange {
    fn so_far(&mut self, ledger: &Ledger) -> f64 {
        let now = [
            ledger.lost,
            ledger.put_in,
            ledger.heat,
            ledger.work,
            ledger.dragged,
            ledger.fallen,
            ledger.sheared,
            ledger.wells,
        ];
        self.sum += now
            .iter()
            .zip(self.last)
            .map(|(now, last)| (now - last).abs())
            .sum::<f64>();
        self.last = now;
        self.sum
    }
}

/// A tag and its bodies.
#[derive(Debug, Serialize)]
struct OfTag {
    name: String,
    /// Number of moving bodies.
    count: usize,
    /// Mean kinetic energy of a moving body; 0 without one.
    energy: f64,
    /// Mean degrees of freedom of a moving body: two, and a third if it turns.
    freedom: f64,
    /// Number of those that cannot turn.
    locked: usize,
}

impl StateWatch {
    /// Nothing has been seen.
    pub fn new(view: &View<'_>) -> Self {
        Self {
            overlapping_pairs: 0,
            deepest: 0.0,
            drift: 0.0,
            exchange: Exchange::default(),
            next_check: Instant::now(),
            collisions: view.counters().collisions,
            seconds: 0.0,
            rate: 0.0,
            clock: ThreadTime::now(),
        }
    }

    /// The engine has run for this long.
    pub fn has_run(&mut self, wall: Duration) {
        self.seconds += wall.as_secs_f64();
    }

    /// The state of the run, with checks of energy and, from time to time, overlaps.
    pub fn status(&mut self, run: &InteractiveRun) -> Value {
        let view = run.view();
        let (totals, ledger) = (Totals::new(&view), view.ledger());
        // That of all bodies, pistons too, as the ledger has it.
        let energy = view.energy();
        let scale = ledger.initial + self.exchange.so_far(&ledger);
        if scale > 0.0 {
            self.drift = self.drift.max((energy - ledger.booked()).abs() / scale);
        }
        let begun = Instant::now();
        if begun >= self.next_check {
            let census = view.overlaps();
            self.overlapping_pairs = self.overlapping_pairs.max(census.pairs);
            self.deepest = self.deepest.max(census.deepest);
            self.next_check = Instant::now() + CHECK.max(begun.elapsed().div_f64(SHARE_OF_CHECKS));
        }
        let collisions = view.counters().collisions;
        if self.seconds > 0.0 {
            self.rate = collisions.saturating_sub(self.collisions) as f64 / self.seconds;
        }
        (self.collisions, self.seconds) = (collisions, 0.0);
        json!({
            "time": view.time().to_f64(),
            "time_scale": totals.time_scale(&view, run.scene().run.sample_interval),
            "bodies": totals.bodies,
            "collisions": collisions,
            "rate": self.rate,
            "processor": self.clock.elapsed().as_secs_f64(),
            "energy": energy,
            "crossing": totals.crossing,
            "temperature": view.temperature(),
            "drift": self.drift,
            "allowed_drift": carom_tables::allowed_drift(collisions, Some(totals.moving as u64)),
            "overlaps": self.overlapping_pairs,
            "deepest": self.deepest,
            "elasticity": run.elasticity().default,
            "rules": run.elasticity(),
            "hold": run.thermostats(),
            "stage": run.stage(),
            "tags": totals.tags,
        })
    }
}

/// Sums over all bodies.
struct Totals {
    /// Number of bodies; walls do not count, pistons do.
    bodies: usize,
    /// Number of those that move.
    moving: usize,
    /// The time in which a moving body of mean speed crosses the shorter side of the box; `None` if
    /// nothing moves.
    crossing: Option<f64>,
    tags: Vec<OfTag>,
}

impl Totals {
    /// The sums, in one pass.
    fn new(view: &View<'_>) -> Self {
        let names = view.tag_names();
        let mut tags: BTreeMap<Tag, OfTag> = BTreeMap::new();
        let mut speed = 0.0;
        let (mut bodies, mut moving) = (0_usize, 0_usize);
        for body in view.bodies() {
            let is_wall = body.body.is_wall() && body.body.is_fixed();
            bodies += usize::from(!is_wall);
            let is_moving = body.body.is_free();
            let own = body.energy();
            if is_moving {
                speed += body.motion.velocity.length();
                moving += 1;
            }
            for &tag in body.body.tags() {
                let new = || OfTag {
                    name: names.name(tag).to_owned(),
                    count: 0,
                    energy: 0.0,
                    freedom: 0.0,
                    locked: 0,
                };
                let of = tags.entry(tag).or_insert_with(new);
                if is_moving {
                    of.count += 1;
                    of.energy += own;
                    of.freedom += if body.body.can_turn() { 3.0 } else { 2.0 };
                    of.locked += usize::from(body.body.is_locked());
                }
            }
        }
        for of in tags.values_mut() {
            let count = of.count.max(1) as f64;
            of.energy /= count;
            of.freedom /= count;
        }
        let crossing = view.bounds().sides().min_element() * moving as f64 / speed;
        let crossing = Some(crossing).filter(|time| time.is_finite());
        Self {
            bodies,
            moving,
            crossing,
            tags: tags.into_values().collect(),
        }
    }

    /// The shorter of the sample interval and the mean free time (time): times are shown to its
    /// digits. The mean free time is known from one collision of each body on.
    fn time_scale(&self, view: &View<'_>, sample_interval: f64) -> f64 {
        let collisions = view.counters().collisions_of_moving() as f64 / self.moving.max(1) as f64;
        let free_time = view.time().to_f64() / collisions;
        if collisions >= 1.0 && free_time > 0.0 {
            free_time.min(sample_interval)
        } else {
            sample_interval
        }
    }
}

/// A measure with its number and name.
pub struct MeasuredNow {
    /// Its number.
    pub id: u64,
    /// Its name.
    pub name: String,
    /// What was asked for.
    pub spec: MeasureSpec,
    /// The time of its first sample.
    pub begun: f64,
    /// The measure.
    pub tracked: Tracked,
}

impl MeasuredNow {
    /// Why no prediction of equilibrium holds, if there is a reason.
    fn disturbed(&self, run: &InteractiveRun) -> Option<&'static str> {
        if self.tracked.is_disturbed {
            Some("the system has been edited since the measure began")
        } else {
            (!run.thermostats().is_empty()).then_some("thermostats act")
        }
    }

    /// Its results so far. `rules` has the elasticity in force, see [`rules_in_force`].
    pub fn results(&self, rules: &Scene, run: &InteractiveRun) -> Results {
        let measure = &self.tracked.measure;
        let record = measure.record(rules, &run.view(), self.disturbed(run));
        carom_runs::merge::merged(&record)
    }
}

/// The scene of a run with the elasticity in force.
pub fn rules_in_force(run: &InteractiveRun) -> Scene {
    Scene {
        elasticity: run.elasticity().clone(),
        ..run.scene().clone()
    }
}

/// The results of the measures so far.
pub fn results(measures: &[MeasuredNow], run: &InteractiveRun) -> Value {
    let rules = rules_in_force(run);
    let time = run.view().time().to_f64();
    let of = |measured: &MeasuredNow| {
        let results = measured.results(&rules, run);
        json!({
            "id": measured.id,
            "name": measured.name,
            "begun": measured.begun,
            "interval": measured.tracked.measure.interval(),
            "time": time,
            "samples": measured.tracked.samples(),
            "disturbed": measured.disturbed(run),
            "ended": !measured.tracked.is_active,
            "figures": results.figures.iter().map(figure).collect::<Vec<_>>(),
            "tables": results.tables.iter().map(table).collect::<Vec<_>>(),
        })
    };
    Value::from(measures.iter().map(of).collect::<Vec<_>>())
}

fn figure(figure: &Figure) -> Value {
    json!({
        "name": figure.name,
        "value": figure.value,
        "error": figure.standard_error,
        "unit": figure.unit,
        "prediction": figure.prediction,
        "source": figure.source,
        "smallest_difference": figure.smallest_difference,
    })
}

/// A table as the page of a run [draws](Table::as_drawn) it: with each curve's scale, errors,
/// prediction and guides beside it, or with its maps.
fn table(table: &Table) -> Value {
    if table.grid().is_some() {
        // A map that cannot be drawn is left out.
        let maps = carom_runs::report::maps_of(table).unwrap_or_default();
        let curves: [Value; 0] = [];
        return json!({ "name": table.name, "title": table.title, "caption": table.caption, "maps": maps, "curves": curves });
    }
    let table = &table.as_drawn();
    let rows = table
        .columns
        .iter()
        .map(|column| column.values.len())
        .max()
        .unwrap_or(0);
    let every = rows.div_ceil(MAX_ROWS).max(1);
    // The last row is always among them.
    let thin = |values: &[Option<f64>]| -> Vec<Option<f64>> {
        values.iter().rev().step_by(every).rev().copied().collect()
    };
    let mut curves: Vec<Value> = Vec::new();
    let mut abscissa = Value::Null;
    for column in &table.columns {
        let values = thin(&column.values);
        match &column.role {
            Role::Abscissa => {
                let label = named(&column.label.replace('_', " "), &column.unit);
                abscissa = json!({ "label": label, "values": values });
            }
            role if role.is_curve() => curves.push(json!({
                "name": column.label,
                "unit": column.unit,
                "logarithmic": table.decades.contains(&column.name),
                "guides": guides(table, &column.name),
                "values": values,
                "levels": table.levels.iter().filter(|level| level.column == column.name)
                    .map(|level| json!({ "name": level.label, "value": level.value, "source": level.source }))
                    .collect::<Vec<_>>(),
            })),
            Role::StandardError => {
                if let Some(curve) = curves.last_mut() {
                    curve["errors"] = json!(values);
                }
            }
            Role::Prediction { source } => {
                if let Some(curve) = curves.last_mut() {
                    curve["prediction"] = json!({ "name": column.label, "values": values, "source": source });
                }
            }
            _ => {}
        }
    }
    json!({
        "name": table.name,
        "title": table.title,
        "caption": table.caption,
        "spacing": table.spacing,
        "abscissa": abscissa,
        "curves": curves,
    })
}

/// The powers of the abscissa that are drawn beside a column.
fn guides(table: &Table, column: &str) -> Vec<Value> {
    let guides = table.guides.iter().filter(|guide| guide.column == column);
    let of = |guide: &Guide| {
        let Guide {
            label,
            power,
            from_end,
            ..
        } = guide;
        json!({ "label": label, "power": power, "from_end": from_end })
    };
    guides.map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{
        EpochTime,
        engine::{ElasticitySpec, HeatSpec, StageSpec, ThermostatKind},
    };
    use carom_runs::measures::SingleMeasure;

    #[test]
    fn walls_do_not_count_and_the_scale_of_times_is_the_mean_free_time() {
        let scene = "[[wall]]\nx = 0.0\n[[wall]]\ny = 0.0\n\
             [[bumper]]\nradius = 0.05\nat = [0.5, 0.5]\n\
             [[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100\n\
             [run]\nsample_interval = 0.5\n";
        let mut run = InteractiveRun::new(&Scene::from_toml(scene).unwrap()).unwrap();
        let status = |run: &InteractiveRun| StateWatch::new(&run.view()).status(run);
        assert_eq!(status(&run)["time_scale"], 0.5);
        run.advance(EpochTime::from(1.0), &mut ()).unwrap();
        let now = status(&run);
        assert_eq!(now["bodies"], 101);
        let scale = now["time_scale"].as_f64().unwrap();
        assert!((0.01..0.2).contains(&scale), "{scale}");
    }

    #[test]
    fn correlations_have_the_scales_of_the_page_of_a_run() {
        let scene =
            "[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100";
        let scene = Scene::from_toml(scene).unwrap();
        let mut run = InteractiveRun::new(&scene).unwrap();
        let spec = MeasureSpec {
            kind: "correlation".to_owned(),
            ..MeasureSpec::default()
        };
        let measure = SingleMeasure::new(&spec, 0.01, &scene, &run.view()).unwrap();
        let mut tracked = Tracked::new(measure, &run.view());
        while tracked.samples() < 400 {
            run.advance(tracked.time(), &mut ()).unwrap();
            tracked.sample(&run.view());
        }
        let measured = MeasuredNow {
            id: 1,
            name: "correlation".to_owned(),
            spec,
            begun: 0.0,
            tracked,
        };
        let results = results(&[measured], &run);
        assert_eq!(
            (&results[0]["begun"], &results[0]["interval"]),
            (&json!(0.0), &json!(0.01))
        );
        let table = &results[0]["tables"][0];
        assert_eq!(table["spacing"], "Logarithmic");
        assert_eq!(table["abscissa"]["label"], "lag (time)");
        let [square, product] = [&table["curves"][0], &table["curves"][1]];
        assert_eq!(square["unit"], "length²");
        assert_eq!(square["logarithmic"], true);
        assert_eq!(square["guides"][0]["power"], 2.0);
        assert!(square["errors"].is_array());
        // Over its value at 0.
        assert_eq!(product["unit"], "1");
        assert_eq!(product["logarithmic"], false);
        assert_eq!(product["values"][0], 1.0);
        let of_time = Table::new("t", "T")
            .abscissa("time", "time", vec![0.0])
            .value("x", "1", vec![Some(1.0)]);
        assert_eq!(super::table(&of_time)["abscissa"]["label"], "time");
    }

    #[test]
    fn a_piston_does_not_seem_to_drift() {
        let text = "[[wall]]\nx = 0.0\n[[piston]]\nx = 0.5\nmass = 10.0\nvelocity = 1.0\n\
             [[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 50\n";
        let mut run = InteractiveRun::new(&Scene::from_toml(text).unwrap()).unwrap();
        let mut watch = StateWatch::new(&run.view());
        run.advance(EpochTime::from(1.0), &mut ()).unwrap();
        let status = watch.status(&run);
        assert!(
            status["drift"].as_f64() < status["allowed_drift"].as_f64(),
            "{status}"
        );
    }

    #[test]
    fn a_gas_that_has_lost_nearly_all_energy_does_not_seem_to_drift() {
        // Walls, so that the gas as a whole comes to rest too.
        let scene = "[[wall]]\nx = 0.0\n[[wall]]\ny = 0.0\n\
             [[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1e-9\ncount = 100";
        let mut run = InteractiveRun::new(&Scene::from_toml(scene).unwrap()).unwrap();
        let mut watch = StateWatch::new(&run.view());
        let heat = HeatSpec {
            tag: "gas".to_owned(),
            kind: ThermostatKind::Maxwell,
            temperature: Some(1.0),
            ..HeatSpec::default()
        };
        let elasticity = ElasticitySpec {
            default: 0.3,
            ..ElasticitySpec::default()
        };
        let edit = StageSpec {
            set_energy: vec![heat],
            elasticity: Some(elasticity),
            ..StageSpec::default()
        };
        run.edit(&edit, None, &mut ()).unwrap();
        let mut time = 0.1;
        while run.view().energy() > 1e-4 {
            assert!(time < 1e6, "the gas does not cool");
            run.advance(EpochTime::from(time), &mut ()).unwrap();
            let status = watch.status(&run);
            assert!(
                status["drift"].as_f64() < status["allowed_drift"].as_f64(),
                "{status}"
            );
            time *= 2.0;
        }
    }
}
