//! Tests of merged runs: order, refusals, and agreement with hand-made averages.

use super::*;
use crate::{
    checkpoint_file::encode, interruption::Signals, output::Existing, run::outcome::in_memory,
};
use carom::Scene;
use carom_methods::Method;
use carom_tables::without_numbers;

/// The record of a run of this scene.
fn record_of(scene: &str) -> Record {
    let scene = Scene::from_toml(scene).unwrap();
    let outcome = in_memory(&scene, &Signals::watch().unwrap()).unwrap();
    let read = checkpoint_round_trip(&outcome.record(&scene, &Method::default()));
    assert_eq!(read.runs.len(), 1);
    read
}

/// A short run of 40 discs.
fn one(seed: u64) -> Record {
    record_of(&format!(
        r#"
            [box]
            seed = {seed}
            [[gas]]
            radius = 0.03
            mass = 1.0
            energy = 1.0
            count = 40
            [run]
            until = 2.0
            sample_interval = 0.05
            measure_from = 0.2
            observe = ["pressure", "correlation", "pair-distribution", "temperature"]
        "#
    ))
}

/// The record as another process reads it.
fn checkpoint_round_trip(record: &Record) -> Record {
    let root = tempfile::tempdir().unwrap();
    let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
    record.write(&folder).unwrap();
    let read = Record::read(root.path()).unwrap();
    assert_eq!(encode(&read).unwrap(), encode(record).unwrap());
    read
}

fn merged(parts: &[&Record]) -> Record {
    let mut all = parts[0].clone();
    parts[1..]
        .iter()
        .for_each(|part| all.merge((*part).clone()).unwrap());
    all
}

/// A run of 60 dumbbells that measures coefficients of curves.
fn of_curves(seed: u64) -> Record {
    record_of(&format!(
        r#"
            [box]
            seed = {seed}
            [[gas]]
            tags = ["gas"]
            shape = "dumbbell"
            atom_radius = 0.02
            atom_mass = 1.0
            temperature = 1.0
            velocities = "maxwell"
            count = 60
            [run]
            until = 12.0
            sample_interval = 0.02
            measure_from = 0.4
            observe = ["correlation:gas", "orientation:gas", "viscosity"]
        "#
    ))
}

/// The lags at which a coefficient is read depend on the data. That of several runs is read from
/// the curve of all of them, none left out, and its error covers the scatter.
#[test]
fn coefficients_of_merged_runs_are_read_from_their_common_curve() {
    let parts: Vec<Record> = (1..=8).map(of_curves).collect();
    let all = average::results(&merged(&parts.iter().collect::<Vec<_>>()));
    let column = |results: &Results, table: &str, name: &str| {
        let table = results
            .tables
            .iter()
            .find(|found| found.name == table)
            .unwrap();
        let found = |name: &str| {
            let column = table.columns.iter().find(|column| column.name == name);
            column.unwrap().values.clone()
        };
        (found("lag"), found(name))
    };
    for (begin, table, name, factor) in [
        (
            "diffusion coefficient at long lags, ",
            "correlation-gas",
            "mean_square_displacement",
            0.25,
        ),
        (
            "shear viscosity, from lags ",
            "viscosity",
            "mean_square",
            f64::NAN,
        ),
    ] {
        let figure = all
            .figures
            .iter()
            .find(|figure| {
                figure
                    .name
                    .trim_start_matches("apparent ")
                    .starts_with(begin)
            })
            .unwrap_or_else(|| panic!("{begin}: {:?}", all.figures));
        let numbers: Vec<f64> = figure
            .name
            .split([' ', ','])
            .filter_map(|word| word.parse().ok())
            .collect();
        let slope = |results: &Results| {
            let (lags, values) = column(results, table, name);
            let at = |lag: f64| {
                let near = |found: &Option<f64>| (found.unwrap() / lag - 1.0).abs() < 1e-3;
                values[lags.iter().position(near).unwrap()].unwrap()
            };
            (at(numbers[1]) - at(numbers[0])) / (numbers[1] - numbers[0])
        };
        let slopes: Vec<f64> = parts
            .iter()
            .map(|part| slope(&average::results(part)))
            .collect();
        let mean = slopes.iter().sum::<f64>() / 8.0;
        let scatter = (slopes.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 7.0 / 8.0).sqrt();
        let factor = if factor.is_nan() {
            figure.value / slope(&all)
        } else {
            factor
        };
        assert!(
            (figure.value / (factor * slope(&all)) - 1.0).abs() < 1e-9,
            "{figure:?}"
        );
        assert!((slope(&all) / mean - 1.0).abs() < 1e-9);
        let ratio = figure.standard_error.unwrap() / (factor * scatter);
        assert!((0.4..2.5).contains(&ratio), "{begin}: {ratio}");
    }
    // Together they resolve at least the lags of the first alone, and have one name each.
    let names = |results: &Results| -> Vec<String> {
        let names = results
            .figures
            .iter()
            .map(|figure| without_numbers(&figure.name));
        names
            .map(|name| name.replace("apparent ", "").replace(", no plateau", ""))
            .collect()
    };
    assert_eq!(names(&all), names(&average::results(&parts[0])));
}

