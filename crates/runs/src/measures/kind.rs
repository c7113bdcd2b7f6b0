//! The kinds of measures: names, bodies, parameters with their defaults.

use std::fmt;

use anyhow::{Result, bail, ensure};
use carom::engine::{MeasureParameter, did_you_mean};

use super::{Measure, Selection};

/// A measure that can be asked for by name.
#[derive(Debug, Clone, Copy)]
pub struct MeasureKind {
    /// Its name in `run.observe`, and `kind` of `[[measure]]`.
    pub name: &'static str,
    /// What it measures, in a sentence.
    pub summary: &'static str,
    /// The bodies that it can be restricted to.
    pub of: Of,
    /// When it observes.
    pub span: Span,
    /// Its parameters besides those of [`Span::parameters`].
    pub parameters: &'static [Parameter],
    /// Beginnings of the names of its figures; a name ends with the label of the measure.
    pub figures: &'static [&'static str],
    /// Starts it.
    pub(super) start: fn(&Selection<'_>) -> Result<Box<dyn Measure>>,
    /// Restores it from a checkpoint.
    pub(super) resume: fn(&[u8]) -> Result<Box<dyn Measure>>,
}

/// The bodies of a measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    /// All bodies, or those with the tag after the colon; each measure says whether fixed ones
    /// count.
    Group,
    /// All bodies, those with one tag, or the pairs of a body of one tag and a body of another,
    /// `A,B`.
    TwoGroups,
    /// The only body with the tag after the colon, which is required.
    OneBody,
    /// All pairs of bodies, those with a body of one tag, or those of two tags, `A,B`.
    Pair,
    /// The whole system; no tag is allowed.
    System,
}

/// When a measure observes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Span {
    /// At samples, from `run.measure_from` on, so that the approach to equilibrium is left out.
    Measurement,
    /// At all samples of the run.
    WholeRun,
    /// Every contact of the run, written to a file while the run continues.
    EveryContact,
}

/// A number, word, tag or point that changes what a measure does.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Its key in `[[measure]]`.
    pub name: &'static str,
    /// Its value if it is not given.
    pub default: Default,
    /// What it is, with its unit.
    pub about: &'static str,
    accepts: Accepts,
}

/// The values that a parameter accepts.
#[derive(Debug, Clone, Copy)]
enum Accepts {
    /// A positive number.
    Positive,
    /// A whole number from 1 to this one.
    WholeUpTo(f64),
    /// One of these words.
    Words(&'static [&'static str]),
    /// The tag of a body.
    Tag,
    /// Both coordinates of a point, of any magnitude that a scene may have.
    Point,
}

/// The value of a parameter that is not given.
#[derive(Debug, Clone, Copy)]
pub enum Default {
    /// This number.
    Number(f64),
    /// A number that depends on the scene, in words.
    FromScene(&'static str),
}

impl fmt::Display for Default {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::FromScene(words) => f.write_str(words),
        }
    }
}

/// Largest number of bins, shells, … of a measure: more would fill the memory with its blocks.
const MAX_BINS: f64 = 1e5;

/// Largest number of samples or rows; more is taken as a mistake.
const MAX_RECORDS: f64 = 1e12;

/// Largest magnitude of a coordinate, as of other lengths of a scene.
const MAX_COORDINATE: f64 = 1e60;

impl Parameter {
    /// A number of bins, shells or the like, from 1 to 100 000.
    pub const fn whole(name: &'static str, default: Default, about: &'static str) -> Self {
        Self {
            name,
            default,
            about,
            accepts: Accepts::WholeUpTo(MAX_BINS),
        }
    }

    /// A whole number from 1 to `most`.
    pub const fn up_to(
        name: &'static str,
        most: f64,
        default: Default,
        about: &'static str,
    ) -> Self {
        Self {
            name,
            default,
            about,
            accepts: Accepts::WholeUpTo(most),
        }
    }

    /// A number of samples or rows, from 1 to 10¹².
    pub const fn records(name: &'static str, default: Default, about: &'static str) -> Self {
        Self {
            name,
            default,
            about,
            accepts: Accepts::WholeUpTo(MAX_RECORDS),
        }
    }

    /// A positive quantity.
    pub const fn positive(name: &'static str, default: Default, about: &'static str) -> Self {
        Self {
            name,
            default,
            about,
            accepts: Accepts::Positive,
        }
    }

