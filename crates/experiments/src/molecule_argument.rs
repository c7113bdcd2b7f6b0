//! The molecule of an experiment, as the user names it: a shape, a file of atoms, or a body of a
//! scene.

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail, ensure};
use carom::{Molecule, Scene, Shape, engine::MoleculeSpec, geometry::EdgedShape};
use carom_runs::{command_line::quoted, run::SceneFile};
use carom_sweeps::{Size, Study};
use clap::Args;

/// Options that name the molecule of an experiment.
#[derive(Debug, Clone, Args)]
pub struct MoleculeArgument {
    /// The molecule: disc, dumbbell, rod:N, cross, tee, ring:N (with --atom-radius); capsule:L,
    /// square, rectangle:A, triangle, polygon:N, kite:A,B, ellipse:K (with --size); a TOML file
    /// with `atoms`, `polygon` or `shape`, as a molecule in a scene has; or a scene or a study
    /// (with --body)
    #[arg(value_name = "MOLECULE")]
    pub molecule: String,
    /// Radius of each atom of a named shape (length)
    #[arg(long, value_name = "LENGTH")]
    pub atom_radius: Option<f64>,
    /// Size of a named shape with sides: the length of a side, the diameter of a capsule
    #[arg(long, value_name = "LENGTH", conflicts_with = "atom_radius")]
    pub size: Option<f64>,
    /// Mass of each atom of a named shape
    #[arg(long, value_name = "MASS", conflicts_with = "mass")]
    pub atom_mass: Option<f64>,
    /// Mass of the whole molecule; the atoms share it in proportion to the masses that they would
    /// have without it
    #[arg(long, value_name = "MASS")]
    pub mass: Option<f64>,
    /// Tag of the molecule in a scene, or in the scene of a study
    #[arg(long, value_name = "TAG")]
    pub body: Option<String>,
}

/// A molecule that the user has named, and the scene in which it is.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedMolecule {
    /// A short name for titles and folders: that of the shape, the file, or the tag.
    pub name: String,
    /// The entry of the molecule; without a scene, its place is the origin.
    pub spec: MoleculeSpec,
    /// The molecule.
    pub molecule: Molecule,
    /// The scene, if one was given, and the index of the molecule in it.
    pub scene: Option<(Scene, usize)>,
}

/// The keys of a `[[molecule]]` that describe it; only a file of one molecule has them at the top.
const KEYS: [&str; 13] = [
    "atoms",
    "ellipses",
    "shape",
    "atom_radius",
    "atom_mass",
    "size",
    "mass",
    "density",
    "polygon",
    "rounding",
    "edges",
    "edge_radius",
    "hollow",
];

/// Mass of a named shape with sides, if none is given, in usual masses of an atom: that of the tee
/// of Montanari (2017) with such atoms.
const ATOMS_OF_THE_TEE: f64 = 5.0;

impl MoleculeArgument {
    /// Reads the molecule. Atoms of a named shape have the mass `usual_mass` if none is given.
    ///
    /// # Errors
    /// A file cannot be read or has unknown keys, an option does not apply to what is named, a
    /// number is out of range, or no or more than one molecule of the scene has the tag.
    pub fn read(&self, usual_mass: f64) -> Result<NamedMolecule> {
        for (option, value) in [
            ("--atom-radius", self.atom_radius),
            ("--size", self.size),
            ("--atom-mass", self.atom_mass),
            ("--mass", self.mass),
        ] {
            if let Some(value) = value {
                carom::geometry::check_positive("it", value)
                    .map_err(|reason| anyhow::anyhow!("{option}: {reason}"))?;
            }
        }
        let path = Path::new(&self.molecule);
        if let Ok(shape) = self.molecule.parse::<EdgedShape>() {
            return self.edged(shape, usual_mass);
        }
        match self.molecule.parse::<Shape>() {
            Ok(shape) => self.named(shape, usual_mass),
            Err(reason) if !path.is_file() => {
                bail!(
                    "{reason}; or the name of a file, but there is no file '{}'",
                    self.molecule
                )
            }
            Err(_) => self
                .file(path, usual_mass)
                .with_context(|| format!("molecule {}", path.display())),
        }
    }

    /// These options as words of a command.
    pub fn words(&self) -> String {
        let number =
            |name: &str, value: Option<f64>| value.map(|value| format!(" --{name} {value}"));
        let parts = [
            number("atom-radius", self.atom_radius),
            number("size", self.size),
            number("atom-mass", self.atom_mass),
            number("mass", self.mass),
            self.body
                .as_ref()
                .map(|body| format!(" --body {}", quoted(body))),
        ];
        quoted(&self.molecule) + &parts.into_iter().flatten().collect::<String>()
    }

