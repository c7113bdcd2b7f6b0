//! Polar charts as SVG: a positive quantity as a function of direction.

use anyhow::{Result, ensure};
use carom_tables::in_parentheses;

use crate::{
    axis::tick,
    chart::{HEADING, TEXT, staircase},
    ink::Ink,
    svg::{Anchor, Svg, fitting},
};

/// Curves of a positive quantity as a function of direction.
#[derive(Debug, Clone)]
pub struct Polar {
    /// Heading.
    pub title: String,
    /// Quantity and unit of the distance from the centre.
    pub label: String,
    /// Curves: a value for each of equal sectors, counter-clockwise from +x.
    pub curves: Vec<(String, Ink, Vec<f64>)>,
    /// Half width of the error band of the first curve for each sector; empty for no band.
    pub errors: Vec<f64>,
}

/// Width (pixels), centre of the chart, and radius of its rim.
const WIDTH: f64 = 600.0;
const CENTRE: (f64, f64) = (300.0, 318.0);
const RIM: f64 = 240.0;

/// Height of the label and of a line of the legend (pixels).
const LINE: f64 = 21.0;

impl Polar {
    /// Draws the curves as SVG; the largest value lies at the rim.
    ///
    /// # Errors
    /// A value that is not finite.
    pub fn svg(&self) -> Result<String> {
        let values = || {
            self.curves
                .iter()
                .flat_map(|(_, _, values)| values.iter().copied())
        };
        let is_sound = values()
            .chain(self.errors.iter().copied())
            .all(f64::is_finite);
        ensure!(
            is_sound,
            "polar chart '{}': a value is not finite",
            self.title
        );
        let largest = values().chain(self.band(1.0)).fold(0.0, f64::max);
        let rim = if largest > 0.0 { 1.05 * largest } else { 1.0 };
        let mut svg = Svg::default();
        let heading = fitting(&self.title, HEADING, WIDTH - 24.0);
        svg.text(
            (0.5 * WIDTH, 26.0),
            Anchor::Middle,
            Ink::Text,
            heading,
            &self.title,
        );
        draw_grid(&mut svg, rim);
        let on = |(turn, value): (f64, f64)| on_circle(value / rim * RIM, turn);
        if let Some((_, ink, _)) = self.curves.first().filter(|_| !self.errors.is_empty()) {
            // Outwards along the upper edge, back along the lower one.
            let edge = |sign: f64| staircase(0.0, 1.0, &self.band(sign)).into_iter().map(on);
            svg.area(edge(1.0).chain(edge(-1.0).rev()), *ink, "area");
        }
        for (_, ink, values) in &self.curves {
            let stairs = staircase(0.0, 1.0, values);
            let closed = stairs.iter().chain(stairs.first()).copied().map(on);
            svg.line(closed, *ink, "thick");
        }
        let label = in_parentheses(&self.label);
        let mut y = CENTRE.1 + RIM + 48.0;
        let size = fitting(&label, TEXT, WIDTH - 24.0);
        svg.text((0.5 * WIDTH, y), Anchor::Middle, Ink::Text, size, &label);
        for (name, ink, _) in &self.curves {
            y += LINE;
            svg.line([(200.0, y - 4.5), (222.0, y - 4.5)], *ink, "thick");
            svg.text(
                (230.0, y),
                Anchor::Start,
                Ink::Text,
                fitting(name, TEXT, WIDTH - 240.0),
                name,
            );
        }
        Ok(svg.finish((WIDTH, y + 16.0), true))
    }

    /// The first curve shifted by its error, at least 0.
    fn band(&self, sign: f64) -> Vec<f64> {
        let first = self.curves.first().map_or(&[][..], |(_, _, values)| values);
        first
            .iter()
            .zip(&self.errors)
            .map(|(value, error)| (value + sign * error).max(0.0))
            .collect()
    }
}

/// Rings with their values, and spokes with their angles.
fn draw_grid(svg: &mut Svg, rim: f64) {
    for ring in 1..=4 {
        let share = f64::from(ring) / 4.0;
        svg.circle(CENTRE, share * RIM, Ink::Quiet, "grid");
    }
    for spoke in 0..12 {
        let turn = f64::from(spoke) / 12.0;
        svg.line([CENTRE, on_circle(RIM, turn)], Ink::Quiet, "grid");
        let (x, y) = on_circle(1.09 * RIM, turn);
        svg.text(
            (x, y + 4.5),
            Anchor::Middle,
            Ink::Quiet,
            TEXT,
            &format!("{}°", 30 * spoke),
        );
    }
    for ring in 1..=4 {
        let share = f64::from(ring) / 4.0;
        let (x, y) = on_circle(share * RIM, 0.25);
        svg.text(
            (x + 4.0, y - 3.0),
            Anchor::Start,
            Ink::Quiet,
            TEXT,
            &tick(share * rim, (0.0, rim)),
        );
    }
}

fn on_circle(radius: f64, turn: f64) -> (f64, f64) {
    let (sin, cos) = (turn * std::f64::consts::TAU).sin_cos();
    (CENTRE.0 + radius * cos, CENTRE.1 - radius * sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polar_chart_of_zeros_can_be_drawn() {
        let polar = |values: Vec<f64>| Polar {
            title: String::new(),
            label: String::new(),
            errors: vec![0.0; values.len()],
            curves: vec![("none".to_owned(), Ink::Blue, values)],
        };
        let svg = polar(vec![0.0; 12]).svg().unwrap();
        assert!(svg.contains("330°") && !svg.contains("NaN"));
        assert!(polar(vec![f64::NAN; 3]).svg().is_err());
    }
}
