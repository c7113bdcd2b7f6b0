//! Labelled points on two logarithmic axes, as SVG.

use std::ops::Range;

use anyhow::{Result, ensure};
use plotters::{coord::Shift, prelude::*};

use crate::{
    canvas::{self, FONT, Side},
    plot::colour,
};

/// One point.
#[derive(Debug, Clone)]
pub struct Point {
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
    pub points: Vec<Point>,
    /// A line through selected points, see [`pareto`]; empty for no line.
    pub front: Vec<(f64, f64)>,
}

/// Returns the points that no other point dominates on both axes (Pareto front), from left to
/// right.
pub fn pareto(points: &[Point]) -> Vec<(f64, f64)> {
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

const SIZE: (u32, u32) = (920, 560);
const COLOURS: [RGBColor; 5] =
    [colour::BLUE, colour::VERMILLION, colour::GREEN, colour::ORANGE, RGBColor(204, 121, 167)];

impl Scatter {
    /// Draws the chart as SVG.
    ///
    /// # Errors
    /// There are no points, or a coordinate has no logarithm.
    pub fn svg(&self) -> Result<String> {
        let sound = |value: f64| value.is_finite() && value > 0.0;
        ensure!(!self.points.is_empty(), "chart '{}' has no points", self.title);
        for point in &self.points {
            ensure!(sound(point.x) && sound(point.y), "chart '{}': {point:?}", self.title);
        }
        canvas::svg(&self.title, SIZE, |root| self.draw(root))
    }

    fn draw(&self, root: &DrawingArea<SVGBackend<'_>, Shift>) -> Result<()> {
        let tops = self.points.iter().map(|point| match point.mark {
            Mark::UpTo(top) => top,
            _ => point.y,
        });
        let (left, right) = range(self.points.iter().map(|point| point.x));
        let (lowest, top) = range(self.points.iter().map(|point| point.y).chain(tops));
        // Space below for arrows and labels.
        let bottom = 0.1 * lowest;
        let format = |value: &f64| power(*value);
        // Space on the right for labels.
        let scale = |low: f64, high: f64| (low..high).log_scale().with_key_points(ticks(low, high));
        let x = Side { scale: scale(left, right * 3.0), label: &self.x_label, format: &format };
        let y = Side { scale: scale(bottom, top), label: &self.y_label, format: &format };
        let mut chart = canvas::plane(root, &self.title, x, y)?;
        chart.draw_series([PathElement::new(self.front.clone(), BLACK.mix(0.35))])?;
        for (index, family) in self.families.iter().enumerate() {
            self.draw_family(&mut chart, index, family, [bottom, top])?;
        }
        let places: Vec<(i32, i32)> =
            self.points.iter().map(|point| chart.backend_coord(&(point.x, point.y))).collect();
        let rows = chart.plotting_area().get_pixel_range().1;
        self.draw_labels(root, &places, &rows)?;
        let corner = self.emptiest_corner([left, right * 3.0], [bottom, top]);
        canvas::legend(&mut chart, corner)
    }

    /// The corner with the fewest points; the axes are from the first to the second number.
    fn emptiest_corner(&self, x: [f64; 2], y: [f64; 2]) -> SeriesLabelPosition {
        let share = |value: f64, [low, high]: [f64; 2]| (value / low).ln() / (high / low).ln();
        let places = self.points.iter().map(|point| [share(point.x, x), share(point.y, y)]);
        let places: Vec<[f64; 2]> = places.collect();
        let inside = |is_left: bool, is_upper: bool| {
            let near = |share: f64, is_low: bool| if is_low { share < LEGEND } else { share > 1.0 - LEGEND };
            places.iter().filter(|place| near(place[0], is_left) && near(place[1], !is_upper)).count()
        };
        let corners = [
            (inside(false, true), SeriesLabelPosition::UpperRight),
            (inside(true, true), SeriesLabelPosition::UpperLeft),
            (inside(true, false), SeriesLabelPosition::LowerLeft),
        ];
        corners
            .into_iter()
            .min_by_key(|corner| corner.0)
            .map_or(SeriesLabelPosition::UpperRight, |corner| corner.1)
    }

    /// Draws the points of a family, its joining line, and the lines of ranges and bounds; the
    /// vertical axis is from `bottom` to `top`.
    fn draw_family<'a, C: CoordTranslate<From = (f64, f64)>>(
        &self,
        chart: &mut ChartContext<'a, SVGBackend<'a>, C>,
        index: usize,
        family: &str,
        [bottom, top]: [f64; 2],
    ) -> Result<()> {
        let colour = COLOURS[index % COLOURS.len()];
        let own = || self.points.iter().filter(move |point| point.family == index);
        if own().next().is_none() {
            return Ok(());
        }
        let dots = own().filter(|point| point.mark != Mark::Line).map(|point| {
            let is_ring = matches!(point.mark, Mark::AtMost | Mark::Published);
            let style = if is_ring { colour.stroke_width(2) } else { colour.filled() };
            Circle::new((point.x, point.y), 5, style)
        });
        let all = |mark| own().all(|point| point.mark == mark);
        let (is_published, is_curve) = (all(Mark::Published), all(Mark::Line));
        let style = if is_published { colour.stroke_width(2) } else { colour.filled() };
        let dots = chart.draw_series(dots)?;
        if !is_curve {
            dots.label(family).legend(move |(x, y)| Circle::new((x + 9, y), 5, style));
        }
        let joined = own().filter(|point| matches!(point.mark, Mark::Joined | Mark::Published | Mark::Line));
        let line: Vec<(f64, f64)> = joined.map(|point| (point.x, point.y)).collect();
        let line = chart.draw_series([PathElement::new(line, colour.mix(0.5))])?;
        if is_curve {
            line.label(family).legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.mix(0.5)));
        }
        for point in own() {
            let line = |to: f64| PathElement::new(vec![(point.x, point.y), (point.x, to)], colour.mix(0.6));
            match point.mark {
                Mark::UpTo(top) => drop(chart.draw_series([line(top)])?),
                Mark::AtMost => drop(chart.draw_series([line(point.y / arrow(bottom, top))])?),
                Mark::Measured | Mark::Joined | Mark::Published | Mark::Line => {}
            }
        }
        Ok(())
    }

    /// Draws the labels beside their points, whose positions are `places` (pixels), within `rows`.
    fn draw_labels(
        &self,
        root: &DrawingArea<SVGBackend<'_>, Shift>,
        places: &[(i32, i32)],
        rows: &Range<i32>,
    ) -> Result<()> {
        let labels: Vec<&str> = self.points.iter().map(|point| point.label.as_str()).collect();
        for (index, (left, top)) in beside(places, &labels, rows).into_iter().enumerate() {
            if labels[index].is_empty() {
                continue;
            }
            let colour = COLOURS[self.points[index].family % COLOURS.len()];
            root.draw(&Text::new(labels[index], (left, top), (FONT, 11).into_font().color(&colour)))?;
            let (x, y) = places[index];
            if (top + HEIGHT / 2 - y).abs() > HEIGHT {
                let right = left + LETTER * labels[index].chars().count() as i32;
                let end = if left > x { left - 2 } else { right + 2 };
                root.draw(&PathElement::new(vec![(x, y), (end, top + HEIGHT / 2)], colour.mix(0.5)))?;
            }
        }
        Ok(())
    }
}