    fn edged(&self, shape: EdgedShape, usual_mass: f64) -> Result<NamedMolecule> {
        self.refuse_body("a named shape")?;
        for (option, value) in [
            ("--atom-radius", self.atom_radius),
            ("--atom-mass", self.atom_mass),
        ] {
            ensure!(
                value.is_none(),
                "{option}: {shape} has no atoms to choose; give --size and --mass"
            );
        }
        let size = self
            .size
            .with_context(|| format!("give its size: {shape} --size LENGTH"))?;
        let spec = MoleculeSpec {
            shape: Some(shape.to_string()),
            size: Some(size),
            mass: Some(self.mass.unwrap_or(ATOMS_OF_THE_TEE * usual_mass)),
            ..MoleculeSpec::default()
        };
        let name = shape.to_string().replace([':', ','], "-");
        self.finish(name, spec, None)
    }

    fn named(&self, shape: Shape, usual_mass: f64) -> Result<NamedMolecule> {
        self.refuse_body("a named shape")?;
        ensure!(
            self.size.is_none(),
            "--size: it goes with a shape that has sides; {shape} has an --atom-radius"
        );
        let spec = MoleculeSpec {
            shape: Some(shape.to_string()),
            atom_radius: Some(self.atom_radius.with_context(|| {
                format!("give the radius of its atoms: {shape} --atom-radius LENGTH")
            })?),
            atom_mass: Some(self.atom_mass.unwrap_or(usual_mass)),
            ..MoleculeSpec::default()
        };
        self.finish(shape.to_string().replace(':', "-"), spec, None)
    }

    fn file(&self, path: &Path, usual_mass: f64) -> Result<NamedMolecule> {
        let text = fs::read_to_string(path).context("cannot read the file")?;
        let keys: toml::Table = text.parse().context("the file is not TOML")?;
        ensure!(
            !keys.contains_key("scene"),
            "the file is a study, which this command does not take"
        );
        if !KEYS.iter().any(|key| keys.contains_key(*key)) {
            return self.in_scene(path);
        }
        self.refuse_body("a file of one molecule")?;
        if let Some(other) = keys.keys().find(|key| !KEYS.contains(&key.as_str())) {
            bail!("unknown key `{other}`: a molecule has {}", KEYS.join(", "));
        }
        let file: MoleculeSpec = toml::from_str(&text)?;
        let is_of_discs = file
            .shape
            .as_ref()
            .is_some_and(|shape| shape.parse::<Shape>().is_ok());
        if !is_of_discs {
            self.refuse_atom_options("a molecule with lengths of its own")?;
        }
        let has_mass = file.atom_mass.is_some() || file.density.is_some();
        let has_sides = !file.polygon.is_empty() || (file.shape.is_some() && !is_of_discs);
        let needs_mass = has_sides && file.density.is_none();
        let spec = MoleculeSpec {
            atom_radius: self.atom_radius.or(file.atom_radius),
            atom_mass: self
                .atom_mass
                .or(file.atom_mass)
                .or((is_of_discs && !has_mass).then_some(usual_mass)),
            mass: file
                .mass
                .or(needs_mass.then(|| self.mass.unwrap_or(ATOMS_OF_THE_TEE * usual_mass))),
            ..file
        };
        let name = path
            .file_stem()
            .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        self.finish(name, spec, None)
    }

    fn in_scene(&self, path: &Path) -> Result<NamedMolecule> {
        self.refuse_atom_options("a scene")?;
        let file = SceneFile {
            path: PathBuf::from(path),
            until: None,
            seed: None,
            from: None,
            set: Vec::new(),
        };
        let mut scene = file.read(None)?;
        let (body, index) = self.body_of(&scene)?;
        let mut named = self.finish(body.to_owned(), scene.molecule[index].clone(), None)?;
        scene.molecule[index] = named.spec.clone();
        named.scene = Some((scene, index));
        Ok(named)
    }

    /// The study, if the file that was named is one.
    ///
    /// # Errors
    /// The study is invalid, or an option goes with a named shape only.
    pub fn study(&self) -> Result<Option<Study>> {
        let path = Path::new(&self.molecule);
        if self.molecule.parse::<Shape>().is_ok() || !path.is_file() {
            return Ok(None);
        }
        let text =
            fs::read_to_string(path).with_context(|| format!("molecule {}", path.display()))?;
        let is_study = text
            .parse::<toml::Table>()
            .is_ok_and(|keys| keys.contains_key("scene"));
        if !is_study {
            return Ok(None);
        }
        self.refuse_atom_options("a study")?;
        ensure!(
            self.mass.is_none(),
            "--mass: change the masses in the study {}",
            self.molecule
        );
        Study::read(path, Size::default()).map(Some)
    }

