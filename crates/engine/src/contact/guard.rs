//! Guard against inelastic collapse: a contact too soon after the last contacts of its bodies loses
//! no energy.
//!
//! With e < 1 bodies can have infinitely many contacts in a finite time: three discs in a row for e
//! < 7 − 4√3 (McNamara and Young, Phys. Fluids A 4 (1992) 496), more discs at any e < 1, and two
//! molecules of which one comes to rest against the other as it turns. Luding and McNamara
//! (Granular Matter 1 (1998) 113) assign a duration t_c to each contact: only contacts separated by
//! more than t_c lose energy. This guard follows them, with these choices.
//!
//! **Duration.** t_c = c T, with the `contact_time` c of the scene and the natural time T = 2
//! min(R_A, R_B)/w of the pair. In T the two bodies move by the diameter of the smaller, at their
//! relative speed w = |V| + |ω_A| R_A + |ω_B| R_B. A wall has no size of its own: R is then that of
//! the other body. The pair alone sets this unit of time. Velocities times a power of two therefore
//! give the same trajectory to the bit, and the guard acts equally on a gas at any stage of
//! cooling.
//!
//! **Condition.** A contact is made elastic if *each* of its moving bodies has had its last
//! contact, with any partner, less than t_c ago. In the original model one of the two is enough;
//! but then each contact of a large body that is hit continually would be elastic. For this reason
//! a fixed body does not count either.
//!
//! **Rough contacts.** A guarded contact is smooth as well as elastic: friction would lose energy.
//!
//! **Turning bodies.** Two bodies that turn can meet again without a third, since the gap bends by
//! K = ω_A² r_A + ω_B² r_B: with a speed of separation u' they touch again after about 2 u'/K. At
//! small e a single contact would leave a u' for which this time is far shorter than t_c at all
//! later contacts. So the surfaces of bodies that can turn separate with at least c w, or with
//! their speed of approach if that is less. Such bodies bounce, by 10⁻⁸ of a diameter for c = 10⁻⁴,
//! instead of resting against each other. This changes energies by a relative c².
//!
//! **Concave walls.** A body that has lost its speed across the inside of an arc follows it by
//! contacts at ever shorter intervals, since its gap bends by v²/R; an elastic contact changes
//! nothing in this. There the surfaces separate with at least c w, whatever their speed of
//! approach: the body follows the wall by chords of length 2 c R. This, too, changes energies by a
//! relative c² for each time that a body begins to slide. So do the two points of a tether at its
//! longest, of which one follows a circle about the other.
//!
//! **Gravity.** A body that has come to rest on a fixed one falls back on it after 2 u'/g. There
//! the surfaces separate with at least c √(2 R g), the guard's share of the speed after a fall by
//! the diameter 2 R: a bed stays barely warm, with bounces to c² of a diameter. Under a gravity
//! time has a unit of its own, and velocities times a power of two are another scene. The same
//! holds where a force presses a piston on a body, with the relative acceleration of both.
//!
//! # Lemmas
//!
//! 1. **A collapse ends.** In a finite time there are finitely many contacts. Proof: the contacts
//!    of a body in a collapse follow at intervals that tend to 0, so from some time on all of them
//!    are elastic; of these there are finitely many (for discs: Burago, Ferleger and Kononenko,
//!    Ann. Math. 147 (1998) 695).
//! 2. **Contacts that lose energy.** In a time t, each body causes at most 1 + t/t_c contacts that
//!    lose energy. Proof: a body causes such a contact only if its last contact was at least t_c
//!    before.
//! 3. **Share of guarded contacts.** In a gas of discs with mean time τ between the contacts of a
//!    disc, the share is 0.2 t_c/τ: three discs come together closely, and two of them meet
//!    again. Measured for c = 10⁻⁴ at area fractions from 0.1 to 0.65: 5·10⁻⁶ to 2·10⁻⁴ of all
//!    contacts.

use carom_detection::TetherBound;
use carom_kinematics::Motion;
use carom_response::{ContactFrame, Elasticity, MAX_COEFFICIENT, approach_speed};
use glam::DVec2;

use crate::world::{body::Body, contact_event::TouchingParts};

