//! SIMD kernels: the event loop compiled for every processor of this architecture, for AVX2, and
//! for AVX-512 with its masks and additional registers.
//!
//! No kernel fuses a multiplication and an addition, and all do the same operations in the same
//! order, so all compute the same bits.
//!
//! AVX-512 is used with registers of four `f64`: registers of eight were 3% to 5% slower.
//!
//! Flights and lanes are stored as whole registers, and the cell of a body as one word. A load that
//! spans several narrower stores fails store-to-load forwarding: it waits until all of them have
//! reached the cache.
//!
//! # Lemmas
//!
//! The kernels compute the times of [`DiscLanes::closed_form`].
//!
//! 1. **Any separation gives the distance of passage.** Two discs pass each other at the distance
//!    |d × v| / |v|, whichever separation d along their straight paths is used. The kernels use
//!    that at the start of the epoch. The square root, which ends the longest dependency chain,
//!    then does not wait for the present separation, which saves 2% of the time of a collision.
//! 2. **Its rounding is within the bound on the rounding of a separation.** This bound is u 16 s
//!    (Sx + Sy) for a body that moves s ≥ 1 sides of lengths Sx, Sy in an epoch. *Proof.* The
//!    separation at the start of the epoch is at most 2 s sides long, and one more by its image.
//!    The two subtractions, those of the velocities, the products and their difference therefore
//!    round by at most u (10 s + 4) (Sx + Sy) together.
//!
//! # Unsafe code
//!
//! This folder is the only place of the program with unsafe code. Safe code cannot misuse it:
//!
//! 1. *Instructions that not every processor has.* A kernel is a value. That of a SIMD kernel
//!    contains a token that only feature detection makes (`instruction_sets.rs`), and every call of
//!    a function with `#[target_feature]` is justified by such a token.
//! 2. *Records read without a check of each index.* One vector comparison checks eight indices
//!    against the number of records, and a slot out of range panics (`registers::records_of`).
//! 3. *Loads and stores of whole registers.* Each goes through a reference to an array, or a slice
//!    of checked length, of the size of the register. The store of a flight is in assembly.
//! 4. *Prefetch.* It reads nothing that the program sees, and never faults.
//!
//! Debug assertions, which tests are built with, check each unchecked access once more.
//! `.ci/memory` runs the tests of all kernels under AddressSanitizer and valgrind.

#![allow(
    unsafe_code,
    reason = "calls into the builds of the loop for vectors; see the module's documentation"
)]

#[cfg(target_arch = "x86_64")]
mod instruction_sets;
#[cfg(target_arch = "x86_64")]
mod masks;
#[cfg(target_arch = "x86_64")]
mod registers;

use carom_detection::{DISC_LANES, Detection, DiscLanes};
use carom_kinematics::HALF_ULP;
use glam::DVec2;
use wide::f64x2;

#[cfg(target_arch = "x86_64")]
use self::{
    instruction_sets::{Avx2, Avx512, InstructionSet},
    registers::InRegisters,
};
#[cfg(any(test, target_arch = "x86_64"))]
use super::slot::INDEX_BITS;
use super::{
    body_record::BodyRecord,
    cell_block::CellBlock,
    f32_filter::{F32Filter, Flights},
    slot::{INDEX_MASK, image_of},
};

/// A query: when does a disc touch the first of some neighbours?
#[derive(Debug, Clone, Copy)]
pub(super) struct NeighbourQuery<'a> {
    /// All bodies.
    pub records: &'a [BodyRecord],
    /// The query disc.
    pub from: &'a BodyRecord,
    pub now: f64,
    /// Bound on the rounding of a separation (length).
    pub separation_error: f64,
    /// Sides of the box, multiples of which shift an image (length).
    pub sides: [f64; 2],
    /// Constants of a pair of small discs, if all have one radius.
    pub pair_constants: Option<PairConstants>,
}

/// Constants of pairs of discs with one contact distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PairConstants {
    /// The contact distance (length).
    sigma: f64,
    sigma_squared: f64,
    /// A pair may touch already if its squared distance exceeds `sigma_squared` by at most this
    /// (length²).
    touching: f64,
}

impl PairConstants {
    /// Constants for discs of this radius, with this bound on the rounding of a separation (both
    /// lengths).
    pub fn new(radius: f64, separation_error: f64) -> Self {
        Self::at(radius + radius, separation_error)
    }

