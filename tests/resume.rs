//! A run that is stored at the end of an epoch and resumed is equal, to the bit, to the run that
//! continued.

use crate::support::{
    bits, disc, gas, named, reference_scene, rule, scene, simulate, test_each_scheduler,
};
use carom::{
    BodyKey, Checkpoint, CollisionRate, DirectionHistogram, EnergyLedger, EpochTime, Exact, Impact,
    Observer, OverlapCheck, Pressure, ProjectionHistogram, RunningAverage, Scene, Scheduler,
    Simulation,
    engine::{ElasticityRule, ElasticitySpec, GasSpec, Restitution, Rotation},
    observers::{
        BodyAxis, ContactDensity, Group, PairDistribution, ThermostatLedger, TimeCorrelation,
        VelocityDistribution,
    },
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

type Run<S> = Simulation<Exact, Impact, S>;

/// Time between two samples.
const SAMPLE_INTERVAL: f64 = 0.125;

/// Long enough for about eighty collisions of each body, after which a difference in the last bit
/// has grown to the first.
const SAMPLES: u32 = 64;

/// All kinds of observers, of the first body and of the whole system.
type Watched = (
    (EnergyLedger, CollisionRate, OverlapCheck, Pressure),
    (
        DirectionHistogram,
        RunningAverage,
        ProjectionHistogram,
        ContactDensity,
    ),
    (
        VelocityDistribution,
        TimeCorrelation,
        PairDistribution,
        ThermostatLedger,
    ),
);

fn watched<S: Scheduler>(simulation: &Run<S>) -> Watched {
    let view = simulation.view();
    let first = view.bodies().next().expect("there are bodies").body;
    (
        Default::default(),
        (
            DirectionHistogram::new(first.key(), 36),
            RunningAverage::new(first.key()),
            ProjectionHistogram::new(first.key(), BodyAxis::X, 3.0, 20).unwrap(),
            ContactDensity::new(first, 0.02, 12).unwrap(),
        ),
        (
            VelocityDistribution::adaptive(Group::All, 10),
            TimeCorrelation::new(Group::All, SAMPLE_INTERVAL, 1.0).unwrap(),
            PairDistribution::new([Group::All; 2], &view.bounds(), 0.2, 20).unwrap(),
            ThermostatLedger::default(),
        ),
    )
}

/// A way to run from one sample to the next.
trait Going<S: Scheduler> {
    fn to(&mut self, time: f64, simulation: &mut Run<S>, watched: &mut Watched);
}

/// Runs without interruption.
struct Straight;

impl<S: Scheduler> Going<S> for Straight {
    fn to(&mut self, time: f64, simulation: &mut Run<S>, watched: &mut Watched) {
        simulation.observe_until(time, watched).unwrap();
    }
}

/// At random ends of epochs, one in `every`, stores the simulation and the observers, drops them,
/// and reads them again.
struct Interrupted<'a, S: Scheduler> {
    random: Pcg64,
    every: u32,
    options: &'a S::Options,
    epochs: u32,
    resumed: u32,
}

impl<S: Scheduler> Interrupted<'_, S> {
    fn die_and_resume(&mut self, simulation: &mut Run<S>, watched: &mut Watched) {
        let checkpoint = simulation.checkpoint().expect("the epoch has ended");
        let written = postcard::to_stdvec(&(&checkpoint, &*watched)).unwrap();
        let (read, observers): (Checkpoint, Watched) = postcard::from_bytes(&written).unwrap();
        let options = self.options.clone();
        *simulation = Simulation::resume_with(&read, Exact::default(), Impact, options).unwrap();
        *watched = observers;
        let again = (simulation.checkpoint().unwrap(), &*watched);
        assert_eq!(
            postcard::to_stdvec(&again).unwrap(),
            written,
            "reading and writing gives the same bytes"
        );
        self.resumed += 1;
    }
}

impl<S: Scheduler> Going<S> for Interrupted<'_, S> {
    fn to(&mut self, time: f64, simulation: &mut Run<S>, watched: &mut Watched) {
        while !simulation
            .observe_epoch(EpochTime::from(time), watched)
            .unwrap()
        {
            self.epochs += 1;
            if self.random.random_range(0..self.every) == 0 {
                self.die_and_resume(simulation, watched);
            }
        }
    }
}

