//! The time at which the measurement of a run starts: a given one, or that at which it has settled.

use std::fmt;

use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{Error, Visitor},
};

/// The word in a file.
const AUTO: &str = "auto";

/// The time at which the averages of a run start. In a file a number or `"auto"`.
///
/// ```
/// use carom_engine::{MeasureFrom, Scene};
///
/// let scene = Scene::from_toml("[run]\nmeasure_from = \"auto\"")?;
/// assert_eq!(scene.run.measure_from, MeasureFrom::Auto);
/// assert_eq!(MeasureFrom::from(2.5).time(), Some(2.5));
/// # Ok::<(), carom_engine::SceneError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MeasureFrom {
    /// From the first sample at or after this time on (time).
    Time(f64),
    /// When no mean changes any more. After 64 samples it is judged whether a mean has changed
    /// since the measurement started; if so, all is dropped, the measurement starts anew, and is
    /// judged again after twice as many samples.
    Auto,
}

impl MeasureFrom {
    /// The time that is given; `None` for [`Self::Auto`].
    pub fn time(self) -> Option<f64> {
        match self {
            Self::Time(time) => Some(time),
            Self::Auto => None,
        }
    }

    /// Whether the whole run is measured.
    pub fn is_start(&self) -> bool {
        *self == Self::default()
    }
}

impl Default for MeasureFrom {
    fn default() -> Self {
        Self::Time(0.0)
    }
}

impl From<f64> for MeasureFrom {
    fn from(time: f64) -> Self {
        Self::Time(time)
    }
}

impl fmt::Display for MeasureFrom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Time(time) => write!(f, "{time}"),
            Self::Auto => f.write_str(AUTO),
        }
    }
}

impl Serialize for MeasureFrom {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Time(time) => serializer.serialize_f64(*time),
            Self::Auto => serializer.serialize_str(AUTO),
        }
    }
}

impl<'de> Deserialize<'de> for MeasureFrom {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NumberOrAuto;
        impl Visitor<'_> for NumberOrAuto {
            type Value = MeasureFrom;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a time or \"auto\"")
            }

            fn visit_f64<E: Error>(self, time: f64) -> Result<MeasureFrom, E> {
                Ok(MeasureFrom::Time(time))
            }

            fn visit_i64<E: Error>(self, time: i64) -> Result<MeasureFrom, E> {
                Ok(MeasureFrom::Time(time as f64))
            }

            fn visit_u64<E: Error>(self, time: u64) -> Result<MeasureFrom, E> {
                Ok(MeasureFrom::Time(time as f64))
            }

            fn visit_str<E: Error>(self, word: &str) -> Result<MeasureFrom, E> {
                if word == AUTO {
                    Ok(MeasureFrom::Auto)
                } else {
                    Err(E::invalid_value(word_of(word), &self))
                }
            }
        }
        deserializer.deserialize_any(NumberOrAuto)
    }
}

fn word_of(word: &str) -> serde::de::Unexpected<'_> {
    serde::de::Unexpected::Str(word)
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for MeasureFrom {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "MeasureFrom".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": ["number", "string"], "minimum": 0.0, "pattern": "^auto$" })
    }
}
