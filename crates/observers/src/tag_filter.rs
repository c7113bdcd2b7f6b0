//! A filter of collisions by the tags of the two bodies.

use carom_engine::{Body, Tag};
use serde::{Deserialize, Serialize};

/// A filter of collisions. A body with several tags matches each of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum TagFilter {
    /// All collisions.
    #[default]
    Any,
    /// Collisions with at least one body that has the tag.
    One(Tag),
    /// Collisions in which one body has the first tag and the other the second, in either order.
    Pair(Tag, Tag),
}

impl TagFilter {
    /// Whether a collision of these two bodies passes the filter.
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
