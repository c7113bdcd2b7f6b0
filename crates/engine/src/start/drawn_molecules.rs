//! The molecules of a gas: equal ones, or each with its own drawn size and mass.

use carom_geometry::{Atom, GeometryError, Molecule, Shape};
use glam::DVec2;
use rand_pcg::Pcg64;

use crate::{
    scene::{
        Scene,
        atom_spec::AtomSpec,
        distribution::{Distribution, Quantity},
        error::SceneError,
        gas_spec::{GasSpec, TWO_MASSES, TWO_RADII},
        random::RandomStream,
    },
    start::body_builder::{geometry, molecule},
};

/// The molecule that a gas describes, or the rule by which each of its molecules is drawn.
pub(crate) enum Described {
    Equal(Box<Molecule>),
    Drawn(Box<DrawnMolecules>),
}

/// The rule by which molecules of different sizes and masses are drawn.
pub(crate) struct DrawnMolecules {
    entry: String,
    /// The atoms: for a named shape, of radius 1 and mass 1.
    atoms: Vec<Atom>,
    radius: Option<Distribution>,
    mass: Option<Distribution>,
    scale: Option<Distribution>,
    density: Option<f64>,
    random: Pcg64,
}

impl Described {
    /// Reads the keys of a gas.
    ///
    /// # Errors
    /// [`SceneError`] with the name of the entry if a key is missing, excluded or out of range.
    pub fn new(scene: &Scene, index: usize, entry: &str) -> Result<Self, SceneError> {
        let spec = &scene.gas[index];
        let problem = |problem: &str| SceneError::Entry {
            entry: entry.to_owned(),
            problem: problem.to_owned(),
        };
        let radius = spec.one_radius().ok_or_else(|| problem(TWO_RADII))?;
        let mass = spec.one_mass().ok_or_else(|| problem(TWO_MASSES))?;
        check(spec, radius, mass).map_err(|reason| problem(&reason))?;
        let is_drawn = [radius, mass]
            .into_iter()
            .flatten()
            .any(|given| given.number().is_none());
        if !is_drawn && spec.scale.is_none() && spec.density.is_none() {
            let [radius, mass] = [radius, mass].map(|given| given.and_then(Quantity::number));
            let molecule = molecule(entry, shape(spec), &spec.atoms, radius, mass)?;
            return Ok(Self::Equal(Box::new(molecule)));
        }
        let atoms =
            atoms(spec, radius.is_some(), mass.is_some()).map_err(|reason| problem(&reason))?;
        let mut random = RandomStream::Sizes.generator(scene.bounds.seed, scene.bounds.replica);
        // A gas needs fewer than 2^64 numbers: its sizes do not depend on the gases before it.
        random.advance((index as u128) << 64);
        let given = [radius, mass, spec.scale.as_ref()];
        let is_one = given.into_iter().flatten().all(Quantity::is_one);
        let [radius, mass, scale] = given.map(|given| given.map(Quantity::distribution));
        let (entry, density) = (entry.to_owned(), spec.density);
        let atoms = atoms.map_err(geometry(&entry))?;
        let mut drawing = DrawnMolecules {
            entry,
            atoms,
            radius,
            mass,
            scale,
            density,
            random,
        };
        if is_one {
            Ok(Self::Equal(Box::new(drawing.next()?)))
        } else {
            Ok(Self::Drawn(Box::new(drawing)))
        }
    }
}

/// The name of the shape of a gas; `None` for a list of atoms.
fn shape(spec: &GasSpec) -> Option<&str> {
    let is_named = spec.atoms.is_empty() || spec.shape.is_some();
    is_named.then(|| spec.shape.as_deref().unwrap_or("disc"))
}

/// Validates the distributions and the density of a gas.
fn check(spec: &GasSpec, radius: Option<&Quantity>, mass: Option<&Quantity>) -> Result<(), String> {
    if let Some(density) = spec.density {
        if mass.is_some() {
            return Err("give either `density` or a mass, not both".to_owned());
        }
        if !(1e-60..=1e60).contains(&density) {
            return Err(format!(
                "`density` must be from 1e-60 to 1e60 (mass / length²), but is {density:?}"
            ));
        }
    }
    for (key, given) in [
        ("radius", radius),
        ("mass", mass),
        ("scale", spec.scale.as_ref()),
    ] {
        if let Some(Err(reason)) = given.map(Quantity::check) {
            return Err(format!("`{key}`: {reason}"));
        }
    }
    Ok(())
}

/// The atoms of a gas whose molecules are drawn: for a named shape, of radius 1 and mass 1.
fn atoms(
    spec: &GasSpec,
    has_radius: bool,
    has_mass: bool,
) -> Result<Result<Vec<Atom>, GeometryError>, String> {
    let Some(name) = shape(spec) else {
        if has_radius || has_mass {
            return Err(
                "`radius` and `mass` go with a named `shape`; a list of atoms has a `scale` and a `density`"
                    .to_owned(),
            );
        }
        let atom = |atom: &AtomSpec| Atom::new(DVec2::from(atom.at), atom.radius, atom.mass);
        return Ok(spec.atoms.iter().map(atom).collect());
    };
    if !spec.atoms.is_empty() {
        return Err("give `shape` or `atoms`, not both".to_owned());
    }
    if !has_radius {
        return Err(match spec.shape {
            Some(_) => "a named shape needs `atom_radius`".to_owned(),
            None => "a disc needs `radius`".to_owned(),
        });
    }
    if !has_mass && spec.density.is_none() {
        return Err(match spec.shape {
            Some(_) => "a named shape needs `atom_mass` or `density`".to_owned(),
            None => "a disc needs `mass` or `density`".to_owned(),
        });
    }
    Ok(name.parse().and_then(|shape: Shape| shape.atoms(1.0, 1.0)))
}

impl DrawnMolecules {
    /// Expected area of a molecule (length²); for normal distributions, to 15 %.
    ///
    /// # Errors
    /// [`SceneError`] with the name of the entry if the molecule of size 1 is invalid.
    pub fn mean_area(&self) -> Result<f64, SceneError> {
        let square = |distribution: &Option<Distribution>| {
            distribution.as_ref().map_or(1.0, Distribution::mean_square)
        };
        let of_size_1 = Molecule::new(self.atoms.clone())
            .map_err(geometry(&self.entry))?
            .area();
        Ok(of_size_1 * square(&self.radius) * square(&self.scale))
    }

    /// Draws the next molecule.
    ///
    /// # Errors
    /// [`SceneError`] with the name of the entry if a length or a mass is out of range.
    pub fn next(&mut self) -> Result<Molecule, SceneError> {
        let Self {
            entry,
            atoms,
            radius,
            mass,
            scale,
            density,
            random,
        } = self;
        let mut draw = |distribution: &Option<Distribution>| {
            distribution
                .as_ref()
                .map_or(1.0, |distribution| distribution.draw(random))
        };
        let length = draw(radius) * draw(scale);
        let mass = draw(mass);
        let scaled = |length: f64, mass: f64| -> Result<Molecule, GeometryError> {
            let atom = |atom: &Atom| {
                Atom::new(
                    length * atom.offset(),
                    length * atom.radius(),
                    mass * atom.mass(),
                )
            };
            Molecule::new(atoms.iter().map(atom).collect::<Result<Vec<_>, _>>()?)
        };
        let molecule = scaled(length, mass).and_then(|molecule| match density {
            Some(density) => scaled(length, *density * molecule.area() / molecule.mass()),
            None => Ok(molecule),
        });
        molecule.map_err(geometry(entry))
    }
}
