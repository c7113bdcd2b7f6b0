//! A first filter in single precision: which of eight discs another may meet at all.
//!
//! In a dilute gas many discs are looked at for each that is met. So their flights are kept in single precision, eight to
//! a register, and only those that may be met are asked exactly. A filter leaves nobody out, so what happens does not depend
//! on it.
//!
//! **Nobody is left out.** In units of the longer side of the box, and of a speed that nobody exceeds ([`Units::quantize`] sees
//! to that), a place in the box and each component of a velocity are 1 at most; let the epoch last T, and u be 2⁻²⁴. A place
//! at its start is kept to u (1 + T), a velocity to u, the time now to u T; so another disc's place now is off by u (2 + 4 T), the
//! asking one's, with its image, by 4 u, their separation d by u (7 + 4 T), and their relative velocity v by 4 u, along each
//! axis. Two discs that touch at a distance σ before the epoch ends come therefore, as they are seen here, within σ + ε,
//! with ε = √2 u (7 + 8 T). Then |d × v| ≤ (σ + ε) |v|; since |d| < 1 (they are in adjacent cells of three or more), the left
//! side is off by 2 u |v|, and what is compared by 2.5 u of itself: σ (1 + 2.5 u) + u (12 + 11.4 T) is needed, and [`Units::new`]
//! takes σ (1 + 8 u) + u (16 + 16 T). Whoever is met approaches, d·v < 0; its error here is below u (40 + 16 T), where 48 + 20 T
//! is taken. What is too small for single precision is added where it counts, [`UNDERFLOW`].
//!
//! What comes after the end of the epoch may be left out or not. It never happens.

use carom_detection::DISC_LANES;
use glam::{DVec2, Vec4};

use super::neighbour_lists::image_of;

/// u, the rounding of a single-precision number of magnitude 1.
const U_SINGLE: f64 = 0.5 * f32::EPSILON as f64;

/// More than all squares together lose that are too small to have all their digits. Smaller: discs at the same velocity,
/// to rounding, may not be seen to touch.
const UNDERFLOW: f32 = f32::MIN_POSITIVE;

/// Epochs longer than this (in the units of the filter) are not looked through: everybody may be met. A few sides of the box
/// at the greatest speed are never so long; this is for times that are no time. Larger: places would have no digits left.
const LONGEST: f64 = 1e3;

/// Flights of eight discs, x₀, y₀, vx, vy after each other; x₀ of nobody is NaN, and every comparison with it false.
pub(super) type Flights = [[f32; DISC_LANES]; 4];

/// In which units flights are kept, and what follows for an epoch.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Units {
    /// What the numbers of a flight are multiplied by (1/length twice, 1/speed twice).
    per_unit: [f64; 4],
    /// What a time is multiplied by (1/time).
    per_time: f64,
    /// Square of the distance within which discs have to come, in these units.
    reach_squared: f32,
    /// d·v from which on they recede, in these units.
    receding: f32,
    /// By how much somebody is shifted who is seen in an image, by its code in a slot.
    shifts: [[f32; 2]; 16],
    /// Whether somebody is too fast, or the epoch too long: then everybody may be met.
    is_disabled: bool,
}

impl Units {
    /// For discs that touch at this distance of their centres (length), in a box of these sides, with these velocities at the
    /// start of an epoch that ends at `limit` (time).
    pub fn new(
        contact_distance: f64,
        sides: DVec2,
        limit: f64,
        velocities: impl ExactSizeIterator<Item = DVec2>,
    ) -> Self {
        let (side, speed) = (sides.max_element(), hardly_exceeded(velocities));
        let per_time = speed / side;
        let longest = limit * per_time;
        let reach = (1.0 + 8.0 * U_SINGLE) * contact_distance / side + U_SINGLE * (16.0 + 16.0 * longest);
        let numbers = [1.0 / side, 1.0 / speed, per_time];
        Self {
            per_unit: [1.0 / side, 1.0 / side, 1.0 / speed, 1.0 / speed],
            per_time,
            reach_squared: (reach * reach) as f32,
            receding: (U_SINGLE * (48.0 + 20.0 * longest)) as f32,
            shifts: std::array::from_fn(|code| {
                let [x, y] = image_of((code as u32) << super::body_record::INDEX_BITS);
                [(f64::from(x) * sides.x / side) as f32, (f64::from(y) * sides.y / side) as f32]
            }),
            is_disabled: !(longest <= LONGEST && numbers.iter().all(|number| number.is_normal())),
        }
    }

    /// Whether everybody may be met, whatever a filter says.
    pub fn is_disabled(&self) -> bool {
        self.is_disabled
    }

    /// A flight as it is kept. If it is too fast for these units, they hold for nobody any longer.
    #[inline(always)]
    pub fn quantize(&mut self, flight: [f64; 4]) -> [f32; 4] {
        let kept: [f64; 4] = std::array::from_fn(|number| flight[number] * self.per_unit[number]);
        // Not written unless it changes: it is read in one piece with what stands beside it.
        if !((kept[2].abs() <= 1.0) & (kept[3].abs() <= 1.0)) {
            self.is_disabled = true;
        }
        kept.map(|number| number as f32)
    }

