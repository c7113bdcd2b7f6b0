//! A tree of circles over the atoms of a molecule; each circle contains those below it.

use glam::DVec2;

use crate::Atom;

/// The most atoms in one block, a leaf of the tree.
///
/// Two blocks are compared atom by atom in one pass, which costs less than further descent as long
/// as they are small. Molecules of up to [`CircleTree::CROSSOVER`] atoms are one block.
const BLOCK: usize = 4;

/// A circle in the frame of a molecule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Position of its centre (length).
    pub offset: DVec2,
    /// Distance of its centre from the origin of the frame, never rounded down (length).
    pub arm: f64,
    /// Radius, never rounded down (length).
    pub radius: f64,
}

/// A node of the tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// A circle that contains every atom of the node, rounding included.
    pub circle: Circle,
    /// Index of the first of its two children, which are adjacent; `None` for a block.
    pub children: Option<u32>,
    first: u32,
    count: u32,
}

/// A binary tree of circles over the atoms of one molecule.
///
/// Splitting by the median along the longer side of the rectangle of centres gives log₂ N levels.
/// From level to level the circles shrink by a factor of 2 for a rod and of √2 for a compact
/// molecule.
///
/// ```
/// use carom_geometry::{Molecule, Shape};
///
/// let rod = Molecule::named(Shape::Rod(50), 0.5, 1.0)?;
/// let tree = rod.outline().tree().expect("fifty atoms are worth a tree");
/// assert_eq!(tree.root().circle.radius, rod.bounding_radius());
/// assert!(Molecule::named(Shape::Dumbbell, 0.5, 1.0)?.outline().tree().is_none());
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[doc(alias = "bounding volume hierarchy")]
pub struct CircleTree {
    nodes: Vec<Node>,
    /// Indices of the atoms, block by block.
    order: Vec<u32>,
}

impl CircleTree {
    /// Molecules of more atoms than this have a tree; for others, comparing all atom pairs of two
    /// molecules in one pass costs less.
    pub const CROSSOVER: usize = 5;

    pub(crate) fn new(atoms: &[Atom], bounding_radius: f64) -> Self {
        let mut order: Vec<u32> = (0..atoms.len() as u32).collect();
        let whole = Circle {
            offset: DVec2::ZERO,
            arm: 0.0,
            radius: bounding_radius,
        };
        let root = Node {
            circle: whole,
            children: None,
            first: 0,
            count: atoms.len() as u32,
        };
        let mut nodes = vec![root];
        let mut next = 0;
        while next < nodes.len() {
            let node = nodes[next];
            if node.count as usize > BLOCK {
                nodes[next].children = Some(nodes.len() as u32);
                nodes.extend(halves(atoms, &mut order, node));
            }
            next += 1;
        }
        Self { nodes, order }
    }

    /// The circle about the centre of mass that contains the whole molecule.
    pub fn root(&self) -> &Node {
        &self.nodes[0]
    }

    /// The node with this index; the root has index 0.
    pub fn node(&self, index: u32) -> &Node {
        &self.nodes[index as usize]
    }

    /// Indices of the atoms of a node, into [`Outline::atoms`](crate::Outline).
    pub fn atoms_of(&self, node: &Node) -> &[u32] {
        &self.order[node.first as usize..(node.first + node.count) as usize]
    }
}

/// Splits the atoms of a node at their median along the longer side of the rectangle of their
/// centres.
fn halves(atoms: &[Atom], order: &mut [u32], node: Node) -> [Node; 2] {
    let (first, count) = (node.first as usize, node.count as usize);
    let mine = &mut order[first..first + count];
    let offset = |index: u32| atoms[index as usize].offset();
    let low = mine
        .iter()
        .fold(DVec2::INFINITY, |low, &index| low.min(offset(index)));
    let high = mine
        .iter()
        .fold(DVec2::NEG_INFINITY, |high, &index| high.max(offset(index)));
    let axis = usize::from(high.y - low.y > high.x - low.x);
    let key = |index: u32| offset(index)[axis];
    let half = count / 2;
    mine.select_nth_unstable_by(half, |&i, &j| key(i).total_cmp(&key(j)).then(i.cmp(&j)));
    let part = |range: std::ops::Range<usize>| Node {
        circle: enclosing_circle(atoms, &mine[range.clone()]),
        children: None,
        first: (first + range.start) as u32,
        count: range.len() as u32,
    };
    [part(0..half), part(half..count)]
}

