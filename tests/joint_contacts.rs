//! Contacts of two bodies at several points at one instant: one joint impulse, and symmetric
//! contacts stay symmetric.

use crate::support::{simulate, test_each_scheduler};
use carom_engine::{
    CellScheduler, CollisionReport, Instructions, Observer, Scene, Scheduler, View,
};

test_each_scheduler! {
    a_rod_that_falls_flat_on_a_wall_leaves_without_spin: check_flat_rod;
    a_disc_in_a_notch_goes_back_the_way_it_came: check_notch;
    a_rod_on_a_rod_exchanges_its_momentum: check_rods;
    a_flat_fall_without_restitution_ends_at_rest_on_the_wall: check_inelastic;
}

/// Impulses, numbers of points, and the largest torque of a resultant less the change of angular
/// momentum.
#[derive(Debug, Default)]
struct Log {
    impulses: Vec<[f64; 2]>,
    points: Vec<u32>,
    torque_error: f64,
}

impl Observer for Log {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.impulses.push(report.impulse.to_array());
        self.points.push(report.points);
        for (side, impulse) in report.sides.iter().zip([-report.impulse, report.impulse]) {
            if side.body.can_turn() {
                let torque = side.arm.perp_dot(impulse);
                self.torque_error = self
                    .torque_error
                    .max((torque - side.angular_momentum_change()).abs());
            }
        }
    }
}

fn contacts<S: Scheduler>(
    text: &str,
    options: &S::Options,
    count: usize,
) -> (Log, Vec<([f64; 2], f64)>, u64) {
    let scene = Scene::from_toml(text).unwrap_or_else(|error| panic!("{error}"));
    let mut simulation = simulate::<S>(&scene, options);
    let mut log = Log::default();
    for _ in 0..count {
        assert!(simulation.step(100.0, &mut log).unwrap());
    }
    let motions = |view: &View<'_>| {
        let moving = view.bodies().filter(|body| !body.body.is_fixed());
        moving
            .map(|body| {
                (
                    body.motion.velocity.to_array(),
                    body.motion.angular_velocity,
                )
            })
            .collect()
    };
    let joint = simulation.view().counters().joint_collisions;
    (log, motions(&simulation.view()), joint)
}

fn check_flat_rod<S: Scheduler>(options: &S::Options) {
    for atoms in [2u32, 3, 8, 9, 40] {
        for tilted in [false, true] {
            // Along the axes, and with all directions turned by a third of a radian.
            let (sin, cos) = if tilted {
                (1.0f64 / 3.0).sin_cos()
            } else {
                (0.0, 1.0)
            };
            let turned = |[x, y]: [f64; 2]| [0.5 + cos * x - sin * y, 0.5 + sin * x + cos * y];
            let [from, to] = [turned([-0.4, -0.2]), turned([0.4, -0.2])];
            let angle = sin.atan2(cos);
            let text = format!(
                "[[wall]]\nfrom = {from:?}\nto = {to:?}\n[[molecule]]\nshape = \"rod:{atoms}\"\n\
                 atom_radius = 0.005\natom_mass = 1.0\nat = [0.5, 0.5]\norientation = {angle}\n\
                 velocity = [{}, {}]\n",
                sin, -cos
            );
            let (log, motions, joint) = contacts::<S>(&text, options, 1);
            let ([vx, vy], spin) = motions[0];
            assert!(
                (vx + sin).abs() < 1e-14 && (vy - cos).abs() < 1e-14,
                "rod:{atoms} {motions:?}"
            );
            assert!(spin.abs() < 1e-12, "rod:{atoms} {spin}");
            assert_eq!(
                (log.points[0], log.impulses.len(), joint),
                (atoms, 1, 1),
                "{log:?}"
            );
            assert!(log.torque_error < 1e-12, "{log:?}");
        }
    }
}

