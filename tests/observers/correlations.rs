//! Mean squared displacement and velocity autocorrelation: known flights, sums by hand, and kinetic
//! theory.

use carom::{
    CollisionRate, Observer, Scene, Simulation,
    engine::BumperSpec,
    observers::{CorrelationPoint, Group, TimeCorrelation},
};
use glam::DVec2;

use super::{disc, gas, hard_discs, key, observe};

#[test]
fn free_flight_is_ballistic_with_constant_autocorrelation() {
    // Discs on separate lanes never meet; one crosses the box backwards eleven times. No body is
    // fixed, so that positions and velocities are relative to the centre of mass.
    let (slow, fast) = (DVec2::new(0.25, 0.0), DVec2::new(-1.1, 0.0));
    let molecule = vec![
        disc(DVec2::new(0.2, 0.2), slow, 0.01, 1.0),
        disc(DVec2::new(0.8, 0.7), fast, 0.01, 3.0),
    ];
    let mut scene = Scene {
        molecule,
        ..Scene::default()
    };
    scene.molecule[1].tags = vec!["fast".into()];
    let mut simulation = Simulation::new(&scene).unwrap();
    let tagged = Group::Tagged(simulation.find_tag("fast").unwrap());
    let mut observers = (
        TimeCorrelation::new(Group::All, 0.1, 10.0).unwrap(),
        TimeCorrelation::new(tagged, 0.1, 10.0).unwrap(),
    );
    observers.sample(&simulation.view());
    observe(&mut simulation, &mut observers, 10.0, 100);
    let drift = (slow + 3.0 * fast) / 4.0;
    let squares = [
        (slow - drift).length_squared(),
        (fast - drift).length_squared(),
    ];
    for (correlation, square) in [
        (&observers.0, 0.5 * (squares[0] + squares[1])),
        (&observers.1, squares[1]),
    ] {
        let points = correlation.points();
        let lags: Vec<f64> = points
            .iter()
            .map(|point| (10.0 * point.lag).round())
            .collect();
        let decades = (0..10)
            .chain((10..100).step_by(10))
            .chain([100])
            .map(f64::from);
        assert_eq!(lags, decades.collect::<Vec<_>>());
        assert_eq!(correlation.uneven(), 0);
        for point in points {
            let expected = square * point.lag * point.lag;
            assert!(
                (point.mean_square_displacement - expected).abs() <= 1e-12 * expected,
                "{point:?}"
            );
            assert!(
                (point.autocorrelation / square - 1.0).abs() < 1e-14,
                "{point:?}"
            );
        }
    }
    // 101 samples of two bodies: 101 − k origins at lag k < 10, then the origins that are multiples
    // of the lag's decade.
    let pairs: Vec<u64> = observers
        .0
        .points()
        .iter()
        .map(|point| point.pairs)
        .collect();
    assert_eq!((pairs[0], pairs[1], pairs[9]), (202, 200, 184));
    assert_eq!((pairs[10], pairs[18], pairs[19]), (20, 4, 2));
}

