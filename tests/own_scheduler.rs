//! A scheduler of one's own, which compares all pairs in all images, and the shipped ones against it.

#[path = "support/engine.rs"]
mod support;

use carom_detection::{Detection, Exact, Outcome};
use carom_engine::{
    CollisionReport, GridError, Observer, Scene, Scheduler, SchedulerCounters, Simulation, World,
    rounding_bound,
    scheduler::{ContactEvent, EventLoop, EventQueue, Parts, StoredMotions},
};
use carom_kinematics::{Motion, RelativeMotion};
use carom_response::{ContactFrame, Impact, approach_speed};
use glam::DVec2;
use support::{frozen, reference_scene, scenes, simulate, test_each_scheduler};

/// Asks every pair in every image for its next contact, each time anew. It keeps nothing but the
/// motions, whose positions it never wraps.
struct AllPairs {
    motions: Vec<Motion>,
    windings: Vec<[i64; 2]>,
    now: f64,
    done: SchedulerCounters,
}

impl Scheduler for AllPairs {
    type Options = ();

    const CONTACTS_PER_EPOCH: u64 = 8;

    fn new((): &(), _: &World) -> Result<Self, GridError> {
        let (motions, windings) = (Vec::new(), Vec::new());
        Ok(Self { motions, windings, now: 0.0, done: SchedulerCounters::default() })
    }

    fn begin_epoch<D: Detection>(&mut self, world: &World, _: &D, _: f64) {
        (self.motions, self.windings) = (world.motions().to_vec(), world.windings().to_vec());
        self.now = 0.0;
    }

    fn run<L: EventLoop>(&mut self, events: L) -> L::End {
        events.run(self)
    }

    fn store(&self, state: &mut StoredMotions<'_>) {
        for (body, (&motion, &winding)) in self.motions.iter().zip(&self.windings).enumerate() {
            state.set(body as u32, motion, winding);
        }
    }

    fn heap_bytes(&self) -> usize {
        size_of_val(&self.motions[..]) + size_of_val(&self.windings[..])
    }

    fn counters(&self) -> SchedulerCounters {
        self.done
    }
}

