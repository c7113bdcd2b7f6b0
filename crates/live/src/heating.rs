//! Heating: what an edit that sets or holds energies does to bodies at rest and to fixed bodies.
//!
//! An energy reset scales velocities. It leaves bodies at rest as they are, and fixed bodies have
//! no energy. Such an edit may therefore have no effect: it is first tried on a copy. If all
//! moving bodies of a tag are at rest, their velocities are drawn from Maxwell's distribution
//! before the reset: the directions are random, and each energy is the one that was requested.

use anyhow::{Result, bail};
use carom::{
    View,
    engine::{HeatSpec, StageSpec, ThermostatCounts, ThermostatKind, ThermostatSpec},
};
use carom_runs::run::interactive::InteractiveRun;

/// A stage whose changes of energy have an effect, with notes for the user.
#[derive(Debug, Clone, PartialEq)]
pub struct Heating {
    /// The stage, with draws of velocities where bodies are at rest.
    pub stage: StageSpec,
    /// Sentences for the user.
    pub notes: Vec<String>,
}

impl Heating {
    /// Tries the edit that begins `stage` with the thermostats `hold`.
    ///
    /// # Errors
    /// The edit is refused by the engine, or it would change the energy of no body with a tag.
    pub fn new(
        run: &InteractiveRun,
        stage: &StageSpec,
        hold: Option<&[ThermostatSpec]>,
    ) -> Result<Self> {
        let heats = heats_at_start(run, stage, hold);
        let mut heating = Self {
            stage: stage.clone(),
            notes: Vec::new(),
        };
        if heats.is_empty() {
            return Ok(heating);
        }
        let mut trial = run.clone();
        trial.edit(stage, hold, &mut ())?;
        let mut drawn: Vec<HeatSpec> = Vec::new();
        for (index, (tag, heat)) in heats.iter().enumerate() {
            if heats[..index].iter().any(|(other, _)| other == tag) {
                continue;
            }
            let changed = counts(&trial.view(), tag).changed - counts(&run.view(), tag).changed;
            let Members {
                fixed,
                at_rest,
                moving,
            } = Members::new(&trial.view(), tag);
            if changed == 0 && at_rest == 0 {
                match fixed {
                    0 => bail!("no body has the tag {tag}: the energy of no body would change"),
                    _ => bail!(
                        "all bodies with the tag {tag} ({fixed}) are fixed: they have no energy"
                    ),
                }
            }
            if let Some(heat) = heat
                && changed == 0
            {
                drawn.push(HeatSpec {
                    kind: ThermostatKind::Maxwell,
                    ..heat.clone()
                });
                heating.notes.push(format!(
                    "{} at rest: random directions were drawn.",
                    bodies(at_rest, "was", "were")
                ));
            } else if at_rest > 0 {
                let stay = bodies(at_rest, "is at rest and remains", "are at rest and remain");
                heating.notes.push(format!("{stay} so; {moving} changed."));
            }
            if fixed > 0 {
                heating.notes.push(format!(
                    "{} fixed and left out.",
                    bodies(fixed, "is", "are")
                ));
            }
        }
        heating.stage.set_energy.splice(0..0, drawn);
        Ok(heating)
    }
}

/// The changes of energy at the start of a stage: those of the stage itself, and the first action
/// of each thermostat in `hold` that does not act yet, by tag; `None` for a thermostat whose action
/// is no change of energy.
fn heats_at_start(
    run: &InteractiveRun,
    stage: &StageSpec,
    hold: Option<&[ThermostatSpec]>,
) -> Vec<(String, Option<HeatSpec>)> {
    let begun = hold
        .unwrap_or(&[])
        .iter()
        .filter(|each| !run.thermostats().contains(each));
    let begun = begun.map(|each| (each.tag.clone(), each.action()));
    let set = stage.set_energy.iter();
    set.map(|heat| (heat.tag.clone(), Some(heat.clone())))
        .chain(begun)
        .collect()
}

/// A number of bodies with its verb.
fn bodies(count: usize, one: &str, many: &str) -> String {
    if count == 1 {
        format!("1 body {one}")
    } else {
        format!("{count} bodies {many}")
    }
}

/// The bodies that thermostats on a tag have changed and left out so far.
fn counts(view: &View<'_>, tag: &str) -> ThermostatCounts {
    let tag = view.tag_names().find(tag);
    let given = view
        .heat()
        .all()
        .iter()
        .find(|given| Some(given.tag) == tag);
    given.map_or_else(ThermostatCounts::default, |given| given.counts)
}

/// Numbers of the bodies with a tag.
struct Members {
    fixed: usize,
    at_rest: usize,
    moving: usize,
}

