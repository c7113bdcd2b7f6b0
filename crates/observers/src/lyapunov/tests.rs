//! Tests of the Lyapunov exponents: vectors against trajectories, pairs, zeros, and the volume.

use super::*;
use carom_engine::{Scene, Simulation};

/// A body of a scene: its keys, place, orientation, velocity and angular velocity.
struct Start {
    keys: &'static str,
    state: [f64; 6],
}

impl Start {
    const fn new(keys: &'static str, state: [f64; 6]) -> Self {
        Self { keys, state }
    }
}

const DISC: &str = "shape = \"disc\"\natom_radius = 0.05\natom_mass = 1.5";
const DUMBBELL: &str = "shape = \"dumbbell\"\natom_radius = 0.06\natom_mass = 1.0";
const SQUARE: &str = "shape = \"square\"\nsize = 0.2\nmass = 0.7";

/// Three bodies, of which one has other keys.
fn bodies(first: &'static str) -> Vec<Start> {
    vec![
        Start::new(first, [0.2, 0.3, 0.7, 0.9, 0.35, 1.3]),
        Start::new(DISC, [0.7, 0.45, 0.0, -1.1, 0.2, 0.0]),
        Start::new(DISC, [0.5, 0.8, 0.0, 0.1, -0.8, 0.0]),
    ]
}

fn simulation(bodies: &[Start], rest: &str) -> Simulation {
    let molecules = bodies.iter().map(|body| {
        let [x, y, angle, u, v, spin] = body.state;
        // A disc has no orientation.
        let turning = if body.keys == DISC {
            String::new()
        } else {
            format!("orientation = {angle:?}\nangular_velocity = {spin:?}\n")
        };
        format!(
            "[[molecule]]\n{}\nat = [{x:?}, {y:?}]\nvelocity = [{u:?}, {v:?}]\n{turning}",
            body.keys
        )
    });
    let text = format!("{rest}\n{}", molecules.collect::<String>());
    Simulation::new(&Scene::from_toml(&text).unwrap()).unwrap()
}

/// Place, orientation, velocity and angular velocity of the free bodies.
fn states(simulation: &Simulation) -> Vec<[f64; 6]> {
    let view = simulation.view();
    let free = view.bodies().filter(|body| body.body.is_free());
    let state = |body: carom_engine::BodyView<'_>| {
        let (place, velocity) = (body.unwrapped(&view.bounds()), body.motion.velocity);
        let angle = body.motion.orientation.radians();
        [
            place.x,
            place.y,
            angle,
            velocity.x,
            velocity.y,
            body.motion.angular_velocity,
        ]
    };
    free.map(state).collect()
}

/// Trajectories are compared once their distance has grown by this factor.
const MIN_GROWTH: f64 = 100.0;

/// Counts the contacts with fixed bodies.
#[derive(Default)]
struct WithFixed(u64);

impl Observer for WithFixed {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.0 += u64::from(report.sides.iter().any(|side| side.body.is_fixed()));
    }
}

/// Compares the vector that the observer carries with the difference of two trajectories that
/// start on both sides of the first, and returns the numbers of contacts and of those with fixed
/// bodies.
fn follows_the_difference(bodies: &[Start], rest: &str) -> [u64; 2] {
    let mut undisturbed = simulation(bodies, rest);
    let mut spectrum = LyapunovSpectrum::new(&undisturbed.view(), 1, 0.0).unwrap();
    spectrum.start(&undisturbed.view());
    let deviation_of = |spectrum: &LyapunovSpectrum| spectrum.space.first_vector();
    let start = deviation_of(&spectrum);
    let (mut until, mut with_fixed) = (0.0, WithFixed::default());
    let has_fixed = undisturbed.view().bodies().any(|body| body.body.is_fixed());
    while spectrum.growth[0] < MIN_GROWTH.ln() || (has_fixed && with_fixed.0 == 0) {
        until += 0.1;
        undisturbed
            .observe_until(until, &mut (&mut spectrum, &mut with_fixed))
            .unwrap();
        spectrum.sample(&undisturbed.view());
    }
    let growth = spectrum.growth[0].exp();
    let end = deviation_of(&spectrum);

    // Small against the radii even at the end.
    let step = 1e-4 / growth.max(1.0);
    let beside = |sign: f64| {
        let moved: Vec<Start> = bodies
            .iter()
            .zip(&start)
            .map(|(body, deviation)| {
                let state = [0, 1, 2, 3, 4, 5].map(|n| body.state[n] + sign * step * deviation[n]);
                Start::new(body.keys, state)
            })
            .collect();
        let mut simulation = simulation(&moved, rest);
        simulation.run_until(until).unwrap();
        assert_eq!(
            simulation.view().counters().collisions,
            undisturbed.view().counters().collisions
        );
        states(&simulation)
    };
    let (above, below) = (beside(1.0), beside(-1.0));
    for ((above, below), vector) in above.iter().zip(&below).zip(&end) {
        for n in 0..6 {
            let difference = (above[n] - below[n]) / (2.0 * step);
            let carried = growth * vector[n];
            assert!(
                (difference - carried).abs() < 1e-6 * growth.max(1.0),
                "{rest}: component {n} is {carried}, the difference {difference}, growth {growth}"
            );
        }
    }
    [undisturbed.view().counters().collisions, with_fixed.0]
}

