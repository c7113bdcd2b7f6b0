//! Measures the goals of the laboratory: time to the first frame, latency of an edit, frames of a
//! second, and what the engine loses to the view.
//!
//!     cargo run --release -p carom-live --example goals -- 10000
//!
//! A second argument is the number of further pages that watch.
//!
//! The page is a program that reads frames and draws nothing, so that the figures are those of
//! engine and server. The loss comes from rounds in turn: the laboratory with a view, and the same
//! run in one piece without a server.

use std::{
    env,
    io::{Stdout, Write as _},
    net::{Ipv4Addr, SocketAddr, TcpStream},
    thread,
    time::{Duration, Instant},
};

use anyhow::{Context, Result, bail};
use carom::Scene;
use carom_live::Server;
use carom_runs::clock::ThreadTime;
use carom_runs::{interruption::Signals, run::interactive::InteractiveRun};
use serde_json::{Value, json};
use tungstenite::{Message, WebSocket, client::IntoClientRequest as _};

/// Rounds with and without a view, and the length of each.
const ROUNDS: usize = 8;
const ROUND: Duration = Duration::from_secs(3);

/// Number of edits.
const EDITS: usize = 20;

struct Page {
    socket: WebSocket<TcpStream>,
    frames: usize,
    /// Bytes of the last frame.
    bytes: usize,
    collisions: u64,
    /// Processor time of the engine (seconds).
    seconds: f64,
}

impl Page {
    fn open(address: &str) -> Result<Self> {
        let host = address
            .trim_start_matches("http://")
            .split('/')
            .next()
            .context("the address")?;
        let mut request =
            format!("{}socket", address.replace("http", "ws")).into_client_request()?;
        request
            .headers_mut()
            .insert("Origin", format!("http://{host}").parse()?);
        let stream = TcpStream::connect(host)?;
        stream.set_read_timeout(Some(Duration::from_mins(1)))?;
        let (socket, _) = tungstenite::client(request, stream)?;
        Ok(Self {
            socket,
            frames: 0,
            bytes: 0,
            collisions: 0,
            seconds: 0.0,
        })
    }

    fn send(&mut self, command: &Value) -> Result<()> {
        Ok(self
            .socket
            .send(Message::text(json!({ "id": 1, "do": command }).to_string()))?)
    }

    fn read(&mut self) -> Result<Option<Value>> {
        match self.socket.read()? {
            Message::Binary(bytes) if bytes[0] == 1 => {
                (self.frames, self.bytes) = (self.frames + 1, bytes.len());
                let number = u32::from_le_bytes([bytes[32], bytes[33], bytes[34], bytes[35]]);
                self.send(&json!({ "seen": number }))?;
            }
            Message::Text(text) => {
                let message: Value = serde_json::from_str(text.as_str())?;
                if let Some(collisions) = message["status"]["collisions"].as_u64() {
                    self.collisions = collisions;
                    self.seconds = message["status"]["processor"].as_f64().unwrap_or(f64::NAN);
                }
                return Ok((!message["answer"].is_null()).then_some(message));
            }
            _ => {}
        }
        Ok(None)
    }

    fn answered(&mut self, command: &Value) -> Result<()> {
        self.send(command)?;
        loop {
            if let Some(answer) = self.read()? {
                if answer.get("refused").is_some() {
                    bail!("{answer}");
                }
                return Ok(());
            }
        }
    }

    /// Collisions of a second of the clock and of the engine's processor time, and frames of a
    /// second.
    fn round(&mut self) -> Result<[f64; 3]> {
        self.report()?;
        let (clock, frames, collisions, seconds) =
            (Instant::now(), self.frames, self.collisions, self.seconds);
        while clock.elapsed() < ROUND {
            self.report()?;
        }
        let wall = clock.elapsed().as_secs_f64();
        let collisions = (self.collisions - collisions) as f64;
        Ok([
            collisions / wall,
            collisions / (self.seconds - seconds),
            (self.frames - frames) as f64 / wall,
        ])
    }

    /// Reads to the next report of the state.
    fn report(&mut self) -> Result<()> {
        let before = self.collisions;
        while self.collisions == before {
            self.read()?;
        }
        Ok(())
    }
}

