//! The molecules of a gas: equal ones, or each with its own drawn size and mass.

use carom_geometry::Molecule;
use rand_pcg::Pcg64;

use crate::{
    scene::{
        Scene,
        distribution::{Distribution, Quantity},
        error::SceneError,
        gas_spec::{GasSpec, TWO_MASSES, TWO_RADII},
        random::RandomStream,
    },
    start::{
        body_builder::{GivenKeys, geometry, template},
        shape_template::Template,
    },
};

/// The molecule that a gas describes, or the rule by which each of its molecules is drawn.
pub(crate) enum Described {
    Equal(Box<Molecule>),
    Drawn(Box<DrawnMolecules>),
}

/// The rule by which molecules of different sizes and masses are drawn.
pub(crate) struct DrawnMolecules {
    entry: String,
    /// The shape: discs by name as a list of atoms of radius 1 and mass 1.
    template: Template,
    /// Radius of an atom, or size.
    size: Option<Distribution>,
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
        let size = radius.or(spec.size.as_ref());
        check(spec, radius, mass).map_err(|reason| problem(&reason))?;
        let template = template(entry, spec.into(), given_keys(spec))?;
        let is_drawn = [size, mass]
            .into_iter()
            .flatten()
            .any(|given| given.number().is_none());
        if !is_drawn && spec.scale.is_none() && spec.density.is_none() {
            let [size, mass] = [size, mass].map(|given| given.and_then(Quantity::number));
            let molecule = template
                .molecule(size.unwrap_or(1.0), mass.unwrap_or(1.0))
                .map_err(geometry(entry))?;
            return Ok(Self::Equal(Box::new(molecule)));
        }
        let mut random = RandomStream::Sizes.generator(scene.bounds.seed, scene.bounds.replica);
        // A gas needs fewer than 2^64 numbers: its sizes do not depend on the gases before it.
        random.advance((index as u128) << 64);
        let given = [size, mass, spec.scale.as_ref()];
        let is_one = given.into_iter().flatten().all(Quantity::is_one);
        let [size, mass, scale] = given.map(|given| given.map(Quantity::distribution));
        let mut drawing = DrawnMolecules {
            template: template.unfolded().map_err(geometry(entry))?,
            entry: entry.to_owned(),
            size,
            mass,
            scale,
            density: spec.density,
            random,
        };
        if is_one {
            Ok(Self::Equal(Box::new(drawing.next()?)))
        } else {
            Ok(Self::Drawn(Box::new(drawing)))
        }
    }
}

fn given_keys(spec: &GasSpec) -> GivenKeys {
    GivenKeys {
        radius: spec.radius.is_some() || spec.atom_radius.is_some(),
        size: spec.size.is_some(),
        atom_mass: spec.atom_mass.is_some(),
        mass: false,
        // A fixed molecule needs none.
        mass_in_gas: spec.mass.is_some()
            || (spec.fixed
                && spec.atoms.is_empty()
                && spec.ellipses.is_empty()
                && spec.atom_mass.is_none()
                && spec.density.is_none()),
        density: spec.density.is_some(),
    }
}

/// Validates the distributions and the density of a gas.
fn check(spec: &GasSpec, radius: Option<&Quantity>, mass: Option<&Quantity>) -> Result<(), String> {
    if let Some(density) = spec.density
        && !(1e-60..=1e60).contains(&density)
    {
        return Err(format!(
            "`density` must be from 1e-60 to 1e60 (mass / length²), but is {density:?}"
        ));
    }
    for (key, given) in [
        ("radius", radius),
        ("size", spec.size.as_ref()),
        ("mass", mass),
        ("scale", spec.scale.as_ref()),
    ] {
        if let Some(Err(reason)) = given.map(Quantity::check) {
            return Err(format!("`{key}`: {reason}"));
        }
    }
    Ok(())
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
        let of_size_1 = self
            .template
            .molecule(1.0, 1.0)
            .map_err(geometry(&self.entry))?
            .area();
        Ok(of_size_1 * square(&self.size) * square(&self.scale))
    }

    /// Draws the next molecule.
    ///
    /// # Errors
    /// [`SceneError`] with the name of the entry if a length or a mass is out of range.
    pub fn next(&mut self) -> Result<Molecule, SceneError> {
        let Self {
            entry,
            template,
            size,
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
        let length = draw(size) * draw(scale);
        let mass = draw(mass);
        let molecule = match density {
            Some(density) => template.of_density(length, *density),
            None => template.molecule(length, mass),
        };
        molecule.map_err(geometry(entry))
    }
}
