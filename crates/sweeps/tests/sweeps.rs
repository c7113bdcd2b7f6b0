//! Sweeps in folders: what is kept, what is run again, shards in any order, and damaged files.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    time::{Duration, SystemTime},
};

use anyhow::Result;
use carom_runs::run::record;
use carom_runs::{folder_lock::FolderLock, interruption::Signals};
use carom_sweeps::{Size, Study, merge, several};
use carom_tables::Verdict;
use clap::{Args, Parser};

const STUDY: &str = r#"
replicas = 3
measure = ["pressure"]
[[vary]]
key = "gas.0.count"
values = [10, 20, 30]
[[scene.gas]]
radius = 0.03
mass = 1.0
temperature = 1.0
velocities = "maxwell"
[scene.box]
seed = 5
[scene.run]
until = 0.8
sample_interval = 0.02
"#;

#[derive(Parser)]
struct Line<T: Args> {
    #[command(flatten)]
    options: T,
}

fn options<T: Args>(words: &str) -> T {
    Line::<T>::parse_from(std::iter::once("carom").chain(words.split_whitespace())).options
}

/// A folder with a study.
struct Place(tempfile::TempDir);

impl Place {
    fn new(study: &str) -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        place.study(study);
        place
    }

    fn study(&self, text: &str) {
        fs::write(self.path("study.toml"), text).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs the sweep into a folder, with further options.
    fn sweep(&self, out: &str, more: &str) -> Result<()> {
        let (study, out) = (self.path("study.toml"), self.path(out));
        let threads = if more.contains("--slurm") {
            ""
        } else {
            "--threads 2"
        };
        let words = format!(
            "{} --out {} {threads} {more}",
            study.display(),
            out.display()
        );
        several::run(&options(&words)).map(drop)
    }

    fn merge(&self, folders: &[String], out: &str) -> Result<()> {
        let folders: Vec<String> = folders
            .iter()
            .map(|name| self.path(name).display().to_string())
            .collect();
        let words = format!("{} --out {}", folders.join(" "), self.path(out).display());
        merge::run(&options(&words)).map(drop)
    }

    /// The verdict of a merge.
    fn merged(&self, folders: &[&str], out: &str) -> Verdict {
        let folders: Vec<String> = folders
            .iter()
            .map(|name| self.path(name).display().to_string())
            .collect();
        let words = format!("{} --out {}", folders.join(" "), self.path(out).display());
        merge::run(&options(&words)).unwrap()
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    fn refused(&self, out: &str, more: &str) -> String {
        format!("{:#}", self.sweep(out, more).unwrap_err())
    }

    /// The finished replicas of a folder with the times of their files.
    fn records(&self, out: &str) -> BTreeMap<PathBuf, SystemTime> {
        let points = fs::read_dir(self.path(out).join("points"))
            .unwrap()
            .map(|entry| entry.unwrap().path());
        let folders = points.filter(|point| point.is_dir());
        let files = folders.flat_map(|point| {
            fs::read_dir(point)
                .unwrap()
                .map(|entry| entry.unwrap().path())
        });
        let records =
            files.filter(|path| path.extension().is_some_and(|ending| ending == "record"));
        records
            .map(|path| {
                (
                    path.clone(),
                    fs::metadata(path).unwrap().modified().unwrap(),
                )
            })
            .collect()
    }
}

/// All files of a folder that do not hold times, with their content.
fn tables(folder: &Path) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut left = vec![folder.to_owned()];
    while let Some(inner) = left.pop() {
        for path in fs::read_dir(inner)
            .unwrap()
            .map(|entry| entry.unwrap().path())
        {
            if path.is_dir() {
                left.push(path);
            } else if path
                .extension()
                .is_some_and(|ending| ending == "csv" || ending == "toml")
            {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                found.insert(name, fs::read_to_string(&path).unwrap());
            }
        }
    }
    found
}

