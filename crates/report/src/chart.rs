//! A chart: layers of lines, bands and points on two axes, as SVG.

use anyhow::{Result, ensure};
use carom_tables::in_parentheses;

use crate::{
    axis::Axis,
    ink::Ink,
    svg::{Anchor, CHARACTER, Svg, fitting},
};

/// One curve, band or set of points of a chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Name in the legend; empty for none.
    pub name: String,
    /// Its colour.
    pub ink: Ink,
    /// Its shape.
    pub shape: LayerShape,
}

/// The shape of a layer, in the units of the axes.
#[derive(Debug, Clone, PartialEq)]
pub enum LayerShape {
    /// A line through points.
    Line(Vec<(f64, f64)>),
    /// A thin line, for what is approximate or a guide.
    Thin(Vec<(f64, f64)>),
    /// The area between a lower and an upper line: x, lower, upper.
    Band(Vec<(f64, f64, f64)>),
    /// Upright lines: x, from, to.
    Bars(Vec<(f64, f64, f64)>),
    /// Dots, for what is measured.
    Dots(Vec<(f64, f64)>),
    /// Rings, for what is predicted or published.
    Rings(Vec<(f64, f64)>),
    /// Crosses, for guides.
    Crosses(Vec<(f64, f64)>),
}

impl LayerShape {
    /// Leaves out points below a height, which a logarithmic axis cannot show.
    pub(crate) fn leave_out_below(&mut self, least: f64) {
        match self {
            Self::Line(points)
            | Self::Thin(points)
            | Self::Dots(points)
            | Self::Rings(points)
            | Self::Crosses(points) => points.retain(|point| point.1 >= least),
            Self::Band(points) | Self::Bars(points) => points.retain(|point| point.2 >= least),
        }
    }
}

/// A chart on two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Heading.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// From back to front.
    pub layers: Vec<Layer>,
    /// Width and height without a legend beside it (pixels).
    pub size: (f64, f64),
}

/// Two charts of this size fit side by side, and the text of one is readable on a narrow screen.
pub const BESIDE: (f64, f64) = (600.0, 400.0);

/// A chart with many labels (pixels).
pub const FULL: (f64, f64) = (920.0, 560.0);

/// Sizes of headings, labels of axes, and numbers and legends (pixels).
pub(crate) const HEADING: f64 = 16.5;
const LABEL: f64 = 14.5;
pub(crate) const TEXT: f64 = 13.0;

/// Space around the axes (pixels): left, right, above, below.
const MARGINS: [f64; 4] = [76.0, 22.0, 40.0, 54.0];

/// Most entries of a legend inside the axes; more are beside the chart.
const MAX_INSIDE: usize = 5;

/// Width of a legend beside the chart, and the most lines of it.
const STRIP: f64 = 190.0;
const MAX_LINES: usize = 17;

/// Height of a line of a legend, and length of its samples (pixels).
const LINE: f64 = 19.0;
const SAMPLE: f64 = 20.0;

/// Points of a step function with `values` in equal bins from `first` to `last`.
pub fn staircase(first: f64, last: f64, values: &[f64]) -> Vec<(f64, f64)> {
    let edge = |index: usize| first + (last - first) * index as f64 / values.len() as f64;
    values
        .iter()
        .enumerate()
        .flat_map(|(index, &y)| [(edge(index), y), (edge(index + 1), y)])
        .collect()
}

/// A corner of the area within the axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Corner {
    is_right: bool,
    is_upper: bool,
}

/// The corners, of equal ones the first is taken.
const CORNERS: [Corner; 4] = [
    Corner {
        is_right: true,
        is_upper: true,
    },
    Corner {
        is_right: false,
        is_upper: true,
    },
    Corner {
        is_right: true,
        is_upper: false,
    },
    Corner {
        is_right: false,
        is_upper: false,
    },
];

