//! Checks of a reported contact: gap 0, point of contact, restitution, momentum, torque, energy,
//! and no friction, or that of a rough contact.

use carom::{
    engine::{CollisionReport, Side},
    response::Elasticity,
};

use super::{
    kinematics::{
        BodyOutline, BodyPair, BodyPart, NormalSpeeds, Placed, TouchedParts, along, cross, dot,
        length, smallest_gap, touch_in_image,
    },
    laws::ContactLaw,
    rough::{RoughContact, TangentialLoss, pushed_speed},
    vectors::U,
};
use crate::fuzz::subject::{Report, exceeds};

/// A body at a contact.
#[derive(Debug, Clone, Copy)]
pub struct ContactBody<'a> {
    /// Its shape.
    pub outline: &'a BodyOutline,
    /// Its placement at the time of the contact.
    pub placed: Placed,
    /// Bound on its position error, including the arms (length).
    pub error: f64,
}

/// Conditions on a contact.
#[derive(Debug, Clone, Copy)]
pub struct ContactRules<'a> {
    /// Sides of the box (length).
    pub sides: BodyPair,
    /// Bound on the gap with exact positions (length).
    pub gap: f64,
    /// Coefficients from the rules of the scene.
    pub law: &'a ContactLaw,
    /// True if the guard against inelastic collapse may raise it.
    pub guarded: bool,
    /// The speed at which the guard separates two bodies at least (length per time); 0 without
    /// gravity and forces.
    pub bounce: f64,
    /// True if gravity or the motion of a wall accelerates the surfaces towards each other: they
    /// may then touch without an approach that is more than rounding.
    pub accelerated: bool,
}

/// Measured quantities of a contact.
#[derive(Debug, Clone, Copy, Default)]
pub struct MeasuredContact {
    /// Approach speed (length per time).
    pub approach: f64,
    /// Sum of the speeds of both bodies and of their rims (length per time).
    pub speed: f64,
    /// Distance between the centres (length).
    pub distance: f64,
    /// Energy lost (mass × length² / time²).
    pub lost: f64,
    /// Work of a wall that moves (mass × length² / time²).
    pub work: f64,
    /// Bound on the errors of both from that of the place (mass × length² / time²).
    pub energy_error: f64,
}

/// Checks a reported contact.
pub fn check(
    contact: &CollisionReport<'_>,
    bodies: [ContactBody<'_>; 2],
    rules: &ContactRules<'_>,
    report: &mut Report,
) -> MeasuredContact {
    let sides = &contact.sides;
    let part = |side: &Side<'_>| match (side.atom, side.edge) {
        (Some(atom), _) => BodyPart::Atom(atom as usize),
        (None, edge) => BodyPart::Edge(edge.unwrap_or(0) as usize),
    };
    let [a, b] = &bodies;
    let separation = separation(contact, rules.sides);
    let touch = touch_in_image(
        (a.outline, &a.placed, part(&sides[0])),
        (b.outline, &b.placed, part(&sides[1])),
        rules.sides,
        // In a narrow box two bodies may touch in two images at the same time.
        separation,
    );
    let Some(touch) = touch else {
        report.fail(
            "gap",
            format!("a contact of bodies out of reach is reported: {contact:?}"),
        );
        return MeasuredContact::default();
    };
    let error = a.error + b.error;
    let bound = rules.gap + error;
    report.keep_worst("gap/bound", touch.gap.abs() / bound);
    if exceeds(touch.gap.abs(), bound) {
        report.fail(
            "gap",
            format!(
                "{:e} at a contact, allowed {bound:e}; {contact:?}",
                touch.gap
            ),
        );
    }
    let least = smallest_gap((a.outline, &a.placed), (b.outline, &b.placed), rules.sides);
    if exceeds(-least, bound) {
        report.fail(
            "gap",
            format!("{least:e} at a contact of other parts, allowed {bound:e}"),
        );
    }
    if contact.points > 1 {
        return check_joint(contact, &touch, rules, bound, report);
    }
    check_impulse(contact, &touch, rules, bound, report)
}

