//! A digest of the states of a run, by which WebAssembly is compared with other machines.

use anyhow::{Context as _, Result, ensure};
use carom::{Checkpoint, EpochTime, Scene, View, engine::InstructionsName};
use carom_methods::{AnySimulation, Method};
use carom_runs::{checkpoint_file, run::interactive::InteractiveRun};

/// Contacts after which a run has been compared long enough.
const MAX_CONTACTS: u64 = 20_000;

/// Parts in which the time of a run is passed through; after each the contacts are counted.
const PARTS: u32 = 256;

/// Runs a scene and returns its digest: the fingerprint of the last state, the number of contacts,
/// and, for a scene without stages, the fingerprint of a run that is resumed from its middle.
///
/// The run ends with the scene, or after the part of its time in which it has made 20 000 contacts.
///
/// # Errors
/// The scene is invalid, or the run cannot continue.
pub fn digest(text: &str) -> Result<String> {
    let mut scene = Scene::from_toml(text)?;
    // What WebAssembly has in any case.
    scene.method.instructions = Some(InstructionsName::Portable);
    let mut run = InteractiveRun::new(&scene)?;
    let mut part = 0;
    while part < PARTS && run.view().counters().collisions < MAX_CONTACTS {
        part += 1;
        let time = scene.run.until * f64::from(part) / f64::from(PARTS);
        let reached = run.advance(EpochTime::from(time), &mut ())?;
        ensure!(reached, "the run has been interrupted");
    }
    let view = run.view();
    let (whole, contacts) = (fingerprint(&view), view.counters().collisions);
    if !scene.stage.is_empty() {
        return Ok(format!("{whole:016x} {contacts}"));
    }
    let resumed = resumed(&scene, view.time())?;
    Ok(format!("{whole:016x} {contacts} {resumed:016x}"))
}

/// The fingerprint at `until` of a run that is resumed from a file of its state in the middle.
fn resumed(scene: &Scene, until: EpochTime) -> Result<u64> {
    let method = Method::try_from(&scene.method)?;
    let mut first = AnySimulation::with(scene, &method)?;
    first.run_until(0.5 * until.to_f64())?;
    let bytes = checkpoint_file::encode(&first.end_epoch_here())?;
    let state: Checkpoint = checkpoint_file::decode(&bytes).context("the state")?;
    let mut second = AnySimulation::resume(&state, &method)?;
    second.run_until(until.to_f64())?;
    Ok(fingerprint(&second.view()))
}

/// FNV-1a, 64 bits (Fowler, Noll, Vo 1991), of the bits of all motions.
fn fingerprint(view: &View<'_>) -> u64 {
    let numbers = view.bodies().flat_map(|body| {
        let motion = body.motion;
        [
            motion.position.x,
            motion.position.y,
            motion.velocity.x,
            motion.velocity.y,
            motion.orientation.radians(),
            motion.angular_velocity,
        ]
    });
    numbers
        .flat_map(|number| number.to_bits().to_le_bytes())
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        })
}