    /// The tag of --body, and the index of the only molecule of the scene with this tag.
    ///
    /// # Errors
    /// There is no option --body, or no or more than one body of the scene has the tag.
    pub fn body_of(&self, scene: &Scene) -> Result<(&str, usize)> {
        let tags = || {
            let all: Vec<&str> = scene
                .molecule
                .iter()
                .flat_map(|entry| &entry.tags)
                .map(String::as_str)
                .collect();
            if all.is_empty() {
                "it has none".to_owned()
            } else {
                format!("it has {}", all.join(", "))
            }
        };
        let Some(body) = &self.body else {
            bail!(
                "name the tag of a [[molecule]] of this scene with --body: {}",
                tags()
            );
        };
        let has_tag = |entry: &MoleculeSpec| entry.tags.contains(body);
        let found: Vec<usize> = (0..scene.molecule.len())
            .filter(|&index| has_tag(&scene.molecule[index]))
            .collect();
        let [index] = found[..] else {
            match found[..] {
                [] => bail!(
                    "--body {body}: no [[molecule]] of this scene has this tag: {}",
                    tags()
                ),
                _ => bail!(
                    "--body {body}: {} molecules of this scene have this tag",
                    found.len()
                ),
            }
        };
        let others = scene.gas.iter().map(|gas| &gas.tags);
        let others = others.chain(scene.bumper.iter().map(|entry| &entry.tags));
        ensure!(
            !others
                .chain(scene.wall_tags())
                .any(|tags| tags.contains(body)),
            "--body {body}: other bodies of this scene have this tag, too"
        );
        Ok((body, index))
    }

    /// Builds the molecule with the mass of the command line.
    fn finish(
        &self,
        name: String,
        mut spec: MoleculeSpec,
        scene: Option<(Scene, usize)>,
    ) -> Result<NamedMolecule> {
        let mut molecule = spec.molecule("molecule")?;
        if let Some(mass) = self.mass {
            let factor = mass / molecule.mass();
            spec.atoms.iter_mut().for_each(|atom| atom.mass *= factor);
            spec.ellipses
                .iter_mut()
                .for_each(|ellipse| ellipse.mass *= factor);
            for given in [&mut spec.atom_mass, &mut spec.mass, &mut spec.density] {
                *given = given.map(|value| value * factor);
            }
            molecule = spec.molecule("molecule")?;
        }
        Ok(NamedMolecule {
            name,
            spec,
            molecule,
            scene,
        })
    }

    fn refuse_body(&self, what: &str) -> Result<()> {
        match &self.body {
            Some(body) => bail!(
                "--body {body}: it names a body of a scene, but {} is {what}",
                self.molecule
            ),
            None => Ok(()),
        }
    }

