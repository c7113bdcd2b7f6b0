//! A body with straight edges as plain numbers.

use anyhow::Result;
use carom_geometry::{Atom, Interior, Molecule};
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// Atoms with straight edges between them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EdgedBody {
    /// Position x, y, radius and mass of each atom.
    pub atoms: Vec<[f64; 4]>,
    /// Atoms at the ends of each edge, from 0, and its radius.
    pub edges: Vec<(u32, u32, f64)>,
    /// Whether the body has what closed lines of edges enclose.
    pub interior: Interior,
    /// The mass, if it is spread evenly; else it is that of the atoms.
    pub uniform_mass: Option<f64>,
}

impl EdgedBody {
    /// The numbers of a molecule, all of whose edges have atoms at their ends.
    pub fn new(molecule: &Molecule) -> Self {
        let numbers = |atom: &Atom| [atom.offset().x, atom.offset().y, atom.radius(), atom.mass()];
        let edges = molecule.edges().iter().filter_map(|edge| {
            let [first, second] = edge.ends()?;
            Some((first, second, edge.radius()))
        });
        Self {
            atoms: molecule.atoms().iter().map(numbers).collect(),
            edges: edges.collect(),
            interior: molecule.interior(),
            uniform_mass: molecule.is_uniform().then_some(molecule.mass()),
        }
    }

    /// The molecule with all lengths multiplied by `factor`.
    ///
    /// # Errors
    /// The molecule is invalid.
    pub fn molecule(&self, factor: f64) -> Result<Molecule> {
        let atom = |&[x, y, radius, mass]: &[f64; 4]| {
            Atom::new(factor * DVec2::new(x, y), factor * radius, mass)
        };
        let atoms = self.atoms.iter().map(atom).collect::<Result<Vec<_>, _>>()?;
        let edge = |&(first, second, radius): &(u32, u32, f64)| ([first, second], factor * radius);
        let edges: Vec<_> = self.edges.iter().map(edge).collect();
        Ok(match self.uniform_mass {
            Some(mass) => Molecule::uniform(atoms, &edges, self.interior, mass)?,
            None => Molecule::with_edges(atoms, &edges, self.interior)?,
        })
    }

    /// All lengths of the body.
    pub fn lengths(&self) -> Vec<f64> {
        let atoms = self
            .atoms
            .iter()
            .flat_map(|&[x, y, radius, _]| [x, y, radius]);
        atoms.chain(self.edges.iter().map(|edge| edge.2)).collect()
    }

    /// Mutable references to all numbers.
    pub fn numbers_mut(&mut self) -> Vec<&mut f64> {
        let atoms = self.atoms.iter_mut().flatten();
        let edges = self.edges.iter_mut().map(|edge| &mut edge.2);
        atoms.chain(edges).chain(&mut self.uniform_mass).collect()
    }

    /// The body without one of its edges, for each edge, and without one of its atoms and the edges
    /// that end at it, for each atom.
    pub fn with_less(&self) -> Vec<Self> {
        let of_edges = without_each(&self.edges).map(|edges| Self {
            edges,
            ..self.clone()
        });
        let mut less: Vec<Self> = of_edges.collect();
        if self.atoms.len() > 1 {
            less.extend((0..self.atoms.len()).map(|index| self.without_atom(index)));
        }
        less
    }

    fn without_atom(&self, index: usize) -> Self {
        let mut less = self.clone();
        less.atoms.remove(index);
        let gone = index as u32;
        less.edges
            .retain(|&(first, second, _)| first != gone && second != gone);
        let moved = |end: u32| if end > gone { end - 1 } else { end };
        for edge in &mut less.edges {
            *edge = (moved(edge.0), moved(edge.1), edge.2);
        }
        less
    }
}

/// The list without one of its items, for each item.
pub fn without_each<T: Clone>(items: &[T]) -> impl Iterator<Item = Vec<T>> {
    (0..items.len()).map(|index| {
        let mut less = items.to_vec();
        less.remove(index);
        less
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> EdgedBody {
        let corners = [DVec2::ZERO, DVec2::X, DVec2::Y];
        EdgedBody::new(&Molecule::polygon(&corners, 0.1, 2.0).unwrap())
    }

    #[test]
    fn a_body_keeps_its_edges_and_its_even_mass() {
        let body = triangle();
        let molecule = body.molecule(1.0).unwrap();
        assert_eq!((molecule.edges().len(), molecule.mass()), (3, 2.0));
        assert!(molecule.is_uniform());
        let larger = body.molecule(1024.0).unwrap();
        assert_eq!(
            larger.atoms()[1].offset(),
            1024.0 * molecule.atoms()[1].offset()
        );
    }

    #[test]
    fn a_body_with_less_is_valid() {
        let less = triangle().with_less();
        assert_eq!(less.len(), 6);
        for body in less {
            assert!(body.molecule(1.0).is_ok(), "{body:?}");
        }
    }
}
