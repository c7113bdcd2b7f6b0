//! The bounds of an atom and an edge against arithmetic of 40 digits.

use super::*;
use crate::{
    edge_pair::EdgePair,
    error_bound::tests::{Big, PRECISION, Random, big, directed_search},
    flight::Flight,
    gap_search::GapFunction,
};
use carom_geometry::{Atom, Interior, Molecule};
use carom_kinematics::Orientation;
use glam::DVec2;

/// A coordinate of an atom in the frame of an edge, and its first two derivatives.
pub(crate) struct Coordinate {
    pub(crate) value: Big,
    pub(crate) rate: Big,
    pub(crate) second: Big,
}

/// An atom of body number `body`, and the first edge of the other body.
pub(crate) struct Case {
    pub(crate) body: usize,
    pub(crate) atom: Atom,
    pub(crate) edged: Molecule,
    pub(crate) motion: RelativeMotion,
    pub(crate) time: f64,
}

type Vector = [Big; 2];

fn dot(a: &Vector, b: &Vector) -> Big {
    &a[0] * &b[0] + &a[1] * &b[1]
}

fn perp(v: &Vector) -> Vector {
    [-v[1].clone(), v[0].clone()]
}

fn sum(a: &Vector, factor: &Big, b: &Vector) -> Vector {
    [&a[0] + factor * &b[0], &a[1] + factor * &b[1]]
}

pub(crate) fn off(computed: f64, exact: &Big) -> f64 {
    (big(computed) - exact).to_f64().value().abs()
}

impl Case {
    pub(crate) fn pair<R>(&self, of: impl FnOnce(&EdgePair<'_>) -> R) -> R {
        let mut outlines = [self.atom.outline(), self.edged.outline()];
        if self.body == 1 {
            outlines.swap(0, 1);
        }
        let flight = Flight::new(outlines[0], outlines[1], &self.motion);
        let edge = &self.edged.edges()[0];
        of(&EdgePair::new(
            &flight,
            self.body,
            (&self.atom).into(),
            edge,
        ))
    }

    pub(crate) fn bound(&self) -> EdgeErrorBound {
        let edge = &self.edged.edges()[0];
        EdgeErrorBound::new(&self.motion, self.body, &(&self.atom).into(), edge)
    }

    /// A vector of a body turned by the exact angle.
    fn turned(&self, body: usize, vector: &Vector, time: &Big) -> Vector {
        let pi = Big::pi(PRECISION);
        let turns = big(2.0 * self.motion.orientation[body].turns()) * &pi;
        let (sin, cos) = (turns + big(self.motion.angular_velocity[body]) * time).sin_cos();
        [
            &vector[0] * &cos - &vector[1] * &sin,
            &vector[0] * &sin + &vector[1] * &cos,
        ]
    }

    /// The coordinates across and along the edge, to about 40 digits; positive at time 0.
    pub(crate) fn exact(&self, time: &Big) -> [Coordinate; 2] {
        let sign = big(if self.body == 1 { 1.0 } else { -1.0 });
        let vector = |v: DVec2| [big(v.x), big(v.y)];
        let [spin, fast] =
            [self.body, 1 - self.body].map(|body| big(self.motion.angular_velocity[body]));
        let arm = self.turned(self.body, &vector(self.atom.offset()), time);
        let still = vector(self.motion.velocity).map(|component| &sign * component);
        let start = vector(self.motion.separation).map(|component| &sign * component);
        let place = sum(&sum(&start, time, &still), &big(1.0), &arm);
        let velocity = sum(&still, &spin, &perp(&arm));
        let [from, to] = self.edged.edges()[0].ends().unwrap().map(|end| {
            let offset = self.edged.atoms()[end as usize].offset();
            self.turned(1 - self.body, &vector(offset), time)
        });
        let span = sum(&to, &big(-1.0), &from);
        let length = dot(&span, &span).sqrt();
        let along = span.map(|component| component / &length);
        let middle = sum(&from, &big(1.0), &to).map(|component| component * big(0.5));
        let relative = sum(&place, &big(-1.0), &middle);
        let rate = sum(&velocity, &-fast.clone(), &perp(&place));
        let of_atom = arm.map(|component| component * -(&spin * &spin));
        let second = sum(&of_atom, &(big(-2.0) * &fast), &perp(&velocity));
        let second = sum(&second, &-(&fast * &fast), &place);
        [perp(&along), along].map(|direction| {
            let value = dot(&direction, &relative);
            let sign = big(if value.to_f64().value() < 0.0 {
                -1.0
            } else {
                1.0
            });
            Coordinate {
                value: &sign * value,
                rate: &sign * dot(&direction, &rate),
                second: sign * dot(&direction, &second),
            }
        })
    }

    /// Error over bound of the distances across and along the edge, of their rates, and of the
    /// second derivative of the first.
    fn ratios(&self) -> [f64; 3] {
        let [across, along] = self.exact(&big(self.time));
        let edge = &self.edged.edges()[0];
        let [from, to] = edge
            .ends()
            .unwrap()
            .map(|end| self.edged.atoms()[end as usize].offset());
        let [dx, dy] = [0, 1].map(|k| big(to[k]) - big(from[k]));
        let half = (&dx * &dx + &dy * &dy).sqrt() * big(0.5);
        let (gap, beyond, second_error) = self.pair(|pair| {
            let pose = pair.pose(self.time);
            let gap = pair.gap(&pose);
            let second_error = pair.second_error(self.time, gap.error);
            (gap, pair.beyond(&pose), second_error)
        });
        let radii = big(self.atom.radius()) + big(edge.radius());
        let bound = self.bound();
        let place =
            off(gap.value, &(across.value - radii)).max(off(beyond.value, &(along.value - half)));
        let rate = off(gap.rate, &across.rate).max(off(beyond.rate, &along.rate));
        [
            place / bound.at(self.time),
            rate / bound.of_rate(self.time),
            off(gap.second, &across.second) / second_error.max(f64::MIN_POSITIVE),
        ]
    }

    /// Whether the bodies are near enough for a contact at the time of the case.
    fn is_within_reach(&self) -> bool {
        let [spin, fast] =
            [self.body, 1 - self.body].map(|body| self.motion.angular_velocity[body]);
        let edge = &self.edged.edges()[0];
        let contact_distance = self.atom.radius() + edge.radius();
        let place = self.motion.separation + self.motion.velocity * self.time;
        let sign = if self.body == 1 { 1.0 } else { -1.0 };
        if fast == 0.0 {
            true
        } else if spin == 0.0 {
            let arm = self.motion.orientation[self.body]
                .cos_sin()
                .rotate(self.atom.offset());
            (sign * place + arm).length() <= edge.reach() + contact_distance
        } else {
            place.length() <= edge.reach() + contact_distance + self.atom.arm()
        }
    }
}

/// Sizes of the numbers of a random case.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sizes {
    pub(crate) arm: f64,
    pub(crate) edge: f64,
    pub(crate) velocity: f64,
    pub(crate) spins: [f64; 2],
    pub(crate) time: f64,
}

