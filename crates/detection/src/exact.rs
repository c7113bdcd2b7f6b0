//! The certified detector: safe Newton steps on the gap, each proven to pass over no contact.
//!
//! For an atom pair let d(t) be the vector between the centres, s the sum of the radii, g = |d| − s the
//! gap, n = d/|d|, g' = n·d'. Free flight bounds the curvature for all time:
//! |d''| ≤ K = ω_A² r_A + ω_B² r_B.
//!
//! **Step.** For any fixed unit vector n, |d(t+h)| ≥ n·d(t+h) ≥ n·d + n·d' h − K h²/2, so with n taken
//! at t there is no contact before the root of g + g' h − K h²/2. Taking that root as the next time
//! converges quadratically to a transversal contact, and can never pass one.
//!
//! **Rounding.** The computed gap is off by at most E ([`ErrorBound`]). A pair is passed as free only
//! where the computed gap exceeds E, hence only where it is truly apart; so no contact deeper than 2 E is
//! missed, and every contact reported has a gap within 2 E.
//!
//! **In contact.** Where the gap is below E the sign of g' decides. g' has its own bound E' =
//! L (2 E/|d| + 8 u) + (|ω_A| + |ω_B|) E + δV, L = |V| + |ω_A| r_A + |ω_B| r_B (errors of the normal, of the
//! arms, and of the velocities that the motion came with). Closing faster than E': a contact, now. Deeper
//! than −E and closing faster than the velocities resolve: likewise. Else the pair has just collided, or
//! only touches: it is followed by steps to where g + (g' − E') h − K h²/2 reaches min(g, 0) − E, which skip
//! nothing deeper than the present gap less E.
//!
//! **Acceptance.** From concavity of the square root |d(t+h)| ≤ |d| + g' h + (K + |d'|²/|d|) h²/2, so a step
//! with (K + |d'|²/|d|) h² ≤ E lands on the contact to within E and is taken without looking again; the
//! last Newton correction −g/g' is guarded by the same bound.
//!
//! **Bound on the work.** Each pair has [`MOST_STEPS`] steps; a search that runs out answers "certified free
//! until", which is never wrong. When one pair runs out before another pair's contact, the answer is the
//! earlier time.

use carom_geometry::Outline;
use carom_kinematics::RelativeMotion;

use crate::{
    Answer, Detection, DiscBatch, ErrorBound, LANES, Outcome, Window,
    atom_block::BlockSearch,
    atom_pair::PairOutcome,
    circle_descent::{Body, descend},
    disc_contact,
    flight::Flight,
    search::Search,
    skim,
    tolerance::MOST_STEPS,
};

/// The certified detector; see the [crate](crate) and the table of detectors there.
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
    fn first_contact(&self, a: Outline<'_>, b: Outline<'_>, motion: &RelativeMotion, horizon: f64) -> Answer {
        let horizon = horizon.min(f64::MAX);
        let Some(window) = skim(motion, a.bounding_radius + b.bounding_radius, horizon) else {
            return Answer { outcome: Outcome::Free, evaluations: 0 };
        };
        let mut search = Search::new(window.end, self.most_steps);
        let flight = Flight::new(a, b, motion);
        if flight.turns() {
            turning(a, b, &flight, window, &mut search);
        } else {
            straight(a, b, &flight, &mut search);
        }
        search.answer()
    }

    fn disc_contacts(&self, batch: &DiscBatch, times: &mut [f64; LANES]) {
        batch.contact_times(times);
    }
}

/// Bodies that do not turn: each atom pair is a pair of discs.
fn straight(a: Outline<'_>, b: Outline<'_>, flight: &Flight<'_>, search: &mut Search) {
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
fn turning(a: Outline<'_>, b: Outline<'_>, flight: &Flight<'_>, window: Window, search: &mut Search) {
    let blocks = BlockSearch::new(flight, [a.bounding_radius, b.bounding_radius]);
    let bodies = [Body::new(a), Body::new(b)];
    match bodies.map(Body::only_block) {
        [Some(a), Some(b)] => blocks.search(a, b, window.begin, search),
        _ => descend(&blocks, flight, bodies, window.begin, search),
    }
}
