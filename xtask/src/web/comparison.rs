//! The module under node, compared with this machine.

use std::{
    io::Write as _,
    path::Path,
    process::{Command, Stdio},
    time::{Duration, Instant},
};

use anyhow::{Context, Result, anyhow, ensure};
use carom_live::{LaboratoryOfPage, Outgoing};
use carom_runs::{examples::Example, print_line};
use carom_tables::Verdict;
use carom_web::digest;
use serde_json::{Value, json};

use super::scenes::{self, THREE_WAYS};

/// The program that runs the module.
const HOST: &str = include_str!("host.mjs");

/// Duration of a measurement of speed.
const SPAN: Duration = Duration::from_secs(8);

/// Runs all scenes in the module and on this machine; [`Verdict::Failed`] if a bit differs.
///
/// # Errors
/// A scene cannot run, or node fails.
pub fn bits(module: &Path) -> Result<Verdict> {
    let all = scenes::all()?;
    let texts: Vec<&str> = all.iter().map(|(_, text)| text.as_str()).collect();
    let found = in_node(module, &json!({ "digests": texts }))?;
    let mut verdict = Verdict::Passed;
    for (index, (name, text)) in all.iter().enumerate() {
        let own = digest(text).with_context(|| format!("the scene {name}"))?;
        let of_module = found[index].as_str().unwrap_or("no answer");
        if own != of_module {
            verdict = Verdict::Failed;
            print_line(&format!(
                "web: FAILED: {name}: {own} here, {of_module} in WebAssembly"
            ));
        }
    }
    let pinned = THREE_WAYS.1.trim().trim_start_matches("0x");
    let first = found[0].as_str().unwrap_or_default();
    if !first.starts_with(pinned) {
        verdict = Verdict::Failed;
        print_line(&format!(
            "web: FAILED: three-ways: {first}, but {pinned} is pinned"
        ));
    }
    if verdict == Verdict::Passed {
        print_line(&format!(
            "web: {} scenes have the same bits here and in WebAssembly",
            all.len()
        ));
    }
    Ok(verdict)
}

/// Prints first motion and collisions a second of the gas of the thesis.
///
/// # Errors
/// Node fails, or the gas cannot run.
pub fn speed(module: &Path) -> Result<()> {
    let text = format!(
        "{}\n[method]\ninstructions = \"portable\"\n",
        Example::named("tee")?.text
    );
    let open = json!({ "id": 1, "do": { "scene": { "name": "tee", "text": text } } });
    let task = json!({ "speed": { "open": open.to_string(), "seconds": SPAN.as_secs_f64() } });
    let found = in_node(module, &task)?;
    let own = rate_here(&open.to_string())?;
    let [first, rate] = ["first", "rate"].map(|key| found[key].as_f64().unwrap_or(f64::NAN));
    print_line(&format!(
        "web: gas of the thesis: first motion after {first:.2} s; {rate:.0} collisions a second in \
         WebAssembly, {own:.0} in this build with portable instructions ({:.2})",
        rate / own
    ));
    Ok(())
}

/// Collisions a second of a scene in the laboratory of this build.
fn rate_here(open: &str) -> Result<f64> {
    let mut laboratory = LaboratoryOfPage::new().context("a laboratory has room for a page")?;
    laboratory.receive(open);
    let begun = Instant::now();
    let mut rates = Vec::new();
    while begun.elapsed() < SPAN {
        laboratory.advance();
        while let Some(message) = laboratory.next() {
            if let Outgoing::Text(text) = message {
                let message: Value = serde_json::from_str(&text)?;
                ensure!(message["refused"].is_null(), "the scene: {message}");
                rates.extend(
                    message["status"]["rate"]
                        .as_f64()
                        .filter(|rate| *rate > 0.0),
                );
            }
        }
    }
    rates.sort_unstable_by(f64::total_cmp);
    rates
        .get(rates.len() / 2)
        .copied()
        .context("the laboratory reports no rate")
}

/// What node answers to a task.
fn in_node(module: &Path, task: &Value) -> Result<Value> {
    let mut node = Command::new("node")
        .args(["--input-type=module", "--eval", HOST])
        .arg(module)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .context("cannot start node")?;
    let mut input = node.stdin.take().context("the input of node is piped")?;
    input
        .write_all(task.to_string().as_bytes())
        .context("node reads no task")?;
    drop(input);
    let output = node.wait_with_output().context("node")?;
    ensure!(output.status.success(), "node: {}", output.status);
    serde_json::from_slice(&output.stdout).map_err(|error| anyhow!("the answer of node: {error}"))
}
