//! Do the mean free path of a disc around a fixed molecule and its directions of impact agree with
//! integral geometry (Santaló 1976, "Integral geometry and geometric probability")?
//!
//! `cargo xtask experiment billiard`: independent flights of one disc; their hits are compared with
//! the prediction by sector of direction and by atom.

mod flights;
mod options;
mod report;
mod results;
mod run;

pub use flights::{BLOCKS, Hits, SECTORS, fly};
pub use options::{Options, Setup};
pub use run::run;
