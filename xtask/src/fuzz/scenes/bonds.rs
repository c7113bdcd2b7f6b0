//! Random bonds between the molecules of a scene, and the check of an event of one.

use carom::engine::{BodyKey, BondSpec, CollisionReport, MoleculeSpec, Scene, TetherSpec, View};

use super::{
    contact::{MeasuredContact, relative_rate, separation},
    kinematics::{Placed, along, cross, dot, length, shortest_way},
    tracked::TrackedBond,
    vectors::{BodyPair, U, rotated},
    watcher::Watcher,
};
use crate::fuzz::{random::FuzzDraw, subject::exceeds};

/// Largest reach of a bond as a share of the shorter side.
const MAX_REACH: f64 = 0.49;

/// Ties some pairs of the molecules of a scene, whose sides are these.
pub fn tie(draw: &mut FuzzDraw, scene: &mut Scene, falls: bool) {
    let sides = scene.bounds.sides;
    let count = scene.molecule.len();
    if count < 2 {
        return;
    }
    for _ in 0..draw.integer(1, 6) {
        let (a, b) = (draw.index(count), draw.index(count));
        let pair = [&scene.molecule[a.min(b)], &scene.molecule[a.max(b)]];
        let is_tied = |bond: &BondSpec| bond.pairs[0] == [a.min(b) as u64, a.max(b) as u64];
        let fixed = pair.map(|spec| spec.fixed);
        let is_refused = a == b
            || (fixed[0] && fixed[1])
            || (falls && (fixed[0] || fixed[1]))
            || scene.bond.iter().any(is_tied);
        if is_refused {
            continue;
        }
        if let Some(tether) = tether(draw, pair, sides, scene.elasticity.contact_time > 0.0) {
            let pairs = vec![[a.min(b) as u64, a.max(b) as u64]];
            scene.bond.push(BondSpec { pairs, tether });
        }
    }
}

/// A tether that holds two molecules where they are.
fn tether(
    draw: &mut FuzzDraw,
    pair: [&MoleculeSpec; 2],
    sides: BodyPair,
    is_guarded: bool,
) -> Option<TetherSpec> {
    let molecules = [pair[0].molecule("a").ok()?, pair[1].molecule("b").ok()?];
    let at_centres = draw.happens(0.4);
    let points = [0, 1].map(|n| {
        // The contacts of discs may be smooth, so that they do not turn.
        if at_centres || molecules[n].is_round() {
            return [0.0; 2];
        }
        let reach = molecules[n].bounding_radius();
        [(); 2].map(|()| draw.between(-1.0, 1.0) * reach)
    });
    let arms = [0, 1].map(|n| {
        let angle = pair[n].orientation_turns.unwrap_or(0.0) * std::f64::consts::TAU;
        let (sin, cos) = libm::sincos(angle);
        rotated(points[n], [cos, sin])
    });
    let centres = shortest_way(pair[0].at, pair[1].at, sides);
    let now = length(along(along(centres, 1.0, arms[1]), -1.0, arms[0]));
    let max = now * (1.0 + draw.scale(1e-3, 1.0)) + 1e-6;
    let reach = max + length(points[0]) + length(points[1]);
    if reach > MAX_REACH * sides[0].min(sides[1]) || length(centres) > reach {
        return None;
    }
    let min = if draw.happens(0.3) {
        now * draw.between(0.1, 0.99)
    } else {
        0.0
    };
    let elasticity = if is_guarded && draw.happens(0.3) {
        draw.between(0.0, 1.0)
    } else {
        1.0
    };
    Some(TetherSpec {
        max,
        min,
        points,
        elasticity,
    })
}

/// Multiplies all lengths of bonds.
pub fn scale(bonds: &mut [BondSpec], factor: f64) {
    for bond in bonds {
        let tether = &mut bond.tether;
        tether.max *= factor;
        tether.min *= factor;
        tether.points = tether.points.map(|point| point.map(|x| x * factor));
    }
}

