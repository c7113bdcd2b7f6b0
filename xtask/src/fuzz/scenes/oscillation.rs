//! The oscillation of a wall, computed from its amplitude, frequency and phase, with double-double
//! places.

use carom::engine::WallMotionSpec;
use carom_kinematics::EpochTime;
use carom_testkit::oracle::{DoubleDouble, Number as _};

use super::{
    durations::duration,
    vectors::{BodyPair, length},
};

/// An oscillation, A sin(Ω s + φ) with the time s since the wall was given it; s falls after a
/// reversal.
#[derive(Debug, Clone, Copy)]
pub struct WallOscillation {
    /// A (length).
    pub amplitude: BodyPair,
    /// Ω (radians per time).
    pub frequency: f64,
    /// φ (turns).
    phase: f64,
    /// A time, and s then.
    since: EpochTime,
    passed: DoubleDouble,
    /// 1, or −1 if s falls.
    direction: f64,
}

impl WallOscillation {
    /// The oscillation that a wall is given at `time`; `None` if the motion is another.
    pub fn new(spec: &WallMotionSpec, time: EpochTime) -> Option<Self> {
        (spec.amplitude != [0.0; 2]).then(|| Self {
            amplitude: spec.amplitude,
            frequency: spec.frequency,
            phase: spec.phase / std::f64::consts::TAU,
            since: time,
            passed: DoubleDouble::new(0.0),
            direction: 1.0,
        })
    }

    /// The oscillation through the places before `time`, in the opposite order.
    #[must_use]
    pub fn reversed(&self, time: EpochTime) -> Self {
        Self {
            since: time,
            passed: self.passed_at(time),
            direction: -self.direction,
            ..*self
        }
    }

    /// s at a time.
    fn passed_at(&self, time: EpochTime) -> DoubleDouble {
        let direction = DoubleDouble::new(self.direction);
        let since = duration(self.since, time);
        self.passed.plus(&direction.times(&since))
    }

    /// Displacement at a time from the place at which the wall was given the oscillation (length).
    pub fn displacement(&self, time: EpochTime) -> [DoubleDouble; 2] {
        let sine = |passed: &DoubleDouble| {
            let [_, sin] = DoubleDouble::cos_sin(self.phase, self.frequency, passed);
            sin
        };
        let change = sine(&self.passed_at(time)).minus(&sine(&DoubleDouble::new(0.0)));
        self.amplitude
            .map(|amplitude| DoubleDouble::new(amplitude).times(&change))
    }

    /// Velocity at a time (length per time).
    pub fn velocity(&self, time: EpochTime) -> BodyPair {
        let [cos, _] = DoubleDouble::cos_sin(self.phase, self.frequency, &self.passed_at(time));
        let factor = self.direction * self.frequency * cos.value();
        self.amplitude.map(|amplitude| factor * amplitude)
    }

    /// The highest speed (length per time).
    pub fn top_speed(&self) -> f64 {
        length(self.amplitude) * self.frequency
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn oscillation() -> WallOscillation {
        let spec = WallMotionSpec {
            amplitude: [0.3, -0.1],
            frequency: 7.0,
            phase: 0.4,
            ..WallMotionSpec::default()
        };
        WallOscillation::new(&spec, EpochTime::from(2.0)).unwrap()
    }

    #[test]
    fn a_wall_follows_a_sine() {
        for step in 0..100 {
            let passed = 0.03 * f64::from(step);
            let time = EpochTime::from(2.0).after(passed);
            let angle = 7.0 * passed + 0.4;
            let [x, y] = oscillation().displacement(time).map(|one| one.value());
            let sine = angle.sin() - 0.4f64.sin();
            assert!((x - 0.3 * sine).abs() < 1e-14 && (y + 0.1 * sine).abs() < 1e-14);
            let [x, y] = oscillation().velocity(time);
            assert!((x - 2.1 * angle.cos()).abs() < 1e-13 && (y + 0.7 * angle.cos()).abs() < 1e-13);
        }
    }

    #[test]
    fn a_reversed_oscillation_returns() {
        let at = |time: f64| EpochTime::from(2.0).after(time);
        let returning = oscillation().reversed(at(1.5));
        let (before, after) = (at(0.625), at(2.375));
        let there = |one: &WallOscillation, time| one.displacement(time)[0].value();
        assert!((there(&oscillation(), before) - there(&returning, after)).abs() < 1e-30);
        assert_eq!(
            oscillation().velocity(before).map(|v| -v),
            returning.velocity(after)
        );
    }
}
