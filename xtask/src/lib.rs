//! Experiments on top of carom, and checks of the repository itself.

pub mod attack;
pub mod bench;
pub mod ci;
pub mod cli;
pub mod experiments;
pub mod fuzz;
pub mod release;
pub mod repository;
pub mod site;
pub mod surface;
pub mod tidy;
pub mod web;
