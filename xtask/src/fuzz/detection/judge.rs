//! Judges the answers of a detector to one query by the oracle's search in extended precision.

use carom_detection::{
    Answer, Contact, Detection, DiscLanes, EdgeErrorBound, ErrorBound, Outcome, QueryBody, Touch,
    encounters::Encounter,
};
use carom_geometry::{Circle, gap_between};
use carom_kinematics::{HALF_ULP, Motion};
use carom_testkit::oracle::{
    DoubleDouble, ExclusionReference, Oracle, OracleVerdict, gap_over_bound,
};
use glam::DVec2;

use super::case::{Query, exp2};
use crate::fuzz::subject::{Report, exceeds};

/// Largest number of intervals for the reference in one query.
const MAX_INTERVALS: u64 = 300_000;

/// Largest bound E in roundings of the lengths involved, so that a detector cannot pass by a wider
/// E.
const MAX_BOUND: f64 = 64.0;

/// Calls every entry point of the detector and judges the answers.
pub fn check(detector: &impl Detection, query: &Query) -> Report {
    let mut report = Report::default();
    let (length, time) = (query.length_exponent, query.time_exponent);
    let (Ok(base), Ok(scaled)) = (query.encounter(), query.scaled(length, time)) else {
        report.count("refused", 1);
        return report;
    };
    if begins_deep(&base) {
        report.count("begun in overlap", 1);
        return report;
    }
    report.count("queries", 1);
    refuse_wide_bounds(&base, &mut report);
    refuse_wide_bounds_of_edges(&base, &mut report);
    let reference = Oracle {
        most_intervals: MAX_INTERVALS,
    }
    .first_contact::<DoubleDouble>(&base);
    if matches!(reference, ExclusionReference::Unresolved) {
        report.count("undecided", 1);
    }
    let judge = Judge {
        base: &base,
        reference: &reference,
        factor: exp2(-time),
    };
    let answer = ask(detector, &scaled, 0.0);
    judge.judge("", &answer, scaled.horizon, &mut report);
    match answer.outcome {
        Outcome::Contact(_) => report.count("contacts", 1),
        Outcome::FreeUntil(_) => report.count("certified in part", 1),
        Outcome::Free | Outcome::Unresolved(_) | Outcome::OutOfRange => {}
    }
    check_exchange(detector, &scaled, &answer, &mut report);
    check_velocities(detector, query, &mut report);
    if base
        .molecules
        .iter()
        .all(|molecule| molecule.wall_edge().is_none())
    {
        check_bounds(detector, &scaled, &judge, &mut report);
    }
    report
}

/// The guarantees of the detector apply to pairs that start separated, or in an overlap of some
/// roundings.
const MAX_OVERLAP: f64 = 1e-9;

/// Returns true if the initial overlap of the bodies is above rounding.
fn begins_deep(encounter: &Encounter) -> bool {
    let [a, b] = &encounter.molecules;
    let [turn_a, turn_b] = encounter
        .motion
        .orientation
        .map(carom_kinematics::Orientation::cos_sin);
    let atom_radii = a
        .atoms()
        .iter()
        .chain(b.atoms())
        .map(carom_geometry::Atom::radius);
    let smallest = atom_radii
        .filter(|&radius| radius > 0.0)
        .fold(f64::INFINITY, f64::min);
    let rounding = 1e3 * encounter.motion.separation_error;
    gap_between(a, turn_a, b, turn_b, encounter.motion.separation)
        < -MAX_OVERLAP * smallest - rounding
}

fn ask(detector: &impl Detection, encounter: &Encounter, begin: f64) -> Answer {
    let [a, b] = encounter
        .molecules
        .each_ref()
        .map(carom_geometry::Molecule::outline);
    detector.first_contact_after(begin, a, b, &encounter.motion, encounter.horizon)
}

struct Judge<'a> {
    base: &'a Encounter,
    reference: &'a ExclusionReference<DoubleDouble>,
    /// Factor from times of the scaled query to those at scale 1.
    factor: f64,
}

