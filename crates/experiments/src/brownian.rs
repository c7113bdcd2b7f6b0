//! Does a small molecule in a gas of discs receive a net force along its body axes (Montanari 2017,
//! chapter 3)?
//!
//! `carom brownian MOLECULE` writes a study of the molecule, and of a disc of the same area and
//! mass as its control, in a gas, with the measure `kicks`, and runs it as `carom sweep` does.

use std::{f64::consts::PI, fmt::Write as _, fs, path::Path};

use anyhow::{Context as _, Result, bail, ensure};
use carom::{
    Molecule, Scene,
    engine::{
        AtomSpec, BoxSpec, BumperSpec, GasSpec, MeasureSpec, MoleculeSpec, Rotation, RunSpec,
    },
    geometry::check_positive,
};
use carom_runs::{
    command_line::{program, quoted},
    measures::kicks::DILUTE,
};
use carom_sweeps::{
    Study,
    sweep::{self, How, Named},
};
use carom_tables::Verdict;
use clap::{Args, builder::BoolishValueParser};
use toml::{Table, Value};

use crate::{
    molecule_argument::{MoleculeArgument, NamedMolecule},
    written_study::{Varied, WrittenStudy, measure, table_of},
};

/// Options of `carom brownian`.
#[derive(Debug, Clone, Args)]
#[group(skip)]
pub struct BrownianOptions {
    /// The molecule.
    #[command(flatten)]
    pub molecule: MoleculeArgument,
    /// Radius of the gas discs (length); default: 0.01
    #[arg(long, value_name = "LENGTH")]
    pub gas_radius: Option<f64>,
    /// Molecules of the gas in place of discs: keys of `[[gas]]`, or a TOML file with them, such as
    /// 'shape = "dumbbell", atom_radius = 0.01, atom_mass = 0.5', or for discs tied in pairs 'chain
    /// = { members = 2, tether = { max = 0.025 } }'. What they leave open is that of the discs
    #[arg(long, value_name = "KEYS")]
    pub gas: Option<String>,
    /// Area fraction of the gas, at most 0.7; below 0.01 the shares of kicks by direction and by
    /// atom follow from the exposed arcs and are tested, and runs are longer. Default: 0.5
    #[arg(long, value_name = "FRACTION")]
    pub area_fraction: Option<f64>,
    /// Side of the periodic square (length); default: 100 gas radii, and at least 10 times the
    /// bounding radius of the molecule with a gas disc
    #[arg(long, value_name = "LENGTH")]
    pub side: Option<f64>,
    /// Lock the orientation, at this angle (degrees) or at 0
    #[arg(long, value_name = "DEGREES", num_args = 0..=1, default_missing_value = "0",
          allow_negative_numbers = true)]
    pub lock: Option<f64>,
    /// Run a disc of equal area and mass beside the molecule, as a control: on or off; default: on,
    /// except for a study, which lists all that runs
    #[arg(long, value_name = "ON", value_parser = BoolishValueParser::new(), hide_possible_values = true)]
    pub control: Option<bool>,
    /// Start of the measurement (time); default: 5 for gas discs of radius 0.01, and 100 in a
    /// dilute gas, in proportion to the radius; of a scene, run.measure_from
    #[arg(long, value_name = "TIME")]
    pub from: Option<f64>,
    /// End of the run (time); default: 200 for gas discs of radius 0.01, and 20000 in a dilute gas,
    /// in proportion to the radius; of a scene, run.until
    #[arg(long, value_name = "TIME")]
    pub until: Option<f64>,
    /// Seed of all random numbers; default: 1, or that of the scene
    #[arg(long)]
    pub seed: Option<u64>,
    /// How the replicas are run.
    #[command(flatten)]
    pub how: How,
}

/// The question that the experiment answers.
const QUESTION: &str = "Does a molecule that gas discs cannot touch from every side receive a net force along its \
                        body axes? Every kick by the gas is recorded by its direction in the body frame: x′ and y′ \
                        are the axes in which the atoms are given. After Montanari (2017), chapter 3.";

