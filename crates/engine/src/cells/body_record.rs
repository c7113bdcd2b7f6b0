//! The record of a body: the data that the event loop reads for each body, in one cache line.

use carom_kinematics::Motion;
use glam::DVec2;

use super::slot::{INDEX_BITS, INDEX_MASK};

/// Kind of a body's next event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub(super) enum RecordKind {
    /// Contact of two discs.
    Discs = 0,
    /// A disc enters the next cell along +x.
    Right = 1,
    /// A disc enters the next cell along −x.
    Left = 2,
    /// A disc enters the next cell along +y.
    Up = 3,
    /// A disc enters the next cell along −y.
    Down = 4,
    /// Contact of a multi-cell body, or with one; its parts and image are in
    /// `MultiCellBodies::pending`.
    MultiCell = 5,
    /// A multi-cell body leaves its shell.
    Shell = 6,
    /// Re-check: the body is predicted again, since a search did not finish.
    Recheck = 7,
    /// A piston reaches one of its stops.
    Stop = 8,
    /// No event.
    Nothing = 9,
}

impl RecordKind {
    /// The crossing along an axis (0 or 1) in the direction with this sign bit (1 for downwards).
    #[inline]
    pub fn crossing(axis: u32, sign: u32) -> Self {
        Self::from_bits(Self::Right as u32 + 2 * axis + sign)
    }

    /// Whether the event is a contact of two bodies.
    #[inline]
    pub fn is_contact(self) -> bool {
        matches!(self, Self::Discs | Self::MultiCell)
    }

    /// Whether a disc enters the next cell.
    #[inline]
    pub fn is_crossing(self) -> bool {
        (self as u32).wrapping_sub(Self::Right as u32) < 4
    }

    /// Axis and direction (+1 or −1) of a crossing.
    #[inline]
    pub fn direction(self) -> (usize, i32) {
        // By arithmetic: a branch on the direction would often be mispredicted.
        let number = (self as u32).wrapping_sub(Self::Right as u32) & 3;
        ((number >> 1) as usize, 1 - 2 * (number & 1) as i32)
    }

    #[inline]
    pub fn from_bits(bits: u32) -> Self {
        match bits {
            0 => Self::Discs,
            1 => Self::Right,
            2 => Self::Left,
            3 => Self::Up,
            4 => Self::Down,
            5 => Self::MultiCell,
            6 => Self::Shell,
            7 => Self::Recheck,
            8 => Self::Stop,
            _ => Self::Nothing,
        }
    }
}

/// A body: its position extrapolated to the start of the epoch, its velocity, and its one event.
///
/// The record describes a disc completely. Molecules have their motions in tables of their own.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct BodyRecord {
    /// x₀, y₀, vx, vy with position = (x₀, y₀) + (vx, vy) t (length, length per time). (x₀, y₀) is
    /// the position at the start of the epoch, had the body always moved as now. Adjacent, so that
    /// one load reads all four.
    pub flight: [f64; 4],
    /// Time of its event (offset in the epoch).
    pub time: f64,
    /// The radius, or in a dilute gas the time of the earliest contact.
    shared: RadiusOrContactTime,
    /// Kind of event, and the partner of a contact.
    event: u32,
    /// Version of the partner when the event was predicted.
    pub partner_version: u32,
    /// Incremented at each change of the motion.
    pub version: u32,
    /// Column and row of the cell of a disc, in one word: it is read as one word right after it is
    /// written, and store-to-load forwarding needs a store of the same width.
    cell: u32,
}

/// Cell of a body that lives in none.
pub(super) const NO_CELL: [u16; 2] = [u16::MAX; 2];

/// A number for which a record has one place: the radius of a body (length), or in a dilute gas,
/// where all radii are equal and not stored for each disc, the time of the disc's earliest contact
/// (offset in the epoch). Which of them it is, is the same for all bodies of an epoch.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
struct RadiusOrContactTime(f64);

/// A record fills one cache line.
const _: () = assert!(size_of::<BodyRecord>() == 64);

/// Numbers of [`BodyRecord::flight`] for a motion.
#[inline]
pub(super) fn flight_of(motion: &Motion) -> [f64; 4] {
    let origin = motion.position - motion.velocity * motion.time;
    [origin.x, origin.y, motion.velocity.x, motion.velocity.y]
}

