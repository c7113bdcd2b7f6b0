//! `cargo xtask experiment billiard`: a disc moves around a fixed molecule; its mean free path and
//! its directions of impact are compared with integral geometry (Santaló 1976, "Integral geometry
//! and geometric probability").

mod campaign;
mod flights;
mod options;
mod report;
mod results;

pub use campaign::run;
pub use flights::{BLOCKS, Hits, SECTORS, fly};
pub use options::{Options, Setup};
