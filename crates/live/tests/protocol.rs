//! The server as a page sees it: what it refuses, and what the commands do to the running gas.

use std::{
    fs,
    io::{Read as _, Write as _},
    net::{Ipv4Addr, SocketAddr, TcpStream},
    path::Path,
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use anyhow::Result;
use carom::Scene;
use carom_live::{LaboratoryEnd, SAVE_INTERVAL, Server};
use carom_runs::{
    interruption::Signals,
    resumable::{CHECKPOINT, last_state},
    run,
};
use clap::Parser;
use serde_json::{Value, json};
use tungstenite::{Message, WebSocket, client::IntoClientRequest as _};

/// Longest wait for an answer.
const PATIENCE: Duration = Duration::from_mins(1);

const GAS: &str = r#"
    [box]
    seed = 2
    [[gas]]
    tags = ["gas"]
    radius = 0.01
    mass = 1.0
    energy = 1.0
    count = 400
    [run]
    until = 2.0
    sample_interval = 0.05
"#;

#[derive(Debug, Parser)]
struct Run {
    #[command(flatten)]
    options: run::RunOptions,
}

/// A server on a free port.
fn bind(folder: &Path, signals: Signals) -> Result<Server> {
    Server::bind(
        SocketAddr::new(Ipv4Addr::LOCALHOST.into(), 0),
        folder,
        signals,
    )
}

/// A running server.
struct Running {
    address: String,
    once: String,
    signals: Signals,
    thread: JoinHandle<Result<LaboratoryEnd>>,
}

impl Running {
    fn start(folder: &Path, scene: Option<&str>) -> Self {
        Self::saving_every(folder, scene, SAVE_INTERVAL)
    }

    fn saving_every(folder: &Path, scene: Option<&str>, interval: Duration) -> Self {
        let signals = Signals::default();
        let server = bind(folder, signals.clone())
            .unwrap()
            .saving_every(interval);
        let (address, once) = (
            server.address().to_owned(),
            server.address_for_once().unwrap(),
        );
        let scene = scene.map(|text| ("gas".to_owned(), Scene::from_toml(text).unwrap()));
        let thread = thread::spawn(move || server.serve(scene));
        Self {
            address,
            once,
            signals,
            thread,
        }
    }

    /// Host with port, and the token.
    fn parts(&self) -> (&str, &str) {
        self.address
            .trim_start_matches("http://")
            .trim_end_matches('/')
            .split_once('/')
            .unwrap()
    }

    fn end(self) -> LaboratoryEnd {
        self.signals.interrupt();
        self.thread.join().unwrap().unwrap()
    }

    /// The status line and the text of an answer.
    fn get(&self, path: &str, headers: &str) -> (String, String) {
        self.ask("GET", path, headers)
    }

    fn ask(&self, method: &str, path: &str, headers: &str) -> (String, String) {
        let (host, _) = self.parts();
        let mut stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n"
        )
        .unwrap();
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        let (head, body) = text.split_once("\r\n\r\n").unwrap();
        (head.to_owned(), body.to_owned())
    }

    /// The status line of a handshake with this host and origin.
    fn handshake(&self, token: &str, host: &str, origin: Option<&str>) -> String {
        let origin = origin.map_or(String::new(), |origin| format!("Origin: {origin}\r\n"));
        let (real, _) = self.parts();
        let mut stream = TcpStream::connect(real).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        write!(
            stream,
            "GET /{token}/socket HTTP/1.1\r\nHost: {host}\r\n{origin}Connection: Upgrade\r\nUpgrade: websocket\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
        )
        .unwrap();
        let mut first = [0; 12];
        stream.read_exact(&mut first).unwrap();
        String::from_utf8_lossy(&first).into_owned()
    }
}

/// A page.
struct Page {
    socket: WebSocket<TcpStream>,
    next: u64,
    /// Texts that came before the one that was waited for.
    status: Value,
    measures: Value,
    /// The last frame.
    frame: Vec<u8>,
    frames: usize,
    hello: Value,
}

