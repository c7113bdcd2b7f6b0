//! The part of a shape that detection needs.

use glam::DVec2;

use crate::{Atom, AtomRow, CircleTree, Edge, Ellipse, HalfPlane, atom::reach, hull::HullSide};

/// The part of a shape that detection needs: its atoms and edges, and what contains them.
#[derive(Debug, Clone, Copy)]
pub struct Outline<'a> {
    /// The atoms, relative to the centre of mass.
    pub atoms: &'a [Atom],
    /// Radius of the smallest circle about the centre of mass that contains all atoms (length).
    pub bounding_radius: f64,
    pub(crate) rectangle: Option<&'a [DVec2; 2]>,
    pub(crate) rows: &'a [AtomRow],
    pub(crate) tree: Option<&'a CircleTree>,
    pub(crate) edges: &'a [Edge],
    pub(crate) ellipses: &'a [Ellipse],
    pub(crate) is_wall: bool,
    pub(crate) sides: &'a [HullSide],
}

impl<'a> Outline<'a> {
    /// The tree of circles over the atoms; `None` for molecules of at most
    /// [`CircleTree::CROSSOVER`] atoms.
    pub fn tree(&self) -> Option<&'a CircleTree> {
        self.tree
    }

    /// Lower left and upper right corner of the axis-parallel rectangle that contains all atoms
    /// (length), to rounding; `None` for a single disc and for walls.
    pub fn rectangle(&self) -> Option<[DVec2; 2]> {
        self.rectangle.copied()
    }

    /// The atoms in rows, for molecules of two to [`CircleTree::CROSSOVER`] atoms without edges;
    /// empty for others.
    pub fn rows(&self) -> &'a [AtomRow] {
        self.rows
    }

    /// The edges.
    #[inline]
    pub fn edges(&self) -> &'a [Edge] {
        self.edges
    }

    /// The shapes of the atoms, one for each, if any is an ellipse; empty for a union of discs.
    #[inline]
    pub fn ellipses(&self) -> &'a [Ellipse] {
        self.ellipses
    }

    /// The shape of an atom: an ellipse, of equal axes if it is a disc.
    ///
    /// # Panics
    /// If the body has no such atom.
    pub fn shape_of(&self, atom: usize) -> Ellipse {
        match self.ellipses.get(atom) {
            Some(ellipse) => *ellipse,
            None => Ellipse::round(self.atoms[atom].radius()),
        }
    }

    /// Whether there are ellipses or arcs.
    pub fn has_curves(&self) -> bool {
        !self.ellipses.is_empty() || self.edges.iter().any(|edge| edge.bend().is_some())
    }

    /// Whether there are parts other than discs: edges or ellipses.
    #[inline]
    pub fn has_other_parts(&self) -> bool {
        self.edges.len() + self.ellipses.len() > 0
    }

    /// The sides of the convex hull of a body with edges; empty for walls and unions of discs.
    pub fn sides(&self) -> &'a [HullSide] {
        self.sides
    }

    /// Whether this is a wall or a half-plane: a single edge through the origin, of any length,
    /// whose ends are as thick as itself.
    pub fn is_wall(&self) -> bool {
        self.is_wall
    }
}

impl Atom {
    /// The outline of this atom as a whole body, as detection needs it.
    pub fn outline(&self) -> Outline<'_> {
        Outline {
            atoms: std::slice::from_ref(self),
            bounding_radius: reach(self),
            rectangle: None,
            rows: &[],
            tree: None,
            edges: &[],
            ellipses: &[],
            is_wall: false,
            sides: &[],
        }
    }
}

impl HalfPlane {
    /// Its outline, as detection needs it: an edge without atoms, with an infinite bounding radius.
    pub fn outline(&self) -> Outline<'_> {
        Outline {
            atoms: &[],
            bounding_radius: f64::INFINITY,
            rectangle: None,
            rows: &[],
            tree: None,
            edges: std::slice::from_ref(&self.border),
            ellipses: &[],
            is_wall: true,
            sides: &[],
        }
    }
}
