//! Coefficients that are read from a curve over the lag, such as a diffusion coefficient: from the
//! sums of one run, and anew from those of several runs together.
//!
//! At which lags a coefficient is read depends on the data. So the coefficients of replicas are not
//! averaged: they belong to different lags. Nor are rates of events, whose error comes from the
//! number of events in all runs.

use carom_tables::{BlockMean, Figure, Sums, block_sums, significant};
use serde::{Deserialize, Serialize};

use super::transport::{
    MIN_PAIRS, Plateau, Slope, Taken, TransportCurve, TransportValue, error_at_lag,
};

/// ⟨cos Δθ⟩ below this is not used for its decay. Smaller: its logarithm is noise. Larger: fewer
/// lags.
const MIN_COSINE: f64 = 0.1;

/// ⟨cos Δθ⟩ must exceed this number of its standard errors. Smaller: its logarithm has a bias.
/// Larger: fewer lags.
const MIN_RESOLUTION: f64 = 4.0;

/// What a coefficient is, and how it follows from the sums of a measure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Coefficient {
    /// Its name without lags.
    name: String,
    /// The label of the measure, which ends the name.
    label: Option<String>,
    unit: String,
    /// The coefficient by what is read from the curve.
    factor: f64,
    reading: Reading,
    /// The number of the sums of the curve at the first lag, or of the events; those at the other
    /// lags follow.
    curve: usize,
    /// All lags (time), from 0 on.
    lags: Vec<f64>,
    /// Duration of a block (time).
    block: f64,
    /// A prediction and its source.
    prediction: Option<(f64, String)>,
}

/// What is read from a curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) enum Reading {
    /// The slope between the lags nearest to these (time).
    SlopeBetween([f64; 2]),
    /// The slope where it has become constant. `memory` is the number of the first sum of the
    /// autocorrelation of the velocities at the same lags.
    Plateau { memory: usize },
    /// The rate of the exponential decay of the curve where it has become constant.
    Decay { memory: usize },
    /// The integral from lag 0 on.
    Integral,
    /// No curve, but the rate of events: their number over the time, with the error R/√n of n
    /// events.
    ///
    /// Events such as first passages happen early, so that blocks of time are no sample of them. If
    /// the rate R is constant, n events have the information n/R² about it, whether or not other
    /// bodies still wait (Cox and Oakes 1984, "Analysis of Survival Data", chapter 3).
    EventRate,
}

impl Coefficient {
    /// A coefficient of this name and unit: `factor` times what is read from the curve whose sums
    /// begin with number `curve`, one for each of `lags` (time). The last are the label of the
    /// measure and the duration of a block (time).
    pub(crate) fn new(
        (name, unit): (&str, &str),
        (reading, factor): (Reading, f64),
        curve: usize,
        lags: &[f64],
        (label, block): (Option<&str>, f64),
    ) -> Self {
        Self {
            name: name.to_owned(),
            label: label.map(str::to_owned),
            unit: unit.to_owned(),
            factor,
            reading,
            curve,
            lags: lags.to_vec(),
            block,
            prediction: None,
        }
    }

    /// Sets the prediction, if there is one, and its source.
    pub(crate) fn predicted(self, prediction: Option<f64>, source: &str) -> Self {
        let prediction = prediction.map(|value| (value, source.to_owned()));
        Self { prediction, ..self }
    }

    /// Whether two are the same coefficient, of different runs.
    pub fn is_same(&self, other: &Self) -> bool {
        let kind = |one: &Self| std::mem::discriminant(&one.reading);
        self.name == other.name && self.curve == other.curve && kind(self) == kind(other)
    }

    /// The coefficient of several runs of one scene: of the first, with the factors and the
    /// predictions in the mean.
    pub fn merged(all: &[&Self]) -> Option<Self> {
        let count = all.len() as f64;
        let mean = |sum: f64| sum / count;
        let first = *all.first()?;
        let predictions = all.iter().map(|one| Some(one.prediction.as_ref()?.0));
        let prediction = predictions.sum::<Option<f64>>().map(mean);
        let source = first.prediction.as_ref().map(|(_, source)| source.clone());
        Some(Self {
            factor: mean(all.iter().map(|one| one.factor).sum()),
            // Each run has its own start, and so its own duration of blocks. Errors hold at lags
            // that the shortest resolve.
            block: all
                .iter()
                .map(|one| one.block)
                .fold(f64::INFINITY, f64::min),
            prediction: prediction.zip(source),
            ..first.clone()
        })
    }

