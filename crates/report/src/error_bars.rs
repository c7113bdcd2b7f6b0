//! Points with error bars against a varied quantity, beside their predictions.

use anyhow::{Result, ensure};
use plotters::{
    coord::{
        Shift,
        ranged1d::{DefaultFormatting, KeyPointHint, Ranged},
        types::RangedCoordf64,
    },
    prelude::*,
};

use crate::{
    canvas::{self, Side},
    plot::{colour, height, marks, tick},
};

/// Width and height (pixels): two charts fit side by side, and the text of one is readable on a
/// narrow screen.
const SIZE: (u32, u32) = (600, 400);

/// Half length of an error bar, in standard errors.
const BAR: f64 = 2.0;

/// Colours of the curves, in order.
const COLOURS: [RGBColor; 6] =
    [colour::BLUE, colour::GREEN, colour::ORANGE, colour::PURPLE, RGBColor(0, 0, 0), RGBColor(86, 180, 233)];

/// Ends and middle of the colours of more curves than [`COLOURS`], from the first to the last.
const SEQUENCE: [[f64; 3]; 3] = [[60.0, 10.0, 110.0], [30.0, 145.0, 140.0], [215.0, 170.0, 20.0]];

/// Most entries of a legend inside the chart; more are beside it.
const MOST_INSIDE: usize = 4;

/// Width of a legend beside the chart, distance of its lines and height of the first (pixels), and
/// the most lines.
const LEGEND_WIDTH: u32 = 190;
const LINE: i32 = 22;
const FIRST_LINE: i32 = 46;
const MOST_LINES: usize = 15;

/// Width of a letter in units of the height of the text, and of what lies beside the axis of names
/// (pixels).
const WIDTH_OF_LETTER: f64 = 0.55;
const FRAME: f64 = 110.0;

/// Legend of [`Value::guide`].
const GUIDES: &str = "crosses: not judged";

/// Space left and right of the points, as a share of their range.
const ROOM: f64 = 0.05;

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
pub struct Value {
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
pub struct Curve {
    /// Its name in the legend; may be empty if there is one.
    pub name: String,
    /// Its values.
    pub values: Vec<Value>,
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
    pub curves: Vec<Curve>,
}

/// An axis with tick marks at given places.
struct Scale {
    range: (f64, f64),
    places: Vec<f64>,
    pixels: RangedCoordf64,
}

impl Scale {
    fn new(range: (f64, f64), places: Vec<f64>) -> Self {
        Self { range, places, pixels: (range.0..range.1).into() }
    }
}

impl Ranged for Scale {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.pixels.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.places.clone()
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.range.0..self.range.1
    }
}

impl ErrorBars {
    /// Draws the chart as SVG.
    ///
    /// # Errors
    /// There are no values, or one is not finite or has no logarithm.
    pub fn svg(&self) -> Result<String> {
        let sound = |value: &Value| {
            let is_placed = self.abscissa != Abscissa::Logarithmic || value.x > 0.0;
            value.x.is_finite() && value.y.is_finite() && is_placed
        };
        let mut values = self.values().peekable();
        ensure!(values.peek().is_some(), "chart '{}' has no points", self.title);
        for value in values {
            ensure!(sound(value), "chart '{}': {value:?}", self.title);
        }
        let width = SIZE.0 + if self.is_legend_beside() { LEGEND_WIDTH } else { 0 };
        canvas::svg(&self.title, (width, SIZE.1), |root| self.draw(root))
    }

    fn values(&self) -> impl Iterator<Item = &Value> {
        self.curves.iter().flat_map(|curve| &curve.values)
    }

    /// The place of a value along the horizontal axis.
    fn place(&self, x: f64) -> f64 {
        if self.abscissa == Abscissa::Logarithmic { x.log10() } else { x }
    }

