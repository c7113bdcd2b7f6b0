//! The hot loop compiled twice: for every processor of this kind, and with AVX2 where there is AVX2.
//!
//! The one place of the project with unsafe code: calling a function that was compiled with instructions which the
//! compiler does not take for granted, after having asked the processor for them. No pointers are handled here. Neither
//! version fuses a multiplication and an addition, so both compute the same bits.

#![allow(unsafe_code, reason = "calls into the AVX2 build of the loop; see the module's documentation")]

use carom_detection::Detection;
use carom_kinematics::Motion;

use super::{Instructions, State};
use crate::{ContactEvent, World};

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
            state.next_contact(world, detection, stop)
        }
        // SAFETY: `available` gives `Widest` only where the processor reports AVX2.
        return unsafe { with_avx2(state, world, detection, stop) };
    }
    state.next_contact(world, detection, stop)
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
            state.motions_changed(world, detection, bodies, motions);
        }
        // SAFETY: `available` gives `Widest` only where the processor reports AVX2.
        return unsafe { with_avx2(state, world, detection, bodies, motions) };
    }
    state.motions_changed(world, detection, bodies, motions);
}
