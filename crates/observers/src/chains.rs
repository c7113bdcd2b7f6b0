//! Chains: sets of bodies that bonds connect, walked from neighbour to neighbour. A fixed body
//! anchors those that are tied to it and connects none.

use carom_engine::{BodyView, View};
use glam::DVec2;

use crate::Group;

/// One chain.
pub(crate) struct Chain {
    /// Index of its first body among those of the view: the earliest of its ends, or of all its
    /// bodies where it has none.
    pub(crate) first: usize,
    /// The centres of its bodies along its bonds, from that of the first in the box on (length). In
    /// a chain without branches they are in its order.
    pub(crate) places: Vec<DVec2>,
    /// Σ of the squared distances of neighbours (length²).
    pub(crate) steps: f64,
    /// Distances of the tied points of its bonds (length).
    pub(crate) lengths: Vec<f64>,
    /// Index of the body reached last: in a chain without branches its other end.
    pub(crate) last: usize,
    /// Whether it has two ends and no branch.
    pub(crate) is_linear: bool,
}

/// The chains of a view whose first body belongs to a group.
pub(crate) fn chains_of(view: &View<'_>, bodies: &[BodyView<'_>], group: Group) -> Vec<Chain> {
    let mut neighbours = vec![Vec::new(); bodies.len()];
    let mut lengths = vec![Vec::new(); bodies.len()];
    for bond in view.bonds() {
        let [a, b] = bond.bond.bodies.map(|body| body as usize);
        let is_anchor = [a, b].map(|body| bodies[body].body.is_fixed());
        lengths[if is_anchor[0] { b } else { a }].push(bond.length);
        if is_anchor == [false; 2] {
            neighbours[a].push(b);
            neighbours[b].push(a);
        }
    }
    for list in &mut neighbours {
        // Two bodies may have several bonds.
        list.sort_unstable();
        list.dedup();
    }
    let mut walk = Walk {
        visited: vec![false; bodies.len()],
        bodies,
        neighbours,
        lengths,
    };
    let ends = (0..bodies.len()).filter(|&body| walk.neighbours[body].len() == 1);
    let ends: Vec<usize> = ends.collect();
    let mut chains = Vec::new();
    for first in ends.into_iter().chain(0..bodies.len()) {
        if !walk.visited[first] && !walk.neighbours[first].is_empty() {
            let chain = walk.chain(view, first);
            if group.contains(bodies[first].body) {
                chains.push(chain);
            }
        }
    }
    chains
}

/// The bodies that chains have not reached yet.
struct Walk<'a> {
    visited: Vec<bool>,
    bodies: &'a [BodyView<'a>],
    neighbours: Vec<Vec<usize>>,
    /// Lengths of bonds, each at one of its bodies.
    lengths: Vec<Vec<f64>>,
}

impl Walk<'_> {
    fn chain(&mut self, view: &View<'_>, first: usize) -> Chain {
        let bounds = view.bounds();
        let mut chain = Chain {
            first,
            places: Vec::new(),
            steps: 0.0,
            lengths: Vec::new(),
            last: first,
            is_linear: true,
        };
        let mut ends = 0;
        self.visited[first] = true;
        let mut open = vec![(first, self.bodies[first].motion.position)];
        while let Some((body, place)) = open.pop() {
            chain.places.push(place);
            chain.last = body;
            chain.lengths.append(&mut self.lengths[body]);
            ends += usize::from(self.neighbours[body].len() == 1);
            chain.is_linear &= self.neighbours[body].len() <= 2;
            for &next in &self.neighbours[body] {
                let apart = self.bodies[next].motion.position - self.bodies[body].motion.position;
                let step = bounds.nearest_image(apart);
                // Two neighbours are seen from both.
                chain.steps += 0.5 * step.length_squared();
                if !self.visited[next] {
                    self.visited[next] = true;
                    open.push((next, place + step));
                }
            }
        }
        chain.is_linear &= ends == 2;
        chain
    }
}

impl Chain {
    /// The places of both ends; `None` for a ring or a star.
    pub(crate) fn ends(&self) -> Option<[DVec2; 2]> {
        let ends = [*self.places.first()?, *self.places.last()?];
        self.is_linear.then_some(ends)
    }

    /// The mean of the places (length).
    pub(crate) fn middle(&self) -> DVec2 {
        self.places.iter().sum::<DVec2>() / self.places.len() as f64
    }

    /// The eigenvalues of the tensor of gyration (length²), the larger first.
    pub(crate) fn gyration(&self) -> [f64; 2] {
        let (count, middle) = (self.places.len() as f64, self.middle());
        let [mut xx, mut xy, mut yy] = [0.0; 3];
        for place in &self.places {
            let DVec2 { x, y } = *place - middle;
            (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
        }
        let (mean, half) = (0.5 * (xx + yy) / count, 0.5 * (xx - yy) / count);
        let apart = half.hypot(xy / count);
        [mean + apart, mean - apart]
    }
}
