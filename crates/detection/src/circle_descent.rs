//! Searches molecules of many atoms by descending the trees of circles of both, where circles come
//! near each other.

use carom_geometry::{Circle, CircleTree, Node, Outline};
use smallvec::SmallVec;

use crate::{
    Parts, Phase, SearchWindow,
    atom_block::{Atoms, BlockSearch},
    atom_pair::AtomPair,
    flight::bounding_circle,
    search::Search,
    tolerance::NEARNESS,
    trace::Recorder,
};

/// Indices of the atoms of a molecule without a tree, which is a single block.
const ALL: [u32; CircleTree::CROSSOVER] = {
    let mut indices = [0; CircleTree::CROSSOVER];
    let mut index = 0;
    while index < CircleTree::CROSSOVER {
        indices[index] = index as u32;
        index += 1;
    }
    indices
};

/// A body as a tree of circles, possibly of a single node.
#[derive(Clone, Copy)]
pub(crate) struct DescentBody<'a> {
    outline: &'a Outline<'a>,
}

/// A node of the tree of a body.
#[derive(Clone, Copy)]
enum Place<'a> {
    Whole(Circle),
    InTree(&'a CircleTree, &'a Node),
}

impl<'a> DescentBody<'a> {
    pub(crate) fn new(outline: &'a Outline<'a>) -> Self {
        Self { outline }
    }

    fn root(self) -> Place<'a> {
        match self.outline.tree() {
            Some(tree) => Place::InTree(tree, tree.root()),
            None => Place::Whole(bounding_circle(*self.outline)),
        }
    }

    /// The atoms of a body that has no tree.
    pub(crate) fn only_block(self) -> Option<Atoms<'a>> {
        self.outline
            .tree()
            .is_none()
            .then(|| self.block(&ALL[..self.outline.atoms.len()]))
    }

    fn block(self, indices: &'a [u32]) -> Atoms<'a> {
        Atoms {
            all: self.outline.atoms,
            indices,
        }
    }

    fn atoms(self, place: Place<'a>) -> Atoms<'a> {
        match place {
            Place::Whole(_) => self.block(&ALL[..self.outline.atoms.len()]),
            Place::InTree(tree, node) => self.block(tree.atoms_of(node)),
        }
    }
}

impl Place<'_> {
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

/// Two nodes whose atoms do not touch before `bound` (time).
#[derive(Clone, Copy)]
struct Task<'a> {
    bound: f64,
    places: [Place<'a>; 2],
}

/// Searches the trees depth first, the children with the earlier bound first. Children lie in their
/// parent, so their search begins at the time up to which the parents are certified.
///
/// The node to split depends on the radii only (the larger one, both if they are equal), so
/// exchanging A and B does not change the answer. There are at most as many tasks as pairs of
/// nodes. Each ends after a bounded number of steps, because nodes that reach their step limit are
/// split as well.
pub(crate) fn descend<R: Recorder>(
    blocks: &BlockSearch<'_>,
    bodies: [DescentBody<'_>; 2],
    begin: f64,
    search: &mut Search<R>,
) {
    let atoms_in = |places: [Place<'_>; 2]| {
        Parts::Circles([0, 1].map(|body| bodies[body].atoms(places[body]).indices.to_vec()))
    };
    let mut stack: SmallVec<[Task<'_>; 64]> = SmallVec::new();
    stack.push(Task {
        bound: begin,
        places: bodies.map(DescentBody::root),
    });
    while let Some(Task { bound, places }) = stack.pop() {
        let limit = search.limit();
        if bound > limit {
            continue;
        }
        let parts = split(places);
        let pair = AtomPair::new(blocks.flight, places.map(Place::circle));
        let window = SearchWindow {
            begin: bound,
            end: limit,
        };
        search.recorder.concerns(|| atoms_in(places));
        let Some(at) = pair.approach(window, NEARNESS, search) else {
            continue;
        };
        let Some(parts) = parts else {
            blocks.search(
                bodies[0].atoms(places[0]),
                bodies[1].atoms(places[1]),
                at.time,
                search,
            );
            continue;
        };
        let first = stack.len();
        for places in parts {
            let bound = AtomPair::new(blocks.flight, places.map(Place::circle))
                .contact_time_lower_bounds(&at);
            search.evaluations += 1;
            search.recorder.concerns(|| atoms_in(places));
            search.recorder.step(Phase::Circles, at.time, Some(bound));
            if bound <= limit {
                stack.push(Task { bound, places });
            }
        }
        // The last task is taken first.
        stack[first..].sort_by(|one, other| other.bound.total_cmp(&one.bound));
    }
}

/// The pairs of children of two nodes; `None` if both are leaves.
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
        (Some([first, second]), Some(parts)) => with_b(first, parts)
            .into_iter()
            .chain(with_b(second, parts))
            .collect(),
    })
}

