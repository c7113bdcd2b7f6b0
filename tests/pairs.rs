//! Pairs of bodies that do not see each other, discs with diameters by pair of tags, and fixed
//! gases: exact cases, conservation, and the schedulers against each other.

use crate::support::{Encounters, bits, scenes, simulate, test_each_scheduler};
use carom::{EpochTime, Scene, Scheduler, Simulation};
use carom_detection::Exact;
use carom_engine::{
    CellScheduler, CellsPerSide, CollisionReport, DiameterSpec, HeapScheduler, Instructions,
    MoleculeSpec, Observer, TransparentSpec, View,
};
use carom_response::Impact;
use std::f64::consts::PI;

test_each_scheduler! {
    no_contact_is_missed_where_rules_apply_to_pairs: check_invariants;
    species_that_do_not_see_each_other_are_independent_gases_to_the_bit: check_independence;
    an_ideal_gas_exerts_its_pressure_on_walls_and_has_no_contacts: check_ideal_gas;
    a_semipermeable_wall_holds_one_species_and_lets_the_other_pass: check_membrane;
    a_run_with_rules_for_pairs_is_resumed_to_the_bit: check_resumed;
}

fn read(text: &str) -> Scene {
    Scene::from_toml(text).unwrap_or_else(|error| panic!("{error}"))
}

fn transparent(between: &[&str]) -> TransparentSpec {
    TransparentSpec {
        between: between.iter().map(|&tag| tag.to_owned()).collect(),
    }
}

fn gas(tag: &str, radius: f64, count: u32) -> String {
    format!(
        "[[gas]]\ntags = [\"{tag}\"]\nradius = {radius}\nmass = 1.0\nenergy = 1.0\ncount = {count}\n"
    )
}

fn unseen(between: &str) -> String {
    format!("[[transparent]]\nbetween = [{between}]\n")
}

