//! The certified search for the first zero of the gap between two parts of two bodies, by
//! conservative advancement.
//!
//! The parts are two atoms ([`AtomPair`](crate::atom_pair::AtomPair)) or an atom and a straight
//! edge ([`EdgePair`](crate::edge_pair::EdgePair)). Each gives a [`GapFunction`]: the gap g, its
//! derivatives, and bounds on their rounding. The lemmas below prove that no step passes a contact.
//!
//! # Notation
//! d(t) is the vector from the centre of one part to the centre of the other (for an edge: from its
//! line). s is the sum of their radii. n is the unit vector along d (for an edge: its normal). g =
//! n·d − s and g' = n·d'. The arms r of the atoms turn with the angular velocities ω. The centres
//! of mass move with the relative velocity V. At all times:
//!
//! * |d'| ≤ L = |V| + |ω_A| r_A + |ω_B| r_B;
//! * |d''| ≤ K = ω_A² r_A + ω_B² r_B;
//! * |d'''| ≤ K₃ = |ω_A|³ r_A + |ω_B|³ r_B.
//!
//! E bounds the rounding of g, and E' that of g' ([`ErrorBound`](crate::ErrorBound),
//! [`EdgeErrorBound`](crate::EdgeErrorBound)); E'' is the bound on the error of g'' used in the
//! code. u = 2⁻⁵³. Unless stated otherwise, g, g' and g'' are the computed values. J and C₃ are
//! defined in Lemma 3. R(φ) is the rotation by φ.
//!
//! # Lemmas
//! 1. **Step.** Let n be the normal at the start of the step. If −n·d'' ≤ k over the next h, then
//!    the exact gap after h is at least g + g' h − k h²/2. *Proof.* |d(t+h)| ≥ n·d(t+h) = n·d +
//!    n·d' h + ∬ n·d''. For an edge y replaces n·d, and the relation is an
//!    equality ([`edge_pair`](crate::edge_pair), Lemma 3).
//! 2. **Growing bounds.** A bound k₀ + k₁ τ on −n·d'' at the time τ from now may be replaced by the
//!    constant k₀ + k₁ H/3 for all h ≤ H. *Proof.* ∬ (k₀ + k₁ τ) = k₀ h²/2 + k₁ h³/6.
//! 3. **Bounds on the curvature.** Each of the following is a valid k for h ≤ H; the search uses
//!    the smallest:
//!    * K;
//!    * K₃ H/3 − n·d''. *Proof.* The rate of change of n·d'' is at most K₃; Lemma 2.
//!    * |d''| + J H/3 with J = min(ω_A² r_A, ω_B² r_B) |ω_B − ω_A|. *Proof.* In the frame that
//!      turns with A the acceleration is ω_A² q_A − ω_B² R((ω_B − ω_A) t) q_B. It has the same
//!      length, and it changes only by the rotation of B relative to A. The same holds with A and B
//!      exchanged. Without this bound, bodies that move side by side with equal angular velocities
//!      take thousands of steps;
//!    * C₃ H/3 − g''. *Proof.* Taylor expansion of g. Let p and q be the components of d' and d''
//!      across n. Then g'' = n·d'' + p²/|d| and g''' = n·d''' + 3 p q/|d| − 3 p² g'/|d|². Since p²
//!      |g'| ≤ 2 |d'|³/√27, and |d| ≥ s up to the first contact, |g'''| ≤ C₃ = K₃ + 3 L K/s + 1.2
//!      L³/s². Here 2·3/√27 = 1.1547; the difference to 1.2 covers |d| ≥ s − 2 E as long as s ≥ 53
//!      E. For smaller atoms the `GapFunction` gives no C₃. For an edge C₃ = K₃.
//! 4. **Other certificates.** The search takes the longest of several certified steps.
//!    * An atom of a fast rotor stays on a circle of radius r about the centre of its body, so the
//!      other atom may be stepped against the disc of radius r + s about that centre.
//!    * An atom beyond the end of an edge cannot touch it before it enters the span. The step of
//!      Lemma 1 along the edge bounds that time.
//!    * Outside the time window in which the centres of mass are within r_A + r_B + s there is no
//!      contact.
//! 5. **Rounding of a step.** A step is taken only where g > E, with g' − E' in place of g'. No
//!    contact deeper than 2 E is passed. *Proof.* Over the step the exact gap is at least −E − L u
//!    t, and L u t < E. The step itself is computed with about twelve roundings, in a form without
//!    cancellation, and is shortened by a relative 16 u
//!    ([`STEP_MARGIN`](crate::tolerance::STEP_MARGIN)), which also covers the roundings of K, K₃, J
//!    and C₃. n·d'' and |d''| have error bounds of their own. The error of p, like that of g', is
//!    at most E'.
//! 6. **Landing.** Near a contact the root h of g + g' h + g'' h²/2 is reported without a further
//!    evaluation, if C₃ h³ and h (E' + h E'') are each at most E/4 and the rate at h is below −E'.
//!    The gap at h is then within 2 E of 0. *Proof.* Up to h the gap differs from the parabola by
//!    at most C₃ h³/6 and h (E' + h E''). The rate at h is −√(g'² − 2 g'' g) to within C₃ h²/2 + E'
//!    + h E''.
//! 7. **Last correction.** The time of a pair found within E of contact is corrected by −g/g' if C
//!    h² ≤ E, with h the correction and C = K + |d'|²/|d| (for an edge C = K). *Proof.* Since the
//!    square root is concave, |d(t+h)| ≤ |d| + g' h + C h²/2.
//! 8. **Contact.** A pair with |g| ≤ E touches. It is in contact if g' < −E'. A pair with g < −E/8
//!    is deep ([`RESTING_DEPTH`](crate::tolerance::RESTING_DEPTH)). It is in contact unless g' ≥
//!    E', that is, unless it certainly separates. A pair that touches, does not certainly close and
//!    is not deep is not in contact. Its search continues to where the bound of Lemma 1 is E/8
//!    below min(g, 0). Every contact decided in this way has |g| ≤ 2 E exactly, unless the pair was
//!    deeper already.
//! 9. **No sinking.** Let the parts separate at 2 E' or faster after each contact. Then no pair
//!    gets deeper than E/4 by its computed gap, or 5/4 E exactly, however many contacts it has.
//!    *Proof.* The search of a touching pair ends at a computed gap of −E/4 at the lowest. The
//!    search of a deep pair that separates advances only as long as Lemma 1 certifies that the gap
//!    is not below its present value, until the pair no longer separates. It is then in contact by
//!    Lemma 8, no deeper than before. A pair that returns very soon is searched by its gap relative
//!    to the last contact (Lemma 10); it returns to its initial gap within 10⁻² E. What remains is
//!    the rounding of positions at each contact, which the engine directs outwards for deep pairs.
//! 10. **Gap since the contact.** While a pair is within E of contact, E exceeds the gap, but the
//!     change of the gap since the contact is still resolved. Let δ = d(h) − d(0) = V h + (R(ω_B h)
//!     − 1) r_B − (R(ω_A h) − 1) r_A, with (R(φ) − 1) r = −2 sin²(φ/2) r + sin φ r^⊥. Then g(h) −
//!     g(0) = δ·(2 d(0) + δ)/(|d(h)| + |d(0)|) (for an edge: [`edge_pair`](crate::edge_pair), Lemma
//!     5) is a sum of terms each accurate to a few roundings. Its error is at most h (E' + 8 u L).
//!     Lemmas 1 to 7 apply with this error in place of E as long as it is smaller. The contact is
//!     placed where the gap is g(0) again.
//! 11. **Termination.** While g > E, either g falls by a fixed factor or the step is of the order
//!     √(E/K). Each pair has at most [`MAX_STEPS`](crate::tolerance::MAX_STEPS) steps, and each
//!     step advances by at least one floating-point number. A search that reaches the limit ends as
//!     "certified free until". Comparisons are written so that NaN never counts as free.