/// What is said of the control.
const CONTROL: &str = " The control is a disc of the same area and mass.";

/// Radius of the gas discs if none is given (length), and their mass and energy.
const GAS_RADIUS: f64 = 0.01;
const GAS_MASS: f64 = 1.0;
const GAS_ENERGY: f64 = 1.0;

/// Area fraction of the gas if none is given, and the largest.
const AREA_FRACTION: f64 = 0.5;
const MAX_AREA_FRACTION: f64 = 0.7;

/// Mass of each atom of a named shape if none is given: twice that of a gas disc, as in the thesis.
const ATOM_MASS: f64 = 2.0;

/// Least side of the box in reaches, the bounding radius of the molecule with a gas disc: gas discs
/// pass between the molecule and its images.
const MIN_REACHES: f64 = 4.0;

/// The side if none is given: in radii of the gas discs, as in the thesis, and at least in reaches.
const SIDE: f64 = 100.0;
const REACHES: f64 = 10.0;

/// Start of the measurement, end, and interval between samples (time) for gas discs of radius
/// 0.01; in a dilute gas kicks are rare and cheap.
const DENSE: [f64; 3] = [5.0, 200.0, 0.5];
const IN_DILUTE: [f64; 3] = [100.0, 20_000.0, 20.0];

/// Tag of the molecule in a scene that the command makes.
const TAG: &str = "molecule";

/// Sectors of the directions.
const SECTORS: i64 = 120;

