//! The window of time in which a body is within reach of a straight edge that does not turn.

use carom_geometry::{Edge, Outline};
use carom_kinematics::{HALF_ULP as U, RelativeMotion};

use crate::{SearchWindow, error_bound::one_norm, skim, tolerance::STEP_MARGIN};

/// A strip on either side of a line, or the half-plane behind it, and a point in uniform motion.
#[derive(Clone, Copy)]
pub(crate) struct Strip {
    /// Signed distance of the point from the line (length).
    place: f64,
    /// Its rate, and a bound on the rounding of the rate (length per time).
    rate: f64,
    rate_error: f64,
    /// Half the width of the strip, inflated by rounding (length).
    reach: f64,
}

impl Strip {
    /// The window of time in which the centre of body number `body` is within `room` (length) of a
    /// edge of the other body, up to `horizon`. The window is never too short. `None` if the centre
    /// stays farther away.
    pub(crate) fn window(
        motion: &RelativeMotion,
        body: usize,
        edge: &Edge,
        room: f64,
        horizon: f64,
    ) -> Option<SearchWindow> {
        let wall = 1 - body;
        let along = motion.orientation[wall].cos_sin().rotate(edge.along());
        let sign = if body == 1 { 1.0 } else { -1.0 };
        let (place, velocity) = (sign * motion.separation, sign * motion.velocity);
        // The error of the direction of the edge is 12 u; see `EdgeErrorBound`.
        let tilt = motion.orientation_error[wall] + 16.0 * U;
        let (middle, arm) = (edge.middle(), edge.middle().length());
        let strip = |direction: glam::DVec2, middle: f64, reach: f64| Self {
            place: direction.dot(place) - middle,
            rate: direction.dot(velocity),
            rate_error: tilt * one_norm(velocity),
            reach: reach
                + (motion.separation_error
                    + 2.0 * tilt * (one_norm(place) + reach)
                    + 8.0 * U * arm),
        };
        let whole = SearchWindow {
            begin: 0.0,
            end: horizon,
        };
        let room = room + edge.radius();
        let (of_line, of_middle) = (edge.normal().dot(middle), edge.along().dot(middle));
        let across = strip(along.perp(), of_line, room).within(whole, edge.is_solid_behind())?;
        strip(along, of_middle, edge.half_length() + room).within(across, false)
    }

    /// The part of a window in which the point is in the strip.
    fn within(self, window: SearchWindow, also_behind: bool) -> Option<SearchWindow> {
        let mirrored = !also_behind && self.place < 0.0;
        let (place, rate) = if mirrored {
            (-self.place, -self.rate)
        } else {
            (self.place, self.rate)
        };
        let begin = if place > self.reach {
            let fastest = self.rate_error - rate;
            if fastest <= 0.0 {
                return None;
            }
            (place - self.reach) / fastest * (1.0 - STEP_MARGIN)
        } else {
            0.0
        };
        let slowest = rate.abs() - self.rate_error;
        let way = match (rate > 0.0, also_behind) {
            (true, _) => self.reach - place,
            (false, true) => f64::INFINITY,
            (false, false) => self.reach + place,
        };
        let end = if slowest > 0.0 {
            (way / slowest).max(0.0) * (1.0 + STEP_MARGIN)
        } else {
            f64::INFINITY
        };
        let (begin, end) = (begin.max(window.begin), end.min(window.end));
        (begin <= end).then_some(SearchWindow { begin, end })
    }
}

