//! The hot loop compiled twice: for every processor of this kind, and with AVX2 where there is AVX2.
//!
//! The one place of the project with unsafe code: calling functions that were compiled with instructions which the
//! compiler does not take for granted, after having asked the processor for them, and giving registers back as arrays
//! of the same size. No pointers are handled here. Neither version fuses a multiplication and an addition, so both
//! compute the same bits.

#![allow(unsafe_code, reason = "calls into the AVX2 build of the loop; see the module's documentation")]

use carom_detection::{DISC_LANES, Detection};
use carom_kinematics::Motion;

use super::{Instructions, State};
use crate::{ContactEvent, World};

/// How the flights of eight bodies are brought from their lines into lanes.
pub(super) trait Gather {
    /// Where eight bodies are at `now` as seen from one, and how they move: for each of x, y, vx, vy the eight lanes.
    fn relative(flights: [&[f64; 4]; DISC_LANES], from: &[f64; 4], now: f64) -> [[f64; DISC_LANES]; 4];

    /// Which lanes hold exactly this number, a bit each.
    fn equal(lanes: &[f64; DISC_LANES], number: f64) -> u32;
}

/// Number by number, for every processor.
pub(super) struct Portable;

impl Gather for Portable {
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    fn relative(flights: [&[f64; 4]; DISC_LANES], from: &[f64; 4], now: f64) -> [[f64; DISC_LANES]; 4] {
        let mut lanes = [[0.0; DISC_LANES]; 4];
        for (lane, flight) in flights.iter().enumerate() {
            for part in 0..2 {
                let velocity = flight[part + 2] - from[part + 2];
                lanes[part + 2][lane] = velocity;
                lanes[part][lane] = (flight[part] - from[part]) + velocity * now;
            }
        }
        lanes
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    fn equal(lanes: &[f64; DISC_LANES], number: f64) -> u32 {
        let mut equal = 0;
        for (lane, &other) in lanes.iter().enumerate() {
            equal |= u32::from(other == number) << lane;
        }
        equal
    }
}

/// Four numbers at a time. To be used in code compiled for AVX2 only.
#[cfg(target_arch = "x86_64")]
struct Avx2;

#[cfg(target_arch = "x86_64")]
impl Gather for Avx2 {
    #[inline(always)]
    fn relative(flights: [&[f64; 4]; DISC_LANES], from: &[f64; 4], now: f64) -> [[f64; DISC_LANES]; 4] {
        use std::arch::x86_64::{
            __m256d, _mm256_add_pd, _mm256_mul_pd, _mm256_permute2f128_pd, _mm256_set1_pd, _mm256_setr_pd,
            _mm256_sub_pd, _mm256_unpackhi_pd, _mm256_unpacklo_pd,
        };
        /// Four flights less one, turned from rows into columns.
        #[target_feature(enable = "avx2")]
        #[inline]
        fn columns(rows: [&[f64; 4]; 4], from: &[f64; 4], now: f64) -> [[f64; 4]; 4] {
            let load = |row: &[f64; 4]| _mm256_setr_pd(row[0], row[1], row[2], row[3]);
            let from = load(from);
            let [a, b, c, d] = [
                _mm256_sub_pd(load(rows[0]), from),
                _mm256_sub_pd(load(rows[1]), from),
                _mm256_sub_pd(load(rows[2]), from),
                _mm256_sub_pd(load(rows[3]), from),
            ];
            let (x_vx_ab, x_vx_cd) = (_mm256_unpacklo_pd(a, b), _mm256_unpacklo_pd(c, d));
            let (y_vy_ab, y_vy_cd) = (_mm256_unpackhi_pd(a, b), _mm256_unpackhi_pd(c, d));
            let now = _mm256_set1_pd(now);
            let (vx, vy) = (
                _mm256_permute2f128_pd::<0x31>(x_vx_ab, x_vx_cd),
                _mm256_permute2f128_pd::<0x31>(y_vy_ab, y_vy_cd),
            );
            let (x, y) = (
                _mm256_permute2f128_pd::<0x20>(x_vx_ab, x_vx_cd),
                _mm256_permute2f128_pd::<0x20>(y_vy_ab, y_vy_cd),
            );
            let x = _mm256_add_pd(x, _mm256_mul_pd(vx, now));
            let y = _mm256_add_pd(y, _mm256_mul_pd(vy, now));
            let columns: [__m256d; 4] = [x, y, vx, vy];
            // SAFETY: four registers of four floats and four arrays of four floats are the same bytes.
            unsafe { std::mem::transmute::<[__m256d; 4], [[f64; 4]; 4]>(columns) }
        }
        let [a, b, c, d, e, f, g, h] = flights;
        // SAFETY: `Avx2` is named only in the functions below that are compiled for AVX2 and called where it is there.
        let (low, high) = unsafe { (columns([a, b, c, d], from, now), columns([e, f, g, h], from, now)) };
        let mut lanes = [[0.0; DISC_LANES]; 4];
        for part in 0..4 {
            lanes[part][..4].copy_from_slice(&low[part]);
            lanes[part][4..].copy_from_slice(&high[part]);
        }
        lanes
    }