/// Small scenes with rules for pairs, and reactions that change the tags of discs.
fn scenes_with_reactions() -> [(&'static str, Scene); 2] {
    [
        (
            "reactions to tags that no disc has at first",
            read(
                &(gas("a", 0.03, 40)
                    + &gas("d", 0.02, 20)
                    + &gas("e", 0.02, 20)
                    + &unseen("\"d\", \"e\"")
                    + "[[reaction]]\nbetween = [\"a\"]\nbecomes = [\"c\", \"c\"]\n"),
            ),
        ),
        (
            "reactions among discs of unlike sizes",
            read(
                &(gas("a", 0.02, 40)
                    + &gas("b", 0.035, 30)
                    + &gas("d", 0.02, 10)
                    + &gas("e", 0.02, 10)
                    + &unseen("\"d\", \"e\"")
                    + "[[reaction]]\nbetween = [\"a\", \"b\"]\nbecomes = [\"b\", \"a\"]\n"),
            ),
        ),
    ]
}

/// Small scenes with rules for pairs: like and unlike sizes, molecules, fixed bodies, walls.
fn scenes_by_pair() -> Vec<(&'static str, Scene)> {
    let molecules = |tag: &str, shape: &str, count: u32| {
        format!(
            "[[gas]]\ntags = [\"{tag}\"]\nshape = \"{shape}\"\natom_radius = 0.015\natom_mass = 1.0\nenergy = 1.0\n\
             count = {count}\n"
        )
    };
    let diameter = |between: &str, factor: f64| {
        format!("[[diameter]]\nbetween = [{between}]\nfactor = {factor}\n")
    };
    let fixed = "[[bumper]]\ntags = [\"f\"]\nradius = 0.08\nat = [0.5, 0.5]\n[[wall]]\ntags = [\"w\"]\nx = 0.1\n";
    vec![
        (
            "two kinds of discs",
            read(&(gas("a", 0.03, 40) + &gas("b", 0.03, 40) + &unseen("\"a\", \"b\""))),
        ),
        (
            "large discs among small ones, of which some do not see them",
            read(
                &(gas("large", 0.1, 4)
                    + &gas("a", 0.015, 60)
                    + &gas("b", 0.02, 60)
                    + &unseen("\"a\", \"large\"")),
            ),
        ),
        (
            "Widom and Rowlinson's mixture with obstacles",
            read(
                &(gas("a", 0.03, 30)
                    + &gas("b", 0.03, 30)
                    + &unseen("\"a\"")
                    + &unseen("\"b\"")
                    + &unseen("\"a\", \"w\"")
                    + &unseen("\"b\", \"f\"")
                    + fixed),
            ),
        ),
        (
            "diameters by pair with unlike sizes and a fixed disc",
            read(
                &(gas("large", 0.08, 4)
                    + &gas("a", 0.01, 50)
                    + &gas("b", 0.015, 50)
                    + &diameter("\"a\", \"large\"", 0.6)
                    + &diameter("\"a\", \"b\"", 1.6)
                    + &diameter("\"b\", \"f\"", 1.2)
                    + fixed),
            ),
        ),
        (
            "molecules and discs",
            read(
                &(molecules("m", "tee", 12)
                    + &molecules("n", "dumbbell", 12)
                    + &gas("a", 0.02, 8)
                    + &unseen("\"m\", \"n\"")
                    + &unseen("\"n\", \"w\"")
                    + &unseen("\"a\", \"f\"")
                    + fixed),
            ),
        ),
        (
            "a few molecules among discs",
            read(
                &(molecules("m", "tee", 4)
                    + &gas("a", 0.02, 40)
                    + &gas("b", 0.02, 40)
                    + &unseen("\"m\", \"a\"")
                    + &unseen("\"a\", \"b\"")),
            ),
        ),
        (
            "a few discs with diameters by pair among molecules",
            read(
                &(molecules("m", "tee", 12)
                    + &gas("a", 0.02, 3)
                    + &gas("b", 0.02, 2)
                    + &diameter("\"a\", \"b\"", 1.5)
                    + &diameter("\"a\"", 0.5)),
            ),
        ),
        (
            "one moving disc among overlapping obstacles",
            read(
                &(gas("a", 0.01, 1)
                    + "[[gas]]\ntags = [\"f\"]\nradius = 0.05\nfixed = true\noverlapping = true\ncount = 50\n"),
            ),
        ),
    ]
}

fn check_invariants<S: Scheduler + Clone>(options: &S::Options) {
    let scenes = scenes_by_pair().into_iter().chain(scenes_with_reactions());
    for (name, scene) in scenes {
        let mut simulation = simulate::<S>(&scene, options);
        for contact in 0..400 {
            simulation.step(10.0, &mut ()).unwrap();
            if contact % 10 == 0 {
                let checked = simulation.check_invariants(0.02);
                checked.unwrap_or_else(|violation| panic!("{name}, {contact}: {violation}"));
            }
        }
    }
}

/// The bodies of a view as single molecules of a scene, with these tags.
fn as_singles(view: &View<'_>, of: &MoleculeSpec, tag: &str) -> Vec<MoleculeSpec> {
    let single = |body: carom_engine::BodyView<'_>| MoleculeSpec {
        tags: vec![tag.to_owned()],
        at: body.motion.position.to_array(),
        velocity: body.motion.velocity.to_array(),
        ..of.clone()
    };
    view.bodies().map(single).collect()
}

