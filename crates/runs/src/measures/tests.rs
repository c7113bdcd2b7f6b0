//! Tests of the measures: by name, in checkpoints, and against theory.

use super::*;
use crate::{
    checkpoint_file::{decode, encode},
    output::{Existing, Folder},
};
use carom_methods::AnySimulation;
use carom_tables::without_numbers;
use carom_tables::{ReportUnits, Table};

/// The requests of a scene with these names in `run.observe`.
fn asked(names: &[&str]) -> Result<Vec<Request>> {
    let mut scene = Scene::default();
    scene.run.observe = names.iter().map(|&name| name.to_owned()).collect();
    requests(&scene)
}

#[test]
fn names_are_refused_with_their_reason() {
    for good in [
        "velocities",
        "velocities:gas",
        "contact-density:the_tee",
        "thermostat",
        "events:a,b",
        "pair-distribution:a,b",
        "structure-factor:a,b",
        "intermediate-scattering:a,b",
        "van-hove-distinct:a,b",
    ] {
        assert!(asked(&[good]).is_ok(), "{good}");
    }
    for (bad, said) in [
        ("colour", "unknown observer"),
        ("colour", "collision-rate"),
        ("presure", "did you mean `pressure`?"),
        ("contact-density", "contact-density:TAG"),
        ("impulses", "impulses:TAG"),
        ("thermostat:gas", "whole system"),
        ("velocities:", "letters"),
        ("velocities:../x", "letters"),
        ("velocities:a,b", "one tag"),
        ("events:a,b,c", "two tags"),
        ("structure-factor:a,b,c", "two tags"),
    ] {
        let error = format!("{:#}", asked(&[bad]).unwrap_err());
        assert!(error.contains(said), "{error}");
    }
    assert!(
        asked(&["energy", "energy"])
            .unwrap_err()
            .to_string()
            .contains("named twice")
    );
    let error = asked(&["impulses:a", "impulses:b"])
        .unwrap_err()
        .to_string();
    assert!(error.contains("same files"), "{error}");
}

#[test]
fn parameters_are_refused_by_name() {
    let refused = |entry: &str| {
        let text = format!(
            "[run]\nsample_interval = 0.1\nobserve = [\"velocities\"]\n[[measure]]\n{entry}"
        );
        format!(
            "{:#}",
            Scene::from_toml(&text)
                .map_err(anyhow::Error::from)
                .and_then(|s| requests(&s))
                .unwrap_err()
        )
    };
    for (entry, said) in [
        ("kind = \"velocity\"", "did you mean `velocities`?"),
        ("of = \"gas\"", "missing field `kind`"),
        (
            "kind = \"directions\"\nof = \"tee\"\nbin = 9",
            "did you mean `bins`?",
        ),
        (
            "kind = \"directions\"\nof = \"tee\"\nmax = 9",
            "expected one of kind, of, name, every, interval, from, until, bins",
        ),
        (
            "kind = \"directions\"\nof = \"tee\"\nbins = 0",
            "whole number from 1",
        ),
        (
            "kind = \"directions\"\nof = \"tee\"\nbins = 1e9",
            "whole number from 1",
        ),
        (
            "kind = \"directions\"\nof = \"tee\"\nbins = \"many\"",
            "'bins' must be a number",
        ),
        (
            "kind = \"correlation\"\nmax = -1.0",
            "'max' must be positive",
        ),
        (
            "kind = \"profile\"\naxis = \"z\"",
            "'axis' must be one of x, y, but is \"z\"",
        ),
        ("kind = \"profile\"\naxis = 1", "'axis' must be one of x, y"),
        (
            "kind = \"profile\"\npoint = [1.0, 2.0, 3.0]",
            "[x, y], but is [1.0, 2.0, 3.0]",
        ),
        ("kind = \"profile\"\npoint = 1.0", "two numbers"),
        ("kind = \"profile\"\nwall = 3", "the tag of a body"),
        (
            "kind = \"correlation\"\ninterval = 0.25",
            "multiple of run.sample_interval",
        ),
        (
            "kind = \"correlation\"\nevery = 2\ninterval = 0.2",
            "exclude each other",
        ),
        (
            "kind = \"k-atic\"\nk = 101",
            "'k' must be a whole number from 1 to 100, but is 101",
        ),
        ("kind = \"nematic\"\nk = 3", "unknown key 'k' of 'nematic'"),
        (
            "kind = \"tetratic\"\ncutoff = 0",
            "'cutoff' must be positive and finite, but is 0",
        ),
        (
            "kind = \"hexatic-order\"\nneighbours = \"voronoy\"",
            "one of nearest, delaunay, voronoi, but is \"voronoy\"; did you mean `voronoi`?",
        ),
        ("kind = \"correlation\"\nname = \"../x\"", "letters"),
        ("kind = \"events\"\nevery = 2", "unknown key 'every'"),
        (
            "kind = \"velocities\"\nbins = 9",
            "measure[0] would write the same files",
        ),
    ] {
        let error = refused(entry);
        assert!(error.contains(said), "{entry}: {error}");
    }
    assert!(refused("kind = \"correlation\"\nmax = -1.0").contains("measure[0]"));
}

#[test]
fn bodies_that_are_missing_or_not_unique_are_refused() {
    let mut scene = Scene::from_toml(
        "[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100",
    )
    .unwrap();
    let simulation = AnySimulation::new(&scene).unwrap();
    let mut refused = |name: &str| {
        scene.run.observe = vec![name.to_owned()];
        format!(
            "{:#}",
            Measures::new(&scene, &simulation.view())
                .err()
                .expect("an error")
        )
    };
    assert!(refused("velocities:none").contains("no body in the scene carries"));
    assert!(refused("events:gas,none").contains("no body in the scene carries"));
    for kind in ["contact-density", "drift", "impulses"] {
        assert!(refused(&format!("{kind}:gas")).contains("several bodies"));
    }
}

/// Runs a scene with its measures from time 0 and returns the results.
fn measured(text: &str) -> (Results, Result<HardDiscs, String>) {
    let scene = Scene::from_toml(text).unwrap();
    let mut simulation = AnySimulation::new(&scene).unwrap();
    let mut measures = Measures::new(&scene, &simulation.view()).unwrap();
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
    measures.finish(&simulation.view());
    let gas = HardDiscs::new(&simulation.view(), &scene.elasticity);
    (measures.results(&scene, &gas), gas)
}

#[test]
fn threads_take_the_samples_of_a_large_system_with_the_same_bits() {
    let scene = Scene::from_toml(
        "[box]\nseed = 5\n[[gas]]\nradius = 0.002\nmass = 1.0\nenergy = 1.0\ncount = 12000\ntags = [\"gas\"]\n\
         [run]\nuntil = 0.002\nsample_interval = 0.001\n\
         observe = [\"pressure\", \"correlation:gas\", \"pair-distribution:gas\", \"velocities:gas\"]\n",
    )
    .unwrap();
    let encoded = |threads| {
        let mut simulation = AnySimulation::new(&scene).unwrap();
        let mut measures = Measures::new(&scene, &simulation.view()).unwrap();
        measures.run_on(threads);
        simulation
            .sample_every(0.001, 0.002, &mut measures)
            .unwrap();
        encode(&measures).unwrap()
    };
    let expected = encoded(1);
    for threads in [2, 16] {
        assert!(encoded(threads) == expected, "{threads} threads");
    }
}

/// The bytes that each measure declares for a sample are those by which a checkpoint grows, apart
/// from small integers and absent values, which are shorter there.
#[test]
fn checkpoints_grow_by_the_declared_bytes_of_a_sample() {
    let gas = "[box]\nseed = 3\n[[wall]]\nx = 0.0\ntags = [\"wall\"]\ntemperature = 1.0\n[[molecule]]\nshape = \"tee\"\n\
               atom_radius = 0.02\natom_mass = 1.0\nat = [0.5, 0.5]\ntags = [\"tee\"]\n[[gas]]\nradius = 0.02\nmass = 1.0\n\
               energy = 1.0\ncount = 20\ntags = [\"gas\"]\n[run]\nuntil = 40.0\nsample_interval = 0.01\n";
    let left_out = ["impulses", "events"];
    for kind in KINDS.iter().filter(|kind| !left_out.contains(&kind.name)) {
        let tag = if kind.of == Of::OneBody { ":tee" } else { "" };
        let piston = match kind.name {
            "piston" => "[[piston]]\nx = 0.25\nmass = 5.0\nstops = [0.2, 0.3]\n",
            "chains" | "chain-relaxation" => {
                "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 8\n\
                 chain = { members = 4, tether = { max = 0.04 } }\n"
            }
            _ => "",
        };
        // A wall with a temperature draws velocities, which have no derivative.
        let gas = if kind.name == "lyapunov" {
            gas.replace("temperature = 1.0\n", "")
        } else {
            gas.to_owned()
        };
        let text = format!("{piston}{gas}observe = [\"{}{tag}\"]\n", kind.name);
        let scene = Scene::from_toml(&text).unwrap();
        let mut simulation = AnySimulation::new(&scene).unwrap();
        let mut measures = Measures::new(&scene, &simulation.view()).unwrap();
        measures.start(&simulation.view());
        measures.sample(&simulation.view());
        let mut lengths = Vec::new();
        for sample in 1..=4000 {
            simulation
                .observe_until(0.01 * f64::from(sample), &mut measures)
                .unwrap();
            measures.sample(&simulation.view());
            if sample % 2000 == 0 {
                lengths.push(encode(&measures).unwrap().len() as f64);
            }
        }
        let declared = measures.bytes_at_end(&scene.run) as f64 / 4001.0;
        let grown = (lengths[1] - lengths[0]) / 2000.0;
        assert!(
            (0.5..1.05).contains(&(grown / declared)),
            "{}: {declared} {grown}",
            kind.name
        );
    }
}

