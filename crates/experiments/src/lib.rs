//! Experiments with molecules and scenes of the user, each with its question, its predictions and
//! its verdict.
//!
//! Internal: a part of the program `carom`. Its public items serve the other crates of it, and
//! change without notice.

pub mod billiard;
pub mod brownian;
pub mod molecule_argument;
pub mod time_reversal;
pub mod trade;
mod written_study;