/// The bits agree if epochs start at the same times, which the number of contacts decides
/// otherwise, and if the cells are the same, which the number of bodies decides unless the discs
/// are as wide as these: then positions and contact times are rounded at the same moments.
fn check_independence<S: Scheduler>(options: &S::Options) {
    let radius = 0.045;
    let gas = |seed: u64| {
        let mut scene = read(&format!(
            "[[gas]]\nradius = {radius}\nmass = 1.0\nenergy = 1.0\ncount = 80\n"
        ));
        scene.bounds.seed = seed;
        let drawn: Simulation = Simulation::new(&scene).unwrap();
        let disc = MoleculeSpec {
            shape: Some("disc".to_owned()),
            atom_radius: Some(radius),
            atom_mass: Some(1.0),
            ..MoleculeSpec::default()
        };
        as_singles(&drawn.view(), &disc, if seed == 1 { "a" } else { "b" })
    };
    let scene = |molecule: Vec<MoleculeSpec>, transparent: Vec<TransparentSpec>| Scene {
        molecule,
        transparent,
        ..Scene::default()
    };
    let (a, b) = (gas(1), gas(2));
    let both = a.iter().chain(&b).cloned().collect();
    let rules = vec![transparent(&["a", "b"])];
    let scenes = [scene(a, vec![]), scene(b, vec![]), scene(both, rules)];
    let [mut a, mut b, mut both] = scenes.map(|scene| simulate::<S>(&scene, options));
    let mut collisions = 0;
    for step in 1..=100 {
        for run in [&mut a, &mut b, &mut both] {
            run.run_until(0.01 * f64::from(step)).unwrap();
            run.end_epoch_here();
        }
        let apart = [bits(&a.view()), bits(&b.view())].concat();
        assert!(apart == bits(&both.view()), "step {step}");
        collisions = both.view().counters().collisions;
    }
    let apart = a.view().counters().collisions + b.view().counters().collisions;
    assert_eq!(apart, collisions);
    assert!(collisions > 1000, "{collisions}");
}

/// The momentum that walls along y have received, per axis (mass × length / time).
#[derive(Default)]
struct Pushed(f64);

impl Observer for Pushed {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.0 += report.impulse.x.abs();
    }
}

/// In a box of walls the pressure on the walls along y is the mean of m vₓ² over the area in which
/// the centres move: each disc hits one of their sides every (L − 2 r)/|vₓ|.
fn check_ideal_gas<S: Scheduler>(options: &S::Options) {
    let scene = read(
        "[[transparent]]\nbetween = [\"ideal\"]\n[[wall]]\nx = 0.0\n[[wall]]\ny = 0.0\n\
         [[gas]]\ntags = [\"ideal\"]\nradius = 0.02\nmass = 1.0\ntemperature = 1.0\nvelocities = \"maxwell\"\ncount = 200\n",
    );
    let mut simulation = simulate::<S>(&scene, options);
    let squares: f64 = simulation
        .view()
        .bodies()
        .map(|body| body.motion.velocity.x.powi(2))
        .sum();
    let (mut pushed, time) = (Pushed::default(), 100.0);
    simulation.observe_until(time, &mut pushed).unwrap();
    let counters = simulation.view().counters();
    assert_eq!(counters.collisions, counters.fixed_collisions);
    // Two sides receive 2 m |vₓ| once in the time for both ways.
    let expected = 2.0 * squares * time / (1.0 - 2.0 * 0.02);
    assert!(
        (pushed.0 / expected - 1.0).abs() < 0.01,
        "{}",
        pushed.0 / expected
    );
    // N kT = Σ m vₓ² on average: β p A / N = 1 with the area in which the centres move. The energy
    // is exact, so that Σ m vₓ² is a share of it with a relative standard error of 1/√(N + 1). The
    // study `pairs/ideal-gas` has Z to 0.1 %.
    let standard_error = (1.0 / 201.0f64).sqrt();
    assert!((squares / 200.0 - 1.0).abs() < 4.0 * standard_error);
}

fn check_membrane<S: Scheduler>(options: &S::Options) {
    let gas = |tag: &str, from: f64| {
        format!(
            "[[gas]]\ntags = [\"{tag}\"]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 40\n\
             region = {{ x = [{from}, {}] }}\n",
            from + 0.5
        )
    };
    let scene = read(
        &(gas("solvent", 0.0)
            + &gas("solute", 0.5)
            + "[[wall]]\nx = 0.0\n[[wall]]\ntags = [\"membrane\"]\nx = 0.5\n\
               [[transparent]]\nbetween = [\"solvent\", \"membrane\"]\n"),
    );
    let mut simulation = simulate::<S>(&scene, options);
    let mut crossed = 0;
    for step in 1..=50 {
        simulation.run_until(0.1 * f64::from(step)).unwrap();
        let view = simulation.view();
        for (index, body) in view
            .bodies()
            .filter(|body| !body.body.is_fixed())
            .enumerate()
        {
            let x = body.motion.position.x;
            if index < 40 {
                crossed += usize::from(x > 0.5);
            } else {
                assert!((0.51 - 1e-12..=0.99 + 1e-12).contains(&x), "solute at {x}");
            }
        }
    }
    // About half of the solvent is beyond the membrane after a few crossings.
    assert!((400..1200).contains(&crossed), "{crossed}");
}

