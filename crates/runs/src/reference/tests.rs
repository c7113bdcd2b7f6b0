//! Tests of the committed page and schema: both are current, and all scenes of the repository
//! conform.

use std::{
    fs,
    path::{Path, PathBuf},
};

use super::*;
use crate::schema;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn committed(name: &str) -> String {
    fs::read_to_string(root().join("crates").join(name)).unwrap_or_default()
}

#[test]
fn the_page_and_the_schema_are_current() {
    let renew = "run `cargo run -p carom-cli -- schema";
    assert!(
        committed("book/src/keys.md") == page().unwrap(),
        "{renew} --page > crates/book/src/keys.md`"
    );
    assert!(
        committed("scene.schema.json") == schema::text(&scene_schema()),
        "{renew} > crates/scene.schema.json`"
    );
}

#[test]
fn all_keys_have_a_meaning() {
    let schema = scene_schema();
    for (name, definition) in schema["definitions"].as_object().unwrap() {
        for (key, property) in definition["properties"].as_object().into_iter().flatten() {
            assert!(property["description"].is_string(), "{name}.{key}");
        }
    }
    let page = page().unwrap();
    assert!(
        !page.contains("crate::") && !page.contains("](") && !page.contains("```"),
        "links or code remain"
    );
}

#[test]
fn units_are_found_between_parentheses() {
    for (text, unit) in [
        ("Sides (length).", "length"),
        (
            "The time (of day) in turns (radians per time); 0.",
            "radians per time",
        ),
        ("A number (of discs).", ""),
    ] {
        assert_eq!(keys::unit(text), unit);
    }
}
