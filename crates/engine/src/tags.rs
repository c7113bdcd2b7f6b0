//! Tags: names that group bodies, kept once and referred to by number.

use serde::{Deserialize, Serialize};

use crate::Tag;

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
pub struct TagNames {
    names: Vec<String>,
}

impl TagNames {
    /// The tag of this name, made if it is new.
    pub fn intern(&mut self, name: &str) -> Tag {
        self.find(name).unwrap_or_else(|| {
            self.names.push(name.to_owned());
            Tag(self.names.len() as u32 - 1)
        })
    }

    /// The tag of this name, if there is one.
    pub fn find(&self, name: &str) -> Option<Tag> {
        self.names.iter().position(|known| known == name).map(|index| Tag(index as u32))
    }

    /// How many tags there are.
    pub(crate) fn len(&self) -> usize {
        self.names.len()
    }

    /// Forgets all tags but the first so many.
    pub(crate) fn forget_after(&mut self, count: usize) {
        self.names.truncate(count);
    }

    /// Whether this tag has a name here.
    pub(crate) fn knows(&self, tag: Tag) -> bool {
        (tag.0 as usize) < self.names.len()
    }

    /// The name of a tag of this system.
    pub fn name(&self, tag: Tag) -> &str {
        self.names.get(tag.0 as usize).map_or("", String::as_str)
    }
}
