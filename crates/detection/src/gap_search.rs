//! The certified search: steps along the gap between two parts of two bodies, none of which can pass over a contact.
//!
//! The two parts are two atoms ([`AtomPair`](crate::atom_pair::AtomPair)) or an atom and a straight face
//! ([`FacePair`](crate::face_pair::FacePair)). Both give a [`GapFunction`]: the gap g, its derivatives, and bounds on their
//! rounding. The method is conservative advancement; the lemmas below are its proof.
//!
//! # Notation
//! d(t) is the vector between the centres of the two parts (for a face: from its plane), s the sum of their radii, n the
//! unit vector along d (the normal of the face), g = n·d − s, and g' = n·d'. The arms r of the atoms turn with the angular
//! velocities ω; the centres of mass move with V relative to each other. For all time
//!
//! |d'| ≤ L = |V| + |ω_A| r_A + |ω_B| r_B,  |d''| ≤ K = ω_A² r_A + ω_B² r_B,  |d'''| ≤ K₃ = |ω_A|³ r_A + |ω_B|³ r_B.
//!
//! E bounds the rounding of g, E' that of g' ([`ErrorBound`](crate::ErrorBound), [`FaceErrorBound`](crate::FaceErrorBound)).
//! g, g' and g'' without further mention are the computed values.
//!
//! # Lemmas
//! 1. **Step.** If −n·d'' ≤ k over the next h for the normal n of now, the exact gap stays above g + g' h − k h²/2. *Proof.*
//!    |d(t+h)| ≥ n·d(t+h) = n·d + n·d' h + ∬ n·d''. For a face the gap is linear in the place and this is an identity.
//! 2. **Growing bounds.** A bound k₀ + k₁ u on −n·d'' at the time u from now may be replaced by the constant k₀ + k₁ H/3 for
//!    all h ≤ H. *Proof.* ∬ (k₀ + k₁ u) = k₀ h²/2 + k₁ h³/6.
//! 3. **Four bounds**, of which the least is taken:
//!    * K;
//!    * K₃ H/3 − n·d'', since n·d'' changes no faster than K₃;
//!    * |d''| + J H/3 with J = min(ω_A² r_A, ω_B² r_B) |ω_B − ω_A|. *Proof.* In the frame that turns with A the acceleration
//!      is ω_A² q_A − ω_B² R((ω_B − ω_A) t) q_B, of equal length, and changes only as B turns relative to A; likewise with
//!      B. Without this bound, bodies that move along with equal angular velocities take thousands of steps;
//!    * C₃ H/3 − g'', from the Taylor expansion of g. With p and q the components of d' and d'' across n, g'' = n·d'' +
//!      p²/|d| and g''' = n·d''' + 3 p q/|d| − 3 p² g'/|d|². As p² |g'| ≤ 2 |d'|³/√27 and |d| ≥ s up to the first
//!      contact, |g'''| ≤ C₃ = K₃ + 3 L K/s + 1.2 L³/s². (2·3/√27 = 1.1547; the difference to 1.2 covers |d| ≥ s − 2 E as long
//!      as s ≥ 53 E. For smaller atoms `GapFunction` gives no C₃.) For a face C₃ = K₃.
//! 4. **Other certificates.** Of several certified steps the longest is taken. An atom of a fast rotor stays on a circle of
//!    radius r about its body's centre, so the other atom may be stepped against the disc of radius r + s about that centre.
//!    An atom beyond the end of a face cannot touch the face before it enters the span; the step of Lemma 1 along the face
//!    leads there. Outside the time window in which the centres of mass are within r_A + r_B + s there is no contact.
//! 5. **Rounding of a step.** A step is taken only where g > E, with g' − E' for g'. Over the step the exact gap is then at
//!    least −E − L u t, and L u t < E: no contact deeper than 2 E is passed. The step itself is computed by a dozen
//!    roundings in a form without cancellation and is shortened by sixteen
//!    ([`STEP_MARGIN`](crate::tolerance::STEP_MARGIN)), which covers the roundings of K, K₃, J and C₃. n·d'' and |d''| come
//!    with a bound of their own; p is off by no more than E', as g' is.
//! 6. **Landing.** Near the contact the root h of g + g' h + g'' h²/2 is reported without another look. Up to there the gap
//!    differs from the parabola by C₃ h³/6 and by h (E' + h E''); C₃ h³ and h (E' + h E'') must each be within E/4, so the
//!    gap at h is within 2 E of 0. The rate there, −√(g'² − 2 g'' g) to within C₃ h²/2 + E' + h E'', must be below −E'.
//! 7. **Last correction.** A pair found within E of contact is corrected by −g/g' if C h² ≤ E, with C = K + |d'|²/|d| (for a
//!    face K). *Proof.* By concavity of the root |d(t+h)| ≤ |d| + g' h + C h²/2.
//! 8. **Contact.** A pair with |g| ≤ E touches. It is in contact if g' < −E'. A pair with g < −E/8 is deep
//!    ([`RESTING_DEPTH`](crate::tolerance::RESTING_DEPTH)). It is in contact unless g' ≥ E', that is, unless it certainly
//!    parts. A pair that touches and neither closes nor is deep is left alone, up to where the bound of Lemma 1 is E/8
//!    below min(g, 0). Every contact so decided has |g| ≤ 2 E exactly, unless the pair was deeper already.
//! 9. **No sinking.** Let each contact end with the parts separating at 2 E' or faster. Then no pair gets deeper than
//!    E/4 by its computed gap, or 5/4 E exactly, however many contacts it has. *Proof.* A pair that touches is followed to a
//!    computed gap of −E/4 at most. A deep pair that parts is followed only as long as Lemma 1 certifies that the gap is
//!    not below its present value, until it no longer parts; it is then in contact by Lemma 8, no deeper than before.
//!    A pair that is back very soon is followed by its gap relative to the last contact (Lemma 10), which ends where it
//!    began to within 10⁻² E. What remains is the rounding of places at each contact, which the engine directs outwards
//!    for deep pairs.
//! 10. **Gap since the contact.** While a pair is within E of contact the gap is lost in E; its change since the contact is
//!     not. With δ = d(h) − d(0) = V h + (R(ω_B h) − 1) r_B − (R(ω_A h) − 1) r_A and (R(φ) − 1) r = −2 sin²(φ/2) r +
//!     sin φ r^⊥, g(h) − g(0) = δ·(2 d(0) + δ)/(|d(h)| + |d(0)|) is a sum of terms that are each known to a few roundings of
//!     themselves (for a face: n·δ). It is off by at most h (E' + 8 u L). Lemmas 1 to 7 apply with this in place of E as long
//!     as it is smaller. The contact is put where the gap is g(0) again.
//! 11. **End.** While g > E either g falls by a fixed factor or the step is of the order √(E/K). Each pair has
//!     [`MOST_STEPS`](crate::tolerance::MOST_STEPS) steps, each of at least one float; a search that runs out is "certified
//!     free until". Comparisons are written so that NaN never counts as free.

