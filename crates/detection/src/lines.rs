//! Separating lines: as long as all corners of one body are in front of a side of the convex hull
//! of the other, the bodies do not touch.
//!
//! # Lemmas
//! Let a line with the outward normal n be fixed in body Q, which lies behind it. y_i is the
//! distance of corner i of body P (an atom, with its radius) from the line.
//!
//! 1. **Line.** While all y_i > 0 the bodies do not touch. *Proof.* P lies in the convex hull of
//!    its atoms, in front of the line, Q behind it.
//! 2. **Corner.** While y_i > 0, corner i touches nothing of Q, and neither does an edge of P whose
//!    two ends are such corners. Before the first corner crosses, nothing touches.
//! 3. **Motion.** y_i is n·D less a constant, as for a corner and an edge: K, K₃ and the rounding
//!    are those of [`edge_pair`](crate::edge_pair), with the bounding radii for arm and reach. In
//!    the frame of Q its second derivative is n·(−ω_Q² X − 2 ω_Q V^⊥) − (ω_P − ω_Q)² n·r_i, so that
//!    one rotated normal serves all corners.
//! 4. **Contact.** If the line is the surface of an edge of Q, the first corner to cross it touches
//!    Q where it crosses beside the edge. Nothing touches earlier (Lemma 2). If it crosses the line
//!    beyond an end, the bodies are apart up to that time, and another line may separate them then.
//! 5. **Rounding.** A contact found in this way has |y_i| ≤ 2 E, with E of the line. Another pair
//!    of parts may have a smaller E, and touch before by more than 2 E of its own, if the corner is
//!    near an end of the edge or another corner near the line: then all parts of the corner are
//!    searched from a time on at which it is still in front of the line.
//! 6. **Rotors.** A crossing must be searched without the orbits of fast rotors, which may carry a
//!    corner across the line where it is no contact.
//!
//! Any line is a certificate; that with the largest distance of the nearest corner is taken.
//! Corners that are behind it already, since none separates the bodies, are searched against all
//! parts of the other body, the others from the time of their crossing on.

use carom_geometry::{Atom, Circle, Edge, HullSide, Outline};
use carom_kinematics::HALF_ULP as U;
use glam::DVec2;
use smallvec::SmallVec;

use crate::{
    EdgeErrorBound, Part, Parts, Phase, SearchWindow, Touch,
    atom_pair::{AtomPair, centripetal, or_none},
    edge_pair::EdgePair,
    flight::{Flight, Pose},
    gap_search::GapFunction,
    safe_step::{Curvature, safe_step},
    search::{PairOutcome, Search},
    skimming::rounding_within,
    tolerance::{FEW_PAIRS, MAX_LINES, NEAR_LINE, NEAR_OTHERS},
    trace::Recorder,
};

/// What separating lines certify.
pub(crate) enum Separation {
    /// The first contact is recorded, or there is none up to the limit of the search.
    Decided,
    /// The bodies do not touch before this time, at which no line separates them.
    Until(f64),
}

/// The corners of one body against the lines of the other.
struct LineSearch<'a> {
    flight: &'a Flight<'a>,
    outlines: [Outline<'a>; 2],
    /// Radii of circles about the centres of mass inside the convex hulls (length).
    inner_radii: [f64; 2],
    /// For the corners of body 0 and of body 1.
    bounds: [Bounds; 2],
}

/// Bounds for all corners of one body against all lines of the other.
#[derive(Clone, Copy)]
struct Bounds {
    error: EdgeErrorBound,
    /// The part of K without the arm of the corner, and of K₃.
    of_line: f64,
    jerk_of_line: f64,
    /// |ω_P − ω_Q|
    apart: f64,
    /// A bound on the sum of the magnitudes of all terms of y''.
    terms: f64,
}

/// A line at one time, relative to the corners of the other body.
struct LineAtTime {
    /// The body with the corners.
    body: usize,
    side: HullSide,
    /// The normal in the frame of the body with the corners.
    normal: DVec2,
    /// y, y' and y'' of its centre of mass as a corner without radius.
    centre: [f64; 3],
}

/// The state of the search for the crossing of a corner and a line.
#[derive(Clone, Copy, PartialEq)]
enum CornerState {
    NotBefore,
    Beside,
    BeyondTheEnd,
    OutOfBudget,
    /// It touches the edge soon after this time, as other parts may.
    AmongOthers,
    /// All pairs of parts to which the corner belongs are searched.
    Opened,
}

