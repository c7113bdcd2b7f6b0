//! Options of the experiment, and the resulting amount of work.

use carom_runs::{output::Destination, price::LONGEST};
use clap::Args;

use carom_experiments::{
    common::{Common, Seed},
    trade::plan::Plan,
};

/// Options of `cargo xtask experiment tradeoff`.
#[derive(Debug, Clone, Args)]
#[command(mut_arg("paper", |arg| arg.help(
    "The run for publication: twenty times as many contacts, and the finest fixed steps"
)))]
pub struct Options {
    /// Compile and run rapier2d-f64 as well, in closed boxes; it has its own workspace
    #[arg(long)]
    pub rapier: bool,
    /// Run only scenes whose name begins with this; default: all
    #[arg(long, default_value = "")]
    pub scene: String,
    /// Seed.
    #[command(flatten)]
    pub random: Seed,
    /// Options of every experiment.
    #[command(flatten)]
    pub common: Common<Destination>,
}

impl Options {
    /// Amount of work.
    pub fn plan(&self) -> Plan {
        let plan = |rounds, turn, states, seconds, physics, finest_step| Plan {
            rounds,
            turn,
            // Two runs, and the turns that give their length.
            timing_seconds: (2.0 * f64::from(rounds) + 6.0) * turn,
            states,
            stretch: LONGEST,
            state_seconds: seconds,
            replay_seconds: seconds,
            reversal_seconds: seconds,
            physics_seconds: seconds,
            physics,
            finest_step,
        };
        self.common.select(plan(5, 0.02, 12, 0.3, 200.0, 2), plan(11, 0.2, 300, 12.0, 4000.0, 5))
    }

    /// The plan as lines of `config.toml`.
    pub fn configuration(&self) -> String {
        let plan = self.plan();
        format!(
            "rounds_of_times = {}\nseconds_of_a_turn = {}\nstates_replayed = {}\nmeasured_mean_times = {}\n\
             most_seconds_of_a_setting = {}\nfinest_step = 1e-{}\n",
            plan.rounds, plan.turn, plan.states, plan.physics, plan.replay_seconds, plan.finest_step,
        )
    }

    /// Note that is printed and shown first.
    pub fn note(&self) -> String {
        self.common.note(
            ": rates below some hundred wrong contacts in a million are not resolved, and the finest fixed \
             steps are omitted. The full run is --paper.",
        )
    }

    /// The command with every option that affects the results.
    pub fn command(&self) -> String {
        let scene = if self.scene.is_empty() { String::new() } else { format!(" --scene {}", self.scene) };
        let rapier = if self.rapier { " --rapier" } else { "" };
        format!("{}{rapier}{scene} --seed {}", self.common.command("tradeoff"), self.random.seed)
    }
}