/// Checks of a contact at several points, whose impulse is a resultant: momentum, and an energy
/// that does not grow, and stays where the contact is elastic.
fn check_joint(
    contact: &CollisionReport<'_>,
    touch: &TouchedParts,
    rules: &ContactRules<'_>,
    place_error: f64,
    report: &mut Report,
) -> MeasuredContact {
    if rules.law.is_rough() {
        report.fail(
            "joint",
            format!("a rough contact has {} points", contact.points),
        );
    }
    let Sums { speed, .. } = check_momentum(contact, touch, false, report);
    let [before, after] = [false, true]
        .map(|after| energy(&contact.sides[0], after) + energy(&contact.sides[1], after));
    let reported = TouchedParts {
        arms: contact.sides.each_ref().map(|side| side.arm.to_array()),
        ..*touch
    };
    let WorkOfWall { work, error, turns } = WorkOfWall::new(contact, &reported, place_error);
    // The impulses act on surfaces of a wall that turns at different velocities; no energy is then
    // booked as lost.
    let work = if turns { after - before } else { work };
    check_work(contact, work, error + 64.0 * U * (before + after), report);
    // The normals and arms of all points have the error of the one that is named.
    let share = 4096.0 * U + 64.0 * place_error / touch.distance;
    let (lost, allowed) = (
        before + work - after,
        share * before.max(after).max(work.abs()),
    );
    let elasticity = contact.elasticity.coefficient();
    let grows = elasticity <= 1.0 && exceeds(-lost, allowed);
    let falls = elasticity == 1.0 && exceeds(lost, allowed);
    if before.max(after) > 1e-280 && (grows || falls) {
        report.fail(
            "energy",
            format!(
                "decreases by {lost:e} at {} points, e = {elasticity}",
                contact.points
            ),
        );
    }
    MeasuredContact {
        approach: -dot(relative_rate(contact, touch.arms, false), touch.normal),
        speed,
        distance: touch.distance,
        lost,
        work,
        energy_error: error,
    }
}

/// The work of a wall that moves on the other body: the product of the impulse and of the velocity
/// of its surface.
#[derive(Debug, Clone, Copy, Default)]
struct WorkOfWall {
    /// The work (mass × length² / time²).
    work: f64,
    /// Bound on its error from that of the arm and from rounding (mass × length² / time²).
    error: f64,
    /// True if the wall turns.
    turns: bool,
}

impl WorkOfWall {
    fn new(contact: &CollisionReport<'_>, touch: &TouchedParts, arm_error: f64) -> Self {
        let impulse = contact.impulse.to_array();
        let mut found = Self::default();
        for (index, side) in contact.sides.iter().enumerate() {
            if !side.body.is_fixed() {
                continue;
            }
            let on_other = if index == 0 { 1.0 } else { -1.0 };
            let arm = touch.arms[index];
            let spin = side.before.angular_velocity;
            let speed = side.before.velocity.length() + spin.abs() * length(arm);
            found.work += on_other * dot(impulse, rate(side, arm, false));
            found.error += length(impulse) * (spin.abs() * arm_error + 64.0 * U * speed);
            found.turns |= spin != 0.0;
        }
        found
    }
}

/// Checks the work of the report.
fn check_work(contact: &CollisionReport<'_>, work: f64, error: f64, report: &mut Report) {
    let off = (contact.work - work).abs();
    // Below this energy the products of speeds underflow.
    if work.abs() > 1e-280 && exceeds(off, error) {
        report.fail(
            "work",
            format!("{:e} deviates by {off:e} from {work:e}", contact.work),
        );
    }
}

/// Vector from the centre of the first body to that of the touched image of the second (length), in
/// a box of these sides.
pub fn separation(contact: &CollisionReport<'_>, sides: BodyPair) -> BodyPair {
    let [first, second] = contact.sides.each_ref().map(|side| side.before.position);
    [0, 1].map(|axis| (second[axis] - first[axis]) + contact.image[axis] as f64 * sides[axis])
}

