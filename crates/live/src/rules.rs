//! Single elasticities and thermostats of an edit, put into those in force.

use anyhow::{Context, Result, ensure};
use carom::{
    View,
    engine::{ElasticitySpec, ThermostatSpec},
};
use carom_runs::run::interactive::InteractiveRun;

use crate::protocol::LiveEdit;

/// A thermostat without an interval acts after this share of the time in which a body crosses the
/// box.
const SHARE_OF_CROSSING: f64 = 0.1;

/// The elasticities of the stage of an edit; `None` if it does not change them.
///
/// # Errors
/// There is no rule between the tags of one that should end.
pub fn elasticity(run: &InteractiveRun, edit: &LiveEdit) -> Result<Option<ElasticitySpec>> {
    let LiveEdit {
        stage,
        elasticity,
        set_rule,
        drop_rule,
        ..
    } = edit;
    if elasticity.is_none() && set_rule.is_empty() && drop_rule.is_empty() {
        return Ok(stage.elasticity.clone());
    }
    let mut spec = stage
        .elasticity
        .as_ref()
        .unwrap_or(run.elasticity())
        .clone();
    spec.default = elasticity.unwrap_or(spec.default);
    for between in drop_rule {
        let before = spec.pair.len();
        spec.pair.retain(|rule| !is_same(&rule.between, between));
        ensure!(
            spec.pair.len() < before,
            "there is no rule between {}",
            between.join(" and ")
        );
    }
    for rule in set_rule {
        spec.pair
            .retain(|old| !is_same(&old.between, &rule.between));
        spec.pair.push(rule.clone());
    }
    Ok(Some(spec))
}

/// Whether two lists have the same tags, in any order.
fn is_same(one: &[String], other: &[String]) -> bool {
    let sorted = |tags: &[String]| {
        let mut tags = tags.to_vec();
        tags.sort_unstable();
        tags
    };
    sorted(one) == sorted(other)
}

/// The thermostats of the stage of an edit; `None` if those in force continue.
///
/// # Errors
/// A tag whose thermostat should end has none, or a target is out of range.
pub fn thermostats(run: &InteractiveRun, edit: &LiveEdit) -> Result<Option<Vec<ThermostatSpec>>> {
    let LiveEdit {
        hold,
        begin_hold,
        end_hold,
        ..
    } = edit;
    if begin_hold.is_empty() && end_hold.is_empty() {
        return Ok(hold.clone());
    }
    let mut specs = hold.as_deref().unwrap_or(run.thermostats()).to_vec();
    for tag in end_hold {
        let before = specs.len();
        specs.retain(|spec| spec.tag != *tag);
        ensure!(specs.len() < before, "no thermostat acts on {tag}");
    }
    for spec in begin_hold {
        specs.retain(|old| old.tag != spec.tag);
        let mut spec = spec.clone();
        if spec.every == 0.0 {
            spec.every = interval(&run.view(), &spec)
                .with_context(|| format!("thermostat on {}", spec.tag))?;
        }
        specs.push(spec);
    }
    Ok(Some(specs))
}

/// An interval for a thermostat: a share of the time in which a body of its tag crosses the shorter
/// side of the box, at the target, with two digits; 1 if no body moves.
fn interval(view: &View<'_>, spec: &ThermostatSpec) -> Result<f64> {
    let action = spec
        .action()
        .context("give `every`: only energies have an interval of their own")?;
    let target = action.target("begin_hold")?;
    let tagged = view
        .tag_names()
        .find(&spec.tag)
        .into_iter()
        .flat_map(|tag| view.tagged(tag));
    let moving = tagged.filter(|body| body.body.is_free());
    let (sum, count) = moving.fold((0.0, 0_u32), |(sum, count), body| {
        // The root mean square speed in a plane.
        let square = 2.0 * target.temperature_of(body.body) * body.body.inertia().inverse_mass;
        (sum + square.sqrt(), count + 1)
    });
    let crossing = view.bounds().sides().min_element() * f64::from(count) / sum;
    let rounded = format!("{:.1e}", SHARE_OF_CROSSING * crossing).parse();
    Ok(rounded
        .ok()
        .filter(|every: &f64| every.is_finite() && *every > 0.0)
        .unwrap_or(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{Scene, engine::ElasticityRule};

    fn rule(between: &[&str], coefficient: f64) -> ElasticityRule {
        ElasticityRule {
            between: names(between),
            coefficient: coefficient.into(),
            ..ElasticityRule::default()
        }
    }

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|&name| name.to_owned()).collect()
    }

    fn held(tag: &str, energy: f64) -> ThermostatSpec {
        ThermostatSpec {
            tag: tag.to_owned(),
            energy: Some(energy),
            ..ThermostatSpec::default()
        }
    }

    #[test]
    fn single_rules_and_thermostats_leave_the_others_in_force() {
        let scene = "[elasticity]\ndefault = 0.9\npair = [{ between = [\"a\", \"b\"], coefficient = 0.5 }]\n\
             [[gas]]\ntags = [\"a\"]\nradius = 0.01\nmass = 2.0\nenergy = 1.0\ncount = 3\n\
             [[gas]]\ntags = [\"b\"]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 3";
        let mut run = InteractiveRun::new(&Scene::from_toml(scene).unwrap()).unwrap();
        let mut make = |edit: LiveEdit| -> Result<()> {
            let (stage, hold) = (
                carom::engine::StageSpec {
                    elasticity: elasticity(&run, &edit)?,
                    ..edit.stage.clone()
                },
                thermostats(&run, &edit)?,
            );
            run.edit(&stage, hold.as_deref(), &mut ()).map(|_| ())
        };
        make(LiveEdit {
            set_rule: vec![rule(&["a"], 0.7)],
            ..LiveEdit::default()
        })
        .unwrap();
        make(LiveEdit {
            elasticity: Some(0.8),
            ..LiveEdit::default()
        })
        .unwrap();
        make(LiveEdit {
            set_rule: vec![rule(&["b", "a"], 0.6)],
            ..LiveEdit::default()
        })
        .unwrap();
        make(LiveEdit {
            begin_hold: vec![held("a", 1.0)],
            ..LiveEdit::default()
        })
        .unwrap();
        make(LiveEdit {
            begin_hold: vec![held("b", 2.0)],
            ..LiveEdit::default()
        })
        .unwrap();
        make(LiveEdit {
            begin_hold: vec![held("a", 4.0)],
            ..LiveEdit::default()
        })
        .unwrap();
        let refused = make(LiveEdit {
            drop_rule: vec![names(&["b"])],
            ..LiveEdit::default()
        })
        .unwrap_err();
        assert!(refused.to_string().contains("no rule between b"));
        let refused = make(LiveEdit {
            end_hold: names(&["c"]),
            ..LiveEdit::default()
        })
        .unwrap_err();
        assert!(refused.to_string().contains("on c"));
        assert_eq!(run.elasticity().default, 0.8);
        assert_eq!(
            run.elasticity().pair,
            [rule(&["a"], 0.7), rule(&["b", "a"], 0.6)]
        );
        let found: Vec<_> = run
            .thermostats()
            .iter()
            .map(|spec| (spec.tag.as_str(), spec.every))
            .collect();
        // Discs of energy 2 and mass 1, and of energy 4 and mass 2: speed 2.
        assert_eq!(found, [("b", 0.05), ("a", 0.05)]);
    }
}
