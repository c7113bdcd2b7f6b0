//! What each reaction of a system has done so far.

use serde::{Deserialize, Serialize};

use crate::scene::reaction_spec::ReactionSpec;

/// What a reaction has done since the system was built.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ReactionCounts {
    /// Contacts of bodies whose tags the rule names, at which no earlier rule has acted.
    pub contacts: u64,
    /// Reactions that have taken place.
    pub reactions: u64,
    /// Reactions that have not, because the product would have overlapped another body.
    pub blocked: u64,
    /// Kinetic energy of the bodies after the reactions, less that before (mass × length² / time²):
    /// negative where bodies are removed. It is a part of [`Ledger::put_in`](crate::Ledger).
    pub energy: f64,
}

/// A reaction and what it has done.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ReactionRecord {
    /// The rule, as in a scene.
    pub spec: ReactionSpec,
    /// Whether it is in force.
    pub is_in_force: bool,
    /// What it has done.
    pub counts: ReactionCounts,
}
