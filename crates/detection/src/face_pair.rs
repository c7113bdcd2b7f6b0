//! An atom in flight against a straight face: its gap, and the search for its first zero.

use carom_geometry::{Circle, Face};
use carom_kinematics::HALF_ULP as U;
use glam::DVec2;

use crate::{
    FaceErrorBound, Window,
    atom_pair::PairOutcome,
    flight::{Flight, Placement},
    recontact::swing,
    safe_step::{Curvature, safe_step},
    strip::Strip,
    tolerance::{MOST_RECONTACT_STEPS, SOON, STEP_MARGIN},
};

/// One atom of a body and the face of the other, which does not turn.
pub(crate) struct FacePair<'a> {
    flight: &'a Flight<'a>,
    /// Which body has the atom.
    body: usize,
    atom: Circle,
    face: &'a Face,
    /// Unit vectors along the face and out of it.
    along: DVec2,
    normal: DVec2,
    /// s
    contact_distance: f64,
    /// K = ω² r, the bound on |d''| for all time.
    centripetal: f64,
    error: FaceErrorBound,
}

/// How far a point is out in one direction, and how that changes.
#[derive(Clone, Copy)]
pub(crate) struct Excess {
    direction: DVec2,
    pub(crate) value: f64,
    pub(crate) rate: f64,
    /// Second derivative.
    bend: f64,
}

/// An atom and a face at one moment.
pub(crate) struct FaceGap {
    /// From the centre of the face's body to that of the atom.
    place: DVec2,
    /// Across the face: the gap.
    pub(crate) across: Excess,
    /// Along the face, beyond its nearer end; not above 0 where the nearest point of the face is none of its ends.
    pub(crate) beyond: Excess,
    /// E
    pub(crate) error: f64,
    /// E'
    pub(crate) rate_error: f64,
}

impl<'a> FacePair<'a> {
    pub(crate) fn new(flight: &'a Flight<'a>, body: usize, atom: Circle, face: &'a Face) -> Self {
        let spin = flight.spin[body];
        let along = flight.at(0.0).arm(1 - body, face.along());
        Self {
            flight,
            body,
            atom,
            face,
            along,
            normal: along.perp(),
            contact_distance: atom.radius + face.radius(),
            centripetal: spin * spin * atom.arm,
            error: FaceErrorBound::with_spin(flight.motion, body, spin, &atom, face),
        }
    }

    /// The first contact up to `limit` with the face between its ends.
    pub(crate) fn first_contact(&self, limit: f64, most_steps: u32, evaluations: &mut u32) -> PairOutcome {
        let room = self.atom.arm + self.atom.radius;
        let window = Strip::window(self.flight.motion, self.body, self.face, room, limit);
        match window {
            None => PairOutcome::Free,
            Some(window) if self.centripetal == 0.0 => {
                *evaluations += 1;
                contact_within(self.straight_contact(), window.end)
            }
            Some(window) => self.search(window, most_steps, evaluations),
        }
    }

