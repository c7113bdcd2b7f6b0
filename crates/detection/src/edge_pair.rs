//! The gap between an atom in flight and a straight edge, of which both may turn.
//!
//! # Lemmas
//! In the notation of [`gap_search`](crate::gap_search): the atom of body P has the arm r and the
//! angular velocity ω_P, the edge of body Q has the normal n, the direction e and the middle m,
//! which turn with ω_Q. D = X + V t + r leads from the centre of Q to the atom. y = n·(D − m) and x
//! = e·(D − m) are its coordinates in the frame of the edge, half of whose length is ℓ.
//!
//! 1. **Gap.** Between the ends, |x| ≤ ℓ, the gap is g = |y| − s. Both sides count, and with s > 0
//!    they never meet.
//! 2. **Derivatives.** y' = n·(D' − ω_Q D^⊥) with D' = V + ω_P r^⊥, and y'' = n·(−ω_P² r − 2 ω_Q
//!    D'^⊥ − ω_Q² D); x' and x'' likewise with e. *Proof.* n' = ω_Q n^⊥.
//! 3. **Bounds for all times.** While |X + V t| ≤ ϱ, y'' and x'' are at most K = ω_Q² ϱ + 2
//!    |ω_Q||V| + (ω_P − ω_Q)² r in magnitude, and y''' and x''' at most K₃ = |ω_Q|³ ϱ +
//!    3 ω_Q² |V| + |ω_P − ω_Q|³ r. *Proof.* In the frame of Q the atom is at p = R_Q⁻¹ (X + V t) +
//!    R(θ_P − θ_Q) r, so that p'' = −R_Q⁻¹ (ω_Q² (X + V t) + 2 ω_Q V^⊥) − (ω_P − ω_Q)² R r.
//!    y and x are linear in p: hence C₃ = K₃, and K bounds the curvature to both sides.
//! 4. **Reach.** A contact needs |D| ≤ q + s, with q the largest distance of a point of the edge
//!    from the centre of Q, and so |X + V t| ≤ ϱ = q + s + r. The search is confined to the window
//!    of time in which this holds, which is connected. If P does not turn, X + r takes the place of
//!    X, and 0 that of r: walls are long. The window is rounded outwards by at most 2 (E(0) + 16 u
//!    (|X|₁ + r + ϱ)); K and K₃ are those of ϱ plus this length.
//! 5. **Growth without cancellation.** y(h) − y(0) = n(h)·(V h + (R(ω_P h) − 1) r) + ((R(ω_Q h) −
//!    1) n)·D(0). *Proof.* n·m is constant in time.
//! 6. **Fast rotors.** The atom stays within r of the centre of P: it does not touch the edge
//!    before a disc of radius r + s about that centre does, nor before that centre is within ℓ + r
//!    of the middle along the edge. The edge stays within q of the centre of Q: the atom does not
//!    touch it before it is within q + s of that centre.
//! 7. **Rounding of y''.** Let T be the sum of the magnitudes of all terms of y''. Its error is at
//!    most T (24 u + 4 u |ω_Q| t + δβ) + (|ω_P| + |ω_Q|)² E + 2 |ω_Q| δV. *Proof.* The direction
//!    has an error of (12 + 4 |ω_Q| t) u and that of the orientation, and each term fewer than 12
//!    roundings. An error δr of the rotated arm enters as ω_P² + 2 |ω_P ω_Q| times itself, and one
//!    of D as ω_Q² times; both are parts of E.

use carom_geometry::{Circle, Edge};
use carom_kinematics::{HALF_ULP as U, RelativeMotion};
use glam::DVec2;

use crate::{
    EdgeErrorBound, Phase, SearchWindow,
    atom_pair::{centripetal, or_none, swing},
    edge_error::reach_of_pair,
    error_bound::one_norm,
    flight::{Flight, Pose},
    gap_search::{Gap, GapFunction, contact_within},
    safe_step::{Curvature, safe_step},
    search::{PairOutcome, Search},
    skim,
    strip::Strip,
    tolerance::FAST_ROTOR,
    trace::Recorder,
};

