//! The shapes of chains: lengths of bonds, end-to-end distance, radius of gyration and asphericity.
//!
//! A chain is a set of bodies that bonds connect. Distances are those of the centres of mass, from
//! neighbour to neighbour through the border of the box. With the tensor of gyration of N bodies
//! S = Σ (r − r̄)(r − r̄)/N and its eigenvalues λ₁ ≥ λ₂, the squared radius of gyration is λ₁ + λ₂
//! and the asphericity in two dimensions ⟨(λ₁ − λ₂)²⟩/⟨(λ₁ + λ₂)²⟩: 0 for round chains, 1 for
//! straight ones (Rudnick & Gaspari, J. Phys. A 19 (1986) L191).
//!
//! For a chain whose bonds are independent of each other, ⟨R²⟩ = Σ ⟨b²⟩ and ⟨Rg²⟩ =
//! Σ n (N − n) ⟨b²⟩/N² over the bonds, each of which leaves n of the N bodies on one side (Kramers,
//! J. Chem. Phys. 14 (1946) 415): of equal bonds in a row (N² − 1) ⟨b²⟩/6N. With Gaussian bonds
//! Σ (λ₁ + λ₂) and its square follow from Wick's theorem: the asphericity is 2q/(1 + q) with
//! q = (2N² + 7)/(5 (N² − 1)), which is 1 at N = 2 and 4/7 for long chains of any independent
//! bonds; of long rings it is 1/3. For a chain that excludes its own area R ∝ N^(3/4) in two
//! dimensions (Nienhuis, Phys. Rev. Lett. 49 (1982) 1062).

use carom_engine::{Observer, View};
use serde::{Deserialize, Serialize};

use crate::{
    Group,
    chains::{Chain, chains_of, eigenvalues},
};

/// Shapes of the chains at each sample, and their bonds. A chain counts if its first body belongs
/// to the group: the earliest of its ends, or of all its bodies where it has none.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{ChainShapes, Group};
///
/// // Three points at right angles.
/// let scene = Scene::from_toml(r#"
///     [[bond]]
///     pairs = [[0, 1], [1, 2]]
///     tether = { max = 0.2 }
///     [[molecule]]
///     atoms = [{ at = [0, 0], radius = 1e-3, mass = 1.0 }]
///     at = [0.95, 0.5]
///     [[molecule]]
///     atoms = [{ at = [0, 0], radius = 1e-3, mass = 1.0 }]
///     at = [0.05, 0.5]
///     [[molecule]]
///     atoms = [{ at = [0, 0], radius = 1e-3, mass = 1.0 }]
///     at = [0.05, 0.6]
/// "#)?;
/// let mut shapes = ChainShapes::new(Group::All);
/// shapes.sample(&Simulation::new(&scene)?.view());
/// let point = shapes.series()[0];
/// assert!((point.end_to_end_squared.unwrap() - 0.02).abs() < 1e-12);
/// assert!((point.gyration_squared - 0.04 / 9.0).abs() < 1e-12);
/// assert!((point.bond_squared - 0.01).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "polymer")]
#[doc(alias = "radius of gyration")]
pub struct ChainShapes {
    group: Group,
    series: Vec<ChainPoint>,
    sums: ChainSums,
}

/// Means over the chains at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ChainPoint {
    /// Time of the sample.
    pub time: f64,
    /// Number of chains.
    pub chains: u64,
    /// Number of bonds.
    pub bonds: u64,
    /// Mean squared distance of the tied points (length²).
    pub bond_squared: f64,
    /// Mean squared distance of the ends of chains without branches (length²); `None` if there is
    /// none.
    pub end_to_end_squared: Option<f64>,
    /// Mean squared radius of gyration (length²).
    pub gyration_squared: f64,
}

/// Sums over all samples.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct ChainSums {
    bonds: f64,
    lengths: f64,
    squared_lengths: f64,
    chains: f64,
    gyration: f64,
    /// Σ (λ₁ − λ₂)² and Σ (λ₁ + λ₂)².
    shape: [f64; 2],
    /// Chains without branches, their Σ R², and Σ b² of the distances of their neighbours.
    linear: [f64; 3],
    /// Σ of the components S_xx, S_xy and S_yy of the tensor of gyration.
    tensor: [f64; 3],
    /// Σ λ₁ and Σ λ₂.
    eigenvalues: [f64; 2],
    /// Chains without rings: their Σ Rg², and that of chains with independent bonds.
    trees: [f64; 2],
}

impl ChainShapes {
    /// Shapes of the chains of a group.
    pub fn new(group: Group) -> Self {
        Self {
            group,
            series: Vec::new(),
            sums: ChainSums::default(),
        }
    }

    /// The samples so far.
    pub fn series(&self) -> &[ChainPoint] {
        &self.series
    }

