//! Charts and HTML pages from tables and figures, independent of the engine.
//!
//! ```
//! use carom_report::page::with_error;
//!
//! // As many digits as the standard error justifies.
//! assert_eq!(with_error(7.987_123, Some(0.0004)), "7.98712 ± 0.00040");
//! ```

pub mod axis;
pub mod chart;
pub mod error_bars;
pub mod ink;
pub mod map;
pub mod molecule_picture;
pub mod page;
pub mod panels;
pub mod polar;
pub mod pose_picture;
pub mod scatter;
mod svg;
pub mod table_chart;
