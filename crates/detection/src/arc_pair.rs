//! The gap between an atom in flight and an arc of a circle: the face inside the circle, which the
//! atom leaves, and the face outside, which it approaches like a disc.
//!
//! # Lemmas
//! In the notation of [`gap_search`](crate::gap_search): the atom of body P has the arm r and the
//! angular velocity ω_P. The arc of body Q has the radius S, the centre of Q as its centre, the
//! direction m to its middle, which turns with ω_Q, and half the angle α. s is the sum of the
//! radius of the atom and half the thickness of the arc. D = X + V t + r leads from the centre of Q
//! to the atom.
//!
//! 1. **Gap inside.** The atom touches the inner face where |D| = R = S − s. The distance |D| has
//!    no derivative at 0; its square has. g = (R² − |D|²)/2R has the zero of R − |D|, and for |D| ≤
//!    R it is between (R − |D|)/2 and R − |D|.
//! 2. **Derivatives.** g' = −D·D'/R and g'' = −(|D'|² + D·D'')/R, with D' = V + ω_P r^⊥ and D'' =
//!    −ω_P² r. The rotation of Q does not enter.
//! 3. **Bounds for all times.** While |D| ≤ S, |g''| ≤ K = (L² + S a)/R and |g'''| ≤ K₃ = (3 L a +
//!    S |ω_P| a)/R, with L = |V| + |ω_P| r and a = ω_P² r. Hence C₃ = K₃. For a body that does not
//!    turn g is a parabola, and Lemma 6 of `gap_search` gives the contact in closed form.
//! 4. **Directions.** A contact with a face of radius F, inside or outside, needs m·D ≥ F cos α, to
//!    rounding: D has the length F and lies in a direction of the arc. While b = F cos α − m·D > 0
//!    there is none. The bounds on b'' and b''' are those of a straight edge
//!    ([`edge_pair`](crate::edge_pair), Lemma 3). A contact at b ≤ E is one in a direction of the
//!    arc, or so near to its end that both touch to rounding.
//! 5. **Other side.** An atom with |D| > S is outside: it does not touch the inner face before |D|
//!    = S. Nor does one with |D| > R that is not in a direction of the arc, before |D| = R: to come
//!    into one earlier it would have to pass the end of the arc, which is searched as an atom.
//!    Since |D|'' ≥ −a, the time until then is bounded as in Lemma 1 of `gap_search`. Likewise an
//!    atom with |D| < S, or one with |D| < F that is not in a direction of the arc, does not touch
//!    the outer face, of radius F = S + s, before |D| has that value; (F² − |D|²)/2F has the bounds
//!    of 3 with F in place of R.
//! 6. **Fast rotors.** The atom stays within r of the centre of P: it does not reach R before that
//!    centre reaches R − r, if this is positive.
//! 7. **Growth without cancellation.** g(h) − g(0) = −δ·(2 D(0) + δ)/2R, with δ = V h + (R(ω_P h) −
//!    1) r.
//! 8. **Rounding.** Let E be that of a straight edge ([`EdgeErrorBound`](crate::EdgeErrorBound))
//!    with its middle at the distance S: it holds the error of D, and 8 u S for the at most 7
//!    roundings of R and |D|. g = (R − |D|)(R + |D|)/2R multiplies it by at most κ = max(1, (R +
//!    |D|)/2R). The error of g' is at most E' = (E L + S (δV + |ω_P| E + 12 u L))/R, and that of
//!    g'' at most ((L² + S a) 48 u + 2 L (δV + |ω_P| E) + (a + ω_P² S) E)/R.

use carom_geometry::{Bend, Circle, Edge};
use carom_kinematics::{HALF_ULP as U, RelativeMotion};
use glam::DVec2;

use crate::{
    EdgeErrorBound, ErrorBound, Phase, Touch,
    atom_pair::{AtomPair, PairPose, centripetal, or_none},
    disc::disc_contact,
    edge_pair::{EdgePair, EdgePose, Excess},
    flight::Flight,
    gap_search::{Gap, GapFunction, contact_within},
    safe_step::{Curvature, safe_step},
    search::{PairOutcome, Search},
    skim,
    tolerance::FAST_ROTOR,
    trace::Recorder,
};

