//! The side of a square box in which a given number of molecules covers a given share.

use carom_geometry::PeriodicBox;
use glam::DVec2;

use crate::{
    scene::{Scene, error::SceneError, gas_spec::MAX_MOLECULES},
    start::species::Species,
};

/// Boxes of two gases agree if their sides differ by at most this share: rounding.
const SAME: f64 = 1e-9;

/// Sets the sides of the box of a scene in whose file a gas gives `count` and `area_fraction`.
///
/// # Errors
/// The file gives the sides, two gases ask for different boxes, or a gas is invalid.
pub(crate) fn fit_box(scene: &mut Scene, table: &toml::Table) -> Result<(), SceneError> {
    let mut side: Option<f64> = None;
    for index in 0..scene.gas.len() {
        let gas = &scene.gas[index];
        let (Some(count), Some(fraction)) = (gas.count, gas.area_fraction) else {
            continue;
        };
        let problem = |problem: String| SceneError::of_entry(&format!("gas[{index}]"), problem);
        let has_sides = table
            .get("box")
            .is_some_and(|sides| sides.get("sides").is_some());
        if has_sides {
            return Err(problem(
                "`count` and `area_fraction` together set the sides of the box: leave `box.sides` out, or one of the \
                 two"
                .to_owned(),
            ));
        }
        if !(fraction > 0.0 && fraction < 1.0 && (1..=MAX_MOLECULES).contains(&count)) {
            return Err(problem(format!(
                "a box for `count` and `area_fraction` needs from 1 to {MAX_MOLECULES} molecules and a share above 0 \
                 and below 1, but they are {count} and {fraction}"
            )));
        }
        if let Some(need) = need_of_sides(scene, index) {
            return Err(problem(need.to_owned()));
        }
        scene.gas[index].area_fraction = None;
        let unit = PeriodicBox::new(DVec2::ONE).map_err(|error| problem(error.to_string()))?;
        let areas = scene.gas[index].sum_of_areas(fraction);
        let found = (Species::new(scene, index, &unit)?.area() / areas).sqrt();
        if let Some(other) = side
            && (other - found).abs() > SAME * found
        {
            return Err(problem(format!(
                "`count` and `area_fraction` ask for a box of side {found}, but those of another gas for {other}: \
                 give `area_fraction` once"
            )));
        }
        side = Some(found);
    }
    if let Some(side) = side {
        scene.bounds.sides = [side, side];
    }
    Ok(())
}

/// What in a scene needs a box of given sides, if anything.
fn need_of_sides(scene: &Scene, gas: usize) -> Option<&'static str> {
    let gas = &scene.gas[gas];
    if gas.has_drawn_sizes() {
        Some(
            "`count` and `area_fraction` set the sides of the box for equal molecules alone: with drawn sizes give \
             `box.sides`",
        )
    } else if gas.region.is_some() {
        Some("`region` needs a box of given sides: give `box.sides`")
    } else if !scene.container.is_empty() {
        Some("a `[[container]]` needs a box of given sides: give `box.sides`")
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DISCS: &str = "radius = 0.5\nmass = 1.0\nenergy = 1.0\n";

    #[test]
    fn the_box_follows_from_number_and_share() {
        let text = format!("[[gas]]\n{DISCS}count = 100\narea_fraction = 0.5\n");
        let scene = Scene::from_toml(&text).unwrap();
        let side = (100.0 * 0.25 * std::f64::consts::PI / 0.5).sqrt();
        assert!(
            (scene.bounds.sides[0] - side).abs() < 1e-12
                && scene.bounds.sides[0] == scene.bounds.sides[1]
        );
        assert_eq!(
            (scene.gas[0].count, scene.gas[0].area_fraction),
            (Some(100), None)
        );
        assert_eq!(Scene::from_toml(&scene.to_toml()).unwrap(), scene);
    }

    #[test]
    fn contradictions_are_refused() {
        let both = "count = 10\narea_fraction = 0.5\n";
        for (text, expected) in [
            (format!("[box]\nsides = [1, 1]\n[[gas]]\n{DISCS}{both}"), "leave `box.sides` out"),
            (format!("[[gas]]\n{DISCS}count = 10\narea_fraction = 1.5\n"), "below 1"),
            (
                "[[gas]]\nradius = { uniform = [0.5, 1.0] }\nmass = 1.0\nenergy = 1.0\ncount = 5\narea_fraction = 0.4\n"
                    .to_owned(),
                "equal molecules alone",
            ),
            (format!("[[gas]]\n{DISCS}count = 0\narea_fraction = 0.5\n"), "from 1 to"),
            (format!("[[gas]]\n{DISCS}{both}region = {{ x = [0.0, 0.5] }}\n"), "give `box.sides`"),
            (format!("[[gas]]\n{DISCS}{both}[[gas]]\n{DISCS}count = 10\narea_fraction = 0.2\n"), "once"),
        ] {
            let error = Scene::from_toml(&text).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