#[test]
fn averages_agree_with_sums_by_hand_while_bodies_are_added_and_removed() {
    let mut scene = Scene::default();
    scene.gas.extend([gas("hot", 20), gas("cold", 20)]);
    let mut simulation = Simulation::new(&scene).unwrap();
    let hot = simulation.find_tag("hot").unwrap();
    let mut correlation = TimeCorrelation::new(hot.into(), 0.125, 25.0).unwrap();
    let mut seen: Vec<Vec<(u64, DVec2, DVec2)>> = Vec::new();
    // All masses are 1, so that the centre of mass moves with the mean velocity.
    let drift =
        |simulation: &Simulation| simulation.view().momentum() / simulation.view().len() as f64;
    let mut gone = DVec2::ZERO;
    for sample in 0..250 {
        simulation.run_until(0.125 * f64::from(sample)).unwrap();
        gone += if sample > 0 {
            0.125 * drift(&simulation)
        } else {
            DVec2::ZERO
        };
        // One body is removed, one is added (by a late tag), and one is cold for a while.
        match sample {
            60 => simulation.remove(key(&simulation, 3)).unwrap(),
            80 => _ = simulation.tag(key(&simulation, 30), "hot").unwrap(),
            90 => simulation.untag(key(&simulation, 5), "hot").unwrap(),
            133 => _ = simulation.tag(key(&simulation, 5), "hot").unwrap(),
            _ => {}
        }
        let view = simulation.view();
        correlation.sample(&view);
        let sample = view.tagged(hot);
        let bounds = view.bounds();
        seen.push(
            sample
                .map(|body| {
                    let velocity = body.motion.velocity - drift(&simulation);
                    (body.body.id(), body.unwrapped(&bounds) - gone, velocity)
                })
                .collect(),
        );
    }
    // Without the removed body, the others drift.
    assert!(
        drift(&simulation).length() > 0.01 && gone.length() > 0.1,
        "{gone}"
    );
    let points = correlation.points();
    assert_eq!(points.len(), 1 + 9 + 9 + 2);
    for point in points {
        let lag = (point.lag / 0.125).round() as usize;
        let stride = 10usize.pow(lag.max(1).ilog10());
        let (mut pairs, mut squares, mut products) = (0, 0.0, 0.0);
        for origin in (0..seen.len() - lag).step_by(stride) {
            for (id, place, velocity) in &seen[origin] {
                if let Some((_, later, then)) =
                    seen[origin + lag].iter().find(|(other, ..)| other == id)
                {
                    pairs += 1;
                    squares += (*later - *place).length_squared();
                    products += velocity.dot(*then);
                }
            }
        }
        assert_eq!(point.pairs, pairs, "{point:?}");
        let close = |found: f64, expected: f64| {
            (found - expected).abs() < 1e-12 * squares.max(pairs as f64)
        };
        assert!(
            close(point.mean_square_displacement * pairs as f64, squares),
            "{point:?} by hand {squares}"
        );
        assert!(
            close(point.autocorrelation * pairs as f64, products),
            "{point:?} by hand {products}"
        );
    }
}

#[test]
fn uneven_samples_are_counted_and_no_lag_reaches_across_a_gap() {
    let flight = disc(DVec2::new(0.2, 0.2), DVec2::X, 0.01, 1.0);
    let bumper = BumperSpec {
        tags: vec![],
        radius: 0.1,
        at: [0.5, 0.7],
    };
    let scene = Scene {
        molecule: vec![flight],
        bumper: vec![bumper],
        ..Scene::default()
    };
    let mut simulation = Simulation::new(&scene).unwrap();
    let mut correlation = TimeCorrelation::new(Group::All, 1.0, 3.0).unwrap();
    // 0, 1, 2 are equally spaced, 2.5 and the second 3 are too early, 5.5 is late: 6.5 follows it.
    for time in [0.0, 1.0, 2.0, 2.5, 3.0, 3.0, 5.5, 6.5] {
        simulation.run_until(time).unwrap();
        correlation.sample(&simulation.view());
    }
    assert_eq!(correlation.uneven(), 3);
    let pairs: Vec<u64> = correlation
        .points()
        .iter()
        .map(|point| point.pairs)
        .collect();
    assert_eq!(pairs, [6, 3 + 1, 2, 1]);
    for point in correlation.points() {
        assert!(
            (point.mean_square_displacement - point.lag * point.lag).abs() < 1e-12,
            "{point:?}"
        );
    }
    for (spacing, longest) in [
        (0.0, 1.0),
        (1.0, f64::INFINITY),
        (f64::NAN, 1.0),
        (-1.0, 1.0),
    ] {
        assert!(TimeCorrelation::new(Group::All, spacing, longest).is_err());
    }
    // A longest lag beyond any run, or below one spacing, is valid.
    assert!(
        TimeCorrelation::new(Group::All, 1e-60, 1e60)
            .unwrap()
            .points()
            .is_empty()
    );
    let mut short = TimeCorrelation::new(Group::All, 1.0, 1e-3).unwrap();
    observe(&mut simulation, &mut short, 9.5, 3);
    assert_eq!(short.points().last().unwrap().lag, 1.0);
}

