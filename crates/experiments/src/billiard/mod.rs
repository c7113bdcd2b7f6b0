//! Do the mean free path between the hits of one molecule and one kind of obstacle, and the
//! directions of these hits, agree with integral geometry (Santaló 1976, "Integral geometry and
//! geometric probability")?
//!
//! `carom billiard`: independent flights of one disc among fixed molecules, or of one molecule
//! among fixed discs; their hits are compared with the prediction by sector of direction and by
//! atom.

mod flights;
mod layout;
mod options;
mod report;
mod results;
mod run;
mod setup;

pub use flights::{BLOCKS, Hits, SECTORS, fly};
pub use layout::Layout;
pub use options::Options;
pub use run::run;
pub use setup::{Mover, Setup};
