//! Oracles of first contacts in high precision, and reference scenes whose outcome is known.

pub mod chromium;
pub mod edged_scenes;
pub mod extremes;
pub mod oracle;
pub mod skipped;