    /// Constants for discs with this contact distance (length).
    #[inline]
    pub fn at(sigma: f64, separation_error: f64) -> Self {
        let touching = 4.0 * sigma * (separation_error + 8.0 * HALF_ULP * sigma);
        Self {
            sigma,
            sigma_squared: sigma * sigma,
            touching,
        }
    }
}

/// The earliest contact with eight discs.
#[derive(Debug, Clone, Copy)]
pub(super) struct SoonestOfEight {
    /// Time from now, infinite for none.
    pub time: f64,
    /// The discs touched at this time, a bit each.
    pub slots: u32,
    /// Whether some pair touches to rounding and does not separate; the detector must then decide.
    pub in_contact: bool,
}

/// The earliest contact with the discs of a list.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SoonestSlot {
    /// Time from now, infinite for none.
    pub time: f64,
    /// The slot of the disc that is touched; any slot if there is no contact.
    pub slot: u32,
    /// Whether the detector must decide the contact.
    pub is_ambiguous: bool,
}

/// Computes contact times with one instruction set. All kernels return the same bits; the module
/// documentation has the method and its rounding.
///
/// A kernel is a value, not only a type: the value of a SIMD kernel proves that this processor has
/// the instructions, so every function is safe to call.
pub(super) trait Kernel: Copy {
    /// The earliest contact with the discs in eight slots. Without `IMAGES` the slots must have no
    /// image.
    fn soonest_of_eight<const IMAGES: bool>(
        self,
        query: NeighbourQuery<'_>,
        slots: &[u32; DISC_LANES],
    ) -> SoonestOfEight;

    /// The earliest contact with the discs of any list.
    fn soonest_of_list(self, query: &NeighbourQuery<'_>, list: &CellBlock<'_>) -> SoonestSlot;

    /// [`NeighbourQuery::lanes`] of eight slots.
    fn lanes(
        self,
        query: &NeighbourQuery<'_>,
        slots: &[u32; DISC_LANES],
        images: bool,
    ) -> DiscLanes;

    /// Which of eight discs pass the filter, a bit each.
    fn near(self, filter: &F32Filter, flights: &Flights) -> u32;

    /// Stores a flight as one register. It is loaded as one register right afterwards, and separate
    /// stores of its numbers would fail store-to-load forwarding.
    fn write(self, flight: &mut [f64; 4], numbers: [f64; 4]);

    /// The slots that hold `slot`, a bit each.
    fn find(self, slots: &[u32; DISC_LANES], slot: u32) -> u32;
}

impl NeighbourQuery<'_> {
    /// |vx| + |vy| of the query disc (length per time).
    #[inline]
    fn speed(&self) -> f64 {
        self.from.flight[2].abs() + self.from.flight[3].abs()
    }

    /// The discs in some slots, relative to the query disc.
    #[inline]
    pub fn lanes<const N: usize>(&self, slots: &[u32; N], images: bool) -> DiscLanes<N> {
        let mut lanes = DiscLanes {
            separation: [[0.0; N]; 2],
            velocity: [[0.0; N]; 2],
            cross: [0.0; N],
            contact_distance: [0.0; N],
            separation_error: self.separation_error,
            speed: self.speed(),
        };
        for (lane, &slot) in slots.iter().enumerate() {
            let other = &self.records[(slot & INDEX_MASK) as usize];
            let mut start = other.origin() - self.from.origin();
            if images {
                start += DVec2::from_array(image_of(slot).map(f64::from))
                    * DVec2::from_array(self.sides);
            }
            let sigma = self
                .pair_constants
                .map_or(other.radius() + self.from.radius(), |pair_constants| {
                    pair_constants.sigma
                });
            lanes.set_since(
                lane,
                start,
                other.velocity() - self.from.velocity(),
                self.now,
                sigma,
            );
        }
        lanes
    }

    /// The earliest contact with the discs in eight slots as the detector finds it: time from now
    /// (infinite for none) and partner. Of contacts at one time it is that with the disc inserted
    /// first.
    #[cold]
    #[inline(never)]
    pub fn resolve_with_detector<D: Detection>(
        &self,
        detection: &D,
        slots: &[u32; DISC_LANES],
        images: bool,
    ) -> (f64, u32) {
        let times = detection.disc_contacts(&self.lanes(slots, images));
        let contacts = slots
            .iter()
            .zip(times)
            .map(|(&slot, time)| (time, slot & INDEX_MASK));
        contacts.fold((f64::INFINITY, 0), sooner)
    }
}

