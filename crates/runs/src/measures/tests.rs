//! Tests of the measures: by name, in checkpoints, and against theory.

use super::*;
use crate::output::Existing;
use carom::Scene;
use carom_methods::AnySimulation;

#[test]
fn names_are_refused_with_their_reason() {
    for good in ["velocities", "velocities:gas", "contact-density:the_tee", "thermostat"] {
        assert!(check(good).is_ok(), "{good}");
    }
    for (bad, said) in [
        ("colour", "unknown observer"),
        ("contact-density", "contact-density:TAG"),
        ("thermostat:gas", "whole system"),
        ("velocities:", "letters"),
        ("velocities:../x", "letters"),
    ] {
        let error = check(bad).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}

#[test]
fn bodies_that_are_missing_or_not_unique_are_refused() {
    let scene =
        Scene::from_toml("[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100")
            .unwrap();
    let simulation = AnySimulation::new(&scene).unwrap();
    let refused = |name: &str| {
        let run = RunSpec { observe: vec![name.to_owned()], ..RunSpec::default() };
        format!("{:#}", Measures::begin(&run, &simulation.view()).err().expect("an error"))
    };
    assert!(refused("velocities:none").contains("no body in the scene carries"));
    assert!(refused("contact-density:gas").contains("several bodies"));
    assert!(refused("drift:gas").contains("several bodies"));
}

/// Runs a scene with its measures from time 0 and returns the results.
fn measured(text: &str) -> (Results, Result<HardDiscs, String>) {
    let scene = Scene::from_toml(text).unwrap();
    let mut simulation = AnySimulation::new(&scene).unwrap();
    let measures = Measures::begin(&scene.run, &simulation.view()).unwrap();
    let mut measures = Delayed::new(scene.run.measure_from, f64::INFINITY, measures);
    measures.start(&simulation.view());
    measures.sample(&simulation.view());
    let samples = (scene.run.until / scene.run.sample_interval).round() as u32;
    for sample in 1..=samples {
        if sample == samples / 2 {
            // A checkpoint in the middle changes nothing.
            measures = decode(&encode(&measures).unwrap()).unwrap();
        }
        let time = scene.run.sample_interval * f64::from(sample);
        simulation.observe_until(time, &mut measures).unwrap();
        measures.sample(&simulation.view());
    }
    let gas = HardDiscs::of(&simulation.view(), &scene.elasticity);
    (measures.observer.results(&scene, &gas), gas)
}

fn table<'a>(results: &'a Results, name: &str) -> &'a Table {
    results.tables.iter().find(|table| table.name == name).unwrap_or_else(|| panic!("no table {name}"))
}

fn column<'a>(table: &'a Table, name: &str) -> &'a [Option<f64>] {
    &table.columns.iter().find(|column| column.name == name).unwrap_or_else(|| panic!("no {name}")).values
}

#[test]
fn a_gas_with_a_molecule_is_measured_and_its_tables_are_written() {
    let (results, gas) = measured(
        r#"
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
            observe = ["velocities:gas", "correlation", "pair-distribution:gas", "contact-density:tee", "thermostat",
                "directions:tee", "projections:tee", "drift:tee", "running-average:tee", "temperature:gas", "orientation:tee",
                "structure-factor", "hexatic-order:gas", "pressure-tensor", "free-path:gas", "viscosity"]
        "#,
    );
    assert!(gas.unwrap_err().contains("equal discs"));
    let root = tempfile::tempdir().unwrap();
    let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
    results.write(&folder).unwrap();
    let lines = |name: &str| std::fs::read_to_string(root.path().join(name)).unwrap().lines().count();
    assert_eq!((lines("velocities-gas.csv"), lines("correlation.csv")), (22, 13));
    // 100 discs of unit mass and energy: ⟨v²⟩ = 2 at first.
    let mean_square = column(table(&results, "velocities-gas"), "mean_square")[0].unwrap();
    assert!((mean_square - 2.0).abs() < 1e-12);
    let components = table(&results, "velocity-components-gas");
    let width = column(components, "velocity")[1].unwrap() - column(components, "velocity")[0].unwrap();
    let total: f64 = column(components, "density_x").iter().flatten().sum::<f64>() * width;
    assert!(total > 0.99 && total < 1.0 + 1e-12, "{total}");
    // No pair is nearer than a diameter, which is 50 bins.
    let pairs = table(&results, "pair-distribution-gas");
    assert!(column(pairs, "pairs")[..49].iter().all(|count| *count == Some(0.0)));
    let near: f64 = column(pairs, "g")[51..76].iter().flatten().sum::<f64>() / 25.0;
    assert!((0.9..1.5).contains(&near), "{near}");
    assert!(
        column(table(&results, "contact-density-tee"), "contacts").iter().any(|count| *count > Some(0.0))
    );
    assert!(column(table(&results, "thermostat"), "put_in").iter().all(|energy| *energy == Some(0.0)));
    // Every measure has a result, each table one length, and each file one writer.
    for kind in KINDS {
        let is_of = |name: &str| name.starts_with(kind.name);
        let has_table = results.tables.iter().any(|table| is_of(&table.name));
        // No wall of this scene has a temperature.
        assert!(has_table || ["drift", "wall-heat"].contains(&kind.name), "{}", kind.name);
    }
    assert_eq!(results.figures.iter().filter(|figure| figure.name.ends_with(", tee")).count(), 6);
    for table in &results.tables {
        let rows = table.columns[0].values.len();
        assert!(rows > 0 && table.columns.iter().all(|column| column.values.len() == rows), "{}", table.name);
    }
    let mut names: Vec<&String> = results.tables.iter().map(|table| &table.name).collect();
    names.sort();
    assert!(names.windows(2).all(|pair| pair[0] != pair[1]));
    // Shares of all sectors, and densities times the width of a bin, sum to 1.
    let shares: f64 = column(table(&results, "directions-tee"), "share_of_contacts").iter().flatten().sum();
    assert!((shares - 1.0).abs() < 1e-12);
    let projections = table(&results, "projections-tee");
    let (impulses, density) = (column(projections, "impulse"), column(projections, "density_x"));
    let width = impulses[1].unwrap() - impulses[0].unwrap();
    assert!((density.iter().flatten().sum::<f64>() * width - 1.0).abs() < 1e-9);
}

