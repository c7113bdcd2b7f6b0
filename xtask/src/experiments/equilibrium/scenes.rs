//! The scenes of the experiment: files that `carom run` would accept.

use anyhow::Result;
use carom::Scene;

/// A scene and its name.
pub struct Case {
    /// Name in tables.
    pub name: String,
    /// The scene.
    pub scene: Scene,
    /// Published β p d² with its standard error, if the scene is for that.
    pub published: Option<[f64; 2]>,
}

/// Area fractions of the gases of hard discs, and the uncertainty of their predicted pressure
/// (relative): the spread of resummations of the virial series.
pub const DENSITIES: [(f64, f64); 5] = [(0.05, 1e-4), (0.2, 2e-4), (0.35, 5e-4), (0.5, 1e-3), (0.6, 2.5e-3)];

/// Published pressures of 870 discs: packing fraction, β p d² and its standard error (Li et al., J.
/// Chem. Phys. 157 (2022) 234111, event-chain Monte Carlo).
pub const PUBLISHED: [(f64, f64, f64); 3] =
    [(0.670, 7.986_735, 2.6e-5), (0.674, 8.199_758, 2.4e-5), (0.678, 8.410_175, 3.5e-5)];

/// Number of discs of the gases.
const DISCS: usize = 400;

/// All cases; `length` multiplies the duration of the measurement.
///
/// # Errors
/// A scene is not a valid file.
pub fn cases(seed: u64, length: f64) -> Result<Vec<Case>> {
    let discs = DENSITIES.iter().map(|&(fraction, _)| hard_discs(fraction, seed, length));
    let published = PUBLISHED.iter().map(|&published| published_discs(published, seed, length));
    discs.chain(published).chain([mixture(seed, length)]).collect()
}

/// Equal discs of diameter 1 and mass 1 at kT = 1.
fn hard_discs(fraction: f64, seed: u64, length: f64) -> Result<Case> {
    let side = (DISCS as f64 * std::f64::consts::FRAC_PI_4 / fraction).sqrt();
    // A disc has about this many collisions a unit of time; samples are a third of a collision
    // apart, so that correlations are resolved.
    let rate = 4.5 * fraction * (1.0 - 0.4375 * fraction) / (1.0 - fraction).powi(2);
    let run = format!(
        r#"
        until = {:?}
        sample_interval = {:?}
        measure_from = {:?}
        observe = ["pressure", "collision-rate", "velocities", "pair-distribution", "free-path", "pressure-tensor"]
        "#,
        (200.0 + 2400.0 * length) / rate,
        1.0 / rate,
        200.0 / rate,
    );
    let name = format!("{DISCS} discs, area fraction {fraction}");
    Ok(Case { name, scene: gas_of_discs(DISCS, [side; 2], seed, &run)?, published: None })
}

/// 870 discs in the published box.
fn published_discs((fraction, pressure, error): (f64, f64, f64), seed: u64, length: f64) -> Result<Case> {
    let ratio = 30.0 * 3f64.sqrt() / 2.0 / 29.0;
    let width = (870.0 * std::f64::consts::FRAC_PI_4 / fraction / ratio).sqrt();
    let run = format!(
        r#"
        until = {:?}
        sample_interval = 1.0
        measure_from = 200.0
        observe = ["pressure"]
        "#,
        200.0 + 200.0 * length,
    );
    let scene = gas_of_discs(870, [width, width * ratio], seed, &run)?;
    let name = format!("870 discs, packing fraction {fraction}");
    Ok(Case { name, scene, published: Some([pressure, error]) })
}

/// A scene of equal discs of diameter 1 and mass 1 at kT = 1, with these entries of `[run]`.
fn gas_of_discs(count: usize, sides: [f64; 2], seed: u64, run: &str) -> Result<Scene> {
    Ok(Scene::from_toml(&format!(
        r#"
        [box]
        sides = {sides:?}
        seed = {seed}
        [[gas]]
        radius = 0.5
        mass = 1.0
        temperature = 1.0
        velocities = "maxwell"
        count = {count}
        [run]
        animation = false
        {run}
        "#
    ))?)
}

/// Discs, dumbbells and tees of different masses, each by its own tag.
fn mixture(seed: u64, length: f64) -> Result<Case> {
    let gas = |tag: &str, shape: &str, mass: f64| {
        format!(
            "[[gas]]\ntags = [\"{tag}\"]\nshape = \"{shape}\"\natom_radius = 0.5\natom_mass = {mass:?}\n\
             temperature = 1.0\ncount = 60\n"
        )
    };
    let gases = [gas("discs", "disc", 1.0), gas("dumbbells", "dumbbell", 3.0), gas("tees", "tee", 0.4)];
    let measured: Vec<String> =
        ["discs", "dumbbells", "tees"].map(|tag| format!("\"temperature:{tag}\"")).to_vec();
    let text = format!(
        "[box]\nsides = [38.0, 38.0]\nseed = {seed}\n{}[run]\nuntil = {until:?}\nsample_interval = 1.0\n\
         measure_from = 50.0\nobserve = [{}]\nanimation = false\n",
        gases.concat(),
        measured.join(", "),
        until = 50.0 + 1500.0 * length,
    );
    Ok(Case {
        name: "discs, dumbbells and tees".to_owned(),
        scene: Scene::from_toml(&text)?,
        published: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_methods::AnySimulation;

    #[test]
    fn all_scenes_can_be_built_at_their_temperature() {
        for case in cases(1, 1.0).unwrap() {
            let simulation = AnySimulation::new(&case.scene).unwrap();
            let kt = simulation.view().temperature().unwrap();
            assert!((kt - 1.0).abs() < 1e-10, "{}: {kt}", case.name);
        }
    }
}
