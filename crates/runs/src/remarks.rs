//! What of a scene is most likely not meant, although it runs.

use carom::{
    Scene,
    engine::{GasSpec, MoleculeSpec, PistonSpec},
};

/// A sentence for each.
pub fn remarks(scene: &Scene) -> Vec<String> {
    let mut remarks = Vec::new();
    if !moves(scene) {
        remarks.push(
            "Nothing moves: no molecule has a velocity, an energy or a temperature above 0, and \
             nothing pushes it."
                .to_owned(),
        );
    }
    let run = &scene.run;
    if run.sample_interval > run.until {
        remarks.push(format!(
            "Only the start is sampled: run.sample_interval = {} is longer than the run, which ends at {}.",
            run.sample_interval, run.until
        ));
    }
    let sides = scene.bounds.sides;
    let mut outside = |entry: &str, index: usize, at: [f64; 2]| {
        if (0..2).any(|axis| !(0.0..=sides[axis]).contains(&at[axis])) {
            remarks.push(format!(
                "{entry}[{index}] is at [{}, {}], outside the box of sides [{}, {}]: its periodic image inside is \
                 taken.",
                at[0], at[1], sides[0], sides[1]
            ));
        }
    };
    for (index, molecule) in scene.molecule.iter().enumerate() {
        outside("molecule", index, molecule.at);
    }
    for (index, bumper) in scene.bumper.iter().enumerate() {
        outside("bumper", index, bumper.at);
    }
    for (index, wall) in scene.wall.iter().enumerate() {
        // A segment may lie outside.
        if wall.x.is_some() || wall.y.is_some() {
            outside(
                "wall",
                index,
                [wall.x.unwrap_or(0.0), wall.y.unwrap_or(0.0)],
            );
        }
    }
    remarks
}

/// Whether something may move during the run.
fn moves(scene: &Scene) -> bool {
    let of_gas = |gas: &GasSpec| {
        let has_energy =
            gas.energy > 0.0 || gas.temperature.is_some_and(|temperature| temperature > 0.0);
        has_energy && gas.count != Some(0) && gas.area_fraction != Some(0.0)
    };
    let of_molecule =
        |molecule: &MoleculeSpec| molecule.velocity != [0.0; 2] || molecule.angular_velocity != 0.0;
    let is_pushed =
        |piston: &PistonSpec| piston.velocity != 0.0 || piston.force != 0.0 || piston.spring > 0.0;
    scene.gas.iter().any(of_gas)
        || scene.molecule.iter().any(of_molecule)
        || scene.start.from.is_some()
        || !scene.gravity.is_none()
        || scene.wall.iter().any(|wall| wall.motion.is_some())
        || scene.piston.iter().any(is_pushed)
        || scene.stage.iter().any(|stage| {
            stage.gravity.is_some_and(|gravity| gravity != [0.0; 2])
                || !stage.move_wall.is_empty()
                || !stage.push_piston.is_empty()
                || stage.add.iter().any(of_molecule)
                || !stage.set_energy.is_empty()
                || !stage.set_velocity.is_empty()
                || !stage.thermostat.is_empty()
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_most_likely_not_meant_is_said() {
        let of = |text: &str| remarks(&Scene::from_toml(text).unwrap()).join(" ");
        let gas = "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 5\n";
        assert_eq!(of(gas), "");
        assert!(of("").starts_with("Nothing moves"));
        assert!(of(&gas.replace("energy = 1.0", "temperature = 0.0")).starts_with("Nothing moves"));
        assert!(of(&gas.replace("count = 5", "area_fraction = 0.0")).starts_with("Nothing moves"));
        let at_rest =
            "[[molecule]]\nshape = \"disc\"\natom_radius = 0.1\natom_mass = 1.0\nat = [0.5, 0.5]\n";
        assert!(of(at_rest).starts_with("Nothing moves"));
        for pushed in [
            "[gravity]\nacceleration = [0.0, -1.0]\n",
            "[[piston]]\nx = 0.1\nmass = 1.0\nvelocity = 1.0\n",
            "[[wall]]\nx = 0.1\nmotion = { velocity = [1.0, 0.0] }\n",
            "[[stage]]\nuntil = 1.0\ngravity = [0.0, -1.0]\n",
        ] {
            assert_eq!(of(&format!("{at_rest}{pushed}")), "");
        }
        assert!(
            of(&format!("{gas}[run]\nuntil = 1.0\nsample_interval = 2.0"))
                .starts_with("Only the start")
        );
        let found = of(&format!(
            "{gas}[[wall]]\nx = 1.7\n[[bumper]]\nradius = 0.1\nat = [5.5, 0.5]\n"
        ));
        assert!(
            found.starts_with("bumper[0] is at [5.5, 0.5], outside the box of sides [1, 1]"),
            "{found}"
        );
        assert!(found.contains("wall[0] is at [1.7, 0]"), "{found}");
    }
}
