//! Do the mean free path of one body among fixed ones, and the directions of its contacts, agree
//! with integral geometry (Santaló 1976, "Integral geometry and geometric probability")?
//!
//! `carom billiard MOLECULE` writes a study of one disc among fixed molecules, or of one molecule
//! among fixed discs, with the measures `free-path` and `directions`, and runs it as `carom sweep`
//! does. Each replica is a flight of its own.

mod layout;

use std::{fmt::Write as _, path::Path};

use anyhow::{Context, Result, ensure};
use carom::{
    Scene,
    engine::{BoxSpec, BumperSpec, GasSpec, MoleculeSpec, RandomStream, Rotation, RunSpec},
    geometry::ExcludedRegion,
};
use carom_runs::command_line::{program, quoted};
use carom_sweeps::{
    Study,
    sweep::{self, How, Named},
};
use carom_tables::Verdict;
use clap::{Args, ValueEnum};
use toml::Value;

pub use self::layout::ObstacleLayout;
use self::layout::{Obstacles, name_of};
use crate::{
    molecule_argument::{MoleculeArgument, NamedMolecule},
    written_study::{ExpectedFigures, Varied, WrittenStudy, measure, table_of},
};

/// Options of `carom billiard`.
#[derive(Debug, Clone, Args)]
#[group(skip)]
pub struct BilliardOptions {
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
    pub layout: ObstacleLayout,
    /// Number of obstacles of a random layout; default: 16
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub obstacles: Option<u16>,
    /// Shorter side of the periodic box (length); default: four times the sum of the radii of
    /// molecule and disc, times the root of the number of obstacles of a random layout
    #[arg(long)]
    pub side: Option<f64>,
    /// Approximate number of contacts of all flights
    #[arg(
        long,
        default_value_t = 4_000_000,
        value_parser = clap::value_parser!(u64).range(10_000..=1_000_000_000_000)
    )]
    pub hits: u64,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// How the replicas are run.
    #[command(flatten)]
    pub how: How,
}

/// The body that moves; all others are fixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Mover {
    /// A disc among fixed molecules
    #[default]
    Disc,
    /// The molecule, free to turn, among fixed discs
    Molecule,
    /// The molecule among fixed discs, each flight in one random orientation
    LockedMolecule,
}

/// Mass of an atom; of a single mover without others, no result depends on it.
const ATOM_MASS: f64 = 1.0;

/// Approximate number of contacts of one flight. Fewer: the initial condition is not forgotten.
/// More: fewer flights for the processors.
const HITS_OF_FLIGHT: f64 = 250_000.0;

/// That of a mover that turns, whose energy of so few degrees of freedom rounding changes faster.
const HITS_OF_TURNING_FLIGHT: f64 = 50_000.0;

/// Samples of a flight. Fewer: too few blocks for a verdict.
const SAMPLES: f64 = 128.0;

/// Number of random layouts.
const LAYOUTS: u64 = 4;

/// Sectors of the directions: one for each degree.
const SECTORS: i64 = 360;

/// Tags of the molecule and of the disc.
const TARGET: &str = "target";
const DISC: &str = "disc";

/// Writes the study and runs it.
///
/// # Errors
/// An option or a file is invalid; and those of [`sweep::run_study`].
pub fn run(options: &BilliardOptions) -> Result<Verdict> {
    let (study, name) = options.study()?;
    let command = |folder: &Path| options.command(folder);
    let folder = format!("out/billiard-{name}");
    sweep::run_study(
        &Named {
            study: &study,
            name: &name,
            folder: &folder,
            command: &command,
        },
        &options.how,
    )
}