/// The result for one line.
enum LineOutcome {
    /// The bodies are apart until this later time, where another line may separate them.
    Apart(f64),
    /// The bodies are apart until this time, from which on all parts are to be searched.
    Unclear(f64),
    /// The search is decided: the first corner to cross the line touches the edge, or what lies
    /// behind the line was searched, or no corner crosses it up to the limit.
    Decided,
}

/// Searches two bodies of which at least one has sides by separating lines.
pub(crate) fn separate<R: Recorder>(
    a: Outline<'_>,
    b: Outline<'_>,
    flight: &Flight<'_>,
    window: SearchWindow,
    search: &mut Search<R>,
) -> Separation {
    let lines = LineSearch {
        flight,
        outlines: [a, b],
        inner_radii: [a, b].map(inner_radius),
        bounds: [0, 1].map(|body| Bounds::new(flight, body, [a, b])),
    };
    let mut time = window.begin;
    for _ in 0..MAX_LINES {
        if time > search.limit() {
            return Separation::Decided;
        }
        let at = flight.at(time);
        search.evaluations += 1;
        let Some(sight) = lines.best(&at) else {
            return Separation::Until(time);
        };
        let verdict = lines.first_to_cross(&sight, &at, search);
        let until = match verdict {
            LineOutcome::Apart(until) | LineOutcome::Unclear(until) => until,
            LineOutcome::Decided => search.limit(),
        };
        search.recorder.concerns(|| all_parts(a, b));
        search.recorder.step(Phase::Shared, time, Some(until));
        match verdict {
            LineOutcome::Apart(_) => time = until,
            LineOutcome::Decided => return Separation::Decided,
            LineOutcome::Unclear(_) => return Separation::Until(until),
        }
    }
    Separation::Until(time)
}

fn all_parts(a: Outline<'_>, b: Outline<'_>) -> Parts {
    Parts::Circles([a, b].map(|outline| (0..outline.atoms.len() as u32).collect()))
}

/// The other end of an edge that ends at an atom.
fn other_end(edge: &Edge, atom: u32) -> Option<u32> {
    match edge.ends()? {
        [first, second] if first == atom => Some(second),
        [first, second] if second == atom => Some(first),
        _ => None,
    }
}

/// The radius of a circle about the centre of mass inside the convex hull (length).
///
/// The hull of the centres, widened by the least radius, lies in that of the atoms; each side is
/// moved outwards from it by at most the largest radius.
fn inner_radius(body: Outline<'_>) -> f64 {
    let distances = body.sides().iter().map(|side| side.distance);
    let nearest = distances.fold(f64::INFINITY, f64::min);
    let radii = || body.atoms.iter().map(Atom::radius);
    let (least, largest) = (
        radii().fold(f64::INFINITY, f64::min),
        radii().fold(0.0, f64::max),
    );
    // A disc, or a union of discs, has no sides.
    if nearest < f64::INFINITY {
        nearest - (largest - least)
    } else {
        0.0
    }
}

impl Bounds {
    fn new(flight: &Flight<'_>, body: usize, outlines: [Outline<'_>; 2]) -> Self {
        let radii = outlines.map(|outline| outline.bounding_radius);
        let (spin, spin_of_line) = (flight.spin[body], flight.spin[1 - body]);
        let (apart, fast) = ((spin - spin_of_line).abs(), spin_of_line.abs());
        // The window of the bounding circles is rounded outwards.
        let reach = radii[0] + radii[1];
        let reach = reach + 2.0 * rounding_within(flight.motion, reach);
        let arm = radii[body];
        Self {
            error: EdgeErrorBound::of_bodies(flight.motion, body, flight.spin, radii),
            of_line: centripetal(fast, reach) + 2.0 * fast * flight.speed,
            jerk_of_line: fast * fast * (fast * reach + 3.0 * flight.speed),
            apart,
            terms: centripetal(apart, arm) + 2.0 * fast * flight.speed + fast * fast * reach,
        }
    }

    /// Bounds on the curvature of y_i for a corner on this arm with this y_i''.
    fn curvature(&self, at: &Pose, flight: &Flight<'_>, arm: f64, second: f64) -> Curvature {
        let error = self.error.at(at.time);
        let of_corner = centripetal(self.apart, arm);
        let largest = self.of_line + of_corner;
        let motion = flight.motion;
        let both = flight.spin[0].abs() + flight.spin[1].abs();
        // The normal is turned with both bodies.
        let tilt =
            motion.orientation_error[0] + motion.orientation_error[1] + 4.0 * U * (both * at.time);
        let second_error = self.terms * (32.0 * U + tilt)
            + both * both * error
            + 2.0 * both * motion.velocity_error;
        let least = second - second_error;
        let jerk = or_none(self.jerk_of_line + self.apart * of_corner, largest > 0.0);
        Curvature {
            along_normal: least,
            of_gap: least,
            jerk,
            gap_jerk: jerk,
            ..Curvature::at_most(largest)
        }
    }
}

