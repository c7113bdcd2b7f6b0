//! Options of `carom brownian`: the molecule, its gas, and the times of the run.

use std::path::Path;

use anyhow::{Result, bail, ensure};
use carom::{
    engine::{MoleculeSpec, Rotation},
    geometry::check_positive,
};
use carom_runs::{measures::kicks::DILUTE, resumable::Choices};
use carom_sweeps::Study;
use carom_tables::Verdict;
use clap::{Args, builder::BoolishValueParser};

use super::{
    campaign::Campaign,
    plan::Plan,
    run::run_campaign,
    setting::{Gas, Setting, words},
    study_points::{common_plan, settings_of},
};
use crate::{
    common::{Seed, Threads},
    molecule_argument::{MoleculeArgument, NamedMolecule},
};

/// Options of `carom brownian`.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// The molecule.
    #[command(flatten)]
    pub molecule: MoleculeArgument,
    /// Radius of the gas discs (length); default: 0.01
    #[arg(long, value_name = "LENGTH")]
    pub gas_radius: Option<f64>,
    /// Area fraction of the gas, at most 0.7; below 0.01 the shares of kicks by direction and by
    /// atom follow from the exposed arcs and are checked, and runs are longer. Default: 0.5
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
    /// Runs of the molecule, and of its control, that differ in their random numbers only; default:
    /// 1, or those of the study
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub replicas: Option<u64>,
    /// Start of the measurement (time); default: 5 for gas discs of radius 0.01, and 100 in a
    /// dilute gas, in proportion to the radius; of a scene, run.measure_from
    #[arg(long, value_name = "TIME")]
    pub from: Option<f64>,
    /// End of the run (time); default: 200 for gas discs of radius 0.01, and 20000 in a dilute gas,
    /// in proportion to the radius; of a scene, run.until
    #[arg(long, value_name = "TIME")]
    pub until: Option<f64>,
    /// Largest number of rows of impulses.csv in each run; the first kicks are kept (0.2 kB each)
    #[arg(long, value_name = "ROWS", default_value_t = 1_000_000)]
    pub impulses: u64,
    /// Seed.
    #[command(flatten)]
    pub random: Seed,
    /// Threads.
    #[command(flatten)]
    pub threads: Threads,
    /// Output folder and checkpoints.
    #[command(flatten)]
    pub choices: Choices,
}

/// Radius of the gas discs if none is given (length).
const GAS_RADIUS: f64 = 0.01;

/// Area fraction of the gas if none is given.
const AREA_FRACTION: f64 = 0.5;

/// Mass of each atom of a named shape if none is given: twice that of a gas disc, as in the thesis.
const ATOM_MASS: f64 = 2.0;

/// Largest area fraction of the gas.
const DENSEST: f64 = 0.7;

/// Least side of the box in reaches, the bounding radius of the molecule with a gas disc: gas discs
/// pass between the molecule and its images.
const LEAST_REACHES: f64 = 4.0;

/// Runs a molecule in its gas, and its control, and writes their folder.
///
/// # Errors
/// An option or a file is invalid, the folder is not empty, or a run fails.
pub fn run(options: &Options) -> Result<Verdict> {
    run_campaign(&options.campaign()?)
}

