//! Reactions of bodies that collide: exact cases, conservation, rates of kinetic theory, and the
//! schedulers against each other.

use crate::support::{bits, disc, simulate, test_each_scheduler};
use carom::{EpochTime, Scene, Scheduler, Simulation};
use carom_detection::Exact;
use carom_engine::{
    CellScheduler, CellsPerSide, EditError, HeapScheduler, Instructions, MoleculeSpec,
    ReactionCounts, ReactionSpec, SceneError, TileUse, Tiling, View,
};
use carom_response::Impact;
use glam::DVec2;
use std::f64::consts::TAU;

test_each_scheduler! {
    no_contact_is_missed_between_reactions: check_invariants;
    a_run_with_reactions_is_resumed_to_the_bit: check_resumed;
    partners_that_touch_at_one_instant_are_absorbed_once_each: check_absorber;
}

fn read(text: &str) -> Scene {
    Scene::from_toml(text).unwrap_or_else(|error| panic!("{error}"))
}

fn names(tags: &[&str]) -> Vec<String> {
    tags.iter().map(|&tag| tag.to_owned()).collect()
}

fn becomes(between: &[&str], tags: [&str; 2]) -> ReactionSpec {
    ReactionSpec {
        between: names(between),
        becomes: names(&tags),
        ..ReactionSpec::default()
    }
}

fn tagged(tag: &str, disc: MoleculeSpec) -> MoleculeSpec {
    MoleculeSpec {
        tags: names(&[tag]),
        ..disc
    }
}

fn count(view: &View<'_>, tag: &str) -> usize {
    let found = view.tag_names().find(tag);
    found.map_or(0, |tag| view.tagged(tag).count())
}

fn counts(view: &View<'_>, rule: usize) -> ReactionCounts {
    view.reactions()[rule].counts
}

/// The angular momentum of all bodies about the origin, without images (mass × length² / time).
fn angular_momentum(view: &View<'_>) -> f64 {
    let of_body = |body: carom_engine::BodyView<'_>| {
        let (motion, inertia) = (body.motion, body.body.inertia());
        let spin = motion.angular_velocity / inertia.inverse_moment;
        let orbit = motion.position.perp_dot(motion.velocity) / inertia.inverse_mass;
        orbit
            + if motion.angular_velocity == 0.0 {
                0.0
            } else {
                spin
            }
    };
    view.bodies().map(of_body).sum()
}

/// Gases in which bodies are removed, get other tags, and are replaced by molecules.
fn scenes() -> Vec<(&'static str, Scene)> {
    let gas = |tag: &str, radius: f64, count: u32| {
        format!(
            "[[gas]]\ntags = [\"{tag}\"]\nradius = {radius}\nmass = 1.0\nenergy = 1.0\n\
             velocities = \"maxwell\"\ncount = {count}\n"
        )
    };
    let rule = |keys: &str| format!("[[reaction]]\n{keys}\n");
    let removed = "between = [\"a\"]\nprobability = 0.2\nbecomes = [\"nothing\", \"nothing\"]";
    let bonded = "between = [\"a\"]\nprobability = 0.3\n\
                  into = { tags = [\"m\"], shape = \"dumbbell\", atom_radius = 0.02, atom_mass = 1.0 }";
    let cycle = rule("between = [\"a\", \"b\"]\nprobability = 0.5\nbecomes = [\"b\", \"a\"]")
        + &rule("between = [\"a\"]\nleast_energy = 1.0\nbecomes = [\"a\", \"b\"]");
    let walls = "[[wall]]\nx = 0.0\n[[wall]]\ntags = [\"w\"]\ny = 0.0\ntemperature = 1.0\n";
    let stuck = rule("between = [\"a\", \"w\"]\nprobability = 0.6\nbecomes = [\"nothing\", \"w\"]");
    let rough = "[[elasticity.pair]]\nbetween = [\"b\"]\ntangential = 0.5\ncoefficient = 1.0\n";
    vec![
        ("annihilation", read(&(gas("a", 0.02, 80) + &rule(removed)))),
        ("bonds", read(&(gas("a", 0.02, 80) + &rule(bonded)))),
        (
            "tags that change to and fro, of smooth and rough discs",
            read(&(gas("a", 0.03, 40) + &gas("b", 0.02, 40) + &cycle + rough)),
        ),
        (
            "absorption by a wall of a temperature",
            read(&(gas("a", 0.02, 80) + walls + &stuck)),
        ),
        (
            "large discs that absorb small ones",
            read(
                &(gas("large", 0.1, 3)
                    + &gas("a", 0.01, 60)
                    + &rule("between = [\"a\", \"large\"]\nbecomes = [\"nothing\", \"large\"]")),
            ),
        ),
    ]
}