fn table<'a>(results: &'a Results, name: &str) -> &'a Table {
    results
        .tables
        .iter()
        .find(|table| table.name == name)
        .unwrap_or_else(|| panic!("no table {name}"))
}

fn column<'a>(table: &'a Table, name: &str) -> &'a [Option<f64>] {
    &table
        .columns
        .iter()
        .find(|column| column.name == name)
        .unwrap_or_else(|| panic!("no {name}"))
        .values
}

/// A gas with a molecule and most measures, with all lengths, masses and energies times powers of
/// two, so that both trajectories have the same bits apart from these factors.
fn gas_in_units([length, mass, energy]: [f64; 3]) -> String {
    let time = length * (mass / energy).sqrt();
    let measures = [
        "velocities:gas",
        "correlation",
        "pair-distribution:gas",
        "contact-density:tee",
        "thermostat",
        "directions:tee",
        "projections:tee",
        "drift:tee",
        "running-average:tee",
        "temperature:gas",
        "orientation:tee",
        "structure-factor",
        "hexatic-order:gas",
        "pressure-tensor",
        "free-path:gas",
        "viscosity",
        "heat-conductivity",
        "energy",
        "collision-rate",
        "pressure",
        "kicks:tee",
        "fields:gas",
        "profile:gas",
        "front:gas",
        "nematic:tee",
        "tetratic",
        "k-atic:tee",
        "body-frame-diffusion:tee",
        "relaxation:gas",
        "intermediate-scattering:gas,tee",
        "van-hove:gas",
        "lyapunov",
        "crossings:gas",
        "incidence:gas",
        "clusters:gas",
        "voronoi:gas",
        "currents:gas",
        "van-hove-distinct:gas,tee",
        "bond-order-correlation:gas",
        "bond-order-relaxation:gas",
        "cage-displacement:gas",
        "friction:gas",
        "overlap",
        "numbers:gas",
    ];
    format!(
        "[box]\nsides = [{length}, {length}]\n[[molecule]]\ntags = [\"tee\"]\nshape = \"tee\"\n\
         atom_radius = {r}\natom_mass = {mass}\nat = [{half}, {half}]\n[[gas]]\ntags = [\"gas\"]\n\
         radius = {r}\nmass = {mass}\nenergy = {energy}\ncount = 100\n[run]\nuntil = {until}\n\
         sample_interval = {interval}\nobserve = {measures:?}\n",
        r = length * 0.02,
        half = length * 0.5,
        until = time * 4.0,
        interval = time * 0.0625,
    )
}

/// The unit that a figure or a column names is the one by which it changes.
#[test]
fn results_in_reduced_units_do_not_depend_on_the_units_of_the_scene() {
    let [small, large] = [[1.0, 1.0, 1.0], [2.0, 4.0, 64.0]].map(|scale| {
        let (mut results, _) = measured(&gas_in_units(scale));
        let [length, mass, energy] = scale;
        let units = ReportUnits {
            length,
            mass,
            energy,
        };
        for figure in &mut results.figures {
            units.apply_to_figure(figure);
        }
        for table in &mut results.tables {
            units.apply_to_table(table);
        }
        results
    });
    let same = |a: Option<f64>, b: Option<f64>| match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() <= 1e-9 * a.abs().max(1e-3),
        (a, b) => a == b,
    };
    let mut wrong = Vec::new();
    for (a, b) in small.figures.iter().zip(&large.figures) {
        let pairs = [
            (Some(a.value), Some(b.value)),
            (a.standard_error, b.standard_error),
            (a.prediction, b.prediction),
        ];
        if !pairs.into_iter().all(|(a, b)| same(a, b)) {
            wrong.push(format!("{} ({}): {} {}", a.name, a.unit, a.value, b.value));
        }
    }
    for (a, b) in small.tables.iter().zip(&large.tables) {
        for (x, y) in a.columns.iter().zip(&b.columns) {
            let pairs = x.values.iter().zip(&y.values);
            if x.values.len() != y.values.len() || pairs.into_iter().any(|(&x, &y)| !same(x, y)) {
                wrong.push(format!("{}, {} ({})", a.name, x.name, x.unit));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
#[expect(clippy::too_many_lines, reason = "one scene with all measures")]
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
                "structure-factor", "hexatic-order:gas", "pressure-tensor", "free-path:gas", "viscosity",
                "heat-conductivity", "energy", "collision-rate", "pressure", "impulses:tee", "events:gas,tee",
                "kicks:tee", "fields:gas", "profile:gas", "front:gas", "nematic:tee", "tetratic", "k-atic:tee",
                "defects:gas", "body-frame-diffusion:tee", "relaxation:gas", "intermediate-scattering:gas,tee",
                "van-hove:gas", "lyapunov", "crossings:gas", "incidence:gas", "clusters:gas", "voronoi:gas",
                "currents:gas", "van-hove-distinct:gas,tee", "bond-order-correlation:gas", "bond-order-relaxation:gas",
                "structure-factor-map:gas,tee", "numbers:gas", "wells", "cage-displacement:gas",
                "bonded-clusters:gas"]
        "#,
    );
    assert!(gas.unwrap_err().contains("equal discs"));
    let root = tempfile::tempdir().unwrap();
    let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
    results.write(&folder).unwrap();
    let lines = |name: &str| {
        std::fs::read_to_string(root.path().join(name))
            .unwrap()
            .lines()
            .count()
    };
    assert_eq!(
        (lines("velocities-gas.csv"), lines("correlation.csv")),
        (22, 13)
    );
    // 100 discs of unit mass and energy: ⟨v²⟩ = 2 at first.
    let mean_square = column(table(&results, "velocities-gas"), "mean_square")[0].unwrap();
    assert!((mean_square - 2.0).abs() < 1e-12);
    let components = table(&results, "velocity-components-gas");
    assert!((integral(components, "density_x") - 1.0).abs() < 1e-12);
    // No pair is nearer than a diameter, which is 50 bins.
    let pairs = table(&results, "pair-distribution-gas");
    assert!(
        column(pairs, "pairs")[..49]
            .iter()
            .all(|count| *count == Some(0.0))
    );
    let near: f64 = column(pairs, "g")[51..76].iter().flatten().sum::<f64>() / 25.0;
    assert!((0.9..1.5).contains(&near), "{near}");
    assert!(
        column(table(&results, "contact-density-tee"), "contacts")
            .iter()
            .any(|count| *count > Some(0.0))
    );
    assert!(
        column(table(&results, "thermostat"), "put_in")
            .iter()
            .all(|energy| *energy == Some(0.0))
    );
    // Every measure has a result, each table one length, and each file one writer.
    for kind in KINDS {
        let is_of = |name: &str| name.starts_with(kind.name);
        let has_table = results.tables.iter().any(|table| is_of(&table.name));
        let has_file = results.files.iter().any(|file| is_of(file));
        // This scene has no walls, pistons or bonds, and nothing leaves a point.
        let is_absent = [
            "drift",
            "friction",
            "overlap",
            "wall-heat",
            "wall-pressure",
            "wall-work",
            "piston",
            "chains",
            "chain-relaxation",
            "front",
        ]
        .contains(&kind.name);
        assert!(has_table || has_file || is_absent, "{}", kind.name);
    }
    // The names by which a scene is refused before its bodies are placed are those of its figures.
    for figure in &results.figures {
        let begins = |kind: &MeasureKind| {
            kind.figures.iter().any(|begin| {
                without_numbers(&figure.name).starts_with(begin) || figure.name.starts_with(begin)
            })
        };
        assert!(
            KINDS.iter().any(begins),
            "no measure announces the figure {:?}",
            figure.name
        );
    }
    // Six of the drift, four of the orientation, two of the nematic order and two of the k-atic,
    // two of the contact density, five shares of the directions, and of the kicks: two rates,
    // six means and three energies, two times and that which a verdict needs, six shares, and
    // two of the geometry.
    assert_eq!(
        results
            .figures
            .iter()
            .filter(|figure| figure.name.ends_with(", tee"))
            .count(),
        43
    );
    for table in &results.tables {
        let rows = table.columns[0].values.len();
        assert!(
            rows > 0
                && table
                    .columns
                    .iter()
                    .all(|column| column.values.len() == rows),
            "{}",
            table.name
        );
    }
    let mut names: Vec<&String> = results.tables.iter().map(|table| &table.name).collect();
    names.sort();
    assert!(names.windows(2).all(|pair| pair[0] != pair[1]));
    // Shares of all sectors, and densities times the width of a bin, sum to 1.
    let shares: f64 = column(table(&results, "directions-tee"), "share_of_contacts")
        .iter()
        .flatten()
        .sum();
    assert!((shares - 1.0).abs() < 1e-12);
    let projections = table(&results, "projections-tee");
    assert!((integral(projections, "density_x") - 1.0).abs() < 1e-12);
}

/// The integral of a density over all bins of a table.
fn integral(table: &Table, name: &str) -> f64 {
    let (density, widths) = (column(table, name), column(table, "bin_width"));
    density
        .iter()
        .zip(widths)
        .map(|(density, width)| density.unwrap() * width.unwrap())
        .sum()
}

fn figure<'a>(results: &'a Results, name: &str) -> Option<&'a Figure> {
    results.figures.iter().find(|figure| figure.name == name)
}