    /// When an atom that moves straight on touches the face; infinite for never.
    ///
    /// The face is touched at the later of the times at which the gap is closed and the span is entered, if the atom
    /// is in the span then. It may enter the span at a gap of 0 to rounding, past an end that it only grazes. One that
    /// closes more slowly than E' tells, while it touches, is in contact when it has come closer by E.
    fn straight_contact(&self) -> f64 {
        let now = self.gap(&self.flight.at(0.0));
        let (across, beyond) = (now.across, now.beyond);
        let closing = -across.rate;
        let reaches = if across.value > now.error {
            if closing > 0.0 { across.value / closing } else { f64::INFINITY }
        } else if self.closes(&now) {
            (across.value / closing).max(0.0)
        } else if closing > self.flight.motion.velocity_error {
            (across.value + now.error).max(0.0) / closing
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
        let then = now.place + self.velocity_of(DVec2::ZERO) * time;
        let in_span = self.along.dot(then).abs() - self.face.half_length() <= self.error.at(time);
        if in_span && across.direction.dot(then) > 0.0 || time == 0.0 { time } else { f64::INFINITY }
    }

    /// Safe steps, each over which the atom is certainly above the face or beyond its ends.
    ///
    /// Both excesses are the sum of a motion on a circle and one on a line, along directions that stay: their second
    /// derivatives are at most K = ω² r, and change no faster than |ω|³ r. See [`Exact`](crate::Exact) for the proof.
    fn search(&self, window: Window, most_steps: u32, evaluations: &mut u32) -> PairOutcome {
        let mut time = window.begin;
        for count in 0..most_steps.max(1) {
            let at = self.flight.at(time);
            let now = self.gap(&at);
            *evaluations += 1;
            let is_beyond = now.beyond.value > now.error;
            let past_end = if is_beyond { self.step(&now, &now.beyond) } else { 0.0 };
            let step = if now.across.value > now.error {
                let step = self.step(&now, &now.across);
                if let Some(landing) = self.landing(&now, step, now.error) {
                    return contact_within(time + landing, window.end);
                }
                step.max(past_end)
            } else if is_beyond {
                past_end
            } else if self.closes(&now) {
                return contact_within(time + self.polish(&now, now.error), window.end);
            } else if count == 0 && self.comes_back_soon(&now) {
                match self.recontact(&at, &now, window.end, evaluations) {
                    Ok(contact) => return contact_within(contact, window.end),
                    Err(step) => step,
                }
            } else {
                self.touching_step(&now)
            };
            time = (time + step).max(time.next_up());
            if time > window.end {
                return PairOutcome::Free;
            }
        }
        PairOutcome::OutOfBudget(time)
    }

    pub(crate) fn gap(&self, at: &Placement) -> FaceGap {
        let arm = at.arm(self.body, self.atom.offset);
        // Exact negation: which body is called A changes no bit.
        let centre = if self.body == 1 { at.separation } else { -at.separation };
        self.gap_from(centre + arm, arm, at.time)
    }

    fn gap_from(&self, place: DVec2, arm: DVec2, time: f64) -> FaceGap {
        let spin = self.flight.spin[self.body];
        let velocity = self.velocity_of(arm);
        let acceleration = -(spin * spin) * arm;
        let excess = |direction: DVec2, beyond: f64| Excess {
            direction,
            value: direction.dot(place) - beyond,
            rate: direction.dot(velocity),
            bend: direction.dot(acceleration),
        };
        let behind = !self.face.is_solid_behind() && self.normal.dot(place) < 0.0;
        let outwards = if behind { -self.normal } else { self.normal };
        let endwards = if self.along.dot(place) < 0.0 { -self.along } else { self.along };
        FaceGap {
            place,
            across: excess(outwards, self.contact_distance),
            beyond: excess(endwards, self.face.half_length()),
            error: self.error.at(time),
            rate_error: self.error.of_rate(time),
        }
    }

    /// Velocity of the atom as seen from the face.
    fn velocity_of(&self, arm: DVec2) -> DVec2 {
        let velocity = self.flight.motion.velocity;
        let of_centre = if self.body == 1 { velocity } else { -velocity };
        of_centre + self.flight.spin[self.body] * arm.perp()
    }

    fn step(&self, now: &FaceGap, excess: &Excess) -> f64 {
        safe_step(excess.value, excess.rate - now.rate_error, &self.curvature(now, excess))
    }

    fn curvature(&self, now: &FaceGap, excess: &Excess) -> Curvature {
        let spin = self.flight.spin[self.body].abs();
        // The direction is off by 12 u, the arm by its share of E, and there are less than 12 roundings.
        let error = self.centripetal * (24.0 * U) + spin * spin * now.error;
        Curvature {
            along_normal: excess.bend - error,
            jerk: spin * self.centripetal,
            ..Curvature::at_most(self.centripetal)
        }
    }

    /// How far the contact is, if it is proved to be within `error` of the root of the gap's parabola, the atom to be
    /// closing still, and to stay between the ends. |g''| is at most K, as the gap is linear in the place: up to twice the
    /// root, the gap is no farther from its tangent than 2 K h².
    fn landing(&self, now: &FaceGap, step: f64, error: f64) -> Option<f64> {
        let across = &now.across;
        let root = (across.rate * across.rate - 2.0 * across.bend * across.value).max(0.0).sqrt();
        let contact = 2.0 * across.value / (root - across.rate);
        let reach = step.max(contact);
        let bend = self.centripetal * reach;
        let lands = 4.0 * bend * reach <= error && across.rate + 2.5 * bend < -now.rate_error;
        let stays = now.beyond.value + now.error + 2.0 * reach * self.error.speed() <= 0.0;
        (lands && stays).then_some(contact)
    }

    /// Whether an atom within E of contact, or overlapping, is in contact rather than leaving or touching.
    fn closes(&self, now: &FaceGap) -> bool {
        let resolved = self.flight.motion.velocity_error;
        now.across.rate < -if now.across.value < -now.error { resolved } else { now.rate_error }
    }

    /// The last Newton correction towards g = 0, where it provably lands within `error` of it, and between the ends.
    fn polish(&self, now: &FaceGap, error: f64) -> f64 {
        let correction = -now.across.value / now.across.rate;
        let safe = now.across.value > 0.0
            && self.centripetal * correction * correction <= error
            && now.beyond.value + self.error.speed() * correction <= 0.0;
        if safe { correction } else { 0.0 }
    }

    /// Step of an atom that leaves or touches: to where the bound from below reaches min(g, 0) − E.
    fn touching_step(&self, now: &FaceGap) -> f64 {
        let across = &now.across;
        let fall = across.value - across.value.min(0.0) + now.error;
        safe_step(fall, across.rate - now.rate_error, &self.curvature(now, across))
    }

    /// Whether an atom that parts may be back before it has gone far enough for the plain gap to tell.
    fn comes_back_soon(&self, now: &FaceGap) -> bool {
        let away = now.across.rate - now.rate_error;
        now.across.value >= -now.error
            && away > 0.0
            && 2.0 * away * self.error.speed() < SOON * self.centripetal * self.contact_distance
    }

    /// When an atom in contact at the placement `at` that parts is in contact again (`Ok`, a time), or how long it is
    /// certainly not (`Err`, a duration).
    ///
    /// As for two atoms (see `recontact`), but simpler: g(h) − g(0) = n·(V h + (R(ω h) − 1) r), off by at most
    /// h (E' + 8 u L).
    fn recontact(
        &self,
        at: &Placement,
        start: &FaceGap,
        limit: f64,
        evaluations: &mut u32,
    ) -> Result<f64, f64> {
        let away = start.across.rate - start.rate_error;
        let arm = at.arm(self.body, self.atom.offset);
        // Up to 2 g'/K the gap is not below what it was.
        let mut elapsed = 2.0 * away / self.centripetal * (1.0 - STEP_MARGIN);
        for _ in 0..MOST_RECONTACT_STEPS {
            if at.time + elapsed > limit {
                break;
            }
            let swing = swing(self.flight.spin[self.body], elapsed, arm);
            let moved = self.velocity_of(DVec2::ZERO) * elapsed + swing;
            let mut now = self.gap_from(start.place + moved, arm + swing, at.time + elapsed);
            now.across.value = start.across.direction.dot(moved);
            *evaluations += 1;
            let error = (now.rate_error + 8.0 * U * self.error.speed()) * elapsed;
            if error >= now.error || error.is_nan() || now.beyond.value > -now.error {
                break;
            }
            if now.across.value > error {
                let step = self.step(&now, &now.across);
                if let Some(landing) = self.landing(&now, step, error) {
                    return Ok(at.time + (elapsed + landing));
                }
                elapsed = (elapsed + step).max(elapsed.next_up());
            } else if now.across.rate < -now.rate_error {
                return Ok(at.time + (elapsed + self.polish(&now, error)));
            } else {
                break;
            }
        }
        Err(elapsed)
    }
}

fn contact_within(time: f64, limit: f64) -> PairOutcome {
    if time <= limit { PairOutcome::Contact(time) } else { PairOutcome::Free }
}
