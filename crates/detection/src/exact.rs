//! The certified detector: no contact deeper than rounding is missed, and none is invented.
//!
//! # What it promises
//! With E the bound on the rounding of the gap ([`ErrorBound`](crate::ErrorBound)): every contact reported has |g| ≤ 2 E
//! unless the pair was deeper already, no contact deeper than 2 E is passed over, and "certified free until" is what it
//! says. Exchanging A and B changes no bit of the time. Velocities times a power of two change only the power.
//!
//! # How it searches
//! Each pair of parts is followed by the steps of [`gap_search`](crate::gap_search), whose lemmas prove the promise for one
//! pair. For whole bodies:
//!
//! 1. **Windows.** Outside the times in which the centres of mass are within R_A + R_B there is no contact: a parabola in
//!    time ([`skim`]), whose reach is inflated by more than the rounding of its coefficients.
//! 2. **Many pairs.** The first steps are taken for all pairs at once, from one placement of the bodies; the pairs are then
//!    followed one by one, the one with the earliest bound first; a pair whose gap widens is left for another whose
//!    bound has become the earliest. A pair whose bound is later than a contact already found cannot matter, nor can
//!    anything after a time up to which some pair is certified and no further.
//! 3. **Many atoms.** Circles that hold atoms ([`CircleTree`](carom_geometry::CircleTree)) are followed as if they were
//!    atoms. Their contents lie inside, rounding included, and cannot touch before they do; so the parts of two circles
//!    begin where those were last certified. These shared steps use g − E and pass over nothing deeper than L u t.
//! 4. **Before a search.** [`Detection::contact_time_lower_bounds`] gives lower bounds by one step from coarser data; the rounding taken
//!    off is wider than E ([`QueryBody`]). A search of bodies that turn begins at that bound.
//! 5. **Discs.** Bodies that do not turn meet by the closed form of [`disc_contact`].
//! 6. **Ranges.** A query that holds NaN, an infinity, or a magnitude whose square could overflow is answered by
//!    [`Outcome::OutOfRange`]. Very slow and very fast pairs are answered in another unit of time, where no product of
//!    velocities underflows.
//!
//! A face that turns is not followed: [`Outcome::Unresolved`] from the start.

use carom_geometry::Outline;
use carom_kinematics::RelativeMotion;

use crate::{
    Answer, Detection, DiscLanes, ErrorBound, Outcome, QueryBody, Window,
    atom_block::BlockSearch,
    circle_descent::{Body, descend},
    disc::disc_contact,
    flight::Flight,
    gap_search::PairOutcome,
    range::{OUT_OF_RANGE, Unit, faster, later, unit},
    search::Search,
    skim,
    tolerance::MOST_STEPS,
    walls,
};

/// The certified detector; see the [crate] and the table of detectors there.
///
/// ```
/// use carom_detection::{Detection, Exact, Outcome, Touch};
/// use carom_geometry::{Molecule, Shape};
/// use carom_kinematics::RelativeMotion;
/// use glam::DVec2;
///
/// // A dumbbell turns on the spot (arms 1, ω = 1) and strikes a disc at rest, 2 + √2 radii away:
/// // contact when the atoms' centres are 2 radii apart.
/// let dumbbell = Molecule::named(Shape::Dumbbell, 1.0, 1.0)?;
/// let disc = Molecule::disc(1.0, 1.0)?;
/// let pair = RelativeMotion {
///     angular_velocity: [1.0, 0.0],
///     ..RelativeMotion::exactly(DVec2::new(0.0, 2.5), DVec2::ZERO)
/// };
/// let answer = Exact::default().first_contact(dumbbell.outline(), disc.outline(), &pair, 10.0);
/// let Outcome::Contact(contact) = answer.outcome else { panic!("it is struck") };
/// // Law of cosines: 2² = 1² + 2.5² − 2 · 2.5 cos ψ, struck at a quarter turn less ψ.
/// let psi = f64::acos((1.0 + 6.25 - 4.0) / 5.0);
/// assert!((contact.time - (std::f64::consts::FRAC_PI_2 - psi)).abs() < 1e-15);
/// assert_eq!(contact.touch, Touch::Atoms(1, 0));
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Exact {
    /// Most steps for one atom pair; see [`MOST_STEPS`].
    pub most_steps: u32,
}