    fn draw(&self, root: &DrawingArea<SVGBackend<'_>, Shift>) -> Result<()> {
        let (x, y) = (self.horizontal(), self.vertical());
        let x_range = x.range;
        let y_range = y.range;
        let x_format = |value: &f64| self.words(*value, x_range);
        let y_format = |value: &f64| tick(*value, y_range);
        let x = Side { scale: x, label: &self.x_label, format: &x_format };
        let y = Side { scale: y, label: &self.y_label, format: &y_format };
        let is_beside = self.is_legend_beside();
        let (plot, strip) = root.split_horizontally(SIZE.0);
        let mut chart = canvas::plane(if is_beside { &plot } else { root }, &self.title, x, y)?;
        let is_predicted = self.values().any(|value| value.prediction.is_some());
        let mut is_explained = false;
        let has_guide = |curve: &Curve| curve.values.iter().any(|value| value.guide.is_some());
        let first_guide = self.curves.iter().position(has_guide).unwrap_or(usize::MAX);
        for (index, curve) in self.curves.iter().enumerate().filter(|(_, curve)| !curve.values.is_empty()) {
            let ink = self.ink(index);
            let theory = if self.curves.len() == 1 { colour::VERMILLION } else { ink };
            let predicted = curve.values.iter().filter_map(|v| Some((self.place(v.x), v.prediction?)));
            let predicted: Vec<(f64, f64)> = predicted.collect();
            if !matches!(self.abscissa, Abscissa::Names(_)) {
                chart.draw_series(LineSeries::new(predicted.iter().copied(), theory.stroke_width(1)))?;
            }
            let rings = predicted.iter().map(|&at| Circle::new(at, 7, theory.stroke_width(1)));
            let rings = chart.draw_series(rings)?;
            if is_predicted && !is_explained {
                is_explained = true;
                let (name, theory) =
                    if self.curves.len() == 1 { ("predicted", theory) } else { ("rings: predicted", BLACK) };
                rings.label(name).legend(move |(x, y)| Circle::new((x + 9, y), 6, theory.stroke_width(1)));
            }
            let guides = curve.values.iter().filter_map(|v| Some((self.place(v.x), v.guide?)));
            let crosses = guides.map(|at| Cross::new(at, 5, theory.stroke_width(1)));
            let crosses = chart.draw_series(crosses)?;
            if index == first_guide {
                let ink = if self.curves.len() == 1 { theory } else { BLACK };
                crosses.label(GUIDES).legend(move |(x, y)| Cross::new((x + 9, y), 5, ink.stroke_width(1)));
            }
            let bars = curve.values.iter().filter_map(|value| {
                let (x, half) = (self.place(value.x), BAR * value.error?);
                Some(PathElement::new(vec![(x, value.y - half), (x, value.y + half)], ink.stroke_width(2)))
            });
            chart.draw_series(bars)?;
            let dots = curve.values.iter().map(|v| Circle::new((self.place(v.x), v.y), 4, ink.filled()));
            let dots = chart.draw_series(dots)?;
            let name = if curve.name.is_empty() && is_predicted { "measured" } else { &curve.name };
            if !name.is_empty() {
                dots.label(name).legend(move |(x, y)| Circle::new((x + 9, y), 4, ink.filled()));
            }
        }
        if is_beside {
            return self.legend_beside(&strip);
        }
        if self.entries() > 0 {
            canvas::legend(&mut chart, SeriesLabelPosition::UpperRight)?;
        }
        Ok(())
    }

    /// The colour of a curve: one of [`COLOURS`], or of many curves one of a sequence.
    fn ink(&self, curve: usize) -> RGBColor {
        if self.curves.len() <= COLOURS.len() {
            return COLOURS[curve];
        }
        let place = 2.0 * curve as f64 / (self.curves.len() - 1) as f64;
        let part = usize::from(place > 1.0);
        let share = place - part as f64;
        let mixed = |i: usize| SEQUENCE[part][i] * (1.0 - share) + SEQUENCE[part + 1][i] * share;
        let [red, green, blue] = [0, 1, 2].map(|i| mixed(i).round() as u8);
        RGBColor(red, green, blue)
    }

    fn is_legend_beside(&self) -> bool {
        self.entries() > MOST_INSIDE
    }

