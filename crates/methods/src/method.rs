//! Detector, scheduler and instructions of a run, with their parameters.

use std::fmt;

use carom_detection::{Exact, FixedStep, GoldenSecant};
use carom_engine::{
    CellsPerSide, DetectorName, Instructions, InstructionsName, MethodSpec, SceneError,
    SchedulerName, TilesName, Tiling,
};
use thiserror::Error;

use crate::AnyDetector;

/// How a simulation finds contacts and orders events. The default is exact and fastest.
///
/// In a scene file it is the table `[method]`, see [`MethodSpec`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Method {
    /// The detector of contacts.
    pub detector: AnyDetector,
    /// The scheduler of events.
    pub order: Order,
    /// Whether the scheduler may divide the box into tiles. No choice changes a bit.
    pub tiles: TilesName,
}

/// The scheduler of the events, with its options.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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

impl From<MethodError> for SceneError {
    fn from(error: MethodError) -> Self {
        Self::Entry {
            entry: "method".to_owned(),
            problem: error.to_string(),
        }
    }
}

impl Method {
    /// How the box is divided for a number of threads.
    pub fn tiling(&self, threads: usize) -> Tiling {
        match self.tiles {
            TilesName::Automatic => Tiling::with_threads(threads),
            TilesName::Always => Tiling {
                least_bodies: 0,
                least_molecules: 0,
                ..Tiling::with_threads(threads)
            },
            TilesName::Never => Tiling::NONE,
        }
    }

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
            AnyDetector::Exact(exact) => {
                write!(f, "exact detector, at most {} steps", exact.most_steps)?;
            }
            AnyDetector::GoldenSecant(golden) => write!(
                f,
                "golden-section and secant search with tolerance {:e} and crop factor {}",
                golden.tolerance, golden.crop_factor
            )?,
            AnyDetector::FixedStep(fixed) => {
                write!(
                    f,
                    "overlap tests every {:e} natural times of a pair",
                    fixed.step
                )?;
            }
            AnyDetector::BoundingCircles => write!(f, "bounding circles in place of molecules")?,
        }
        match self.order {
            Order::Cells(Instructions::Widest) => {}
            Order::Cells(Instructions::Avx2) => write!(f, "; AVX2 instructions")?,
            Order::Cells(Instructions::Portable) => write!(f, "; portable instructions")?,
            Order::Heap(CellsPerSide::Automatic) => write!(f, "; heap of all events")?,
            Order::Heap(CellsPerSide::Given(cells)) => {
                write!(f, "; heap of all events, {cells} cells per side")?;
            }
            Order::Heap(CellsPerSide::Unchecked(cells)) => {
                write!(
                    f,
                    "; heap of all events, {cells} cells per side, which may miss contacts"
                )?;
            }
        }
        match self.tiles {
            TilesName::Automatic => Ok(()),
            TilesName::Always => write!(f, "; tiles in a system of any size"),
            TilesName::Never => write!(f, "; no tiles"),
        }
    }
}

fn detector(spec: &MethodSpec) -> Result<AnyDetector, MethodError> {
    let is = |name| spec.detector == name;
    let no_effect = |key, owner| Err(MethodError::NoEffect { key, owner });
    if !is(DetectorName::GoldenSecant) {
        let owner = "detector = \"golden-secant\"";
        if spec.tolerance.is_some() {
            return no_effect("tolerance", owner);
        }
        if spec.crop_factor.is_some() {
            return no_effect("crop_factor", owner);
        }
    }
    if spec.step.is_some() && !is(DetectorName::FixedStep) {
        return no_effect("step", "detector = \"fixed-step\"");
    }
    if spec.most_steps.is_some() && !(is(DetectorName::FixedStep) || is(DetectorName::Exact)) {
        return no_effect("most_steps", "detector = \"exact\" and \"fixed-step\"");
    }
    if spec.most_steps == Some(0) {
        return Err(MethodError::OutOfRange {
            key: "most_steps",
            allowed: "at least 1",
            value: 0.0,
        });
    }
    Ok(match spec.detector {
        DetectorName::Exact => AnyDetector::Exact(Exact {
            most_steps: spec.most_steps.unwrap_or(Exact::default().most_steps),
        }),
        DetectorName::GoldenSecant => {
            let default = GoldenSecant::default();
            AnyDetector::GoldenSecant(GoldenSecant {
                tolerance: within("tolerance", spec.tolerance, default.tolerance)?,
                crop_factor: within("crop_factor", spec.crop_factor, default.crop_factor)?,
                ..default
            })
        }
        DetectorName::FixedStep => {
            let default = FixedStep::default();
            AnyDetector::FixedStep(FixedStep {
                step: within("step", spec.step, default.step)?,
                most_steps: spec.most_steps.unwrap_or(default.most_steps),
            })
        }
        DetectorName::BoundingCircles => AnyDetector::BoundingCircles,
    })
}