impl BilliardOptions {
    /// The study, and its name.
    ///
    /// # Errors
    /// The molecule cannot be read, a length is invalid, or the box is too small for the obstacles.
    pub fn study(&self) -> Result<(Study, String)> {
        ensure!(
            self.gas_radius.is_finite() && self.gas_radius > 0.0,
            "--gas-radius {}: it must be positive and finite",
            self.gas_radius
        );
        let named = self.molecule.read(ATOM_MASS)?;
        let region =
            ExcludedRegion::new(&named.molecule, self.gas_radius).context("--gas-radius")?;
        let reach = named.molecule.bounding_radius() + self.gas_radius;
        let obstacles = Obstacles::new(self.layout, self.obstacles, self.side, reach)?;
        let flights = self.flights(&named);
        // At speed 1.
        let until = self.hits as f64 * region.mean_free_path(obstacles.area_of_one()) / flights;
        let fixed = self.fixed_layouts(&named, &obstacles, reach)?;
        let layouts = fixed.len();
        let key = if self.moves == Mover::Disc {
            "molecule"
        } else {
            "bumper"
        };
        let mut scene = table_of(&self.around(&named, &obstacles, until))?;
        let vary = if layouts > 1 {
            let names = (1..=layouts).map(|layout| layout.to_string()).collect();
            vec![Varied {
                key: key.to_owned(),
                label: "layout".to_owned(),
                names,
                values: fixed,
            }]
        } else {
            scene.extend(fixed.into_iter().map(|fixed| (key.to_owned(), fixed)));
            Vec::new()
        };
        let mover = if self.moves == Mover::Disc {
            DISC
        } else {
            TARGET
        };
        let study = WrittenStudy {
            title: format!("Billiard: {}", named.name),
            question: self.question().to_owned(),
            replicas: (flights / layouts as f64).ceil() as u64,
            measure: vec![
                format!("free-path:{mover}").into(),
                measure("directions", TARGET, SECTORS),
            ],
            vary,
            expect: expected_figures(mover, &named),
            scene,
        };
        Ok((study.read(self.how.replicas)?, named.name))
    }

    /// Number of flights that share the contacts.
    fn flights(&self, named: &NamedMolecule) -> f64 {
        let turns = self.moves == Mover::Molecule && !named.molecule.is_round();
        let of_flight = if turns {
            HITS_OF_TURNING_FLIGHT
        } else {
            HITS_OF_FLIGHT
        };
        (self.hits as f64 / of_flight).ceil().max(2.0)
    }

    /// The fixed bodies of each layout: there are several if it is random.
    fn fixed_layouts(
        &self,
        named: &NamedMolecule,
        obstacles: &Obstacles,
        reach: f64,
    ) -> Result<Vec<Value>> {
        let layouts = if self.layout == ObstacleLayout::Random {
            LAYOUTS
        } else {
            1
        };
        let places = |layout: u64| {
            obstacles.places(
                reach,
                &mut RandomStream::Placement.generator(self.seed, layout),
            )
        };
        (0..layouts)
            .map(|layout| self.fixed(named, &places(layout)?))
            .collect()
    }

