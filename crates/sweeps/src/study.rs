//! A study: a scene, the keys of it that vary, the number of replicas, and what ends each of them.

use std::{collections::BTreeMap, fs, path::Path};

use anyhow::{Context, Result, bail, ensure};
use carom::engine::StopSpec;
use carom_runs::{other_run::refuse_other, overrides::Override};
use carom_tables::{Figure, without_numbers};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use crate::{
    expect::{Expect, ExpectationAnswer},
    point::{Key, StudyPoint},
    vary::{Vary, VarySpec},
};

/// Largest number of points of a study, and of replicas of all points together; more are a mistake.
const MAX_POINTS: usize = 100_000;
const MAX_REPLICAS: u64 = 10_000_000;

/// A study file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StudyFile {
    /// Title of the page. Default: the numbers of points and replicas.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    title: Option<String>,
    /// The question that the study answers, at the head of the page.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    question: Option<String>,
    /// Number of replicas of each point: runs with different random numbers. All points together
    /// have at most 10 000 000.
    #[serde(default = "one")]
    #[schemars(range(min = 1, max = 10_000_000))]
    replicas: u64,
    /// Measures besides those of the scene: names as in `run.observe`, or tables as `[[measure]]`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(with = "Vec<serde_json::Value>")]
    measure: Vec<Value>,
    /// What ends each replica before `run.until`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    stop: Option<StopSpec>,
    /// The keys of the scene that change. The points are all combinations of the entries, at most
    /// 100 000; the last entry varies fastest.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    vary: Vec<VarySpec>,
    /// What is expected of the results.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    expect: Vec<Expect>,
    /// The short form, taken by `--quick`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    quick: Option<Quick>,
    /// The scene: the path of its file relative to the study, or the scene as a table `[scene]`.
    #[schemars(with = "serde_json::Value")]
    scene: Value,
}

/// The short form of a study, which `carom sweep STUDY --quick` runs: what it changes. The varied
/// keys and their values are those of the study.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Quick {
    /// Number of replicas of each point; default: that of the study. `--replicas` overrides it.
    #[schemars(range(min = 1, max = 10_000_000))]
    replicas: Option<u64>,
    /// What ends each replica, in the place of the table `stop` of the study.
    stop: Option<StopSpec>,
    /// Paths of keys of the scene with their values, such as `"run.until" = 10.0`. Keys that vary
    /// are refused.
    #[schemars(with = "serde_json::Map<String, serde_json::Value>")]
    set: Table,
}

impl Quick {
    /// The scene with the changed keys; with the first value of each varied key it is valid.
    fn scene(&self, base: &Table, vary: &[Vary]) -> Result<Table> {
        let mut base = base.clone();
        for (key, value) in &self.set {
            let is_varied = vary.iter().any(|vary| vary.keys.contains(key));
            ensure!(!is_varied, "[quick.set]: `{key}` varies");
            Override::new(key, value.clone())
                .and_then(|set| set.apply(&mut base))
                .context("[quick.set]")?;
        }
        let keys: Vec<&str> = vary
            .iter()
            .flat_map(|vary| vary.keys.iter().map(String::as_str))
            .collect();
        let values = vary
            .iter()
            .flat_map(|vary| vary.settings[0].clone())
            .collect();
        StudyPoint::new(&base, &keys, values, "of the short form".to_owned()).context("[quick]")?;
        Ok(base)
    }
}

/// How large a study is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Size {
    /// Number of replicas of each point instead of that of the study.
    pub replicas: Option<u64>,
    /// Whether the short form is taken, from `[quick]`.
    pub is_quick: bool,
}

const fn one() -> u64 {
    1
}