fn check_invariants<S: Scheduler + Clone>(options: &S::Options) {
    for (name, scene) in scenes() {
        let mut simulation = simulate::<S>(&scene, options);
        for contact in 0..300 {
            simulation.step(50.0, &mut ()).unwrap();
            if contact % 10 == 0 {
                let checked = simulation.check_invariants(0.02);
                checked.unwrap_or_else(|violation| panic!("{name}, {contact}: {violation}"));
            }
        }
        let view = simulation.view();
        let (energy, booked) = (view.energy(), view.ledger().booked());
        assert!((energy - booked).abs() < 1e-9, "{name}: {energy} {booked}");
        let by_rule: u64 = view
            .reactions()
            .iter()
            .map(|one| one.counts.reactions)
            .sum();
        assert_eq!(by_rule, view.counters().reactions, "{name}");
        assert!(by_rule > 5, "{name}: {by_rule}");
    }
}

fn check_resumed<S: Scheduler>(options: &S::Options) {
    for (name, scene) in scenes() {
        let (mut whole, mut parts) = (
            simulate::<S>(&scene, options),
            simulate::<S>(&scene, options),
        );
        let mut resumes = 0;
        while !parts.observe_epoch(EpochTime::from(4.0), &mut ()).unwrap() {
            let Some(checkpoint) = parts.checkpoint() else {
                continue;
            };
            let written = postcard::to_stdvec(&checkpoint).unwrap();
            let stored = postcard::from_bytes(&written).unwrap();
            parts = Simulation::resume_with(&stored, Exact::default(), Impact, options.clone())
                .unwrap();
            resumes += 1;
        }
        whole.run_until(4.0).unwrap();
        assert!(resumes > 1, "{name}: {resumes}");
        assert!(bits(&whole.view()) == bits(&parts.view()), "{name}");
        assert_eq!(whole.view().reactions(), parts.view().reactions(), "{name}");
        assert_eq!(whole.view().ledger(), parts.view().ledger(), "{name}");
    }
}

/// A heavy disc is hit by 24 discs from all sides at one instant.
fn check_absorber<S: Scheduler>(options: &S::Options) {
    let (large, small, distance) = (0.2, 0.02, 0.35);
    let partner = |n: u32| {
        let direction = DVec2::from_angle(TAU * f64::from(n) / 24.0);
        let at = DVec2::splat(0.5) + distance * direction;
        tagged(
            "a",
            disc(small, 1.0, at.to_array(), (-direction).to_array()),
        )
    };
    let absorber = tagged("A", disc(large, 100.0, [0.5; 2], [0.0; 2]));
    let scene = Scene {
        molecule: [absorber].into_iter().chain((0..24).map(partner)).collect(),
        reaction: vec![becomes(&["A", "a"], ["A", "nothing"])],
        ..Scene::default()
    };
    let mut simulation = simulate::<S>(&scene, options);
    let touch = distance - large - small;
    simulation.run_until(touch - 1e-6).unwrap();
    assert_eq!(simulation.view().counters().reactions, 0);
    simulation.run_until(touch + 1e-6).unwrap();
    let view = simulation.view();
    assert_eq!((view.len(), count(&view, "A")), (1, 1));
    assert_eq!(counts(&view, 0).reactions, 24);
    assert_eq!(view.counters().collisions, 24);
    assert!((view.energy() - view.ledger().booked()).abs() < 1e-12);
}

