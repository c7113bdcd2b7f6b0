//! The gap between a convex part and a straight edge in flight, of which both may turn.
//!
//! # Lemmas
//! In the notation of [`edge_pair`](crate::edge_pair), for a part P with the support function h and
//! an edge of body Q with its round ends; D leads from the centre of Q to that of the part, and r
//! is its arm. f(n) = n·D − h_Q(n) − h(−n).
//!
//! 1. **Certificate.** For a direction n that turns with Q, h_Q(n) is constant, also where it has a
//!    kink. f(n(t), t) ≤ g(t), as in [`support_pair`](crate::support_pair).
//! 2. **Derivatives.** f' = n·D' + ω_Q n^⊥·D − (ω_Q − ω_P) h' and f'' = −ω_P² n·r + 2 ω_Q n^⊥·D' −
//!    ω_Q² n·D − (ω_Q − ω_P)² h''.
//! 3. **Bounds.** With M and H that bound h'' and |h'''|, K is that of an atom plus (ω_P − ω_Q)² M,
//!    and K₃ that of an atom plus |ω_P − ω_Q|³ H. *Proof.* As there, in the frame of Q.
//! 4. **A line that cuts the part.** There the nearest point of the part can lie beside the edge
//!    though the part cuts the line beyond its end. Where f of the normal does not certify, the
//!    directions from both ends are therefore tried.
//! 5. **Lines.** A wall across the box has no ends, and n is its normal everywhere. Of its images,
//!    which lie on one line, a contact is that of the image that the point of contact is in; at the
//!    border of two it may be that of both, at the same time to rounding.
//! 6. **Ends.** Where the best direction comes from an end, it is not that of the greatest f, but
//!    is off by at most δ = √(E/32 F), so that f' is off by δ times its greatest derivative. The
//!    end lies in an atom, whose contact is found by itself.

use carom_geometry::{Circle, Edge, EdgeTangents, Ellipse, FacingEdge, FacingParts, Support};
use carom_kinematics::HALF_ULP as U;
use glam::DVec2;

use crate::{
    EdgeErrorBound, SearchWindow,
    error_bound::one_norm,
    flight::{Flight, Pose},
    gap_search::{Gap, GapFunction},
    safe_step::{Curvature, safe_step},
    search::{PairOutcome, Search},
    skim,
    strip::Strip,
    support_pair::MIN_ORBIT,
    tolerance::FAST_ROTOR,
    trace::Recorder,
};

/// A convex part of one body and an edge of the other.
pub(crate) struct SupportEdgePair<'a, P> {
    flight: &'a Flight<'a>,
    /// The number of the body with the part (0 for A, 1 for B).
    body: usize,
    part: &'a P,
    offset: DVec2,
    /// r
    arm: f64,
    edge: &'a Edge,
    /// ω_P and ω_Q
    spins: [f64; 2],
    /// The largest distance of the centres of mass in contact.
    reach: f64,
    largest: f64,
    jerk: f64,
    /// A bound on the sum of the magnitudes of all terms of f''.
    terms: f64,
    error: EdgeErrorBound,
}

/// The part and the edge at one time, and the tangents at which they are nearest.
#[derive(Clone, Copy)]
pub(crate) struct SupportEdgePose {
    at: Pose,
    arm: DVec2,
    /// D
    d: DVec2,
    pub(crate) facing: EdgeTangents,
}

impl<'a, P: Support> SupportEdgePair<'a, P> {
    /// A part of body number `body`, with its centre at this offset from the centre of mass.
    pub(crate) fn new(
        flight: &'a Flight<'a>,
        body: usize,
        part: &'a P,
        offset: DVec2,
        edge: &'a Edge,
    ) -> Self {
        Self::within(flight, body, part, offset, edge, 0.0)
    }

