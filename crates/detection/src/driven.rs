//! Contacts of bodies of which one is driven: their relative motion is not uniform.
//!
//! # Lemmas
//! In the notation of [`gap_search`](crate::gap_search): w(t) is the deviation of B from uniform
//! motion relative to A since the present, so that w = w' = 0 now. From now to the end of the
//! search |w'| ≤ W, |w''| ≤ A and |w'''| ≤ J ([`Drive::bounds`]).
//!
//! 1. **One placement.** At each time of evaluation the pair is a pair in uniform motion, with the
//!    present relative velocity, whose gap is known with its rate and their rounding. What the
//!    drive adds to the separation and the velocity has rounding bounds of its own, which are added
//!    to those of the relative motion ([`DriveDeviation`](carom_kinematics::DriveDeviation)).
//! 2. **Curvature with a fixed normal.** Bounds −n·d'' ≤ K and |d/dt (n·d'')| ≤ K₃ of the uniform
//!    motion become K + A and K₃ + J, and n·d'' becomes n·d'' + n·w''. *Proof.* d'' is the sum of
//!    that of the uniform motion and w''. Of A and J the part along n is enough: a wall that
//!    oscillates fast along itself does not shorten the steps.
//! 3. **Curvature with a normal that turns at a rate ω** (of an edge). K + A + 2 |ω| W and K₃ + J +
//!    3 |ω| A + 3 ω² W are bounds. *Proof.* y'' of [`edge_pair`](crate::edge_pair), Lemma 2, has
//!    the additional terms n·w'' − 2 ω n·w'^⊥, and its derivative w''', at most 3 |ω| |w''| and at
//!    most 3 ω² |w'|. Its terms in D are bounded by the reach, for which |X| + r + (|V| + W) T is
//!    taken, with the time T that is left.
//! 4. **No window.** A driven pair may come back: times at which the bodies are out of reach are
//!    passed by steps. For an atom beyond the end of an edge, the step of Lemma 1 of `gap_search`
//!    along the edge holds with the bounds of Lemma 3.
//! 5. **No landing.** There is no bound on g''' here: a search ends within E of the contact.
//! 6. **Whole bodies.** No part of a body touches before its bounding circle does.
//!
//! With a constant acceleration and a wall that does not turn, the bound on the gap of a disc is
//! the parabola itself, so that one step leads to the contact.

use carom_geometry::{Circle, Edge, Ellipse, Outline};
use carom_kinematics::{Drive, DriveBounds, HALF_ULP as U, RelativeMotion};
use glam::DVec2;

use crate::{
    Answer, Outcome, Part, Parts, Touch,
    atom_pair::AtomPair,
    edge_error::reach_of_pair,
    edge_pair::EdgePair,
    flight::{Flight, bounding_circle},
    gap_search::{Gap, GapFunction},
    safe_step::{Curvature, safe_step},
    search::{PairOutcome, Search},
    support_edge::SupportEdgePair,
    support_pair::SupportPair,
    trace::Recorder,
};

/// Share of its radius by which a bounding circle is enlarged: more than all rounding.
const CIRCLE_MARGIN: f64 = 1e-9;

