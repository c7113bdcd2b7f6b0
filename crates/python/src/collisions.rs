//! Reports of collisions as rows of a structured array.

use carom::{
    CollisionReport, Observer,
    engine::{Body, Side},
    observers::TagFilter,
};

/// Bytes of one row; `_collisions.py` has the fields in the same order.
pub const ROW: usize = 8 + 2 * 8 + 2 * 4 + 2 * 4 + 3 * 16 + 8 + 3 * 32 + 3 * 16 + 8;

/// Largest number of rows kept at once (about 24 GB). More is taken as a mistake.
pub const MAX_ROWS: usize = 100_000_000;

/// Keeps the reports that a filter admits, as bytes.
#[derive(Debug, Default)]
pub struct Rows {
    /// The filters; a report is kept if one admits it.
    pub filters: Vec<TagFilter>,
    /// The rows.
    pub bytes: Vec<u8>,
    /// For each row, the filters that admit it; filled for callbacks alone.
    pub admitted: Option<Vec<Vec<usize>>>,
}

impl Rows {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.bytes.len() / ROW
    }
}

impl Observer for Rows {
    fn watches_any(&self) -> bool {
        !self.filters.is_empty()
    }

    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.filters.iter().any(|filter| filter.matches(bodies))
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        let bodies = report.sides.each_ref().map(|side| side.body);
        if !self.watches(bodies) {
            return;
        }
        if let Some(admitted) = &mut self.admitted {
            let matching = |&index: &usize| self.filters[index].matches(bodies);
            admitted.push((0..self.filters.len()).filter(matching).collect());
        }
        write(&mut self.bytes, report);
    }
}

fn write(bytes: &mut Vec<u8>, report: &CollisionReport<'_>) {
    let mut row = [0; ROW];
    let mut at = 0;
    let mut put = |number: &[u8]| {
        row[at..at + number.len()].copy_from_slice(number);
        at += number.len();
    };
    let sides: &[Side<'_>; 2] = &report.sides;
    put(&report.time.to_f64().to_ne_bytes());
    sides
        .iter()
        .for_each(|side| put(&side.body.id().to_ne_bytes()));
    sides
        .iter()
        .for_each(|side| put(&side.atom.map_or(-1, |atom| atom as i32).to_ne_bytes()));
    report
        .image
        .iter()
        .for_each(|image| put(&(*image as i32).to_ne_bytes()));
    for vector in [report.point, report.normal, report.impulse] {
        vector
            .to_array()
            .iter()
            .for_each(|number| put(&number.to_ne_bytes()));
    }
    put(&report.elasticity.coefficient().to_ne_bytes());
    let vectors = [
        sides.each_ref().map(|side| side.before.position),
        sides.each_ref().map(|side| side.before.velocity),
        sides.each_ref().map(|side| side.after.velocity),
    ];
    for vector in vectors.as_flattened() {
        vector
            .to_array()
            .iter()
            .for_each(|number| put(&number.to_ne_bytes()));
    }
    let numbers = [
        sides
            .each_ref()
            .map(|side| side.before.orientation.radians()),
        sides.each_ref().map(|side| side.before.angular_velocity),
        sides.each_ref().map(|side| side.after.angular_velocity),
    ];
    numbers
        .as_flattened()
        .iter()
        .for_each(|number| put(&number.to_ne_bytes()));
    let kind: i64 = match (report.bond, report.is_step) {
        (Some(_), _) => 1,
        (None, true) => 2,
        (None, false) => 0,
    };
    put(&kind.to_ne_bytes());
    bytes.extend_from_slice(&row);
}