/// The window of time in which two bodies are within reach, up to `horizon`: their bounding circles
/// overlap, or the bounding circle of one is near the edge of a wall that does not turn.
pub(crate) fn window_of_bodies(
    a: Outline<'_>,
    b: Outline<'_>,
    motion: &RelativeMotion,
    horizon: f64,
) -> Option<SearchWindow> {
    let [spin_a, spin_b] = motion.angular_velocity;
    let stands = |body: Outline<'_>, spin: f64| {
        body.is_wall() && spin == 0.0 && body.edges().iter().all(|edge| edge.bend().is_none())
    };
    if !stands(a, spin_a) && !stands(b, spin_b) {
        return skim(motion, a.bounding_radius + b.bounding_radius, horizon);
    }
    let mut window = SearchWindow {
        begin: 0.0,
        end: horizon,
    };
    for (body, outline, other, spin) in [(0, a, b, spin_b), (1, b, a, spin_a)] {
        if stands(other, spin) {
            for edge in other.edges() {
                let near = Strip::window(motion, body, edge, outline.bounding_radius, window.end)?;
                window.begin = window.begin.max(near.begin);
                window.end = near.end;
            }
        }
    }
    (window.begin <= window.end).then_some(window)
}

/// Whether the detectors that sample the gap of discs and edges do not search a pair: a half-plane
/// that turns, ellipses, and arcs.
pub(crate) fn is_not_searched(a: Outline<'_>, b: Outline<'_>, motion: &RelativeMotion) -> bool {
    a_half_plane_turns(a, b, motion) || [a, b].iter().any(Outline::has_curves)
}

/// Whether a half-plane turns, which no detector handles: it reaches everything at once.
pub(crate) fn a_half_plane_turns(a: Outline<'_>, b: Outline<'_>, motion: &RelativeMotion) -> bool {
    [a, b]
        .iter()
        .zip(motion.angular_velocity)
        .any(|(body, spin)| body.bounding_radius == f64::INFINITY && spin != 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_geometry::{HalfPlane, Molecule};
    use glam::DVec2;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_window_holds_every_moment_within_reach(
            x in -5.0..5.0f64, y in -5.0..5.0f64, vx in -2.0..2.0f64, vy in -2.0..2.0f64,
            length in 0.1..6.0f64, angle in -3.0..3.0f64, room in 0.1..2.0f64, t in 0.0..10.0f64, parallel in any::<bool>(),
        ) {
            let span = length * DVec2::from_angle(angle);
            let velocity = if parallel { vx * span } else { DVec2::new(vx, vy) };
            let wall = Molecule::wall(span, 0.05).unwrap();
            let half_plane = HalfPlane::new(span.perp()).unwrap();
            for edge in [&wall.edges()[0], &half_plane.outline().edges()[0]] {
                for body in [0, 1] {
                    let sign = if body == 1 { 1.0 } else { -1.0 };
                    let motion = RelativeMotion::exactly(sign * DVec2::new(x, y), sign * velocity);
                    let place = DVec2::new(x, y) + velocity * t;
                    let within = edge.nearest(place).distance <= edge.radius() + room;
                    let window = Strip::window(&motion, body, edge, room, 10.0);
                    let inside = window.is_some_and(|w| (w.begin..=w.end).contains(&t));
                    prop_assert!(!within || inside, "{window:?} misses {t}");
                }
            }
        }
    }

    #[test]
    fn a_body_that_flies_past_has_no_window() {
        let wall = Molecule::wall(DVec2::new(0.0, 2.0), 0.0).unwrap();
        let edge = &wall.edges()[0];
        let ask = |place: DVec2, velocity: DVec2| {
            Strip::window(
                &RelativeMotion::exactly(place, velocity),
                1,
                edge,
                0.5,
                100.0,
            )
        };
        // Away from the wall, along it, and past its end.
        assert_eq!(ask(DVec2::new(1.0, 0.0), DVec2::X), None);
        assert_eq!(ask(DVec2::new(1.0, 0.0), DVec2::Y), None);
        assert_eq!(ask(DVec2::new(5.0, 0.0), DVec2::new(-1.0, 1.0)), None);
        let through = ask(DVec2::new(5.5, 0.0), DVec2::NEG_X).unwrap();
        assert!(
            (through.begin - 5.0).abs() < 1e-13 && (through.end - 6.0).abs() < 1e-13,
            "{through:?}"
        );
    }
}
