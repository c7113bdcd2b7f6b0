//! Labelled points on two logarithmic axes, as SVG.

use std::ops::Range;

use anyhow::{Result, ensure};

use crate::{
    axis::Axis,
    chart::{Chart, FULL, Layer, LayerShape, Plane},
    ink::Ink,
    svg::{Anchor, Svg},
};

/// One point.
#[derive(Debug, Clone)]
pub struct ScatterPoint {
    /// Index of the family.
    pub family: usize,
    /// Text beside the point.
    pub label: String,
    /// Horizontal coordinate.
    pub x: f64,
    /// Vertical coordinate.
    pub y: f64,
    /// Meaning of the vertical coordinate.
    pub mark: Mark,
}

/// Symbol of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mark {
    /// A dot.
    Measured,
    /// A dot, joined by a line to the previous point of its family.
    Joined,
    /// A ring for published values, joined to the previous point of its family.
    Published,
    /// End of a line from the previous point of its family: part of a curve.
    Line,
    /// A ring with a downward arrow: an upper bound.
    AtMost,
    /// A dot with a line up to a high percentile.
    UpTo(f64),
}

/// A chart of labelled points.
#[derive(Debug, Clone)]
pub struct Scatter {
    /// Heading.
    pub title: String,
    /// Label of the horizontal axis.
    pub x_label: String,
    /// Label of the vertical axis.
    pub y_label: String,
    /// Names of the families; each has its own colour.
    pub families: Vec<String>,
    /// The points.
    pub points: Vec<ScatterPoint>,
    /// A line through selected points, see [`pareto`]; empty for no line.
    pub front: Vec<(f64, f64)>,
}

/// Returns the points that no other point dominates on both axes (Pareto front), from left to
/// right.
pub fn pareto(points: &[ScatterPoint]) -> Vec<(f64, f64)> {
    let mut places: Vec<(f64, f64)> = points.iter().map(|point| (point.x, point.y)).collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut lowest = f64::INFINITY;
    places.retain(|&(_, y)| {
        let beats = y < lowest;
        lowest = lowest.min(y);
        beats
    });
    places
}

impl Scatter {
    /// Draws the chart as SVG.
    ///
    /// # Errors
    /// There are no points, or a coordinate has no logarithm.
    pub fn svg(&self) -> Result<String> {
        let sound = |value: f64| value.is_finite() && value > 0.0;
        ensure!(
            !self.points.is_empty(),
            "chart '{}' has no points",
            self.title
        );
        for point in &self.points {
            ensure!(
                sound(point.x) && sound(point.y),
                "chart '{}': {point:?}",
                self.title
            );
        }
        let tops = self.points.iter().map(|point| match point.mark {
            Mark::UpTo(top) => top,
            _ => point.y,
        });
        let (left, right) = whole_decades(self.points.iter().map(|point| point.x));
        let (lowest, top) = whole_decades(self.points.iter().map(|point| point.y).chain(tops));
        // Space below for downward lines, and on the right for labels.
        let (x, y) = ((left, 3.0 * right), (0.1 * lowest, top));
        let chart = Chart {
            title: self.title.clone(),
            x: Axis::logarithmic(&self.x_label, x),
            y: Axis::logarithmic(&self.y_label, y),
            layers: self.layers(y),
            size: FULL,
        };
        chart.svg_with(|plane, svg| self.draw_labels(plane, svg))
    }

