//! Random queries of all known hard kinds, in addition to the classes of
//! [`carom_detection::encounters`].

use std::f64::consts::TAU;

use carom_detection::{
    Contact, Exact, Touch,
    encounters::{Class, Encounter},
};
use carom_geometry::{Atom, Molecule, Shape, gap_between};
use carom_kinematics::{HALF_ULP, Orientation, RelativeMotion};
use glam::DVec2;

use super::{
    case::{Query, exp2},
    edged_shapes::{VALID, edged},
};
use crate::fuzz::random::FuzzDraw;

/// Bound on lengths and speeds of scaled queries; its inverse is the lower bound on lengths.
const MAX_SCALED: f64 = 1e59;

/// A random query.
pub fn draw(seed: u64) -> Query {
    let draw = &mut FuzzDraw::new(seed);
    let (class, encounter) = match draw.index(15) {
        0..=3 => of_class(draw),
        4 => ("bisected graze", bisected_graze(draw)),
        5 | 6 => ("after an impulse", after_impulse(draw)),
        7 => ("equal or opposite spins", paired_spins_of_discs(draw)),
        8 => ("tiny atoms on long arms", tiny_atoms(draw)),
        9 => ("many atoms", many_atoms(draw)),
        10 => ("wall", wall(draw)),
        11 | 12 => ("edges", edges(draw)),
        13 => ("equal or opposite spins", paired_spins_of_edges(draw)),
        _ => ("rods of six", rods(draw)),
    };
    let mut query = Query::new(class, &encounter);
    if draw.happens(0.4) {
        scale(draw, &mut query);
    }
    query
}

/// A query of one of the library's classes.
fn of_class(draw: &mut FuzzDraw) -> (&'static str, Encounter) {
    let class = draw.one_of(&Class::ALL);
    // Up to 16 atoms: 256 atoms have too many pairs for the reference.
    let index = draw.integer(0, 1 << 40) as u64;
    let index = if matches!(class, Class::Rods | Class::Blobs) {
        8 * (index / 8) + index % 3
    } else {
        index
    };
    ("class", Encounter::draw(class, draw.bits() >> 1, index))
}

/// Multiplies lengths by 1e-48 to 1e55 and speeds by 1e-80 to 1e55, or velocities alone by factors
/// down to 2^-330.
fn scale(draw: &mut FuzzDraw, query: &mut Query) {
    let lengths: Vec<f64> = query
        .a
        .lengths()
        .into_iter()
        .chain(query.b.lengths())
        .map(f64::abs)
        .collect();
    let smallest = lengths
        .iter()
        .copied()
        .filter(|&length| length > 0.0)
        .fold(1.0, f64::min);
    let [x, y] = query.flight.separation;
    let largest = lengths
        .iter()
        .copied()
        .fold(x.abs() + y.abs(), f64::max)
        .max(1e-3);
    let [u, v] = query.flight.velocity;
    let fastest = (u.abs() + v.abs()).max(1e-3);
    let spin = query.flight.spins[0]
        .abs()
        .max(query.flight.spins[1].abs())
        .max(1e-3);
    for _ in 0..100 {
        let [length, speed] = if draw.happens(0.3) {
            [0, draw.integer(-330, 100) as i32]
        } else {
            [
                draw.integer(-160, 183) as i32,
                draw.integer(-266, 183) as i32,
            ]
        };
        let time = length - speed;
        let fits = largest * exp2(length) < MAX_SCALED
            && smallest * exp2(length) > 1.0 / MAX_SCALED
            && fastest * exp2(speed) < MAX_SCALED
            && spin * exp2(-time) < MAX_SCALED
            && (query.horizon * exp2(time)).is_finite();
        if fits {
            (query.length_exponent, query.time_exponent) = (length, time);
            return;
        }
    }
}

fn named(draw: &mut FuzzDraw) -> Molecule {
    let count = draw.integer(2, 8) as usize;
    let shapes = [
        Shape::Disc,
        Shape::Dumbbell,
        Shape::Rod(count),
        Shape::Cross,
        Shape::Tee,
    ];
    let (shape, radius) = (draw.one_of(&shapes), draw.scale(0.2, 1.0));
    Molecule::named(shape, radius, draw.between(0.5, 2.0)).expect(VALID)
}

/// Smallest gap at time 0 (length).
fn first_gap(molecules: &[Molecule; 2], motion: &RelativeMotion) -> f64 {
    let [a, b] = molecules;
    let [turn_a, turn_b] = motion.orientation.map(Orientation::cos_sin);
    gap_between(a, turn_a, b, turn_b, motion.separation)
}

