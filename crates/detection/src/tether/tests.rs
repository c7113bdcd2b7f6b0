//! Events of tethers: known times, random bodies against their length, and many events in a row.

use carom_kinematics::{Motion, Orientation, RelativeMotion};
use glam::DVec2;
use proptest::prelude::*;

use super::{LongestLength, Tether, TetherBound, TetherError};
use crate::{
    Contact, Outcome,
    error_bound::tests::{Big, PRECISION, Random, arm, big},
    first_zero::{Samples, is_first_zero},
    gap_search::GapFunction,
};

/// The distance of the points of a tether, beyond the room that it has: positive between its
/// bounds.
fn room(tether: &Tether, motion: &RelativeMotion, time: f64) -> f64 {
    let arm = |body: usize| {
        motion.orientation[body]
            .turned(motion.angular_velocity[body], time)
            .cos_sin()
            .rotate(tether.points()[body])
    };
    let place = motion.separation + motion.velocity * time;
    let distance = (place + arm(1) - arm(0)).length();
    let [shortest, longest] = tether.bounds();
    (longest - distance).min(if shortest > 0.0 {
        distance - shortest
    } else {
        f64::INFINITY
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: ProptestConfig::default().cases.max(600), max_global_rejects: 1 << 20, ..ProptestConfig::default() })]

    /// The length stays between the bounds before the event, and is at one of them there.
    #[test]
    fn a_tether_reaches_its_bound_first_where_its_length_says_so(
        points in prop::array::uniform4(prop_oneof![Just(0.0), -0.5..0.5f64]),
        bounds in (prop_oneof![Just(0.0), 0.05..0.9f64], 0.01..1.5f64),
        x in -2.0..2.0f64, y in -2.0..2.0f64,
        velocity in (-1.0..1.0f64, -1.0..1.0f64), turns in prop::array::uniform2(-0.5..0.5f64),
        spins in prop::array::uniform2(prop_oneof![Just(0.0), -1.0..1.0f64, -30.0..30.0f64, -1e3..1e3f64]),
    ) {
        let [ax, ay, bx, by] = points;
        let bounds = [bounds.0, bounds.0 + bounds.1];
        let tether = Tether::new([DVec2::new(ax, ay), DVec2::new(bx, by)], bounds).unwrap();
        let motion = RelativeMotion {
            orientation: turns.map(Orientation::from_turns),
            angular_velocity: spins,
            ..RelativeMotion::exactly(DVec2::new(x, y), DVec2::new(velocity.0, velocity.1))
        };
        let gap = |time: f64| room(&tether, &motion, time);
        prop_assume!(gap(0.0) > 1e-9);
        let fastest = spins[0].abs().max(spins[1].abs());
        let allowed = |_: f64| 1e-13 * (1.0 + fastest);
        let samples = Samples { count: 3000, depth: 1e-12 };
        let outcome = tether.first_event(&motion, 4.0);
        is_first_zero(outcome, 4.0, gap, allowed, &samples)?;
        // The same with the bodies exchanged, to the bit.
        prop_assert_eq!(outcome, tether.exchanged().first_event(&motion.exchanged(), 4.0));
    }

    /// However slowly or fast all moves, the event is the same one.
    #[test]
    fn the_unit_of_time_does_not_matter(power in -200..200i32, spin in -3.0..3.0f64, y in -0.9..0.9f64) {
        let tether = Tether::new([DVec2::new(0.1, 0.0), DVec2::ZERO], [0.0, 1.0]).unwrap();
        let factor = 2f64.powi(power);
        let of_unit = |factor: f64| RelativeMotion {
            angular_velocity: [spin * factor, 0.0],
            ..RelativeMotion::exactly(DVec2::new(0.0, y), DVec2::new(factor, 0.0))
        };
        let event = |factor: f64| match tether.first_event(&of_unit(factor), f64::MAX) {
            Outcome::Contact(contact) => (contact.time * factor, contact.touch),
            other => panic!("{other:?}"),
        };
        prop_assert_eq!(event(factor), event(1.0));
    }
}

#[test]
fn points_at_the_centres_are_decided_in_closed_form_to_rounding() {
    let tether = Tether::new([DVec2::ZERO; 2], [0.0, 5.0]).unwrap();
    // Past each other at the distance 3: a chord of half length 4.
    let motion = RelativeMotion::exactly(DVec2::new(-3.5, 3.0), DVec2::new(2.0, 0.0));
    let Contact { time, touch } = tether.first_event(&motion, 1e3).contact().unwrap();
    assert_eq!(touch, TetherBound::Longest);
    assert!((time - 3.75).abs() < 8.0 * f64::EPSILON, "{time}");
    // Bodies at rest to each other never reach a bound.
    let still = RelativeMotion::exactly(DVec2::new(5.0, 0.0), DVec2::ZERO);
    assert_eq!(tether.first_event(&still, 1e300), Outcome::Free);
}

#[test]
fn a_taut_tether_is_at_its_bound_only_while_the_points_part() {
    let tether = Tether::new([DVec2::ZERO; 2], [0.0, 1.0]).unwrap();
    for excess in [-1e-16, 0.0, 1e-16] {
        let place = DVec2::new(1.0 + excess, 0.0);
        let taut_after = |velocity| {
            let motion = RelativeMotion::exactly(place, velocity);
            let Contact { time, touch } = tether.first_event(&motion, 10.0).contact().unwrap();
            assert_eq!(touch, TetherBound::Longest);
            time
        };
        let time = taut_after(DVec2::new(0.5, 0.3));
        assert!(time < 1e-15, "{time}");
        // A chord of length √2 at the speed √2.
        let time = taut_after(DVec2::new(-1.0, 1.0));
        assert!((time - 1.0).abs() < 1e-15, "{time}");
    }
}

