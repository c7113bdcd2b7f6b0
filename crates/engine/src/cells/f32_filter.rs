//! A floating-point filter in single precision: it excludes discs of a dilute gas that a disc
//! cannot touch in this epoch.
//!
//! Many discs of a dilute gas are tested for each contact. Their flights are stored in single
//! precision, eight numbers to a register, and only discs that pass the filter are tested exactly.
//! The filter excludes no contact of this epoch, so results do not depend on it. Contacts after the
//! end of the epoch may be excluded; they never happen.
//!
//! # Lemmas
//!
//! No two discs that touch before the end of the epoch are excluded. The unit of length is the
//! longer side of the box. The unit of speed is a bound that no component of a velocity exceeds
//! ([`Units::quantize`] checks this). So each coordinate in the box and each component of a
//! velocity is at most 1. Let the epoch last T, u = 2⁻²⁴, σ the contact distance, d the present
//! separation and v the relative velocity. Errors are along each axis.
//!
//! 1. **Input.** A position at the start of the epoch is stored to u (1 + T), a velocity to u, and
//!    the present time to u T. So the present position of a stored disc has the error
//!    u (2 + 4 T), that of the query disc, with its image, 4 u, d the error u (7 + 4 T), and v the
//!    error 4 u.
//! 2. **Distance.** In the rounded numbers, discs that touch come within σ + ε with
//!    ε = √2 u (7 + 8 T). *Proof.* The error of d + v τ at the contact, a time τ ≤ T from now, is
//!    u (7 + 4 T) + 4 u τ along each of two axes.
//! 3. **Discriminant.** By lemma 2, |d × v| ≤ (σ + ε) |v|. As |d| < 1 (cells are adjacent, at least
//!    three a side), the rounding of d × v is at most 2 u |v|, and that of the compared numbers
//!    2.5 u of their magnitude. So the distance σ (1 + 2.5 u) + u (12 + 11.4 T) is sufficient.
//!    [`Units::new`] takes σ (1 + 8 u) + u (16 + 16 T).
//! 4. **Approach.** Discs that touch later approach, d·v < 0. The error of d·v is below
//!    u (40 + 16 T). [`Units::new`] takes u (48 + 20 T).
//! 5. **Underflow.** [`UNDERFLOW`] exceeds the error of squares that are too small for all their
//!    digits.

use carom_detection::DISC_LANES;
use glam::{DVec2, Vec4};

use super::slot::{INDEX_BITS, image_of};

/// u, the rounding of a single-precision number of magnitude 1.
const U_SINGLE: f64 = 0.5 * f32::EPSILON as f64;

/// Bound on the total error of squares that underflow. Smaller: discs with equal velocities, to
/// rounding, may be excluded although they touch.
const UNDERFLOW: f32 = f32::MIN_POSITIVE;

/// Longest epoch for which the filter works, in its units. An epoch in which the fastest body
/// crosses the box a few times is never so long; the bound is for infinite or NaN times and the
/// like. Larger: positions would have no digits left.
const MAX_EPOCH: f64 = 1e3;

/// Flights of eight discs as a structure of arrays: x₀, y₀, vx, vy. Empty lanes hold NaN in x₀, so
/// that every comparison is false.
pub(super) type Flights = [[f32; DISC_LANES]; 4];

/// Units of the stored flights, and the thresholds for an epoch.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Units {
    /// Factors on the numbers of a flight (1/length twice, 1/speed twice).
    per_unit: [f64; 4],
    /// Factor on a time (1/time).
    per_time: f64,
    /// Square of the distance within which discs must come, in these units.
    reach_squared: f32,
    /// d·v from which on discs recede, in these units.
    receding: f32,
    /// Shift of a disc seen in an image, by the image's code in a slot.
    shifts: [[f32; 2]; 16],
    /// Whether a disc is too fast or the epoch too long: then every disc is a candidate.
    is_disabled: bool,
}

impl Units {
    /// Units for discs with this contact distance (length), in a box of these sides (length), with
    /// these velocities at the start of an epoch that ends at `limit` (time).
    pub fn new(
        contact_distance: f64,
        sides: DVec2,
        limit: f64,
        velocities: impl ExactSizeIterator<Item = DVec2>,
    ) -> Self {
        let (side, speed) = (sides.max_element(), speed_unit(velocities));
        let per_time = speed / side;
        let longest = limit * per_time;
        let reach =
            (1.0 + 8.0 * U_SINGLE) * contact_distance / side + U_SINGLE * (16.0 + 16.0 * longest);
        let numbers = [1.0 / side, 1.0 / speed, per_time];
        Self {
            per_unit: [1.0 / side, 1.0 / side, 1.0 / speed, 1.0 / speed],
            per_time,
            reach_squared: (reach * reach) as f32,
            receding: (U_SINGLE * (48.0 + 20.0 * longest)) as f32,
            shifts: std::array::from_fn(|code| {
                let [x, y] = image_of((code as u32) << INDEX_BITS);
                [
                    (f64::from(x) * sides.x / side) as f32,
                    (f64::from(y) * sides.y / side) as f32,
                ]
            }),
            is_disabled: !(longest <= MAX_EPOCH && numbers.iter().all(|number| number.is_normal())),
        }
    }