    /// The filter of a disc on its flight, at a time.
    #[inline(always)]
    pub fn filter(&self, flight: &[f64; 4], now: f64) -> F32Filter {
        let place = [flight[0] + flight[2] * now, flight[1] + flight[3] * now];
        F32Filter {
            place: place.map(|number| (number * self.per_unit[0]) as f32),
            velocity: [(flight[2] * self.per_unit[2]) as f32, (flight[3] * self.per_unit[3]) as f32],
            now: (now * self.per_time) as f32,
            reach_squared: self.reach_squared,
            receding: self.receding,
        }
    }
}

/// A speed that few of some discs ever reach: at least twice that of the fastest, and at least four times their root mean
/// square, which of a gas in equilibrium one in 10⁷ exceeds; at the start of a run all may have the same.
fn hardly_exceeded(velocities: impl ExactSizeIterator<Item = DVec2>) -> f64 {
    let count = velocities.len() as f64;
    let (fastest, sum) = velocities.map(DVec2::length_squared).fold((0.0, 0.0), |(fastest, sum), square| {
        (if square > fastest { square } else { fastest }, sum + square)
    });
    2.0 * f64::max(fastest, 4.0 * sum / count).sqrt()
}

/// What is to be known of a disc that looks who may be met, in the units of the epoch.
#[derive(Debug, Clone, Copy)]
pub(super) struct F32Filter {
    pub place: [f32; 2],
    pub velocity: [f32; 2],
    pub now: f32,
    pub reach_squared: f32,
    pub receding: f32,
}

impl F32Filter {
    /// The same at others that are seen in the image with this code.
    #[inline(always)]
    pub fn through(self, units: &Units, code: usize) -> Self {
        let [x, y] = units.shifts[code];
        Self { place: [self.place[0] - x, self.place[1] - y], ..self }
    }

    /// The least σ² v² − (d × v)² of those that may be met.
    pub const LEAST: f32 = -UNDERFLOW;

    /// Which of eight discs may be met, a bit each: four at a time, as the registers of every processor have room for.
    #[inline(always)]
    pub fn near(&self, flights: &Flights) -> u32 {
        let [place_x, place_y] = self.place.map(Vec4::splat);
        let [velocity_x, velocity_y] = self.velocity.map(Vec4::splat);
        let (now, reach_squared) = (Vec4::splat(self.now), Vec4::splat(self.reach_squared));
        let (receding, least) = (Vec4::splat(self.receding), Vec4::splat(Self::LEAST));
        let four = |first: usize| {
            let [x, y, vx, vy] = flights.each_ref().map(|numbers| Vec4::from_slice(&numbers[first..]));
            let (dx, dy) = (place_x - (x + vx * now), place_y - (y + vy * now));
            let (vx, vy) = (velocity_x - vx, velocity_y - vy);
            let cross = dx * vy - dy * vx;
            let discriminant = reach_squared * (vx * vx + vy * vy) - cross * cross;
            ((dx * vx + dy * vy).cmplt(receding) & discriminant.cmpge(least)).bitmask()
        };
        four(0) | four(DISC_LANES / 2) << (DISC_LANES / 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn units<const N: usize>(limit: f64, speeds: [f64; N]) -> Units {
        Units::new(0.1, DVec2::ONE, limit, speeds.map(|speed| DVec2::new(0.0, speed)).into_iter())
    }

    #[test]
    fn whoever_is_too_fast_makes_everybody_worth_asking() {
        // Twice the fastest, or four times the root mean square.
        for (speeds, bound) in
            [([1.0, 0.0], 8.0_f64.sqrt()), ([1.0, 1.0], 4.0), ([1e-3, 0.0], 8e-6_f64.sqrt())]
        {
            let mut units = units(1.0, speeds);
            units.quantize([0.0, 0.0, 0.999 * bound, -0.999 * bound]);
            assert!(!units.is_disabled(), "{bound}");
            units.quantize([0.0, 0.0, 0.0, -1.001 * bound]);
            assert!(units.is_disabled(), "{bound}");
        }
        let mut units = units(1.0, [1.0]);
        units.quantize([0.0, 0.0, 0.0, f64::NAN]);
        assert!(units.is_disabled());
    }

    #[test]
    fn where_nothing_can_be_seen_everybody_is_asked() {
        let nobody = Units::new(0.1, DVec2::ONE, 1.0, [].into_iter());
        let blind = [
            nobody,
            units(1e9, [1.0]),
            units(f64::INFINITY, [1.0]),
            units(f64::NAN, [1.0]),
            units(1.0, [0.0]),
            units(f64::INFINITY, [0.0]),
            // Its square is 0.
            units(1e300, [1e-300]),
            units(1.0, [f64::NAN]),
        ];
        assert!(blind.iter().all(Units::is_disabled), "{blind:?}");
        // A square with few digits gives a speed that is kept to, whatever it is.
        let mut coarse = units(1e161, [1e-161]);
        assert!(!coarse.is_disabled());
        coarse.quantize([0.0, 0.0, 0.0, 1e-160]);
        assert!(coarse.is_disabled());
    }
}
