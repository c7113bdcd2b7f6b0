//! A user-defined scheduler, which compares all pairs in all images, and the shipped schedulers
//! against it.

use crate::support::{frozen, reference_scene, scenes, simulate, test_each_scheduler};
use carom_detection::{Detection, Exact, Outcome};
use carom_engine::{
    CollisionReport, GridError, Observer, Scene, Scheduler, SchedulerCounters, Simulation, World,
    rounding_bound,
    scheduler::{ContactEvent, EventLoop, EventQueue, StoredMotions, TouchingParts},
};
use carom_kinematics::Motion;
use carom_response::{ContactFrame, Impact, approach_speed};
use glam::DVec2;

/// Computes the next contact of each pair in each image anew for each event. It stores only the
/// motions, whose positions it never wraps.
pub(crate) struct AllPairs {
    motions: Vec<Motion>,
    now: f64,
}

impl Scheduler for AllPairs {
    type Options = ();

    const CONTACTS_PER_EPOCH: u64 = 8;
    // Bodies are passed through the seam at the end of the epoch.
    const RUNS_SHEAR: bool = true;

    fn new((): &(), _: &World) -> Result<Self, GridError> {
        Ok(Self {
            motions: Vec::new(),
            now: 0.0,
        })
    }

    fn begin_epoch<D: Detection>(&mut self, world: &World, _: &D, _: f64) {
        (self.motions, self.now) = (world.motions().to_vec(), 0.0);
    }

    fn run<L: EventLoop>(&mut self, events: L) -> L::End {
        events.run(self)
    }

    fn store(&self, state: &mut StoredMotions<'_>) {
        for (body, &motion) in (0..).zip(&self.motions) {
            state.set(body, motion, state.winding(body));
        }
    }

    fn heap_bytes(&self) -> usize {
        size_of_val(&self.motions[..])
    }

    fn counters(&self) -> SchedulerCounters {
        SchedulerCounters::default()
    }
}

impl EventQueue for AllPairs {
    fn next_contact<D: Detection>(
        &mut self,
        world: &World,
        search: &D,
        stop: f64,
    ) -> Option<ContactEvent> {
        let (all, sides) = (world.bodies(), world.bounds().sides());
        let fastest = self
            .motions
            .iter()
            .map(|motion| motion.velocity.length())
            .fold(world.shear_rate().abs() * sides.y, f64::max);
        let pairs = (0..all.len()).flat_map(|a| (a + 1..all.len()).map(move |b| [a, b]));
        let pairs: Vec<_> = pairs
            .filter(|pair| !pair.iter().all(|&body| all[body].is_fixed()))
            .collect();
        loop {
            // In this time no two bodies approach each other by more than half a side, so that they
            // meet in the nearest image or in an image next to it within reach.
            let mut until = (self.now + 0.25 * sides.min_element() / fastest).min(stop);
            let mut soonest: Option<ContactEvent> = None;
            for &pair in &pairs {
                let [a, b] = pair.map(|body| &self.motions[body]);
                let molecules = pair.map(|body| all[body].molecule());
                let reach: f64 = molecules
                    .iter()
                    .map(|molecule| molecule.bounding_radius())
                    .sum();
                let [w, h] = (reach / sides).to_array().map(|boxes| boxes.ceil() as i64);
                let bodies = pair.map(|body| body as u32);
                let seen = |image| world.relative_motion(bodies, [a, b], image, self.now);
                let nearest = |apart: f64, side: f64| -(apart / side).round() as i64;
                let y = nearest(seen([0, 0]).separation.y, sides.y);
                let images = (y - h..=y + h).flat_map(|y| {
                    let x = nearest(seen([0, y]).separation.x, sides.x);
                    (x - w..=x + w).map(move |x| [x, y])
                });
                for image in images {
                    let relative = seen(image);
                    let [a, b] = molecules.map(|molecule| molecule.outline());
                    match search
                        .first_contact(a, b, &relative, until - self.now)
                        .outcome
                    {
                        Outcome::Contact(contact) => {
                            let (time, parts) = (self.now + contact.time, contact.touch.into());
                            let found = ContactEvent {
                                time,
                                bodies,
                                image,
                                parts,
                            };
                            soonest = soonest
                                .filter(|best| best.in_order(&found).is_lt())
                                .or(Some(found));
                        }
                        Outcome::FreeUntil(time) | Outcome::Unresolved(time) => {
                            until = until.min((self.now + time).max(self.now.next_up()));
                        }
                        Outcome::Free => {}
                        Outcome::OutOfRange => {
                            panic!("bodies {pair:?} cannot be searched: {relative:?}")
                        }
                    }
                }
            }
            let found = soonest.filter(|contact| contact.time <= until);
            self.now = found.map_or(until, |contact| contact.time);
            if found.is_some() || until == stop {
                return found;
            }
        }
    }

