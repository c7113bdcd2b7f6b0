//! Certified contact detection: no contact deeper than rounding is missed, none is invented.
//!
//! # Guarantees
//! E is the bound on the rounding of the gap g ([`ErrorBound`](crate::ErrorBound)).
//!
//! * Every reported contact has |g| ≤ 2 E, unless the pair was deeper already.
//! * No contact deeper than 2 E is missed.
//! * No contact deeper than 2 E lies before the time of [`Outcome::FreeUntil`].
//! * Exchanging A and B changes no bit of the time.
//! * Multiplying all velocities by a power of two multiplies the time by its inverse, to the last
//!   bit.
//!
//! # Method
//! Each pair of parts is searched by the steps of [`gap_search`](crate::gap_search) (conservative
//! advancement), whose lemmas prove the guarantees for one pair of parts. For whole bodies:
//!
//! 1. **Windows.** A contact requires that the centres of mass are within R_A + R_B. The window of
//!    time in which they are follows from a parabola ([`skim`]), with R_A + R_B enlarged by more
//!    than the rounding of its coefficients.
//! 2. **Many pairs.** The first steps are taken for all pairs at once, from one placement of the
//!    bodies. The pairs are then searched one by one, in the order of their lower bounds. The
//!    search of a pair whose gap widens is interrupted when the bound of another pair is earlier.
//!    Pairs whose bound is later than a contact already found are skipped. If the search of a pair
//!    ends at its step limit, nothing after the time up to which the pair is certified is searched.
//! 3. **Many atoms.** The nodes of a tree of circles that hold atoms
//!    ([`CircleTree`](carom_geometry::CircleTree)) are searched as if they were atoms. The atoms
//!    lie inside their circles, rounding included, and cannot touch before the circles do. The
//!    search of two children therefore begins at the time up to which their parents are certified.
//!    These shared steps use g − E and pass no contact deeper than L u t.
//! 4. **Broad phase.** [`Detection::contact_time_lower_bounds`] computes lower bounds by one step
//!    from coarser data. The rounding subtracted there is larger than E ([`QueryBody`]). A search
//!    of bodies that turn begins at that bound.
//! 5. **Discs.** Contacts of bodies that do not turn follow from the closed form of
//!    [`disc_contact`].
//! 6. **Edges.** An atom is searched against a straight edge by its coordinates in the frame of the
//!    edge ([`edge_pair`](crate::edge_pair)). Bodies with edges are first kept apart by lines along
//!    their sides ([`lines`](crate::lines)).
//! 7. **Ellipses.** Convex parts are searched by their support functions, along directions that
//!    turn ([`support_pair`](crate::support_pair), [`support_edge`](crate::support_edge)).
//! 8. **Driven bodies.** A pair of which one body is driven is at each time a pair in uniform
//!    motion, with further bounds on the curvature of its gap ([`driven`](crate::driven)).
//! 9. **Range.** A query that holds NaN, an infinity, or a magnitude whose square could overflow
//!    results in [`Outcome::OutOfRange`]. Very slow and very fast pairs are searched in another
//!    unit of time, in which no product of velocities underflows.
//!
//! A half-plane that turns is not searched: the outcome is [`Outcome::Unresolved`] at time 0.

use carom_geometry::Outline;
use carom_kinematics::{Drive, RelativeMotion};

use crate::{
    Answer, Detection, DiscLanes, Outcome, QueryBody, SearchWindow, Trace, driven, edges, ellipses,
    flight::Flight,
    molecule_pair::{straight, turning},
    range::{OUT_OF_RANGE, Unit, faster, later, unit},
    search::Search,
    skim,
    tolerance::MAX_STEPS,
    trace::{Recorder, SearchLog},
};

/// The certified detector; the [crate] documentation compares it with the other detectors.
///
/// ```
/// use carom_detection::{Detection, Exact, Outcome, Touch};
/// use carom_geometry::{Molecule, Shape};
/// use carom_kinematics::RelativeMotion;
/// use glam::DVec2;
///
/// // A dumbbell (arms 1, radii 1, ω = 1) turns on the spot, 2.5 below a disc of radius 1 at rest.
/// // They touch when the centres of the two atoms are 2 apart.
/// let dumbbell = Molecule::named(Shape::Dumbbell, 1.0, 1.0)?;
/// let disc = Molecule::disc(1.0, 1.0)?;
/// let pair = RelativeMotion {
///     angular_velocity: [1.0, 0.0],
///     ..RelativeMotion::exactly(DVec2::new(0.0, 2.5), DVec2::ZERO)
/// };
/// let answer = Exact::default().first_contact(dumbbell.outline(), disc.outline(), &pair, 10.0);
/// let Outcome::Contact(contact) = answer.outcome else { panic!("the dumbbell hits the disc") };
/// // Law of cosines: 2² = 1² + 2.5² − 2 · 2.5 cos ψ; contact at a quarter turn less ψ.
/// let psi = f64::acos((1.0 + 6.25 - 4.0) / 5.0);
/// assert!((contact.time - (std::f64::consts::FRAC_PI_2 - psi)).abs() < 1e-15);
/// assert_eq!(contact.touch, Touch::Atoms(1, 0));
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Exact {
    /// Step limit of the search for one atom pair; see [`MAX_STEPS`].
    pub most_steps: u32,
}