impl Page {
    fn open(server: &Running) -> Self {
        let (host, token) = server.parts();
        let stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut request = format!("ws://{host}/{token}/socket")
            .into_client_request()
            .unwrap();
        request
            .headers_mut()
            .insert("Origin", format!("http://{host}").parse().unwrap());
        let (socket, _) = tungstenite::client(request, stream).unwrap();
        let mut page = Self {
            socket,
            next: 0,
            status: Value::Null,
            measures: Value::Null,
            frame: Vec::new(),
            frames: 0,
            hello: Value::Null,
        };
        page.until(|page| !page.hello.is_null());
        page
    }

    fn send(&mut self, id: u64, command: &Value) {
        self.socket
            .send(Message::text(
                json!({ "id": id, "do": command }).to_string(),
            ))
            .unwrap();
    }

    /// Reads one message; returns an answer.
    fn read(&mut self) -> Option<Value> {
        match self.socket.read().unwrap() {
            Message::Text(text) => {
                let mut message: Value = serde_json::from_str(text.as_str()).unwrap();
                if message.get("hello").is_some() {
                    self.hello = message;
                } else if message.get("status").is_some() {
                    self.status = message["status"].take();
                } else if message.get("measures").is_some() {
                    self.measures = message["measures"].take();
                } else {
                    return Some(message);
                }
            }
            Message::Binary(bytes) if bytes[0] == 1 => {
                self.frame = bytes.to_vec();
                self.frames += 1;
                let number = u32::from_le_bytes(bytes[32..36].try_into().unwrap());
                self.send(0, &json!({ "seen": number }));
            }
            _ => {}
        }
        None
    }

    fn until(&mut self, is_done: impl Fn(&Self) -> bool) {
        let begun = Instant::now();
        while !is_done(self) {
            assert!(begun.elapsed() < PATIENCE, "{}", self.status);
            self.read();
        }
    }

    /// What was done, or the refusal.
    fn request(&mut self, command: &Value) -> Result<Value, String> {
        self.next += 1;
        self.send(self.next, command);
        let begun = Instant::now();
        loop {
            assert!(begun.elapsed() < PATIENCE, "no answer to {command}");
            let Some(mut answer) = self.read() else {
                continue;
            };
            if answer["answer"] == self.next {
                return match answer["refused"].as_str() {
                    Some(refused) => Err(refused.to_owned()),
                    None => Ok(answer["done"].take()),
                };
            }
        }
    }

    /// The next state of the run that has been computed from now on.
    fn fresh(&mut self) -> &Value {
        for _ in 0..2 {
            self.status = Value::Null;
            self.until(|page| !page.status.is_null());
        }
        &self.status
    }

    /// Number of contacts of the chosen body in the last frame.
    fn kicks(&self) -> u32 {
        u32::from_le_bytes(self.frame[44..48].try_into().unwrap())
    }

    fn time(&self) -> f64 {
        f64::from_le_bytes(self.frame[8..16].try_into().unwrap())
    }
}

const WHOLE: &str = r#"{ "view": { "centre": [0.5, 0.5], "half": [0.6, 0.6] } }"#;

fn whole() -> Value {
    serde_json::from_str(WHOLE).unwrap()
}

