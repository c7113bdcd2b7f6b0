//! All detectors as one type, so that a run can use any of them.

use carom_detection::{
    Answer, BoundingCircles, DISC_LANES, Detection, DiscLanes, Exact, FixedStep, GoldenSecant,
};
use carom_geometry::Outline;
use carom_kinematics::RelativeMotion;

/// A detector, chosen at run time.
///
/// [`Self::Exact`] finds the same contacts as [`Exact`] but has no SIMD broad phase for molecules;
/// [`AnySimulation`](crate::AnySimulation) therefore runs [`Exact`] itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AnyDetector {
    /// The certified detector.
    Exact(Exact),
    /// The detector of the thesis.
    GoldenSecant(GoldenSecant),
    /// Overlap tests at regular times.
    FixedStep(FixedStep),
    /// The coarser model in which molecules are their bounding circles.
    BoundingCircles,
}

impl Default for AnyDetector {
    fn default() -> Self {
        Self::Exact(Exact::default())
    }
}

impl AnyDetector {
    /// Its name in Rust.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Exact(_) => "Exact",
            Self::GoldenSecant(_) => "GoldenSecant",
            Self::FixedStep(_) => "FixedStep",
            Self::BoundingCircles => "BoundingCircles",
        }
    }
}

impl Detection for AnyDetector {
    fn first_contact(&self, a: Outline<'_>, b: Outline<'_>, motion: &RelativeMotion, horizon: f64) -> Answer {
        match self {
            Self::Exact(detector) => detector.first_contact(a, b, motion, horizon),
            Self::GoldenSecant(detector) => detector.first_contact(a, b, motion, horizon),
            Self::FixedStep(detector) => detector.first_contact(a, b, motion, horizon),
            Self::BoundingCircles => BoundingCircles.first_contact(a, b, motion, horizon),
        }
    }

    #[inline]
    fn decides_discs_in_closed_form(&self) -> bool {
        match self {
            Self::Exact(detector) => detector.decides_discs_in_closed_form(),
            Self::GoldenSecant(detector) => detector.decides_discs_in_closed_form(),
            Self::FixedStep(detector) => detector.decides_discs_in_closed_form(),
            Self::BoundingCircles => BoundingCircles.decides_discs_in_closed_form(),
        }
    }

    fn disc_contacts(&self, lanes: &DiscLanes) -> [f64; DISC_LANES] {
        match self {
            Self::Exact(detector) => detector.disc_contacts(lanes),
            Self::GoldenSecant(detector) => detector.disc_contacts(lanes),
            Self::FixedStep(detector) => detector.disc_contacts(lanes),
            Self::BoundingCircles => BoundingCircles.disc_contacts(lanes),
        }
    }
}