/// Numbers in the state of a turning edge.
pub(crate) const NUMBERS: usize = 18;

impl Sizes {
    /// A random state of these sizes.
    pub(crate) fn state(self, random: &mut Random) -> [f64; NUMBERS] {
        let Self {
            arm,
            edge,
            velocity,
            spins,
            time,
        } = self;
        let reach = arm + 2.0 * edge;
        [
            arm, arm, 0.1, edge, edge, edge, edge, 0.1, reach, reach, velocity, velocity, 0.5, 0.5,
            spins[0], spins[1], time, 1.0,
        ]
        .map(|scale| scale * random.next())
    }
}

/// The case of a state: an edge with its ends anywhere about the centre of mass, and an atom within
/// reach at the time of the case.
pub(crate) fn case_of(state: &[f64; NUMBERS]) -> Case {
    let [
        x,
        y,
        radius,
        from_x,
        from_y,
        to_x,
        to_y,
        thickness,
        place_x,
        place_y,
        vx,
        vy,
        turns,
        turns_of_edge,
        spin,
        spin_of_edge,
        time,
        which,
    ] = *state;
    let body = usize::from(which < 0.0);
    let thick = thickness.abs() + 1e-6;
    let atom = Atom::new(DVec2::new(x, y), radius.abs() + 1e-6, 1.0).unwrap();
    let end = |x, y| Atom::new(DVec2::new(x, y), thick, 1e-3).unwrap();
    let heavy = Atom::new(DVec2::new(1e-5, 1e-5), thick, 1e3).unwrap();
    let ends = [end(from_x, from_y), end(to_x, to_y), heavy];
    let edged = Molecule::with_edges(ends, &[([0, 1], thick)], Interior::Solid).unwrap();
    let time = time.abs();
    let (place, velocity) = (DVec2::new(place_x, place_y), DVec2::new(vx, vy));
    let in_order = |of_atom: f64, of_edge: f64| {
        if body == 0 {
            [of_atom, of_edge]
        } else {
            [of_edge, of_atom]
        }
    };
    let motion = RelativeMotion {
        orientation: in_order(turns, turns_of_edge).map(Orientation::from_turns),
        angular_velocity: in_order(spin, spin_of_edge),
        ..RelativeMotion::exactly(place - velocity * time, velocity)
    };
    Case {
        body,
        atom,
        edged,
        motion,
        time,
    }
}

