//! Charts as SVG: lines and bands on two linear axes, in colours that colour-blind readers can
//! distinguish.

use anyhow::Result;
use carom_tables::Spacing;
use plotters::{
    coord::{
        Shift,
        ranged1d::{DefaultFormatting, KeyPointHint, Ranged},
        types::RangedCoordf64,
    },
    prelude::*,
};

use crate::canvas::{self, Plane, Side};

/// Colours of Okabe and Ito (2008), "Color universal design".
pub mod colour {
    use plotters::style::RGBColor;

    /// For measured values.
    pub const BLUE: RGBColor = RGBColor(0, 114, 178);
    /// For predictions.
    pub const VERMILLION: RGBColor = RGBColor(213, 94, 0);
    /// For a second measured quantity.
    pub const GREEN: RGBColor = RGBColor(0, 158, 115);
    /// For a third measured quantity.
    pub const ORANGE: RGBColor = RGBColor(230, 159, 0);
    /// For a fourth measured quantity.
    pub const PURPLE: RGBColor = RGBColor(204, 121, 167);
}

/// An axis: quantity, unit and range.
#[derive(Debug, Clone)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// First and last value.
    pub range: (f64, f64),
}

/// One curve or band of a chart.
#[derive(Debug, Clone)]
pub struct Layer {
    /// Name in the legend; empty for none.
    pub name: String,
    /// Its colour.
    pub colour: RGBColor,
    /// Its shape.
    pub shape: Shape,
}

/// The shape of a layer, in the units of the axes.
#[derive(Debug, Clone)]
pub enum Shape {
    /// A line through points.
    Line(Vec<(f64, f64)>),
    /// A line of half the width, for approximate values.
    Thin(Vec<(f64, f64)>),
    /// The area between a lower and an upper line: x, lower, upper.
    Band(Vec<(f64, f64, f64)>),
}

/// A chart with two linear axes.
#[derive(Debug, Clone)]
pub struct Chart {
    /// Heading.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// From back to front.
    pub layers: Vec<Layer>,
}

/// Points of a step function with `values` in equal bins from `first` to `last`.
pub fn staircase(first: f64, last: f64, values: &[f64]) -> Vec<(f64, f64)> {
    let edge = |index: usize| first + (last - first) * index as f64 / values.len() as f64;
    values.iter().enumerate().flat_map(|(index, &y)| [(edge(index), y), (edge(index + 1), y)]).collect()
}

/// Width and height (pixels): two charts fit side by side, and the text of one is readable on a
/// narrow screen.
const SIZE: (u32, u32) = (600, 400);

/// Points farther from the chart than this many of its widths are drawn at that distance.
const FAR_OFF: f64 = 1000.0;

/// An axis with its tick marks.
struct Scale {
    /// With logarithmic spacing the values are decimal logarithms of the quantity, and tick marks
    /// show the quantity.
    spacing: Spacing,
    range: (f64, f64),
    places: RangedCoordf64,
}

impl Ranged for Scale {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        // Far points are clamped: their pixel coordinates would overflow.
        let (low, high) = self.range;
        let far = FAR_OFF * (high - low);
        self.places.map(&value.clamp(low - far, high + far), limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        match self.spacing {
            Spacing::Linear => marks(self.range),
            Spacing::Logarithmic => {
                let (low, high) = (self.range.0.ceil() as i64, self.range.1.floor() as i64);
                (low..=high).map(|decade| decade as f64).collect()
            }
        }
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.range.0..self.range.1
    }
}

impl Axis {
    fn scale(&self, spacing: Spacing) -> Scale {
        Scale { spacing, range: self.range, places: (self.range.0..self.range.1).into() }
    }
}

/// Positions of tick marks: 4 to 12 multiples of a round number; multiples of 30 if the axis is a
/// full circle in degrees.
pub(crate) fn marks((low, high): (f64, f64)) -> Vec<f64> {
    let span = high - low;
    let tenth = 10f64.powf((span / 4.0).log10().floor());
    let round = [5.0, 2.0, 1.0].into_iter().map(|factor| factor * tenth).find(|step| span / step >= 4.0);
    let step = if (low, high) == (0.0, 360.0) { 30.0 } else { round.unwrap_or(tenth) };
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(|index| index as f64 * step).collect()
}

/// A curve that changes by less than this share of its value is constant: what changes is rounding,
/// and the numbers at its axis would all be the same.
const CONSTANT: f64 = 1e-9;

