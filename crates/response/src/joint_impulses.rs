//! The impulses of two bodies that touch at several points at one instant, such as a rod that falls
//! flat on a wall.
//!
//! One impulse after the other would not do: the result depends on their order, and a symmetric
//! contact ends unsymmetric. Instead the impulses J_k ≥ 0 along the normals are those after which
//! each point separates with at least e times its speed of approach u_k, and with just that speed
//! if it has an impulse:
//!
//! A J ≥ (1 + e) u, J ≥ 0, J · (A J − (1 + e) u) = 0,
//!
//! where A_kl is the speed of separation at k for a unit impulse at l. This is the complementarity
//! of Moreau ("Nonsmooth Mechanics and Applications", 1988) with Newton's restitution. The motions
//! after it are unique, because A is positive semidefinite, and an elastic contact conserves the
//! energy. The impulses themselves are not unique where more than three points touch; those found
//! are a smallest set, of three at most.
//!
//! The conditions are those of the least ‖G J − h‖ over J ≥ 0 with A = GᵀG, found by the method of
//! Lawson and Hanson ("Solving Least Squares Problems", 1974, chapter 23).

use carom_kinematics::{Inertia, Motion};
use glam::DVec2;

use crate::{
    Elasticity,
    contact_frame::{ContactFrame, approach_speed},
};

/// Largest number of impulses: the columns of G are forces on a body in the plane, so that no more
/// than three are independent.
const MAX_IMPULSES: usize = 3;

/// A speed of separation that is too small by this share of the largest demanded is rounding.
/// Smaller: impulses of rounding size at points that already separate. Larger: such points keep
/// approaching.
const ROUNDING: f64 = 1e-12;

/// A pivot below this share of its diagonal means that a point depends on those with impulses.
const SINGULAR: f64 = 1e-9;

/// The impulses on B at contacts of one pair of bodies at the same instant (mass × length / time),
/// in the order of `frames`. `None` if fewer than two of them approach, or if rounding leaves no
/// solution: then the contacts are resolved one by one.
pub(crate) fn joint_impulses(
    frames: &[ContactFrame],
    bodies: [(&Motion, &Inertia); 2],
    elasticity: Elasticity,
) -> Option<Vec<DVec2>> {
    let motions = bodies.map(|(motion, _)| motion);
    let inertias = bodies.map(|(_, inertia)| inertia);
    let speed =
        |frame: &ContactFrame| (1.0 + elasticity.coefficient()) * approach_speed(frame, motions);
    // A point that separates takes no part: it would gain energy in an elastic contact.
    let approaching: Vec<usize> = (0..frames.len())
        .filter(|&k| speed(&frames[k]) > 0.0)
        .collect();
    if approaching.len() < 2 {
        return None;
    }
    let points: Vec<Point> = approaching
        .iter()
        .map(|&k| Point::new(&frames[k]))
        .collect();
    let demanded: Vec<f64> = approaching.iter().map(|&k| speed(&frames[k])).collect();
    let sizes = smallest_set(&points, &demanded, inertias)?;
    let mut impulses = vec![DVec2::ZERO; frames.len()];
    for ((&k, point), size) in approaching.iter().zip(&points).zip(sizes) {
        impulses[k] = size * point.normal;
    }
    Some(impulses)
}

/// A point of contact: its normal and the levers of an impulse along it.
struct Point {
    normal: DVec2,
    levers: [f64; 2],
}

impl Point {
    fn new(frame: &ContactFrame) -> Self {
        let normal = frame.normal();
        Self {
            normal,
            levers: frame.arms.map(|arm| arm.perp_dot(normal)),
        }
    }

    /// A_kl: the speed of separation here for a unit impulse at another point.
    fn yielding(&self, other: &Self, [a, b]: [&Inertia; 2]) -> f64 {
        self.normal.dot(other.normal) * (a.inverse_mass + b.inverse_mass)
            + self.levers[0] * other.levers[0] * a.inverse_moment
            + self.levers[1] * other.levers[1] * b.inverse_moment
    }
}

