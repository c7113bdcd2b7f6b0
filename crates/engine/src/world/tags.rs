//! Tags: names of groups of bodies, stored once and referred to by number.

use std::{collections::HashMap, sync::Arc};

use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

/// A tag, stored as a number: a name shared by a group of bodies.
///
/// It is valid in the system that has created it, as long as the system has, or has had, a body or
/// rule with its name. A tag that is new in a batch becomes invalid if the batch is refused: the
/// next new name gets its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Tag(pub(crate) u32);

/// The tags of one body, in ascending order.
pub type Tags = SmallVec<[Tag; 2]>;

/// The names of all tags ever used in a system.
///
/// ```
/// let mut names = carom_engine::TagNames::default();
/// let gas = names.intern("gas");
/// assert_eq!(names.intern("gas"), gas);
/// assert_eq!(names.name(gas), "gas");
/// assert_eq!(names.find("tee"), None);
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(from = "Names", into = "Names")]
pub struct TagNames {
    names: Vec<Arc<str>>,
    /// The tag of each name; the first one if names in a file repeat.
    tags: HashMap<Arc<str>, Tag>,
}

/// Names in the order of their tags, as stored in files.
#[derive(Serialize, Deserialize)]
#[serde(rename = "TagNames")]
struct Names {
    names: Vec<String>,
}

impl From<Names> for TagNames {
    fn from(Names { names }: Names) -> Self {
        let names: Vec<Arc<str>> = names.into_iter().map(Arc::from).collect();
        let tags = names
            .iter()
            .enumerate()
            .rev()
            .map(|(index, name)| (Arc::clone(name), Tag(index as u32)));
        Self {
            tags: tags.collect(),
            names,
        }
    }
}

impl From<TagNames> for Names {
    fn from(names: TagNames) -> Self {
        Self {
            names: names.names.iter().map(ToString::to_string).collect(),
        }
    }
}

impl TagNames {
    /// Returns the tag of this name, and creates it if it is new. Takes O(1) time on average.
    pub fn intern(&mut self, name: &str) -> Tag {
        self.find(name).unwrap_or_else(|| {
            let (name, tag) = (Arc::<str>::from(name), Tag(self.names.len() as u32));
            self.names.push(Arc::clone(&name));
            self.tags.insert(name, tag);
            tag
        })
    }

    /// The tags of these names, each once; those that are new are created.
    pub(crate) fn intern_all(&mut self, names: &[String]) -> Tags {
        let mut tags: Tags = names.iter().map(|name| self.intern(name)).collect();
        tags.sort_unstable();
        tags.dedup();
        tags
    }

    /// Returns the tag of this name, if there is one. Takes O(1) time on average.
    pub fn find(&self, name: &str) -> Option<Tag> {
        self.tags.get(name).copied()
    }

    /// Number of tags.
    pub(crate) fn len(&self) -> usize {
        self.names.len()
    }

    /// Removes all tags but the first `count`.
    pub(crate) fn forget_after(&mut self, count: usize) {
        for name in self.names.drain(count.min(self.names.len())..) {
            self.tags.remove(&name);
        }
    }

    /// Whether this tag has a name here.
    pub(crate) fn knows(&self, tag: Tag) -> bool {
        (tag.0 as usize) < self.names.len()
    }

    /// The name of a tag of this system.
    pub fn name(&self, tag: Tag) -> &str {
        self.names.get(tag.0 as usize).map_or("", |name| &**name)
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;

    #[test]
    fn many_names_take_a_time_proportional_to_their_number() {
        // A linear search would compare names 4·10¹⁰ times here, which takes at least a minute.
        let start = Instant::now();
        let mut names = TagNames::default();
        for _ in 0..2 {
            for n in 0..200_000 {
                assert_eq!(names.intern(&format!("body {n}")), Tag(n));
            }
        }
        assert!(
            start.elapsed() < Duration::from_secs(15),
            "{:?}",
            start.elapsed()
        );
    }

    #[test]
    fn removed_names_free_their_tags() {
        let mut names = TagNames::default();
        let [gas, tee] = ["gas", "tee"].map(|name| names.intern(name));
        names.forget_after(1);
        assert_eq!(
            (names.find("gas"), names.find("tee"), names.len()),
            (Some(gas), None, 1)
        );
        assert_eq!((names.intern("rod"), names.name(tee)), (tee, "rod"));
        names.forget_after(5);
        assert_eq!(names.len(), 2);
    }

    #[test]
    fn files_contain_only_the_names() {
        let mut names = TagNames::default();
        names.intern("gas");
        names.intern("tee");
        let written = toml::to_string(&names).unwrap();
        assert_eq!(written, "names = [\"gas\", \"tee\"]\n");
        let read: TagNames = toml::from_str(&written).unwrap();
        assert_eq!((&read, read.find("tee")), (&names, Some(Tag(1))));
    }
}