/// Two studies of which one expects what is wrong, and one whose runs end with an error.
#[test]
fn several_studies_have_a_folder_each_and_one_page_with_their_verdicts() {
    let place = Place::new(STUDY);
    let expecting = |bound: f64| {
        let expect =
            format!("[[expect]]\nfigure = \"pressure\"\nvalue = 0.0\nabsolute = {bound}\n");
        STUDY
            .replace("[[scene.gas]]", &format!("{expect}[[scene.gas]]"))
            .replace("replicas = 3", "replicas = 1")
    };
    fs::create_dir(place.path("studies")).unwrap();
    let write = |name: &str, text: &str| fs::write(place.path("studies").join(name), text).unwrap();
    write("good.toml", &expecting(1e6));
    write("bad.toml", &expecting(1e-6));
    write("notes.txt", "not a study");
    let run = |more: &str| {
        let words = format!(
            "{} --out {} {more}",
            place.path("studies").display(),
            place.path("all").display()
        );
        several::run(&options(&words))
    };
    assert_eq!(run("").unwrap(), Verdict::Failed);
    let page = place.read("all/report.html");
    assert!(
        page.contains("1 of 2 studies did not pass.") && page.contains("bad: "),
        "{page}"
    );
    let summary: serde_json::Value = serde_json::from_str(&place.read("all/summary.json")).unwrap();
    let verdicts: Vec<_> = summary["studies"]
        .as_array()
        .unwrap()
        .iter()
        .map(|s| (s["study"].as_str(), s["verdict"].as_str()))
        .collect();
    assert_eq!(
        verdicts,
        [
            (Some("bad"), Some("failed")),
            (Some("good"), Some("passed"))
        ]
    );
    // Each is the sweep of its own, and is continued.
    let records = place.records("all/good");
    assert_eq!(records.len(), 3);
    assert_eq!(run("").unwrap(), Verdict::Failed);
    assert_eq!(place.records("all/good"), records, "nothing is run again");

    // One that cannot continue does not keep the others from running.
    write(
        "ends.toml",
        &STUDY.replace("[10, 20, 30]", "[10, 20, 10000]"),
    );
    let error = format!("{:#}", run("").unwrap_err());
    assert!(error.contains("ends"), "{error}");
    assert!(
        place
            .read("all/report.html")
            .contains("2 of 3 studies did not pass.")
    );

    write("invalid.toml", "replicas = 0\n");
    assert!(format!("{:#}", run("").unwrap_err()).contains("invalid.toml"));
    fs::remove_file(place.path("studies/invalid.toml")).unwrap();
    fs::create_dir(place.path("empty")).unwrap();
    let words = |study: &str| {
        format!(
            "{} {} --out {}",
            place.path("studies/good.toml").display(),
            study,
            place.path("all").display()
        )
    };
    let refused = |study: &str, more: &str| {
        format!(
            "{:#}",
            several::run(&options(&format!("{} {more}", words(study)))).unwrap_err()
        )
    };
    assert!(refused(&place.path("empty").display().to_string(), "").contains("holds no study"));
    let same = place.path("studies/good.toml").display().to_string();
    assert!(refused(&same, "").contains("two studies are called good"));
    let other = place.path("study.toml").display().to_string();
    assert!(refused(&other, "--force").contains("also holds the study"));
}

#[test]
fn shards_merged_in_any_order_and_tree_give_the_tables_of_one_process_to_the_digit() {
    let place = Place::new(STUDY);
    place.sweep("whole", "").unwrap();
    let expected = tables(&place.path("whole"));
    assert!(
        expected["table.csv"].lines().count() == 4
            && expected["table.csv"].contains("pressure_error")
    );
    assert_eq!(
        expected
            .keys()
            .filter(|name| name.ends_with("pressure.csv"))
            .count(),
        3
    );
    let shards: Vec<String> = (1..=4).map(|index| format!("shard-{index}")).collect();
    for (index, shard) in shards.iter().enumerate() {
        place
            .sweep(shard, &format!("--shard {}/4", index + 1))
            .unwrap();
    }
    assert_eq!(
        shards
            .iter()
            .map(|shard| place.records(shard).len())
            .sum::<usize>(),
        9
    );
    let order = |order: [usize; 4]| order.map(|index| shards[index].clone());
    place.merge(&order([0, 1, 2, 3]), "a").unwrap();
    place.merge(&order([3, 1, 0, 2]), "b").unwrap();
    place.merge(&shards[..2], "left").unwrap();
    place.merge(&shards[1..], "right").unwrap();
    place
        .merge(&["right".to_owned(), "left".to_owned()], "c")
        .unwrap();
    for merged in ["a", "b", "c"] {
        assert_eq!(tables(&place.path(merged)), expected, "{merged}");
    }
    // Shard 2 is in both halves.
    assert!(
        place
            .read("c/report.html")
            .contains("replicas are in several folders, with the same content")
    );
    assert!(
        place
            .read("a/report.html")
            .contains("All 3 points are complete, with 9 replicas")
    );

    // A folder in which another process writes gives what is finished, with a note.
    let writing = FolderLock::exclusive(&place.path("shard-2")).unwrap();
    place.merge(&shards, "meanwhile").unwrap();
    drop(writing);
    assert_eq!(
        tables(&place.path("meanwhile"))["table.csv"],
        expected["table.csv"]
    );
    let page = place.read("meanwhile/report.html");
    assert!(
        page.contains("shard-2") && page.contains("only its finished replicas are merged"),
        "{page}"
    );

    // What is missing is named, and can be done later.
    let half = place.read("left/report.html");
    assert!(
        half.contains("Incomplete: ") && half.contains("Of 4 shards these are not there: 3, 4."),
        "{half}"
    );
    place.sweep("left", "").unwrap();
    assert_eq!(
        tables(&place.path("left"))["table.csv"],
        expected["table.csv"]
    );
}

