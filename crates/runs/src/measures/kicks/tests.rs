//! Tests of the kicks: sums by hand, contacts that are known beforehand, a dilute gas, and merging.

use std::f64::consts::TAU;

use super::{super::Request, *};
use crate::{
    interruption::Signals, measures::Results, merge::merged, record::Record,
    run::outcome::in_memory,
};
use carom::Scene;
use carom_methods::{AnySimulation, Method};
use carom_tables::{Figure, SAFELY, THRESHOLD, Table};
use glam::DVec2;

/// The kicks of the body with the tag `body`, as of now.
fn kicks(scene: &Scene, view: &View<'_>) -> Result<Kicks> {
    let request = Request {
        tags: vec!["body".to_owned()],
        ..Request::plain(&KIND)
    };
    let selection = Selection::new(&request, &scene.run, view)?;
    Kicks::new(&selection)
}

/// Sums of the impulses on one body, from its reports alone.
struct ByHand {
    body: BodyKey,
    counts: Vec<u64>,
    impulse: Vec<f64>,
    by_atom: Vec<u64>,
    force: DVec2,
    squares: [f64; 2],
}

impl Observer for ByHand {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        let Some((side, impulse)) = report.side_of(self.body) else {
            return;
        };
        let (sin, cos) = side.before.orientation.radians().sin_cos();
        let own = DVec2::new(
            cos * impulse.x + sin * impulse.y,
            cos * impulse.y - sin * impulse.x,
        );
        self.force += own;
        if report
            .sides
            .iter()
            .any(|side| side.body.key() != self.body && side.body.is_fixed())
        {
            return;
        }
        let turns = own.y.atan2(own.x).rem_euclid(TAU) / TAU;
        let sectors = self.counts.len();
        let sector = ((turns * sectors as f64) as usize).min(sectors - 1);
        self.counts[sector] += 1;
        self.impulse[sector] += impulse.length();
        self.by_atom[side.atom.unwrap() as usize] += 1;
        self.squares[0] += own.x * own.x;
        self.squares[1] += own.y * own.y;
    }
}

/// A free tee among discs and a fixed disc that is in its way.
const PINNED: &str = "[box]\nseed = 5\n[[molecule]]\ntags = [\"body\"]\nshape = \"tee\"\natom_radius = 0.02\n\
                      atom_mass = 1.0\nat = [0.5, 0.5]\n[[bumper]]\nradius = 0.1\nat = [0.1, 0.1]\n\
                      [[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100\n";

#[test]
fn the_sums_are_those_of_the_contacts_with_bodies_that_move() {
    let scene = Scene::from_toml(PINNED).unwrap();
    let mut simulation = AnySimulation::new(&scene).unwrap();
    let mut kicks = kicks(&scene, &simulation.view()).unwrap();
    kicks.start(&simulation.view());
    kicks.sample(&simulation.view());
    let mut by_hand = ByHand {
        body: kicks.body,
        counts: vec![0; 72],
        impulse: vec![0.0; 72],
        by_atom: vec![0; 5],
        force: DVec2::ZERO,
        squares: [0.0; 2],
    };
    let mut drift = Drift::new(kicks.body);
    drift.start(&simulation.view());
    simulation
        .observe_until(10.0, &mut (&mut kicks, &mut by_hand, &mut drift))
        .unwrap();
    kicks.sample(&simulation.view());
    drift.sample(&simulation.view());
    let directions = kicks.directions();
    assert_eq!(
        (directions.counts(), kicks.by_part()),
        (by_hand.counts.as_slice(), by_hand.by_atom)
    );
    for (found, expected) in directions.impulse().iter().zip(&by_hand.impulse) {
        assert_eq!(found.to_bits(), expected.to_bits());
    }
    assert!(directions.hits() > 300, "{}", directions.hits());
    // The motion includes the fixed disc, as that of `drift` does.
    assert_eq!(
        (kicks.drift.impulse(), kicks.drift.path()),
        (drift.impulse(), drift.path())
    );
    assert!(kicks.drift.impulse().distance(by_hand.force) < 1e-10);
    // The places on the boundary and the components have the same contacts.
    let places = kicks.from_gas.observer.2.as_ref().unwrap();
    assert_eq!(
        places
            .points()
            .iter()
            .map(|point| point.contacts)
            .sum::<u64>(),
        directions.hits()
    );
    let components = kicks.distributions();
    assert!(
        components[0]
            .iter()
            .all(|component| component.total() == directions.hits())
    );
}

