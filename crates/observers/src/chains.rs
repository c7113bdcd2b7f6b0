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
    /// The mean squared radius of gyration of chains with bonds of these lengths and independent
    /// directions (length²); `None` for a chain with a ring.
    pub(crate) independent_gyration: Option<f64>,
}

/// How a body is tied to the chain that was walked before it.
struct Link {
    /// Number of the neighbour from which the body was reached, in the order of the places.
    parent: usize,
    /// Squared distance from that neighbour (length²).
    squared: f64,
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
            independent_gyration: None,
        };
        let (mut ends, mut neighbours) = (0, 0);
        let mut links = Vec::new();
        self.visited[first] = true;
        let start = Link {
            parent: 0,
            squared: 0.0,
        };
        let mut open = vec![(first, self.bodies[first].motion.position, start)];
        while let Some((body, place, link)) = open.pop() {
            let number = links.len();
            chain.places.push(place);
            links.push(link);
            chain.last = body;
            chain.lengths.append(&mut self.lengths[body]);
            ends += usize::from(self.neighbours[body].len() == 1);
            neighbours += self.neighbours[body].len();
            chain.is_linear &= self.neighbours[body].len() <= 2;
            for &next in &self.neighbours[body] {
                let apart = self.bodies[next].motion.position - self.bodies[body].motion.position;
                let step = bounds.nearest_image(apart);
                let squared = step.length_squared();
                // Two neighbours are seen from both.
                chain.steps += 0.5 * squared;
                if !self.visited[next] {
                    self.visited[next] = true;
                    let parent = number;
                    open.push((next, place + step, Link { parent, squared }));
                }
            }
        }
        let is_tree = neighbours == 2 * (links.len() - 1);
        chain.independent_gyration = is_tree.then(|| independent_gyration(&links));
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

    /// The components S_xx, S_xy and S_yy of the tensor of gyration (length²).
    pub(crate) fn gyration_tensor(&self) -> [f64; 3] {
        let (count, middle) = (self.places.len() as f64, self.middle());
        let [mut xx, mut xy, mut yy] = [0.0; 3];
        for place in &self.places {
            let DVec2 { x, y } = *place - middle;
            (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
        }
        [xx / count, xy / count, yy / count]
    }
}

/// The eigenvalues of a symmetric tensor of components xx, xy and yy, the larger first.
pub(crate) fn eigenvalues([xx, xy, yy]: [f64; 3]) -> [f64; 2] {
    let (mean, apart) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
    [mean + apart, mean - apart]
}

/// Mean squared radius of gyration of a tree whose bonds have independent directions:
/// Σ n (N − n) b²/N² over its bonds, each of which leaves n of the N bodies on one side (Kramers,
/// J. Chem. Phys. 14 (1946) 415). For equal bonds in a row it is (N² − 1) b²/6N.
fn independent_gyration(links: &[Link]) -> f64 {
    let count = links.len() as f64;
    let mut beyond = vec![1.0; links.len()];
    let mut sum = 0.0;
    // A body comes after its parent.
    for (number, link) in links.iter().enumerate().skip(1).rev() {
        let bodies = beyond[number];
        beyond[link.parent] += bodies;
        sum += bodies * (count - bodies) * link.squared;
    }
    sum / (count * count)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::test_scenes::random_points;

    /// Chains of `members` points with bonds of Gaussian components of variance 1.
    fn gaussian_chains(count: usize, members: usize) -> Vec<Chain> {
        let points = random_points(count * (members - 1), [1.0; 2], 5).bumper;
        // The transform of Box and Muller (Ann. Math. Stat. 29 (1958) 610).
        let bonds = points.iter().map(|point| {
            let [uniform, turn] = point.at;
            let length = (-2.0 * libm::log(1.0 - uniform)).sqrt();
            length * DVec2::new(libm::cos(TAU * turn), libm::sin(TAU * turn))
        });
        let bonds: Vec<DVec2> = bonds.collect();
        let chain = |bonds: &[DVec2]| {
            let mut places = vec![DVec2::ZERO];
            for bond in bonds {
                places.push(places[places.len() - 1] + *bond);
            }
            Chain {
                first: 0,
                places,
                steps: 0.0,
                lengths: vec![],
                last: 0,
                is_linear: true,
                independent_gyration: None,
            }
        };
        bonds.chunks(members - 1).map(chain).collect()
    }

    /// The eigenvalues of the matrix of a Gaussian chain are 1/(4 N sin²(kπ/2N)), k = 1 … N − 1.
    /// With the ratio q of the sum of their squares to the square of their sum,
    /// (2N² + 7)/(5 (N² − 1)), the asphericity is 2q/(1 + q) by Wick's theorem.
    #[test]
    fn gaussian_chains_have_their_radius_of_gyration_and_asphericity() {
        for members in [2_u32, 4, 8] {
            let chains = gaussian_chains(20_000, members as usize);
            let (mut squared, mut shape) = (0.0, [0.0; 2]);
            for chain in &chains {
                let [larger, smaller] = eigenvalues(chain.gyration_tensor());
                squared += (larger + smaller) / chains.len() as f64;
                shape[0] += (larger - smaller).powi(2);
                shape[1] += (larger + smaller).powi(2);
            }
            let square = f64::from(members * members);
            let expected = 2.0 * (square - 1.0) / (6.0 * f64::from(members));
            // Five standard errors: Rg² varies by at most its mean from chain to chain.
            let tolerance = 5.0 / (chains.len() as f64).sqrt();
            assert!(
                (squared / expected - 1.0).abs() < tolerance,
                "{members} {squared}"
            );
            let ratio = (2.0 * square + 7.0) / (5.0 * (square - 1.0));
            let asphericity = 2.0 * ratio / (1.0 + ratio);
            let found = shape[0] / shape[1];
            assert!(
                (found - asphericity).abs() < 0.02,
                "{members} {found} {asphericity}"
            );
        }
    }

    #[test]
    fn equal_bonds_in_a_row_have_the_radius_of_gyration_of_independent_bonds() {
        for members in 2..20 {
            let link = |number: usize| Link {
                parent: number.saturating_sub(1),
                squared: 0.3,
            };
            let links: Vec<Link> = (0..members).map(link).collect();
            let count = members as f64;
            let expected = 0.3 * (count * count - 1.0) / (6.0 * count);
            assert!((independent_gyration(&links) / expected - 1.0).abs() < 1e-12);
        }
    }
}