/// A dense gas of 400 discs agrees with its predictions within their errors and a few per cent of
/// the finite size.
#[test]
fn measures_of_hard_discs_agree_with_their_predictions() {
    let (results, gas) = measured(
        r#"
            [box]
            seed = 7
            [[gas]]
            radius = 0.01
            mass = 1.0
            energy = 1.0
            count = 400
            [run]
            until = 6.0
            sample_interval = 0.005
            measure_from = 1.0
            observe = ["velocities", "correlation", "pair-distribution"]
        "#,
    );
    let gas = gas.unwrap();
    let correlation = table(&results, "correlation");
    let (lags, found) = (column(correlation, "lag"), column(correlation, "velocity_autocorrelation"));
    let errors = column(correlation, "velocity_autocorrelation_error");
    let predicted = column(correlation, "velocity_autocorrelation_predicted");
    // At the first lag the exponential is exact up to second order in Γ t.
    let (lag, rate) = (lags[1].unwrap(), gas.collision_rate());
    let off = found[1].unwrap() - predicted[1].unwrap();
    let second_order = found[0].unwrap() * (rate * lag).powi(2);
    assert!(off.abs() < 5.0 * errors[1].unwrap() + second_order, "{off} {errors:?}");
    assert!(errors[1].unwrap() < 0.02 * found[0].unwrap());
    // Discs move freely at first: the mean squared displacement is ⟨v²⟩ t².
    let squares = column(correlation, "mean_square_displacement");
    assert!((squares[1].unwrap() / (found[0].unwrap() * lag * lag) - 1.0).abs() < rate * lag);
    let figure = |part: &str| results.figures.iter().find(|figure| figure.name.contains(part)).unwrap();
    for part in ["at contact", "kurtosis"] {
        let figure = figure(part);
        let (off, error) = (figure.value - figure.prediction.unwrap(), figure.standard_error.unwrap());
        assert!(off.abs() < 5.0 * error && error < 0.05 * figure.value, "{part}: {figure:?}");
    }
    // The tail of the autocorrelation makes it larger than in Enskog's theory.
    let diffusion = figure("diffusion");
    assert!((0.9..1.3).contains(&(diffusion.value / diffusion.prediction.unwrap())), "{diffusion:?}");
}

#[test]
fn the_heat_of_walls_is_that_of_the_ledger() {
    let text = "[[wall]]\ntags = [\"hot\"]\nx = 0.0\ntemperature = 4.0\n[[wall]]\ntags = [\"cold\"]\nx = 0.5\ntemperature = 1.0\n\
                [[gas]]\nradius = 0.01\nmass = 1.0\ntemperature = 2.0\ncount = 100\n\
                [run]\nuntil = 20.0\nsample_interval = 0.1\nobserve = [\"thermostat\", \"wall-heat\", \"wall-heat:hot\", \"wall-heat:cold\"]";
    let (results, _) = measured(text);
    let last = |name: &str| column(table(&results, name), "heat").last().copied().flatten().unwrap();
    let (all, hot, cold) = (last("wall-heat"), last("wall-heat-hot"), last("wall-heat-cold"));
    let booked: f64 = column(table(&results, "thermostat"), "heat").iter().flatten().sum();
    assert!(
        (all - booked).abs() < 1e-10 * hot && (hot + cold - all).abs() < 1e-10 * hot,
        "{hot} {cold} {all}"
    );
    assert!(hot > 0.0 && cold < 0.0);
    let figure =
        results.figures.iter().find(|figure| figure.name == "heat received from walls, hot").unwrap();
    assert!((figure.value - hot / 20.0).abs() < 1e-9 * hot && figure.standard_error.is_some());
    let gas = Scene::from_toml("[[gas]]\nradius = 0.01\nmass = 1.0\ntemperature = 2.0\ncount = 100").unwrap();
    let run = RunSpec { observe: vec!["wall-heat".to_owned()], ..RunSpec::default() };
    let simulation = AnySimulation::new(&gas).unwrap();
    let error = Measures::begin(&run, &simulation.view()).err().expect("no wall");
    assert!(format!("{error:#}").contains("no such wall has a temperature"), "{error:#}");
}