/// An atom of one body and an edge of the other.
pub(crate) struct EdgePair<'a> {
    flight: &'a Flight<'a>,
    /// The number of the body with the atom (0 for A, 1 for B).
    body: usize,
    atom: Circle,
    edge: &'a Edge,
    /// ℓ; infinite where the whole line counts.
    half_length: f64,
    /// Coordinates of m across and along the edge, in the frame of its body.
    middle: [f64; 2],
    /// s
    contact_distance: f64,
    /// ω_P and ω_Q
    spins: [f64; 2],
    /// r; 0 if P does not turn.
    orbit: f64,
    /// ϱ
    reach: f64,
    /// The bound on y'' of the centre of P, the part of K without r.
    of_centre: f64,
    /// K
    largest: f64,
    /// K₃
    jerk: f64,
    /// A bound on the sum of the magnitudes of all terms of y''.
    terms: f64,
    error: EdgeErrorBound,
}

/// An atom at one time, relative to the edge.
#[derive(Clone, Copy)]
pub(crate) struct EdgePose {
    pub(crate) time: f64,
    /// D
    pub(crate) place: DVec2,
    /// r in the present orientation.
    pub(crate) arm: DVec2,
    /// e
    along: DVec2,
    pub(crate) outwards: AxisSide,
    pub(crate) endwards: AxisSide,
}

/// A direction, and the coordinate of the middle of the edge in it: the normal on the atom's side,
/// or the direction along the edge to the nearer end.
#[derive(Clone, Copy)]
pub(crate) struct AxisSide {
    pub(crate) direction: DVec2,
    middle: f64,
}

/// A distance in one direction, and its first two time derivatives.
#[derive(Clone, Copy)]
pub(crate) struct Excess {
    pub(crate) value: f64,
    pub(crate) rate: f64,
    /// Second derivative.
    second: f64,
}

impl AxisSide {
    /// The side of the point `place`, of the two in a direction and against it.
    fn facing(direction: DVec2, middle: f64, place: DVec2) -> Self {
        if direction.dot(place) - middle < 0.0 {
            Self {
                direction: -direction,
                middle: -middle,
            }
        } else {
            Self { direction, middle }
        }
    }

    fn coordinate(self, place: DVec2) -> f64 {
        self.direction.dot(place) - self.middle
    }
}

impl<'a> EdgePair<'a> {
    pub(crate) fn new(flight: &'a Flight<'a>, body: usize, atom: Circle, edge: &'a Edge) -> Self {
        let reach = reach_of_pair(flight.spin[body], &atom, edge);
        Self::within(flight, body, atom, edge, reach)
    }

    /// The pair while |X + V t| ≤ `reach` (length).
    pub(crate) fn within(
        flight: &'a Flight<'a>,
        body: usize,
        atom: Circle,
        edge: &'a Edge,
        reach: f64,
    ) -> Self {
        let spins = [flight.spin[body], flight.spin[1 - body]];
        let [spin, fast] = spins.map(f64::abs);
        let contact_distance = atom.radius + edge.radius();
        let orbit = if spin == 0.0 { 0.0 } else { atom.arm };
        let apart = (spins[0] - spins[1]).abs();
        let of_atom = centripetal(apart, orbit);
        let error = EdgeErrorBound::within(flight.motion, body, flight.spin, reach, &atom, edge);
        // The border of a half-plane reaches to infinity, and does not turn.
        let way = if fast == 0.0 {
            0.0
        } else {
            let lengths = one_norm(flight.motion.separation) + atom.arm + reach;
            reach + 2.0 * (error.at(0.0) + 16.0 * U * lengths)
        };
        let of_centre = centripetal(fast, way) + 2.0 * fast * flight.speed;
        let jerk = fast * fast * (fast * way + 3.0 * flight.speed) + apart * of_atom;
        Self {
            flight,
            body,
            atom,
            edge,
            half_length: edge.half_length(),
            middle: [edge.normal(), edge.along()].map(|direction| direction.dot(edge.middle())),
            contact_distance,
            spins,
            orbit,
            reach,
            of_centre,
            largest: of_centre + of_atom,
            jerk: or_none(jerk, of_centre + of_atom > 0.0),
            terms: centripetal(spin, orbit)
                + 2.0 * fast * (flight.speed + spin * orbit)
                + fast * fast * (way + orbit),
            error,
        }
    }

