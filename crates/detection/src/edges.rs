//! Contacts of bodies with straight edges: each atom against each atom and each edge of the other
//! body.
//!
//! **Lemma.** Two thick segments that come to touch do so at an end of one of them. *Proof.* The
//! distance of two disjoint segments in the plane is attained at an end of one. The ends of edges
//! lie inside atoms, so the pairs of atoms with atoms and of atoms with edges are all. A closed
//! line of edges is not crossed without a contact; whether its interior is solid is of no
//! importance.

use carom_geometry::Outline;
use carom_kinematics::RelativeMotion;

use crate::{
    Answer, Outcome, Part, Parts, Touch,
    arc_pair::search_arc,
    disc::disc_contact,
    edge_pair::EdgePair,
    error_bound::ErrorBound,
    flight::{Flight, bounding_circle},
    gap_search::contact_within,
    lines::{Separation, separate},
    molecule_pair::{straight, turning},
    search::Search,
    strip::{a_half_plane_turns, window_of_bodies},
    tolerance::MAX_STEPS,
    trace::Recorder,
};

/// The answer for a half-plane that turns, and for two walls in the model of bounding circles.
const NOTHING_IS_KNOWN: Answer = Answer {
    outcome: Outcome::Unresolved(0.0),
    evaluations: 0,
};

/// The certified first contact where A or B has edges, from `begin` (time) on.
///
/// The atoms at the ends of edges are searched like any atoms.
pub(crate) fn first_contact<R: Recorder>(
    mut recorder: R,
    most_steps: u32,
    begin: f64,
    a: Outline<'_>,
    b: Outline<'_>,
    motion: &RelativeMotion,
    horizon: f64,
) -> Answer {
    if a_half_plane_turns(a, b, motion) {
        return NOTHING_IS_KNOWN;
    }
    let Some(mut window) = window_of_bodies(a, b, motion, horizon) else {
        return Answer {
            outcome: Outcome::Free,
            evaluations: 0,
        };
    };
    recorder.window(window);
    window.begin = window.begin.max(begin);
    let mut search = Search::new(window.end, most_steps, recorder);
    let flight = Flight::new(a, b, motion);
    let has_lines = !(a.sides().is_empty() && b.sides().is_empty());
    let mut begin = begin;
    if has_lines && !a.is_wall() && !b.is_wall() && flight.turns() {
        match separate(a, b, &flight, window, &mut search) {
            Separation::Decided => return search.answer(),
            Separation::Until(time) => begin = time,
        }
        window.begin = begin;
    }
    match a.atoms.is_empty() || b.atoms.is_empty() {
        true => {}
        false if flight.turns() => turning(a, b, &flight, window, &mut search),
        false => straight(a, b, &flight, &mut search),
    }
    for (body, outline, other) in [(0, a, b), (1, b, a)] {
        for (number, edge) in (0..).zip(other.edges()) {
            for (index, atom) in (0..).zip(outline.atoms) {
                let touch = Touch::edge(body, number, Part::Atom(index));
                search.recorder.concerns(|| Parts::Pair(touch));
                if let Some(bend) = edge.bend() {
                    let arc = (edge, bend);
                    search_arc(&flight, body, atom.into(), arc, begin, touch, &mut search);
                    continue;
                }
                let pair = EdgePair::new(&flight, body, atom.into(), edge);
                let outcome = pair.first_contact_in_span(begin, search.limit(), &mut search);
                search.record_touch(outcome, touch);
            }
        }
    }
    search.answer()
}

