//! First contacts with a known analytic answer, from head-on discs to grazes a billionth of a
//! radius deep.

use std::f64::consts::PI;

use crate::support::formulas::Pair;
use carom_detection::{Answer, Contact, Detection, Exact, GoldenSecant, Outcome, Touch, skim};
use carom_geometry::{Atom, Molecule, Shape};
use carom_kinematics::{Orientation, RelativeMotion};
use glam::DVec2;

fn ask(detector: &dyn Detection, pair: &Pair<'_>, horizon: f64) -> Answer {
    detector.first_contact(pair.a.outline(), pair.b.outline(), &pair.motion, horizon)
}

fn contact(detector: &dyn Detection, pair: &Pair<'_>, horizon: f64) -> Contact {
    let answer = ask(detector, pair, horizon);
    answer
        .outcome
        .contact()
        .unwrap_or_else(|| panic!("no contact: {answer:?}"))
}

/// The certified detector and that of the thesis.
fn both() -> [Box<dyn Detection>; 2] {
    [
        Box::new(Exact::default()),
        Box::new(GoldenSecant::default()),
    ]
}

#[test]
fn discs_on_pythagorean_triangles() {
    // Two discs with σ = 5 and impact parameter 3 touch 4 before the foot of the perpendicular; the
    // other cases are analogous.
    for (across, along, sigma) in [
        (0.0, 5.0, 5.0),
        (3.0, 4.0, 5.0),
        (5.0, 12.0, 13.0),
        (20.0, 21.0, 29.0),
    ] {
        let (a, b) = (
            Molecule::disc(2.0, 1.0).unwrap(),
            Molecule::disc(sigma - 2.0, 1.0).unwrap(),
        );
        for (speed, distance) in [(1.0, 100.0), (0.125, 64.0), (1024.0, 50.0)] {
            let motion =
                RelativeMotion::exactly(DVec2::new(distance, across), DVec2::new(-speed, 0.0));
            let pair = Pair {
                a: &a,
                b: &b,
                motion,
            };
            let expected = (distance - along) / speed;
            for detector in both() {
                let time = contact(&*detector, &pair, 2.0 * distance / speed).time;
                assert!(
                    (time - expected).abs() <= pair.time_tolerance((0, 0), expected),
                    "{time}"
                );
            }
        }
    }
}

#[test]
fn molecules_that_do_not_turn_touch_like_their_single_discs() {
    // A cross and a dumbbell with atoms of radius 1: the arm at (2, 0) touches the atom that passes
    // it 1.2 above.
    let cross = Molecule::named(Shape::Cross, 1.0, 1.0).unwrap();
    let dumbbell = Molecule::named(Shape::Dumbbell, 1.0, 1.0).unwrap();
    let motion = RelativeMotion::exactly(DVec2::new(10.0, 1.2), DVec2::new(-0.5, 0.0));
    let pair = Pair {
        a: &cross,
        b: &dumbbell,
        motion,
    };
    for detector in both() {
        let found = contact(&*detector, &pair, 100.0);
        // The dumbbell's left atom starts at x = 9 and touches at 2 + √(2² − 1.2²) = 3.6.
        assert!((found.time - 5.4 / 0.5).abs() < 1e-13);
        assert_eq!(found.touch, Touch::Atoms(1, 0));
    }
}

/// A dumbbell of arm a that turns without translation, at first along `start`, and a disc at rest
/// at (d, 0).
fn turning_dumbbell<'a>(
    dumbbell: &'a Molecule,
    disc: &'a Molecule,
    distance: f64,
    start: f64,
    spin: f64,
) -> Pair<'a> {
    let motion = RelativeMotion {
        orientation: [Orientation::from_turns(start), Orientation::default()],
        angular_velocity: [spin, 0.0],
        ..RelativeMotion::exactly(DVec2::new(distance, 0.0), DVec2::ZERO)
    };
    Pair {
        a: dumbbell,
        b: disc,
        motion,
    }
}

/// Angle between arm and disc at which the atom touches it: cos ψ = (a² + d² − s²)/(2 a d).
///
/// The form sin²(ψ/2) = δ (2 s − δ)/(4 a d) with the depth δ = a + s − d keeps the digits of a
/// graze.
fn touching_angle(arm: f64, distance: f64, contact_distance: f64) -> f64 {
    let depth = arm + contact_distance - distance;
    2.0 * (depth * (2.0 * contact_distance - depth) / (4.0 * arm * distance))
        .sqrt()
        .asin()
}