use carom_kinematics::HALF_ULP as U;

use crate::{
    Phase,
    safe_step::{Curvature, safe_step, short_step},
    search::{PairOutcome, Search},
    tolerance::{MAX_RECONTACT_STEPS, RESTING_DEPTH, SHORT_STEPS, SOON, STEP_MARGIN},
    trace::Recorder,
};

/// The gap between two parts at one time, its derivatives, and bounds on their rounding.
#[derive(Clone, Copy)]
pub(crate) struct Gap {
    /// g (length).
    pub(crate) value: f64,
    /// g' (length per time).
    pub(crate) rate: f64,
    /// g'' (length per time squared).
    pub(crate) second: f64,
    /// 1/(E' − g') (time per length): the inverse of the highest closing speed within the rounding;
    /// negative for a gap that widens.
    pub(crate) slowness: f64,
    /// E (length).
    pub(crate) error: f64,
    /// E' (length per time).
    pub(crate) rate_error: f64,
    /// Bounds on the curvature of the gap from this time on.
    pub(crate) curvature: Curvature,
}

/// The gap between two parts of two bodies in flight as a function of time, and the search for its
/// first zero.
pub(crate) trait GapFunction {
    /// The positions of the two parts at one time.
    type Pose;

    /// Returns the pose at a time.
    fn pose(&self, time: f64) -> Self::Pose;