/// The sizes of the impulses, by the method of Lawson and Hanson.
fn smallest_set(points: &[Point], demanded: &[f64], inertias: [&Inertia; 2]) -> Option<Vec<f64>> {
    let mut set = ActiveSet {
        points,
        demanded,
        inertias,
        sizes: vec![0.0; points.len()],
        active: Vec::new(),
        dependent: vec![false; points.len()],
    };
    // Each pass adds a point with an impulse, and each set of points is met once; ten times their
    // number is never reached but by rounding.
    for _ in 0..10 * points.len() {
        let Some(most) = set.most_lacking() else {
            return Some(set.sizes);
        };
        set.active.push(most);
        let Some(mut found) = set.solve() else {
            set.active.pop();
            set.dependent[most] = true;
            continue;
        };
        // Points whose impulse would pull are released, the first that reaches 0 first.
        while found.iter().any(|size| *size <= 0.0) {
            set.release_pulling(&found)?;
            found = set.solve()?;
        }
        for (&k, size) in set.active.iter().zip(&found) {
            set.sizes[k] = *size;
        }
    }
    None
}

/// The points that have an impulse so far.
struct ActiveSet<'a> {
    points: &'a [Point],
    /// The speed of separation that each point needs at least (length / time).
    demanded: &'a [f64],
    inertias: [&'a Inertia; 2],
    /// The size of the impulse at each point.
    sizes: Vec<f64>,
    /// The points with an impulse.
    active: Vec<usize>,
    /// Whether the impulse at each point follows from those of the others.
    dependent: Vec<bool>,
}

impl ActiveSet<'_> {
    fn yielding(&self, k: usize, l: usize) -> f64 {
        self.points[k].yielding(&self.points[l], self.inertias)
    }

    /// The speed of separation that a point still needs.
    fn lacking(&self, k: usize) -> f64 {
        self.demanded[k]
            - self
                .active
                .iter()
                .map(|&l| self.yielding(k, l) * self.sizes[l])
                .sum::<f64>()
    }

    /// The point without an impulse that lacks most in the norm of the energy; of equal ones the
    /// first. `None` if none lacks more than rounding.
    fn most_lacking(&self) -> Option<usize> {
        let largest = self.demanded.iter().copied().fold(0.0, f64::max);
        let in_energy = |k: usize| self.lacking(k) / self.yielding(k, k).sqrt();
        (0..self.points.len())
            .filter(|k| !self.active.contains(k) && !self.dependent[*k])
            .filter(|&k| self.lacking(k) > ROUNDING * largest)
            .reduce(|one, other| {
                if in_energy(other) > in_energy(one) {
                    other
                } else {
                    one
                }
            })
    }

    /// The sizes with which all active points separate as they must.
    fn solve(&self) -> Option<Vec<f64>> {
        solve(&self.active, self.demanded, |k, l| self.yielding(k, l))
    }

    /// Changes the sizes towards those found until the first one is 0, and releases its point.
    fn release_pulling(&mut self, found: &[f64]) -> Option<()> {
        let Self { sizes, active, .. } = self;
        let steps = active.iter().zip(found).filter(|(_, size)| **size <= 0.0);
        let step = steps
            .map(|(&k, size)| sizes[k] / (sizes[k] - size))
            .fold(1.0, f64::min);
        for (&k, size) in active.iter().zip(found) {
            sizes[k] += step * (size - sizes[k]);
        }
        let pulled = active
            .iter()
            .zip(found)
            .filter(|&(&k, size)| *size <= 0.0 && sizes[k] <= 0.0);
        let released: Vec<usize> = pulled.map(|(&k, _)| k).collect();
        if released.is_empty() {
            return None;
        }
        for &k in &released {
            sizes[k] = 0.0;
        }
        active.retain(|k| !released.contains(k));
        Some(())
    }
}