/// Returns −d ln C/dτ at τ = 0 and C/C(0) at τ = 1 and 2, where τ = Γt with the measured Γ, and the
/// mean of D(t) / D_E from τ = 0.5 to 1.5.
fn decay(count: usize, seed: u64) -> [f64; 4] {
    // Γ = 2 n σ χ √(π kT/m) with χ = 1.181 at area fraction 0.1.
    let spacing = 0.05 / 0.533;
    let mut simulation = Simulation::new(&hard_discs(count, 0.1, seed)).unwrap();
    simulation.run_until(400.0 * spacing).unwrap();
    let mut observers = (
        TimeCorrelation::new(Group::All, spacing, 50.0 * spacing).unwrap(),
        CollisionRate::default(),
    );
    let samples = 4000;
    observe(
        &mut simulation,
        &mut observers,
        f64::from(400 + samples) * spacing,
        samples as u32,
    );
    let points = observers.0.points();
    assert_eq!(observers.0.uneven(), 0);
    let rate = observers.1.mean().unwrap().0;
    let square = points[0].autocorrelation;
    let slope =
        |point: &CorrelationPoint| -(point.autocorrelation / square).ln() / (rate * point.lag);
    // ln C over τ, extrapolated linearly to τ = 0.
    let initial = 2.0 * slope(&points[1]) - slope(&points[2]);
    let at = |tau: f64| {
        let after = points
            .iter()
            .position(|point| rate * point.lag >= tau)
            .unwrap();
        let [before, after] = [points[after - 1], points[after]];
        let share = (tau / rate - before.lag) / (after.lag - before.lag);
        // Exponential interpolation.
        let logarithm = |point: CorrelationPoint| (point.autocorrelation / square).ln();
        (logarithm(before) + share * (logarithm(after) - logarithm(before))).exp()
    };
    // ⟨|Δx|²⟩ = 2 ∫ (t − s) C(s) ds: over one spacing, with a linearly decreasing C.
    let forgotten = 1.0 - points[1].autocorrelation / square;
    let expected = square * spacing * spacing * (1.0 - forgotten / 3.0);
    assert!(
        (points[1].mean_square_displacement / expected - 1.0).abs() < 1e-3,
        "{points:?}"
    );
    let [first, second] = [points[10], points[12]];
    let growth = second.mean_square_displacement - first.mean_square_displacement;
    let diffusion = 0.25 * growth / (second.lag - first.lag);
    [initial, at(1.0), at(2.0), diffusion * rate / (0.5 * square)]
}

#[test]
fn velocity_autocorrelation_of_hard_discs_decays_at_the_collision_rate() {
    let (count, replicas) = (256, 8);
    let runs: Vec<[f64; 4]> = (0..replicas)
        .map(|replica| decay(count, 100 + replica))
        .collect();
    let [slope, one, two, diffusion] = std::array::from_fn(|index| {
        let n = replicas as f64;
        let mean = runs.iter().map(|run| run[index]).sum::<f64>() / n;
        let squares: f64 = runs.iter().map(|run| (run[index] - mean).powi(2)).sum();
        (mean, (squares / (n - 1.0) / n).sqrt())
    });
    // −d ln C/dτ = 1 is exact at any density (positions and velocities are independent at
    // equilibrium, and ⟨u²⟩ of a contact is 4 kT/m), and N/(N − 1) at total momentum 0.
    let expected = count as f64 / (count as f64 - 1.0);
    assert!(
        slope.1 < 0.005 && (slope.0 - expected).abs() < 4.0 * slope.1 + 0.002,
        "{slope:?}"
    );
    // From another event-driven code: 0.376 and 0.147 ± 0.003 for 256 discs at 0.1.
    assert!(
        one.1 < 0.004 && (one.0 - 0.376).abs() < 4.0 * one.1 + 0.004,
        "{one:?}"
    );
    assert!(
        two.1 < 0.005 && (two.0 - 0.147).abs() < 4.0 * two.1 + 0.004,
        "{two:?}"
    );
    // D(t) = D_E (1 − e^{−τ}), averaged from τ = 0.5 to 1.5; the slower decay of C adds about 2 %.
    let expected = 1.0 - ((-0.5f64).exp() - (-1.5f64).exp());
    assert!(
        diffusion.1 < 0.01 && (diffusion.0 / expected - 1.02).abs() < 0.04,
        "{diffusion:?}, {expected}"
    );
}