/// Of two contacts (time, partner) the earlier; of two at one time that with the disc inserted
/// first.
#[inline(always)]
pub(super) fn sooner(one: (f64, u32), other: (f64, u32)) -> (f64, u32) {
    if goes_before(other, one) { other } else { one }
}

/// Whether a contact precedes another, in the order of [`sooner`].
#[inline(always)]
pub(super) fn goes_before((time, with): (f64, u32), (other_time, with_other): (f64, u32)) -> bool {
    (time < other_time) | ((time == other_time) & (with < with_other) & (time < f64::INFINITY))
}

impl SoonestOfEight {
    /// Whether the detector must decide: several discs are touched at one time, or a pair may touch
    /// or overlap already. A negative time indicates a deep overlap. An infinite time is no
    /// contact.
    #[inline(always)]
    fn is_ambiguous(&self) -> bool {
        let several = self.slots & (self.slots.wrapping_sub(1)) != 0;
        (several & (self.time < f64::INFINITY)) | self.in_contact | (self.time < 0.0)
    }

    /// The disc that is touched, of those in the slots of the query.
    #[inline(always)]
    pub fn in_slots(self, slots: &[u32; DISC_LANES]) -> SoonestSlot {
        let lowest = self.slots.trailing_zeros() as usize % DISC_LANES;
        SoonestSlot {
            time: self.time,
            slot: slots[lowest],
            is_ambiguous: self.is_ambiguous(),
        }
    }
}

impl SoonestSlot {
    /// No contact.
    pub const NONE: Self = Self {
        time: f64::INFINITY,
        slot: 0,
        is_ambiguous: false,
    };

    /// The earliest contact with the discs of a list, from that with eight of them at a time.
    #[inline(always)]
    fn new(list: &CellBlock<'_>, test: impl Fn(&[u32; DISC_LANES]) -> SoonestOfEight) -> Self {
        let mut soonest = Self::NONE;
        list.for_each_slots8(|slots| soonest = soonest.or(test(slots).in_slots(slots)));
        soonest
    }

    /// The earlier contact; ambiguous if both are at one time.
    #[inline(always)]
    pub fn or(self, other: Self) -> Self {
        let is_later = other.time > self.time;
        let several = (other.time == self.time) & (other.time < f64::INFINITY);
        Self {
            time: if is_later { self.time } else { other.time },
            slot: if is_later { self.slot } else { other.slot },
            is_ambiguous: self.is_ambiguous | other.is_ambiguous | several,
        }
    }
}

/// Registers of two numbers, which every processor has, in safe code.
#[derive(Debug, Clone, Copy)]
pub(super) struct Portable;

impl Portable {
    #[inline(never)]
    fn soonest<const IMAGES: bool>(
        query: &NeighbourQuery<'_>,
        list: &CellBlock<'_>,
    ) -> SoonestSlot {
        SoonestSlot::new(list, |slots| Self::eight_of::<IMAGES>(query, slots))
    }

    #[inline(always)]
    fn eight_of<const IMAGES: bool>(
        query: &NeighbourQuery<'_>,
        slots: &[u32; DISC_LANES],
    ) -> SoonestOfEight {
        if let Some(PairConstants {
            sigma_squared,
            touching,
            ..
        }) = query.pair_constants
        {
            return Self::eight_with::<IMAGES>(query, slots, |_| (sigma_squared, touching));
        }
        let (radius, error) = (query.from.radius(), query.separation_error);
        Self::eight_with::<IMAGES>(query, slots, |other| {
            let PairConstants {
                sigma_squared,
                touching,
                ..
            } = PairConstants::at(other.radius() + radius, error);
            (sigma_squared, touching)
        })
    }

    /// The earliest contact with the discs in eight slots; `pair_constants` returns the squared
    /// contact distance of a pair and the excess below which it may touch already (both length²).
    #[inline(always)]
    fn eight_with<const IMAGES: bool>(
        query: &NeighbourQuery<'_>,
        [a, b, c, d, e, f, g, h]: &[u32; DISC_LANES],
        pair_constants: impl Fn(&BodyRecord) -> (f64, f64),
    ) -> SoonestOfEight {
        let two = |one: &u32, other: &u32| {
            Self::two_with::<IMAGES>(query, [*one, *other], &pair_constants)
        };
        let (ab, cd, ef, gh) = (two(a, b), two(c, d), two(e, f), two(g, h));
        // A tree of minima: a sequence of them would be one long dependency chain.
        let [one, other] = (ab.times.fast_min(cd.times))
            .fast_min(ef.times.fast_min(gh.times))
            .to_array();
        let time = if other < one { other } else { one };
        let soonest = f64x2::splat(time);
        let slots = |of: &Two, place: u32| of.times.simd_eq(soonest).to_bitmask() << place;
        let in_contact = (ab.in_contact | cd.in_contact) | (ef.in_contact | gh.in_contact);
        SoonestOfEight {
            time,
            slots: (slots(&ab, 0) | slots(&cd, 2)) | (slots(&ef, 4) | slots(&gh, 6)),
            in_contact: in_contact.to_bitmask() != 0,
        }
    }

