//! The table `[method]` of a scene file: which detector and scheduler compute the run.

use std::str::FromStr;

use serde::{
    Deserialize, Serialize,
    de::{
        Error as _, IntoDeserializer as _,
        value::{Error, StrDeserializer},
    },
};

use crate::scene::spelling::suggestion;

/// How contacts are found and events ordered; exact by default.
///
/// Plain data, from which `carom-methods` builds the simulation.
/// [`Simulation::new`](crate::Simulation::new) ignores it: that run is exact.
///
/// ```toml
/// [method]
/// detector = "golden-secant"
/// tolerance = 1e-9
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct MethodSpec {
    /// The detector of contacts; the default is exact.
    pub detector: DetectorName,
    /// Of `golden-secant`: tolerance of the searches, relative to the time at which a segment ends;
    /// from 1e-15 to 1000.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1e-15, max = 1000.0)))]
    pub tolerance: Option<f64>,
    /// Of `golden-secant`: length of a segment in shortest quarter periods; from 1e-15 to 1000.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1e-15, max = 1000.0)))]
    pub crop_factor: Option<f64>,
    /// Of `fixed-step`: the step in natural times of a pair, in which it moves by its own size;
    /// from 1e-15 to 1000.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1e-15, max = 1000.0)))]
    pub step: Option<f64>,
    /// Of `exact`: largest number of steps of the search of one atom pair. Of `fixed-step`: of one
    /// flight. At least 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    pub most_steps: Option<u32>,
    /// The scheduler of events.
    pub scheduler: SchedulerName,
    /// Of `heap`: cells per side of its grid, from 1 to 4096; a number that is not safe is refused.
    /// Default: the largest safe number.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 4096)))]
    pub cells_per_side: Option<u32>,
    /// Of `heap`: cells per side, even if contacts are then missed. Excludes `cells_per_side`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 4096)))]
    pub unchecked_cells_per_side: Option<u32>,
    /// Of `cells`: the instruction set. All give the same bits. Default: `widest`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instructions: Option<InstructionsName>,
    /// Of `cells`: whether large gases are divided into tiles, which several threads can
    /// run. It changes no bit of the results. Default: `automatic`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tiles: Option<TilesName>,
}

/// Whether the box is divided into tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum TilesName {
    /// Where they pay: from 400 000 bodies on one thread; on two or three from 150 000 discs, or
    /// 20 000 bodies if molecules move; on four or more from 30 000 discs, or 20 000.
    #[default]
    Automatic,
    /// In a system of any size that can be divided into two tiles or more.
    Always,
    /// Every contact is computed in order, on one thread.
    Never,
}

/// Name of a detector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum DetectorName {
    /// The certified detector.
    #[default]
    Exact,
    /// The golden-section and secant search of the thesis: misses some contacts.
    GoldenSecant,
    /// Overlap tests at regular times, as in a time-stepped code: misses some contacts.
    FixedStep,
    /// Bounding circles in place of molecules: another model.
    BoundingCircles,
}

impl FromStr for DetectorName {
    type Err = Error;

    /// Parses the name as in a scene file; the error lists the names.
    fn from_str(text: &str) -> Result<Self, Error> {
        let name: StrDeserializer<'_, Error> = text.into_deserializer();
        Self::deserialize(name).map_err(|error| {
            let message = error.to_string();
            Error::custom(format!("{message}{}", suggestion(&message)))
        })
    }
}

/// Name of a scheduler.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SchedulerName {
    /// [`CellScheduler`](crate::CellScheduler), the fastest.
    #[default]
    Cells,
    /// [`HeapScheduler`](crate::HeapScheduler), the scheduler of the thesis.
    Heap,
}

/// Name of an instruction set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum InstructionsName {
    /// The best that this processor has.
    Widest,
    /// AVX2.
    Avx2,
    /// Those of every processor of this architecture.
    Portable,
}
