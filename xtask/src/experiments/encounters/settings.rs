//! The compared detectors, each at several settings.

use carom_detection::{
    Exact, FixedStep, GoldenSecant,
    tolerance::{MAX_FIXED_STEPS, MAX_STEPS},
};

use carom_methods::AnyDetector;

/// A detector at one setting.
#[derive(Debug, Clone)]
pub struct DetectorSetting {
    /// The detector.
    pub detector: AnyDetector,
    /// Description of the setting.
    pub name: String,
}

/// The settings; the first is the reference of all others.
pub fn settings() -> Vec<DetectorSetting> {
    let mut settings = vec![DetectorSetting {
        detector: AnyDetector::Exact(Exact::default()),
        name: format!("{MAX_STEPS} steps"),
    }];
    for most_steps in [4, 16, 64] {
        let detector = AnyDetector::Exact(Exact { most_steps });
        settings.push(DetectorSetting {
            detector,
            name: format!("{most_steps} steps"),
        });
    }
    let golden = GoldenSecant::default();
    for (crop_factor, name) in [
        (0.5, "crop ½"),
        (1.0, "crop 1"),
        (2.0, "crop 2"),
        (4.0, "crop 4"),
    ] {
        let detector = AnyDetector::GoldenSecant(GoldenSecant {
            crop_factor,
            ..golden
        });
        settings.push(DetectorSetting {
            detector,
            name: name.to_owned(),
        });
    }
    for exponent in [12, 9, 6, 3] {
        let detector = AnyDetector::GoldenSecant(GoldenSecant {
            tolerance: 10f64.powi(-exponent),
            ..golden
        });
        settings.push(DetectorSetting {
            detector,
            name: format!("crop ½, tol 1e-{exponent}"),
        });
    }
    for exponent in [2, 3, 4, 5] {
        // Enough steps for windows of a hundred natural times at any step size.
        let most_steps = MAX_FIXED_STEPS.max(100 * 10u32.pow(exponent as u32));
        let detector = AnyDetector::FixedStep(FixedStep {
            step: 10f64.powi(-exponent),
            most_steps,
        });
        settings.push(DetectorSetting {
            detector,
            name: format!("step 1e-{exponent}"),
        });
    }
    settings.push(DetectorSetting {
        detector: AnyDetector::BoundingCircles,
        name: "circles".to_owned(),
    });
    settings
}

/// Index of the baseline: crop ½, tolerance 5 eps, earliest pair, one new evaluation per
/// golden-section step.
pub const BASELINE: usize = 4;

#[cfg(test)]
mod tests {
    use super::super::cost::most_evaluations;
    use super::*;
    use carom_detection::encounters::Encounter;

    #[test]
    fn the_baseline_is_the_corrected_search_of_the_thesis() {
        let settings = settings();
        assert_eq!(settings[0].detector, AnyDetector::Exact(Exact::default()));
        assert_eq!(
            settings[BASELINE].detector,
            AnyDetector::GoldenSecant(GoldenSecant::default())
        );
    }

    #[test]
    fn predicted_cost_is_an_upper_bound() {
        use carom_detection::encounters::Class;
        for setting in settings() {
            if matches!(
                setting.detector,
                AnyDetector::Exact(_) | AnyDetector::BoundingCircles
            ) {
                continue;
            }
            for class in [
                Class::Generic,
                Class::ZeroOmega,
                Class::Grazing,
                Class::Squares,
                Class::TurningWall,
            ] {
                for index in 0..10 {
                    let encounter = Encounter::draw(class, 1, index);
                    let most = most_evaluations(&setting.detector, &encounter);
                    if most > 1e6 {
                        continue;
                    }
                    let spent = f64::from(encounter.first_contact(&setting.detector).evaluations);
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