/// Edges that turn about a point near them and far from them, atoms on long and on short arms, at
/// the start, after 10⁸ turns, a million sizes away, and with one body that does not turn.
pub(crate) const SIZES: [Sizes; 8] = {
    const fn sizes(arm: f64, edge: f64, velocity: f64, spins: [f64; 2], time: f64) -> Sizes {
        Sizes {
            arm,
            edge,
            velocity,
            spins,
            time,
        }
    }
    [
        sizes(1.0, 1.0, 1.0, [1.0, 1.0], 1.0),
        sizes(1.0, 1.0, 1.0, [3.0, 3.0], 0.0),
        sizes(1e-3, 1.0, 1.0, [1e-9, 3.0], 3.0),
        sizes(1.0, 1e-3, 1.0, [3.0, 1e-9], 3.0),
        sizes(1.0, 1.0, 1e-3, [1e8, 1e8], 6.0),
        sizes(1.0, 1.0, 1.0, [1.0, 3.0], 1e6),
        sizes(1.0, 1.0, 1.0, [0.0, 2.0], 2.0),
        sizes(1.0, 1.0, 1.0, [2.0, 0.0], 2.0),
    ]
};

#[test]
fn bounds_hold_for_random_states_of_edges_that_turn() {
    let mut random = Random(2027);
    for sizes in SIZES {
        let mut worst = [0.0f64; 3];
        let mut count = 0;
        while count < 400 {
            let case = case_of(&sizes.state(&mut random));
            if !case.is_within_reach() {
                continue;
            }
            count += 1;
            for (worst, found) in worst.iter_mut().zip(case.ratios()) {
                *worst = worst.max(found);
            }
        }
        eprintln!("{sizes:?}: worst error over E, E', E'' {worst:.3?}");
        assert!(
            worst.iter().all(|&ratio| ratio <= 1.0),
            "{sizes:?}: {worst:?}"
        );
        // The bounds are not trivially wide.
        assert!(
            worst.iter().all(|&ratio| ratio > 0.01),
            "{sizes:?}: {worst:?}"
        );
        assert!(worst[0] > 0.04, "{sizes:?}: {worst:?}");
    }
}

#[test]
fn no_directed_search_exceeds_the_bounds_of_an_edge_that_turns() {
    let mut random = Random(21);
    for sizes in SIZES {
        let mut all = [0.0; 3];
        for (which, found) in all.iter_mut().enumerate() {
            let state = |random: &mut Random| sizes.state(random);
            let ratio = |state: &[f64; NUMBERS]| {
                let case = case_of(state);
                if case.is_within_reach() {
                    case.ratios()[which]
                } else {
                    0.0
                }
            };
            let worst = directed_search(&mut random, 100, 400, state, ratio);
            assert!(worst <= 1.0, "number {which}, {sizes:?}: {worst}");
            assert!(worst > 0.02, "number {which}, {sizes:?}: {worst}");
            *found = worst;
        }
        eprintln!("{sizes:?}: worst found error over E, E', E'' {all:.3?}");
    }
}

/// A case with a wall at rest.
fn case_of_wall(
    body: usize,
    atom: Atom,
    wall: Molecule,
    motion: RelativeMotion,
    time: f64,
) -> Case {
    Case {
        body,
        atom,
        edged: wall,
        motion,
        time,
    }
}

