//! The known name nearest to a misspelt one, for error messages.

use crate::scene::expressions::{WORDS, problem_of};

/// Letters of a name for each edit that a suggestion may need, rounded up. Smaller: unrelated names
/// are suggested. Larger: two slips in a short name find nothing.
const LETTERS_PER_EDIT: usize = 3;

/// Returns "; did you mean `name`?" with the known name nearest to `word`, as the end of an error
/// message, or nothing if no known name is near.
///
/// ```
/// use carom_engine::did_you_mean;
///
/// assert_eq!(did_you_mean("raduis", ["mass", "radius"]), "; did you mean `radius`?");
/// assert_eq!(did_you_mean("colour", ["mass", "radius"]), "");
/// ```
pub fn did_you_mean<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let most = word.chars().count().div_ceil(LETTERS_PER_EDIT);
    let near = known
        .into_iter()
        .map(|name| (strsim::osa_distance(word, name), name));
    let nearest = near
        .filter(|(distance, _)| *distance <= most)
        .min_by_key(|(distance, _)| *distance);
    nearest.map_or_else(String::new, |(_, name)| format!("; did you mean `{name}`?"))
}

/// The error of a TOML text that is no scene, with line and key, in the words of a scene file: what
/// to write where serde names a type of Rust, the keys allowed, and the nearest of them.
pub(crate) fn plain_words(error: &toml::de::Error, text: &str) -> String {
    let (shown, message) = (error.to_string(), error.message());
    let place = error
        .span()
        .and_then(|span| text.get(span))
        .unwrap_or_default();
    let before = shown.trim_end().strip_suffix(message).unwrap_or(&shown);
    format!(
        "{before}{}{}{}",
        in_words(message, place),
        of_expression(message),
        suggestion(message)
    )
}

/// Why a text that stands in place of a number is no expression, as the end of a message of serde.
fn of_expression(message: &str) -> String {
    let text = message
        .strip_prefix("invalid type: string \"")
        .and_then(|rest| rest.rsplit_once("\", expected "))
        .filter(|(_, expected)| {
            let is_number = |kind: &&str| expected.starts_with(kind);
            ["a number", "f64", "usize", "u64", "u32", "two numbers"]
                .iter()
                .any(is_number)
        });
    text.map_or_else(String::new, |(text, _)| {
        format!("; as an expression: {} ({WORDS})", problem_of(text))
    })
}

/// Beginnings of messages about TOML that a user of other formats meets, and what to write.
const OF_TOML: [(&str, &str); 5] = [
    (
        "invalid mantissa",
        "a number has a digit before its point: 0.5",
    ),
    (
        "invalid fraction",
        "a number has a digit after its point: 1.0",
    ),
    ("invalid exponent", "an exponent has digits: 1e-3"),
    (
        "unexpected leading zero",
        "a number does not begin with a zero: 5 or 0.5",
    ),
    (
        "string values must be quoted",
        "a text has quotes, and the entries of a list have commas between them",
    ),
];

/// A message of serde about this part of the text.
fn in_words(message: &str, place: &str) -> String {
    if let Some((_, words)) = OF_TOML.iter().find(|(begin, _)| message.starts_with(begin)) {
        return (*words).to_owned();
    }
    let table = place
        .trim()
        .strip_prefix('[')
        .and_then(|rest| rest.split_once(']'));
    let (message, is_list) = match message.strip_suffix(", expected a sequence") {
        Some(start) => (start, true),
        None => (message, false),
    };
    match (is_list, table) {
        (true, Some((name, _))) if message.ends_with("map") => {
            format!("there may be several of them, so that each has two brackets: [[{name}]]")
        }
        (true, _) if message.ends_with("map") => {
            "there may be several of them: a list of tables [{ … }] is expected".to_owned()
        }
        (true, _) => format!("a list is expected: [{}]", place.trim()),
        (false, _) => {
            if let Some(start) = message.strip_suffix(", expected f64") {
                return format!(
                    "{start}: a number is expected, or an expression such as \"sqrt(3)/2\""
                );
            }
            let words = ["usize", "u64", "u32"]
                .iter()
                .find_map(|kind| message.strip_suffix(&format!(", expected {kind}")))
                .map(|start| start.replace("floating point", "number"));
            words.map_or_else(
                || message.to_owned(),
                |start| format!("{start}: a whole number from 0 on is expected, without a point"),
            )
        }
    }
}

/// Keys that a reader expects in a table, a key by which the table is recognised, and what to write
/// instead.
const ELSEWHERE: [(&[&str], &str, &str); 5] = [
    (
        &["gravity", "acceleration"],
        "sides",
        "gravity is a table of its own: [gravity] with `acceleration`",
    ),
    (
        &["gravity"],
        "observe",
        "gravity is a table of its own, [gravity] with `acceleration`, or the key of a [[stage]]",
    ),
    (
        &["persistence", "persistence_time"],
        "rotational_diffusion",
        "the persistence time τ of active bodies is given by `rotational_diffusion` = 1/τ",
    ),
    // Only containers have a stadium.
    (
        &["ellipse"],
        "stadium",
        "there is no elliptic container, because a disc can touch an ellipse from inside at two \
         points at once, and such contacts are not certified: use `circle` or `stadium`",
    ),
    (
        &["arc"],
        "stadium",
        "an arc encloses nothing: give it as a wall, [[wall]] with `arc`, or use `circle`, \
         `stadium` or `mushroom`",
    ),
];