#[test]
fn replicas_are_those_of_a_run_with_the_same_seed() {
    let place = Place::new(STUDY);
    place.sweep("out", "").unwrap();
    let study = Study::read(&place.path("study.toml"), Size::default()).unwrap();
    let point = &study.points[1];
    let scene = point.replica(2);
    let alone = record(&scene, &Signals::default()).unwrap();
    let runs = place.read(&format!("out/points/{}/runs.csv", point.key));
    let run = alone.runs.values().next().unwrap();
    let row = format!("{},2,{},0.8", scene.bounds.seed, run.totals.collisions);
    assert!(runs.lines().any(|line| line == row), "{row}: {runs}");
}

#[test]
fn new_values_and_replicas_keep_what_is_done_and_nothing_is_done_twice() {
    let place = Place::new(STUDY);
    place.sweep("out", "").unwrap();
    let first = place.records("out");
    assert_eq!(first.len(), 9);
    place.sweep("out", "").unwrap();
    assert_eq!(place.records("out"), first);
    let kept = |now: &BTreeMap<PathBuf, SystemTime>| {
        first
            .iter()
            .filter(|one| now.get(one.0) == Some(one.1))
            .count()
    };

    // A comment, another order, and a new value.
    place.study(&STUDY.replace("[10, 20, 30]", "[30, 20, 40, 10] # more"));
    place.sweep("out", "").unwrap();
    let more = place.records("out");
    assert_eq!((more.len(), kept(&more)), (12, 9));
    assert_eq!(place.read("out/table.csv").lines().count(), 5);

    place.study(STUDY);
    place.sweep("out", "--replicas 5").unwrap();
    let five = place.records("out");
    assert_eq!((five.len(), kept(&five)), (12 + 6, 9));
    assert!(
        place
            .read("out/table.csv")
            .lines()
            .nth(1)
            .unwrap()
            .starts_with("10,5,")
    );

    // An edited value drops its own point alone.
    place.study(&STUDY.replace("[10, 20, 30]", "[10, 21, 30]"));
    place.sweep("out", "").unwrap();
    assert_eq!(
        (place.records("out").len(), kept(&place.records("out"))),
        (18 + 3, 9)
    );
    assert!(!place.read("out/table.csv").contains("\n20,"));

    // Another scene is another study.
    place.study(&STUDY.replace("radius = 0.03", "radius = 0.02"));
    let error = place.refused("out", "");
    assert!(
        error.contains("another study") && error.contains("0.02") && error.contains("--force"),
        "{error}"
    );
    place.sweep("out", "--force").unwrap();
    assert_eq!(
        (place.records("out").len(), kept(&place.records("out"))),
        (9, 0)
    );
    fs::write(place.path("out/study.toml"), "").unwrap();
    assert!(place.refused("out", "").contains("out/study.toml"));
    fs::create_dir(place.path("other")).unwrap();
    fs::write(place.path("other/notes.txt"), "mine").unwrap();
    assert!(place.refused("other", "").contains("is not empty"));
}

#[test]
fn a_damaged_file_is_recognised_at_every_length_and_its_replica_run_again() {
    let place = Place::new(
        &STUDY
            .replace("[10, 20, 30]", "[10]")
            .replace("until = 0.8", "until = 0.2"),
    );
    place.sweep("out", "").unwrap();
    let table = place.read("out/table.csv");
    let path = place.records("out").into_keys().next().unwrap();
    let whole = fs::read(&path).unwrap();
    let half = whole.len() / 2;
    // Nothing, parts of the header, the header alone, parts of the body, and too much.
    let mut broken: Vec<Vec<u8>> = [0, 1, 15, 16, 27, 31, 32, 33, half, whole.len() - 1]
        .iter()
        .map(|&n| whole[..n].to_vec())
        .collect();
    broken.push([&whole[..], b"more"].concat());
    let mut flipped = whole.clone();
    flipped[half] ^= 1;
    broken.push(flipped);
    for content in broken {
        fs::write(&path, &content).unwrap();
        place.sweep("out", "").unwrap();
        assert_eq!(
            place.read("out/table.csv"),
            table,
            "{} bytes",
            content.len()
        );
        // All but the time that it took.
        assert_eq!(fs::read(&path).unwrap().len(), whole.len());
    }
    // The file of another replica is not taken for this one.
    let other = place.records("out").into_keys().nth(1).unwrap();
    fs::copy(&other, &path).unwrap();
    place.sweep("out", "").unwrap();
    assert_eq!(place.read("out/table.csv"), table);

    // A merge leaves a damaged file out and says so; an intact copy elsewhere counts.
    place.merge(&["out".to_owned()], "copy").unwrap();
    fs::write(&path, &whole[..half]).unwrap();
    place.merge(&["out".to_owned()], "lacking").unwrap();
    let page = place.read("lacking/report.html");
    assert!(
        page.contains("it is truncated") && page.contains("Missing are 1 of 3 replicas"),
        "{page}"
    );
    place
        .merge(&["out".to_owned(), "copy".to_owned()], "both")
        .unwrap();
    assert_eq!(place.read("both/table.csv"), table);
}

