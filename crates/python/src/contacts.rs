//! Detection alone: the first contacts of many pairs of molecules.

use carom::{
    BoundingCircles, Detection, Exact, FixedStep, GoldenSecant,
    engine::DetectorName,
    kinematics::{Motion, Orientation},
};
use carom_detection::{Outcome, Part, Touch};
use carom_runs::{detect, encounters::EncounterRecord};
use glam::DVec2;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::{exceptions::PyValueError, prelude::*};

use crate::{arrays::rows, molecule::MoleculeCore};

/// Times (infinite without contact), atoms (−1 without), and outcome (0 free, 1 contact, 2
/// undecided, 3 out of range).
type Answers<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<i64>>,
    Bound<'py, PyArray1<u8>>,
);

/// Times, atoms and outcomes, as in `Answers`.
type Found = (Vec<f64>, Vec<i64>, Vec<u8>);

/// Pairs between two looks for Ctrl-C.
const PAIRS_AT_ONCE: usize = 1024;

/// The first contact of each pair. The columns of `motions` are the separation from A to B, the
/// velocity of B relative to A, the angles and the angular velocities of A and B.
#[pyfunction]
pub fn first_contact<'py>(
    py: Python<'py>,
    a: &MoleculeCore,
    b: &MoleculeCore,
    motions: PyReadonlyArray2<'py, f64>,
    until: PyReadonlyArray1<'py, f64>,
    detector: &str,
) -> PyResult<Answers<'py>> {
    let (motions, until) = (motions.as_slice()?, until.as_slice()?);
    if motions.len() != 8 * until.len() {
        return Err(PyValueError::new_err(
            "there must be 8 numbers and a limit for each pair",
        ));
    }
    let molecules = [a.0.clone(), b.0.clone()];
    let detector: DetectorName = detector
        .parse()
        .map_err(|error| PyValueError::new_err(format!("`detector`: {error}")))?;
    let mut found = Found::default();
    for (motions, until) in motions
        .chunks(8 * PAIRS_AT_ONCE)
        .zip(until.chunks(PAIRS_AT_ONCE))
    {
        let molecules = molecules.clone();
        let (times, atoms, outcomes) = py.detach(|| match detector {
            DetectorName::Exact => search(&Exact::default(), molecules, motions, until),
            DetectorName::GoldenSecant => {
                search(&GoldenSecant::default(), molecules, motions, until)
            }
            DetectorName::FixedStep => search(&FixedStep::default(), molecules, motions, until),
            DetectorName::BoundingCircles => search(&BoundingCircles, molecules, motions, until),
        });
        found.0.extend(times);
        found.1.extend(atoms);
        found.2.extend(outcomes);
        py.check_signals()?;
    }
    let (times, atoms, outcomes) = found;
    Ok((
        PyArray1::from_vec(py, times),
        rows(py, atoms, 2)?,
        PyArray1::from_vec(py, outcomes),
    ))
}

/// The index of the atom that touches an edge; −1 for a bounding circle.
fn atom(part: Part) -> i64 {
    match part {
        Part::Atom(index) => i64::from(index),
        Part::BoundingCircle => -1,
    }
}

fn search(
    detector: &impl Detection,
    molecules: [carom::Molecule; 2],
    motions: &[f64],
    until: &[f64],
) -> Found {
    let still = [Motion::at_rest(DVec2::ZERO); 2];
    let (class, id, window_end, expected) = (String::new(), String::new(), None, None);
    let mut pair = EncounterRecord {
        class,
        id,
        molecules,
        motions: still,
        window_end,
        expected,
    };
    let (mut times, mut atoms, mut outcomes) = (Vec::new(), Vec::new(), Vec::new());
    for (numbers, &until) in motions.chunks_exact(8).zip(until) {
        let body = |place: DVec2, velocity: DVec2, which: usize| Motion {
            velocity,
            orientation: Orientation::from_radians(numbers[4 + which]),
            angular_velocity: numbers[6 + which],
            ..Motion::at_rest(place)
        };
        let (place, velocity) = (
            DVec2::new(numbers[0], numbers[1]),
            DVec2::new(numbers[2], numbers[3]),
        );
        pair.motions = [body(DVec2::ZERO, DVec2::ZERO, 0), body(place, velocity, 1)];
        pair.window_end = until.is_finite().then_some(until);
        let (time, touch, outcome) = match detect::first_contact(detector, &pair).outcome {
            Outcome::Contact(contact) => match contact.touch {
                Touch::Atoms(a, b) => (contact.time, [i64::from(a), i64::from(b)], 1),
                Touch::EdgeOfA { part, .. } => (contact.time, [-1, atom(part)], 1),
                Touch::EdgeOfB { part, .. } => (contact.time, [atom(part), -1], 1),
                Touch::BoundingCircles => (contact.time, [-1; 2], 1),
            },
            Outcome::Free => (f64::INFINITY, [-1; 2], 0),
            Outcome::FreeUntil(time) | Outcome::Unresolved(time) => (time, [-1; 2], 2),
            Outcome::OutOfRange => (f64::NAN, [-1; 2], 3),
        };
        times.push(time);
        atoms.extend(touch);
        outcomes.push(outcome);
    }
    (times, atoms, outcomes)
}
