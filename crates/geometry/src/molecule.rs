//! A molecule: a rigid union of atoms, written in the frame of its centre of mass.

use glam::DVec2;
use parry2d_f64::{
    math::Pose,
    shape::{Compound, SharedShape},
};
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

use crate::{Atom, CircleTree, GeometryError, Shape, atom::reach};

/// A rigid union of discs with its mass, moment of inertia and bounding circle.
///
/// The atoms' offsets are taken from the centre of mass, in the order given. Atoms may overlap:
/// each brings its own mass.
///
/// ```
/// use carom_geometry::{Atom, Molecule};
/// use glam::DVec2;
///
/// let left = Atom::new(DVec2::new(0.0, 0.0), 0.5, 1.0)?;
/// let right = Atom::new(DVec2::new(1.0, 0.0), 0.5, 1.0)?;
/// let dumbbell = Molecule::new([left, right])?;
/// assert_eq!(dumbbell.atoms()[0].offset(), DVec2::new(-0.5, 0.0));
/// // Two discs: 2 (m r²/2 + m d²), r = d = 1/2.
/// assert_eq!(dumbbell.moment_of_inertia(), 0.75);
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(into = "CentredAtoms", try_from = "CentredAtoms")]
pub struct Molecule {
    atoms: SmallVec<[Atom; 1]>,
    mass: f64,
    moment_of_inertia: f64,
    bounding_radius: f64,
    tree: Option<CircleTree>,
}

/// What detection needs to know of a shape: its atoms and the circles that hold them.
#[derive(Debug, Clone, Copy)]
pub struct Outline<'a> {
    /// The atoms, about the centre of mass.
    pub atoms: &'a [Atom],
    /// Radius of the smallest circle about the centre of mass that holds all atoms (length).
    pub bounding_radius: f64,
    pub(crate) tree: Option<&'a CircleTree>,
}

impl<'a> Outline<'a> {
    /// The tree of circles over the atoms, of molecules that have more than
    /// [`CircleTree::CROSSOVER`] of them.
    pub fn tree(&self) -> Option<&'a CircleTree> {
        self.tree
    }
}

impl Molecule {
    /// A molecule of the given atoms, whose offsets may be in any frame.
    ///
    /// # Errors
    /// [`GeometryError::NoAtoms`] or [`GeometryError::CoincidentAtoms`].
    pub fn new(atoms: impl IntoIterator<Item = Atom>) -> Result<Self, GeometryError> {
        let mut atoms: SmallVec<[Atom; 1]> = atoms.into_iter().collect();
        refuse_coincident(&atoms)?;
        let mass: f64 = atoms.iter().map(Atom::mass).sum();
        let centre = if atoms.len() == 1 {
            atoms[0].offset()
        } else {
            atoms.iter().map(|atom| atom.mass() * atom.offset()).sum::<DVec2>() / mass
        };
        for atom in &mut atoms {
            *atom = atom.moved_by(-centre);
        }
        Ok(Self::of_centred(atoms))
    }

    /// A molecule of atoms that stand about their centre of mass already.
    fn of_centred(atoms: SmallVec<[Atom; 1]>) -> Self {
        let bounding_radius = atoms.iter().map(reach).fold(0.0, f64::max);
        Self {
            mass: atoms.iter().map(Atom::mass).sum(),
            moment_of_inertia: atoms.iter().map(inertia_about_origin).sum(),
            bounding_radius,
            tree: (atoms.len() > CircleTree::CROSSOVER).then(|| CircleTree::new(&atoms, bounding_radius)),
            atoms,
        }
    }

    /// One disc of `radius` (length) and `mass`.
    ///
    /// # Errors
    /// [`GeometryError`] if either is not positive.
    pub fn disc(radius: f64, mass: f64) -> Result<Self, GeometryError> {
        Self::new([Atom::new(DVec2::ZERO, radius, mass)?])
    }

    /// A shape by name, of touching atoms of `atom_radius` (length) and `atom_mass` each.
    ///
    /// # Errors
    /// [`GeometryError`] if radius, mass or the number of atoms is impossible.
    pub fn named(shape: Shape, atom_radius: f64, atom_mass: f64) -> Result<Self, GeometryError> {
        Self::new(shape.atoms(atom_radius, atom_mass)?)
    }

    /// The atoms about the centre of mass, in the order given.
    pub fn atoms(&self) -> &[Atom] {
        &self.atoms
    }

    /// Total mass.
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// Moment of inertia about the centre of mass, each atom a uniform disc: Σ m (r²/2 + d²)
    /// (mass × length²).
    pub fn moment_of_inertia(&self) -> f64 {
        self.moment_of_inertia
    }

    /// Radius of the smallest circle about the centre of mass that holds all atoms (length).
    ///
    /// parry's bounding sphere of a compound is neither centred there nor tight.
    #[doc(alias = "bounding circle")]
    pub fn bounding_radius(&self) -> f64 {
        self.bounding_radius
    }

    /// Sum of the areas of the atoms (length²); overlaps of atoms count twice.
    pub fn area(&self) -> f64 {
        self.atoms.iter().map(|atom| std::f64::consts::PI * atom.radius() * atom.radius()).sum()
    }

    /// Whether this is a single disc, which cannot be made to spin by a smooth contact.
    pub fn is_disc(&self) -> bool {
        self.atoms.len() == 1
    }

    /// What detection needs of this molecule.
    pub fn outline(&self) -> Outline<'_> {
        Outline { atoms: &self.atoms, bounding_radius: self.bounding_radius, tree: self.tree.as_ref() }
    }
}