/// Searches an atom of body number `body` and an arc of the other body, apart from its ends, from
/// `begin` (time) on; there must be no contact before.
pub(crate) fn search_arc<R: Recorder>(
    flight: &Flight<'_>,
    body: usize,
    atom: Circle,
    (edge, bend): (&Edge, &Bend),
    begin: f64,
    touch: Touch,
    search: &mut Search<R>,
) {
    let reach = edge.reach() + edge.radius() + atom.radius + atom.arm;
    let Some(window) = skim(flight.motion, reach, search.limit()) else {
        return;
    };
    let begin = window.begin.max(begin);
    if begin > window.end {
        return;
    }
    let arc = ArcPair {
        frame: EdgePair::new(flight, body, atom, edge),
        flight,
        body,
        atom,
        bend,
    };
    if let Some(face) = InnerFace::new(&arc, edge) {
        let outcome = face.first_contact(begin, [f64::INFINITY, window.end], &mut 0, search);
        search.record_touch(outcome, touch);
    }
    if !bend.is_one_sided() {
        let limit = window.end.min(search.limit());
        let face = OuterFace::new(&arc, edge);
        let outcome = face.first_contact_in_directions(begin, limit, search);
        search.record_touch(outcome, touch);
    }
}

/// A bound on the rounding of the closing speed of an atom of body number `body` that touches an
/// arc at time 0 (length per time).
pub(crate) fn rate_error_at_arc(
    motion: &RelativeMotion,
    body: usize,
    atom: &Circle,
    edge: &Edge,
    bend: &Bend,
) -> f64 {
    let (spins, speed) = (motion.angular_velocity, motion.velocity.length());
    let radius = bend.radius() - (edge.radius() + atom.radius);
    let inside = (radius > 0.0).then(|| {
        let error = EdgeErrorBound::new(motion, body, atom, edge).at(0.0);
        let spin = spins[body].abs();
        of_rate(error, [spin, speed + spin * atom.arm], radius, bend, motion)
    });
    let outside = (!bend.is_one_sided()).then(|| {
        let circles = arc_and_atom(body, *atom, edge, bend);
        let at_contact = circles[0].radius + circles[1].radius;
        ErrorBound::of_circles(motion, speed, spins, &circles).of_rate(0.0, at_contact)
    });
    let faces = inside.into_iter().chain(outside);
    faces.reduce(f64::max).unwrap_or(f64::INFINITY)
}

/// E' (Lemma 8) with the error E of the gap, |ω_P| and L, and R.
fn of_rate(
    error: f64,
    [spin, top]: [f64; 2],
    radius: f64,
    bend: &Bend,
    motion: &RelativeMotion,
) -> f64 {
    let of_velocity = motion.velocity_error + spin * error + 12.0 * U * top;
    (error * top + bend.radius() * of_velocity) / radius
}

/// The atom and the disc that the circle of an arc encloses, in the order of the bodies.
fn arc_and_atom(body: usize, atom: Circle, edge: &Edge, bend: &Bend) -> [Circle; 2] {
    let mut circles = [atom; 2];
    circles[1 - body] = Circle {
        offset: DVec2::ZERO,
        arm: 0.0,
        radius: bend.radius() + edge.radius(),
    };
    circles
}

/// An atom of one body and an arc of the other.
struct ArcPair<'a> {
    /// The atom in the frame of the arc: D, m and the rounding of both.
    frame: EdgePair<'a>,
    flight: &'a Flight<'a>,
    body: usize,
    atom: Circle,
    bend: &'a Bend,
}

