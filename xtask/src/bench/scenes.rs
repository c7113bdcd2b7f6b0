//! The timed scenes: dense and dilute, of equal and unequal discs, and molecules.

use std::f64::consts::PI;

use carom::engine::{AtomSpec, BumperSpec, GasSpec, MoleculeSpec, Quantity, Scene, WallSpec};
use clap::ValueEnum;

type Build = Box<dyn Fn() -> Scene>;

/// All scenes by name.
pub fn all() -> Vec<(&'static str, Build)> {
    let mut scenes: Vec<(&'static str, Build)> =
        vec![("thesis-gas", Box::new(|| gas_only(fraction(0.01, 0.5))))];
    for (name, count) in [
        ("gas-1e3", 1_000),
        ("gas-1e4", 10_000),
        ("gas-1e5", 100_000),
        ("gas-1e6", 1_000_000),
    ] {
        scenes.push((name, Box::new(move || gas_only(filling(count, 0.5)))));
    }
    let dilute = [
        ("dilute-50", 50),
        ("dilute-100", 100),
        ("dilute-500", 500),
        ("dilute-1000", 1000),
        ("dilute-2000", 2000),
    ];
    for (name, count) in dilute {
        scenes.push((name, Box::new(move || gas_only(discs(0.001, 1.0, count)))));
    }
    scenes.push(("dense-0.7", Box::new(|| gas_only(filling(10_000, 0.7)))));
    scenes.push(("mixture-10", Box::new(|| mixture(10_000, 100, 10.0))));
    scenes.push((
        "mixture-10-without",
        Box::new(|| gas_only(filling(10_000, among(0.2, 0.2)))),
    ));
    scenes.push(("mixture-100", Box::new(|| mixture(40_000, 4, 100.0))));
    scenes.extend(of_molecules());
    scenes.push(("one-big-disc", Box::new(one_big_disc)));
    scenes.push((
        "one-big-disc-without",
        Box::new(|| gas_only(filling(10_000, among(0.4, 400.0 * 0.4 / 1e4)))),
    ));
    scenes
}

/// The scenes of molecules that are no discs.
fn of_molecules() -> Vec<(&'static str, Build)> {
    let mut scenes: Vec<(&'static str, Build)> = vec![
        ("tee", Box::new(tee)),
        ("tees-50", Box::new(tees)),
        ("rod-50", Box::new(rod)),
        ("dumbbells-0.26", Box::new(|| gas_only(dumbbells(0.26)))),
        ("dumbbells-0.4", Box::new(|| gas_only(dumbbells(0.4)))),
    ];
    scenes.push((
        "dumbbells-0.3-2000",
        Box::new(|| LargeGas::Dumbbells.scene(2000, 0.3)),
    ));
    scenes.push((
        "ellipses-0.3-2000",
        Box::new(|| gas_only(ellipses(2000, 0.3))),
    ));
    scenes.push((
        "squares-0.3-2000",
        Box::new(|| gas_only(sided("square", 1.0, 2000, 0.3))),
    ));
    // A straight part of L diameters d has the area L d² + π d²/4.
    for (name, shape, length) in [
        ("capsules-0.3-2000", "capsule:2", 2.0),
        ("long-capsules-0.3-2000", "capsule:7", 7.0),
    ] {
        let gas = move || gas_only(sided(shape, length + 0.25 * PI, 2000, 0.3));
        scenes.push((name, Box::new(gas)));
    }
    // As long as the longer capsules.
    let atom_radius = (0.3f64 / (8.0 * PI * 2000.0)).sqrt();
    scenes.push((
        "rods-0.3-2000",
        Box::new(move || gas_only(molecules("rod:8", atom_radius, 0.125, 2000))),
    ));
    scenes
}

fn discs(radius: f64, mass: f64, count: usize) -> GasSpec {
    GasSpec {
        radius: Some(radius.into()),
        mass: Some(mass.into()),
        energy: 1.0,
        count: Some(count),
        ..GasSpec::default()
    }
}

fn fraction(radius: f64, area_fraction: f64) -> GasSpec {
    GasSpec {
        count: None,
        area_fraction: Some(area_fraction),
        ..discs(radius, 1.0, 0)
    }
}

fn filling(count: usize, area_fraction: f64) -> GasSpec {
    discs((area_fraction / (PI * count as f64)).sqrt(), 1.0, count)
}

/// Area fraction of small discs in the area that the large ones leave free; both arguments are area
/// fractions of the box. A gas of this area fraction corresponds to the mixture without the large
/// discs.
fn among(discs: f64, large: f64) -> f64 {
    discs / (1.0 - large)
}

/// A large gas of equal molecules.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LargeGas {
    /// Discs.
    Discs,
    /// Dumbbells.
    Dumbbells,
    /// Discs between three walls.
    BetweenWalls,
    /// Discs among fixed discs of twice their radius, one for 16 of them.
    AmongBumpers,
}