#[test]
fn only_the_page_of_this_server_on_this_machine_is_served() {
    let root = tempfile::tempdir().unwrap();
    let server = Running::start(root.path(), None);
    let (host, token) = server.parts();
    let of = |host: &str| format!("Host: {host}\r\n");
    let (head, page) = server.get(&format!("/{token}/"), &of(host));
    assert!(
        head.starts_with("HTTP/1.1 200") && page.starts_with("<!DOCTYPE html>"),
        "{head}"
    );
    assert!(
        head.to_lowercase()
            .contains("content-security-policy: default-src 'none'"),
        "{head}"
    );
    assert!(
        page.len() < 300_000 && !page.contains("http://") && !page.contains("https://"),
        "{}",
        page.len()
    );
    for (path, headers) in [
        ("/".to_owned(), of(host)),
        ("/wrong/".to_owned(), of(host)),
        (format!("/{}/", &token[1..]), of(host)),
        (format!("/{token}/"), of("evil.example")),
        (format!("/{token}/"), of("localhost.evil.example:80")),
        (format!("/{token}/"), of("192.168.7.7")),
    ] {
        assert!(
            server.get(&path, &headers).0.starts_with("HTTP/1.1 403"),
            "{path} {headers}"
        );
    }
    assert!(
        server
            .get(&format!("/{token}/more"), &of(host))
            .0
            .starts_with("HTTP/1.1 404")
    );
    // An address for once, without the token, leads to the page.
    let once = server.once.strip_prefix(&format!("http://{host}")).unwrap();
    assert!(!once.contains(token));
    for (path, headers) in [
        (once, of("evil.example")),
        (&once[..once.len() - 1], of(host)),
        ("/open/", of(host)),
    ] {
        assert!(
            server.get(path, &headers).0.starts_with("HTTP/1.1 403"),
            "{path} {headers}"
        );
    }
    // A program that only asks for the type of the page does not use it up.
    assert!(
        server
            .ask("HEAD", once, &of(host))
            .0
            .starts_with("HTTP/1.1 405")
    );
    let (head, _) = server.get(once, &of(host));
    assert!(
        head.starts_with("HTTP/1.1 303") && head.contains(&format!("location: /{token}/")),
        "{head}"
    );
    assert!(
        server.get(once, &of(host)).0.starts_with("HTTP/1.1 403"),
        "only once"
    );
    let own = format!("http://{host}");
    assert!(server.handshake(token, host, Some(&own)).ends_with("101"));
    for (token, host, origin) in [
        (token, host, None),
        (token, host, Some("http://evil.example")),
        (token, host, Some("null")),
        (token, "evil.example", Some("http://evil.example")),
        ("wrong", host, Some(own.as_str())),
    ] {
        assert!(
            server.handshake(token, host, origin).ends_with("403"),
            "{token} {host} {origin:?}"
        );
    }
    assert!(server.end().saved.is_none(), "no scene was open");
}

/// Contacts one by one, the impulses on one of their bodies, and the way back to a bookmark.
fn steps_and_goes_back(page: &mut Page) {
    page.request(&json!({ "play": false })).unwrap();
    let before = page.fresh()["collisions"].as_u64().unwrap();
    let time = page.status["time"].as_f64().unwrap();
    let done = page.request(&json!({ "bookmark": true })).unwrap();
    assert_eq!(done["time"], time);
    page.request(&json!({ "choose": 7 })).unwrap();
    assert_eq!(
        page.request(&json!({ "step": 10 })).unwrap()["contacts"],
        10
    );
    assert_eq!(page.fresh()["collisions"], before + 10);
    for _ in 0..5 {
        page.request(&json!({ "step": 1000 })).unwrap();
    }
    page.fresh();
    assert!(page.kicks() > 5, "5010 contacts of 400 discs");
    // Edits keep them.
    let kicks = page.kicks();
    page.request(&json!({ "edit": [{ "elasticity": 0.9 }] }))
        .unwrap();
    page.fresh();
    assert_eq!(page.kicks(), kicks);
    // A body that is removed is no longer chosen.
    page.request(&json!({ "edit": [{ "stage": { "tag": [{ "body": 7, "name": "x" }] } }, { "stage": { "remove": ["x"] } }] }))
        .unwrap();
    assert!(page.fresh()["chosen"].is_null());
    page.request(&json!({ "back": true })).unwrap();
    page.fresh();
    assert_eq!(
        (&page.status["time"], &page.status["collisions"]),
        (&json!(time), &json!(before))
    );
}

