//! Tests of merged runs: order, refusals, and agreement with hand-made averages.

use super::*;
use crate::{checkpoint_file::encode, interruption::Signals, output::Existing, run::outcome::in_memory};
use carom::Scene;
use carom_methods::Method;

/// A short run of 40 discs.
fn one(seed: u64) -> Record {
    let scene = Scene::from_toml(&format!(
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
    ));
    let scene = scene.unwrap();
    let outcome = in_memory(&scene, &Signals::watch().unwrap()).unwrap();
    let read = checkpoint_round_trip(&outcome.record(&scene, &Method::default()));
    assert_eq!(read.runs.len(), 1);
    read
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
    parts[1..].iter().for_each(|part| all.merge((*part).clone()).unwrap());
    all
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
        average::results(record).figures.into_iter().find(|figure| figure.name == "pressure").unwrap()
    };
    let all = pressure(&merged(&[a, b, c, d]));
    let alone: Vec<f64> = parts.iter().map(|part| pressure(part).value).collect();
    assert!((all.value / (alone.iter().sum::<f64>() / 4.0) - 1.0).abs() < 1e-12);
    let errors: f64 = parts.iter().map(|part| pressure(part).standard_error.unwrap().powi(2)).sum();
    let ratio = all.standard_error.unwrap() / (errors.sqrt() / 4.0);
    assert!((0.5..2.0).contains(&ratio), "{ratio}");

    // A correlation gets an error also at lags that are longer than a block.
    let table = |record: &Record| {
        average::results(record).tables.into_iter().find(|table| table.name == "correlation").unwrap()
    };
    let errors = |record: &Record| {
        let table = table(record);
        let column = table.columns.iter().find(|column| column.name == "mean_square_displacement_error");
        column.unwrap().values.iter().flatten().count()
    };
    assert!(errors(&merged(&[a, b, c, d])) >= errors(a));
    // Series become averages over the runs with the error of their scatter.
    let series = expected.tables.iter().find(|table| table.name == "pressure").unwrap();
    assert!(series.columns.iter().any(|column| column.name == "pressure_error"));
}

#[test]
fn runs_that_do_not_fit_are_refused() {
    let mut a = one(1);
    assert!(a.merge(one(1)).unwrap_err().to_string().contains("seed 1 and replica 0 is there twice"));
    let mut other = one(2);
    other.what = other.what.replace("count = 40", "count = 41");
    assert!(a.merge(other).unwrap_err().to_string().contains("count = 40"));
    assert!(format!("{:#}", Record::read(Path::new("no/such")).unwrap_err()).contains("sums"));
}