/// Each run has waited for a time of its own.
#[test]
fn the_rate_of_first_passages_of_merged_runs_is_that_of_all_passages() {
    let parts: Vec<Record> = (1..=3)
        .map(|seed| {
            record_of(&format!(
                r#"
                    [box]
                    seed = {seed}
                    [[gas]]
                    radius = 0.03
                    mass = 1.0
                    energy = 1.0
                    count = 10
                    [run]
                    until = 1.0
                    sample_interval = 0.25
                    observe = ["crossings"]
                "#
            ))
        })
        .collect();
    let rate = |results: &Results| {
        let mut figures = results.figures.iter();
        let figure = figures.find(|figure| figure.name == "rate of first passages");
        let figure = figure.expect("a rate");
        (figure.value, figure.standard_error.expect("passages"))
    };
    // A rate R with the error R/√n comes from n passages in the time n/R.
    let [mut passages, mut time] = [0.0; 2];
    for part in &parts {
        let (rate, error) = rate(&average::results(part));
        let number = (rate / error).powi(2);
        passages += number;
        time += number / rate;
    }
    let (found, error) = rate(&average::results(&merged(
        &parts.iter().collect::<Vec<_>>(),
    )));
    let expected = passages / time;
    assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
    let expected = expected / passages.sqrt();
    assert!((error / expected - 1.0).abs() < 1e-12, "{error} {expected}");
}

#[test]
fn runs_merged_in_any_order_and_tree_have_the_same_digits() {
    let parts: Vec<Record> = (1..=4).map(one).collect();
    let [a, b, c, d] = [0, 1, 2, 3].map(|index| &parts[index]);
    let expected = average::results(&merged(&[a, b, c, d]));
    for order in [[d, c, b, a], [b, d, a, c], [c, a, d, b]] {
        assert_eq!(average::results(&merged(&order)), expected);
    }
    let (left, right) = (merged(&[d, a]), checkpoint_round_trip(&merged(&[c, b])));
    assert_eq!(average::results(&merged(&[&right, &left])), expected);

    // The pressure is the mean of the runs, which are equally long.
    let pressure = |record: &Record| {
        average::results(record)
            .figures
            .into_iter()
            .find(|figure| figure.name == "pressure")
            .unwrap()
    };
    let all = pressure(&merged(&[a, b, c, d]));
    let alone: Vec<f64> = parts.iter().map(|part| pressure(part).value).collect();
    assert!((all.value / (alone.iter().sum::<f64>() / 4.0) - 1.0).abs() < 1e-12);
    let errors: f64 = parts
        .iter()
        .map(|part| pressure(part).standard_error.unwrap().powi(2))
        .sum();
    let ratio = all.standard_error.unwrap() / (errors.sqrt() / 4.0);
    assert!((0.5..2.0).contains(&ratio), "{ratio}");

    // A correlation gets an error also at lags that are longer than a block.
    let table = |record: &Record| {
        average::results(record)
            .tables
            .into_iter()
            .find(|table| table.name == "correlation")
            .unwrap()
    };
    let errors = |record: &Record| {
        let table = table(record);
        let column = table
            .columns
            .iter()
            .find(|column| column.name == "mean_square_displacement_error");
        column.unwrap().values.iter().flatten().count()
    };
    assert!(errors(&merged(&[a, b, c, d])) >= errors(a));
    // Series become averages over the runs with the error of their scatter.
    let series = expected
        .tables
        .iter()
        .find(|table| table.name == "pressure")
        .unwrap();
    assert!(
        series
            .columns
            .iter()
            .any(|column| column.name == "pressure_error")
    );
}