impl ArcPair<'_> {
    /// ω_P
    fn spin(&self) -> f64 {
        self.flight.spin[self.body]
    }

    /// b for a face of radius F (length; Lemma 4), and its derivatives; `None` for a whole circle.
    fn beyond(&self, pose: &EdgePose, face: f64) -> Option<Excess> {
        (!self.bend.is_circle()).then(|| self.frame.before_normal(pose, face * self.bend.cosine()))
    }

    /// A certified time for which the atom stays out of the directions of the arc at a face of
    /// radius F.
    fn step_to_directions(&self, pose: &EdgePose, face: f64) -> f64 {
        let error = self.frame.error_at(pose.time);
        match self.beyond(pose, face) {
            Some(beyond) if beyond.value > error => self.frame.step_of(pose, &beyond),
            _ => 0.0,
        }
    }

    /// Whether the atom is in a direction of the arc, or within rounding of one.
    fn is_faced(&self, pose: &EdgePose) -> bool {
        let rounding = 2.0 * self.frame.error_at(pose.time);
        let towards_middle = -self.frame.before_normal(pose, 0.0).value;
        self.bend.is_circle()
            || towards_middle >= self.bend.cosine() * pose.place.length() - rounding
    }

    /// Whether the atom stays in the directions of the arc for `duration` (time).
    fn stays(&self, pose: &EdgePose, face: f64, duration: f64) -> bool {
        let way = 2.0 * duration * self.frame.top_speed();
        self.beyond(pose, face)
            .is_none_or(|beyond| beyond.value + self.frame.error_at(pose.time) + way <= 0.0)
    }
}

/// The face of an arc towards its centre.
struct InnerFace<'a> {
    arc: &'a ArcPair<'a>,
    /// R
    radius: f64,
    /// L
    top_speed: f64,
    /// a
    centripetal: f64,
    /// K
    largest: f64,
    /// K₃
    jerk: f64,
}

impl<'a> InnerFace<'a> {
    /// The face, unless the atom does not fit inside the circle.
    fn new(arc: &'a ArcPair<'a>, edge: &Edge) -> Option<Self> {
        let radius = arc.bend.radius() - (arc.atom.radius + edge.radius());
        if radius <= 0.0 {
            return None;
        }
        let spin = arc.spin().abs();
        let orbit = if spin == 0.0 { 0.0 } else { arc.atom.arm };
        let (top_speed, centripetal) = (arc.flight.speed + spin * orbit, centripetal(spin, orbit));
        let of_circle = arc.bend.radius();
        let jerk = centripetal * (3.0 * top_speed + of_circle * spin) / radius;
        Some(Self {
            arc,
            radius,
            top_speed,
            centripetal,
            largest: (top_speed * top_speed + of_circle * centripetal) / radius,
            jerk: or_none(jerk, centripetal > 0.0),
        })
    }

    /// The step until the centre of P may be so far out that the atom reaches the face (Lemma 6).
    #[cold]
    fn step_of_orbit(&self, pose: &EdgePose) -> f64 {
        let room = self.radius - self.arc.atom.arm;
        if room <= 0.0 {
            return 0.0;
        }
        let place = pose.place - pose.arm;
        let gap = (room * room - place.length_squared()) / (2.0 * room);
        let gap = gap - self.arc.frame.error_at(pose.time) * (room + self.radius) / room;
        if gap > 0.0 {
            let speed = self.arc.flight.speed;
            let velocity = self.arc.frame.velocity_of(DVec2::ZERO);
            let rounding = self.arc.frame.rate_error_at(pose.time) * (self.radius / room);
            let rate = -place.dot(velocity) / room - rounding;
            safe_step(gap, rate, &Curvature::at_most(speed * speed / room))
        } else {
            0.0
        }
    }
}