#[cfg(test)]
mod tests {
    use crate::{Answer, Contact, Detection, Exact};
    use carom_geometry::{Atom, Molecule, Shape};
    use carom_kinematics::{Orientation, RelativeMotion};
    use glam::DVec2;
    use proptest::{prelude::*, strategy::ValueTree, test_runner::TestRunner};

    /// The earliest contact of all atom pairs, each searched separately.
    fn all_pairs(
        a: &Molecule,
        b: &Molecule,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Option<Contact> {
        let mut earliest: Option<Contact> = None;
        for i in a.atoms() {
            for j in b.atoms() {
                let limit = earliest.map_or(horizon, |contact| contact.time);
                let answer =
                    Exact::default().first_contact(i.outline(), j.outline(), motion, limit);
                if let Some(contact) = answer.outcome.contact() {
                    earliest = Some(contact);
                }
            }
        }
        earliest
    }

    fn blob(count: usize, places: &[(f64, f64)]) -> Molecule {
        let side = f64::sqrt(count as f64);
        let atom = |&(x, y): &(f64, f64)| Atom::new(side * DVec2::new(x, y), 0.5, 1.0).unwrap();
        Molecule::new(places[..count].iter().map(atom)).unwrap()
    }

    type Encounter = (Vec<(f64, f64)>, [f64; 2], [f64; 2], (f64, f64));

    fn encounters() -> impl Strategy<Value = Encounter> {
        (
            prop::collection::vec((-0.7..0.7f64, -0.7..0.7f64), 256),
            prop::array::uniform2(-0.5..0.5f64),
            prop::array::uniform2(-3.0..3.0f64),
            (1.05..2.5f64, -1.0..1.0f64),
        )
    }

    #[test]
    fn trees_give_the_answers_of_all_pairs() {
        let mut runner = TestRunner::deterministic();
        let [mut hits, mut misses] = [0, 0];
        for (count, cases) in [
            (2, 40),
            (5, 40),
            (6, 60),
            (9, 60),
            (16, 40),
            (33, 30),
            (64, 20),
            (128, 10),
            (256, 6),
        ] {
            for case in 0..cases {
                let (places, turns, spins, (ahead, aside)) =
                    encounters().new_tree(&mut runner).unwrap().current();
                let rod = Molecule::named(Shape::Rod(count), 0.5, 1.0).unwrap();
                let (a, b) = if case % 2 == 0 {
                    (rod.clone(), rod)
                } else {
                    (blob(count, &places), rod)
                };
                let b = if case % 5 == 0 {
                    Molecule::disc(0.5, 1.0).unwrap()
                } else {
                    b
                };
                let reach = a.bounding_radius() + b.bounding_radius();
                let motion = RelativeMotion {
                    orientation: turns.map(Orientation::from_turns),
                    angular_velocity: spins.map(|spin| spin / reach),
                    ..RelativeMotion::exactly(
                        reach * DVec2::new(ahead, aside),
                        DVec2::new(-1.0, 0.0),
                    )
                };
                let answer: Answer =
                    Exact::default().first_contact(a.outline(), b.outline(), &motion, 1e9);
                let found = answer.outcome.contact().map(|contact| contact.time);
                match (found, all_pairs(&a, &b, &motion, 1e9)) {
                    (Some(tree), Some(all)) => {
                        hits += 1;
                        assert!(
                            (tree - all.time).abs() <= 1e-11 * reach,
                            "{count}: {tree} against {all:?}"
                        );
                    }
                    (None, None) => misses += 1,
                    (tree, all) => panic!("{count} atoms: {tree:?} against {all:?}"),
                }
                assert!(answer.evaluations < 4000, "{count}: {answer:?}");
            }
        }
        assert!(hits > 100 && misses > 30, "{hits} hits, {misses} misses");
    }
}