#[test]
fn homogeneous_discs_cool_by_haffs_law() {
    let (results, _) = measured(
        "[box]\nseed = 3\n[elasticity]\ndefault = 0.95\n[[gas]]\nradius = 0.005\nmass = 1.0\ntemperature = 1.0\n\
         velocities = \"maxwell\"\ncount = 1000\n[run]\nuntil = 2.0\nsample_interval = 0.05\nobserve = [\"temperature\"]\n",
    );
    let table = table(&results, "temperature");
    let measured = column(table, "translation");
    let law = table
        .columns
        .iter()
        .find(|column| column.label.starts_with("Haff"))
        .unwrap();
    let last = measured.last().unwrap().unwrap();
    assert!(last < 0.5, "{last}");
    for (measured, law) in measured.iter().zip(&law.values) {
        let ratio = measured.unwrap() / law.unwrap();
        assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
    }
    assert!(!table.caption.contains("equilibrium"));
}

/// A gas of 150 bodies of this shape, with more in the scene, and the viscosity and the heat
/// conductivity of it.
fn transport(shape: &str, more: &str) -> (Results, Option<HardDiscs>) {
    let (results, gas) = measured(&format!(
        "[box]\nseed = 5\n[[gas]]\n{shape}\ntemperature = 1.0\nvelocities = \"maxwell\"\ncount = 150\n{more}\n\
         [run]\nuntil = 80.0\nsample_interval = 0.01\nobserve = [\"viscosity\", \"heat-conductivity\"]\n"
    ));
    (results, gas.ok())
}

/// The two coefficients of a run.
fn coefficients(results: &Results) -> [Option<&Figure>; 2] {
    [
        "shear viscosity, from lags",
        "heat conductivity λ/k, from lags",
    ]
    .map(|begin| {
        let mut figures = results.figures.iter();
        figures.find(|figure| figure.name.starts_with(begin))
    })
}

/// Two atoms at nearly one place are a disc of the same mass that turns without being touched: they
/// have the coefficients of discs, although no theory of discs is asked.
#[test]
fn bodies_of_any_shape_have_a_viscosity() {
    let (discs, gas) = transport("radius = 0.02\nmass = 1.0", "");
    let gas = gas.expect("they are equal discs");
    let [viscosity, conductivity] = coefficients(&discs).map(|figure| figure.expect("discs"));
    assert_eq!(viscosity.prediction, Some(gas.viscosity()));
    assert_eq!(conductivity.prediction, Some(gas.heat_conductivity()));
    let pair = "atoms = [{ at = [1e-7, 0], radius = 0.02, mass = 0.5 }, { at = [-1e-7, 0], radius = 0.02, mass = 0.5 }]";
    let (pairs, none) = transport(pair, "");
    assert!(none.is_none());
    let found = coefficients(&pairs).map(|figure| figure.expect("molecules"));
    // Their rotation carries heat without being exchanged: only the viscosity is that of discs.
    for (figure, exact) in [
        (viscosity, gas.viscosity()),
        (conductivity, gas.heat_conductivity()),
        (found[0], gas.viscosity()),
    ] {
        let error = figure.standard_error.expect("there are blocks");
        let away = (figure.value - exact).abs() / error;
        assert!(away < 4.0 && error < 0.2 * exact, "{figure:?}, {exact}");
    }
    assert_eq!(found[0].prediction, None);
}

#[test]
fn slopes_that_are_no_coefficient_are_called_so() {
    let disc = "radius = 0.02\nmass = 1.0";
    let caption = |results: &Results, name: &str| table(results, name).caption.clone();
    let (walled, _) = transport(disc, "[[wall]]\nx = 0.0");
    assert_eq!(coefficients(&walled), [None; 2]);
    assert!(caption(&walled, "viscosity").contains("walls take up momentum"));
    let heavy = "[[gas]]\nradius = 0.02\nmass = 3.0\ntemperature = 1.0\ncount = 50";
    let (mixed, _) = transport(disc, heavy);
    assert!(matches!(coefficients(&mixed), [Some(_), None]));
    assert!(caption(&mixed, "heat-conductivity").contains("the bodies differ"));
    let (cooling, _) = transport(disc, "[elasticity]\ndefault = 0.9");
    assert_eq!(coefficients(&cooling), [None; 2]);
    assert!(walled.silent.is_empty() && mixed.silent.is_empty() && cooling.silent.is_empty());
}

/// A disc of 25 times the mass of the others, from rest.
fn tracer(measure: &str) -> Results {
    let scene = format!(
        "[box]\nseed = 3\n[[molecule]]\ntags = [\"t\"]\n\
         atoms = [{{ at = [0, 0], radius = 0.06, mass = 25 }}]\nat = [0.5, 0.5]\n\
         [[gas]]\nradius = 0.015\nmass = 1.0\ntemperature = 1.0\narea_fraction = 0.2\n\
         [run]\nuntil = 40.0\nsample_interval = 0.05\n{measure}"
    );
    measured(&scene).0
}

#[test]
fn the_velocities_of_a_body_that_starts_at_rest_are_all_in_the_bins() {
    let results = tracer("observe = [\"velocities:t\", \"projections:t\"]");
    for name in ["density_x", "density_y"] {
        let components = table(&results, "velocity-components-t");
        assert!((integral(components, name) - 1.0).abs() < 1e-12, "{name}");
        // σ is 0.2 at equilibrium.
        let range = column(components, "velocity").last().unwrap().unwrap();
        assert!((0.3..3.0).contains(&range), "{range}");
        assert!(
            (integral(table(&results, "projections-t"), name) - 1.0).abs() < 1e-12,
            "{name}"
        );
    }
    assert!((integral(table(&results, "speeds-t"), "density") - 1.0).abs() < 1e-12);
    // A predicted density has the same integral.
    assert!((integral(table(&results, "speeds-t"), "density_predicted") - 1.0).abs() < 1e-3);
    assert!(figure(&results, "share of the speeds outside the range, t").is_none());
}

#[test]
fn what_lies_outside_a_given_range_is_counted() {
    let results = tracer("[[measure]]\nkind = \"velocities\"\nof = \"t\"\nmax = 0.2\nbins = 10");
    let speeds = table(&results, "speeds-t");
    let outside = figure(&results, "share of the speeds outside the range, t").unwrap();
    assert_eq!(speeds.rows().len(), 10);
    assert!((0.1..0.9).contains(&outside.value), "{outside:?}");
    assert!((integral(speeds, "density") + outside.value - 1.0).abs() < 1e-12);
    assert!(
        speeds.caption.contains("outside the given range"),
        "{}",
        speeds.caption
    );
    assert!(
        figure(
            &results,
            "share of the velocity components outside the range, t"
        )
        .is_some()
    );
}

/// ⟨v⁴⟩/⟨v²⟩² is 2 for a Gaussian velocity, and 1 at each time for one body.
#[test]
fn the_kurtosis_of_one_body_is_that_of_its_velocities_at_all_times() {
    let results = tracer("measure_from = 10.0\nobserve = [\"velocities:t\"]");
    let found = figure(&results, "kurtosis of the velocity over time ⟨v⁴⟩/⟨v²⟩², t").unwrap();
    let (error, prediction) = (found.standard_error.unwrap(), found.prediction.unwrap());
    assert!(
        (found.value - prediction).abs() < 4.0 * error && (1.9..2.0).contains(&prediction),
        "{found:?}"
    );
    assert!((0.01..0.5).contains(&error), "{found:?}");
    assert!(figure(&results, "kurtosis of the velocities ⟨v⁴⟩/⟨v²⟩², t").is_none());
    assert!(
        !table(&results, "velocities-t")
            .header()
            .contains(&"kurtosis")
    );
}

/// Gases that heat or cool by a factor of 10 in speed: all velocities are in the bins, and those of
/// most samples lie in many.
#[test]
fn the_velocities_of_a_gas_whose_temperature_changes_are_all_in_the_bins() {
    for (first, then) in [(0.01, 1.0), (1.0, 0.0001)] {
        let (results, _) = measured(&format!(
            "[[wall]]\nx = 0.0\ntemperature = {then:?}\n[[gas]]\nradius = 0.01\nmass = 1.0\n\
             temperature = {first:?}\ncount = 100\n\
             [run]\nuntil = 60.0\nsample_interval = 0.1\nobserve = [\"velocities\"]"
        ));
        let (components, speeds) = (
            table(&results, "velocity-components"),
            table(&results, "speeds"),
        );
        assert!(
            (integral(components, "density_x") - 1.0).abs() < 1e-12,
            "{first} {then}"
        );
        assert!(
            (integral(speeds, "density") - 1.0).abs() < 1e-12,
            "{first} {then}"
        );
        let most = column(speeds, "density")
            .iter()
            .zip(column(speeds, "bin_width"));
        let most = most
            .map(|(density, width)| density.unwrap() * width.unwrap())
            .fold(0.0, f64::max);
        assert!(most < 0.25, "{first} {then}: {most}");
    }
}

