//! A disc around a fixed molecule: mean free path and directions agree with integral geometry.

use carom::Shape;
use carom_runs::work_items::WorkItems;
use carom_tables::chi_square::ChiSquare;
use clap::Parser as _;
use xtask::experiments::billiard::{Options, fly};

#[derive(clap::Parser)]
struct Line {
    #[command(flatten)]
    options: Options,
}

fn options(arguments: &[&str]) -> Options {
    Line::try_parse_from([&["billiard"], arguments].concat()).unwrap().options
}

#[test]
fn mean_free_path_and_directions_agree_with_integral_geometry() {
    for (shape, radius) in [("tee", "0.0025"), ("ring:12", "0.005")] {
        let mut options = options(&["--shape", shape, "--atom-radius", radius, "--seed", "11"]);
        options.hits = Some(40_000);
        let setup = options.setup().unwrap();
        let hits = fly(&setup, &WorkItems::default()).unwrap();
        let (path, error) = hits.mean_free_path();
        let predicted = setup.mean_free_path();
        assert!((path - predicted).abs() < 4.0 * error, "{shape}: {path} ± {error}, {predicted}");
        assert!(error < 0.03 * predicted, "{error}");
        let directions = ChiSquare::of(&hits.directions, &setup.region.direction_shares(360));
        assert!(directions.p_value() > 1e-4, "{shape}: {directions:?}");
        for atom in setup.region.unreachable() {
            assert_eq!(hits.atoms[atom], 0, "{shape}: atom {atom} is out of reach");
        }
        assert_eq!((hits.totals.overlapping_pairs, hits.total()), (0, hits.atoms.iter().sum()));
        assert!(hits.totals.energy_drift < 1e-12);
    }
}

#[test]
fn the_number_of_threads_changes_no_hit() {
    let options = Options { hits: Some(20_000), ..options(&["--shape", "dumbbell"]) };
    let setup = options.setup().unwrap();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fly(&setup, &WorkItems::default())).unwrap()
    };
    let (one, two) = (on(1), on(2));
    assert_eq!((one.blocks, one.directions), (two.blocks, two.directions));
}

#[test]
fn invalid_options_are_refused() {
    for (arguments, word) in [
        (["--gas-radius", "0"], "--gas-radius"),
        (["--gas-radius", "nan"], "--gas-radius"),
        (["--atom-radius", "0"], "--atom-radius"),
        (["--side", "0.02"], "--side"),
    ] {
        let refused = format!("{:#}", options(&arguments).setup().unwrap_err());
        assert!(refused.contains(word), "{refused}");
    }
    assert_eq!(options(&[]).shape, Shape::Tee);
}
