//! Bodies from entries of a scene: shape, inertia, tags, and their place in the world.

use std::sync::Arc;

use carom_geometry::{Atom, GeometryError, Molecule, Shape};
use carom_kinematics::{Inertia, Motion};
use glam::DVec2;

use crate::{
    scene::{MoleculeSpec, atom_spec::AtomSpec, error::SceneError},
    world::{
        World,
        body::{BodyKind, Rotation},
        tags::{TagNames, Tags},
    },
};

pub(crate) fn insert(
    world: &mut World,
    molecule: Arc<Molecule>,
    inertia: Inertia,
    tags: Tags,
    motion: Motion,
) -> crate::BodyKey {
    world.insert(
        BodyKind {
            molecule,
            inertia,
            tags,
            elasticity_class: 0,
            temperature: None,
        },
        motion,
    )
}

pub(crate) fn inertia(molecule: &Molecule, rotation: Rotation) -> Inertia {
    match rotation {
        Rotation::Free => Inertia::free(molecule.mass(), molecule.moment_of_inertia()),
        Rotation::Locked => Inertia::locked(molecule.mass()),
    }
}

pub(crate) fn tags(names: &mut TagNames, requested: &[String]) -> Tags {
    let mut tags: Tags = requested.iter().map(|name| names.intern(name)).collect();
    tags.sort_unstable();
    tags.dedup();
    tags
}

/// Creates a molecule from the name of its shape or from its atoms.
pub(crate) fn molecule(
    entry: &str,
    shape: Option<&str>,
    atoms: &[AtomSpec],
    atom_radius: Option<f64>,
    atom_mass: Option<f64>,
) -> Result<Molecule, SceneError> {
    let problem = |problem: &str| SceneError::Entry {
        entry: entry.to_owned(),
        problem: problem.to_owned(),
    };
    match shape {
        Some(_) if !atoms.is_empty() => Err(problem("give `shape` or `atoms`, not both")),
        Some(name) => {
            let shape: Shape = name.parse().map_err(geometry(entry))?;
            let [no_radius, no_mass] = match shape {
                Shape::Disc => [
                    "a disc needs a radius: `radius` in a gas, `atom_radius` in a molecule",
                    "a disc needs a mass: `mass` in a gas, `atom_mass` in a molecule",
                ],
                _ => [
                    "a named shape needs `atom_radius`",
                    "a named shape needs `atom_mass`",
                ],
            };
            let radius = atom_radius.ok_or_else(|| problem(no_radius))?;
            let mass = atom_mass.ok_or_else(|| problem(no_mass))?;
            Molecule::named(shape, radius, mass).map_err(geometry(entry))
        }
        None if atom_radius.is_some() || atom_mass.is_some() => Err(problem(
            "`atom_radius` and `atom_mass` go with a named `shape`",
        )),
        None => {
            let atom = |spec: &AtomSpec| Atom::new(DVec2::from(spec.at), spec.radius, spec.mass);
            let atoms: Result<Vec<Atom>, GeometryError> = atoms.iter().map(atom).collect();
            atoms.and_then(Molecule::new).map_err(geometry(entry))
        }
    }
}

impl MoleculeSpec {
    /// The molecule that `shape` and `atoms` describe; `entry` names this table in errors.
    ///
    /// ```
    /// use carom_engine::MoleculeSpec;
    ///
    /// let spec = MoleculeSpec { shape: Some("tee".into()), ..MoleculeSpec::default() };
    /// let spec = MoleculeSpec { atom_radius: Some(0.005), atom_mass: Some(2.0), ..spec };
    /// assert_eq!(spec.molecule("molecule[0]")?.mass(), 10.0);
    /// # Ok::<(), carom_engine::SceneError>(())
    /// ```
    ///
    /// # Errors
    /// [`SceneError`] if there is neither a shape nor an atom, there are both, or a radius, a mass
    /// or a place is out of range.
    pub fn molecule(&self, entry: &str) -> Result<Molecule, SceneError> {
        molecule(
            entry,
            self.shape.as_deref(),
            &self.atoms,
            self.atom_radius,
            self.atom_mass,
        )
    }
}

/// Adds the name of the entry to an error of geometry.
pub(crate) fn geometry(entry: &str) -> impl FnOnce(GeometryError) -> SceneError {
    let entry = entry.to_owned();
    move |reason| SceneError::Geometry { entry, reason }
}
