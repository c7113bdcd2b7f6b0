//! A gas starts with the requested temperature or energy, with equal energies or Maxwell's
//! distribution of velocities, whether it is placed on a lattice or grown.

use crate::support::{bumper, gas, named};
use carom_engine::{
    BodyView, GasSpec, Placement, Rotation, Scene, SceneError, Simulation, StartSpec,
    StartVelocities, View, WallSpec,
};
use carom_kinematics::Motion;

const BOTH: [StartVelocities; 2] = [StartVelocities::EqualEnergy, StartVelocities::Maxwell];

/// Standard errors by which a random quantity may differ from its expectation.
const TOLERANCE: f64 = 5.0;

/// Molecules of a shape at kT = 0.7.
fn warm(shape: &str, count: usize, velocities: StartVelocities) -> GasSpec {
    GasSpec {
        energy: 0.0,
        temperature: Some(0.7),
        velocities,
        ..gas(shape, 0.002, count)
    }
}

fn of(gas: Vec<GasSpec>) -> Scene {
    let mut scene = Scene {
        gas,
        ..Scene::default()
    };
    scene.bounds.seed = 11;
    scene
}

fn across(x: Option<f64>, y: Option<f64>) -> WallSpec {
    WallSpec {
        x,
        y,
        ..WallSpec::default()
    }
}

fn start(scene: &Scene) -> Simulation {
    Simulation::new(scene).unwrap()
}

fn motions(scene: &Scene) -> Vec<Motion> {
    start(scene)
        .view()
        .bodies()
        .map(|body| body.motion)
        .collect()
}

/// Velocities and angular velocities of all bodies, as bits.
fn velocity_bits(scene: &Scene) -> Vec<[u64; 3]> {
    let bits = |motion: Motion| {
        [
            motion.velocity.x,
            motion.velocity.y,
            motion.angular_velocity,
        ]
    };
    motions(scene)
        .into_iter()
        .map(|motion| bits(motion).map(f64::to_bits))
        .collect()
}

/// ⟨x²⟩ / ⟨x⟩².
fn mean_square(numbers: impl Iterator<Item = f64>) -> f64 {
    let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for number in numbers {
        (count, sum, squares) = (count + 1.0, sum + number, squares + number * number);
    }
    count * squares / (sum * sum)
}

/// Asserts that kT of all bodies is 0.7 to rounding.
fn assert_warm(view: &View<'_>, case: &str) {
    let temperature = view.temperature().unwrap();
    assert!(
        (temperature / 0.7 - 1.0).abs() < 1e-13,
        "{case}: {temperature}"
    );
}

#[test]
fn maxwell_velocities_have_the_moments_of_the_normal_distribution() {
    let count = 4000;
    let drawn = motions(&of(vec![warm("dumbbell", count, StartVelocities::Maxwell)]));
    let standard_error = |variance: f64| (variance / count as f64).sqrt();
    // v² is exponential: the variance of the estimate of ⟨v⁴⟩/⟨v²⟩² is 4/N by the delta method.
    let kurtosis = mean_square(drawn.iter().map(|motion| motion.velocity.length_squared()));
    assert!(
        (kurtosis - 2.0).abs() < TOLERANCE * standard_error(4.0),
        "{kurtosis}"
    );
    // ⟨x⁴⟩/⟨x²⟩² of a normal number is 3, and the variance of its estimate 24/N.
    let components: [fn(&Motion) -> f64; 3] = [
        |motion| motion.velocity.x,
        |motion| motion.velocity.y,
        |motion| motion.angular_velocity,
    ];
    for component in components {
        let kurtosis = mean_square(drawn.iter().map(|motion| component(motion).powi(2)));
        assert!(
            (kurtosis - 3.0).abs() < TOLERANCE * standard_error(24.0),
            "{kurtosis}"
        );
    }
    // Components are not correlated; ω is as often positive as negative.
    let mean =
        |product: &dyn Fn(&Motion) -> f64| drawn.iter().map(product).sum::<f64>() / count as f64;
    let rms = components.map(|component| mean(&|motion| component(motion).powi(2)).sqrt());
    for [one, other] in [[0, 1], [0, 2], [1, 2]] {
        let product = mean(&|motion| components[one](motion) * components[other](motion));
        let correlation = product / (rms[one] * rms[other]);
        assert!(
            correlation.abs() < TOLERANCE * standard_error(1.0),
            "{one} {other}: {correlation}"
        );
    }
    assert!(
        (mean(&|motion| motion.angular_velocity) / rms[2]).abs() < TOLERANCE * standard_error(1.0)
    );

    // Equal energies: ⟨v⁴⟩ = ⟨v²⟩².
    let equal = motions(&of(vec![warm("disc", count, StartVelocities::EqualEnergy)]));
    let kurtosis = mean_square(equal.iter().map(|motion| motion.velocity.length_squared()));
    assert!((kurtosis - 1.0).abs() < 1e-14, "{kurtosis}");
}

