//! The path of a wall with a table of places, computed from the table, with double-double places.

use carom::engine::WallMotionSpec;
use carom_kinematics::EpochTime;
use carom_testkit::oracle::{DoubleDouble, Number as _};

use super::{
    durations::duration,
    vectors::{BodyPair, along, length},
};

/// Largest number of places of a table.
pub const MAX_PLACES: usize = 8;

/// The path of a wall through the places of a table, from the time on at which it was given it.
#[derive(Debug, Clone, Copy)]
pub struct TablePath {
    times: [f64; MAX_PLACES],
    places: [BodyPair; MAX_PLACES],
    /// Number of times and places.
    count: usize,
    repeats: bool,
    /// A time, and the time of the table then.
    since: EpochTime,
    begin: f64,
    /// True if the wall returns on its path until the next time of the table, and then goes on
    /// with it.
    returns: bool,
}

impl TablePath {
    /// The path of a wall that is given a motion at `time`; `None` if the motion has no table, or
    /// one of more than [`MAX_PLACES`] places.
    pub fn new(spec: &WallMotionSpec, time: EpochTime) -> Option<Self> {
        let count = spec.times.len();
        if !(2..=MAX_PLACES).contains(&count) || spec.places.len() != count {
            return None;
        }
        let (mut times, mut places) = ([0.0; MAX_PLACES], [[0.0; 2]; MAX_PLACES]);
        times[..count].copy_from_slice(&spec.times);
        places[..count].copy_from_slice(&spec.places);
        Some(Self {
            times,
            places,
            count,
            repeats: spec.repeat,
            since: time,
            begin: 0.0,
            returns: false,
        })
    }

    /// The path of the wall after a reversal of all velocities at `time`.
    #[must_use]
    pub fn reversed(&self, time: EpochTime) -> Self {
        let begin = self.begin + duration(self.since, time).value();
        let is_in_piece = self.piece_at(begin).0 == self.piece_at(self.begin).0;
        let has_returned = self.returns && is_in_piece;
        Self {
            since: time,
            begin,
            returns: !has_returned,
            ..*self
        }
    }

    /// Duration of the table (time).
    pub fn period(&self) -> f64 {
        self.times[self.count - 1]
    }

    /// The number of a piece of the table, counted on in each repetition, and the time at which it
    /// ends; the last one of a table without repetition does not end.
    fn piece_at(&self, passed: f64) -> (usize, f64) {
        let (period, pieces) = (self.period(), self.count - 1);
        if !self.repeats && passed >= period {
            return (pieces, f64::INFINITY);
        }
        let rounds = if self.repeats {
            (passed / period).floor()
        } else {
            0.0
        };
        let within = passed - rounds * period;
        let ends = self.times[1..self.count].iter();
        let piece = ends.filter(|&&end| end <= within).count().min(pieces - 1);
        let end = rounds * period + self.times[piece + 1];
        (rounds as usize * pieces + piece, end)
    }

    /// The velocity of a piece (length per time).
    fn velocity_of(&self, piece: usize) -> BodyPair {
        let pieces = self.count - 1;
        if piece >= pieces && !self.repeats {
            return [0.0; 2];
        }
        let piece = piece % pieces;
        let way = along(self.places[piece + 1], -1.0, self.places[piece]);
        let lasts = self.times[piece + 1] - self.times[piece];
        way.map(|way| way / lasts)
    }

    /// Way of the table from its start (length).
    fn way_at(&self, passed: &DoubleDouble) -> [DoubleDouble; 2] {
        let (piece, _) = self.piece_at(passed.value());
        let pieces = self.count - 1;
        let (rounds, piece) = if self.repeats {
            (piece / pieces, piece % pieces)
        } else {
            (0, piece)
        };
        let before = DoubleDouble::new(rounds as f64);
        let since = passed
            .minus(&before.times(&DoubleDouble::new(self.period())))
            .minus(&DoubleDouble::new(self.times[piece]));
        let velocity = self.velocity_of(piece);
        [0, 1].map(|axis| {
            let difference = |from: usize, to: usize| {
                let [from, to] = [from, to].map(|at| DoubleDouble::new(self.places[at][axis]));
                to.minus(&from)
            };
            let of_rounds = before.times(&difference(0, pieces));
            let of_piece = DoubleDouble::new(velocity[axis]).times(&since);
            of_rounds.plus(&difference(0, piece)).plus(&of_piece)
        })
    }

