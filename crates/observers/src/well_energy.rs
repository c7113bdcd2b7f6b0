//! The energy of the wells of discs, and the pairs within their ranges, at each sample.

use std::collections::HashSet;

use carom_engine::{Observer, View};
use serde::{Deserialize, Serialize};

/// The energy of all wells at each sample.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::WellEnergy;
///
/// let scene = Scene::from_toml(r#"
///     [[well]]
///     between = ["sticky"]
///     steps = [[1.5, -0.5]]
///     [[gas]]
///     tags = ["sticky"]
///     radius = 0.02
///     mass = 1.0
///     temperature = 1.0
///     count = 100
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// simulation.run_until(1.0)?;
/// let mut wells = WellEnergy::default();
/// wells.sample(&simulation.view());
/// let point = wells.series()[0];
/// assert_eq!(point.energy, -0.5 * point.pairs as f64);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[doc(alias = "potential energy")]
#[doc(alias = "square well")]
pub struct WellEnergy {
    series: Vec<WellPoint>,
    sums: [[f64; 2]; 3],
}

/// The wells at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct WellPoint {
    /// Time of the sample.
    pub time: f64,
    /// Energy of all pairs (mass × length² / time²).
    pub energy: f64,
    /// Number of pairs within the ranges of their wells.
    pub pairs: u64,
}

impl WellEnergy {
    /// The samples so far.
    pub fn series(&self) -> &[WellPoint] {
        &self.series
    }

    /// [Σx, Σw] over all samples so far: of the energy of all pairs; of that by the number of
    /// bodies that move; and of the mean number of bodies within the wells of one that moves.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        self.sums.to_vec()
    }
}

impl Observer for WellEnergy {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let mut bodies = 0.0;
        let mut fixed = HashSet::new();
        for body in view.bodies() {
            if body.body.is_free() {
                bodies += 1.0;
            } else {
                fixed.insert(body.body.key());
            }
        }
        let (mut pairs, mut neighbours) = (0, 0.0);
        for pair in view.pairs_in_wells() {
            pairs += 1;
            neighbours += pair
                .bodies
                .iter()
                .filter(|key| !fixed.contains(key))
                .count() as f64;
        }
        let energy = view.energy_of_wells();
        let terms = [[energy, 1.0], [energy, bodies], [neighbours, bodies]];
        for (sum, term) in self.sums.iter_mut().zip(terms) {
            sum[0] += term[0];
            sum[1] += term[1];
        }
        self.series.push(WellPoint {
            time: view.time().to_f64(),
            energy,
            pairs,
        });
    }
}