#[test]
fn a_turning_arm_touches_a_disc_at_rest_at_the_known_angle() {
    let dumbbell = Molecule::named(Shape::Dumbbell, 1.0, 1.0).unwrap();
    let disc = Molecule::disc(0.5, 1.0).unwrap();
    let (arm, sum) = (1.0, 1.5);
    // Depths relative to the reach of 2.5, down to grazes that last a millionth of a turn.
    for depth in [0.4, 1e-1, 1e-3, 1e-6, 1e-9, 1e-12] {
        let distance = 2.5 * (1.0 - depth);
        let psi = touching_angle(arm, distance, sum);
        for (start, spin) in [(-0.3, 1.0), (0.3, -1.0), (-0.25, 1e6), (-0.375, 1e-6)] {
            let pair = turning_dumbbell(&dumbbell, &disc, distance, start, spin);
            // Either atom may touch first; the atom at −x is half a turn behind.
            let turned = [0.5, 0.0].map(|behind| {
                let to_go = (-spin.signum() * (start + behind)).rem_euclid(1.0) * 2.0 * PI - psi;
                to_go / spin.abs()
            });
            let (expected, atom) = if turned[0] < turned[1] {
                (turned[0], 0)
            } else {
                (turned[1], 1)
            };
            let tolerance = 2.0 * pair.time_tolerance((atom, 0), expected);
            for detector in both() {
                let found = contact(&*detector, &pair, 10.0 / spin.abs());
                assert!(
                    (found.time - expected).abs() <= tolerance,
                    "depth {depth}, spin {spin}: {} against {expected} ± {tolerance:e}",
                    found.time
                );
                assert_eq!(found.touch, Touch::Atoms(atom, 0));
            }
            // Even the time of the shallowest graze is accurate to a millionth of a radian.
            assert!(tolerance * spin.abs() < 1e-6);
        }
    }
}

#[test]
fn a_turning_arm_out_of_reach_misses_and_a_tangent_contact_gives_no_impulse() {
    let dumbbell = Molecule::named(Shape::Dumbbell, 1.0, 1.0).unwrap();
    let disc = Molecule::disc(0.5, 1.0).unwrap();
    for gap in [1e-3, 1e-6, 1e-9, 1e-12] {
        let pair = turning_dumbbell(&dumbbell, &disc, 2.5 * (1.0 + gap), -0.3, 1.0);
        for detector in both() {
            assert_eq!(
                ask(&*detector, &pair, 10.0).outcome,
                Outcome::Free,
                "gap {gap}"
            );
        }
    }
    // For d = a + s exactly, rounding decides whether they touch. If a contact is returned, the
    // closing speed must be at most that of a graze of depth 2 E, √(2 g'' 2E): 1e-7 of the atom's
    // speed.
    let pair = turning_dumbbell(&dumbbell, &disc, 2.5, -0.3, 1.0);
    for detector in both() {
        if let Outcome::Contact(found) = ask(&*detector, &pair, 10.0).outcome {
            let Touch::Atoms(i, j) = found.touch else {
                panic!("{found:?}")
            };
            assert!(pair.approach((i, j), found.time).rate.abs() < 1e-7);
        }
    }
}

#[test]
fn a_pair_that_has_just_collided_meets_again_when_it_has_turned() {
    // The arm touches the disc and separates; its other end arrives after half a turn less 2 ψ.
    let dumbbell = Molecule::named(Shape::Dumbbell, 1.0, 1.0).unwrap();
    let disc = Molecule::disc(0.5, 1.0).unwrap();
    for distance in [1.75, 2.0, 2.25, 2.4375] {
        let psi = touching_angle(1.0, distance, 1.5);
        let pair = turning_dumbbell(&dumbbell, &disc, distance, psi / (2.0 * PI), 3.0);
        let expected = (PI - 2.0 * psi) / 3.0;
        for detector in both() {
            let found = contact(&*detector, &pair, 10.0);
            assert!(
                (found.time - expected).abs() < 1e-14,
                "{} against {expected}",
                found.time
            );
            assert_eq!(found.touch, Touch::Atoms(0, 0));
        }
    }
}

