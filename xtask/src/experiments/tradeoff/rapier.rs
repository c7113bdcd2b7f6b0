//! Comparison with rapier2d-f64, a physics engine with fixed time steps, for the same gases in a
//! closed box.

use std::{
    io::Write as _,
    process::{Command, Stdio},
};

use anyhow::{Context, Result, ensure};
use carom::{View, engine::WallSpec};
use carom_methods::AnySimulation;
use cpu_time::ThreadTime;
use serde::Deserialize;
use serde_json::{Value, json};

use carom_experiments::trade::plan::Plan;

use super::{scenes::Named, settle::settle};

/// Duration of the run in both engines (mean times between two collisions of a body).
const LENGTH: f64 = 10.0;

/// Factor for the duration of the exact run, which would otherwise be too short to time.
const LONGER: f64 = 10.0;

/// Time steps of rapier (mean times between two collisions of a body).
const STEPS: [f64; 4] = [0.3, 0.1, 0.03, 0.01];

/// Output of the runner for one time step.
#[derive(Debug, Clone, Deserialize)]
struct Seen {
    step: f64,
    duration: f64,
    seconds: f64,
    collisions: u64,
    energy_change: f64,
    overlapping: usize,
    deepest: f64,
    escaped: usize,
}

/// Results of both engines in one scene.
#[derive(Debug)]
pub struct Compared {
    scene: &'static str,
    tau: f64,
    /// Processor seconds of the exact run for each unit of simulated time.
    seconds: f64,
    /// Collisions of the exact run for each unit of simulated time.
    rate: f64,
    seen: Vec<Seen>,
}

/// Columns of the table.
pub const HEADER: [&str; 9] = [
    "scene",
    "step [τ]",
    "processor time over exact",
    "contacts begun over exact",
    "energy change",
    "overlapping pairs",
    "deepest overlap [diameters]",
    "outside the box",
    "run [τ]",
];

/// Runs a scene, closed by two walls (each also bounds the periodic image), with both engines.
///
/// # Errors
/// The exact run fails, or the runner cannot be compiled or run.
pub fn compare(named: &Named, plan: &Plan) -> Result<Compared> {
    let mut scene = named.scene.clone();
    scene.wall = vec![
        WallSpec { x: Some(0.0), ..WallSpec::default() },
        WallSpec { y: Some(0.0), ..WallSpec::default() },
    ];
    let mut simulation =
        AnySimulation::new(&scene).with_context(|| format!("{} in a closed box", named.name))?;
    let (begin, tau) = settle(&mut simulation)?;
    simulation.run_until(begin)?;
    let request = request(&simulation.view(), tau, plan);
    let before = simulation.view().counters().collisions;
    let clock = ThreadTime::now();
    simulation.run_until(begin + LONGER * LENGTH * tau)?;
    let time = LONGER * LENGTH * tau;
    let collisions = simulation.view().counters().collisions - before;
    Ok(Compared {
        scene: named.name,
        tau,
        seconds: clock.elapsed().as_secs_f64() / time,
        rate: collisions as f64 / time,
        seen: run_rapier(&request)?,
    })
}

/// The bodies of a view as input of the runner.
fn request(view: &View<'_>, tau: f64, plan: &Plan) -> Value {
    let sides = view.bounds().sides();
    let bodies = view.bodies().filter(|body| !body.body.is_wall()).map(|body| {
        let atoms = body.body.molecule().atoms().iter().map(
            |atom| json!({ "at": atom.offset().to_array(), "radius": atom.radius(), "mass": atom.mass() }),
        );
        let motion = &body.motion;
        let at = [motion.position.x.rem_euclid(sides.x), motion.position.y.rem_euclid(sides.y)];
        json!({
            "atoms": atoms.collect::<Vec<_>>(),
            "at": at,
            "turns": motion.orientation.turns(),
            "velocity": motion.velocity.to_array(),
            "angular_velocity": motion.angular_velocity,
            "fixed": body.body.is_fixed(),
        })
    });
    json!({
        "sides": sides.to_array(),
        "bodies": bodies.collect::<Vec<_>>(),
        "duration": LENGTH * tau,
        "steps": STEPS.map(|step| step * tau),
        "most_seconds": 10.0 * plan.replay_seconds,
    })
}

/// Compiles and runs the runner, which has its own workspace.
fn run_rapier(request: &Value) -> Result<Vec<Seen>> {
    let mut runner = Command::new(option_env!("CARGO").unwrap_or("cargo"))
        .args(["run", "--release", "--locked", "--quiet", "--manifest-path"])
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/rapier/Cargo.toml"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .context("cannot start cargo")?;
    // The runner reads all input before it writes, so the pipes cannot block each other.
    let mut input = runner.stdin.take().context("the runner has no input")?;
    input.write_all(request.to_string().as_bytes()).context("the runner does not read its input")?;
    drop(input);
    let output = runner.wait_with_output()?;
    ensure!(output.status.success(), "the runner of rapier failed: {}", output.status);
    serde_json::from_slice(&output.stdout).context("cannot parse the output of the runner of rapier")
}

/// Rows of the table.
pub fn rows(compared: &Compared) -> Vec<Vec<String>> {
    let row = |seen: &Seen| {
        vec![
            compared.scene.to_owned(),
            format!("{:.2}", seen.step / compared.tau),
            format!("{:.1}", seen.seconds / seen.duration / compared.seconds),
            format!("{:.3}", seen.collisions as f64 / seen.duration / compared.rate),
            format!("{:+.1e}", seen.energy_change),
            seen.overlapping.to_string(),
            format!("{:.1e}", seen.deepest),
            seen.escaped.to_string(),
            format!("{:.1}", seen.duration / compared.tau),
        ]
    };
    compared.seen.iter().map(row).collect()
}

/// A line for each step, for the terminal.
pub fn lines(compared: &Compared) -> Vec<String> {
    let line = |row: Vec<String>| {
        format!(
            "{:<11} rapier, step {} τ: time {:>6}, contacts {}, energy {}, overlaps {} {}, outside {}, run {} τ",
            row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8]
        )
    };
    rows(compared).into_iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_runner_receives_every_body_in_the_box_and_no_wall() {
        let scene = carom::Scene::from_toml(
            "[box]\nseed = 1\n[[wall]]\nx = 0.0\n[[bumper]]\nradius = 0.1\nat = [0.5, 0.5]\n[[gas]]\nradius = 0.02\nmass = 1.0\n\
             energy = 1.0\ncount = 20",
        )
        .unwrap();
        let simulation = AnySimulation::new(&scene).unwrap();
        let plan = Plan {
            rounds: 1,
            turn: 0.1,
            timing_seconds: 1.0,
            states: 1,
            stretch: 2.0,
            state_seconds: 1.0,
            replay_seconds: 1.0,
            reversal_seconds: 1.0,
            physics_seconds: 1.0,
            physics: 1.0,
            finest_step: 2,
        };
        let request = request(&simulation.view(), 0.5, &plan);
        let bodies = request["bodies"].as_array().unwrap();
        assert_eq!(bodies.len(), 21);
        assert_eq!(bodies.iter().filter(|body| body["fixed"] == true).count(), 1);
        let inside =
            |body: &Value| (0..2).all(|axis| (0.0..1.0).contains(&body["at"][axis].as_f64().unwrap()));
        assert!(bodies.iter().all(inside));
        assert_eq!(request["duration"], 5.0);
    }
}