    /// Two discs, for the registers of most processors. With d₀ the separation at the start of the
    /// epoch, d the present one, and v the relative velocity, from the query disc to the other: b =
    /// d·v, c = d·d − σ², and the discriminant is σ² v² − (d₀ × v)².
    #[inline(always)]
    fn two_with<const IMAGES: bool>(
        query: &NeighbourQuery<'_>,
        slots: [u32; 2],
        pair_constants: impl Fn(&BodyRecord) -> (f64, f64),
    ) -> Two {
        let NeighbourQuery {
            records,
            from,
            now,
            sides,
            ..
        } = *query;
        let body = |slot| &records[if IMAGES { slot & INDEX_MASK } else { slot } as usize];
        let (one, other) = (body(slots[0]), body(slots[1]));
        let pair = |record: &BodyRecord, first: usize| {
            f64x2::new([record.flight[first], record.flight[first + 1]])
        };
        let relative = |first| {
            let from = pair(from, first);
            f64x2::transpose([pair(one, first) - from, pair(other, first) - from])
        };
        let ([mut x0, mut y0], [vx, vy]) = (relative(0), relative(2));
        if IMAGES {
            let (one, other) = (image_of(slots[0]), image_of(slots[1]));
            let boxes = |axis: usize| f64x2::new([f64::from(one[axis]), f64::from(other[axis])]);
            x0 += boxes(0) * f64x2::splat(sides[0]);
            y0 += boxes(1) * f64x2::splat(sides[1]);
        }
        let now = f64x2::splat(now);
        let (dx, dy) = (x0 + vx * now, y0 + vy * now);
        let ((one_squared, one_touching), (other_squared, other_touching)) =
            (pair_constants(one), pair_constants(other));
        let sigma_squared = f64x2::new([one_squared, other_squared]);
        let touching = f64x2::new([one_touching, other_touching]);
        let zero = f64x2::ZERO;
        let b = dx * vx + dy * vy;
        let c = (dx * dx + dy * dy) - sigma_squared;
        let cross = x0 * vy - y0 * vx;
        let discriminant = sigma_squared * (vx * vx + vy * vy) - cross * cross;
        // Without branches: whether a pair closes is unpredictable.
        let does_not_part = b.simd_le(zero);
        let closes = does_not_part & zero.simd_lt(discriminant);
        let time = c / (discriminant.fast_max(zero).sqrt() - b);
        Two {
            times: closes.bitselect(time, f64x2::splat(f64::INFINITY)),
            in_contact: does_not_part & c.abs().simd_le(touching),
        }
    }
}

/// Contacts with two discs.
struct Two {
    /// Times from now, infinite for none.
    times: f64x2,
    /// Which pairs touch to rounding and do not separate: all bits or none.
    in_contact: f64x2,
}

impl Kernel for Portable {
    #[inline(always)]
    fn soonest_of_eight<const IMAGES: bool>(
        self,
        query: NeighbourQuery<'_>,
        slots: &[u32; DISC_LANES],
    ) -> SoonestOfEight {
        Self::eight_of::<IMAGES>(&query, slots)
    }

    #[inline]
    fn soonest_of_list(self, query: &NeighbourQuery<'_>, list: &CellBlock<'_>) -> SoonestSlot {
        if list.at_border {
            Self::soonest::<true>(query, list)
        } else {
            Self::soonest::<false>(query, list)
        }
    }

    #[inline]
    fn lanes(
        self,
        query: &NeighbourQuery<'_>,
        slots: &[u32; DISC_LANES],
        images: bool,
    ) -> DiscLanes {
        query.lanes(slots, images)
    }

    #[inline(always)]
    fn near(self, filter: &F32Filter, flights: &Flights) -> u32 {
        filter.near(flights)
    }

    #[inline]
    fn write(self, flight: &mut [f64; 4], numbers: [f64; 4]) {
        *flight = numbers;
    }

