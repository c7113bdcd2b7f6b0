//! Observers of a gas that `run.observe` selects: velocities, correlations, distances, contacts
//! along a body, heat.
//!
//! A name may be followed by a colon and a tag that restricts it to the bodies with that tag:
//! `velocities:gas`.

use anyhow::{Context, Result, bail, ensure};
use carom::{
    CollisionReport, ContactDensity, Group, Observer, PairDistribution, ThermostatLedger, TimeCorrelation,
    VelocityDistribution, View,
    engine::{Body, BodyView, RunSpec},
    observers::ImpulseLog,
};
use serde::{Deserialize, Serialize};

use crate::output::Folder;

/// Names allowed in `run.observe`, with or without a tag unless stated otherwise.
pub const OBSERVERS: [&str; 6] =
    ["velocities", "correlation", "pair-distribution", CONTACT_DENSITY, IMPULSES, THERMOSTAT];

/// Requires the tag of the one body observed.
const CONTACT_DENSITY: &str = "contact-density";

/// Requires the tag of the one body observed.
const IMPULSES: &str = "impulses";

/// Largest number of rows in the table of impulses (0.2 kB each).
const MOST_IMPULSES: u64 = 1_000_000;

/// Takes no tag: the energy ledger is that of the whole system.
const THERMOSTAT: &str = "thermostat";

/// Longest lag of correlations in samples. It does not depend on the end of the run, so an extended
/// run measures the same as a long one.
const LONGEST_LAG: f64 = 1e6;

/// Number of bins for speeds; components have twice as many.
const SPEED_BINS: usize = 60;

/// Cutoff of distances in diameters of the largest body of the group, and bins for each diameter.
const DIAMETERS: f64 = 5.0;
const BINS_PER_DIAMETER: f64 = 50.0;

/// Number of bins of the full angle around each atom.
const TURN_BINS: usize = 72;

/// A parsed entry of `run.observe`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct ObserverSpec {
    kind: String,
    tag: Option<String>,
}

impl ObserverSpec {
    /// Parses a name; `None` if it is not in [`OBSERVERS`].
    fn parse(name: &str) -> Option<Self> {
        let (kind, tag) = name.split_once(':').map_or((name, None), |(kind, tag)| (kind, Some(tag)));
        let kind = OBSERVERS.into_iter().find(|&known| known == kind)?;
        Some(Self { kind: kind.to_owned(), tag: tag.map(str::to_owned) })
    }

    fn group(&self, view: &View<'_>) -> Result<Group> {
        let Some(name) = &self.tag else { return Ok(Group::All) };
        let tag = view.tag_names().find(name);
        let tag = tag.filter(|&tag| view.tagged(tag).next().is_some());
        tag.map(Group::from).with_context(|| format!("no body in the scene carries the tag {name:?}"))
    }

    /// File name of a table.
    fn file(&self, name: &str) -> String {
        self.tag.as_ref().map_or_else(|| format!("{name}.csv"), |tag| format!("{name}-{tag}.csv"))
    }
}

/// Validates a name and its tag.
///
/// # Errors
/// The name is unknown, a required tag is missing, or the tag is not allowed.
pub fn check(name: &str) -> Result<()> {
    let Some(ObserverSpec { kind, tag }) = ObserverSpec::parse(name) else {
        bail!("unknown observer '{name}'")
    };
    match (kind.as_str(), tag.as_deref()) {
        (CONTACT_DENSITY | IMPULSES, None) => bail!("'{name}' needs the tag of a body: {name}:TAG"),
        (THERMOSTAT, Some(_)) => {
            bail!("'{name}': the energy ledger covers the whole system and takes no tag")
        }
        // The tag becomes part of a file name.
        (_, Some(tag)) => ensure!(
            !tag.is_empty() && tag.chars().all(|c| c.is_alphanumeric() || "-_".contains(c)),
            "'{name}': the tag may contain letters, digits, - and _ only"
        ),
        _ => {}
    }
    Ok(())
}

/// Observers that need samples only.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct AtSamples(Vec<(ObserverSpec, SampledObserver)>);

