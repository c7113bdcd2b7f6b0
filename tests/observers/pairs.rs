//! The pair distribution: counts by hand, and the structure of hard discs.

use carom::{
    Observer, Scene, Simulation,
    engine::BumperSpec,
    observers::{CutoffError, Group, PairDistribution},
};

use super::{gas, hard_discs, observe, tee};
use glam::DVec2;

#[test]
fn counts_are_those_of_all_pairs_for_any_number_of_cells() {
    let mut scene = Scene {
        molecule: vec![tee(DVec2::new(0.5, 0.35), 0.7)],
        ..Scene::default()
    };
    scene.bounds.sides = [1.0, 0.7];
    scene.molecule[0].tags = vec!["hot".into(), "cold".into()];
    scene.bumper.push(BumperSpec {
        tags: vec!["cold".into()],
        radius: 0.02,
        at: [0.999, 0.001],
    });
    scene.gas.extend([gas("hot", 40), gas("cold", 70)]);
    let mut simulation = Simulation::new(&scene).unwrap();
    let tag = |name: &str| simulation.find_tag(name).unwrap();
    let (hot, cold) = (tag("hot"), tag("cold"));
    simulation.run_until(1.0).unwrap();
    let view = simulation.view();
    let [width, height] = [1.0, 0.7];
    // From one cell per side for each of the few bodies up to thirty: two, three and more.
    for cutoff in [0.349, 0.3, 0.23, 0.1, 0.03] {
        for groups in [
            [Group::All, Group::All],
            [hot.into(), cold.into()],
            [cold.into(), hot.into()],
            [cold.into(), cold.into()],
            [Group::All, hot.into()],
        ] {
            let mut pairs = PairDistribution::new(groups, &view.bounds(), cutoff, 10).unwrap();
            assert!(pairs.points().is_empty());
            pairs.sample(&view);
            let (mut counts, mut all) = ([0; 10], 0.0);
            for one in view.bodies().filter(|body| groups[0].contains(body.body)) {
                for other in view.bodies().filter(|body| groups[1].contains(body.body)) {
                    if one.body.id() == other.body.id() {
                        continue;
                    }
                    all += 1.0;
                    let apart = other.motion.position - one.motion.position;
                    let nearest = |apart: f64, side: f64| apart.abs().min(side - apart.abs());
                    let distance = nearest(apart.x, width).hypot(nearest(apart.y, height));
                    if distance < cutoff {
                        counts[(10.0 * distance / cutoff) as usize] += 1;
                    }
                }
            }
            let points = pairs.points();
            assert_eq!(
                points.iter().map(|point| point.pairs).collect::<Vec<_>>(),
                counts,
                "{groups:?} to {cutoff}"
            );
            // The bins tile the disc of that radius: Σ g (r₂² − r₁²) = pairs A / (π all).
            let tiled: f64 = points
                .iter()
                .map(|point| point.g * point.distance * cutoff / 10.0)
                .sum::<f64>()
                * 2.0;
            let expected =
                counts.iter().sum::<u64>() as f64 * width * height / (std::f64::consts::PI * all);
            assert!(
                (tiled - expected).abs() < 1e-13,
                "{tiled} against {expected}"
            );
        }
    }
}

#[test]
fn the_pair_distribution_of_hard_discs_is_that_of_the_liquid() {
    // At area fraction 0.3, Z = 2.0633 (Padé approximant of the virial series of Clisby & McCoy, J.
    // Stat. Phys. 122 (2006) 15), so that χ = (Z − 1) / 2η = 1.772.
    let mut simulation = Simulation::new(&hard_discs(400, 0.3, 3)).unwrap();
    simulation.run_until(20.0).unwrap();
    let bounds = simulation.view().bounds();
    let mut pairs = PairDistribution::new([Group::All; 2], &bounds, 8.0, 400).unwrap();
    // Γ = 2.4: about one collision per disc between samples, and about 17 pairs per sample in the
    // bin at contact.
    observe(&mut simulation, &mut pairs, 20.0 + 1500.0 * 0.42, 1500);
    let points = pairs.points();
    assert!(
        points[..50]
            .iter()
            .all(|point| (point.pairs, point.g) == (0, 0.0))
    );
    // ln g as a straight line through the bins from σ to 1.1 σ, by least squares: the standard
    // error is about 0.7 %.
    let near: Vec<(f64, f64)> = points[50..55]
        .iter()
        .map(|point| (point.distance - 1.05, point.g.ln()))
        .collect();
    let mean = near.iter().map(|(_, y)| y).sum::<f64>() / 5.0;
    let slope =
        near.iter().map(|(x, y)| x * y).sum::<f64>() / near.iter().map(|(x, _)| x * x).sum::<f64>();
    let contact = (mean - 0.05 * slope).exp();
    assert!((contact / 1.772 - 1.0).abs() < 0.03, "{contact}");
    // A minimum behind the first shell (1.8 σ to 2 σ), a second shell, and no order far away.
    let mean = |from: usize, to: usize| {
        let bins = &points[from..to];
        bins.iter()
            .map(|point| point.g * point.distance)
            .sum::<f64>()
            / bins.iter().map(|point| point.distance).sum::<f64>()
    };
    assert!(
        mean(90, 100) < 0.95 && mean(115, 130) > 1.01,
        "{} {}",
        mean(90, 100),
        mean(115, 130)
    );
    assert!((mean(250, 400) - 1.0).abs() < 0.005, "{}", mean(250, 400));
}

#[test]
fn a_cutoff_must_be_less_than_half_the_box() {
    let mut scene = Scene::default();
    scene.bounds.sides = [1.0, 0.5];
    let simulation = Simulation::new(&scene).unwrap();
    let view = simulation.view();
    let new = |cutoff| PairDistribution::new([Group::All; 2], &view.bounds(), cutoff, 0);
    assert_eq!(
        new(0.25).unwrap_err(),
        CutoffError::BeyondHalf {
            cutoff: 0.25,
            half: 0.25
        }
    );
    assert!(matches!(new(f64::NAN), Err(CutoffError::Length(_))));
    assert!(matches!(new(0.0), Err(CutoffError::Length(_))));
    let mut pairs = new(0.2).unwrap();
    pairs.sample(&view);
    assert!(pairs.points().is_empty(), "there is no pair");
    let unit = Simulation::new(&Scene::default()).unwrap();
    pairs.sample(&unit.view());
    assert_eq!(pairs.passed_over(), 1);
}