/// The geometry of an event of a bond.
struct BondEvent {
    /// From the centre of mass of each body to its end of the bond (length).
    arms: [BodyPair; 2],
    /// From the first centre of mass to the second (length).
    centres: BodyPair,
    /// The length of the bond.
    distance: f64,
    /// The direction from its first end to its second.
    direction: BodyPair,
    /// Whether the longest length is reached, and not the shortest.
    is_taut: bool,
    /// Bound on the error of the length.
    bound: f64,
    /// Sum of the speeds of both ends (length per time).
    speed: f64,
}

impl BondEvent {
    /// The rounding of a speed or an impulse along the bond, relative to its magnitude.
    fn relative_error(&self) -> f64 {
        256.0 * U + 8.0 * self.bound / self.distance
    }
}

impl Watcher {
    /// Takes over the bonds of a scene at its start.
    pub(super) fn take_bonds(&mut self, view: &View<'_>, scene: &Scene) {
        let keys: Vec<BodyKey> = view.bodies().map(|body| body.body.key()).collect();
        self.bonds = (scene.bond.iter())
            .flat_map(|spec| spec.pairs.iter().map(move |pair| (pair, &spec.tether)))
            .filter_map(|(pair, tether)| {
                let [a, b] = pair.map(|number| keys.get(number as usize).copied());
                Some(TrackedBond {
                    bodies: [a?, b?],
                    points: tether.points,
                    bounds: [tether.min, tether.max],
                    elasticity: tether.elasticity,
                })
            })
            .collect();
    }

    /// Checks that a bond has reached one of its bounds, and its impulse.
    pub(super) fn check_bond(
        &mut self,
        contact: &CollisionReport<'_>,
        placed: [Placed; 2],
        error: f64,
    ) -> MeasuredContact {
        let pair = contact.sides.each_ref().map(|side| side.body.key());
        let Some(bond) = self.bonds.iter().find(|bond| bond.bodies == pair).cloned() else {
            self.report.fail(
                "bond",
                format!("bodies that are not tied pull: {contact:?}"),
            );
            return MeasuredContact::default();
        };
        let event = self.bond_event(contact, &bond, placed, error);
        self.check_bond_length(&bond, &event);
        let outwards = self.check_bond_rates(contact, &bond, &event);
        self.check_bond_impulse(contact, &event);
        let lost = self.check_changes(contact, event.arms, event.bound);
        let is_elastic = contact.elasticity.coefficient() == 1.0;
        if is_elastic {
            self.check_elastic_bond(contact, &event, lost);
        }
        self.report.count("events of bonds", 1);
        MeasuredContact {
            approach: outwards,
            speed: event.speed,
            distance: length(event.centres),
            lost: if is_elastic { 0.0 } else { lost },
            ..MeasuredContact::default()
        }
    }

    /// The geometry of an event of a bond, whose bodies have an error (length).
    fn bond_event(
        &self,
        contact: &CollisionReport<'_>,
        bond: &TrackedBond,
        placed: [Placed; 2],
        error: f64,
    ) -> BondEvent {
        let arms = [0, 1].map(|n| rotated(bond.points[n], placed[n].rotation));
        let centres = separation(contact, self.sides);
        let between = along(along(centres, 1.0, arms[1]), -1.0, arms[0]);
        let distance = length(between);
        let direction = between.map(|x| x / distance);
        let arm_lengths = length(arms[0]) + length(arms[1]);
        BondEvent {
            arms,
            centres,
            distance,
            direction,
            is_taut: dot(contact.normal.to_array(), direction) < 0.0,
            bound: 64.0 * f64::EPSILON * (self.longer_side() + arm_lengths + distance) + error,
            speed: (0..2)
                .map(|n| {
                    let motion = &contact.sides[n].before;
                    motion.velocity.length() + motion.angular_velocity.abs() * length(arms[n])
                })
                .sum(),
        }
    }

    /// Checks that the length of a bond is one of its bounds.
    fn check_bond_length(&mut self, bond: &TrackedBond, event: &BondEvent) {
        let BondEvent {
            distance, bound, ..
        } = *event;
        let end = bond.bounds[usize::from(event.is_taut)];
        let off = (distance - end).abs();
        self.report.keep_worst("bond/bound", off / bound);
        if exceeds(off, bound) {
            self.report.fail(
                "bond",
                format!(
                    "an event at the length {distance:e}, {off:e} from the bound: allowed {bound:e}"
                ),
            );
        }
    }

