//! All numbers on which a search depends: what each is for and what breaks if it changes.
//!
//! All are relative or counts, so that velocities times a power of two give the same bits.

use carom_kinematics::HALF_ULP;

/// Relative shortening of each certified step and window edge, against the rounding of the step
/// itself (a dozen operations). Smaller: the proof has a hole of an ulp. Larger: slower, no less exact.
pub const STEP_MARGIN: f64 = 16.0 * HALF_ULP;

/// Most steps that [`Exact`](crate::Exact) takes for one atom pair before it answers "certified free
/// until". Ordinary pairs take 5 to 30, grazes up to 80. Smaller: more re-checks. Larger: a pair that
/// flies along at a constant gap of rounding size keeps one query busy for longer.
pub const MOST_STEPS: u32 = 4096;

/// Relative tolerance of the golden-section search and of the secant: five machine epsilon
/// (Montanari 2017, appendix A), taken relative to the time sought. Smaller than about 2: neither
/// search can end before its rounds are used up.
pub const THESIS_TOLERANCE: f64 = 5.0 * f64::EPSILON;