#[test]
#[expect(clippy::too_many_lines, reason = "one course with many looks")]
fn a_page_runs_edits_measures_and_saves_a_gas() {
    let root = tempfile::tempdir().unwrap();
    let server = Running::start(&root.path().join("saved"), Some(GAS));
    let mut page = Page::open(&server);
    assert_eq!(page.hello["writer"], true);
    page.request(&json!({ "play": true })).unwrap();
    page.send(0, &whole());
    page.until(|page| page.frames > 3);
    let first = page.time();
    page.until(|page| page.time() > first);
    assert_eq!(
        u32::from_le_bytes(page.frame[36..40].try_into().unwrap()),
        400
    );
    assert_eq!(
        page.frame.len(),
        48 + 8 * 400,
        "places alone, of discs coloured by tag"
    );
    let energy = page.fresh()["energy"].as_f64().unwrap();
    assert!((energy - 400.0).abs() < 1e-9);

    // A second page only watches.
    let mut reader = Page::open(&server);
    assert_eq!(reader.hello["writer"], false);
    let refused = reader.request(&json!({ "play": false })).unwrap_err();
    assert!(refused.contains("only watch"), "{refused}");
    reader.send(0, &whole());
    reader.until(|page| page.frames > 0);
    // It chooses a body for itself.
    assert_eq!(reader.request(&json!({ "choose": 3 })).unwrap()["id"], 3);
    page.request(&json!({ "choose": 7 })).unwrap();
    reader.until(|page| page.status["chosen"]["id"] == 3 && page.kicks() > 1);
    assert_eq!(page.fresh()["chosen"]["id"], 7);
    page.request(&json!({ "choose": null })).unwrap();
    page.fresh();
    page.until(|page| page.kicks() == 0);
    assert_eq!(reader.fresh()["chosen"]["id"], 3);

    // Contacts begin to lose energy. At full speed the gas would come to rest in the meantime, at a
    // time so late that the rest of the saved run would be long.
    page.request(&json!({ "speed": 1.0 })).unwrap();
    page.request(&json!({ "edit": [{ "stage": { "elasticity": { "default": 0.5 } } }] }))
        .unwrap();
    page.until(|page| {
        page.status["energy"]
            .as_f64()
            .is_some_and(|energy| energy < 200.0)
    });
    assert_eq!(page.status["elasticity"], 0.5);
    assert!(page.status["drift"].as_f64().unwrap() < 1e-12);
    assert_eq!(page.status["overlaps"], 0);
    page.request(&json!({ "edit": [{ "stage": {
        "elasticity": { "default": 1.0 }, "set_energy": [{ "tag": "gas", "energy": 2.0 }] } }] }))
        .unwrap();
    assert!((page.fresh()["energy"].as_f64().unwrap() - 800.0).abs() < 1e-9);
    page.request(&json!({ "speed": null })).unwrap();

    // Impossible edits are refused in the words of the engine.
    for (stage, words) in [
        (json!({ "elasticity": { "default": -0.5 } }), "-0.5"),
        (json!({ "remove": ["gsa"] }), "gas"),
        (json!({ "tag": [{ "body": 4000, "name": "x" }] }), "4000"),
        (
            json!({ "add": [{ "shape": "disc", "atom_radius": 0.4, "atom_mass": 1.0, "at": [0.5, 0.5] }] }),
            "overlap",
        ),
        (json!({ "until": 7.0 }), "until"),
    ] {
        let refused = page
            .request(&json!({ "edit": [{ "stage": stage }] }))
            .unwrap_err();
        assert!(refused.contains(words), "{stage}: {refused}");
    }
    for (command, words) in [
        (json!({ "speed": -1.0 }), "positive"),
        (json!({ "step": 0 }), "contacts"),
        (json!({ "choose": 4000 }), "4000"),
        (json!({ "back": true }), "bookmark"),
        (json!({ "open": "nowhere" }), "nowhere"),
        (
            json!({ "measure": { "spec": { "kind": "pressur" } } }),
            "pressure",
        ),
        (json!({ "edit": [] }), "edits"),
    ] {
        let refused = page.request(&command).unwrap_err();
        assert!(refused.contains(words), "{command}: {refused}");
    }

    // Measures with their predictions; the last edit was before.
    page.request(&json!({ "measure": { "spec": { "kind": "pressure" }, "interval": 0.01 } }))
        .unwrap();
    page.until(|page| {
        page.measures[0]["samples"]
            .as_u64()
            .is_some_and(|samples| samples > 100)
    });
    let figures = page.measures[0]["figures"].as_array().unwrap().clone();
    let pressure = figures
        .iter()
        .find(|figure| figure["name"] == "pressure")
        .unwrap();
    let (found, theory) = (
        pressure["value"].as_f64().unwrap(),
        pressure["prediction"].as_f64().unwrap(),
    );
    assert!((found / theory - 1.0).abs() < 0.2, "{pressure}");

    steps_and_goes_back(&mut page);

    // Slow motion: a hundredth of a time unit a second.
    page.request(&json!({ "speed": 0.01 })).unwrap();
    page.request(&json!({ "play": true })).unwrap();
    let (clock, from) = (Instant::now(), page.fresh()["time"].as_f64().unwrap());
    page.until(|page| {
        page.status["time"]
            .as_f64()
            .is_some_and(|time| time > from + 0.005)
    });
    assert!(clock.elapsed() > Duration::from_millis(200));

    let saved = page.request(&json!({ "save": true })).unwrap();
    assert!(saved["command"].as_str().unwrap().contains("--resume"));
    let ended = server.end().saved.expect("a run was open");
    // JSON numbers are read to a rounding.
    assert!(ended.time >= saved["time"].as_f64().unwrap() * (1.0 - 1e-15));
    assert!(
        root.path().join("saved/2/checkpoint").exists(),
        "{}",
        ended.command
    );
    // The run continues by `carom run`.
    let folder = root.path().join("saved/1");
    let text = folder.join("config.toml");
    let words = [
        "run",
        text.to_str().unwrap(),
        "--out",
        folder.to_str().unwrap(),
        "--resume",
    ];
    run::run(&Run::parse_from(words).options).unwrap();
    let last = last_state(&folder.join(CHECKPOINT)).unwrap();
    assert!(last.is_end && last.state.time().to_f64() > saved["time"].as_f64().unwrap());
}

