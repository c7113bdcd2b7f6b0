//! Reads two numbers from a file, such as the vector `[x, y]`.
//!
//! Readers of TOML fill a fixed array with the first entries of a list and ignore the rest, so that
//! a vector in space would lose its third component without notice. Every pair of a scene is
//! therefore read here.

use std::fmt;

use serde::{
    Deserializer,
    de::{DeserializeSeed, Error, SeqAccess, Visitor},
};

/// Largest whole number that no other is rounded to: 2⁵³ − 1.
const MAX_WHOLE: f64 = 9_007_199_254_740_991.0;

/// Most numbers of a list that a message repeats.
const MAX_REPEATED: usize = 8;

/// A list of exactly two numbers, with its form for messages, such as `[x, y]`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TwoNumbers(pub &'static str);

impl<'de> Visitor<'de> for TwoNumbers {
    type Value = [f64; 2];

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "two numbers {}", self.0)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
        let mut repeated = Vec::new();
        let mut count = 0_usize;
        while let Some(number) = list.next_element::<f64>()? {
            count += 1;
            if count <= MAX_REPEATED {
                repeated.push(number);
            }
        }
        if let ([first, second], 2) = (&repeated[..], count) {
            return Ok([*first, *second]);
        }
        let words: Vec<String> = repeated
            .iter()
            .map(|number| format!("{number:?}"))
            .collect();
        let rest = if count > MAX_REPEATED { ", …" } else { "" };
        Err(A::Error::custom(format!(
            "there must be {self}, but there are {count}: [{}{rest}]",
            words.join(", ")
        )))
    }
}

impl fmt::Display for TwoNumbers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.expecting(f)
    }
}

impl<'de> DeserializeSeed<'de> for TwoNumbers {
    type Value = [f64; 2];

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_seq(self)
    }
}

/// Reads a vector `[x, y]`.
pub(crate) fn vector<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 2], D::Error> {
    TwoNumbers("[x, y]").deserialize(deserializer)
}

/// Reads the semi-axes `[a, b]` of an ellipse.
pub(crate) fn axes<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 2], D::Error> {
    TwoNumbers("[a, b]").deserialize(deserializer)
}

/// Reads a list of places `[[x, y], …]`.
pub(crate) fn vectors<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<[f64; 2]>, D::Error> {
    deserializer.deserialize_seq(List("[x, y]"))
}

/// Reads a list of pairs of atoms `[[first, second], …]`.
pub(crate) fn pairs<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<[u32; 2]>, D::Error> {
    let most = f64::from(u32::MAX);
    let lists = whole_pairs(deserializer, most, "an edge names atoms by index, from 0")?;
    Ok(lists
        .into_iter()
        .map(|pair| pair.map(|index| index as u32))
        .collect())
}

/// Reads a list of pairs of bodies `[[first, second], …]`.
pub(crate) fn pairs_of_bodies<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<[u64; 2]>, D::Error> {
    whole_pairs(
        deserializer,
        MAX_WHOLE,
        "a bond names bodies by number, from 0",
    )
}

/// Reads a list of pairs of whole numbers up to `most`; `rule` says what they are.
fn whole_pairs<'de, D: Deserializer<'de>>(
    deserializer: D,
    most: f64,
    rule: &str,
) -> Result<Vec<[u64; 2]>, D::Error> {
    let whole = |number: f64| {
        let is_whole = number.fract() == 0.0 && (0.0..=most).contains(&number);
        is_whole
            .then_some(number as u64)
            .ok_or_else(|| D::Error::custom(format!("{rule}, not {number:?}")))
    };
    let pair = |[first, second]: [f64; 2]| Ok([whole(first)?, whole(second)?]);
    let lists = deserializer.deserialize_seq(List("[first, second]"))?;
    lists.into_iter().map(pair).collect()
}

/// Reads two places `[[x, y], [x, y]]`.
pub(crate) fn two_vectors<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<[[f64; 2]; 2], D::Error> {
    let all = vectors(deserializer)?;
    let count = all.len();
    all.try_into().map_err(|_| {
        D::Error::custom(format!(
            "there must be two places [x, y], but there are {count}"
        ))
    })
}

/// A list of lists of exactly two numbers, with their form for messages.
struct List(&'static str);

impl<'de> Visitor<'de> for List {
    type Value = Vec<[f64; 2]>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a list of two numbers {} each", self.0)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
        let mut all = Vec::new();
        while let Some(two) = list.next_element_seed(TwoNumbers(self.0))? {
            all.push(two);
        }
        Ok(all)
    }
}