#[test]
fn the_mean_velocity_is_relative_to_the_centre_of_mass() {
    let gas = "[[gas]]\ntags = [\"gas\"]\nradius = 0.01\nmass = 1.0\ntemperature = 1.0\nzero_momentum = false\n\
               count = 50\n[[molecule]]\ntags = [\"heavy\"]\natoms = [{ at = [0, 0], radius = 0.05, mass = 50 }]\n\
               at = [0.5, 0.5]\nvelocity = [3.0, 0.0]\n\
               [run]\nuntil = 1.0\nsample_interval = 0.1\nobserve = [\"temperature\", \"temperature:gas\", \"temperature:heavy\"]";
    let (results, _) = measured(gas);
    // 0 by definition: no figure, but words.
    assert!(figure(&results, "mean velocity along x").is_none());
    assert!(
        table(&results, "temperature")
            .caption
            .contains("along x and y is conserved, and 0")
    );
    // Both have half of the mass.
    let of = |tag: &str| {
        figure(&results, &format!("mean velocity along x, {tag}"))
            .unwrap()
            .value
    };
    assert!(
        (of("gas") + of("heavy")).abs() < 1e-12 && of("heavy") > 0.5,
        "{}",
        of("heavy")
    );
    let (results, _) = measured(&format!("[[wall]]\nx = 0.0\n{gas}"));
    assert!(
        figure(&results, "mean velocity along x").is_some()
            && figure(&results, "mean velocity along y").is_none()
    );
    assert!(
        table(&results, "temperature")
            .caption
            .contains("along y is conserved")
    );
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
            observe = ["velocities", "correlation", "pair-distribution", "friction"]
        "#,
    );
    let gas = gas.unwrap();
    let correlation = table(&results, "correlation");
    let (lags, found) = (
        column(correlation, "lag"),
        column(correlation, "velocity_autocorrelation"),
    );
    let errors = column(correlation, "velocity_autocorrelation_error");
    let predicted = column(correlation, "velocity_autocorrelation_predicted");
    // At the first lag the exponential is exact up to second order in Γ t.
    let (lag, rate) = (lags[1].unwrap(), gas.collision_rate());
    let off = found[1].unwrap() - predicted[1].unwrap();
    let second_order = found[0].unwrap() * (rate * lag).powi(2);
    assert!(
        off.abs() < 5.0 * errors[1].unwrap() + second_order,
        "{off} {errors:?}"
    );
    assert!(errors[1].unwrap() < 0.02 * found[0].unwrap());
    // Discs move freely at first: the mean squared displacement is ⟨v²⟩ t².
    let squares = column(correlation, "mean_square_displacement");
    assert!((squares[1].unwrap() / (found[0].unwrap() * lag * lag) - 1.0).abs() < rate * lag);
    let figure = |part: &str| {
        results
            .figures
            .iter()
            .find(|figure| figure.name.contains(part))
            .unwrap()
    };
    for part in [
        "at contact",
        "kurtosis",
        "friction coefficient Σ|J|²",
        "initial decay",
    ] {
        let figure = figure(part);
        let (off, error) = (
            figure.value - figure.prediction.unwrap(),
            figure.standard_error.unwrap(),
        );
        assert!(
            off.abs() < 5.0 * error && error < 0.05 * figure.value,
            "{part}: {figure:?}"
        );
    }
    // The tail of the autocorrelation makes it larger than in Enskog's theory.
    let diffusion = figure("diffusion");
    assert!(
        (0.9..1.3).contains(&(diffusion.value / diffusion.prediction.unwrap())),
        "{diffusion:?}"
    );
}

#[test]
fn the_heat_of_walls_is_that_of_the_ledger() {
    let text = "[[wall]]\ntags = [\"hot\"]\nx = 0.0\ntemperature = 4.0\n[[wall]]\ntags = [\"cold\"]\nx = 0.5\ntemperature = 1.0\n\
                [[gas]]\nradius = 0.01\nmass = 1.0\ntemperature = 2.0\ncount = 100\n\
                [run]\nuntil = 20.0\nsample_interval = 0.1\nobserve = [\"thermostat\", \"wall-heat\", \"wall-heat:hot\", \"wall-heat:cold\"]";
    let (results, _) = measured(text);
    let last = |name: &str| {
        column(table(&results, name), "heat")
            .last()
            .copied()
            .flatten()
            .unwrap()
    };
    let (all, hot, cold) = (
        last("wall-heat"),
        last("wall-heat-hot"),
        last("wall-heat-cold"),
    );
    let booked: f64 = column(table(&results, "thermostat"), "heat")
        .iter()
        .flatten()
        .sum();
    assert!(
        (all - booked).abs() < 1e-10 * hot && (hot + cold - all).abs() < 1e-10 * hot,
        "{hot} {cold} {all}"
    );
    assert!(hot > 0.0 && cold < 0.0);
    let figure = results
        .figures
        .iter()
        .find(|figure| figure.name == "heat received from walls, hot")
        .unwrap();
    assert!((figure.value - hot / 20.0).abs() < 1e-9 * hot && figure.standard_error.is_some());
    let text = "run.observe = [\"wall-heat\"]\n[[gas]]\nradius = 0.01\nmass = 1.0\ntemperature = 2.0\ncount = 100";
    let gas = Scene::from_toml(text).unwrap();
    let simulation = AnySimulation::new(&gas).unwrap();
    let error = Measures::new(&gas, &simulation.view())
        .err()
        .expect("no wall");
    assert!(
        format!("{error:#}").contains("no such wall has a temperature"),
        "{error:#}"
    );
}

#[test]
fn the_pressure_on_walls_is_that_of_the_bulk() {
    let gas = "[[gas]]\nradius = 0.01\nmass = 1.0\ntemperature = 2.0\nvelocities = \"maxwell\"\ncount = 300\n\
               [run]\nuntil = 20.0\nsample_interval = 0.05\nobserve = [\"wall-pressure\"]";
    let (results, _) = measured(&format!("[[wall]]\ny = 0.0\n{gas}"));
    let figure = results
        .figures
        .iter()
        .find(|figure| figure.name == "pressure on the walls")
        .unwrap();
    let (off, error) = (
        figure.value - figure.prediction.unwrap(),
        figure.standard_error.unwrap(),
    );
    assert!(
        off.abs() < 4.0 * error && error < 0.02 * figure.value,
        "{figure:?}"
    );
    // Under gravity the density differs at each height.
    let has_bulk = |results: &Results| {
        let mut names = results.figures.iter().map(|figure| &figure.name);
        names.any(|name| name == "density far from the walls")
    };
    let falling = format!("[gravity]\nacceleration = [0.0, -4.0]\n[[wall]]\ny = 0.0\n{gas}");
    assert!(has_bulk(&results) && !has_bulk(&measured(&falling).0));
    // No centre is nearer to a wall than a radius, and the density at contact exceeds the mean.
    let density = column(table(&results, "wall-pressure"), "density");
    assert_eq!(
        (density.len(), density[0], density[1]),
        (100, Some(0.0), Some(0.0))
    );
    assert!(density[2].unwrap() > density[50].unwrap());
    for (walls, expected) in [
        ("", "no such wall"),
        ("[[wall]]\nfrom = [0.1, 0.5]\nto = [0.9, 0.5]\n", "parallel"),
    ] {
        let scene = Scene::from_toml(&format!("{walls}{gas}")).unwrap();
        let simulation = AnySimulation::new(&scene).unwrap();
        let error = Measures::new(&scene, &simulation.view())
            .err()
            .expect("no pressure");
        assert!(format!("{error:#}").contains(expected), "{error:#}");
    }
}

#[test]
fn a_gas_of_molecules_has_no_direction_and_no_flow() {
    let (results, _) = measured(
        "[[gas]]\ntags = [\"tees\"]\nshape = \"tee\"\natom_radius = 0.01\natom_mass = 1.0\ntemperature = 1.0\n\
         velocities = \"maxwell\"\ncount = 60\n[run]\nuntil = 20.0\nsample_interval = 0.1\n\
         observe = [\"orientation:tees\", \"temperature:tees\"]",
    );
    for name in ["mean cos θ, tees", "mean cos 4θ, tees"] {
        let figure = results
            .figures
            .iter()
            .find(|figure| figure.name == name)
            .unwrap();
        let error = figure.standard_error.unwrap();
        assert!(
            figure.value.abs() < 4.0 * error && error < 0.1,
            "{figure:?}"
        );
        assert_eq!(figure.prediction, Some(0.0));
    }
    // All bodies are tees, whose mean velocity is 0 by definition.
    assert!(
        results
            .figures
            .iter()
            .all(|figure| !figure.name.starts_with("mean velocity"))
    );
}

/// The time before `measure_from` is left out, and each measure has its own interval.
#[test]
fn measures_begin_late_and_have_their_own_intervals() {
    let (results, _) = measured(
        r#"
            [[gas]]
            radius = 0.02
            mass = 1.0
            energy = 1.0
            count = 50
            [run]
            until = 1.05
            sample_interval = 0.05
            measure_from = 0.43
            observe = ["collision-rate", "energy"]
            [[measure]]
            kind = "pressure"
            every = 2
            [[measure]]
            kind = "pressure"
            name = "coarse"
            interval = 0.25
            [[measure]]
            kind = "correlation"
            every = 3
            max = 0.3
        "#,
    );
    let times = |name: &str| -> Vec<f64> {
        column(table(&results, name), "time")
            .iter()
            .map(|time| time.unwrap())
            .collect()
    };
    // The first sample at or after 0.43 is that at 0.45, so the first interval ends at 0.5.
    let rates = times("collision-rate");
    assert_eq!(rates.len(), 12);
    assert!((rates[0] - 0.5).abs() < 1e-12);
    assert_eq!(times("energy").len(), 22);
    assert_eq!(times("pressure").len(), 6);
    assert!((times("pressure")[0] - 0.55).abs() < 1e-12);
    // 0.7, 0.95, and the rest of the run.
    assert_eq!(times("pressure-coarse").len(), 3);
    let lags = column(table(&results, "correlation"), "lag");
    assert_eq!(
        lags.iter()
            .map(|lag| (100.0 * lag.unwrap()).round())
            .collect::<Vec<_>>(),
        [0.0, 15.0, 30.0]
    );
    // The mean is that over the whole time, whatever the interval.
    let mean = |name: &str| {
        results
            .figures
            .iter()
            .find(|figure| figure.name == name)
            .unwrap()
            .value
    };
    assert!((mean("pressure") / mean("pressure, coarse") - 1.0).abs() < 1e-9);
}