/// The certified first contact of two bodies from `begin` to `horizon` (times), of which B has the
/// drive from `from` on relative to A.
///
/// Bodies with arcs are not searched.
pub(crate) fn first_contact<R: Recorder>(
    recorder: R,
    most_steps: u32,
    begin: f64,
    [a, b]: [Outline<'_>; 2],
    motion: &RelativeMotion,
    (drive, from): (&Drive, f64),
    horizon: f64,
) -> Answer {
    let has_arc = |body: Outline<'_>| body.edges().iter().any(|edge| edge.bend().is_some());
    if has_arc(a) || has_arc(b) || !drive.is_finite() {
        return Answer {
            outcome: Outcome::Unresolved(0.0),
            evaluations: 0,
        };
    }
    let mut search = Search::new(horizon, most_steps, recorder);
    let pair = |parts| DrivenPair::new([a, b], motion, (drive, from), horizon, parts);
    let begin = certified_by_circles(&pair, [a, b], begin, &mut search);
    for (parts, touch) in pairs_of_parts(a, b) {
        search.recorder.concerns(|| Parts::Pair(touch));
        let limit = search.limit();
        if begin <= limit {
            let times = [f64::INFINITY, limit];
            let pair = pair(parts);
            let outcome = match pair.first_contact(begin, times, &mut 0, &mut search) {
                PairOutcome::Contact(time) if !pair.is_in_image(time) => PairOutcome::Free,
                outcome => outcome,
            };
            search.record_touch(outcome, touch);
        }
    }
    search.answer()
}

/// Every part of A with every part of B, but edges with edges.
fn pairs_of_parts<'a>(a: Outline<'a>, b: Outline<'a>) -> Vec<(PartPair<'a>, Touch)> {
    let mut pairs = Vec::new();
    for (i, atom) in a.atoms.iter().enumerate() {
        for (j, other) in b.atoms.iter().enumerate() {
            let [one, two] = [a.shape_of(i), b.shape_of(j)];
            let offsets = [atom.offset(), other.offset()];
            let parts = if is_round(&one) && is_round(&two) {
                PartPair::Atoms([atom.into(), other.into()])
            } else {
                PartPair::Convex([one, two], offsets)
            };
            pairs.push((parts, Touch::Atoms(i as u32, j as u32)));
        }
    }
    for (body, outline, other) in [(0, a, b), (1, b, a)] {
        for (number, edge) in (0..).zip(other.edges()) {
            for (index, atom) in outline.atoms.iter().enumerate() {
                let shape = outline.shape_of(index);
                let parts = if is_round(&shape) {
                    PartPair::Edge(body, atom.into(), edge)
                } else {
                    PartPair::ConvexEdge(body, shape, atom.offset(), edge)
                };
                pairs.push((parts, Touch::edge(body, number, Part::Atom(index as u32))));
            }
        }
    }
    pairs
}