/// The atoms about their centre of mass: a molecule as it is written down.
///
/// They are taken back as they stand. To centre them anew would move them by a rounding.
#[derive(Serialize, Deserialize)]
struct CentredAtoms(SmallVec<[Atom; 1]>);

impl From<Molecule> for CentredAtoms {
    fn from(molecule: Molecule) -> Self {
        Self(molecule.atoms)
    }
}

impl TryFrom<CentredAtoms> for Molecule {
    type Error = GeometryError;

    fn try_from(CentredAtoms(atoms): CentredAtoms) -> Result<Self, GeometryError> {
        refuse_coincident(&atoms)?;
        Ok(Self::of_centred(atoms))
    }
}

fn refuse_coincident(atoms: &[Atom]) -> Result<(), GeometryError> {
    if atoms.is_empty() {
        return Err(GeometryError::NoAtoms);
    }
    for second in 0..atoms.len() {
        for first in 0..second {
            if atoms[first].offset() == atoms[second].offset() {
                return Err(GeometryError::CoincidentAtoms { first, second });
            }
        }
    }
    Ok(())
}

/// The molecule as a parry shape, for queries that parry answers.
impl From<&Molecule> for Compound {
    fn from(molecule: &Molecule) -> Self {
        let parts = molecule
            .atoms()
            .iter()
            .map(|atom| (Pose::from_translation(atom.offset()), SharedShape::new(*atom.ball())));
        Compound::new(parts.collect())
    }
}

/// Moment of inertia of one uniform disc about the origin (parallel-axis theorem).
fn inertia_about_origin(atom: &Atom) -> f64 {
    atom.mass() * (0.5 * atom.radius() * atom.radius() + atom.offset().length_squared())
}

#[cfg(test)]
mod tests {
    use super::*;
    use parry2d_f64::mass_properties::MassProperties;
    use proptest::prelude::*;

    fn molecules() -> impl Strategy<Value = Vec<Atom>> {
        prop::collection::vec((-1.0..1.0, -1.0..1.0, 0.01..0.5, 0.1..10.0), 1..8).prop_map(|list| {
            let atom = |(x, y, r, m)| Atom::new(DVec2::new(x, y), r, m).unwrap();
            list.into_iter().map(atom).collect()
        })
    }

    proptest! {
        #[test]
        fn mass_centre_and_inertia_agree_with_parry(atoms in molecules()) {
            let molecule = Molecule::new(atoms.clone()).unwrap();
            let oracle: MassProperties = atoms
                .iter()
                .map(|atom| {
                    let density = atom.mass() / (std::f64::consts::PI * atom.radius().powi(2));
                    MassProperties::from_ball(density, atom.radius())
                        .transform_by(&Pose::from_translation(atom.offset()))
                })
                .sum();
            prop_assert!((molecule.mass() - oracle.mass()).abs() < 1e-12 * molecule.mass());
            let inertia = oracle.principal_inertia();
            prop_assert!((molecule.moment_of_inertia() - inertia).abs() < 1e-10 * inertia);
            let centre = atoms[0].offset() - molecule.atoms()[0].offset();
            prop_assert!((centre - oracle.local_com).length() < 1e-12);
        }

        #[test]
        fn bounding_circle_holds_every_atom_and_touches_one(atoms in molecules()) {
            let molecule = Molecule::new(atoms).unwrap();
            let farthest = molecule
                .atoms()
                .iter()
                .map(|atom| atom.offset().length() + atom.radius())
                .fold(0.0, f64::max);
            prop_assert!(molecule.bounding_radius() >= farthest);
            prop_assert!(molecule.bounding_radius() <= farthest * (1.0 + 8.0 * f64::EPSILON));
        }

        #[test]
        fn compound_has_the_same_atoms(atoms in molecules()) {
            let molecule = Molecule::new(atoms).unwrap();
            let compound = Compound::from(&molecule);
            prop_assert_eq!(compound.shapes().len(), molecule.atoms().len());
            for ((pose, ball), atom) in compound.shapes().iter().zip(molecule.atoms()) {
                prop_assert_eq!(pose.translation, atom.offset());
                prop_assert_eq!(ball.as_ball().unwrap().radius, atom.radius());
            }
        }
    }

    proptest! {
        /// Atoms centred once and centred again differ by a rounding; what was written down must not.
        #[test]
        fn written_down_and_read_again_it_is_the_same_to_the_bit(atoms in molecules()) {
            let molecule = Molecule::new(atoms).unwrap();
            let again = Molecule::try_from(CentredAtoms::from(molecule.clone())).unwrap();
            prop_assert_eq!(format!("{:?}", again), format!("{:?}", molecule));
        }
    }

    #[test]
    fn empty_and_coincident_are_refused() {
        assert_eq!(Molecule::new([]).unwrap_err(), GeometryError::NoAtoms);
        let atom = Atom::new(DVec2::ONE, 0.1, 1.0).unwrap();
        let refused = Molecule::new([atom, atom]).unwrap_err();
        assert_eq!(refused, GeometryError::CoincidentAtoms { first: 0, second: 1 });
    }

    #[test]
    fn numbers_that_are_no_lengths_are_refused() {
        for bad in [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e61, 1e-61] {
            assert!(Molecule::disc(bad, 1.0).is_err(), "radius {bad}");
            assert!(Molecule::disc(1.0, bad).is_err(), "mass {bad}");
        }
        assert!(Atom::new(DVec2::new(f64::NAN, 0.0), 1.0, 1.0).is_err());
    }
}
