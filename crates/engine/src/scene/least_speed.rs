//! The least speed of a body that moves.

/// The least speed that is not 0 (length per time), of a centre or of a rim, |ω| R. All bodies of a
/// scene and after an edit must satisfy it, and the fastest body at the start of each epoch.
///
/// Detection forms products such as σ² w², with the contact distance σ of two atoms and a relative
/// velocity w. They must not underflow as long as w changes a position at all. An epoch ends when
/// the fastest body, of speed v, has travelled a few sides of the box or has turned 64 times, so a
/// w below u v/400 is lost in the rounding of positions. With σ ≥ 10⁻⁶⁰ and v ≥ 10⁻⁷⁰ all larger w
/// give σ² w² ≥ 7·10⁻²⁹⁸, and with masses m ≥ 10⁻⁶⁰ energies are m v² ≥ 10⁻²⁰⁰: normal numbers,
/// above 2.2·10⁻³⁰⁸. Smaller: small and slow bodies would pass through each other. Larger: fewer
/// scenes are accepted.
pub const MIN_SPEED: f64 = 1e-70;
