//! The energy balance of a thermostat: energy put in by resets and lost in contacts, from sample to
//! sample.
//!
//! E(t) − E(0) = Σ (work of resets) + Σ (heat of walls) − Σ ½ (1 − e²) μ u² (mass × length² /
//! time²), u being the speed of approach of a contact and μ its reduced mass. The power of each is
//! its change in an interval divided by the duration of the interval.

use carom_engine::{Observer, Tag, TagHeat, View};
use carom_kinematics::EpochTime;
use serde::{Deserialize, Serialize};

/// Energy put in and lost in each interval between samples, and in total.
///
/// An edit at a sample counts for the following interval if [`Observer::sample`] is called before
/// the edit, and for the preceding one if it is called after the edit. Intervals of length 0 are
/// kept: a sample between a reset of hot bodies and one of cold bodies separates their energies.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::ThermostatLedger;
///
/// let scene = Scene::from_toml(
///     "[elasticity]\ndefault = 0.9\n[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100",
/// )?;
/// let mut simulation = Simulation::new(&scene)?;
/// let gas = simulation.find_tag("gas").expect("the scene names it");
/// let mut ledger = ThermostatLedger::default();
/// ledger.sample(&simulation.view());
/// for sample in 1..=5 {
///     simulation.observe_until(0.2 * f64::from(sample), &mut ledger)?;
///     simulation.reset_energy_of_tag(gas, 1.0)?;
///     ledger.sample(&simulation.view());
/// }
/// // The resets replace the energy lost in inelastic contacts.
/// let power = ledger.mean_power().expect("time has passed");
/// assert!(power > 0.0 && (ledger.total_lost() - power * 1.0).abs() < 1e-10);
/// assert!(ledger.imbalance() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[doc(alias = "heat")]
pub struct ThermostatLedger {
    /// The totals at the first and at the last sample.
    books: Option<[Books; 2]>,
    series: Vec<ThermostatPoint>,
    heats: Vec<HeatOfTag>,
    /// The totals after the last action of a thermostat since the first sample.
    acted: Option<Books>,
}

/// The heat that thermostats have given to the bodies of one tag.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HeatOfTag {
    tag: Tag,
    name: String,
    /// Heat at the first and at the last sample, since the system was built.
    booked: [f64; 2],
    /// Bodies that its thermostats have changed so far.
    changed: u64,
    /// Time and heat after the first and after the last action since the first sample.
    acted: Option<[(EpochTime, f64); 2]>,
    series: Vec<f64>,
}

impl HeatOfTag {
    /// The tag.
    pub fn tag(&self) -> Tag {
        self.tag
    }

    /// Name of the tag.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Heat in each interval of [`ThermostatLedger::series`], negative if it is taken away
    /// (mass × length² / time²).
    pub fn series(&self) -> &[f64] {
        &self.series
    }

    /// Heat since the first sample (mass × length² / time²).
    pub fn total(&self) -> f64 {
        self.booked[1] - self.booked[0]
    }

    /// Heat from the first to the last action of a thermostat, and the time between them (mass ×
    /// length² / time², and time); `None` before two actions. Between other times there may be one
    /// action more or less, which is no change of the mean.
    pub fn between_actions(&self) -> Option<[f64; 2]> {
        let [(begin, first), (end, last)] = self.acted?;
        Some([last - first, end.since(begin)]).filter(|[_, time]| *time > 0.0)
    }
}

/// The interval that ends at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ThermostatPoint {
    /// Time of the sample.
    pub time: f64,
    /// Duration of the interval (time).
    pub duration: f64,
    /// Energy put in by edits, less energy removed by edits (mass × length² / time²).
    pub put_in: f64,
    /// Energy lost in contacts, less the gain in superelastic contacts (mass × length² / time²).
    pub lost: f64,
    /// Energy received from walls that have a temperature (mass × length² / time²).
    pub heat: f64,
    /// Kinetic energy at the sample (mass × length² / time²).
    pub energy: f64,
}

impl ThermostatPoint {
    /// Energy put in per time (mass × length² / time³); `None` for an interval of length 0.
    pub fn power(&self) -> Option<f64> {
        (self.duration > 0.0).then(|| self.put_in / self.duration)
    }

    /// Energy lost in contacts per time (mass × length² / time³); `None` for an interval of length
    /// 0.
    pub fn dissipation(&self) -> Option<f64> {
        (self.duration > 0.0).then(|| self.lost / self.duration)
    }
}

/// The totals at one sample, since the system was built.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Books {
    time: EpochTime,
    put_in: f64,
    lost: f64,
    heat: f64,
    energy: f64,
}

impl ThermostatLedger {
    /// The intervals so far; the first begins at the first sample.
    pub fn series(&self) -> &[ThermostatPoint] {
        &self.series
    }

    /// The tags to which thermostats have given heat, in the order of their first use.
    pub fn heats(&self) -> &[HeatOfTag] {
        &self.heats
    }