    /// Whether every disc is a candidate, because the filter does not work in this epoch.
    pub fn is_disabled(&self) -> bool {
        self.is_disabled
    }

    /// Converts a flight to these units. Disables the filter if the flight is too fast for them.
    #[inline(always)]
    pub fn quantize(&mut self, flight: [f64; 4]) -> [f32; 4] {
        let kept: [f64; 4] = std::array::from_fn(|number| flight[number] * self.per_unit[number]);
        // Written only if it changes: an unconditional store to one field would break store-to-load
        // forwarding for loads that span it.
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
            velocity: [
                (flight[2] * self.per_unit[2]) as f32,
                (flight[3] * self.per_unit[3]) as f32,
            ],
            now: (now * self.per_time) as f32,
            reach_squared: self.reach_squared,
            receding: self.receding,
        }
    }
}

/// A speed that few discs ever reach: the larger of twice the greatest and four times the root mean
/// square. In a gas in equilibrium one disc in 10⁷ exceeds the second. At the start of a run all
/// may have the same speed, and twice the greatest would be too low.
fn speed_unit(velocities: impl ExactSizeIterator<Item = DVec2>) -> f64 {
    let count = velocities.len() as f64;
    let (fastest, sum) =
        velocities
            .map(DVec2::length_squared)
            .fold((0.0, 0.0), |(fastest, sum), square| {
                (
                    if square > fastest { square } else { fastest },
                    sum + square,
                )
            });
    2.0 * f64::max(fastest, 4.0 * sum / count).sqrt()
}

/// Filter of a query disc, in the units of the epoch.
#[derive(Debug, Clone, Copy)]
pub(super) struct F32Filter {
    pub place: [f32; 2],
    pub velocity: [f32; 2],
    pub now: f32,
    pub reach_squared: f32,
    pub receding: f32,
}

impl F32Filter {
    /// The filter for discs seen in the image with this code.
    #[inline(always)]
    pub fn for_image(self, units: &Units, code: usize) -> Self {
        let [x, y] = units.shifts[code];
        Self {
            place: [self.place[0] - x, self.place[1] - y],
            ..self
        }
    }

    /// Lower bound on σ² v² − (d × v)² of discs that can touch.
    pub const MIN_DISCRIMINANT: f32 = -UNDERFLOW;

    /// Which of eight discs pass the filter, a bit each. Four lanes at a time, the width of the
    /// registers of every processor.
    #[inline(always)]
    pub fn near(&self, flights: &Flights) -> u32 {
        let [place_x, place_y] = self.place.map(Vec4::splat);
        let [velocity_x, velocity_y] = self.velocity.map(Vec4::splat);
        let (now, reach_squared) = (Vec4::splat(self.now), Vec4::splat(self.reach_squared));
        let (receding, least) = (
            Vec4::splat(self.receding),
            Vec4::splat(Self::MIN_DISCRIMINANT),
        );
        let four = |first: usize| {
            let [x, y, vx, vy] = flights
                .each_ref()
                .map(|numbers| Vec4::from_slice(&numbers[first..]));
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
        Units::new(
            0.1,
            DVec2::ONE,
            limit,
            speeds.map(|speed| DVec2::new(0.0, speed)).into_iter(),
        )
    }

    #[test]
    fn a_disc_too_fast_for_the_units_disables_the_filter() {
        // Twice the greatest, or four times the root mean square.
        for (speeds, bound) in [
            ([1.0, 0.0], 8.0_f64.sqrt()),
            ([1.0, 1.0], 4.0),
            ([1e-3, 0.0], 8e-6_f64.sqrt()),
        ] {
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
    fn units_without_digits_disable_the_filter() {
        let no_discs = Units::new(0.1, DVec2::ONE, 1.0, [].into_iter());
        let disabled = [
            no_discs,
            units(1e9, [1.0]),
            units(f64::INFINITY, [1.0]),
            units(f64::NAN, [1.0]),
            units(1.0, [0.0]),
            units(f64::INFINITY, [0.0]),
            // The square of this speed underflows to 0.
            units(1e300, [1e-300]),
            units(1.0, [f64::NAN]),
        ];
        assert!(disabled.iter().all(Units::is_disabled), "{disabled:?}");
        // A subnormal square gives a coarse unit of speed; it is still a bound.
        let mut coarse = units(1e161, [1e-161]);
        assert!(!coarse.is_disabled());
        coarse.quantize([0.0, 0.0, 0.0, 1e-160]);
        assert!(coarse.is_disabled());
    }
}