#[test]
fn bodies_at_rest_are_heated_and_edits_that_heat_no_body_are_refused() {
    const REST: &str = r#"
        [[molecule]]
        tags = ["tee"]
        shape = "tee"
        atom_radius = 0.02
        atom_mass = 1.0
        at = [0.5, 0.5]
        [[bumper]]
        tags = ["bumper"]
        radius = 0.05
        at = [0.2, 0.2]
    "#;
    let root = tempfile::tempdir().unwrap();
    let server = Running::start(root.path(), Some(REST));
    let mut page = Page::open(&server);
    // One body, by a tag that it has during the edit.
    let own = json!([{ "body": 0, "name": "own" }]);
    let done = page.request(&json!({ "edit": [
        { "stage": { "tag": own } },
        { "stage": { "set_energy": [{ "tag": "own", "energy": 3.0 }] } },
        { "stage": { "untag": own } },
    ] }));
    let notes = done.unwrap()["notes"].take();
    assert!(
        notes[0].as_str().unwrap().contains("1 body was at rest"),
        "{notes}"
    );
    assert!((page.fresh()["energy"].as_f64().unwrap() - 3.0).abs() < 1e-12);
    assert_eq!(page.status["tags"].as_array().unwrap().len(), 2);
    let heat = json!({ "tag": "bumper", "energy": 1.0 });
    let hold = json!({ "tag": "bumper", "energy": 1.0, "every": 0.1 });
    for edit in [
        json!({ "stage": { "set_energy": [heat] } }),
        json!({ "hold": [hold] }),
    ] {
        let refused = page.request(&json!({ "edit": [edit] })).unwrap_err();
        assert!(refused.contains("fixed"), "{refused}");
    }
    assert_eq!(page.fresh()["hold"], json!([]));
}