use carom_kinematics::HALF_ULP as U;

use crate::{
    safe_step::{Curvature, safe_step, short_step},
    search::Search,
    tolerance::{MOST_RECONTACT_STEPS, RESTING_DEPTH, SHORT_STEPS, SOON, STEP_MARGIN},
};

/// How the search for one pair of parts ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum PairOutcome {
    /// They touch at this time.
    Contact(f64),
    /// They do not touch before the limit.
    Free,
    /// The steps are used up; they do not touch before this time.
    OutOfBudget(f64),
    /// They do not touch before this time, which is later than that from which another pair has to be followed first.
    Paused(f64),
}

/// The gap between two parts at one moment, its derivatives, and bounds on their rounding.
pub(crate) struct Gap {
    /// g (length).
    pub(crate) value: f64,
    /// g' (length per time).
    pub(crate) rate: f64,
    /// g'' (length per time squared).
    pub(crate) second: f64,
    /// 1/(E' − g') (time per length): for a gap that certainly closes or may close, how slowly at least; negative for one
    /// that widens.
    pub(crate) slowness: f64,
    /// E (length).
    pub(crate) error: f64,
    /// E' (length per time).
    pub(crate) rate_error: f64,
    /// Bounds on how the gap bends from now on.
    pub(crate) curvature: Curvature,
}