type Edit<S> = fn(u32, &mut Run<S>, &[BodyKey]);

/// Runs from sample to sample with edits at the samples; returns all bits at the end, and at the
/// end of one more epoch.
fn run<S: Scheduler>(
    scene: &Scene,
    options: &S::Options,
    edit: Edit<S>,
    going: &mut impl Going<S>,
) -> End {
    let mut simulation = simulate::<S>(scene, options);
    let keys: Vec<BodyKey> = simulation
        .view()
        .bodies()
        .map(|view| view.body.key())
        .collect();
    let mut watched = watched(&simulation);
    watched.start(&simulation.view());
    for sample in 1..=SAMPLES {
        going.to(
            SAMPLE_INTERVAL * f64::from(sample),
            &mut simulation,
            &mut watched,
        );
        watched.sample(&simulation.view());
        edit(sample, &mut simulation, &keys);
    }
    let bits = bits(&simulation.view());
    let collisions = simulation.view().counters().collisions;
    let counters = format!(
        "{:?} {:?}",
        simulation.view().counters(),
        simulation.view().ledger()
    );
    let reached = simulation
        .observe_epoch(EpochTime::from(1e6), &mut watched)
        .unwrap();
    assert!(!reached, "an epoch ends before a million");
    let state = postcard::to_stdvec(&(simulation.checkpoint().unwrap(), watched)).unwrap();
    End {
        bits,
        collisions,
        counters,
        state,
    }
}

struct End {
    bits: Vec<[u64; 6]>,
    collisions: u64,
    counters: String,
    /// Stored simulation and observers.
    state: Vec<u8>,
}

/// A run that is resumed at random ends of epochs, and at each of them, must end as an
/// uninterrupted one.
fn check<S: Scheduler>(scene: &Scene, options: &S::Options, edit: Edit<S>) {
    let expected = run(scene, options, edit, &mut Straight);
    assert!(expected.collisions > 500, "{}", expected.collisions);
    for (seed, every) in [(1, 1), (2, 2), (3, 3)] {
        let random = Pcg64::seed_from_u64(seed);
        let mut going = Interrupted {
            random,
            every,
            options,
            epochs: 0,
            resumed: 0,
        };
        let found = run(scene, options, edit, &mut going);
        assert!(going.resumed > 0, "{} epochs", going.epochs);
        assert_eq!(found.counters, expected.counters);
        assert_eq!(found.bits, expected.bits);
        assert!(
            found.state == expected.state,
            "bodies, ledger or observers differ"
        );
    }
}

fn no_edit<S: Scheduler>(_: u32, _: &mut Run<S>, _: &[BodyKey]) {}

test_each_scheduler! {
    discs_resume_to_the_bit: check_discs;
    molecules_that_turn_or_are_locked_or_fixed_resume_to_the_bit: check_menagerie;
    /// Rings have enough atoms for a tree of bounding circles.
    lossy_contacts_by_tags_resume_to_the_bit: check_lossy;
    rough_contacts_resume_to_the_bit: check_rough;
    edits_at_samples_resume_to_the_bit: check_edits;
}

fn check_discs<S: Scheduler>(options: &S::Options) {
    let discs = Scene {
        gas: vec![gas("disc", 0.02, 150)],
        ..Scene::default()
    };
    check(&discs, options, no_edit::<S>);
}

fn check_menagerie<S: Scheduler>(options: &S::Options) {
    check(&reference_scene(21), options, no_edit::<S>);
}

fn check_lossy<S: Scheduler>(options: &S::Options) {
    let mut lossy = reference_scene(22);
    lossy.molecule.push(named("ring:12", 0.01, 0.1, [0.5, 0.5]));
    lossy.molecule[0].tags = vec!["tee".to_owned(), "watched".to_owned()];
    lossy.gas[0].tags = vec!["small".to_owned()];
    lossy.gas[2].tags = vec!["dumbbells".to_owned()];
    lossy.elasticity.default = 0.999;
    lossy.elasticity.pair = vec![rule(&["small", "tee"], 0.9), rule(&["dumbbells"], 1.05)];
    check(&lossy, options, no_edit::<S>);
}

