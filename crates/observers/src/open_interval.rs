//! The open interval between two samples, with the time average of a quantity across edits.

use std::ops::{Add, Mul};

use carom_kinematics::EpochTime;
use serde::{Deserialize, Serialize};

/// An interval that has begun, and the mean of a quantity in it.
///
/// Edits divide the interval into parts. In each part the mean is that of the values at its two
/// ends (trapezoidal rule), so that a value may change at an edit.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct OpenInterval<T> {
    began: EpochTime,
    /// From the start of the interval to that of the present part (time).
    earlier: f64,
    /// Mean over the earlier parts; unused if there are none.
    mean: T,
    /// Value at the start of the present part.
    first: T,
    /// Whether an edit divides the interval now.
    is_paused: bool,
}

impl<T: Clone + Add<Output = T> + Mul<f64, Output = T>> OpenInterval<T> {
    /// An interval that begins at this time with this value.
    pub(crate) fn new(time: EpochTime, first: T) -> Self {
        Self {
            began: time,
            earlier: 0.0,
            mean: first.clone(),
            first,
            is_paused: false,
        }
    }

    /// Its length at this time (time).
    pub(crate) fn duration(&self, time: EpochTime) -> f64 {
        time.since(self.began)
    }

    /// The mean from the start to this time, at which the quantity has this value.
    pub(crate) fn mean(&self, time: EpochTime, last: T) -> T {
        let duration = self.duration(time);
        if duration <= self.earlier {
            return self.mean.clone();
        }
        let share = self.earlier / duration;
        let part = (self.first.clone() + last) * 0.5;
        if share == 0.0 {
            part
        } else {
            self.mean.clone() * share + part * (1.0 - share)
        }
    }

    /// Ends the present part, before an edit. If the edit fails, the next part begins with the same
    /// value.
    pub(crate) fn pause(&mut self, time: EpochTime, last: T) {
        self.mean = self.mean(time, last.clone());
        self.earlier = self.duration(time);
        self.first = last;
        self.is_paused = true;
    }

    /// Begins the next part, after an edit. Returns false if the interval has not been paused at
    /// this time: what happened since is not known.
    pub(crate) fn proceed(&mut self, time: EpochTime, first: T) -> bool {
        let continues = self.is_paused && self.duration(time) == self.earlier;
        self.first = first;
        self.is_paused = false;
        continues
    }
}

#[cfg(test)]
mod tests {
    use carom_engine::{Observer as _, Scene, Simulation};

    use super::*;
    use crate::{CollisionRate, Pressure, PressurePoint, PressureTensor, TensorPoint};

    #[test]
    fn parts_count_by_their_length() {
        let at = EpochTime::from;
        let mut interval = OpenInterval::new(at(1.0), 2.0);
        assert_eq!(interval.mean(at(3.0), 6.0), 4.0);
        interval.pause(at(2.0), 4.0);
        assert!(interval.proceed(at(2.0), 10.0));
        // Two edits at one time.
        interval.pause(at(2.0), 10.0);
        assert!(interval.proceed(at(2.0), 7.0));
        // 3 for 1, then 8 for 3.
        assert_eq!(interval.mean(at(5.0), 9.0), 0.25 * 3.0 + 0.75 * 8.0);
        assert_eq!(interval.duration(at(5.0)), 4.0);
        // A run that continues without a pause, or later than it.
        assert!(!interval.proceed(at(5.0), 1.0));
        interval.pause(at(5.0), 1.0);
        assert!(!interval.proceed(at(6.0), 1.0));
    }

    #[test]
    #[expect(clippy::too_many_lines, reason = "one table of cases")]
    fn an_interval_with_edits_has_the_mean_of_its_parts() {
        // Inelastic, so that the pressure also falls between the edits.
        let scene = Scene::from_toml(
            "[elasticity]\ndefault = 0.95\n[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\n\
             count = 200",
        )
        .unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        let tag = simulation.find_tag("gas").unwrap();
        let new = || {
            (
                Pressure::default(),
                PressureTensor::default(),
                CollisionRate::default(),
            )
        };
        // One interval with edits, and one interval for each part.
        let (mut whole, mut parts) = (new(), new());
        whole.start(&simulation.view());
        parts.start(&simulation.view());
        for (edit, until) in [0.3, 0.4, 0.4, 1.0].into_iter().enumerate() {
            simulation
                .observe_until(until, &mut (&mut whole, &mut parts))
                .unwrap();
            parts.sample(&simulation.view());
            whole.pause(&simulation.view());
            match edit {
                0 => {
                    simulation.reset_energy_of_tag(tag, 7.0).unwrap();
                }
                1 => {
                    let keys: Vec<_> = simulation
                        .view()
                        .tagged(tag)
                        .take(60)
                        .map(|body| body.body.key())
                        .collect();
                    simulation
                        .edit(|batch| keys.iter().try_for_each(|&key| batch.remove(key)))
                        .unwrap();
                }
                // Nothing is edited: the interval continues all the same.
                2 => (),
                _ => {
                    simulation.reset_energy_of_tag(tag, 0.5).unwrap();
                }
            }
            whole.start(&simulation.view());
            parts.start(&simulation.view());
        }
        simulation
            .observe_until(2.0, &mut (&mut whole, &mut parts))
            .unwrap();
        whole.sample(&simulation.view());
        parts.sample(&simulation.view());

        let lengths = [0.3, 0.1, 0.6, 1.0];
        let mean = |values: Vec<f64>| -> f64 {
            assert_eq!(values.len(), lengths.len());
            values
                .iter()
                .zip(lengths)
                .map(|(value, length)| value * length)
                .sum::<f64>()
                / 2.0
        };
        let close = |found: f64, expected: f64| {
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        };
        let [point] = whole.0.series() else {
            panic!("{:?}", whole.0.series())
        };
        close(
            point.pressure(),
            mean(
                parts
                    .0
                    .series()
                    .iter()
                    .map(PressurePoint::pressure)
                    .collect(),
            ),
        );
        close(
            point.momentum_flux(),
            mean(
                parts
                    .0
                    .series()
                    .iter()
                    .map(PressurePoint::momentum_flux)
                    .collect(),
            ),
        );
        let [point] = whole.1.series() else {
            panic!("{:?}", whole.1.series())
        };
        close(
            point.xx(),
            mean(parts.1.series().iter().map(TensorPoint::xx).collect()),
        );
        close(
            point.yy(),
            mean(parts.1.series().iter().map(TensorPoint::yy).collect()),
        );
        let [point] = whole.2.series() else {
            panic!("{:?}", whole.2.series())
        };
        assert_eq!(point.collisions, simulation.view().counters().collisions);
        assert_eq!(
            point.collisions,
            parts
                .2
                .series()
                .iter()
                .map(|part| part.collisions)
                .sum::<u64>()
        );
        // 200 bodies for 0.4, then 140 for 1.6.
        close(
            point.rate,
            2.0 * point.collisions as f64 / (200.0 * 0.4 + 140.0 * 1.6),
        );

        // Without a pause the contacts before are unknown: the interval begins anew.
        let (mut anew, mut last) = (Pressure::default(), Pressure::default());
        anew.start(&simulation.view());
        simulation.observe_until(3.0, &mut anew).unwrap();
        anew.start(&simulation.view());
        last.start(&simulation.view());
        simulation
            .observe_until(3.5, &mut (&mut anew, &mut last))
            .unwrap();
        anew.sample(&simulation.view());
        last.sample(&simulation.view());
        assert_eq!(anew.series(), last.series());
    }
}