/// The range of an axis with room around the values: from 0 on where 0 is near.
pub(crate) fn height(low: f64, high: f64) -> (f64, f64) {
    let largest = low.abs().max(high.abs());
    if high - low <= CONSTANT * largest {
        let room = largest.max(1e-15);
        return (low - room, high + room);
    }
    let low = if low > 0.0 && low < 0.5 * high { 0.0 } else { low };
    let room = 0.08 * (high - low);
    (if low == 0.0 { 0.0 } else { low - room }, high + room)
}

impl Chart {
    /// Draws the chart as SVG. Points outside the axes are clipped at the border.
    ///
    /// # Errors
    /// An axis is empty or not finite.
    pub fn svg(&self) -> Result<String> {
        self.spaced_svg(Spacing::Linear)
    }

    /// Draws the chart as SVG; its x values are decimal logarithms, and the tick marks along x are
    /// powers of ten.
    ///
    /// # Errors
    /// An axis is empty or not finite.
    pub fn svg_in_decades_of_x(&self) -> Result<String> {
        self.spaced_svg(Spacing::Logarithmic)
    }

    fn spaced_svg(&self, spacing: Spacing) -> Result<String> {
        for axis in [&self.x, &self.y] {
            let (low, high) = axis.range;
            let sound = low.is_finite() && high.is_finite() && low < high;
            anyhow::ensure!(sound, "chart '{}': axis '{}' from {low} to {high}", self.title, axis.label);
        }
        let roomy = self.with_room_for_legend();
        canvas::svg(&self.title, SIZE, |root| roomy.draw(root, spacing))
    }

    fn draw(&self, root: &DrawingArea<SVGBackend<'_>, Shift>, spacing: Spacing) -> Result<()> {
        let x_format = |value: &f64| match spacing {
            Spacing::Linear => tick(*value, self.x.range),
            Spacing::Logarithmic => power_of_ten(*value),
        };
        let y_format = |value: &f64| tick(*value, self.y.range);
        let x = Side { scale: self.x.scale(spacing), label: &self.x.label, format: &x_format };
        let y = Side { scale: self.y.scale(Spacing::Linear), label: &self.y.label, format: &y_format };
        let mut chart = canvas::plane(root, &self.title, x, y)?;
        for layer in &self.layers {
            self.draw_layer(&mut chart, layer)?;
        }
        if self.layers.iter().any(|layer| !layer.name.is_empty()) {
            canvas::legend(&mut chart, self.freest_corner().1)?;
        }
        Ok(())
    }

    /// The chart, with a higher vertical axis where the legend would cover points in every corner.
    fn with_room_for_legend(&self) -> Self {
        let mut roomy = self.clone();
        if self.freest_corner().0 > 0 {
            let ((low, high), [_, share]) = (self.y.range, self.legend_size());
            roomy.y.range.1 = high + (high - low) * share / (1.0 - share);
        }
        roomy
    }

    /// Width and height of the legend, as shares of the axes, whose size is that of the chart
    /// without its margins.
    fn legend_size(&self) -> [f64; 2] {
        let names = || self.layers.iter().map(|layer| layer.name.chars().count()).filter(|&count| count > 0);
        let (across, along) = (f64::from(SIZE.0) - 114.0, f64::from(SIZE.1) - 102.0);
        let longest = names().max().unwrap_or(0) as f64;
        let width = (50.0 + canvas::CHARACTER * canvas::TEXT * longest) / across;
        let height = (20.0 + 1.3 * canvas::TEXT * names().count() as f64) / along;
        [width, height].map(|share| share.min(0.6))
    }