/// Velocity of the end of the arm of the second body relative to that of the first (length per
/// time).
pub fn relative_rate(contact: &CollisionReport<'_>, arms: [BodyPair; 2], after: bool) -> BodyPair {
    let [first, second] = &contact.sides;
    along(
        rate(second, arms[1], after),
        -1.0,
        rate(first, arms[0], after),
    )
}

fn rate(side: &Side<'_>, arm: BodyPair, after: bool) -> BodyPair {
    let motion = if after { &side.after } else { &side.before };
    let spin = motion.angular_velocity;
    along(motion.velocity.to_array(), spin, [-arm[1], arm[0]])
}

fn energy(side: &Side<'_>, after: bool) -> f64 {
    let motion = if after { &side.after } else { &side.before };
    let inertia = side.body.inertia();
    let mut energy = 0.0;
    if inertia.inverse_mass > 0.0 {
        energy += 0.5 / inertia.inverse_mass
            * dot(motion.velocity.to_array(), motion.velocity.to_array());
    }
    if inertia.inverse_moment > 0.0 {
        energy += 0.5 / inertia.inverse_moment * motion.angular_velocity * motion.angular_velocity;
    }
    energy
}

/// Sums over both bodies of a contact.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    /// Speeds of the bodies and of their rims, before and after (length per time).
    speed: f64,
    /// Magnitudes of the angular velocities, before and after (1 / time).
    spins: f64,
    /// Inverse effective mass along the normal (1 / mass).
    inverse_mass: f64,
}

impl Sums {
    /// The resolution of detection (length per time), E' = L (2 E/s + 12 u) + |ω| E + 2 u (|v_A| +
    /// |v_B|), with E the rounding bound of positions for bodies that move eight sides in an epoch.
    /// Contacts that lose energy separate at four times this speed at least.
    fn resolved_speed(&self, distance: f64, sides: BodyPair, place_error: f64) -> f64 {
        let places = 128.0 * U * (sides[0] + sides[1]) + place_error;
        self.speed * (2.0 * places / distance + 16.0 * U) + self.spins * places
    }

    /// Returns true if two bodies that already separate may have touched in a graze. Its deepest
    /// point may be one of rounding: the two then separate by at most the speed that their path
    /// about each other gives them over such a depth.
    fn may_graze(&self, speeds: &NormalSpeeds, distance: f64, place_error: f64) -> bool {
        let graze = (2.0 * place_error * self.speed * (self.speed / distance + self.spins)).sqrt();
        speeds.approach < -speeds.error && speeds.approach > -graze
    }
}

/// The parts of a contact at one point, as its impulse acts on them.
struct ActingParts {
    touch: TouchedParts,
    /// Bound on the error of the arms (length).
    arm_error: f64,
    /// Bound on the error of the direction of the normal.
    normal_error: f64,
    /// Largest velocity that the impulse of a rough contact gives the surfaces (length per time).
    pushed: f64,
}

impl ActingParts {
    fn new(
        contact: &CollisionReport<'_>,
        touch: &TouchedParts,
        is_rough: bool,
        place_error: f64,
    ) -> Self {
        let normal_error = 32.0 * U + 2.0 * place_error / touch.distance;
        let (touch, arm_error, pushed) = if is_rough {
            // The impulse of a rough contact acts at the surfaces.
            let [first, second] = touch.radii;
            let touch = touch.at_surfaces();
            let arm_error = place_error + normal_error * first.max(second);
            (touch, arm_error, pushed_speed(contact, &touch))
        } else {
            (*touch, place_error, 0.0)
        };
        Self {
            touch,
            arm_error: touch.arm_sensitivity * arm_error,
            normal_error,
            pushed,
        }
    }

