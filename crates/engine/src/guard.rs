//! The guard against inelastic collapse: a contact that follows too soon on the last ones of its bodies loses no energy.
//!
//! With e < 1 bodies can have infinitely many contacts in a finite time: three discs in a row do if e < 7 − 4√3 (McNamara
//! and Young, Phys. Fluids A 4 (1992) 496), more of them at any e < 1, and so do two molecules of which one comes to lie
//! against the other as it turns. Luding and McNamara (Granular Matter 1 (1998) 113) give a contact a duration t_c,
//! and let only such contacts lose energy as are farther apart in time. Here likewise, with these choices.
//!
//! **How long it lasts.** t_c = c T with the `contact_time` c of the scene and T = 2 min(R_A,
//! R_B)/w the time in which the two move by the diameter of the smaller, w = |V| + |ω_A| R_A +
//! |ω_B| R_B being how fast they move relative to each other now. A wall has no size of its own: R
//! is then the other's. Time is so measured by the pair alone: velocities times a power of two give
//! the same trajectory to the bit, and a gas that cools without end is guarded neither more nor
//! less.
//!
//! **Whose last contact counts.** A contact is made elastic if *each* of its bodies that moves has had its last one, with
//! whichever partner, less than t_c ago. In the original that of *either* is enough; but then a large body that is hit all
//! the time would make each of these hits elastic. For the same reason a fixed body has no say. Asking for both is
//! enough to end a collapse: whoever takes part in it for ever does so at intervals that go to 0, so from some moment
//! on all of its contacts are elastic, and of those there are finitely many (for discs: Burago, Ferleger and Kononenko, Ann.
//! Math. 147 (1998) 695). In numbers: of contacts that lose energy each body has no more than 1 + t/t_c in a time t on its own
//! account. Of the contacts of a gas of discs with a time τ from one to the next of each, a share of 0.2 t_c/τ is spared:
//! three discs are almost at one place, and two of them meet again (measured at area fractions from 0.1 to 0.65: 5·10⁻⁶ to
//! 2·10⁻⁴ of all contacts for c = 10⁻⁴).
//!
//! **Bodies that turn** come back to each other without a third, since the gap bends by K = ω_A² r_A + ω_B² r_B: one that
//! parts with u' is back after some 2 u'/K. At small e a single contact would leave a u' for which that is far less than
//! t_c, and there it would stay. So the surfaces of bodies that can turn part no slower than with c w, or with what they
//! came with if that is less. They bounce, by 10⁻⁸ of a diameter for c = 10⁻⁴, where they would lie against each other.
//! That is an energy of c² of what there is.

use carom_kinematics::Motion;
use carom_response::{ContactFrame, Elasticity, approach_speed};

use crate::Body;

/// See the [module](self).
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Guard {
    /// t_c in natural times of the pair; 0: no guard.
    pub(crate) contact_time: f64,
}

/// One body of a contact.
pub(crate) struct Partner<'a> {
    pub(crate) body: &'a Body,
    pub(crate) motion: &'a Motion,
    /// How long ago its last contact was (time).
    pub(crate) since: f64,
}

impl Guard {
    /// A higher elasticity for a contact that would have one below 1; `None` if it keeps its own.
    #[cold]
    pub(crate) fn raise(
        self,
        elasticity: Elasticity,
        frame: &ContactFrame,
        [a, b]: [Partner<'_>; 2],
    ) -> Option<Elasticity> {
        let approach = approach_speed(frame, [a.motion, b.motion]);
        let radii = [&a, &b].map(|partner| partner.body.kind.molecule.bounding_radius());
        let rims = a.motion.angular_velocity.abs() * radii[0] + b.motion.angular_velocity.abs() * radii[1];
        let speed = (b.motion.velocity - a.motion.velocity).length() + rims;
        let way = self.contact_time * (2.0 * size(a.body).min(size(b.body)));
        // An infinite time at no speed is no number, and is not soon.
        let soon = |partner: &Partner<'_>| partner.body.is_fixed() || partner.since * speed < way;
        let turns =
            |partner: &Partner<'_>| !partner.body.is_locked() && !partner.body.kind.molecule.is_disc();
        let e = elasticity.coefficient();
        let raised = if soon(&a) && soon(&b) {
            1.0
        } else if turns(&a) || turns(&b) {
            (self.contact_time * speed / approach).clamp(e, 1.0)
        } else {
            e
        };
        // Bodies that do not approach have no impulse, whatever the elasticity.
        (raised > e && approach > 0.0).then(|| Elasticity::new(raised).ok()).flatten()
    }
}

/// The size by which the time of a contact is measured (length): the bounding radius; infinite for
/// a wall, whose length is unrelated to the size of a contact.
fn size(body: &Body) -> f64 {
    if body.is_wall() { f64::INFINITY } else { body.kind.molecule.bounding_radius() }
}
