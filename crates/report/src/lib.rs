//! Charts and pages made from tables and figures, without the engine.

pub mod canvas;
pub mod molecule_picture;
pub mod page;
pub mod plot;
pub mod polar;
pub mod scatter;