    /// The pair while the centres of mass are at most this length, or the largest one in contact,
    /// apart.
    pub(crate) fn within(
        flight: &'a Flight<'a>,
        body: usize,
        part: &'a P,
        offset: DVec2,
        edge: &'a Edge,
        reach: f64,
    ) -> Self {
        let spins = [flight.spin[body], flight.spin[1 - body]];
        let arm = offset.length();
        let reach = reach.max(edge.reach() + edge.radius() + arm + part.reach());
        let circle = Circle {
            offset,
            // Each point turns about the centre of mass; twice the size covers the roundings of h.
            arm: arm + 2.0 * part.reach(),
            radius: 0.0,
        };
        let error = EdgeErrorBound::within(flight.motion, body, flight.spin, reach, &circle, edge);
        let [spin, fast] = spins.map(f64::abs);
        let way = if fast == 0.0 {
            0.0
        } else {
            let lengths = one_norm(flight.motion.separation) + circle.arm + reach;
            reach + 2.0 * (error.at(0.0) + 16.0 * U * lengths)
        };
        let apart = (spins[0] - spins[1]).abs();
        let of_centre = fast * (fast * way + 2.0 * flight.speed);
        Self {
            flight,
            body,
            part,
            offset,
            arm,
            edge,
            spins,
            reach,
            largest: of_centre + apart * apart * (arm + part.max_bend()),
            jerk: fast * fast * (fast * way + 3.0 * flight.speed)
                + apart * apart * apart * (arm + part.max_third()),
            terms: spin * spin * arm
                + 2.0 * fast * (flight.speed + spin * arm)
                + fast * fast * (way + arm)
                + apart * apart * (part.reach() + part.max_bend()),
            error,
        }
    }

    /// The first contact from `begin` to `limit`; there must be none before `begin`.
    pub(crate) fn first_contact_from<R: Recorder>(
        &self,
        begin: f64,
        limit: f64,
        search: &mut Search<R>,
    ) -> PairOutcome {
        let window = if self.spins[1] == 0.0 {
            let room = self.arm + self.part.reach();
            Strip::window(self.flight.motion, self.body, self.edge, room, limit)
        } else {
            skim(self.flight.motion, self.reach, limit)
        };
        let Some(SearchWindow { begin: enters, end }) = window else {
            return PairOutcome::Free;
        };
        let begin = enters.max(begin);
        if begin > end {
            return PairOutcome::Free;
        }
        let outcome = self.first_contact(begin, [f64::INFINITY, end], &mut 0, search);
        match outcome {
            PairOutcome::Contact(time) if !self.is_in_image(time) => PairOutcome::Free,
            _ => outcome,
        }
    }

    /// Whether the point that touches a line at this time is within the image of the wall that the
    /// edge is; elsewhere the part touches the next image, to rounding at the same time.
    pub(crate) fn is_in_image(&self, time: f64) -> bool {
        !self.edge.is_line() || self.pose(time).facing.beyond <= self.error.at(time)
    }

    /// The position of P's centre relative to that of Q, or its velocity.
    fn seen_by_edge(&self, vector: DVec2) -> DVec2 {
        if self.body == 1 { vector } else { -vector }
    }

    fn rotations(&self, at: &Pose) -> [DVec2; 2] {
        [self.body, 1 - self.body].map(|body| at.arm(body, DVec2::X))
    }

    fn velocity_of(&self, arm: DVec2) -> DVec2 {
        self.seen_by_edge(self.flight.motion.velocity) + self.spins[0] * arm.perp()
    }

    /// The step against the circle about the centre of P in which the part stays.
    #[cold]
    fn step_of_orbiting_part(&self, pose: &SupportEdgePose) -> f64 {
        let circle = Ellipse::round(self.arm + self.part.reach());
        let d = pose.d - pose.arm;
        let error = self.error.at(pose.at.time);
        let facing = FacingEdge {
            part: &circle,
            edge: self.edge,
            rotations: self.rotations(&pose.at),
            d,
        };
        let found = facing.across(pose.facing.normal);
        let gap = found.gap - error;
        if gap > 0.0 {
            let spin = self.spins[1];
            let rate = found.normal.dot(self.velocity_of(DVec2::ZERO))
                + spin * found.normal.perp().dot(d)
                - self.error.of_rate(pose.at.time);
            let fast = spin.abs();
            let bend = fast * (fast * 2.0 * self.reach + 2.0 * self.flight.speed);
            safe_step(gap, rate, &Curvature::at_most(bend))
        } else {
            0.0
        }
    }

    /// The step against the circle about the centre of Q in which the edge stays.
    #[cold]
    fn step_of_orbiting_edge(&self, pose: &SupportEdgePose) -> f64 {
        let circle = Ellipse::round(self.edge.reach() + self.edge.radius());
        let error = self.error.at(pose.at.time);
        let facing = FacingParts {
            a: &circle,
            b: self.part,
            rotations: [DVec2::X, self.rotations(&pose.at)[0]],
            d: pose.d,
        };
        let found = facing.across(facing.towards());
        let gap = found.gap - error;
        if gap > 0.0 {
            let spin = self.spins[0];
            let rate = found.normal.dot(self.velocity_of(pose.arm)) + spin * found.points[1].slope
                - self.error.of_rate(pose.at.time);
            let bend = spin * spin * (self.arm + self.part.max_bend());
            safe_step(gap, rate, &Curvature::at_most(bend))
        } else {
            0.0
        }
    }
}

