//! Points with error bars against a varied quantity, beside their predictions.

use anyhow::{Result, ensure};

use crate::{
    axis::{Axis, Scale, height, range},
    chart::{BESIDE, Chart, Layer, LayerShape},
    ink::Ink,
};

/// Half length of an error bar, in standard errors.
const BAR: f64 = 2.0;

/// Legend of [`MeasuredValue::guide`].
const GUIDES: &str = "crosses: not judged";

/// Space left and right of the points, as a share of their range.
const MARGIN: f64 = 0.05;

/// The quantity that is varied.
#[derive(Debug, Clone, PartialEq)]
pub enum Abscissa {
    /// Numbers.
    Linear,
    /// Positive numbers on a logarithmic axis.
    Logarithmic,
    /// Names; x is the index of a name.
    Names(Vec<String>),
}

/// A measured value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredValue {
    /// The varied quantity.
    pub x: f64,
    /// The measured quantity.
    pub y: f64,
    /// Its standard error.
    pub error: Option<f64>,
    /// Its prediction.
    pub prediction: Option<f64>,
    /// What a theory says that is no more than a guide here.
    pub guide: Option<f64>,
}

/// The values of one curve, in the order of x; a curve without values keeps its colour.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorBarCurve {
    /// Its name in the legend; may be empty if there is one.
    pub name: String,
    /// Its values.
    pub values: Vec<MeasuredValue>,
}

impl ErrorBarCurve {
    /// The points of its values that have a part, such as a prediction.
    fn points(&self, part: fn(&MeasuredValue) -> Option<f64>) -> Vec<(f64, f64)> {
        self.values
            .iter()
            .filter_map(|value| Some((value.x, part(value)?)))
            .collect()
    }
}

/// A chart of points with error bars of two standard errors.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorBars {
    /// Heading.
    pub title: String,
    /// Name and unit of the varied quantity.
    pub x_label: String,
    /// Name and unit of the measured quantity.
    pub y_label: String,
    /// Kind of the varied quantity.
    pub abscissa: Abscissa,
    /// The curves.
    pub curves: Vec<ErrorBarCurve>,
}

impl ErrorBars {
    /// Draws the chart as SVG.
    ///
    /// # Errors
    /// There are no values, or one is not finite or has no logarithm.
    pub fn svg(&self) -> Result<String> {
        let sound = |value: &MeasuredValue| {
            let is_placed = self.abscissa != Abscissa::Logarithmic || value.x > 0.0;
            value.x.is_finite() && value.y.is_finite() && is_placed
        };
        let mut values = self.values().peekable();
        ensure!(
            values.peek().is_some(),
            "chart '{}' has no points",
            self.title
        );
        for value in values {
            ensure!(sound(value), "chart '{}': {value:?}", self.title);
        }
        let (title, x, y) = (self.title.clone(), self.horizontal(), self.vertical());
        Chart {
            title,
            x,
            y,
            layers: self.layers(),
            size: BESIDE,
        }
        .svg()
    }

    fn values(&self) -> impl Iterator<Item = &MeasuredValue> {
        self.curves.iter().flat_map(|curve| &curve.values)
    }

    /// For each curve its predictions, guides, bars and dots.
    fn layers(&self) -> Vec<Layer> {
        let is_one = self.curves.len() == 1;
        let mut layers = Vec::new();
        // One entry for all predictions, and one for all guides.
        let (mut rings, mut crosses) = (
            if is_one {
                "predicted"
            } else {
                "rings: predicted"
            },
            GUIDES,
        );
        for (index, curve) in self
            .curves
            .iter()
            .enumerate()
            .filter(|(_, curve)| !curve.values.is_empty())
        {
            let ink = Ink::of_curve(index, self.curves.len());
            let theory = if is_one { Ink::Vermillion } else { ink };
            layers.extend(self.theory_layers(curve, theory, [&mut rings, &mut crosses]));
            layers.extend(self.measured_layers(curve, ink));
        }
        layers
    }

    /// The predictions and guides of a curve. The first ones take the names of rings and crosses,
    /// and leave none for later curves.
    fn theory_layers(
        &self,
        curve: &ErrorBarCurve,
        ink: Ink,
        [rings, crosses]: [&mut &str; 2],
    ) -> Vec<Layer> {
        let mut layers = Vec::new();
        let predicted = curve.points(|value| value.prediction);
        if !predicted.is_empty() {
            if !matches!(self.abscissa, Abscissa::Names(_)) {
                layers.push(layer("", ink, LayerShape::Thin(predicted.clone())));
            }
            let name = std::mem::take(rings);
            layers.push(layer(name, ink, LayerShape::Rings(predicted)));
        }
        let guides = curve.points(|value| value.guide);
        if !guides.is_empty() {
            let name = std::mem::take(crosses);
            layers.push(layer(name, ink, LayerShape::Crosses(guides)));
        }
        layers
    }

