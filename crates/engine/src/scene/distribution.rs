//! Distributions of sizes and masses: the molecules of a gas need not be equal.
//!
//! Numbers are drawn from the stream [`RandomStream::Sizes`](crate::RandomStream::Sizes), which
//! nothing else uses: a gas of equal molecules starts from the same state with and without another
//! gas of drawn sizes.

use std::fmt;

use rand::{RngExt, distr::Open01};
use rand_pcg::Pcg64;
use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{Error, MapAccess, Visitor},
    ser::SerializeMap,
};

use crate::scene::{random::normal_pair, two_numbers::TwoNumbers};

/// Numbers farther than this many standard deviations from the mean of a normal distribution are
/// drawn again: one such number among 10⁴ molecules would set the size of all cells. The standard
/// deviation of the numbers kept is smaller by 0.05 %.
const MAX_DEVIATION: f64 = 4.0;

/// Most draws of one number. At least 49 % of the numbers of a normal distribution with a mean
/// above 0 are kept, so that the last draw is rejected with a probability of 10⁻⁷⁴.
const MAX_DRAWS: usize = 256;

/// A distribution of positive numbers, from which each molecule of a gas draws its own.
///
/// ```
/// use carom_engine::{Scene, Simulation};
///
/// // Mass proportional to area, sizes from 0.7 to 1.3 of the mean.
/// let scene = Scene::from_toml(r#"
///     [[gas]]
///     radius = { uniform = [0.007, 0.013] }
///     density = 1000.0
///     temperature = 1.0
///     velocities = "maxwell"
///     area_fraction = 0.4
/// "#)?;
/// let simulation = Simulation::new(&scene)?;
/// let area: f64 = simulation.view().bodies().map(|body| body.body.molecule().area()).sum();
/// assert!((area - 0.4).abs() < 0.001);
/// assert!((simulation.view().temperature().unwrap() - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
#[doc(alias = "polydispersity")]
pub enum Distribution {
    /// Uniform between two numbers, above 0 and in ascending order. In a file: `{ uniform = [a, b]
    /// }`.
    Uniform([f64; 2]),
    /// Normal with this mean and standard deviation, above 0 and at least 0. Numbers that are not
    /// positive, or more than four standard deviations from the mean, are drawn again. In a file:
    /// `{ normal = [mean, deviation] }`.
    #[doc(alias = "Gaussian")]
    Normal([f64; 2]),
    /// One of these numbers, all above 0, with probabilities in proportion to the weights; without
    /// weights, with equal probabilities. In a file: `{ values = [...], weights = [...] }`.
    Values {
        /// The numbers.
        values: Vec<f64>,
        /// Their weights: as many, each at least 0, with a positive sum; or none.
        weights: Vec<f64>,
    },
}

impl Distribution {
    /// Refuses parameters out of range; the message does not name the key.
    pub(crate) fn check(&self) -> Result<(), String> {
        let is_length = |number: f64| (1e-60..=1e60).contains(&number);
        match self {
            Self::Uniform([from, to]) if !(is_length(*from) && is_length(*to) && from <= to) => {
                Err(format!(
                    "`uniform` must be two numbers in ascending order from 1e-60 to 1e60, but is [{from}, {to}]"
                ))
            }
            Self::Normal([mean, deviation])
                if !(is_length(*mean) && (0.0..=1e60).contains(deviation)) =>
            {
                Err(format!(
                    "`normal` must be a mean from 1e-60 to 1e60 and a standard deviation from 0 to 1e60, but is \
                     [{mean}, {deviation}]"
                ))
            }
            Self::Values { values, weights } => check_values(values, weights),
            _ => Ok(()),
        }
    }