/// Elastic events of a rotor on a short tether to a fixed point: after any number the length is
/// within rounding of its bounds.
#[test]
fn no_number_of_events_stretches_a_tether() {
    for (arm, bounds) in [(0.0, [0.0, 1.0]), (0.4, [0.0, 0.01]), (0.4, [0.02, 0.021])] {
        let tether = Tether::new([DVec2::ZERO, DVec2::new(arm, 0.0)], bounds).unwrap();
        let mut motion = Motion {
            velocity: DVec2::new(0.7, 0.1),
            angular_velocity: 1.3,
            ..Motion::at_rest(DVec2::new(0.5 * (bounds[0] + bounds[1]) - arm, 0.0))
        };
        let moment = 0.1;
        let mut deepest = 0.0_f64;
        for _ in 0..200_000 {
            let still = Motion::at_rest(DVec2::ZERO);
            let relative = RelativeMotion::between(&still, &motion, DVec2::ZERO, motion.time);
            let event = tether.first_event(&relative, 1e3).contact();
            let event = event.expect("a body that moves reaches a bound");
            motion = Motion {
                time: 0.0,
                ..motion.at(motion.time + event.time)
            };
            let turned = motion.orientation.cos_sin().rotate(DVec2::new(arm, 0.0));
            let d = motion.position + turned;
            let excess = (d.length() - bounds[1]).max(bounds[0] - d.length());
            deepest = deepest.max(excess);
            // The elastic impulse on a body of mass 1 along d.
            let normal = d / d.length();
            let lever = turned.perp_dot(normal);
            let speed = (motion.velocity + motion.angular_velocity * turned.perp()).dot(normal);
            let impulse = -2.0 * speed / (1.0 + lever * lever / moment);
            motion.velocity += impulse * normal;
            motion.angular_velocity += impulse * lever / moment;
        }
        assert!(
            deepest < 64.0 * f64::EPSILON,
            "{deepest:e} with bounds {bounds:?}"
        );
    }
}

#[test]
fn bounds_and_points_that_cannot_be_are_refused() {
    let new = |point: f64, bounds| Tether::new([DVec2::new(point, 0.0), DVec2::ZERO], bounds);
    assert_eq!(
        new(0.0, [0.0, -1.0]).unwrap_err(),
        TetherError::Longest(-1.0)
    );
    assert!(matches!(
        new(0.0, [0.0, f64::NAN]),
        Err(TetherError::Longest(_))
    ));
    for shortest in [-0.1, 1.0, 2.0, f64::NAN] {
        assert!(matches!(
            new(0.0, [shortest, 1.0]),
            Err(TetherError::Shortest { .. })
        ));
    }
    assert!(matches!(
        new(f64::INFINITY, [0.0, 1.0]),
        Err(TetherError::Point(_))
    ));
    // Numbers of a query are looked at, too.
    let lost = RelativeMotion::exactly(DVec2::new(f64::NAN, 0.0), DVec2::X);
    let outcome = new(0.0, [0.0, 1.0]).unwrap().first_event(&lost, 1.0);
    assert_eq!(outcome, Outcome::OutOfRange);
}

/// The computed gap and its rate differ from those of 48 digits by no more than their bounds.
#[test]
fn rounding_stays_within_its_bounds() {
    let pi = Big::pi(PRECISION);
    let mut random = Random(50);
    for (distance, spin, duration) in [
        (1.0, 3.0, 3.0),
        (0.5, 1.0, 0.0),
        (1.0, 1e8, 6.0),
        (10.0, 3.0, 10.0),
    ] {
        let mut worst = [0.0_f64; 2];
        for _ in 0..500 {
            let points = [random.vector(), random.vector()];
            let longest = random.next().abs() + 1e-2;
            let tether = Tether::new(points, [0.0, longest]).unwrap();
            let motion = RelativeMotion {
                orientation: [0, 1].map(|_| Orientation::from_turns(0.5 * random.next())),
                angular_velocity: [0, 1].map(|_| spin * random.next()),
                ..RelativeMotion::exactly(distance * random.vector(), random.vector())
            };
            let time = duration * random.next().abs();
            let flight = tether.flight(&motion);
            let taut = LongestLength::new(&flight, &tether);
            let now = taut.gap(&taut.pose(time));
            let [a, b] = [0, 1].map(|body| {
                let (turned, spin) = (motion.orientation[body], motion.angular_velocity[body]);
                arm(points[body], turned, spin, time, &pi)
            });
            let component = |k: usize| {
                let way = big(motion.separation[k]) + big(motion.velocity[k]) * big(time);
                (
                    way + (&b[0][k] - &a[0][k]),
                    big(motion.velocity[k]) + (&b[1][k] - &a[1][k]),
                )
            };
            let ((x, vx), (y, vy)) = (component(0), component(1));
            let of_length = big(longest);
            let gap = (&of_length * &of_length - (&x * &x + &y * &y)) / (big(2.0) * &of_length);
            let rate = -(x * vx + y * vy) / of_length;
            // Lemma 6 is for distances up to S; the share beyond is that of |d|.
            let beyond = (2.0 * now.value.abs() / longest + 1.0).sqrt();
            let off = |computed: f64, exact: Big| (big(computed) - exact).to_f64().value().abs();
            worst[0] = worst[0].max(off(now.value, gap) / now.error);
            worst[1] = worst[1].max(off(now.rate, rate) / (now.rate_error * beyond));
        }
        assert!(
            worst.iter().all(|ratio| (0.01..1.0).contains(ratio)),
            "{worst:?}"
        );
    }
}
