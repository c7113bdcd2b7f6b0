//! What the page and the program send each other: requests and answers as JSON, positions as
//! binary messages (`frame.rs`, `body_list.rs`).

use carom::engine::{ElasticityRule, MeasureSpec, StageSpec, ThermostatSpec};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Largest number of contacts of one step.
pub const MAX_CONTACTS: u32 = 1000;

/// Largest number of edits in one request.
pub const MAX_EDITS: usize = 16;

/// A request of a page. The answer has the same number.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LiveRequest {
    /// Number chosen by the page.
    pub id: u64,
    /// What is requested.
    #[serde(rename = "do")]
    pub command: LiveCommand,
}

/// A command. Readers may send [`LiveCommand::View`], [`LiveCommand::Seen`] and
/// [`LiveCommand::Choose`] only.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum LiveCommand {
    /// The part of the box that this page shows.
    View(VisibleWindow),
    /// This page has drawn the frame of this number.
    Seen(u32),
    /// Begins a scene of the gallery.
    Open(String),
    /// Begins a scene of the user.
    Scene(SceneText),
    /// Requests the name and the text of the open scene.
    Source(bool),
    /// Runs on, or pauses.
    Play(bool),
    /// Simulated time for each second; `null` for as fast as it runs.
    Speed(Option<f64>),
    /// Runs through so many contacts and pauses.
    Step(u32),
    /// Edits, one after another up to the first that is refused.
    Edit(Vec<LiveEdit>),
    /// Records the impulses on the body of this number for this page; `null` for none.
    Choose(Option<u64>),
    /// Keeps the present state in memory.
    Bookmark(bool),
    /// Returns to the state that was kept.
    Back(bool),
    /// Begins a measure.
    Measure(MeasureRequest),
    /// Ends the measure of this number.
    EndMeasure(u64),
    /// Writes the run into a new folder.
    Save(bool),
}

/// One edit: what a stage of a scene file does at its start, and the thermostats from then on.
///
/// Single elasticities and thermostats are put into those in force when the edit is made, so that a
/// page whose report of the state is old removes nothing.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LiveEdit {
    /// The changes, without `until`, `measure` and `thermostat`.
    pub stage: StageSpec,
    /// The thermostats from now on; those in force continue without it.
    pub hold: Option<Vec<ThermostatSpec>>,
    /// Thermostats that begin; each ends those on the same tag. Without `every`: a tenth of the
    /// time in which one of its bodies crosses the box.
    pub begin_hold: Vec<ThermostatSpec>,
    /// Tags whose thermostats end.
    pub end_hold: Vec<String>,
    /// The elasticity of contacts without a rule.
    pub elasticity: Option<f64>,
    /// Rules of elasticity; each replaces that between the same tags.
    pub set_rule: Vec<ElasticityRule>,
    /// Pairs of tags whose rules end.
    pub drop_rule: Vec<Vec<String>>,
}

/// The text of a scene file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneText {
    /// The name that the page shows.
    pub name: String,
    /// TOML.
    pub text: String,
}

/// A measure by name, with a sample every `interval` (time); by default that of the scene.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasureRequest {
    /// The measure with its parameters, as in `[[measure]]`.
    pub spec: MeasureSpec,
    /// Time between two samples.
    #[serde(default)]
    pub interval: Option<f64>,
}

/// The part of the box that a page shows, and what it shows of each body.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VisibleWindow {
    /// The middle (length).
    pub centre: [f64; 2],
    /// From the middle to the right and to the upper border (length).
    pub half: [f64; 2],
    /// The quantity that colours the bodies.
    #[serde(default)]
    pub colour: BodyColour,
    /// The body that stays in the middle.
    #[serde(default)]
    pub follow: Option<u64>,
}

/// A quantity of each body, as a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BodyColour {
    /// Tags, size and mass: no number is sent.
    #[default]
    Kind,
    /// Speed (length / time).
    Speed,
    /// Kinetic energy (mass × length² / time²).
    Energy,
    /// |ψ₆|, the order of the directions to the nearest neighbours.
    Order,
}