impl Chart {
    /// A chart of the size of which two fit side by side.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis, layers: Vec<Layer>) -> Self {
        Self {
            title: title.into(),
            x,
            y,
            layers,
            size: BESIDE,
        }
    }

    /// Draws the chart as SVG. Points outside the axes are drawn at the border.
    ///
    /// # Errors
    /// An axis is empty or not finite.
    pub fn svg(&self) -> Result<String> {
        self.svg_with(|_, _| ())
    }

    /// Draws the chart, and more on its axes below the legend.
    pub(crate) fn svg_with(&self, more: impl FnOnce(&Plane<'_>, &mut Svg)) -> Result<String> {
        for axis in [&self.x, &self.y] {
            let (low, high) = axis.range;
            ensure!(
                axis.is_sound(),
                "chart '{}': axis '{}' from {low} to {high}",
                self.title,
                axis.label
            );
        }
        let (width, height) = self.size;
        let is_beside = self.entries().count() > MAX_INSIDE;
        let mut svg = Svg::default();
        let roomy = if is_beside {
            self.clone()
        } else {
            self.with_room_for_legend()
        };
        let plane = Plane {
            chart: &roomy,
            rectangle: self.rectangle(),
        };
        plane.draw_axes(&mut svg);
        roomy
            .layers
            .iter()
            .for_each(|layer| plane.draw(layer, &mut svg));
        more(&plane, &mut svg);
        if is_beside {
            self.legend_beside(&mut svg);
        } else if self.entries().next().is_some() {
            roomy.legend_inside(&plane, &mut svg);
        }
        Ok(svg.finish((width + if is_beside { STRIP } else { 0.0 }, height), true))
    }

    /// The area within the axes (pixels): left, right, top, bottom.
    fn rectangle(&self) -> [f64; 4] {
        let [left, right, above, below] = MARGINS;
        [left, self.size.0 - right, above, self.size.1 - below]
    }

    /// Layers with a name.
    fn entries(&self) -> impl Iterator<Item = &Layer> {
        self.layers.iter().filter(|layer| !layer.name.is_empty())
    }

    /// The chart, with a higher vertical axis where the legend would cover points in every corner.
    fn with_room_for_legend(&self) -> Self {
        let mut roomy = self.clone();
        if self.entries().next().is_some() && self.freest_corner().0 > 0 {
            roomy.y = self.y.with_room(self.legend_size()[1]);
        }
        roomy
    }

    /// Width and height of the legend, as shares of the axes.
    fn legend_size(&self) -> [f64; 2] {
        let longest = self
            .entries()
            .map(|layer| layer.name.chars().count())
            .max()
            .unwrap_or(0) as f64;
        let [left, right, top, bottom] = self.rectangle();
        let width = (SAMPLE + 26.0 + CHARACTER * TEXT * longest) / (right - left);
        let height = (LINE * self.entries().count() as f64 + 16.0) / (bottom - top);
        [width, height].map(|share| share.min(0.6))
    }

    /// The corner in which the legend covers the fewest points, with their number.
    fn freest_corner(&self) -> (usize, Corner) {
        let mut places: Vec<[f64; 2]> = Vec::new();
        let place = |&(x, y): &(f64, f64)| [self.x.share(x), self.y.share(y)];
        let mut note = |points: &[(f64, f64)]| {
            for ends in points.iter().map(place).collect::<Vec<_>>().windows(2) {
                let between = |part: f64| {
                    [0, 1].map(|axis| ends[0][axis] + part * (ends[1][axis] - ends[0][axis]))
                };
                places.extend((0..=8).map(|part| between(f64::from(part) / 8.0)));
            }
        };
        for layer in &self.layers {
            match &layer.shape {
                LayerShape::Line(points) | LayerShape::Thin(points) => note(points),
                LayerShape::Band(points) => {
                    note(
                        &points
                            .iter()
                            .map(|&(x, low, _)| (x, low))
                            .collect::<Vec<_>>(),
                    );
                    note(
                        &points
                            .iter()
                            .map(|&(x, _, high)| (x, high))
                            .collect::<Vec<_>>(),
                    );
                }
                LayerShape::Bars(bars) => bars
                    .iter()
                    .for_each(|&(x, from, to)| note(&[(x, from), (x, to)])),
                LayerShape::Dots(points)
                | LayerShape::Rings(points)
                | LayerShape::Crosses(points) => {
                    for &point in points {
                        note(&[point, point]);
                    }
                }
            }
        }
        let [width, height] = self.legend_size();
        let hidden = |corner: Corner| {
            let near = |[x, y]: &&[f64; 2]| {
                (if corner.is_right { 1.0 - x } else { *x }) < width
                    && (if corner.is_upper { 1.0 - y } else { *y }) < height
            };
            places.iter().filter(near).count()
        };
        let [first, rest @ ..] = CORNERS.map(|corner| (hidden(corner), corner));
        rest.into_iter().fold(
            first,
            |best, corner| if corner.0 < best.0 { corner } else { best },
        )
    }

    fn legend_inside(&self, plane: &Plane<'_>, svg: &mut Svg) {
        let [left, right, top, bottom] = plane.rectangle;
        let longest = self
            .entries()
            .map(|layer| layer.name.chars().count())
            .max()
            .unwrap_or(0) as f64;
        let width = (SAMPLE + 22.0 + CHARACTER * TEXT * longest).min(right - left - 16.0);
        let height = LINE * self.entries().count() as f64 + 8.0;
        let corner = self.freest_corner().1;
        let x = if corner.is_right {
            right - 8.0 - width
        } else {
            left + 8.0
        };
        let y = if corner.is_upper {
            top + 8.0
        } else {
            bottom - 8.0 - height
        };
        svg.raw(&format!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" class=\"ground\" \
             fill-opacity=\".85\"/>"
        ));
        svg.rectangle((x, y), (x + width, y + height), Ink::Quiet, "grid");
        for (index, layer) in self.entries().enumerate() {
            draw_entry(
                layer,
                (x + 8.0, y + 4.0 + LINE * (index as f64 + 0.5)),
                width - SAMPLE - 18.0,
                svg,
            );
        }
    }

    /// The legend in a strip of its own; of very many entries the first ones.
    fn legend_beside(&self, svg: &mut Svg) {
        let left = self.size.0;
        let count = self.entries().count();
        for (index, layer) in self.entries().take(MAX_LINES).enumerate() {
            let y = MARGINS[2] + LINE * (index as f64 + 0.5);
            draw_entry(layer, (left, y), STRIP - SAMPLE - 14.0, svg);
        }
        if count > MAX_LINES {
            let place = (left, MARGINS[2] + LINE * (MAX_LINES as f64 + 0.5) + 4.5);
            svg.text(
                place,
                Anchor::Start,
                Ink::Quiet,
                TEXT,
                &format!("and {} more", count - MAX_LINES),
            );
        }
    }
}

