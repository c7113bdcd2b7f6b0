//! Measured figures with errors and predictions, and the statistics that test them.
//!
//! Unstable: its public items may change with any version.
//!
//! Plain data: no engine and no files. Commands fill it; reports show it.
//!
//! ```
//! use carom_tables::Check;
//!
//! let check = Check::at_most("energy drift", 1e-13, carom_tables::allowed_drift(1000, None));
//! assert!(check.passed);
//! ```

pub mod averages;
pub mod block_sums;
pub mod blocking;
pub mod calibration;
pub mod chi_square;
pub mod estimate;
pub mod figure_name;
pub mod numbers;
pub mod power_law;
pub mod run_sums;
pub mod spectrum;
pub mod stationarity;
pub mod student;
pub mod summary;
pub mod table;
pub mod units;

pub use block_sums::{BlockMean, BlockSums, Sums};
pub use blocking::Blocking;
pub use calibration::Calibration;
pub use estimate::Estimate;
pub use figure_name::{is_named, without_numbers};
pub use numbers::{
    fifteen_digits, grouped, in_parentheses, named, predicted, significant, two_digits, with_error,
};
pub use run_sums::{MergeError, MergedSums, Replica, RunSums, SumsError};
pub use stationarity::Stationarity;
pub use student::student_quantile;
pub use summary::*;
pub use table::{Column, Guide, Level, Role, Spacing, Table, TableGrid};
pub use units::ReportUnits;
