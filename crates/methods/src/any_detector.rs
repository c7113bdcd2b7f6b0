//! All detectors as one type, so that a run can use any of them.

#![allow(
    clippy::inline_always,
    reason = "compiled with the instructions of the loop over the events"
)]

use carom_detection::{
    Answer, BoundingCircles, DISC_LANES, Detection, DiscLanes, Exact, FixedStep, GoldenSecant,
    QueryBody,
};
use carom_geometry::Outline;
use carom_kinematics::{Drive, RelativeMotion};

/// A detector, chosen at run time.
///
/// Each finds the contacts of the detector of its name, with the same broad phase. The choice costs
/// a branch that is always predicted, and all loops over events are compiled once.
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

/// Calls a method of the detector that this is.
macro_rules! delegate {
    ($self:ident, $detector:ident => $call:expr) => {
        match $self {
            Self::Exact($detector) => $call,
            Self::GoldenSecant($detector) => $call,
            Self::FixedStep($detector) => $call,
            Self::BoundingCircles => {
                let $detector = &BoundingCircles;
                $call
            }
        }
    };
}

impl Detection for AnyDetector {
    #[inline]
    fn first_contact(
        &self,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Answer {
        delegate!(self, detector => detector.first_contact(a, b, motion, horizon))
    }

    #[inline]
    fn first_contact_after(
        &self,
        begin: f64,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Answer {
        delegate!(self, detector => detector.first_contact_after(begin, a, b, motion, horizon))
    }

    #[inline(always)]
    fn contact_time_lower_bounds<const N: usize>(
        &self,
        query: &QueryBody<'_>,
        lanes: &DiscLanes<N>,
        horizon: f64,
    ) -> [f64; N] {
        delegate!(self, detector => detector.contact_time_lower_bounds(query, lanes, horizon))
    }

    #[inline(always)]
    fn contact_time_lower_bound(
        &self,
        query: &QueryBody<'_>,
        lanes: &DiscLanes<1>,
        horizon: f64,
    ) -> f64 {
        delegate!(self, detector => detector.contact_time_lower_bound(query, lanes, horizon))
    }

    fn searches_driven_bodies(&self) -> bool {
        delegate!(self, detector => detector.searches_driven_bodies())
    }

    fn first_contact_driven(
        &self,
        begin: f64,
        bodies: [Outline<'_>; 2],
        motion: &RelativeMotion,
        drive: (&Drive, f64),
        horizon: f64,
    ) -> Answer {
        delegate!(self, detector => detector.first_contact_driven(begin, bodies, motion, drive, horizon))
    }

    fn searches_turning_walls(&self) -> bool {
        delegate!(self, detector => detector.searches_turning_walls())
    }

    fn searches_curves(&self) -> bool {
        delegate!(self, detector => detector.searches_curves())
    }

    #[inline(always)]
    fn decides_discs_in_closed_form(&self) -> bool {
        delegate!(self, detector => detector.decides_discs_in_closed_form())
    }

    #[inline]
    fn disc_contacts(&self, lanes: &DiscLanes) -> [f64; DISC_LANES] {
        delegate!(self, detector => detector.disc_contacts(lanes))
    }
}
