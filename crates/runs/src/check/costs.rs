//! What a scene pays for, and what it does not.

use carom::{
    Scene, View,
    engine::{Body, BodyView},
};
use carom_methods::Method;
use serde::Serialize;

use super::contents::CheckedContents;
use crate::{
    measures::Measures,
    sampling_times::{sampling_count, sampling_times},
    schedule::stages,
};

/// A capability of the program.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Cost {
    pub(super) what: &'static str,
    /// Whether this scene uses it, and pays for it.
    pub(super) is_paid: bool,
    pub(super) words: String,
}

/// The capabilities that cost time, in the order in which they cost.
pub(super) fn costs(
    scene: &Scene,
    view: &View<'_>,
    measures: &Measures,
    contents: &CheckedContents,
) -> Vec<Cost> {
    vec![
        molecules(view, contents),
        fixed(view),
        elasticity(scene),
        rough(scene, view),
        contacts(measures),
        samples(scene, measures),
        snapshots(scene),
        animation(scene),
        thermostats(scene),
    ]
}

/// The price of the method; `None` if it is exact.
pub(super) fn price(method: &Method) -> Option<&'static str> {
    (!method.is_exact()).then_some("not measured; `carom trade SCENE` measures it")
}

fn cost(what: &'static str, paid: Option<String>, free: &str) -> Cost {
    Cost {
        what,
        is_paid: paid.is_some(),
        words: paid.unwrap_or_else(|| free.to_owned()),
    }
}

fn molecules(view: &View<'_>, contents: &CheckedContents) -> Cost {
    let bodies = || {
        view.bodies()
            .map(|view| view.body)
            .filter(|body| !body.is_wall())
    };
    let molecules = bodies().filter(|body| !body.molecule().is_disc()).count();
    let atoms = bodies()
        .map(|body| body.molecule().atoms().len())
        .max()
        .unwrap_or(0);
    let edges = bodies()
        .map(|body| body.molecule().edges().len())
        .max()
        .unwrap_or(0);
    let parts = if edges > 0 {
        format!("{atoms} atoms and {edges} edges")
    } else {
        format!("{atoms} atoms")
    };
    let paid = (molecules > 0).then(|| {
        format!(
            "{molecules} of up to {parts}, {} turning: orientations, searches of their pairs",
            contents.turning
        )
    });
    cost(
        "molecules",
        paid,
        "discs only: no orientations, no searches",
    )
}

fn fixed(view: &View<'_>) -> Cost {
    let count = |of: fn(&Body) -> bool| view.bodies().filter(|view| of(view.body)).count();
    let walls = count(|body| body.is_wall() && body.is_fixed());
    let bumpers = count(Body::is_fixed) - walls;
    let pistons = count(Body::is_piston);
    let thermal = count(|body| body.wall_temperature().is_some());
    let is_moved = |wall: &BodyView<'_>| wall.body.is_fixed() && !wall.motion.is_at_rest();
    let moved = view.bodies().filter(is_moved).count();
    let mut parts = Vec::new();
    for (number, name) in [
        (walls, "walls"),
        (moved, "that move"),
        (thermal, "with a temperature"),
        (pistons, "pistons"),
        (bumpers, "fixed discs"),
    ] {
        if number > 0 {
            parts.push(format!("{name}: {number}"));
        }
    }
    cost(
        "walls, fixed bodies",
        (!parts.is_empty()).then(|| parts.join(", ")),
        "none",
    )
}

fn elasticity(scene: &Scene) -> Cost {
    let mut specs = [&scene.elasticity].into_iter().chain(
        scene
            .stage
            .iter()
            .filter_map(|stage| stage.elasticity.as_ref()),
    );
    let is_guarded = specs.any(|spec| spec.least_coefficient() < 1.0);
    let paid = is_guarded
        .then(|| "some contacts lose energy: times of last contacts for the guard".to_owned());
    cost(
        "elasticity",
        paid,
        "no contact loses energy: no guard against inelastic collapse",
    )
}

fn rough(scene: &Scene, view: &View<'_>) -> Cost {
    let stages = scene
        .stage
        .iter()
        .filter_map(|stage| stage.elasticity.as_ref());
    let is_rough = [&scene.elasticity]
        .into_iter()
        .chain(stages)
        .any(carom::engine::ElasticitySpec::is_rough);
    let bodies = view.bodies().map(|view| view.body);
    let turning = bodies
        .filter(|body| body.molecule().is_round() && body.can_turn())
        .count();
    let paid = is_rough.then(|| {
        format!(
            "tangential impulses; {turning} discs turn at the start: a motion beside each record"
        )
    });
    cost(
        "rough contacts",
        paid,
        "all contacts are smooth: discs have no spins",
    )
}

