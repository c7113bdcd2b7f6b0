//! The cost of a search before it is run.

use carom_detection::{encounters::Encounter, skim};
use carom_methods::AnyDetector;

/// Upper bound on the number of gap evaluations for an encounter; too expensive encounters are
/// skipped.
pub fn most_evaluations(detector: &AnyDetector, encounter: &Encounter) -> f64 {
    let [a, b] = &encounter.molecules;
    let (atoms_a, atoms_b) = (a.atoms().len(), b.atoms().len());
    let pairs = atoms_a * atoms_b + atoms_a * b.edges().len() + atoms_b * a.edges().len();
    let window = skim(&encounter.motion, encounter.size(), encounter.horizon);
    let duration = window.map_or(0.0, |window| window.end - window.begin);
    let evaluations = match detector {
        AnyDetector::Exact(_) | AnyDetector::BoundingCircles => return 0.0,
        AnyDetector::GoldenSecant(detector) => {
            let [a, b] = encounter.motion.angular_velocity.map(f64::abs);
            let quarters = duration * a.max(b) / std::f64::consts::FRAC_PI_2;
            let segments = (quarters / detector.crop_factor).ceil().max(1.0);
            // A golden section and a secant search take about five rounds for each decade of
            // tolerance.
            segments.min(f64::from(detector.most_segments))
                * (8.0 - 5.0 * detector.tolerance.log10())
        }
        AnyDetector::FixedStep(detector) => {
            let steps = duration / (detector.step * encounter.natural_time());
            steps.min(f64::from(detector.most_steps))
        }
    };
    evaluations * pairs as f64
}