fn check_resumed<S: Scheduler>(options: &S::Options) {
    for (name, scene) in scenes_by_pair() {
        let mut simulation = simulate::<S>(&scene, options);
        simulation
            .observe_epoch(EpochTime::from(1000.0), &mut ())
            .unwrap();
        let Some(checkpoint) = simulation.checkpoint() else {
            panic!("{name}: the epoch is longer than the run");
        };
        let written = postcard::to_stdvec(&checkpoint).unwrap();
        let stored = postcard::from_bytes(&written).unwrap();
        let mut resumed: Simulation<Exact, Impact, S> =
            Simulation::resume_with(&stored, Exact::default(), Impact, options.clone()).unwrap();
        let until = checkpoint.time().after(1.0).to_f64();
        for run in [&mut simulation, &mut resumed] {
            run.run_until(until).unwrap();
        }
        assert!(bits(&simulation.view()) == bits(&resumed.view()), "{name}");
    }
}

#[test]
fn the_schedulers_find_the_same_contacts() {
    for (name, scene) in scenes_by_pair() {
        let mut cells = simulate::<CellScheduler>(&scene, &Instructions::default());
        let mut heap = simulate::<HeapScheduler>(&scene, &CellsPerSide::Given(1));
        let [mut ours, mut theirs] = [(); 2].map(|()| Encounters::since(EpochTime::ZERO));
        // Later the roundings of the two have grown to other contacts, sooner for few bodies or
        // molecules.
        let moving = cells.view().bodies().filter(|body| !body.body.is_fixed());
        let contacts = 4 * moving.count().min(10);
        for _ in 0..contacts {
            cells.step(10.0, &mut ours).unwrap();
            heap.step(10.0, &mut theirs).unwrap();
        }
        let bodies = |contacts: &Encounters| {
            let contacts = contacts.list.iter();
            contacts.map(|contact| contact.bodies).collect::<Vec<_>>()
        };
        assert_eq!(bodies(&ours), bodies(&theirs), "{name}");
    }
}

/// Without a rule that affects a body, the bits are those without rules.
#[test]
fn rules_without_effect_change_no_bit() {
    for (name, scene) in scenes() {
        let mut ruled = scene.clone();
        let tags = ["x", "y"].map(str::to_owned);
        // The tag of a body that a stage would add.
        ruled.stage = vec![carom_engine::StageSpec {
            add: vec![MoleculeSpec {
                tags: tags.to_vec(),
                ..MoleculeSpec::default()
            }],
            ..carom_engine::StageSpec::default()
        }];
        ruled.transparent = vec![transparent(&["x"])];
        ruled.diameter = vec![DiameterSpec {
            between: tags.to_vec(),
            factor: 0.5,
        }];
        let [plain, ruled] = [&scene, &ruled].map(|scene| {
            let mut simulation = simulate::<CellScheduler>(scene, &Instructions::default());
            for _ in 0..100 {
                simulation.step(1.0, &mut ()).unwrap();
            }
            bits(&simulation.view())
        });
        assert_eq!(plain, ruled, "{name}");
    }
}

/// Contacts per time of N_a discs with N_b others at low density (Enskog 1922): 2 σ n_b N_a ⟨|v|⟩
/// with ⟨|v|⟩ = √(π kT/2μ), where nothing correlates the places of the two kinds.
fn rate(sigma: f64, pairs: f64, area: f64, kt: f64, mass: f64) -> f64 {
    2.0 * sigma * pairs / area * (PI * kt / mass).sqrt()
}

