//! The clock rate of this core as it is now, so that times can be compared where it changes from one second to the next.

use std::hint::black_box;

use cpu_time::ThreadTime;

/// Multiplications that are timed in one go: a quarter of a millisecond.
const MULTIPLICATIONS: u32 = 250_000;

/// Of so many goes the fastest counts: what comes in between makes one longer, never shorter.
const GOES: usize = 4;

/// Cycles of a multiplication of 64-bit integers that needs the result of the one before: three on the x86-64 cores that
/// servers and workstations have. Where there are others, the unit is a third of that.
const CYCLES: f64 = 3.0;

/// Cycles in a nanosecond, from the time of a chain of multiplications; none if the clock of this system is too coarse.
///
/// This tells how fast the core ticks, not whether it works for somebody else half of the time: a chain that waits for itself
/// hardly feels that.
pub fn gigahertz() -> Option<f64> {
    let go = |_| {
        let clock = ThreadTime::now();
        let mut product = black_box(3_u64);
        for _ in 0..MULTIPLICATIONS {
            product = product.wrapping_mul(product);
        }
        black_box(product);
        clock.elapsed().as_secs_f64()
    };
    let fastest = (0..GOES).map(go).fold(f64::INFINITY, f64::min);
    (fastest > 0.0).then(|| CYCLES * f64::from(MULTIPLICATIONS) / (1e9 * fastest))
}