fn check_rough<S: Scheduler>(options: &S::Options) {
    let mut rough = reference_scene(25);
    rough.gas[0].tags = vec!["small".to_owned()];
    rough.elasticity.tangential = 0.5;
    rough.elasticity.pair = vec![
        ElasticityRule {
            between: vec!["small".to_owned()],
            coefficient: Restitution::Table {
                speeds: vec![0.0, 10.0],
                values: vec![1.0, 0.9],
            },
            tangential: 0.8,
            friction: Some(0.4),
            ..ElasticityRule::default()
        },
        ElasticityRule {
            kick: 1e-3,
            ..rule(&["small", "small"], 0.95)
        },
    ];
    check(
        &rough,
        options,
        |sample, simulation: &mut Run<S>, _: &[BodyKey]| {
            if sample == 7 {
                // The spins of the discs remain, although no contact changes them any more.
                simulation
                    .set_elasticity(&ElasticitySpec::default())
                    .unwrap();
            }
        },
    );
}

fn check_edits<S: Scheduler>(options: &S::Options) {
    let edit = |sample: u32, simulation: &mut Run<S>, keys: &[BodyKey]| match sample {
        2 => simulation.remove(keys[20]).unwrap(),
        3 => simulation.remove(keys[9]).unwrap(),
        4 => {
            simulation.tag(keys[0], "hot").unwrap();
            let pair = vec![rule(&["hot"], 0.95)];
            simulation
                .set_elasticity(&ElasticitySpec {
                    pair,
                    ..ElasticitySpec::default()
                })
                .unwrap();
        }
        6 => simulation.reset_energy(keys[0], 3.0).unwrap(),
        8 => simulation.set_rotation(keys[0], Rotation::Locked).unwrap(),
        10 => {
            // The position of the free place does not depend on the interruptions.
            let place = |step: u32| [f64::from(step % 32) / 32.0, f64::from(step / 32) / 32.0];
            let added = (0..1024).find_map(|step| {
                let one = disc(0.015, 1.0, place(step), [1.0, -0.5]);
                simulation.add(&one).ok()
            });
            assert!(added.is_some_and(|key| !keys.contains(&key)));
        }
        12 => simulation.set_rotation(keys[0], Rotation::Free).unwrap(),
        14 => simulation.untag(keys[0], "hot").unwrap(),
        16 => simulation
            .set_scheduler_options(&S::Options::default())
            .unwrap(),
        18 => assert!(
            simulation.remove(keys[9]).is_err(),
            "a key is never used again"
        ),
        _ => {}
    };
    check(&reference_scene(23), options, edit);
}

#[test]
fn a_checkpoint_exists_only_at_the_end_of_an_epoch() {
    let dilute = Scene {
        gas: vec![GasSpec {
            tags: vec!["gas".to_owned()],
            ..gas("disc", 0.01, 50)
        }],
        ..scene(vec![])
    };
    let mut simulation = Simulation::new(&dilute).unwrap();
    assert_eq!(
        simulation.checkpoint().unwrap().time(),
        EpochTime::ZERO,
        "before the first"
    );
    simulation.run_until(0.01).unwrap();
    assert!(simulation.checkpoint().is_none(), "within one");
    assert!(
        !simulation
            .observe_epoch(EpochTime::from(1e9), &mut ())
            .unwrap()
    );
    let ended = simulation.time();
    assert_eq!(simulation.checkpoint().unwrap().time(), ended);
    assert!(
        simulation
            .observe_epoch(EpochTime::from(0.0), &mut ())
            .unwrap(),
        "a time that has passed"
    );
    assert_eq!(simulation.time(), ended);
    for never in [f64::NAN, f64::INFINITY] {
        assert!(
            simulation
                .observe_epoch(EpochTime::from(never), &mut ())
                .is_err()
        );
    }
    // A tag and its bodies are found again.
    let resumed = Simulation::resume(&simulation.checkpoint().unwrap()).unwrap();
    let tag = resumed.find_tag("gas").unwrap();
    assert_eq!(resumed.view().tagged(tag).count(), 50);
}