/// A loss of power leaves files that were not flushed empty, or without their name.
#[test]
fn results_of_a_point_that_a_loss_of_power_has_spoilt_are_written_again() {
    let place = Place::new(&STUDY.replace("[10, 20, 30]", "[10]"));
    place.sweep("out", "").unwrap();
    place.merge(&["out".to_owned()], "merged").unwrap();
    for out in ["out", "merged"] {
        let record = place.records(out).into_keys().next().unwrap();
        let point = record.parent().unwrap();
        let names = [
            "report.html",
            "pressure.csv",
            "summary.json",
            "runs.csv",
            "tables.json",
            "config.toml",
        ];
        for name in names {
            let whole = fs::read(point.join(name)).unwrap();
            let mut changed = whole.clone();
            changed[whole.len() / 2] ^= 1;
            for content in [Some(Vec::new()), Some(changed), None] {
                match &content {
                    Some(bytes) => fs::write(point.join(name), bytes).unwrap(),
                    None => fs::remove_file(point.join(name)).unwrap(),
                }
                place.sweep(out, "").unwrap();
                let now = fs::read(point.join(name)).unwrap();
                // Times differ.
                assert!(
                    name == "summary.json" || name == "report.html" || now == whole,
                    "{out} {name}"
                );
                assert!(
                    now.len().abs_diff(whole.len()) < 100,
                    "{out} {name}: {} bytes",
                    now.len()
                );
            }
        }
        // The process has ended between the page and the manifest.
        let manifest = fs::read_to_string(point.join("manifest.json")).unwrap();
        let open = manifest.replace("\"complete\": true", "\"complete\": false");
        assert_ne!(open, manifest);
        fs::write(point.join("manifest.json"), open).unwrap();
        place.sweep(out, "").unwrap();
        assert!(
            fs::read_to_string(point.join("manifest.json"))
                .unwrap()
                .contains("\"complete\": true")
        );
        // What is intact stays as it is.
        let time = |name: &str| fs::metadata(point.join(name)).unwrap().modified().unwrap();
        let before = time("report.html");
        place.sweep(out, "").unwrap();
        assert_eq!(time("report.html"), before);
    }
}

#[test]
fn records_of_other_formats_are_named_with_the_remedy_and_stop_no_merge() {
    let place = Place::new(STUDY);
    place.sweep("out", "").unwrap();
    let table = place.read("out/table.csv");
    let path = place.records("out").into_keys().next().unwrap();
    let whole = fs::read(&path).unwrap();
    let with_format = |change: i8| {
        let mut bytes = whole.clone();
        bytes[16] = bytes[16].checked_add_signed(change).unwrap();
        fs::write(&path, bytes).unwrap();
    };
    for (change, words) in [(-1, "an older program"), (1, "a newer program")] {
        with_format(change);
        let out = format!("merged{change}");
        assert_eq!(place.merged(&["out"], &out), Verdict::Incomplete);
        let page = place.read(&format!("{out}/report.html"));
        assert!(
            page.contains(words) && page.contains("To run it again: carom sweep"),
            "{page}"
        );
        assert!(page.contains("Missing are 1 of 9 replicas"), "{page}");
        let summary: serde_json::Value =
            serde_json::from_str(&place.read(&format!("{out}/summary.json"))).unwrap();
        assert_eq!(summary["damaged"][0]["file"], path.display().to_string());
        assert_eq!(
            summary["missing"][0]["replicas"].as_array().unwrap().len(),
            1
        );
    }
    // The record of a newer program is not replaced by an older one.
    assert!(
        place
            .refused("out", "")
            .contains("Continue the sweep with the newer program")
    );
    with_format(-1);
    place.sweep("out", "").unwrap();
    assert_eq!(place.read("out/table.csv"), table);
}

#[test]
fn forged_numbers_in_a_record_are_counted_as_damaged() {
    let place = Place::new(STUDY);
    place.sweep("out", "").unwrap();
    let table = place.read("out/table.csv");
    let path = place.records("out").into_keys().next().unwrap();
    let mut stored = read(&place, &path);
    let run = stored.record.runs.values_mut().next().unwrap();
    let measure = run
        .measures
        .iter_mut()
        .find(|measure| !measure.sums.total.is_empty())
        .unwrap();
    measure.sums.total[0][0] = f64::NAN;
    stored.write(&path).unwrap();
    assert_eq!(place.merged(&["out"], "merged"), Verdict::Incomplete);
    let page = place.read("merged/report.html");
    assert!(
        page.contains("sums.total[0][0] must be finite, but is NaN"),
        "{page}"
    );
    assert!(!place.read("merged/table.csv").contains("NaN"));
    place.sweep("out", "").unwrap();
    assert_eq!(place.read("out/table.csv"), table);
}