/// The gap between two parts of two bodies in flight, as a function of time, and the search for its first zero.
pub(crate) trait GapFunction {
    /// Where the two parts are at one moment.
    type Pose;

    /// Places the parts at a time.
    fn pose(&self, time: f64) -> Self::Pose;

    /// The gap of the parts in a pose.
    fn gap(&self, pose: &Self::Pose) -> Gap;

    /// The pose `elapsed` (time) after `start`, and how much the gap has widened since (Lemma 10). `None` where the parts
    /// may no longer be those that touch.
    fn moved(&self, start: &Self::Pose, elapsed: f64) -> Option<(Self::Pose, f64)>;

    /// L: no point of one part moves faster relative to the other (length per time).
    fn top_speed(&self) -> f64;

    /// s: the gap's distance in contact (length).
    fn contact_distance(&self) -> f64;

    /// How long the parts are certainly apart for another reason than their gap (Lemma 4); 0 if there is none.
    fn other_step(&self, pose: &Self::Pose) -> f64;

    /// Whether the parts stay those that can touch for `duration` (time) after a pose.
    fn stays(&self, pose: &Self::Pose, duration: f64) -> bool;

    /// The first time from `time` on at which the bodies are near enough for a contact of these parts, if there is one up
    /// to `limit`.
    fn within_reach(&self, time: f64, limit: f64) -> Option<f64>;

    /// The first contact from `begin` on, before which there must be none, up to `limit`. Once past `pause`, the search of
    /// a pair that does not close is interrupted. `steps` counts the steps of the pair over all interruptions.
    #[inline]
    fn first_contact(
        &self,
        begin: f64,
        [pause, limit]: [f64; 2],
        steps: &mut u32,
        search: &mut Search,
    ) -> PairOutcome {
        let mut time = begin;
        loop {
            match self.within_reach(time, limit) {
                Some(entry) => time = entry,
                None => return PairOutcome::Free,
            }
            let pose = self.pose(time);
            let now = self.gap(&pose);
            search.evaluations += 1;
            *steps += 1;
            let other_step = self.other_step(&pose);
            let step = if now.value > now.error {
                if let Some(landing) = now.landing(now.error).filter(|&h| self.stays(&pose, h)) {
                    return contact_within(time + landing, limit);
                }
                let step = now.step(*steps <= SHORT_STEPS);
                if other_step > step { other_step } else { step }
            } else if other_step > 0.0 {
                other_step
            } else if now.is_contact() {
                return contact_within(time + self.last_correction(&pose, &now, now.error), limit);
            } else if *steps == 1 && self.is_back_soon(&now) {
                match self.recontact(&pose, &now, time, limit, &mut search.evaluations) {
                    Ok(contact) => return contact_within(contact, limit),
                    Err(step) => step,
                }
            } else {
                self.touching_step(&now)
            };
            let next = time + step;
            time = if next > time { next } else { time.next_up() };
            if time > limit {
                return PairOutcome::Free;
            }
            if *steps >= search.most_steps {
                return PairOutcome::OutOfBudget(time);
            }
            // A falling gap is followed to its end: that is mostly the answer.
            if time > pause && now.rate >= 0.0 {
                return PairOutcome::Paused(time);
            }
        }
    }

    /// The last Newton step to g = 0 where Lemma 7 proves that it ends within `error` of it; 0 elsewhere.
    fn last_correction(&self, pose: &Self::Pose, now: &Gap, error: f64) -> f64 {
        let correction = -now.value / now.rate;
        let is_safe = now.value > 0.0
            && now.curvature.upwards * correction * correction <= error
            && self.stays(pose, correction);
        if is_safe { correction } else { 0.0 }
    }

    /// Step of a pair that touches or overlaps and is not in contact: E deeper at most for a touching pair, no deeper
    /// for a deep one (Lemma 9).
    fn touching_step(&self, now: &Gap) -> f64 {
        // No gap closes faster than L, even where E' is infinite because the centres coincide.
        let rate = (now.rate - now.rate_error).max(-self.top_speed());
        safe_step(now.fall(), rate, &now.curvature)
    }

