//! Oracles of first contacts in high precision, and reference scenes whose outcome is known.
//!
//! Internal: a part of the program `carom`. Its public items serve the other crates of it, and
//! change without notice.

pub mod chromium;
pub mod extremes;
pub mod oracle;
pub mod skipped;