#[test]
fn translation_and_rotation_have_the_same_temperature() {
    let count = 4000;
    let simulation = start(&of(vec![warm("tee", count, StartVelocities::Maxwell)]));
    let thermal = simulation
        .view()
        .centre_of_mass_frame()
        .thermal(simulation.view().bodies());
    let count = count as f64;
    let (translation, rotation) = (
        thermal.translation / (count - 1.0),
        2.0 * thermal.rotation / count,
    );
    // Relative variances 1/N of the energy of 2 N and 2/N of that of N normal numbers.
    let standard_error = (3.0 / count).sqrt();
    assert!(
        (rotation / translation - 1.0).abs() < TOLERANCE * standard_error,
        "{translation} {rotation}"
    );
}

#[test]
fn a_gas_starts_at_the_requested_temperature() {
    for velocities in BOTH {
        for shape in ["disc", "dumbbell"] {
            for count in [2, 3, 50, 151] {
                let gas = warm(shape, count, velocities);
                let scene = of(vec![gas.clone()]);
                let case = format!("{count} of {shape}, {velocities:?}");
                assert_warm(&start(&scene).view(), &case);
                // Momentum is conserved along y, along x, and along no axis.
                for wall in [across(Some(0.0), None), across(None, Some(0.0))] {
                    assert_warm(
                        &start(&Scene {
                            wall: vec![wall],
                            ..scene.clone()
                        })
                        .view(),
                        &case,
                    );
                }
                for zero_momentum in [None, Some(true)] {
                    let gas = GasSpec {
                        zero_momentum,
                        ..gas.clone()
                    };
                    let bumper = vec![bumper(0.1, [0.5, 0.5])];
                    assert_warm(
                        &start(&Scene {
                            bumper,
                            ..of(vec![gas])
                        })
                        .view(),
                        &case,
                    );
                }
                let locked = GasSpec {
                    rotation: Rotation::Locked,
                    ..gas
                };
                assert_warm(&start(&of(vec![locked])).view(), &case);
            }
        }
    }
}

#[test]
fn each_gas_of_a_mixture_has_its_temperature() {
    let tagged = |tag: &str, gas: GasSpec| GasSpec {
        tags: vec![tag.to_owned()],
        ..gas
    };
    for velocities in BOTH {
        let discs = tagged(
            "disc",
            GasSpec {
                atom_mass: Some(5.0.into()),
                ..warm("disc", 7, velocities)
            },
        );
        let tees = tagged("tee", warm("tee", 10, velocities));
        let scene = of(vec![discs.clone(), tees.clone()]);
        assert_warm(&start(&scene).view(), "mixture");
        let hot = GasSpec {
            temperature: Some(2.0),
            ..tees
        };
        let simulation = start(&of(vec![discs, hot]));
        let frame = simulation.view().centre_of_mass_frame();
        for (tag, expected) in [("disc", 0.7), ("tee", 2.0)] {
            let tag = simulation.find_tag(tag).unwrap();
            let temperature = frame
                .thermal(simulation.view().tagged(tag))
                .temperature()
                .unwrap();
            assert!(
                (temperature / expected - 1.0).abs() < 1e-13,
                "{temperature} of {expected}"
            );
        }
    }
}

