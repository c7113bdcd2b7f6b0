//! Bodies from entries of a scene: shape, inertia, tags, and their place in the world.

use std::sync::Arc;

use carom_geometry::{GeometryError, Molecule, Shape};
use carom_kinematics::{Inertia, Motion};

use crate::{
    scene::{MoleculeSpec, error::SceneError},
    start::shape_template::{Refusal, ShapeKeys, Template},
    world::{
        World,
        body::{BodyKind, Rotation},
        tags::Tags,
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
            tag_class: 0,
            has_rough_contacts: false,
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

/// Which keys of the size and of the mass a molecule or a gas has.
#[derive(Debug, Clone, Copy)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "one for each key that a file may give"
)]
pub(crate) struct GivenKeys {
    /// `atom_radius`, or `radius` in a gas.
    pub radius: bool,
    pub size: bool,
    pub atom_mass: bool,
    /// `mass` of a single molecule, which is that of a body with sides.
    pub mass: bool,
    /// `mass` of a gas, which is that of a body with sides or of an atom of a named shape.
    pub mass_in_gas: bool,
    pub density: bool,
}

/// Refuses keys that do not go with a shape, and shapes without size or mass.
pub(crate) fn check_keys(template: &Template, given: GivenKeys) -> Result<(), String> {
    let refused = |problem: &str| Err(problem.to_owned());
    let of_body = given.mass || given.mass_in_gas;
    if given.density && (of_body || given.atom_mass) {
        return refused("give either `density` or a mass, not both");
    }
    match template {
        Template::Named(_) if given.size => {
            refused("`size` goes with a shape that has sides; atoms have an `atom_radius`")
        }
        Template::Named(_) if given.mass => {
            refused("`mass` goes with a shape that has sides; atoms have an `atom_mass`")
        }
        Template::Named(shape) => {
            let is_disc = *shape == Shape::Disc;
            let has_mass = given.mass_in_gas || given.atom_mass || given.density;
            match (given.radius, has_mass, is_disc) {
                (false, _, true) => {
                    refused("a disc needs a radius: `radius` in a gas, `atom_radius` in a molecule")
                }
                (false, _, false) => refused("a named shape needs `atom_radius`"),
                (true, false, true) => refused(
                    "a disc needs a mass: `mass` in a gas, `atom_mass` in a molecule, or a `density`",
                ),
                (true, false, false) => refused("a named shape needs `atom_mass`, or a `density`"),
                (true, true, _) => Ok(()),
            }
        }
        Template::Listed { .. } | Template::Ellipses(_)
            if given.size || given.radius || given.atom_mass || of_body =>
        {
            refused(
                "`size`, radii and masses go with a named `shape`; a list of atoms or ellipses has a `scale`, in a \
                 gas, and a `density`",
            )
        }
        Template::Listed { .. } | Template::Ellipses(_) => Ok(()),
        Template::Edged { .. } | Template::Polygon { .. } if given.radius || given.atom_mass => {
            refused("a shape with sides has `size` and `mass` in place of those of atoms")
        }
        Template::Edged { shape, .. } if !given.size => {
            Err(format!("the shape {shape} needs a `size`"))
        }
        Template::Polygon { .. } if given.size => {
            refused("`polygon` has its own lengths and no `size`")
        }
        Template::Edged { .. } | Template::Polygon { .. } => {
            if of_body || given.density {
                Ok(())
            } else {
                refused("a shape with sides needs `mass` or `density`")
            }
        }
    }
}

/// The template that keys describe, checked; `entry` names the table in errors.
pub(crate) fn template(
    entry: &str,
    keys: ShapeKeys<'_>,
    given: GivenKeys,
) -> Result<Template, SceneError> {
    let problem = |problem| SceneError::Entry {
        entry: entry.to_owned(),
        problem,
    };
    let template = Template::new(keys).map_err(|refusal| match refusal {
        Refusal::Keys(reason) => problem(reason),
        Refusal::Geometry(reason) => geometry(entry)(reason),
    })?;
    check_keys(&template, given).map_err(problem)?;
    Ok(template)
}

impl MoleculeSpec {
    /// The molecule that `shape`, `atoms`, `ellipses` or `polygon` describe; `entry` names this
    /// table in errors.
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
    /// [`SceneError`] if there is no description or more than one, or a length, a mass or a place
    /// is out of range.
    pub fn molecule(&self, entry: &str) -> Result<Molecule, SceneError> {
        let given = GivenKeys {
            radius: self.atom_radius.is_some(),
            size: self.size.is_some(),
            atom_mass: self.atom_mass.is_some(),
            mass: self.mass.is_some(),
            mass_in_gas: false,
            density: self.density.is_some(),
        };
        let template = template(entry, self.into(), given)?;
        let length = self.atom_radius.or(self.size).unwrap_or(1.0);
        let molecule = match self.density {
            Some(density) => template.of_density(length, density),
            None => template.molecule(length, self.atom_mass.or(self.mass).unwrap_or(1.0)),
        };
        molecule.map_err(geometry(entry))
    }
}

/// Adds the name of the entry to an error of geometry.
pub(crate) fn geometry(entry: &str) -> impl FnOnce(GeometryError) -> SceneError {
    let entry = entry.to_owned();
    move |reason| SceneError::Geometry { entry, reason }
}