    /// A line for each curve, and one for the predictions.
    fn legend_beside(&self, strip: &DrawingArea<SVGBackend<'_>, Shift>) -> Result<()> {
        let font = || (canvas::FONT, canvas::TEXT).into_font();
        let mut height = FIRST_LINE;
        let mut line = |ink: RGBColor, is_dot: bool, name: &str| -> Result<()> {
            let style = if is_dot { ink.filled() } else { ink.stroke_width(1) };
            strip.draw(&Circle::new((14, height), if is_dot { 4 } else { 6 }, style))?;
            strip.draw(&Text::new(name.to_owned(), (28, height - 9), font()))?;
            height += LINE;
            Ok(())
        };
        let drawn = self.curves.iter().enumerate().filter(|(_, curve)| !curve.values.is_empty());
        let drawn: Vec<(usize, &Curve)> = drawn.collect();
        for &(index, curve) in drawn.iter().take(MOST_LINES) {
            line(self.ink(index), true, &curve.name)?;
        }
        if self.values().any(|value| value.prediction.is_some()) {
            line(BLACK, false, "rings: predicted")?;
        }
        if self.has_guides() {
            strip.draw(&Cross::new((14, height), 5, BLACK.stroke_width(1)))?;
            strip.draw(&Text::new(GUIDES, (28, height - 9), font()))?;
            height += LINE;
        }
        if drawn.len() > MOST_LINES {
            let more = format!("and {} more", drawn.len() - MOST_LINES);
            strip.draw(&Text::new(more, (28, height - 9), font()))?;
        }
        Ok(())
    }

    /// Number of entries of the legend.
    fn entries(&self) -> usize {
        let is_predicted = self.values().any(|value| value.prediction.is_some());
        let drawn = self.curves.iter().filter(|curve| !curve.values.is_empty());
        let named = drawn.filter(|curve| is_predicted || !curve.name.is_empty()).count();
        named + usize::from(is_predicted) + usize::from(self.has_guides())
    }

    fn has_guides(&self) -> bool {
        self.values().any(|value| value.guide.is_some())
    }

    fn horizontal(&self) -> Scale {
        let (low, high) = range(self.values().map(|value| self.place(value.x)));
        match &self.abscissa {
            Abscissa::Names(names) => {
                let last = names.len() as f64 - 0.5;
                let every = apart(names);
                let marks = (0..names.len()).step_by(every).map(|index| index as f64);
                Scale::new((-0.5, last), marks.collect())
            }
            Abscissa::Linear => {
                let room = if high > low { ROOM * (high - low) } else { 0.5 * high.abs().max(1e-300) };
                let range = (low - room, high + room);
                Scale::new(range, marks(range))
            }
            Abscissa::Logarithmic => {
                let room = (ROOM * (high - low)).max(0.05);
                let range = (low - room, high + room);
                Scale::new(range, decades(range))
            }
        }
    }

    /// The vertical axis, with room for the legend above the points.
    fn vertical(&self) -> Scale {
        let heights = self.values().flat_map(|value| {
            let half = BAR * value.error.unwrap_or(0.0);
            let theory = [value.prediction, value.guide];
            [Some(value.y - half), Some(value.y + half)].into_iter().chain(theory).flatten()
        });
        let (low, high) = range(heights.filter(|height| height.is_finite()));
        let (low, high) = height(low, high);
        let inside = if self.is_legend_beside() { 0 } else { self.entries() };
        let legend = inside as f64 * 1.3 * canvas::TEXT;
        let share = if inside > 0 { (20.0 + legend) / (f64::from(SIZE.1) - 102.0) } else { 0.0 };
        let range = (low, high + (high - low) * share.min(0.6) / (1.0 - share.min(0.6)));
        Scale::new(range, marks(range))
    }

    /// The words at a tick mark of the horizontal axis.
    fn words(&self, place: f64, range: (f64, f64)) -> String {
        match &self.abscissa {
            Abscissa::Linear => tick(place, range),
            Abscissa::Logarithmic => {
                let value = 10f64.powf(place);
                let digits = format!("{value:.0e}");
                if (1e-3..1e5).contains(&value) {
                    digits.parse().unwrap_or(value).to_string()
                } else {
                    digits
                }
            }
            Abscissa::Names(names) => names.get(place.round() as usize).cloned().unwrap_or_default(),
        }
    }
}

/// Distance between two names that are written below the axis, so that they do not overlap: 1 if
/// there is room for all.
fn apart(names: &[String]) -> usize {
    let longest = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
    let width = WIDTH_OF_LETTER * canvas::TEXT * (longest + 1) as f64 * names.len() as f64;
    (width / (f64::from(SIZE.0) - FRAME)).ceil().max(1.0) as usize
}