    /// The first contact with the edge between its ends from `begin` to `limit`; there must be none
    /// before `begin`.
    pub(crate) fn first_contact_in_span<R: Recorder>(
        &self,
        begin: f64,
        limit: f64,
        search: &mut Search<R>,
    ) -> PairOutcome {
        match self.window(limit) {
            None => PairOutcome::Free,
            Some(window) if self.largest == 0.0 => {
                search.evaluations += 1;
                let time = self.straight_contact();
                search.recorder.step(Phase::ClosedForm, 0.0, Some(time));
                contact_within(time, window.end)
            }
            Some(window) if window.begin.max(begin) > window.end => PairOutcome::Free,
            Some(window) => self.first_contact(
                window.begin.max(begin),
                [f64::INFINITY, window.end],
                &mut 0,
                search,
            ),
        }
    }

    /// The pair for [`Self::first_crossing`], for bodies of these bounding radii (length).
    pub(crate) fn of_line(
        flight: &'a Flight<'a>,
        body: usize,
        atom: Circle,
        edge: &'a Edge,
        radii: [f64; 2],
    ) -> Self {
        let spin = flight.spin[body];
        let offset = if spin == 0.0 { atom.arm } else { 0.0 };
        let of_bodies = radii[0] + radii[1] + offset;
        let reach = of_bodies.max(reach_of_pair(spin, &atom, edge));
        Self::within(flight, body, atom, edge, reach)
    }

    /// The first time from `begin` to `limit` at which the atom touches the line through the edge,
    /// also beyond its ends, and whether it is beside the edge then; there must be no contact
    /// before `begin`, and the bounding circles must overlap from then on.
    ///
    /// Orbits are not made use of: they may carry an atom across the line beyond an end.
    pub(crate) fn first_crossing<R: Recorder>(
        mut self,
        begin: f64,
        limit: f64,
        search: &mut Search<R>,
    ) -> (PairOutcome, bool) {
        let half_length = std::mem::replace(&mut self.half_length, f64::INFINITY);
        let outcome = if self.largest == 0.0 {
            search.evaluations += 1;
            let time = self.straight_contact();
            search.recorder.step(Phase::ClosedForm, 0.0, Some(time));
            contact_within(time, limit)
        } else {
            self.first_contact(begin, [f64::INFINITY, limit], &mut 0, search)
        };
        let PairOutcome::Contact(time) = outcome else {
            return (outcome, false);
        };
        self.half_length = half_length;
        let is_beside = self.beyond(&self.pose(time)).value <= self.error.at(time);
        let near = Self::new(self.flight, self.body, self.atom, self.edge);
        if !is_beside || near.reach == self.reach {
            return (outcome, is_beside);
        }
        // The bounds of the pair are those of a longer reach: a contact has smaller ones.
        let gap = self.gap(&self.pose(time));
        let closing = (-gap.rate).max(gap.rate_error);
        let until = (time + 4.0 * gap.error / closing).min(limit);
        match near.first_contact_in_span(begin, until, search) {
            contact @ PairOutcome::Contact(_) => (contact, true),
            PairOutcome::OutOfBudget(until) => (PairOutcome::OutOfBudget(until), false),
            PairOutcome::Free | PairOutcome::Paused(_) => (outcome, false),
        }
    }

    /// This pair, with the whole line through the edge.
    pub(crate) fn of_whole_line(self) -> Self {
        Self {
            half_length: f64::INFINITY,
            ..self
        }
    }