#[test]
fn the_vectors_are_the_derivative_of_the_trajectory() {
    let walls = "[[wall]]\nx = 0.0\n[[wall]]\ny = 0.0\n";
    let scenes = [
        "",
        walls,
        "[elasticity]\ndefault = 0.8\n[[bumper]]\nradius = 0.05\nat = [0.9, 0.9]\n",
        &format!("[gravity]\nacceleration = [0.3, -1.0]\n{walls}"),
        "[[wall]]\nfrom = [0.35, 0.5]\nto = [0.65, 0.62]\n",
    ];
    for keys in [DISC, DUMBBELL, SQUARE] {
        for rest in scenes {
            let [contacts, with_fixed] = follows_the_difference(&bodies(keys), rest);
            assert!(contacts >= 2, "{keys} {rest}: {contacts} contacts");
            assert!(rest.is_empty() || with_fixed > 0, "{keys} {rest}");
        }
    }
}

#[test]
fn arcs_and_walls_that_move_have_derivatives_too() {
    let container = "[[container]]\ncircle = { at = [0.5, 0.5], radius = 0.49 }\n";
    let moving = "[[wall]]\nx = 0.0\nmotion = { velocity = [0.05, 0.0] }\n";
    let turning = "[[wall]]\nfrom = [0.4, 0.55]\nto = [0.6, 0.65]\nmotion = { turn = 0.5, about = [0.5, 0.6] }\n";
    for rest in [container, moving, turning] {
        let [contacts, with_fixed] = follows_the_difference(&bodies(DUMBBELL), rest);
        assert!(
            contacts >= 3 && with_fixed > 0,
            "{rest}: {contacts} contacts"
        );
    }
}

/// All exponents of a gas, and the sum that its contacts give.
fn spectrum_of(text: &str, until: f64) -> (Vec<f64>, f64) {
    let mut simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
    let mut spectrum = LyapunovSpectrum::new(&simulation.view(), usize::MAX, 0.1 * until).unwrap();
    spectrum.start(&simulation.view());
    for sample in 1..=20 {
        let time = until * f64::from(sample) / 20.0;
        simulation.observe_until(time, &mut spectrum).unwrap();
        spectrum.sample(&simulation.view());
    }
    let exponents = spectrum.sums().iter().map(|[x, t]| x / t).collect();
    (exponents, spectrum.contraction() / spectrum.duration)
}

#[test]
fn the_exponents_of_an_elastic_gas_pair_and_six_are_zero() {
    for (keys, each) in [
        ("radius = 0.06\nmass = 1.0", 4),
        (
            "shape = \"dumbbell\"\natom_radius = 0.03\natom_mass = 1.0",
            6,
        ),
    ] {
        let (exponents, contraction) = spectrum_of(
            &format!("[box]\nseed = 4\n[[gas]]\n{keys}\nenergy = 1.0\ncount = 8"),
            400.0,
        );
        assert_eq!((exponents.len(), contraction), (8 * each, 0.0));
        for (large, small) in exponents.iter().zip(exponents.iter().rev()) {
            assert!((large + small).abs() < 1e-6, "{large} {small}");
        }
        // They approach 0 as ln t / t.
        let zeros = exponents.iter().filter(|exponent| exponent.abs() < 0.05);
        assert_eq!(zeros.count(), 6, "{exponents:?}");
        assert!(
            exponents.windows(2).all(|pair| pair[0] > pair[1] - 0.02),
            "{exponents:?}"
        );
    }
}