impl Options {
    fn campaign(&self) -> Result<Campaign<'_>> {
        match self.molecule.study()? {
            Some(study) => self.of_study(&study),
            None => self.of_molecule(),
        }
    }

    /// Runs of one molecule, and of its control.
    fn of_molecule(&self) -> Result<Campaign<'_>> {
        let named = self.molecule.read(ATOM_MASS)?;
        let spec = self.locked(&named)?;
        let (setting, plan) = match named.scene {
            Some(_) => self.in_scene(&named, spec)?,
            None => self.in_square(&named, spec)?,
        };
        setting.check()?;
        let title = setting.title.clone();
        let mut settings = vec![setting];
        if self.control.unwrap_or(true) && !named.molecule.is_round() {
            settings.push(settings[0].control(&named.molecule));
        }
        self.of_settings(settings, &named.name, &title, plan, self.replicas.unwrap_or(1))
    }

    /// Runs at all points of a study.
    fn of_study(&self, study: &Study) -> Result<Campaign<'_>> {
        ensure!(self.lock.is_none(), "--lock: change it in the study {}", self.molecule.molecule);
        self.refuse_gas_options("the study")?;
        ensure!(
            self.control != Some(true),
            "--control: the study {} lists all that runs; add the control as a point",
            self.molecule.molecule
        );
        let settings = settings_of(study, |scene| Ok(self.molecule.body_of(scene)?.1))?;
        let plan = common_plan(&settings)?;
        let path = Path::new(&self.molecule.molecule);
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let title = format!("{} points of the study {name}", settings.len());
        self.of_settings(settings, &name, &title, plan, self.replicas.unwrap_or(study.replicas))
    }

    /// The campaign of these settings.
    fn of_settings(
        &self,
        settings: Vec<Setting>,
        name: &str,
        title: &str,
        plan: Plan,
        replicas: u64,
    ) -> Result<Campaign<'_>> {
        let plan = plan.with(self.from, self.until)?;
        let command = self.command(&plan, replicas);
        Ok(Campaign {
            replicas,
            seed: self.random.seed,
            plan,
            impulses: self.impulses,
            choices: &self.choices,
            usual_folder: format!("out/brownian-{name}"),
            threads: self.threads,
            program: "carom brownian",
            configuration: format!("command = {}\n", toml::Value::from(command.clone())),
            command,
            note: self.note(&settings[0])?,
            title: format!("Brownian motion: {title}"),
            settings,
        })
    }

    /// The entry of the molecule, with its orientation locked if the command line says so.
    fn locked(&self, named: &NamedMolecule) -> Result<MoleculeSpec> {
        let Some(degrees) = self.lock else { return Ok(named.spec.clone()) };
        ensure!(degrees.is_finite(), "--lock {degrees}: the angle must be finite");
        Ok(MoleculeSpec {
            orientation: None,
            orientation_turns: Some(degrees / 360.0),
            angular_velocity: 0.0,
            rotation: Rotation::Locked,
            ..named.spec.clone()
        })
    }

    /// The molecule in the middle of a periodic square.
    fn in_square(&self, named: &NamedMolecule, spec: MoleculeSpec) -> Result<(Setting, Plan)> {
        for (option, value) in [("--gas-radius", self.gas_radius), ("--side", self.side)] {
            if let Some(value) = value {
                check_positive("it", value).map_err(|reason| anyhow::anyhow!("{option}: {reason}"))?;
            }
        }
        let radius = self.gas_radius.unwrap_or(GAS_RADIUS);
        let area_fraction = self.area_fraction.unwrap_or(AREA_FRACTION);
        ensure!(
            area_fraction > 0.0 && area_fraction <= DENSEST,
            "--area-fraction {area_fraction}: it must be above 0 and at most {DENSEST}, near the freezing density"
        );
        let side = self.side.unwrap_or_else(|| Gas::usual_side(radius, &named.molecule));
        let least = LEAST_REACHES * (named.molecule.bounding_radius() + radius);
        ensure!(
            side >= least,
            "--side {side}: the molecule with a gas disc around it needs a box of at least {least:.6}"
        );
        let ready = if area_fraction < DILUTE { Plan::DILUTE } else { Plan::DENSE };
        let spec = MoleculeSpec { tags: vec![TAG.to_owned()], ..spec };
        let setting = Setting {
            name: named.name.clone(),
            title: named.name.clone(),
            words: words(&named.molecule, &spec),
            scene: Gas { radius, area_fraction, side }.around(spec),
            body: 0,
        };
        Ok((setting, ready.scaled(radius / GAS_RADIUS)))
    }

    /// The molecule in a scene of the user.
    fn in_scene(&self, named: &NamedMolecule, spec: MoleculeSpec) -> Result<(Setting, Plan)> {
        let Some((scene, body)) = &named.scene else { bail!("there is no scene") };
        self.refuse_gas_options("the scene")?;
        let mut scene = scene.clone();
        let words = words(&named.molecule, &spec);
        scene.molecule[*body] = spec;
        let plan = Plan::of(&scene.run);
        let name = named.name.clone();
        Ok((Setting { title: name.clone(), name, words, scene, body: *body }, plan))
    }

    fn refuse_gas_options(&self, what: &str) -> Result<()> {
        for (option, value) in [
            ("--gas-radius", self.gas_radius),
            ("--area-fraction", self.area_fraction),
            ("--side", self.side),
        ] {
            ensure!(value.is_none(), "{option}: change it in {what} {}", self.molecule.molecule);
        }
        Ok(())
    }

    /// What of the scene is left out or not exact, for the reader.
    fn note(&self, setting: &Setting) -> Result<String> {
        let (scene, method) = (&setting.scene, setting.method()?);
        let mut notes = Vec::new();
        if !method.is_exact() {
            notes.push(format!("NOT EXACT. Method: {method}. Contacts may be missed, late or invented."));
        }
        if self.molecule.body.is_some() && !(scene.measure.is_empty() && scene.run.observe.is_empty()) {
            let left = "run.observe and [[measure]] of the scene are not measured here; carom run does.";
            notes.push(left.to_owned());
        }
        Ok(notes.join(" "))
    }

    /// The command with every option that affects the results.
    fn command(&self, plan: &Plan, replicas: u64) -> String {
        let mut words = vec!["carom brownian".to_owned(), self.molecule.words()];
        let mut number = |option: &str, value: Option<f64>| {
            words.extend(value.map(|value| format!("{option} {value}")));
        };
        number("--gas-radius", self.gas_radius);
        number("--area-fraction", self.area_fraction);
        number("--side", self.side);
        number("--lock", self.lock);
        let control = self.control.map_or("", |is_on| if is_on { " --control on" } else { " --control off" });
        words.push(format!(
            "--seed {}{control} --replicas {replicas} --from {} --until {} --impulses {}",
            self.random.seed, plan.from, plan.until, self.impulses
        ));
        words.join(" ")
    }
}