    /// The corner in which the legend covers the fewest points, with their number; of equal corners
    /// the upper right.
    fn freest_corner(&self) -> (usize, SeriesLabelPosition) {
        let share = |value: f64, (low, high): (f64, f64)| (value - low) / (high - low);
        let mut places: Vec<[f64; 2]> = Vec::new();
        let mut note = |points: Vec<(f64, f64)>| {
            let points: Vec<[f64; 2]> =
                points.iter().map(|&(x, y)| [share(x, self.x.range), share(y, self.y.range)]).collect();
            for ends in points.windows(2) {
                let between =
                    |part: f64| [0, 1].map(|axis| ends[0][axis] + part * (ends[1][axis] - ends[0][axis]));
                places.extend((0..=8).map(|part| between(f64::from(part) / 8.0)));
            }
        };
        for layer in &self.layers {
            match &layer.shape {
                Shape::Line(points) | Shape::Thin(points) => note(points.clone()),
                Shape::Band(points) => {
                    note(points.iter().map(|&(x, low, _)| (x, low)).collect());
                    note(points.iter().map(|&(x, _, high)| (x, high)).collect());
                }
            }
        }
        let [width, height] = self.legend_size();
        let hidden = |right: bool, upper: bool| {
            let near = |[x, y]: &&[f64; 2]| {
                (if right { 1.0 - x } else { *x }) < width && (if upper { 1.0 - y } else { *y }) < height
            };
            places.iter().filter(near).count()
        };
        let corners = [
            (hidden(true, true), SeriesLabelPosition::UpperRight),
            (hidden(false, true), SeriesLabelPosition::UpperLeft),
            (hidden(true, false), SeriesLabelPosition::LowerRight),
            (hidden(false, false), SeriesLabelPosition::LowerLeft),
        ];
        let [first, rest @ ..] = corners;
        rest.into_iter().fold(first, |best, corner| if corner.0 < best.0 { corner } else { best })
    }

    fn draw_layer(&self, chart: &mut Plane<'_, Scale, Scale>, layer: &Layer) -> Result<()> {
        let colour = layer.colour;
        let inside = |y: f64| y.clamp(self.y.range.0, self.y.range.1);
        match &layer.shape {
            Shape::Line(points) | Shape::Thin(points) => {
                let width = if matches!(layer.shape, Shape::Line(_)) { 2 } else { 1 };
                let points = points.iter().map(|&(x, y)| (x, inside(y)));
                let series = chart.draw_series(LineSeries::new(points, colour.stroke_width(width)))?;
                if !layer.name.is_empty() {
                    series.label(&layer.name).legend(move |(x, y)| {
                        PathElement::new(vec![(x, y), (x + 18, y)], colour.stroke_width(2))
                    });
                }
            }
            Shape::Band(points) => {
                let upper = points.iter().map(|&(x, _, high)| (x, inside(high)));
                let lower = points.iter().rev().map(|&(x, low, _)| (x, inside(low)));
                let outline: Vec<(f64, f64)> = upper.chain(lower).collect();
                let series = chart.draw_series([Polygon::new(outline, colour.mix(0.25))])?;
                if !layer.name.is_empty() {
                    series.label(&layer.name).legend(move |(x, y)| {
                        Rectangle::new([(x, y - 5), (x + 18, y + 5)], colour.mix(0.25).filled())
                    });
                }
            }
        }
        Ok(())
    }
}

/// Formats a power of ten from 0.001 to 1000 as a decimal, others with an exponent.
fn power_of_ten(exponent: f64) -> String {
    let value = 10f64.powf(exponent.round());
    if (-3.5..3.5).contains(&exponent) { format!("{value}") } else { format!("{value:.0e}") }
}