    /// The error bars and dots of a curve.
    fn measured_layers(&self, curve: &ErrorBarCurve, ink: Ink) -> [Layer; 2] {
        let bar = |value: &MeasuredValue| {
            let half = BAR * value.error?;
            Some((value.x, value.y - half, value.y + half))
        };
        let bars = curve.values.iter().filter_map(bar).collect();
        let is_predicted = self.values().any(|value| value.prediction.is_some());
        let name = if curve.name.is_empty() && is_predicted {
            "measured"
        } else {
            &curve.name
        };
        let dots = curve.points(|value| Some(value.y));
        [
            layer("", ink, LayerShape::Bars(bars)),
            layer(name, ink, LayerShape::Dots(dots)),
        ]
    }

    fn horizontal(&self) -> Axis {
        let (low, high) = range(self.values().map(|value| value.x)).unwrap_or_default();
        match &self.abscissa {
            Abscissa::Names(names) => Axis::of_names(&self.x_label, names.clone()),
            Abscissa::Linear => {
                let room = if high > low {
                    MARGIN * (high - low)
                } else {
                    0.5 * high.abs().max(1e-300)
                };
                Axis::new(&self.x_label, (low - room, high + room))
            }
            Abscissa::Logarithmic => {
                let room = (high / low).powf(MARGIN).max(1.12);
                Axis {
                    scale: Scale::Logarithmic,
                    ..Axis::new(&self.x_label, (low / room, high * room))
                }
            }
        }
    }

    fn vertical(&self) -> Axis {
        let heights = self.values().flat_map(|value| {
            let half = BAR * value.error.unwrap_or(0.0);
            let theory = [value.prediction, value.guide];
            [Some(value.y - half), Some(value.y + half)]
                .into_iter()
                .chain(theory)
                .flatten()
        });
        let (low, high) = range(heights.filter(|height| height.is_finite())).unwrap_or_default();
        Axis::new(&self.y_label, height(low, high))
    }
}

/// A layer of a chart; one with an empty name is not in the legend.
fn layer(name: &str, ink: Ink, shape: LayerShape) -> Layer {
    Layer {
        name: name.to_owned(),
        ink,
        shape,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(abscissa: &Abscissa, curves: usize) -> ErrorBars {
        let value = |x: f64| MeasuredValue {
            x,
            y: 2.0 * x,
            error: Some(0.1),
            prediction: Some(2.1 * x),
            guide: None,
        };
        let curve = |index| ErrorBarCurve {
            name: format!("curve <{index}>"),
            values: [0.0, 1.0, 2.0]
                .map(|x| value(x + f64::from(u8::from(*abscissa == Abscissa::Logarithmic))))
                .to_vec(),
        };
        ErrorBars {
            title: "a & b".to_owned(),
            x_label: "x".to_owned(),
            y_label: "y".to_owned(),
            curves: (0..curves).map(curve).collect(),
            abscissa: abscissa.clone(),
        }
    }

    #[test]
    fn every_value_has_a_dot_a_bar_and_a_ring() {
        let names = Abscissa::Names(["disc", "rod", "tee"].map(str::to_owned).to_vec());
        let many = (Abscissa::Linear, 8);
        for (abscissa, curves) in [
            (Abscissa::Linear, 1),
            (Abscissa::Logarithmic, 3),
            (names, 2),
            many,
        ] {
            let svg = chart(&abscissa, curves).svg().unwrap();
            // Two circles a value, one for each name in the legend, and one for the predictions.
            assert_eq!(
                svg.matches("<circle").count(),
                2 * 3 * curves + curves + 1,
                "{abscissa:?}"
            );
            assert!(
                svg.contains("curve &lt;0&gt;")
                    && svg.contains("predicted")
                    && !svg.contains("NaN")
            );
            assert_eq!(svg.contains("rod"), matches!(abscissa, Abscissa::Names(_)));
        }
    }

    #[test]
    fn guides_are_crosses_within_the_chart() {
        for curves in [1, 3, 8] {
            let mut chart = chart(&Abscissa::Linear, curves);
            assert!(!chart.svg().unwrap().contains(GUIDES));
            chart.curves[0].values[1].guide = Some(50.0);
            assert!(chart.svg().unwrap().contains(GUIDES) && chart.vertical().range.1 >= 50.0);
        }
    }

    #[test]
    fn a_chart_without_points_or_logarithms_is_refused() {
        assert!(chart(&Abscissa::Linear, 0).svg().is_err());
        let mut negative = chart(&Abscissa::Logarithmic, 1);
        negative.curves[0].values[0].x = -1.0;
        assert!(negative.svg().is_err());
        for abscissa in [Abscissa::Linear, Abscissa::Logarithmic] {
            let mut one = chart(&abscissa, 1);
            one.curves[0].values.truncate(1);
            one.svg().unwrap();
        }
    }
}