/// A study, with its points.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// Title of the page, if it has one of its own.
    pub title: Option<String>,
    /// The question that the study answers.
    pub question: Option<String>,
    /// Number of replicas of each point.
    pub replicas: u64,
    /// What varies, from the slowest to the fastest.
    pub vary: Vec<Vary>,
    /// The points: all combinations of values.
    pub points: Vec<StudyPoint>,
    /// Ends the replicas of a point before `run.until`; an error is that of all replicas together.
    stop: Option<StopSpec>,
    /// What is expected of the results.
    expect: Vec<Expect>,
    /// The points, in ascending order, that each entry of `expect` tests.
    tested: Vec<Vec<usize>>,
    /// The scene as a table, with the measures of the study.
    base: Table,
}

impl Study {
    /// Reads a study file and validates all its points, without placing bodies.
    ///
    /// # Errors
    /// The file or the scene cannot be read, a key is unknown, or a point is invalid.
    pub fn read(path: &Path, size: Size) -> Result<Self> {
        let shown = path.display();
        let text = fs::read_to_string(path)
            .with_context(|| format!("cannot read the study file {shown}"))?;
        let folder = path.parent().unwrap_or_else(|| Path::new(""));
        Self::parse(&text, folder, size).with_context(|| format!("study {shown}"))
    }

    /// Reads a study from text; a path to a scene is relative to `folder`.
    ///
    /// # Errors
    /// Those of [`Self::read`].
    pub fn parse(text: &str, folder: &Path, size: Size) -> Result<Self> {
        let file: StudyFile = toml::from_str(text).map_err(|error| unknown_key(&error, text))?;
        let StudyFile {
            title,
            question,
            scene,
            mut replicas,
            measure,
            mut stop,
            vary,
            expect,
            quick,
        } = file;
        let mut base = base(scene, folder)?;
        let entry = |(index, spec): (usize, &VarySpec)| {
            Vary::new(spec).with_context(|| format!("vary[{index}]"))
        };
        let vary = vary
            .iter()
            .enumerate()
            .map(entry)
            .collect::<Result<Vec<_>>>()?;
        refuse_repeated_keys(&vary)?;
        if let Some(quick) = &quick {
            // Also without --quick, so that an error in it is found.
            let shortened = quick.scene(&base, &vary)?;
            if size.is_quick {
                base = shortened;
                replicas = quick.replicas.unwrap_or(replicas);
                stop = quick.stop.clone().or(stop);
            }
        } else if size.is_quick {
            bail!("--quick: the study has no table [quick], its short form");
        }
        measure
            .into_iter()
            .try_for_each(|entry| add_measure(&mut base, entry))?;
        let replicas = size.replicas.unwrap_or(replicas);
        check_counts(&vary, replicas)?;
        let (points, tested) = (Vec::new(), Vec::new());
        let mut study = Self {
            title,
            question,
            replicas,
            vary,
            points,
            stop,
            expect,
            tested,
            base,
        };
        study.points = study.make_points()?;
        study.tested = study.expected_points()?;
        Ok(study)
    }

    /// All combinations of values; the last entry varies fastest.
    fn make_points(&self) -> Result<Vec<StudyPoint>> {
        let keys = self.keys();
        let count: usize = self.vary.iter().map(|vary| vary.settings.len()).product();
        let mut base = self.base.clone();
        self.add_stop(&mut base)?;
        let point = |index: usize| {
            let settings = || {
                self.vary
                    .iter()
                    .enumerate()
                    .map(|(entry, vary)| (vary, self.setting(index, entry)))
            };
            let values = settings()
                .flat_map(|(vary, setting)| vary.settings[setting].clone())
                .collect();
            let words: Vec<String> = settings()
                .map(|(vary, setting)| vary.words(setting))
                .collect();
            let label = if words.is_empty() {
                "the scene".to_owned()
            } else {
                words.join(", ")
            };
            let point = StudyPoint::new(&base, &keys, values, label)?;
            point.check()?;
            Ok(point)
        };
        let points: Vec<StudyPoint> = (0..count)
            .into_par_iter()
            .map(point)
            .collect::<Result<_>>()?;
        let mut by_key: BTreeMap<Key, &StudyPoint> = BTreeMap::new();
        for point in &points {
            if let Some(same) = by_key.insert(point.key, point) {
                bail!(
                    "the points {} and {} are the same scene",
                    same.label,
                    point.label
                );
            }
        }
        Ok(points)
    }

