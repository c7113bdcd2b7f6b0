//! Sweeps: a scene at many points of its parameters, with replicas, on one machine or many.
//!
//! Internal: a part of the program `carom`. Its public items serve the other crates of it, and
//! change without notice.
//!
//! A [`Study`] names a scene, the keys of it that vary, and the number of replicas. `carom sweep`
//! runs them ([`several`]); each replica is a file that appears when it has ended ([`stored`]).
//! Shards are processes with a part of the work each ([`shard`]), and [`merge`] joins their
//! folders. What is kept does not depend on clocks, threads, interruptions, or the order of
//! merging.
//!
//! ```
//! use std::path::Path;
//!
//! use carom_sweeps::{Size, Study};
//!
//! let study = Study::parse(
//!     r#"
//!     replicas = 8
//!     [[vary]]
//!     key = "gas.0.area_fraction"
//!     values = [0.1, 0.3, 0.5]
//!     [[scene.gas]]
//!     radius = 0.01
//!     mass = 1.0
//!     energy = 1.0
//! "#,
//!     Path::new(""),
//!     Size::default(),
//! )?;
//! assert_eq!(study.points.len(), 3);
//! assert_eq!(study.points[1].label, "gas.0.area_fraction = 0.3");
//! # Ok::<(), anyhow::Error>(())
//! ```

mod charts;
pub mod cost;
mod errors;
pub mod expect;
mod hash;
mod hosts;
pub mod layout;
pub mod merge;
mod missing;
mod motion;
mod page;
pub mod point;
pub mod reference;
mod report;
mod results;
mod seal;
pub mod several;
pub mod shard;
pub mod slurm;
pub mod stored;
mod study;
pub mod summary;
pub mod sweep;
mod table;
pub mod vary;
mod work;

pub use study::{Size, Study};
