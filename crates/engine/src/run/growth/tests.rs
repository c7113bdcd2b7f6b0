//! Growth of few large molecules among many small ones, and the error of gases that jam.

use super::*;

/// Grows the gases of a scene file without relaxation, in the unit box.
fn grown(gases: &str) -> Result<Simulation, SceneError> {
    let text = format!("[box]\nseed = 3\n[start]\nplacement = \"grown\"\nrelax = 0\n{gases}");
    let mut growth = Growth::new(&Scene::from_toml(&text)?)?;
    while !growth.is_done() {
        growth.step()?;
    }
    growth.finish()
}

/// The entry of a gas of so many molecules of a shape.
fn gas(shape: &str, atom_radius: f64, count: usize) -> String {
    format!(
        "[[gas]]\nshape = \"{shape}\"\natom_radius = {atom_radius}\natom_mass = 1.0\nenergy = 1.0\ncount = {count}\n"
    )
}

/// Radius of discs of this number that cover this share of the box.
fn radius(count: usize, area_fraction: f64) -> f64 {
    (area_fraction / (count as f64 * std::f64::consts::PI)).sqrt()
}

fn assert_grown(gases: &str, count: usize) {
    let simulation = grown(gases).unwrap_or_else(|error| panic!("{gases}: {error}"));
    let view = simulation.view();
    assert_eq!(
        (view.len(), view.overlaps().deepest_length),
        (count, 0.0),
        "{gases}"
    );
}

#[test]
fn few_large_discs_grow_among_many_small_ones() {
    for [large, small] in [[(0.15, 3), (0.0027, 5000)], [(0.2, 2), (0.002, 5000)]] {
        assert_grown(
            &(gas("disc", large.0, large.1) + &gas("disc", small.0, small.1)),
            large.1 + small.1,
        );
    }
}

#[test]
fn a_drawn_gas_of_very_unlike_sizes_grows() {
    let gas = "[[gas]]\nradius = { values = [0.003, 0.15], weights = [700, 1] }\nmass = 1.0\nenergy = 1.0\n\
               area_fraction = 0.5\n";
    let view = grown(gas).unwrap();
    assert_eq!(view.view().overlaps().deepest_length, 0.0);
    let area: f64 = view
        .view()
        .bodies()
        .map(|body| body.body.molecule().area())
        .sum();
    assert!((area - 0.5).abs() < 0.08, "{area}");
}

#[test]
fn few_large_molecules_grow_among_many_small_ones() {
    assert_grown(
        &(gas("dumbbell", 0.12, 3) + &gas("disc", 0.003, 1500)),
        1503,
    );
    assert_grown(&(gas("tee", 0.07, 3) + &gas("dumbbell", 0.002, 1500)), 1503);
}

#[test]
fn a_jam_is_refused_with_the_molecules_that_have_not_reached_their_size() {
    let error = grown(&gas("disc", radius(60, 0.9), 60)).unwrap_err();
    let SceneError::Jammed {
        reached,
        smaller,
        molecules,
        area_share,
        smallest_scale,
        ..
    } = error
    else {
        panic!("{error}")
    };
    assert!((0.75..0.9).contains(&reached) && molecules == 60, "{error}");
    assert!(
        smaller > 50 && area_share > 0.8 && smallest_scale < 1.0,
        "{error}"
    );
    assert!(
        error
            .to_string()
            .contains(&format!("{smaller} of 60 molecules")),
        "{error}"
    );
}