    /// Returns the gap of the parts in a pose.
    fn gap(&self, pose: &Self::Pose) -> Gap;

    /// Returns the pose `elapsed` (time) after `start` and the growth of the gap since (length;
    /// Lemma 10). `None` where other parts may be the touching ones, and by default, for parts
    /// whose growth is not known without cancellation.
    fn moved(&self, _start: &Self::Pose, _elapsed: f64) -> Option<(Self::Pose, f64)> {
        None
    }

    /// L: a bound on the relative speed of any points of the two parts (length per time).
    fn top_speed(&self) -> f64;

    /// The distance of the centres in contact, or another length of the size of the bodies.
    fn size(&self) -> f64;

    /// A time for which the parts are certified apart for another reason than their gap (Lemma 4);
    /// 0 if there is none.
    fn other_step(&self, pose: &Self::Pose) -> f64;

    /// Whether the same parts stay those that can touch for `duration` (time) after a pose.
    fn stays(&self, pose: &Self::Pose, duration: f64) -> bool;

    /// The first time, from `time` to `limit`, at which the bodies are near enough for a contact of
    /// these parts.
    fn within_reach(&self, time: f64, limit: f64) -> Option<f64>;

    /// Returns the first contact of the parts between `begin` and `limit`; there must be none
    /// before `begin`. Past `pause` the search of a pair that does not close is interrupted.
    /// `steps` counts the steps of the pair over all interruptions.
    #[inline]
    fn first_contact<R: Recorder, T>(
        &self,
        begin: f64,
        [pause, limit]: [f64; 2],
        steps: &mut u32,
        search: &mut Search<R, T>,
    ) -> PairOutcome {
        let mut time = begin;
        loop {
            let Some(entry) = self.within_reach(time, limit) else {
                search
                    .recorder
                    .step(Phase::OutOfReach, time, Some(f64::INFINITY));
                return PairOutcome::Free;
            };
            if R::RECORDS && entry > time {
                search.recorder.step(Phase::OutOfReach, time, Some(entry));
            }
            time = entry;
            let pose = self.pose(time);
            let now = self.gap(&pose);
            search.evaluations += 1;
            *steps += 1;
            let step = if now.value > now.error {
                if let Some(landing) = now.landing(now.error).filter(|&h| self.stays(&pose, h)) {
                    search
                        .recorder
                        .step(Phase::Single, time, Some(time + landing));
                    return contact_within(time + landing, limit);
                }
                let step = now.step(*steps <= SHORT_STEPS);
                let other_step = self.other_step(&pose);
                if other_step > step { other_step } else { step }
            } else if let other_step = self.other_step(&pose)
                && other_step > 0.0
            {
                other_step
            } else if now.is_contact() {
                let contact = time + self.last_correction(&pose, &now, now.error);
                search.recorder.step(Phase::Single, time, Some(contact));
                return contact_within(contact, limit);
            } else if *steps == 1 && self.is_back_soon(&now) {
                match self.recontact(&pose, &now, time, limit, search) {
                    Ok(contact) => {
                        search.recorder.step(Phase::Single, time, Some(contact));
                        return contact_within(contact, limit);
                    }
                    Err(step) => step,
                }
            } else {
                self.touching_step(&now)
            };
            let next = time + step;
            let next = if next > time { next } else { time.next_up() };
            search.recorder.step(Phase::Single, time, Some(next));
            time = next;
            if time > limit {
                return PairOutcome::Free;
            }
            if *steps >= search.most_steps {
                return PairOutcome::OutOfBudget(time);
            }
            // A closing pair is not interrupted: it mostly gives the first contact.
            if time > pause && now.rate >= 0.0 {
                return PairOutcome::Paused(time);
            }
        }
    }