/// Longest time for which the centres of mass are within reach of each other; `otherwise` if
/// unbounded.
fn horizon(molecules: &[Molecule; 2], motion: &RelativeMotion, otherwise: f64) -> f64 {
    let reach = molecules[0].bounding_radius() + molecules[1].bounding_radius();
    let way = motion.separation.length() + reach;
    let time = 1.01 * way / motion.velocity.length();
    if time < otherwise { time } else { otherwise }
}

/// A motion at thermal speeds towards a random position within reach.
fn flight(draw: &mut FuzzDraw, molecules: &[Molecule; 2]) -> Encounter {
    let reach = molecules[0].bounding_radius() + molecules[1].bounding_radius();
    let velocity = DVec2::new(draw.normal(), draw.normal());
    let velocity = if velocity.length() < 1e-3 {
        DVec2::X
    } else {
        velocity
    };
    let spin = |draw: &mut FuzzDraw, molecule: &Molecule| {
        if molecule.is_disc() || molecule.is_wall() {
            0.0
        } else {
            draw.normal() / reach
        }
    };
    let spins = [spin(draw, &molecules[0]), spin(draw, &molecules[1])];
    let turns = [draw.between(-0.5, 0.5), draw.between(-0.5, 0.5)];
    let miss = draw.between(-1.1, 1.1) * reach * velocity.perp().normalize();
    for step in 0..20 {
        let back = f64::from(step) * 0.5 + 1.05 * draw.between(1.0, 2.0);
        let separation = miss - back * reach * velocity.normalize();
        let motion = RelativeMotion {
            orientation: turns.map(Orientation::from_turns),
            angular_velocity: spins,
            ..RelativeMotion::exactly(separation, velocity)
        };
        if first_gap(molecules, &motion) > 0.0 {
            let horizon = horizon(molecules, &motion, 100.0 * reach);
            return Encounter {
                molecules: molecules.clone(),
                motion,
                horizon,
            };
        }
    }
    Encounter::draw(Class::Generic, draw.bits() >> 1, 0)
}

/// A graze whose position is bisected to two adjacent floats: the detector finds a contact with one
/// and none with the other.
fn bisected_graze(draw: &mut FuzzDraw) -> Encounter {
    let classes = [
        Class::Grazing,
        Class::Graze(6),
        Class::Graze(10),
        Class::WallGraze(6),
        Class::WallGraze(10),
        Class::CornerGraze(9),
    ];
    let class = draw.one_of(&classes);
    let encounter = Encounter::draw(class, draw.bits() >> 1, draw.integer(0, 1000) as u64);
    let direction = draw.direction();
    let moved = |way: f64| {
        let mut moved = encounter.clone();
        moved.motion.separation += way * direction;
        moved
    };
    let touch = |way: f64| {
        let answer = moved(way).first_contact(&Exact::default());
        answer.outcome.contact().map(|contact| contact.touch)
    };
    let first = touch(0.0);
    let size = encounter.size();
    let mut end = 1e-12 * size;
    let changed = |way: f64| touch(way) != first;
    while !changed(end) {
        end *= -4.0;
        if end.abs() > size {
            return encounter;
        }
    }
    let mut begin = 0.0;
    for _ in 0..200 {
        let middle = 0.5 * (begin + end);
        if middle == begin || middle == end {
            break;
        }
        if changed(middle) {
            end = middle;
        } else {
            begin = middle;
        }
    }
    moved(if draw.happens(0.5) { begin } else { end })
}

/// A pair at its contact, with the velocities after an impulse of elasticity 1 to 1e-10.
fn after_impulse(draw: &mut FuzzDraw) -> Encounter {
    let class = draw.one_of(&[
        Class::Generic,
        Class::OneOmega,
        Class::LargeOmega,
        Class::Wall,
        Class::SizeRatio,
        Class::Squares,
        Class::Polygons,
        Class::BondedDiscs,
    ]);
    let encounter = Encounter::draw(class, draw.bits() >> 1, draw.integer(0, 1000) as u64);
    let answer = encounter.first_contact(&Exact::default());
    let Some(contact) = answer.outcome.contact() else {
        return encounter;
    };
    let elasticity = if draw.happens(0.3) {
        1.0
    } else {
        draw.scale(1e-10, 1.0)
    };
    let mut after = encounter.after(contact.time);
    if !struck(&mut after, contact, elasticity) {
        return encounter;
    }
    let reach = after.size();
    after.horizon =
        horizon(&after.molecules, &after.motion, 100.0 * reach).min(1e3 * after.natural_time());
    after
}

