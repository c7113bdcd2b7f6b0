//! Which collisions are wanted, by the tags of the two bodies.

use carom_engine::{Body, Tag};
use serde::{Deserialize, Serialize};

/// Which collisions are wanted. A body with several tags counts for each of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum TagFilter {
    /// All.
    #[default]
    Any,
    /// Those in which at least one of the bodies carries the tag.
    One(Tag),
    /// Those in which one body carries the first tag and the other the second, whichever way round.
    Pair(Tag, Tag),
}

impl TagFilter {
    /// Whether a collision of these two is wanted.
    pub fn matches(&self, [a, b]: [&Body; 2]) -> bool {
        match *self {
            Self::Any => true,
            Self::One(tag) => a.has_tag(tag) || b.has_tag(tag),
            Self::Pair(one, other) => {
                (a.has_tag(one) && b.has_tag(other)) || (a.has_tag(other) && b.has_tag(one))
            }
        }
    }
}
