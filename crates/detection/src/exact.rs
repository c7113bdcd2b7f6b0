//! The certified detector: safe Newton steps on the gap, each proven to pass over no contact.
//!
//! For an atom pair let d(t) be the vector between the centres, s the sum of the radii, g = |d| − s the gap,
//! n = d/|d|, g' = n·d' and a = n·d''. The arms r of the atoms turn with the angular velocities ω, the centres of
//! mass move with V relative to each other. For all time
//!
//! |d'| ≤ L = |V| + |ω_A| r_A + |ω_B| r_B,  |d''| ≤ K = ω_A² r_A + ω_B² r_B,  |d'''| ≤ K₃ = |ω_A|³ r_A + |ω_B|³ r_B.
//!
//! # What is promised
//! With E the bound on the rounding of g ([`ErrorBound`]): every contact reported has |g| ≤ 2 E unless the pair was
//! deeper already, no contact deeper than 2 E is passed over, and "certified free until" is what it says. Which body
//! is called A changes no bit of the time; velocities times a power of two only change the power.
//!
//! # Proof
//! **Step.** For the fixed unit vector n of time t, |d(t+h)| ≥ n·d(t+h) = n·d + n·d' h + ∬ n·d''. So while −n·d'' ≤ k
//! the gap is not below g + g' h − k h²/2, and there is no contact before the root of that. A bound on −n·d'' that
//! starts at k₀ and grows at the rate k₁ may be replaced by the constant k = k₀ + k₁ H/3 for all h ≤ H, because
//! ∬ (k₀ + k₁ u) = k₀ h²/2 + k₁ h³/6. Of four k the least is taken:
//! * K, always;
//! * K₃ H/3 − a, since n·d'' cannot change faster than K₃;
//! * |d''| + J H/3, with J = min(ω_A² r_A, ω_B² r_B) |ω_B − ω_A|: for an observer who turns with A the acceleration is
//!   ω_A² q_A − ω_B² R((ω_B − ω_A) t) q_B, of the same length, and changes only as B turns relative to A; likewise
//!   with B. Without this one, bodies that fly along with equal spins would take thousands of steps;
//! * C₃ H/3 − g'', from the Taylor expansion of the gap itself. With the components p of d' and q of d'' across the normal
//!   g'' = a + p²/|d| and g''' = n·d''' + 3 p q/|d| − 3 p² g'/|d|². As p² |g'| ≤ 2 |d'|³/√27 and |d| ≥ s until the
//!   first contact, |g'''| ≤ C₃ = K₃ + 3 L K/s + 1.2 L³/s² up to there. This is what makes the last steps short in
//!   number: it is exact to third order, the others to second.
//!
//! **Orbits.** The atom of a body that turns fast stays on a circle about its body's centre. The other atom against
//! the disc of radius r + s about that centre gives another certified step, by the triangle inequality. Of several
//! certified steps the longest is taken. Each begins where the last one ended, so the first contact is never passed.
//! Towards a transversal contact the error is cubed from step to step.
//!
//! **Windows.** Outside the times in which the centres of mass are within r_A + r_B + s there is no contact: a
//! parabola in time ([`skim`]) whose reach is inflated by more than the rounding of its coefficients; for the bodies
//! first, and for each atom pair again, which is left when its centres are out of reach and part.
//!
//! **Many pairs.** The first steps are taken for all pairs at once, from one placement of the bodies; the pairs are
//! then followed one by one, the one with the earliest bound first; one whose gap widens is left for another whose
//! bound has become the earliest. A pair whose bound is later than a contact that
//! has been found cannot matter, nor can anything after a time up to which some pair is certified and no further.
//! For molecules of many atoms, circles that hold atoms ([`CircleTree`](carom_geometry::CircleTree)) are followed as
//! if they were atoms. What they hold lies inside, rounding included, and cannot touch before they do; so the
//! parts of two circles begin where those were last certified.
//!
//! **Before a search.** Most bodies around one that asks are told to be apart until its next event without a search, by one
//! step from coarser data: circles, the rectangle that holds its atoms, or its atoms against a disc, which may just have
//! left one of them; the rounding taken off is wider than E ([`Asker`]). A search of bodies that turn begins at its end.
//!
//! **Rounding.** The computed g is off by at most E, g' by at most E', t + h by u t. A step is taken only where
//! g > E, with g' − E' for g'. Over the step the exact gap is then at least −E − L u t, and L u t < E: nothing deeper
//! than 2 E is passed. (The shared steps and the circles use g − E as well, and pass over nothing deeper than
//! L u t.) h itself is computed by a dozen roundings in a form without cancellation, and shortened by
//! sixteen ([`STEP_MARGIN`](crate::tolerance::STEP_MARGIN)), which covers K, K₃, J and C₃ too. a and |d''| come with a
//! bound of their own, K (2 E/|d| + 12 u) + max(ω²) E; p = n^⊥·d' is off by no more than E', as g' is.
//!
//! **Contact.** Where g ≤ E the sign of g' decides. Closing faster than E': a contact, now. Deeper than −E and closing
//! faster than the velocities resolve: likewise. Else the pair has just collided, or only touches: its step goes to
//! where the bound from below reaches min(g, 0) − E, so that nothing deeper than the present gap less E is passed.
//! That is at least 2 (g' − E')/K, within which a parting pair is not back. A pair that may be back within a
//! thousandth of its natural time is followed by its gap relative to the contact that it left, which is known
//! far better than E.
//!
//! **Acceptance.** Where the contact is near enough it is not looked at again, but put at the root h of
//! g + g' h + g'' h²/2. Up to there the gap differs from that by C₃ h³/6, and by h (E' + h E'') because g' and g''
//! are rounded; each of C₃ h³ and h (E' + h E'') must be within E/4, so that nothing deeper than 2 E is passed and the gap at
//! h is within 2 E. The rate there, −√(g'² − 2 g'' g) to within C₃ h²/2 + E' + h E'', must be below −E': the pair
//! still closes.
//!
//! The last Newton correction −g/g' of a pair that is found within E of contact is guarded likewise: on a near-tangent it
//! would leap past the contact. From concavity of the square root |d(t+h)| ≤ |d| + g' h + C h²/2, C = K + |d'|²/|d|; the
//! correction is made if C h² is within E.
//!
//! **Walls.** A straight face that does not turn is touched where an atom's centre comes within s of its line, between its
//! ends. With the fixed normal n of the face the gap n·d − s is linear in the place of the atom, so that the step of the
//! first paragraph, with K = ω² r, needs no convexity: it holds as it stands, and C is K. Beyond an end the same
//! step, taken along the face, leads to where the atom may enter the span; of the two the longer is taken. An atom
//! that enters the span nearer than s has met the end point before. End points are atoms of radius 0. The bounds E
//! and E' of a face are in [`FaceErrorBound`](crate::FaceErrorBound). A face that turns is not followed:
//! [`Outcome::Unresolved`] from the start.
//!
//! **Bound on the work.** While g > E either g falls by a fixed factor or the step is of the order √(E/K). Each pair
//! has [`MOST_STEPS`] steps; a search that runs out answers "certified free until", which is later than where it
//! began and beats a later contact of another pair. Each step moves on by a float at least, and comparisons
//! are written so that what is no number never counts as free.

use carom_geometry::Outline;
use carom_kinematics::RelativeMotion;

use crate::{
    Answer, Asker, Detection, DiscLanes, ErrorBound, Outcome, Window,
    atom_block::BlockSearch,
    atom_pair::PairOutcome,
    circle_descent::{Body, descend},
    disc_contact,
    flight::Flight,
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
    #[expect(
        clippy::inline_always,
        reason = "it must be compiled with the vector instructions of its caller"
    )]
    fn apart_until<const N: usize>(&self, asker: &Asker<'_>, lanes: &DiscLanes<N>, horizon: f64) -> [f64; N] {
        asker.apart_until(lanes, horizon)
    }

    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "it must be compiled with the vector instructions of its caller"
    )]
    fn one_apart_until(&self, asker: &Asker<'_>, lanes: &DiscLanes<1>, horizon: f64) -> f64 {
        asker.one_apart_until(lanes, horizon)
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
        let horizon = horizon.min(f64::MAX);
        if a.face().is_some() || b.face().is_some() {
            return walls::first_contact(*self, a, b, motion, horizon);
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