/// Sets the velocities after the contact, by J = (1 + e) μ u along the normal; returns false if the
/// parts are not two atoms, or an atom and a face, so close.
fn struck(encounter: &mut Encounter, contact: Contact, elasticity: f64) -> bool {
    let Some((normal, arms)) = normal_and_arms(encounter, contact.touch) else {
        return false;
    };
    let spins = encounter.motion.angular_velocity;
    let rate = encounter.motion.velocity + spins[1] * arms[1].perp() - spins[0] * arms[0].perp();
    let approach = -normal.dot(rate);
    let inverse = |molecule: &Molecule| {
        // Discs receive no spin; walls have infinite mass.
        let moment = if molecule.is_disc() {
            0.0
        } else {
            1.0 / molecule.moment_of_inertia()
        };
        [1.0 / molecule.mass(), moment]
    };
    let [[mass_a, moment_a], [mass_b, moment_b]] = encounter.molecules.each_ref().map(inverse);
    let torques = arms.map(|arm| arm.perp_dot(normal));
    let inverse_mass =
        mass_a + mass_b + moment_a * torques[0] * torques[0] + moment_b * torques[1] * torques[1];
    let impulse = (1.0 + elasticity) * approach / inverse_mass;
    if !(approach > 0.0 && impulse.is_finite()) {
        return false;
    }
    let motion = &mut encounter.motion;
    motion.velocity += impulse * (mass_a + mass_b) * normal;
    motion.angular_velocity = [
        spins[0] - moment_a * impulse * torques[0],
        spins[1] + moment_b * impulse * torques[1],
    ];
    motion.velocity_error += 4.0 * HALF_ULP * motion.velocity.length();
    true
}

/// Normal from A to B, and arms; `None` if the parts are not two atoms, or an atom and an edge.
fn normal_and_arms(encounter: &Encounter, touch: Touch) -> Option<(DVec2, [DVec2; 2])> {
    let [a, b] = &encounter.molecules;
    let turned = |body: usize, atom: &Atom| {
        encounter.motion.orientation[body]
            .cos_sin()
            .rotate(atom.offset())
    };
    let separation = encounter.motion.separation;
    let rotation = |body: usize| encounter.motion.orientation[body].cos_sin();
    let of_edge = |body: usize, molecule: &Molecule, edge: u32, place: DVec2| {
        let edge = &molecule.edges()[edge as usize];
        let (middle, across) = [edge.middle(), edge.normal()]
            .map(|vector| rotation(body).rotate(vector))
            .into();
        let off = (place - middle).dot(across);
        (across * off.signum(), place - off * across)
    };
    Some(match touch {
        Touch::Atoms(i, j) => {
            let arms = [
                turned(0, &a.atoms()[i as usize]),
                turned(1, &b.atoms()[j as usize]),
            ];
            ((separation + arms[1] - arms[0]).normalize(), arms)
        }
        Touch::EdgeOfA {
            edge,
            part: carom_detection::Part::Atom(j),
        } => {
            let arm = turned(1, &b.atoms()[j as usize]);
            let (outwards, foot) = of_edge(0, a, edge, separation + arm);
            (outwards, [foot, arm])
        }
        Touch::EdgeOfB {
            edge,
            part: carom_detection::Part::Atom(i),
        } => {
            let arm = turned(0, &a.atoms()[i as usize]);
            let (outwards, foot) = of_edge(1, b, edge, arm - separation);
            (-outwards, [arm, foot])
        }
        _ => return None,
    })
}

fn paired_spins_of_discs(draw: &mut FuzzDraw) -> Encounter {
    let molecules = [named(draw), named(draw)];
    paired_spins(draw, molecules)
}

fn paired_spins_of_edges(draw: &mut FuzzDraw) -> Encounter {
    let molecules = [edged(draw), edged(draw)];
    paired_spins(draw, molecules)
}

/// Two molecules with equal or opposite spins and a gap of 1e-3 to 1e-13 sizes.
fn paired_spins(draw: &mut FuzzDraw, molecules: [Molecule; 2]) -> Encounter {
    let size = molecules[0].bounding_radius() + molecules[1].bounding_radius();
    let turns = [draw.between(-0.5, 0.5), draw.between(-0.5, 0.5)].map(Orientation::from_turns);
    let (direction, gap) = (draw.direction(), draw.scale(1e-13, 1e-3) * size);
    let at = |distance: f64| RelativeMotion {
        orientation: turns,
        ..RelativeMotion::exactly(distance * direction, DVec2::ZERO)
    };
    let (mut near, mut far) = (0.0, 1.1 * size);
    for _ in 0..100 {
        let middle = 0.5 * (near + far);
        if first_gap(&molecules, &at(middle)) < gap {
            near = middle;
        } else {
            far = middle;
        }
    }
    let spin = draw.sign() * draw.scale(0.01, 10.0);
    let other = if draw.happens(0.5) { spin } else { -spin };
    let detune = if draw.happens(0.3) {
        draw.scale(1e-12, 1e-2)
    } else {
        0.0
    };
    let drift = if draw.happens(0.3) {
        0.0
    } else {
        draw.scale(1e-12, 1e-2)
    };
    let motion = RelativeMotion {
        angular_velocity: [spin, other * (1.0 + detune)],
        velocity: drift * draw.direction(),
        ..at(far)
    };
    let spins = draw.between(0.1, 3.0) * TAU;
    Encounter {
        molecules,
        motion,
        horizon: spins / spin.abs(),
    }
}