impl Default for Exact {
    fn default() -> Self {
        Self {
            most_steps: MAX_STEPS,
        }
    }
}

impl Detection for Exact {
    fn searches_turning_walls(&self) -> bool {
        true
    }

    fn searches_curves(&self) -> bool {
        true
    }

    fn searches_driven_bodies(&self) -> bool {
        true
    }

    fn first_contact_driven(
        &self,
        begin: f64,
        bodies: [Outline<'_>; 2],
        motion: &RelativeMotion,
        drive: (&Drive, f64),
        horizon: f64,
    ) -> Answer {
        let [a, b] = bodies;
        // In its own unit of time, since the drive has another scale.
        if matches!(unit(a, b, motion, horizon), Unit::OutOfRange) {
            return OUT_OF_RANGE;
        }
        let horizon = horizon.min(f64::MAX);
        driven::first_contact((), self.most_steps, begin, bodies, motion, drive, horizon)
    }

    #[inline]
    fn decides_discs_in_closed_form(&self) -> bool {
        true
    }

    #[inline(always)]
    fn contact_time_lower_bounds<const N: usize>(
        &self,
        query: &QueryBody<'_>,
        lanes: &DiscLanes<N>,
        horizon: f64,
    ) -> [f64; N] {
        query.contact_time_lower_bounds(lanes, horizon)
    }

    #[inline(always)]
    fn contact_time_lower_bound(
        &self,
        query: &QueryBody<'_>,
        lanes: &DiscLanes<1>,
        horizon: f64,
    ) -> f64 {
        query.contact_time_lower_bound(lanes, horizon)
    }

    fn first_contact(
        &self,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Answer {
        self.first_contact_after(0.0, a, b, motion, horizon)
    }

    fn first_contact_after(
        &self,
        begin: f64,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Answer {
        match unit(a, b, motion, horizon) {
            Unit::Ordinary => self.search((), begin, a, b, motion, horizon.min(f64::MAX)),
            Unit::Scaled(factor) => {
                let motion = faster(motion, factor);
                let [begin, horizon] = [begin, horizon].map(|time| in_unit(time, factor));
                later(self.search((), begin, a, b, &motion, horizon), factor)
            }
            Unit::OutOfRange => OUT_OF_RANGE,
        }
    }
}

/// A time in a unit that is `factor` times as long. One before the present stays before it.
fn in_unit(time: f64, factor: f64) -> f64 {
    let scaled = (time / factor).min(f64::MAX);
    if time < 0.0 {
        scaled.min(-f64::MIN_POSITIVE)
    } else {
        scaled
    }
}

impl Exact {
    /// Searches like [`Detection::first_contact`] and records the steps: the times of evaluation,
    /// and the times up to which they certify the parts free.
    pub fn trace(
        self,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Trace {
        let mut log = SearchLog::new();
        match unit(a, b, motion, horizon) {
            Unit::Ordinary => {
                let answer = self.search(&mut log, 0.0, a, b, motion, horizon.min(f64::MAX));
                log.trace(answer, 1.0)
            }
            Unit::Scaled(factor) => {
                let motion = faster(motion, factor);
                let horizon = in_unit(horizon, factor);
                let answer = later(self.search(&mut log, 0.0, a, b, &motion, horizon), factor);
                log.trace(answer, factor)
            }
            Unit::OutOfRange => log.trace(OUT_OF_RANGE, 1.0),
        }
    }

    /// Searches a pair whose numbers are in the range of the arithmetic, from `begin` (time) on.
    #[inline]
    fn search<R: Recorder>(
        self,
        mut recorder: R,
        begin: f64,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Answer {
        if a.has_other_parts() || b.has_other_parts() {
            let most_steps = self.most_steps;
            return if a.ellipses().is_empty() && b.ellipses().is_empty() {
                edges::first_contact(recorder, most_steps, begin, a, b, motion, horizon)
            } else {
                ellipses::first_contact(recorder, most_steps, begin, a, b, motion, horizon)
            };
        }
        let Some(window) = skim(motion, a.bounding_radius + b.bounding_radius, horizon) else {
            return Answer {
                outcome: Outcome::Free,
                evaluations: 0,
            };
        };
        recorder.window(window);
        let mut search = Search::new(window.end, self.most_steps, recorder);
        let flight = Flight::new(a, b, motion);
        if flight.turns() {
            let window = SearchWindow {
                begin: window.begin.max(begin),
                ..window
            };
            turning(a, b, &flight, window, &mut search);
        } else {
            straight(a, b, &flight, &mut search);
        }
        search.answer()
    }
}

#[cfg(test)]
mod tests;