    fn refuse_atom_options(&self, what: &str) -> Result<()> {
        for (option, value) in [
            ("--atom-radius", self.atom_radius),
            ("--size", self.size),
            ("--atom-mass", self.atom_mass),
        ] {
            ensure!(
                value.is_none(),
                "{option}: it goes with a named shape, but {} is {what}",
                self.molecule
            );
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        molecule: MoleculeArgument,
    }

    fn read(words: &[&str]) -> Result<NamedMolecule> {
        Line::try_parse_from([&["carom"], words].concat())?
            .molecule
            .read(2.0)
    }

    /// Reads a file with this text, named `made.toml`.
    fn read_text(text: &str, words: &[&str]) -> Result<NamedMolecule> {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("made.toml");
        fs::write(&path, text).unwrap();
        read(&[&[path.to_str().unwrap()], words].concat())
    }

    const ATOMS: &str = "atoms = [\n  { at = [0.0, 0.0], radius = 0.5, mass = 1.0 },\n  \
                         { at = [1.0, 0.0], radius = 0.25, mass = 3.0 },\n]\n";

    const SCENE: &str = "[[molecule]]\ntags = [\"one\", \"pair\"]\nshape = \"rod:3\"\natom_radius = 0.01\n\
                         atom_mass = 1.0\nat = [0.25, 0.5]\n\
                         [[molecule]]\ntags = [\"two\", \"pair\", \"gas\"]\nshape = \"disc\"\natom_radius = 0.01\n\
                         atom_mass = 1.0\nat = [0.75, 0.5]\n\
                         [[gas]]\ntags = [\"gas\"]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 10\n";

    #[test]
    fn a_named_shape_has_the_usual_mass_unless_one_is_given() {
        let tee = read(&["tee", "--atom-radius", "0.005"]).unwrap();
        assert_eq!((tee.name.as_str(), tee.molecule.mass()), ("tee", 10.0));
        assert!(tee.scene.is_none());
        let mass = |words: &[&str]| {
            let rod = read(&[&["rod:8", "--atom-radius", "0.004"], words].concat()).unwrap();
            assert_eq!(
                (rod.name.as_str(), rod.molecule.atoms().len()),
                ("rod-8", 8)
            );
            rod.molecule.mass()
        };
        assert_eq!(
            (mass(&["--atom-mass", "0.5"]), mass(&["--mass", "12"])),
            (4.0, 12.0)
        );
    }

    #[test]
    fn a_file_has_a_list_of_atoms_or_a_shape() {
        let made = read_text(ATOMS, &[]).unwrap();
        assert_eq!((made.name.as_str(), made.molecule.mass()), ("made", 4.0));
        assert_eq!(made.molecule.atoms()[1].offset().x, 0.25);
        // Atoms share a given mass in proportion to their own.
        let heavy = read_text(ATOMS, &["--mass", "8"]).unwrap();
        assert_eq!(heavy.molecule.atoms()[1].mass(), 6.0);
        let tables = "[[atoms]]\nat = [0.0, 0.0]\nradius = 0.5\nmass = 1.0\n\
                      [[atoms]]\nat = [1.0, 0.0]\nradius = 0.25\nmass = 3.0\n";
        assert_eq!(read_text(tables, &[]).unwrap().molecule, made.molecule);
        let ring = read_text("shape = \"ring:6\"\natom_radius = 0.1\n", &[]).unwrap();
        assert_eq!(
            (ring.molecule.atoms().len(), ring.molecule.mass()),
            (6, 12.0)
        );
    }

    #[test]
    fn a_body_of_a_scene_comes_with_its_scene() {
        let named = read_text(SCENE, &["--body", "one"]).unwrap();
        let (scene, index) = named.scene.unwrap();
        assert_eq!(
            (index, named.molecule.atoms().len(), scene.gas.len()),
            (0, 3, 1)
        );
        assert_eq!(scene.molecule[0], named.spec);
        let heavy = read_text(SCENE, &["--body", "one", "--mass", "6"]).unwrap();
        assert_eq!(heavy.scene.unwrap().0.molecule[0].atom_mass, Some(2.0));
    }

    #[test]
    fn what_is_no_molecule_is_refused_by_name() {
        let radius = ["--atom-radius", "0.1"];
        let named = |words: &[&str]| format!("{:#}", read(words).unwrap_err());
        let atom = |keys: &str| format!("atoms = [{{ at = [0.0, 0.0], {keys} }}]");
        let cases = [
            (named(&["tree", "--atom-radius", "0.1"]), "no file 'tree'"),
            (named(&["rod:0", "--atom-radius", "0.1"]), "no file 'rod:0'"),
            (named(&["tee"]), "--atom-radius LENGTH"),
            (
                named(&["tee", "--atom-radius=-0.1"]),
                "--atom-radius: it must be positive",
            ),
            (
                named(&["tee", "--atom-radius", "nan"]),
                "--atom-radius: it must be positive",
            ),
            (
                named(&[&["tee", "--mass", "0"][..], &radius].concat()),
                "--mass: it must be positive",
            ),
            (
                named(&[&["tee", "--body", "x"][..], &radius].concat()),
                "--body x",
            ),
            (
                format!(
                    "{:#}",
                    read_text(&atom("radius = -1.0, mass = 1.0"), &[]).unwrap_err()
                ),
                "radius",
            ),
            (
                format!(
                    "{:#}",
                    read_text(&atom("radius = nan, mass = 1.0"), &[]).unwrap_err()
                ),
                "NaN",
            ),
            (
                format!("{:#}", read_text(&atom("radius = 1.0"), &[]).unwrap_err()),
                "mass",
            ),
            (
                format!(
                    "{:#}",
                    read_text(&format!("{ATOMS}colour = 1\n"), &[]).unwrap_err()
                ),
                "colour",
            ),
            (
                format!("{:#}", read_text("atoms = []\n", &[]).unwrap_err()),
                "at least one atom",
            ),
            (
                format!("{:#}", read_text(ATOMS, &radius).unwrap_err()),
                "--atom-radius: it goes with",
            ),
            (
                format!("{:#}", read_text(ATOMS, &["--body", "one"]).unwrap_err()),
                "--body one",
            ),
            (
                format!("{:#}", read_text(SCENE, &[]).unwrap_err()),
                "--body: it has one, pair, two",
            ),
            (
                format!("{:#}", read_text(SCENE, &["--body", "gone"]).unwrap_err()),
                "--body gone: no",
            ),
            (
                format!("{:#}", read_text(SCENE, &["--body", "pair"]).unwrap_err()),
                "2 molecules",
            ),
            (
                format!("{:#}", read_text(SCENE, &["--body", "gas"]).unwrap_err()),
                "other bodies",
            ),
            (
                format!(
                    "{:#}",
                    read_text("[elefant]\n", &["--body", "x"]).unwrap_err()
                ),
                "elefant",
            ),
            (
                format!("{:#}", read_text("atoms = [", &[]).unwrap_err()),
                "not TOML",
            ),
        ];
        for (error, expected) in cases {
            assert!(error.contains(expected), "'{error}' lacks '{expected}'");
        }
    }
}