#[test]
fn a_gallery_scene_opens_and_a_page_that_leaves_passes_its_rights_on() {
    let root = tempfile::tempdir().unwrap();
    let server = Running::start(root.path(), None);
    let (mut first, mut second) = (Page::open(&server), Page::open(&server));
    assert!(first.hello["gallery"].as_array().unwrap().len() >= 6);
    let refused = first.request(&json!({ "play": true })).unwrap_err();
    assert!(refused.contains("no scene"), "{refused}");
    first.request(&json!({ "open": "sinai" })).unwrap();
    second.send(0, &whole());
    second.until(|page| page.frames > 2 && page.status["bodies"] == 2);
    drop(first);
    // Until the server has noticed.
    let begun = Instant::now();
    while second.request(&json!({ "play": false })).is_err() {
        assert!(begun.elapsed() < PATIENCE);
        thread::sleep(Duration::from_millis(20));
    }
    // A page that does not read holds nothing up.
    second.request(&json!({ "play": true })).unwrap();
    let time = second.fresh()["time"].as_f64().unwrap();
    thread::sleep(Duration::from_millis(300));
    assert!(second.fresh()["time"].as_f64().unwrap() > time);
    assert!(server.end().saved.is_some());
}

#[test]
fn a_run_is_saved_by_itself_with_the_bits_of_a_save_on_request() {
    let root = tempfile::tempdir().unwrap();
    let server = Running::saving_every(root.path(), Some(GAS), Duration::from_millis(50));
    let mut page = Page::open(&server);
    page.request(&json!({ "play": true })).unwrap();
    // Several, each of which replaces the one before.
    for _ in 0..3 {
        let last = page.status["saved"]["time"].as_f64().unwrap_or(-1.0);
        page.until(|page| {
            page.status["saved"]["time"]
                .as_f64()
                .is_some_and(|time| time > last)
        });
        assert!(page.status["saved"]["error"].is_null());
    }
    page.request(&json!({ "play": false })).unwrap();
    let now = page.fresh()["time"].as_f64().unwrap();
    page.until(|page| {
        page.status["saved"]["time"]
            .as_f64()
            .is_some_and(|time| time >= now)
    });
    page.request(&json!({ "save": true })).unwrap();
    let session = root.path().join("auto-1");
    let begun = Instant::now();
    let saves = || {
        fs::read_dir(&session)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect::<Vec<_>>()
    };
    while saves().len() > 1 {
        assert!(begun.elapsed() < PATIENCE, "{:?}", saves());
        thread::sleep(Duration::from_millis(20));
    }
    let automatic = saves().pop().unwrap();
    for file in ["checkpoint", "config.toml", "start.svg"] {
        let [one, other] =
            [&automatic, &root.path().join("1")].map(|folder| fs::read(folder.join(file)).unwrap());
        assert!(one == other, "{file}");
    }
    // It continues by `carom run`.
    let copy = root.path().join("copy");
    fs::rename(&automatic, &copy).unwrap();
    let text = copy.join("config.toml");
    let words = [
        "run",
        text.to_str().unwrap(),
        "--out",
        copy.to_str().unwrap(),
        "--resume",
    ];
    run::run(&Run::parse_from(words).options).unwrap();
    assert!(last_state(&copy.join(CHECKPOINT)).unwrap().is_end);
    assert!(server.end().saved.is_some());
    assert!(
        !session.exists(),
        "a session that ends well leaves its numbered runs alone"
    );
}

#[test]
fn a_folder_that_cannot_be_written_is_refused_before_the_first_frame() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("file"), "").unwrap();
    let refused = bind(&root.path().join("file/inner"), Signals::default()).unwrap_err();
    let words = format!("{refused:#}");
    assert!(
        words.contains("runs cannot be saved in") && words.contains("--out"),
        "{words}"
    );
    // Without a scene nothing remains.
    let folder = root.path().join("new");
    assert!(Running::start(&folder, None).end().saved.is_none() && !folder.exists());
}

