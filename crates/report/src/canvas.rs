//! Elements common to all charts: white SVG background, frame with two axes, legend.

use anyhow::{Result, anyhow};
use plotters::{
    coord::{
        CoordTranslate, Shift,
        ranged1d::{AsRangedCoord, Ranged, ValueFormatter},
    },
    prelude::*,
};

use crate::page::in_parentheses;

/// Font family of all text.
pub const FONT: &str = "sans-serif";

/// Sizes of headings and of labels of axes. plotters gives the height of a line; the font size that
/// it writes is 1.24 times smaller (pixels).
pub const HEADING: f64 = 20.0;
const LABEL: f64 = 18.0;
/// Size of numbers and legends.
pub const TEXT: f64 = 16.5;

/// Width of a character in units of these sizes, on the safe side of sans-serif.
pub const CHARACTER: f64 = 0.48;

/// Least size of text that is made smaller to fit (pixels). Smaller: it cannot be read.
const LEAST: f64 = 11.0;

/// Space around the axes for labels (pixels).
const MARGINS: [u32; 4] = [12, 24, 48, 78];

/// The size at which a text fits a width, at most `size` (pixels).
pub fn fitting(text: &str, size: f64, width: f64) -> f64 {
    let natural = CHARACTER * text.chars().count().max(1) as f64;
    (width / natural).clamp(LEAST, size)
}

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
    let [margin, right, below, left] = MARGINS;
    let (width, height) = root.dim_in_pixel();
    let (across, along) =
        (f64::from(width - left - margin - right), f64::from(height - below - 2 * margin) - 30.0);
    let heading = fitting(title, HEADING, f64::from(width - 2 * margin));
    let labels = [x.label, y.label].map(in_parentheses);
    // One size for both labels, so that neither looks like a note.
    let label = fitting(&labels[0], LABEL, across).min(fitting(&labels[1], LABEL, along));
    let mut chart = ChartBuilder::on(root)
        .margin(margin)
        .margin_right(right)
        .caption(title, (FONT, heading))
        .x_label_area_size(below)
        .y_label_area_size(left)
        .build_cartesian_2d(x.scale, y.scale)?;
    chart
        .configure_mesh()
        .x_desc(&labels[0])
        .y_desc(&labels[1])
        .label_style((FONT, TEXT))
        .axis_desc_style((FONT, label))
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
        .label_font((FONT, TEXT))
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.25))
        .draw()?;
    Ok(())
}