/// Tick marks of a logarithmic axis, as decimal logarithms: powers of ten, with 2 and 5 between
/// them where there are few.
fn decades((low, high): (f64, f64)) -> Vec<f64> {
    let factors: &[f64] = if high - low < 2.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let powers = low.floor() as i32..=high.ceil() as i32;
    let places = powers.flat_map(|power| factors.iter().map(move |f| f64::from(power) + f.log10()));
    places.filter(|place| (low..=high).contains(place)).collect()
}

/// Least and largest value; 0 and 0 without values.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let ends = values.fold(None, |range: Option<(f64, f64)>, value| {
        Some(range.map_or((value, value), |(low, high)| (low.min(value), high.max(value))))
    });
    ends.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_would_overlap_are_left_out() {
        let names = |count: usize, name: &str| vec![name.to_owned(); count];
        assert_eq!(apart(&names(3, "disc")), 1);
        let many = names(11, "224 at 0.702");
        let shown = many.len().div_ceil(apart(&many));
        assert!((3..=6).contains(&shown), "{shown}");
        assert_eq!(apart(&[]), 1);
    }

    fn chart(abscissa: &Abscissa, curves: usize) -> ErrorBars {
        let value =
            |x: f64| Value { x, y: 2.0 * x, error: Some(0.1), prediction: Some(2.1 * x), guide: None };
        let curve = |index| Curve {
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
        for (abscissa, curves) in [(Abscissa::Linear, 1), (Abscissa::Logarithmic, 3), (names, 2), many] {
            let svg = chart(&abscissa, curves).svg().unwrap();
            // Two circles a value, one for each name in the legend, and one for the predictions.
            assert_eq!(svg.matches("<circle").count(), 2 * 3 * curves + curves + 1, "{abscissa:?}");
            assert!(svg.contains("curve &lt;0&gt;") && svg.contains("predicted") && !svg.contains("NaN"));
            assert_eq!(svg.contains("rod"), matches!(abscissa, Abscissa::Names(_)));
        }
    }

    #[test]
    fn guides_are_crosses_within_the_chart() {
        for curves in [1, 3, 8] {
            let mut chart = chart(&Abscissa::Linear, curves);
            let before = (chart.svg().unwrap(), chart.vertical().range.1);
            assert!(!before.0.contains(GUIDES));
            chart.curves[0].values[1].guide = Some(50.0);
            assert!(chart.svg().unwrap().contains(GUIDES) && chart.vertical().range.1 >= 50.0);
        }
    }

    #[test]
    fn many_curves_have_different_colours_and_a_bounded_legend() {
        let many = chart(&Abscissa::Linear, 40);
        let inks: std::collections::BTreeSet<_> =
            (0..40).map(|curve| many.ink(curve)).map(|c| (c.0, c.1, c.2)).collect();
        assert_eq!(inks.len(), 40);
        assert!(many.svg().unwrap().contains("and 25 more"));
        assert_eq!(chart(&Abscissa::Linear, 6).ink(0), COLOURS[0]);
    }

    #[test]
    fn a_chart_without_points_or_logarithms_is_refused() {
        assert!(chart(&Abscissa::Linear, 0).svg().is_err());
        let mut negative = chart(&Abscissa::Logarithmic, 1);
        negative.curves[0].values[0].x = -1.0;
        assert!(negative.svg().is_err());
        let mut one = chart(&Abscissa::Linear, 1);
        one.curves[0].values.truncate(1);
        one.svg().unwrap();
    }

    #[test]
    fn short_logarithmic_axes_have_more_marks() {
        let near = |found: Vec<f64>, expected: &[f64]| {
            assert_eq!(found.len(), expected.len(), "{found:?}");
            assert!(found.iter().zip(expected).all(|(a, b)| (10f64.powf(*a) / b - 1.0).abs() < 1e-12));
        };
        near(decades((-1.1, 0.1)), &[0.1, 0.2, 0.5, 1.0]);
        near(decades((0.0, 3.0)), &[1.0, 10.0, 100.0, 1000.0]);
    }
}
