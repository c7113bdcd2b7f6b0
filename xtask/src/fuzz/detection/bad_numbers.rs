//! Queries with NaN, infinite or out-of-range numbers: no panic, no hang, no NaN in the answer, no
//! wrong `Free`.

use carom_detection::{
    Answer, BoundingCircles, Detection, DiscLanes, FixedStep, GoldenSecant, Outcome, QueryBody,
    skim,
};
use carom_kinematics::Motion;
use dashu_float::{FBig, round::mode::HalfEven};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::{
    case::{CaseBody, CaseFlight},
    classes,
};
use crate::fuzz::{
    random::FuzzDraw,
    subject::{Report, exceeds},
};

type Big = FBig<HalfEven, 2>;

/// A query with arbitrary numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BadNumbers {
    /// Horizon of the search (time).
    pub horizon: f64,
    /// Lower bound on the contact time, where the search begins (time).
    pub begin: f64,
    /// The relative motion.
    pub flight: CaseFlight,
    /// The body A.
    pub a: CaseBody,
    /// The body B.
    pub b: CaseBody,
}

/// Largest length or speed in the documented range of detection.
const MAX_IN_RANGE: f64 = 1e70;

/// Boundary values of floats and of the documented range.
pub const NASTY: [f64; 25] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    -5e-324,
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    1e16,
    1e60,
    1.000_000_1e60,
    1e-60,
    1e-61,
    1e150,
    1e154,
    1e200,
    1e-160,
    1e-200,
    1e308,
    4_503_599_627_370_496.0,
];

/// A random query with up to all of its numbers replaced.
pub fn draw(seed: u64) -> BadNumbers {
    let draw = &mut FuzzDraw::new(seed);
    let query = classes::draw(draw.bits());
    let mut bad = BadNumbers {
        horizon: query.horizon,
        begin: 0.0,
        flight: query.flight,
        a: query.a,
        b: query.b,
    };
    let replaced = if draw.happens(0.1) {
        usize::MAX
    } else {
        draw.integer(1, 4) as usize
    };
    let bodies_too = draw.happens(0.3);
    let mut numbers = bad.numbers_mut(bodies_too);
    for _ in 0..replaced.min(3 * numbers.len()) {
        let index = draw.index(numbers.len());
        *numbers[index] = match draw.index(3) {
            0 => f64::from_bits(draw.bits()),
            1 => draw.sign() * libm::exp(draw.between(-700.0, 700.0)),
            _ => draw.one_of(&NASTY),
        };
    }
    bad
}

impl BadNumbers {
    fn numbers_mut(&mut self, bodies_too: bool) -> Vec<&mut f64> {
        let mut numbers = self.flight.numbers_mut();
        numbers.push(&mut self.horizon);
        numbers.push(&mut self.begin);
        if bodies_too {
            numbers.extend(self.a.numbers_mut());
            numbers.extend(self.b.numbers_mut());
        }
        numbers
    }

    /// Queries with fewer atoms, or with a number replaced by 0 or 1.
    pub fn simpler(&self) -> Vec<Self> {
        let mut list = Vec::new();
        list.extend(
            self.a
                .with_less()
                .into_iter()
                .map(|a| Self { a, ..self.clone() }),
        );
        list.extend(
            self.b
                .with_less()
                .into_iter()
                .map(|b| Self { b, ..self.clone() }),
        );
        for index in 0..self.clone().numbers_mut(true).len() {
            for plain in [0.0, 1.0] {
                let mut simpler = self.clone();
                let mut numbers = simpler.numbers_mut(true);
                if numbers[index].to_bits() == f64::to_bits(plain)
                    || (plain == 1.0 && numbers[index].to_bits() == 0)
                {
                    continue;
                }
                *numbers[index] = plain;
                list.push(simpler);
            }
        }
        list
    }
}

/// Largest number of atom pairs for detectors without certification, which take up to a million
/// steps for each pair, that is, seconds.
const MAX_PAIRS: usize = 4;

/// Calls every public function of the layer.
pub fn check(detector: &impl Detection, bad: &BadNumbers) -> Report {
    let mut report = Report::default();
    let (Ok(a), Ok(b)) = (bad.a.molecule(1.0), bad.b.molecule(1.0)) else {
        report.count("refused bodies", 1);
        return report;
    };
    report.count("bad queries", 1);
    let motion = bad.flight.motion(1.0, 1.0);
    let answer =
        detector.first_contact_after(bad.begin, a.outline(), b.outline(), &motion, bad.horizon);
    check_times("exact", &answer, bad.horizon, &mut report);
    // A lower bound on the contact time is the responsibility of the caller.
    if (bad.begin.is_nan() || bad.begin <= 0.0)
        && answer.outcome == Outcome::Free
        && let Some(doubt) = doubt(bad)
    {
        report.fail("free without proof", doubt);
    }
    let (a_outline, b_outline) = (a.outline(), b.outline());
    check_times(
        "bounding circles",
        &BoundingCircles.first_contact(a_outline, b_outline, &motion, bad.horizon),
        bad.horizon,
        &mut report,
    );
    if a.atoms().len() * b.atoms().len() <= MAX_PAIRS {
        check_times(
            "golden secant",
            &GoldenSecant::default().first_contact(a_outline, b_outline, &motion, bad.horizon),
            bad.horizon,
            &mut report,
        );
        check_times(
            "fixed step",
            &FixedStep::default().first_contact(a_outline, b_outline, &motion, bad.horizon),
            bad.horizon,
            &mut report,
        );
    }
    let reach = a.bounding_radius() + b.bounding_radius();
    if let Some(window) = skim(&motion, reach, bad.horizon)
        && (window.begin.is_nan() || window.end.is_nan())
    {
        report.fail("NaN", format!("skim: {window:?}"));
    }
    if a.wall_edge().is_none() && b.wall_edge().is_none() {
        check_lanes(detector, bad, [&a, &b], &mut report);
    }
    report
}