    #[inline]
    fn find(self, slots: &[u32; DISC_LANES], slot: u32) -> u32 {
        let mut found = 0;
        for (place, &other) in slots.iter().enumerate() {
            found |= u32::from(other == slot) << place;
        }
        found
    }
}

/// Prefetches an element of a slice. A hint: it has no effect on results, and the index may be out
/// of range.
#[inline]
pub(super) fn prefetch<T>(slice: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: SSE, which every x86-64 processor has, contains the instruction. It is a hint: at
        // any address, mapped or not, it neither faults nor changes what the program sees.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(slice.as_ptr().wrapping_add(index).cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (slice, index);
}

/// Instruction set that [`CellScheduler`](crate::CellScheduler) computes with. All give the same
/// bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Instructions {
    /// The best one that this processor supports: AVX-512 (F, VL, DQ, BW), else as [`Self::Avx2`].
    #[default]
    Widest,
    /// AVX2 where the processor supports it, else as [`Self::Portable`]. Some percent slower than
    /// AVX-512.
    Avx2,
    /// Instructions that every processor of this architecture supports. The slowest.
    Portable,
}

impl Instructions {
    /// The instruction set that [`CellScheduler`](crate::CellScheduler) uses on this processor if
    /// `self` is chosen: the best supported one, up to `self`.
    ///
    /// ```
    /// use carom_engine::Instructions;
    ///
    /// // Every processor has these.
    /// assert_eq!(Instructions::Portable.on_this_processor(), Instructions::Portable);
    /// // `Widest` is AVX-512, where the processor has it.
    /// let best = Instructions::Widest.on_this_processor();
    /// assert_eq!(best.on_this_processor(), best);
    /// ```
    #[must_use]
    pub fn on_this_processor(self) -> Self {
        available(self).instructions()
    }
}

/// An instruction set that this processor has, with its proof.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AvailableInstructions {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512),
}

impl AvailableInstructions {
    /// The instruction set without its proof.
    pub fn instructions(self) -> Instructions {
        match self {
            Self::Portable => Instructions::Portable,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => Instructions::Avx2,
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(_) => Instructions::Widest,
        }
    }
}

/// The best instruction set that this processor has, up to `chosen`.
pub(super) fn available(chosen: Instructions) -> AvailableInstructions {
    #[cfg(target_arch = "x86_64")]
    {
        if chosen == Instructions::Widest
            && let Some(set) = Avx512::detect()
        {
            return AvailableInstructions::Avx512(set);
        }
        if chosen != Instructions::Portable
            && let Some(set) = Avx2::detect()
        {
            return AvailableInstructions::Avx2(set);
        }
    }
    let _ = chosen;
    AvailableInstructions::Portable
}

/// A computation that is compiled for each instruction set.
pub(super) trait KernelWork {
    type Output;

    /// Runs the computation with a kernel. Inlined, so that it is compiled with the kernel's
    /// instructions.
    fn with<K: Kernel>(self, kernel: K) -> Self::Output;
}

