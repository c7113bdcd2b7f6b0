//! Charts and HTML pages from tables and figures, independent of the engine.

pub mod canvas;
pub mod molecule_picture;
pub mod page;
pub mod plot;
pub mod polar;
pub mod scatter;
