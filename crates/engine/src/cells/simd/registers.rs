//! Kernels in 256-bit registers: exact tests of four discs and filter tests of eight, with the
//! operations and their order as in [`Portable`](super::Portable), [`NeighbourQuery::lanes`] and
//! [`F32Filter::near`].

use std::arch::asm;
use std::arch::x86_64::{
    __m256d, _mm_cvtsd_f64, _mm_min_pd, _mm_unpackhi_pd, _mm256_add_pd, _mm256_add_ps,
    _mm256_and_si256, _mm256_castpd256_pd128, _mm256_castsi256_si128, _mm256_cvtepi32_pd,
    _mm256_extractf128_pd, _mm256_extracti128_si256, _mm256_lddqu_si256, _mm256_loadu_ps,
    _mm256_loadu_si256, _mm256_min_pd, _mm256_mul_pd, _mm256_mul_ps, _mm256_permute2f128_pd,
    _mm256_set1_epi32, _mm256_set1_pd, _mm256_set1_ps, _mm256_setr_pd, _mm256_slli_epi32,
    _mm256_sqrt_pd, _mm256_srai_epi32, _mm256_storeu_pd, _mm256_sub_epi32, _mm256_sub_pd,
    _mm256_sub_ps, _mm256_unpackhi_pd, _mm256_unpacklo_pd,
};

use carom_kinematics::HALF_ULP;

use super::{
    BodyRecord, CellBlock, DISC_LANES, DiscLanes, F32Filter, Flights, INDEX_BITS, INDEX_MASK,
    Kernel, KernelWork, NeighbourQuery, SoonestOfEight, SoonestSlot,
    instruction_sets::CompiledWith, masks::Masks,
};

/// Registers of 256 bits, with masks of one kind.
///
/// A value exists only where `M` has one, hence only on a processor that has the instructions.
#[derive(Clone, Copy)]
struct Registers<M>(M);

impl<M: Masks> Registers<M> {
    /// Registers on a processor that has the instructions, as `masks` proves.
    #[inline]
    fn new(masks: M) -> Self {
        Self(masks)
    }
}

/// A computation with a kernel, run in registers of 256 bits.
pub(super) struct InRegisters<W>(pub W);

impl<M: Masks, W: KernelWork> CompiledWith<M> for InRegisters<W> {
    type Output = W::Output;

    #[inline(always)]
    fn with(self, masks: M) -> W::Output {
        self.0.with(Registers::new(masks))
    }
}

/// The search of any list: with or without images, of one radius or of several, of any length.
struct ListSearch<'a, const IMAGES: bool>(&'a NeighbourQuery<'a>, &'a CellBlock<'a>);

impl<M: Masks, const IMAGES: bool> CompiledWith<M> for ListSearch<'_, IMAGES> {
    type Output = SoonestSlot;

    #[inline(always)]
    fn with(self, masks: M) -> SoonestSlot {
        SoonestSlot::new(self.1, |slots| {
            soonest_of_eight::<M, IMAGES>(masks, self.0, slots)
        })
    }
}

impl<M: Masks> Kernel for Registers<M> {
    #[inline(always)]
    fn soonest_of_eight<const IMAGES: bool>(
        self,
        query: NeighbourQuery<'_>,
        slots: &[u32; DISC_LANES],
    ) -> SoonestOfEight {
        soonest_of_eight::<M, IMAGES>(self.0, &query, slots)
    }

    #[inline(always)]
    fn soonest_of_list(self, query: &NeighbourQuery<'_>, list: &CellBlock<'_>) -> SoonestSlot {
        if list.at_border {
            self.0.run_apart(ListSearch::<true>(query, list))
        } else {
            self.0.run_apart(ListSearch::<false>(query, list))
        }
    }

