//! The experiments: each answers a question with a folder of files and a page.

pub mod all;
pub mod capability_cost;
pub mod common;
pub mod encounters;
pub mod extremes;
pub mod studies;
pub mod thesis_tests;
