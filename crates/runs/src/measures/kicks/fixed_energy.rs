//! Mean speeds in a system of few bodies at fixed total energy.

/// Mean magnitude of a velocity component at a fixed energy E of f degrees of freedom, relative to
/// the canonical value at temperature 2E/f: √(f/2) Γ(f/2) / Γ((f + 1)/2), because the velocities
/// are uniform on a sphere in f dimensions.
///
/// The expansion is 1 + 1/(4f) + smaller terms.
pub fn mean_speed(freedom: f64) -> f64 {
    (0.5 * freedom).sqrt()
        * (libm::lgamma(0.5 * freedom) - libm::lgamma(0.5 * (freedom + 1.0))).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// One dimension: |v| is constant and equals the root mean square, √(π/2) times the Maxwellian
    /// mean. Two dimensions: a component of a unit vector has the mean magnitude 2/π.
    #[test]
    fn mean_speeds_at_fixed_energy() {
        assert!((mean_speed(1.0) - (0.5 * PI).sqrt()).abs() < 1e-14);
        assert!((mean_speed(2.0) - 2.0 / PI.sqrt()).abs() < 1e-14);
        assert!((mean_speed(1000.0) - 1.0 - 1.0 / 4000.0).abs() < 1e-6);
    }
}