#[derive(Debug, Clone, Serialize, Deserialize)]
enum SampledObserver {
    Velocities(VelocityDistribution),
    Correlation(TimeCorrelation),
    Pairs(PairDistribution),
    Thermostat(ThermostatLedger),
}

/// Observers that need reports of contacts.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct AtContacts(Vec<(ObserverSpec, ContactDensity)>, Option<ImpulseLog>);

/// Creates the observers that a run requests.
///
/// # Errors
/// No body carries a tag, or a body or gas is not unique.
pub fn observers(run: &RunSpec, view: &View<'_>) -> Result<(AtSamples, AtContacts)> {
    let (mut sampled, mut densities, mut impulses) = (Vec::new(), Vec::new(), None);
    for name in &run.observe {
        let Some(spec) = ObserverSpec::parse(name) else { continue };
        let context = || format!("run.observe: '{name}'");
        if spec.kind == CONTACT_DENSITY {
            let density = contact_density(spec.group(view)?, view).with_context(context)?;
            densities.push((spec, density));
        } else if spec.kind == IMPULSES {
            let body = only_body(spec.group(view)?, view).with_context(context)?;
            let earlier = impulses.replace(ImpulseLog::new(body.body.key(), MOST_IMPULSES));
            ensure!(earlier.is_none(), "run.observe: '{name}': impulses can be logged for one body only");
        } else {
            let observer = sampled_observer(&spec, run, view).with_context(context)?;
            sampled.push((spec, observer));
        }
    }
    Ok((AtSamples(sampled), AtContacts(densities, impulses)))
}

fn sampled_observer(spec: &ObserverSpec, run: &RunSpec, view: &View<'_>) -> Result<SampledObserver> {
    let group = spec.group(view)?;
    Ok(match spec.kind.as_str() {
        "velocities" => SampledObserver::Velocities(VelocityDistribution::adaptive(group, SPEED_BINS)),
        "correlation" => {
            let longest = (run.sample_interval * LONGEST_LAG).min(f64::MAX);
            SampledObserver::Correlation(TimeCorrelation::new(group, run.sample_interval, longest)?)
        }
        "pair-distribution" => {
            let radii = view.bodies().filter(|body| group.contains(body.body)).map(|body| radius(&body));
            let diameter = 2.0 * radii.fold(0.0, f64::max);
            // Slightly less than half the shorter side: beyond it, periodic images would be missed.
            let half = 0.499 * view.bounds().sides().min_element();
            let cutoff = (DIAMETERS * diameter).min(half);
            let bins = (cutoff / diameter * BINS_PER_DIAMETER).ceil() as usize;
            SampledObserver::Pairs(PairDistribution::new([group; 2], view.bounds(), cutoff, bins)?)
        }
        _ => SampledObserver::Thermostat(ThermostatLedger::default()),
    })
}

fn radius(body: &BodyView<'_>) -> f64 {
    body.body.molecule().bounding_radius()
}

/// The only body of a group.
fn only_body<'a>(group: Group, view: &View<'a>) -> Result<BodyView<'a>> {
    let mut members = view.bodies().filter(|body| group.contains(body.body));
    let (body, another) = (members.next().context("no body carries that tag")?, members.next());
    ensure!(another.is_none(), "several bodies carry that tag, but only one can be observed");
    Ok(body)
}

/// The contacts of the only body of a group with the discs of a gas, all of one radius.
fn contact_density(group: Group, view: &View<'_>) -> Result<ContactDensity> {
    let body = only_body(group, view)?;
    let is_of_a_gas = |other: &BodyView<'_>| {
        let disc = other.body.molecule().is_disc() && !other.body.is_fixed();
        disc && other.body.key() != body.body.key()
    };
    let mut radii = view.bodies().filter(is_of_a_gas).map(|other| radius(&other));
    let disc = radii.next().context("the scene has no gas of discs")?;
    ensure!(radii.all(|radius| radius == disc), "the discs of the gas have several radii");
    Ok(ContactDensity::new(body.body, disc, TURN_BINS)?)
}