    /// Mean of the square of the numbers; for a normal distribution, without the cuts at 0 and at
    /// four standard deviations, which change it by less than 15 %.
    pub(crate) fn mean_square(&self) -> f64 {
        match self {
            Self::Uniform([from, to]) => (from * from + from * to + to * to) / 3.0,
            Self::Normal([mean, deviation]) => mean * mean + deviation * deviation,
            Self::Values { values, weights } => {
                let weight = |index: usize| weights.get(index).copied().unwrap_or(1.0);
                let all: f64 = (0..values.len()).map(weight).sum();
                let share = |(index, value): (usize, &f64)| weight(index) / all * value * value;
                values.iter().enumerate().map(share).sum()
            }
        }
    }

    /// Mean of the numbers; for a normal distribution, without the cuts at 0 and at four standard
    /// deviations.
    pub fn mean(&self) -> f64 {
        match self {
            Self::Uniform([from, to]) => 0.5 * (from + to),
            Self::Normal([mean, _]) => *mean,
            Self::Values { values, weights } => {
                let weight = |index: usize| weights.get(index).copied().unwrap_or(1.0);
                let all: f64 = (0..values.len()).map(weight).sum();
                values
                    .iter()
                    .enumerate()
                    .map(|(index, value)| weight(index) / all * value)
                    .sum()
            }
        }
    }

    /// Greatest lower bound of the numbers: at least 0, and 0 for a normal distribution with a
    /// standard deviation above a quarter of its mean.
    pub fn lower_bound(&self) -> f64 {
        match self {
            Self::Uniform([from, _]) => *from,
            Self::Normal([mean, deviation]) => (mean - MAX_DEVIATION * deviation).max(0.0),
            Self::Values { values, weights } => {
                let is_drawn = |index: usize| weights.get(index).is_none_or(|&weight| weight > 0.0);
                let drawn = values
                    .iter()
                    .enumerate()
                    .filter(|(index, _)| is_drawn(*index));
                drawn.map(|(_, value)| *value).fold(f64::INFINITY, f64::min)
            }
        }
    }

    /// Draws a number.
    pub(crate) fn draw(&self, random: &mut Pcg64) -> f64 {
        match self {
            Self::Uniform([from, to]) => {
                let share: f64 = random.sample(Open01);
                (from + share * (to - from)).clamp(*from, *to)
            }
            Self::Normal([mean, deviation]) => (0..MAX_DRAWS)
                .map(|_| normal_pair(random).x)
                .filter(|score| score.abs() <= MAX_DEVIATION)
                .map(|score| mean + score * deviation)
                .find(|&number| number > 0.0)
                .unwrap_or(*mean),
            Self::Values { values, weights } => {
                let weight = |index: usize| weights.get(index).copied().unwrap_or(1.0);
                let all: f64 = (0..values.len()).map(weight).sum();
                let mut rest = all * random.random::<f64>();
                let last = (0..values.len())
                    .rfind(|&index| weight(index) > 0.0)
                    .unwrap_or(0);
                let chosen = (0..last).find(|&index| {
                    rest -= weight(index);
                    rest < 0.0
                });
                values[chosen.unwrap_or(last)]
            }
        }
    }
}

fn check_values(values: &[f64], weights: &[f64]) -> Result<(), String> {
    if values.is_empty() {
        return Err("`values` must have at least one number".to_owned());
    }
    if let Some(value) = values.iter().find(|value| !(1e-60..=1e60).contains(*value)) {
        return Err(format!(
            "`values` must be from 1e-60 to 1e60, but one is {value:?}"
        ));
    }
    if !weights.is_empty() && weights.len() != values.len() {
        return Err(format!(
            "{} `values` have {} `weights`: give as many",
            values.len(),
            weights.len()
        ));
    }
    if let Some(weight) = weights
        .iter()
        .find(|weight| !(0.0..=1e60).contains(*weight))
    {
        return Err(format!(
            "`weights` must be from 0 to 1e60, but one is {weight:?}"
        ));
    }
    if !weights.is_empty() && weights.iter().all(|&weight| weight == 0.0) {
        return Err("at least one of the `weights` must be above 0".to_owned());
    }
    Ok(())
}

