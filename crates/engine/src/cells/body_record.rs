//! A body's record: all that the hot loop needs of it, in one cache line.

use carom_kinematics::Motion;
use glam::DVec2;

/// Bits of a body's index in a slot or a partner; the rest says what kind of event, or which image.
pub(super) const INDEX_BITS: u32 = 28;
/// Mask of an index.
pub(super) const INDEX_MASK: u32 = (1 << INDEX_BITS) - 1;

/// What a body's next event is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub(super) enum Kind {
    /// Contact of two discs.
    Discs = 0,
    /// A disc enters the next cell along +x.
    Right = 1,
    /// Along −x.
    Left = 2,
    /// Along +y.
    Up = 3,
    /// Along −y.
    Down = 4,
    /// Contact with a covering body, or of one; its parts and image are kept aside.
    MultiCell = 5,
    /// A covering body leaves its shell.
    Shell = 6,
    /// A covering body is to be predicted again, since a search had to be broken off.
    Recheck = 7,
    /// Nothing.
    Nothing = 8,
}

impl Kind {
    /// The crossing along an axis (0 or 1), whose direction has this sign bit (1 for downwards).
    #[inline]
    pub fn crossing(axis: u32, sign: u32) -> Self {
        Self::from_bits(Self::Right as u32 + 2 * axis + sign)
    }

    /// Whether it is a contact of two bodies.
    #[inline]
    pub fn is_contact(self) -> bool {
        matches!(self, Self::Discs | Self::MultiCell)
    }

    /// Whether a disc enters the next cell.
    #[inline]
    pub fn is_crossing(self) -> bool {
        (self as u32).wrapping_sub(Self::Right as u32) < 4
    }

    /// Axis and direction of a crossing.
    #[inline]
    pub fn direction(self) -> (usize, i32) {
        // By arithmetic: which way a disc goes cannot be predictn by a branch.
        let number = (self as u32).wrapping_sub(Self::Right as u32) & 3;
        ((number >> 1) as usize, 1 - 2 * (number & 1) as i32)
    }

    #[inline]
    fn from_bits(bits: u32) -> Self {
        match bits {
            0 => Self::Discs,
            1 => Self::Right,
            2 => Self::Left,
            3 => Self::Up,
            4 => Self::Down,
            5 => Self::MultiCell,
            6 => Self::Shell,
            7 => Self::Recheck,
            _ => Self::Nothing,
        }
    }
}

/// One body: where it would have been at the start of the epoch, its velocity, and its one event.
///
/// A disc is wholly described by it; what turns has more in a table of its own.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct BodyRecord {
    /// Place at the start of the epoch, had it always moved as now (length), and velocity: x₀, y₀, vx, vy with
    /// place = (x₀, y₀) + (vx, vy) t. Side by side, so that they are read as one vector.
    pub flight: [f64; 4],
    /// Time of its event (offset in the epoch).
    pub time: f64,
    /// Radius of a disc, bounding radius of anything else (length). In a dilute gas of like discs, whose radius need not be
    /// kept for each: the time of the contact that waits behind a crossing.
    pub radius: f64,
    /// Kind of event, and the partner of a contact.
    event: u32,
    /// Version of the partner when the event was predicted.
    pub partner_version: u32,
    /// Goes up each time the motion changes.
    pub version: u32,
    /// Column and row of the cell of a disc, in one piece: it is read in one piece right after it was written.
    cell: u32,
}

/// Place at the start of the epoch, had the body always moved as now, and velocity.
#[inline]
pub(super) fn flight_of(motion: &Motion) -> [f64; 4] {
    let origin = motion.position - motion.velocity * motion.time;
    [origin.x, origin.y, motion.velocity.x, motion.velocity.y]
}

impl BodyRecord {
    /// What fills unused slots: every comparison with NaN is false, so it never wins.
    pub fn dummy() -> Self {
        Self {
            flight: [f64::NAN, f64::NAN, 0.0, 0.0],
            time: f64::INFINITY,
            radius: 0.0,
            event: (Kind::Nothing as u32) << INDEX_BITS,
            partner_version: 0,
            version: 0,
            cell: 0,
        }
    }

    pub fn new(motion: &Motion, radius: f64) -> Self {
        let mut record = Self { radius, ..Self::dummy() };
        record.set_motion(motion);
        record
    }

    /// Takes over a motion that begins at its subjective time.
    pub fn set_motion(&mut self, motion: &Motion) {
        self.flight = flight_of(motion);
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

    /// Number of the cell along an axis, its column or row.
    #[inline]
    pub fn cell_along(&self, axis: usize) -> u16 {
        (self.cell >> (16 * axis)) as u16
    }

    /// Sets the number of the cell along an axis. By arithmetic: what is written in two pieces cannot be read as one until it
    /// has reached the cache, and the cell is read at once.
    #[inline]
    pub fn set_cell_along(&mut self, axis: usize, number: u16) {
        self.cell = self.cell & !(0xffff << (16 * axis)) | u32::from(number) << (16 * axis);
    }

    /// In a dilute gas: the time of its soonest contact, be a crossing before it or not.
    pub fn later(&self) -> f64 {
        self.radius
    }

    pub fn set_later(&mut self, time: f64) {
        self.radius = time;
    }

    pub fn kind(&self) -> Kind {
        Kind::from_bits(self.event >> INDEX_BITS)
    }

    pub fn partner(&self) -> u32 {
        self.event & INDEX_MASK
    }

    pub fn set_event(&mut self, time: f64, kind: Kind, partner: u32, partner_version: u32) {
        self.time = time;
        self.event = ((kind as u32) << INDEX_BITS) | partner;
        self.partner_version = partner_version;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crossing_says_where_it_goes() {
        for (axis, sign, kind) in
            [(0, 0, Kind::Right), (0, 1, Kind::Left), (1, 0, Kind::Up), (1, 1, Kind::Down)]
        {
            assert_eq!(Kind::crossing(axis, sign), kind);
            assert_eq!(kind.direction(), (axis as usize, if sign == 0 { 1 } else { -1 }));
            assert!(kind.is_crossing() && !kind.is_contact());
        }
        for kind in [Kind::Discs, Kind::MultiCell, Kind::Shell, Kind::Recheck, Kind::Nothing] {
            assert!(!kind.is_crossing());
            assert_eq!(kind.is_contact(), kind == Kind::Discs || kind == Kind::MultiCell);
        }
    }
}
