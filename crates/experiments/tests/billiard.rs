//! Hits of a disc and a molecule: mean free paths and directions agree with integral geometry.

use std::fs;

use carom_experiments::billiard::{Hits, Options, Setup, fly};
use carom_runs::work_items::WorkItems;
use carom_tables::chi_square::ChiSquare;
use clap::Parser as _;

#[derive(clap::Parser)]
struct Line {
    #[command(flatten)]
    options: Options,
}

fn options(arguments: &[&str]) -> Options {
    Line::try_parse_from([&["billiard"], arguments].concat()).unwrap().options
}

/// Flies and compares mean, directions and atoms with the prediction.
fn assert_predicted(arguments: &[&str], hits: u64) -> (Setup, Hits) {
    let options = Options { hits, ..options(arguments) };
    let setup = options.setup().unwrap();
    let hits = fly(&setup, &WorkItems::default()).unwrap();
    let ((mean, error), predicted) = (hits.mean_interval(), setup.mean_interval());
    assert!((mean - predicted).abs() < 4.0 * error, "{arguments:?}: {mean} ± {error}, {predicted}");
    assert!(error < 0.03 * predicted, "{arguments:?}: {error}");
    let directions = ChiSquare::of(&hits.directions, &setup.direction_shares());
    assert!(directions.p_value() > 1e-4, "{arguments:?}: {directions:?}");
    let atoms = ChiSquare::of(&hits.atoms, &setup.atom_shares());
    assert!(atoms.p_value() > 1e-4, "{arguments:?}: {atoms:?}");
    for atom in setup.region.unreachable() {
        assert_eq!(hits.atoms[atom], 0, "{arguments:?}: atom {atom} is out of reach");
    }
    assert_eq!((hits.totals.overlapping_pairs, hits.total()), (0, hits.atoms.iter().sum()));
    assert!(hits.totals.energy_drift < 1e-12);
    (setup, hits)
}

#[test]
fn mean_free_path_and_directions_agree_with_integral_geometry() {
    for (shape, radius) in [("tee", "0.0025"), ("ring:12", "0.005")] {
        assert_predicted(&[shape, "--atom-radius", radius, "--seed", "11"], 40_000);
    }
}

/// Five discs of three radii in an L, of which no other test has heard.
const L: &str = "atoms = [\n\
    { at = [0.0, 0.0], radius = 0.006, mass = 1.0 },\n\
    { at = [0.0, 0.008], radius = 0.004, mass = 1.0 },\n\
    { at = [0.0, 0.016], radius = 0.005, mass = 2.0 },\n\
    { at = [0.008, 0.0], radius = 0.004, mass = 1.0 },\n\
    { at = [0.016, 0.0], radius = 0.005, mass = 1.0 },\n]\n";

#[test]
fn any_molecule_moves_or_is_fixed_in_any_layout() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("ell.toml");
    fs::write(&path, L).unwrap();
    let path = path.to_str().unwrap();
    for moves in ["disc", "molecule", "locked-molecule"] {
        for layout in ["square", "triangular", "random"] {
            let arguments = [path, "--moves", moves, "--layout", layout, "--gas-radius", "0.003"];
            assert_predicted(&arguments, 60_000);
        }
    }
}

/// Lorentz's gas: the mean free path of a point among discs is (A/N − π R²) / 2R.
#[test]
fn discs_among_discs_have_the_mean_free_path_of_the_lorentz_gas() {
    for moves in ["disc", "molecule", "locked-molecule"] {
        let arguments = ["disc", "--atom-radius", "0.01", "--gas-radius", "0.02", "--moves", moves];
        let random = ["--layout", "random", "--obstacles", "7", "--side", "0.4"];
        let setup = options(&[&arguments[..], &random].concat()).setup().unwrap();
        let area = 0.4 * 0.4 / 7.0;
        let lorentz = (area - std::f64::consts::PI * 0.03 * 0.03) / 0.06;
        assert!((setup.mean_interval() / lorentz - 1.0).abs() < 1e-12);
        assert!(!setup.turns());
    }
}

/// A molecule that can turn hits more often far from its centre, and more often than its speed.
#[test]
fn rotation_makes_the_ends_of_a_rod_hit_more_often() {
    let rod = ["rod:3", "--atom-radius", "0.01", "--gas-radius", "0.01", "--moves"];
    let setup = |moves| options(&[&rod[..], &[moves]].concat()).setup().unwrap();
    let (free, locked) = (setup("molecule"), setup("locked-molecule"));
    assert!(free.turns() && !locked.turns());
    assert!(free.atom_shares()[0] > 1.05 * locked.atom_shares()[0]);
    // For I → ∞, 4 / ∮ √(1 + m (r × n)²/I) ds → 4 / P, against π / P at the mean speed π/4.
    let heavy =
        free.region.perimeter() * free.mean_interval() / (free.obstacles.area_of_one() - free.region.area());
    assert!(heavy < 4.0 && heavy > 2.0, "{heavy}");
}

#[test]
fn the_number_of_threads_changes_no_hit() {
    let options = Options { hits: 20_000, ..options(&["dumbbell", "--atom-radius", "0.005"]) };
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
    let tee = ["tee", "--atom-radius", "0.005"];
    for (arguments, word) in [
        (&["--gas-radius", "0"][..], "--gas-radius 0"),
        (&["--gas-radius", "nan"], "--gas-radius NaN"),
        (&["--side", "0.02"], "--side 0.02"),
        (&["--side", "inf"], "--side inf"),
        (&["--obstacles", "3"], "--obstacles 3"),
        (&["--layout", "triangular", "--obstacles", "1"], "the layout triangular has 2"),
        (&["--layout", "random", "--obstacles", "100", "--side", "0.3"], "--side 0.3"),
    ] {
        let refused = format!("{:#}", options(&[&tee[..], arguments].concat()).setup().unwrap_err());
        assert!(refused.contains(word), "{refused}");
    }
}