    fn question(&self) -> &'static str {
        match self.moves {
            Mover::Disc => {
                "A disc moves among fixed molecules in a periodic box. Its mean free path, and the shares of the \
                 directions and atoms that it touches, follow from the boundary of the region that its centre cannot \
                 enter."
            }
            Mover::Molecule | Mover::LockedMolecule => {
                "A molecule moves among fixed discs in a periodic box. Its mean free path, and the shares of its \
                 directions and atoms that are touched, follow from the boundary of the region around it that the \
                 centre of a disc cannot enter."
            }
        }
    }

    /// The scene with the body that moves, without the fixed ones.
    fn around(&self, named: &NamedMolecule, obstacles: &Obstacles, until: f64) -> Scene {
        let gas = if self.moves == Mover::Disc {
            GasSpec {
                tags: vec![DISC.to_owned()],
                radius: Some(self.gas_radius.into()),
                mass: Some(1.0.into()),
                energy: 0.5,
                ..GasSpec::default()
            }
        } else {
            let spec = named.spec.clone();
            let is_locked = self.moves == Mover::LockedMolecule;
            GasSpec {
                tags: vec![TARGET.to_owned()],
                shape: spec.shape,
                atoms: spec.atoms,
                ellipses: spec.ellipses,
                edges: spec.edges,
                edge_radius: spec.edge_radius,
                hollow: spec.hollow,
                polygon: spec.polygon,
                rounding: spec.rounding,
                size: spec.size.map(Into::into),
                mass: spec.mass.map(Into::into),
                density: spec.density,
                atom_radius: spec.atom_radius.map(Into::into),
                atom_mass: spec.atom_mass.map(Into::into),
                energy: 0.5 * named.molecule.mass(),
                rotation: if is_locked {
                    Rotation::Locked
                } else {
                    Rotation::Free
                },
                ..GasSpec::default()
            }
        };
        let mut scene = Scene {
            bounds: BoxSpec {
                sides: obstacles.sides().into(),
                seed: self.seed,
                ..BoxSpec::default()
            },
            gas: vec![GasSpec {
                count: Some(1),
                ..gas
            }],
            run: RunSpec {
                until,
                sample_interval: until / SAMPLES,
                ..RunSpec::default()
            },
            ..Scene::default()
        };
        scene.start.empty_pockets = true;
        scene
    }

    /// The list of the fixed bodies at these places.
    fn fixed(&self, named: &NamedMolecule, places: &[glam::DVec2]) -> Result<Value> {
        // In a scene the molecule may have a place, a motion, and other tags.
        let MoleculeSpec {
            velocity, rotation, ..
        } = MoleculeSpec::default();
        let molecule = MoleculeSpec {
            tags: vec![TARGET.to_owned()],
            orientation: None,
            orientation_turns: None,
            velocity,
            angular_velocity: 0.0,
            rotation,
            fixed: true,
            ..named.spec.clone()
        };
        let entry = |place: &glam::DVec2| {
            let at = (*place).into();
            if self.moves == Mover::Disc {
                Value::try_from(MoleculeSpec {
                    at,
                    ..molecule.clone()
                })
            } else {
                Value::try_from(BumperSpec {
                    tags: vec![DISC.to_owned()],
                    radius: self.gas_radius,
                    at,
                })
            }
        };
        Ok(Value::Array(
            places.iter().map(entry).collect::<Result<_, _>>()?,
        ))
    }

    /// The command that repeats the experiment into a folder.
    fn command(&self, folder: &Path) -> String {
        let (moves, layout) = (name_of(&self.moves), name_of(&self.layout));
        let mut command = format!(
            "{} billiard {} --gas-radius {} --moves {moves} --layout {layout} --hits {} --seed {}",
            program(),
            self.molecule.words(),
            self.gas_radius,
            self.hits,
            self.seed
        );
        if let Some(obstacles) = self.obstacles {
            let _ = write!(command, " --obstacles {obstacles}");
        }
        if let Some(side) = self.side {
            let _ = write!(command, " --side {side}");
        }
        format!("{command} --out {}{}", quoted(folder), self.how.words())
    }
}