/// Two discs of masses 1 and 3 that meet at relative speed u have an energy of approach of
/// ½ · ¾ · u².
#[test]
fn the_least_energy_is_that_of_the_approach_along_the_normal() {
    let meet = |speed: f64, offset: f64, least_energy: f64| {
        let mut scene = Scene {
            molecule: vec![
                tagged("a", disc(0.05, 1.0, [0.3, 0.5], [speed, 0.0])),
                tagged("b", disc(0.05, 3.0, [0.7, 0.5 + offset], [0.0; 2])),
            ],
            ..Scene::default()
        };
        scene.reaction = vec![ReactionSpec {
            least_energy,
            ..becomes(&["a", "b"], ["c", "nothing"])
        }];
        let mut simulation: Simulation = Simulation::new(&scene).unwrap();
        assert!(simulation.step(10.0, &mut ()).unwrap());
        let view = simulation.view();
        assert_eq!(counts(&view, 0).contacts, 1);
        (count(&view, "c"), view.len())
    };
    let energy = 0.375 * 4.0;
    assert_eq!(meet(2.0, 0.0, energy * (1.0 - 1e-12)), (1, 1));
    assert_eq!(meet(2.0, 0.0, energy * (1.0 + 1e-12)), (0, 2));
    // At an offset b the normal is turned by asin(b/0.1): the energy has the factor 1 − (b/0.1)².
    let part = 1.0 - 0.6 * 0.6;
    assert_eq!(meet(2.0, 0.06, part * energy * (1.0 - 1e-9)), (1, 1));
    assert_eq!(meet(2.0, 0.06, part * energy * (1.0 + 1e-9)), (0, 2));
}

/// At equilibrium the speed of approach along the normal has the distribution u exp(−μ u²/2kT), so
/// that a share exp(−E/kT) of the contacts has an energy of at least E, whatever the shapes. The
/// rules treat all pairs alike: tags tell nothing about the energy of a body.
#[test]
fn the_share_of_contacts_above_an_energy_is_that_of_arrhenius() {
    for shape in ["disc", "dumbbell"] {
        let mut scene = read(&format!(
            "[[gas]]\ntags = [\"a\"]\nshape = \"{shape}\"\natom_radius = 0.008\natom_mass = 1.0\n\
             temperature = 1.0\nvelocities = \"maxwell\"\ncount = 500\n"
        ));
        let rules = [
            becomes(&["a"], ["a", "b"]),
            becomes(&["a", "b"], ["b", "a"]),
            becomes(&["b"], ["b", "a"]),
        ];
        let above = |rule: ReactionSpec| ReactionSpec {
            least_energy: 2.0,
            ..rule
        };
        scene.reaction = rules.map(above).to_vec();
        let mut simulation: Simulation = Simulation::new(&scene).unwrap();
        simulation.run_until(10.0).unwrap();
        let counters = simulation.view().counters();
        let contacts = counters.reactive_collisions as f64;
        let share = counters.reactions as f64 / contacts;
        let expected = (-2.0 / simulation.view().temperature().unwrap()).exp();
        let error = (expected / contacts).sqrt();
        assert_eq!(counters.reactive_collisions, counters.collisions);
        assert!(contacts > 20_000.0, "{shape}: {contacts}");
        // Contacts that follow each other are not quite independent.
        assert!(
            (share - expected).abs() < 6.0 * error + 3e-3 * expected,
            "{shape}: {share} {expected} ± {error}"
        );
    }
}

