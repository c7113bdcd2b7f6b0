//! Mutated encounter files: each is refused by name, or answered without NaN by each detector.

use std::{env, fmt::Write as _, fs, process};

use carom::engine::DetectorName;
use carom_detection::encounters::{Class, Encounter};
use carom_geometry::Molecule;
use carom_runs::detect::detect;

use super::mutate;
use crate::fuzz::{random::FuzzDraw, subject::Report};

/// The tested detectors.
const DETECTORS: [DetectorName; 4] = [
    DetectorName::Exact,
    DetectorName::GoldenSecant,
    DetectorName::BoundingCircles,
    DetectorName::FixedStep,
];

/// A mutated encounter file of a few lines.
pub fn draw(draw: &mut FuzzDraw) -> Vec<u8> {
    let columns = "class,id,xA,yA,vxA,vyA,thA,wA,atomsA,xB,yB,vxB,vyB,thB,wB,atomsB,window_end";
    let mut text = format!("{columns}\n");
    for id in 0..draw.integer(1, 4) {
        let class = draw.one_of(&[
            Class::Generic,
            Class::Annulus,
            Class::Graze(8),
            Class::LargeOmega,
        ]);
        let encounter = Encounter::draw(class, draw.bits() >> 1, 0);
        let motion = &encounter.motion;
        let [a, b] = encounter.molecules.each_ref().map(atoms);
        let [turn_a, turn_b] = motion
            .orientation
            .map(carom_kinematics::Orientation::radians);
        let [spin_a, spin_b] = motion.angular_velocity;
        let (place, velocity) = (motion.separation, motion.velocity);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{class},{id},0,0,0,0,{turn_a},{spin_a},{a},{},{},{},{},{turn_b},{spin_b},{b},{}",
            place.x, place.y, velocity.x, velocity.y, encounter.horizon
        );
    }
    if draw.happens(0.05) {
        text.into_bytes()
    } else {
        mutate::text(draw, &text)
    }
}

fn atoms(molecule: &Molecule) -> String {
    let atom = |atom: &carom_geometry::Atom| {
        format!(
            "{}:{}:{}:{}",
            atom.offset().x,
            atom.offset().y,
            atom.mass(),
            atom.radius()
        )
    };
    molecule
        .atoms()
        .iter()
        .map(atom)
        .collect::<Vec<_>>()
        .join(";")
}

/// Reads the file and runs the detectors on it.
pub fn check(bytes: &[u8], report: &mut Report) {
    let folder = env::temp_dir();
    let [cases, answers] = ["csv", "answers.csv"]
        .map(|ending| folder.join(format!("carom-fuzz-{}.{ending}", process::id())));
    if fs::write(&cases, bytes).is_err() {
        report.fail("disk", format!("cannot write {}", cases.display()));
        return;
    }
    for detector in DETECTORS {
        if detect(&cases, detector, &answers).is_err() {
            report.count("encounter files refused", 1);
            continue;
        }
        report.count("encounter files answered", 1);
        let text = fs::read_to_string(&answers).unwrap_or_default();
        if let Some(line) = text.lines().skip(1).find(|line| has_nan(line)) {
            report.fail("NaN", format!("{detector:?}: {line}"));
        }
    }
    // The files may not exist.
    let _ = fs::remove_file(&cases);
    let _ = fs::remove_file(&answers);
}

/// Returns true if the time in the answer is NaN; the labels of a case are arbitrary.
fn has_nan(line: &str) -> bool {
    line.rsplit(',')
        .nth(3)
        .is_some_and(|time| time.parse::<f64>().is_ok_and(f64::is_nan))
}
