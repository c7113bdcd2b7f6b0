//! Chart of the directions of impulses on a molecule, in its own frame.

use anyhow::Result;
use carom_report::plot::{Axis, Chart, Layer, Shape, colour, staircase};

/// Draws a histogram over equal sectors of all directions: values, their standard errors, and the
/// prediction, whose name is `name`; an empty prediction is not drawn.
///
/// # Errors
/// A value is not finite.
pub fn directions(
    title: &str,
    label: &str,
    [values, errors, predicted]: &[Vec<f64>; 3],
    name: &str,
) -> Result<String> {
    let highest =
        values.iter().zip(errors).map(|(value, error)| value + error).chain(predicted.iter().copied());
    let highest = highest.fold(0.0, f64::max);
    let with = |sign: f64| -> Vec<f64> {
        values.iter().zip(errors).map(|(value, error)| value + sign * error).collect()
    };
    let band = staircase(0.0, 360.0, &with(-1.0)).into_iter().zip(staircase(0.0, 360.0, &with(1.0)));
    let mut layers = vec![
        Layer {
            name: "± one standard error".to_owned(),
            colour: colour::BLUE,
            shape: Shape::Band(band.map(|((x, low), (_, high))| (x, low, high)).collect()),
        },
        Layer {
            name: "measured".to_owned(),
            colour: colour::BLUE,
            shape: Shape::Thin(staircase(0.0, 360.0, values)),
        },
    ];
    if !predicted.is_empty() {
        layers.push(Layer {
            name: name.to_owned(),
            colour: colour::VERMILLION,
            shape: Shape::Line(staircase(0.0, 360.0, predicted)),
        });
    }
    Chart {
        title: title.to_owned(),
        x: Axis {
            label: "direction of the impulse in the body frame [degrees from x′]".to_owned(),
            range: (0.0, 360.0),
        },
        y: Axis { label: label.to_owned(), range: (0.0, if highest > 0.0 { 1.2 * highest } else { 1.0 }) },
        layers,
    }
    .svg()
}