    #[inline(always)]
    fn lanes(
        self,
        query: &NeighbourQuery<'_>,
        slots: &[u32; DISC_LANES],
        images: bool,
    ) -> DiscLanes {
        if images {
            lanes::<M, true>(self.0, query, slots)
        } else {
            lanes::<M, false>(self.0, query, slots)
        }
    }

    #[inline(always)]
    fn near(self, filter: &F32Filter, flights: &Flights) -> u32 {
        near(self.0, filter, flights)
    }

    #[inline(always)]
    fn write(self, flight: &mut [f64; 4], [x, y, vx, vy]: [f64; 4]) {
        // SAFETY: the token `self.0` proves AVX2 (see `Masks`), which is what both functions
        // enable.
        unsafe { store(flight, _mm256_setr_pd(x, y, vx, vy)) }
    }

    #[inline(always)]
    fn find(self, slots: &[u32; DISC_LANES], slot: u32) -> u32 {
        // SAFETY: the token `self.0` proves AVX2 (see `Masks`). The load reads 32 bytes, the size
        // of the array that the reference borrows; it needs no alignment.
        let (slots, slot) = unsafe {
            (
                _mm256_loadu_si256(slots.as_ptr().cast()),
                _mm256_set1_epi32(slot as i32),
            )
        };
        self.0.equal_whole(slots, slot)
    }
}

/// Stores a register with one instruction. The compiler would split the store of a register that
/// was just combined from two halves, and the next load of the whole register would fail
/// store-to-load forwarding.
#[target_feature(enable = "avx2")]
#[inline]
fn store(numbers: &mut [f64; 4], register: __m256d) {
    // SAFETY: the instruction writes 32 bytes at the address of `numbers`, the size of the array
    // that the reference borrows mutably, and needs no alignment. It changes no register, no flag,
    // no stack.
    unsafe {
        asm!("vmovupd [{}], {}", in(reg) numbers, in(ymm_reg) register, options(nostack, preserves_flags));
    }
}

/// The earliest contact with the discs in eight slots.
///
/// Always inlined, as are the functions that it calls: a call would write registers to memory and
/// read them back.
#[inline(always)]
pub(super) fn soonest_of_eight<M: Masks, const IMAGES: bool>(
    masks: M,
    query: &NeighbourQuery<'_>,
    slots: &[u32; DISC_LANES],
) -> SoonestOfEight {
    let [a, b, c, d, e, f, g, h] = records_of::<M, IMAGES>(masks, query, slots);
    let shifts = IMAGES.then(|| shifts(masks, query, slots));
    let low = Four::of_records(masks, query, [a, b, c, d], shifts.map(|[low, _]| low));
    let high = Four::of_records(masks, query, [e, f, g, h], shifts.map(|[_, high]| high));
    soonest_of(low, high)
}

/// The earliest contact of eight.
#[inline(always)]
fn soonest_of<M: Masks>(low: Four<M>, high: Four<M>) -> SoonestOfEight {
    let masks = low.masks;
    let in_contact = masks.is_any([low.in_contact(), high.in_contact()]);
    let (low, high) = (low.times(), high.times());
    // SAFETY: `masks` proves AVX2 (see `Masks`); the instructions touch no memory.
    let (time, spread) = unsafe {
        let least = _mm256_min_pd(low, high);
        let least = _mm_min_pd(
            _mm256_castpd256_pd128(least),
            _mm256_extractf128_pd::<1>(least),
        );
        let time = _mm_cvtsd_f64(_mm_min_pd(least, _mm_unpackhi_pd(least, least)));
        (time, _mm256_set1_pd(time))
    };
    SoonestOfEight {
        time,
        slots: masks.equal(low, spread) | masks.equal(high, spread) << 4,
        in_contact,
    }
}