impl LineSearch<'_> {
    /// The line with the largest distance of the nearest corner.
    fn best(&self, at: &Pose) -> Option<LineAtTime> {
        let mut best: Option<(usize, HullSide)> = None;
        let mut least = f64::NEG_INFINITY;
        // Of equal distances the same one for exchanged bodies.
        let is_ahead = at.separation.x > 0.0 || (at.separation.x == 0.0 && at.separation.y > 0.0);
        let first = usize::from(is_ahead);
        for body in [first, 1 - first] {
            let sides = self.outlines[1 - body].sides();
            let to_corners = if body == 1 {
                at.separation
            } else {
                -at.separation
            };
            let place = at.in_frame_of(1 - body, to_corners);
            let of_centre = |side: &HullSide| side.normal.dot(place) - side.distance;
            // Mostly the side that faces the other centre.
            let facing = sides
                .iter()
                .max_by(|one, other| of_centre(one).total_cmp(&of_centre(other)));
            for side in facing.into_iter().chain(sides) {
                // The nearest corner is nearer than the centre by at least this.
                let most = of_centre(side) - self.inner_radii[body];
                if most <= least {
                    continue;
                }
                let normal = at.in_frame_of(body, at.arm(1 - body, side.normal));
                let distance = of_centre(side) + self.nearest(body, normal);
                if distance > least {
                    (best, least) = (Some((body, *side)), distance);
                }
            }
        }
        best.map(|(body, side)| self.sight(body, side, at))
    }

    /// The least distance of a corner of a body, in a direction of its frame, from its centre of
    /// mass (length, negative).
    fn nearest(&self, body: usize, normal: DVec2) -> f64 {
        self.outlines[body]
            .atoms
            .iter()
            .map(|atom| normal.dot(atom.offset()) - atom.radius())
            .fold(f64::INFINITY, |least, y| if y < least { y } else { least })
    }

    fn sight(&self, body: usize, side: HullSide, at: &Pose) -> LineAtTime {
        let spin_of_line = self.flight.spin[1 - body];
        let normal = at.arm(1 - body, side.normal);
        let sign = if body == 1 { 1.0 } else { -1.0 };
        let place = sign * at.separation;
        let velocity = sign * self.flight.motion.velocity;
        let turned = 2.0 * velocity.perp() + spin_of_line * place;
        LineAtTime {
            body,
            side,
            normal: at.in_frame_of(body, normal),
            centre: [
                normal.dot(place) - side.distance,
                normal.dot(velocity - spin_of_line * place.perp()),
                -spin_of_line * normal.dot(turned),
            ],
        }
    }

    /// Follows the corners up to the first that crosses the line.
    ///
    /// A corner that is behind the line already may touch any part: it is opened, unless the bodies
    /// have so few parts that all of them are searched at once.
    fn first_to_cross<R: Recorder>(
        &self,
        sight: &LineAtTime,
        at: &Pose,
        search: &mut Search<R>,
    ) -> LineOutcome {
        let mut corners = self.not_before(sight, at);
        let mut has_opened = false;
        loop {
            let soonest = corners.iter().enumerate();
            let soonest = soonest.min_by(|one, other| one.1.0.total_cmp(&other.1.0));
            let Some((index, &(bound, known))) = soonest else {
                return LineOutcome::Decided;
            };
            if bound > search.limit() {
                return LineOutcome::Decided;
            }
            let may_restart = bound > at.time && !has_opened;
            let edge = sight.side.edge.filter(|_| self.is_before(sight, at, index));
            corners[index] = match (known, edge) {
                (CornerState::Beside | CornerState::OutOfBudget, _) => return LineOutcome::Decided,
                (CornerState::BeyondTheEnd, _) if may_restart => return LineOutcome::Apart(bound),
                (CornerState::NotBefore, _) if may_restart && self.is_far(sight, at, index) => {
                    return LineOutcome::Apart(bound);
                }
                (CornerState::NotBefore, Some(edge)) => {
                    self.crossing(sight, index, edge, bound, search)
                }
                _ if !has_opened && self.has_few_parts() => return LineOutcome::Unclear(bound),
                _ => {
                    has_opened = true;
                    self.open(sight, index, bound, &corners, search);
                    (f64::INFINITY, CornerState::Opened)
                }
            };
        }
    }

    fn has_few_parts(&self) -> bool {
        let [a, b] = self.outlines.map(|outline| outline.atoms.len());
        a * b <= FEW_PAIRS
    }

    /// Whether a corner is in front of the line or touches it, so that its crossing can be
    /// searched.
    fn is_before(&self, sight: &LineAtTime, at: &Pose, index: usize) -> bool {
        let atom = &self.outlines[sight.body].atoms[index];
        let (y, ..) = self.corner(sight, atom.offset());
        y - atom.radius() >= -self.bounds[sight.body].error.at(at.time)
    }

    /// Searches a corner against all parts of the other body, and the edges that end at it against
    /// all corners of the other, from `begin` on.
    fn open<R: Recorder>(
        &self,
        sight: &LineAtTime,
        index: usize,
        begin: f64,
        corners: &[(f64, CornerState)],
        search: &mut Search<R>,
    ) {
        let (own, other) = (sight.body, 1 - sight.body);
        let [own_outline, other_outline] = [own, other].map(|body| self.outlines[body]);
        let corner = Circle::from(&own_outline.atoms[index]);
        let mut beside = |body: usize, atom: (u32, Circle), edge: (u32, &Edge)| {
            let touch = Touch::edge(body, edge.0, Part::Atom(atom.0));
            search.recorder.concerns(|| Parts::Pair(touch));
            let pair = EdgePair::new(self.flight, body, atom.1, edge.1);
            let outcome = pair.first_contact_in_span(begin, search.limit(), search);
            search.record_touch(outcome, touch);
        };
        for edge in (0..).zip(other_outline.edges()) {
            beside(own, (index as u32, corner), edge);
        }
        for edge in (0..).zip(own_outline.edges()) {
            let Some(end) = other_end(edge.1, index as u32) else {
                continue;
            };
            // Searched from an earlier time on, when its other end was opened.
            if corners[end as usize].1 == CornerState::Opened {
                continue;
            }
            for (number, atom) in (0..).zip(other_outline.atoms) {
                beside(other, (number, atom.into()), edge);
            }
        }
        for (number, atom) in (0..).zip(other_outline.atoms) {
            let (mut circles, mut atoms) = ([corner; 2], [index as u32; 2]);
            (circles[other], atoms[other]) = (atom.into(), number);
            search
                .recorder
                .concerns(|| Parts::Pair(Touch::Atoms(atoms[0], atoms[1])));
            let pair = AtomPair::new(self.flight, circles);
            let limit = search.limit();
            if begin <= limit {
                let outcome = pair.first_contact(begin, [f64::INFINITY, limit], &mut 0, search);
                search.record(outcome, atoms);
            }
        }
    }

    /// Times at which the corners cross the line at the earliest.
    fn not_before(&self, sight: &LineAtTime, at: &Pose) -> SmallVec<[(f64, CornerState); 16]> {
        let bounds = &self.bounds[sight.body];
        let (error, rate_error) = (bounds.error.at(at.time), bounds.error.of_rate(at.time));
        let atoms = self.outlines[sight.body].atoms.iter();
        let bound = atoms.map(|atom| {
            let (y, rate, second) = self.corner(sight, atom.offset());
            let gap = y - atom.radius() - error;
            let time = if gap > 0.0 {
                let curvature = bounds.curvature(at, self.flight, atom.arm(), second);
                at.time + safe_step(gap, rate - rate_error, &curvature)
            } else {
                at.time
            };
            (time, CornerState::NotBefore)
        });
        bound.collect()
    }

    /// y_i without the radius, y_i' and y_i'' of a corner.
    fn corner(&self, sight: &LineAtTime, offset: DVec2) -> (f64, f64, f64) {
        let [y, rate, second] = sight.centre;
        let apart = self.flight.spin[sight.body] - self.flight.spin[1 - sight.body];
        let along = sight.normal.dot(offset);
        (
            y + along,
            rate + apart * sight.normal.dot(offset.perp()),
            second - apart * apart * along,
        )
    }

    /// Whether a corner is so far from the line that a step is worth more than a search.
    fn is_far(&self, sight: &LineAtTime, at: &Pose, index: usize) -> bool {
        let atom = &self.outlines[sight.body].atoms[index];
        let (y, rate, _) = self.corner(sight, atom.offset());
        let bounds = &self.bounds[sight.body];
        let gap = y - atom.radius() - bounds.error.at(at.time);
        // A corner that falls faster than this crosses the line in any case.
        let curvature = bounds.of_line + centripetal(bounds.apart, atom.arm());
        let crosses = rate < 0.0 && rate * rate > 2.0 * curvature * gap;
        let radii = self.outlines.map(|outline| outline.bounding_radius);
        !crosses && gap > NEAR_LINE * (radii[0] + radii[1])
    }

    /// A time before the contact of a corner and an edge at which it is certainly apart, if another
    /// pair of parts may touch so soon before that its own, smaller bound on the rounding decides:
    /// near an end of the edge, or with another corner at the line.
    fn just_before_others(
        &self,
        sight: &LineAtTime,
        index: usize,
        edge: u32,
        time: f64,
    ) -> Option<f64> {
        let (body, other) = (sight.body, 1 - sight.body);
        let at = self.flight.at(time);
        let now = self.sight(body, sight.side, &at);
        let radii = self.outlines.map(|outline| outline.bounding_radius);
        let near = NEAR_OTHERS * (radii[0] + radii[1]);
        let atoms = self.outlines[body].atoms;
        let is_at_line = |atom: &Atom| self.corner(&now, atom.offset()).0 - atom.radius() < near;
        let edge = &self.outlines[other].edges()[edge as usize];
        let to_corners = if body == 1 {
            at.separation
        } else {
            -at.separation
        };
        let place = at.in_frame_of(other, to_corners + at.arm(body, atoms[index].offset()));
        let along = edge.along().dot(place - edge.middle()).abs();
        let is_alone = atoms.iter().filter(|atom| is_at_line(atom)).count() < 2;
        if is_alone && along < edge.half_length() - near {
            return None;
        }
        let (_, rate, _) = self.corner(&now, atoms[index].offset());
        let bounds = &self.bounds[body];
        let closing = (-rate).max(bounds.error.of_rate(time));
        Some(time - 4.0 * bounds.error.at(time) / closing)
    }

    /// Searches the crossing of one corner and the line of an edge; a contact is recorded.
    fn crossing<R: Recorder>(
        &self,
        sight: &LineAtTime,
        index: usize,
        edge: u32,
        begin: f64,
        search: &mut Search<R>,
    ) -> (f64, CornerState) {
        let (body, outlines) = (sight.body, &self.outlines);
        let line = &outlines[1 - body].edges()[edge as usize];
        let radii = outlines.map(|outline| outline.bounding_radius);
        let atom = Circle::from(&outlines[body].atoms[index]);
        let pair = EdgePair::of_line(self.flight, body, atom, line, radii);
        let touch = Touch::edge(body, edge, Part::Atom(index as u32));
        search.recorder.concerns(|| Parts::Pair(touch));
        let limit = search.limit();
        let (outcome, is_beside) = pair.first_crossing(begin, limit, search);
        match outcome {
            PairOutcome::Contact(time) if is_beside => {
                if let Some(before) = self.just_before_others(sight, index, edge, time) {
                    return (before.max(begin), CornerState::AmongOthers);
                }
                search.record_touch(outcome, touch);
                (time, CornerState::Beside)
            }
            PairOutcome::Contact(time) => (time, CornerState::BeyondTheEnd),
            PairOutcome::OutOfBudget(time) => {
                search.record_touch(outcome, touch);
                (time, CornerState::OutOfBudget)
            }
            PairOutcome::Free | PairOutcome::Paused(_) => {
                search.recorder.step(Phase::Shared, begin, Some(limit));
                (f64::INFINITY, CornerState::NotBefore)
            }
        }
    }
}
