//! The table `[method]` of a scene file: detector, scheduler and instructions, with their
//! parameters.

use std::fmt;

use carom_detection::{Exact, FixedStep, GoldenSecant};
use carom_engine::{CellsPerSide, Instructions};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::AnyDetector;

/// How a simulation finds contacts and orders events. The default is exact and fastest.
///
/// In a scene file:
///
/// ```toml
/// [method]
/// detector = "golden-secant"   # exact (default), golden-secant, fixed-step, bounding-circles
/// tolerance = 1e-9             # of golden-secant, relative to the end of a segment
/// crop_factor = 1.0            # of golden-secant, in shortest quarter periods
/// step = 1e-3                  # of fixed-step, in natural times of a pair
/// most_steps = 100000          # of exact and fixed-step
/// scheduler = "heap"           # cells (default), heap
/// cells_per_side = 20          # of heap; default: the largest safe number
/// unchecked_cells_per_side = 50  # of heap; contacts are missed if too fine
/// instructions = "portable"    # of cells: widest (default), avx2, portable
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(try_from = "Entries", into = "Entries")]
pub struct Method {
    /// The detector of contacts.
    pub detector: AnyDetector,
    /// The scheduler of events.
    pub order: Order,
}

/// The scheduler of the events, with its options.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Order {
    /// [`CellScheduler`](carom_engine::CellScheduler).
    Cells(Instructions),
    /// [`HeapScheduler`](carom_engine::HeapScheduler).
    Heap(CellsPerSide),
}

impl Default for Order {
    fn default() -> Self {
        Self::Cells(Instructions::Widest)
    }
}

/// An invalid entry of `[method]`.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MethodError {
    /// A number is out of range.
    #[error("`{key}` must be {allowed}, but is {value}")]
    OutOfRange {
        /// The key.
        key: &'static str,
        /// The allowed range.
        allowed: &'static str,
        /// The value given.
        value: f64,
    },
    /// A key has no effect with the other entries.
    #[error("`{key}` has no effect: it belongs to {owner}")]
    NoEffect {
        /// The key.
        key: &'static str,
        /// The entry to which the key belongs.
        owner: &'static str,
    },
    /// Two keys exclude each other.
    #[error("give `cells_per_side` or `unchecked_cells_per_side`, not both")]
    TwoGrids,
}

impl Method {
    /// Whether no contact is missed, invented or late beyond rounding.
    pub fn is_exact(&self) -> bool {
        let is_unchecked = matches!(self.order, Order::Heap(CellsPerSide::Unchecked(_)));
        matches!(self.detector, AnyDetector::Exact(_)) && !is_unchecked
    }
}

/// In words, for pages and error messages.
impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.detector {
            AnyDetector::Exact(exact) if exact == Exact::default() => write!(f, "exact detector")?,
            AnyDetector::Exact(exact) => write!(f, "exact detector, at most {} steps", exact.most_steps)?,
            AnyDetector::GoldenSecant(golden) => write!(
                f,
                "golden-section and secant search with tolerance {:e} and crop factor {}",
                golden.tolerance, golden.crop_factor
            )?,
            AnyDetector::FixedStep(fixed) => {
                write!(f, "overlap tests every {:e} natural times of a pair", fixed.step)?;
            }
            AnyDetector::BoundingCircles => write!(f, "bounding circles in place of molecules")?,
        }
        match self.order {
            Order::Cells(Instructions::Widest) => Ok(()),
            Order::Cells(Instructions::Avx2) => write!(f, "; AVX2 instructions"),
            Order::Cells(Instructions::Portable) => write!(f, "; portable instructions"),
            Order::Heap(CellsPerSide::Automatic) => write!(f, "; heap of all events"),
            Order::Heap(CellsPerSide::Given(cells)) => {
                write!(f, "; heap of all events, {cells} cells per side")
            }
            Order::Heap(CellsPerSide::Unchecked(cells)) => {
                write!(f, "; heap of all events, {cells} cells per side, which may miss contacts")
            }
        }
    }
}