/// A product has the mass, the momentum, the angular momentum and the centre of mass of the two
/// bodies that it replaces; where it has no room, they only collide.
#[test]
fn a_product_keeps_mass_momentum_angular_momentum_and_centre() {
    let dumbbell = MoleculeSpec {
        tags: names(&["m"]),
        shape: Some("dumbbell".to_owned()),
        atom_radius: Some(0.05),
        atom_mass: Some(1.0),
        ..MoleculeSpec::default()
    };
    let mut scene = Scene {
        molecule: vec![
            tagged("a", disc(0.05, 1.0, [0.3, 0.5], [1.0, 0.25])),
            tagged("a", disc(0.05, 1.0, [0.7, 0.53], [-0.5, 0.0])),
        ],
        reaction: vec![ReactionSpec {
            between: names(&["a"]),
            into: Some(dumbbell),
            ..ReactionSpec::default()
        }],
        ..Scene::default()
    };
    let mut simulation: Simulation = Simulation::new(&scene).unwrap();
    let before = (
        simulation.view().momentum(),
        angular_momentum(&simulation.view()),
    );
    assert!(simulation.step(10.0, &mut ()).unwrap());
    let view = simulation.view();
    let body = view.bodies().next().unwrap();
    assert_eq!((view.len(), count(&view, "m")), (1, 1));
    assert!((view.momentum() - before.0).length() < 1e-14);
    assert!((angular_momentum(&view) - before.1).abs() < 1e-14);
    let time = view.time().to_f64();
    let centre = DVec2::new(0.5, 0.515) + time * DVec2::new(0.25, 0.125);
    assert!((body.motion.position - centre).length() < 1e-14);
    assert_eq!(body.body.mass(), 2.0);
    // Its atoms are where the discs were.
    let atoms: Vec<DVec2> = body.atoms().map(|(place, _)| place).collect();
    let discs = [
        DVec2::new(0.3, 0.5) + time * DVec2::new(1.0, 0.25),
        DVec2::new(0.7, 0.53) + time * DVec2::new(-0.5, 0.0),
    ];
    for place in discs {
        let nearest = atoms.iter().map(|atom| (*atom - place).length());
        assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-14, "{atoms:?}");
    }
    let booked = view.ledger().booked();
    assert!((view.energy() - booked).abs() < 1e-14);
    assert_eq!(counts(&view, 0).energy, view.ledger().put_in);
    // A bumper where the large product would be.
    let wide = MoleculeSpec {
        shape: Some("disc".to_owned()),
        atom_radius: Some(0.09),
        atom_mass: Some(2.0),
        ..MoleculeSpec::default()
    };
    scene.reaction[0].into = Some(wide);
    scene.bumper = vec![crate::support::bumper(0.01, [0.54, 0.61])];
    let mut simulation: Simulation = Simulation::new(&scene).unwrap();
    assert!(simulation.step(10.0, &mut ()).unwrap());
    let view = simulation.view();
    assert_eq!((view.len(), counts(&view, 0).blocked), (3, 1));
    assert_eq!(view.counters().reactions, 0);
}

/// A reaction that has probability p takes place at a share p of the contacts, within 4 standard
/// errors, and removes two bodies each time.
#[test]
fn the_share_of_contacts_with_a_reaction_is_its_probability() {
    let scene = read(
        "[[reaction]]\nbetween = [\"a\"]\nprobability = 0.03\nbecomes = [\"nothing\", \"nothing\"]\n\
         [[reaction]]\nbetween = [\"a\"]\nprobability = 0.5\nbecomes = [\"a\", \"b\"]\n\
         [[reaction]]\nbetween = [\"a\", \"b\"]\nbecomes = [\"a\", \"a\"]\n\
         [[gas]]\ntags = [\"a\"]\nradius = 0.005\nmass = 1.0\ntemperature = 1.0\n\
         velocities = \"maxwell\"\ncount = 2000\n",
    );
    let mut simulation: Simulation = Simulation::new(&scene).unwrap();
    simulation.run_until(1.0).unwrap();
    let view = simulation.view();
    for (rule, probability) in [(0, 0.03), (1, 0.5)] {
        let counts = counts(&view, rule);
        let contacts = counts.contacts as f64;
        let error = (probability * (1.0 - probability) / contacts).sqrt();
        let share = counts.reactions as f64 / contacts;
        assert!(contacts > 3_000.0, "{counts:?}");
        assert!(
            (share - probability).abs() < 4.0 * error,
            "{share} {probability} {error}"
        );
    }
    // The second rule has only seen contacts at which the first has not acted.
    let first = counts(&view, 0);
    assert_eq!(counts(&view, 1).contacts, first.contacts - first.reactions);
    assert_eq!(view.len() as u64, 2000 - 2 * first.reactions);
}