/// The simulated time of a round, from a start of this length.
fn in_time(run: &mut InteractiveRun, mut length: f64) -> Result<f64> {
    loop {
        let (clock, until) = (Instant::now(), run.view().time().after(length));
        run.advance(until, &mut ())?;
        let seconds = clock.elapsed().as_secs_f64();
        if seconds > 0.3 {
            return Ok(length * ROUND.as_secs_f64() / seconds);
        }
        length *= 2.0;
    }
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

fn main() -> Result<()> {
    let count: f64 = env::args()
        .nth(1)
        .map_or(Ok(10_000.0), |word| word.parse())?;
    let scene = gas_of(count)?;
    let begun = Instant::now();
    let signals = Signals::default();
    let address = SocketAddr::new(Ipv4Addr::LOCALHOST.into(), 0);
    let server = Server::bind(
        address,
        &env::temp_dir().join("carom-goals"),
        signals.clone(),
    )?;
    let address = server.address().to_owned();
    let served = scene.clone();
    let thread = thread::spawn(move || server.serve(Some(("gas".to_owned(), served))));
    let mut page = Page::open(&address)?;
    let whole = json!({ "view": { "centre": [0.5, 0.5], "half": [0.6, 0.6] } });
    page.send(&whole)?;
    while page.frames == 0 {
        page.read()?;
    }
    let mut out = std::io::stdout();
    let more = env::args()
        .nth(2)
        .map_or(Ok(0_usize), |word| word.parse())?;
    for _ in 0..more {
        let mut reader = Page::open(&address)?;
        reader.send(&whole)?;
        // Until the server ends.
        thread::spawn(move || while reader.read().is_ok() {});
    }
    writeln!(
        out,
        "{count} discs; first frame after {:.0} ms",
        begun.elapsed().as_secs_f64() * 1e3
    )?;
    page.answered(&json!({ "play": true }))?;
    let latency = median(latencies(&mut page)?);
    writeln!(
        out,
        "an edit is shown after {latency:.0} ms (median of {EDITS})"
    )?;
    page.answered(&json!({ "play": false }))?;
    write_loss(&mut page, &scene, &mut out)?;
    signals.interrupt();
    thread
        .join()
        .map_err(|_| anyhow::anyhow!("the server has panicked"))??;
    Ok(())
}

/// A gas of this number of equal discs, at an area fraction of 0.3.
fn gas_of(count: f64) -> Result<Scene> {
    let radius = (0.3 / (count * std::f64::consts::PI)).sqrt();
    Ok(Scene::from_toml(&format!(
        "[[gas]]\ntags = [\"gas\"]\nradius = {radius}\nmass = 1.0\ntemperature = 1.0\nvelocities = \"maxwell\"\n\
         count = {count}\n"
    ))?)
}

/// The times from edits of the elasticity to their frames (milliseconds).
fn latencies(page: &mut Page) -> Result<Vec<f64>> {
    let mut latencies = Vec::new();
    for edit in 0..EDITS {
        // The last one is elastic: rules for lossy contacts cost time of their own.
        let elasticity = 1.0 - 0.001 * ((edit + 1) % 2) as f64;
        let (clock, frames) = (Instant::now(), page.frames);
        page.answered(
            &json!({ "edit": [{ "stage": { "elasticity": { "default": elasticity } } }] }),
        )?;
        while page.frames == frames {
            page.read()?;
        }
        latencies.push(clock.elapsed().as_secs_f64() * 1e3);
    }
    Ok(latencies)
}

/// Writes the speed of the engine in one piece, and what it loses to the view, from rounds in turn.
fn write_loss(page: &mut Page, scene: &Scene, out: &mut Stdout) -> Result<()> {
    let mut alone = InteractiveRun::new(scene)?;
    let length = in_time(&mut alone, 1e-3)?;
    let (mut losses, mut frames, mut speeds) =
        ([(); 2].map(|()| Vec::new()), Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        page.answered(&json!({ "play": true }))?;
        let [by_clock, by_processor, shown] = page.round()?;
        frames.push(shown);
        page.answered(&json!({ "play": false }))?;
        let before = alone.view().counters().collisions;
        let (clock, processor) = (Instant::now(), ThreadTime::now());
        let until = alone.view().time().after(length);
        alone.advance(until, &mut ())?;
        let collisions = (alone.view().counters().collisions - before) as f64;
        speeds.push(collisions / processor.elapsed().as_secs_f64());
        losses[0].push(1.0 - by_clock * clock.elapsed().as_secs_f64() / collisions);
        losses[1].push(1.0 - by_processor * processor.elapsed().as_secs_f64() / collisions);
    }
    let [by_clock, by_processor] = losses.map(|losses| 100.0 * median(losses));
    writeln!(
        out,
        "{:.0} frames a second of {} bytes; {:.2e} collisions a second of processor time in one piece; with a view \
         {by_clock:.1} % fewer by the clock, {by_processor:.1} % fewer by processor time (medians of {ROUNDS} pairs)",
        median(frames),
        page.bytes,
        median(speeds),
    )?;
    Ok(())
}
