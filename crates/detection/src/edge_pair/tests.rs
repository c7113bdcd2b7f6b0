//! The bounds of Lemmas 3 and 5 against positions alone.

use super::*;
use crate::{
    edge_error::tests::{Case, Sizes, case_of, off},
    error_bound::tests::{Random, big},
};

/// The largest derivatives of the coordinates, as shares of their bounds, at `count` times in the
/// window of a case; from finite differences of positions.
fn largest_derivatives(case: &Case, count: u32) -> Option<[f64; 2]> {
    case.pair(|pair| {
        let window = pair.window(case.time + 20.0)?;
        let reach = pair.edge.reach() + pair.contact_distance + pair.orbit;
        let spins = pair.spins.map(f64::abs);
        // The error of the third difference is of the order of (spin step)².
        let step = 1e-3 / spins[0].max(spins[1]).max(pair.flight.speed / reach);
        let mut worst = [0.0f64; 2];
        for index in 0..=count {
            let share = f64::from(index) / f64::from(count);
            let time = window.begin + share * (window.end - window.begin);
            let start = pair.pose(time);
            for along in [false, true] {
                let at = |number: f64| {
                    let pose = pair.pose(time + number * step);
                    let direction = if along { pose.along } else { pose.along.perp() };
                    direction.dot(pose.place)
                };
                let second = (at(1.0) - 2.0 * at(0.0) + at(-1.0)) / step.powi(2);
                let third =
                    0.5 * (at(2.0) - 2.0 * at(1.0) + 2.0 * at(-1.0) - at(-2.0)) / step.powi(3);
                worst[0] = worst[0].max(second.abs() / pair.largest);
                worst[1] = worst[1].max(third.abs() / pair.jerk);
            }
            assert!(start.place.length() <= (reach + pair.orbit) * (1.0 + 1e-12));
        }
        Some(worst)
    })
}

fn sizes(arm: f64, edge: f64, velocity: f64, spins: [f64; 2]) -> Sizes {
    Sizes {
        arm,
        edge,
        velocity,
        spins,
        time: 2.0,
    }
}

#[test]
fn derivatives_stay_within_their_bounds_as_long_as_the_atom_is_within_reach() {
    let mut random = Random(44);
    for sizes in [
        sizes(1.0, 1.0, 1.0, [1.0, 1.0]),
        sizes(1.0, 1.0, 0.1, [1.0, 1.0]),
        sizes(0.1, 1.0, 1.0, [1.0, 3.0]),
        sizes(1.0, 0.1, 1.0, [3.0, 1.0]),
        sizes(1.0, 1.0, 3.0, [0.0, 1.0]),
        sizes(1.0, 1.0, 1.0, [3.0, 0.1]),
    ] {
        let mut worst = [0.0f64; 2];
        for _ in 0..400 {
            let case = case_of(&sizes.state(&mut random));
            let found = largest_derivatives(&case, 40).unwrap_or_default();
            worst = [worst[0].max(found[0]), worst[1].max(found[1])];
        }
        eprintln!("{sizes:?}: y''/K {:.3}, y'''/K₃ {:.3}", worst[0], worst[1]);
        assert!(worst.iter().all(|&share| share <= 1.0 + 1e-4), "{worst:?}");
        assert!(worst.iter().all(|&share| share > 0.5), "{worst:?}");
    }
}

/// The edge turns at the rate ω and the atom flies straight away from its centre: at the border of
/// the reach, K and K₃ are attained.
#[test]
fn the_bounds_are_attained() {
    let mut random = Random(45);
    let still = sizes(1e-9, 1.0, 1e-6, [0.0, 1.0]);
    let mut worst = [0.0f64; 2];
    for _ in 0..200 {
        let case = case_of(&still.state(&mut random));
        let found = largest_derivatives(&case, 40).unwrap_or_default();
        worst = [worst[0].max(found[0]), worst[1].max(found[1])];
    }
    assert!(worst.iter().all(|&share| share > 0.95), "{worst:?}");
}

#[test]
fn the_growth_of_the_gap_has_no_cancellation() {
    let mut random = Random(46);
    let mut worst = 0.0f64;
    let mut count = 0;
    for sizes in [
        sizes(1.0, 1.0, 1.0, [1.0, 1.0]),
        sizes(1.0, 1.0, 1e-3, [3.0, 3.0]),
        sizes(1.0, 1.0, 1.0, [0.0, 1.0]),
        sizes(1.0, 1.0, 1.0, [1.0, 0.0]),
        sizes(1e-3, 1.0, 1.0, [1.0, 10.0]),
    ] {
        for exponent in [0, 3, 6, 9, 12] {
            for _ in 0..100 {
                let mut state = sizes.state(&mut random);
                // The case is within reach at this time, from which the gap grows.
                state[16] *= f64::from(exponent % 2);
                let case = case_of(&state);
                let elapsed = 10f64.powi(-exponent) * random.next().abs();
                let elapsed = (case.time + elapsed) - case.time;
                let (ratio, is_moved) = growth(&case, elapsed);
                worst = worst.max(ratio);
                count += u32::from(is_moved);
            }
        }
    }
    eprintln!("{count} growths: worst error {worst:.3} of h (E' + 8 u L)");
    assert!(
        count > 300 && worst <= 1.0 && worst > 0.01,
        "{count} {worst}"
    );
}

/// The error of the growth over `elapsed` (time) as a share of its bound, and whether the atom is
/// beside the edge.
fn growth(case: &Case, elapsed: f64) -> (f64, bool) {
    if elapsed == 0.0 {
        return (0.0, false);
    }
    case.pair(|pair| {
        let start = pair.pose(case.time);
        let Some((_, widened)) = pair.moved(&start, elapsed) else {
            return (0.0, false);
        };
        let then = case.time + elapsed;
        // Signed coordinates: the side of the atom may change if it crosses the line.
        let [[before, _], [after, _]] = [case.time, then].map(|time| case.exact(&big(time)));
        let side = |time: f64| {
            let pose = pair.pose(time);
            pose.along.perp().dot(pose.outwards.direction).signum()
        };
        if side(case.time) != side(then) {
            return (0.0, false);
        }
        let bound = case.bound();
        let allowed = elapsed * (bound.of_rate(then) + 8.0 * U * bound.speed());
        (off(widened, &(after.value - before.value)) / allowed, true)
    })
}