    /// The front, and for each family its lines, bounds and points.
    fn layers(&self, (bottom, top): (f64, f64)) -> Vec<Layer> {
        let mut layers = Vec::new();
        let mut add = |name: &str, ink, shape| {
            layers.push(Layer {
                name: name.to_owned(),
                ink,
                shape,
            });
        };
        add("", Ink::Quiet, LayerShape::Thin(self.front.clone()));
        for (index, family) in self.families.iter().enumerate() {
            let ink = ink_of(index);
            let own = || {
                self.points
                    .iter()
                    .filter(move |point| point.family == index)
            };
            let of = |is: fn(&Mark) -> bool| -> Vec<(f64, f64)> {
                own()
                    .filter(|point| is(&point.mark))
                    .map(|point| (point.x, point.y))
                    .collect()
            };
            let joined = of(|mark| matches!(mark, Mark::Joined | Mark::Published | Mark::Line));
            let dots = of(|mark| matches!(mark, Mark::Measured | Mark::Joined | Mark::UpTo(_)));
            let rings = of(|mark| matches!(mark, Mark::AtMost | Mark::Published));
            let bar = |point: &ScatterPoint| match point.mark {
                Mark::UpTo(top) => Some((point.x, point.y, top)),
                Mark::AtMost => Some((point.x, point.y, point.y / (top / bottom).powf(DOWNWARD))),
                Mark::Measured | Mark::Joined | Mark::Published | Mark::Line => None,
            };
            let is_curve = dots.is_empty() && rings.is_empty();
            add(
                if is_curve && !joined.is_empty() {
                    family
                } else {
                    ""
                },
                ink,
                LayerShape::Thin(joined),
            );
            add("", ink, LayerShape::Bars(own().filter_map(bar).collect()));
            let named = |is_named: bool| if is_named { family.as_str() } else { "" };
            add(
                named(dots.is_empty() && !rings.is_empty()),
                ink,
                LayerShape::Rings(rings),
            );
            add(named(!dots.is_empty()), ink, LayerShape::Dots(dots));
        }
        layers
    }

    /// Draws the labels beside their points.
    fn draw_labels(&self, plane: &Plane<'_>, svg: &mut Svg) {
        let places: Vec<(i32, i32)> = self
            .points
            .iter()
            .map(|point| plane.at((point.x, point.y)))
            .map(|(x, y)| (x.round() as i32, y.round() as i32))
            .collect();
        let labels: Vec<&str> = self
            .points
            .iter()
            .map(|point| point.label.as_str())
            .collect();
        let [.., top, bottom] = plane.rectangle;
        for (index, (left, top)) in beside(&places, &labels, &(top as i32..bottom as i32))
            .into_iter()
            .enumerate()
        {
            if labels[index].is_empty() {
                continue;
            }
            let ink = ink_of(self.points[index].family);
            let baseline = (f64::from(left), f64::from(top + HEIGHT - 3));
            svg.text(baseline, Anchor::Start, ink, SIZE, labels[index]);
            let (x, y) = places[index];
            if (top + HEIGHT / 2 - y).abs() > HEIGHT {
                let right = left + LETTER * labels[index].chars().count() as i32;
                let end = if left > x { left - 2 } else { right + 2 };
                let line =
                    [(x, y), (end, top + HEIGHT / 2)].map(|(x, y)| (f64::from(x), f64::from(y)));
                svg.line(line, ink, "faint");
            }
        }
    }
}

/// The colour of a family.
fn ink_of(family: usize) -> Ink {
    const INKS: [Ink; 6] = [
        Ink::Blue,
        Ink::Vermillion,
        Ink::Green,
        Ink::Orange,
        Ink::Purple,
        Ink::Sky,
    ];
    INKS[family % INKS.len()]
}

/// Length of the line below an upper bound, as a share of the axis.
const DOWNWARD: f64 = 0.05;

/// Size of a label (pixels).
const SIZE: f64 = 10.5;

/// Height of a label, and width of its letters (pixels).
const HEIGHT: i32 = 13;
const LETTER: i32 = 6;

/// Most shifts of a label up or down, by 3 pixels each: those of thirty labels of one place.
const REACH: i32 = 80;

/// Positions of labels: to the right of their points, or else to the left, shifted up or down
/// within `rows` until they cover no other label or point.
fn beside(places: &[(i32, i32)], labels: &[&str], rows: &Range<i32>) -> Vec<(i32, i32)> {
    let mut taken: Vec<[i32; 4]> = places
        .iter()
        .map(|&(x, y)| [x - 5, y - 5, x + 5, y + 5])
        .collect();
    let mut found = Vec::new();
    for (&(x, y), label) in places.iter().zip(labels) {
        let width = LETTER * label.chars().count() as i32;
        let at = |(left, shift): (i32, i32)| {
            [
                left,
                y - HEIGHT / 2 + shift,
                left + width,
                y + HEIGHT / 2 + shift,
            ]
        };
        let free = |rectangle: &[i32; 4]| {
            let inside = rows.start <= rectangle[1] && rectangle[3] <= rows.end;
            inside
                && taken.iter().all(|other| {
                    rectangle[2] < other[0]
                        || other[2] < rectangle[0]
                        || rectangle[3] < other[1]
                        || other[3] < rectangle[1]
                })
        };
        let sides = [x + 10, x - 10 - width];
        let shifts = || (0..REACH).flat_map(|step| [3 * step, -3 * step]);
        let mut tried = sides
            .into_iter()
            .flat_map(|left| shifts().map(move |shift| at((left, shift))));
        let rectangle = tried.find(free).unwrap_or(at((sides[0], 0)));
        if !label.is_empty() {
            taken.push(rectangle);
        }
        found.push((rectangle[0], rectangle[1]));
    }
    found
}

