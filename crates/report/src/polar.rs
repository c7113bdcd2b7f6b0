//! Polar charts as SVG: a positive quantity as a function of direction.

use anyhow::{Result, ensure};
use plotters::{
    coord::Shift,
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

use crate::{
    canvas::{self, FONT},
    page::in_parentheses,
    plot::{staircase, tick},
};

/// Curves of a positive quantity as a function of direction.
#[derive(Debug, Clone)]
pub struct Polar {
    /// Heading.
    pub title: String,
    /// Quantity and unit of the distance from the centre.
    pub label: String,
    /// Curves: a value for each of equal sectors, counter-clockwise from +x.
    pub curves: Vec<(String, RGBColor, Vec<f64>)>,
    /// Half width of the error band of the first curve for each sector; empty for no band.
    pub errors: Vec<f64>,
}

/// Width and height (pixels): the circle with its angles, and below it the label and the legend.
const SIZE: (u32, u32) = (600, 740);

/// Half the width of the chart, in radii of the rim.
const SPAN: f64 = 1.18;

/// Height of the label and the legend, in radii of the rim.
const BELOW: f64 = 0.42;

impl Polar {
    /// Draws the curves as SVG; the largest value lies at the rim.
    ///
    /// # Errors
    /// A value that is not finite.
    pub fn svg(&self) -> Result<String> {
        let values = || self.curves.iter().flat_map(|(_, _, values)| values.iter().copied());
        ensure!(values().all(f64::is_finite), "polar chart '{}': a value is not finite", self.title);
        ensure!(
            self.errors.iter().all(|error| error.is_finite()),
            "polar chart '{}': an error is not finite",
            self.title
        );
        let largest = values().chain(self.band(1.0)).fold(0.0, f64::max);
        let rim = if largest > 0.0 { 1.05 * largest } else { 1.0 };
        canvas::svg(&self.title, SIZE, |root| self.draw(root, rim))
    }

    /// The first curve shifted by its error, at least 0.
    fn band(&self, sign: f64) -> Vec<f64> {
        let first = self.curves.first().map_or(&[][..], |(_, _, values)| values);
        first.iter().zip(&self.errors).map(|(value, error)| (value + sign * error).max(0.0)).collect()
    }

    fn draw(&self, root: &DrawingArea<SVGBackend<'_>, Shift>, rim: f64) -> Result<()> {
        let span = SPAN * rim;
        let mut chart = ChartBuilder::on(root)
            .margin(10)
            .caption(&self.title, (FONT, canvas::HEADING))
            .build_cartesian_2d(-span..span, -span - BELOW * rim..span)?;
        let grid = BLACK.mix(0.15);
        for ring in 1..=4 {
            let radius = rim * f64::from(ring) / 4.0;
            let circle = (0..=180).map(|step| on_circle(radius, f64::from(step) / 180.0));
            chart.draw_series(LineSeries::new(circle, grid))?;
            let label = tick(radius, (0.0, rim));
            chart.draw_series([Text::new(
                label,
                (0.0, radius),
                (FONT, canvas::TEXT).into_font().color(&BLACK.mix(0.6)),
            )])?;
        }
        for spoke in 0..12 {
            let turn = f64::from(spoke) / 12.0;
            chart.draw_series(LineSeries::new([(0.0, 0.0), on_circle(rim, turn)], grid))?;
            let centred = Pos::new(HPos::Center, VPos::Center);
            let style = (FONT, canvas::TEXT).into_font().color(&BLACK.mix(0.7)).pos(centred);
            chart.draw_series([Text::new(format!("{}°", 30 * spoke), on_circle(1.09 * rim, turn), style)])?;
        }
        if let Some((_, colour, _)) = self.curves.first().filter(|_| !self.errors.is_empty()) {
            // Outwards along the upper edge, back along the lower one.
            let edge = |sign: f64| {
                let stairs = staircase(0.0, 1.0, &self.band(sign));
                stairs.into_iter().map(|(turn, value)| on_circle(value, turn))
            };
            let ring: Vec<(f64, f64)> = edge(1.0).chain(edge(-1.0).rev()).collect();
            chart.draw_series([Polygon::new(ring, colour.mix(0.35))])?;
        }
        for (name, colour, values) in &self.curves {
            let mut curve: Vec<(f64, f64)> =
                staircase(0.0, 1.0, values).into_iter().map(|(turn, value)| on_circle(value, turn)).collect();
            curve.extend(curve.first().copied());
            let colour = *colour;
            chart.draw_series([Polygon::new(curve.clone(), colour.mix(0.12))])?;
            chart
                .draw_series(LineSeries::new(curve, colour.stroke_width(2)))?
                .label(name)
                .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 18, y)], colour.stroke_width(2)));
        }
        canvas::legend(&mut chart, SeriesLabelPosition::LowerMiddle)?;
        let label = in_parentheses(&self.label);
        let size = canvas::fitting(&label, canvas::TEXT, f64::from(SIZE.0) - 20.0);
        let above = Pos::new(HPos::Center, VPos::Top);
        chart.draw_series([Text::new(
            label,
            (0.0, -span),
            (FONT, size).into_font().color(&BLACK).pos(above),
        )])?;
        Ok(())
    }
}

fn on_circle(radius: f64, turn: f64) -> (f64, f64) {
    let (sin, cos) = (turn * std::f64::consts::TAU).sin_cos();
    (radius * cos, radius * sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::colour;

    #[test]
    fn a_polar_chart_of_zeros_can_be_drawn() {
        let polar = Polar {
            title: String::new(),
            label: String::new(),
            curves: vec![("none".to_owned(), colour::BLUE, vec![0.0; 12])],
            errors: vec![0.0; 12],
        };
        assert!(polar.svg().unwrap().contains("330°"));
    }
}
