//! Mutated scene files: each is refused by name, or builds a system that runs without overlap.

use carom::engine::{
    Distribution, GasSpec, Placement, Quantity, RunError, Scene, StartVelocities, View,
};
use carom_kinematics::EpochTime;
use carom_methods::AnySimulation;

use super::mutate;
use crate::fuzz::{random::FuzzDraw, scenes, subject::Report};

/// Largest numbers of epochs and of contacts of one run.
const MAX_EPOCHS: u32 = 300;
const MAX_CONTACTS: u64 = 3000;

/// Scenes with more atoms are skipped because they are slow.
const MAX_ATOMS: f64 = 2e4;

/// Scenes with more atoms are placed on lattices only.
const MAX_ATOMS_TO_GROW: f64 = 200.0;

/// Most collisions a molecule in a relaxation.
const MAX_RELAXATION: f64 = 10.0;

/// A mutated scene file.
pub fn draw(draw: &mut FuzzDraw) -> Vec<u8> {
    let mut scene = scenes::draw::draw(draw.bits()).scene;
    // Short scenes, so that mutations affect relevant places.
    scene.molecule.truncate(draw.integer(0, 8) as usize);
    if draw.happens(0.6) {
        scene.gas.push(GasSpec {
            tags: vec!["gas".to_owned()],
            shape: draw.happens(0.3).then(|| "dumbbell".to_owned()),
            atom_radius: Some((0.02 * scene.bounds.sides[0]).into()),
            atom_mass: Some(1.0.into()),
            energy: 1.0,
            count: draw.happens(0.5).then_some(20),
            ..GasSpec::default()
        });
        if let Some(gas) = scene.gas.last_mut()
            && gas.count.is_none()
        {
            gas.area_fraction = Some(0.2);
        }
        if let Some(gas) = scene.gas.last_mut()
            && draw.happens(0.3)
        {
            (gas.energy, gas.temperature) = (0.0, Some(1.0));
            if draw.happens(0.3) {
                let side = scene.bounds.sides[0];
                gas.atom_radius = Some(Distribution::Uniform([0.01 * side, 0.02 * side]).into());
            }
            gas.velocities = draw.one_of(&[StartVelocities::EqualEnergy, StartVelocities::Maxwell]);
        }
    }
    if draw.happens(0.1) {
        scene.start.placement = Some(Placement::Grown);
        scene.start.relax = Some(5.0);
    }
    for wall in &mut scene.wall {
        wall.temperature = draw.happens(0.2).then_some(1.0);
    }
    let text = scene.to_toml();
    if draw.happens(0.05) {
        text.into_bytes()
    } else {
        mutate::text(draw, &text)
    }
}

/// Reads the file and runs its scene.
pub fn check(bytes: &[u8], report: &mut Report) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        report.count("scenes refused", 1);
        return;
    };
    let Ok(mut scene) = Scene::from_toml(text) else {
        report.count("scenes refused", 1);
        return;
    };
    if Scene::from_toml(&scene.to_toml()).is_ok_and(|again| again != scene) && !has_nan(&scene) {
        report.fail("round trip", "a scene differs after encoding and decoding");
    }
    if size(&scene) > MAX_ATOMS {
        report.count("scenes too large to try", 1);
        return;
    }
    // Many atoms take too long to grow or to relax.
    if size(&scene) > MAX_ATOMS_TO_GROW {
        scene.start.placement = Some(Placement::Lattice);
    }
    scene.start.relax = scene
        .start
        .relax
        .map(|collisions| collisions.min(MAX_RELAXATION))
        .or(Some(0.0));
    match AnySimulation::new(&scene) {
        Err(_) => report.count("scenes refused", 1),
        Ok(mut simulation) => {
            report.count("scenes run", 1);
            let until = if scene.run.until.is_finite() && scene.run.until > 0.0 {
                scene.run.until
            } else {
                1.0
            };
            run(&mut simulation, until, report);
        }
    }
}

fn has_nan(scene: &Scene) -> bool {
    scene.to_toml().contains("nan")
}

/// Mean or least number of a distribution.
fn small(given: &Quantity) -> f64 {
    match given {
        Quantity::Number(number) => *number,
        Quantity::Drawn(Distribution::Uniform([from, to])) => 0.5 * (from + to),
        Quantity::Drawn(Distribution::Normal([mean, _])) => *mean,
        Quantity::Drawn(Distribution::Values { values, .. }) => {
            values.iter().copied().fold(f64::INFINITY, f64::min)
        }
        Quantity::Drawn(_) => 0.0,
    }
}

