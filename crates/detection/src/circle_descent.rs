//! Molecules of many atoms: down the trees of circles of both, as far as circles come near each other.

use carom_geometry::{Circle, CircleTree, Node, Outline};
use smallvec::SmallVec;

use crate::{
    Window,
    atom_block::{Atoms, BlockSearch},
    atom_pair::AtomPair,
    flight::{Flight, bounding_circle},
    search::Search,
    tolerance::NEARNESS,
};

/// Indices of the atoms of molecules that have no tree: they are one block.
const ALL: [u32; CircleTree::CROSSOVER] = {
    let mut indices = [0; CircleTree::CROSSOVER];
    let mut index = 0;
    while index < CircleTree::CROSSOVER {
        indices[index] = index as u32;
        index += 1;
    }
    indices
};

/// A body as a tree of circles, be it of a single one.
#[derive(Clone, Copy)]
pub(crate) struct Body<'a> {
    outline: Outline<'a>,
}

/// A node of such a tree.
#[derive(Clone, Copy)]
enum Place<'a> {
    Whole(Circle),
    InTree(&'a CircleTree, &'a Node),
}

impl<'a> Body<'a> {
    pub(crate) fn new(outline: Outline<'a>) -> Self {
        Self { outline }
    }

    fn root(self) -> Place<'a> {
        match self.outline.tree() {
            Some(tree) => Place::InTree(tree, tree.root()),
            None => Place::Whole(bounding_circle(self.outline)),
        }
    }

    /// The atoms of a body that has no tree.
    pub(crate) fn only_block(self) -> Option<Atoms<'a>> {
        self.outline.tree().is_none().then(|| self.block(&ALL[..self.outline.atoms.len()]))
    }

    fn block(self, indices: &'a [u32]) -> Atoms<'a> {
        Atoms { all: self.outline.atoms, indices }
    }

    fn atoms(self, place: Place<'a>) -> Atoms<'a> {
        match place {
            Place::Whole(_) => self.block(&ALL[..self.outline.atoms.len()]),
            Place::InTree(tree, node) => self.block(tree.atoms_of(node)),
        }
    }
}

impl<'a> Place<'a> {
    fn circle(self) -> Circle {
        match self {
            Self::Whole(circle) => circle,
            Self::InTree(_, node) => node.circle,
        }
    }

    fn children(self) -> Option<[Self; 2]> {
        match self {
            Self::InTree(tree, node) => node
                .children
                .map(|first| [first, first + 1].map(|child| Self::InTree(tree, tree.node(child)))),
            Self::Whole(_) => None,
        }
    }
}

/// Two nodes whose atoms do not touch before `bound`.
#[derive(Clone, Copy)]
struct Task<'a> {
    bound: f64,
    places: [Place<'a>; 2],
}

/// Depth first, the sooner children first. Children lie in their parent, so they begin where it ends.
///
/// Which circle is split depends on their radii only (the larger, both of equal ones), so the argument order does
/// not matter. There are at most as many tasks as pairs of nodes, and each ends after a bounded number of
/// steps, because nodes that have used theirs up are split as well.
pub(crate) fn descend(
    blocks: &BlockSearch<'_>,
    flight: &Flight<'_>,
    bodies: [Body<'_>; 2],
    begin: f64,
    search: &mut Search,
) {
    let mut stack: SmallVec<[Task<'_>; 64]> = SmallVec::new();
    stack.push(Task { bound: begin, places: bodies.map(Body::root) });
    while let Some(Task { bound, places }) = stack.pop() {
        let limit = search.limit();
        if bound > limit {
            continue;
        }
        let parts = split(places);
        let pair = AtomPair::new(flight, places.map(Place::circle));
        let window = Window { begin: bound, end: limit };
        let Some(at) = pair.approach(window, NEARNESS, search.most_steps, &mut search.evaluations) else {
            continue;
        };
        let Some(parts) = parts else {
            blocks.search(bodies[0].atoms(places[0]), bodies[1].atoms(places[1]), at.time, search);
            continue;
        };
        let first = stack.len();
        for places in parts {
            let bound = AtomPair::new(flight, places.map(Place::circle)).apart_until(&at);
            search.evaluations += 1;
            if bound <= limit {
                stack.push(Task { bound, places });
            }
        }
        // The last is taken first.
        stack[first..].sort_by(|one, other| other.bound.total_cmp(&one.bound));
    }
}

/// The pairs of parts of two nodes, or nothing if both are blocks.
fn split<'a>([a, b]: [Place<'a>; 2]) -> Option<SmallVec<[[Place<'a>; 2]; 4]>> {
    let (radius_a, radius_b) = (a.circle().radius, b.circle().radius);
    let with_a = |b: Place<'a>, parts: [Place<'a>; 2]| parts.map(|part| [part, b]);
    let with_b = |a: Place<'a>, parts: [Place<'a>; 2]| parts.map(|part| [a, part]);
    Some(match (a.children(), b.children()) {
        (None, None) => return None,
        (Some(parts), None) => SmallVec::from_slice(&with_a(b, parts)),
        (None, Some(parts)) => SmallVec::from_slice(&with_b(a, parts)),
        (Some(parts), Some(_)) if radius_a > radius_b => SmallVec::from_slice(&with_a(b, parts)),
        (Some(_), Some(parts)) if radius_b > radius_a => SmallVec::from_slice(&with_b(a, parts)),
        (Some([first, second]), Some(parts)) => {
            with_b(first, parts).into_iter().chain(with_b(second, parts)).collect()
        }
    })
}