/// Runs a computation in the build for an instruction set.
#[inline]
pub(super) fn dispatch<W: KernelWork>(instructions: AvailableInstructions, work: W) -> W::Output {
    match instructions {
        #[cfg(target_arch = "x86_64")]
        AvailableInstructions::Avx512(set) => set.run(InRegisters(work)),
        #[cfg(target_arch = "x86_64")]
        AvailableInstructions::Avx2(set) => set.run(InRegisters(work)),
        AvailableInstructions::Portable => work.with(Portable),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::{f32_filter::Units, neighbour_lists::NeighbourLists};
    use carom_kinematics::Motion;
    use proptest::prelude::*;

    /// The result with each instruction set that this processor has.
    fn with_each_instruction_set<W: KernelWork<Output: std::fmt::Debug + PartialEq> + Copy>(
        query: W,
    ) -> Vec<W::Output> {
        let sets = [
            Instructions::Portable,
            Instructions::Avx2,
            Instructions::Widest,
        ];
        sets.into_iter()
            .map(|chosen| dispatch(available(chosen), query))
            .collect()
    }

    /// The discs of a block that pass the filter.
    #[derive(Clone, Copy)]
    struct FilterEight<'a>(&'a F32Filter, &'a Flights);

    /// The earliest contact with the discs of a list.
    #[derive(Clone, Copy)]
    struct SearchList<'a>(NeighbourQuery<'a>, CellBlock<'a>);

    impl KernelWork for FilterEight<'_> {
        type Output = u32;

        #[inline(always)]
        fn with<K: Kernel>(self, kernel: K) -> u32 {
            kernel.near(self.0, self.1)
        }
    }

    impl KernelWork for SearchList<'_> {
        type Output = SoonestSlot;

        #[inline(always)]
        fn with<K: Kernel>(self, kernel: K) -> SoonestSlot {
            let soonest = kernel.soonest_of_list(&self.0, &self.1);
            self.1.for_each_slots8(|slots| {
                let images = self.1.at_border;
                let (lanes, expected) = (
                    kernel.lanes(&self.0, slots, images),
                    self.0.lanes(slots, images),
                );
                let bits = |lanes: &DiscLanes| {
                    let numbers = lanes.separation.iter().chain(&lanes.velocity).flatten();
                    let rest = [lanes.separation_error, lanes.speed];
                    numbers
                        .chain(&lanes.cross)
                        .chain(&lanes.contact_distance)
                        .chain(&rest)
                        .map(|n| n.to_bits())
                        .collect::<Vec<_>>()
                };
                assert_eq!(bits(&lanes), bits(&expected));
            });
            let mut eights = Vec::new();
            self.1.for_each_slots8(|slots| eights.push(*slots));
            if let [slots] = eights.as_slice() {
                assert_eq!(
                    kernel
                        .soonest_of_eight::<true>(self.0, slots)
                        .in_slots(slots),
                    soonest
                );
                if !self.1.at_border {
                    assert_eq!(
                        kernel
                            .soonest_of_eight::<false>(self.0, slots)
                            .in_slots(slots),
                        soonest
                    );
                }
            }
            soonest
        }
    }

    /// Whether a time is that of a contact to rounding, or infinite where there is none to
    /// rounding.
    fn is_right(lanes: &DiscLanes, lane: usize, time: f64) -> bool {
        let Some(motion) = lanes.relative_motion(lane) else {
            return time == f64::INFINITY;
        };
        let sigma = lanes.contact_distance[lane];
        let there = motion.separation + motion.velocity * time;
        let miss = motion.separation.perp_dot(motion.velocity).abs() / motion.velocity.length();
        let gap = if time < f64::INFINITY {
            there.length() - sigma
        } else {
            miss - sigma
        };
        let leaves = motion.separation.dot(motion.velocity) >= 0.0;
        gap.abs() <= lanes.separation_error || (time == f64::INFINITY && (gap > 0.0 || leaves))
    }

    /// The slots that hold a number.
    #[derive(Clone, Copy)]
    struct Find<'a>(&'a [u32; DISC_LANES], u32);

    impl KernelWork for Find<'_> {
        type Output = u32;

        #[inline(always)]
        fn with<K: Kernel>(self, kernel: K) -> u32 {
            kernel.find(self.0, self.1)
        }
    }

    proptest! {
        #[test]
        fn a_disc_is_found_in_every_slot_that_holds_it(slots in prop::array::uniform8(0u32..5), disc in 0u32..5) {
            let expected = (0..DISC_LANES).filter(|&place| slots[place] == disc).map(|place| 1 << place).sum::<u32>();
            prop_assert_eq!(with_each_instruction_set(Find(&slots, disc)), [expected; 3]);
        }

        /// The discs around a cell, inside the box or at its border, of any radii or all of one,
        /// some touching, some listed twice: all kernels give the bits of the closed form, and the
        /// contacts of detection to rounding.
        #[test]
        fn kernels_agree_to_the_bit_and_with_detection_to_rounding(
            others in prop::collection::vec(
                (0u16..5, 0u16..5, -1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64), 1..40),
            kinds in prop::collection::vec(0u8..6, 40), alike in any::<bool>(), at_border in any::<bool>(),
            velocity in (-1.0..1.0f64, -1.0..1.0f64), now in 0.0..2.0f64, speed in 0.1..8.0f64,
        ) {
            // No disc flies farther than this many sides of the box.
            let separation_error = HALF_ULP * 16.0 * (1.0 + 2.0 * speed) * (1.0 + 0.75);
            let radius = |kind: u8| if alike { 0.15 } else { 0.05 + 0.05 * f64::from(kind) };
            let moving = |velocity, place| Motion { velocity, ..Motion::at_rest(place) };
            let asking = moving(DVec2::from(velocity), DVec2::new(0.1, -0.2));
            let mut records = vec![BodyRecord::new(&asking, radius(0))];
            for (&(_, _, x, y, vx, vy), &kind) in others.iter().zip(&kinds) {
                let (place, velocity) = (DVec2::new(x, y), speed * DVec2::new(vx, vy));
                let record = match kind {
                    // At contact to rounding.
                    1 => {
                        let normal = place.normalize_or(DVec2::X);
                        let there = asking.position_at(now) + (radius(0) + radius(kind)) * normal;
                        BodyRecord::new(&moving(velocity, there - velocity * now), radius(kind))
                    }
                    // At the place of the one before.
                    2 => records[records.len() - 1],
                    _ => BodyRecord::new(&moving(velocity, place), radius(kind)),
                };
                records.push(record);
            }
            let dummy = records.len() as u32;
            records.push(BodyRecord::dummy());
            let mut neighbour_lists: NeighbourLists = NeighbourLists::default();
            let cells = others.iter().map(|&(column, row, ..)| [column, row]);
            neighbour_lists.list_all([5, 5], dummy, (1..).zip(cells));
            let list = neighbour_lists.list(if at_border { [4, 0] } else { [2, 2] });
            prop_assert_eq!(list.at_border, at_border);
            let query = NeighbourQuery {
                records: &records,
                from: &records[0],
                now,
                separation_error,
                sides: [1.0, 0.75],
                pair_constants: alike.then(|| PairConstants::new(0.15, separation_error)),
            };
            // Every slot on its own, in the order of the list.
            let slots: Vec<u32> = list.slots().collect();
            let (mut times, mut in_contact) = (Vec::new(), false);
            for some in slots.chunks(DISC_LANES) {
                let mut eight = [dummy; DISC_LANES];
                eight[..some.len()].copy_from_slice(some);
                let lanes = query.lanes(&eight, at_border);
                let (times_of_some, touching) = lanes.closed_form();
                for (lane, time) in times_of_some.into_iter().enumerate().take(some.len()) {
                    prop_assert!(is_right(&lanes, lane, time), "{time} where detection says {:?}", lanes.closed_form().0[lane]);
                }
                times.extend(&times_of_some[..some.len()]);
                in_contact |= touching;
            }
            let least = times.iter().copied().fold(f64::INFINITY, f64::min);
            let touched = times.iter().filter(|&&time| time == least && time < f64::INFINITY).count();
            let query = SearchList(query, list);
            let answers = with_each_instruction_set(query);
            for answer in &answers {
                prop_assert_eq!(answer.time.to_bits(), least.to_bits());
                // An ambiguous result costs time only; an unambiguous one must be right.
                prop_assert!(answer.is_ambiguous || (touched < 2 && !in_contact));
                if touched == 1 {
                    let place = times.iter().position(|&time| time == least);
                    prop_assert_eq!(Some(answer.slot), place.map(|place| slots[place]));
                }
            }
            prop_assert!(answers.iter().all(|answer| *answer == answers[0]));
            // With at most eight discs, the result is ambiguous exactly if it has to be.
            prop_assert!(slots.len() > DISC_LANES || answers[0].is_ambiguous == (touched > 1 || in_contact));
        }

        /// Every disc that is touched before the end of the epoch passes the filter: from a
        /// distance, at contact, in a graze to rounding, at nearly equal velocities, in any units;
        /// and so do discs at relative rest that touch.
        #[test]
        fn the_filter_excludes_no_contact(
            others in prop::collection::vec(
                (-0.66..0.66f64, -0.66..0.66f64, -1.0..1.0f64, -1.0..1.0f64), DISC_LANES),
            kinds in prop::collection::vec(0u8..7, DISC_LANES), grazes in -1.0..1.0f64, slow in 0.0..12.0f64,
            place in (0.0..1.0f64, 0.0..1.0f64), velocity in (-1.0..1.0f64, -1.0..1.0f64),
            radius in 1.0..5.0f64, now in 0.0..1.0f64, limit in 0.1..8.0f64,
            units in (-30i32..30, -30i32..30), image in 0usize..9,
        ) {
            let (side, speed) = (2f64.powi(units.0), 2f64.powi(units.1));
            let limit = limit * side / speed;
            let (now, radius) = (now * limit, side * 10f64.powf(-radius));
            let sides = DVec2::new(side, 0.75 * side);
            let velocity = speed * 0.9 * DVec2::from(velocity);
            let here = sides * DVec2::from(place);
            let code = (image as u32 % 3) | ((image as u32 / 3) << 2);
            let shift = DVec2::from_array(image_of(code << INDEX_BITS).map(f64::from)) * sides;
            // A quarter of the unit: the unit is four times the root mean square.
            let at_start = [DVec2::new(0.25 * speed, 0.0)];
            let mut units = Units::new(2.0 * radius, sides, limit, at_start.into_iter());
            let asking = BodyRecord::new(&Motion { velocity, time: now, ..Motion::at_rest(here) }, radius);
            let mut records = vec![asking];
            let mut flights = [[f32::NAN; DISC_LANES]; 4];
            for (lane, (&(x, y, vx, vy), kind)) in others.iter().zip(&kinds).enumerate() {
                let (mut apart, mut theirs) = (DVec2::new(x, y) * sides, speed * DVec2::new(vx, vy));
                let towards = -apart.normalize_or(DVec2::X);
                match kind {
                    // An empty lane.
                    0 => { records.push(BodyRecord::dummy()); continue }
                    // At contact to rounding, and approaching.
                    1 => apart = -2.0 * radius * towards,
                    // On a path that grazes to rounding.
                    2 => {
                        let course = (theirs - velocity).normalize_or(DVec2::X);
                        let miss = 2.0 * radius * (1.0 + 1e-15 * grazes) * course.perp();
                        apart = miss - course * apart.length();
                    }
                    // On a head-on path, hardly faster.
                    3 => theirs = velocity + speed * 0.1 * 10f64.powf(-slow) * towards,
                    // At contact with equal velocities, to rounding.
                    4 => {
                        apart = -2.0 * radius * towards;
                        theirs = velocity * (1.0 + f64::EPSILON * grazes) + speed * 1e-18 * towards;
                    }
                    _ => {}
                }
                let motion = Motion { velocity: theirs, time: now, ..Motion::at_rest(here + apart - shift) };
                let record = BodyRecord::new(&motion, radius);
                for (numbers, number) in flights.iter_mut().zip(units.quantize(record.flight)) {
                    numbers[lane] = number;
                }
                records.push(record);
            }
            prop_assert!(!units.is_disabled());
            let filter = units.filter(&records[0].flight, now).for_image(&units, code as usize);
            let near = filter.near(&flights);
            prop_assert_eq!(with_each_instruction_set(FilterEight(&filter, &flights)), [near; 3]);
            let query = NeighbourQuery {
                records: &records,
                from: &records[0],
                now,
                separation_error: 0.0,
                sides: sides.to_array(),
                pair_constants: Some(PairConstants::new(radius, 0.0)),
            };
            let slots: [u32; DISC_LANES] = std::array::from_fn(|lane| (lane as u32 + 1) | code << INDEX_BITS);
            let times = query.lanes(&slots, true).contact_times();
            for (lane, time) in times.into_iter().enumerate() {
                let may_be_met = near & (1 << lane) != 0;
                prop_assert!(may_be_met || now + time > limit, "lane {}, kind {}, {}", lane, kinds[lane], time);
                prop_assert!(!may_be_met || kinds[lane] > 0, "an empty lane passes the filter");
            }
        }
    }

    #[test]
    fn the_filter_excludes_nearly_all_discs_of_a_dilute_gas() {
        // Discs of radius 0.001 at a distance of 0.04 on a circle around the query disc: a path has
        // a width of 0.004 in a circumference of 2 π 0.04, and half of the discs on it recede.
        use rand::{RngExt, SeedableRng};
        let mut random = rand_pcg::Pcg64::seed_from_u64(11);
        let mut number = move || random.random::<f64>() - 0.5;
        let velocities = [DVec2::new(1.0, 0.0)];
        let mut units = Units::new(0.002, DVec2::ONE, 2.0, velocities.into_iter());
        let mut seen = 0;
        for _ in 0..1000 {
            let filter = units.filter(&[0.5, 0.5, number(), number()], 0.0);
            let mut flights = [[0.0; DISC_LANES]; 4];
            for lane in 0..DISC_LANES {
                let angle = std::f64::consts::TAU * number();
                let kept = [
                    0.5 + 0.04 * angle.cos(),
                    0.5 + 0.04 * angle.sin(),
                    number(),
                    number(),
                ];
                units
                    .quantize(kept)
                    .into_iter()
                    .zip(&mut flights)
                    .for_each(|(kept, numbers)| numbers[lane] = kept);
            }
            seen += filter.near(&flights).count_ones();
        }
        // 8000 (2 · 0.002 / 0.04) / (2 π) = 127 ± 11.
        assert!((85..=170).contains(&seen), "{seen}");
    }
}
