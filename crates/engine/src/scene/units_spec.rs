//! The units in which pages and the terminal show what was measured.

use std::fmt;

use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{Error, MapAccess, Unexpected, Visitor, value::MapAccessDeserializer},
};

/// The word in a file.
const REDUCED: &str = "reduced";

/// The units of a report. In a file `"reduced"`, or the three units.
///
/// ```
/// use carom_engine::{Scene, UnitsSpec};
///
/// let scene = Scene::from_toml("[run]\nunits = { length = 0.01, mass = 1.0, energy = 4.0 }")?;
/// assert_eq!(scene.run.units, Some(UnitsSpec::Given { length: 0.01, mass: 1.0, energy: 4.0 }));
/// # Ok::<(), carom_engine::SceneError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum UnitsSpec {
    /// Diameter and mass of the discs of the first gas that moves, and its kT at the start.
    Reduced,
    /// These, in the units of the scene.
    Given {
        /// Unit of length (length), from 1e-60 to 1e60.
        length: f64,
        /// Unit of mass (mass), from 1e-60 to 1e60.
        mass: f64,
        /// Unit of energy (mass × length² / time²), from 1e-60 to 1e60.
        energy: f64,
    },
}

/// The three units in a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Given {
    length: f64,
    mass: f64,
    energy: f64,
}

impl Serialize for UnitsSpec {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match *self {
            Self::Reduced => serializer.serialize_str(REDUCED),
            Self::Given {
                length,
                mass,
                energy,
            } => Given {
                length,
                mass,
                energy,
            }
            .serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for UnitsSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct WordOrUnits;
        impl<'de> Visitor<'de> for WordOrUnits {
            type Value = UnitsSpec;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("\"reduced\" or `{ length = σ, mass = m, energy = ε }`")
            }

            fn visit_str<E: Error>(self, word: &str) -> Result<UnitsSpec, E> {
                if word == REDUCED {
                    Ok(UnitsSpec::Reduced)
                } else {
                    Err(E::invalid_value(Unexpected::Str(word), &self))
                }
            }

            fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<UnitsSpec, M::Error> {
                let Given {
                    length,
                    mass,
                    energy,
                } = Given::deserialize(MapAccessDeserializer::new(map))?;
                Ok(UnitsSpec::Given {
                    length,
                    mass,
                    energy,
                })
            }
        }
        deserializer.deserialize_any(WordOrUnits)
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for UnitsSpec {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "UnitsSpec".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let unit =
            || schemars::json_schema!({ "type": "number", "minimum": 1e-60, "maximum": 1e60 });
        schemars::json_schema!({
            "anyOf": [
                { "enum": ["reduced"] },
                {
                    "type": "object",
                    "properties": { "length": unit(), "mass": unit(), "energy": unit() },
                    "required": ["length", "mass", "energy"],
                    "additionalProperties": false
                }
            ]
        })
    }
}