/// Reads a vector `[x, y]`, which may be `null` in JSON.
pub(crate) fn optional_vector<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<[f64; 2]>, D::Error> {
    deserializer.deserialize_option(Optional(TwoNumbers("[x, y]")))
}

/// Reads a range `[first, last]`, which may be `null` in JSON.
pub(crate) fn optional_range<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<[f64; 2]>, D::Error> {
    deserializer.deserialize_option(Optional(TwoNumbers("[first, last]")))
}

/// Two numbers or nothing.
struct Optional(TwoNumbers);

impl<'de> Visitor<'de> for Optional {
    type Value = Option<[f64; 2]>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.expecting(f)
    }

    fn visit_none<E: Error>(self) -> Result<Self::Value, E> {
        Ok(None)
    }

    fn visit_unit<E: Error>(self) -> Result<Self::Value, E> {
        Ok(None)
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        self.0.deserialize(deserializer).map(Some)
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::Scene;

    /// The scene with one list in each place where two numbers stand, and the line of that list.
    const SCENES: [(&str, &str); 19] = [
        ("[box]\nsides = LIST\n", "[x, y]"),
        ("[[molecule]]\nshape = \"disc\"\nat = LIST\n", "[x, y]"),
        ("[[molecule]]\nat = [0, 0]\nvelocity = LIST\n", "[x, y]"),
        (
            "[[molecule]]\nat = [0, 0]\natoms = [{ at = LIST, radius = 0.1, mass = 1 }]\n",
            "[x, y]",
        ),
        (
            "[[molecule]]\nat = [0, 0]\nellipses = [{ at = [0, 0], axes = LIST, mass = 1 }]\n",
            "[a, b]",
        ),
        ("[[molecule]]\nat = [0, 0]\npolygon = [LIST]\n", "[x, y]"),
        ("[[gas]]\nenergy = 1\npolygon = [LIST]\n", "[x, y]"),
        ("[[bumper]]\nradius = 0.1\nat = LIST\n", "[x, y]"),
        ("[[wall]]\nto = [1, 1]\nfrom = LIST\n", "[x, y]"),
        ("[[wall]]\nfrom = [1, 1]\nto = LIST\n", "[x, y]"),
        ("[[stage]]\nuntil = 1\n[[stage.add]]\nat = LIST\n", "[x, y]"),
        (
            "[[stage]]\nuntil = 1\n[[stage.set_velocity]]\ntag = \"a\"\nvelocity = LIST\n",
            "[x, y]",
        ),
        (
            "[[gas]]\nenergy = 1\nregion = { y = LIST }\n",
            "[first, last]",
        ),
        (
            "[[gas]]\nenergy = 1\nradius = { uniform = LIST }\n",
            "[from, to]",
        ),
        (
            "[[gas]]\nenergy = 1\nmass = { normal = LIST }\n",
            "[mean, deviation]",
        ),
        ("[[wall]]\narc = { at = LIST, radius = 1 }\n", "[x, y]"),
        (
            "[[container]]\ncircle = { at = LIST, radius = 1 }\n",
            "[x, y]",
        ),
        (
            "[[container]]\nmushroom = { at = [0, 0], radius = 1, stem = LIST }\n",
            "[x, y]",
        ),
        (
            "[[bond]]\npairs = [[0, 1]]\ntether = { max = 1, points = [[0, 0], LIST] }\n",
            "[x, y]",
        ),
    ];

    #[test]
    fn other_than_two_numbers_are_refused_with_their_key_and_values() {
        for (scene, form) in SCENES {
            assert!(
                Scene::from_toml(&scene.replace("LIST", "[0.5, 1]")).is_ok(),
                "{scene}"
            );
            for (list, numbers) in [
                ("[0.25, 0.5, 0.75]", "3: [0.25, 0.5, 0.75]"),
                ("[0.25]", "1: [0.25]"),
                ("[]", "0: []"),
                (
                    "[1, 2, 3, 4, 5, 6, 7, 8, 9]",
                    "9: [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, …]",
                ),
            ] {
                let text = scene.replace("LIST", list);
                let error = Scene::from_toml(&text).unwrap_err().to_string();
                let line = text.lines().find(|line| line.contains(list)).unwrap();
                let problem = format!("there must be two numbers {form}, but there are {numbers}");
                assert!(
                    error.contains(line) && error.contains(&problem),
                    "{text}: {error}"
                );
            }
            let error = Scene::from_toml(&scene.replace("LIST", "0.5"))
                .unwrap_err()
                .to_string();
            assert!(
                error.contains(&format!("expected two numbers {form}")),
                "{error}"
            );
        }
    }
}
