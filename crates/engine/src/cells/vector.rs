//! The hot loop compiled twice: for every processor of this kind, and with AVX2 where there is AVX2.
//!
//! The one place of the project with unsafe code: calling functions that were compiled with instructions which the
//! compiler does not take for granted, after having asked the processor for them, and one store of a register. Neither
//! version fuses a multiplication and an addition, and both do the same operations in the same order, so both compute
//! the same bits.

#![allow(unsafe_code, reason = "calls into the AVX2 build of the loop; see the module's documentation")]

use carom_detection::{DISC_LANES, Detection, DiscLanes};
use carom_kinematics::Motion;

use super::{Instructions, State, line::Line};
use crate::{ContactEvent, World};

/// One disc's question to eight others: when is the first of them touched?
pub(super) struct Question<'a> {
    /// The eight, where they lie: copied one by one, they could not be read as registers at once.
    pub others: [&'a Line; DISC_LANES],
    /// Flight and radius of the asking disc.
    pub from: &'a [f64; 4],
    pub radius: f64,
    pub now: f64,
    /// Bound on the rounding of a separation (length).
    pub separation_error: f64,
}

/// The answer.
pub(super) struct Soonest {
    /// From now on, infinite for never.
    pub time: f64,
    /// Which of the eight are touched then, a bit each.
    pub lanes: u32,
    /// Some pair touches to rounding, or overlaps, while it seems to close: the question needs a closer look.
    pub in_contact: bool,
}

/// How the question is answered: with which instructions. The numbers are the same.
pub(super) trait Kernel {
    fn soonest(question: &Question<'_>) -> Soonest;

    /// Writes a flight the way [`Self::soonest`] reads it: numbers written one by one cannot be read as one register until
    /// they have reached the cache, and the flight is read again at once.
    fn write(flight: &mut [f64; 4], numbers: [f64; 4]);
}

impl Question<'_> {
    /// The eight as seen from the asking disc.
    pub fn lanes(&self) -> DiscLanes {
        let mut lanes = DiscLanes {
            separation: [[0.0; DISC_LANES]; 2],
            velocity: [[0.0; DISC_LANES]; 2],
            contact_distance: [0.0; DISC_LANES],
            separation_error: self.separation_error,
            speed: self.from[2].abs() + self.from[3].abs(),
        };
        for (lane, other) in self.others.iter().enumerate() {
            for axis in 0..2 {
                let velocity = other.flight[axis + 2] - self.from[axis + 2];
                lanes.velocity[axis][lane] = velocity;
                lanes.separation[axis][lane] = (other.flight[axis] - self.from[axis]) + velocity * self.now;
            }
            lanes.contact_distance[lane] = other.radius + self.radius;
        }
        lanes
    }
}

impl Soonest {
    /// The soonest of eight times.
    pub fn of(times: &[f64; DISC_LANES]) -> Self {
        let least = |a: f64, b: f64| if b < a { b } else { a };
        let time = times.iter().copied().fold(f64::INFINITY, least);
        let mut lanes = 0;
        for (lane, &other) in times.iter().enumerate() {
            lanes |= u32::from(other == time) << lane;
        }
        Self { time, lanes, in_contact: false }
    }
}

/// As the compiler sees fit, for every processor.
pub(super) struct Portable;

impl Kernel for Portable {
    #[inline]
    fn soonest(question: &Question<'_>) -> Soonest {
        let (times, in_contact) = question.lanes().closed_form();
        Soonest { in_contact, ..Soonest::of(&times) }
    }

    #[inline]
    fn write(flight: &mut [f64; 4], numbers: [f64; 4]) {
        *flight = numbers;
    }
}

/// Four numbers at a time. To be used in code compiled for AVX2 only.
#[cfg(target_arch = "x86_64")]
struct Avx2;