    /// The points that each entry of `expect` tests, by their indices in ascending order.
    fn expected_points(&self) -> Result<Vec<Vec<usize>>> {
        if self.expect.is_empty() {
            return Ok(Vec::new());
        }
        let mut keys = self.keys();
        let paths: Vec<String> = self.vary.iter().flat_map(Vary::columns).collect();
        keys.extend(paths.iter().map(String::as_str));
        let cells: Vec<Vec<(String, Value)>> = (0..self.points.len())
            .map(|point| self.cells(point))
            .collect();
        let of_entry = |(index, expect): (usize, &Expect)| -> Result<Vec<usize>> {
            let entry = || format!("expect[{index}]");
            expect.check(&keys, &cells).with_context(entry)?;
            let tested: Vec<usize> = (0..cells.len())
                .filter(|&point| expect.applies(&cells[point]))
                .collect();
            ensure!(!tested.is_empty(), "{}: `only` leaves no point", entry());
            if let Some(values) = &expect.values {
                let (count, points) = (values.len(), tested.len());
                ensure!(
                    count == points,
                    "{}: {count} `values` for {points} points",
                    entry()
                );
            }
            Ok(tested)
        };
        self.expect.iter().enumerate().map(of_entry).collect()
    }

    /// The values of a point by key; names of settings by the common path, and both by a label.
    fn cells(&self, point: usize) -> Vec<(String, Value)> {
        let of_entry = |(entry, vary): (usize, &Vary)| {
            let setting = self.setting(point, entry);
            let values = vary
                .keys
                .iter()
                .cloned()
                .zip(vary.settings[setting].iter().cloned());
            let name = vary
                .names
                .as_ref()
                .map(|names| Value::String(names[setting].clone()));
            let name = name.or_else(|| {
                vary.label
                    .as_ref()
                    .map(|_| vary.settings[setting][0].clone())
            });
            let named = name.map(|name| (vary.columns().concat(), name));
            values.chain(named).collect::<Vec<_>>()
        };
        self.vary.iter().enumerate().flat_map(of_entry).collect()
    }

    /// The place of the first `[[expect]]` entry about a figure, in the order of the file.
    pub fn place_of_expectation(&self, figure: &str) -> Option<usize> {
        let is_about = |expect: &Expect| {
            expect
                .figure
                .as_ref()
                .is_some_and(|name| without_numbers(name) == without_numbers(figure))
        };
        self.expect.iter().position(is_about)
    }

    /// Compares the results of a point, by its index, with what is expected.
    pub fn answers(
        &self,
        point: usize,
        figures: &[Figure],
        tables: &[carom_tables::Table],
    ) -> Vec<ExpectationAnswer> {
        let of_entry = |(expect, tested): (&Expect, &Vec<usize>)| {
            let number = tested.binary_search(&point).ok()?;
            Some(expect.answer(number, figures, tables))
        };
        self.expect
            .iter()
            .zip(&self.tested)
            .filter_map(of_entry)
            .collect()
    }

    /// Number of answers when all points have results.
    pub fn expected_answers(&self) -> usize {
        self.tested.iter().map(Vec::len).sum()
    }

    /// Writes `[stop]` into the scene. The error of the mean of n equal replicas is smaller by √n
    /// than that of each.
    fn add_stop(&self, base: &mut Table) -> Result<()> {
        let Some(stop) = &self.stop else {
            return Ok(());
        };
        let run = base
            .entry("run")
            .or_insert_with(|| Value::Table(Table::new()));
        let Value::Table(run) = run else {
            bail!("`run` of the scene is no table")
        };
        ensure!(
            !run.contains_key("stop"),
            "[stop] is given, and so is [run.stop] of the scene: give one"
        );
        let factor = (self.replicas as f64).sqrt();
        let of_one = |error: Option<f64>| error.map(|error| error * factor);
        let stop = StopSpec {
            standard_error: of_one(stop.standard_error),
            relative_error: of_one(stop.relative_error),
            ..stop.clone()
        };
        run.insert("stop".to_owned(), Value::try_from(stop)?);
        Ok(())
    }