/// Streamed files have the columns of their tables.
#[test]
fn files_that_grow_with_the_run_have_the_columns_of_their_tables() {
    use crate::series;
    let (results, _) = measured(
        r#"
            [[gas]]
            radius = 0.02
            mass = 1.0
            energy = 1.0
            count = 50
            [run]
            until = 0.2
            sample_interval = 0.1
            observe = ["pressure", "collision-rate", "energy"]
        "#,
    );
    assert_eq!(table(&results, "energy").header(), series::ENERGY.header);
    assert_eq!(
        table(&results, "pressure").header(),
        series::PRESSURE.header
    );
    assert_eq!(
        table(&results, "collision-rate").header(),
        series::RATES.header
    );
}

#[test]
fn measures_of_order_are_refused_with_the_value_and_the_range() {
    let mut scene = Scene::from_toml(
        "[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 20\n\
         [[molecule]]\ntags = [\"rod\"]\nshape = \"rod:3\"\natom_radius = 0.01\natom_mass = 1.0\nat = [0.5, 0.5]",
    )
    .unwrap();
    let simulation = AnySimulation::new(&scene).unwrap();
    let mut refused = |entry: &str| {
        let text = format!("[[measure]]\n{entry}");
        scene.measure = Scene::from_toml(&text).unwrap().measure;
        let started = Measures::new(&scene, &simulation.view());
        started
            .err()
            .map(|error| format!("{error:#}"))
            .unwrap_or_default()
    };
    for kind in ["nematic", "tetratic", "k-atic", "body-frame-diffusion"] {
        let error = refused(&format!("kind = \"{kind}\"\nof = \"gas\""));
        assert!(
            error.contains("no body of it has an axis"),
            "{kind}: {error}"
        );
        assert_eq!(refused(&format!("kind = \"{kind}\"")), "");
    }
    for key in ["cutoff", "distance"] {
        let error = refused(&format!("kind = \"nematic\"\nof = \"rod\"\n{key} = 0.5"));
        assert!(
            error.contains("0.5 must be less than half the shorter side of the box, 0.5"),
            "{error}"
        );
    }
    let error = refused("kind = \"hexatic-order\"\nneighbours = \"delaunay\"\nk = 4");
    assert!(error.contains("neighbours = \"nearest\""), "{error}");
    // Discs get an axis from the thermostat of a stage.
    let driven = Scene::from_toml(
        "[[stage]]\nname = \"drive\"\nuntil = 1.0\n\
         thermostat = [{ tag = \"gas\", kind = \"active\", every = 0.1, speed = 1.0, rotational_diffusion = 1.0 }]",
    );
    scene.stage = driven.unwrap().stage;
    scene.run.observe = vec!["nematic:gas".to_owned()];
    scene.measure.clear();
    assert!(Measures::new(&scene, &simulation.view()).is_ok());
}

/// Squares on a lattice, alternately a quarter turn apart: planted answers in all tables.
#[test]
fn planted_order_is_in_the_tables() {
    let rods: Vec<String> = (0..100)
        .map(|k| {
            let [x, y] = [k % 10, k / 10].map(|n| 0.1 * f64::from(n) + 0.03);
            let turned = 0.25 * f64::from((k + k / 10) % 2);
            format!(
                "[[molecule]]\ntags = [\"rod\"]\nshape = \"rod:3\"\natom_radius = 0.005\natom_mass = 1.0\n\
                 at = [{x:?}, {y:?}]\norientation_turns = {turned}\n"
            )
        })
        .collect();
    let (results, _) = measured(&format!(
        "{}[run]\nuntil = 4.0\nsample_interval = 0.1\n\
         observe = [\"nematic\", \"tetratic:rod\", \"defects\", \"body-frame-diffusion\"]\n\
         [[measure]]\nkind = \"k-atic\"\nk = 8\ndistance = 0.11\nbins = 10\nmax = 1.0\ncutoff = 0.12\n\
         [[measure]]\nkind = \"hexatic-order\"\nname = \"square\"\nn = 4\nneighbours = \"voronoi\"\n",
        rods.concat()
    ));
    let value = |name: &str| {
        figure(&results, name)
            .unwrap_or_else(|| panic!("no {name}"))
            .value
    };
    for (name, expected) in [
        ("order S₂", 0.0),
        ("order S₄, rod", 1.0),
        ("mean square order S₄², rod", 1.0),
        ("order S₈", 1.0),
        ("local order cos 8Δθ", 1.0),
        ("mean |ψ₄| of the bodies, square", 1.0),
        ("|mean ψ₄|, square", 1.0),
        // A square lattice: the cells have four sides.
        ("share of disclinations", 1.0),
        ("mean square charge (6 − z)²", 4.0),
    ] {
        assert!(
            (value(name) - expected).abs() < 1e-9,
            "{name}: {}",
            value(name)
        );
    }
    let pairs = table(&results, "k-atic-distance");
    let counts = column(pairs, "pairs");
    assert_eq!((counts.len(), counts[9]), (10, Some(400.0 * 41.0)));
    assert!((column(pairs, "g")[9].unwrap() - 1.0).abs() < 1e-9);
    let lags = table(&results, "k-atic-lag");
    for name in ["of_body", "of_group"] {
        let values = column(lags, name);
        assert!(values.len() == 11 && (values[10].unwrap() - 1.0).abs() < 1e-9);
    }
    assert_eq!(table(&results, "defects-list").rows().len(), 100);
    let drawing = results
        .drawings
        .iter()
        .find(|drawing| drawing.file == "defects.svg");
    assert_eq!(drawing.unwrap().svg.matches("#cc79a7").count(), 100);
    assert_eq!(
        column(table(&results, "body-frame-diffusion"), "square_along")[3],
        Some(0.0)
    );
}

/// Every parameter of every kind changes the tables.
#[test]
fn parameters_have_their_effect() {
    let (results, _) = measured(
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
            until = 1.0
            sample_interval = 0.1
            observe = ["directions:tee"]
            [[measure]]
            kind = "directions"
            of = "tee"
            name = "coarse"
            bins = 8
            [[measure]]
            kind = "projections"
            of = "tee"
            bins = 10
            max = 4.0
            [[measure]]
            kind = "contact-density"
            of = "tee"
            bins = 12
            [[measure]]
            kind = "pair-distribution"
            bins = 20
            max = 0.1
            [[measure]]
            kind = "free-path"
            bins = 7
            max = 0.07
            [[measure]]
            kind = "structure-factor"
            shells = 5
            [[measure]]
            kind = "velocities"
            bins = 6
            [[measure]]
            kind = "viscosity"
            max = 0.2
            [[measure]]
            kind = "heat-conductivity"
            max = 0.3
            [[measure]]
            kind = "orientation"
            max = 0.4
        "#,
    );
    let rows = |name: &str| table(&results, name).rows().len();
    assert_eq!((rows("directions-tee"), rows("directions-coarse")), (72, 8));
    let impulses = column(table(&results, "projections-tee"), "impulse");
    assert_eq!((impulses.len(), impulses[0]), (10, Some(-3.6)));
    assert_eq!(rows("contact-density-tee.by-angle"), 12);
    let distances = column(table(&results, "pair-distribution"), "distance");
    assert!(distances.len() == 20 && (distances[19].unwrap() - 0.0975).abs() < 1e-12);
    let lengths = column(table(&results, "free-path"), "length");
    assert!(lengths.len() == 7 && (lengths[0].unwrap() - 0.005).abs() < 1e-12);
    assert_eq!(
        (
            rows("structure-factor"),
            rows("speeds"),
            rows("velocity-components")
        ),
        (5, 6, 12)
    );
    assert_eq!(
        (
            rows("viscosity"),
            rows("heat-conductivity"),
            rows("orientation")
        ),
        (3, 4, 5)
    );
}

#[test]
fn parameters_of_correlations_in_time_have_their_effect() {
    let (results, _) = measured(
        r#"
            [[gas]]
            radius = 0.02
            mass = 1.0
            energy = 1.0
            count = 100
            [run]
            until = 1.0
            sample_interval = 0.1
            [[measure]]
            kind = "relaxation"
            k = 1e-6
            a = 1e3
            max = 0.5
            [[measure]]
            kind = "intermediate-scattering"
            k = 6.283185307179586
            shells = 1
            max = 0.2
            [[measure]]
            kind = "van-hove"
            distance = 0.3
            bins = 6
            max = 0.3
        "#,
    );
    // No body leaves such a distance, and none moves over such a wave.
    let relaxation = table(&results, "relaxation");
    assert_eq!(column(relaxation, "overlap"), [Some(1.0); 6]);
    assert!(column(relaxation, "self_scattering")[5] > Some(1.0 - 1e-9));
    // 11 samples of two wave vectors are too few at lag 0.
    assert!(
        results
            .tables
            .iter()
            .all(|table| table.name != "intermediate-scattering")
    );
    let displacements = column(table(&results, "van-hove"), "displacement");
    assert!(displacements.len() == 6 && (displacements[5].unwrap() - 0.275).abs() < 1e-12);
    assert_eq!(table(&results, "van-hove").header().len(), 2 + 2 * 3);
}