#[test]
fn job_scripts_are_not_written_into_folders_that_they_cannot_name() {
    let place = Place::new(STUDY);
    for name in ["a\"b", "a\\b"] {
        let error = place.refused(name, "--slurm --array-size 2");
        assert!(
            error.contains("which a Slurm script cannot quote"),
            "{error}"
        );
        assert!(!place.path(name).exists(), "{name}");
    }
    place.sweep("@options@", "--slurm --array-size 2").unwrap();
    assert!(
        place
            .read("@options@/array.sh")
            .contains("/@options@/logs/shard-%a.log")
    );
}

/// No clock of the day has an effect: durations are those of a clock that never jumps, and times of
/// files are never read.
#[test]
fn a_clock_that_jumps_repeats_and_changes_nothing() {
    let place = Place::new(STUDY);
    place.sweep("whole", "").unwrap();
    let expected = tables(&place.path("whole"));
    place.sweep("a", "--shard 1/2").unwrap();
    place.sweep("b", "--shard 2/2").unwrap();
    let times = [
        SystemTime::UNIX_EPOCH,
        SystemTime::now() + Duration::from_secs(1 << 32),
    ];
    for (out, time) in ["a", "b"].into_iter().zip(times) {
        for path in place.records(out).into_keys() {
            fs::File::options()
                .append(true)
                .open(path)
                .unwrap()
                .set_modified(time)
                .unwrap();
        }
        place
            .sweep(
                out,
                &format!("--shard {}/2", if out == "a" { 1 } else { 2 }),
            )
            .unwrap();
        assert!(
            place.records(out).into_values().all(|now| now == time),
            "{out} was run again"
        );
    }
    place
        .merge(&["b".to_owned(), "a".to_owned()], "all")
        .unwrap();
    assert_eq!(tables(&place.path("all")), expected);
}

#[test]
fn folders_that_do_not_fit_are_not_merged() {
    let place = Place::new(STUDY);
    place.sweep("a", "--shard 1/2").unwrap();
    place.study(&STUDY.replace("[10, 20, 30]", "[10, 20]"));
    place.sweep("b", "--shard 2/2").unwrap();
    let refused = |folders: &[&str], out: &str| {
        let folders: Vec<String> = folders.iter().map(|&name| name.to_owned()).collect();
        format!("{:#}", place.merge(&folders, out).unwrap_err())
    };
    let error = refused(&["a", "b"], "all");
    assert!(
        error.contains("another study") && error.contains("[10, 20]") && error.contains("/b"),
        "{error}"
    );
    assert!(refused(&["a"], "a").contains("is one of the folders"));
    fs::create_dir(place.path("run")).unwrap();
    assert!(refused(&["a", "run"], "all").contains("run holds no sweep"));
    assert!(!place.path("all").exists());

    // The same replica with another content: two files that swapped their names.
    place.study(STUDY);
    place.sweep("c", "--shard 1/2").unwrap();
    let [one, other] =
        [place.records("a"), place.records("c")].map(|all| all.into_keys().next().unwrap());
    let mut stored = carom_sweeps::stored::Stored::clone(&read(&place, &one));
    stored
        .record
        .runs
        .values_mut()
        .for_each(|run| run.totals.collisions += 1);
    stored.write(&other).unwrap();
    let error = refused(&["a", "c"], "all");
    assert!(
        error.contains("have different results") && error.contains(".record"),
        "{error}"
    );

    // Other processor times are no difference.
    let mut stored = read(&place, &one);
    stored.seconds *= 7.0;
    stored.write(&other).unwrap();
    place
        .merge(&["c".to_owned(), "a".to_owned()], "again")
        .unwrap();
}

/// The content of the file of a replica.
fn read(place: &Place, path: &Path) -> carom_sweeps::stored::Stored {
    use carom_sweeps::{
        shard::Work,
        stored::{self, Found},
    };
    let study = Study::read(&place.path("study.toml"), Size::default()).unwrap();
    let folder = path
        .parent()
        .unwrap()
        .file_name()
        .unwrap()
        .to_string_lossy()
        .into_owned();
    let point = study
        .points
        .iter()
        .find(|point| point.key.to_string() == folder)
        .unwrap();
    let name = path.file_stem().unwrap().to_string_lossy().into_owned();
    let replica = name.trim_start_matches("replica-").parse().unwrap();
    let work = Work {
        key: point.key,
        replica,
    };
    match stored::read(path, work, &carom_runs::record::description(&point.scene)).unwrap() {
        Found::Finished(stored) => *stored,
        other => panic!("{other:?}"),
    }
}

