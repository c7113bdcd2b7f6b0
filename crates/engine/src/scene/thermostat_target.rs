//! The energy or temperature to which a thermostat brings bodies.

use crate::world::body::Body;

/// The energy to which a thermostat brings each body of a tag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ThermostatTarget {
    /// Kinetic energy of a body (mass × length² / time²): of each, or the mean of the distribution.
    Energy(f64),
    /// Temperature kT (mass × length² / time²): energy ½ f kT for a body of f = 2 degrees of
    /// freedom, or 3 if contacts turn it.
    Temperature(f64),
}

impl ThermostatTarget {
    /// The kinetic energy of this body (mass × length² / time²).
    pub fn energy_of(&self, body: &Body) -> f64 {
        match *self {
            Self::Energy(energy) => energy,
            Self::Temperature(temperature) => 0.5 * degrees_of_freedom(body) * temperature,
        }
    }

    /// The temperature kT of this body (mass × length² / time²).
    pub fn temperature_of(&self, body: &Body) -> f64 {
        match *self {
            Self::Energy(energy) => 2.0 * energy / degrees_of_freedom(body),
            Self::Temperature(temperature) => temperature,
        }
    }
}

/// Degrees of freedom of a moving body that contacts change.
fn degrees_of_freedom(body: &Body) -> f64 {
    if body.can_turn() { 3.0 } else { 2.0 }
}
