//! The gap between an atom in flight and a straight face of finite length.

use carom_geometry::{Circle, Face};
use carom_kinematics::HALF_ULP as U;
use glam::DVec2;

use crate::{
    FaceErrorBound, Phase,
    atom_pair::{centripetal, swing},
    flight::{Flight, Pose},
    gap_search::{Gap, GapFunction, contact_within},
    safe_step::{Curvature, safe_step},
    search::{PairOutcome, Search},
    strip::Strip,
    trace::Recorder,
};

/// An atom of one body and the face of the other, which does not turn, in the notation of
/// [`gap_search`](crate::gap_search).
pub(crate) struct FacePair<'a> {
    flight: &'a Flight<'a>,
    /// The number of the body with the atom (0 for A, 1 for B).
    body: usize,
    atom: Circle,
    face: &'a Face,
    /// Unit vectors along the face and normal to it.
    along: DVec2,
    normal: DVec2,
    /// s
    contact_distance: f64,
    /// K = ω² r, the bound on |d''| at all times.
    centripetal: f64,
    error: FaceErrorBound,
}

/// An atom at one time, relative to the face.
pub(crate) struct FacePose {
    time: f64,
    /// From the centre of the face to the centre of the atom.
    place: DVec2,
    /// Arm of the atom in its present orientation.
    arm: DVec2,
    /// The normal on the atom's side, and the direction along the face to the nearer end.
    outwards: DVec2,
    endwards: DVec2,
}

/// A distance in one direction, and its first two time derivatives.
#[derive(Clone, Copy)]
pub(crate) struct Excess {
    pub(crate) value: f64,
    pub(crate) rate: f64,
    /// Second derivative.
    second: f64,
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
            centripetal: centripetal(spin, atom.arm),
            error: FaceErrorBound::with_spin(flight.motion, body, spin, &atom, face),
        }
    }

    /// The first contact with the face between its ends, up to `limit`.
    pub(crate) fn first_contact_in_span<R: Recorder>(
        &self,
        limit: f64,
        search: &mut Search<R>,
    ) -> PairOutcome {
        let room = self.atom.arm + self.atom.radius;
        let window = Strip::window(self.flight.motion, self.body, self.face, room, limit);
        match window {
            None => PairOutcome::Free,
            Some(window) if self.centripetal == 0.0 => {
                search.evaluations += 1;
                let time = self.straight_contact();
                search.recorder.step(Phase::ClosedForm, 0.0, Some(time));
                contact_within(time, window.end)
            }
            Some(window) => {
                self.first_contact(window.begin, [f64::INFINITY, window.end], &mut 0, search)
            }
        }
    }

    /// The contact time of an atom in uniform motion with the face; infinite if there is none.
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
        let in_span = self.along.dot(then).abs() - self.face.half_length() <= self.error.at(time);
        if in_span && pose.outwards.dot(then) > 0.0 || time == 0.0 {
            time
        } else {
            f64::INFINITY
        }
    }

    fn spin(&self) -> f64 {
        self.flight.spin[self.body]
    }

    /// Velocity of the atom relative to the face.
    fn velocity_of(&self, arm: DVec2) -> DVec2 {
        let velocity = self.flight.motion.velocity;
        let of_centre = if self.body == 1 { velocity } else { -velocity };
        of_centre + self.spin() * arm.perp()
    }

    fn pose_of(&self, time: f64, place: DVec2, arm: DVec2) -> FacePose {
        let is_behind = !self.face.is_solid_behind() && self.normal.dot(place) < 0.0;
        let outwards = if is_behind { -self.normal } else { self.normal };
        let endwards = if self.along.dot(place) < 0.0 {
            -self.along
        } else {
            self.along
        };
        FacePose {
            time,
            place,
            arm,
            outwards,
            endwards,
        }
    }

    /// The distance of the atom in one direction (length) less `distance`, and its derivatives.
    fn excess(&self, pose: &FacePose, direction: DVec2, distance: f64) -> Excess {
        let spin = self.spin();
        Excess {
            value: direction.dot(pose.place) - distance,
            rate: direction.dot(self.velocity_of(pose.arm)),
            second: direction.dot(-(spin * spin) * pose.arm),
        }
    }

    /// The distance of the atom's centre beyond the nearer end of the face; at most 0 in the span.
    pub(crate) fn beyond(&self, pose: &FacePose) -> Excess {
        self.excess(pose, pose.endwards, self.face.half_length())
    }

    /// The curvature of the excess in a direction. The excess is linear in the position of the
    /// atom, so its second derivative is at most K = ω² r and changes at a rate of at most |ω|³ r.
    fn curvature(&self, excess: &Excess, error: f64) -> Curvature {
        let spin = self.spin().abs();
        // The direction has an error of 12 u, the arm its share of E, and there are fewer than 12
        // roundings.
        let second_error = self.centripetal * (24.0 * U) + spin * spin * error;
        let least = excess.second - second_error;
        let jerk = spin * self.centripetal;
        Curvature {
            along_normal: least,
            of_gap: least,
            jerk,
            gap_jerk: jerk,
            upwards: self.centripetal,
            ..Curvature::at_most(self.centripetal)
        }
    }
}

impl GapFunction for FacePair<'_> {
    type Pose = FacePose;

    fn pose(&self, time: f64) -> FacePose {
        let at: Pose = self.flight.at(time);
        let arm = at.arm(self.body, self.atom.offset);
        // Negation is exact, so exchanging A and B changes no bit.
        let centre = if self.body == 1 {
            at.separation
        } else {
            -at.separation
        };
        self.pose_of(time, centre + arm, arm)
    }

    fn gap(&self, pose: &FacePose) -> Gap {
        let across = self.excess(pose, pose.outwards, self.contact_distance);
        let (error, rate_error) = (self.error.at(pose.time), self.error.of_rate(pose.time));
        Gap {
            value: across.value,
            rate: across.rate,
            second: across.second,
            slowness: 1.0 / (rate_error - across.rate),
            error,
            rate_error,
            curvature: self.curvature(&across, error),
        }
    }

    fn moved(&self, start: &FacePose, elapsed: f64) -> Option<(FacePose, f64)> {
        let swing = swing(self.spin(), elapsed, start.arm);
        let moved = self.velocity_of(DVec2::ZERO) * elapsed + swing;
        let time = start.time + elapsed;
        let pose = FacePose {
            outwards: start.outwards,
            ..self.pose_of(time, start.place + moved, start.arm + swing)
        };
        let is_in_span = self.beyond(&pose).value <= -self.error.at(time);
        is_in_span.then(|| (pose, start.outwards.dot(moved)))
    }

    fn top_speed(&self) -> f64 {
        self.error.speed()
    }

    fn contact_distance(&self) -> f64 {
        self.contact_distance
    }

    /// A certified time for which an atom beyond an end stays there.
    fn other_step(&self, pose: &FacePose) -> f64 {
        let (beyond, error) = (self.beyond(pose), self.error.at(pose.time));
        if beyond.value > error {
            let rate = beyond.rate - self.error.of_rate(pose.time);
            safe_step(beyond.value, rate, &self.curvature(&beyond, error))
        } else {
            0.0
        }
    }

    fn stays(&self, pose: &FacePose, duration: f64) -> bool {
        let way = 2.0 * duration * self.error.speed();
        self.beyond(pose).value + self.error.at(pose.time) + way <= 0.0
    }

    /// Always `time`: the window of the search already covers all times within reach.
    fn within_reach(&self, time: f64, _: f64) -> Option<f64> {
        Some(time)
    }
}