    /// The window of time, up to `limit`, in which the atom is within reach of the edge (Lemma 4).
    fn window(&self, limit: f64) -> Option<SearchWindow> {
        let motion = self.flight.motion;
        if self.spins[1] == 0.0 {
            let room = self.atom.arm + self.atom.radius;
            return Strip::window(motion, self.body, self.edge, room, limit);
        }
        if self.orbit == self.atom.arm {
            return skim(motion, self.reach, limit);
        }
        let arm = self.flight.at(0.0).arm(self.body, self.atom.offset);
        let about_the_atom = RelativeMotion {
            separation: motion.separation + if self.body == 1 { arm } else { -arm },
            separation_error: self.error.at(0.0),
            ..*motion
        };
        skim(&about_the_atom, self.reach, limit)
    }

    /// The contact time of an atom in uniform motion with the edge; infinite if there is none.
    ///
    /// The contact is at the later of the times at which the gap closes and the atom enters the
    /// span, if the atom is in the span then. An atom that only grazes an end may enter the span at
    /// a gap of 0 to rounding. Atoms that touch or overlap are decided by Lemma 8 of
    /// [`gap_search`](crate::gap_search).
    fn straight_contact(&self) -> f64 {
        let pose = self.pose(0.0);
        let now = self.gap(&pose);
        let beyond = self.beyond(&pose);
        let closing = -now.rate;
        let reaches = if now.value > now.error {
            if closing > 0.0 {
                now.value / closing
            } else {
                f64::INFINITY
            }
        } else if now.is_contact() {
            if closing > 0.0 {
                (now.value / closing).max(0.0)
            } else {
                0.0
            }
        } else if closing > 0.0 {
            now.fall() / closing
        } else {
            f64::INFINITY
        };
        let enters = if beyond.value <= now.error {
            0.0
        } else if beyond.rate < 0.0 {
            beyond.value / -beyond.rate
        } else {
            f64::INFINITY
        };
        let time = reaches.max(enters);
        if time == f64::INFINITY {
            return time;
        }
        let then = pose.place + self.velocity_of(DVec2::ZERO) * time;
        let along = pose.endwards.coordinate(then).abs();
        let in_span = along - self.half_length <= self.error.at(time);
        if in_span && pose.outwards.coordinate(then) > 0.0 || time == 0.0 {
            time
        } else {
            f64::INFINITY
        }
    }

    /// D': the velocity of the atom relative to the centre of the edge's body.
    pub(crate) fn velocity_of(&self, arm: DVec2) -> DVec2 {
        let velocity = self.flight.motion.velocity;
        let of_centre = if self.body == 1 { velocity } else { -velocity };
        of_centre + self.spins[0] * arm.perp()
    }

    fn pose_of(&self, time: f64, along: DVec2, place: DVec2, arm: DVec2) -> EdgePose {
        let [across, lengthwise] = self.middle;
        let outwards = if self.edge.is_solid_behind() {
            AxisSide {
                direction: along.perp(),
                middle: across,
            }
        } else {
            AxisSide::facing(along.perp(), across, place)
        };
        EdgePose {
            time,
            place,
            arm,
            along,
            outwards,
            endwards: AxisSide::facing(along, lengthwise, place),
        }
    }

    /// The distance of the atom from the middle of the edge in one direction (length) less
    /// `distance`, and its derivatives (Lemma 2).
    fn excess(&self, pose: &EdgePose, side: AxisSide, distance: f64) -> Excess {
        let [spin, spin_of_edge] = self.spins;
        let velocity = self.velocity_of(pose.arm);
        let of_atom = -(spin * spin) * pose.arm;
        let of_edge = spin_of_edge * (2.0 * velocity.perp() + spin_of_edge * pose.place);
        Excess {
            value: side.coordinate(pose.place) - distance,
            rate: side
                .direction
                .dot(velocity - spin_of_edge * pose.place.perp()),
            second: side.direction.dot(of_atom - of_edge),
        }
    }