/// Part of each axis that a legend in a corner covers at most.
const LEGEND: f64 = 0.3;

/// Height of a label, and width of its letters (pixels).
const HEIGHT: i32 = 13;
const LETTER: i32 = 6;

/// Most shifts of a label up or down, by 3 pixels each: those of thirty labels of one place.
const REACH: i32 = 80;

/// Positions of labels: to the right of their points, or else to the left, shifted up or down
/// within `rows` until they cover no other label or point.
fn beside(places: &[(i32, i32)], labels: &[&str], rows: &Range<i32>) -> Vec<(i32, i32)> {
    let mut taken: Vec<[i32; 4]> = places.iter().map(|&(x, y)| [x - 5, y - 5, x + 5, y + 5]).collect();
    let mut found = Vec::new();
    for (&(x, y), label) in places.iter().zip(labels) {
        let width = LETTER * label.chars().count() as i32;
        let at =
            |(left, shift): (i32, i32)| [left, y - HEIGHT / 2 + shift, left + width, y + HEIGHT / 2 + shift];
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
        let mut tried = sides.into_iter().flat_map(|left| shifts().map(move |shift| at((left, shift))));
        let rectangle = tried.find(free).unwrap_or(at((sides[0], 0)));
        if !label.is_empty() {
            taken.push(rectangle);
        }
        found.push((rectangle[0], rectangle[1]));
    }
    found
}

/// Length of an arrow, as a factor.
fn arrow(bottom: f64, top: f64) -> f64 {
    (top / bottom).powf(0.05)
}

/// Smallest range of whole decades that holds all values.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) =
        values.fold((f64::INFINITY, 0.0f64), |(low, high), value| (low.min(value), high.max(value)));
    let decade = |value: f64, rounded: fn(f64) -> f64| 10f64.powf(rounded(value.log10()));
    let (low, high) = (decade(0.8 * low, f64::floor), decade(1.2 * high, f64::ceil));
    (low, high)
}

/// Most decades with a number each at an axis. More: the numbers cover each other.
const MOST_DECADES: i32 = 12;