/// Shifts of the discs in eight slots by their images (length), x and y of the first four and of
/// the last four: the vectorised [`image_of`](super::image_of), times the sides of the box.
#[inline(always)]
fn shifts<M: Masks>(
    _: M,
    query: &NeighbourQuery<'_>,
    slots: &[u32; DISC_LANES],
) -> [[__m256d; 2]; 2] {
    // SAFETY: the token proves AVX2 (see `Masks`). The load reads 32 bytes, the size of the array
    // that the reference borrows; it needs no alignment. Nothing else touches memory.
    unsafe {
        let slots = _mm256_loadu_si256(slots.as_ptr().cast());
        // Minus one where the bit at this distance from the highest is set.
        let up_x = _mm256_srai_epi32::<31>(_mm256_slli_epi32::<{ 31 - INDEX_BITS as i32 }>(slots));
        let down_x =
            _mm256_srai_epi32::<31>(_mm256_slli_epi32::<{ 30 - INDEX_BITS as i32 }>(slots));
        let up_y = _mm256_srai_epi32::<31>(_mm256_slli_epi32::<{ 29 - INDEX_BITS as i32 }>(slots));
        let down_y = _mm256_srai_epi32::<31>(slots);
        let images = [
            _mm256_sub_epi32(down_x, up_x),
            _mm256_sub_epi32(down_y, up_y),
        ];
        let shift = |axis: usize, boxes| {
            _mm256_mul_pd(_mm256_cvtepi32_pd(boxes), _mm256_set1_pd(query.sides[axis]))
        };
        let low = |axis: usize| shift(axis, _mm256_castsi256_si128(images[axis]));
        let high = |axis: usize| shift(axis, _mm256_extracti128_si256::<1>(images[axis]));
        [[low(0), low(1)], [high(0), high(1)]]
    }
}

/// Four numbers in a register.
#[inline(always)]
fn load<M: Masks>(_: M, row: &[f64; 4]) -> __m256d {
    // SAFETY: the token proves AVX2 (see `Masks`); the numbers are read by their indices, in safe
    // code.
    unsafe { _mm256_setr_pd(row[0], row[1], row[2], row[3]) }
}

/// Transposes the rows of four discs into registers of x, y, vx, vy.
#[inline(always)]
fn by_number<M: Masks>(_: M, [a, b, c, d]: [__m256d; 4]) -> [__m256d; 4] {
    // SAFETY: the token proves AVX2 (see `Masks`); the instructions touch no memory.
    unsafe {
        let (x_vx_ab, x_vx_cd) = (_mm256_unpacklo_pd(a, b), _mm256_unpacklo_pd(c, d));
        let (y_vy_ab, y_vy_cd) = (_mm256_unpackhi_pd(a, b), _mm256_unpackhi_pd(c, d));
        [
            _mm256_permute2f128_pd::<0x20>(x_vx_ab, x_vx_cd),
            _mm256_permute2f128_pd::<0x20>(y_vy_ab, y_vy_cd),
            _mm256_permute2f128_pd::<0x31>(x_vx_ab, x_vx_cd),
            _mm256_permute2f128_pd::<0x31>(y_vy_ab, y_vy_cd),
        ]
    }
}

/// The vectorised [`NeighbourQuery::lanes`], stored as whole registers, as they are loaded.
#[inline(always)]
fn lanes<M: Masks, const IMAGES: bool>(
    masks: M,
    query: &NeighbourQuery<'_>,
    slots: &[u32; DISC_LANES],
) -> DiscLanes {
    let mut lanes = DiscLanes::empty(query.separation_error, query.speed());
    let [a, b, c, d, e, f, g, h] = records_of::<M, IMAGES>(masks, query, slots);
    let shifts = IMAGES.then(|| shifts(masks, query, slots));
    write_lanes::<M, 0>(
        masks,
        query,
        [a, b, c, d],
        shifts.map(|[low, _]| low),
        &mut lanes,
    );
    write_lanes::<M, 4>(
        masks,
        query,
        [e, f, g, h],
        shifts.map(|[_, high]| high),
        &mut lanes,
    );
    lanes
}