/// Atoms of radius 1e-11 to 1e-3 on arms of 1, with a constructed contact.
fn tiny_atoms(draw: &mut FuzzDraw) -> Encounter {
    let molecule = |draw: &mut FuzzDraw| {
        let radius = draw.scale(1e-11, 1e-3);
        let count = draw.integer(2, 4);
        let atom = |index: i64| {
            let angle = TAU * index as f64 / count as f64;
            let (sin, cos) = libm::sincos(angle);
            Atom::new(DVec2::new(cos, sin), radius, 1.0).expect(VALID)
        };
        Molecule::new((0..count).map(atom)).expect(VALID)
    };
    let molecules = [molecule(draw), molecule(draw)];
    for _ in 0..50 {
        let then = [draw.between(-0.5, 0.5), draw.between(-0.5, 0.5)];
        let atoms =
            [0, 1].map(|body| molecules[body].atoms()[draw.index(molecules[body].atoms().len())]);
        let arms = [0, 1].map(|body| {
            Orientation::from_turns(then[body])
                .cos_sin()
                .rotate(atoms[body].offset())
        });
        let normal = draw.direction();
        let spins = [draw.normal(), draw.normal()];
        let turning = spins[1] * arms[1].perp() - spins[0] * arms[0].perp();
        let slip = draw.normal() * normal.perp();
        let velocity = slip - draw.scale(1e-3, 1.0) * normal - turning;
        let time = draw.between(0.05, 1.0);
        let contact_distance = atoms[0].radius() + atoms[1].radius();
        let separation = contact_distance * normal - (arms[1] - arms[0]) - velocity * time;
        let before = |body: usize| Orientation::from_turns(then[body] - spins[body] * time / TAU);
        let motion = RelativeMotion {
            orientation: [before(0), before(1)],
            angular_velocity: spins,
            ..RelativeMotion::exactly(separation, velocity)
        };
        if first_gap(&molecules, &motion) > 0.0 {
            return Encounter {
                molecules,
                motion,
                horizon: 2.0 * time,
            };
        }
    }
    flight(draw, &molecules)
}

/// Rings, rods and clusters of up to 36 atoms, and discs inside rings.
fn many_atoms(draw: &mut FuzzDraw) -> Encounter {
    let molecule = |draw: &mut FuzzDraw| {
        let count = draw.integer(2, 36) as usize;
        match draw.index(3) {
            0 => Molecule::named(Shape::Rod(count), 0.5, 1.0).expect(VALID),
            1 => Molecule::named(Shape::Ring(count.max(3)), 0.5, 1.0).expect(VALID),
            _ => cluster(draw, count),
        }
    };
    if draw.happens(0.3) {
        return inside_a_ring(draw);
    }
    let molecules = [molecule(draw), molecule(draw)];
    flight(draw, &molecules)
}

/// Atoms at random positions with random radii; they may overlap.
fn cluster(draw: &mut FuzzDraw, count: usize) -> Molecule {
    let side = (count as f64).sqrt();
    let atom = |_| {
        let place = side * DVec2::new(draw.between(-1.0, 1.0), draw.between(-1.0, 1.0));
        Atom::new(place, draw.scale(0.1, 0.7), draw.scale(0.1, 10.0)).expect(VALID)
    };
    Molecule::new((0..count).map(atom).collect::<Vec<_>>()).expect(VALID)
}

