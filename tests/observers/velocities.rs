//! The velocity distribution: relaxation from equal speeds, and Maxwell's distribution at
//! equilibrium.

use std::f64::consts::{LN_2, PI};

use carom::{
    Observer, Scene, Simulation,
    engine::BumperSpec,
    observers::{AdaptiveHistogram, Group, VelocityDistribution, VelocityPoint},
};
use glam::DVec2;

use super::{disc, hard_discs, observe};

/// The value of `of` at `tau`, interpolated between the two nearest points.
fn interpolated(
    points: &[(f64, VelocityPoint)],
    tau: f64,
    of: impl Fn(&VelocityPoint) -> f64,
) -> f64 {
    let after = points.iter().position(|(at, _)| *at >= tau).unwrap();
    let [(t0, before), (t1, after)] = [&points[after - 1], &points[after]];
    of(before) + (of(after) - of(before)) * (tau - t0) / (t1 - t0)
}

#[test]
fn equal_speeds_relax_according_to_the_boltzmann_equation() {
    // ⟨v⁴⟩/⟨v²⟩² and H_x − H_eq (bins of 0.05 √(kT/m)) after τ collisions per disc: direct
    // simulation Monte Carlo of the Boltzmann equation with 10⁶ discs, ± 0.002. Here with 60 000
    // discs: the standard error of the kurtosis is below √(4/60 000) = 0.008, that of an
    // equilibrium sample; that of H from two components is about 0.003.
    let count = 60_000;
    let scene = hard_discs(count, 0.02, 7);
    let mut simulation = Simulation::new(&scene).unwrap();
    let mut velocities = VelocityDistribution::new(Group::All, 6.0, 120).unwrap();
    let mut taus = Vec::new();
    // Γ = 2 n σ χ √π with n = 0.08/π: 0.05 collisions per disc between samples.
    let step = 0.05 / (0.16 / PI.sqrt());
    for sample in 0..=45 {
        simulation
            .observe_until(step * f64::from(sample), &mut velocities)
            .unwrap();
        velocities.sample(&simulation.view());
        taus.push(2.0 * simulation.view().counters().collisions as f64 / count as f64);
    }
    let first = velocities.series()[0];
    assert_eq!((first.time, first.bodies), (0.0, count));
    assert!(
        (first.mean_square - 2.0).abs() < 1e-12 && (first.kurtosis.unwrap() - 1.0).abs() < 1e-12,
        "{first:?}"
    );
    let points: Vec<_> = taus
        .into_iter()
        .zip(velocities.series().iter().copied())
        .collect();
    let excess =
        |point: &VelocityPoint| 0.5 * point.h.unwrap().element_sum() - point.h_at_equilibrium();
    for (tau, kurtosis, h) in [
        (0.5, 1.1368, 0.226),
        (1.0, 1.2614, 0.122),
        (2.0, 1.4714, 0.040),
    ] {
        let found = interpolated(&points, tau, |point| point.kurtosis.unwrap());
        assert!(
            (found / kurtosis - 1.0).abs() < 0.02,
            "at {tau}: {found}, expected {kurtosis}"
        );
        let found = interpolated(&points, tau, excess);
        assert!(
            (found - h).abs() < 0.008,
            "H − H_eq at {tau}: {found}, expected {h}"
        );
    }
    // H decreases at all times.
    assert!(
        points
            .windows(2)
            .all(|pair| excess(&pair[1].1) < excess(&pair[0].1) + 0.003)
    );
}

/// χ² of a histogram against the probability of lying below each edge, and its degrees of freedom.
/// Bins with an expectation below 20, and values out of range, are combined.
fn chi_squared(distribution: &AdaptiveHistogram, below: impl Fn(f64) -> f64) -> (f64, f64) {
    let total = distribution.total() as f64;
    let bins = distribution.bins();
    let (mut rest_found, mut rest_expected) = (total, total);
    let (mut sum, mut compared) = (0.0, 0.0);
    for (edges, count) in bins.edges().windows(2).zip(distribution.counts()) {
        let expected = total * (below(edges[1]) - below(edges[0]));
        if expected >= 20.0 {
            sum += (count as f64 - expected).powi(2) / expected;
            (rest_found, rest_expected) = (rest_found - count as f64, rest_expected - expected);
            compared += 1.0;
        }
    }
    // With an expectation below 1, the rest is not significant.
    if rest_expected >= 1.0 {
        sum += (rest_found - rest_expected).powi(2) / rest_expected;
    }
    (sum, compared)
}

/// Standard normal distribution function, by Simpson's rule.
fn normal(x: f64) -> f64 {
    let (steps, h) = (400, x / 400.0);
    let density = |x: f64| (-0.5 * x * x).exp() / (2.0 * PI).sqrt();
    let weight = |k: i32| if k % 2 == 1 { 4.0 } else { 2.0 };
    let inner: f64 = (1..steps)
        .map(|k| weight(k) * density(f64::from(k) * h))
        .sum();
    0.5 + h / 3.0 * (density(0.0) + inner + density(x))
}