impl Serialize for Distribution {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        match self {
            Self::Uniform(ends) => map.serialize_entry("uniform", ends)?,
            Self::Normal(moments) => map.serialize_entry("normal", moments)?,
            Self::Values { values, weights } => {
                map.serialize_entry("values", values)?;
                if !weights.is_empty() {
                    map.serialize_entry("weights", weights)?;
                }
            }
        }
        map.end()
    }
}

/// A positive quantity of the molecules of a gas: one number for all, or a distribution from which
/// each draws its own.
///
/// ```
/// use carom_engine::{Distribution, GasSpec, Quantity};
///
/// let equal = GasSpec { radius: Some(0.01.into()), ..GasSpec::default() };
/// let drawn = GasSpec { radius: Some(Distribution::Uniform([0.01, 0.02]).into()), ..equal.clone() };
/// assert_eq!(equal.radius.and_then(|radius| radius.number()), Some(0.01));
/// assert_eq!(drawn.radius.and_then(|radius| radius.number()), None);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Quantity {
    /// The same for all.
    Number(f64),
    /// Drawn for each.
    Drawn(Distribution),
}

impl Quantity {
    /// The number; `None` if it is drawn.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Drawn(_) => None,
        }
    }

    /// The distribution from which it is drawn; that of a number has one value.
    pub(crate) fn distribution(&self) -> Distribution {
        match self {
            Self::Number(number) => Distribution::Values {
                values: vec![*number],
                weights: Vec::new(),
            },
            Self::Drawn(distribution) => distribution.clone(),
        }
    }

    /// Whether all molecules have the same.
    pub(crate) fn is_one(&self) -> bool {
        match self {
            Self::Drawn(Distribution::Values { values, .. }) => values.len() == 1,
            Self::Drawn(_) => false,
            Self::Number(_) => true,
        }
    }

    /// Refuses a distribution out of range; the message does not name the key. A number is refused
    /// where it becomes an atom.
    pub(crate) fn check(&self) -> Result<(), String> {
        match self {
            Self::Number(_) => Ok(()),
            Self::Drawn(distribution) => distribution.check(),
        }
    }
}

impl From<f64> for Quantity {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<Distribution> for Quantity {
    fn from(distribution: Distribution) -> Self {
        Self::Drawn(distribution)
    }
}

impl<'de> Deserialize<'de> for Quantity {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(QuantityVisitor)
    }
}

/// As the visitor reads it.
#[cfg(feature = "schema")]
impl schemars::JsonSchema for Quantity {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Quantity".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "anyOf": [
                { "type": "number", "minimum": 1e-60, "maximum": 1e60 },
                {
                    "type": "object",
                    "properties": {
                        "uniform": { "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 2 },
                        "normal": { "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 2 },
                        "values": { "type": "array", "items": { "type": "number" } },
                        "weights": { "type": "array", "items": { "type": "number" } }
                    },
                    "additionalProperties": false
                }
            ]
        })
    }
}

struct QuantityVisitor;

const FORMS: &str = "`{ uniform = [a, b] }`, `{ normal = [mean, deviation] }` or `{ values = [...], weights = [...] }`";