    /// The setting of an entry of [`Self::vary`] at a point, both by their indices; the last entry
    /// varies fastest.
    pub fn setting(&self, point: usize, entry: usize) -> usize {
        let faster: usize = self.vary[entry + 1..]
            .iter()
            .map(|vary| vary.settings.len())
            .product();
        point / faster % self.vary[entry].settings.len()
    }

    /// The names of the settings of a point, or else their values, such as `tee, 0.1`; of a study
    /// without varied keys it is empty.
    pub fn name(&self, point: usize) -> String {
        let entries = self.vary.iter().enumerate();
        let cells = entries.flat_map(|(entry, vary)| vary.cells(self.setting(point, entry)));
        cells.collect::<Vec<_>>().join(", ")
    }

    /// The paths of all varied keys, in the order of the values of a point.
    pub fn keys(&self) -> Vec<&str> {
        self.vary
            .iter()
            .flat_map(|vary| vary.keys.iter().map(String::as_str))
            .collect()
    }

    /// The study as the text of a file that needs no other file, without comments and with all
    /// values listed. [`Self::parse`] reads it.
    ///
    /// # Panics
    /// Never: a study is plain data.
    pub fn text(&self) -> String {
        let file = StudyFile {
            title: self.title.clone(),
            question: self.question.clone(),
            replicas: self.replicas,
            measure: Vec::new(),
            stop: self.stop.clone(),
            vary: self.vary.iter().map(Vary::spec).collect(),
            expect: self.expect.clone(),
            quick: None,
            scene: Value::Table(self.base.clone()),
        };
        toml::to_string(&file).expect("a study is plain data, which TOML can always hold")
    }

    /// Refuses a study of another subject: with another scene, other keys, or other rules that end
    /// runs. Other values and another number of replicas are the same subject.
    ///
    /// # Errors
    /// The first line that differs.
    pub fn refuse_other_subject(&self, other: &Self) -> Result<()> {
        let subject = |study: &Self| {
            let vary = |vary: &Vary| Vary {
                settings: Vec::new(),
                names: None,
                ..vary.clone()
            };
            let vary = study.vary.iter().map(vary).collect();
            let (title, question) = (None, None);
            let (expect, points) = (Vec::new(), Vec::new());
            Self {
                title,
                question,
                replicas: 1,
                vary,
                expect,
                points,
                ..study.clone()
            }
            .text()
        };
        refuse_other(&subject(other), &subject(self))
    }
}

/// The scene as a table.
fn base(scene: Value, folder: &Path) -> Result<Table> {
    match scene {
        Value::Table(table) => Ok(table),
        Value::String(name) => {
            let path = folder.join(&name);
            let shown = path.display();
            let text = fs::read_to_string(&path)
                .with_context(|| format!("cannot read the scene file {shown}"))?;
            text.parse().with_context(|| format!("scene {shown}"))
        }
        other => bail!("`scene` must be the path of a scene file, or a table, but is {other}"),
    }
}