impl BodyRecord {
    /// The record of unused slots: every comparison with NaN is false, so it never gives a contact.
    pub fn dummy() -> Self {
        Self {
            flight: [f64::NAN, f64::NAN, 0.0, 0.0],
            time: f64::INFINITY,
            shared: RadiusOrContactTime(0.0),
            event: (RecordKind::Nothing as u32) << INDEX_BITS,
            partner_version: 0,
            version: 0,
            cell: 0,
        }
    }

    pub fn new(motion: &Motion, radius: f64) -> Self {
        let mut record = Self {
            shared: RadiusOrContactTime(radius),
            ..Self::dummy()
        };
        record.set_motion(motion);
        record
    }

    /// The record of a disc with this flight and radius, without an event.
    #[inline]
    pub fn at(flight: [f64; 4], radius: f64) -> Self {
        Self {
            flight,
            shared: RadiusOrContactTime(radius),
            ..Self::dummy()
        }
    }

    /// Sets the flight from a motion that begins at its subjective time.
    pub fn set_motion(&mut self, motion: &Motion) {
        self.flight = flight_of(motion);
    }

    /// The motion of a disc.
    #[inline]
    pub fn motion(&self) -> Motion {
        Motion {
            velocity: self.velocity(),
            ..Motion::at_rest(self.origin())
        }
    }

    pub fn origin(&self) -> DVec2 {
        DVec2::new(self.flight[0], self.flight[1])
    }

    pub fn velocity(&self) -> DVec2 {
        DVec2::new(self.flight[2], self.flight[3])
    }

    /// Column and row of the cell of a disc.
    #[inline]
    pub fn cell(&self) -> [u16; 2] {
        [self.cell as u16, (self.cell >> 16) as u16]
    }

    #[inline]
    pub fn set_cell(&mut self, [column, row]: [u16; 2]) {
        self.cell = u32::from(column) | u32::from(row) << 16;
    }

    /// Column (axis 0) or row (axis 1) of the cell.
    #[inline]
    pub fn cell_along(&self, axis: usize) -> u16 {
        (self.cell >> (16 * axis)) as u16
    }

    /// Sets the column (axis 0) or row (axis 1) of the cell. By arithmetic on the whole word: a
    /// store of half of it would fail store-to-load forwarding, because the word is read right
    /// afterwards.
    #[inline]
    pub fn set_cell_along(&mut self, axis: usize, number: u16) {
        self.cell = self.cell & !(0xffff << (16 * axis)) | u32::from(number) << (16 * axis);
    }

    /// Radius of a disc, bounding radius of another body (length); not in a dilute gas.
    #[inline]
    pub fn radius(&self) -> f64 {
        self.shared.0
    }

    /// In a dilute gas: time of the earliest contact, whether or not a crossing comes before it
    /// (offset in the epoch).
    #[inline]
    pub fn kept_contact_time(&self) -> f64 {
        self.shared.0
    }

    #[inline]
    pub fn set_kept_contact_time(&mut self, time: f64) {
        self.shared = RadiusOrContactTime(time);
    }

    pub fn kind(&self) -> RecordKind {
        RecordKind::from_bits(self.event >> INDEX_BITS)
    }

    pub fn partner(&self) -> u32 {
        self.event & INDEX_MASK
    }

    pub fn set_event(&mut self, time: f64, kind: RecordKind, partner: u32, partner_version: u32) {
        self.time = time;
        self.event = ((kind as u32) << INDEX_BITS) | partner;
        self.partner_version = partner_version;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crossing_encodes_its_axis_and_direction() {
        for (axis, sign, kind) in [
            (0, 0, RecordKind::Right),
            (0, 1, RecordKind::Left),
            (1, 0, RecordKind::Up),
            (1, 1, RecordKind::Down),
        ] {
            assert_eq!(RecordKind::crossing(axis, sign), kind);
            assert_eq!(
                kind.direction(),
                (axis as usize, if sign == 0 { 1 } else { -1 })
            );
            assert!(kind.is_crossing() && !kind.is_contact());
        }
        for kind in [
            RecordKind::Discs,
            RecordKind::MultiCell,
            RecordKind::Shell,
            RecordKind::Recheck,
            RecordKind::Stop,
            RecordKind::Nothing,
        ] {
            assert!(!kind.is_crossing());
            assert_eq!(
                kind.is_contact(),
                kind == RecordKind::Discs || kind == RecordKind::MultiCell
            );
        }
    }
}
