//! Wells and shoulders: the energy of two discs at a distance, in steps.

use carom_geometry::MAX_MAGNITUDE;
use serde::{Deserialize, Serialize};

use crate::scene::two_numbers::vectors;

/// Most steps of a well.
pub(crate) const MAX_STEPS: usize = 64;

/// Largest range of a step, in distances at contact. Beyond it a scene is most likely an error: the
/// largest range sets the size of the cells.
pub(crate) const MAX_RANGE: f64 = 1e3;

/// Discs of two tags that attract or repel each other in steps of the potential energy.
///
/// At the range of a step the two get an impulse along the line of their centres, so that kinetic
/// energy and energy of the pair stay the same together. Discs too slow for a step upwards bounce
/// back from it. Between the steps they fly freely.
///
/// ```
/// use carom_engine::{Scene, Simulation};
///
/// // A gas with a square well of range 1.5 and depth 0.5.
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
/// let total = |view: carom_engine::View<'_>| view.energy() + view.energy_of_wells();
/// let before = total(simulation.view());
/// simulation.run_until(1.0)?;
/// assert!(simulation.view().energy_of_wells() < 0.0);
/// assert!((total(simulation.view()) / before - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[doc(alias = "square well")]
#[doc(alias = "square shoulder")]
#[doc(alias = "sticky discs")]
#[doc(alias = "stepped potential")]
pub struct WellSpec {
    /// Two tags, or one for discs of one tag with each other. Bodies with these tags must be discs.
    #[cfg_attr(feature = "schema", schemars(length(min = 1, max = 2)))]
    pub between: Vec<String>,
    /// The steps `[range, energy]` from the inside outwards, at most 64. A range is the distance of
    /// the centres in units of that at contact, above 1, up to 1000. The energy is that of a pair
    /// within the range (mass × length² / time²), below 0 for attraction, from -1e60 to 1e60;
    /// beyond the last range it is 0.
    #[cfg_attr(feature = "schema", schemars(length(min = 1, max = MAX_STEPS)))]
    #[serde(deserialize_with = "vectors")]
    pub steps: Vec<[f64; 2]>,
}

impl WellSpec {
    /// Checks the steps.
    ///
    /// # Errors
    /// A number is out of range, or the ranges do not ascend.
    pub(crate) fn check(&self) -> Result<(), String> {
        let steps = &self.steps;
        if steps.is_empty() || steps.len() > MAX_STEPS {
            return Err(format!(
                "`steps` must have from 1 to {MAX_STEPS} steps, but has {}",
                steps.len()
            ));
        }
        let mut before = 1.0;
        for &[range, energy] in steps {
            if !(range > before && range <= MAX_RANGE) {
                return Err(format!(
                    "the ranges of `steps` must ascend from above 1 to {MAX_RANGE} (distances at contact), but \
                     {range:?} follows {before:?}"
                ));
            }
            if energy.is_nan() || energy.abs() > MAX_MAGNITUDE {
                return Err(format!(
                    "the energies of `steps` must be from -{MAX_MAGNITUDE:e} to {MAX_MAGNITUDE:e}, but one is {energy:?}"
                ));
            }
            before = range;
        }
        Ok(())
    }
}
