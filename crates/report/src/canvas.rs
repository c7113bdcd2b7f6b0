//! Elements common to all charts: white SVG background, frame with two axes, legend.

use anyhow::{Result, anyhow};
use plotters::{
    coord::{
        CoordTranslate, Shift,
        ranged1d::{AsRangedCoord, Ranged, ValueFormatter},
    },
    prelude::*,
};

/// Font family of all text.
pub const FONT: &str = "sans-serif";

/// A chart on two axes.
pub type Plane<'a, X, Y> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<X, Y>>;

/// An axis of a chart: scale, label, and format of numbers.
pub struct Side<'a, X> {
    /// Range and scale.
    pub scale: X,
    /// Quantity and unit.
    pub label: &'a str,
    /// Format of a number at the axis.
    pub format: &'a dyn Fn(&f64) -> String,
}

/// Draws SVG of the given size in pixels on a white background.
///
/// # Errors
/// The error of `draw`, with the title of the chart.
pub fn svg(
    title: &str,
    size: (u32, u32),
    draw: impl FnOnce(&DrawingArea<SVGBackend<'_>, Shift>) -> Result<()>,
) -> Result<String> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        let drawn = root.fill(&WHITE).map_err(Into::into).and_then(|()| draw(&root));
        drawn.and_then(|()| Ok(root.present()?)).map_err(|error| anyhow!("chart '{title}': {error}"))?;
    }
    Ok(text)
}

/// Draws title, axes and grid.
///
/// # Errors
/// They cannot be drawn.
pub fn plane<'a, X, Y>(
    root: &DrawingArea<SVGBackend<'a>, Shift>,
    title: &str,
    x: Side<'_, X>,
    y: Side<'_, Y>,
) -> Result<Plane<'a, X::CoordDescType, Y::CoordDescType>>
where
    X: AsRangedCoord<Value = f64>,
    Y: AsRangedCoord<Value = f64>,
    X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let mut chart = ChartBuilder::on(root)
        .margin(12)
        .margin_right(24)
        .caption(title, (FONT, 18))
        .x_label_area_size(46)
        .y_label_area_size(78)
        .build_cartesian_2d(x.scale, y.scale)?;
    chart
        .configure_mesh()
        .x_desc(x.label)
        .y_desc(y.label)
        .label_style((FONT, 13))
        .axis_desc_style((FONT, 14))
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12))
        .x_label_formatter(x.format)
        .y_label_formatter(y.format)
        .draw()?;
    Ok(chart)
}

/// Draws the legend in a corner.
///
/// # Errors
/// It cannot be drawn.
pub fn legend<'a, C: CoordTranslate>(
    chart: &mut ChartContext<'a, SVGBackend<'a>, C>,
    corner: SeriesLabelPosition,
) -> Result<()> {
    chart
        .configure_series_labels()
        .position(corner)
        .label_font((FONT, 13))
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.25))
        .draw()?;
    Ok(())
}