    /// Energy put in since the first sample (mass × length² / time²).
    pub fn total_put_in(&self) -> f64 {
        self.since_first(|books| books.put_in)
    }

    /// Energy lost in contacts since the first sample (mass × length² / time²).
    pub fn total_lost(&self) -> f64 {
        self.since_first(|books| books.lost)
    }

    /// Energy put in per time since the first sample (mass × length² / time³); `None` before any
    /// time has passed.
    pub fn mean_power(&self) -> Option<f64> {
        let duration: f64 = self.series.iter().map(|point| point.duration).sum();
        (duration > 0.0).then(|| self.total_put_in() / duration)
    }

    /// Energy lost in contacts from the first sample to the last action of a thermostat, or to the
    /// last sample before the first action, and the time (mass × length² / time², and time). A gas
    /// that loses energy cools between actions, so that only equal phases compare.
    pub fn lost_until_action(&self) -> [f64; 2] {
        let Some([first, last]) = self.books else {
            return [0.0; 2];
        };
        let end = self.acted.unwrap_or(last);
        [end.lost - first.lost, end.time.since(first.time)]
    }

    /// Time from the first to the last sample; 0 without one.
    pub fn duration(&self) -> f64 {
        self.books
            .map_or(0.0, |[first, last]| last.time.since(first.time))
    }

    /// Largest |E − E(first) − put in − heat + lost| over the samples, relative to the largest
    /// energy; 0 if that is 0.
    pub fn imbalance(&self) -> f64 {
        let Some([first, _]) = self.books else {
            return 0.0;
        };
        let (mut booked, mut worst, mut largest) = (first.energy, 0.0f64, first.energy);
        for point in &self.series {
            booked += point.put_in + point.heat - point.lost;
            worst = worst.max((point.energy - booked).abs());
            largest = largest.max(point.energy);
        }
        if largest > 0.0 { worst / largest } else { 0.0 }
    }

    /// The place of a tag among the heats; it is added if it is new.
    fn place(&mut self, view: &View<'_>, tag: Tag) -> usize {
        let place = self
            .heats
            .iter()
            .position(|of| of.tag == tag)
            .unwrap_or(self.heats.len());
        if place == self.heats.len() {
            self.heats.push(begun(view, tag, 0.0, 0));
        }
        place
    }

    fn since_first(&self, of: impl Fn(&Books) -> f64) -> f64 {
        self.books
            .map_or(0.0, |[first, last]| of(&last) - of(&first))
    }
}

fn begun(view: &View<'_>, tag: Tag, booked: f64, changed: u64) -> HeatOfTag {
    let name = view.tag_names().name(tag).to_owned();
    HeatOfTag {
        tag,
        name,
        booked: [booked; 2],
        changed,
        acted: None,
        series: Vec::new(),
    }
}

/// The totals of a system.
fn totals(view: &View<'_>) -> Books {
    let (time, ledger) = (view.time(), view.ledger());
    let (put_in, lost, heat) = (ledger.put_in, ledger.lost, ledger.heat);
    Books {
        time,
        put_in,
        lost,
        heat,
        energy: view.energy(),
    }
}

impl Observer for ThermostatLedger {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    /// Finds the actions of thermostats, which come before it.
    fn start(&mut self, view: &View<'_>) {
        if self.books.is_none() {
            return;
        }
        let mut has_acted = false;
        for &TagHeat {
            tag,
            energy,
            counts,
        } in view.heat().all()
        {
            let place = self.place(view, tag);
            let of = &mut self.heats[place];
            if counts.changed > of.changed {
                of.changed = counts.changed;
                let now = (view.time(), energy);
                of.acted = Some([of.acted.map_or(now, |[first, _]| first), now]);
                has_acted = true;
            }
        }
        if has_acted {
            self.acted = Some(totals(view));
        }
    }

    fn sample(&mut self, view: &View<'_>) {
        let now = totals(view);
        let Some([first, before]) = self.books else {
            self.books = Some([now; 2]);
            let heats = view.heat().all().iter();
            self.heats = heats
                .map(|heat| begun(view, heat.tag, heat.energy, heat.counts.changed))
                .collect();
            return;
        };
        let intervals = self.series.len();
        for &TagHeat {
            tag, energy: heat, ..
        } in view.heat().all()
        {
            let place = self.place(view, tag);
            let of = &mut self.heats[place];
            of.series.resize(intervals, 0.0);
            of.series.push(heat - of.booked[1]);
            of.booked[1] = heat;
        }
        self.series.push(ThermostatPoint {
            time: now.time.to_f64(),
            duration: now.time.since(before.time),
            put_in: now.put_in - before.put_in,
            lost: now.lost - before.lost,
            heat: now.heat - before.heat,
            energy: now.energy,
        });
        self.books = Some([first, now]);
    }
}