#[cfg(target_arch = "x86_64")]
impl Kernel for Avx2 {
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled with the instructions of its caller")]
    fn soonest(question: &Question<'_>) -> Soonest {
        // SAFETY: `Avx2` is named only in the functions below that are compiled for AVX2 and called where it is there.
        unsafe { avx2::soonest(question) }
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled with the instructions of its caller")]
    fn write(flight: &mut [f64; 4], numbers: [f64; 4]) {
        // SAFETY: as above.
        unsafe { avx2::write(flight, numbers) }
    }
}

/// The closed form of [`DiscLanes::closed_form`] in registers of four, operation by operation.
#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::{
        __m256d, _CMP_EQ_OQ, _CMP_GT_OQ, _CMP_LE_OQ, _CMP_LT_OQ, _mm_cvtsd_f64, _mm_min_pd, _mm_unpackhi_pd,
        _mm256_add_pd, _mm256_and_pd, _mm256_blendv_pd, _mm256_castpd256_pd128, _mm256_cmp_pd, _mm256_div_pd,
        _mm256_extractf128_pd, _mm256_min_pd, _mm256_movemask_pd, _mm256_mul_pd, _mm256_or_pd,
        _mm256_permute2f128_pd, _mm256_set1_pd, _mm256_setr_pd, _mm256_setzero_pd, _mm256_sqrt_pd,
        _mm256_storeu_pd, _mm256_sub_pd, _mm256_unpackhi_pd, _mm256_unpacklo_pd,
    };

    use super::{Line, Question, Soonest};
    use carom_kinematics::HALF_ULP;

    #[target_feature(enable = "avx2")]
    #[inline]
    pub(super) fn soonest(question: &Question<'_>) -> Soonest {
        let [a, b, c, d, e, f, g, h] = question.others;
        let (low, low_contact) = four(question, [a, b, c, d]);
        let (high, high_contact) = four(question, [e, f, g, h]);
        let least = _mm256_min_pd(low, high);
        let least = _mm_min_pd(_mm256_castpd256_pd128(least), _mm256_extractf128_pd::<1>(least));
        let time = _mm_cvtsd_f64(_mm_min_pd(least, _mm_unpackhi_pd(least, least)));
        let spread = _mm256_set1_pd(time);
        let equal = |times| _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_EQ_OQ>(times, spread)) as u32;
        Soonest {
            time,
            lanes: equal(low) | equal(high) << 4,
            in_contact: _mm256_movemask_pd(_mm256_or_pd(low_contact, high_contact)) != 0,
        }
    }

    #[target_feature(enable = "avx2")]
    #[inline]
    pub(super) fn write(flight: &mut [f64; 4], [x, y, vx, vy]: [f64; 4]) {
        let register = _mm256_setr_pd(x, y, vx, vy);
        // SAFETY: `flight` is four floats that may be written, wherever they are.
        unsafe { _mm256_storeu_pd(flight.as_mut_ptr(), register) }
    }

    /// Times of contact of four discs, and a mask of those that need a closer look.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn four(question: &Question<'_>, lines: [&Line; 4]) -> (__m256d, __m256d) {
        let load = |row: &[f64; 4]| _mm256_setr_pd(row[0], row[1], row[2], row[3]);
        let [a, b, c, d] = lines;
        let radii = _mm256_setr_pd(a.radius, b.radius, c.radius, d.radius);
        let from = load(question.from);
        let (a, b) = (_mm256_sub_pd(load(&a.flight), from), _mm256_sub_pd(load(&b.flight), from));
        let (c, d) = (_mm256_sub_pd(load(&c.flight), from), _mm256_sub_pd(load(&d.flight), from));
        // From a row for each disc to a register for each of x, y, vx, vy.
        let (x_vx_ab, x_vx_cd) = (_mm256_unpacklo_pd(a, b), _mm256_unpacklo_pd(c, d));
        let (y_vy_ab, y_vy_cd) = (_mm256_unpackhi_pd(a, b), _mm256_unpackhi_pd(c, d));
        let vx = _mm256_permute2f128_pd::<0x31>(x_vx_ab, x_vx_cd);
        let vy = _mm256_permute2f128_pd::<0x31>(y_vy_ab, y_vy_cd);
        let now = _mm256_set1_pd(question.now);
        let origin_x = _mm256_permute2f128_pd::<0x20>(x_vx_ab, x_vx_cd);
        let origin_y = _mm256_permute2f128_pd::<0x20>(y_vy_ab, y_vy_cd);
        let dx = _mm256_add_pd(origin_x, _mm256_mul_pd(vx, now));
        let dy = _mm256_add_pd(origin_y, _mm256_mul_pd(vy, now));
        let sigma = _mm256_add_pd(radii, _mm256_set1_pd(question.radius));
        let sigma_squared = _mm256_mul_pd(sigma, sigma);
        let b = _mm256_add_pd(_mm256_mul_pd(dx, vx), _mm256_mul_pd(dy, vy));
        let d_squared = _mm256_add_pd(_mm256_mul_pd(dx, dx), _mm256_mul_pd(dy, dy));
        let c = _mm256_sub_pd(d_squared, sigma_squared);
        let cross = _mm256_sub_pd(_mm256_mul_pd(dx, vy), _mm256_mul_pd(dy, vx));
        let v_squared = _mm256_add_pd(_mm256_mul_pd(vx, vx), _mm256_mul_pd(vy, vy));
        let discriminant =
            _mm256_sub_pd(_mm256_mul_pd(sigma_squared, v_squared), _mm256_mul_pd(cross, cross));
        let zero = _mm256_setzero_pd();
        let real = _mm256_cmp_pd::<_CMP_GT_OQ>(discriminant, zero);
        let root = _mm256_sqrt_pd(_mm256_and_pd(discriminant, real));
        let closes = _mm256_and_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(b, zero), real);
        let time = _mm256_div_pd(c, _mm256_sub_pd(root, b));
        let time = _mm256_blendv_pd(_mm256_set1_pd(f64::INFINITY), time, closes);
        // 4 σ (error + 8 u σ), multiplied in the same order.
        let error = _mm256_set1_pd(question.separation_error);
        let error = _mm256_add_pd(error, _mm256_mul_pd(_mm256_set1_pd(8.0 * HALF_ULP), sigma));
        let touching = _mm256_mul_pd(_mm256_mul_pd(_mm256_set1_pd(4.0), sigma), error);
        let in_contact = _mm256_and_pd(closes, _mm256_cmp_pd::<_CMP_LE_OQ>(c, touching));
        (time, in_contact)
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