/// Smallest range of whole decades that holds all values.
fn whole_decades(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let decade = |value: f64, rounded: fn(f64) -> f64| 10f64.powf(rounded(value.log10()));
    (decade(0.8 * low, f64::floor), decade(1.2 * high, f64::ceil))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scatter(y: f64, mark: Mark) -> Scatter {
        Scatter {
            title: "a & b".to_owned(),
            x_label: "time".to_owned(),
            y_label: "error".to_owned(),
            families: vec!["Exact".to_owned()],
            points: vec![ScatterPoint {
                family: 0,
                label: "default".to_owned(),
                x: 1.0,
                y,
                mark,
            }],
            front: vec![(1.0, y)],
        }
    }

    #[test]
    fn points_are_labelled_and_zero_is_refused() {
        let marks = [
            Mark::Measured,
            Mark::Joined,
            Mark::Published,
            Mark::Line,
            Mark::AtMost,
            Mark::UpTo(1e-9),
        ];
        for mark in marks {
            let svg = scatter(1e-15, mark).svg().unwrap();
            assert!(svg.contains("default") && svg.contains("Exact") && !svg.contains("NaN"));
        }
        assert!(scatter(0.0, Mark::Measured).svg().is_err());
        assert!(scatter(f64::NAN, Mark::Measured).svg().is_err());
    }

    #[test]
    fn the_front_holds_the_points_that_no_other_dominates() {
        let point = |x, y| ScatterPoint {
            family: 0,
            label: String::new(),
            x,
            y,
            mark: Mark::Measured,
        };
        let points = [
            point(2.0, 1.0),
            point(1.0, 3.0),
            point(1.5, 4.0),
            point(3.0, 1.0),
            point(4.0, 0.5),
        ];
        assert_eq!(pareto(&points), [(1.0, 3.0), (2.0, 1.0), (4.0, 0.5)]);
    }

    #[test]
    fn labels_do_not_cover_each_other() {
        let places = [(100, 100); 5];
        let labels = ["one", "two", "three", "four", "five"];
        let mut tops: Vec<i32> = beside(&places, &labels, &(95..400))
            .into_iter()
            .map(|(_, top)| top)
            .collect();
        tops.sort_unstable();
        assert!(tops[0] >= 95, "no label leaves the chart: {tops:?}");
        assert!(
            tops.windows(2).all(|pair| pair[1] - pair[0] >= HEIGHT - 1),
            "{tops:?}"
        );
    }

    /// As in a scene of discs, where all exact settings have one upper bound and nearly one time,
    /// close to the lower border of the chart.
    #[test]
    fn labels_of_many_points_in_a_row_do_not_cover_each_other() {
        let places: Vec<(i32, i32)> = (0..16).map(|index| (300 + 6 * index, 480)).collect();
        let labels = ["CellScheduler, portable"; 16];
        let found = beside(&places, &labels, &(60..520));
        let width = LETTER * labels[0].chars().count() as i32;
        for (index, one) in found.iter().enumerate() {
            assert!(
                one.1 >= 60 && one.1 + HEIGHT - 1 <= 520,
                "{one:?} is in the chart"
            );
            for other in &found[..index] {
                let apart =
                    (one.0 - other.0).abs() > width || (one.1 - other.1).abs() >= HEIGHT - 1;
                assert!(apart, "{one:?} and {other:?}");
            }
        }
    }

    #[test]
    fn axes_span_all_values_between_powers_of_ten() {
        assert_eq!(whole_decades([0.3, 7.0].into_iter()), (0.1, 10.0));
        assert_eq!(whole_decades([1.0].into_iter()), (0.1, 10.0));
    }
}