#[test]
fn velocities_at_equilibrium_are_gaussian_and_speeds_rayleigh() {
    let count = 1000;
    let mut simulation = Simulation::new(&hard_discs(count, 0.1, 20_170_131)).unwrap();
    simulation.run_until(60.0).unwrap();
    let mut velocities = VelocityDistribution::adaptive(Group::All, 40);
    // Γ = 0.533 (Enskog): samples four collisions per disc apart.
    observe(&mut simulation, &mut velocities, 60.0 + 150.0 * 7.5, 150);
    let temperature = simulation.view().energy() / count as f64;
    let [x, y] = velocities.components();
    let speeds = velocities.speeds();
    assert_eq!(
        (x.total(), x.counts().len(), speeds.counts().len()),
        (150_000, 80, 40)
    );
    let gaussian = |v: f64| normal(v / temperature.sqrt());
    let rayleigh = |v: f64| 1.0 - (-0.5 * v * v / temperature).exp();
    for (name, (chi, freedom)) in [
        ("x", chi_squared(x, gaussian)),
        ("y", chi_squared(y, gaussian)),
        ("speed", chi_squared(speeds, rayleigh)),
    ] {
        // Four standard deviations √(2 ν) of χ²; too small a χ² would be wrong as well.
        assert!(
            freedom > 20.0 && (chi - freedom).abs() < 4.0 * (2.0 * freedom).sqrt(),
            "{name}: {chi} {freedom}"
        );
    }
    // A colder Maxwell distribution is excluded.
    assert!(chi_squared(speeds, |v| 1.0 - (-0.53 * v * v / temperature).exp()).0 > 200.0);
    // The median of a Rayleigh distribution is √(2 ln 2 kT/m).
    let median = (2.0 * LN_2 * temperature).sqrt();
    let bins = speeds.bins();
    let until = bins.edges().partition_point(|&edge| edge <= median) - 1;
    let share = speeds.counts()[..until].iter().sum::<u64>() as f64 / 150_000.0;
    assert!(
        (rayleigh(bins.edges()[until]) - share).abs() < 0.006,
        "{share}"
    );
    // 2N′/(N′ + 1) with N′ = N − 1 at total momentum 0; and H of a Gaussian, with a bias of its
    // bins of 80 / 2N.
    let (kurtosis, error) = velocities.kurtosis().unwrap();
    assert!(
        error < 0.01 && (kurtosis - 1.998).abs() < 4.0 * error,
        "{kurtosis} ± {error}"
    );
    // ⟨ln f⟩ of N = 1000 Gaussian numbers scatters by √(1/2N) = 0.022.
    let last = velocities.series().last().unwrap();
    let excess = last.h.unwrap() - last.h_at_equilibrium();
    assert!(
        (excess - 0.04).abs().max_element() < 4.0 * 0.0224,
        "{last:?}"
    );
}

#[test]
fn only_moving_bodies_with_the_tag_are_counted() {
    let molecule = vec![
        disc(DVec2::new(0.2, 0.2), DVec2::new(3.0, -4.0), 0.01, 1.0),
        disc(DVec2::new(0.8, 0.8), DVec2::ZERO, 0.01, 1.0),
    ];
    let mut scene = Scene {
        molecule,
        ..Scene::default()
    };
    scene.molecule[1].tags = vec!["resting".into()];
    scene.bumper.push(BumperSpec {
        tags: vec!["resting".into()],
        radius: 0.01,
        at: [0.5, 0.5],
    });
    let simulation = Simulation::new(&scene).unwrap();
    let resting = Group::Tagged(simulation.find_tag("resting").unwrap());
    let mut observers = (
        VelocityDistribution::new(Group::All, 6.0, 96).unwrap(),
        VelocityDistribution::new(Group::All, 4.0, 4).unwrap(),
        VelocityDistribution::adaptive(resting, 10),
    );
    observers.sample(&simulation.view());
    let (all, narrow, resting) = observers;
    // Speeds 0 and 5: ⟨v²⟩ = 12.5, ⟨v⁴⟩ = 312.5.
    let [point] = all.series() else {
        panic!("there was one sample")
    };
    assert_eq!(
        (point.bodies, point.mean_square, point.kurtosis),
        (2, 12.5, Some(2.0))
    );
    let [x, y] = all.components();
    let occupied = |distribution: &AdaptiveHistogram| -> Vec<usize> {
        let counts = distribution.counts();
        (0..counts.len()).filter(|&bin| counts[bin] == 1).collect()
    };
    assert_eq!(
        [occupied(x), occupied(y), occupied(all.speeds())],
        [vec![96, 144], vec![32, 96], vec![0, 80]]
    );
    // Two bins of p = ½ and w = 1/16: H = ln 8.
    assert!(
        (point.h.unwrap() - 8f64.ln()).abs().max_element() < 1e-13,
        "{point:?}"
    );
    // −4 is just inside, 5 outside; H is computed from the values inside.
    let [x, y] = narrow.components();
    assert_eq!(
        (x.beyond(), y.beyond(), narrow.speeds().beyond()),
        (0, 0, 1)
    );
    // The only body with that tag that can move rests: its speed counts, but has no kurtosis.
    let [point] = resting.series() else {
        panic!("there was one sample")
    };
    assert_eq!(
        (point.mean_square, point.kurtosis, point.h),
        (0.0, None, None)
    );
    assert_eq!((resting.speeds().total(), resting.kurtosis()), (1, None));
    assert!(VelocityDistribution::new(Group::All, f64::NAN, 10).is_err());
}