/// The circle about the centre of the rectangle that contains the atoms.
fn enclosing_circle(atoms: &[Atom], indices: &[u32]) -> Circle {
    if let [only] = indices {
        return Circle::from(&atoms[*only as usize]);
    }
    let mine = || indices.iter().map(|&index| &atoms[index as usize]);
    let low = mine().fold(DVec2::INFINITY, |low, atom| {
        low.min(atom.offset() - atom.radius())
    });
    let high = mine().fold(DVec2::NEG_INFINITY, |high, atom| {
        high.max(atom.offset() + atom.radius())
    });
    let offset = 0.5 * low + 0.5 * high;
    let reach = mine()
        .map(|atom| (atom.offset() - offset).length() + atom.radius())
        .fold(0.0, f64::max);
    // Three roundings in the length, one in the sum, and one in the difference of offsets.
    let round_up = 1.0 + 8.0 * f64::EPSILON;
    Circle {
        offset,
        arm: offset.length() * round_up,
        radius: reach * round_up,
    }
}

impl From<&Atom> for Circle {
    fn from(atom: &Atom) -> Self {
        Self {
            offset: atom.offset(),
            arm: atom.arm(),
            radius: atom.radius(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Molecule;
    use proptest::prelude::*;

    fn blobs() -> impl Strategy<Value = Molecule> {
        let atom = (-9.0..9.0, -9.0..9.0, 0.01..0.9);
        prop::collection::vec(atom, CircleTree::CROSSOVER + 1..90).prop_map(|list| {
            let atoms = list
                .into_iter()
                .map(|(x, y, r)| Atom::new(DVec2::new(x, y), r, 1.0).unwrap());
            Molecule::new(atoms).unwrap()
        })
    }

    proptest! {
        #[test]
        fn every_circle_holds_its_atoms_and_every_atom_is_in_one_block(molecule in blobs()) {
            let tree = molecule.outline().tree().unwrap();
            let mut seen = vec![0; molecule.atoms().len()];
            for node in &tree.nodes {
                for &index in tree.atoms_of(node) {
                    let atom = &molecule.atoms()[index as usize];
                    let reach = (atom.offset() - node.circle.offset).length() + atom.radius();
                    prop_assert!(reach <= node.circle.radius);
                    seen[index as usize] += usize::from(node.children.is_none());
                }
                prop_assert!(node.children.is_some() || tree.atoms_of(node).len() <= BLOCK);
                prop_assert!(node.circle.arm >= node.circle.offset.length());
            }
            prop_assert!(seen.iter().all(|&count| count == 1));
        }

        #[test]
        fn children_partition_the_atoms_of_their_parent(molecule in blobs()) {
            let tree = molecule.outline().tree().unwrap();
            for node in &tree.nodes {
                let Some(first) = node.children else { continue };
                let parts = [tree.node(first), tree.node(first + 1)].map(|child| tree.atoms_of(child));
                prop_assert_eq!(parts.concat(), tree.atoms_of(node));
                prop_assert!(parts.iter().all(|part| !part.is_empty()));
            }
        }
    }

    #[test]
    fn circles_of_a_rod_halve_from_level_to_level() {
        let rod = Molecule::named(crate::Shape::Rod(64), 0.5, 1.0).unwrap();
        let tree = rod.outline().tree().unwrap();
        let (mut node, mut radius) = (tree.root(), 32.0);
        while let Some(first) = node.children {
            assert!((node.circle.radius - radius).abs() < 1e-12);
            (node, radius) = (tree.node(first), 0.5 * radius);
        }
        assert_eq!(tree.atoms_of(node).len(), BLOCK);
    }
}
