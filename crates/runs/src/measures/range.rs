//! Distributions in a range that is given or follows the data: the key, what lies outside, and the
//! words for the page.

use carom::observers::AdaptiveHistogram;
use carom_tables::{BlockMean, Figure};

use super::{Context, Default};

/// Name of the key that gives the range.
pub(super) const MAX: &str = "max";

/// The range without that key.
pub(super) const FOLLOWS: Default = Default::FromScene("follows the data");

/// [Σx, Σw] of the share of the values outside the range.
pub(super) fn outside(distribution: &AdaptiveHistogram) -> [f64; 2] {
    [distribution.beyond() as f64, distribution.total() as f64]
}

/// The share of `what` outside a given range, with its error; `None` if the range follows the data,
/// so that none is outside.
pub(super) fn share_outside(
    distribution: &AdaptiveHistogram,
    what: &str,
    mean: Option<&BlockMean>,
    context: &Context<'_>,
) -> Option<Figure> {
    let mean = mean.filter(|_| distribution.has_given_range())?;
    context.figure(&format!("share of the {what} outside the range"), "1", mean)
}

/// How the densities of a table are normalised and what their bins are.
pub(super) fn caption(distributions: &[&AdaptiveHistogram]) -> String {
    if !distributions
        .iter()
        .any(|distribution| distribution.has_given_range())
    {
        return "Normalised to 1 over all values: the range follows the data. Bins have equal widths, \
                or, beyond the bulk of the values, widths that double with each octave."
            .to_owned();
    }
    let sum = |of: fn(&AdaptiveHistogram) -> u64| {
        distributions
            .iter()
            .map(|distribution| of(distribution))
            .sum()
    };
    let (outside, all): (u64, u64) = (
        sum(AdaptiveHistogram::beyond),
        sum(AdaptiveHistogram::total),
    );
    let share = outside as f64 / all.max(1) as f64;
    format!(
        "Normalised to 1 over all values, of which a share of {share:.3e} ({outside} of {all}) is \
         outside the given range."
    )
}