/// Draws an entry of a legend from a place at its left end and half its height.
fn draw_entry(layer: &Layer, (x, y): (f64, f64), width: f64, svg: &mut Svg) {
    let middle = (x + 0.5 * SAMPLE, y);
    match &layer.shape {
        LayerShape::Line(_) => svg.line([(x, y), (x + SAMPLE, y)], layer.ink, "thick"),
        LayerShape::Thin(_) => svg.line([(x, y), (x + SAMPLE, y)], layer.ink, "thin"),
        LayerShape::Band(_) => {
            svg.rectangle((x, y - 5.0), (x + SAMPLE, y + 5.0), layer.ink, "area");
        }
        LayerShape::Bars(_) => svg.line(
            [(middle.0, y - 6.0), (middle.0, y + 6.0)],
            layer.ink,
            "thick",
        ),
        LayerShape::Dots(_) => svg.circle(middle, 3.6, layer.ink, "fill"),
        LayerShape::Rings(_) => svg.circle(middle, 5.5, layer.ink, "thin"),
        LayerShape::Crosses(_) => draw_cross(middle, layer.ink, svg),
    }
    let size = fitting(&layer.name, TEXT, width);
    svg.text(
        (x + SAMPLE + 6.0, y + 0.35 * size),
        Anchor::Start,
        Ink::Text,
        size,
        &layer.name,
    );
}

