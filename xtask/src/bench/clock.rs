//! The clock rate of this core as it is now, so that times can be compared between machines, and between an hour and the next.

use std::hint::black_box;

use cpu_time::ThreadTime;

/// Multiplications that are timed: about a millisecond.
const MULTIPLICATIONS: u32 = 1_000_000;

/// Cycles of one that needs the result of the one before: of 64-bit integers, three on x86-64 cores since Nehalem (2008) and
/// Zen (2017), and on most others.
const CYCLES: f64 = 3.0;

/// Cycles in a nanosecond, from the time of a chain of multiplications. A core that others share, or that has been slowed
/// down, has fewer.
pub fn clock_in_gigahertz() -> f64 {
    let clock = ThreadTime::now();
    let mut product = black_box(3_u64);
    for _ in 0..MULTIPLICATIONS {
        product = product.wrapping_mul(product);
    }
    black_box(product);
    CYCLES * f64::from(MULTIPLICATIONS) / (1e9 * clock.elapsed().as_secs_f64())
}