/// A suggestion for an error message of serde, "unknown field `x`, expected one of `a`, `b`", or
/// nothing for another message.
pub(crate) fn suggestion(message: &str) -> String {
    let mut names = message.split('`').skip(1).step_by(2);
    match names.next() {
        Some(word) if message.starts_with("unknown ") => {
            let (near, full): (String, Vec<&str>) = (format!("atom_{word}"), names.collect());
            let elsewhere = ELSEWHERE
                .iter()
                .find(|(keys, of_table, _)| keys.contains(&word) && full.contains(of_table));
            if let Some((.., instead)) = elsewhere {
                return format!("; {instead}");
            }
            // A gas of discs has `radius` and `mass`, a molecule `atom_radius` and `atom_mass`.
            let of_atoms = full.iter().find(|name| **name == near);
            let of_atoms = of_atoms.map(|name| format!("; did you mean `{name}`?"));
            of_atoms.unwrap_or_else(|| did_you_mean(word, full))
        }
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_of_serde_are_completed() {
        let text = "unknown field `sede`, expected one of `sides`, `seed`, `replica`";
        assert_eq!(suggestion(text), "; did you mean `seed`?");
        assert_eq!(
            suggestion("unknown variant `lokced`, expected `free` or `locked`"),
            "; did you mean `locked`?"
        );
        assert_eq!(suggestion("missing field `at`"), "");
        let text = "unknown field `radius`, expected one of `at`, `atom_radius`, `atom_mass`";
        assert_eq!(suggestion(text), "; did you mean `atom_radius`?");
        assert_eq!(suggestion("unknown field `xyz`, there are no fields"), "");
        let text = "unknown field `ellipse`, expected one of `shape`, `ellipses`";
        assert_eq!(suggestion(text), "; did you mean `ellipses`?");
    }

    #[test]
    fn keys_in_a_wrong_table_are_told_their_place() {
        let message = |text: &str| crate::Scene::from_toml(text).unwrap_err().to_string();
        for (table, key, expected) in [
            ("[box]", "gravity", "[gravity] with `acceleration`"),
            ("[box]", "acceleration", "[gravity] with `acceleration`"),
            ("[run]", "gravity", "or the key of a [[stage]]"),
            (
                "[[stage.thermostat]]",
                "persistence",
                "`rotational_diffusion` = 1/τ",
            ),
            (
                "[[stage.thermostat]]",
                "persistence_time",
                "`rotational_diffusion` = 1/τ",
            ),
            (
                "[[container]]",
                "ellipse",
                "such contacts are not certified",
            ),
            ("[[container]]", "arc", "an arc encloses nothing"),
        ] {
            let stage = if table.contains("stage") {
                "[[stage]]\nuntil = 1.0\n"
            } else {
                ""
            };
            let found = message(&format!("{stage}{table}\n{key} = 2.0\n"));
            assert!(found.contains(expected), "{table} {key}: {found}");
        }
        // In another table the nearest key is meant.
        assert!(!message("[gravity]\ngravity = 2.0\n").contains("table of its own"));
    }

    #[test]
    fn numbers_that_toml_refuses_are_told_how_to_write() {
        for (at, expected) in [
            ("[.5, .5]", "digit before its point: 0.5"),
            ("[1., 1.]", "digit after its point: 1.0"),
            ("[5e-, 1]", "an exponent has digits"),
            ("[05, 1]", "does not begin with a zero"),
            ("[0.5 0.5]", "commas between them"),
            (
                "[\"log(2)\", 1]",
                "`log` is not known: the natural logarithm is `ln`",
            ),
        ] {
            let text = format!("[[molecule]]\nradius = 0.1\nmass = 1.0\nat = {at}\n");
            let message = crate::Scene::from_toml(&text).unwrap_err().to_string();
            assert!(message.contains(expected), "{at}: {message}");
        }
    }

    #[test]
    fn types_of_rust_are_said_in_the_words_of_a_scene_file() {
        for (text, expected) in [
            ("[gas]\nradius = 0.1\n", "each has two brackets: [[gas]]"),
            (
                "gas = { radius = 0.1 }\n",
                "a list of tables [{ … }] is expected",
            ),
            ("[[gas]]\ntags = \"gas\"\n", "a list is expected: [\"gas\"]"),
            (
                "[[gas]]\ncount = 1e3\n",
                "number `1000.0`: a whole number from 0 on is expected",
            ),
            (
                "[box]\nseed = -1\n",
                "integer `-1`: a whole number from 0 on is expected",
            ),
        ] {
            let message = crate::Scene::from_toml(text).unwrap_err().to_string();
            assert!(message.contains(expected), "{expected}: {message}");
            assert!(
                !message.contains("sequence")
                    && !message.contains("usize")
                    && !message.contains("u64")
            );
        }
    }
}