    /// The speeds along the normal from the relative velocities before and after.
    fn normal_speeds(&self, [before, after]: [BodyPair; 2], sums: &Sums) -> NormalSpeeds {
        NormalSpeeds {
            approach: -dot(before, self.touch.normal),
            parting: dot(after, self.touch.normal),
            error: self.normal_error * (length(before) + length(after))
                + self.arm_error * sums.spins
                + 64.0 * U * (sums.speed + self.pushed),
        }
    }
}

/// Checks of a contact at one point.
fn check_impulse(
    contact: &CollisionReport<'_>,
    touch: &TouchedParts,
    rules: &ContactRules<'_>,
    place_error: f64,
    report: &mut Report,
) -> MeasuredContact {
    let is_rough = rules.law.is_rough();
    let parts = ActingParts::new(contact, touch, is_rough, place_error);
    let (touch, arm_error, normal_error) = (&parts.touch, parts.arm_error, parts.normal_error);
    check_arms(contact, touch, is_rough, (arm_error, normal_error), report);
    let sums = check_momentum(contact, touch, is_rough, report);
    check_torque(contact, touch, arm_error, report);
    let velocities = [false, true].map(|after| relative_rate(contact, touch.arms, after));
    let speeds = parts.normal_speeds(velocities, &sums);
    check_elasticity(contact.elasticity, &speeds, rules, report);
    let measured = MeasuredContact {
        approach: speeds.approach,
        speed: sums.speed,
        distance: touch.distance,
        ..MeasuredContact::default()
    };
    let has_no_impulse = contact.impulse.to_array() == [0.0; 2];
    if has_no_impulse && sums.may_graze(&speeds, touch.distance, place_error) {
        report.count("grazes", 1);
        return measured;
    }
    let resolved = sums.resolved_speed(touch.distance, rules.sides, place_error);
    check_restitution(contact.elasticity.coefficient(), &speeds, resolved, report);
    let rough = RoughContact {
        contact,
        touch,
        velocities,
        speeds,
        arm_error,
        normal_error,
        added: 4.0 * resolved,
    };
    let tangential = if rules.accelerated && is_idle(&rough) {
        TangentialLoss::default()
    } else {
        check_tangential(&rough, report)
    };
    let wall = WorkOfWall::new(contact, touch, arm_error);
    check_work(contact, wall.work, wall.error, report);
    let lost = check_energy(
        contact,
        sums.inverse_mass,
        &speeds,
        (tangential, wall),
        report,
    );
    MeasuredContact {
        lost,
        work: wall.work,
        energy_error: wall.error,
        ..measured
    }
}

/// Returns true if bodies that approach by no more than rounding have no impulse.
fn is_idle(rough: &RoughContact<'_>) -> bool {
    let NormalSpeeds {
        approach, error, ..
    } = rough.speeds;
    rough.contact.impulse.to_array() == [0.0; 2] && !exceeds(approach, error)
}

/// Checks the part of the impulse across the normal; returns the energy that it takes.
fn check_tangential(rough: &RoughContact<'_>, report: &mut Report) -> TangentialLoss {
    let contact = rough.contact;
    if contact.elasticity.is_smooth() {
        let impulse = contact.impulse.to_array();
        check_direction(impulse, rough.touch, rough.normal_error, report);
        TangentialLoss::default()
    } else {
        rough.check(report)
    }
}

/// Checks the arms and the point of contact of the report.
fn check_arms(
    contact: &CollisionReport<'_>,
    touch: &TouchedParts,
    is_rough: bool,
    (arm_error, normal_error): (f64, f64),
    report: &mut Report,
) {
    for (side, arm) in contact.sides.iter().zip(touch.arms) {
        let off = length(along(side.arm.to_array(), -1.0, arm));
        let allowed = arm_error + 32.0 * U * length(arm);
        report.keep_worst("arm/bound", off / allowed);
        if exceeds(off, allowed) {
            report.fail(
                "arm",
                format!("{} deviates by {off:e} from {arm:?}", side.arm),
            );
        }
    }
    let place = contact.sides[0].before.position.to_array();
    let to_surface = if is_rough { 0.0 } else { touch.radii[0] };
    let arm = along(touch.arms[0], to_surface, touch.normal);
    let found = along(contact.point.to_array(), -1.0, place);
    let off = length(along(found, -1.0, arm));
    let rounding = 32.0 * U * (length(arm) + length(place));
    if exceeds(off, arm_error + normal_error * to_surface + rounding) {
        report.fail("point", format!("{} deviates by {off:e}", contact.point));
    }
}