impl<P: Support> GapFunction for SupportEdgePair<'_, P> {
    type Pose = SupportEdgePose;

    fn pose(&self, time: f64) -> SupportEdgePose {
        let at = self.flight.at(time);
        let arm = at.arm(self.body, self.offset);
        let d = self.seen_by_edge(at.separation) + arm;
        let facing = FacingEdge {
            part: self.part,
            edge: self.edge,
            rotations: self.rotations(&at),
            d,
        };
        let facing = facing.farthest(self.error.at(time));
        SupportEdgePose { at, arm, d, facing }
    }

    fn gap(&self, pose: &SupportEdgePose) -> Gap {
        let [spin, turn] = self.spins;
        let EdgeTangents {
            normal,
            gap,
            point,
            is_beside,
            ..
        } = pose.facing;
        let (time, tangent) = (pose.at.time, normal.perp());
        let velocity = self.velocity_of(pose.arm);
        let apart = turn - spin;
        let rate = normal.dot(velocity) + turn * tangent.dot(pose.d) - apart * point.slope;
        let second = turn * (2.0 * tangent.dot(velocity) - turn * normal.dot(pose.d))
            - (spin * spin) * normal.dot(pose.arm)
            - (apart * apart) * point.bend();
        let (error, mut rate_error) = (self.error.at(time), self.error.of_rate(time));
        if !is_beside {
            let stiffness = gap + point.curvature_radius + self.edge.radius();
            let off = (error / (32.0 * stiffness)).sqrt().min(1.0);
            let steepest = self.error.speed() + apart.abs() * self.part.max_bend();
            rate_error += if stiffness > 0.0 {
                off * steepest
            } else {
                steepest
            };
        }
        let motion = self.flight.motion;
        let both = spin.abs() + turn.abs();
        let angles = motion.orientation_error[0] + motion.orientation_error[1];
        let second_error = self.terms * 32.0 * U
            + (self.terms + apart * apart * self.part.max_third())
                * (angles + 4.0 * U * (both * time + 4.0))
            + both * both * error
            + 2.0 * turn.abs() * motion.velocity_error;
        let least = second - second_error;
        Gap {
            value: gap,
            rate,
            second,
            slowness: 1.0 / (rate_error - rate),
            error,
            rate_error,
            curvature: Curvature {
                along_normal: least,
                jerk: self.jerk,
                of_gap: least,
                gap_jerk: self.jerk,
                // |h''| is at most M, or the size of the part where R is small.
                upwards: self.largest + apart * apart * self.part.reach(),
                ..Curvature::at_most(self.largest)
            },
        }
    }

    fn top_speed(&self) -> f64 {
        self.error.speed()
    }

    fn size(&self) -> f64 {
        self.arm + self.part.reach()
    }

    fn other_step(&self, pose: &SupportEdgePose) -> f64 {
        let [spin, turn] = self.spins.map(f64::abs);
        let speed = self.flight.speed;
        let mut step: f64 = 0.0;
        let rim = spin * (self.arm + self.part.reach());
        if rim > MIN_ORBIT * FAST_ROTOR * (speed + turn * self.edge.reach()) {
            step = step.max(self.step_of_orbiting_part(pose));
        }
        if turn > 0.0 && turn * self.edge.reach() > MIN_ORBIT * FAST_ROTOR * (speed + rim) {
            step = step.max(self.step_of_orbiting_edge(pose));
        }
        step
    }

    /// Whether the part stays beside the edge.
    fn stays(&self, pose: &SupportEdgePose, duration: f64) -> bool {
        let apart = (self.spins[0] - self.spins[1]).abs();
        let size = self.part.reach() + self.part.max_bend();
        let way = 2.0 * duration * (self.error.speed() + apart * size);
        let EdgeTangents {
            is_beside, beyond, ..
        } = pose.facing;
        self.edge.is_line() || (is_beside && beyond + self.error.at(pose.at.time) + way <= 0.0)
    }

    /// Always `time`: the window of the search already covers all times within reach.
    fn within_reach(&self, time: f64, _: f64) -> Option<f64> {
        Some(time)
    }
}