    /// The distance of the atom's centre beyond the nearer end of the edge; at most 0 in the span.
    pub(crate) fn beyond(&self, pose: &EdgePose) -> Excess {
        self.excess(pose, pose.endwards, self.half_length)
    }

    /// How far an atom is from `distance` (length) in the direction of the normal; for an arc, in
    /// the direction to its middle.
    pub(crate) fn before_normal(&self, pose: &EdgePose, distance: f64) -> Excess {
        let inwards = AxisSide {
            direction: -pose.along.perp(),
            middle: 0.0,
        };
        self.excess(pose, inwards, -distance)
    }

    /// A certified time for which a positive excess stays positive.
    pub(crate) fn step_of(&self, pose: &EdgePose, excess: &Excess) -> f64 {
        let error = self.error_at(pose.time);
        let rate = excess.rate - self.rate_error_at(pose.time);
        safe_step(excess.value, rate, &self.curvature(pose, excess, error))
    }

    /// E
    pub(crate) fn error_at(&self, time: f64) -> f64 {
        self.error.at(time)
    }

    /// E'
    pub(crate) fn rate_error_at(&self, time: f64) -> f64 {
        self.error.of_rate(time)
    }

    /// The pose `elapsed` (time) after `start`, and the way of the atom relative to the centre of
    /// the edge's body since, without cancellation (length).
    pub(crate) fn moved_pose(&self, start: &EdgePose, elapsed: f64) -> (EdgePose, DVec2) {
        let [spin, spin_of_edge] = self.spins;
        let swing_of_atom = swing(spin, elapsed, start.arm);
        let moved = self.velocity_of(DVec2::ZERO) * elapsed + swing_of_atom;
        let along = start.along + swing(spin_of_edge, elapsed, start.along);
        let time = start.time + elapsed;
        let (place, arm) = (start.place + moved, start.arm + swing_of_atom);
        (self.pose_of(time, along, place, arm), moved)
    }

    /// A bound on the rounding of y'' and x'' (Lemma 7).
    pub(crate) fn second_error(&self, time: f64, error: f64) -> f64 {
        let [spin, spin_of_edge] = self.spins.map(f64::abs);
        let motion = self.flight.motion;
        let both = spin + spin_of_edge;
        let tilt = motion.orientation_error[1 - self.body] + 4.0 * U * (spin_of_edge * time);
        self.terms * (24.0 * U + tilt)
            + both * both * error
            + 2.0 * spin_of_edge * motion.velocity_error
    }

    /// The curvature of the excess in a direction (Lemma 3), with the error E.
    pub(crate) fn curvature(&self, pose: &EdgePose, excess: &Excess, error: f64) -> Curvature {
        let second_error = self.second_error(pose.time, error);
        Curvature::of_smooth_gap(self.largest, excess.second - second_error, self.jerk)
    }

    /// The step to the time at which the disc of radius r + s about the centre of P may reach the
    /// line of the edge, and its centre be within r of the ends (Lemma 6).
    #[cold]
    fn step_of_orbiting_atom(&self, pose: &EdgePose) -> f64 {
        let place = pose.place - pose.arm;
        let centre = self.pose_of(pose.time, pose.along, place, DVec2::ZERO);
        let step = |side: AxisSide, distance: f64| {
            let excess = self.excess(&centre, side, distance + self.orbit);
            let gap = excess.value - self.error.at(pose.time);
            if gap > 0.0 {
                let rate = excess.rate - self.error.of_rate(pose.time);
                safe_step(gap, rate, &Curvature::at_most(self.of_centre))
            } else {
                0.0
            }
        };
        let across = step(centre.outwards, self.contact_distance);
        across.max(step(centre.endwards, self.edge.half_length()))
    }