#[test]
fn laboratories_with_one_folder_take_different_numbers_and_skip_what_is_there() {
    let root = tempfile::tempdir().unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink("nowhere", root.path().join("1")).unwrap();
    #[cfg(not(unix))]
    fs::write(root.path().join("1"), "").unwrap();
    let servers: Vec<_> = (0..2)
        .map(|_| Running::start(root.path(), Some(GAS)))
        .collect();
    let save = |server: &Running| {
        let mut page = Page::open(server);
        (0..5).for_each(|_| drop(page.request(&json!({ "save": true })).unwrap()));
    };
    thread::scope(|scope| {
        for server in &servers {
            scope.spawn(move || save(server));
        }
    });
    for server in servers {
        assert!(server.end().saved.is_some());
    }
    for number in 2..=13 {
        assert!(
            root.path().join(format!("{number}/checkpoint")).exists(),
            "{number}"
        );
    }
    assert_eq!(fs::read_dir(root.path()).unwrap().count(), 13);
}

#[test]
fn connections_that_send_half_a_request_neither_keep_pages_out_nor_stop_a_save() {
    let root = tempfile::tempdir().unwrap();
    let server = Running::start(root.path(), Some(GAS));
    let mut page = Page::open(&server);
    let (host, _) = server.parts();
    let silent: Vec<TcpStream> = (0..400)
        .map(|_| {
            let mut stream = TcpStream::connect(host).unwrap();
            stream.write_all(b"GET / HTTP/1.1\r\nHost: ").unwrap();
            stream
        })
        .collect();
    let mut other = Page::open(&server);
    assert_eq!(other.hello["writer"], false);
    other.fresh();
    page.request(&json!({ "save": true })).unwrap();
    // All but those of the limit have been ended, the oldest first.
    let mut first = &silent[0];
    first.set_read_timeout(Some(PATIENCE)).unwrap();
    assert!(matches!(first.read(&mut [0]), Ok(0) | Err(_)));
    // The others are ended by the time limit of their headers.
    let mut last = &silent[399];
    last.set_read_timeout(Some(PATIENCE)).unwrap();
    let mut answer = Vec::new();
    let _ = last.read_to_end(&mut answer);
    assert!(server.end().saved.is_some());
}

#[cfg(unix)]
#[test]
fn a_folder_whose_name_is_not_utf_8_takes_runs() {
    use std::{ffi::OsStr, os::unix::ffi::OsStrExt as _};
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join(OsStr::from_bytes(b"sv\xff"));
    let saved = Running::start(&folder, Some(GAS))
        .end()
        .saved
        .expect("a run was open");
    assert!(saved.command.contains("/sv\\377/1'"), "{}", saved.command);
    assert!(folder.join("1/checkpoint").exists());
}

#[test]
fn an_engine_far_from_its_next_stop_answers_and_saves() {
    const PARALLEL: &str = r#"
        [[molecule]]
        tags = ["gas"]
        shape = "disc"
        atom_radius = 0.1
        atom_mass = 1.0
        at = [0.5, 0.25]
        velocity = [1.0, 0.0]
        [[molecule]]
        tags = ["gas"]
        shape = "disc"
        atom_radius = 0.1
        atom_mass = 1.0
        at = [0.5, 0.75]
        velocity = [1.0, 0.0]
        [run]
        until = 1e12
        sample_interval = 1e11
    "#;
    let root = tempfile::tempdir().unwrap();
    let server = Running::start(root.path(), Some(PARALLEL));
    let mut page = Page::open(&server);
    let refused = page.request(&json!({ "step": 1 })).unwrap_err();
    assert!(refused.contains("no contact until"), "{refused}");
    let hold = json!({ "tag": "gas", "every": 1e12, "energy": 1.0 });
    page.request(&json!({ "edit": [{ "hold": [hold] }] }))
        .unwrap();
    page.request(&json!({ "edit": [{ "elasticity": 0.5 }] }))
        .unwrap();
    assert!(page.fresh()["time"].as_f64().unwrap() < 1e11);
    // A signal ends the steps at once.
    page.send(1000, &json!({ "step": 1000 }));
    assert!(server.end().saved.unwrap().time < 1e12);
}