fn order(spec: &MethodSpec) -> Result<Order, MethodError> {
    match spec.scheduler {
        SchedulerName::Cells => {
            let owner = "scheduler = \"heap\"";
            if spec.cells_per_side.is_some() {
                return Err(MethodError::NoEffect {
                    key: "cells_per_side",
                    owner,
                });
            }
            if spec.unchecked_cells_per_side.is_some() {
                return Err(MethodError::NoEffect {
                    key: "unchecked_cells_per_side",
                    owner,
                });
            }
            Ok(Order::Cells(match spec.instructions {
                None | Some(InstructionsName::Widest) => Instructions::Widest,
                Some(InstructionsName::Avx2) => Instructions::Avx2,
                Some(InstructionsName::Portable) => Instructions::Portable,
            }))
        }
        SchedulerName::Heap => {
            if spec.instructions.is_some() {
                let owner = "scheduler = \"cells\"";
                return Err(MethodError::NoEffect {
                    key: "instructions",
                    owner,
                });
            }
            if spec.tiles.is_some() {
                let owner = "scheduler = \"cells\"";
                return Err(MethodError::NoEffect {
                    key: "tiles",
                    owner,
                });
            }
            Ok(Order::Heap(
                match (spec.cells_per_side, spec.unchecked_cells_per_side) {
                    (None, None) => CellsPerSide::Automatic,
                    (Some(cells), None) => CellsPerSide::Given(cells),
                    (None, Some(cells)) => CellsPerSide::Unchecked(cells),
                    (Some(_), Some(_)) => return Err(MethodError::TwoGrids),
                },
            ))
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
        Err(MethodError::OutOfRange {
            key,
            allowed: "from 1e-15 to 1e3",
            value,
        })
    }
}

impl TryFrom<&MethodSpec> for Method {
    type Error = MethodError;

    fn try_from(spec: &MethodSpec) -> Result<Self, MethodError> {
        let tiles = spec.tiles.unwrap_or_default();
        Ok(Self {
            detector: detector(spec)?,
            order: order(spec)?,
            tiles,
        })
    }
}

impl From<&Method> for MethodSpec {
    fn from(method: &Method) -> Self {
        let tiles = (method.tiles != TilesName::default()).then_some(method.tiles);
        let mut spec = Self {
            tiles,
            ..Self::default()
        };
        match method.detector {
            AnyDetector::Exact(exact) => {
                spec.most_steps = (exact != Exact::default()).then_some(exact.most_steps);
            }
            AnyDetector::GoldenSecant(golden) => {
                spec.detector = DetectorName::GoldenSecant;
                (spec.tolerance, spec.crop_factor) =
                    (Some(golden.tolerance), Some(golden.crop_factor));
            }
            AnyDetector::FixedStep(fixed) => {
                spec.detector = DetectorName::FixedStep;
                (spec.step, spec.most_steps) = (Some(fixed.step), Some(fixed.most_steps));
            }
            AnyDetector::BoundingCircles => spec.detector = DetectorName::BoundingCircles,
        }
        match method.order {
            Order::Cells(Instructions::Widest) => {}
            Order::Cells(Instructions::Avx2) => spec.instructions = Some(InstructionsName::Avx2),
            Order::Cells(Instructions::Portable) => {
                spec.instructions = Some(InstructionsName::Portable);
            }
            Order::Heap(cells) => {
                spec.scheduler = SchedulerName::Heap;
                match cells {
                    CellsPerSide::Automatic => {}
                    CellsPerSide::Given(cells) => spec.cells_per_side = Some(cells),
                    CellsPerSide::Unchecked(cells) => spec.unchecked_cells_per_side = Some(cells),
                }
            }
        }
        spec
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn method(text: &str) -> Result<Method, String> {
        let spec: MethodSpec =
            toml::from_str(text).map_err(|error: toml::de::Error| error.to_string())?;
        Method::try_from(&spec).map_err(|error| error.to_string())
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
            "tiles = \"always\"",
        ] {
            let read = method(text).unwrap();
            let written = toml::to_string(&MethodSpec::from(&read)).unwrap();
            assert_eq!(method(&written).unwrap(), read, "{text}");
        }
        assert_eq!(method("").unwrap(), Method::default());
    }

    #[test]
    fn only_the_certified_detector_on_a_safe_grid_is_exact() {
        assert!(Method::default().is_exact());
        assert!(
            method("scheduler = \"heap\"\ncells_per_side = 20")
                .unwrap()
                .is_exact()
        );
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
            (
                "detector = \"bounding-circles\"\nmost_steps = 5",
                "most_steps",
            ),
            ("most_steps = 0", "at least 1"),
            ("detector = \"golden-secant\"\ntolerance = 0.0", "1e-15"),
            ("detector = \"fixed-step\"\nstep = nan", "1e-15"),
            ("cells_per_side = 20", "heap"),
            ("unchecked_cells_per_side = 20", "heap"),
            ("scheduler = \"heap\"\ninstructions = \"avx2\"", "cells"),
            (
                "scheduler = \"heap\"\ncells_per_side = 2\nunchecked_cells_per_side = 2",
                "not both",
            ),
        ] {
            let error = method(text).unwrap_err();
            assert!(error.contains(said), "{text}: {error}");
        }
    }

    #[test]
    fn a_method_reads_as_words() {
        assert_eq!(Method::default().to_string(), "exact detector");
        let words = method("detector = \"fixed-step\"\nstep = 0.01\nscheduler = \"heap\"")
            .unwrap()
            .to_string();
        assert_eq!(
            words,
            "overlap tests every 1e-2 natural times of a pair; heap of all events"
        );
    }
}