#[test]
fn both_schedulers_draw_the_same_numbers() {
    for (name, scene) in scenes() {
        let mut cells = simulate::<CellScheduler>(&scene, &Instructions::default());
        let mut heap = simulate::<HeapScheduler>(&scene, &CellsPerSide::Automatic);
        // Until chaos has amplified their different rounding.
        for _ in 0..40 {
            cells.step(10.0, &mut ()).unwrap();
            heap.step(10.0, &mut ()).unwrap();
        }
        let [ours, theirs] = [cells.view(), heap.view()];
        let done = |view: &View<'_>| {
            let records = view.reactions().iter();
            let counts = records.map(|one| (one.counts.contacts, one.counts.reactions));
            counts.collect::<Vec<_>>()
        };
        assert_eq!(done(&ours), done(&theirs), "{name}");
        let ids = |view: &View<'_>| view.bodies().map(|body| body.body.id()).collect::<Vec<_>>();
        assert_eq!(ids(&ours), ids(&theirs), "{name}");
    }
}

/// Rules that name no body change no count; tiles leave reactions to the order of events.
#[test]
fn reactions_run_in_order_of_time() {
    let mut scene =
        read("[[gas]]\ntags = [\"a\"]\nradius = 0.002\nmass = 1.0\nenergy = 1.0\ncount = 20000\n");
    let tiling = Tiling {
        threads: 2,
        least_bodies: 1,
        side: 50,
        ..Tiling::NONE
    };
    let mut simulation: Simulation = Simulation::new(&scene).unwrap();
    simulation.set_tiling(&tiling);
    simulation.run_until(1e-3).unwrap();
    assert!(matches!(simulation.tile_use(), TileUse::Tiles(_)));
    simulation
        .set_reactions(&[becomes(&["a"], ["b", "b"])])
        .unwrap();
    assert_eq!(simulation.tile_use(), TileUse::Reactions);
    simulation.run_until(2e-3).unwrap();
    let reactions = simulation.view().counters().reactions;
    assert_eq!(count(&simulation.view(), "b") as u64, 2 * reactions);
    assert!(reactions > 10, "{reactions}");
    simulation.set_reactions(&[]).unwrap();
    simulation.run_until(3e-3).unwrap();
    assert_eq!(simulation.view().counters().reactions, reactions);
    assert!(matches!(simulation.tile_use(), TileUse::Tiles(_)));
    scene.reaction = vec![becomes(&["a"], ["b", "b"])];
    let other: Simulation = Simulation::new(&scene).unwrap();
    assert_eq!(other.tile_use(), TileUse::Reactions);
}

#[test]
fn a_product_of_another_mass_is_refused() {
    let pair = || {
        vec![
            tagged("a", disc(0.05, 1.0, [0.3, 0.5], [1.0, 0.0])),
            tagged("a", disc(0.05, 1.0, [0.7, 0.5], [0.0; 2])),
        ]
    };
    let into = |mass: f64| MoleculeSpec {
        shape: Some("disc".to_owned()),
        atom_radius: Some(0.05),
        atom_mass: Some(mass),
        ..MoleculeSpec::default()
    };
    let merged = |mass: f64| ReactionSpec {
        between: names(&["a"]),
        into: Some(into(mass)),
        ..ReactionSpec::default()
    };
    let scene = Scene {
        molecule: pair(),
        reaction: vec![merged(2.5)],
        ..Scene::default()
    };
    let error = Simulation::new(&scene).unwrap_err();
    assert_eq!(
        error.to_string(),
        "reaction a + a → a molecule: the mass of `into` must be that of the two bodies which it replaces, 2, but is \
         2.5"
    );
    let mut simulation: Simulation = Simulation::new(&Scene {
        molecule: pair(),
        ..Scene::default()
    })
    .unwrap();
    let refused = simulation.set_reactions(&[merged(2.5)]);
    assert!(matches!(
        refused,
        Err(EditError::Scene(SceneError::Entry { .. }))
    ));
    simulation.set_reactions(&[merged(2.0)]).unwrap();
    simulation.run_until(1.0).unwrap();
    assert_eq!(simulation.view().len(), 1);
}