/// The guard; see the [module](self).
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Guard {
    /// t_c in natural times of the pair; 0: no guard.
    pub(crate) contact_time: f64,
}

/// One body of a contact.
pub(crate) struct Partner<'a> {
    pub(crate) body: &'a Body,
    pub(crate) motion: &'a Motion,
    /// The time since its last contact.
    pub(crate) since: f64,
}

impl Guard {
    /// Whether the guard raises the elasticity of a contact of two discs that no force accelerates.
    /// `since` are the times since their last contacts.
    #[inline]
    pub(crate) fn raises_for_discs(
        self,
        radii: [f64; 2],
        relative_velocity: DVec2,
        since: [f64; 2],
    ) -> bool {
        let way = self.contact_time * (2.0 * radii[0].min(radii[1]));
        let speed = relative_velocity.length();
        since.iter().all(|&since| is_soon(since, speed, way))
    }

    /// Returns a higher elasticity for a contact of elasticity below 1; `None` if it keeps its own.
    /// `fall` is the relative acceleration of the bodies (length / time²).
    #[inline(never)]
    pub(crate) fn raise(
        self,
        elasticity: Elasticity,
        (frame, parts): (&ContactFrame, TouchingParts),
        [a, b]: [Partner<'_>; 2],
        fall: DVec2,
    ) -> Option<Elasticity> {
        let approach = approach_speed(frame, [a.motion, b.motion]);
        let radii = [&a, &b].map(|partner| partner.body.kind.molecule.bounding_radius());
        let rims =
            a.motion.angular_velocity.abs() * radii[0] + b.motion.angular_velocity.abs() * radii[1];
        let speed = (b.motion.velocity - a.motion.velocity).length() + rims;
        let diameter = 2.0 * size(a.body).min(size(b.body));
        let way = self.contact_time * diameter;
        let soon =
            |partner: &Partner<'_>| partner.body.is_fixed() || is_soon(partner.since, speed, way);
        let turns = |partner: &Partner<'_>| {
            !partner.body.is_locked() && !partner.body.kind.molecule.is_disc()
        };
        let e = elasticity.coefficient();
        // Bodies that do not approach receive no impulse at any elasticity.
        if approach <= 0.0 {
            return None;
        }
        let bounces = self.contact_time * speed / approach;
        let is_taut = matches!(parts, TouchingParts::Bond(_, TetherBound::Longest));
        let of_bend = if is_taut || follows_concave_wall(frame, [&a, &b]) {
            bounces
        } else if turns(&a) || turns(&b) {
            bounces.min(1.0)
        } else {
            0.0
        };
        let of_fall = self.contact_time * (diameter * fall.length()).sqrt() / approach;
        let least = of_bend.max(of_fall).min(MAX_COEFFICIENT);
        if soon(&a) && soon(&b) {
            return Elasticity::ELASTIC.with_coefficient(least.max(1.0)).ok();
        }
        let raised = least.max(e);
        (raised > e)
            .then(|| elasticity.with_coefficient(raised).ok())
            .flatten()
    }
}

/// Whether a time is less than that of a way (length) at a speed.
#[inline]
fn is_soon(since: f64, speed: f64, way: f64) -> bool {
    // 0 × ∞ is NaN, and the comparison is then false.
    since * speed < way
}

/// Whether one of the bodies touches the inside of an arc: the arm from the centre of the circle
/// leads away from the other body.
fn follows_concave_wall(frame: &ContactFrame, pair: [&Partner<'_>; 2]) -> bool {
    let to_other = [frame.line_of_centres, -frame.line_of_centres];
    (0..2).any(|side| {
        let edge = pair[side].body.molecule().wall_edge();
        edge.is_some_and(|edge| edge.bend().is_some()) && frame.arms[side].dot(to_other[side]) < 0.0
    })
}

/// The size of a body in the natural time of a contact (length): the bounding radius; infinite for
/// a wall, whose length is unrelated to the size of a contact.
fn size(body: &Body) -> f64 {
    if body.is_wall() {
        f64::INFINITY
    } else {
        body.kind.molecule.bounding_radius()
    }
}
