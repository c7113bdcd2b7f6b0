//! Skimming: the window of time in which two circles about the centres of mass are within reach.

use carom_kinematics::{HALF_ULP as U, RelativeMotion};

use crate::{error_bound::one_norm, tolerance::STEP_MARGIN};

/// An interval of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchWindow {
    /// Its begin (time from now).
    pub begin: f64,
    /// Its end (time from now).
    pub end: f64,
}

/// Returns the window of time in which the centres of two bodies are within `reach` (length), up to
/// `horizon`; `None` if they stay farther apart.
///
/// The squared distance of the centres is a parabola in time (Montanari 2017, equations 2.1 to
/// 2.3). The window is never too short: `reach` is enlarged by the rounding of the positions, and
/// the edges are moved outwards by the rounding of the roots. The discriminant is computed as
/// reach² v² − (X × V)², which keeps its digits on grazes, where b² − a c loses them.
///
/// If a square overflows or a number is NaN, the window is the whole time up to the horizon.
pub fn skim(motion: &RelativeMotion, reach: f64, horizon: f64) -> Option<SearchWindow> {
    let (x, v) = (motion.separation, motion.velocity);
    let horizon = if horizon.is_nan() {
        f64::INFINITY
    } else {
        horizon
    };
    let reach = reach + rounding_within(motion, reach);
    let c = x.length_squared() - reach * reach;
    let v_squared = v.length_squared();
    if v_squared == 0.0 {
        return (c <= 0.0).then_some(SearchWindow {
            begin: 0.0,
            end: horizon,
        });
    }
    let b = x.dot(v);
    let cross = x.perp_dot(v);
    let discriminant = reach * reach * v_squared - cross * cross;
    if !(c + discriminant).is_finite() {
        return Some(SearchWindow {
            begin: 0.0,
            end: horizon,
        });
    }
    if c > 0.0 && (b >= 0.0 || discriminant < 0.0) {
        return None;
    }
    let root = discriminant.max(0.0).sqrt();
    let begin = if c > 0.0 {
        c / (root - b) * (1.0 - STEP_MARGIN)
    } else {
        0.0
    };
    let end = if b <= 0.0 {
        (root - b) / v_squared
    } else {
        -c / (root + b)
    };
    let end = (end * (1.0 + STEP_MARGIN)).min(horizon);
    (begin <= end).then_some(SearchWindow { begin, end })
}

/// A bound on the rounding of the distance of the centres while they are within `reach` (length).
/// |V t| is then at most |X| + reach, so the bound covers X + V t.
#[inline]
pub(crate) fn rounding_within(motion: &RelativeMotion, reach: f64) -> f64 {
    motion.separation_error + 16.0 * U * (one_norm(motion.separation) + reach)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_window_holds_every_moment_within_reach(
            x in -5.0..5.0f64, y in -5.0..5.0f64, vx in -2.0..2.0f64, vy in -2.0..2.0f64,
            reach in 0.1..3.0f64, t in 0.0..10.0f64,
        ) {
            let motion = RelativeMotion::exactly(DVec2::new(x, y), DVec2::new(vx, vy));
            let within = (motion.separation + motion.velocity * t).length() <= reach;
            let window = skim(&motion, reach, 10.0);
            let inside = window.is_some_and(|w| (w.begin..=w.end).contains(&t));
            prop_assert!(!within || inside, "{window:?} misses {t}");
        }
    }

    #[test]
    fn equal_velocities_give_all_or_nothing() {
        let near = RelativeMotion::exactly(DVec2::new(1.0, 0.0), DVec2::ZERO);
        assert_eq!(
            skim(&near, 1.5, 7.0),
            Some(SearchWindow {
                begin: 0.0,
                end: 7.0
            })
        );
        assert_eq!(skim(&near, 0.5, 7.0), None);
    }
}