impl Judge<'_> {
    /// Judges one answer at the scale of the query.
    fn judge(&self, way: &str, answer: &Answer, horizon: f64, report: &mut Report) {
        let answer = match answer.outcome {
            Outcome::Contact(contact) if !(0.0..=horizon).contains(&contact.time) => {
                return report.fail(
                    "time out of range",
                    format!("{way}{contact:?}, horizon {horizon:e}"),
                );
            }
            Outcome::Contact(contact) => Answer {
                outcome: Outcome::Contact(Contact {
                    time: self.factor * contact.time,
                    ..contact
                }),
                ..*answer
            },
            Outcome::FreeUntil(time) if time.is_nan() || time <= 0.0 => {
                return report.fail("time out of range", format!("{way}free until {time:e}"));
            }
            Outcome::FreeUntil(time) => Answer {
                outcome: Outcome::FreeUntil(self.factor * time),
                ..*answer
            },
            Outcome::Free | Outcome::Unresolved(_) | Outcome::OutOfRange => *answer,
        };
        let Some(judgement) = self.reference.judge(self.base, &answer) else {
            return;
        };
        let kind = match judgement.verdict {
            OracleVerdict::Right | OracleVerdict::Graze | OracleVerdict::FreeUntil => {
                if let Outcome::Contact(contact) = answer.outcome
                    && let Some(gap) = gap_over_bound::<DoubleDouble>(self.base, &contact)
                {
                    report.keep_worst("gap/E", gap.abs());
                }
                return;
            }
            OracleVerdict::Missed => "missed",
            OracleVerdict::Late => "late",
            OracleVerdict::Early => "early",
            OracleVerdict::False => "false contact",
            OracleVerdict::GaveUp => "gave up",
        };
        let reference = match self.reference {
            ExclusionReference::Deep(deep) => {
                use carom_testkit::oracle::Number as _;
                format!(
                    "{:?} touch at {:e} and overlap by more than 2 E at {:e}",
                    deep.parts,
                    deep.touch.value(),
                    deep.time.value()
                )
            }
            _ => "there is no contact deeper than 2 E".to_owned(),
        };
        report.fail(
            kind,
            format!("{way}{:?}; reference: {reference}", answer.outcome),
        );
    }
}

/// Checks that exchanging A and B changes no bit of the time.
fn check_exchange(
    detector: &impl Detection,
    encounter: &Encounter,
    answer: &Answer,
    report: &mut Report,
) {
    let exchanged = ask(detector, &encounter.clone().exchanged(), 0.0);
    let bits = |answer: &Answer| match answer.outcome {
        Outcome::Contact(contact) => (0, contact.time.to_bits()),
        Outcome::Free => (1, 0),
        Outcome::FreeUntil(time) => (2, time.to_bits()),
        Outcome::Unresolved(time) => (3, time.to_bits()),
        Outcome::OutOfRange => (4, 0),
    };
    if bits(answer) != bits(&exchanged) {
        let (one, other) = (answer.outcome, exchanged.outcome);
        report.fail("exchange", format!("{one:?}, but exchanged {other:?}"));
    }
}

/// Checks that velocities times a moderate power of two change only the exponent of the time.
fn check_velocities(detector: &impl Detection, query: &Query, report: &mut Report) {
    let [one, other] = [0, 40].map(|exponent| query.scaled(0, exponent));
    let (Ok(one), Ok(other)) = (one, other) else {
        return;
    };
    let time = |encounter: &Encounter, factor: f64| {
        ask(detector, encounter, 0.0)
            .outcome
            .contact()
            .map(|contact| ((factor * contact.time).to_bits(), contact.touch))
    };
    let (one, other) = (time(&one, 1.0), time(&other, exp2(-40)));
    if one != other {
        let times =
            [one, other].map(|contact| contact.map(|(bits, touch)| (f64::from_bits(bits), touch)));
        report.fail("power of two", format!("velocities × 2^-40: {times:?}"));
    }
}

/// Checks that the lower bounds used by schedulers are no later than the contact, and that a search
/// from there finds it.
fn check_bounds(
    detector: &impl Detection,
    encounter: &Encounter,
    judge: &Judge<'_>,
    report: &mut Report,
) {
    let [a, b] = &encounter.molecules;
    let motion = &encounter.motion;
    let turning = Motion {
        orientation: motion.orientation[0],
        angular_velocity: motion.angular_velocity[0],
        ..Motion::at_rest(DVec2::ZERO)
    };
    let mut query = QueryBody::new(a.outline(), &turning, 0.0);
    query.rotation_error += motion.orientation_error[0];
    let reach = a.bounding_radius() + b.bounding_radius();
    let lane = |v: DVec2| [[v.x], [v.y]];
    let lanes = DiscLanes::<1> {
        separation: lane(motion.separation),
        velocity: lane(motion.velocity),
        cross: [motion.separation.perp_dot(motion.velocity)],
        contact_distance: [reach],
        separation_error: motion.separation_error,
        speed: motion.velocity.x.abs() + motion.velocity.y.abs() + motion.velocity_error / HALF_ULP,
    };
    let [bound] = detector.contact_time_lower_bounds(&query, &lanes, encounter.horizon);
    let mut bounds = vec![("entry bound", bound)];
    if b.is_disc() {
        bounds.push((
            "bound of one disc",
            detector.contact_time_lower_bound(&query, &lanes, encounter.horizon),
        ));
    }
    for (name, bound) in bounds {
        if bound.is_nan() {
            report.fail("NaN", name);
        }
        // The bound is for the bounding circle of B; the contact of its atoms is later.
        let bound = bound.min(encounter.horizon);
        let free = Answer {
            outcome: Outcome::FreeUntil(bound),
            evaluations: 0,
        };
        if bound > 0.0 {
            report.count("bounds", 1);
            judge.judge(&format!("{name}: "), &free, encounter.horizon, report);
            let answer = ask(detector, encounter, bound);
            judge.judge(
                &format!("search after the {name}: "),
                &answer,
                encounter.horizon,
                report,
            );
        }
    }
    if a.is_disc() && b.is_disc() {
        check_eight_lanes(detector, encounter, &lanes, judge, report);
    }
}

