//! The units of `run.units`: those of the first gas, or given ones.

use std::f64::consts::PI;

use anyhow::{Context, Result, bail, ensure};
use carom::{
    Scene,
    engine::{GasSpec, Quantity, UnitsSpec},
    geometry::{MAX_MAGNITUDE, MIN_MAGNITUDE},
};
use carom_tables::{ReportUnits, significant};

/// What to write where the first gas does not define the units.
const REMEDY: &str = "write run.units = { length = σ, mass = m, energy = ε }";

/// The units in which the results of a scene are shown; `None` for its own. They follow from the
/// scene file alone, so that all replicas have the same.
///
/// # Errors
/// A unit is not positive, or the first gas does not define the three.
pub fn units(scene: &Scene) -> Result<Option<ReportUnits>> {
    let units = match scene.run.units {
        None => return Ok(None),
        Some(UnitsSpec::Reduced) => of_first_gas(scene).context("run.units = \"reduced\"")?,
        Some(UnitsSpec::Given {
            length,
            mass,
            energy,
        }) => ReportUnits {
            length,
            mass,
            energy,
        },
    };
    for (name, unit) in [
        ("length", units.length),
        ("mass", units.mass),
        ("energy", units.energy),
    ] {
        ensure!(
            (MIN_MAGNITUDE..=MAX_MAGNITUDE).contains(&unit),
            "run.units: the unit of {name} must be from {MIN_MAGNITUDE:e} to {MAX_MAGNITUDE:e}, \
             but is {unit:?}"
        );
    }
    Ok(Some(units))
}

/// What a reader of the page must know.
pub(crate) fn in_words(units: &ReportUnits) -> String {
    let [length, mass, energy, time] =
        [units.length, units.mass, units.energy, units.time()].map(|unit| significant(unit, 6));
    format!(
        "Figures and charts are in units of σ = {length} (length), m = {mass} (mass), ε = {energy} (energy) and \
         τ = σ√(m/ε) = {time} (time) of the scene. Times in sentences, numbers in names, pictures and files are in those \
         of the scene."
    )
}

fn of_first_gas(scene: &Scene) -> Result<ReportUnits> {
    let gas = scene
        .gas
        .iter()
        .find(|gas| !gas.fixed && gas.count != Some(0));
    let gas = gas.with_context(|| format!("no gas moves: {REMEDY}"))?;
    let is_disc = gas.atoms.is_empty() && gas.ellipses.is_empty() && gas.polygon.is_empty();
    let is_named = gas.shape.as_deref().is_none_or(|name| name == "disc");
    if !is_disc || !is_named {
        bail!("the first gas that moves is not of discs: {REMEDY}");
    }
    let energy = gas.temperature.filter(|&temperature| temperature > 0.0);
    let energy = energy.with_context(|| {
        format!("the first gas that moves has no `temperature` above 0: {REMEDY}")
    })?;
    let (radius, mass) = size(gas).with_context(|| {
        format!("the discs of the first gas that moves are not of one size and mass: {REMEDY}")
    })?;
    Ok(ReportUnits {
        length: 2.0 * radius,
        mass,
        energy,
    })
}

/// Radius and mass of the discs of a gas, if all are alike.
fn size(gas: &GasSpec) -> Option<(f64, f64)> {
    let number = |quantity: &Option<Quantity>| quantity.as_ref()?.number();
    let scale = gas.scale.as_ref().map_or(Some(1.0), Quantity::number)?;
    let radius = scale * number(&gas.radius).or_else(|| number(&gas.atom_radius))?;
    let mass = match gas.density {
        Some(density) => density * PI * radius * radius,
        None => number(&gas.mass).or_else(|| number(&gas.atom_mass))?,
    };
    Some((radius, mass))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn units_of(text: &str) -> Result<Option<ReportUnits>> {
        units(&Scene::from_toml(text).expect("a scene"))
    }

    #[test]
    fn reduced_units_are_those_of_the_first_gas_that_moves() {
        let walls = "[[gas]]\nradius = 0.3\nmass = 1.0\nfixed = true\ncount = 1\n";
        let discs = "[[gas]]\nradius = 0.01\nmass = 2.0\ntemperature = 8.0\ncount = 5\n";
        let run = "[run]\nunits = \"reduced\"\n";
        let found = units_of(&format!("{walls}{discs}{run}")).expect("discs");
        let found = found.expect("units are asked for");
        assert_eq!((found.length, found.mass, found.energy), (0.02, 2.0, 8.0));
        assert_eq!(found.time(), 0.01);
        let scaled = discs.replace("mass = 2.0", "density = 100.0\nscale = 2.0");
        let found = units_of(&format!("{scaled}{run}"))
            .expect("discs")
            .expect("units");
        assert_eq!(found.length, 0.04);
        assert!((found.mass - 100.0 * PI * 4e-4).abs() < 1e-15);
        assert_eq!(units_of(discs).expect("a scene"), None);
    }

    #[test]
    fn what_defines_no_units_is_refused_with_the_remedy() {
        let run = "[run]\nunits = \"reduced\"\n";
        for (gas, expected) in [
            ("", "no gas moves"),
            (
                "[[gas]]\nshape = \"tee\"\natom_radius = 0.01\natom_mass = 1.0\ntemperature = 1.0\ncount = 1\n",
                "not of discs",
            ),
            (
                "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 1\n",
                "no `temperature`",
            ),
            (
                "[[gas]]\nradius = { uniform = [0.01, 0.02] }\nmass = 1.0\ntemperature = 1.0\ncount = 1\n",
                "not of one size",
            ),
        ] {
            let error = format!("{:#}", units_of(&format!("{gas}{run}")).expect_err(gas));
            assert!(
                error.contains(expected) && error.contains(REMEDY),
                "{error}"
            );
        }
        for (given, expected) in [
            (
                "length = 0, mass = 1, energy = 1",
                "the unit of length must be from 1e-60",
            ),
            (
                "length = 1, mass = -1, energy = 1",
                "the unit of mass must be from 1e-60",
            ),
            (
                "length = 1, mass = 1, energy = 1e300",
                "the unit of energy must be from 1e-60",
            ),
        ] {
            let text = format!("[run]\nunits = {{ {given} }}\n");
            let error = format!("{:#}", units_of(&text).expect_err(given));
            assert!(error.contains(expected), "{error}");
        }
    }
}