impl Members {
    fn new(view: &View<'_>, tag: &str) -> Self {
        let mut members = Self {
            fixed: 0,
            at_rest: 0,
            moving: 0,
        };
        let tagged = view
            .tag_names()
            .find(tag)
            .into_iter()
            .flat_map(|tag| view.tagged(tag));
        for body in tagged {
            if !body.body.is_free() {
                members.fixed += 1;
            } else if body.energy() == 0.0 {
                members.at_rest += 1;
            } else {
                members.moving += 1;
            }
        }
        members
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::Scene;

    /// Tees and discs at rest, a disc that moves, and a bumper.
    const SCENE: &str = r#"
        [[molecule]]
        tags = ["tees", "rest"]
        shape = "tee"
        atom_radius = 0.01
        atom_mass = 1.0
        at = [0.2, 0.2]
        [[molecule]]
        tags = ["discs", "rest"]
        shape = "disc"
        atom_radius = 0.01
        atom_mass = 1.0
        at = [0.5, 0.2]
        [[molecule]]
        tags = ["discs"]
        shape = "disc"
        atom_radius = 0.01
        atom_mass = 1.0
        at = [0.8, 0.2]
        velocity = [1.0, 0.0]
        [[bumper]]
        tags = ["fixed", "discs"]
        radius = 0.01
        at = [0.5, 0.8]
    "#;

    fn run() -> InteractiveRun {
        InteractiveRun::new(&Scene::from_toml(SCENE).unwrap()).unwrap()
    }

    fn set(tag: &str, energy: Option<f64>, temperature: Option<f64>) -> StageSpec {
        let heat = HeatSpec {
            tag: tag.to_owned(),
            energy,
            temperature,
            ..HeatSpec::default()
        };
        StageSpec {
            set_energy: vec![heat],
            ..StageSpec::default()
        }
    }

    /// The energies of the molecules after an edit, and its notes.
    fn heated(stage: &StageSpec, hold: Option<&[ThermostatSpec]>) -> (Vec<f64>, Vec<String>) {
        let mut run = run();
        let Heating { stage, notes } = Heating::new(&run, stage, hold).unwrap();
        run.edit(&stage, hold, &mut ()).unwrap();
        let bodies = run.view();
        let molecules = bodies.bodies().filter(|body| body.body.is_free());
        (molecules.map(|body| body.energy()).collect(), notes)
    }

    fn assert_near(found: &[f64], expected: [f64; 3]) {
        for (one, other) in found.iter().zip(expected) {
            assert!((one - other).abs() < 1e-12, "{found:?} {expected:?}");
        }
    }

    #[test]
    fn bodies_at_rest_get_the_energy_that_is_set_in_random_directions() {
        let (energies, notes) = heated(&set("rest", Some(3.0), None), None);
        assert_near(&energies, [3.0, 3.0, 0.5]);
        assert_eq!(
            notes,
            ["2 bodies were at rest: random directions were drawn."]
        );
        // A molecule that turns has 3/2 kT, a disc kT.
        let (energies, _) = heated(&set("rest", None, Some(2.0)), None);
        assert_near(&energies, [3.0, 2.0, 0.5]);
        let hold = ThermostatSpec {
            tag: "rest".to_owned(),
            every: 0.1,
            energy: Some(4.0),
            ..ThermostatSpec::default()
        };
        let (energies, notes) = heated(&StageSpec::default(), Some(&[hold]));
        assert_near(&energies, [4.0, 4.0, 0.5]);
        assert_eq!(notes.len(), 1);
    }

    #[test]
    fn bodies_that_are_left_out_are_counted() {
        let (energies, notes) = heated(&set("discs", Some(2.0), None), None);
        assert_near(&energies, [0.0, 0.0, 2.0]);
        assert_eq!(
            notes,
            [
                "1 body is at rest and remains so; 1 changed.",
                "1 body is fixed and left out."
            ]
        );
    }

    #[test]
    fn an_edit_that_heats_no_body_is_refused_in_words() {
        let refused = |stage: &StageSpec, hold: Option<&[ThermostatSpec]>| {
            Heating::new(&run(), stage, hold).unwrap_err().to_string()
        };
        let text = refused(&set("fixed", Some(1.0), None), None);
        assert_eq!(
            text,
            "all bodies with the tag fixed (1) are fixed: they have no energy"
        );
        let drawn = ThermostatKind::Maxwell;
        let hold = ThermostatSpec {
            tag: "fixed".to_owned(),
            every: 1.0,
            energy: Some(1.0),
            ..Default::default()
        };
        for kind in [ThermostatKind::EnergyReset, drawn] {
            let text = refused(
                &StageSpec::default(),
                Some(&[ThermostatSpec {
                    kind,
                    ..hold.clone()
                }]),
            );
            assert!(text.contains("are fixed"), "{text}");
        }
        let removed = StageSpec {
            remove: vec!["tees".to_owned()],
            ..set("tees", Some(1.0), None)
        };
        assert!(refused(&removed, None).contains("no body has the tag tees"));
    }
}
