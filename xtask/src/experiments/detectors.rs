//! All detectors as one type, so that an experiment runs the same simulation with each.

use carom::{geometry::Outline, kinematics::RelativeMotion};
use carom_detection::{
    Answer, BoundingCircles, DISC_LANES, Detection, DiscLanes, Exact, FixedStep, GoldenSecant,
    encounters::Encounter, skim,
};

/// A detector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AnyDetector {
    /// The certified detector.
    Exact(Exact),
    /// The detector of the thesis.
    GoldenSecant(GoldenSecant),
    /// The detector with fixed steps.
    FixedStep(FixedStep),
    /// The coarser model of bounding circles.
    BoundingCircles,
}

impl AnyDetector {
    /// Its name.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Exact(_) => "Exact",
            Self::GoldenSecant(_) => "GoldenSecant",
            Self::FixedStep(_) => "FixedStep",
            Self::BoundingCircles => "BoundingCircles",
        }
    }

    /// Result for one encounter.
    pub fn search(&self, encounter: &Encounter) -> Answer {
        match self {
            Self::Exact(detector) => encounter.first_contact(detector),
            Self::GoldenSecant(detector) => encounter.first_contact(detector),
            Self::FixedStep(detector) => encounter.first_contact(detector),
            Self::BoundingCircles => encounter.first_contact(&BoundingCircles),
        }
    }

    /// Upper bound on the number of gap evaluations for an encounter; too expensive encounters are
    /// skipped.
    pub fn most_evaluations(&self, encounter: &Encounter) -> f64 {
        let [a, b] = encounter.molecules.each_ref().map(|molecule| molecule.atoms().len());
        let has_wall = encounter.molecules.iter().any(|molecule| molecule.face().is_some());
        let pairs = a * b + if has_wall { a + b } else { 0 };
        let window = skim(&encounter.motion, encounter.size(), encounter.horizon);
        let duration = window.map_or(0.0, |window| window.end - window.begin);
        let evaluations = match self {
            Self::Exact(_) | Self::BoundingCircles => return 0.0,
            Self::GoldenSecant(detector) => {
                let [a, b] = encounter.motion.angular_velocity.map(f64::abs);
                let quarters = duration * a.max(b) / std::f64::consts::FRAC_PI_2;
                let segments = (quarters / detector.crop_factor).ceil().max(1.0);
                // A golden section and a secant search take about five rounds for each decade of
                // tolerance.
                segments.min(f64::from(detector.most_segments)) * (8.0 - 5.0 * detector.tolerance.log10())
            }
            Self::FixedStep(detector) => {
                let steps = duration / (detector.step * encounter.natural_time());
                steps.min(f64::from(detector.most_steps))
            }
        };
        evaluations * pairs as f64
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
