//! `cargo xtask experiment billiard`: one disc flies around one fixed molecule, and integral geometry says exactly how
//! far, and from where it hits (Santaló 1976, "Integral geometry and geometric probability").

mod campaign;
mod flights;
mod options;
mod report;
mod results;

pub use campaign::run;
pub use flights::{BLOCKS, Hits, SECTORS, fly};
pub use options::{Options, Setup};