    /// [Σx, Σw] over all samples so far: of the length of a bond and its square; of the squared
    /// end-to-end distance of a chain without branches; of that by the sum of the squared distances
    /// of its neighbours; of the squared radius of gyration; the asphericity; of the eigenvalues
    /// λ₁ and λ₂; of ⟨λ₂⟩/⟨λ₁⟩; of the components S_xx, S_yy and S_xy; and of the squared radius of
    /// gyration of a chain without rings by that of independent bonds.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        let sums = &self.sums;
        let [linear, ends, steps] = sums.linear;
        let [xx, xy, yy] = sums.tensor;
        let [larger, smaller] = sums.eigenvalues;
        vec![
            [sums.lengths, sums.bonds],
            [sums.squared_lengths, sums.bonds],
            [ends, linear],
            [ends, steps],
            [sums.gyration, sums.chains],
            sums.shape,
            [larger, sums.chains],
            [smaller, sums.chains],
            [smaller, larger],
            [xx, sums.chains],
            [yy, sums.chains],
            [xy, sums.chains],
            sums.trees,
        ]
    }
}

impl ChainSums {
    /// Adds one chain.
    fn add(&mut self, chain: &Chain) {
        for length in &chain.lengths {
            self.bonds += 1.0;
            self.lengths += length;
            self.squared_lengths += length * length;
        }
        let tensor = chain.gyration_tensor();
        let [larger, smaller] = eigenvalues(tensor);
        self.chains += 1.0;
        self.gyration += larger + smaller;
        self.shape[0] += (larger - smaller).powi(2);
        self.shape[1] += (larger + smaller).powi(2);
        for (sum, component) in self.tensor.iter_mut().zip(tensor) {
            *sum += component;
        }
        self.eigenvalues[0] += larger;
        self.eigenvalues[1] += smaller;
        if let Some(independent) = chain.independent_gyration {
            self.trees[0] += larger + smaller;
            self.trees[1] += independent;
        }
        if let Some([from, to]) = chain.ends() {
            let [count, squared, steps] = &mut self.linear;
            *count += 1.0;
            *squared += (to - from).length_squared();
            *steps += chain.steps;
        }
    }
}