/// Writes the study and runs it.
///
/// # Errors
/// An option or a file is invalid; and those of [`sweep::run_study`].
pub fn run(options: &BrownianOptions) -> Result<Verdict> {
    let (study, name) = options.study()?;
    let command = |folder: &Path| options.command(folder);
    let folder = format!("out/brownian-{name}");
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

impl BrownianOptions {
    /// The study, and its name.
    fn study(&self) -> Result<(Study, String)> {
        match self.molecule.study()? {
            Some(study) => self.of_study(&study),
            None => self.of_molecule(),
        }
    }

    /// A study of one molecule, and of its control.
    fn of_molecule(&self) -> Result<(Study, String)> {
        let named = self.molecule.read(ATOM_MASS)?;
        let spec = self.locked(&named)?;
        let (mut scene, body) = match &named.scene {
            Some((scene, body)) => {
                self.refuse_gas_options("the scene")?;
                (scene.clone(), *body)
            }
            None => (self.square(&named.molecule)?, 0),
        };
        let spec = match &named.scene {
            Some(_) => spec,
            None => MoleculeSpec {
                tags: vec![TAG.to_owned()],
                at: scene.bounds.sides.map(|side| 0.5 * side),
                ..spec
            },
        };
        ensure!(
            !spec.fixed,
            "molecule[{body}]: a fixed molecule has no Brownian motion"
        );
        if named.scene.is_none() {
            scene.molecule.push(spec.clone());
        } else {
            scene.molecule[body] = spec.clone();
        }
        let has_control = self.control.unwrap_or(true) && !named.molecule.is_round();
        let mut table = table_of(&scene)?;
        let tag = self.molecule.body.as_deref().unwrap_or(TAG);
        self.change(&mut table)?;
        let kicks = (!has_kicks(&scene, tag)).then(|| measure("kicks", tag, SECTORS));
        let name = named.name.clone();
        let vary = has_control.then(|| -> Result<Varied> {
            let values = [&spec, &control(&named.molecule, &spec)].map(Value::try_from);
            Ok(Varied {
                key: format!("molecule.{body}"),
                label: "molecule".to_owned(),
                names: vec![name.clone(), "control".to_owned()],
                values: values.into_iter().collect::<Result<_, _>>()?,
            })
        });
        let study = WrittenStudy {
            title: format!("Brownian motion: {name}"),
            question: format!("{QUESTION}{}", if has_control { CONTROL } else { "" }),
            replicas: 1,
            measure: kicks.into_iter().collect(),
            vary: vary.transpose()?.into_iter().collect(),
            scene: table,
            ..WrittenStudy::default()
        };
        Ok((study.read(self.how.replicas)?, name))
    }

    /// The points of a study, with the measure of the kicks.
    fn of_study(&self, study: &Study) -> Result<(Study, String)> {
        let file = &self.molecule.molecule;
        ensure!(self.lock.is_none(), "--lock: change it in the study {file}");
        self.refuse_gas_options("the study")?;
        ensure!(
            self.control != Some(true),
            "--control: the study {file} lists all that runs; add the control as a point"
        );
        let mut tag = "";
        for point in &study.points {
            let found = self.molecule.body_of(&point.scene);
            tag = found
                .map_err(|error| error.context(format!("point {}", point.label)))?
                .0;
        }
        let mut text: Table = study.text().parse()?;
        let name = Path::new(file)
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        text.entry("title")
            .or_insert_with(|| format!("Brownian motion: study {name}").into());
        text.entry("question").or_insert_with(|| QUESTION.into());
        if let Some(Value::Table(scene)) = text.get_mut("scene") {
            self.change(scene)?;
        }
        if !study
            .points
            .iter()
            .any(|point| has_kicks(&point.scene, tag))
        {
            text.insert(
                "measure".to_owned(),
                Value::Array(vec![measure("kicks", tag, SECTORS)]),
            );
        }
        let size = carom_sweeps::Size {
            replicas: self.how.replicas,
            is_quick: false,
        };
        Ok((
            Study::parse(&toml::to_string(&text)?, Path::new(""), size)?,
            name,
        ))
    }

    /// Changes the times and the seed of a scene as the options say.
    fn change(&self, scene: &mut Table) -> Result<()> {
        let inner = |scene: &mut Table, name: &str, key: &str, value: Option<Value>| {
            let table = scene
                .entry(name)
                .or_insert_with(|| Value::Table(Table::new()));
            if let (Value::Table(table), Some(value)) = (table, value) {
                table.insert(key.to_owned(), value);
            }
        };
        for (option, key, value) in [
            ("--from", "measure_from", self.from),
            ("--until", "until", self.until),
        ] {
            if let Some(value) = value {
                ensure!(
                    value.is_finite() && value >= 0.0,
                    "{option} {value}: it must be at least 0 and finite"
                );
            }
            inner(scene, "run", key, value.map(Value::Float));
        }
        let seed = self.seed.map(i64::try_from).transpose()?;
        inner(scene, "box", "seed", seed.map(Value::Integer));
        Ok(())
    }

    /// The entry of the molecule, with its orientation locked if the command line says so.
    fn locked(&self, named: &NamedMolecule) -> Result<MoleculeSpec> {
        let Some(degrees) = self.lock else {
            return Ok(named.spec.clone());
        };
        ensure!(
            degrees.is_finite(),
            "--lock {degrees}: the angle must be finite"
        );
        Ok(MoleculeSpec {
            orientation: None,
            orientation_turns: Some(degrees / 360.0),
            angular_velocity: 0.0,
            rotation: Rotation::Locked,
            ..named.spec.clone()
        })
    }

    /// The scene of a gas in a periodic square, of equal discs if nothing else is given, without
    /// the molecule, and a small fixed disc. A gas of nonzero momentum would flow as a wind; the
    /// fixed disc stops it (Montanari 2017, section 3.1.1).
    fn square(&self, molecule: &Molecule) -> Result<Scene> {
        for (option, value) in [("--gas-radius", self.gas_radius), ("--side", self.side)] {
            if let Some(value) = value {
                check_positive("it", value)
                    .map_err(|reason| anyhow::anyhow!("{option}: {reason}"))?;
            }
        }
        let radius = self.gas_radius.unwrap_or(GAS_RADIUS);
        let area_fraction = self.area_fraction.unwrap_or(AREA_FRACTION);
        ensure!(
            area_fraction > 0.0 && area_fraction <= MAX_AREA_FRACTION,
            "--area-fraction {area_fraction}: it must be above 0 and at most {MAX_AREA_FRACTION}, near the freezing \
             density"
        );
        let reach = molecule.bounding_radius() + radius;
        let side = self
            .side
            .unwrap_or_else(|| (SIDE * radius).max(REACHES * reach));
        let least = MIN_REACHES * reach;
        ensure!(
            side >= least,
            "--side {side}: the molecule with a gas disc around it needs a box of at least {least:.6}"
        );
        let discs = GasSpec {
            tags: vec!["gas".to_owned()],
            radius: Some(radius.into()),
            mass: Some(GAS_MASS.into()),
            energy: GAS_ENERGY,
            area_fraction: Some(area_fraction),
            ..GasSpec::default()
        };
        let mut scene = Scene {
            bounds: BoxSpec {
                sides: [side; 2],
                seed: 1,
                ..BoxSpec::default()
            },
            bumper: vec![BumperSpec {
                tags: vec!["bumper".to_owned()],
                radius: 0.25 * radius,
                at: [0.1 * side; 2],
            }],
            gas: vec![match &self.gas {
                Some(keys) => with_keys(&discs, keys)?,
                None => discs,
            }],
            run: run_of_gas(radius, area_fraction),
            ..Scene::default()
        };
        // Discs in the hole of a ring would strike it from within for ever.
        scene.start.empty_pockets = true;
        Ok(scene)
    }

    fn refuse_gas_options(&self, what: &str) -> Result<()> {
        ensure!(
            self.gas.is_none(),
            "--gas: change it in {what} {}",
            self.molecule.molecule
        );
        for (option, value) in [
            ("--gas-radius", self.gas_radius),
            ("--area-fraction", self.area_fraction),
            ("--side", self.side),
        ] {
            ensure!(
                value.is_none(),
                "{option}: change it in {what} {}",
                self.molecule.molecule
            );
        }
        Ok(())
    }

    /// The command that repeats the experiment into a folder.
    fn command(&self, folder: &Path) -> String {
        let mut command = format!("{} brownian {}", program(), self.molecule.words());
        for (option, value) in [
            ("gas-radius", self.gas_radius),
            ("area-fraction", self.area_fraction),
            ("side", self.side),
            ("lock", self.lock),
            ("from", self.from),
            ("until", self.until),
        ] {
            if let Some(value) = value {
                let _ = write!(command, " --{option} {value}");
            }
        }
        if let Some(gas) = &self.gas {
            let _ = write!(command, " --gas {}", quoted(Path::new(gas)));
        }
        if let Some(seed) = self.seed {
            let _ = write!(command, " --seed {seed}");
        }
        if let Some(is_on) = self.control {
            let _ = write!(command, " --control {}", if is_on { "on" } else { "off" });
        }
        format!("{command} --out {}{}", quoted(folder), self.how.words())
    }
}

/// Keys of a gas that exclude others: with the first, the others are not taken from the discs.
const INSTEAD: [(&str, &[&str]); 6] = [
    ("shape", &["radius", "mass"]),
    ("atoms", &["radius", "mass"]),
    ("ellipses", &["radius", "mass"]),
    ("polygon", &["radius", "mass"]),
    ("count", &["area_fraction"]),
    ("temperature", &["energy"]),
];

/// Keys of a gas that have options of their own.
const OF_OPTIONS: [(&str, &str); 2] = [
    ("radius", "--gas-radius"),
    ("area_fraction", "--area-fraction"),
];

/// A gas with these keys, in a text or in a file, and otherwise like the gas of discs.
fn with_keys(discs: &GasSpec, keys: &str) -> Result<GasSpec> {
    let is_file = Path::new(keys)
        .extension()
        .is_some_and(|ending| ending == "toml");
    let text = if is_file {
        fs::read_to_string(keys).with_context(|| format!("--gas {keys}"))?
    } else {
        format!("gas = {{ {keys} }}")
    };
    let mut given: Table = text
        .parse()
        .with_context(|| format!("--gas: keys of [[gas]] are expected, not '{keys}'"))?;
    match given.remove("gas") {
        Some(Value::Table(keys)) => given = keys,
        Some(Value::Array(mut gases)) if gases.len() == 1 => {
            given = gases.remove(0).try_into().context("--gas")?;
        }
        Some(_) => bail!("--gas: one [[gas]] is expected"),
        None => {}
    }
    for (key, option) in OF_OPTIONS {
        ensure!(
            !given.contains_key(key),
            "--gas: give `{key}` by the option {option}, on which the box and the times depend"
        );
    }
    let mut gas = Table::try_from(discs)?;
    for (key, others) in INSTEAD {
        if given.contains_key(key) {
            gas.retain(|name, _| !others.contains(&name));
        }
    }
    gas.extend(given);
    gas.try_into()
        .with_context(|| format!("--gas: it is no [[gas]]: '{keys}'"))
}

/// The run of a gas of this density: its times, in proportion to the radius of the discs, and its
/// measures.
fn run_of_gas(radius: f64, area_fraction: f64) -> RunSpec {
    let times = if area_fraction < DILUTE {
        IN_DILUTE
    } else {
        DENSE
    };
    let [measure_from, until, sample_interval] = times.map(|time| time * radius / GAS_RADIUS);
    let observe = [
        "energy",
        "collision-rate",
        "overlap",
        "running-average:molecule",
    ];
    RunSpec {
        observe: observe.map(str::to_owned).to_vec(),
        measure_from: measure_from.into(),
        until,
        sample_interval,
        ..RunSpec::default()
    }
}

/// Whether a scene measures the kicks on the body with this tag.
fn has_kicks(scene: &Scene, tag: &str) -> bool {
    let name = format!("kicks:{tag}");
    let is_kicks = |entry: &MeasureSpec| entry.kind == "kicks" && entry.of.as_deref() == Some(tag);
    scene.run.observe.contains(&name) || scene.measure.iter().any(is_kicks)
}

/// A disc of the area and mass of a molecule in its place.
fn control(molecule: &Molecule, entry: &MoleculeSpec) -> MoleculeSpec {
    let disc = AtomSpec {
        at: [0.0; 2],
        radius: (molecule.area() / PI).sqrt(),
        mass: molecule.mass(),
    };
    MoleculeSpec {
        tags: entry.tags.clone(),
        atoms: vec![disc],
        at: entry.at,
        velocity: entry.velocity,
        ..MoleculeSpec::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(words: &[&str]) -> BrownianOptions {
        crate::written_study::options(words)
    }

    fn study(words: &[&str]) -> Study {
        options(words).study().unwrap().0
    }

    fn refused(words: &[&str]) -> String {
        format!("{:#}", options(words).study().unwrap_err())
    }

    #[test]
    fn the_gas_may_be_of_any_molecules() {
        let gas = |keys: &str| {
            study(&[&TEE[..], &["--gas", keys]].concat()).points[0]
                .scene
                .clone()
        };
        let hinged = gas("chain = { members = 2, tether = { max = 0.025 } }");
        assert!(hinged.gas[0].chain.is_some() && hinged.gas[0].area_fraction == Some(0.5));
        assert_eq!(hinged.gas[0].radius, Some(0.01.into()));
        let rods = gas("shape = \"dumbbell\", atom_radius = 0.008, atom_mass = 0.5, count = 300");
        let [found] = &rods.gas[..] else {
            panic!("one gas")
        };
        assert_eq!((found.count, found.area_fraction), (Some(300), None));
        assert!(found.radius.is_none() && found.shape.is_some());
        assert!(rods.expected_bodies().is_ok());
        let root = tempfile::tempdir().unwrap();
        let file = root.path().join("gas.toml");
        fs::write(&file, "[[gas]]\ntemperature = 2.0\n").unwrap();
        let hot = gas(file.to_str().unwrap());
        assert_eq!(hot.gas[0].temperature, Some(2.0));
        for (keys, expected) in [
            ("chain = {", "keys of [[gas]] are expected"),
            ("radus = 0.1", "unknown field `radus`"),
            ("radius = 0.1", "by the option --gas-radius"),
            ("none.toml", "--gas none.toml"),
        ] {
            let problem = refused(&[&TEE[..], &["--gas", keys]].concat());
            assert!(problem.contains(expected), "{keys}: {problem}");
        }
    }

    const TEE: [&str; 3] = ["tee", "--atom-radius", "0.005"];

    const SCENE: &str = "[box]\nsides = [2.0, 1.0]\n[[molecule]]\ntags = [\"probe\"]\nshape = \"tee\"\natom_radius = 0.02\n\
                         atom_mass = 3.0\nat = [0.4, 0.6]\n[[wall]]\nx = 0.0\n[[gas]]\nradius = 0.03\nmass = 1.0\n\
                         energy = 1.0\ncount = 100\n[run]\nuntil = 8.0\nsample_interval = 0.25\nmeasure_from = 1.5\n\
                         observe = [\"energy\"]\n";

    /// The study of a scene with a tee tagged `probe`.
    fn of_scene(words: &[&str]) -> Result<Study> {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("made.toml");
        fs::write(&path, SCENE).unwrap();
        Ok(
            options(&[&[path.to_str().unwrap(), "--body", "probe"], words].concat())
                .study()?
                .0,
        )
    }

    #[test]
    fn a_molecule_comes_with_its_control_in_the_gas_of_the_thesis() {
        let both = study(&TEE);
        let [tee, control] = both.points.as_slice() else {
            panic!("two points")
        };
        assert_eq!(
            (both.name(0).as_str(), both.name(1).as_str(), both.replicas),
            ("tee", "control", 1)
        );
        assert_eq!(
            (tee.scene.bounds.sides, tee.scene.gas[0].radius.clone()),
            ([1.0; 2], Some(0.01.into()))
        );
        assert_eq!(
            (tee.scene.bumper[0].radius, tee.scene.molecule[0].at),
            (0.0025, [0.5; 2])
        );
        let [original, disc] =
            [tee, control].map(|point| point.scene.molecule[0].molecule("molecule").unwrap());
        assert!(disc.is_disc() && disc.mass() == original.mass());
        assert!((disc.area() / original.area() - 1.0).abs() < 1e-14);
        let run = |study: &Study| {
            let run = &study.points[0].scene.run;
            [
                run.measure_from.time().unwrap(),
                run.until,
                run.sample_interval,
            ]
        };
        assert_eq!(run(&both), DENSE);
        let words = |more: &[&str]| study(&[&TEE[..], more].concat());
        assert_eq!(words(&["--control", "off"]).points.len(), 1);
        // A disc is its own control.
        assert_eq!(study(&["disc", "--atom-radius", "0.02"]).points.len(), 1);
        // Ten times as large, all times are ten times as long.
        let large = words(&["--gas-radius", "0.1", "--replicas", "7"]);
        assert_eq!(
            (
                run(&large)[1],
                large.points[0].scene.bounds.sides,
                large.replicas
            ),
            (2000.0, [10.0; 2], 7)
        );
        assert_eq!(
            run(&words(&["--area-fraction", "0.005", "--until", "300"])),
            [100.0, 300.0, 20.0]
        );
        // A large molecule has a large box.
        let rod = study(&["rod:20", "--atom-radius", "0.01"]);
        assert!((rod.points[0].scene.bounds.sides[0] - 2.1).abs() < 1e-12);
    }

    #[test]
    fn a_locked_molecule_has_the_angle_of_the_command_line() {
        for (words, turns) in [
            (&["--lock"][..], 0.0),
            (&["--lock", "180"], 0.5),
            (&["--lock", "-90"], -0.25),
        ] {
            let study = study(&[&TEE[..], words].concat());
            let [entry, control] = [0, 1].map(|point| &study.points[point].scene.molecule[0]);
            assert_eq!(
                (entry.rotation, entry.orientation_turns),
                (Rotation::Locked, Some(turns))
            );
            assert_eq!(control.orientation_turns, None);
        }
    }

    #[test]
    fn a_scene_keeps_its_box_walls_times_and_measures() {
        let study = of_scene(&[]).unwrap();
        let [scene, control] = [0, 1].map(|point| &study.points[point].scene);
        assert_eq!(
            (scene.bounds.sides, scene.wall.len(), scene.run.until),
            ([2.0, 1.0], 1, 8.0)
        );
        assert_eq!(
            (control.molecule[0].at, control.molecule[0].atoms.len()),
            ([0.4, 0.6], 1)
        );
        assert_eq!(
            (
                scene.run.observe.len(),
                scene.measure.len(),
                scene.measure[0].kind.as_str()
            ),
            (1, 1, "kicks")
        );
        let study = of_scene(&["--from", "2", "--until", "4"]).unwrap();
        let run = &study.points[0].scene.run;
        assert_eq!((run.measure_from, run.until), (2.0.into(), 4.0));
    }

    #[test]
    fn a_study_gets_the_measure_and_refuses_what_it_fixes() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("sizes.toml");
        let text = "replicas = 3\nscene = \"base.toml\"\n[[vary]]\nkey = \"gas.0.radius\"\nvalues = [0.03, 0.04]\n\
                    names = [\"small\", \"large\"]\n";
        fs::write(&path, text).unwrap();
        fs::write(root.path().join("base.toml"), SCENE).unwrap();
        let words = |more: &[&str]| [&[path.to_str().unwrap()], more].concat().join(" ");
        let of = |more: &[&str]| options(&words(more).split(' ').collect::<Vec<_>>());
        let (study, name) = of(&["--body", "probe"]).study().unwrap();
        assert_eq!(
            (study.name(0), study.name(1), study.replicas),
            ("small".into(), "large".into(), 3)
        );
        assert!(name == "sizes" && study.title.as_deref() == Some("Brownian motion: study sizes"));
        let scene = &study.points[1].scene;
        assert_eq!(
            (scene.gas[0].radius.clone(), scene.measure[0].kind.as_str()),
            (Some(0.04.into()), "kicks")
        );
        let more = of(&["--body", "probe", "--replicas", "7", "--until", "4"])
            .study()
            .unwrap()
            .0;
        assert_eq!((more.replicas, more.points[0].scene.run.until), (7, 4.0));
        for (words, expected) in [
            (
                &["--body", "gone"][..],
                "point gas.0.radius = small: --body gone",
            ),
            (&[], "--body: it has probe"),
            (
                &["--body", "probe", "--control", "on"],
                "--control: the study",
            ),
            (
                &["--body", "probe", "--lock"],
                "--lock: change it in the study",
            ),
            (
                &["--body", "probe", "--mass", "2"],
                "--mass: change the masses in the study",
            ),
            (
                &["--body", "probe", "--side", "2"],
                "--side: change it in the study",
            ),
            (&["--body", "probe", "--atom-radius", "2"], "--atom-radius"),
        ] {
            let error = format!("{:#}", of(words).study().unwrap_err());
            assert!(error.contains(expected), "'{error}' lacks '{expected}'");
        }
    }

    #[test]
    fn invalid_options_are_refused_by_name() {
        let tee = |more: &[&str]| refused(&[&TEE[..], more].concat());
        let scene = |words: &[&str]| format!("{:#}", of_scene(words).unwrap_err());
        for (error, expected) in [
            (tee(&["--gas-radius=-1"]), "--gas-radius"),
            (tee(&["--gas-radius", "nan"]), "--gas-radius"),
            (tee(&["--area-fraction", "0.8"]), "--area-fraction 0.8"),
            (tee(&["--area-fraction", "0"]), "--area-fraction 0"),
            (tee(&["--side", "0.05"]), "--side 0.05"),
            (tee(&["--side", "inf"]), "--side"),
            (tee(&["--lock", "inf"]), "--lock"),
            (tee(&["--until", "nan"]), "--until"),
            (tee(&["--from", "7", "--until", "5"]), "run.measure_from"),
            (scene(&["--side", "3"]), "--side"),
            (scene(&["--area-fraction", "0.3"]), "--area-fraction"),
            (scene(&["--gas-radius", "0.3"]), "--gas-radius"),
        ] {
            assert!(error.contains(expected), "'{error}' lacks '{expected}'");
        }
    }
}