/// Tag of the molecule in a scene that the command makes.
const TAG: &str = "molecule";

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use std::fs;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        options: Options,
    }

    fn options(words: &[&str]) -> Options {
        Line::try_parse_from([&["carom"], words].concat()).unwrap().options
    }

    fn refused(words: &[&str]) -> String {
        format!("{:#}", options(words).campaign().unwrap_err())
    }

    const TEE: [&str; 3] = ["tee", "--atom-radius", "0.005"];

    /// The campaign of a scene with a tee tagged `probe`, and of its changed text.
    fn of_scene(change: fn(String) -> String, words: &[&str]) -> Result<(Vec<Setting>, Plan, String)> {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("made.toml");
        let text = "[box]\nsides = [2.0, 1.0]\n[[molecule]]\ntags = [\"probe\"]\nshape = \"tee\"\natom_radius = 0.02\n\
                    atom_mass = 3.0\nat = [0.4, 0.6]\n[[wall]]\nx = 0.0\n[[gas]]\nradius = 0.03\nmass = 1.0\n\
                    energy = 1.0\ncount = 100\n[run]\nuntil = 8.0\nsample_interval = 0.25\nmeasure_from = 1.5\n\
                    observe = [\"energy\"]\n";
        fs::write(&path, change(text.to_owned())).unwrap();
        let options = options(&[&[path.to_str().unwrap(), "--body", "probe"], words].concat());
        options.campaign().map(|campaign| (campaign.settings, campaign.plan, campaign.note))
    }

    #[test]
    fn a_molecule_comes_with_its_control_in_the_gas_of_the_thesis() {
        let options = options(&TEE);
        let campaign = options.campaign().unwrap();
        let [tee, control] = campaign.settings.as_slice() else { panic!("two settings") };
        assert_eq!((tee.name.as_str(), control.name.as_str()), ("tee", "control"));
        assert_eq!((tee.scene.bounds.sides, tee.surroundings().unwrap().probe()), ([1.0; 2], 0.01));
        assert_eq!(tee.scene.bumper[0].radius, 0.0025);
        assert_eq!(campaign.plan, Plan::DENSE);
        assert!(campaign.command.starts_with("carom brownian tee --atom-radius 0.005 --seed 1 --replicas 1"));
        let words = |more: &[&str]| self::options(&[&TEE[..], more].concat());
        assert_eq!(words(&["--control", "off"]).campaign().unwrap().settings.len(), 1);
        // A disc is its own control.
        let disc = self::options(&["disc", "--atom-radius", "0.02"]);
        assert_eq!(disc.campaign().unwrap().settings.len(), 1);
        // Ten times as large, all times are ten times as long.
        let large = words(&["--gas-radius", "0.1"]);
        let large = large.campaign().unwrap();
        assert_eq!((large.plan.until, large.settings[0].scene.bounds.sides), (2000.0, [10.0; 2]));
        let dilute = words(&["--area-fraction", "0.005", "--until", "300"]);
        assert_eq!(dilute.campaign().unwrap().plan, Plan { until: 300.0, ..Plan::DILUTE });
        // A large molecule has a large box.
        let rod = self::options(&["rod:20", "--atom-radius", "0.01"]);
        let rod = rod.campaign().unwrap();
        assert!((rod.settings[0].scene.bounds.sides[0] - 2.1).abs() < 1e-12);
    }

    #[test]
    fn a_locked_molecule_has_the_angle_of_the_command_line() {
        for (words, turns) in [(&["--lock"][..], 0.0), (&["--lock", "180"], 0.5), (&["--lock", "-90"], -0.25)]
        {
            let options = options(&[&TEE[..], words].concat());
            let campaign = options.campaign().unwrap();
            let entry = &campaign.settings[0].scene.molecule[0];
            assert_eq!((entry.rotation, entry.orientation_turns), (Rotation::Locked, Some(turns)));
            assert_eq!(campaign.settings[1].scene.molecule[0].orientation_turns, None);
        }
    }

    #[test]
    fn a_scene_keeps_its_box_walls_and_times() {
        let (settings, plan, note) = of_scene(|text| text, &[]).unwrap();
        assert_eq!(plan, Plan { from: 1.5, until: 8.0, sample_interval: 0.25 });
        assert_eq!((settings[0].scene.bounds.sides, settings[0].scene.wall.len()), ([2.0, 1.0], 1));
        assert_eq!(
            (settings[1].scene.molecule[0].at, settings[0].surroundings().unwrap().probe()),
            ([0.4, 0.6], 0.03)
        );
        assert!(!settings[0].is_open() && note.contains("run.observe"), "{note}");
        let (_, plan, _) = of_scene(|text| text, &["--from", "2", "--until", "4"]).unwrap();
        assert_eq!((plan.from, plan.until), (2.0, 4.0));
        let step = |text| text + "[method]\ndetector = \"fixed-step\"\nstep = 0.3\n";
        assert!(of_scene(step, &[]).unwrap().2.starts_with("NOT EXACT"));
    }

    #[test]
    fn a_study_gives_a_setting_for_each_point_and_refuses_what_it_fixes() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("sizes.toml");
        let text = "replicas = 3\nscene = \"base.toml\"\n[[vary]]\nkey = \"gas.0.radius\"\nvalues = [0.03, 0.04]\n\
                    names = [\"small\", \"large\"]\n";
        let scene = "[[molecule]]\ntags = [\"probe\"]\nshape = \"tee\"\natom_radius = 0.02\natom_mass = 3.0\n\
                     at = [0.4, 0.6]\n[[wall]]\nx = 0.0\n[[gas]]\nradius = 0.03\nmass = 1.0\nenergy = 1.0\ncount = 50\n\
                     [run]\nuntil = 8.0\nsample_interval = 0.25\nmeasure_from = 1.5\n";
        fs::write(&path, text).unwrap();
        fs::write(root.path().join("base.toml"), scene).unwrap();
        let options = |more: &[&str]| options(&[&[path.to_str().unwrap()], more].concat());
        let own = options(&["--body", "probe"]);
        let campaign = own.campaign().unwrap();
        let names: Vec<&str> = campaign.settings.iter().map(|setting| setting.name.as_str()).collect();
        assert_eq!((names.as_slice(), campaign.replicas), (&["small", "large"][..], 3));
        assert_eq!(campaign.plan, Plan { from: 1.5, until: 8.0, sample_interval: 0.25 });
        assert_eq!(campaign.settings[1].scene.gas[0].radius, Some(0.04));
        assert!(campaign.usual_folder.ends_with("brownian-sizes"));
        let more = options(&["--body", "probe", "--replicas", "7", "--until", "4"]);
        assert_eq!(more.campaign().unwrap().replicas, 7);
        for (words, expected) in [
            (&["--body", "gone"][..], "point gas.0.radius = small: --body gone"),
            (&[], "--body: it has probe"),
            (&["--body", "probe", "--control", "on"], "--control: the study"),
            (&["--body", "probe", "--lock"], "--lock: change it in the study"),
            (&["--body", "probe", "--mass", "2"], "--mass: change the masses in the study"),
            (&["--body", "probe", "--side", "2"], "--side: change it in the study"),
            (&["--body", "probe", "--atom-radius", "2"], "--atom-radius"),
        ] {
            let error = format!("{:#}", options(words).campaign().unwrap_err());
            assert!(error.contains(expected), "'{error}' lacks '{expected}'");
        }
    }

    #[test]
    fn invalid_options_are_refused_by_name() {
        let tee = |more: &[&str]| refused(&[&TEE[..], more].concat());
        let scene = |words: &[&str]| format!("{:#}", of_scene(|text| text, words).unwrap_err());
        for (error, expected) in [
            (tee(&["--gas-radius=-1"]), "--gas-radius"),
            (tee(&["--gas-radius", "nan"]), "--gas-radius"),
            (tee(&["--area-fraction", "0.8"]), "--area-fraction 0.8"),
            (tee(&["--area-fraction", "0"]), "--area-fraction 0"),
            (tee(&["--side", "0.05"]), "--side 0.05"),
            (tee(&["--side", "inf"]), "--side"),
            (tee(&["--lock", "inf"]), "--lock"),
            (tee(&["--until", "nan"]), "--until"),
            (tee(&["--from", "7", "--until", "5"]), "--from"),
            (scene(&["--side", "3"]), "--side"),
            (scene(&["--area-fraction", "0.3"]), "--area-fraction"),
            (scene(&["--gas-radius", "0.3"]), "--gas-radius"),
        ] {
            assert!(error.contains(expected), "'{error}' lacks '{expected}'");
        }
    }
}
