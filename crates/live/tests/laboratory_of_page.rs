//! The laboratory without a server: messages, faults of scenes, and a downloaded run that `carom
//! run` continues.

use std::{
    fs,
    path::Path,
    time::{Duration, Instant},
};

use base64::{Engine as _, engine::general_purpose::STANDARD};
use carom_live::{LaboratoryOfPage, Outgoing};
use carom_runs::{
    resumable::{CHECKPOINT, last_state},
    run,
};
use clap::Parser;
use serde_json::{Value, json};

/// Longest wait for a message.
const PATIENCE: Duration = Duration::from_mins(1);

#[derive(Debug, Parser)]
struct Run {
    #[command(flatten)]
    options: run::RunOptions,
}

/// Advances until a text fits, and returns it.
fn wait_for(laboratory: &mut LaboratoryOfPage, fits: impl Fn(&Value) -> bool) -> Value {
    let begun = Instant::now();
    loop {
        while let Some(message) = laboratory.next() {
            let Outgoing::Text(text) = message else {
                continue;
            };
            let message = serde_json::from_str(&text).unwrap();
            if fits(&message) {
                return message;
            }
        }
        assert!(begun.elapsed() < PATIENCE, "the message does not come");
        laboratory.advance();
    }
}

/// The answer to a command.
fn answer(laboratory: &mut LaboratoryOfPage, id: u64, command: &Value) -> Value {
    laboratory.receive(&json!({ "id": id, "do": command }).to_string());
    wait_for(laboratory, |message| message["answer"] == id)
}

/// Writes the files of an archive without compression into a folder.
fn unpack(bytes: &[u8], folder: &Path) {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let half = |at: usize| usize::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]));
    let mut at = 0;
    while word(at) == 0x0403_4b50 {
        let (size, name) = (word(at + 18), half(at + 26));
        let begin = at + 30 + name;
        let path = folder.join(std::str::from_utf8(&bytes[at + 30..begin]).unwrap());
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, &bytes[begin..begin + size]).unwrap();
        at = begin + size;
    }
}

#[test]
fn a_downloaded_run_continues_in_a_folder() {
    let mut laboratory = LaboratoryOfPage::new().unwrap();
    let hello = wait_for(&mut laboratory, |message| !message["hello"].is_null());
    assert_eq!(hello["writer"], true);
    assert!(hello["gallery"].as_array().unwrap().len() > 8);
    let text = "[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 50\n\
                [run]\nuntil = 0.5\nsample_interval = 0.1\nobserve = [\"energy\"]\n";
    let open = json!({ "scene": { "name": "gas", "text": text } });
    assert!(answer(&mut laboratory, 1, &open)["refused"].is_null());
    let source = answer(&mut laboratory, 2, &json!({ "source": true }));
    assert_eq!(source["done"], json!({ "name": "gas", "text": text }));
    wait_for(&mut laboratory, |message| {
        message["status"]["time"].as_f64() > Some(0.1)
    });
    let edit = json!({ "edit": [{ "elasticity": 0.9 }] });
    assert!(answer(&mut laboratory, 3, &edit)["refused"].is_null());
    let spec = json!({ "kind": "temperature", "of": "gas" });
    let measure = json!({ "measure": { "spec": spec, "interval": 0.02 } });
    let begun = answer(&mut laboratory, 5, &measure)["done"]["begun"].clone();
    assert!(begun.as_f64() > Some(0.1), "{begun}");
    let saved = answer(&mut laboratory, 4, &json!({ "save": true }));
    assert_eq!(saved["done"]["measured"], "run/measured-before");
    assert!(saved["done"]["shown"].as_f64() <= saved["done"]["time"].as_f64());
    assert_eq!(saved["done"]["measures_from"], saved["done"]["time"]);
    let archive = STANDARD
        .decode(saved["done"]["archive"].as_str().unwrap())
        .unwrap();
    let root = tempfile::tempdir().unwrap();
    unpack(&archive, root.path());
    let folder = root.path().join("run");
    let before = last_state(&folder.join(CHECKPOINT)).unwrap();
    assert!(folder.join("measured-before/figures.csv").exists());
    let config = fs::read_to_string(folder.join("config.toml")).unwrap();
    assert!(config.contains("sample_interval = 0.02\n"), "{config}");
    // A state starts its epoch anew: its time is rounded again.
    let said = saved["done"]["time"].as_f64().unwrap();
    let time = before.state.time().to_f64();
    assert!((time - said).abs() <= f64::EPSILON * said, "{time} {said}");
    let [scene, folder] = [folder.join("config.toml"), folder];
    let words = ["run", scene.to_str().unwrap(), "--out"];
    let more = [folder.to_str().unwrap(), "--resume", "--no-price"];
    let run = Run::parse_from(words.iter().chain(&more));
    run::run(&run.options).unwrap();
    let after = last_state(&folder.join(CHECKPOINT)).unwrap();
    assert!(after.is_end && after.state.time() > before.state.time());
    // The series of the page comes first.
    let series = fs::read_to_string(folder.join("temperature-gas.csv")).unwrap();
    let times: Vec<f64> = series
        .lines()
        .skip(1)
        .map(|row| row.split(',').next().unwrap().parse().unwrap())
        .collect();
    let begun = begun.as_f64().unwrap();
    assert!(
        (times[0] - begun).abs() <= 1e-14 * begun,
        "{times:?} {begun}"
    );
    assert!(times.is_sorted() && times.last().unwrap() > &said);
}

#[test]
fn a_faulty_scene_is_refused_with_its_line_and_the_open_one_stays() {
    let mut laboratory = LaboratoryOfPage::new().unwrap();
    assert!(answer(&mut laboratory, 1, &json!({ "open": "sinai" }))["refused"].is_null());
    for (text, named) in [
        ("[box]\nseed = 1\n[[gas]\n", "line 3"),
        ("[[gas]]\nradius = 0.1\nlevity = 1.0\n", "levity"),
        (
            "[[gas]]\nradius = 1e-6\nmass = 1.0\nenergy = 1.0\ncount = 4000000000\n",
            "2^27",
        ),
    ] {
        let open = json!({ "scene": { "name": "faulty", "text": text } });
        let refused = answer(&mut laboratory, 2, &open)["refused"].clone();
        assert!(
            refused.as_str().is_some_and(|words| words.contains(named)),
            "{text}: {refused}"
        );
    }
    let source = answer(&mut laboratory, 3, &json!({ "source": true }));
    assert_eq!(source["done"]["name"], "sinai");
}