/// Approximate number of atoms of the scene.
fn size(scene: &Scene) -> f64 {
    let [width, height] = scene.bounds.sides;
    let atoms = |shape: Option<&String>, list: usize| {
        let named = shape
            .and_then(|shape| shape.split_once(':'))
            .filter(|(name, _)| *name != "ellipse")
            .and_then(|(_, count)| count.parse().ok());
        // What follows the name of a shape with sides may be a length below 1.
        named.unwrap_or(5.0_f64).max(1.0).max(list as f64)
    };
    let of_molecules: f64 = scene
        .molecule
        .iter()
        .map(|molecule| {
            let parts = molecule.atoms.len() + molecule.ellipses.len();
            let list = parts.max(molecule.polygon.len());
            atoms(molecule.shape.as_ref(), list)
        })
        .sum();
    let of_gas = |gas: &GasSpec| {
        let given = [&gas.radius, &gas.atom_radius, &gas.size]
            .into_iter()
            .find_map(Option::as_ref);
        let radius = given
            .map(small)
            .or(gas.atoms.first().map(|atom| atom.radius));
        let scale = gas.scale.as_ref().map_or(1.0, small);
        let covered = std::f64::consts::PI * (scale * radius.unwrap_or(1.0)).powi(2);
        let by_area = gas
            .area_fraction
            .map_or(0.0, |share| share * (width * height / covered).abs());
        let count = gas.count.map_or(by_area, |count| count as f64);
        let atoms = atoms(gas.shape.as_ref(), gas.atoms.len().max(gas.polygon.len()));
        // A scene with more molecules is refused, at once if they are equal.
        let is_equal = given.is_none_or(|given| given.number().is_some()) && gas.scale.is_none();
        if is_equal && count > 134_217_728.0 * atoms {
            0.0
        } else {
            count * atoms
        }
    };
    of_molecules + scene.gas.iter().map(of_gas).sum::<f64>()
}

/// Runs for some epochs: no overlap, no NaN, and an early end has a named error.
pub fn run(simulation: &mut AnySimulation, until: f64, report: &mut Report) {
    check_view(&simulation.view(), "at the start", report);
    let contacts = simulation.view().counters().collisions;
    let target = EpochTime::ZERO.after(until);
    let target = if simulation.time().since(target) > 0.0 {
        simulation.time().after(until)
    } else {
        target
    };
    for _ in 0..MAX_EPOCHS {
        match simulation.observe_epoch(target, &mut ()) {
            Ok(true) => break,
            Ok(false) => {}
            Err(error) => {
                named(&error, report);
                break;
            }
        }
        if simulation
            .view()
            .counters()
            .collisions
            .saturating_sub(contacts)
            > MAX_CONTACTS
        {
            break;
        }
    }
    report.count(
        "contacts",
        simulation
            .view()
            .counters()
            .collisions
            .saturating_sub(contacts),
    );
    check_view(&simulation.view(), "after a run", report);
}

fn named(error: &RunError, report: &mut Report) {
    report.count("ended by name", 1);
    if error.to_string().contains("NaN") {
        report.fail("NaN", error.to_string());
    }
}

/// Checks that every body is in the box and does not overlap another.
fn check_view(view: &View<'_>, when: &str, report: &mut Report) {
    for body in view.bodies() {
        let motion = body.motion;
        let numbers = [
            motion.position.x,
            motion.position.y,
            motion.velocity.x,
            motion.velocity.y,
            motion.orientation.turns(),
            motion.angular_velocity,
        ];
        if numbers.iter().any(|number| !number.is_finite()) {
            report.fail(
                "NaN",
                format!("{when} body {} has {numbers:?}", body.body.id()),
            );
        }
    }
    let overlaps = view.overlaps();
    if overlaps.pairs > 0 {
        report.fail("overlap", format!("{when}: {overlaps:?}"));
    }
    if !view.energy().is_finite() || !view.ledger().booked().is_finite() {
        report.fail(
            "NaN",
            format!(
                "{when} the energy is {}, the ledger {:?}",
                view.energy(),
                view.ledger()
            ),
        );
    }
}