/// The answer to a request: what was done, or why it was refused.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum LiveAnswer {
    /// It was done.
    Done {
        /// Number of the request.
        answer: u64,
        /// What the page needs to know.
        done: Value,
    },
    /// It was refused.
    Refused {
        /// Number of the request; `None` if the text could not be read.
        answer: Option<u64>,
        /// The reason, in words.
        refused: String,
    },
}

impl LiveAnswer {
    /// The answer to a request.
    pub fn new(id: u64, result: Result<Value, String>) -> Self {
        match result {
            Ok(done) => Self::Done { answer: id, done },
            Err(refused) => Self::Refused {
                answer: Some(id),
                refused,
            },
        }
    }
}

/// Reads a request.
///
/// # Errors
/// The answer that names the fault.
pub fn read(text: &str) -> Result<LiveRequest, LiveAnswer> {
    serde_json::from_str(text).map_err(|error| LiveAnswer::Refused {
        answer: None,
        refused: error.to_string(),
    })
}

impl VisibleWindow {
    /// Whether all numbers are finite and the window has an area.
    pub fn is_valid(&self) -> bool {
        let finite = self
            .centre
            .iter()
            .chain(&self.half)
            .all(|number| number.is_finite());
        finite && self.half.iter().all(|half| *half > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        match read(text) {
            Err(LiveAnswer::Refused { refused, .. }) => refused,
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn requests_are_read_and_unknown_keys_are_refused_by_name() {
        let play = read(r#"{ "id": 7, "do": { "play": true } }"#).unwrap();
        assert_eq!(
            play,
            LiveRequest {
                id: 7,
                command: LiveCommand::Play(true)
            }
        );
        let edit = read(
            r#"{ "id": 8, "do": { "edit": [{ "stage": { "elasticity": { "default": 0.5 } },
                "hold": [{ "tag": "hot", "every": 0.1, "energy": 2.0 }] }] } }"#,
        );
        let LiveCommand::Edit(edits) = edit.unwrap().command else {
            panic!()
        };
        assert_eq!(edits[0].stage.elasticity.as_ref().unwrap().default, 0.5);
        assert_eq!(edits[0].hold.as_ref().unwrap()[0].tag, "hot");
        let view = r#"{ "id": 9, "do": { "view": { "centre": [0.5, 0.5], "half": [1, 1], "colour": "order" } } }"#;
        let LiveCommand::View(window) = read(view).unwrap().command else {
            panic!()
        };
        assert_eq!(
            (window.colour, window.follow, window.is_valid()),
            (BodyColour::Order, None, true)
        );
        assert!(
            !VisibleWindow {
                half: [0.0, 1.0],
                ..window
            }
            .is_valid()
        );
        for (text, named) in [
            (r#"{ "id": 1, "do": { "explode": true } }"#, "explode"),
            (
                r#"{ "id": 1, "do": { "play": true }, "twice": 2 }"#,
                "twice",
            ),
            (
                r#"{ "id": 1, "do": { "edit": [{ "stage": { "levity": 9.81 } }] } }"#,
                "levity",
            ),
            (
                r#"{ "id": 1, "do": { "edit": [{ "stages": {} }] } }"#,
                "stages",
            ),
            (
                r#"{ "id": 1, "do": { "measure": { "spec": { "kind": "energy" }, "colour": 1 } } }"#,
                "colour",
            ),
            (r#"{ "id": -1, "do": { "play": true } }"#, "-1"),
            ("play", "expected"),
        ] {
            assert!(refusal(text).contains(named), "{text}: {}", refusal(text));
        }
    }

    #[test]
    fn an_answer_has_the_number_of_its_request() {
        let text = |answer: LiveAnswer| serde_json::to_string(&answer).unwrap();
        assert_eq!(
            text(LiveAnswer::new(3, Ok(Value::from(2)))),
            r#"{"answer":3,"done":2}"#
        );
        assert_eq!(
            text(LiveAnswer::new(3, Err("no".to_owned()))),
            r#"{"answer":3,"refused":"no"}"#
        );
    }
}