/// Writes four bodies into the lanes from `FIRST` on.
#[inline(always)]
fn write_lanes<M: Masks, const FIRST: usize>(
    masks: M,
    query: &NeighbourQuery<'_>,
    [a, b, c, d]: [&BodyRecord; 4],
    shifts: Option<[__m256d; 2]>,
    lanes: &mut DiscLanes,
) {
    // SAFETY: `masks` proves AVX2 (see `Masks`). Each store writes 32 bytes at the start of a slice
    // of four `f64`, whose bounds the slicing has checked; it needs no alignment.
    unsafe {
        let from = load(masks, &query.from.flight);
        let reach = if let Some(pair_constants) = query.pair_constants {
            _mm256_set1_pd(pair_constants.sigma)
        } else {
            let radii = _mm256_setr_pd(a.radius(), b.radius(), c.radius(), d.radius());
            _mm256_add_pd(radii, _mm256_set1_pd(query.from.radius()))
        };
        let (a, b) = (
            _mm256_sub_pd(load(masks, &a.flight), from),
            _mm256_sub_pd(load(masks, &b.flight), from),
        );
        let (c, d) = (
            _mm256_sub_pd(load(masks, &c.flight), from),
            _mm256_sub_pd(load(masks, &d.flight), from),
        );
        let [x, y, vx, vy] = by_number(masks, [a, b, c, d]);
        let (mut x0, mut y0) = (x, y);
        if let Some([x, y]) = shifts {
            (x0, y0) = (_mm256_add_pd(x0, x), _mm256_add_pd(y0, y));
        }
        let now = _mm256_set1_pd(query.now);
        let dx = _mm256_add_pd(x0, _mm256_mul_pd(vx, now));
        let dy = _mm256_add_pd(y0, _mm256_mul_pd(vy, now));
        let across = _mm256_sub_pd(_mm256_mul_pd(x0, vy), _mm256_mul_pd(y0, vx));
        let DiscLanes {
            separation,
            velocity,
            cross,
            contact_distance,
            ..
        } = lanes;
        _mm256_storeu_pd(separation[0][FIRST..FIRST + 4].as_mut_ptr(), dx);
        _mm256_storeu_pd(separation[1][FIRST..FIRST + 4].as_mut_ptr(), dy);
        _mm256_storeu_pd(velocity[0][FIRST..FIRST + 4].as_mut_ptr(), vx);
        _mm256_storeu_pd(velocity[1][FIRST..FIRST + 4].as_mut_ptr(), vy);
        _mm256_storeu_pd(cross[FIRST..FIRST + 4].as_mut_ptr(), across);
        _mm256_storeu_pd(contact_distance[FIRST..FIRST + 4].as_mut_ptr(), reach);
    }
}

/// The vectorised [`F32Filter::near`].
#[inline(always)]
fn near<M: Masks>(masks: M, filter: &F32Filter, flights: &Flights) -> u32 {
    // SAFETY: `masks` proves AVX2 (see `Masks`). Each load reads 32 bytes, the size of the array of
    // eight `f32` that the reference borrows; it needs no alignment. Nothing else touches memory.
    unsafe {
        let [x, y, vx, vy] = flights;
        let (x, y) = (_mm256_loadu_ps(x.as_ptr()), _mm256_loadu_ps(y.as_ptr()));
        let (vx, vy) = (_mm256_loadu_ps(vx.as_ptr()), _mm256_loadu_ps(vy.as_ptr()));
        let now = _mm256_set1_ps(filter.now);
        let (x, y) = (
            _mm256_add_ps(x, _mm256_mul_ps(vx, now)),
            _mm256_add_ps(y, _mm256_mul_ps(vy, now)),
        );
        let dx = _mm256_sub_ps(_mm256_set1_ps(filter.place[0]), x);
        let dy = _mm256_sub_ps(_mm256_set1_ps(filter.place[1]), y);
        let vx = _mm256_sub_ps(_mm256_set1_ps(filter.velocity[0]), vx);
        let vy = _mm256_sub_ps(_mm256_set1_ps(filter.velocity[1]), vy);
        let b = _mm256_add_ps(_mm256_mul_ps(dx, vx), _mm256_mul_ps(dy, vy));
        let cross = _mm256_sub_ps(_mm256_mul_ps(dx, vy), _mm256_mul_ps(dy, vx));
        let v_squared = _mm256_add_ps(_mm256_mul_ps(vx, vx), _mm256_mul_ps(vy, vy));
        let reach_squared = _mm256_set1_ps(filter.reach_squared);
        let discriminant = _mm256_sub_ps(
            _mm256_mul_ps(reach_squared, v_squared),
            _mm256_mul_ps(cross, cross),
        );
        let least = _mm256_set1_ps(F32Filter::MIN_DISCRIMINANT);
        masks.below_and_at_least([b, _mm256_set1_ps(filter.receding)], [discriminant, least])
    }
}