impl<'de> Visitor<'de> for QuantityVisitor {
    type Value = Quantity;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a number, {FORMS}")
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Quantity, E> {
        Ok(Quantity::Number(number))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Quantity, E> {
        Ok(Quantity::Number(number as f64))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Quantity, E> {
        Ok(Quantity::Number(number as f64))
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Quantity, M::Error> {
        let (mut simple, mut values, mut weights) = (None, None, None);
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "uniform" if simple.is_none() => {
                    let ends = map.next_value_seed(TwoNumbers("[from, to]"))?;
                    simple = Some(Distribution::Uniform(ends));
                }
                "normal" if simple.is_none() => {
                    let moments = map.next_value_seed(TwoNumbers("[mean, deviation]"))?;
                    simple = Some(Distribution::Normal(moments));
                }
                "values" => values = Some(map.next_value()?),
                "weights" => weights = Some(map.next_value()?),
                _ => {
                    return Err(M::Error::custom(format!(
                        "unexpected key `{key}`: give {FORMS}"
                    )));
                }
            }
        }
        match (simple, values, weights) {
            (Some(simple), None, None) => Ok(Quantity::Drawn(simple)),
            (None, Some(values), weights) => Ok(Quantity::Drawn(Distribution::Values {
                values,
                weights: weights.unwrap_or_default(),
            })),
            _ => Err(M::Error::custom(format!("give {FORMS}"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::random::RandomStream;

    /// Mean and variance of many numbers, with the standard errors of both.
    fn moments(distribution: &Distribution) -> [(f64, f64); 2] {
        let mut random = RandomStream::Sizes.generator(7, 0);
        let numbers: Vec<f64> = (0..200_000)
            .map(|_| distribution.draw(&mut random))
            .collect();
        let count = numbers.len() as f64;
        let mean = numbers.iter().sum::<f64>() / count;
        let power = |n| numbers.iter().map(|x| (x - mean).powi(n)).sum::<f64>() / count;
        let (variance, fourth) = (power(2), power(4));
        [
            (mean, (variance / count).sqrt()),
            (variance, ((fourth - variance * variance) / count).sqrt()),
        ]
    }

    fn assert_moments(distribution: &Distribution, mean: f64, variance: f64) {
        distribution.check().unwrap();
        let square = distribution.mean_square();
        let exact = variance + mean * mean;
        assert!(
            (square / exact - 1.0).abs() < 0.15,
            "{distribution:?}: {square}, {exact}"
        );
        for ((drawn, error), expected) in moments(distribution).into_iter().zip([mean, variance]) {
            assert!(
                (drawn - expected).abs() < 5.0 * error,
                "{distribution:?}: {drawn} ± {error}, {expected}"
            );
        }
    }

    #[test]
    fn moments_are_those_of_the_formulas() {
        // (a + b)/2 and (b − a)²/12.
        assert_moments(&Distribution::Uniform([0.7, 1.3]), 1.0, 0.03);
        // Cut at four standard deviations: 1 − 8 φ(4)/(2Φ(4) − 1) times the variance.
        assert_moments(&Distribution::Normal([2.0, 0.1]), 2.0, 0.01 * 0.998_929);
        // Cut at 0 and at 4: with α = −1, β = 4, Z = Φ(4) − Φ(−1) and δ = (φ(α) − φ(β))/Z, the mean
        // is 1 + δ and the variance 1 + (α φ(α) − β φ(β))/Z − δ².
        let (phi, cdf) = (
            [0.241_970_724_5, 1.338_302_258e-4],
            0.999_968_328_8 - 0.158_655_253_9,
        );
        let shift = (phi[0] - phi[1]) / cdf;
        let variance = 1.0 + (-phi[0] - 4.0 * phi[1]) / cdf - shift * shift;
        assert_moments(&Distribution::Normal([1.0, 1.0]), 1.0 + shift, variance);
        // Σ w x / Σ w and Σ w (x − mean)² / Σ w; a value of weight 0 is never drawn.
        let values = Distribution::Values {
            values: vec![1.0, 2.0, 9.0],
            weights: vec![3.0, 1.0, 0.0],
        };
        assert_moments(&values, 1.25, 0.1875);
        assert_eq!((values.mean(), values.lower_bound()), (1.25, 1.0));
        let equal = Distribution::Values {
            values: vec![1.0, 2.0],
            weights: vec![],
        };
        assert_moments(&equal, 1.5, 0.25);
        assert_eq!((equal.mean(), equal.lower_bound()), (1.5, 1.0));
        let uniform = Distribution::Uniform([0.5, 1.5]);
        assert_eq!((uniform.mean(), uniform.lower_bound()), (1.0, 0.5));
        assert_eq!(Distribution::Normal([2.0, 0.25]).lower_bound(), 1.0);
        assert_eq!(Distribution::Normal([1.0, 1.0]).lower_bound(), 0.0);
    }
}