    fn motion(&self, body: u32) -> Motion {
        self.motions[body as usize]
    }

    fn motions_changed<D: Detection>(
        &mut self,
        world: &World,
        _: &D,
        bodies: [u32; 2],
        motions: [Motion; 2],
    ) {
        let both = bodies.map(|body| body as usize).into_iter().zip(motions);
        let moving = both.filter(|&(body, _)| !world.bodies()[body].is_fixed());
        moving.for_each(|(body, motion)| self.motions[body] = motion);
    }
}

/// A contact in a form that can be compared between schedulers that wrap positions at different
/// times.
#[derive(Debug, Clone, Copy)]
struct Contact {
    time: f64,
    bodies: [u64; 2],
    atoms: [Option<u32>; 2],
    /// From the centre of the first body to that of the touched image of the second.
    separation: DVec2,
    approach: f64,
}

/// Stores the last contact.
#[derive(Default)]
struct Last {
    sides: DVec2,
    contact: Option<Contact>,
}

impl Observer for Last {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        let [a, b] = &report.sides;
        let image = DVec2::new(report.image[0] as f64, report.image[1] as f64);
        let frame = ContactFrame {
            line_of_centres: report.normal,
            arms: [a.arm, b.arm],
        };
        self.contact = Some(Contact {
            time: report.time.to_f64(),
            bodies: [a.body.id(), b.body.id()],
            atoms: [a.atom, b.atom],
            separation: b.before.position - a.before.position + image * self.sides,
            approach: approach_speed(&frame, [&a.before, &b.before]),
        });
    }
}

/// Returns the next contact of a run.
fn next<S: Scheduler>(simulation: &mut Simulation<Exact, Impact, S>, sides: DVec2) -> Contact {
    let mut last = Last {
        sides,
        contact: None,
    };
    assert!(
        simulation.step(1e3, &mut last).unwrap(),
        "there is a contact"
    );
    last.contact.expect("it was reported")
}

/// The largest distance between equal bodies of two runs (length).
fn deviation<S: Scheduler, T: Scheduler>(
    one: &Simulation<Exact, Impact, S>,
    other: &Simulation<Exact, Impact, T>,
    sides: DVec2,
) -> f64 {
    let (one, other) = (one.view(), other.view());
    let apart = one.bodies().zip(other.bodies()).map(|(one, other)| {
        let apart = one.motion.position - other.motion.position;
        (apart - sides * (apart / sides).round()).length()
    });
    apart.fold(0.0, f64::max)
}

/// Number of contacts compared from each common state on, if rounding permits.
const CONTACTS: usize = 8;

/// Number of common states of each scene.
const RUNS: usize = 4;

/// Relative change of velocities with which the instability of a run is measured.
const PERTURBATION: f64 = 1e-9;

/// Allowed distance of two runs, in units of the bound on the rounding of a contact times the
/// measured instability. The largest seen is 0.24.
const ALLOWED: f64 = 2.0;

/// Runs are compared while rounding separates them by at most this share of the shorter side.
const RESOLVED: f64 = 1e-9;

/// The scene with all velocities changed by [`PERTURBATION`], with opposite signs along x and y.
fn perturbed(mut scene: Scene) -> Scene {
    for molecule in &mut scene.molecule {
        molecule.velocity[0] *= 1.0 + PERTURBATION;
        molecule.velocity[1] *= 1.0 - PERTURBATION;
        molecule.angular_velocity *= 1.0 + PERTURBATION;
    }
    scene
}

