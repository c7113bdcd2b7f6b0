//! What can be chosen about the experiment, and the set-up that follows from it.

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

/// Choices of `cargo xtask experiment billiard`.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// The fixed molecule: disc, dumbbell, rod:N, cross, tee, ring:N
    #[arg(long, default_value = "tee")]
    pub shape: Shape,
    /// Radius of its atoms (length)
    #[arg(long, default_value_t = 0.005)]
    pub atom_radius: f64,
    /// Radius of the disc that flies (length)
    #[arg(long, default_value_t = 0.01)]
    pub gas_radius: f64,
    /// Side of the periodic box (length); four times the reach of the two if not given
    #[arg(long)]
    pub side: Option<f64>,
    /// A short run to look at, well under two minutes: 4·10⁶ hits (the default)
    #[arg(long, conflicts_with = "paper")]
    pub quick: bool,
    /// The run to quote from: 10⁸ hits
    #[arg(long)]
    pub paper: bool,
    /// About so many hits instead; more of them, in whole quarters of a million, extend a run with --resume
    #[arg(long, value_parser = clap::value_parser!(u64).range(10_000..=1_000_000_000_000))]
    pub hits: Option<u64>,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Discs that fly at once, each in a box of its own; as many as there are processors if not given. The results do not
    /// depend on it
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Where to write, over what, and whether to go on
    #[command(flatten)]
    pub resumption: Resumption,
}

/// The molecule, the disc, the box, and how long.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The fixed molecule's shape.
    pub shape: Shape,
    /// Radius of its atoms (length).
    pub atom_radius: f64,
    /// The fixed molecule.
    pub molecule: Molecule,
    /// Radius of the disc (length).
    pub gas_radius: f64,
    /// Where the disc's centre cannot be.
    pub region: ExcludedRegion,
    /// Side of the box (length).
    pub side: f64,
    /// Hits that are expected of all discs together.
    pub hits: f64,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// Hits of one flight, about. Fewer: the discs have no time to forget where they began. More: rounding adds up, by chance,
/// to more than the drift of the energy that is allowed.
const HITS_OF_FLIGHT: f64 = 250_000.0;

/// Tries to find a place for the disc outside the molecule; more than half of the box is always free.
const MOST_TRIES: usize = 1000;

impl Setup {
    /// The mean path between two hits that integral geometry predicts (length).
    pub fn mean_free_path(&self) -> f64 {
        self.region.mean_free_path(self.side * self.side)
    }

    /// Discs that fly independently: what comes out must not depend on the machine.
    pub fn flights(&self) -> u64 {
        (self.hits / HITS_OF_FLIGHT).ceil().max(2.0) as u64
    }

    /// How long each disc flies at speed 1 (time).
    pub fn duration(&self) -> f64 {
        self.hits * self.mean_free_path() / self.flights() as f64
    }

    /// The scene of one replica: the molecule in the middle, and a disc of speed 1 from a random place in a random
    /// direction.
    ///
    /// # Errors
    /// No place was found.
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
            at: at.context("no place for the disc was found")?.into(),
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
    /// The molecule, the disc, the box, and how long.
    ///
    /// # Errors
    /// Lengths that make no sense, or a box so small that the molecule's images stand in the way.
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
            "--side {side}: it must be finite and more than 2.2 times {reach}, the reach of molecule and disc together, \
             or the molecule's images stand too close"
        );
        let ready = if self.paper { 1e8 } else { 4e6 };
        let hits = self.hits.map_or(ready, |hits| hits as f64);
        let (shape, atom_radius, gas_radius) = (self.shape, self.atom_radius, self.gas_radius);
        Ok(Setup { shape, atom_radius, molecule, gas_radius, region, side, hits, seed: self.seed })
    }

    /// What is to be known of the run before anything else.
    pub fn note(&self) -> String {
        if self.paper {
            String::new()
        } else {
            "This is a short run, to look at. The run to quote from, of 10⁸ hits, is --paper.".to_owned()
        }
    }

    /// Folder to write to if no other is asked for.
    pub fn usual_folder(&self) -> String {
        format!("out/billiard-{}", self.shape).replace(':', "-")
    }

    /// What a flight depends on, but for its number: so many of them more extend a run.
    pub fn what(&self, setup: &Setup) -> String {
        format!("{}\nflights of {} each", self.flight(setup), setup.duration())
    }

    fn flight(&self, setup: &Setup) -> String {
        format!(
            "cargo xtask experiment billiard --shape {} --atom-radius {} --gas-radius {} --side {} --seed {}",
            self.shape, self.atom_radius, self.gas_radius, setup.side, self.seed
        )
    }

    /// The command with every choice written out that the results depend on.
    pub fn command(&self, setup: &Setup) -> String {
        format!("{} --hits {}", self.flight(setup), setup.hits)
    }
}