#[test]
fn replicas_end_at_the_wanted_error_and_the_record_says_where() {
    let study = "replicas = 4\nmeasure = [\"pressure\"]\n[stop]\nfigure = \"pressure\"\nrelative_error = 0.02\n\
                 [[scene.gas]]\nradius = 0.03\nmass = 1.0\ntemperature = 1.0\nvelocities = \"maxwell\"\ncount = 60\n\
                 [scene.run]\nuntil = 400.0\nsample_interval = 0.05\nmeasure_from = 0.5\n";
    let place = Place::new(study);
    place.sweep("out", "").unwrap();
    let point = Study::read(&place.path("study.toml"), Size::default())
        .unwrap()
        .points[0]
        .key;
    let runs = place.read(&format!("out/points/{point}/runs.csv"));
    let ends: Vec<f64> = runs
        .lines()
        .skip(1)
        .map(|row| row.rsplit(',').next().unwrap().parse().unwrap())
        .collect();
    // 32 blocks of one sample at least; long before the end.
    assert!(
        ends.iter().all(|end| (2.0..100.0).contains(end)),
        "{ends:?}"
    );
    let table = place.read("out/table.csv");
    let column = |name: &str| {
        table
            .lines()
            .next()
            .unwrap()
            .split(',')
            .position(|column| column == name)
            .unwrap()
    };
    let row: Vec<&str> = table.lines().nth(1).unwrap().split(',').collect();
    let number = |name: &str| row[column(name)].parse::<f64>().unwrap();
    let error = number("pressure_error") / number("pressure");
    // The errors of the replicas scatter, and their mean is weighted by time.
    assert!(error < 1.5 * 0.02, "{error}");
    let misspelt = study.replace("figure = \"pressure\"", "figure = \"presure\"");
    place.study(&misspelt);
    let refused = place.refused("other", "");
    assert!(
        refused.contains("no figure 'presure'") && refused.contains("did you mean `pressure`?"),
        "{refused}"
    );
}

#[test]
fn replicas_end_at_the_first_sample_with_the_wanted_collisions() {
    let place = Place::new(
        &STUDY
            .replace("until = 0.8", "until = 50.0")
            .replace("[[vary]]", "stop.collisions = 300\n[[vary]]"),
    );
    place.sweep("out", "").unwrap();
    for point in Study::read(&place.path("study.toml"), Size::default())
        .unwrap()
        .points
    {
        let runs = place.read(&format!("out/points/{}/runs.csv", point.key));
        for row in runs.lines().skip(1) {
            let cells: Vec<&str> = row.split(',').collect();
            let (collisions, end): (f64, f64) =
                (cells[2].parse().unwrap(), cells[3].parse().unwrap());
            assert!(
                end < 50.0 && (end / 0.02 - (end / 0.02).round()).abs() < 1e-9,
                "{row}"
            );
            let of_interval = collisions / end * 0.02;
            assert!(
                (300.0..300.0 + 5.0 * of_interval + 20.0).contains(&collisions),
                "{row}"
            );
        }
    }
}

#[test]
fn a_folder_that_cannot_be_written_ends_the_sweep_and_keeps_what_is_done() {
    use std::os::unix::fs::PermissionsExt as _;
    let place = Place::new(STUDY);
    place.sweep("out", "--shard 1/2").unwrap();
    let done = place.records("out");
    let points = place.path("out/points");
    let set = |mode| fs::set_permissions(&points, fs::Permissions::from_mode(mode)).unwrap();
    set(0o555);
    let is_root = fs::create_dir(points.join("probe")).is_ok();
    if is_root {
        // Root writes anywhere: a file in the place of a folder has the same effect.
        fs::remove_dir(points.join("probe")).unwrap();
        set(0o755);
        let study = Study::read(&place.path("study.toml"), Size::default()).unwrap();
        let missing = study
            .points
            .iter()
            .map(|point| points.join(point.key.to_string()));
        for path in missing.filter(|path| !path.exists()) {
            fs::write(path, "").unwrap();
        }
        let lacking = points
            .read_dir()
            .unwrap()
            .any(|entry| entry.unwrap().path().is_file());
        if !lacking {
            return;
        }
    }
    let error = place.refused("out", "");
    assert!(error.contains("cannot"), "{error}");
    let kept = place.records("out");
    assert!(done.iter().all(|(path, time)| kept.get(path) == Some(time)));
    set(0o755);
    for path in points
        .read_dir()
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.is_file())
    {
        fs::remove_file(path).unwrap();
    }
    place.sweep("out", "").unwrap();
    place.sweep("whole", "").unwrap();
    assert_eq!(place.read("out/table.csv"), place.read("whole/table.csv"));
}