impl LargeGas {
    /// So many molecules at an area fraction.
    pub fn scene(self, count: usize, area_fraction: f64) -> Scene {
        let discs = filling(count, area_fraction);
        match self {
            Self::Discs => gas_only(discs),
            Self::Dumbbells => {
                let atom_radius = (area_fraction / (2.0 * PI * count as f64)).sqrt();
                gas_only(molecules("dumbbell", atom_radius, 0.5, count))
            }
            Self::BetweenWalls => {
                let wall = |x, y| WallSpec {
                    x,
                    y,
                    ..WallSpec::default()
                };
                let wall = vec![
                    wall(Some(0.0), None),
                    wall(None, Some(0.0)),
                    wall(None, Some(0.5)),
                ];
                Scene {
                    wall,
                    ..gas_only(discs)
                }
            }
            Self::AmongBumpers => {
                let radius = discs
                    .radius
                    .as_ref()
                    .and_then(Quantity::number)
                    .unwrap_or(0.0);
                let side = (count as f64 / 16.0).sqrt().round();
                let places = 0..(side * side) as usize;
                let bumper = places.map(|place| BumperSpec {
                    tags: Vec::new(),
                    at: [
                        (place as f64 % side + 0.5) / side,
                        ((place as f64 / side).floor() + 0.5) / side,
                    ],
                    radius: 2.0 * radius,
                });
                Scene {
                    bumper: bumper.collect(),
                    ..gas_only(discs)
                }
            }
        }
    }
}

fn gas_only(gas: GasSpec) -> Scene {
    with_gas(vec![], vec![gas])
}

fn with_gas(molecule: Vec<MoleculeSpec>, gas: Vec<GasSpec>) -> Scene {
    let mut scene = Scene {
        molecule,
        gas,
        ..Scene::default()
    };
    scene.bounds.seed = 1;
    scene
}

fn single(shape: &str, atom_radius: f64, atom_mass: f64) -> MoleculeSpec {
    MoleculeSpec {
        shape: Some(shape.to_owned()),
        atom_radius: Some(atom_radius),
        atom_mass: Some(atom_mass),
        at: [0.5, 0.5],
        ..MoleculeSpec::default()
    }
}

fn molecules(shape: &str, atom_radius: f64, atom_mass: f64, count: usize) -> GasSpec {
    GasSpec {
        shape: Some(shape.to_owned()),
        atom_radius: Some(atom_radius.into()),
        atom_mass: Some(atom_mass.into()),
        energy: 1.5,
        count: Some(count),
        ..GasSpec::default()
    }
}

/// Small discs, and large discs of the same total area, at area fraction 0.4; masses are
/// proportional to areas.
fn mixture(small: usize, large: usize, ratio: f64) -> Scene {
    let radius = (0.2 / (PI * small as f64)).sqrt();
    with_gas(
        vec![],
        vec![
            discs(radius, 1.0, small),
            discs(ratio * radius, ratio * ratio, large),
        ],
    )
}

/// The Brownian experiment: a tee with atoms of half the gas radius, in the gas of the thesis, with
/// its bumper.
fn tee() -> Scene {
    let bumper = BumperSpec {
        radius: 0.0025,
        at: [0.1, 0.1],
        tags: vec![],
    };
    let scene = with_gas(vec![single("tee", 0.005, 2.0)], vec![fraction(0.01, 0.5)]);
    Scene {
        bumper: vec![bumper],
        ..scene
    }
}

fn tees() -> Scene {
    with_gas(
        vec![],
        vec![molecules("tee", 0.005, 0.25, 50), fraction(0.01, 0.45)],
    )
}

fn rod() -> Scene {
    with_gas(
        vec![single("rod:50", 0.0025, 0.0625)],
        vec![fraction(0.01, 0.48)],
    )
}

fn dumbbells(area_fraction: f64) -> GasSpec {
    molecules(
        "dumbbell",
        (area_fraction / (2000.0 * PI)).sqrt(),
        0.5,
        1000,
    )
}

/// Ellipses with axes of ratio 2.
fn ellipses(count: usize, area_fraction: f64) -> GasSpec {
    // The longer axis is twice the shorter one, so that the area is π size²/8.
    let size = (8.0 * area_fraction / (PI * count as f64)).sqrt();
    GasSpec {
        shape: Some("ellipse:2".to_owned()),
        size: Some(size.into()),
        mass: Some(1.0.into()),
        energy: 1.5,
        count: Some(count),
        ..GasSpec::default()
    }
}

/// So many molecules with sides, whose area is this times the square of their size.
fn sided(shape: &str, area: f64, count: usize, area_fraction: f64) -> GasSpec {
    let size = (area_fraction / (area * count as f64)).sqrt();
    GasSpec {
        shape: Some(shape.to_owned()),
        size: Some(size.into()),
        ..ellipses(count, area_fraction)
    }
}

fn one_big_disc() -> Scene {
    let gas = filling(10_000, 0.4);
    let radius = 20.0
        * gas
            .radius
            .as_ref()
            .and_then(Quantity::number)
            .unwrap_or(0.0);
    let big = AtomSpec {
        at: [0.0; 2],
        radius,
        mass: 400.0,
    };
    let molecule = MoleculeSpec {
        atoms: vec![big],
        at: [0.5, 0.5],
        ..MoleculeSpec::default()
    };
    with_gas(vec![molecule], vec![gas])
}