/// Compares runs of several contacts with those of all pairs, each from a common state.
///
/// The rate at which runs separate that differ by rounding is measured with a third run, also of
/// all pairs, whose velocities are slightly changed.
fn compare<S: Scheduler>(options: &S::Options) {
    let (mut compared, mut possible) = (0, 0);
    for (name, mut scene) in scenes() {
        // A number of bodies for which all pairs in all images can be computed in a short time.
        scene
            .gas
            .iter_mut()
            .for_each(|gas| gas.count = gas.count.map(|count| count.div_ceil(3)));
        let sides = DVec2::from(scene.bounds.sides);
        for run in 0..RUNS {
            let wall = scene.wall.clone();
            scene = Scene {
                wall: wall.clone(),
                ..frozen(&simulate::<S>(&scene, options).view())
            };
            let mut all_pairs = simulate::<AllPairs>(&scene, &());
            let mut twin = simulate::<AllPairs>(&perturbed(scene.clone()), &());
            let mut simulation = simulate::<S>(&scene, options);
            let reach = simulation
                .view()
                .bodies()
                .map(|body| body.body.molecule().bounding_radius());
            // Each finds the gap closed to within the bound on the rounding of a contact.
            let gap = rounding_bound(sides, reach.fold(0.0, f64::max));
            possible += CONTACTS;
            for n in 0..CONTACTS {
                let expected = next(&mut all_pairs, sides);
                let instability = if next(&mut twin, sides).bodies == expected.bodies {
                    deviation(&all_pairs, &twin, sides) / (PERTURBATION * sides.min_element())
                } else {
                    f64::INFINITY
                };
                let allowed = ALLOWED * gap * instability.max(1.0);
                if allowed > RESOLVED * sides.min_element() {
                    break;
                }
                compared += 1;
                let found = next(&mut simulation, sides);
                let what = format!("{name}, run {run}, contact {n}: {found:?}, {expected:?}");
                assert_eq!(found.bodies, expected.bodies, "{what}");
                assert_eq!(found.atoms, expected.atoms, "{what}");
                let late = (found.time - expected.time).abs() * expected.approach;
                let off = (found.separation - expected.separation).length();
                let apart = deviation(&all_pairs, &simulation, sides);
                // Before the first contact there are no others that amplify a rounding.
                assert!(
                    late < if n == 0 { ALLOWED * gap } else { allowed },
                    "{what}"
                );
                assert!(
                    off < allowed && apart < allowed,
                    "{what}: {off:e} and {apart:e} of {allowed:e}"
                );
            }
            scene = Scene {
                wall,
                ..frozen(&all_pairs.view())
            };
        }
    }
    assert!(
        10 * compared > 9 * possible,
        "{compared} of {possible} contacts"
    );
}

test_each_scheduler! {
    contacts_are_those_of_all_pairs: compare;
}

#[test]
fn a_user_defined_scheduler_runs_a_scene_through_many_epochs() {
    let mut scene = reference_scene(7);
    scene
        .gas
        .iter_mut()
        .for_each(|gas| gas.count = gas.count.map(|count| count.div_ceil(4)));
    let mut simulation = simulate::<AllPairs>(&scene, &());
    let energy = simulation.view().energy();
    simulation.run_until(20.0).unwrap();
    let view = simulation.view();
    assert!(
        view.counters().epochs > 10 && view.counters().collisions > 400,
        "{:?}",
        view.counters()
    );
    assert_eq!(view.overlaps().pairs, 0);
    assert!((view.energy() - energy).abs() < 1e-13 * energy);
    let sides = DVec2::from(scene.bounds.sides);
    assert!(
        view.bodies()
            .all(|body| body.motion.position.cmplt(sides).all())
    );
    assert!(
        view.bodies().any(|body| body.winding != [0, 0]),
        "a body has left the box"
    );
}

#[test]
fn ties_are_in_the_order_of_the_bodies() {
    let at = |time, bodies| ContactEvent {
        time,
        bodies,
        image: [0; 2],
        parts: TouchingParts::Discs,
    };
    assert!(at(1.0, [7, 8]).in_order(&at(2.0, [0, 1])).is_lt());
    assert!(at(1.0, [0, 8]).in_order(&at(1.0, [1, 2])).is_lt());
    assert!(at(1.0, [0, 3]).in_order(&at(1.0, [0, 2])).is_gt());
}

#[test]
fn a_scheduler_that_does_not_run_driven_bodies_is_refused_with_them() {
    for text in [
        "[gravity]\nacceleration = [0.0, -1.0]\n[[wall]]\ny = 0.0",
        "[[wall]]\ny = 0.0\nmotion = { amplitude = [0.0, 0.1], frequency = 1.0 }",
    ] {
        let scene = Scene::from_toml(text).unwrap();
        let refused = Simulation::<_, _, AllPairs>::with(&scene, Exact::default(), Impact, ());
        let words = refused.map(|_| ()).unwrap_err().to_string();
        assert!(words.contains("this scheduler runs neither"), "{words}");
    }
}

#[test]
fn a_scheduler_that_does_not_run_tethers_is_refused_with_bonds() {
    let text = "[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 4\n\
        chain = { members = 2, tether = { max = 0.06 } }";
    let scene = Scene::from_toml(text).unwrap();
    let refused = Simulation::<_, _, AllPairs>::with(&scene, Exact::default(), Impact, ());
    let words = refused.map(|_| ()).unwrap_err().to_string();
    assert!(words.contains("does not run tethers"), "{words}");
}
