//! Masks that select some of several numbers: in registers as wide as the numbers (AVX2), or in one
//! bit for each (AVX-512).

use std::arch::x86_64::{
    __m256, __m256d, __m256i, __mmask8, _CMP_EQ_OQ, _CMP_GE_OQ, _CMP_GT_OQ, _CMP_LE_OQ, _CMP_LT_OQ,
    _mm256_and_pd, _mm256_and_ps, _mm256_andnot_pd, _mm256_blendv_pd, _mm256_castsi256_ps,
    _mm256_cmp_pd, _mm256_cmp_pd_mask, _mm256_cmp_ps, _mm256_cmp_ps_mask, _mm256_cmpeq_epi32,
    _mm256_cmpeq_epi32_mask, _mm256_cmpge_epu32_mask, _mm256_div_pd, _mm256_mask_cmp_pd_mask,
    _mm256_mask_cmp_ps_mask, _mm256_mask_div_pd, _mm256_max_epu32, _mm256_movemask_pd,
    _mm256_movemask_ps, _mm256_or_pd, _mm256_set1_pd, _mm256_setzero_pd, _mm256_testz_si256,
};

use super::instruction_sets::{Avx2, Avx512, InstructionSet};

/// A representation of masks, and the operations on it.
///
/// Every function is marked `#[inline(always)]`, so that it is compiled with the instructions of
/// its caller and its values stay in registers.
///
/// # Safety
/// A value of an implementing type must exist only on processors that have AVX2: `Registers`
/// takes any value for the proof of it.
pub(in crate::cells) unsafe trait Masks: InstructionSet {
    /// A mask of four numbers.
    type Mask: Copy;

    /// Selects numbers that are not above zero.
    fn not_above_zero(self, numbers: __m256d) -> Self::Mask;

    /// Of the selected numbers, selects those above zero.
    fn above_zero(self, mask: Self::Mask, numbers: __m256d) -> Self::Mask;

    /// Of the selected numbers, selects those whose magnitude is at most a bound.
    fn within(self, mask: Self::Mask, numbers: __m256d, most: __m256d) -> Self::Mask;

    /// Whether one of the masks selects a number.
    fn is_any(self, mask: [Self::Mask; 2]) -> bool;

    /// Quotients of the selected numbers, infinity for the others.
    fn quotients(self, mask: Self::Mask, dividends: __m256d, divisors: __m256d) -> __m256d;

    /// Which of four numbers are equal, a bit each.
    fn equal(self, numbers: __m256d, others: __m256d) -> u32;

    /// Which of eight integers are equal, a bit each.
    fn equal_whole(self, numbers: __m256i, others: __m256i) -> u32;

    /// Whether each of eight integers is less than its counterpart.
    fn all_less(self, numbers: __m256i, others: __m256i) -> bool;

    /// Which of eight numbers are below a bound while their counterparts are at least another
    /// bound, a bit each.
    fn below_and_at_least(self, below: [__m256; 2], at_least: [__m256; 2]) -> u32;
}

// SAFETY: only `Avx2::detect` makes an `Avx2`, after it has found AVX2.
unsafe impl Masks for Avx2 {
    /// All bits of a number's lane, or none.
    type Mask = __m256d;

    #[inline(always)]
    fn not_above_zero(self, numbers: __m256d) -> __m256d {
        // SAFETY: `self` proves that this processor has AVX2; the instructions touch no memory.
        unsafe { _mm256_cmp_pd::<_CMP_LE_OQ>(numbers, _mm256_setzero_pd()) }
    }

    #[inline(always)]
    fn above_zero(self, mask: __m256d, numbers: __m256d) -> __m256d {
        // SAFETY: `self` proves that this processor has AVX2; the instructions touch no memory.
        unsafe {
            _mm256_and_pd(
                mask,
                _mm256_cmp_pd::<_CMP_GT_OQ>(numbers, _mm256_setzero_pd()),
            )
        }
    }

    #[inline(always)]
    fn within(self, mask: __m256d, numbers: __m256d, most: __m256d) -> __m256d {
        // SAFETY: `self` proves that this processor has AVX2; the instructions touch no memory.
        unsafe {
            let magnitudes = _mm256_andnot_pd(_mm256_set1_pd(-0.0), numbers);
            _mm256_and_pd(mask, _mm256_cmp_pd::<_CMP_LE_OQ>(magnitudes, most))
        }
    }

    #[inline(always)]
    fn is_any(self, [mask, others]: [__m256d; 2]) -> bool {
        // SAFETY: `self` proves that this processor has AVX2; the instructions touch no memory.
        unsafe { _mm256_movemask_pd(_mm256_or_pd(mask, others)) != 0 }
    }

    #[inline(always)]
    fn quotients(self, mask: __m256d, dividends: __m256d, divisors: __m256d) -> __m256d {
        // SAFETY: `self` proves that this processor has AVX2; the instructions touch no memory.
        unsafe {
            let quotients = _mm256_div_pd(dividends, divisors);
            _mm256_blendv_pd(_mm256_set1_pd(f64::INFINITY), quotients, mask)
        }
    }