/// A dilute gas of two masses over a small part of its free time.
#[test]
fn displacements_of_a_dilute_gas_are_those_of_free_flight() {
    let gas = |tag: &str, mass: f64| {
        format!(
            "[[gas]]\ntags = [\"{tag}\"]\nradius = 0.0005\nmass = {mass:?}\ntemperature = 1.0\n\
             velocities = \"maxwell\"\ncount = 200\n"
        )
    };
    let (results, _) = measured(&format!(
        "[box]\nseed = 7\n{}{}[run]\nuntil = 20.0\nsample_interval = 0.001\n\
         [[measure]]\nkind = \"relaxation\"\nof = \"light\"\nk = 500.0\na = 0.002\nmax = 0.006\n\
         [[measure]]\nkind = \"relaxation\"\nk = 500.0\na = 0.002\nmax = 0.006\n\
         [[measure]]\nkind = \"van-hove\"\ndistance = 0.01\nbins = 5\nmax = 0.003\n",
        gas("light", 1.0),
        gas("heavy", 4.0)
    ));
    let near = |table: &Table, name: &str, row: usize, expected: f64| {
        let found = column(table, name)[row].unwrap();
        let error = column(table, &format!("{name}_error"))[row].unwrap();
        // The contacts within the lag change it by less than 0.2 %.
        let allowed = 5.0 * error + 0.002 * expected.abs();
        assert!(
            (found - expected).abs() < allowed,
            "{name} {row}: {found} ± {error}, not {expected}"
        );
        assert!(
            error < 0.1 * expected.abs().max(0.5),
            "{name} {row}: {error}"
        );
    };
    for name in ["relaxation", "relaxation-light"] {
        let table = table(&results, name);
        for row in 1..=4 {
            let predicted = column(table, "self_scattering_predicted")[row].unwrap();
            near(table, "self_scattering", row, predicted);
        }
    }
    let [all, light] = ["relaxation", "relaxation-light"].map(|name| table(&results, name));
    // Velocities are Gaussian for one mass; for both ⟨1/m²⟩/⟨1/m⟩² − 1.
    near(light, "non_gaussian", 2, 0.0);
    near(all, "non_gaussian", 2, 0.36);
    // Q = 1 − exp(−x) with x = a²/2t² = 1/2. A part of a gas has the fluctuations of its own energy
    // nearly.
    near(light, "overlap", 2, 1.0 - f64::exp(-0.5));
    let chi = column(light, "chi_4")[2].unwrap();
    assert!((0.12..0.25).contains(&chi), "{chi}");
    let distances = table(&results, "van-hove");
    for name in ["density_at_0.001", "density_at_0.003"] {
        let predicted = column(distances, &format!("{name}_predicted"))[1].unwrap();
        near(distances, name, 1, predicted);
    }
    let tau = figure(&results, "relaxation time τ of F_s, light").unwrap();
    // k² t²/2 = 1.
    let error = tau.standard_error.unwrap();
    let expected = 2f64.sqrt() / 500.0;
    assert!(
        (tau.value - expected).abs() < 5.0 * error && error < 0.03 * expected,
        "{tau:?}"
    );
}

/// Currents against free flight, and G_d at lag 0, g₆ and S(k_x, k_y) against other measures.
#[test]
fn currents_and_functions_of_places_agree_with_other_measures() {
    let (results, _) = measured(
        r#"
            [box]
            seed = 5
            [[gas]]
            radius = 0.002
            mass = 2.0
            temperature = 3.0
            velocities = "maxwell"
            count = 100
            [run]
            until = 8.0
            sample_interval = 0.002
            observe = ["hexatic-order"]
            [[measure]]
            kind = "currents"
            k = 60.0
            shells = 4
            max = 0.012
            [[measure]]
            kind = "pair-distribution"
            bins = 8
            max = 0.3
            every = 40
            [[measure]]
            kind = "van-hove-distinct"
            bins = 8
            distance = 0.3
            max = 0.1
            every = 40
            [[measure]]
            kind = "bond-order-correlation"
            bins = 8
            max = 0.3
            every = 40
            [[measure]]
            kind = "structure-factor"
            shells = 1
            every = 40
            [[measure]]
            kind = "structure-factor-map"
            max = 20.0
            every = 40
        "#,
    );
    let currents = table(&results, "currents");
    for row in 0..=3 {
        for name in ["longitudinal", "transverse"] {
            let [found, error, predicted] = ["", "_error", "_predicted"]
                .map(|end| column(currents, &format!("{name}{end}"))[row].unwrap());
            assert!(
                (found - predicted).abs() < 5.0 * error + 0.01 * predicted.abs() && error < 0.1,
                "{name} {row}: {found} ± {error}, not {predicted}"
            );
        }
    }
    // x = 60² · 1.5 · 0.008²: the longitudinal current has decayed more.
    let last = |name: &str| column(currents, name)[4].unwrap();
    assert!(last("longitudinal") < 0.9 * last("transverse"));
    let g = column(table(&results, "pair-distribution"), "g");
    let at_0 = column(table(&results, "van-hove-distinct"), "density_at_0");
    for (g, density) in g.iter().zip(at_0) {
        assert!((density.unwrap() / 99.0 - g.unwrap()).abs() < 1e-9);
    }
    let order = table(&results, "bond-order-correlation");
    assert_eq!(
        order.header(),
        ["distance", "pairs", "correlation", "correlation_error"]
    );
    assert!(column(order, "correlation")[7].unwrap().abs() < 0.01);
    let map = table(&results, "structure-factor-map");
    let grid = map.grid().unwrap();
    assert_eq!(grid.counts, [7, 7]);
    let s = column(map, "s");
    assert_eq!((s[24], s[23], s[31]), (None, s[25], s[17]));
    let mean = 0.5 * (s[25].unwrap() + s[31].unwrap());
    let shell = column(table(&results, "structure-factor"), "s")[0].unwrap();
    assert!((mean - shell).abs() < 1e-12, "{mean} {shell}");
}

/// Equilibrium pushes no free body on average; it pushes a fixed one towards its neighbour.
#[test]
fn only_the_mean_force_on_a_body_that_moves_is_predicted_to_vanish() {
    let scene = |tee: &str, more: &str| {
        format!(
            "[[molecule]]\ntags = [\"tee\"]\nshape = \"tee\"\natom_radius = 0.01\natom_mass = 1.0\nat = [0.3, 0.3]\n{tee}\n\
             [[bumper]]\nradius = 0.05\nat = [0.4, 0.3]\n\
             [[gas]]\ntags = [\"gas\"]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 50\n{more}\n\
             [run]\nobserve = [\"drift:tee\"]\nsample_interval = 0.1\n"
        )
    };
    let predictions = |tee: &str, more: &str| {
        let (results, _) = measured(&scene(tee, more));
        let figures = results
            .figures
            .iter()
            .filter(|figure| figure.name.ends_with(", tee"));
        figures.map(|figure| figure.prediction).collect::<Vec<_>>()
    };
    assert_eq!(predictions("", ""), [Some(0.0); 6]);
    assert_eq!(predictions("fixed = true", ""), [None; 6]);
    assert_eq!(predictions("", "[elasticity]\ndefault = 0.9"), [None; 6]);
    assert_eq!(
        predictions("", "[[wall]]\nx = 0.0\ntemperature = 1.0"),
        [None; 6]
    );
    let thermostat =
        "[[stage]]\nuntil = 1.0\nthermostat = [{ tag = \"gas\", every = 0.1, temperature = 1.0 }]";
    assert_eq!(predictions("", thermostat), [None; 6]);
}

#[test]
fn partial_correlations_of_two_tags_add_up_to_those_of_all() {
    let (results, _) = measured(
        r#"
            [[gas]]
            tags = ["a"]
            radius = 0.01
            mass = 1.0
            energy = 1.0
            count = 40

            [[gas]]
            tags = ["b"]
            radius = 0.01
            mass = 1.0
            energy = 1.0
            count = 160

            [run]
            until = 4.0
            sample_interval = 0.1
            observe = ["structure-factor", "structure-factor:a", "structure-factor:b", "structure-factor:a,b",
                "pair-distribution", "pair-distribution:a", "pair-distribution:b", "pair-distribution:a,b"]
        "#,
    );
    let columns = |name: &str, value: &str| {
        ["", "-a", "-b", "-a-b"]
            .map(|tags| column(table(&results, &format!("{name}{tags}")), value))
    };
    let [all, aa, bb, ab] = columns("structure-factor", "s");
    assert_eq!(all.len(), 200);
    for (index, total) in all.iter().enumerate() {
        // √(N_a N_b) / N with N_a = 40, N_b = 160.
        let of = |column: &[Option<f64>]| column[index].unwrap();
        let sum = 0.2 * of(aa) + 0.8 * of(bb) + 2.0 * 0.4 * of(ab);
        assert!((sum - total.unwrap()).abs() < 1e-12, "{sum} {total:?}");
    }
    let [all, aa, bb, ab] = columns("pair-distribution", "pairs");
    for (index, total) in all.iter().enumerate() {
        let of = |column: &[Option<f64>]| column[index].unwrap();
        assert_eq!(of(aa) + of(bb) + 2.0 * of(ab), total.unwrap());
    }
    let figure = "g(r) at contact, a-b";
    assert!(
        self::figure(&results, figure)
            .unwrap()
            .standard_error
            .is_some()
    );
}

/// Two walls at different temperatures; their two sides make two slabs of the periodic box.
#[test]
fn profiles_between_walls_have_a_heat_conductivity_and_their_own_times() {
    let (results, _) = measured(
        r#"
            [box]
            sides = [2.0, 1.0]
            [[wall]]
            x = 0.5
            temperature = 1.0
            [[wall]]
            tags = ["hot"]
            x = 1.5
            temperature = 2.0
            [[gas]]
            radius = 0.02
            mass = 1.0
            temperature = 1.5
            count = 200
            [run]
            until = 40.0
            sample_interval = 0.1
            observe = ["profile", "fields"]
            [[measure]]
            kind = "profile"
            name = "wall"
            wall = "hot"
            bins = 10
            from = 10.0
            until = 20.0
            [[measure]]
            kind = "profile"
            name = "rings"
            point = [0.5, 0.5]
            bins = 7
            every = 10
        "#,
    );
    let conductivity = figure(&results, "heat conductivity λ/k from the profile").unwrap();
    let (error, predicted) = (
        conductivity.standard_error.unwrap(),
        conductivity.prediction.unwrap(),
    );
    assert!(
        (conductivity.value - predicted).abs() < 4.0 * error && error < 0.4 * predicted,
        "{conductivity:?}"
    );
    assert_eq!(table(&results, "profile").rows().len(), 50);
    assert_eq!(table(&results, "fields").grid().unwrap().counts, [20, 10]);
    // 200 bodies at 101 samples from 10 to 20; the farthest place is half a side away.
    let layers = table(&results, "profile-wall");
    let bodies: f64 = column(layers, "bodies").iter().flatten().sum();
    assert_eq!(bodies, 200.0 * 101.0);
    let hot = column(layers, "kT")[0].unwrap();
    let cold = column(layers, "kT")[9].unwrap();
    assert!(hot > cold, "{hot} {cold}");
    assert!(column(layers, "stress_nn_error")[3].unwrap() > 0.0);
    let rings = table(&results, "profile-rings");
    let area: f64 = column(rings, "area").iter().flatten().sum();
    assert!((area - std::f64::consts::PI * 0.25).abs() < 1e-12);
}