#[test]
fn equal_angular_velocities_without_translation_give_a_circular_separation() {
    // With equal angular velocities and orientations the separation of unlike atoms of two
    // dumbbells is X − 2a (cos, sin)(θ + ω t).
    let dumbbell = Molecule::named(Shape::Dumbbell, 1.0, 1.0).unwrap();
    for distance in [3.0, 3.5, 4.0 - 1e-6, 4.0 - 1e-9] {
        let (start, spin) = (-0.125, 2.0);
        let motion = RelativeMotion {
            orientation: [Orientation::from_turns(start); 2],
            angular_velocity: [spin; 2],
            ..RelativeMotion::exactly(DVec2::new(distance, 0.0), DVec2::ZERO)
        };
        let pair = Pair {
            a: &dumbbell,
            b: &dumbbell,
            motion,
        };
        let psi = touching_angle(2.0, distance, 2.0);
        let expected = (0.25 * PI - psi) / spin;
        for detector in both() {
            let found = contact(&*detector, &pair, 10.0);
            let tolerance = 2.0 * pair.time_tolerance((1, 0), expected);
            assert!(
                (found.time - expected).abs() < tolerance,
                "distance {distance}: {found:?}"
            );
            assert_eq!(found.touch, Touch::Atoms(1, 0));
        }
    }
}

#[test]
fn a_body_inside_a_ring_that_turns_with_it_never_touches() {
    // The gap is constant, so the pair is close to a contact at each time.
    let ring = Molecule::named(Shape::Ring(12), 0.5, 1.0).unwrap();
    for gap in [1e-2, 1e-5, 1e-8] {
        // The end atoms point at atoms 0 and 6 of the ring.
        let arm = ring.atoms()[0].arm() - 0.5 - 0.25 - gap;
        let end = |x: f64| Atom::new(DVec2::new(x, 0.0), 0.25, 1.0).unwrap();
        let inside = Molecule::new([end(arm), end(-arm)]).unwrap();
        let motion = RelativeMotion {
            angular_velocity: [1.0; 2],
            ..RelativeMotion::exactly(DVec2::ZERO, DVec2::ZERO)
        };
        let pair = Pair {
            a: &ring,
            b: &inside,
            motion,
        };
        assert!((pair.smallest_gap(0.0) - gap).abs() < 1e-14);
        // Certified free, or free until some time: a stronger answer would need the fact that the
        // relative motion is rigid.
        let answer = ask(&Exact::default(), &pair, 1e3);
        match answer.outcome {
            Outcome::Free => {}
            Outcome::FreeUntil(time) => assert!(time > 0.0, "gap {gap}"),
            other => panic!("gap {gap}: {other:?}"),
        }
    }
}

#[test]
fn a_fast_rotor_is_touched_at_its_bounding_circle() {
    // A dumbbell with a million radians per unit time sweeps its whole bounding circle in half a
    // turn. The disc reaches the circle at t0; an atom points at it before t0 + π/ω.
    let dumbbell = Molecule::named(Shape::Dumbbell, 1.0, 1.0).unwrap();
    let disc = Molecule::disc(0.5, 1.0).unwrap();
    for spin in [1e2, 1e4, 1e6] {
        for start in [0.0, 0.1, 0.2, 0.3, 0.4] {
            let motion = RelativeMotion {
                orientation: [Orientation::from_turns(start), Orientation::default()],
                angular_velocity: [spin, 0.0],
                ..RelativeMotion::exactly(DVec2::new(3.5, 0.0), DVec2::new(-1.0, 0.0))
            };
            let pair = Pair {
                a: &dumbbell,
                b: &disc,
                motion,
            };
            for detector in both() {
                let time = contact(&*detector, &pair, 10.0).time;
                assert!(
                    (1.0 - 1e-15..=1.0 + PI / spin).contains(&time),
                    "spin {spin}, start {start}: {time}"
                );
            }
        }
    }
}

#[test]
fn bodies_whose_bounding_circles_do_not_meet_are_excluded() {
    let tee = Molecule::named(Shape::Tee, 1.0, 1.0).unwrap();
    let motion = RelativeMotion {
        angular_velocity: [5.0, -3.0],
        ..RelativeMotion::exactly(DVec2::new(50.0, 7.7), DVec2::new(-1.0, 0.0))
    };
    let pair = Pair {
        a: &tee,
        b: &tee,
        motion,
    };
    // The bounding circles have radius 3.8.
    assert!(skim(&motion, 7.6, 1e3).is_none());
    for detector in both() {
        assert_eq!(
            ask(&*detector, &pair, 1e3),
            Answer {
                outcome: Outcome::Free,
                evaluations: 0
            }
        );
    }
}