/// Solves A J = b for the points of a set by elimination; `None` if they depend on each other.
fn solve(
    set: &[usize],
    demanded: &[f64],
    yielding: impl Fn(usize, usize) -> f64,
) -> Option<Vec<f64>> {
    let count = set.len();
    if count > MAX_IMPULSES {
        return None;
    }
    let mut rows: Vec<Vec<f64>> = set
        .iter()
        .map(|&k| {
            set.iter()
                .map(|&l| yielding(k, l))
                .chain([demanded[k]])
                .collect()
        })
        .collect();
    // Positive definite: no exchange of rows is needed.
    for pivot in 0..count {
        if rows[pivot][pivot] <= SINGULAR * yielding(set[pivot], set[pivot]) {
            return None;
        }
        let (done, rest) = rows.split_at_mut(pivot + 1);
        for row in rest {
            let factor = row[pivot] / done[pivot][pivot];
            row.iter_mut()
                .zip(&done[pivot])
                .for_each(|(x, y)| *x -= factor * y);
        }
    }
    let mut solution = vec![0.0; count];
    for k in (0..count).rev() {
        let known: f64 = (k + 1..count).map(|l| rows[k][l] * solution[l]).sum();
        solution[k] = (rows[k][count] - known) / rows[k][k];
    }
    Some(solution)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Impact, Response as _, apply_impulse};
    use carom_kinematics::{kinetic_energy, momentum};
    use proptest::prelude::*;

    /// A rigid row of points at these places along x falls with speed 1 on the ground.
    fn falling_row(places: &[f64], spin: f64, e: f64) -> (Motion, Vec<DVec2>) {
        let moment = places.iter().map(|x| x * x).sum::<f64>() / places.len() as f64 + 0.1;
        let inertia = Inertia::free(1.0, moment);
        let (ground, mut row) = (Motion::at_rest(DVec2::ZERO), Motion::at_rest(DVec2::Y));
        (row.velocity, row.angular_velocity) = (-DVec2::Y, spin);
        let frames: Vec<ContactFrame> = places
            .iter()
            .map(|&x| ContactFrame {
                line_of_centres: 0.5 * DVec2::Y,
                arms: [DVec2::X * x, DVec2::new(x, -0.5)],
            })
            .collect();
        let bodies = [(&ground, &Inertia::FIXED), (&row, &inertia)];
        let impulses = joint_impulses(&frames, bodies, Elasticity::new(e).unwrap()).unwrap();
        for (frame, impulse) in frames.iter().zip(&impulses) {
            row = apply_impulse(&row, &inertia, frame.arms[1], *impulse);
        }
        (row, impulses)
    }

    #[test]
    fn a_row_that_falls_flat_leaves_without_spin() {
        for count in [2, 3, 8, 9, 100] {
            let places: Vec<f64> = (0..count)
                .map(|k| f64::from(k) - 0.5 * f64::from(count - 1))
                .collect();
            for e in [0.0, 0.5, 1.0] {
                let (after, impulses) = falling_row(&places, 0.0, e);
                assert!(
                    (after.velocity.y - e).abs() < 1e-14 && after.angular_velocity.abs() < 1e-14,
                    "{count}"
                );
                assert!(
                    impulses.iter().filter(|impulse| impulse.y > 0.0).count() <= 2,
                    "{count}"
                );
            }
        }
    }

    #[test]
    fn one_point_suffices_where_the_others_separate_fast_enough() {
        // At an instant at which both ends touch, the row turns: the left end falls faster.
        let (after, impulses) = falling_row(&[-1.0, 1.0], 0.5, 1.0);
        // 1/μ = 1 + 1/1.1 at each end; the coupling of the ends is 1 − 1/1.1.
        let [left, right] = [impulses[0].y, impulses[1].y];
        assert!(left > 0.0 && right > 0.0);
        assert!(
            (after.velocity.y - 1.0).abs() < 1e-14 && (after.angular_velocity + 0.5).abs() < 1e-14
        );
        // A strong spin: the right end hardly approaches, and leaves fast enough by the left
        // impulse alone if the coupling is positive.
        let (_, impulses) = falling_row(&[-1.0, -0.4], 0.5, 1.0);
        assert_eq!(
            impulses.iter().filter(|impulse| impulse.y > 0.0).count(),
            1,
            "{impulses:?}"
        );
    }

    proptest! {
        #[test]
        fn joint_impulses_keep_their_conditions(
            places in prop::collection::vec((-1.0..1.0f64, -1.0..1.0f64, 0.0..std::f64::consts::TAU), 2..7),
            motion in (-1.0..1.0f64, -1.0..1.0f64, -2.0..2.0f64),
            masses in (0.1..10.0f64, 0.01..1.0f64, 0.1..10.0f64, 0.01..1.0f64),
            e in 0.0..=1.0f64,
        ) {
            let inertias = [Inertia::free(masses.0, masses.1), Inertia::free(masses.2, masses.3)];
            let mut a = Motion::at_rest(DVec2::ZERO);
            (a.velocity, a.angular_velocity) = (DVec2::new(motion.0, motion.1), motion.2);
            let b = Motion::at_rest(DVec2::new(0.3, -0.2));
            let frames: Vec<ContactFrame> = places
                .iter()
                .map(|&(x, y, angle)| {
                    let point = DVec2::new(x, y);
                    ContactFrame { line_of_centres: DVec2::from_angle(angle), arms: [point, point - b.position] }
                })
                .collect();
            let elasticity = Elasticity::new(e).unwrap();
            let bodies = [(&a, &inertias[0]), (&b, &inertias[1])];
            let Some(impulses) = joint_impulses(&frames, bodies, elasticity) else { return Ok(()) };
            let mut after = [a, b];
            for (frame, &impulse) in frames.iter().zip(&impulses) {
                after = [
                    apply_impulse(&after[0], &inertias[0], frame.arms[0], -impulse),
                    apply_impulse(&after[1], &inertias[1], frame.arms[1], impulse),
                ];
            }
            let sum = |motions: [&Motion; 2], of: fn(&Motion, &Inertia) -> f64| {
                motions.iter().zip(&inertias).map(|(motion, inertia)| of(motion, inertia)).sum::<f64>()
            };
            let (before, now) = ([&a, &b], [&after[0], &after[1]]);
            let scale = sum(before, kinetic_energy).max(sum(now, kinetic_energy));
            let mut work = 0.0;
            for (frame, impulse) in frames.iter().zip(&impulses) {
                let (u, left) = (approach_speed(frame, before), -approach_speed(frame, now));
                let size = impulse.dot(frame.normal());
                prop_assert!(size >= 0.0);
                if u > 0.0 {
                    prop_assert!(left >= e * u - 1e-9, "{left} {u}");
                    prop_assert!(size == 0.0 || (left - e * u).abs() < 1e-9);
                }
                work += 0.5 * (1.0 - e) * size * u;
            }
            prop_assert!((sum(before, kinetic_energy) - sum(now, kinetic_energy) - work).abs() <= 1e-11 * scale);
            let total = |motions: [&Motion; 2]| {
                momentum(motions[0], &inertias[0]) + momentum(motions[1], &inertias[1])
            };
            prop_assert!((total(before) - total(now)).length() <= 1e-12 * (1.0 + total(before).length()) * 10.0);
            prop_assert!(impulses.iter().filter(|impulse| **impulse != DVec2::ZERO).count() <= MAX_IMPULSES);
        }
    }

    #[test]
    fn one_approaching_point_is_an_ordinary_contact() {
        let inertia = Inertia::free(1.0, 1.0);
        let (a, b) = (
            Motion {
                velocity: DVec2::X,
                ..Motion::at_rest(DVec2::ZERO)
            },
            Motion::at_rest(DVec2::X),
        );
        let frames = [DVec2::X, -DVec2::X].map(|line_of_centres| ContactFrame {
            line_of_centres,
            arms: [DVec2::ZERO; 2],
        });
        let bodies = [(&a, &inertia), (&b, &inertia)];
        assert_eq!(
            Impact.joint_impulses(&frames, bodies, Elasticity::ELASTIC),
            None
        );
    }
}
