//! The detectors that are compared, each at several settings.

use carom::{geometry::Outline, kinematics::RelativeMotion};
use carom_detection::{
    Answer, BoundingCircles, DISC_LANES, Detection, DiscLanes, Exact, FixedStep, GoldenSecant,
    encounters::Encounter,
    skim,
    tolerance::{MOST_FIXED_STEPS, MOST_STEPS},
};

/// A detector at one setting.
#[derive(Debug, Clone)]
pub struct Setting {
    /// Which detector.
    pub detector: Detector,
    /// The setting in words.
    pub name: String,
}

/// A detector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Detector {
    /// The certified one.
    Exact(Exact),
    /// The thesis's.
    GoldenSecant(GoldenSecant),
    /// The step-wise one.
    FixedStep(FixedStep),
    /// The coarser model.
    BoundingCircles,
}

impl Detector {
    /// Its name.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Exact(_) => "Exact",
            Self::GoldenSecant(_) => "GoldenSecant",
            Self::FixedStep(_) => "FixedStep",
            Self::BoundingCircles => "BoundingCircles",
        }
    }

    /// Its answer.
    pub fn ask(&self, encounter: &Encounter) -> Answer {
        match self {
            Self::Exact(detector) => encounter.ask(detector),
            Self::GoldenSecant(detector) => encounter.ask(detector),
            Self::FixedStep(detector) => encounter.ask(detector),
            Self::BoundingCircles => encounter.ask(&BoundingCircles),
        }
    }

    /// The most gaps that it may compute for an encounter; what costs too much is not asked.
    pub fn most_evaluations(&self, encounter: &Encounter) -> f64 {
        let [a, b] = encounter.molecules.each_ref().map(|molecule| molecule.atoms().len());
        let has_wall = encounter.molecules.iter().any(|molecule| molecule.face().is_some());
        let pairs = a * b + if has_wall { a + b } else { 0 };
        let window = skim(&encounter.motion, encounter.size(), encounter.horizon);
        let duration = window.map_or(0.0, |window| window.end - window.begin);
        let looks = match self {
            Self::Exact(_) | Self::BoundingCircles => return 0.0,
            Self::GoldenSecant(detector) => {
                let [a, b] = encounter.motion.angular_velocity.map(f64::abs);
                let quarters = duration * a.max(b) / std::f64::consts::FRAC_PI_2;
                let segments = (quarters / detector.crop_factor).ceil().max(1.0);
                // A golden section and a secant to a tolerance take some five rounds a decade.
                segments.min(f64::from(detector.most_segments)) * (8.0 - 5.0 * detector.tolerance.log10())
            }
            Self::FixedStep(detector) => {
                let steps = duration / (detector.step * encounter.natural_time());
                steps.min(f64::from(detector.most_steps))
            }
        };
        looks * pairs as f64
    }
}

/// Whichever it is: so that one type of simulation can be run with each.
impl Detection for Detector {
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

/// The settings; the first is the one that all others are compared with.
pub fn settings() -> Vec<Setting> {
    let mut settings =
        vec![Setting { detector: Detector::Exact(Exact::default()), name: format!("{MOST_STEPS} steps") }];
    for most_steps in [4, 16, 64] {
        let detector = Detector::Exact(Exact { most_steps });
        settings.push(Setting { detector, name: format!("{most_steps} steps") });
    }
    let golden = GoldenSecant::default();
    for (crop_factor, name) in [(0.5, "crop ½"), (1.0, "crop 1"), (2.0, "crop 2"), (4.0, "crop 4")] {
        let detector = Detector::GoldenSecant(GoldenSecant { crop_factor, ..golden });
        settings.push(Setting { detector, name: name.to_owned() });
    }
    for exponent in [12, 9, 6, 3] {
        let detector = Detector::GoldenSecant(GoldenSecant { tolerance: 10f64.powi(-exponent), ..golden });
        settings.push(Setting { detector, name: format!("crop ½, tol 1e-{exponent}") });
    }
    for exponent in [2, 3, 4, 5] {
        // Windows of a hundred natural times can be walked through at any step.
        let most_steps = MOST_FIXED_STEPS.max(100 * 10u32.pow(exponent as u32));
        let detector = Detector::FixedStep(FixedStep { step: 10f64.powi(-exponent), most_steps });
        settings.push(Setting { detector, name: format!("step 1e-{exponent}") });
    }
    settings.push(Setting { detector: Detector::BoundingCircles, name: "circles".to_owned() });
    settings
}

/// Where the pinned baseline stands among the settings: crop ½, tolerance 5 eps, earliest pair, one new evaluation per
/// golden-section step.
pub const BASELINE: usize = 4;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_baseline_is_the_thesis_as_repaired() {
        let settings = settings();
        assert_eq!(settings[0].detector, Detector::Exact(Exact::default()));
        assert_eq!(settings[BASELINE].detector, Detector::GoldenSecant(GoldenSecant::default()));
    }

    #[test]
    fn predicted_cost_is_an_upper_bound() {
        use carom_detection::encounters::Class;
        for setting in settings() {
            if matches!(setting.detector, Detector::Exact(_) | Detector::BoundingCircles) {
                continue;
            }
            for class in [Class::Generic, Class::ZeroOmega, Class::Grazing] {
                for index in 0..10 {
                    let encounter = Encounter::draw(class, 1, index);
                    let most = setting.detector.most_evaluations(&encounter);
                    if most > 1e6 {
                        continue;
                    }
                    let spent = f64::from(setting.detector.ask(&encounter).evaluations);
                    assert!(
                        spent <= 3.0 * most + 1000.0,
                        "{} {class} {index}: {spent} of {most}",
                        setting.name
                    );
                }
            }
        }
    }
}
