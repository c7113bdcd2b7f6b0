//! Charts and HTML pages from tables and figures, independent of the engine.
//!
//! Internal: a part of the program `carom`. Its public items serve the other crates of it, and
//! change without notice.
//!
//! ```
//! use carom_report::page::{Page, PagePart};
//!
//! let mut page = Page::new("A gas", "What it shows.");
//! page.part(PagePart::Results);
//! page.paragraph("Its pressure is 7.98712 ± 0.00040.");
//! assert!(page.html().contains("7.98712"));
//! ```

pub mod axis;
pub mod chart;
pub mod error_bars;
pub mod ink;
pub mod map;
pub mod molecule_picture;
pub mod page;
pub mod panels;
mod part_places;
pub mod polar;
pub mod pose_picture;
pub mod scatter;
mod svg;
pub mod table_chart;
