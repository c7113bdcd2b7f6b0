//! Measured figures against their predictions, with a verdict on each.

use carom_tables::{Check, Figure, Summary};

use super::scenes::{Case, DENSITIES};

/// A figure passes if it is within this many standard errors of its prediction, theory included.
/// Of 60 figures one exceeds 4 by chance in one of 260 experiments.
pub const ALLOWED: f64 = 4.0;

/// Uncertainty of predictions without their own (relative): finite-size terms of second order, and
/// for the contact value the curvature of g(r) over the first bins.
const OF_THEORY: f64 = 3e-3;

/// The figures of one scene.
pub struct Measured {
    /// The scene.
    pub case: Case,
    /// What it gave.
    pub summary: Summary,
}

impl Measured {
    /// The figures with a prediction and an error, by name of the scene.
    pub fn figures(&self) -> Vec<Figure> {
        let named = |figure: &Figure| Figure {
            name: format!("{}: {}", self.case.name, figure.name),
            ..figure.clone()
        };
        let mut figures: Vec<Figure> =
            self.summary.figures.iter().filter(|figure| is_tested(figure)).map(named).collect();
        if let Some([published, _]) = self.case.published
            && let Some(pressure) = self.summary.figures.iter().find(|figure| figure.name == "pressure")
        {
            // kT = 1 and d = 1, so that the pressure is β p d².
            let source = "Li et al. (2022)";
            figures = vec![
                named(&Figure { name: "β p d²".to_owned(), ..pressure.clone() }).predicted(published, source),
            ];
        }
        if self.case.name.contains("tees") {
            let kt = self.summary.figures.iter().filter(|figure| figure.name.starts_with("kT of"));
            figures.extend(kt.map(|figure| named(figure).predicted(1.0, "equipartition")));
        }
        figures
    }

    /// The deviation of each figure from its prediction, in standard errors.
    pub fn deviations(&self) -> Vec<(Figure, f64)> {
        let of = |figure: Figure| {
            let (prediction, error) = (figure.prediction?, figure.standard_error?);
            let theory = self.uncertainty(&figure) * prediction.abs();
            let deviation = (figure.value - prediction).abs() / error.hypot(theory);
            Some((figure, deviation))
        };
        self.figures().into_iter().filter_map(of).collect()
    }

    /// Uncertainty of the prediction of a figure (relative).
    fn uncertainty(&self, figure: &Figure) -> f64 {
        if let Some([published, error]) = self.case.published {
            return error / published;
        }
        if figure.name.contains("kT of") || figure.name.contains("p_xy") || figure.name.contains("p_yx") {
            return 0.0;
        }
        let density =
            DENSITIES.iter().find(|(fraction, _)| self.case.name.ends_with(&format!(" {fraction}")));
        let is_pressure = figure.name.contains("pressure") || figure.name.contains("compressibility");
        match density {
            Some((_, uncertainty)) if is_pressure => *uncertainty,
            _ => OF_THEORY,
        }
    }
}

/// Whether a figure of hard discs is tested: transport coefficients depend on the size of the box.
fn is_tested(figure: &Figure) -> bool {
    figure.prediction.is_some() && !["diffusion", "viscosity"].iter().any(|word| figure.name.contains(word))
}

/// A check of each figure.
pub fn checks(all: &[Measured]) -> Vec<Check> {
    let deviations = all.iter().flat_map(Measured::deviations);
    deviations
        .map(|(figure, off)| Check::at_most(&format!("{} (standard errors)", figure.name), off, ALLOWED))
        .collect()
}