impl GapFunction for InnerFace<'_> {
    type Pose = EdgePose;

    fn pose(&self, time: f64) -> EdgePose {
        self.arc.frame.pose(time)
    }

    fn gap(&self, pose: &EdgePose) -> Gap {
        let (arc, radius, spin) = (self.arc, self.radius, self.arc.spin());
        let velocity = arc.frame.velocity_of(pose.arm);
        let distance = pose.place.length();
        let of_place = arc.frame.error_at(pose.time);
        let stretch = (0.5 * (radius + distance) / radius).max(1.0);
        let error = of_place * stretch;
        let motion = arc.flight.motion;
        let magnitudes = [spin.abs(), self.top_speed];
        let rate_error = of_rate(of_place, magnitudes, radius, arc.bend, motion);
        let acceleration = -(spin * spin) * pose.arm;
        let second = -(velocity.length_squared() + pose.place.dot(acceleration)) / radius;
        let of_velocity = motion.velocity_error + spin.abs() * of_place;
        let second_error = 48.0 * U * self.largest
            + (2.0 * self.top_speed * of_velocity
                + (self.centripetal + spin * spin * arc.bend.radius()) * of_place)
                / radius;
        let rate = -pose.place.dot(velocity) / radius;
        Gap {
            value: (radius - distance) * (radius + distance) / (2.0 * radius),
            rate,
            second,
            slowness: 1.0 / (rate_error - rate),
            error,
            rate_error,
            curvature: Curvature::of_smooth_gap(self.largest, second - second_error, self.jerk),
        }
    }

    fn moved(&self, start: &EdgePose, elapsed: f64) -> Option<(EdgePose, f64)> {
        let (pose, moved) = self.arc.frame.moved_pose(start, elapsed);
        let error = self.arc.frame.error_at(pose.time);
        let is_faced = self
            .arc
            .beyond(&pose, self.radius)
            .is_none_or(|beyond| beyond.value <= -error);
        let widened = -moved.dot(2.0 * start.place + moved) / (2.0 * self.radius);
        is_faced.then_some((pose, widened))
    }

    fn top_speed(&self) -> f64 {
        self.top_speed * (self.arc.bend.radius() / self.radius)
    }

    fn size(&self) -> f64 {
        self.radius
    }

    fn other_step(&self, pose: &EdgePose) -> f64 {
        let mut step = self.arc.step_to_directions(pose, self.radius);
        let (distance, error) = (pose.place.length(), self.arc.frame.error_at(pose.time));
        let bend = self.arc.bend;
        let least = if self.arc.is_faced(pose) {
            bend.radius()
        } else {
            self.radius
        };
        let beyond = distance - least - error;
        if beyond > 0.0 {
            let rate = pose.place.dot(self.arc.frame.velocity_of(pose.arm)) / distance;
            let rate = rate - self.arc.frame.rate_error_at(pose.time);
            step = step.max(safe_step(
                beyond,
                rate,
                &Curvature::at_most(self.centripetal),
            ));
        }
        let rim = self.arc.spin().abs() * self.arc.atom.arm;
        if rim > FAST_ROTOR * self.arc.flight.speed {
            step = step.max(self.step_of_orbit(pose));
        }
        step
    }

    fn stays(&self, pose: &EdgePose, duration: f64) -> bool {
        self.arc.stays(pose, self.radius, duration)
    }

    /// Always `time`: the window of the search already covers all times within reach.
    fn within_reach(&self, time: f64, _: f64) -> Option<f64> {
        Some(time)
    }
}

/// The face of an arc away from its centre: that of a disc, in the directions of the arc.
struct OuterFace<'a> {
    arc: &'a ArcPair<'a>,
    disc: AtomPair<'a>,
    circles: [Circle; 2],
    /// S + s
    radius: f64,
}

/// The atom relative to the disc, and in the frame of the arc.
struct OuterPose {
    disc: PairPose,
    frame: EdgePose,
}

impl<'a> OuterFace<'a> {
    fn new(arc: &'a ArcPair<'a>, edge: &Edge) -> Self {
        let circles = arc_and_atom(arc.body, arc.atom, edge, arc.bend);
        Self {
            arc,
            disc: AtomPair::new(arc.flight, circles),
            circles,
            radius: circles[0].radius + circles[1].radius,
        }
    }

