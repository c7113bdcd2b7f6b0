//! The clock of bodies that a common drag slows: in it they fly straight at constant velocity.
//!
//! A drag v' = −γ v, ω' = −γ ω of all bodies keeps every path and only delays it. With
//!
//! s = (1 − exp(−γ t))/γ,  ds/dt = exp(−γ t) = 1 − γ s,
//!
//! a body of the initial velocity v₀ is at x₀ + v₀ s, and its velocity is v₀ (1 − γ s). Contacts
//! depend on the paths alone, and an impulse is proportional to the velocities, so that a whole gas
//! moves in s as it would in t without drag. The clock s never reaches 1/γ, where all bodies are at
//! rest.

use serde::{Deserialize, Serialize};

/// Converts between durations t and readings s of the clock of a drag γ, both from one start. At
/// γ = 0 both are equal, to the bit.
///
/// ```
/// use carom_kinematics::DragClock;
///
/// let clock = DragClock::new(0.5);
/// let reading = clock.reading(2.0);
/// assert!((reading - (1.0 - (-1.0_f64).exp()) / 0.5).abs() < 1e-15);
/// assert!((clock.slowing(reading) - (-1.0_f64).exp()).abs() < 1e-15);
/// assert!((clock.duration(reading) - 2.0).abs() < 1e-15);
/// assert_eq!(DragClock::FREE.reading(2.0), 2.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct DragClock {
    drag: f64,
}

impl DragClock {
    /// The clock without drag: ordinary time.
    pub const FREE: Self = Self { drag: 0.0 };

    /// The clock of a drag γ (1/time), finite and at least 0.
    pub const fn new(drag: f64) -> Self {
        // −0 becomes 0: a time over it would be in the past.
        Self { drag: drag + 0.0 }
    }

    /// The drag γ (1/time).
    #[inline]
    pub fn drag(self) -> f64 {
        self.drag
    }

    /// Whether there is no drag.
    #[inline]
    pub fn is_free(self) -> bool {
        self.drag == 0.0
    }

    /// The reading s after a duration (time); less than 1/γ up to rounding.
    #[inline]
    pub fn reading(self, duration: f64) -> f64 {
        self.weighted(duration, 1)
    }

    /// The duration from the start to a reading s below 1/γ (time).
    #[inline]
    pub fn duration(self, reading: f64) -> f64 {
        if self.is_free() {
            reading
        } else {
            -(-self.drag * reading).ln_1p() / self.drag
        }
    }

    /// The share of its initial velocity that a body has at a reading, 1 − γ s.
    #[inline]
    pub fn slowing(self, reading: f64) -> f64 {
        1.0 - self.drag * reading
    }

    /// A reading, on the clock that starts at another reading.
    #[inline]
    pub fn restarted(self, reading: f64, start: f64) -> f64 {
        (reading - start) / self.slowing(start)
    }

    /// ∫₀ᵗ exp(−n γ t') dt' over a duration t (time): the integral of what is proportional to the
    /// n-th power of the velocities, over its initial value. For n = 1 the reading.
    pub fn weighted(self, duration: f64, power: u8) -> f64 {
        if self.is_free() {
            return duration;
        }
        let rate = f64::from(power) * self.drag;
        -(-rate * duration).exp_m1() / rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_and_durations_are_inverse_for_any_drag() {
        for drag in [1e-30, 1e-9, 0.3, 1.0, 40.0] {
            let clock = DragClock::new(drag);
            for share in [1e-12, 1e-3, 0.1, 0.5, 2.0] {
                let duration = share / drag;
                let reading = clock.reading(duration);
                let back = clock.duration(reading);
                // The end of the clock is steep: an ulp of s is exp(γ t) ulps of t.
                let allowed = 8.0 * f64::EPSILON * duration * share.exp() / share.min(1.0);
                assert!((back - duration).abs() < allowed, "{drag} {share}: {back}");
                assert!((clock.slowing(reading) - (-share).exp()).abs() < 4.0 * f64::EPSILON);
            }
            assert!(clock.reading(f64::INFINITY) * drag <= 1.0);
        }
    }

    #[test]
    fn a_drag_of_minus_zero_is_none() {
        assert!(DragClock::new(-0.0).drag().is_sign_positive());
    }

    #[test]
    fn a_clock_that_starts_later_goes_on() {
        let clock = DragClock::new(0.7);
        let [first, second] = [0.4, 1.1].map(|duration| clock.reading(duration));
        let rest = clock.restarted(second, first);
        assert!((rest - clock.reading(0.7)).abs() < 1e-15);
        // Also for times before the start.
        let past = clock.restarted(0.0, first);
        assert!((clock.duration(past) + 0.4).abs() < 1e-15);
    }

    #[test]
    fn powers_of_the_velocity_have_their_integrals() {
        let clock = DragClock::new(0.7);
        // Simpson's rule on a fine mesh.
        for power in 1..=3 {
            let value = |t: f64| (-0.7 * f64::from(power) * t).exp();
            let steps = 1000;
            let h = 2.0 / f64::from(steps);
            let sum: f64 = (0..steps)
                .map(|n| {
                    let t = h * f64::from(n);
                    h / 6.0 * (value(t) + 4.0 * value(t + 0.5 * h) + value(t + h))
                })
                .sum();
            assert!((clock.weighted(2.0, power) - sum).abs() < 1e-12);
        }
    }
}