/// The records of the bodies in eight slots; without `IMAGES` a slot is an index.
#[inline(always)]
fn records_of<'a, M: Masks, const IMAGES: bool>(
    masks: M,
    query: &NeighbourQuery<'a>,
    slots: &[u32; DISC_LANES],
) -> [&'a BodyRecord; DISC_LANES] {
    let records = query.records;
    // SAFETY: `masks` proves AVX2 (see `Masks`). The load reads 32 bytes, the size of the array
    // that the reference borrows; it needs no alignment. Nothing else touches memory.
    let (indices, count) = unsafe {
        // This instruction prevents the compiler from splitting the register into indices again: it
        // does not recognise that they are equal.
        let mut indices = _mm256_lddqu_si256(slots.as_ptr().cast());
        if IMAGES {
            indices = _mm256_and_si256(indices, _mm256_set1_epi32(INDEX_MASK as i32));
        }
        (indices, _mm256_set1_epi32(records.len() as i32))
    };
    assert!(
        masks.all_less(indices, count),
        "a slot holds a body that is not there"
    );
    slots.map(|slot| {
        let index = if IMAGES { slot & INDEX_MASK } else { slot };
        // SAFETY: the assertion above holds for this index, which is one of the eight in the
        // register: it is less than the number of records, or than its lowest 32 bits, which are no
        // greater.
        unsafe { records.get_unchecked(index as usize) }
    })
}

/// Four discs on their paths relative to the query disc.
#[derive(Clone, Copy)]
struct Four<M> {
    /// Proof of the instruction set.
    masks: M,
    /// d·v and d·d − σ², with d and v from the other disc to the query disc.
    b: __m256d,
    c: __m256d,
    /// σ² v² − (d₀ × v)², d₀ at the start of the epoch.
    discriminant: __m256d,
    /// A pair may touch already if its c is at most this.
    touching: __m256d,
}