    /// The step to the time at which the atom may reach the disc about the centre of Q in which the
    /// edge stays (Lemma 6).
    #[cold]
    fn step_of_orbiting_edge(&self, pose: &EdgePose) -> f64 {
        let (distance, error) = (pose.place.length(), self.error.at(pose.time));
        let gap = distance - (self.edge.reach() + self.contact_distance) - error;
        if gap > 0.0 {
            let rate = pose.place.dot(self.velocity_of(pose.arm)) / distance;
            // The direction of D has an error of 2 E/|D|.
            let of_direction = 2.0 * self.error.speed() * error / distance;
            let rate = rate - (self.error.of_rate(pose.time) + of_direction);
            let bend = centripetal(self.spins[0], self.orbit);
            safe_step(gap, rate, &Curvature::at_most(bend))
        } else {
            0.0
        }
    }
}

impl GapFunction for EdgePair<'_> {
    type Pose = EdgePose;

    fn pose(&self, time: f64) -> EdgePose {
        let at: Pose = self.flight.at(time);
        let arm = at.arm(self.body, self.atom.offset);
        let along = at.arm(1 - self.body, self.edge.along());
        // Negation is exact, so exchanging A and B changes no bit.
        let centre = if self.body == 1 {
            at.separation
        } else {
            -at.separation
        };
        self.pose_of(time, along, centre + arm, arm)
    }

    fn gap(&self, pose: &EdgePose) -> Gap {
        let across = self.excess(pose, pose.outwards, self.contact_distance);
        let (error, rate_error) = (self.error.at(pose.time), self.error.of_rate(pose.time));
        Gap {
            value: across.value,
            rate: across.rate,
            second: across.second,
            slowness: 1.0 / (rate_error - across.rate),
            error,
            rate_error,
            curvature: self.curvature(pose, &across, error),
        }
    }

    fn moved(&self, start: &EdgePose, elapsed: f64) -> Option<(EdgePose, f64)> {
        let (pose, moved) = self.moved_pose(start, elapsed);
        let turned = swing(self.spins[1], elapsed, start.outwards.direction);
        let outwards = AxisSide {
            direction: start.outwards.direction + turned,
            ..start.outwards
        };
        let pose = EdgePose { outwards, ..pose };
        let is_in_span = self.beyond(&pose).value <= -self.error.at(pose.time);
        let widened = outwards.direction.dot(moved) + turned.dot(start.place);
        is_in_span.then_some((pose, widened))
    }

    fn top_speed(&self) -> f64 {
        self.error.speed()
    }

    /// Corners may be much smaller than their distance from the centre of mass.
    fn size(&self) -> f64 {
        self.contact_distance + self.orbit
    }

    /// A certified time for which an atom beyond an end stays there, or for which fast rotors do
    /// not reach each other.
    fn other_step(&self, pose: &EdgePose) -> f64 {
        let (beyond, error) = (self.beyond(pose), self.error.at(pose.time));
        let mut step = 0.0;
        if beyond.value > error {
            step = self.step_of(pose, &beyond);
        }
        let [spin, spin_of_edge] = self.spins.map(f64::abs);
        if spin_of_edge > 0.0 && self.half_length < f64::INFINITY {
            let speed = self.flight.speed;
            let (rim, rim_of_edge) = (spin * self.orbit, spin_of_edge * self.edge.reach());
            if rim > FAST_ROTOR * (speed + rim_of_edge) {
                step = f64::max(step, self.step_of_orbiting_atom(pose));
            }
            if rim_of_edge > FAST_ROTOR * (speed + rim) {
                step = f64::max(step, self.step_of_orbiting_edge(pose));
            }
        }
        step
    }

    fn stays(&self, pose: &EdgePose, duration: f64) -> bool {
        let way = 2.0 * duration * self.error.speed();
        self.beyond(pose).value + self.error.at(pose.time) + way <= 0.0
    }

    /// Always `time`: the window of the search already covers all times within reach.
    fn within_reach(&self, time: f64, _: f64) -> Option<f64> {
        Some(time)
    }
}

#[cfg(test)]
mod tests;