    /// Checks that the points of a bond reach its bound and leave it by its elasticity; returns the
    /// speed at which they reach it.
    fn check_bond_rates(
        &mut self,
        contact: &CollisionReport<'_>,
        bond: &TrackedBond,
        event: &BondEvent,
    ) -> f64 {
        let rate = |after: bool| dot(relative_rate(contact, event.arms, after), event.direction);
        let (before, after) = (rate(false), rate(true));
        let rate_error = event.relative_error() * event.speed;
        let outwards = if event.is_taut { before } else { -before };
        // Beyond the speed that the search resolves, at which points that rest are pushed apart.
        let slow = 1e3 * rate_error;
        if exceeds(-outwards, slow) {
            self.report.fail(
                "bond",
                format!("points leave the bound that they reach: {contact:?}"),
            );
        }
        let share = contact.elasticity.coefficient();
        if share < bond.elasticity || (share > bond.elasticity && bond.elasticity == 1.0) {
            self.report.fail(
                "bond",
                format!("the elasticity {share} instead of {}", bond.elasticity),
            );
        }
        let missing = (after + share * before).abs();
        if exceeds(missing, slow) {
            self.report.fail(
                "bond",
                format!("the points meet at {before:e} and part at {after:e} with the elasticity {share}"),
            );
        }
        outwards
    }

    /// Checks the direction of the impulse of a bond.
    fn check_bond_impulse(&mut self, contact: &CollisionReport<'_>, event: &BondEvent) {
        let impulse = contact.impulse.to_array();
        if exceeds(
            cross(event.direction, impulse).abs(),
            event.relative_error() * length(impulse),
        ) {
            self.report.fail(
                "bond",
                format!("the impulse {impulse:?} is not along the bond"),
            );
        }
    }

    /// Checks that an elastic bond has lost no energy.
    fn check_elastic_bond(&mut self, contact: &CollisionReport<'_>, event: &BondEvent, lost: f64) {
        let energy = 0.5 * event.speed * event.speed
            / (contact.sides.iter())
                .map(|side| side.body.inertia().inverse_mass)
                .fold(f64::MIN_POSITIVE, f64::max);
        if exceeds(lost.abs(), 1e3 * event.relative_error() * energy) {
            self.report
                .fail("bond", format!("an elastic bond loses the energy {lost:e}"));
        }
    }

    /// Checks that an impulse at the ends of these arms changes both motions of a bond, and returns
    /// the energy lost. The arms have an error (length).
    fn check_changes(
        &mut self,
        contact: &CollisionReport<'_>,
        arms: [BodyPair; 2],
        bound: f64,
    ) -> f64 {
        let (sides, impulse) = (&contact.sides, contact.impulse.to_array());
        let mut lost = 0.0;
        for (n, side) in sides.iter().enumerate() {
            let on_it = if n == 0 { impulse.map(|x| -x) } else { impulse };
            let inertia = side.body.inertia();
            let change = along(
                side.after.velocity.to_array(),
                -1.0,
                side.before.velocity.to_array(),
            );
            let off = length(along(change, -inertia.inverse_mass, on_it));
            let scale = length(on_it) * inertia.inverse_mass + side.before.velocity.length();
            let torque = cross(arms[n], on_it) * inertia.inverse_moment;
            let spun = side.after.angular_velocity - side.before.angular_velocity;
            let arm = length(arms[n]) + bound;
            let turned = (spun - torque).abs() * arm;
            let of_torque = length(on_it) * arm * arm * inertia.inverse_moment
                + side.before.angular_velocity.abs() * arm;
            if exceeds(off, 64.0 * U * scale)
                || exceeds(turned, (256.0 * U + 8.0 * bound / arm) * of_torque)
            {
                self.report.fail(
                    "bond",
                    format!(
                        "the impulse {on_it:?} does not change the motion of its body: {contact:?}"
                    ),
                );
            }
            lost -= side.energy_change();
        }
        lost
    }
}
