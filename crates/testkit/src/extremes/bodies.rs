//! Constructors of single bodies of a scene, also used by the engine's tests.

use carom::{
    Scene,
    engine::{AtomSpec, BumperSpec, MoleculeSpec, Rotation, View},
};

/// One disc.
pub fn disc(radius: f64, mass: f64, at: [f64; 2], velocity: [f64; 2]) -> MoleculeSpec {
    MoleculeSpec {
        velocity,
        ..named("disc", radius, mass, at)
    }
}

/// A molecule at rest with the shape of this name.
pub fn named(shape: &str, atom_radius: f64, atom_mass: f64, at: [f64; 2]) -> MoleculeSpec {
    MoleculeSpec {
        shape: Some(shape.to_owned()),
        atom_radius: Some(atom_radius),
        atom_mass: Some(atom_mass),
        at,
        ..MoleculeSpec::default()
    }
}

/// A fixed disc.
pub fn bumper(radius: f64, at: [f64; 2]) -> BumperSpec {
    BumperSpec {
        tags: Vec::new(),
        radius,
        at,
    }
}

/// A scene of single molecules in the present state of a view, without its walls.
pub fn frozen(view: &View<'_>) -> Scene {
    let molecule = view
        .bodies()
        .filter(|view| !view.body.is_wall())
        .map(|view| MoleculeSpec {
            atoms: view
                .body
                .molecule()
                .atoms()
                .iter()
                .map(|atom| AtomSpec {
                    at: atom.offset().to_array(),
                    radius: atom.radius(),
                    mass: atom.mass(),
                })
                .collect(),
            at: view.motion.position.to_array(),
            orientation_turns: Some(view.motion.orientation.turns()),
            velocity: view.motion.velocity.to_array(),
            angular_velocity: view.motion.angular_velocity,
            rotation: if view.body.is_locked() {
                Rotation::Locked
            } else {
                Rotation::Free
            },
            fixed: view.body.is_fixed(),
            ..MoleculeSpec::default()
        })
        .collect();
    let mut scene = Scene {
        molecule,
        ..Scene::default()
    };
    scene.bounds.sides = view.bounds().sides().to_array();
    scene
}
