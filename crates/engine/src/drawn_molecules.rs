//! The molecules of a gas: equal ones, or each with its own drawn size and mass.

use carom_geometry::{Atom, GeometryError, Molecule, Shape};
use glam::DVec2;
use rand_pcg::Pcg64;

use crate::{
    AtomSpec, Distribution, GasSpec, RandomStream, Scene, SceneError,
    body_builder::{geometry, molecule},
    gas_spec::{TWO_MASSES, TWO_RADII},
};

/// The molecule that a gas describes, or the rule by which each of its molecules is drawn.
pub(crate) enum Described {
    Equal(Box<Molecule>),
    Drawn(Drawing),
}

/// The rule by which molecules of different sizes and masses are drawn.
pub(crate) struct Drawing {
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
        let problem =
            |problem: &str| SceneError::Entry { entry: entry.to_owned(), problem: problem.to_owned() };
        let is_named = spec.atoms.is_empty() || spec.shape.is_some();
        let shape = if is_named { Some(spec.shape.as_deref().unwrap_or("disc")) } else { None };
        let radius = one(spec.radius, spec.atom_radius, spec.radius_distribution.as_ref())
            .ok_or_else(|| problem(TWO_RADII))?;
        let mass = one(spec.mass, spec.atom_mass, spec.mass_distribution.as_ref())
            .ok_or_else(|| problem(TWO_MASSES))?;
        if spec.density.is_some() && mass.is_some() {
            return Err(problem("give either `density` or a mass, not both"));
        }
        if let Some(density) = spec.density
            && !(1e-60..=1e60).contains(&density)
        {
            return Err(problem(&format!(
                "`density` must be from 1e-60 to 1e60 (mass / length²), but is {density}"
            )));
        }
        for (key, distribution) in
            [("radius", &spec.radius_distribution), ("mass", &spec.mass_distribution), ("scale", &spec.scale)]
        {
            if let Some(Err(reason)) = distribution.as_ref().map(Distribution::check) {
                return Err(problem(&format!("`{key}`: {reason}")));
            }
        }
        let is_drawn = spec.radius_distribution.is_some() || spec.mass_distribution.is_some();
        if !is_drawn && spec.scale.is_none() && spec.density.is_none() {
            let molecule = molecule(
                entry,
                shape,
                &spec.atoms,
                spec.radius.or(spec.atom_radius),
                spec.mass.or(spec.atom_mass),
            )?;
            return Ok(Self::Equal(Box::new(molecule)));
        }
        if !is_named && (radius.is_some() || mass.is_some()) {
            return Err(problem(
                "`radius` and `mass` go with a named `shape`; a list of atoms has a `scale` and a `density`",
            ));
        }
        let atoms = match shape {
            Some(_) if !spec.atoms.is_empty() => return Err(problem("give `shape` or `atoms`, not both")),
            Some(_) if radius.is_none() => return Err(problem("a named shape needs `atom_radius`")),
            Some(_) if mass.is_none() && spec.density.is_none() => {
                return Err(problem("a named shape needs `atom_mass` or `density`"));
            }
            Some(name) => name.parse().and_then(|shape: Shape| shape.atoms(1.0, 1.0)),
            None => spec
                .atoms
                .iter()
                .map(|atom: &AtomSpec| Atom::new(DVec2::from(atom.at), atom.radius, atom.mass))
                .collect(),
        };
        let mut random = RandomStream::Sizes.generator(scene.bounds.seed, scene.bounds.replica);
        // A gas needs fewer than 2^64 numbers: its sizes do not depend on the gases before it.
        random.advance((index as u128) << 64);
        let drawing = Drawing {
            entry: entry.to_owned(),
            atoms: atoms.map_err(geometry(entry))?,
            radius,
            mass,
            scale: spec.scale.clone(),
            density: spec.density,
            random,
        };
        if has_one_size(spec) {
            let mut drawing = drawing;
            return Ok(Self::Equal(Box::new(drawing.next()?)));
        }
        Ok(Self::Drawn(drawing))
    }
}

/// Whether all molecules are equal: `density` alone makes no difference between them.
fn has_one_size(spec: &GasSpec) -> bool {
    [&spec.radius_distribution, &spec.mass_distribution, &spec.scale]
        .into_iter()
        .flatten()
        .all(|distribution| matches!(distribution, Distribution::Values { values, .. } if values.len() == 1))
}

/// The one of these that is given, if any; `None` if several are.
#[expect(clippy::option_option, reason = "several and none are different")]
fn one(
    first: Option<f64>,
    second: Option<f64>,
    drawn: Option<&Distribution>,
) -> Option<Option<Distribution>> {
    let single = |value: f64| Distribution::Values { values: vec![value], weights: Vec::new() };
    match (first.or(second), drawn) {
        _ if first.is_some() && second.is_some() => None,
        (Some(_), Some(_)) => None,
        (value, drawn) => Some(value.map(single).or_else(|| drawn.cloned())),
    }
}

impl Drawing {
    /// Draws the next molecule.
    ///
    /// # Errors
    /// [`SceneError`] with the name of the entry if a length or a mass is out of range.
    pub fn next(&mut self) -> Result<Molecule, SceneError> {
        let Self { entry, atoms, radius, mass, scale, density, random } = self;
        let mut draw = |distribution: &Option<Distribution>| {
            distribution.as_ref().map_or(1.0, |distribution| distribution.draw(random))
        };
        let length = draw(radius) * draw(scale);
        let mass = draw(mass);
        let scaled = |length: f64, mass: f64| -> Result<Molecule, GeometryError> {
            let atom =
                |atom: &Atom| Atom::new(length * atom.offset(), length * atom.radius(), mass * atom.mass());
            Molecule::new(atoms.iter().map(atom).collect::<Result<Vec<_>, _>>()?)
        };
        let molecule = scaled(length, mass).and_then(|molecule| match density {
            Some(density) => scaled(length, *density * molecule.area() / molecule.mass()),
            None => Ok(molecule),
        });
        molecule.map_err(geometry(entry))
    }
}