/// In Widom and Rowlinson's mixture the first correction to the contact rate is 0: no third disc
/// sees both discs of a pair in contact. So is it between two ideal gases with a diameter by pair.
/// The rate gives the second virial coefficient of the cross term, B₂ = π σ²/2, from Z − 1 = x_a
/// x_b 2 n B₂.
#[test]
fn cross_contacts_have_the_rate_of_their_diameter() {
    for (factor, count) in [(1.0, 600), (0.5, 600), (1.7, 300)] {
        let rules = if factor == 1.0 {
            String::new()
        } else {
            format!("[[diameter]]\nbetween = [\"a\", \"b\"]\nfactor = {factor}\n")
        };
        let gas = |tag: &str| {
            format!(
                "[[gas]]\ntags = [\"{tag}\"]\nradius = 0.004\nmass = 1.0\ntemperature = 1.0\n\
                 velocities = \"maxwell\"\ncount = {count}\n[[transparent]]\nbetween = [\"{tag}\"]\n"
            )
        };
        let scene = read(&(gas("a") + &gas("b") + &rules));
        let mut simulation = simulate::<CellScheduler>(&scene, &Instructions::default());
        simulation.run_until(0.5).unwrap();
        let before = simulation.view().counters().collisions;
        let time = 20_000.0 / rate(0.008 * factor, f64::from(count).powi(2), 1.0, 1.0, 1.0);
        simulation.run_until(0.5 + time).unwrap();
        let found = (simulation.view().counters().collisions - before) as f64;
        // Relative momentum 0 leaves 2 N − 2 degrees of freedom: kT of the relative motion to 1/N.
        assert!((found / 20_000.0 - 1.0).abs() < 0.03, "{factor}: {found}");
    }
}

#[test]
fn a_lorentz_gas_is_five_lines_and_its_free_path_is_that_of_independent_discs() {
    let scene = read(
        "[[gas]]\nradius = 0.001\nfixed = true\noverlapping = true\ncount = 10000\n\
         [[gas]]\ntags = [\"tracer\"]\nradius = 1e-12\nmass = 1.0\nenergy = 1.0\ncount = 200\n\
         [[transparent]]\nbetween = [\"tracer\"]\n",
    );
    let mut simulation = simulate::<CellScheduler>(&scene, &Instructions::default());
    assert_eq!(simulation.view().overlaps().pairs, 0);
    let speed = 2f64.sqrt();
    simulation.run_until(10.0).unwrap();
    let collisions = simulation.view().counters().fixed_collisions as f64;
    let free_path = 200.0 * speed * 10.0 / collisions;
    // π A / P with the free area A and the exposed perimeter P of the obstacles. Overlaps reduce
    // both by exp(−π n a²), so that the free path is 1/(2 n a) at any density.
    let expected = 1.0 / (2.0 * 1e4 * 1e-3);
    assert!(
        (free_path / expected - 1.0).abs() < 0.02,
        "{free_path} {expected}"
    );
    assert_eq!(simulation.view().overlaps().pairs, 0);
}

