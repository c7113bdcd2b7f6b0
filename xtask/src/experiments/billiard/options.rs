//! Options of the experiment, and the resulting setup.

use anyhow::{Context, Result, ensure};
use carom::{
    Molecule, Scene, Shape,
    engine::{AtomSpec, BoxSpec, MoleculeSpec, RandomStream, RunSpec},
    geometry::ExcludedRegion,
};
use carom_runs::output::Resumption;
use clap::Args;
use glam::DVec2;
use rand::RngExt as _;

use crate::experiments::common::{Common, Seed, Threads};

/// Options of `cargo xtask experiment billiard`.
#[derive(Debug, Clone, Args)]
#[command(
    mut_arg("quick", |arg| arg.help("A short test run, well under two minutes: 4·10⁶ hits (the default)")),
    mut_arg("paper", |arg| arg.help("The run for publication: 10⁸ hits"))
)]
pub struct Options {
    /// The fixed molecule: disc, dumbbell, rod:N, cross, tee, ring:N
    #[arg(long, default_value = "tee")]
    pub shape: Shape,
    /// Radius of its atoms (length)
    #[arg(long, default_value_t = 0.005)]
    pub atom_radius: f64,
    /// Radius of the moving disc (length)
    #[arg(long, default_value_t = 0.01)]
    pub gas_radius: f64,
    /// Side of the periodic box (length); default: four times the sum of the two bounding radii
    #[arg(long)]
    pub side: Option<f64>,
    /// Approximate number of hits instead; with --resume a larger number, in multiples of a quarter
    /// of a million, extends a run
    #[arg(long, value_parser = clap::value_parser!(u64).range(10_000..=1_000_000_000_000))]
    pub hits: Option<u64>,
    /// Seed.
    #[command(flatten)]
    pub random: Seed,
    /// Threads.
    #[command(flatten)]
    pub threads: Threads,
    /// Options of every experiment.
    #[command(flatten)]
    pub common: Common<Resumption>,
}

/// Molecule, disc, box, and number of hits.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The fixed molecule's shape.
    pub shape: Shape,
    /// Radius of its atoms (length).
    pub atom_radius: f64,
    /// The fixed molecule.
    pub molecule: Molecule,
    /// Radius of the moving disc (length).
    pub gas_radius: f64,
    /// The region that the disc's centre cannot enter.
    pub region: ExcludedRegion,
    /// Side of the box (length).
    pub side: f64,
    /// Expected number of hits of all discs.
    pub hits: f64,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// Approximate number of hits of one flight. Fewer: the initial condition is not forgotten. More:
/// accumulated rounding exceeds the allowed energy drift.
const HITS_OF_FLIGHT: f64 = 250_000.0;

/// Largest number of random positions tried for the disc; more than half of the box is always free.
const MOST_TRIES: usize = 1000;

impl Setup {
    /// Mean free path between hits predicted by integral geometry (length).
    pub fn mean_free_path(&self) -> f64 {
        self.region.mean_free_path(self.side * self.side)
    }

    /// Number of independent flights; it does not depend on the machine.
    pub fn flights(&self) -> u64 {
        (self.hits / HITS_OF_FLIGHT).ceil().max(2.0) as u64
    }

    /// Duration of a flight at speed 1 (time).
    pub fn duration(&self) -> f64 {
        self.hits * self.mean_free_path() / self.flights() as f64
    }

    /// The scene of one replica: the molecule at the centre, and a disc of speed 1 at a random
    /// position with a random direction.
    ///
    /// # Errors
    /// No free position was found.
    pub fn scene(&self, replica: u64) -> Result<Scene> {
        let mut places = RandomStream::Placement.generator(self.seed, replica);
        let mut place = || self.side * DVec2::new(places.random::<f64>(), places.random::<f64>());
        let middle = DVec2::splat(0.5 * self.side);
        let at =
            std::iter::repeat_with(&mut place).take(MOST_TRIES).find(|at| !self.region.contains(at - middle));
        let angle =
            std::f64::consts::TAU * RandomStream::Velocities.generator(self.seed, replica).random::<f64>();
        let target = MoleculeSpec {
            tags: vec!["target".to_owned()],
            shape: Some(self.shape.to_string()),
            atom_radius: Some(self.atom_radius),
            atom_mass: Some(1.0),
            at: middle.into(),
            fixed: true,
            ..MoleculeSpec::default()
        };
        let disc = MoleculeSpec {
            tags: vec!["disc".to_owned()],
            atoms: vec![AtomSpec { at: [0.0; 2], radius: self.gas_radius, mass: 1.0 }],
            at: at.context("no free position for the disc was found")?.into(),
            velocity: DVec2::from_angle(angle).into(),
            ..MoleculeSpec::default()
        };
        let until = self.duration();
        Ok(Scene {
            bounds: BoxSpec { sides: [self.side; 2], seed: self.seed, replica },
            molecule: vec![target, disc],
            run: RunSpec { until, sample_interval: until / super::BLOCKS as f64, ..RunSpec::default() },
            ..Scene::default()
        })
    }
}

impl Options {
    /// Molecule, disc, box, and number of hits from these options.
    ///
    /// # Errors
    /// A length is invalid, or the box is too small for the periodic images of the molecule.
    pub fn setup(&self) -> Result<Setup> {
        ensure!(
            self.gas_radius.is_finite() && self.gas_radius > 0.0,
            "--gas-radius {}: it must be positive and finite",
            self.gas_radius
        );
        let molecule =
            Molecule::named(self.shape, self.atom_radius, 1.0).context("--shape, --atom-radius")?;
        let region = ExcludedRegion::of(&molecule, self.gas_radius).context("--gas-radius")?;
        let reach = molecule.bounding_radius() + self.gas_radius;
        let side = self.side.unwrap_or(4.0 * reach);
        ensure!(
            side.is_finite() && side > 2.2 * reach,
            "--side {side}: it must be finite and more than 2.2 times {reach}, the sum of the radii of \
             molecule and disc, so that the molecule's images stay apart"
        );
        let ready = self.common.select(4e6, 1e8);
        let hits = self.hits.map_or(ready, |hits| hits as f64);
        let (shape, atom_radius, gas_radius) = (self.shape, self.atom_radius, self.gas_radius);
        Ok(Setup { shape, atom_radius, molecule, gas_radius, region, side, hits, seed: self.random.seed })
    }

    /// Note that is printed and shown first.
    pub fn note(&self) -> String {
        self.common.note(". The run for publication, of 10⁸ hits, is --paper.")
    }

    /// Default output folder.
    pub fn usual_folder(&self) -> String {
        format!("out/billiard-{}", self.shape).replace(':', "-")
    }

    /// Description of the run without the number of flights, which may grow when the run is
    /// resumed.
    pub fn what(&self, setup: &Setup) -> String {
        format!("{}\nflights of {} each", self.flight(setup), setup.duration())
    }

    fn flight(&self, setup: &Setup) -> String {
        format!(
            "cargo xtask experiment billiard --shape {} --atom-radius {} --gas-radius {} --side {} --seed {}",
            self.shape, self.atom_radius, self.gas_radius, setup.side, self.random.seed
        )
    }

    /// The command with every option that affects the results.
    pub fn command(&self, setup: &Setup) -> String {
        format!("{} --hits {}", self.flight(setup), setup.hits)
    }
}
