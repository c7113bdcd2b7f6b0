//! Tests of the experiment runners: one program.

mod attack;
mod commands;
mod data;
mod fuzz;
mod page;
mod resume;
mod support;
