//! Contacts of bodies with ellipses: each part of one body against each part of the other.

use carom_geometry::Outline;
use carom_kinematics::RelativeMotion;

use crate::{
    Answer, Outcome, Part, Parts, Touch,
    edge_pair::EdgePair,
    flight::Flight,
    gap_search::GapFunction,
    search::Search,
    strip::{a_half_plane_turns, window_of_bodies},
    support_edge::SupportEdgePair,
    support_pair::SupportPair,
    trace::Recorder,
};

/// The certified first contact where A or B has ellipses, from `begin` (time) on.
pub(crate) fn first_contact<R: Recorder>(
    mut recorder: R,
    most_steps: u32,
    begin: f64,
    a: Outline<'_>,
    b: Outline<'_>,
    motion: &RelativeMotion,
    horizon: f64,
) -> Answer {
    let nothing = |outcome| Answer {
        outcome,
        evaluations: 0,
    };
    let has_arc = |body: Outline<'_>| body.edges().iter().any(|edge| edge.bend().is_some());
    if a_half_plane_turns(a, b, motion) || has_arc(a) || has_arc(b) {
        return nothing(Outcome::Unresolved(0.0));
    }
    let Some(window) = window_of_bodies(a, b, motion, horizon) else {
        return nothing(Outcome::Free);
    };
    recorder.window(window);
    let begin = window.begin.max(begin);
    let mut search = Search::new(window.end, most_steps, recorder);
    let flight = Flight::new(a, b, motion);
    for (i, atom) in a.atoms.iter().enumerate() {
        let one = a.shape_of(i);
        for (j, other_atom) in b.atoms.iter().enumerate() {
            let other = b.shape_of(j);
            let offsets = [atom.offset(), other_atom.offset()];
            let pair = SupportPair::new(&flight, (&one, &other), offsets);
            let touch = Touch::Atoms(i as u32, j as u32);
            search.recorder.concerns(|| Parts::Pair(touch));
            let limit = search.limit();
            let outcome = pair.first_contact(begin, [f64::INFINITY, limit], &mut 0, &mut search);
            search.record_touch(outcome, touch);
        }
    }
    for (body, outline, other) in [(0, a, b), (1, b, a)] {
        for (number, edge) in (0..).zip(other.edges()) {
            for (index, atom) in outline.atoms.iter().enumerate() {
                let part = outline.shape_of(index);
                let touch = Touch::edge(body, number, Part::Atom(index as u32));
                search.recorder.concerns(|| Parts::Pair(touch));
                let limit = search.limit();
                let outcome = if part.axes()[0] == part.axes()[1] {
                    EdgePair::new(&flight, body, atom.into(), edge).first_contact_in_span(
                        begin,
                        limit,
                        &mut search,
                    )
                } else {
                    SupportEdgePair::new(&flight, body, &part, atom.offset(), edge)
                        .first_contact_from(begin, limit, &mut search)
                };
                search.record_touch(outcome, touch);
            }
        }
    }
    search.answer()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Detection, Exact,
        first_zero::{Samples, is_first_zero},
    };
    use carom_geometry::{Ellipse, Molecule, gap_between};
    use carom_kinematics::Orientation;
    use glam::DVec2;
    use proptest::prelude::*;

    fn bodies() -> impl Strategy<Value = Molecule> {
        let ellipse = (0.05..0.5f64, 1.0..12.0f64)
            .prop_map(|(b, ratio)| Molecule::ellipse([b * ratio, b], 1.0).unwrap());
        let pair = (0.05..0.3f64, 1.0..4.0f64, -3.2..3.2f64).prop_map(|(b, ratio, turn)| {
            let shape = |angle| Ellipse::new([b * ratio, b], DVec2::from_angle(angle)).unwrap();
            let place = DVec2::new(b * ratio + b, 0.0);
            let apart = place + DVec2::new(b * ratio, 0.0);
            Molecule::of_ellipses([(-place, shape(0.0), 1.0), (apart, shape(turn), 2.0)]).unwrap()
        });
        let disc = (0.01..0.5f64).prop_map(|radius| Molecule::disc(radius, 1.0).unwrap());
        let square = (0.1..1.0f64).prop_map(|size| {
            let corners = [(0.0, 0.0), (size, 0.0), (size, size), (0.0, size)].map(DVec2::from);
            Molecule::polygon(&corners, 1e-6 * size, 1.0).unwrap()
        });
        let capsule = (0.1..2.0f64, 0.01..0.3f64)
            .prop_map(|(length, radius)| Molecule::capsule(length, radius, 1.0).unwrap());
        let wall = (0.1..4.0f64, 0.0..0.1f64)
            .prop_map(|(length, r)| Molecule::wall(DVec2::new(length, 0.0), r).unwrap());
        prop_oneof![3 => ellipse, 1 => pair, 1 => disc, 1 => square, 1 => capsule, 1 => wall]
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 400, max_global_rejects: 1 << 20, ..ProptestConfig::default() })]

        /// Nothing overlaps before the contact, and at the contact the gap is 0 to rounding.
        #[test]
        fn bodies_touch_first_where_their_gap_is_zero(
            a in (0.05..0.5f64, 1.0..12.0f64), b in bodies(), x in -3.0..3.0f64, y in -3.0..3.0f64,
            velocity in (-1.0..1.0f64, -1.0..1.0f64), turns in prop::array::uniform2(-0.5..0.5f64),
            spins in prop::array::uniform2(prop_oneof![Just(0.0), -1.0..1.0f64, -30.0..30.0f64]),
        ) {
            let a = Molecule::ellipse([a.0 * a.1, a.0], 1.0).unwrap();
            let spins = if b.is_wall() { [spins[0], 0.0] } else { spins };
            let motion = RelativeMotion {
                orientation: turns.map(Orientation::from_turns),
                angular_velocity: spins,
                ..RelativeMotion::exactly(DVec2::new(x, y), velocity.into())
            };
            let gap = |t: f64| {
                let [to_a, to_b] = [0, 1].map(|n| motion.orientation[n].turned(spins[n], t).cos_sin());
                gap_between(&a, to_a, &b, to_b, motion.separation + motion.velocity * t)
            };
            prop_assume!(gap(0.0) > 1e-9);
            let horizon = 6.0;
            let answer = Exact::default().first_contact(a.outline(), b.outline(), &motion, horizon);
            // Twice E, with the arms of the search and those of edges; the rounding of the gap here
            // is less.
            let arms = [&a, &b].map(|body| 2.0 * body.bounding_radius());
            let turned = spins[0].abs() * arms[0] + spins[1].abs() * arms[1];
            let allowed = |time: f64| {
                2.0 * f64::EPSILON * (30.0 + 34.0 * (arms[0] + arms[1]) + (14.0 + 4.0 * turned) * time)
            };
            let samples = Samples { count: 2000, depth: 1e-13 };
            is_first_zero(answer.outcome, horizon, gap, allowed, &samples)?;
            prop_assert!(answer.evaluations < 3000, "{}", answer.evaluations);
            // Exchanging the bodies changes no bit of the time.
            let exchanged = RelativeMotion {
                orientation: [motion.orientation[1], motion.orientation[0]],
                angular_velocity: [spins[1], spins[0]],
                ..RelativeMotion::exactly(-motion.separation, -motion.velocity)
            };
            let other = Exact::default().first_contact(b.outline(), a.outline(), &exchanged, horizon);
            let time = |answer: Answer| answer.outcome.contact().map(|contact| contact.time);
            prop_assert_eq!(time(answer), time(other));
        }
    }

    #[test]
    fn an_ellipse_that_turns_meets_a_disc_at_the_known_time() {
        // The tip of an ellipse of half axes 2 and 1 reaches a point at 1.5 from its centre where
        // its radius in that direction is 1.5: 1/r² = cos²/4 + sin².
        let ellipse = Molecule::ellipse([2.0, 1.0], 1.0).unwrap();
        let point = Molecule::disc(1e-9, 1.0).unwrap();
        let motion = RelativeMotion {
            angular_velocity: [1.0, 0.0],
            ..RelativeMotion::exactly(DVec2::new(0.0, 1.5), DVec2::ZERO)
        };
        let answer =
            Exact::default().first_contact(ellipse.outline(), point.outline(), &motion, 10.0);
        let time = answer.outcome.contact().unwrap().time;
        let sine_squared = (1.0 / 2.25 - 0.25) / 0.75;
        let expected = std::f64::consts::FRAC_PI_2 - f64::asin(f64::sqrt(sine_squared));
        assert!((time - expected).abs() < 2e-9, "{time} {expected}");
    }
}
