//! The present clock rate of this core, so that times can be compared while it changes.

use std::hint::black_box;

use cpu_time::ThreadTime;

/// Number of multiplications in one measurement: a quarter of a millisecond.
const MULTIPLICATIONS: u32 = 250_000;

/// Number of measurements; the fastest counts, because interruptions only lengthen a measurement.
const GOES: usize = 4;

/// Latency of a 64-bit integer multiplication (cycles): three on current x86-64 cores. On other
/// cores the result is in units of a third of their latency.
const CYCLES: f64 = 3.0;

/// Clock rate in cycles per nanosecond, from the time of a chain of dependent multiplications;
/// `None` if the system clock is too coarse.
///
/// It measures the rate of the core, not its availability: a latency-bound chain is hardly affected
/// by another thread on the same core.
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
