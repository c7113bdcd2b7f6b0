//! A browser without a window, which runs scripts in pages.

use std::{
    fs,
    path::Path,
    process::{Command, Stdio},
};

use crate::skipped::skipped;

/// Names of the program in Debian, other distributions, and from Google.
const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// Elements for the beginning of a head, which collect errors and warnings of the page in `faults`.
const FAULTS: &str = "<script nonce=probe>const faults = []; addEventListener('error', (event) => faults.push(event.message)); \
     for (const kind of ['error', 'warn']) console[kind] = (...words) => faults.push(words.join(' '));</script>";

/// The browser of this machine; without one, `test` is reported as skipped.
pub fn browser(test: &str) -> Option<&'static str> {
    let answers = |name: &&str| {
        let version = Command::new(name)
            .arg("--version")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status();
        version.is_ok_and(|status| status.success())
    };
    let found = BROWSERS.into_iter().find(|name| answers(name));
    if found.is_none() {
        skipped(test, format_args!("none of {BROWSERS:?} is installed"));
    }
    found
}

/// Adds a script at the end of a page, and at its beginning a list `faults` of errors and warnings.
/// The Content-Security-Policy of the page allows both beside the scripts of the page.
pub fn with_probe(html: &str, script: &str) -> String {
    // The last end of a body: a script of the page may hold another.
    let (start, end) = html.rsplit_once("</body>").unwrap_or((html, ""));
    let start = start.replacen("script-src ", "script-src 'nonce-probe' ", 1);
    let start = start.replacen("<head>", &format!("<head>{FAULTS}"), 1);
    format!("{start}<script nonce=probe>{script}</script></body>{end}")
}

/// Opens a page and returns the text that its scripts put into the element `seen`.
///
/// # Panics
/// The browser cannot be started, writes a message to the console, or shows no such element.
pub fn seen(browser: &str, page: &Path, options: &[&str]) -> String {
    let profile = page.with_file_name("profile");
    let output = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--enable-logging=stderr",
        ])
        .args(["--virtual-time-budget=20000", "--dump-dom"])
        .args(options)
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("the browser can be started");
    // A process that ends may still hold files; they lie in a temporary folder.
    let _ = fs::remove_dir_all(profile);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!said.contains("CONSOLE"), "{said}");
    let shown = String::from_utf8_lossy(&output.stdout);
    let (_, rest) = shown
        .split_once("id=\"seen\">")
        .unwrap_or_else(|| panic!("the probe has no result: {said}"));
    rest.split_once("</script>")
        .map(|(text, _)| text.to_owned())
        .expect("the end of the element")
}
