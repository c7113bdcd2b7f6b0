//! How a search for the first zero of a gap can end.

/// How the search for one pair of parts ended.
pub enum Found<N> {
    /// No contact.
    Nothing,
    /// When it is.
    Zero(N),
    /// Too many intervals.
    OutOfBudget,
}