fn results(text: &str) -> Results {
    let scene = Scene::from_toml(text).unwrap();
    in_memory(&scene, &Signals::default()).unwrap().results
}

fn figure<'a>(results: &'a Results, name: &str) -> &'a Figure {
    let found = results
        .figures
        .iter()
        .find(|figure| figure.name == format!("{name}, body"));
    found.unwrap_or_else(|| panic!("no figure {name}"))
}

fn table<'a>(results: &'a Results, name: &str) -> &'a Table {
    results
        .tables
        .iter()
        .find(|table| table.name == name)
        .unwrap_or_else(|| panic!("no table {name}"))
}

/// A disc of radius 0.05 and mass 2 that flies along x through a periodic box of side 1 with speed
/// 1 meets a fixed disc of radius 0.15 every 0.6, in turn from both sides, with impulses of 4.
#[test]
fn contacts_that_are_known_beforehand_give_their_rate_and_directions() {
    let found = results(
        "[[bumper]]\ntags = [\"body\"]\nradius = 0.15\nat = [0.5, 0.5]\n[[molecule]]\nshape = \"disc\"\n\
         atom_radius = 0.05\natom_mass = 2.0\nat = [0.1, 0.5]\nvelocity = [1.0, 0.0]\n\
         [run]\nuntil = 60.1\nsample_interval = 0.1\nobserve = [\"kicks:body\"]\n",
    );
    // The first contact is at 0.2, the last at 59.6.
    assert!((figure(&found, "kicks").value - 100.0 / 60.1).abs() < 1e-9);
    let force = figure(&found, "force along x′");
    assert!(
        force.value.abs() < 1e-12 && force.prediction.is_none(),
        "a fixed body may be pushed"
    );
    assert!(
        found
            .figures
            .iter()
            .all(|figure| !figure.name.starts_with("velocity"))
    );
    let directions = table(&found, "kicks-directions-body");
    let contacts = &directions
        .columns
        .iter()
        .find(|column| column.name == "contacts")
        .unwrap()
        .values;
    // The directions 0 and half a turn, each at the border of two sectors.
    let at = |sectors: [usize; 2]| {
        sectors
            .map(|sector| contacts[sector].unwrap())
            .iter()
            .sum::<f64>()
    };
    assert_eq!([at([71, 0]), at([35, 36])], [50.0; 2]);
}