    /// The last Newton step to g = 0 where Lemma 7 proves that it ends within `error` of it; 0
    /// elsewhere.
    fn last_correction(&self, pose: &Self::Pose, now: &Gap, error: f64) -> f64 {
        let correction = -now.value / now.rate;
        let is_safe = now.value > 0.0
            && now.curvature.upwards * correction * correction <= error
            && self.stays(pose, correction);
        if is_safe { correction } else { 0.0 }
    }

    /// The step of a pair that touches or overlaps and is not in contact. The gap of a touching
    /// pair falls to E/8 below min(g, 0) at most, that of a deep pair not at all (Lemma 9).
    fn touching_step(&self, now: &Gap) -> f64 {
        // No gap closes faster than L, even where E' is infinite because the centres coincide.
        let rate = (now.rate - now.rate_error).max(-self.top_speed());
        safe_step(now.fall(), rate, &now.curvature)
    }

    /// Whether a pair that separates may return before E resolves its gap.
    fn is_back_soon(&self, now: &Gap) -> bool {
        let away = now.rate - now.rate_error;
        away > 0.0 && 2.0 * away * self.top_speed() < SOON * now.curvature.largest * self.size()
    }

    /// Returns the next contact of a pair that separates from a contact at `time` (`Ok`, a time),
    /// or a duration for which there certainly is none (`Err`). See Lemma 10.
    #[cold]
    fn recontact<R: Recorder, T>(
        &self,
        start: &Self::Pose,
        at_start: &Gap,
        time: f64,
        limit: f64,
        search: &mut Search<R, T>,
    ) -> Result<f64, f64> {
        let away = at_start.rate - at_start.rate_error;
        // Up to 2 g'/K the gap is not below its initial value.
        let mut elapsed = 2.0 * away / at_start.curvature.largest * (1.0 - STEP_MARGIN);
        for _ in 0..MAX_RECONTACT_STEPS {
            if time + elapsed > limit {
                break;
            }
            let Some((pose, widened)) = self.moved(start, elapsed) else {
                break;
            };
            let now = Gap {
                value: widened,
                ..self.gap(&pose)
            };
            search.evaluations += 1;
            search.recorder.step(Phase::Recontact, time + elapsed, None);
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
    /// Whether the parts overlap by more than parts that rest on each other (Lemma 8).
    fn is_deep(&self) -> bool {
        self.value < -RESTING_DEPTH * self.error
    }

    /// How much deeper parts that touch or overlap without contact may get before the next
    /// evaluation (length): for touching parts to E/8 below min(g, 0), for deep parts 0 (Lemmas 8
    /// and 9).
    pub(crate) fn fall(&self) -> f64 {
        if self.is_deep() {
            0.0
        } else {
            self.value - self.value.min(0.0) + RESTING_DEPTH * self.error
        }
    }

    /// Whether parts that touch or overlap are in contact (Lemma 8).
    pub(crate) fn is_contact(&self) -> bool {
        self.rate
            < if self.is_deep() {
                self.rate_error
            } else {
                -self.rate_error
            }
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

    /// The time to the contact, if it is accurate to within `error` and the pair still closes there
    /// (Lemma 6).
    #[inline]
    pub(crate) fn landing(&self, error: f64) -> Option<f64> {
        // Most contacts are much too far for a landing, which this test decides without a square
        // root.
        let straight = self.value * self.slowness;
        if self.curvature.gap_jerk * straight * straight * straight > error {
            return None;
        }
        let slope = (self.rate * self.rate - 2.0 * self.second * self.value).sqrt();
        let landing = 2.0 * self.value / (slope - self.rate);
        let third = self.curvature.gap_jerk * landing * landing;
        // E' and h E''; the upper bound of g'' is as far above g'' as the lower bound is below it.
        let rate_error = self.rate_error + 2.0 * (self.second - self.curvature.of_gap) * landing;
        let lands = 4.0 * landing * third.max(rate_error) <= error
            && self.rate < 0.0
            && slope > 2.0 * rate_error + third;
        lands.then_some(landing)
    }
}

/// A contact at `time`, unless that is past `limit`.
pub(crate) fn contact_within(time: f64, limit: f64) -> PairOutcome {
    if time <= limit {
        PairOutcome::Contact(time)
    } else {
        PairOutcome::Free
    }
}