/// The error that ends a run is that of its mean: runs that end by chance too early would scatter
/// more.
#[test]
fn runs_that_end_at_a_wanted_error_scatter_as_wanted() {
    let study = "replicas = 48\nmeasure = [\"pressure\"]\n[[scene.gas]]\nradius = 0.03\nmass = 1.0\ntemperature = 1.0\n\
                 velocities = \"maxwell\"\ncount = 40\n[scene.run]\nuntil = 1000.0\nsample_interval = 0.05\n\
                 measure_from = 0.5\n[scene.run.stop]\nfigure = \"pressure\"\nrelative_error = 0.01\n";
    let study = Study::parse(study, Path::new(""), Size::default()).unwrap();
    let point = &study.points[0];
    let pressures: Vec<f64> = (1..=study.replicas)
        .map(|number| {
            let record = record(&point.replica(number), &Signals::default()).unwrap();
            let run = record.runs.into_values().next().unwrap();
            let figures = run.measures.into_iter().flat_map(|measure| measure.figures);
            let (figure, ..) = figures
                .into_iter()
                .find(|(figure, ..)| figure.name == "pressure")
                .unwrap();
            // At the sample that ends the run.
            assert!(figure.standard_error.unwrap() <= 0.01 * figure.value);
            figure.value
        })
        .collect();
    let count = pressures.len() as f64;
    let mean = pressures.iter().sum::<f64>() / count;
    let variance = pressures.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let scatter = variance.sqrt() / mean;
    // 48 replicas give their scatter to 10 %. Runs that end where the error is small by chance make
    // it somewhat larger than requested.
    assert!((0.006..0.014).contains(&scatter), "{scatter}");
}

/// Entries for `STUDY`: the first holds for equal discs, the second is wrong on purpose at a point.
const EXPECT: &str = "
[[expect]]
figure = \"pressure\"
relative = 0.5
[[expect]]
figure = \"compressibility factor βpA/N\"
values = [1.0, 9.0]
standard_errors = 0
absolute = 3.0
source = \"a guess\"
only = { \"gas.0.count\" = [10, 30] }
";

/// The answers of all points, as in `summary.json`, and the checks of the terminal.
fn answers(place: &Place, out: &str) -> (Vec<serde_json::Value>, serde_json::Value) {
    let summary: serde_json::Value =
        serde_json::from_str(&place.read(&format!("{out}/summary.json"))).unwrap();
    let of_point =
        |point: &serde_json::Value| point["answers"].as_array().cloned().unwrap_or_default();
    (
        summary["points"]
            .as_array()
            .unwrap()
            .iter()
            .flat_map(of_point)
            .collect(),
        summary["checks"].clone(),
    )
}

#[test]
fn expectations_are_answered_alike_by_one_process_and_by_merged_shards() {
    let place = Place::new(&format!("{STUDY}{EXPECT}"));
    let sweep = |out: &str, more: &str| {
        let (study, out) = (place.path("study.toml"), place.path(out));
        several::run(&options(&format!(
            "{} --out {} {more}",
            study.display(),
            out.display()
        )))
        .unwrap()
    };
    assert_eq!(sweep("whole", ""), Verdict::Failed);
    let whole = answers(&place, "whole");
    let passed: Vec<bool> = whole
        .0
        .iter()
        .map(|answer| answer["passed"].as_bool().unwrap())
        .collect();
    // Of each point in turn: the prediction, then the guess.
    assert_eq!(passed, [true, true, true, true, false], "{whole:?}");
    assert!(whole.0[0]["source"].as_str().unwrap().contains("Liu"));
    assert_eq!(
        (&whole.0[4]["expected"], &whole.0[4]["source"]),
        (&"9".into(), &"a guess".into())
    );
    assert!(
        whole
            .1
            .as_array()
            .unwrap()
            .iter()
            .any(|check| check["passed"] == false)
    );
    let page = place.read("whole/report.html");
    assert!(
        page.contains("NOT AS EXPECTED")
            && page.contains("a guess")
            && !page.contains("not tested")
    );

    // Shards alone have no verdict; merged ones have that of one process.
    for index in 1..=3 {
        assert_eq!(
            sweep(&format!("shard-{index}"), &format!("--shard {index}/3")),
            Verdict::Passed
        );
    }
    let merge = |shards: &[u32], out: &str| {
        let folders: Vec<String> = shards
            .iter()
            .map(|index| place.path(&format!("shard-{index}")).display().to_string())
            .collect();
        let words = format!("{} --out {}", folders.join(" "), place.path(out).display());
        merge::run(&options(&words)).unwrap()
    };
    assert_eq!(merge(&[3, 1, 2], "all"), Verdict::Failed);
    assert_eq!(answers(&place, "all"), whole);

    // What has no replica is named as untested. 9 replicas in 9 shards: the first has one point.
    sweep("lone", "--shard 1/9");
    place.merge(&["lone".to_owned()], "part").unwrap();
    let left = 5 - answers(&place, "part").0.len();
    assert!((3..=4).contains(&left));
    assert!(
        place
            .read("part/report.html")
            .contains(&format!("{left} more are not tested"))
    );

    // A corrected expectation is judged from the finished replicas.
    let first = place.records("whole");
    place.study(&format!("{STUDY}{EXPECT}").replace("[1.0, 9.0]", "[1.0, 1.5]"));
    assert_eq!(sweep("whole", ""), Verdict::Passed);
    assert_eq!(place.records("whole"), first);
}

#[test]
fn the_short_form_is_a_study_of_its_own_in_shards_and_jobs_too() {
    let quick =
        "\n[quick]\nreplicas = 2\nstop = { collisions = 50 }\nset = { \"run.until\" = 0.4 }\n";
    let place = Place::new(&format!("{STUDY}{EXPECT}{quick}").replace("9.0", "1.5"));
    let is_quick = Size {
        is_quick: true,
        ..Size::default()
    };
    let study = |name: &str, size| Study::read(&place.path(name), size).unwrap();
    let (short, full) = (
        study("study.toml", is_quick),
        study("study.toml", Size::default()),
    );
    assert_eq!((short.replicas, full.replicas), (2, 3));
    assert_eq!(
        (
            short.points[0].scene.run.until,
            full.points[0].scene.run.until
        ),
        (0.4, 0.8)
    );
    assert!(short.points[0].scene.run.stop.is_some() && full.points[0].scene.run.stop.is_none());
    let more = Size {
        replicas: Some(4),
        is_quick: true,
    };
    assert_eq!(study("study.toml", more).replicas, 4);

    place.sweep("whole", "--quick").unwrap();
    assert_eq!(place.records("whole").len(), 6);
    assert!(place.refused("whole", "").contains("another study"));
    for index in 1..=2 {
        place
            .sweep(
                &format!("shard-{index}"),
                &format!("--quick --shard {index}/2"),
            )
            .unwrap();
    }
    place
        .merge(&["shard-2".to_owned(), "shard-1".to_owned()], "all")
        .unwrap();
    assert_eq!(tables(&place.path("all")), tables(&place.path("whole")));
    assert_eq!(answers(&place, "all"), answers(&place, "whole"));
    // A shard of the whole study is of another study.
    place.sweep("shard-3", "--shard 2/2").unwrap();
    let mixed = ["shard-1", "shard-3"].map(str::to_owned);
    assert!(format!("{:#}", place.merge(&mixed, "mixed").unwrap_err()).contains("another study"));

    // The jobs run the short form from a file that has no other.
    let words = format!(
        "{} --quick --slurm --array-size 2 --out {}",
        place.path("study.toml").display(),
        place.path("jobs").display()
    );
    several::run(&options(&words)).unwrap();
    assert_eq!(study("jobs/input.toml", Size::default()), short);
    let again = Study::parse(&short.text(), Path::new(""), is_quick).unwrap_err();
    assert!(format!("{again:#}").contains("no table [quick]"));
}

#[test]
fn the_study_of_the_book_is_valid() {
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("../book/src");
    let listing = |chapter: &str| {
        let page = fs::read_to_string(book.join(chapter)).unwrap();
        let rest = page.split("```toml\n").nth(1).unwrap();
        rest.split("```").next().unwrap().to_owned()
    };
    let (text, scene) = (listing("sweeps.md"), listing("scenes.md"));
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("gas.toml"), scene).unwrap();
    let study = Study::parse(&text, folder.path(), Size::default()).unwrap();
    assert_eq!((study.points.len(), study.replicas), (6, 8));
    let quick = Study::parse(
        &text,
        folder.path(),
        Size {
            is_quick: true,
            ..Size::default()
        },
    )
    .unwrap();
    assert_eq!((quick.points.len(), quick.replicas), (6, 2));
    // The points of the first and the second density.
    assert_eq!(study.expected_answers(), 4);
}