/// A locked tee in a dilute gas: all that is predicted holds.
#[test]
fn a_dilute_gas_kicks_as_the_exposed_arcs_predict() {
    let found = results(
        "[box]\nseed = 2\n[[molecule]]\ntags = [\"body\"]\nshape = \"tee\"\natom_radius = 0.02\natom_mass = 2.0\n\
         at = [0.5, 0.5]\nrotation = \"locked\"\n[[bumper]]\nradius = 0.01\nat = [0.1, 0.1]\n\
         [[gas]]\nradius = 0.005\nmass = 1.0\nenergy = 1.0\ncount = 50\n\
         [run]\nuntil = 4000.0\nsample_interval = 2.0\nobserve = [\"kicks:body\"]\n",
    );
    let mut judged = 0;
    for figure in found
        .figures
        .iter()
        .filter(|figure| figure.name.ends_with(", body"))
    {
        let (Some(prediction), Some(error)) = (figure.prediction, figure.standard_error) else {
            continue;
        };
        // The rates have systematic errors of 0.3 %.
        let away = (figure.value - prediction).abs() - 0.003 * prediction.abs();
        assert!(away < 4.5 * error, "{figure:?}");
        judged += 1;
    }
    // Rate and density, two forces, the torque, two velocities and energies, two of the mirror
    // symmetry, three χ², and five atoms.
    assert_eq!(judged, 19);
    let rate = figure(&found, "kicks");
    assert!(rate.value > 5.0);
    // It has the relative error of the rate.
    let time = figure(&found, "relaxation time of the velocity, from the kicks");
    let error = rate.standard_error.unwrap() / rate.value * time.value;
    assert!((time.standard_error.unwrap() / error - 1.0).abs() < 1e-12);
    let mirror = figure(&found, "share of kicks on A less that on C");
    let error = mirror.standard_error.unwrap();
    assert!(error < 0.02 && mirror.smallest_difference == Some((THRESHOLD + SAFELY) * error));
    // The force on a locked body is bounded: it cannot show that it is driven.
    assert!(
        figure(&found, "velocity along x′")
            .smallest_difference
            .is_some()
    );
    assert!(figure(&found, "torque").smallest_difference.is_some());
    assert!(
        figure(&found, "force along x′")
            .smallest_difference
            .is_none()
    );
    let by_atom = table(&found, "kicks-body");
    assert_eq!(by_atom.header()[..3], ["atom", "kicks", "exposed_angle"]);
    let by_direction = table(&found, "kicks-directions-body");
    assert!(
        by_direction
            .header()
            .contains(&"share_of_impulse_predicted")
    );
    assert!(
        !table(&found, "kicks-contact-density-body.by-angle")
            .levels
            .is_empty()
    );
}

/// The kicks of a disc are isotropic and their components Gaussian, at any density.
#[test]
fn a_disc_is_kicked_isotropically() {
    let found = results(
        "[box]\nseed = 4\n[[molecule]]\ntags = [\"body\"]\nshape = \"disc\"\natom_radius = 0.06\natom_mass = 5.0\n\
         at = [0.5, 0.5]\n[[bumper]]\nradius = 0.01\nat = [0.1, 0.1]\n\
         [[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\narea_fraction = 0.2\n\
         [run]\nuntil = 300.0\nsample_interval = 0.2\nobserve = [\"kicks:body\"]\n",
    );
    let away = |name: &str| {
        let figure = figure(&found, name);
        (figure.value - figure.prediction.unwrap()) / figure.standard_error.unwrap()
    };
    for name in [
        "isotropy of the kicks, Fisher's F",
        "kT along x′",
        "velocity along y′",
    ] {
        assert!(away(name).abs() < 4.5, "{name}: {}", away(name));
    }
    // The disc has 2 % of the box, which the approximate density at its rim neglects.
    for name in ["kicks", "gas density at the rim"] {
        let figure = figure(&found, name);
        assert!(
            (figure.value / figure.prediction.unwrap() - 1.0).abs() < 0.04,
            "{figure:?}"
        );
    }
    let components = table(&found, "kicks-projections-body");
    let column = |name: &str| {
        &components
            .columns
            .iter()
            .find(|column| column.name == name)
            .unwrap()
            .values
    };
    let [found, errors, predicted, widths] = [
        "density_x",
        "density_x_error",
        "density_x_predicted",
        "bin_width",
    ]
    .map(column);
    // Bins of few kicks have no Gaussian errors.
    let is_full = |bin: &usize| predicted[*bin].unwrap() * widths[*bin].unwrap() > 0.005;
    let square = |bin: usize| {
        ((found[bin].unwrap() - predicted[bin].unwrap()) / errors[bin].unwrap()).powi(2)
    };
    let squares: Vec<f64> = (0..found.len()).filter(is_full).map(square).collect();
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    assert!(
        squares.len() > 20 && (0.5..2.0).contains(&mean),
        "{mean} of {}",
        squares.len()
    );
}