/// The entries of the table as they stand in the file.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Entries {
    detector: DetectorName,
    #[serde(skip_serializing_if = "Option::is_none")]
    tolerance: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    crop_factor: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    most_steps: Option<u32>,
    scheduler: SchedulerName,
    #[serde(skip_serializing_if = "Option::is_none")]
    cells_per_side: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    unchecked_cells_per_side: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    instructions: Option<InstructionsName>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum DetectorName {
    #[default]
    Exact,
    GoldenSecant,
    FixedStep,
    BoundingCircles,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum SchedulerName {
    #[default]
    Cells,
    Heap,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum InstructionsName {
    Widest,
    Avx2,
    Portable,
}

impl Entries {
    fn detector(&self) -> Result<AnyDetector, MethodError> {
        let is = |name| self.detector == name;
        let no_effect = |key, owner| Err(MethodError::NoEffect { key, owner });
        if !is(DetectorName::GoldenSecant) {
            let owner = "detector = \"golden-secant\"";
            if self.tolerance.is_some() {
                return no_effect("tolerance", owner);
            }
            if self.crop_factor.is_some() {
                return no_effect("crop_factor", owner);
            }
        }
        if self.step.is_some() && !is(DetectorName::FixedStep) {
            return no_effect("step", "detector = \"fixed-step\"");
        }
        if self.most_steps.is_some() && !(is(DetectorName::FixedStep) || is(DetectorName::Exact)) {
            return no_effect("most_steps", "detector = \"exact\" and \"fixed-step\"");
        }
        if self.most_steps == Some(0) {
            return Err(MethodError::OutOfRange { key: "most_steps", allowed: "at least 1", value: 0.0 });
        }
        Ok(match self.detector {
            DetectorName::Exact => AnyDetector::Exact(Exact {
                most_steps: self.most_steps.unwrap_or(Exact::default().most_steps),
            }),
            DetectorName::GoldenSecant => {
                let default = GoldenSecant::default();
                AnyDetector::GoldenSecant(GoldenSecant {
                    tolerance: within("tolerance", self.tolerance, default.tolerance)?,
                    crop_factor: within("crop_factor", self.crop_factor, default.crop_factor)?,
                    ..default
                })
            }
            DetectorName::FixedStep => {
                let default = FixedStep::default();
                AnyDetector::FixedStep(FixedStep {
                    step: within("step", self.step, default.step)?,
                    most_steps: self.most_steps.unwrap_or(default.most_steps),
                })
            }
            DetectorName::BoundingCircles => AnyDetector::BoundingCircles,
        })
    }

    fn order(&self) -> Result<Order, MethodError> {
        match self.scheduler {
            SchedulerName::Cells => {
                let owner = "scheduler = \"heap\"";
                if self.cells_per_side.is_some() {
                    return Err(MethodError::NoEffect { key: "cells_per_side", owner });
                }
                if self.unchecked_cells_per_side.is_some() {
                    return Err(MethodError::NoEffect { key: "unchecked_cells_per_side", owner });
                }
                Ok(Order::Cells(match self.instructions {
                    None | Some(InstructionsName::Widest) => Instructions::Widest,
                    Some(InstructionsName::Avx2) => Instructions::Avx2,
                    Some(InstructionsName::Portable) => Instructions::Portable,
                }))
            }
            SchedulerName::Heap => {
                if self.instructions.is_some() {
                    let owner = "scheduler = \"cells\"";
                    return Err(MethodError::NoEffect { key: "instructions", owner });
                }
                Ok(Order::Heap(match (self.cells_per_side, self.unchecked_cells_per_side) {
                    (None, None) => CellsPerSide::Automatic,
                    (Some(cells), None) => CellsPerSide::Given(cells),
                    (None, Some(cells)) => CellsPerSide::Unchecked(cells),
                    (Some(_), Some(_)) => return Err(MethodError::TwoGrids),
                }))
            }
        }
    }
}

/// Least and largest value of a tolerance, crop factor or step. Below, rounding decides; above, the
/// search is one look at a whole flight.
const RANGE: std::ops::RangeInclusive<f64> = 1e-15..=1e3;

fn within(key: &'static str, given: Option<f64>, default: f64) -> Result<f64, MethodError> {
    let value = given.unwrap_or(default);
    if RANGE.contains(&value) {
        Ok(value)
    } else {
        Err(MethodError::OutOfRange { key, allowed: "from 1e-15 to 1e3", value })
    }
}

impl TryFrom<Entries> for Method {
    type Error = MethodError;

    fn try_from(entries: Entries) -> Result<Self, MethodError> {
        Ok(Self { detector: entries.detector()?, order: entries.order()? })
    }
}

impl From<Method> for Entries {
    fn from(method: Method) -> Self {
        let mut entries = Self::default();
        match method.detector {
            AnyDetector::Exact(exact) => {
                entries.most_steps = (exact != Exact::default()).then_some(exact.most_steps);
            }
            AnyDetector::GoldenSecant(golden) => {
                entries.detector = DetectorName::GoldenSecant;
                (entries.tolerance, entries.crop_factor) = (Some(golden.tolerance), Some(golden.crop_factor));
            }
            AnyDetector::FixedStep(fixed) => {
                entries.detector = DetectorName::FixedStep;
                (entries.step, entries.most_steps) = (Some(fixed.step), Some(fixed.most_steps));
            }
            AnyDetector::BoundingCircles => entries.detector = DetectorName::BoundingCircles,
        }
        match method.order {
            Order::Cells(Instructions::Widest) => {}
            Order::Cells(Instructions::Avx2) => entries.instructions = Some(InstructionsName::Avx2),
            Order::Cells(Instructions::Portable) => entries.instructions = Some(InstructionsName::Portable),
            Order::Heap(cells) => {
                entries.scheduler = SchedulerName::Heap;
                match cells {
                    CellsPerSide::Automatic => {}
                    CellsPerSide::Given(cells) => entries.cells_per_side = Some(cells),
                    CellsPerSide::Unchecked(cells) => entries.unchecked_cells_per_side = Some(cells),
                }
            }
        }
        entries
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn method(text: &str) -> Result<Method, String> {
        toml::from_str(text).map_err(|error: toml::de::Error| error.to_string())
    }

    #[test]
    fn a_method_is_unchanged_by_writing_and_reading() {
        for text in [
            "",
            "most_steps = 7",
            "detector = \"golden-secant\"\ntolerance = 1e-6\ncrop_factor = 2.0",
            "detector = \"fixed-step\"\nstep = 0.01\nmost_steps = 1000",
            "detector = \"bounding-circles\"\ninstructions = \"portable\"",
            "scheduler = \"heap\"\ncells_per_side = 20",
            "scheduler = \"heap\"\nunchecked_cells_per_side = 50",
            "instructions = \"avx2\"",
        ] {
            let read = method(text).unwrap();
            assert_eq!(method(&toml::to_string(&read).unwrap()).unwrap(), read, "{text}");
        }
        assert_eq!(method("").unwrap(), Method::default());
    }

    #[test]
    fn only_the_certified_detector_on_a_safe_grid_is_exact() {
        assert!(Method::default().is_exact());
        assert!(method("scheduler = \"heap\"\ncells_per_side = 20").unwrap().is_exact());
        for text in [
            "detector = \"golden-secant\"",
            "detector = \"fixed-step\"",
            "detector = \"bounding-circles\"",
            "scheduler = \"heap\"\nunchecked_cells_per_side = 20",
        ] {
            assert!(!method(text).unwrap().is_exact(), "{text}");
        }
    }

    #[test]
    fn invalid_entries_are_refused_by_name() {
        for (text, said) in [
            ("detector = \"magic\"", "golden-secant"),
            ("detektor = \"exact\"", "detektor"),
            ("tolerance = 1e-9", "golden-secant"),
            ("crop_factor = 1.0", "crop_factor"),
            ("step = 1e-3", "fixed-step"),
            ("detector = \"bounding-circles\"\nmost_steps = 5", "most_steps"),
            ("most_steps = 0", "at least 1"),
            ("detector = \"golden-secant\"\ntolerance = 0.0", "1e-15"),
            ("detector = \"fixed-step\"\nstep = nan", "1e-15"),
            ("cells_per_side = 20", "heap"),
            ("unchecked_cells_per_side = 20", "heap"),
            ("scheduler = \"heap\"\ninstructions = \"avx2\"", "cells"),
            ("scheduler = \"heap\"\ncells_per_side = 2\nunchecked_cells_per_side = 2", "not both"),
        ] {
            let error = method(text).unwrap_err();
            assert!(error.contains(said), "{text}: {error}");
        }
    }

    #[test]
    fn a_method_reads_as_words() {
        assert_eq!(Method::default().to_string(), "exact detector");
        let words =
            method("detector = \"fixed-step\"\nstep = 0.01\nscheduler = \"heap\"").unwrap().to_string();
        assert_eq!(words, "overlap tests every 1e-2 natural times of a pair; heap of all events");
    }
}