#[test]
fn independent_velocities_have_the_energy_of_the_temperature() {
    for velocities in BOTH {
        for (shape, freedom) in [("disc", 2.0), ("dumbbell", 3.0)] {
            for count in [1, 2, 60] {
                let zero_momentum = (count > 1).then_some(false);
                let gas = GasSpec {
                    zero_momentum,
                    ..warm(shape, count, velocities)
                };
                let simulation = start(&of(vec![gas]));
                let expected = 0.5 * freedom * 0.7 * count as f64;
                assert!((simulation.view().energy() / expected - 1.0).abs() < 1e-13);
                assert!(
                    simulation.view().momentum().length() > 0.1,
                    "{count} of {shape}"
                );
            }
        }
    }
}

#[test]
fn maxwell_velocities_have_no_drift_where_momentum_is_conserved() {
    let gas = |count| warm("dumbbell", count, StartVelocities::Maxwell);
    let momentum = |scene: &Scene| start(scene).view().momentum().length();
    for count in [2, 3, 200] {
        assert!(momentum(&of(vec![gas(count)])) < 1e-13, "{count}");
        let wall = vec![across(Some(0.0), None)];
        assert!(
            momentum(&Scene {
                wall,
                ..of(vec![gas(count)])
            }) < 1e-13,
            "{count}"
        );
    }
    let around = Scene {
        bumper: vec![bumper(0.1, [0.5, 0.5])],
        ..of(vec![gas(200)])
    };
    assert!(momentum(&around) > 1.0);
    let refused = Simulation::new(&of(vec![GasSpec {
        zero_momentum: Some(true),
        ..gas(1)
    }]))
    .unwrap_err();
    assert!(refused.to_string().contains("zero_momentum"), "{refused}");
}

#[test]
fn a_maxwell_gas_may_be_given_by_its_energy() {
    let gas = GasSpec {
        velocities: StartVelocities::Maxwell,
        ..gas("dumbbell", 0.002, 100)
    };
    let simulation = start(&of(vec![GasSpec {
        energy: 2.5,
        ..gas.clone()
    }]));
    assert!((simulation.view().energy() / 250.0 - 1.0).abs() < 1e-13);
    let energies: Vec<f64> = simulation
        .view()
        .bodies()
        .map(|body| body.energy())
        .collect();
    assert!(
        energies.iter().any(|&energy| energy > 5.0) && energies.iter().any(|&energy| energy < 1.0)
    );
    // At rest.
    let cold = GasSpec {
        energy: 0.0,
        ..gas.clone()
    };
    let frozen = GasSpec {
        temperature: Some(0.0),
        ..cold.clone()
    };
    for gas in [cold, frozen] {
        let is_at_rest = |body: BodyView<'_>| body.energy() == 0.0;
        assert!(start(&of(vec![gas])).view().bodies().all(is_at_rest));
    }
}

#[test]
fn velocities_depend_on_the_seed_alone() {
    let scene = of(vec![warm("dumbbell", 20, StartVelocities::Maxwell)]);
    let first = velocity_bits(&scene);
    assert_eq!(velocity_bits(&scene), first);
    let mut other = scene.clone();
    other.bounds.seed = 12;
    assert!(
        velocity_bits(&other)
            .iter()
            .zip(&first)
            .all(|(one, other)| one != other)
    );
    other.bounds.seed = 11;
    other.bounds.replica = 1;
    assert!(
        velocity_bits(&other)
            .iter()
            .zip(&first)
            .all(|(one, other)| one != other)
    );
    // On every processor: FNV-1a, 64 bits (Fowler, Noll, Vo 1991).
    let bytes = first
        .as_flattened()
        .iter()
        .flat_map(|word| word.to_le_bytes());
    let fingerprint = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    assert_eq!(fingerprint, 0x9209_dbf5_82ae_5aad, "{fingerprint:#x}");
}