fn contacts(measures: &Measures) -> Cost {
    let watching = measures.watching();
    let paid =
        (!watching.is_empty()).then(|| format!("reports of contacts for {}", watching.join(", ")));
    cost("observers", paid, "none watches contacts: no reports")
}

fn samples(scene: &Scene, measures: &Measures) -> Cost {
    let run = &scene.run;
    let samples = sampling_times(0.0, run.until, run.sample_interval).count() as u64;
    let checks = run
        .check_interval
        .map_or(samples, |interval| sampling_count(0.0, run.until, interval));
    let words = format!(
        "{samples} of {} measures; {checks} checks for overlaps",
        measures.len()
    );
    cost("samples", Some(words), "")
}

fn snapshots(scene: &Scene) -> Cost {
    let run = &scene.run;
    let count = |interval| sampling_count(0.0, run.until, interval) + 1;
    let paid = run.snapshots.as_ref().map(|format| {
        format!(
            "{} frames ({format})",
            count(run.snapshot_interval.unwrap_or(run.sample_interval))
        )
    });
    cost("snapshots", paid, "none")
}

fn animation(scene: &Scene) -> Cost {
    let run = &scene.run;
    let paid = run
        .animation
        .then(|| format!("the first contacts from t = {} on", run.animation_from));
    cost("animation", paid, "none")
}

fn thermostats(scene: &Scene) -> Cost {
    let count: u64 = stages::action_counts(scene).iter().flatten().sum();
    let paid =
        (count > 0).then(|| format!("{count} actions, each with a prediction of all bodies"));
    cost("thermostats", paid, "none")
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_methods::AnySimulation;

    fn paid(text: &str) -> Vec<(&'static str, bool, String)> {
        let scene = Scene::from_toml(text).unwrap();
        let simulation = AnySimulation::new(&scene).unwrap();
        let (view, measures) = (
            simulation.view(),
            Measures::new(&scene, &simulation.view()).unwrap(),
        );
        let all = costs(
            &scene,
            &view,
            &measures,
            &CheckedContents::new(&scene, &view),
        );
        all.into_iter()
            .map(|cost| (cost.what, cost.is_paid, cost.words))
            .collect()
    }

    #[test]
    fn a_gas_of_discs_pays_for_samples_only() {
        let gas = "[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 20\n[run]\nanimation = false\n";
        let all = paid(gas);
        let names: Vec<&str> = all
            .iter()
            .filter(|(_, is_paid, _)| *is_paid)
            .map(|(name, ..)| *name)
            .collect();
        assert_eq!(names, ["samples"]);
        assert_eq!(all[0].2, "discs only: no orientations, no searches");
    }

    #[test]
    fn what_is_in_the_scene_is_paid_for() {
        let all = paid(
            "[[molecule]]\ntags = [\"tee\"]\nshape = \"tee\"\natom_radius = 0.02\natom_mass = 1.0\nat = [0.5, 0.5]\n\
             velocity = [1.0, 0.0]\n[[wall]]\nx = 0.0\ntemperature = 1.0\n[[bumper]]\nradius = 0.05\nat = [0.2, 0.2]\n\
             [elasticity]\ndefault = 0.9\ntangential = 0.5\n[run]\nsnapshots = \"extxyz\"\nobserve = [\"pressure\", \"directions:tee\"]\n\
             [[stage]]\nuntil = 1.0\nthermostat = [{ tag = \"tee\", every = 0.25, energy = 1.0 }]\n",
        );
        assert!(all.iter().all(|(_, is_paid, _)| *is_paid), "{all:?}");
        let words = |what: &str| &all.iter().find(|(name, ..)| *name == what).unwrap().2;
        assert!(
            words("molecules").starts_with("1 of up to 5 atoms, 1 turning"),
            "{all:?}"
        );
        assert_eq!(
            words("walls, fixed bodies"),
            "walls: 1, with a temperature: 1, fixed discs: 1"
        );
        assert_eq!(
            words("observers"),
            "reports of contacts for pressure, directions:tee"
        );
        assert!(words("thermostats").starts_with("4 actions"), "{all:?}");
    }

    #[test]
    fn pistons_are_neither_fixed_bodies_nor_molecules() {
        let all = paid(
            "[[piston]]\nx = 0.5\nmass = 3.0\nstops = [0.2, 0.8]\n[[wall]]\ny = 0.0\n\
             [[bumper]]\nradius = 0.05\nat = [0.2, 0.2]\n",
        );
        let words = |what: &str| &all.iter().find(|(name, ..)| *name == what).unwrap().2;
        assert_eq!(
            words("walls, fixed bodies"),
            "walls: 1, pistons: 1, fixed discs: 1"
        );
        assert!(words("molecules").starts_with("discs only"), "{all:?}");
    }
}