impl Default for Exact {
    fn default() -> Self {
        Self { most_steps: MOST_STEPS }
    }
}

impl Detection for Exact {
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
    fn contact_time_lower_bound(&self, query: &QueryBody<'_>, lanes: &DiscLanes<1>, horizon: f64) -> f64 {
        query.contact_time_lower_bound(lanes, horizon)
    }

    fn first_contact(&self, a: Outline<'_>, b: Outline<'_>, motion: &RelativeMotion, horizon: f64) -> Answer {
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
            Unit::Ordinary => self.search(begin, a, b, motion, horizon.min(f64::MAX)),
            Unit::Scaled(factor) => {
                let motion = faster(motion, factor);
                let [begin, horizon] = [begin, horizon].map(|time| (time / factor).min(f64::MAX));
                later(self.search(begin, a, b, &motion, horizon), factor)
            }
            Unit::OutOfRange => OUT_OF_RANGE,
        }
    }
}

impl Exact {
    /// [`Detection::first_contact_after`] for numbers in the range of the arithmetic.
    #[inline]
    fn search(
        self,
        begin: f64,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Answer {
        if a.face().is_some() || b.face().is_some() {
            return walls::first_contact(self, a, b, motion, horizon);
        }
        let Some(window) = skim(motion, a.bounding_radius + b.bounding_radius, horizon) else {
            return Answer { outcome: Outcome::Free, evaluations: 0 };
        };
        let mut search = Search::new(window.end, self.most_steps);
        let flight = Flight::new(a, b, motion);
        if flight.turns() {
            let window = Window { begin: window.begin.max(begin), ..window };
            turning(a, b, &flight, window, &mut search);
        } else {
            straight(a, b, &flight, &mut search);
        }
        search.answer()
    }
}

/// Bodies that do not turn: each atom pair is a pair of discs.
pub(crate) fn straight(a: Outline<'_>, b: Outline<'_>, flight: &Flight<'_>, search: &mut Search) {
    let (motion, start) = (flight.motion, flight.at(0.0));
    for (i, atom_a) in a.atoms.iter().enumerate() {
        let arm_a = start.arm(0, atom_a.offset());
        for (j, atom_b) in b.atoms.iter().enumerate() {
            let arm_b = start.arm(1, atom_b.offset());
            let d = motion.separation + (arm_b - arm_a);
            let sigma = atom_a.radius() + atom_b.radius();
            let circles = [atom_a.into(), atom_b.into()];
            let error = ErrorBound::of_circles(motion, flight.speed, flight.spin, &circles).at(0.0);
            let time = disc_contact(d, motion.velocity, sigma, (error, motion.velocity_error));
            search.evaluations += 1;
            if time <= search.limit() {
                search.record(PairOutcome::Contact(time), [i as u32, j as u32]);
            }
        }
    }
}

/// Bodies that turn: all atom pairs at once, or through the trees of circles where there are many.
pub(crate) fn turning(
    a: Outline<'_>,
    b: Outline<'_>,
    flight: &Flight<'_>,
    window: Window,
    search: &mut Search,
) {
    let blocks = BlockSearch::new(flight, [a.bounding_radius, b.bounding_radius]);
    let bodies = [Body::new(&a), Body::new(&b)];
    match bodies.map(Body::only_block) {
        [Some(a), Some(b)] => blocks.search(a, b, window.begin, search),
        _ => descend(&blocks, bodies, window.begin, search),
    }
}

#[cfg(test)]
mod tests;