/// A time, not before `begin`, up to which the bodies are certified free by their bounding circles
/// (Lemma 6); infinite if they do not touch at all.
fn certified_by_circles<'a, R: Recorder>(
    pair: &impl Fn(PartPair<'a>) -> DrivenPair<'a>,
    [a, b]: [Outline<'a>; 2],
    begin: f64,
    search: &mut Search<R>,
) -> f64 {
    let parts = |body: Outline<'_>| body.atoms.len() + body.edges().len();
    let [of_a, of_b] = [a, b].map(parts);
    let (body, inside, other) = if b.is_wall() || (of_b < of_a && !a.is_wall()) {
        (0, a, b)
    } else {
        (1, b, a)
    };
    // Of two alike none is chosen, so that exchanging them changes nothing.
    if parts(inside) == 1 || inside.is_wall() || (of_a == of_b && !other.is_wall()) {
        return begin;
    }
    let circle = bounding_circle(inside);
    let circle = Circle {
        radius: circle.radius * (1.0 + CIRCLE_MARGIN),
        ..circle
    };
    let in_order = |one: Circle, two: Circle| if body == 0 { [one, two] } else { [two, one] };
    let atoms = other.atoms.iter().enumerate().map(|(index, atom)| {
        let shape = other.shape_of(index);
        // The reach of an ellipse about its own centre.
        let radius = shape.axes()[0].max(shape.axes()[1]) * (1.0 + CIRCLE_MARGIN);
        let atom = Circle {
            radius,
            ..Circle::from(atom)
        };
        PartPair::Atoms(in_order(circle, atom))
    });
    let edges = other.edges().iter();
    // Where no atoms are at the ends, a circle beyond them may hold parts that touch the edge.
    let edges = edges.map(|edge| match other.atoms {
        [] => PartPair::Line(body, circle, edge),
        _ => PartPair::Edge(body, circle, edge),
    });
    let limit = search.limit();
    let mut first = f64::INFINITY;
    for parts in atoms.chain(edges) {
        let pair = pair(parts);
        let pose = pair.pose(begin);
        // Circles that overlap and separate may come back, but their parts may touch at once.
        if !(pose.gap.value > pose.gap.error || pose.step > 0.0) {
            return begin;
        }
        match pair.first_contact(begin, [f64::INFINITY, limit.min(first)], &mut 0, search) {
            PairOutcome::Free => {}
            PairOutcome::Contact(time)
            | PairOutcome::OutOfBudget(time)
            | PairOutcome::Paused(time) => first = first.min(time),
        }
    }
    first.max(begin)
}

fn is_round(shape: &Ellipse) -> bool {
    shape.axes()[0] == shape.axes()[1]
}

/// A part of A and a part of B; with edges, the number of the body with the atom comes first.
enum PartPair<'a> {
    Atoms([Circle; 2]),
    Convex([Ellipse; 2], [DVec2; 2]),
    Edge(usize, Circle, &'a Edge),
    /// The whole line through an edge.
    Line(usize, Circle, &'a Edge),
    ConvexEdge(usize, Ellipse, DVec2, &'a Edge),
}

/// A part of each of two bodies, of which one is driven.
struct DrivenPair<'a> {
    bodies: [Outline<'a>; 2],
    motion: &'a RelativeMotion,
    drive: &'a Drive,
    from: f64,
    end: f64,
    parts: PartPair<'a>,
    top_speed: f64,
    size: f64,
}

/// The parts at one time.
struct DrivenPose {
    gap: Gap,
    /// A certified time for which an atom beyond the end of an edge stays there.
    step: f64,
    /// Whether the same parts can touch for twice the time in which the gap closes.
    stays: bool,
}

/// The terms of a drive in the bounds on the curvature.
struct DriveCurvature<'a> {
    drive: &'a Drive,
    /// The time that is left.
    left: f64,
    bounds: DriveBounds,
    /// w'', of B relative to A (length per time squared).
    acceleration: DVec2,
    /// Bound on its rounding.
    error: f64,
    /// Bound on the rounding of the orientations (radians).
    tilt: f64,
}

impl<'a> DrivenPair<'a> {
    fn new(
        bodies: [Outline<'a>; 2],
        motion: &'a RelativeMotion,
        (drive, from): (&'a Drive, f64),
        end: f64,
        parts: PartPair<'a>,
    ) -> Self {
        let mut pair = Self {
            bodies,
            motion,
            drive,
            from,
            end,
            parts,
            top_speed: 0.0,
            size: 0.0,
        };
        let start = pair.evaluated(0.0);
        pair.top_speed = start.top_speed + drive.bounds(end).velocity;
        pair.size = start.size;
        pair
    }

    /// Whether an ellipse touches a wall across the box in this image of the wall.
    fn is_in_image(&self, time: f64) -> bool {
        let PartPair::ConvexEdge(body, shape, offset, edge) = &self.parts else {
            return true;
        };
        let (motion, _) = self.motion.driven(self.drive, self.from, time);
        let [a, b] = self.bodies;
        let flight = Flight::new(a, b, &motion);
        let reach = motion.separation.length() + offset.length();
        SupportEdgePair::within(&flight, *body, shape, *offset, edge, reach).is_in_image(0.0)
    }

    /// The parts at a time, with the bounds of this pair.
    fn evaluated(&self, time: f64) -> PairBounds {
        let (motion, deviation) = self.motion.driven(self.drive, self.from, time);
        let [a, b] = self.bodies;
        let flight = Flight::new(a, b, &motion);
        let left = (self.end - time).max(0.0);
        let of_drive = DriveCurvature {
            drive: self.drive,
            left,
            bounds: self.drive.bounds(left),
            acceleration: deviation.acceleration,
            error: deviation.acceleration_error,
            tilt: motion.orientation_error[0] + motion.orientation_error[1],
        };
        let reach = motion.separation.length() + (flight.speed + of_drive.bounds.velocity) * left;
        let seen_by = |body: usize| if body == 1 { 1.0 } else { -1.0 };
        match &self.parts {
            PartPair::Atoms(circles) => {
                let pair = AtomPair::new(&flight, *circles);
                PairBounds::new(&pair, |pose, gap| {
                    let normal = pose.d.normalize_or_zero();
                    (of_drive.added_to(gap, normal, 0.0), 0.0)
                })
            }
            PartPair::Convex(shapes, offsets) => {
                let pair = SupportPair::new(&flight, (&shapes[0], &shapes[1]), *offsets);
                PairBounds::new(&pair, |pose, gap| {
                    (of_drive.added_to(gap, pose.facing.normal, 0.0), 0.0)
                })
            }
            PartPair::Edge(body, circle, edge) | PartPair::Line(body, circle, edge) => {
                let turn = flight.spin[1 - body];
                // The atom of a body that does not turn counts from its own centre.
                let reach = reach + circle.arm;
                let reach = reach.max(reach_of_pair(flight.spin[*body], circle, edge));
                let pair = EdgePair::within(&flight, *body, *circle, edge, reach);
                let pair = match self.parts {
                    PartPair::Line(..) => pair.of_whole_line(),
                    _ => pair,
                };
                of_drive.bounds_of_edge(&pair, seen_by(*body), turn)
            }
            PartPair::ConvexEdge(body, shape, offset, edge) => {
                let turn = flight.spin[1 - body];
                let reach = reach + offset.length();
                let pair = SupportEdgePair::within(&flight, *body, shape, *offset, edge, reach);
                PairBounds::new(&pair, |pose, gap| {
                    let normal = seen_by(*body) * pose.facing.normal;
                    (of_drive.added_to(gap, normal, turn), 0.0)
                })
            }
        }
    }
}

/// The parts at one time, and bounds that hold at all times.
struct PairBounds {
    pose: DrivenPose,
    top_speed: f64,
    size: f64,
}

impl PairBounds {
    /// The pair now; `bend` returns the curvature with the drive, and another certified step.
    fn new<G: GapFunction>(
        pair: &G,
        bend: impl FnOnce(&G::Pose, Curvature) -> (Curvature, f64),
    ) -> Self {
        let pose = pair.pose(0.0);
        let gap = pair.gap(&pose);
        let closes_in = (gap.value / gap.rate).abs();
        let stays = pair.stays(&pose, 2.0 * closes_in);
        let (curvature, step) = bend(&pose, gap.curvature);
        Self {
            pose: DrivenPose {
                gap: Gap { curvature, ..gap },
                step,
                stays,
            },
            top_speed: pair.top_speed(),
            size: pair.size(),
        }
    }
}

impl DriveCurvature<'_> {
    /// An atom and an edge that turns at a rate; `sign` is that of the directions of the edge seen
    /// from A to B.
    fn bounds_of_edge(&self, pair: &EdgePair<'_>, sign: f64, turn: f64) -> PairBounds {
        PairBounds::new(pair, |pose, gap| {
            let (beyond, error) = (pair.beyond(pose), pair.error_at(0.0));
            let step = if beyond.value > error {
                let along = pair.curvature(pose, &beyond, error);
                let along = self.added_to(along, sign * pose.endwards.direction, turn);
                safe_step(beyond.value, beyond.rate - pair.rate_error_at(0.0), &along)
            } else {
                0.0
            };
            (
                self.added_to(gap, sign * pose.outwards.direction, turn),
                step,
            )
        })
    }

    /// The bounds of a pair in uniform motion with those of the drive, for a normal from A to B
    /// that turns at a rate (Lemmas 2 and 3).
    fn added_to(&self, uniform: Curvature, normal: DVec2, turn: f64) -> Curvature {
        let turn = turn.abs();
        // Rounding of the direction of the normal, and of products with it.
        let tilt = 64.0 * U + self.tilt;
        let whole = self.bounds;
        let DriveBounds {
            velocity,
            acceleration,
            jerk,
        } = if turn == 0.0 && normal != DVec2::ZERO {
            let along = self.drive.along(normal).bounds(self.left);
            DriveBounds {
                velocity: whole.velocity,
                acceleration: along.acceleration + tilt * whole.acceleration,
                jerk: along.jerk + tilt * whole.jerk,
            }
        } else {
            whole
        };
        let more = acceleration + 2.0 * turn * velocity;
        let error = self.error + tilt * (whole.acceleration + 2.0 * turn * velocity);
        let along_normal = normal.dot(self.acceleration) - error;
        Curvature {
            along_normal: uniform.along_normal + along_normal,
            jerk: uniform.jerk + (jerk + 3.0 * turn * (acceleration + turn * velocity)),
            upwards: uniform.upwards + more,
            ..Curvature::at_most(uniform.largest + more)
        }
    }
}

impl GapFunction for DrivenPair<'_> {
    type Pose = DrivenPose;

    fn pose(&self, time: f64) -> DrivenPose {
        self.evaluated(time).pose
    }

    fn gap(&self, pose: &DrivenPose) -> Gap {
        pose.gap
    }

    fn top_speed(&self) -> f64 {
        self.top_speed
    }

    fn size(&self) -> f64 {
        self.size
    }

    fn other_step(&self, pose: &DrivenPose) -> f64 {
        pose.step
    }

    /// The search corrects a contact by less than twice the time in which the gap closes.
    fn stays(&self, pose: &DrivenPose, _: f64) -> bool {
        pose.stays
    }

    /// Always `time` (Lemma 4).
    fn within_reach(&self, time: f64, _: f64) -> Option<f64> {
        Some(time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Detection, Exact,
        first_zero::{Samples, is_first_zero},
    };
    use carom_geometry::{Atom, Molecule, gap_between};
    use carom_kinematics::Orientation;
    use proptest::prelude::*;

    fn bodies() -> impl Strategy<Value = Molecule> {
        let disc = (0.01..0.5f64).prop_map(|radius| Molecule::disc(radius, 1.0).unwrap());
        let atoms = (0.1..0.5f64, 0.05..0.3f64, 0.1..2.0f64).prop_map(|(arm, radius, mass)| {
            let at = |x, y, mass| Atom::new(DVec2::new(x, y), radius, mass).unwrap();
            Molecule::new([at(-arm, 0.0, 1.0), at(arm, 0.0, mass), at(0.0, arm, 0.5)]).unwrap()
        });
        let square = (0.1..1.0f64, 0.0..0.1f64).prop_map(|(size, radius)| {
            let corners = [(0.0, 0.0), (size, 0.0), (size, size), (0.0, size)].map(DVec2::from);
            Molecule::polygon(&corners, radius + 1e-6 * size, 1.0).unwrap()
        });
        let ellipse = (0.05..0.5f64, 1.0..6.0f64)
            .prop_map(|(b, ratio)| Molecule::ellipse([b * ratio, b], 1.0).unwrap());
        prop_oneof![disc, atoms, square, ellipse]
    }

    fn fixed_bodies() -> impl Strategy<Value = Molecule> {
        let wall = (0.1..6.0f64, 0.0..0.1f64, -3.2..3.2f64).prop_map(|(length, radius, angle)| {
            Molecule::wall(length * DVec2::from_angle(angle), radius).unwrap()
        });
        // So long that no body comes to its ends, where its next image would begin.
        let across = (60.0..80.0f64, 0.0..0.1f64)
            .prop_map(|(length, r)| Molecule::wall_without_ends(length * DVec2::X, r).unwrap());
        prop_oneof![2 => wall, 1 => across, 1 => bodies()]
    }

    fn drives() -> impl Strategy<Value = Drive> {
        let vector = (-1.0..1.0f64, -1.0..1.0f64).prop_map(DVec2::from);
        let turns = (-0.5..0.5f64).prop_map(Orientation::from_turns);
        let oscillation = (vector.clone(), 0.3..20.0f64, turns)
            .prop_map(|(a, frequency, phase)| Drive::oscillation(0.3 * a, frequency, phase));
        prop_oneof![vector.prop_map(Drive::acceleration), oscillation]
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: ProptestConfig::default().cases.max(600), max_global_rejects: 1 << 20, ..ProptestConfig::default() })]

        /// Nothing overlaps before the contact, and at the contact the gap is 0 to rounding.
        #[test]
        fn driven_bodies_touch_first_where_their_gap_is_zero(
            a in bodies(), b in fixed_bodies(), drive in drives(), x in -2.0..2.0f64, y in -2.0..2.0f64,
            velocity in (-1.0..1.0f64, -1.0..1.0f64), turns in prop::array::uniform2(-0.5..0.5f64),
            spin in prop_oneof![Just(0.0), -1.0..1.0f64, -20.0..20.0f64], from in 0.0..3.0f64,
        ) {
            let spins = [spin, 0.0];
            let motion = RelativeMotion {
                orientation: turns.map(Orientation::from_turns),
                angular_velocity: spins,
                ..RelativeMotion::exactly(DVec2::new(x, y), velocity.into())
            };
            let gap = |t: f64| {
                let there = motion.driven(&drive, from, t).0;
                let [to_a, to_b] = there.orientation.map(Orientation::cos_sin);
                gap_between(&a, to_a, &b, to_b, there.separation)
            };
            prop_assume!(gap(0.0) > 1e-9);
            let horizon = 3.0;
            let find = |bodies: [&Molecule; 2], motion: &RelativeMotion, drive: &Drive| {
                let bodies = bodies.map(Molecule::outline);
                Exact::default().first_contact_driven(0.0, bodies, motion, (drive, from), horizon)
            };
            let answer = find([&a, &b], &motion, &drive);
            let arms = [&a, &b].map(|body| 2.0 * body.bounding_radius());
            let turned = spins[0].abs() * arms[0];
            let allowed = |time: f64| {
                2.0 * f64::EPSILON
                    * (60.0 + 34.0 * (arms[0] + arms[1]) + (54.0 + 4.0 * turned) * (1.0 + time)
                        + 20.0 * drive.max_speed(6.0))
            };
            let samples = Samples { count: 2000, depth: 1e-13 };
            is_first_zero(answer.outcome, horizon, gap, allowed, &samples)?;
            prop_assert!(answer.evaluations < 3000, "{}", answer.evaluations);
            // Exchanging the bodies changes no bit of the time.
            let exchanged = find([&b, &a], &motion.exchanged(), &-drive);
            let time = |answer: Answer| answer.outcome.contact().map(|contact| contact.time);
            prop_assert_eq!(time(answer), time(exchanged));
        }
    }

    #[test]
    fn a_ball_falls_onto_the_ground_at_the_time_of_the_parabola() {
        let ball = Molecule::disc(0.25, 1.0).unwrap();
        let ground = Molecule::wall_without_ends(8.0 * DVec2::X, 0.0).unwrap();
        // The ground rises with 2 in the falling frame: 1.25 − 0.25 = v t + t².
        let drive = Drive::acceleration(DVec2::new(0.0, -2.0));
        for velocity in [-0.5, 0.0, 0.25, 3.0] {
            let motion = RelativeMotion::exactly(DVec2::new(0.3, 1.25), DVec2::new(0.1, velocity));
            let bodies = [ground.outline(), ball.outline()];
            let answer =
                Exact::default().first_contact_driven(0.0, bodies, &motion, (&drive, 0.0), 9.0);
            let time = answer.outcome.contact().expect("it falls").time;
            let expected = 0.5 * (velocity + f64::sqrt(velocity * velocity + 4.0));
            assert!((time - expected).abs() < 2e-15, "{time} {expected}");
            assert!(answer.evaluations <= 6, "{}", answer.evaluations);
        }
    }

    /// A wall that oscillates along itself at 10⁴ times the speed of a disc above it: the search
    /// sees only the motion across.
    #[test]
    fn a_fast_oscillation_of_a_wall_along_itself_shortens_no_step() {
        let disc = Molecule::disc(0.25, 1.0).unwrap();
        let wall = Molecule::wall_without_ends(8.0 * DVec2::X, 0.0).unwrap();
        let drive = Drive::oscillation(0.01 * DVec2::X, 1e6, Orientation::default());
        let [_, along] = drive.oscillation_now();
        let find = |velocity: f64| {
            let separation = DVec2::new(0.3, 0.25 + 1e-9);
            let motion = RelativeMotion::exactly(separation, DVec2::new(0.0, velocity) - along);
            let bodies = [wall.outline(), disc.outline()];
            Exact::default().first_contact_driven(0.0, bodies, &motion, (&-drive, 0.0), 8e-6)
        };
        let leaves = find(1e-3);
        assert!(
            leaves.outcome.contact().is_none() && leaves.evaluations < 50,
            "{leaves:?}"
        );
        let falls = find(-1e-3);
        let time = falls.outcome.contact().expect("it falls").time;
        assert!(
            (time - 1e-6).abs() < 1e-12 && falls.evaluations < 50,
            "{falls:?}"
        );
    }
}