fn check_times(name: &str, answer: &Answer, horizon: f64, report: &mut Report) {
    let wrong = match answer.outcome {
        Outcome::Contact(contact) => exceeds(0.0, contact.time) || contact.time > horizon,
        Outcome::FreeUntil(time) | Outcome::Unresolved(time) => time.is_nan(),
        Outcome::Free | Outcome::OutOfRange => false,
    };
    if wrong {
        report.fail(
            "time out of range",
            format!("{name}: {:?}, horizon {horizon:e}", answer.outcome),
        );
    }
}

fn check_lanes(
    detector: &impl Detection,
    bad: &BadNumbers,
    [a, b]: [&carom_geometry::Molecule; 2],
    report: &mut Report,
) {
    let motion = bad.flight.motion(1.0, 1.0);
    let turning = Motion {
        orientation: motion.orientation[0],
        angular_velocity: motion.angular_velocity[0],
        time: bad.begin,
        ..Motion::at_rest(DVec2::ZERO)
    };
    let query = QueryBody::new(a.outline(), &turning, bad.horizon);
    let reach = a.bounding_radius() + b.bounding_radius();
    let mut lanes = DiscLanes::empty(motion.separation_error, motion.velocity_error);
    lanes.set_since(2, motion.separation, motion.velocity, bad.begin, reach);
    let one = DiscLanes::<1> {
        separation: [[motion.separation.x], [motion.separation.y]],
        velocity: [[motion.velocity.x], [motion.velocity.y]],
        cross: [motion.separation.perp_dot(motion.velocity)],
        contact_distance: [reach],
        separation_error: motion.separation_error,
        speed: motion.velocity_error,
    };
    let mut times = detector
        .contact_time_lower_bounds(&query, &lanes, bad.horizon)
        .to_vec();
    times.extend(detector.disc_contacts(&lanes));
    times.extend(lanes.entry_times());
    times.push(detector.contact_time_lower_bound(&query, &one, bad.horizon));
    if times.iter().any(|time| time.is_nan()) {
        report.fail("NaN", format!("lanes: {times:?}"));
    }
}

/// Reason why the answer `Free` is wrong; `None` if it is correct or the reference is undecided.
fn doubt(bad: &BadNumbers) -> Option<String> {
    let [x, y] = bad.flight.separation;
    let [u, v] = bad.flight.velocity;
    let molecules = [bad.a.molecule(1.0).ok()?, bad.b.molecule(1.0).ok()?];
    if bad.horizon < 0.0 {
        return None;
    }
    let turning = |body: usize| !molecules[body].is_disc();
    let mut numbers = vec![
        x,
        y,
        u,
        v,
        bad.flight.separation_error,
        bad.flight.velocity_error,
    ];
    for body in (0..2).filter(|&body| turning(body)) {
        // Whole turns are removed exactly, in any number.
        numbers.push(bad.flight.turns[body].fract());
        numbers.push(bad.flight.spins[body]);
        numbers.push(bad.flight.orientation_error[body]);
    }
    if let Some(number) = numbers.iter().find(|number| !number.is_finite()) {
        return Some(format!("one of the numbers is {number}"));
    }
    let beyond = numbers.iter().find(|number| number.abs() > MAX_IN_RANGE)?;
    let reach = molecules[0].bounding_radius() + molecules[1].bounding_radius();
    circles_meet([x, y], [u, v], reach, bad.horizon)
        .then(|| format!("the bounding circles meet, and one of the numbers is {beyond:e}"))
}

/// Returns true if two circles in uniform motion come within `reach` up to `horizon`, computed
/// without overflow; contacts within a relative 10⁻⁹ of the reach do not count.
fn circles_meet(place: [f64; 2], velocity: [f64; 2], reach: f64, horizon: f64) -> bool {
    let big = |x: f64| {
        Big::try_from(x)
            .expect("the numbers are finite")
            .with_precision(200)
            .value()
    };
    let ([x, y], [u, v]) = (place.map(big), velocity.map(big));
    let approach = &x * &u + &y * &v;
    let speed_squared = &u * &u + &v * &v;
    let zero = Big::ZERO;
    let nearest = if approach < zero && speed_squared > zero {
        let time = -approach / speed_squared;
        if horizon.is_finite() && time > big(horizon) {
            big(horizon)
        } else {
            time
        }
    } else {
        big(0.0)
    };
    let (x, y) = (x + u * &nearest, y + v * &nearest);
    let reach = big(reach) * big(1.0 - 1e-9);
    &x * &x + &y * &y < &reach * &reach
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn circles_meet_at_any_magnitude() {
        assert!(circles_meet([3.0, 0.0], [-1e200, 0.0], 1.0, 1.0));
        assert!(!circles_meet([3.0, 2.0], [-1e200, 0.0], 1.0, 1.0));
        assert!(!circles_meet([3.0, 0.0], [1e200, 0.0], 1.0, f64::INFINITY));
        assert!(!circles_meet([3e300, 0.0], [-1.0, 0.0], 1.0, 1e10));
        assert!(circles_meet([3e300, 0.0], [-1.0, 0.0], 1.0, f64::INFINITY));
    }
}
