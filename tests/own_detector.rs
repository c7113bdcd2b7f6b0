//! A user-defined detector decides about all pairs: discs in a gas, large discs and bumpers.

use carom_detection::{Answer, DISC_LANES, Detection, DiscLanes, Exact, Outcome};
use carom_engine::{
    AtomSpec, BumperSpec, CellScheduler, CollisionReport, GasSpec, Instructions, MoleculeSpec,
    Observer, Scene, Simulation,
};
use carom_geometry::Outline;
use carom_kinematics::{Motion, RelativeMotion};
use carom_response::Impact;

/// A detector that lets bodies pass through each other unless both are small.
#[derive(Debug, Clone, Copy)]
struct SmallOnly {
    /// Sum of the bounding radii (length).
    largest: f64,
}

impl Detection for SmallOnly {
    fn first_contact(
        &self,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Answer {
        if a.bounding_radius + b.bounding_radius > self.largest {
            return Answer {
                outcome: Outcome::Free,
                evaluations: 0,
            };
        }
        Exact::default().first_contact(a, b, motion, horizon)
    }

    fn disc_contacts(&self, lanes: &DiscLanes) -> [f64; DISC_LANES] {
        let mut times = lanes.contact_times();
        for (time, &sum) in times.iter_mut().zip(&lanes.contact_distance) {
            if sum > self.largest {
                *time = f64::INFINITY;
            }
        }
        times
    }
}

/// Number of contacts of two small bodies, and of all others.
#[derive(Default)]
struct Counts {
    small: u32,
    others: u32,
}

impl Observer for Counts {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        let small = report
            .sides
            .iter()
            .all(|side| side.body.molecule().bounding_radius() < 0.03);
        *(if small {
            &mut self.small
        } else {
            &mut self.others
        }) += 1;
    }
}

fn disc(radius: f64, count: usize) -> GasSpec {
    GasSpec {
        radius: Some(radius.into()),
        mass: Some(1.0.into()),
        energy: 1.0,
        count: Some(count),
        ..GasSpec::default()
    }
}

fn counts(detector: impl Detection) -> Counts {
    let mut scene = Scene::default();
    scene.bounds.seed = 5;
    let atom = |radius: f64| {
        vec![AtomSpec {
            at: [0.0; 2],
            radius,
            mass: 25.0,
        }]
    };
    scene.molecule = vec![
        MoleculeSpec {
            atoms: atom(0.15),
            at: [0.9, 0.1],
            ..MoleculeSpec::default()
        },
        MoleculeSpec {
            atoms: atom(0.1),
            at: [0.3, 0.2],
            velocity: [1.0, 0.3],
            ..MoleculeSpec::default()
        },
    ];
    scene.bumper = vec![BumperSpec {
        radius: 0.08,
        at: [0.4, 0.7],
        tags: vec![],
    }];
    scene.gas = vec![disc(0.02, 120)];
    let mut simulation: Simulation<_, Impact, CellScheduler> =
        Simulation::with(&scene, detector, Impact, Instructions::default())
            .expect("a scene that can be built");
    let mut counts = Counts::default();
    for _ in 0..3000 {
        simulation.step(1e3, &mut counts).unwrap();
    }
    counts
}

#[test]
fn pairs_without_a_contact_by_the_detector_do_not_collide() {
    let exact = counts(Exact::default());
    assert!(
        exact.small > 100 && exact.others > 100,
        "{} and {}",
        exact.small,
        exact.others
    );
    let blind = counts(SmallOnly { largest: 0.05 });
    assert!(blind.small > 100, "{}", blind.small);
    assert_eq!(blind.others, 0);
}

/// Positions and velocities of a gas of equal discs after a thousand contacts.
fn paths(detector: impl Detection, scene: &Scene) -> Vec<[f64; 4]> {
    let mut simulation: Simulation<_, Impact, CellScheduler> =
        Simulation::with(scene, detector, Impact, Instructions::default())
            .expect("a scene that can be built");
    for _ in 0..1000 {
        simulation.step(1e3, &mut ()).unwrap();
    }
    let view = simulation.view();
    let numbers = |motion: Motion| {
        [
            motion.position.x,
            motion.position.y,
            motion.velocity.x,
            motion.velocity.y,
        ]
    };
    view.bodies().map(|body| numbers(body.motion)).collect()
}

/// A detector that does not declare a closed form for discs is called for each pair of discs. If it
/// gives the same answers, the run is the same to the bit: in a dense gas; in dilute gases, where
/// the single-precision filter excludes pairs; with discs so small that the filter's rounding
/// matters; and with light discs that become faster than any body at the start.
#[test]
fn discs_move_equally_with_a_called_detector_and_in_closed_form() {
    let light = GasSpec {
        mass: Some((1e-3).into()),
        energy: 1e-9,
        ..disc(0.005, 60)
    };
    let gases = [
        (vec![disc(0.03, 100)], [1.0, 1.0]),
        (vec![disc(0.008, 120)], [1.0, 1.0]),
        (vec![disc(0.005, 60)], [1.0, 1.0]),
        (vec![disc(1e-5, 200)], [1.0, 1.0]),
        (vec![disc(0.005, 60), light], [1.5, 0.5]),
    ];
    for (gas, sides) in gases {
        let mut scene = Scene {
            gas,
            ..Scene::default()
        };
        (scene.bounds.seed, scene.bounds.sides) = (5, sides);
        assert_eq!(
            paths(Exact::default(), &scene),
            paths(SmallOnly { largest: 1.0 }, &scene)
        );
    }
}
