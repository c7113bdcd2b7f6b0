//! How a search for the first zero of a gap can end.

/// Result of the search for one pair of parts.
pub enum SearchEnd<N> {
    /// No contact.
    Nothing,
    /// Time of the contact.
    Zero(N),
    /// The limit on intervals was reached.
    OutOfBudget,
}
