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
fn what_a_column_says_is_not_said_again() {
    let meaning =
        "Stiffness (mass / time²), from 0 to 1e60, of a spring. Default: none. With a mass.";
    let (default, rest) = keys::default_in_words(meaning).unwrap();
    assert_eq!(default, "none");
    assert_eq!(
        keys::without_columns(&rest, "mass / time²", "0 to 1e60"),
        "Stiffness, of a spring. With a mass."
    );
    let signed = "A velocity (length per time, from −1e60 to 1e60).";
    assert_eq!(
        keys::without_columns(signed, "", "-1e60 to 1e60"),
        "A velocity (length per time)."
    );
    assert_eq!(
        keys::default_in_words("A number. Default: 0.5 of all."),
        None
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