impl Observer for AtSamples {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn start(&mut self, view: &View<'_>) {
        for (_, observer) in &mut self.0 {
            match observer {
                SampledObserver::Velocities(velocities) => velocities.start(view),
                SampledObserver::Correlation(correlation) => correlation.start(view),
                SampledObserver::Pairs(pairs) => pairs.start(view),
                SampledObserver::Thermostat(ledger) => ledger.start(view),
            }
        }
    }

    fn sample(&mut self, view: &View<'_>) {
        for (_, observer) in &mut self.0 {
            match observer {
                SampledObserver::Velocities(velocities) => velocities.sample(view),
                SampledObserver::Correlation(correlation) => correlation.sample(view),
                SampledObserver::Pairs(pairs) => pairs.sample(view),
                SampledObserver::Thermostat(ledger) => ledger.sample(view),
            }
        }
    }
}

impl AtSamples {
    /// Writes the tables.
    ///
    /// # Errors
    /// A table cannot be written.
    pub fn write(&self, folder: &Folder) -> Result<()> {
        self.0.iter().try_for_each(|(spec, observer)| match observer {
            SampledObserver::Velocities(velocities) => write_velocities(folder, spec, velocities),
            SampledObserver::Correlation(correlation) => {
                let rows = correlation.points().into_iter().map(|point| {
                    (point.lag, point.pairs, point.mean_square_displacement, point.autocorrelation)
                });
                let header = ["lag", "pairs", "mean_square_displacement", "velocity_autocorrelation"];
                folder.write_table(&spec.file("correlation"), &header, rows)
            }
            SampledObserver::Pairs(pairs) => {
                let rows = pairs.points().into_iter().map(|point| (point.distance, point.pairs, point.g));
                folder.write_table(&spec.file("pair-distribution"), &["distance", "pairs", "g"], rows)
            }
            SampledObserver::Thermostat(ledger) => {
                let points = ledger.series().iter();
                let rows = points.map(|p| (p.time, p.duration, p.put_in, p.lost, p.energy));
                let header = ["time", "duration", "put_in", "lost", "energy"];
                folder.write_table(&spec.file(THERMOSTAT), &header, rows)
            }
        })
    }
}

fn write_velocities(folder: &Folder, spec: &ObserverSpec, velocities: &VelocityDistribution) -> Result<()> {
    let rows = velocities.series().iter().map(|point| {
        let h = [point.h.map(|h| h.x), point.h.map(|h| h.y)];
        (point.time, point.bodies, point.mean_square, point.kurtosis, h, point.h_at_equilibrium())
    });
    let header = ["time", "bodies", "mean_square", "kurtosis", "h_x", "h_y", "h_at_equilibrium"];
    folder.write_table(&spec.file("velocities"), &header, rows)?;
    let histograms = velocities
        .components()
        .zip(velocities.speeds())
        .map_or_else(Vec::new, |([x, y], speeds)| vec![("x", x), ("y", y), ("speed", speeds)]);
    let rows = histograms.into_iter().flat_map(|(name, histogram)| {
        let bins = histogram.counts().iter().zip(histogram.densities()).enumerate();
        bins.map(move |(bin, (&count, density))| (name, histogram.centre(bin), count, density))
    });
    let header = ["component", "value", "count", "density"];
    folder.write_table(&spec.file("velocity-histogram"), &header, rows)
}

impl Observer for AtContacts {
    #[inline]
    fn watches_any(&self) -> bool {
        !self.0.is_empty() || self.1.watches_any()
    }

    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.0.iter().any(|(_, density)| density.watches(bodies)) || self.1.watches(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        self.0.iter_mut().for_each(|(_, density)| density.start(view));
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.0.iter_mut().for_each(|(_, density)| density.collision(report));
        self.1.collision(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        self.0.iter_mut().for_each(|(_, density)| density.sample(view));
    }
}

impl AtContacts {
    /// Returns true if there are no observers.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty() && self.1.is_none()
    }

    /// The log of impulses, which is written during the run.
    pub fn impulses(&mut self) -> Option<&mut ImpulseLog> {
        self.1.as_mut()
    }