impl Observer for ChainShapes {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let bodies: Vec<_> = view.bodies().collect();
        let chains = chains_of(view, &bodies, self.group);
        if chains.is_empty() {
            return;
        }
        let before = self.sums;
        for chain in &chains {
            self.sums.add(chain);
        }
        let bonds = self.sums.bonds - before.bonds;
        let linear = self.sums.linear[0] - before.linear[0];
        let ends = self.sums.linear[1] - before.linear[1];
        self.series.push(ChainPoint {
            time: view.time().to_f64(),
            chains: chains.len() as u64,
            bonds: bonds as u64,
            bond_squared: (self.sums.squared_lengths - before.squared_lengths) / bonds,
            end_to_end_squared: (linear > 0.0).then(|| ends / linear),
            gyration_squared: (self.sums.gyration - before.gyration) / chains.len() as f64,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_engine::{Scene, Simulation};

    fn shapes(text: &str) -> ChainShapes {
        let mut shapes = ChainShapes::new(Group::All);
        let scene = Scene::from_toml(text).unwrap();
        shapes.sample(&Simulation::new(&scene).unwrap().view());
        shapes
    }

    fn discs(places: &[[f64; 2]]) -> String {
        let disc = |at: &[f64; 2]| {
            format!(
                "[[molecule]]\natoms = [{{ at = [0, 0], radius = 1e-3, mass = 1 }}]\nat = {at:?}\n"
            )
        };
        places.iter().map(disc).collect()
    }

    #[test]
    fn a_straight_chain_around_the_box_has_its_length() {
        let places: Vec<[f64; 2]> = (0..15)
            .map(|k| {
                [
                    (0.1 * f64::from(k) + 0.05) % 1.0,
                    0.3 + 0.2 * f64::from(k / 10),
                ]
            })
            .collect();
        // The step from the tenth to the next goes up by 0.2, too.
        let text = format!(
            "[[bond]]\npairs = {:?}\ntether = {{ max = 0.25 }}\n{}",
            (0..14).map(|k| [k, k + 1]).collect::<Vec<_>>(),
            discs(&places)
        );
        let shapes = shapes(&text);
        let point = shapes.series()[0];
        assert_eq!((point.chains, point.bonds), (1, 14));
        let squared = 1.4_f64.powi(2) + 0.04;
        assert!((point.end_to_end_squared.unwrap() - squared).abs() < 1e-12);
        let steps = 14.0 * 0.01 + 0.04;
        let [_, _, _, [ends, sum], ..] = shapes.sums()[..] else {
            panic!("four sums and more")
        };
        assert!((ends / sum - squared / steps).abs() < 1e-10);
        assert!((point.bond_squared - steps / 14.0).abs() < 1e-12);
    }

    #[test]
    fn rings_and_stars_have_no_ends() {
        let square = [[0.4, 0.4], [0.5, 0.4], [0.5, 0.5], [0.4, 0.5]];
        let ring = "[[bond]]\npairs = [[0, 1], [1, 2], [2, 3], [3, 0]]\ntether = { max = 0.2 }\n";
        let of_ring = shapes(&format!("{ring}{}", discs(&square)));
        let point = of_ring.series()[0];
        assert_eq!(point.end_to_end_squared, None);
        assert!((point.gyration_squared - 0.005).abs() < 1e-12);
        // Round: both eigenvalues are equal.
        let [apart, together] = of_ring.sums()[5];
        assert!(apart < 1e-12 * together);
        let star = "[[bond]]\npairs = [[0, 1], [0, 2], [0, 3]]\ntether = { max = 0.2 }\n";
        let point = shapes(&format!("{star}{}", discs(&square))).series()[0];
        assert_eq!((point.chains, point.bonds), (1, 3));
        assert_eq!(point.end_to_end_squared, None);
    }

    #[test]
    fn a_rod_has_asphericity_one() {
        let row = [[0.2, 0.2], [0.3, 0.3], [0.4, 0.4]];
        let bonds = "[[bond]]\npairs = [[0, 1], [1, 2]]\ntether = { max = 0.2 }\n";
        let [apart, together] = shapes(&format!("{bonds}{}", discs(&row))).sums()[5];
        assert!((apart / together - 1.0).abs() < 1e-12);
        // Without bonds nothing is sampled.
        assert!(shapes(&discs(&row)).series().is_empty());
    }

    /// Means of the quantities from the larger eigenvalue on.
    fn gyration(shapes: &ChainShapes) -> Vec<f64> {
        let sums = shapes.sums().into_iter().skip(6);
        sums.map(|[sum, weight]| sum / weight).collect()
    }

    /// N points in a row at distance b: λ₁ = (N² − 1) b²/12 along the row, λ₂ = 0.
    #[test]
    fn straight_chains_and_square_rings_have_their_tensor_of_gyration() {
        let row: Vec<[f64; 2]> = (0..5)
            .map(|k| [0.3 + 0.06 * f64::from(k), 0.3 + 0.08 * f64::from(k)])
            .collect();
        let pairs: Vec<[u32; 2]> = (0..4).map(|k| [k, k + 1]).collect();
        let bonds = format!("[[bond]]\npairs = {pairs:?}\ntether = {{ max = 0.2 }}\n");
        let found = gyration(&shapes(&format!("{bonds}{}", discs(&row))));
        // By that of independent bonds: λ₁/((N² − 1) b²/6N) = N/2.
        let expected = [0.02, 0.0, 0.0, 0.36 * 0.02, 0.64 * 0.02, 0.48 * 0.02, 2.5];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        assert_eq!(found.len(), expected.len());
        let square = [[0.4, 0.4], [0.5, 0.4], [0.5, 0.5], [0.4, 0.5]];
        let ring = "[[bond]]\npairs = [[0, 1], [1, 2], [2, 3], [3, 0]]\ntether = { max = 0.2 }\n";
        let found = gyration(&shapes(&format!("{ring}{}", discs(&square))));
        let expected = [0.0025, 0.0025, 1.0, 0.0025, 0.0025, 0.0];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        // A ring has no independent bonds.
        assert!(found[6].is_nan());
    }

    /// The mean over all signs of the bonds is that of bonds with independent directions, exactly.
    #[test]
    fn trees_with_independent_bonds_have_the_radius_of_gyration_of_kramers() {
        let bonds = [[0.05, 0.02], [-0.03, 0.06], [0.01, 0.07], [0.08, 0.0]];
        let row = [[0, 1], [1, 2], [2, 3], [3, 4]];
        let star = [[0, 1], [0, 2], [0, 3], [0, 4]];
        let comb = [[0, 1], [1, 2], [1, 3], [3, 4]];
        for pairs in [row, star, comb] {
            let mut total = [0.0; 2];
            for signs in 0..16 {
                let mut places = vec![[0.95, 0.5]];
                for (number, ([from, _], bond)) in pairs.iter().zip(bonds).enumerate() {
                    let sign = if signs >> number & 1 == 0 { 1.0 } else { -1.0 };
                    let [x, y] = places[*from];
                    places.push([x + sign * bond[0], y + sign * bond[1]]);
                }
                let places: Vec<[f64; 2]> = places.iter().map(|[x, y]| [x % 1.0, *y]).collect();
                let text = format!("[[bond]]\npairs = {pairs:?}\ntether = {{ max = 0.2 }}\n");
                let sums = shapes(&format!("{text}{}", discs(&places))).sums();
                total = [total[0] + sums[12][0], total[1] + sums[12][1]];
            }
            assert!(
                (total[0] / total[1] - 1.0).abs() < 1e-12,
                "{pairs:?} {total:?}"
            );
        }
    }
}
