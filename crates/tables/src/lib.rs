//! Measured figures with their errors and predictions, and the statistics by which they are judged.
//!
//! Plain data: no engine and no files. Runners fill it, reports draw it.
//!
//! ```
//! use carom_tables::Check;
//!
//! let check = Check::at_most("energy drift", 1e-13, 1e-12);
//! assert!(check.passed);
//! ```

pub mod chi_square;
pub mod power_law;
pub mod summary;

pub use summary::*;