fn draw_cross((x, y): (f64, f64), ink: Ink, svg: &mut Svg) {
    svg.path(
        &format!("M{:.1} {:.1}l8 8m0 -8l-8 8", x - 4.0, y - 4.0),
        ink,
        "thin",
    );
}

/// The area within the axes of a chart.
pub(crate) struct Plane<'a> {
    chart: &'a Chart,
    /// Left, right, top, bottom (pixels).
    pub rectangle: [f64; 4],
}

impl Plane<'_> {
    fn x(&self, value: f64) -> f64 {
        let [left, right, ..] = self.rectangle;
        left + (right - left) * self.chart.x.share(value).clamp(0.0, 1.0)
    }

    fn y(&self, value: f64) -> f64 {
        let [.., top, bottom] = self.rectangle;
        bottom - (bottom - top) * self.chart.y.share(value).clamp(0.0, 1.0)
    }

    /// The place of a point (pixels).
    pub fn at(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.x(x), self.y(y))
    }

    /// Heading, grid, numbers and labels.
    fn draw_axes(&self, svg: &mut Svg) {
        let ([left, right, top, bottom], chart) = (self.rectangle, self.chart);
        let (width, height) = chart.size;
        let heading = fitting(&chart.title, HEADING, width - 24.0);
        svg.text(
            (0.5 * width, 26.0),
            Anchor::Middle,
            Ink::Text,
            heading,
            &chart.title,
        );
        let characters = |length: f64| length / (CHARACTER * TEXT);
        for (mark, text) in chart.x.marks(characters(right - left)) {
            let x = self.x(mark);
            svg.line([(x, top), (x, bottom)], Ink::Quiet, "grid");
            svg.text((x, bottom + 18.0), Anchor::Middle, Ink::Quiet, TEXT, &text);
        }
        for (mark, text) in chart.y.marks(characters(bottom - top)) {
            let y = self.y(mark);
            svg.line([(left, y), (right, y)], Ink::Quiet, "grid");
            let size = fitting(&text, TEXT, left - 32.0);
            svg.text(
                (left - 7.0, y + 0.35 * size),
                Anchor::End,
                Ink::Quiet,
                size,
                &text,
            );
        }
        svg.line(
            [(left, top), (left, bottom), (right, bottom)],
            Ink::Quiet,
            "thin",
        );
        let labels = [&chart.x, &chart.y].map(|axis| in_parentheses(&axis.label));
        // One size for both labels, so that neither looks like a note.
        let size =
            fitting(&labels[0], LABEL, width - 24.0).min(fitting(&labels[1], LABEL, height - 16.0));
        svg.text(
            (0.5 * (left + right), bottom + 42.0),
            Anchor::Middle,
            Ink::Text,
            size,
            &labels[0],
        );
        svg.upwards((20.0, 0.5 * (top + bottom)), Ink::Text, size, &labels[1]);
    }

    fn draw(&self, layer: &Layer, svg: &mut Svg) {
        let ink = layer.ink;
        match &layer.shape {
            LayerShape::Line(points) => {
                svg.line(points.iter().map(|&at| self.at(at)), ink, "thick");
            }
            LayerShape::Thin(points) => svg.line(points.iter().map(|&at| self.at(at)), ink, "thin"),
            LayerShape::Band(points) => {
                let upper = points.iter().map(|&(x, _, high)| self.at((x, high)));
                let lower = points.iter().rev().map(|&(x, low, _)| self.at((x, low)));
                svg.area(upper.chain(lower), ink, "area");
            }
            LayerShape::Bars(bars) => {
                for &(x, from, to) in bars {
                    svg.line([self.at((x, from)), self.at((x, to))], ink, "thin");
                }
            }
            LayerShape::Dots(points) => points
                .iter()
                .for_each(|&at| svg.circle(self.at(at), 3.6, ink, "fill")),
            LayerShape::Rings(points) => points
                .iter()
                .for_each(|&at| svg.circle(self.at(at), 6.0, ink, "thin")),
            LayerShape::Crosses(points) => points
                .iter()
                .for_each(|&at| draw_cross(self.at(at), ink, svg)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: &[(f64, f64)]) -> Chart {
        let axis = || Axis::new("t <time>", (0.0, 1.0));
        let shape = LayerShape::Line(points.to_vec());
        let layers = vec![Layer {
            name: "measured".to_owned(),
            ink: Ink::Blue,
            shape,
        }];
        Chart::new("a & b", axis(), axis(), layers)
    }

    #[test]
    fn points_at_any_distance_are_drawn_at_the_border() {
        let svg = chart(&[
            (-1e300, 0.5),
            (0.5, 1e300),
            (f64::MAX, -f64::MAX),
            (f64::NAN, 0.0),
        ])
        .svg()
        .unwrap();
        assert!(
            svg.contains("a &amp; b") && svg.contains("t &lt;time&gt;") && svg.contains("measured")
        );
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert!(chart(&[]).svg().is_ok());
        let empty = Chart {
            x: Axis::new("x", (1.0, 1.0)),
            ..chart(&[])
        };
        assert!(
            empty
                .svg()
                .unwrap_err()
                .to_string()
                .contains("axis 'x' from 1 to 1")
        );
        assert!(
            Chart {
                y: Axis::logarithmic("y", (0.0, 1.0)),
                ..chart(&[])
            }
            .svg()
            .is_err()
        );
    }

    #[test]
    fn the_legend_avoids_the_lines() {
        let corner = |points: &[(f64, f64)]| {
            let corner = chart(points).freest_corner().1;
            (corner.is_right, corner.is_upper)
        };
        assert_eq!(corner(&[(0.0, 1.0), (1.0, 0.0)]), (true, true));
        assert_eq!(corner(&[(0.0, 0.0), (1.0, 1.0)]), (false, true));
        assert_eq!(corner(&[(0.0, 1.0), (1.0, 1.0)]), (true, false));
        assert_eq!(
            corner(&[(0.0, 1.0), (1.0, 1.0), (1.0, 0.0)]),
            (false, false)
        );
    }

    #[test]
    fn the_axis_is_higher_where_the_legend_would_cover_a_curve() {
        let top = |points: &[(f64, f64)]| chart(points).with_room_for_legend().y.range.1;
        assert_eq!(top(&[(0.0, 0.0), (1.0, 1.0)]), 1.0);
        assert!(top(&[(0.0, 0.0), (1.0, 1.0), (0.0, 1.0), (1.0, 0.0), (0.0, 0.0)]) > 1.05);
    }

    #[test]
    fn many_entries_are_beside_the_chart_and_bounded() {
        let mut many = chart(&[(0.0, 0.0), (1.0, 1.0)]);
        let layer = |index| Layer {
            name: format!("curve {index}"),
            ..many.layers[0].clone()
        };
        many.layers = (0..40).map(layer).collect();
        let svg = many.svg().unwrap();
        assert!(
            svg.contains("width=\"790\"")
                && svg.contains("and 23 more")
                && !svg.contains("curve 17<")
        );
    }

    #[test]
    fn every_shape_is_drawn_with_its_entry() {
        let shapes = [
            (
                LayerShape::Band(vec![(0.0, 0.1, 0.2), (1.0, 0.2, 0.4)]),
                "area",
                2,
            ),
            (LayerShape::Dots(vec![(0.5, 0.5)]), "<circle", 2),
            (LayerShape::Rings(vec![(0.5, 0.5)]), "<circle", 2),
            (LayerShape::Crosses(vec![(0.5, 0.5)]), "l8 8m0 -8l-8 8", 2),
        ];
        for (shape, element, count) in shapes {
            let mut chart = chart(&[]);
            chart.layers[0].shape = shape;
            let svg = chart.svg().unwrap();
            let drawn = &svg[svg.find("</style>").unwrap()..];
            assert_eq!(drawn.matches(element).count(), count, "{element}");
        }
    }

    #[test]
    fn a_step_function_has_two_points_a_bin() {
        assert_eq!(
            staircase(0.0, 2.0, &[5.0, 7.0]),
            [(0.0, 5.0), (1.0, 5.0), (1.0, 7.0), (2.0, 7.0)]
        );
    }
}