fn check_notch<S: Scheduler>(options: &S::Options) {
    // A disc falls between the two atoms of a fixed dumbbell, and between those of a free one.
    for (fixed, speed) in [("fixed = true\n", 1.0), ("", -0.5)] {
        let text = format!(
            "[[molecule]]\nshape = \"dumbbell\"\natom_radius = 0.05\natom_mass = 0.5\nat = [0.5, 0.5]\n{fixed}\
             [[molecule]]\nshape = \"disc\"\natom_radius = 0.05\natom_mass = 3.0\nat = [0.5, 0.8]\n\
             velocity = [0.0, -1.0]\n"
        );
        let (log, motions, joint) = contacts::<S>(&text, options, 1);
        assert_eq!((log.points.as_slice(), joint), ([2].as_slice(), 1));
        // Head-on: the disc of mass 3 continues with (3 − 1)/(3 + 1) of its speed, or turns round.
        let ([vx, vy], _) = motions[motions.len() - 1];
        assert!(
            vx.abs() < 1e-15 && (vy - speed).abs() < 1e-14,
            "{motions:?}"
        );
        assert!(
            motions.iter().all(|(_, spin)| spin.abs() < 1e-13),
            "{motions:?}"
        );
    }
}

fn check_rods<S: Scheduler>(options: &S::Options) {
    // Parallel, one half of their length beside the other: the resultant is in the middle of the
    // part in which they meet, and turns both alike.
    let rod = |at: [f64; 2], vy: f64| {
        format!(
            "[[molecule]]\nshape = \"rod:6\"\natom_radius = 0.01\natom_mass = 1.0\nat = {at:?}\n\
             velocity = [0.0, {vy:?}]\n"
        )
    };
    let text = rod([0.5, 0.4], 0.5) + &rod([0.56, 0.6], -0.5);
    let (log, motions, joint) = contacts::<S>(&text, options, 1);
    assert!(
        joint == 1 && log.points[0] > 1 && log.torque_error < 1e-12,
        "{log:?}"
    );
    let [(first, one), (second, other)] = motions[..] else {
        panic!("{motions:?}")
    };
    assert!(
        (first[1] + second[1]).abs() < 1e-15 && (one - other).abs() < 1e-12 && one != 0.0,
        "{motions:?}"
    );
    // Elastic: 6 masses of speed ½ and I = Σ m (x² + ½ r²) for each.
    let moment: f64 = (0..6)
        .map(|k| (0.02 * (f64::from(k) - 2.5)).powi(2) + 0.5 * 0.01 * 0.01)
        .sum();
    let energy =
        |v: [f64; 2], spin: f64| 3.0 * (v[0] * v[0] + v[1] * v[1]) + 0.5 * moment * spin * spin;
    assert!((energy(first, one) + energy(second, other) - 1.5).abs() < 1e-14);
}

fn check_inelastic<S: Scheduler>(options: &S::Options) {
    let text = "[elasticity]\ndefault = 0.0\n[[wall]]\ny = 0.0\n[[molecule]]\nshape = \"rod:7\"\natom_radius = 0.02\n\
                atom_mass = 1.0\nat = [0.5, 0.5]\nvelocity = [0.25, -1.0]\n";
    let (_, motions, _) = contacts::<S>(text, options, 1);
    let ([vx, vy], spin) = motions[0];
    assert!(
        (vx - 0.25).abs() < 1e-15 && (0.0..1e-3).contains(&vy) && spin.abs() < 1e-12,
        "{motions:?}"
    );
}

#[test]
fn contacts_with_several_bodies_at_one_instant_are_counted() {
    // The disc in the middle is hit from both sides at once: the second contact follows the first.
    let text = "[[molecule]]\nshape = \"disc\"\natom_radius = 0.05\natom_mass = 1.0\nat = [0.5, 0.5]\n\
                [[molecule]]\nshape = \"disc\"\natom_radius = 0.05\natom_mass = 1.0\nat = [0.25, 0.5]\n\
                velocity = [1.0, 0.0]\n[[molecule]]\nshape = \"disc\"\natom_radius = 0.05\natom_mass = 1.0\n\
                at = [0.75, 0.5]\nvelocity = [-1.0, 0.0]\n";
    let scene = Scene::from_toml(text).unwrap();
    let mut simulation = simulate::<CellScheduler>(&scene, &Instructions::default());
    simulation.run_until(0.2).unwrap();
    let view = simulation.view();
    assert_eq!(
        (
            view.counters().collisions,
            view.counters().simultaneous_collisions
        ),
        (3, 2)
    );
}