/// Numbers at an axis: powers of ten, or only some of them on a long axis; on one of fewer than two
/// decades their multiples by 2 and 5, too.
fn ticks(low: f64, high: f64) -> Vec<f64> {
    // The ends are powers of ten up to rounding.
    let (low, high) = (low * (1.0 - 1e-9), high * (1.0 + 1e-9));
    let (first, last) = (low.log10().floor() as i32, high.log10().floor() as i32);
    let every = (last - first).div_euclid(MOST_DECADES) + 1;
    let factors: &[f64] = if high < 100.0 * low { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let decades = (first..=last).filter(|decade| decade.rem_euclid(every) == 0);
    let all = decades.flat_map(|decade| factors.iter().map(move |factor| factor * 10f64.powi(decade)));
    all.filter(|tick| (low..=high).contains(tick)).collect()
}

/// Formats 0.1 to 1000 as decimals, other values as powers of ten, with one digit.
fn power(value: f64) -> String {
    if (0.05..5e3).contains(&value) {
        format!("{value:.1}").trim_end_matches(".0").to_owned()
    } else {
        format!("{value:.0e}")
    }
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
            points: vec![Point { family: 0, label: "default".to_owned(), x: 1.0, y, mark }],
            front: vec![(1.0, y)],
        }
    }

    #[test]
    fn points_are_labelled_and_zero_is_refused() {
        let marks =
            [Mark::Measured, Mark::Joined, Mark::Published, Mark::Line, Mark::AtMost, Mark::UpTo(1e-9)];
        for mark in marks {
            let svg = scatter(1e-15, mark).svg().unwrap();
            assert!(svg.contains("default") && svg.contains("Exact") && !svg.contains("NaN"));
        }
        assert!(scatter(0.0, Mark::Measured).svg().is_err());
        assert!(scatter(f64::NAN, Mark::Measured).svg().is_err());
    }

    #[test]
    fn the_front_holds_the_points_that_no_other_dominates() {
        let point = |x, y| Point { family: 0, label: String::new(), x, y, mark: Mark::Measured };
        let points = [point(2.0, 1.0), point(1.0, 3.0), point(1.5, 4.0), point(3.0, 1.0), point(4.0, 0.5)];
        assert_eq!(pareto(&points), [(1.0, 3.0), (2.0, 1.0), (4.0, 0.5)]);
    }

    #[test]
    fn labels_do_not_cover_each_other() {
        let places = [(100, 100); 5];
        let labels = ["one", "two", "three", "four", "five"];
        let mut tops: Vec<i32> =
            beside(&places, &labels, &(95..400)).into_iter().map(|(_, top)| top).collect();
        tops.sort_unstable();
        assert!(tops[0] >= 95, "no label leaves the chart: {tops:?}");
        assert!(tops.windows(2).all(|pair| pair[1] - pair[0] >= HEIGHT - 1), "{tops:?}");
    }

    /// As in a scene of discs, where all settings that are exact have one upper bound and nearly one
    /// time, close to the lower border of the chart.
    #[test]
    fn labels_of_many_points_in_a_row_do_not_cover_each_other() {
        let places: Vec<(i32, i32)> = (0..16).map(|index| (300 + 6 * index, 480)).collect();
        let labels = ["CellScheduler, portable"; 16];
        let found = beside(&places, &labels, &(60..520));
        let width = LETTER * labels[0].chars().count() as i32;
        for (index, one) in found.iter().enumerate() {
            assert!(one.1 >= 60 && one.1 + HEIGHT - 1 <= 520, "{one:?} is in the chart");
            for other in &found[..index] {
                let apart = (one.0 - other.0).abs() > width || (one.1 - other.1).abs() >= HEIGHT - 1;
                assert!(apart, "{one:?} and {other:?}");
            }
        }
    }

    #[test]
    fn numbers_at_an_axis_are_powers_of_ten_and_on_a_short_one_their_multiples() {
        assert_eq!(ticks(0.1, 1000.0), [0.1, 1.0, 10.0, 100.0, 1000.0]);
        assert_eq!(ticks(1.0, 30.0), [1.0, 2.0, 5.0, 10.0, 20.0]);
        let long = ticks(1e-16, 1e7);
        assert!((8..=13).contains(&long.len()), "{long:?}");
        assert_eq!([0.2, 50.0, 1e-12, 1e4].map(power), ["0.2", "50", "1e-12", "1e4"]);
    }

    #[test]
    fn axes_span_all_values_between_powers_of_ten() {
        assert_eq!(range([0.3, 7.0].into_iter()), (0.1, 10.0));
        assert_eq!(range([1.0].into_iter()), (0.1, 10.0));
    }
}