/// The largest `ratios` of an atom and a wall at rest among `count` random states.
fn worst_ratios(count: u32, distance: f64, spin: f64, duration: f64) -> [f64; 3] {
    let mut random = Random(2026);
    let mut worst = [0.0f64; 3];
    for index in 0..count {
        let body = (index % 2) as usize;
        let atom = Atom::new(random.vector(), random.next().abs() + 1e-3, 1.0).unwrap();
        let wall = Molecule::wall(3.0 * random.vector(), (0.1 * random.next()).max(0.0)).unwrap();
        let mut angular_velocity = [0.0; 2];
        angular_velocity[body] = spin * random.next();
        let motion = RelativeMotion {
            orientation: [0, 1].map(|_| Orientation::from_turns(0.5 * random.next())),
            angular_velocity,
            ..RelativeMotion::exactly(distance * random.vector(), random.vector())
        };
        let time = duration * random.next().abs();
        let found = case_of_wall(body, atom, wall, motion, time).ratios();
        for (worst, found) in worst.iter_mut().zip(found) {
            *worst = worst.max(found);
        }
    }
    worst
}

#[test]
fn no_directed_search_exceeds_the_bounds_of_a_wall() {
    let ratios = |state: &[f64; 13]| {
        let [
            x,
            y,
            radius,
            length,
            turns_wall,
            tx,
            ty,
            vx,
            vy,
            turns,
            spin,
            time,
            thick,
        ] = *state;
        let atom = Atom::new(DVec2::new(x, y), radius.abs() + 1e-9, 1.0).unwrap();
        let span = DVec2::new(length.abs() + 1e-3, 0.0);
        let wall = Molecule::wall(span, thick.abs()).unwrap();
        let motion = RelativeMotion {
            orientation: [turns_wall, turns].map(Orientation::from_turns),
            angular_velocity: [0.0, spin],
            ..RelativeMotion::exactly(DVec2::new(tx, ty), DVec2::new(vx, vy))
        };
        case_of_wall(1, atom, wall, motion, time.abs()).ratios()
    };
    let mut random = Random(20);
    for which in 0..3 {
        for [place, arm, velocity, spin, time] in [
            [1.0, 1e-6, 1e-9, 1e-9, 0.0],
            [1e-6, 1.0, 1e-9, 1.0, 1e-6],
            [1e-6, 1.0, 1e-9, 1e6, 1.0],
            [1e-3, 1e-6, 1.0, 1e-9, 1e6],
            [1.0; 5],
        ] {
            let scales = [
                arm, arm, 1e-3, 1.0, 0.5, place, place, velocity, velocity, 0.5, spin, time, 1e-3,
            ];
            let state = |random: &mut Random| scales.map(|scale| scale * random.next());
            let worst = directed_search(&mut random, 100, 500, state, |state| ratios(state)[which]);
            assert!(worst <= 1.0, "number {which}, {scales:?}: {worst}");
        }
    }
}

#[test]
fn bounds_hold_for_random_states_of_a_wall() {
    for (distance, spin, duration) in [
        (3.0, 3.0, 3.0),
        (2.0, 1.0, 0.0),
        (3.0, 1e8, 6.0),
        (1e6, 3.0, 1e6),
    ] {
        let [gap, rate, second] = worst_ratios(1_000, distance, spin, duration);
        eprintln!(
            "distance {distance:e}, spin {spin:e}: worst |error|/E {gap:.2}, |error|/E' {rate:.2}, \
             |error|/E'' {second:.2}"
        );
        assert!(
            gap <= 1.0 && rate <= 1.0 && second <= 1.0,
            "{gap} {rate} {second}"
        );
        // The bounds are not trivially wide.
        assert!(gap > 0.05 && rate > 0.01, "{gap} {rate}");
    }
}

#[test]
fn the_error_of_a_tilted_wall_grows_with_the_distance_from_its_centre() {
    let wall = Molecule::wall(DVec2::X, 0.0).unwrap();
    let atom = Circle::from(&Atom::new(DVec2::ZERO, 0.1, 1.0).unwrap());
    let at = |separation: DVec2| {
        let motion = RelativeMotion {
            orientation_error: [0.0, 1e-9],
            ..RelativeMotion::exactly(separation, DVec2::ZERO)
        };
        EdgeErrorBound::new(&motion, 0, &atom, &wall.edges()[0]).at(0.0)
    };
    assert!((at(DVec2::X) - 1e-9).abs() < 1e-13 && (at(1e3 * DVec2::X) - 1e-6).abs() < 1e-10);
}