    /// Whether a pair that parts may be back before it has gone far enough for E to resolve its gap.
    fn is_back_soon(&self, now: &Gap) -> bool {
        let away = now.rate - now.rate_error;
        away > 0.0 && 2.0 * away * self.top_speed() < SOON * now.curvature.largest * self.contact_distance()
    }

    /// When a pair that parts from a contact at `time` is in contact again (`Ok`, a time), or how long it certainly is not
    /// (`Err`, a duration). See Lemma 10.
    #[cold]
    fn recontact(
        &self,
        start: &Self::Pose,
        at_start: &Gap,
        time: f64,
        limit: f64,
        evaluations: &mut u32,
    ) -> Result<f64, f64> {
        let away = at_start.rate - at_start.rate_error;
        // Up to 2 g'/K the gap is not below its value at the start.
        let mut elapsed = 2.0 * away / at_start.curvature.largest * (1.0 - STEP_MARGIN);
        for _ in 0..MOST_RECONTACT_STEPS {
            if time + elapsed > limit {
                break;
            }
            let Some((pose, widened)) = self.moved(start, elapsed) else { break };
            let now = Gap { value: widened, ..self.gap(&pose) };
            *evaluations += 1;
            let error = (now.rate_error + 8.0 * U * self.top_speed()) * elapsed;
            if error >= now.error || error.is_nan() {
                break;
            }
            if now.value > error {
                if let Some(landing) = now.landing(error).filter(|&h| self.stays(&pose, h)) {
                    return Ok(time + (elapsed + landing));
                }
                elapsed = (elapsed + now.step(false)).max(elapsed.next_up());
            } else if now.rate < -now.rate_error {
                return Ok(time + (elapsed + self.last_correction(&pose, &now, error)));
            } else {
                break;
            }
        }
        Err(elapsed)
    }
}

impl Gap {
    /// Whether the parts are deeper in each other than parts that rest (Lemma 8).
    fn is_deep(&self) -> bool {
        self.value < -RESTING_DEPTH * self.error
    }

    /// How much deeper parts may get before the next look, if they touch or overlap and are not in contact (Lemmas 8
    /// and 9): to E/8 below min(g, 0) if they touch, no deeper than they are if they are deep.
    pub(crate) fn fall(&self) -> f64 {
        if self.is_deep() { 0.0 } else { self.value - self.value.min(0.0) + RESTING_DEPTH * self.error }
    }

    /// Whether parts that touch or overlap are in contact (Lemma 8).
    pub(crate) fn is_contact(&self) -> bool {
        self.rate < if self.is_deep() { self.rate_error } else { -self.rate_error }
    }

    /// A step over which the gap, now positive, certainly does not close.
    #[inline]
    fn step(&self, is_short: bool) -> f64 {
        let rate = self.rate - self.rate_error;
        if is_short {
            short_step(self.value, rate, self.slowness, &self.curvature)
        } else {
            safe_step(self.value, rate, &self.curvature)
        }
    }

    /// How far the contact is, if that can be told to within `error` from here, and the pair still closes then (Lemma 6).
    #[inline]
    pub(crate) fn landing(&self, error: f64) -> Option<f64> {
        // Mostly it is far too far, which this decides without a square root.
        let straight = self.value * self.slowness;
        if self.curvature.gap_jerk * straight * straight * straight > error {
            return None;
        }
        let slope = (self.rate * self.rate - 2.0 * self.second * self.value).sqrt();
        let landing = 2.0 * self.value / (slope - self.rate);
        let third = self.curvature.gap_jerk * landing * landing;
        // E' and h E''; g'' lies as far above its lower bound as its upper bound does above it.
        let rate_error = self.rate_error + 2.0 * (self.second - self.curvature.of_gap) * landing;
        let lands = 4.0 * landing * third.max(rate_error) <= error
            && self.rate < 0.0
            && slope > 2.0 * rate_error + third;
        lands.then_some(landing)
    }
}

/// A contact at `time`, unless that is past `limit`.
pub(crate) fn contact_within(time: f64, limit: f64) -> PairOutcome {
    if time <= limit { PairOutcome::Contact(time) } else { PairOutcome::Free }
}