/// Discs that all run away from a point with the same speed.
#[test]
fn a_front_grows_in_proportion_to_the_time_where_nothing_is_in_its_way() {
    let disc = |k: i32| {
        let (sin, cos) = (0.1 * std::f64::consts::PI * f64::from(k)).sin_cos();
        format!(
            "[[molecule]]\natoms = [{{ at = [0, 0], radius = 0.001, mass = 1 }}]\nat = [{}, {}]\n\
             velocity = [{cos}, {sin}]\n",
            0.5 + 0.01 * cos,
            0.5 + 0.01 * sin
        )
    };
    let discs: String = (0..20).map(disc).collect();
    let (results, _) = measured(&format!(
        "{discs}[run]\nuntil = 0.4\nsample_interval = 0.05\nobserve = [\"front\"]"
    ));
    let front = table(&results, "front");
    for (time, distance) in column(front, "time").iter().zip(column(front, "distance")) {
        assert!((distance.unwrap() - time.unwrap() - 0.01).abs() < 1e-12);
    }
    let power = figure(&results, "power of time of the front").unwrap();
    // Points of one path are not independent, so that their scatter about the law is no error.
    assert!(
        (0.85..0.98).contains(&power.value) && power.standard_error.is_none(),
        "{power:?}"
    );
}

/// Ten discs in a row that wraps around the box along x, a fixed pair, and discs alone.
#[test]
fn clusters_are_counted_by_the_gap_of_their_surfaces() {
    let disc = |x: f64, y: f64| format!("[[bumper]]\nradius = 0.04\nat = [{x}, {y}]\n");
    let row = (0..10).map(|k| disc(0.1 * f64::from(k), 0.2));
    let others = [disc(0.3, 0.8), disc(0.39, 0.8), disc(0.7, 0.6)];
    let discs: String = row.chain(others).collect();
    let scene = |measure: &str| {
        format!(
            "{discs}[run]\nuntil = 4.0\nsample_interval = 0.1\n[[measure]]\nkind = \"clusters\"\n{measure}"
        )
    };
    let (results, _) = measured(&scene("gap = 0.03"));
    for (name, expected) in [
        ("number of clusters", 3.0),
        ("largest cluster", 10.0),
        ("mean cluster size (number average)", 13.0 / 3.0),
        ("mean cluster size (weight average)", 105.0 / 13.0),
        ("share of samples that percolate along x", 1.0),
        ("share of samples that percolate along y", 0.0),
        ("share of samples that percolate", 1.0),
    ] {
        let found = figure(&results, name).unwrap_or_else(|| panic!("no {name}"));
        assert!((found.value - expected).abs() < 1e-12, "{found:?}");
        assert_eq!(found.standard_error, Some(0.0), "{found:?}");
    }
    let series = table(&results, "clusters");
    assert_eq!(column(series, "wraps_x")[40], Some(1.0));
    assert_eq!(column(series, "largest")[40], Some(10.0));
    let sizes = table(&results, "clusters-sizes");
    // 41 samples; the bin of 10 and 11 bodies is the last.
    assert_eq!(column(sizes, "clusters")[..2], [Some(41.0); 2]);
    assert_eq!(column(sizes, "size").last(), Some(&Some(10.5)));
    let per_body = column(sizes, "n").iter().map(|n| n.unwrap() * 13.0);
    let expected = [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5];
    assert!(
        per_body
            .zip(expected)
            .all(|(n, expected)| (n - expected).abs() < 1e-12)
    );
    // The default is a tenth of the diameter, less than the gaps of 0.01 and 0.02.
    let (results, _) = measured(&scene(""));
    assert_eq!(figure(&results, "largest cluster").unwrap().value, 1.0);
    // The centres of the pair are 0.09 apart, those of the row 0.1.
    for (distance, largest) in [(0.089, 1.0), (0.095, 2.0), (0.101, 10.0)] {
        let (results, _) = measured(&scene(&format!("distance = {distance}")));
        let found = figure(&results, "largest cluster").unwrap().value;
        assert_eq!(found, largest, "{distance}");
    }
    // The reasons for which it is refused.
    for (text, said) in [
        (
            scene("gap = 0.5"),
            "less than half the shorter side of the box, 0.5",
        ),
        (
            scene("distance = 0.5"),
            "'distance' must be less than half the shorter side of the box, 0.5",
        ),
        (scene("gap = 0.03\ndistance = 0.1"), "exclude each other"),
        (
            "run.observe = [\"clusters\"]\n[[wall]]\nx = 0.0\n".to_owned(),
            "give 'gap'",
        ),
    ] {
        let scene = Scene::from_toml(&text).unwrap();
        let simulation = AnySimulation::new(&scene).unwrap();
        let error = Measures::new(&scene, &simulation.view())
            .err()
            .expect("an error");
        assert!(format!("{error:#}").contains(said), "{error:#}");
    }
}

/// Three discs that move together, the first two within a well and the last two tied.
#[test]
fn bonded_clusters_are_counted_by_bonds_and_wells() {
    let disc = |x: f64| {
        format!(
            "[[molecule]]\natoms = [{{ at = [0, 0], radius = 0.02, mass = 1.0 }}]\nat = [{x}, 0.5]\n\
             velocity = [0.5, 0.25]\ntags = [\"sticky\"]\n"
        )
    };
    let discs = [0.3, 0.35, 0.45].map(disc).concat();
    let scene = |measure: &str| {
        format!(
            "[[well]]\nbetween = [\"sticky\"]\nsteps = [[1.5, -1.0]]\n[[bond]]\npairs = [[1, 2]]\n\
             tether = {{ max = 0.2 }}\n{discs}[run]\nuntil = 4.0\nsample_interval = 0.1\n[[measure]]\n\
             kind = \"bonded-clusters\"\n{measure}"
        )
    };
    for (measure, clusters, largest, weight_mean) in [
        ("by = \"wells\"", 2.0, 2.0, 5.0 / 3.0),
        ("by = \"bonds\"", 2.0, 2.0, 5.0 / 3.0),
        ("", 1.0, 3.0, 3.0),
    ] {
        let (results, _) = measured(&scene(measure));
        for (name, expected) in [
            ("number of bonded clusters", clusters),
            ("largest bonded cluster", largest),
            ("mean bonded cluster size (number average)", 3.0 / clusters),
            ("mean bonded cluster size (weight average)", weight_mean),
            ("share of samples whose bonds percolate", 0.0),
        ] {
            let found = figure(&results, name).unwrap_or_else(|| panic!("no {name}"));
            assert!(
                (found.value - expected).abs() < 1e-12,
                "{measure} {found:?}"
            );
        }
        let series = table(&results, "bonded-clusters");
        assert_eq!(column(series, "largest")[40], Some(largest));
        let sizes = table(&results, "bonded-clusters-sizes");
        assert_eq!(column(sizes, "size").len() as f64, largest);
    }
}

/// Chains in a gas: the trace of the tensor of gyration, and times of relaxation in order.
#[test]
fn chains_have_a_tensor_of_gyration_and_relaxation_times() {
    let (results, _) = measured(
        "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 32\ntags = [\"chain\"]\n\
         chain = { members = 4, tether = { max = 0.04 } }\n[[gas]]\nradius = 0.01\nmass = 1.0\n\
         energy = 1.0\ncount = 40\n[run]\nuntil = 10.0\nsample_interval = 0.005\n\
         observe = [\"chains:chain\", \"chain-relaxation:chain\"]\n[[measure]]\n\
         kind = \"chain-relaxation\"\nname = \"third\"\nmode = 3\n",
    );
    let of = |name: &str| {
        figure(&results, name)
            .unwrap_or_else(|| panic!("no {name}"))
            .value
    };
    let squared = of("squared radius of gyration, chain");
    let sums = [
        of("tensor of gyration S_xx, chain") + of("tensor of gyration S_yy, chain"),
        of("larger eigenvalue of the tensor of gyration, chain")
            + of("smaller eigenvalue of the tensor of gyration, chain"),
    ];
    assert!(
        sums.iter().all(|sum| (sum / squared - 1.0).abs() < 1e-12),
        "{sums:?} {squared}"
    );
    let ratio = of("ratio of the eigenvalues of the tensor of gyration, chain");
    assert!((0.0..1.0).contains(&ratio), "{ratio}");
    let [of_ends, slowest, fastest] = [
        of("relaxation time of the end-to-end vector, chain"),
        of("relaxation time of the Rouse mode X₁, chain"),
        of("relaxation time of the Rouse mode X₃, third"),
    ];
    // The end-to-end vector has fast modes, too.
    assert!(0.0 < fastest && fastest < of_ends && of_ends < 1.1 * slowest);
}

