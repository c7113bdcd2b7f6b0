//! The pressure against exact results: two discs, and the published pressure of 72.

use std::f64::consts::PI;

use carom::{
    Scene, Simulation,
    observers::{Estimate, Pressure},
};
use glam::DVec2;

use super::{disc, hard_discs, observe};

/// β p A of a run, its standard error, and β times the momentum flux times A, from intervals
/// between samples, after a time in which the start is forgotten.
fn reduced_pressure(scene: &Scene, settle: f64, until: f64, samples: u32) -> (Estimate, f64) {
    let mut simulation = Simulation::new(scene).unwrap();
    simulation.run_until(settle).unwrap();
    let mut pressure = Pressure::default();
    observe(&mut simulation, &mut pressure, until, samples);
    let view = simulation.view();
    let moving = view.bodies().filter(|view| !view.body.is_fixed()).count() as f64;
    let (factor, error) = pressure.compressibility_factor().unwrap();
    let series = pressure.series();
    let flux: f64 = series
        .iter()
        .map(|point| point.momentum_flux() / point.ideal)
        .sum();
    let estimate = Estimate {
        mean: factor * moving,
        standard_error: error * moving,
    };
    (estimate, flux / series.len() as f64 * moving)
}

/// Two discs of diameter σ have Q ∝ A (A − πσ²), so that
/// β p A = ∂ ln Q / ∂ ln A = 2 + πσ²/(A − πσ²). Their relative motion is that of a point in Sinai's
/// billiard, which is ergodic.
#[test]
fn two_discs_have_their_exact_pressure_with_and_without_drift() {
    for (sides, radius, drift) in [
        ([1.0, 1.0], 0.2, DVec2::ZERO),
        ([1.0, 1.0], 0.2, DVec2::new(3.0, 1.7)),
        ([1.2, 0.9], 0.13, DVec2::new(-0.4, 0.9)),
    ] {
        // Different masses: the pressure depends on positions alone.
        let velocity = DVec2::new(0.6, 0.8);
        let molecule = vec![
            disc(DVec2::new(0.2, 0.2), drift + velocity, radius, 1.0),
            disc(DVec2::new(0.7, 0.65), drift - velocity / 3.0, radius, 3.0),
        ];
        let mut scene = Scene {
            molecule,
            ..Scene::default()
        };
        scene.bounds.sides = sides;
        let (found, flux) = reduced_pressure(&scene, 10.0, 40_010.0, 400);
        let excluded = 4.0 * PI * radius * radius;
        let expected = 2.0 + excluded / (sides[0] * sides[1] - excluded);
        assert!(found.standard_error < 0.006, "{found:?}");
        let deviation = (found.mean - expected) / found.standard_error;
        assert!(deviation.abs() < 3.0, "{found:?}, exact {expected}");
        // Two of the four degrees of freedom remain for the momentum flux.
        assert!((found.mean - flux - 1.0).abs() < 1e-9, "{found:?}, {flux}");
    }
}

/// Single walls break the conservation of one component of momentum: a single disc has kT = 2 E / f
/// with f = 1, and only contacts with the wall contribute to its virial.
#[test]
fn a_single_disc_has_a_temperature_only_between_walls() {
    let lone = disc(DVec2::new(0.2, 0.2), DVec2::new(0.5, 7.0), 0.1, 2.0);
    let mut scene = Scene {
        molecule: vec![lone],
        ..Scene::default()
    };
    let mut pressure = Pressure::default();
    observe(&mut Simulation::new(&scene).unwrap(), &mut pressure, 1.0, 2);
    assert_eq!(pressure.compressibility_factor(), None);
    assert_eq!(pressure.mean(), Some((0.0, 0.0)));
    scene.wall.push(carom::engine::WallSpec {
        x: Some(0.5),
        ..carom::engine::WallSpec::default()
    });
    let simulation = Simulation::new(&scene).unwrap();
    // ½ 2 0.5² across, and no degree of freedom along the wall: kT = 2 × 0.25 / 1.
    assert!((simulation.view().temperature().unwrap() - 0.5).abs() < 1e-15);
}

/// β p d² of 72 discs in a square box at area fraction 0.650, by event-chain Monte Carlo:
/// 6.901074(71) (Li, Nishikawa, Höllmer, Carillo, Maggs & Krauth, J. Chem. Phys. 157 (2022) 234111,
/// data repository HistoricDisks). An ideal term of N − 1 would be lower by d²/A = 0.0115.
#[test]
fn the_pressure_of_72_discs_is_the_published_one() {
    let (count, fraction) = (72, 0.65);
    let area = f64::from(count) * 0.25 * PI / fraction;
    let scene = hard_discs(count as usize, fraction, 19);
    let (found, flux) = reduced_pressure(&scene, 100.0, 28_100.0, 100);
    let (pressure, error) = (found.mean / area, found.standard_error / area);
    let published = 6.901_074;
    let deviation = (pressure - published) / error.hypot(0.000_071);
    // The two ideal terms differ by more than five standard errors.
    assert!(error < 0.0115 / 5.0, "{error}");
    assert!(
        deviation.abs() < 3.0,
        "{pressure} ± {error}: {deviation} errors off"
    );
    assert!((flux / area - published) / error < -3.0, "{}", flux / area);
}