#[test]
fn inelastic_contacts_shrink_the_volume_by_the_square_of_the_elasticity() {
    let (exponents, contraction) = spectrum_of(
        "[elasticity]\ndefault = 0.9\n[[gas]]\nradius = 0.06\nmass = 1.0\nenergy = 1.0\ncount = 8",
        30.0,
    );
    let sum: f64 = exponents.iter().sum();
    assert!(
        contraction < -0.1 && (sum / contraction - 1.0).abs() < 1e-9,
        "{sum} {contraction}"
    );
}

/// After a contact with elasticity 0 nothing depends on the speed of approach before it.
#[test]
fn vectors_that_are_rounding_alone_are_counted() {
    let scene =
        "[elasticity]\ndefault = 0.0\n[[gas]]\nradius = 0.06\nmass = 1.0\nenergy = 1.0\ncount = 4";
    let mut simulation = Simulation::new(&Scene::from_toml(scene).unwrap()).unwrap();
    let mut spectrum = LyapunovSpectrum::new(&simulation.view(), usize::MAX, 0.0).unwrap();
    spectrum.start(&simulation.view());
    simulation.observe_until(3.0, &mut spectrum).unwrap();
    spectrum.sample(&simulation.view());
    assert!(spectrum.replaced() > 0);
    assert!(spectrum.sums().iter().flatten().all(|sum| sum.is_finite()));
}

/// A thin Lorentz gas: contacts stretch a thousandfold, grazing ones much more.
#[test]
fn the_exponents_of_one_disc_among_few_pair() {
    let (exponents, _) = spectrum_of(
        "[box]\nsides = [300.0, 300.0]\n[[gas]]\nradius = 1.0\nfixed = true\noverlapping = true\ncount = 100\n\
         [[gas]]\nradius = 1e-9\nmass = 2.0\nenergy = 1.0\ncount = 1",
        1e6,
    );
    assert!(
        (exponents[0] + exponents[3]).abs() < 1e-6 * exponents[0],
        "{exponents:?}"
    );
    assert!(exponents[1].abs() < 1e-3 * exponents[0], "{exponents:?}");
}

#[test]
fn systems_without_a_known_derivative_are_refused_by_name() {
    let error = |text: &str| {
        let simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
        LyapunovSpectrum::new(&simulation.view(), 4, 0.0).unwrap_err()
    };
    assert_eq!(
        error("[[bumper]]\nradius = 0.1\nat = [0.5, 0.5]"),
        LyapunovError::NoFreeBody
    );
    // 40 000 components of 40 000 vectors would take 13 GB.
    let many = "[[gas]]\nradius = 1e-4\nmass = 1.0\nenergy = 1.0\ncount = 10000";
    let many = Simulation::new(&Scene::from_toml(many).unwrap()).unwrap();
    assert_eq!(
        LyapunovSpectrum::new(&many.view(), usize::MAX, 0.0).unwrap_err(),
        LyapunovError::TooMany {
            exponents: 40000,
            dimension: 40000,
            most: 6710
        }
    );
    let gas = "[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 2\n";
    for (keys, what) in [
        (
            "[[piston]]\nx = 0.25\nmass = 3.0\n[[wall]]\nx = 0.0\n",
            "pistons",
        ),
        ("[box]\ndrag = 0.5\n", "a drag"),
        (
            "[[wall]]\nx = 0.0\ntemperature = 1.0\n",
            "walls with a temperature",
        ),
    ] {
        assert_eq!(
            error(&format!("{keys}{gas}")),
            LyapunovError::Unsupported(what)
        );
    }
}

/// Bodies that are added before anything is measured are part of the exponents, and rough contacts
/// are counted.
#[test]
fn the_vectors_are_those_of_the_bodies_at_the_start() {
    let text = "[elasticity]\ntangential = 0.5\n[[gas]]\nradius = 0.06\nmass = 1.0\nenergy = 1.0\ncount = 6";
    let mut simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
    let mut spectrum = LyapunovSpectrum::new(&simulation.view(), usize::MAX, 0.0).unwrap();
    let all = spectrum.dimension();
    let first = simulation.view().bodies().next().unwrap().body.key();
    simulation.remove(first).unwrap();
    spectrum.start(&simulation.view());
    assert_eq!(
        (spectrum.dimension(), spectrum.sums().len()),
        (all / 6 * 5, all / 6 * 5)
    );
    simulation.observe_until(2.0, &mut spectrum).unwrap();
    assert!(spectrum.approximated() > 0);
}