/// Checks that the impulse changes the momentum of each body as it must.
fn check_momentum(
    contact: &CollisionReport<'_>,
    touch: &TouchedParts,
    is_rough: bool,
    report: &mut Report,
) -> Sums {
    let impulse = contact.impulse.to_array();
    let mut sums = Sums::default();
    // The velocity after an elastic contact with a fixed body may be that of a reflection, while
    // the impulse of a rough one has the rounding of the speed of the rim.
    let is_reflected = is_rough
        && contact
            .sides
            .iter()
            .any(|side| side.body.inertia().inverse_mass == 0.0);
    // A reflection is one in the frame of the surface of a wall.
    let surfaces = contact.sides.iter().zip(touch.arms);
    let of_walls: f64 = surfaces
        .filter(|(side, _)| side.body.is_fixed())
        .map(|(side, arm)| length(rate(side, arm, false)))
        .sum();
    for (side, (sign, arm)) in contact
        .sides
        .iter()
        .zip([(-1.0, touch.arms[0]), (1.0, touch.arms[1])])
    {
        let inertia = side.body.inertia();
        let [before, after] = [&side.before, &side.after].map(|motion| motion.velocity.to_array());
        let change = along(after, -1.0, before);
        let expected = [
            sign * inertia.inverse_mass * impulse[0],
            sign * inertia.inverse_mass * impulse[1],
        ];
        let speeds = length(before) + length(after);
        let spin = side.after.angular_velocity.abs() + side.before.angular_velocity.abs();
        let rim = spin * length(arm);
        let rounded = if is_reflected { rim } else { 0.0 };
        if exceeds(
            length(along(change, -1.0, expected)),
            32.0 * U * (speeds + of_walls + rounded + length(expected)),
        ) {
            report.fail(
                "momentum",
                format!("velocity changes by {change:?}, not by {expected:?}: {contact:?}"),
            );
        }
        sums.speed += speeds + rim;
        sums.spins += spin;
        let lever = cross(arm, touch.normal);
        sums.inverse_mass += inertia.inverse_mass + inertia.inverse_moment * lever * lever;
    }
    sums
}

/// Checks that the impulse changes the spin of each body as it must.
fn check_torque(
    contact: &CollisionReport<'_>,
    touch: &TouchedParts,
    place_error: f64,
    report: &mut Report,
) {
    let impulse = contact.impulse.to_array();
    for (side, (sign, arm)) in contact
        .sides
        .iter()
        .zip([(-1.0, touch.arms[0]), (1.0, touch.arms[1])])
    {
        let inverse_moment = side.body.inertia().inverse_moment;
        let turned = side.after.angular_velocity - side.before.angular_velocity;
        let torque = sign * inverse_moment * cross(arm, impulse);
        let spin = side.after.angular_velocity.abs() + side.before.angular_velocity.abs();
        let place = place_error + 32.0 * U * length(arm);
        let allowed = 32.0 * U * spin + inverse_moment * length(impulse) * place;
        if exceeds((turned - torque).abs(), allowed) {
            report.fail(
                "torque",
                format!("spin changes by {turned:e}, not by {torque:e}"),
            );
        }
    }
}

/// Checks that the impulse is along the normal and separates the bodies.
fn check_direction(
    impulse: BodyPair,
    touch: &TouchedParts,
    normal_error: f64,
    report: &mut Report,
) {
    if exceeds(
        cross(impulse, touch.normal).abs(),
        length(impulse) * normal_error,
    ) {
        report.fail(
            "friction",
            format!(
                "impulse {impulse:?} is not along the normal {:?}",
                touch.normal
            ),
        );
    }
    let parts = dot(impulse, touch.normal);
    if parts.is_nan() || parts <= 0.0 {
        report.fail(
            "impulse",
            format!("impulse {impulse:?} does not separate the bodies"),
        );
    }
}