impl<M: Masks> Four<M> {
    /// Four bodies from their records, in images that shift them by `shifts` (length).
    #[inline(always)]
    fn of_records(
        masks: M,
        query: &NeighbourQuery<'_>,
        [a, b, c, d]: [&BodyRecord; 4],
        shifts: Option<[__m256d; 2]>,
    ) -> Self {
        // SAFETY: `masks` proves AVX2 (see `Masks`); the instructions touch no memory.
        unsafe {
            let (sigma_squared, touching) = if let Some(pair_constants) = query.pair_constants {
                (
                    _mm256_set1_pd(pair_constants.sigma_squared),
                    _mm256_set1_pd(pair_constants.touching),
                )
            } else {
                let radii = _mm256_setr_pd(a.radius(), b.radius(), c.radius(), d.radius());
                let sigma = _mm256_add_pd(radii, _mm256_set1_pd(query.from.radius()));
                // 4 σ (error + 8 u σ), multiplied in the order of `PairConstants::at`.
                let error = _mm256_set1_pd(query.separation_error);
                let error =
                    _mm256_add_pd(error, _mm256_mul_pd(_mm256_set1_pd(8.0 * HALF_ULP), sigma));
                let touching = _mm256_mul_pd(_mm256_mul_pd(_mm256_set1_pd(4.0), sigma), error);
                (_mm256_mul_pd(sigma, sigma), touching)
            };
            let from = load(masks, &query.from.flight);
            // From the other disc to the query disc: this sign needs one instruction. The sums and
            // products below have the same bits for either sign.
            let (a, b) = (
                _mm256_sub_pd(from, load(masks, &a.flight)),
                _mm256_sub_pd(from, load(masks, &b.flight)),
            );
            let (c, d) = (
                _mm256_sub_pd(from, load(masks, &c.flight)),
                _mm256_sub_pd(from, load(masks, &d.flight)),
            );
            let [origin_x, origin_y, vx, vy] = by_number(masks, [a, b, c, d]);
            let (mut x0, mut y0) = (origin_x, origin_y);
            if let Some([x, y]) = shifts {
                (x0, y0) = (_mm256_sub_pd(x0, x), _mm256_sub_pd(y0, y));
            }
            let now = _mm256_set1_pd(query.now);
            let dx = _mm256_add_pd(x0, _mm256_mul_pd(vx, now));
            let dy = _mm256_add_pd(y0, _mm256_mul_pd(vy, now));
            Self::from_slots(masks, [x0, y0], [dx, dy], [vx, vy], sigma_squared, touching)
        }
    }

    /// Four discs from their separations at the start of the epoch and now, and their velocities.
    #[inline(always)]
    fn from_slots(
        masks: M,
        [x0, y0]: [__m256d; 2],
        [dx, dy]: [__m256d; 2],
        [vx, vy]: [__m256d; 2],
        sigma_squared: __m256d,
        touching: __m256d,
    ) -> Self {
        // SAFETY: `masks` proves AVX2 (see `Masks`); the instructions touch no memory.
        unsafe {
            let b = _mm256_add_pd(_mm256_mul_pd(dx, vx), _mm256_mul_pd(dy, vy));
            let d_squared = _mm256_add_pd(_mm256_mul_pd(dx, dx), _mm256_mul_pd(dy, dy));
            let c = _mm256_sub_pd(d_squared, sigma_squared);
            let cross = _mm256_sub_pd(_mm256_mul_pd(x0, vy), _mm256_mul_pd(y0, vx));
            let v_squared = _mm256_add_pd(_mm256_mul_pd(vx, vx), _mm256_mul_pd(vy, vy));
            let discriminant = _mm256_sub_pd(
                _mm256_mul_pd(sigma_squared, v_squared),
                _mm256_mul_pd(cross, cross),
            );
            Self {
                masks,
                b,
                c,
                discriminant,
                touching,
            }
        }
    }

    /// Selects discs that come to a contact.
    #[inline(always)]
    fn closes(self) -> M::Mask {
        self.masks
            .above_zero(self.masks.not_above_zero(self.b), self.discriminant)
    }

    /// Times of contact, infinite for none.
    #[inline(always)]
    fn times(self) -> __m256d {
        // SAFETY: `masks` proves AVX2 (see `Masks`); the instructions touch no memory.
        let divisors = unsafe {
            // NaN where there is no real root; the mask excludes these lanes.
            let root = _mm256_sqrt_pd(self.discriminant);
            _mm256_sub_pd(root, self.b)
        };
        self.masks.quotients(self.closes(), self.c, divisors)
    }

    /// Selects pairs that touch to rounding and do not separate; the detector must decide them.
    #[inline(always)]
    fn in_contact(self) -> M::Mask {
        self.masks
            .within(self.masks.not_above_zero(self.b), self.c, self.touching)
    }
}
