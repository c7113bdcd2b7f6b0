//! The slope of a measured curve between two lags, for transport coefficients.

use carom_tables::{BlockMean, significant};

use super::HardDiscs;

/// A slope between two lags.
pub struct Slope {
    between: [f64; 2],
    /// The slope (unit of the curve / time).
    pub value: f64,
    /// Its standard error. Both ends have the same origins, and the later one has nearly all of the
    /// error.
    pub standard_error: Option<f64>,
}

impl Slope {
    /// The slope between the first lags of at least these numbers of mean free times; `None` if the
    /// curve is too short or too coarse.
    pub fn between(
        free_times: [f64; 2],
        lags: &[f64],
        curve: &[BlockMean],
        gas: &HardDiscs,
    ) -> Option<Self> {
        let rate = gas.collision_rate();
        let at = |free_times: f64| {
            lags.iter()
                .zip(curve)
                .find(|(lag, _)| **lag * rate >= free_times)
        };
        let ((&begin, first), (&end, last)) = (at(free_times[0])?, at(free_times[1])?);
        let duration = end - begin;
        (duration > 0.0).then_some(())?;
        Some(Self {
            between: [begin, end],
            value: (last.value? - first.value?) / duration,
            standard_error: last.standard_error.map(|error| error / duration),
        })
    }

    /// The two lags, for the name of a figure.
    pub fn lags(&self) -> String {
        between(self.between)
    }
}

/// Two lags, for the name of a figure.
pub(super) fn between([begin, end]: [f64; 2]) -> String {
    let [begin, end] = [begin, end].map(|lag| significant(lag, 3));
    format!("{begin} to {end}")
}