/// A mixture has no single boundary, and without equilibrium nothing is predicted.
#[test]
fn only_what_theory_covers_is_predicted() {
    let of = |more: &str| {
        results(&format!(
            "{PINNED}{more}[run]\nuntil = 2.0\nsample_interval = 0.1\nobserve = [\"kicks:body\"]\n"
        ))
    };
    let mixed = of("[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 20\n");
    assert!(
        mixed
            .tables
            .iter()
            .all(|table| !table.name.contains("contact-density"))
    );
    assert_eq!(figure(&mixed, "kicks").prediction, None);
    assert_eq!(figure(&mixed, "velocity along x′").prediction, Some(0.0));
    assert!(
        mixed
            .figures
            .iter()
            .all(|figure| figure.name != "gas density at the rim, body")
    );
    let inelastic = of("[elasticity]\ndefault = 0.9\n");
    let of_kicks = inelastic
        .figures
        .iter()
        .filter(|figure| figure.name.ends_with(", body"));
    let predicted: Vec<&str> = of_kicks
        .filter(|figure| figure.prediction.is_some())
        .map(|figure| figure.name.as_str())
        .collect();
    assert!(
        predicted
            .iter()
            .all(|name| name.contains("share of kicks on A less")),
        "{predicted:?}"
    );
}

#[test]
fn merged_runs_have_the_sums_of_both() {
    let record = |replica: u64| -> Record {
        let text = PINNED.replace("seed = 5", &format!("seed = 5\nreplica = {replica}"));
        let run = "[run]\nuntil = 20.0\nsample_interval = 0.1\nobserve = [\"kicks:body\"]\n";
        let scene = Scene::from_toml(&format!("{text}{run}")).unwrap();
        in_memory(&scene, &Signals::default())
            .unwrap()
            .record(&scene, &Method::default())
    };
    let alone = [record(0), record(1)];
    let [one, other] = alone.each_ref().map(merged);
    let mut both = alone[0].clone();
    both.merge(alone[1].clone()).unwrap();
    let both = merged(&both);
    // The runs are equally long.
    for name in ["kicks", "force along x′", "velocity along y′", "kT turning"] {
        let mean = 0.5 * (figure(&one, name).value + figure(&other, name).value);
        assert!(
            (figure(&both, name).value - mean).abs() < 1e-12 * (1.0 + mean.abs()),
            "{name}"
        );
    }
    let contacts = |results: &Results| -> Vec<f64> {
        let columns = &table(results, "kicks-directions-body").columns;
        columns
            .iter()
            .find(|column| column.name == "contacts")
            .unwrap()
            .values
            .iter()
            .flatten()
            .copied()
            .collect()
    };
    let sums: Vec<f64> = contacts(&one)
        .iter()
        .zip(contacts(&other))
        .map(|(one, other)| one + other)
        .collect();
    assert_eq!(contacts(&both), sums);
    // The errors of both runs together are smaller, and so are the differences that are found.
    let mirror = |results: &Results| figure(results, "share of kicks on A less that on C").clone();
    let [of_one, of_both] = [mirror(&one), mirror(&both)];
    let least = of_both.smallest_difference.unwrap();
    assert!(least < of_one.smallest_difference.unwrap());
    assert_eq!(
        least,
        (THRESHOLD + SAFELY) * of_both.standard_error.unwrap()
    );
}

#[test]
fn a_wall_is_refused() {
    let scene = Scene::from_toml(
        "[[wall]]\nx = 0.0\ntags = [\"body\"]\n[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 9\n",
    );
    let scene = scene.unwrap();
    let simulation = AnySimulation::new(&scene).unwrap();
    let refused = kicks(&scene, &simulation.view()).err().unwrap().to_string();
    assert!(refused.contains("wall-pressure"), "{refused}");
}
