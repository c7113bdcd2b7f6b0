//! Description and results of a test: timings, costs as functions of size, and a table.

use carom_tables::Figure;

use super::{fits::Fit, timing::ThesisTiming};

/// Description of a test.
#[derive(Debug, Clone, Copy)]
pub struct Test {
    /// Name of the command.
    pub name: &'static str,
    /// Heading.
    pub title: &'static str,
    /// Question of the test.
    pub lead: &'static str,
    /// Label of the system size.
    pub size: &'static str,
}

/// Results.
#[derive(Debug)]
pub struct ThesisResults {
    /// The cases.
    pub timings: Vec<ThesisTiming>,
    /// The charts; the most important one is the first.
    pub charts: Vec<Costs>,
    /// Exponents and counts.
    pub figures: Vec<Figure>,
    /// Header of the table.
    pub header: Vec<&'static str>,
    /// The table.
    pub rows: Vec<Vec<String>>,
}

/// Cost as a function of size.
#[derive(Debug)]
pub struct Costs {
    /// Name of the file.
    pub file: &'static str,
    /// Name of the cost, with unit.
    pub what: &'static str,
    /// Engine, size and cost of each point.
    pub points: Vec<(String, usize, f64)>,
    /// Engine, size and cost of the published points.
    pub published: Vec<(String, usize, f64)>,
    /// Fitted curves, by name.
    pub fits: Vec<(String, Fit)>,
}