/// Adds a measure of the study to the scene: a name as in `run.observe`, or a table as
/// `[[measure]]`.
fn add_measure(base: &mut Table, entry: Value) -> Result<()> {
    let list = match &entry {
        Value::String(_) => {
            let run = base
                .entry("run")
                .or_insert_with(|| Value::Table(Table::new()));
            let Value::Table(run) = run else {
                bail!("`run` of the scene is no table")
            };
            run.entry("observe")
                .or_insert_with(|| Value::Array(Vec::new()))
        }
        Value::Table(_) => base
            .entry("measure")
            .or_insert_with(|| Value::Array(Vec::new())),
        other => {
            bail!("`measure` must have names, or tables as [[measure]] of a scene, but has {other}")
        }
    };
    let Value::Array(list) = list else {
        bail!("`observe` or `measure` of the scene is no list")
    };
    if !list.contains(&entry) {
        list.push(entry);
    }
    Ok(())
}

fn refuse_repeated_keys(vary: &[Vary]) -> Result<()> {
    let keys: Vec<&String> = vary.iter().flat_map(|vary| &vary.keys).collect();
    for (index, key) in keys.iter().enumerate() {
        ensure!(!keys[..index].contains(key), "the key `{key}` varies twice");
    }
    Ok(())
}

/// Refuses too many points, and too many or no replicas.
fn check_counts(vary: &[Vary], replicas: u64) -> Result<()> {
    let count = vary.iter().fold(1usize, |count, vary| {
        count.saturating_mul(vary.settings.len())
    });
    ensure!(
        count <= MAX_POINTS,
        "the study has {count} points; allowed are {MAX_POINTS}"
    );
    let most = MAX_REPLICAS / count as u64;
    ensure!(
        (1..=most).contains(&replicas),
        "`replicas` must be from 1 to {most} with {count} points, but is {replicas}"
    );
    Ok(())
}