    /// One of some words.
    pub const fn word(
        name: &'static str,
        words: &'static [&'static str],
        default: Default,
        about: &'static str,
    ) -> Self {
        Self {
            name,
            default,
            about,
            accepts: Accepts::Words(words),
        }
    }

    /// The tag of a body.
    pub const fn tag(name: &'static str, default: Default, about: &'static str) -> Self {
        Self {
            name,
            default,
            about,
            accepts: Accepts::Tag,
        }
    }

    /// A point, `[x, y]`.
    pub const fn point(name: &'static str, default: Default, about: &'static str) -> Self {
        Self {
            name,
            default,
            about,
            accepts: Accepts::Point,
        }
    }

    /// Validates a value.
    pub(super) fn check(&self, value: &MeasureParameter) -> Result<()> {
        let name = self.name;
        match (self.accepts, value) {
            (Accepts::Positive, MeasureParameter::Number(value)) => ensure!(
                value.is_finite() && *value > 0.0,
                "'{name}' must be positive and finite, but is {value:?}"
            ),
            (Accepts::WholeUpTo(most), MeasureParameter::Number(value)) => ensure!(
                value.fract() == 0.0 && (1.0..=most).contains(value),
                "'{name}' must be a whole number from 1 to {}, but is {value}",
                if most < 1e3 {
                    format!("{most}")
                } else {
                    format!("{most:e}")
                }
            ),
            (Accepts::Words(words), MeasureParameter::Text(word)) => ensure!(
                words.contains(&word.as_str()),
                "'{name}' must be one of {}, but is {word:?}{}",
                words.join(", "),
                did_you_mean(word, words.iter().copied())
            ),
            (Accepts::Tag, MeasureParameter::Text(_)) => {}
            (Accepts::Point, MeasureParameter::Numbers(numbers)) => ensure!(
                numbers.len() == 2 && numbers.iter().all(|x| x.abs() <= MAX_COORDINATE),
                "'{name}' must be two numbers of magnitude up to {MAX_COORDINATE:e}, [x, y], but is {numbers:?}"
            ),
            _ => bail!("'{name}' must be {}", self.accepts),
        }
        Ok(())
    }
}

impl fmt::Display for Accepts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Positive | Self::WholeUpTo(_) => f.write_str("a number"),
            Self::Words(words) => write!(f, "one of {}", words.join(", ")),
            Self::Tag => f.write_str("the tag of a body, as a text"),
            Self::Point => f.write_str("two numbers, [x, y]"),
        }
    }
}

/// Samples of the run for each sample of a measure.
pub(super) const EVERY: Parameter = Parameter::records(
    "every",
    Default::Number(1.0),
    "samples of the run for one sample of the measure",
);

/// Time between samples of a measure.
pub(super) const INTERVAL: Parameter = Parameter::positive(
    "interval",
    Default::FromScene("run.sample_interval"),
    "time between its samples, a multiple of run.sample_interval; excludes 'every'",
);

/// The time at which a measure begins.
pub(super) const FROM: Parameter = Parameter::positive(
    "from",
    Default::FromScene("run.measure_from"),
    "time of its first sample, or that of the next sample of the run (time)",
);

/// The time at which a measure ends.
pub(super) const UNTIL: Parameter = Parameter::positive(
    "until",
    Default::FromScene("the end of the run"),
    "time of its last sample, or that of the next sample of the run (time)",
);

/// The longest lag of correlations in time.
pub(super) const MAX_LAG: Parameter = Parameter::positive(
    "max",
    Default::FromScene("1e6 samples"),
    "longest lag (time)",
);

impl Span {
    /// The parameters of all measures with this span.
    pub fn parameters(self) -> &'static [Parameter] {
        match self {
            Self::Measurement | Self::WholeRun => &[EVERY, INTERVAL, FROM, UNTIL],
            Self::EveryContact => &[],
        }
    }
}

impl MeasureKind {
    /// All parameters that an entry `[[measure]]` may have.
    pub fn all_parameters(&self) -> impl Iterator<Item = &'static Parameter> {
        self.span.parameters().iter().chain(self.parameters)
    }

    /// Validates the tags of a name.
    pub(super) fn check_tags(&self, name: &str, tags: &[&str]) -> Result<()> {
        let kind = self.name;
        match (self.of, tags.len()) {
            (Of::OneBody, 0) => bail!("'{name}' needs the tag of a body: {kind}:TAG"),
            (Of::System, 1..) => bail!("'{name}': it covers the whole system and takes no tag"),
            (Of::TwoGroups | Of::Pair, 3..) => {
                bail!("'{name}': it takes at most two tags: {kind}:TAG,TAG")
            }
            (Of::Group | Of::OneBody, 2..) => bail!("'{name}': it takes one tag"),
            _ => {}
        }
        tags.iter()
            .try_for_each(|tag| check_word(name, "the tag", tag))
    }

    /// The name with the place of its tags, such as `velocities[:TAG]`.
    pub fn usage(&self) -> String {
        let tag = match self.of {
            Of::Group => "[:TAG]",
            Of::OneBody => ":TAG",
            Of::TwoGroups | Of::Pair => "[:TAG[,TAG]]",
            Of::System => "",
        };
        format!("{}{tag}", self.name)
    }
}

/// Validates a word that becomes part of a file name.
pub(super) fn check_word(name: &str, what: &str, word: &str) -> Result<()> {
    ensure!(
        !word.is_empty()
            && word
                .chars()
                .all(|c| c.is_alphanumeric() || "-_".contains(c)),
        "'{name}': {what} may contain letters, digits, - and _ only"
    );
    Ok(())
}