    /// Writes the tables that exist at the end only.
    ///
    /// # Errors
    /// A table cannot be written.
    pub fn write(&self, folder: &Folder) -> Result<()> {
        self.0.iter().try_for_each(|(spec, density)| {
            let rows = density
                .points()
                .into_iter()
                .map(|p| (p.atom, p.angle, p.arc, p.contacts, p.pressure, p.standard_error));
            let header = ["atom", "angle", "arc", "contacts", "pressure", "standard_error"];
            folder.write_table(&spec.file(CONTACT_DENSITY), &header, rows)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::Existing;
    use carom::Scene;
    use carom_methods::AnySimulation;

    #[test]
    fn names_are_refused_with_their_reason() {
        for good in ["velocities", "velocities:gas", "contact-density:the_tee", "thermostat"] {
            assert!(check(good).is_ok(), "{good}");
        }
        for (bad, expected) in [
            ("colour", "unknown observer"),
            ("contact-density", "contact-density:TAG"),
            ("impulses", "impulses:TAG"),
            ("thermostat:gas", "whole system"),
            ("velocities:", "letters"),
            ("velocities:../x", "letters"),
        ] {
            let error = check(bad).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn a_gas_is_observed_and_its_tables_are_written() {
        let text = r#"
            [[molecule]]
            tags = ["tee"]
            shape = "tee"
            atom_radius = 0.02
            atom_mass = 1.0
            at = [0.5, 0.5]

            [[gas]]
            tags = ["gas"]
            radius = 0.02
            mass = 1.0
            energy = 1.0
            count = 100

            [run]
            until = 2.0
            sample_interval = 0.1
            observe = ["velocities:gas", "correlation", "pair-distribution:gas", "contact-density:tee", "thermostat"]
        "#;
        let scene = Scene::from_toml(text).unwrap();
        let mut simulation = AnySimulation::new(&scene).unwrap();
        let mut watched = observers(&scene.run, &simulation.view()).unwrap();
        watched.start(&simulation.view());
        watched.sample(&simulation.view());
        for tick in 1..=20 {
            simulation.observe_until(0.1 * f64::from(tick), &mut watched).unwrap();
            watched.sample(&simulation.view());
        }
        let root = tempfile::tempdir().unwrap();
        let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
        watched.0.write(&folder).unwrap();
        watched.1.write(&folder).unwrap();
        let table = |name: &str| -> Vec<Vec<String>> {
            let text = std::fs::read_to_string(root.path().join(name)).unwrap();
            text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
        };
        let number = |cell: &String| cell.parse::<f64>().unwrap();
        // 100 discs of unit mass and energy: ⟨v²⟩ = 2 at first.
        let velocities = table("velocities-gas.csv");
        assert_eq!((velocities.len(), velocities[0].len()), (21, 7));
        assert!((number(&velocities[0][2]) - 2.0).abs() < 1e-12);
        let counted: f64 = table("velocity-histogram-gas.csv").iter().map(|row| number(&row[2])).sum();
        assert!(counted > 0.99 * 3.0 * 2100.0 && counted <= 3.0 * 2100.0, "{counted}");
        assert_eq!(table("correlation.csv").len(), 12);
        // No pair is nearer than a diameter, which is 50 bins.
        let pairs = table("pair-distribution-gas.csv");
        assert!(pairs[..49].iter().all(|row| number(&row[1]) == 0.0));
        let near: f64 = pairs[51..76].iter().map(|row| number(&row[2]) / 25.0).sum();
        assert!((0.9..1.5).contains(&near), "{near}");
        assert!(table("contact-density-tee.csv").iter().any(|row| number(&row[3]) > 0.0));
        assert!(table("thermostat.csv").iter().all(|row| number(&row[2]) == 0.0));

        let refused = |name: &str| {
            let run = RunSpec { observe: vec![name.to_owned()], ..RunSpec::default() };
            format!("{:#}", observers(&run, &simulation.view()).expect_err("an error"))
        };
        assert!(refused("velocities:none").contains("no body in the scene carries"));
        assert!(refused("contact-density:gas").contains("several bodies"));
        assert!(refused("impulses:gas").contains("several bodies"));
    }
}