/// The error of a study file, with a hint where its tables are those of a scene.
fn unknown_key(error: &toml::de::Error, text: &str) -> anyhow::Error {
    let is_scene = ["[[gas]]", "[box]", "[[molecule]]", "[run]"];
    let is_scene = text
        .lines()
        .any(|line| is_scene.iter().any(|table| line.starts_with(table)));
    let hint = if is_scene && error.message().starts_with("unknown field") {
        "; this is a scene, which `carom run` runs; inside a study it is in the table [scene]: [scene.box], \
         [[scene.gas]], …"
    } else {
        ""
    };
    anyhow::anyhow!("{}{hint}", error.to_string().trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "[scene.box]\nseed = 3\n[[scene.gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\n\
                         area_fraction = 0.1\n[scene.run]\nuntil = 1.0\n";

    fn study(head: &str) -> Result<Study> {
        Study::parse(&format!("{head}\n{SCENE}"), Path::new(""), Size::default())
    }

    const VARY: &str = "replicas = 4\n[[vary]]\nkey = \"gas.0.area_fraction\"\nvalues = [0.1, 0.3]\n\
                        [[vary]]\nkeys = [\"gas.0.radius\", \"gas.0.mass\"]\nvalues = [[0.01, 1], [0.02, 4], [0.03, 9]]";

    #[test]
    fn entries_are_combined_and_the_last_varies_fastest() {
        let study = study(VARY).unwrap();
        assert_eq!((study.points.len(), study.replicas), (6, 4));
        assert_eq!(
            study.points[1].label,
            "gas.0.area_fraction = 0.1, gas.0.radius = 0.02, gas.0.mass = 4"
        );
        assert_eq!(study.points[4].scene.gas[0].area_fraction, Some(0.3));
        let again = Study::parse(&study.text(), Path::new(""), Size::default()).unwrap();
        assert_eq!(again, study);
        assert_eq!(again.text(), study.text());
    }

    #[test]
    fn comments_and_new_values_keep_points_and_other_scenes_are_another_subject() {
        let one = study(VARY).unwrap();
        let more = study(
            &VARY
                .replace("[0.1, 0.3]", "[0.1, 0.2, 0.3] # more")
                .replace("= 4", "= 9"),
        )
        .unwrap();
        one.refuse_other_subject(&more).unwrap();
        assert!(one.points.iter().all(|point| more.points.contains(point)));
        let other = Study::parse(
            &format!("{VARY}\n{}", SCENE.replace("energy = 1.0", "energy = 2.0")),
            Path::new(""),
            Size::default(),
        );
        let error = one
            .refuse_other_subject(&other.unwrap())
            .unwrap_err()
            .to_string();
        assert!(error.contains("another"), "{error}");
    }

    #[test]
    fn a_wanted_error_is_shared_among_the_replicas() {
        let stop = "[stop]\nfigure = \"collision rate\"\nrelative_error = 0.01\n";
        let study = study(&format!("replicas = 16\n{stop}")).unwrap();
        let of_one = study.points[0].scene.run.stop.as_ref().unwrap();
        assert_eq!(of_one.relative_error, Some(0.04));
        assert_eq!(study.points[0].label, "the scene");
        let again = Study::parse(&study.text(), Path::new(""), Size::default()).unwrap();
        assert_eq!(again.points, study.points);
    }

    #[test]
    fn measures_are_added_to_those_of_the_scene() {
        let added =
            study("measure = [\"pressure\", { kind = \"pair-distribution\", bins = 20 }]").unwrap();
        let scene = &added.points[0].scene;
        assert_eq!(
            (scene.run.observe.as_slice(), scene.measure.len()),
            (&["pressure".to_owned()][..], 1)
        );
        let error = format!("{:#}", study("measure = [\"presure\"]").unwrap_err());
        assert!(
            error.contains("point the scene") && error.contains("did you mean `pressure`?"),
            "{error}"
        );
    }

    #[test]
    fn studies_are_refused_with_the_place_of_the_error() {
        for (head, expected) in [
            ("replicas = 0", "`replicas` must be from 1"),
            ("replica = 2", "line 1"),
            (
                "replica = 2",
                "expected one of `title`, `question`, `replicas`",
            ),
            ("[[vary]]\nkey = \"gas.0.mass\"", "vary[0]: give `values`"),
            (
                "[[vary]]\nkey = \"gas.0.mass\"\nvalue = [1]",
                "unknown field `value`",
            ),
            (
                "[[vary]]\nkey = \"run.until\"\nvalues = [1, -1]",
                "point run.until = -1",
            ),
            (
                "[[vary]]\nkey = \"gas.0.mass\"\nvalues = [1, 1.0]",
                "are the same scene",
            ),
            (
                "[[vary]]\nkey = \"gas.0.mass\"\nvalues = [1]\n[[vary]]\nkey = \"gas.0.mass\"\nvalues = [2]",
                "varies twice",
            ),
            ("[stop]\nfigure = \"pressure\"", "needs `standard_error`"),
            ("measure = [\"events\"]", "it writes contacts to a file"),
            (
                "[[expect]]\nfigure = \"pressure\"\nvalues = [1, 2]",
                "expect[0]: 2 `values` for 1 points",
            ),
            ("[[expect]]\nvalue = 1", "expect[0]: `figure` is missing"),
            ("[quick]\nreplica = 1", "unknown field `replica`"),
            (
                "[quick]\nset = { \"gas.0.raduis\" = 1 }",
                "did you mean `radius`?",
            ),
            (
                "[quick]\nset = { \"gas.0.mass\" = 1 }\n[[vary]]\nkey = \"gas.0.mass\"\nvalues = [1]",
                "[quick.set]: `gas.0.mass` varies",
            ),
        ] {
            let error = format!("{:#}", study(head).unwrap_err());
            assert!(error.contains(expected), "{head}: {error}");
        }
        let error = format!(
            "{:#}",
            Study::parse("scene = \"no.toml\"", Path::new("a"), Size::default()).unwrap_err()
        );
        assert!(error.contains("a/no.toml"), "{error}");
        let text = format!("replicas = 2\n{}", SCENE.replace("scene.", ""));
        let error = format!(
            "{:#}",
            Study::parse(&text, Path::new(""), Size::default()).unwrap_err()
        );
        assert!(error.contains("[scene.box]"), "{error}");
    }
}