impl EventQueue for AllPairs {
    fn next_contact<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        stop: f64,
    ) -> Option<ContactEvent> {
        let fastest = self.motions.iter().map(|motion| motion.velocity.length()).fold(0.0, f64::max);
        let quarter = 0.25 * world.bounds().sides().min_element();
        loop {
            // In this time no two bodies approach each other by more than half a side.
            let mut until = (self.now + quarter / fastest).min(stop);
            let mut soonest: Option<ContactEvent> = None;
            for (bodies, image) in self.pairs_and_images(world) {
                self.done.pairs += 1;
                let [a, b] = bodies.map(|body| &self.motions[body as usize]);
                let relative = RelativeMotion::between(a, b, world.bounds().shift(image), self.now);
                let [a, b] = bodies.map(|body| world.bodies()[body as usize].molecule().outline());
                match detection.first_contact(a, b, &relative, until - self.now).outcome {
                    Outcome::Contact(contact) => {
                        let (time, parts) = (self.now + contact.time, contact.touch.into());
                        let found = ContactEvent { time, bodies, image, parts };
                        if soonest.is_none_or(|soonest| found.in_order(&soonest).is_lt()) {
                            soonest = Some(found);
                        }
                    }
                    Outcome::FreeUntil(time) | Outcome::Unresolved(time) => {
                        until = until.min((self.now + time).max(self.now.next_up()));
                    }
                    Outcome::Free | Outcome::OutOfRange => {}
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
        for (body, motion) in bodies.into_iter().zip(motions) {
            if !world.bodies()[body as usize].is_fixed() {
                self.motions[body as usize] = motion;
            }
        }
    }
}

impl AllPairs {
    /// All pairs of which one body moves, each with all images of the second that the first may
    /// reach before their centres have approached by half a side: the nearest, and those around it.
    fn pairs_and_images(&self, world: &World) -> Vec<([u32; 2], [i64; 2])> {
        let (bodies, sides) = (world.bodies(), world.bounds().sides());
        let mut list = Vec::new();
        for a in 0..bodies.len() {
            for b in a + 1..bodies.len() {
                if bodies[a].is_fixed() && bodies[b].is_fixed() {
                    continue;
                }
                let [from, to] = [a, b].map(|body| self.motions[body].position_at(self.now));
                let nearest = ((from - to) / sides).round().to_array().map(|boxes| boxes as i64);
                let reach = [a, b].map(|body| bodies[body].molecule().bounding_radius());
                let [w, h] = ((reach[0] + reach[1]) / sides).to_array().map(|boxes| boxes.ceil() as i64);
                let around = (-w..=w).flat_map(|x| (-h..=h).map(move |y| [nearest[0] + x, nearest[1] + y]));
                list.extend(around.map(|image| ([a as u32, b as u32], image)));
            }
        }
        list
    }
}

/// One contact, as it can be compared between schedulers that wrap positions at different times.
#[derive(Debug, Clone, Copy)]
struct Contact {
    time: f64,
    bodies: [u64; 2],
    atoms: [Option<u32>; 2],
    /// From the centre of the first body to that of the second, of the image that is touched.
    separation: DVec2,
    approach: f64,
}

/// Keeps the last contact.
#[derive(Default)]
struct Last {
    sides: DVec2,
    contact: Option<Contact>,
}

impl Observer for Last {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        let [a, b] = &report.sides;
        let image = DVec2::new(report.image[0] as f64, report.image[1] as f64);
        let frame = ContactFrame { line_of_centres: report.normal, arms: [a.arm, b.arm] };
        self.contact = Some(Contact {
            time: report.time.to_f64(),
            bodies: [a.body.id(), b.body.id()],
            atoms: [a.atom, b.atom],
            separation: b.before.position - a.before.position + image * self.sides,
            approach: approach_speed(&frame, [&a.before, &b.before]),
        });
    }
}

/// The next contact of a scene, and the state after it.
fn next<S: Scheduler>(scene: &Scene, options: &S::Options) -> (Contact, Simulation<Exact, Impact, S>) {
    let mut simulation = simulate::<S>(scene, options);
    let mut last = Last { sides: DVec2::from(scene.bounds.sides), contact: None };
    assert!(simulation.step(1e3, &mut last).unwrap(), "there is a contact");
    (last.contact.expect("it was reported"), simulation)
}

/// Compares contact after contact with that of all pairs, each from a common state.
fn compare<S: Scheduler>(options: &S::Options) {
    for (name, mut scene) in scenes() {
        // As many pairs as all images of can be asked in a short time.
        scene.gas.iter_mut().for_each(|gas| gas.count = gas.count.map(|count| count.div_ceil(3)));
        for n in 0..25 {
            let wall = scene.wall.clone();
            scene = Scene { wall: wall.clone(), ..frozen(&simulate::<S>(&scene, options).view()) };
            let (expected, simulation) = next::<AllPairs>(&scene, &());
            let (found, _) = next::<S>(&scene, options);
            let what = format!("{name}, contact {n}: {found:?}, {expected:?}");
            assert_eq!(found.bodies, expected.bodies, "{what}");
            assert_eq!(found.atoms, expected.atoms, "{what}");
            let sides = DVec2::from(scene.bounds.sides);
            assert!((found.separation - expected.separation).length() < 1e-9 * sides.min_element(), "{what}");
            // Either finds the gap closed to within the bound on the rounding of a contact.
            let reach = simulation.view().bodies().map(|body| body.body.molecule().bounding_radius());
            let gap = rounding_bound(sides, reach.fold(0.0, f64::max));
            assert!((found.time - expected.time).abs() * expected.approach < 2.0 * gap, "{what}");
            scene = Scene { wall, ..frozen(&simulation.view()) };
        }
    }
}

test_each_scheduler! {
    contacts_are_those_of_all_pairs: compare;
}

#[test]
fn a_scheduler_from_outside_runs_a_scene_through_many_epochs() {
    let mut scene = reference_scene(7);
    scene.gas.iter_mut().for_each(|gas| gas.count = gas.count.map(|count| count.div_ceil(4)));
    let mut simulation = simulate::<AllPairs>(&scene, &());
    let energy = simulation.view().energy();
    simulation.run_until(20.0).unwrap();
    let view = simulation.view();
    assert!(view.counters().epochs > 10 && view.counters().collisions > 400, "{:?}", view.counters());
    assert_eq!(view.overlaps().pairs, 0);
    assert!((view.energy() - energy).abs() < 1e-13 * energy);
    let sides = DVec2::from(scene.bounds.sides);
    assert!(view.bodies().all(|body| body.motion.position.cmplt(sides).all()));
    assert!(view.bodies().any(|body| body.winding != [0, 0]), "somebody has left the box");
}

#[test]
fn the_order_of_ties_is_that_of_the_bodies() {
    let at = |time, bodies| ContactEvent { time, bodies, image: [0; 2], parts: Parts::Discs };
    assert!(at(1.0, [7, 8]).in_order(&at(2.0, [0, 1])).is_lt());
    assert!(at(1.0, [0, 8]).in_order(&at(1.0, [1, 2])).is_lt());
    assert!(at(1.0, [0, 3]).in_order(&at(1.0, [0, 2])).is_gt());
}