/// Checks that the coefficients are those of the rules at the speed of approach, or those to which
/// the guard may raise them: a contact that it makes elastic is smooth.
fn check_elasticity(
    found: Elasticity,
    speeds: &NormalSpeeds,
    rules: &ContactRules<'_>,
    report: &mut Report,
) {
    let law = rules.law;
    let [slow, fast] = [-1.0, 1.0].map(|sign| speeds.approach + sign * speeds.error);
    let [least, most] = law.coefficients(slow, fast);
    let guarded = rules.guarded && least < 1.0;
    // Of bodies that hardly approach any coefficient gives this speed.
    let of_bounce = if slow > 0.0 {
        (1.0 + 32.0 * U) * rules.bounce / slow
    } else {
        f64::INFINITY
    };
    let highest = match (guarded, rules.bounce > 0.0) {
        (true, true) => most.max(1.0).max(of_bounce),
        (true, false) => most.max(1.0),
        (false, _) => most,
    };
    let (tangential, friction) = if law.is_rough() {
        (law.tangential, law.friction)
    } else {
        (-1.0, f64::INFINITY)
    };
    let has_surfaces = found.tangential() == tangential
        && found.friction() == friction
        && !exceeds((found.kick() - law.kick).abs(), 8.0 * U * law.kick.abs());
    let is_elastic = guarded && found.is_smooth() && found.coefficient() >= 1.0;
    let e = found.coefficient();
    if !(least..=highest).contains(&e) || !(has_surfaces || is_elastic) {
        report.fail(
            "elasticity",
            format!("the report has {found:?}, the rules give {least} to {most} and {law:?}"),
        );
    }
}

/// Checks that the bodies approach, and separate at e times that speed or at the least one.
fn check_restitution(elasticity: f64, speeds: &NormalSpeeds, resolved: f64, report: &mut Report) {
    let NormalSpeeds {
        approach,
        parting,
        error,
    } = *speeds;
    if exceeds(-approach, error) {
        report.fail(
            "approach",
            format!(
                "a contact of bodies that separate at {:e} is reported",
                -approach
            ),
        );
    }
    let excess = parting - elasticity * approach;
    let allowed = (1.0 + elasticity) * error;
    if exceeds(-excess, allowed) || exceeds(excess, allowed + 4.0 * resolved) {
        report.fail(
            "restitution",
            format!("approach {approach:e}, separation {parting:e}, e = {elasticity}"),
        );
    }
}

/// Checks that the energy and the work of a wall decrease by ½ (1 − e²) μ u² and what a tangential
/// impulse takes; returns the decrease.
fn check_energy(
    contact: &CollisionReport<'_>,
    inverse_mass: f64,
    speeds: &NormalSpeeds,
    (tangential, wall): (TangentialLoss, WorkOfWall),
    report: &mut Report,
) -> f64 {
    let NormalSpeeds {
        approach, error, ..
    } = *speeds;
    let elasticity = contact.elasticity.coefficient();
    let size = length(contact.impulse.to_array());
    let [before, after] = [false, true]
        .map(|after| energy(&contact.sides[0], after) + energy(&contact.sides[1], after));
    let lost = before + wall.work - after;
    let expected = 0.5 * (1.0 - elasticity * elasticity) / inverse_mass * approach * approach
        + tangential.lost;
    let allowed = 64.0 * U * (before + after)
        + 4.0 * size * (1.0 + elasticity) * error
        + tangential.error
        + wall.error;
    // Below this energy the squares of speeds underflow.
    let resolved = before.max(after) > 1e-280;
    if resolved && exceeds((lost - expected).abs(), allowed) {
        report.fail(
            "energy",
            format!("decreases by {lost:e}, not by {expected:e}, e = {elasticity}"),
        );
    }
    lost
}