    /// The figure from the sums over all runs and the blocks of each; `None` if they are too few.
    pub fn figure(&self, total: &[[f64; 2]], runs: &[Vec<Sums>]) -> Option<Figure> {
        let curve = self.means(self.curve, total, runs);
        let of_curve = |means, of| TransportCurve {
            lags: &self.lags,
            means,
            runs,
            block: self.block,
            of,
        };
        let (name, value, error) = match self.reading {
            Reading::SlopeBetween(between) => {
                let slope: Slope = of_curve(&curve, Taken::Itself).slope_between(between)?;
                (slope.named(&self.name), slope.value, slope.standard_error)
            }
            Reading::Plateau { memory } => {
                let memory = self.means(memory, total, runs);
                self.of_plateau(of_curve(&curve, Taken::Itself).plateau(&memory)?)
            }
            Reading::Decay { memory } => {
                let memory = self.means(memory, total, runs);
                let known = known_cosines(&curve);
                self.of_plateau(of_curve(&known, Taken::MinusLogarithm).plateau(&memory)?)
            }
            Reading::Integral => {
                let (integral, until) = of_curve(&curve, Taken::Itself).integral()?;
                let name = format!("{}, up to lag {}", self.name, significant(until, 3));
                (name, integral.value, Some(integral.standard_error))
            }
            Reading::EventRate => {
                let [events, time] = *total.get(self.curve)?;
                let rate = (time > 0.0).then(|| events / time)?;
                let error = (events > 0.0).then(|| rate / events.sqrt());
                (self.name.clone(), rate, error)
            }
        };
        let name = match &self.label {
            Some(label) => format!("{name}, {label}"),
            None => name,
        };
        let figure = Figure::new(name, self.factor * value, &self.unit)
            .error(error.map(|error| self.factor * error));
        Some(match &self.prediction {
            Some((prediction, source)) => figure.predicted(*prediction, source),
            None => figure,
        })
    }

    fn of_plateau(&self, plateau: Plateau) -> (String, f64, Option<f64>) {
        let TransportValue {
            value,
            standard_error,
        } = plateau.slope;
        (plateau.named(&self.name), value, Some(standard_error))
    }

    /// The means at all lags of a quantity whose sums begin with number `first`, with errors as far
    /// as blocks are long enough; none at lags with few pairs.
    fn means(&self, first: usize, total: &[[f64; 2]], runs: &[Vec<Sums>]) -> Vec<BlockMean> {
        // Of all quantities of a measure only those of this curve: each takes a spectrum.
        let of_curve = |sums: &[[f64; 2]]| -> Sums {
            let end = (first + self.lags.len()).min(sums.len());
            sums.get(first..end).unwrap_or_default().to_vec()
        };
        let of_run = |blocks: &Vec<Sums>| blocks.iter().map(|sums| of_curve(sums)).collect();
        let total = of_curve(total);
        let all = block_sums::means(&total, &runs.iter().map(of_run).collect::<Vec<_>>());
        let mean = |(place, &lag): (usize, &f64)| {
            let (Some(&[_, pairs]), Some(&mean)) = (total.get(place), all.get(place)) else {
                return BlockMean::default();
            };
            if pairs < MIN_PAIRS as f64 {
                return BlockMean::default();
            }
            let mean = BlockMean {
                quantity: Some(first + place),
                ..mean
            };
            BlockMean {
                standard_error: error_at_lag(&mean, lag, self.block, runs),
                ..mean
            }
        };
        self.lags.iter().enumerate().map(mean).collect()
    }
}

/// ⟨cos Δθ⟩ up to the lag at which it is forgotten, with errors where its logarithm is known.
fn known_cosines(cosines: &[BlockMean]) -> Vec<BlockMean> {
    let is_usable = |mean: &BlockMean| {
        let (Some(value), Some(error)) = (mean.value, mean.standard_error) else {
            return false;
        };
        value >= MIN_COSINE && value >= MIN_RESOLUTION * error
    };
    let forgotten = cosines
        .iter()
        .position(|mean| mean.value.is_none_or(|value| value < MIN_COSINE));
    cosines[..forgotten.unwrap_or(cosines.len())]
        .iter()
        .map(|mean| BlockMean {
            standard_error: mean.standard_error.filter(|_| is_usable(mean)),
            ..*mean
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_a_rate_of_events_is_that_of_their_number() {
        let rate = Coefficient::new(
            ("rate", "1/time"),
            (Reading::EventRate, 1.0),
            1,
            &[],
            (Some("gas"), 0.5),
        );
        let figure = |sums| rate.figure(&[[0.0; 2], sums], &[]);
        let found = figure([36.0, 60.0]).unwrap();
        assert_eq!((found.name.as_str(), found.value), ("rate, gas", 0.6));
        assert!((found.standard_error.unwrap() - 0.1).abs() < 1e-15);
        let without = figure([0.0, 60.0]).unwrap();
        assert_eq!((without.value, without.standard_error), (0.0, None));
        assert_eq!(figure([0.0, 0.0]), None);
    }
}
