//! Single bodies of a scene in a few words; the tests of the engine use them, too.

use carom::{
    Scene,
    engine::{AtomSpec, BumperSpec, MoleculeSpec, Rotation, View},
};

/// One disc.
pub fn disc(radius: f64, mass: f64, at: [f64; 2], velocity: [f64; 2]) -> MoleculeSpec {
    MoleculeSpec { velocity, ..named("disc", radius, mass, at) }
}

/// A molecule at rest, by the name of its shape.
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
    BumperSpec { tags: Vec::new(), radius, at }
}

/// The bodies of a view as a scene of single molecules that begins where the view stands; its walls are to be added.
pub fn frozen(view: &View<'_>) -> Scene {
    let molecule = view
        .bodies()
        .filter(|view| view.body.molecule().face().is_none())
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
            rotation: if view.body.is_locked() { Rotation::Locked } else { Rotation::Free },
            fixed: view.body.is_fixed(),
            ..MoleculeSpec::default()
        })
        .collect();
    let mut scene = Scene { molecule, ..Scene::default() };
    scene.bounds.sides = view.bounds().sides().to_array();
    scene
}