/// The first contact of the bounding circle of one body with the edge of a wall, or with its end
/// points.
pub(crate) fn contact_of_circle(
    a: Outline<'_>,
    b: Outline<'_>,
    motion: &RelativeMotion,
    horizon: f64,
) -> Answer {
    let (body, circle, wall) = if b.is_wall() { (0, a, b) } else { (1, b, a) };
    let turns = motion.angular_velocity[1 - body] != 0.0;
    let [edge] = wall.edges() else {
        return NOTHING_IS_KNOWN;
    };
    if circle.is_wall() || turns {
        return NOTHING_IS_KNOWN;
    }
    let flight = Flight::new(a, b, motion);
    let touch = Touch::edge(body, 0, Part::BoundingCircle);
    let mut search = Search::new(horizon, MAX_STEPS, ());
    if let Some(bend) = edge.bend() {
        let atom = bounding_circle(circle);
        search_arc(&flight, body, atom, (edge, bend), 0.0, touch, &mut search);
    } else {
        let pair = EdgePair::new(&flight, body, bounding_circle(circle), edge);
        let outcome = pair.first_contact_in_span(0.0, horizon, &mut search);
        search.record_touch(outcome, touch);
    }
    let sign = if body == 1 { 1.0 } else { -1.0 };
    for end in wall.atoms {
        let place = sign * motion.separation - flight.at(0.0).arm(1 - body, end.offset());
        let circles = [bounding_circle(circle), end.into()];
        let error = ErrorBound::of_circles(motion, flight.speed, [0.0; 2], &circles).at(0.0);
        let sigma = circle.bounding_radius + end.radius();
        let errors = (error, motion.velocity_error);
        let time = disc_contact(place, sign * motion.velocity, sigma, errors);
        search.evaluations += 1;
        if time.is_finite() {
            search.record_touch(contact_within(time, horizon), touch);
        }
    }
    search.answer()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BoundingCircles, Contact, Detection, Exact, FixedStep, GoldenSecant};
    use carom_geometry::{Atom, HalfPlane, Molecule, Shape};
    use carom_kinematics::Orientation;
    use glam::DVec2;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn contact(answer: Answer) -> Contact {
        answer
            .outcome
            .contact()
            .unwrap_or_else(|| panic!("{answer:?}"))
    }

    /// Every detector, with the tolerance of its times.
    fn detectors() -> [(Box<dyn Detection>, f64); 3] {
        [
            (Box::new(Exact::default()), 1e-15),
            (Box::new(GoldenSecant::default()), 1e-14),
            (Box::new(FixedStep::default()), 1e-14),
        ]
    }

    #[test]
    fn a_disc_meets_face_and_end_point_at_the_expected_times() {
        let (wall, disc) = (
            Molecule::wall(DVec2::new(0.0, 2.0), 0.25).unwrap(),
            Molecule::disc(0.5, 1.0).unwrap(),
        );
        let circles: (Box<dyn Detection>, f64) = (Box::new(BoundingCircles), 1e-15);
        for (detector, tolerance) in detectors().into_iter().chain([circles]) {
            let ask = |place: DVec2, velocity: DVec2| {
                let motion = RelativeMotion::exactly(place, velocity);
                detector.first_contact(wall.outline(), disc.outline(), &motion, 100.0)
            };
            for side in [1.0, -1.0] {
                let face = contact(ask(DVec2::new(3.0 * side, 0.5), DVec2::new(-side, -0.125)));
                assert!((face.time - 2.25).abs() <= tolerance, "{face:?}");
                assert!(matches!(face.touch, Touch::EdgeOfA { .. }), "{face:?}");
                let onto_end = contact(ask(DVec2::new(0.0, 3.0 * side), DVec2::new(0.0, -side)));
                assert!((onto_end.time - 1.25).abs() <= tolerance, "{onto_end:?}");
                // Centre 0.45 past the end: 0.6 to the side at contact.
                let corner = contact(ask(DVec2::new(3.0 * side, 1.45), DVec2::new(-side, 0.0)));
                assert!((corner.time - 2.4).abs() <= 4.0 * tolerance, "{corner:?}");
                let past = ask(DVec2::new(3.0 * side, 1.7501), DVec2::new(-side, 0.0));
                assert_eq!(past.outcome, Outcome::Free);
                let along = ask(DVec2::new(0.7501 * side, 5.0), DVec2::NEG_Y);
                assert_eq!(along.outcome, Outcome::Free);
            }
        }
    }

    #[test]
    fn a_turning_dumbbell_hits_a_wall_at_the_time_of_arcsine() {
        // Centre 1.5 above the ground, arms 1, radii 1, ω = 1: an atom is at height 1 when sin θ =
        // 1/2.
        let dumbbell = Molecule::named(Shape::Dumbbell, 1.0, 1.0).unwrap();
        let wall = Molecule::wall(DVec2::new(100.0, 0.0), 0.0).unwrap();
        let ground = HalfPlane::new(DVec2::Y).unwrap();
        for (detector, tolerance) in detectors() {
            for below in [ground.outline(), wall.outline()] {
                let motion = RelativeMotion {
                    angular_velocity: [0.0, 1.0],
                    ..RelativeMotion::exactly(DVec2::new(0.25, 1.5), DVec2::ZERO)
                };
                let found =
                    contact(detector.first_contact(below, dumbbell.outline(), &motion, 10.0));
                assert!(
                    (found.time - PI / 6.0).abs() <= 4.0 * tolerance,
                    "{found:?}"
                );
                assert_eq!(
                    found.touch,
                    Touch::EdgeOfA {
                        edge: 0,
                        part: Part::Atom(0)
                    }
                );
                let seen_from_it = contact(detector.first_contact(
                    dumbbell.outline(),
                    below,
                    &motion.exchanged(),
                    10.0,
                ));
                assert_eq!(
                    (seen_from_it.time, seen_from_it.touch.exchanged()),
                    (found.time, found.touch)
                );
            }
        }
    }

    #[test]
    fn touching_bodies_collide_if_they_close_and_overlapping_bodies_unless_they_separate() {
        let (wall, disc) = (
            Molecule::wall(DVec2::X, 0.0).unwrap(),
            Molecule::disc(0.5, 1.0).unwrap(),
        );
        let dumbbell = Molecule::named(Shape::Dumbbell, 0.5, 1.0).unwrap();
        for gap in [-1e-3, -1e-16, 0.0, 1e-16] {
            for (body, spin) in [(&disc, 0.0), (&dumbbell, 1e-3)] {
                let ask = |velocity: DVec2| {
                    let upright = Orientation::from_turns(0.25);
                    let motion = RelativeMotion {
                        orientation: [Orientation::default(), upright],
                        angular_velocity: [0.0, spin],
                        ..RelativeMotion::exactly(
                            DVec2::new(0.1, body.bounding_radius() + gap),
                            velocity,
                        )
                    };
                    Exact::default().first_contact(wall.outline(), body.outline(), &motion, 0.1)
                };
                assert!(
                    contact(ask(DVec2::new(0.2, -1.0))).time <= 1e-15,
                    "gap {gap}"
                );
                for parting in [DVec2::new(0.2, 1.0), DVec2::new(1.0, 1e-13)] {
                    assert_eq!(
                        ask(parting).outcome,
                        Outcome::Free,
                        "gap {gap}, velocity {parting}"
                    );
                }
                let sliding = ask(DVec2::X).outcome;
                if gap == -1e-3 {
                    assert_eq!(sliding.contact().map(|contact| contact.time), Some(0.0));
                } else {
                    assert_eq!(sliding, Outcome::Free, "gap {gap}");
                }
            }
            if gap > -1e-3 {
                let still = RelativeMotion::exactly(DVec2::new(0.1, 0.5 + gap), DVec2::ZERO);
                let answer =
                    Exact::default().first_contact(wall.outline(), disc.outline(), &still, 0.1);
                assert_eq!(answer.outcome, Outcome::Free);
            }
        }
    }

    #[test]
    fn an_atom_that_returns_very_soon_is_found_at_the_expected_time() {
        // A heavy rim: the centre of the touching atom is farther from the face than the centre of
        // mass, so the rotation returns it: g = V t − A (1 − cos ω t), zero at about 2 V / (A ω²).
        let big = Atom::new(DVec2::ZERO, 1.0, 1e-3).unwrap();
        let heavy = Atom::new(DVec2::new(0.0, -0.9), 0.05, 1e3).unwrap();
        let molecule = Molecule::new([big, heavy]).unwrap();
        let lever = molecule.atoms()[0].arm();
        let ground = HalfPlane::new(DVec2::Y).unwrap();
        for exponent in [3, 6, 9] {
            let back = 10f64.powi(-exponent);
            let rate = 0.5 * lever * back;
            let motion = RelativeMotion {
                angular_velocity: [0.0, 1.0],
                ..RelativeMotion::exactly(DVec2::new(0.0, 1.0 - lever), DVec2::new(0.0, rate))
            };
            let found = contact(Exact::default().first_contact(
                ground.outline(),
                molecule.outline(),
                &motion,
                1.0,
            ));
            assert_eq!(
                found.touch,
                Touch::EdgeOfA {
                    edge: 0,
                    part: Part::Atom(0)
                }
            );
            // cos t = 1 − t²/2 + t⁴/24
            let expected = back * (1.0 + back * back / 12.0);
            assert!(
                (found.time / expected - 1.0).abs() < 1e-6,
                "{} against {expected}",
                found.time
            );
        }
    }

    #[test]
    fn a_wall_that_turns_meets_a_disc_with_its_edge_or_its_end() {
        let disc = Molecule::disc(0.5, 1.0).unwrap();
        let motion = RelativeMotion {
            angular_velocity: [1.0, 0.0],
            ..RelativeMotion::exactly(DVec2::new(0.0, 0.9), DVec2::ZERO)
        };
        // The line is 0.9 cos θ from the disc; the short wall does not reach the foot of its
        // centre.
        let edge = Touch::EdgeOfA {
            edge: 0,
            part: Part::Atom(0),
        };
        let expected = [
            (4.0, f64::acos(0.5 / 0.9), edge),
            (1.0, f64::asin(0.9), Touch::Atoms(1, 0)),
        ];
        for (length, time, touch) in expected {
            let wall = Molecule::wall(DVec2::new(length, 0.0), 0.0).unwrap();
            for (detector, tolerance) in detectors() {
                let found =
                    contact(detector.first_contact(wall.outline(), disc.outline(), &motion, 10.0));
                assert!((found.time - time).abs() < 10.0 * tolerance, "{found:?}");
                assert_eq!(found.touch, touch);
            }
        }
    }

    #[test]
    fn a_half_plane_that_turns_is_unresolved_from_the_start() {
        let ground = HalfPlane::new(DVec2::Y).unwrap();
        let disc = Molecule::disc(0.5, 1.0).unwrap();
        let motion = RelativeMotion {
            angular_velocity: [1.0, 0.0],
            ..RelativeMotion::exactly(DVec2::new(0.0, 1.0), DVec2::ZERO)
        };
        let circles: (Box<dyn Detection>, f64) = (Box::new(BoundingCircles), 0.0);
        for (detector, _) in detectors().into_iter().chain([circles]) {
            let answer = detector.first_contact(ground.outline(), disc.outline(), &motion, 10.0);
            assert_eq!(answer.outcome, Outcome::Unresolved(0.0));
        }
    }

    proptest! {
        /// A disc in uniform motion touches first when its distance to the segment is its radius.
        #[test]
        fn discs_touch_at_their_radius_from_the_segment(
            x in -3.0..3.0f64, y in -3.0..3.0f64, vx in -1.0..1.0f64, vy in -1.0..1.0f64,
            length in 0.1..4.0f64, angle in -3.0..3.0f64, radius in 0.01..0.5f64,
        ) {
            let (wall, disc) = (
                Molecule::wall(length * DVec2::from_angle(angle), 0.0).unwrap(),
                Molecule::disc(radius, 1.0).unwrap(),
            );
            let (place, velocity) = (DVec2::new(x, y), DVec2::new(vx, vy));
            let gap = |t: f64| wall.edges()[0].nearest(place + velocity * t).distance - radius;
            prop_assume!(gap(0.0) > 1e-9);
            let motion = RelativeMotion::exactly(place, velocity);
            let answer = Exact::default().first_contact(wall.outline(), disc.outline(), &motion, 30.0);
            let until = match answer.outcome {
                Outcome::Contact(contact) => {
                    prop_assert!(gap(contact.time).abs() < 1e-13, "{:e}", gap(contact.time));
                    contact.time
                }
                _ => 30.0,
            };
            for part in 0..1000 {
                prop_assert!(gap(until * f64::from(part) / 1000.0) > -1e-13);
            }
            // A disc that turns has the same contacts, found by another search.
            let off_centre = Molecule::new([
                Atom::new(DVec2::ZERO, radius, 1.0).unwrap(),
                Atom::new(DVec2::new(1e-3 * radius, 0.0), 0.5 * radius, 1e-30).unwrap(),
            ]).unwrap();
            let turning = RelativeMotion { angular_velocity: [0.0, 1.0], ..motion };
            let other = Exact::default().first_contact(wall.outline(), off_centre.outline(), &turning, 30.0);
            match (answer.outcome.contact(), other.outcome.contact()) {
                (Some(_), Some(found)) => prop_assert!(gap(found.time).abs() < 1e-13),
                (None, None) => {}
                (one, two) => prop_assert!(false, "{one:?} against {two:?}"),
            }
        }
    }
}