#[test]
fn fixed_gases_cover_their_share() {
    // Discs that may overlap: 1 − exp(−n a) of the box, by a grid of points.
    let scene = read(
        "[[gas]]\nradius = 0.01\nfixed = true\noverlapping = true\narea_fraction = 0.5\n\
         [[gas]]\nradius = 0.002\nmass = 1.0\nenergy = 1.0\ncount = 100\n",
    );
    let simulation = simulate::<CellScheduler>(&scene, &Instructions::default());
    let view = simulation.view();
    let fixed: Vec<_> = view.bodies().filter(|body| body.body.is_fixed()).collect();
    let expected = (2f64.ln() / (PI * 1e-4)).round();
    assert_eq!(fixed.len(), expected as usize);
    let covered = (0..10_000).filter(|point| {
        let place = glam::DVec2::new(f64::from(point % 100), f64::from(point / 100)) * 0.01;
        fixed.iter().any(|body| {
            let d = (body.motion.position - place + 0.5).rem_euclid(glam::DVec2::ONE) - 0.5;
            d.length_squared() < 1e-4
        })
    });
    let covered = covered.count() as f64 / 10_000.0;
    assert!((covered - 0.5).abs() < 0.03, "{covered}");
    // Others do not overlap, whatever their shape.
    let scene = read(
        "[[gas]]\nshape = \"tee\"\natom_radius = 0.01\nfixed = true\narea_fraction = 0.2\n\
         [[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 100\n",
    );
    let simulation = simulate::<CellScheduler>(&scene, &Instructions::default());
    let view = simulation.view();
    let fixed: Vec<_> = view.bodies().filter(|body| body.body.is_fixed()).collect();
    for (n, a) in fixed.iter().enumerate() {
        for b in &fixed[..n] {
            let d =
                (b.motion.position - a.motion.position + 0.5).rem_euclid(glam::DVec2::ONE) - 0.5;
            let turned = [a, b].map(|body| body.motion.orientation.cos_sin());
            let gap = carom_geometry::gap_between(
                a.body.molecule(),
                turned[0],
                b.body.molecule(),
                turned[1],
                d,
            );
            assert!(gap > 0.0, "{gap}");
        }
    }
    assert_eq!(view.overlaps().pairs, 0);
}

/// Bodies that would see each other again while they overlap are refused, and nothing changes.
#[test]
fn overlapping_bodies_do_not_become_visible() {
    let scene = read(
        "[[transparent]]\nbetween = [\"a\"]\n\
         [[gas]]\ntags = [\"a\"]\nradius = 0.05\nmass = 1.0\nenergy = 1.0\ncount = 100\n",
    );
    let mut simulation = simulate::<CellScheduler>(&scene, &Instructions::default());
    simulation.run_until(0.1).unwrap();
    let before = bits(&simulation.view());
    let refused = simulation
        .edit(|batch| batch.set_transparent(&[]))
        .unwrap_err();
    assert!(refused.to_string().contains("overlap"), "{refused}");
    assert_eq!(before, bits(&simulation.view()));
    let keys: Vec<_> = simulation
        .view()
        .bodies()
        .map(|body| body.body.key())
        .collect();
    let refused = simulation.edit(|batch| keys.iter().try_for_each(|&key| batch.untag(key, "a")));
    assert!(refused.unwrap_err().to_string().contains("overlap"));
    // One body at a time may lose the tag if it overlaps no other.
    let lone = simulation.edit(|batch| {
        let tag = batch.find_tag("a").unwrap();
        let keys: Vec<_> = batch.tagged(tag).skip(1).collect();
        keys.iter().try_for_each(|&key| batch.remove(key))?;
        batch.set_transparent(&[])
    });
    lone.unwrap();
    assert_eq!(simulation.view().len(), 1);
}

/// Grown gases of which some pairs do not see each other cover more than the box.
#[test]
fn gases_that_do_not_see_each_other_grow_through_each_other() {
    let gas = |tag: &str| {
        format!(
            "[[gas]]\ntags = [\"{tag}\"]\nradius = 0.03\nmass = 1.0\nenergy = 1.0\narea_fraction = 0.65\n"
        )
    };
    let scene = read(
        &("[start]\nplacement = \"grown\"\nrelax = 5\n[[transparent]]\nbetween = [\"a\", \"b\"]\n"
            .to_owned()
            + &gas("a")
            + &gas("b")),
    );
    let mut simulation = simulate::<CellScheduler>(&scene, &Instructions::default());
    assert_eq!(simulation.view().overlaps().pairs, 0);
    simulation.run_until(0.2).unwrap();
    assert_eq!(simulation.view().overlaps().pairs, 0);
    let covered: f64 = simulation
        .view()
        .bodies()
        .map(|body| body.body.molecule().area())
        .sum();
    assert!(covered > 1.25);
}