/// The figures that integral geometry predicts.
fn expected_figures(mover: &str, named: &NamedMolecule) -> Vec<ExpectedFigures> {
    let mut expected = vec![
        format!("mean free path, {mover}"),
        format!("directions, χ² per degree of freedom, {TARGET}"),
    ];
    if named.molecule.atoms().len() > 1 {
        let edges = named.molecule.edges();
        let parts = if edges.is_empty() {
            "atom"
        } else {
            "atom and edge"
        };
        expected.push(format!(
            "contacts by {parts}, χ² per degree of freedom, {TARGET}"
        ));
    }
    expected
        .into_iter()
        .map(|figure| ExpectedFigures { figure })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_runs::{interruption::Signals, run::record};
    use std::fs;

    fn options(words: &[&str]) -> BilliardOptions {
        crate::written_study::options(words)
    }

    /// Runs the first replica of each point, and verifies that all is as expected.
    fn assert_as_expected(words: &[&str]) {
        let study = options(words).study().unwrap().0;
        for (index, point) in study.points.iter().enumerate() {
            let record = record(&point.replica(1), &Signals::default()).unwrap();
            let results = carom_runs::merge::merged(&record);
            let answers = study.answers(index, &results.figures, &results.tables);
            assert!(answers.len() > 1);
            for answer in answers {
                assert!(
                    answer.passed && answer.value.is_finite(),
                    "{words:?}: {answer:?}"
                );
            }
            let unreachable = results
                .figures
                .iter()
                .filter(|figure| figure.prediction == Some(0.0));
            unreachable
                .for_each(|figure| assert_eq!(figure.value, 0.0, "{words:?}: {}", figure.name));
        }
    }

    /// Five discs of three radii in an L, of which no other test has heard.
    const L: &str = "atoms = [\n\
        { at = [0.0, 0.0], radius = 0.006, mass = 1.0 },\n\
        { at = [0.0, 0.008], radius = 0.004, mass = 1.0 },\n\
        { at = [0.0, 0.016], radius = 0.005, mass = 2.0 },\n\
        { at = [0.008, 0.0], radius = 0.004, mass = 1.0 },\n\
        { at = [0.016, 0.0], radius = 0.005, mass = 1.0 },\n]\n";

    /// An L of straight sides.
    const CORNERS: &str = "polygon = [[0, 0], [0.06, 0], [0.06, 0.02], [0.02, 0.02], [0.02, 0.06], [0, 0.06]]\n\
        rounding = 0.02\ndensity = 1000.0\n";

    #[test]
    fn any_molecule_moves_or_is_fixed_in_any_layout() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("ell.toml");
        fs::write(&path, L).unwrap();
        let path = path.to_str().unwrap();
        for moves in ["disc", "molecule", "locked-molecule"] {
            for layout in ["square", "triangular", "random"] {
                let hits = if layout == "random" {
                    "120000"
                } else {
                    "60000"
                };
                let words = [
                    path,
                    "--moves",
                    moves,
                    "--layout",
                    layout,
                    "--gas-radius",
                    "0.003",
                    "--hits",
                    hits,
                ];
                assert_as_expected(&words);
            }
        }
        let corners = root.path().join("corners.toml");
        fs::write(&corners, CORNERS).unwrap();
        let corners = corners.to_str().unwrap();
        for moves in ["disc", "molecule", "locked-molecule"] {
            assert_as_expected(&[corners, "--moves", moves, "--hits", "60000"]);
        }
        assert_as_expected(&["capsule:2", "--size", "0.02", "--hits", "60000"]);
        for (shape, radius) in [("tee", "0.0025"), ("ring:12", "0.005"), ("disc", "0.01")] {
            assert_as_expected(&[
                shape,
                "--atom-radius",
                radius,
                "--seed",
                "11",
                "--hits",
                "80000",
            ]);
        }
    }

    #[test]
    fn invalid_options_are_refused() {
        let tee = ["tee", "--atom-radius", "0.005"];
        for (words, expected) in [
            (&["--gas-radius", "0"][..], "--gas-radius 0"),
            (&["--gas-radius", "nan"], "--gas-radius NaN"),
            (&["--side", "0.02"], "--side 0.02"),
            (&["--side", "inf"], "--side inf"),
            (&["--obstacles", "3"], "--obstacles 3"),
            (
                &["--layout", "triangular", "--obstacles", "1"],
                "the layout triangular has 2",
            ),
            (
                &["--layout", "random", "--obstacles", "100", "--side", "0.3"],
                "--side 0.3",
            ),
        ] {
            let refused = format!(
                "{:#}",
                options(&[&tee[..], words].concat()).study().unwrap_err()
            );
            assert!(refused.contains(expected), "{refused}");
        }
    }
}
