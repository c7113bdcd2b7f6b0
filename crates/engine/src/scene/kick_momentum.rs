//! The momentum that a thermostat adds to each body: a magnitude in a random direction, or a vector.

use std::fmt;

use serde::{
    Deserialize, Deserializer, Serialize,
    de::{Error, SeqAccess, Visitor},
};

use crate::scene::two_numbers::TwoNumbers;

/// The momentum of a kick. In a file: a number, or a vector `[x, y]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum KickMomentum {
    /// Magnitude (mass × length / time), in a direction drawn for each body.
    Magnitude(f64),
    /// A vector (mass × length / time), the same for all bodies.
    Vector([f64; 2]),
}

impl<'de> Deserialize<'de> for KickMomentum {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(MomentumVisitor)
    }
}

/// As the visitor reads it.
#[cfg(feature = "schema")]
impl schemars::JsonSchema for KickMomentum {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "KickMomentum".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "anyOf": [
                { "type": "number", "exclusiveMinimum": 0.0, "maximum": 1e60 },
                { "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 2 }
            ]
        })
    }
}

struct MomentumVisitor;

impl<'de> Visitor<'de> for MomentumVisitor {
    type Value = KickMomentum;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, the magnitude in random directions, or a vector [x, y]")
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<KickMomentum, E> {
        Ok(KickMomentum::Magnitude(number))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<KickMomentum, E> {
        Ok(KickMomentum::Magnitude(number as f64))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<KickMomentum, E> {
        Ok(KickMomentum::Magnitude(number as f64))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<KickMomentum, A::Error> {
        TwoNumbers("[x, y]")
            .visit_seq(list)
            .map(KickMomentum::Vector)
    }
}