    /// The time of the table at `time`.
    fn passed_at(&self, time: EpochTime) -> DoubleDouble {
        DoubleDouble::new(self.begin).plus(&duration(self.since, time))
    }

    /// Displacement at a time from the place at which the wall was given the path, or at the last
    /// reversal (length).
    pub fn displacement(&self, time: EpochTime) -> [DoubleDouble; 2] {
        let begin = DoubleDouble::new(self.begin);
        let passed = self.passed_at(time);
        let [here, start] = [&passed, &begin].map(|passed| self.way_at(passed));
        let ways = [0, 1].map(|axis| here[axis].minus(&start[axis]));
        let (piece, end) = self.piece_at(self.begin);
        if !self.returns {
            return ways;
        }
        // The wall has gone back, by what it would have gone on, until the end of the piece.
        let until = if passed.value() < end {
            passed.value()
        } else {
            end
        };
        let lasted = DoubleDouble::new(until).minus(&begin);
        let velocity = self.velocity_of(piece);
        [0, 1].map(|axis| {
            let back = DoubleDouble::new(2.0 * velocity[axis]).times(&lasted);
            ways[axis].minus(&back)
        })
    }

    /// Velocity at a time (length per time).
    pub fn velocity(&self, time: EpochTime) -> BodyPair {
        let piece = self.piece_at(self.passed_at(time).value()).0;
        let velocity = self.velocity_of(piece);
        if self.returns && piece == self.piece_at(self.begin).0 {
            velocity.map(|v| -v)
        } else {
            velocity
        }
    }

    /// The highest speed (length per time).
    pub fn top_speed(&self) -> f64 {
        let speeds = (0..self.count - 1).map(|piece| length(self.velocity_of(piece)));
        speeds.fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(repeat: bool) -> TablePath {
        let spec = WallMotionSpec {
            times: vec![0.0, 1.0, 3.0, 4.0],
            places: vec![[1.0, 0.0], [2.0, 0.0], [2.0, -1.0], [1.5, -1.0]],
            repeat,
            ..WallMotionSpec::default()
        };
        TablePath::new(&spec, EpochTime::from(2.0)).unwrap()
    }

    fn place(path: &TablePath, passed: f64) -> BodyPair {
        let time = EpochTime::from(2.0).after(passed);
        path.displacement(time).map(|one| one.value())
    }

    #[test]
    fn a_wall_passes_the_places_of_a_table() {
        for (passed, expected) in [
            (0.0, [0.0, 0.0]),
            (0.5, [0.5, 0.0]),
            (2.0, [1.0, -0.5]),
            (3.5, [0.75, -1.0]),
        ] {
            assert_eq!(place(&path(false), passed), expected);
            assert_eq!(place(&path(true), passed), expected);
        }
        assert_eq!(place(&path(false), 7.0), [0.5, -1.0]);
        assert_eq!(place(&path(true), 8.5), [1.5, -2.0]);
        let at = |passed: f64| EpochTime::from(2.0).after(passed);
        assert_eq!(path(true).velocity(at(4.5)), [1.0, 0.0]);
        assert_eq!(path(false).velocity(at(4.5)), [0.0, 0.0]);
        assert_eq!(path(false).top_speed(), 1.0);
    }

    #[test]
    fn a_reversed_wall_returns_until_the_next_place_of_its_table() {
        let reversed = path(true).reversed(EpochTime::from(2.75));
        let at = |passed: f64| EpochTime::from(2.0).after(passed);
        let way = |passed: f64| reversed.displacement(at(passed)).map(|one| one.value());
        assert_eq!(way(0.875), [-0.125, 0.0]);
        assert_eq!(way(2.0), [-0.25, -0.5]);
        assert_eq!(reversed.velocity(at(0.875)), [-1.0, 0.0]);
        assert_eq!(reversed.velocity(at(2.0)), [0.0, -0.5]);
        // A second reversal within the piece restores its velocity.
        let twice = reversed.reversed(at(0.875));
        assert_eq!(twice.velocity(at(0.9)), [1.0, 0.0]);
    }
}