    fn first_contact_in_directions<R: Recorder>(
        &self,
        begin: f64,
        limit: f64,
        search: &mut Search<R>,
    ) -> PairOutcome {
        if self.arc.spin() != 0.0 {
            return self.first_contact(begin, [f64::INFINITY, limit], &mut 0, search);
        }
        search.evaluations += 1;
        let time = self.straight_contact();
        search.recorder.step(Phase::ClosedForm, 0.0, Some(time));
        if time == f64::INFINITY || time > limit {
            return PairOutcome::Free;
        }
        if self.arc.is_faced(&self.arc.frame.pose(time)) {
            contact_within(time, limit)
        } else {
            PairOutcome::Free
        }
    }

    /// The time at which an atom in uniform motion enters the disc of radius S + s; infinite if it
    /// is inside already. It enters once: a line crosses the circle twice, and leaves it the second
    /// time.
    fn straight_contact(&self) -> f64 {
        let pose = self.arc.frame.pose(0.0);
        if pose.place.length() < self.arc.bend.radius() {
            return f64::INFINITY;
        }
        let motion = self.arc.flight.motion;
        let spins = self.arc.flight.spin;
        let errors = ErrorBound::of_circles(motion, self.arc.flight.speed, spins, &self.circles);
        let velocity = self.arc.frame.velocity_of(DVec2::ZERO);
        let errors = (errors.at(0.0), motion.velocity_error);
        disc_contact(pose.place, velocity, self.radius, errors)
    }
}

impl GapFunction for OuterFace<'_> {
    type Pose = OuterPose;

    fn pose(&self, time: f64) -> OuterPose {
        OuterPose {
            disc: self.disc.pose(time),
            frame: self.arc.frame.pose(time),
        }
    }

    fn gap(&self, pose: &OuterPose) -> Gap {
        self.disc.gap(&pose.disc)
    }

    fn moved(&self, start: &OuterPose, elapsed: f64) -> Option<(OuterPose, f64)> {
        let (disc, widened) = self.disc.moved(&start.disc, elapsed)?;
        let (frame, _) = self.arc.frame.moved_pose(&start.frame, elapsed);
        let error = self.arc.frame.error_at(frame.time);
        let is_faced = self
            .arc
            .beyond(&frame, self.radius)
            .is_none_or(|beyond| beyond.value <= -error);
        is_faced.then_some((OuterPose { disc, frame }, widened))
    }

    fn top_speed(&self) -> f64 {
        self.disc.top_speed()
    }

    fn size(&self) -> f64 {
        self.disc.size()
    }

    fn other_step(&self, pose: &OuterPose) -> f64 {
        let step = self
            .disc
            .other_step(&pose.disc)
            .max(self.arc.step_to_directions(&pose.frame, self.radius));
        let place = pose.frame.place;
        let of_circle = if self.arc.is_faced(&pose.frame) {
            self.arc.bend.radius()
        } else {
            self.radius
        };
        let error = self.arc.frame.error_at(pose.frame.time);
        let distance = place.length();
        let gap = (of_circle - distance) * (of_circle + distance) / (2.0 * of_circle) - error;
        if gap <= 0.0 {
            return step;
        }
        let arc = self.arc;
        let spin = arc.spin().abs();
        let top = arc.flight.speed + spin * arc.atom.arm;
        let motion = arc.flight.motion;
        let rounding = of_rate(error, [spin, top], of_circle, arc.bend, motion);
        let rate = -place.dot(arc.frame.velocity_of(pose.frame.arm)) / of_circle - rounding;
        let largest = top * top / of_circle + centripetal(spin, arc.atom.arm);
        step.max(safe_step(gap, rate, &Curvature::at_most(largest)))
    }

    fn stays(&self, pose: &OuterPose, duration: f64) -> bool {
        self.arc.stays(&pose.frame, self.radius, duration)
    }

    fn within_reach(&self, time: f64, limit: f64) -> Option<f64> {
        self.disc.within_reach(time, limit)
    }
}

#[cfg(test)]
mod tests;