/// A small molecule inside a ring that it cannot leave.
fn inside_a_ring(draw: &mut FuzzDraw) -> Encounter {
    let ring = Molecule::named(Shape::Ring(draw.integer(12, 36) as usize), 0.5, 1.0).expect(VALID);
    let hole = ring.bounding_radius() - 1.0;
    let small = if draw.happens(0.5) {
        Molecule::disc(draw.between(0.1, 0.6) * hole, 1.0).expect(VALID)
    } else {
        Molecule::named(Shape::Dumbbell, draw.between(0.05, 0.3) * hole, 1.0).expect(VALID)
    };
    let spin = if small.is_disc() { 0.0 } else { draw.normal() };
    let motion = RelativeMotion {
        orientation: [draw.between(-0.5, 0.5), draw.between(-0.5, 0.5)]
            .map(Orientation::from_turns),
        angular_velocity: [draw.normal(), spin],
        ..RelativeMotion::exactly(
            0.2 * hole * draw.direction(),
            draw.scale(1e-3, 1.0) * draw.direction(),
        )
    };
    Encounter {
        molecules: [ring, small],
        motion,
        horizon: 10.0 * hole,
    }
}

/// A molecule and a wall, short or long, thin or thick, from either side.
fn wall(draw: &mut FuzzDraw) -> Encounter {
    let molecule = named(draw);
    let size = molecule.bounding_radius();
    let radius = if draw.happens(0.5) {
        0.0
    } else {
        draw.scale(1e-12, 1.0) * size
    };
    let length = draw.scale(1e-3, 30.0) * size;
    let wall = Molecule::wall(length * draw.direction(), radius).expect(VALID);
    let molecules = if draw.happens(0.5) {
        [wall, molecule]
    } else {
        [molecule, wall]
    };
    flight(draw, &molecules)
}

/// A body with edges, and another, a union of discs or a wall that turns; a tenth of the pairs turn
/// by 10 to 10⁴ times as much.
fn edges(draw: &mut FuzzDraw) -> Encounter {
    let body = edged(draw);
    let other = match draw.index(4) {
        0 => named(draw),
        1 => {
            let length = draw.scale(0.1, 10.0) * body.bounding_radius();
            let radius = draw.one_of(&[0.0, 1e-3, 0.1]) * length;
            Molecule::wall(length * draw.direction(), radius).expect(VALID)
        }
        _ => edged(draw),
    };
    let molecules = if draw.happens(0.5) {
        [body, other]
    } else {
        [other, body]
    };
    let mut encounter = flight(draw, &molecules);
    let factor = if draw.happens(0.1) {
        draw.scale(10.0, 1e4)
    } else {
        1.0
    };
    let spin_of_wall = draw.normal() / encounter.size();
    for (spin, molecule) in encounter
        .motion
        .angular_velocity
        .iter_mut()
        .zip(&encounter.molecules)
    {
        *spin = factor
            * if molecule.is_wall() {
                spin_of_wall
            } else {
                *spin
            };
    }
    encounter
}

/// Two rods of six atoms with positions, velocities and spins on a coarse grid, which gives many
/// simple motions.
fn rods(draw: &mut FuzzDraw) -> Encounter {
    let rod = Molecule::named(Shape::Rod(6), 0.5, 1.0).expect(VALID);
    let molecules = [rod.clone(), rod];
    for _ in 0..50 {
        let coarse = |draw: &mut FuzzDraw, most: i64| draw.integer(-most, most) as f64 / 4.0;
        let motion = RelativeMotion {
            angular_velocity: [coarse(draw, 8), coarse(draw, 8)],
            ..RelativeMotion::exactly(
                DVec2::new(coarse(draw, 40), coarse(draw, 40)),
                DVec2::new(coarse(draw, 8), coarse(draw, 8)),
            )
        };
        if first_gap(&molecules, &motion) > 0.0 {
            return Encounter {
                horizon: horizon(&molecules, &motion, 20.0),
                molecules,
                motion,
            };
        }
    }
    flight(draw, &molecules)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn all_kinds_are_drawn_and_many_of_them_touch() {
        let queries: Vec<Query> = (0..400).map(draw).collect();
        let kinds: BTreeSet<&str> = queries.iter().map(|query| &query.class[..]).collect();
        assert_eq!(kinds.len(), 9, "{kinds:?}");
        let touch = |query: &&Query| {
            query
                .encounter()
                .unwrap()
                .first_contact(&Exact::default())
                .outcome
                .contact()
                .is_some()
        };
        let contacts = queries.iter().filter(touch).count();
        assert!((100..350).contains(&contacts), "{contacts}");
        assert!(
            queries
                .iter()
                .filter(|query| query.time_exponent != 0)
                .count()
                > 100
        );
    }

    #[test]
    fn a_constructed_contact_of_tiny_atoms_is_found_at_its_time() {
        let mut found = 0;
        for seed in 0..40 {
            let encounter = tiny_atoms(&mut FuzzDraw::new(seed));
            found += u32::from(
                encounter
                    .first_contact(&Exact::default())
                    .outcome
                    .contact()
                    .is_some(),
            );
        }
        assert!(found > 25, "{found}");
    }
}