#[test]
fn grown_gases_have_the_velocities_of_gases_on_a_lattice() {
    for velocities in BOTH {
        let gases = vec![
            warm("dumbbell", 40, velocities),
            warm("disc", 31, velocities),
        ];
        let molecule = vec![named("tee", 0.03, 1.0, [0.5, 0.5])];
        let placed = Scene {
            molecule,
            ..of(gases)
        };
        let grown = |relax| {
            let start = StartSpec {
                placement: Some(Placement::Grown),
                relax: Some(relax),
                ..StartSpec::default()
            };
            Scene {
                start,
                ..placed.clone()
            }
        };
        assert_eq!(velocity_bits(&grown(0.0)), velocity_bits(&placed));
        // Collisions change the velocities, but not the temperature.
        let relaxed = Scene {
            molecule: vec![],
            ..grown(20.0)
        };
        assert!(velocity_bits(&relaxed) != velocity_bits(&placed)[1..]);
        assert_warm(&start(&relaxed).view(), "relaxed");
    }
}

#[test]
fn contradictory_energies_are_refused_by_name() {
    let text = |keys: &str| format!("[[gas]]\nradius = 0.01\nmass = 1.0\ncount = 10\n{keys}");
    let read = |keys: &str| Scene::from_toml(&text(keys));
    let both = "gas[0]: give either `energy` or `temperature`, not both";
    for keys in [
        "energy = 1.0\ntemperature = 1.0",
        "energy = 0.0\ntemperature = 0.0",
    ] {
        assert_eq!(read(keys).unwrap_err().to_string(), both);
    }
    assert_eq!(
        read("").unwrap_err().to_string(),
        "gas[0]: `energy` or `temperature` is missing"
    );
    let unknown = read("temperature = 1.0\nvelocities = \"boltzmann\"").unwrap_err();
    assert!(matches!(unknown, SceneError::Syntax(_)), "{unknown}");
    for word in ["line 6", "boltzmann", "`equal-energy`", "`maxwell`"] {
        assert!(unknown.to_string().contains(word), "{unknown}");
    }
    let refusal = |gas: GasSpec| Simulation::new(&of(vec![gas])).unwrap_err().to_string();
    let good = || warm("disc", 10, StartVelocities::Maxwell);
    assert_eq!(
        refusal(GasSpec {
            energy: 1.0,
            ..good()
        }),
        both
    );
    for (bad, written) in [
        (-1.0, "-1"),
        (f64::NAN, "NaN"),
        (f64::INFINITY, "inf"),
        (1e61, "1e61"),
    ] {
        let message = refusal(GasSpec {
            temperature: Some(bad),
            ..good()
        });
        let words = [
            "gas[0]: ",
            "`temperature` must be from 0 to 1e60",
            &format!("but is {written}"),
        ];
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
    // Speeds beyond the range of the engine.
    for velocities in BOTH {
        let gas = warm("disc", 10, velocities);
        let fast = GasSpec {
            temperature: Some(1e60),
            atom_mass: Some((1e-60).into()),
            ..gas.clone()
        };
        assert!(refusal(fast).contains("the speed that `temperature` gives"));
        let slow = GasSpec {
            temperature: Some(1e-150),
            ..gas
        };
        assert!(refusal(slow).contains("must be 0 or at least 1e-70"));
    }
}

#[test]
fn a_temperature_is_unchanged_by_writing_and_reading() {
    let mut scene = of(vec![
        warm("disc", 10, StartVelocities::Maxwell),
        gas("tee", 0.002, 3),
    ]);
    scene.gas[0].tags = vec!["warm".to_owned()];
    let text = scene.to_toml();
    assert_eq!(Scene::from_toml(&text).unwrap(), scene);
    assert!(
        text.contains("velocities = \"maxwell\"") && text.matches("energy = ").count() == 1,
        "{text}"
    );
    // Files without the new keys are written as before.
    let old = of(vec![gas("tee", 0.002, 3)]).to_toml();
    assert!(
        !old.contains("temperature") && !old.contains("velocities"),
        "{old}"
    );
}