/// Formats a number at an axis with the digits that the range needs.
pub(crate) fn tick(value: f64, (low, high): (f64, f64)) -> String {
    let span = (high - low).abs();
    let largest = low.abs().max(high.abs());
    if value.abs() < 1e-9 * span {
        return "0".to_owned();
    }
    if !(1e-3..1e5).contains(&largest) {
        let decimals = (value.abs().log10().floor() + 2.0 - span.log10()).ceil().clamp(2.0, 12.0) as usize;
        let text = format!("{value:.decimals$e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let digits =
            if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits };
        return format!("{digits}e{exponent}");
    }
    let decimals = (2.0 - span.log10()).ceil().clamp(0.0, 8.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_at_any_distance_can_be_drawn() {
        let points = vec![(-1e300, 0.5), (0.5, 1e300), (f64::MAX, -f64::MAX)];
        let axis = || Axis { label: String::new(), range: (0.0, 1.0) };
        let layers = vec![Layer { name: String::new(), colour: colour::BLUE, shape: Shape::Line(points) }];
        assert!(Chart { title: String::new(), x: axis(), y: axis(), layers }.svg().is_ok());
    }

    #[test]
    fn the_legend_avoids_the_lines() {
        let corner = |points: &[(f64, f64)]| {
            let shape = Shape::Line(points.to_vec());
            let layers = vec![Layer { name: "a".to_owned(), colour: colour::BLUE, shape }];
            let chart = Chart { title: String::new(), x: axis((0.0, 1.0)), y: axis((0.0, 1.0)), layers };
            format!("{:?}", chart.freest_corner().1)
        };
        assert_eq!(corner(&[(0.0, 1.0), (1.0, 0.0)]), "UpperRight");
        assert_eq!(corner(&[(0.0, 0.0), (1.0, 1.0)]), "UpperLeft");
        assert_eq!(corner(&[(0.0, 1.0), (1.0, 1.0)]), "LowerRight");
        assert_eq!(corner(&[(0.0, 1.0), (1.0, 1.0), (1.0, 0.0)]), "LowerLeft");
    }

    #[test]
    fn the_axis_is_higher_where_the_legend_would_cover_a_curve() {
        let top = |points: &[(f64, f64)]| {
            let shape = Shape::Line(points.to_vec());
            let layers = vec![Layer { name: "a".to_owned(), colour: colour::BLUE, shape }];
            let chart = Chart { title: String::new(), x: axis((0.0, 1.0)), y: axis((0.0, 1.0)), layers };
            chart.with_room_for_legend().y.range.1
        };
        assert_eq!(top(&[(0.0, 0.0), (1.0, 1.0)]), 1.0);
        assert!(top(&[(0.0, 0.0), (1.0, 1.0), (0.0, 1.0), (1.0, 0.0), (0.0, 0.0)]) > 1.05);
    }

    fn axis(range: (f64, f64)) -> Axis {
        Axis { label: "t <time>".to_owned(), range }
    }

    #[test]
    fn a_chart_has_its_labels_and_stays_inside_its_axes() {
        let chart = Chart {
            title: "a & b".to_owned(),
            x: axis((0.0, 1.0)),
            y: axis((-1.0, 1.0)),
            layers: vec![Layer {
                name: "measured".to_owned(),
                colour: colour::BLUE,
                shape: Shape::Line(vec![(0.0, 0.0), (0.5, 1e9), (1.0, 0.5)]),
            }],
        };
        let svg = chart.svg().unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
        assert!(svg.contains("a &amp; b") && svg.contains("t &lt;time&gt;") && svg.contains("measured"));
        assert!(!svg.contains("NaN"));
    }

    #[test]
    fn an_axis_without_extent_is_refused() {
        for range in [(1.0, 1.0), (0.0, f64::NAN), (f64::NEG_INFINITY, 0.0)] {
            let chart =
                Chart { title: String::new(), x: axis(range), y: axis((0.0, 1.0)), layers: Vec::new() };
            assert!(chart.svg().is_err(), "{range:?}");
        }
    }

    #[test]
    fn marks_are_round_and_inside() {
        assert_eq!(marks((0.0, 9.2)), [0.0, 2.0, 4.0, 6.0, 8.0]);
        assert_eq!(marks((0.0, 360.0)).len(), 13);
        assert_eq!(marks((-19.0, 19.0)), [-15.0, -10.0, -5.0, 0.0, 5.0, 10.0, 15.0]);
        for range in [(0.0, 1e-15), (-3e7, 1.0), (0.0, 4.0), (0.0, 35.0)] {
            let marks = marks(range);
            assert!((4..=12).contains(&marks.len()), "{range:?}: {marks:?}");
            assert!(marks.iter().all(|mark| (range.0..=range.1).contains(mark)), "{range:?}: {marks:?}");
        }
    }

    #[test]
    fn a_step_function_has_two_points_a_bin() {
        assert_eq!(staircase(0.0, 2.0, &[5.0, 7.0]), [(0.0, 5.0), (1.0, 5.0), (1.0, 7.0), (2.0, 7.0)]);
    }

    #[test]
    fn ticks_have_the_digits_that_the_range_needs() {
        assert_eq!(tick(90.0, (0.0, 360.0)), "90");
        assert_eq!(tick(0.25, (0.0, 1.0)), "0.25");
        assert_eq!(tick(1.5e-5, (0.0, 2e-5)), "1.5e-5");
        assert_eq!(tick(-4e-15, (-5e-15, 0.0)), "-4e-15");
        assert_eq!(tick(1.638e6, (1.63e6, 1.64e6)), "1.638e6");
        assert_eq!(tick(1e-17, (-1.0, 1.0)), "0");
    }
}