/// Rows of a square lattice that move along x to the right and to the left in turn. Every sample
/// finds them in a square lattice, in which a disc has two of eight neighbours in its own row.
#[test]
fn displacements_relative_to_the_cage_are_those_of_rows_that_pass_each_other() {
    let disc = |index: u32| {
        let [column, row] = [index % 4, index / 4];
        let at = [column, row].map(|place| 0.25 * f64::from(place) + 0.125);
        let velocity = if row % 2 == 0 { 1.0 } else { -1.0 };
        format!(
            "[[molecule]]\nshape = \"disc\"\natom_radius = 0.01\natom_mass = 1.0\nat = {at:?}\n\
             velocity = [{velocity:?}, 0.0]\ntags = [\"row\"]\n"
        )
    };
    let discs: String = (0..16).map(disc).collect();
    let scene = |measure: &str| {
        format!(
            "{discs}[run]\nuntil = 4.0\nsample_interval = 0.125\n[[measure]]\nkind = \"cage-displacement\"\n\
             of = \"row\"\nmax = 1.0\n{measure}"
        )
    };
    let (results, _) = measured(&scene("cutoff = 0.36"));
    let neighbours = figure(&results, "mean number of neighbours in the cage, row").unwrap();
    assert_eq!(
        (neighbours.value, neighbours.standard_error),
        (8.0, Some(0.0))
    );
    let cages = table(&results, "cage-displacement-row");
    let lags = column(cages, "lag");
    assert_eq!(lags.len(), 9);
    for (place, lag) in lags.iter().enumerate() {
        // Δ − (2 Δ − 6 Δ)/8 = 3/2 Δ.
        let square = lag.unwrap().powi(2);
        let found = ["mean_square_displacement", "cage_relative"]
            .map(|name| column(cages, name)[place].unwrap());
        assert!((found[0] - square).abs() < 1e-12, "{lag:?} {found:?}");
        assert!(
            (found[1] - 2.25 * square).abs() < 1e-12,
            "{lag:?} {found:?}"
        );
    }
    let refused = Scene::from_toml(&scene("cutoff = 0.5")).unwrap();
    let simulation = AnySimulation::new(&refused).unwrap();
    let error = Measures::new(&refused, &simulation.view())
        .err()
        .map(|error| format!("{error:#}"))
        .unwrap_or_default();
    let said = "0.5 must be less than half the shorter side of the box, 0.5";
    assert!(error.contains(said), "{error}");
}

/// Discs in a triangular lattice, and bins up to a given area.
#[test]
fn voronoi_cells_of_a_lattice_have_one_area_and_six_neighbours() {
    let height = 0.75_f64.sqrt();
    let disc = |site: u32| {
        let [x, y] = [f64::from(site % 10), f64::from(site / 10)];
        let [x, y] = [0.1 * (x + 0.5 * (y % 2.0)) + 0.02, 0.1 * height * y + 0.03];
        format!("[[bumper]]\nradius = 0.045\nat = [{x}, {y}]\n")
    };
    let discs: String = (0..100).map(disc).collect();
    let scene = |measure: &str| {
        format!(
            "[box]\nsides = [1.0, {height}]\n{discs}[run]\nuntil = 4.0\nsample_interval = 0.1\n\
             [[measure]]\nkind = \"voronoi\"\n{measure}"
        )
    };
    let (results, _) = measured(&scene(""));
    let free = 1.0 - std::f64::consts::PI / 12.0_f64.sqrt() * 0.81;
    for (name, expected) in [
        ("relative variance of the cell areas", 0.0),
        ("mean free share of the cells", free),
        ("share of cells with 5 neighbours", 0.0),
        ("share of cells with 6 neighbours", 1.0),
        ("share of cells with 7 neighbours", 0.0),
    ] {
        let found = figure(&results, name).unwrap_or_else(|| panic!("no {name}"));
        assert!((found.value - expected).abs() < 1e-9, "{found:?}");
        assert!(found.standard_error.unwrap() < 1e-9, "{found:?}");
    }
    assert!((integral(table(&results, "voronoi-areas"), "density") - 1.0).abs() < 1e-12);
    let neighbours = table(&results, "voronoi-neighbours");
    assert_eq!(column(neighbours, "neighbours").len(), 7);
    assert_eq!(column(neighbours, "share")[3], Some(1.0));
    let series = table(&results, "voronoi");
    assert_eq!(column(series, "cells")[40], Some(100.0));
    assert!((column(series, "mean_area")[40].unwrap() - 0.01 * height).abs() < 1e-12);
    // All areas are outside these bins.
    let (results, _) = measured(&scene("max = 0.9\nbins = 9"));
    assert_eq!(table(&results, "voronoi-areas").rows().len(), 9);
    let outside = figure(&results, "share of the cell areas outside the range");
    assert_eq!(outside.unwrap().value, 1.0);
}

/// Half of the gas crosses half as often.
#[test]
fn crossings_are_predicted_for_the_group() {
    let scene = "[box]\nseed = 2\n[[gas]]\ntags = [\"a\"]\nradius = 0.02\nmass = 1.0\ntemperature = 1.0\nvelocities = \
             \"maxwell\"\ncount = 100\n[[gas]]\nradius = 0.02\nmass = 1.0\ntemperature = 1.0\nvelocities = \"maxwell\"\n\
             count = 100\n[run]\nuntil = 40.0\nsample_interval = 0.5\nobserve = [\"crossings:a\", \"crossings\"]\n";
    let (results, _) = measured(scene);
    let of = |name: &str| {
        let figure = results.figures.iter().find(|figure| figure.name == name);
        figure.unwrap_or_else(|| panic!("no figure {name}"))
    };
    let [half, all] = ["crossings forward, a", "crossings forward"].map(of);
    let expected = 200.0 * (0.995 / std::f64::consts::TAU).sqrt();
    for (figure, expected) in [(half, 0.5 * expected), (all, expected)] {
        let predicted = figure.prediction.unwrap();
        assert!(
            (predicted / expected - 1.0).abs() < 1e-6,
            "{predicted} {expected}"
        );
        assert!((figure.value / expected - 1.0).abs() < 0.1, "{figure:?}");
    }
    // The error of the rate is that of the number of bodies which have crossed.
    let rate = of("rate of first passages");
    let waiting = column(table(&results, "crossings"), "waiting").last();
    let passages: f64 = 200.0 - waiting.copied().flatten().unwrap();
    let share = rate.standard_error.unwrap() / rate.value;
    assert!(
        passages > 0.0 && (share * passages.sqrt() - 1.0).abs() < 1e-12,
        "{rate:?}"
    );
}

/// What the exponents cannot follow is refused wherever it stands in the measured stages.
#[test]
fn lyapunov_exponents_are_refused_with_edits_of_the_motion() {
    let gas = "[[wall]]\nx = 0.0\ntags = [\"wall\"]\n[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\n\
               count = 20\n[run]\nuntil = 2.0\nsample_interval = 0.1\nobserve = [\"lyapunov\"]\n";
    let check = |stages: &str| requests(&Scene::from_toml(&format!("{gas}{stages}")).unwrap());
    let stage = |keys: &str, until: f64| format!("[[stage]]\nuntil = {until:?}\n{keys}\n");
    let set = "set_velocity = [{ tag = \"gas\", velocity = [0.1, 0.0] }]";
    assert!(check(&format!("{}{}", stage(set, 1.0), stage("", 2.0))).is_ok());
    for (first, second, word) in [
        ("", set, "set_velocity"),
        ("drag = 0.5", "", "a drag"),
        (
            "add_wall = [{ y = 0.0, temperature = 1.0 }]",
            "",
            "add_wall",
        ),
        ("", "unlock = [\"gas\"]", "unlock"),
        (
            "elasticity = { default = 0.9, tangential = 0.5 }",
            "",
            "rough surfaces",
        ),
        ("elasticity = { default = 0.0 }", "", "an elasticity of 0"),
    ] {
        let error = check(&format!("{}{}", stage(first, 1.0), stage(second, 2.0))).unwrap_err();
        let text = format!("{error:#}");
        assert!(text.contains("'lyapunov'") && text.contains(word), "{text}");
    }
}

/// Two chains of three points that do not move: a straight one around the border of the box, and
/// one with a right angle.
#[test]
fn chains_are_measured_along_their_bonds() {
    let places = [
        [0.9, 0.5],
        [0.0, 0.5],
        [0.1, 0.5], //
        [0.4, 0.2],
        [0.5, 0.2],
        [0.5, 0.3],
    ];
    let disc = |[x, y]: [f64; 2]| {
        format!(
            "[[molecule]]\natoms = [{{ at = [0, 0], radius = 0.01, mass = 1 }}]\nat = [{x}, {y}]\ntags = [\"m\"]\n"
        )
    };
    let discs: String = places.into_iter().map(disc).collect();
    let text = |kind: &str| {
        format!(
            "[[bond]]\npairs = [[0, 1], [1, 2], [3, 4], [4, 5]]\ntether = {{ max = 0.15 }}\n{discs}\
             [run]\nuntil = 4.0\nsample_interval = 0.1\nobserve = [\"{kind}\"]"
        )
    };
    for kind in ["chains", "chains:m"] {
        let (results, gas) = measured(&text(kind));
        assert!(gas.unwrap_err().contains("tied"));
        let value = |name: &str| {
            let found = results
                .figures
                .iter()
                .find(|figure| figure.name.starts_with(name));
            found.unwrap_or_else(|| panic!("no {name}")).value
        };
        for (name, expected) in [
            ("squared length of a bond", 0.01),
            ("squared end-to-end distance", 0.03),
            ("squared end-to-end distance by", 1.5),
            (
                "squared radius of gyration",
                0.5 * (0.02 / 3.0 + 0.04 / 9.0),
            ),
        ] {
            assert!(
                (value(name) - expected).abs() < 1e-12,
                "{name}: {}",
                value(name)
            );
        }
    }
}