    #[inline(always)]
    fn equal(self, numbers: __m256d, others: __m256d) -> u32 {
        // SAFETY: `self` proves that this processor has AVX2; the instructions touch no memory.
        unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_EQ_OQ>(numbers, others)) as u32 }
    }

    #[inline(always)]
    fn equal_whole(self, numbers: __m256i, others: __m256i) -> u32 {
        // SAFETY: `self` proves that this processor has AVX2; the instructions touch no memory.
        unsafe {
            _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(numbers, others))) as u32
        }
    }

    #[inline(always)]
    fn all_less(self, numbers: __m256i, others: __m256i) -> bool {
        // SAFETY: `self` proves that this processor has AVX2; the instructions touch no memory.
        unsafe {
            // The maximum equals the first number exactly where this is not less.
            let not_less = _mm256_cmpeq_epi32(_mm256_max_epu32(numbers, others), numbers);
            _mm256_testz_si256(not_less, not_less) == 1
        }
    }

    #[inline(always)]
    fn below_and_at_least(self, [here, bound]: [__m256; 2], [there, least]: [__m256; 2]) -> u32 {
        // SAFETY: `self` proves that this processor has AVX2; the instructions touch no memory.
        unsafe {
            let below = _mm256_cmp_ps::<_CMP_LT_OQ>(here, bound);
            _mm256_movemask_ps(_mm256_and_ps(
                below,
                _mm256_cmp_ps::<_CMP_GE_OQ>(there, least),
            )) as u32
        }
    }
}

// SAFETY: only `Avx512::detect` makes an `Avx512`, after it has found AVX2.
unsafe impl Masks for Avx512 {
    /// A bit for each number of a 256-bit register.
    type Mask = __mmask8;

    #[inline(always)]
    fn not_above_zero(self, numbers: __m256d) -> __mmask8 {
        // SAFETY: `self` proves that this processor has AVX-512; the instructions touch no memory.
        unsafe { _mm256_cmp_pd_mask::<_CMP_LE_OQ>(numbers, _mm256_setzero_pd()) }
    }

    #[inline(always)]
    fn above_zero(self, mask: __mmask8, numbers: __m256d) -> __mmask8 {
        // SAFETY: `self` proves that this processor has AVX-512; the instructions touch no memory.
        unsafe { _mm256_mask_cmp_pd_mask::<_CMP_GT_OQ>(mask, numbers, _mm256_setzero_pd()) }
    }

    #[inline(always)]
    fn within(self, mask: __mmask8, numbers: __m256d, most: __m256d) -> __mmask8 {
        // SAFETY: `self` proves that this processor has AVX-512; the instructions touch no memory.
        unsafe {
            let magnitudes = _mm256_andnot_pd(_mm256_set1_pd(-0.0), numbers);
            _mm256_mask_cmp_pd_mask::<_CMP_LE_OQ>(mask, magnitudes, most)
        }
    }

    #[inline(always)]
    fn is_any(self, [mask, others]: [__mmask8; 2]) -> bool {
        mask | others != 0
    }

    #[inline(always)]
    fn quotients(self, mask: __mmask8, dividends: __m256d, divisors: __m256d) -> __m256d {
        // SAFETY: `self` proves that this processor has AVX-512; the instructions touch no memory.
        unsafe { _mm256_mask_div_pd(_mm256_set1_pd(f64::INFINITY), mask, dividends, divisors) }
    }

    #[inline(always)]
    fn equal(self, numbers: __m256d, others: __m256d) -> u32 {
        // SAFETY: `self` proves that this processor has AVX-512; the instructions touch no memory.
        unsafe { u32::from(_mm256_cmp_pd_mask::<_CMP_EQ_OQ>(numbers, others)) }
    }

    #[inline(always)]
    fn equal_whole(self, numbers: __m256i, others: __m256i) -> u32 {
        // SAFETY: `self` proves that this processor has AVX-512; the instructions touch no memory.
        unsafe { u32::from(_mm256_cmpeq_epi32_mask(numbers, others)) }
    }

    #[inline(always)]
    fn all_less(self, numbers: __m256i, others: __m256i) -> bool {
        // SAFETY: `self` proves that this processor has AVX-512; the instructions touch no memory.
        unsafe { _mm256_cmpge_epu32_mask(numbers, others) == 0 }
    }

    #[inline(always)]
    fn below_and_at_least(self, [here, bound]: [__m256; 2], [there, least]: [__m256; 2]) -> u32 {
        // SAFETY: `self` proves that this processor has AVX-512; the instructions touch no memory.
        unsafe {
            let below = _mm256_cmp_ps_mask::<_CMP_LT_OQ>(here, bound);
            u32::from(_mm256_mask_cmp_ps_mask::<_CMP_GE_OQ>(below, there, least))
        }
    }
}
