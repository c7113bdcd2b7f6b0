//! Measured figures with errors and predictions, and the statistics that test them.
//!
//! Plain data: no engine and no files. Commands fill it; reports show it.
//!
//! ```
//! use carom_tables::Check;
//!
//! let check = Check::at_most("energy drift", 1e-13, 1e-12);
//! assert!(check.passed);
//! ```

pub mod block_sums;
pub mod chi_square;
pub mod power_law;
pub mod summary;
pub mod table;

pub use block_sums::{BlockMean, BlockSums};
pub use summary::*;
pub use table::{Column, Role, Spacing, Table};
