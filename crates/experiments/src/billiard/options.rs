//! Options of the experiment, and the resulting setup.

use anyhow::{Context, Result, ensure};
use carom::{engine::MoleculeSpec, geometry::ExcludedRegion};
use carom_runs::output::Resumption;
use clap::Args;

use super::{
    Layout, Mover, Setup,
    layout::{Obstacles, name_of},
    setup::reach,
};
use crate::{
    common::{Seed, Threads},
    molecule_argument::{MoleculeArgument, NamedMolecule},
};

/// Options of `carom billiard`.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// The molecule.
    #[command(flatten)]
    pub molecule: MoleculeArgument,
    /// Radius of a disc (length)
    #[arg(long, default_value_t = 0.01)]
    pub gas_radius: f64,
    /// What moves; everything else is fixed
    #[arg(long, value_enum, default_value_t)]
    pub moves: Mover,
    /// Arrangement of the fixed obstacles
    #[arg(long, value_enum, default_value_t)]
    pub layout: Layout,
    /// Number of obstacles of a random layout; default: 16
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub obstacles: Option<u16>,
    /// Shorter side of the periodic box (length); default: four times the sum of the radii of
    /// molecule and disc, times the root of the number of obstacles of a random layout
    #[arg(long)]
    pub side: Option<f64>,
    /// Approximate number of hits; with --resume a larger number, in multiples of a quarter of a
    /// million, extends a run
    #[arg(
        long,
        default_value_t = 4_000_000,
        value_parser = clap::value_parser!(u64).range(10_000..=1_000_000_000_000)
    )]
    pub hits: u64,
    /// Seed.
    #[command(flatten)]
    pub random: Seed,
    /// Threads.
    #[command(flatten)]
    pub threads: Threads,
    /// Output folder and its treatment.
    #[command(flatten)]
    pub destination: Resumption,
}

/// Mass of an atom; of a single mover without others, no result depends on it.
const ATOM_MASS: f64 = 1.0;

impl Options {
    /// Molecule, disc, obstacles, and number of hits from these options.
    ///
    /// # Errors
    /// The molecule cannot be read, a length is invalid, or the box is too small for the obstacles.
    pub fn setup(&self) -> Result<Setup> {
        ensure!(
            self.gas_radius.is_finite() && self.gas_radius > 0.0,
            "--gas-radius {}: it must be positive and finite",
            self.gas_radius
        );
        let NamedMolecule { name, spec, molecule, .. } = self.molecule.read(ATOM_MASS)?;
        let region = ExcludedRegion::of(&molecule, self.gas_radius).context("--gas-radius")?;
        // In a scene it may have a place, a motion, and other tags.
        let MoleculeSpec { shape, atoms, atom_radius, atom_mass, .. } = spec;
        let spec = MoleculeSpec { shape, atoms, atom_radius, atom_mass, ..MoleculeSpec::default() };
        let named = NamedMolecule { name, spec, molecule, scene: None };
        let reach = reach(&named, self.gas_radius);
        Ok(Setup {
            obstacles: Obstacles::new(self.layout, self.obstacles, self.side, reach)?,
            named,
            disc_radius: self.gas_radius,
            region,
            mover: self.moves,
            hits: self.hits as f64,
            seed: self.random.seed,
        })
    }

    /// Default output folder.
    pub fn usual_folder(&self, setup: &Setup) -> String {
        format!("out/billiard-{}", setup.named.name)
    }

    /// The command without the number of hits.
    fn flights(&self, setup: &Setup) -> String {
        format!(
            "carom billiard {} --gas-radius {} --moves {} --layout {} --obstacles {} --side {} --seed {}",
            self.molecule.words(),
            self.gas_radius,
            name_of(&self.moves),
            name_of(&self.layout),
            setup.obstacles.count,
            setup.obstacles.side,
            self.random.seed
        )
    }

    /// Description of the run without the number of flights, which may grow when the run is
    /// resumed: the command and the first flight.
    ///
    /// # Errors
    /// There is no first flight.
    pub fn what(&self, setup: &Setup) -> Result<String> {
        Ok(format!("{}\n{}", self.flights(setup), setup.scene(0)?.to_toml()))
    }

    /// The command with every option that affects the results.
    pub fn command(&self, setup: &Setup) -> String {
        format!("{} --hits {}", self.flights(setup), self.hits)
    }
}