/// A short run of 60 discs, whose temperature changes by a factor that depends on the seed.
fn heated(seed: u64) -> Record {
    let kt = [0.01, 1.0, 100.0][seed as usize % 3];
    let scene = Scene::from_toml(&format!(
        r#"
            [box]
            seed = {seed}
            [[gas]]
            tags = ["gas"]
            radius = 0.02
            mass = 1.0
            temperature = 1.0
            count = 60
            [run]
            until = 2.0
            sample_interval = 0.05
            observe = ["velocities", "free-path"]
            [[stage]]
            until = 2.0
            thermostat = [{{ tag = "gas", every = 0.1, temperature = {kt:?} }}]
        "#
    ));
    let scene = scene.unwrap();
    let outcome = in_memory(&scene, &Signals::watch().unwrap()).unwrap();
    let mut record = outcome.record(&scene, &Method::default());
    // As if all had one scene.
    record.what.clear();
    checkpoint_round_trip(&record)
}

#[test]
fn distributions_in_bins_of_different_widths_are_merged_without_loss() {
    let parts: Vec<Record> = (1..=3).map(heated).collect();
    let [a, b, c] = [0, 1, 2].map(|index| &parts[index]);
    let expected = average::results(&merged(&[a, b, c]));
    assert_eq!(average::results(&merged(&[c, a, b])), expected);
    let table = |results: &Results, name: &str| {
        let found = results.tables.iter().find(|table| table.name == name);
        found.unwrap_or_else(|| panic!("no table {name}")).clone()
    };
    for (name, columns) in [
        ("velocity-components", &["density_x", "density_y"][..]),
        ("speeds", &["density"]),
        ("free-path", &["density"]),
    ] {
        let all = table(&expected, name);
        let of = |table: &Table, name: &str| -> Vec<f64> {
            let column = table
                .columns
                .iter()
                .find(|column| column.name == name)
                .unwrap();
            column.values.iter().map(|value| value.unwrap()).collect()
        };
        let integral = |table: &Table, name: &str| -> f64 {
            of(table, name)
                .iter()
                .zip(of(table, "bin_width"))
                .map(|(density, width)| density * width)
                .sum()
        };
        let widths: Vec<usize> = parts
            .iter()
            .map(|part| table(&average::results(part), name).rows().len())
            .collect();
        for column in columns {
            let found = integral(&all, column);
            assert!(
                (found - 1.0).abs() < 1e-12,
                "{name} {column}: {found}, rows {widths:?}"
            );
        }
        // The density at the highest speeds counts the runs that have none.
        assert!(
            all.columns
                .iter()
                .any(|column| column.name == format!("{}_error", columns[0]))
        );
        assert!(
            !all.caption.contains("interpolated") && !all.caption.contains("Not merged"),
            "{}",
            all.caption
        );
    }
}

#[test]
fn runs_that_do_not_fit_are_refused() {
    let mut a = one(1);
    assert!(
        a.merge(one(1))
            .unwrap_err()
            .to_string()
            .contains("seed 1 and replica 0 is there twice")
    );
    let mut other = one(2);
    other.what = other.what.replace("count = 40", "count = 41");
    assert!(
        a.merge(other)
            .unwrap_err()
            .to_string()
            .contains("count = 40")
    );
    assert!(format!("{:#}", Record::read(Path::new("no/such")).unwrap_err()).contains("sums"));
}
