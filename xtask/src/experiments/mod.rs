//! The experiments: each answers a question with a folder of files and a page.

pub mod all;
pub mod billiard;
pub mod brownian;
pub mod capability_cost;
pub mod encounters;
pub mod extremes;
pub mod theory;
pub mod thesis_scene;
pub mod thesis_tests;