#[test]
fn the_studies_of_the_repository_are_valid() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let files = |folder: &str| {
        fs::read_dir(root.join(folder))
            .unwrap()
            .map(|entry| entry.unwrap().path())
    };
    let theory = "crates/runs/examples/theory";
    let folders = ["xtask/studies", "crates/runs/examples/studies", theory];
    let of_theory = files(theory).filter(|path| path.is_dir());
    let all: Vec<PathBuf> = folders
        .into_iter()
        .flat_map(files)
        .chain(
            of_theory
                .flat_map(|folder| fs::read_dir(folder).unwrap().map(|one| one.unwrap().path())),
        )
        .collect();
    let mut points = 0;
    for path in all
        .into_iter()
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
    {
        let text = fs::read_to_string(&path).unwrap();
        let study = Study::read(&path, Size::default()).unwrap();
        points += study.points.len();
        if text.contains("\n[quick]") {
            let quick = Study::read(
                &path,
                Size {
                    is_quick: true,
                    ..Size::default()
                },
            )
            .unwrap();
            assert_eq!(quick.points.len(), study.points.len());
        }
        for point in &study.points {
            assert!(
                carom_sweeps::cost::of_replica(point).unwrap() > 0,
                "{}",
                point.label
            );
        }
    }
    // Equation of state, shapes, Brownian runs and billiard, and those of kinetic theory.
    assert!(points > 7 + 9 + 8 + 1, "{points}");
}
