//! Mean speeds of few bodies, which share one energy instead of each having a heat bath.

/// The mean magnitude of a velocity component where the energy of f degrees of freedom is given, relative to that at a given
/// temperature 2E/f: √(f/2) Γ(f/2) / Γ((f + 1)/2), as the velocities are spread evenly over a sphere of f dimensions.
///
/// It is 1 + 1/(4f) and smaller terms.
pub fn mean_speed(freedom: f64) -> f64 {
    (0.5 * freedom).sqrt() * (libm::lgamma(0.5 * freedom) - libm::lgamma(0.5 * (freedom + 1.0))).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// One dimension: |v| is always what Maxwell's is on root mean square, √(π/2) of its mean; two: a component of a unit
    /// vector has the mean 2/π.
    #[test]
    fn mean_speeds_at_fixed_energy() {
        assert!((mean_speed(1.0) - (0.5 * PI).sqrt()).abs() < 1e-14);
        assert!((mean_speed(2.0) - 2.0 / PI.sqrt()).abs() < 1e-14);
        assert!((mean_speed(1000.0) - 1.0 - 1.0 / 4000.0).abs() < 1e-6);
    }
}