    #[inline(always)]
    fn equal(lanes: &[f64; DISC_LANES], number: f64) -> u32 {
        use std::arch::x86_64::{
            _CMP_EQ_OQ, _mm256_cmp_pd, _mm256_movemask_pd, _mm256_set1_pd, _mm256_setr_pd,
        };
        #[target_feature(enable = "avx2")]
        #[inline]
        fn mask(lanes: &[f64; DISC_LANES], number: f64) -> i32 {
            let [a, b, c, d, e, f, g, h] = *lanes;
            let (low, high) = (_mm256_setr_pd(a, b, c, d), _mm256_setr_pd(e, f, g, h));
            let number = _mm256_set1_pd(number);
            let low = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_EQ_OQ>(low, number));
            let high = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_EQ_OQ>(high, number));
            low | high << 4
        }
        // SAFETY: as above.
        unsafe { mask(lanes, number) as u32 }
    }
}

/// What of the wish this processor can fulfil.
pub(super) fn available(wish: Instructions) -> Instructions {
    #[cfg(target_arch = "x86_64")]
    if wish == Instructions::Widest && std::arch::is_x86_feature_detected!("avx2") {
        return Instructions::Widest;
    }
    let _ = wish;
    Instructions::Portable
}

#[inline]
pub(super) fn next_contact<D: Detection>(
    state: &mut State,
    world: &World,
    detection: &D,
    stop: f64,
) -> Option<ContactEvent> {
    #[cfg(target_arch = "x86_64")]
    if state.instructions == Instructions::Widest {
        #[target_feature(enable = "avx2")]
        fn with_avx2<D: Detection>(
            state: &mut State,
            world: &World,
            detection: &D,
            stop: f64,
        ) -> Option<ContactEvent> {
            state.next_contact::<D, Avx2>(world, detection, stop)
        }
        // SAFETY: `available` gives `Widest` only where the processor reports AVX2.
        return unsafe { with_avx2(state, world, detection, stop) };
    }
    state.next_contact::<D, Portable>(world, detection, stop)
}

#[inline]
pub(super) fn motions_changed<D: Detection>(
    state: &mut State,
    world: &World,
    detection: &D,
    bodies: [u32; 2],
    motions: [Motion; 2],
) {
    #[cfg(target_arch = "x86_64")]
    if state.instructions == Instructions::Widest {
        #[target_feature(enable = "avx2")]
        fn with_avx2<D: Detection>(
            state: &mut State,
            world: &World,
            detection: &D,
            bodies: [u32; 2],
            motions: [Motion; 2],
        ) {
            state.motions_changed::<D, Avx2>(world, detection, bodies, motions);
        }
        // SAFETY: `available` gives `Widest` only where the processor reports AVX2.
        return unsafe { with_avx2(state, world, detection, bodies, motions) };
    }
    state.motions_changed::<D, Portable>(world, detection, bodies, motions);
}
