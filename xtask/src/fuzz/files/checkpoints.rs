//! Mutated checkpoints: an altered file is refused; one with a correct checksum is refused by name
//! or runs.

use std::{env, fs, process};

use carom::engine::{Checkpoint, Scene};
use carom_kinematics::EpochTime;
use carom_methods::{AnySimulation, Method};
use carom_runs::checkpoint_file::{self, CheckpointBody, decode, encode};

use super::{mutate, scene_files};
use crate::fuzz::{random::FuzzDraw, scenes, subject::Report};

/// Encoded state of a small scene after some epochs.
fn sound(draw: &mut FuzzDraw) -> Vec<u8> {
    let mut scene = scenes::draw::draw(draw.bits()).scene;
    scene.molecule.truncate(draw.integer(1, 8) as usize);
    let fallback = || AnySimulation::new(&Scene::default()).expect("an empty box can be built");
    let mut simulation = AnySimulation::new(&scene).unwrap_or_else(|_| fallback());
    for _ in 0..draw.integer(0, 3) {
        // A run that ends with a named error has a state too.
        if simulation
            .observe_epoch(EpochTime::from(1e60), &mut ())
            .is_err()
        {
            break;
        }
    }
    let checkpoint = simulation.checkpoint().or_else(|| fallback().checkpoint());
    checkpoint
        .and_then(|checkpoint| encode(&checkpoint).ok())
        .unwrap_or_default()
}

/// A complete file with one to three changes.
pub fn draw_file(draw: &mut FuzzDraw) -> Vec<u8> {
    let path = path("draw");
    let body = sound(draw);
    let written = checkpoint_file::write(&path, &[&body])
        .ok()
        .and_then(|()| fs::read(&path).ok());
    // The file may not exist.
    let _ = fs::remove_file(&path);
    changed(draw, written.unwrap_or_default())
}

/// The body of a file with one to three changes.
pub fn draw_body(draw: &mut FuzzDraw) -> Vec<u8> {
    let body = sound(draw);
    changed(draw, body)
}

fn changed(draw: &mut FuzzDraw, mut bytes: Vec<u8>) -> Vec<u8> {
    for _ in 0..draw.integer(1, 3) {
        bytes = mutate::bytes(draw, &bytes);
    }
    bytes
}

fn path(name: &str) -> std::path::PathBuf {
    env::temp_dir().join(format!("carom-fuzz-{}-{name}.checkpoint", process::id()))
}

/// Checks that a changed file is refused, unless the changes cancel.
pub fn check_file(bytes: &[u8], report: &mut Report) {
    let path = path("check");
    if fs::write(&path, bytes).is_err() {
        report.fail("disk", format!("cannot write {}", path.display()));
        return;
    }
    let read = CheckpointBody::read(&path);
    if let Ok(body) = &read {
        // If writing it again gives the same file, nothing was changed.
        let same = checkpoint_file::write(&path, &[body.rest()]).is_ok()
            && fs::read(&path).is_ok_and(|again| again == bytes);
        report.count("checkpoints unchanged", 1);
        if !same {
            report.fail("checksum", "an altered file is accepted");
        }
    } else {
        report.count("checkpoints refused", 1);
    }
    // The file may not exist.
    let _ = fs::remove_file(&path);
}

/// Checks a body with a correct checksum.
pub fn check_body(bytes: &[u8], report: &mut Report) {
    let Ok(checkpoint) = decode::<Checkpoint>(bytes) else {
        report.count("checkpoints refused", 1);
        return;
    };
    let Ok(mut simulation) = AnySimulation::resume(&checkpoint, &Method::default()) else {
        report.count("checkpoints refused", 1);
        return;
    };
    report.count("checkpoints resumed", 1);
    // Overlapping positions in a forged checkpoint are a valid state, which detectors that miss
    // contacts also produce: it is resumed as written.
    if simulation.view().overlaps().pairs > 0 {
        report.count("checkpoints of overlapping bodies", 1);
        return;
    }
    scene_files::run(&mut simulation, 1e60, report);
}