/// Checks the contact time of two discs, by the search that treats eight discs at once.
fn check_eight_lanes(
    detector: &impl Detection,
    encounter: &Encounter,
    lanes: &DiscLanes<1>,
    judge: &Judge<'_>,
    report: &mut Report,
) {
    let motion = &encounter.motion;
    let mut eight = DiscLanes::empty(lanes.separation_error, lanes.speed);
    eight.set(
        3,
        motion.separation,
        motion.velocity,
        lanes.contact_distance[0],
    );
    let time = detector.disc_contacts(&eight)[3];
    let outcome = if time <= encounter.horizon {
        Outcome::Contact(Contact {
            time,
            touch: Touch::Atoms(0, 0),
        })
    } else {
        Outcome::Free
    };
    judge.judge(
        "lanes: ",
        &Answer {
            outcome,
            evaluations: 1,
        },
        encounter.horizon,
        report,
    );
}

/// Checks that E is at most some roundings of the lengths involved plus the errors of the query.
fn refuse_wide_bounds(encounter: &Encounter, report: &mut Report) {
    let (motion, time) = (&encounter.motion, encounter.horizon);
    let [a, b] = &encounter.molecules;
    for atom_a in a.atoms() {
        for atom_b in b.atoms() {
            let arms = [atom_a.arm(), atom_b.arm()];
            let rims = motion.angular_velocity[0].abs() * arms[0]
                + motion.angular_velocity[1].abs() * arms[1];
            let lengths = motion.separation.length()
                + motion.velocity.length() * time
                + rims * time
                + arms[0]
                + arms[1]
                + atom_a.radius()
                + atom_b.radius();
            let given = motion.separation_error
                + arms[0] * motion.orientation_error[0]
                + arms[1] * motion.orientation_error[1];
            let allowed = MAX_BOUND * HALF_ULP * lengths + 2.0 * given;
            let bound = ErrorBound::new(motion, atom_a, atom_b).at(time);
            if exceeds(bound, allowed) {
                return report.fail(
                    "bound too wide",
                    format!("E = {bound:e}, expected at most {allowed:e}"),
                );
            }
        }
    }
}

/// Checks that E of atoms and edges is at most some roundings of the lengths involved plus the
/// errors of the query.
fn refuse_wide_bounds_of_edges(encounter: &Encounter, report: &mut Report) {
    let (motion, time) = (&encounter.motion, encounter.horizon);
    for (body, molecule) in encounter.molecules.iter().enumerate() {
        let [spin, fast] = [body, 1 - body].map(|index| motion.angular_velocity[index].abs());
        for edge in encounter.molecules[1 - body].edges() {
            for atom in molecule.atoms() {
                let way = motion.separation.length() + motion.velocity.length() * time;
                let near = edge.reach() + edge.radius() + atom.radius() + 2.0 * atom.arm();
                // An edge at rest may be a long wall, which the atom passes anywhere.
                let far = if fast == 0.0 { way + near } else { near };
                let lengths = way + near + (spin * atom.arm() + fast * near) * time;
                let given = motion.separation_error
                    + atom.arm() * motion.orientation_error[body]
                    + far * motion.orientation_error[1 - body];
                let allowed = MAX_BOUND * HALF_ULP * lengths + 2.0 * given;
                let bound = EdgeErrorBound::new(motion, body, &Circle::from(atom), edge).at(time);
                if exceeds(bound, allowed) {
                    return report.fail(
                        "bound too wide",
                        format!("E = {bound:e} of an edge, expected at most {allowed:e}"),
                    );
                }
            }
        }
    }
}
