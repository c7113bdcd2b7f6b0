//! Random queries to the exact detector, judged by a search in extended precision, and queries with
//! invalid numbers.

pub mod bad_numbers;
pub mod case;
pub mod classes;
pub mod edged_body;
mod edged_shapes;
pub mod judge;

use anyhow::Result;
use carom_detection::{Detection, Exact};
use serde::{Deserialize, Serialize};

use self::{bad_numbers::BadNumbers, case::Query};
use super::{
    random::FuzzDraw,
    subject::{Report, Subject, read_toml, write_toml},
};

/// The fuzzer of a detector.
#[derive(Debug, Clone, Default)]
pub struct Queries<D = Exact> {
    /// The detector under test.
    pub detector: D,
}

/// One query.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DetectionCase {
    /// Numbers that a detector must answer correctly.
    Query(Query),
    /// Arbitrary numbers.
    BadNumbers(BadNumbers),
}

/// Share of queries with arbitrary numbers.
const BAD: f64 = 0.3;

impl<D: Detection> Subject for Queries<D> {
    type Case = DetectionCase;
    const NAME: &'static str = "detection";
    const TIME_LIMIT: u64 = 20;

    fn draw(&self, seed: u64) -> DetectionCase {
        let draw = &mut FuzzDraw::new(seed);
        let (bad, inner) = (draw.happens(BAD), draw.bits());
        if bad {
            DetectionCase::BadNumbers(bad_numbers::draw(inner))
        } else {
            DetectionCase::Query(classes::draw(inner))
        }
    }

    fn check(&self, case: &DetectionCase) -> Report {
        match case {
            DetectionCase::Query(query) => judge::check(&self.detector, query),
            DetectionCase::BadNumbers(bad) => bad_numbers::check(&self.detector, bad),
        }
    }

    fn simpler(&self, case: &DetectionCase) -> Vec<DetectionCase> {
        match case {
            DetectionCase::Query(query) => query
                .simpler()
                .into_iter()
                .map(DetectionCase::Query)
                .collect(),
            DetectionCase::BadNumbers(bad) => bad
                .simpler()
                .into_iter()
                .map(DetectionCase::BadNumbers)
                .collect(),
        }
    }

    fn write(&self, case: &DetectionCase) -> (String, Vec<u8>) {
        write_toml(case)
    }

    fn read(&self, ending: &str, bytes: &[u8]) -> Result<DetectionCase> {
        read_toml(ending, bytes)
    }
}

#[cfg(test)]
mod tests;
