//! Pages as a reader sees them, on a wide and on a narrow screen, light and dark: no empty chart,
//! no cut label, no broken word, nothing beyond the page.

use std::{fmt::Write as _, fs, path::Path, process::Command};

use carom_report::{
    axis::Axis,
    chart::{Chart, Layer, LayerShape},
    ink::Ink,
    page::{Layout, Page},
};
use carom_testkit::chromium;
use serde_json::Value;

/// Widths of the screens (pixels).
const WIDTHS: [u32; 2] = [1400, 400];

/// Blink's setting of the preferred colour scheme.
const SCHEMES: [(&str, bool); 2] = [
    ("--blink-settings=preferredColorScheme=1", false),
    ("--blink-settings=preferredColorScheme=0", true),
];

/// Measures pages in one browser, each in a frame of each width; returns the results by page, width
/// and scheme.
fn looked_at(browser: &str, pages: &[(&str, String)]) -> Vec<(String, Value)> {
    let root = tempfile::tempdir().unwrap();
    let mut frames = String::new();
    for (index, (name, html)) in pages.iter().enumerate() {
        let probed = chromium::with_probe(html, include_str!("layout.js"));
        fs::write(root.path().join(format!("{index}.html")), probed).unwrap();
        for width in WIDTHS {
            let _ = writeln!(
                frames,
                "<iframe name=\"{name} {width}\" src=\"{index}.html\" width=\"{width}\" height=\"900\" \
                 frameborder=\"0\"></iframe>"
            );
        }
    }
    let count = pages.len() * WIDTHS.len();
    let holder = format!(
        "<!DOCTYPE html><html><head><meta charset=\"utf-8\"><style>:root {{ color-scheme: light dark; }}</style></head><body>\
         <script>const all = {{}}; addEventListener('message', (event) => {{ all[event.data.name] = event.data.seen; \
         if (Object.keys(all).length < {count}) return; const element = document.createElement('script'); \
         element.type = 'application/json'; element.id = 'seen'; \
         element.textContent = JSON.stringify(all).replaceAll('<', '\\\\u003c'); document.body.append(element); }});</script>\
         {frames}</body></html>"
    );
    let path = root.path().join("holder.html");
    fs::write(&path, holder).unwrap();
    let mut results = Vec::new();
    for (scheme, is_dark) in SCHEMES {
        let seen = chromium::seen(browser, &path, &["--window-size=1500,900", scheme]);
        let seen: Value = serde_json::from_str(&seen).unwrap();
        for (name, of_page) in seen.as_object().unwrap() {
            assert_eq!(
                of_page["dark"], is_dark,
                "{name} follows the preferred scheme"
            );
            results.push((
                format!("{name} {}", if is_dark { "dark" } else { "light" }),
                of_page.clone(),
            ));
        }
    }
    assert_eq!(results.len(), 2 * count);
    results
}

fn run(program: &str, folder: &Path, arguments: &[&str], code: i32) {
    let output = Command::new(program)
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap();
    assert_eq!(
        output.status.code(),
        Some(code),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

/// A gas with measures whose tables have errors, predictions, logarithmic axes and adaptive bins.
const GAS: &str = r#"
    [[gas]]
    tags = ["gas"]
    radius = 0.03
    mass = 1.0
    energy = 1.0
    count = 60
    [run]
    until = 4.0
    sample_interval = 0.05
    snapshots = "extxyz"
    observe = ["energy", "pressure", "velocities", "correlation", "pair-distribution", "structure-factor",
        "temperature", "free-path"]
"#;

/// A molecule that hits discs.
const MOLECULE: &str = r#"
    [[molecule]]
    tags = ["tee"]
    shape = "tee"
    atom_radius = 0.03
    atom_mass = 1.0
    at = [0.5, 0.5]
    [[gas]]
    tags = ["gas"]
    radius = 0.02
    mass = 1.0
    energy = 1.0
    area_fraction = 0.1
    [run]
    until = 3.0
    sample_interval = 0.05
    observe = ["directions:tee", "drift:tee", "contact-density:tee", "events:tee,gas"]
"#;

/// Points with names, on a logarithmic axis, and in small multiples.
const STUDY: &str = r#"
    replicas = 2
    measure = ["pressure", "correlation:gas"]
    [[vary]]
    key = "gas.0.atom_mass"
    from = 1.0
    to = 100.0
    steps = 3
    spacing = "logarithmic"
    [[vary]]
    keys = ["gas.0.shape", "gas.0.count"]
    values = [["disc", 60], ["rod:4", 20]]
    [[vary]]
    key = "box.sides"
    values = [[1.0, 1.0], [1.5, 0.8]]
    [[scene.gas]]
    tags = ["gas"]
    shape = "disc"
    atom_radius = 0.02
    energy = 1.0
    [scene.run]
    until = 4.0
    sample_interval = 0.05
"#;

/// Each contact doubles the speed, so the run ends with an error.
const FAILING: &str = r#"
    [[gas]]
    radius = 0.05
    mass = 1.0
    energy = 1.0
    count = 20
    [elasticity]
    default = 2.0
    [run]
    until = 100.0
    sample_interval = 0.05
    observe = ["pressure"]
"#;

#[test]
#[expect(clippy::too_many_lines, reason = "one course with many looks")]
fn nothing_is_cut_empty_or_broken_on_any_screen() {
    let test = concat!(
        module_path!(),
        "::nothing_is_cut_empty_or_broken_on_any_screen"
    );
    let Some(browser) = chromium::browser(test) else {
        return;
    };
    let carom = env!("CARGO_BIN_EXE_carom");
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    for (name, scene) in [("gas", GAS), ("molecule", MOLECULE), ("failing", FAILING)] {
        fs::write(folder.join(format!("{name}.toml")), scene).unwrap();
    }
    run(carom, folder, &["run", "gas.toml", "--out", "gas"], 0);
    run(
        carom,
        folder,
        &["run", "gas.toml", "--set", "box.replica=1", "--out", "gas1"],
        0,
    );
    run(
        carom,
        folder,
        &["merge", "gas", "gas1", "--out", "merged"],
        0,
    );
    run(
        carom,
        folder,
        &["run", "molecule.toml", "--out", "molecule"],
        0,
    );
    run(
        carom,
        folder,
        &["run", "failing.toml", "--out", "failing"],
        1,
    );
    fs::write(folder.join("study.toml"), STUDY).unwrap();
    run(carom, folder, &["sweep", "study.toml", "--out", "sweep"], 0);
    run(
        carom,
        folder,
        &["sweep", "study.toml", "--shard", "1/3", "--out", "shard"],
        0,
    );
    run(carom, folder, &["merge", "shard", "--out", "incomplete"], 3);
    let gas = [
        "--gas-radius",
        "0.02",
        "--side",
        "0.5",
        "--area-fraction",
        "0.3",
    ];
    let brownian = [
        "brownian",
        "tee",
        "--atom-radius",
        "0.01",
        "--from",
        "0.5",
        "--until",
        "3",
        "--out",
        "brownian",
    ];
    run(carom, folder, &[&brownian[..], &gas].concat(), 0);
    let billiard = [
        "billiard",
        "tee",
        "--atom-radius",
        "0.01",
        "--hits",
        "20000",
        "--out",
        "billiard",
    ];
    run(carom, folder, &billiard, 0);
    let names = [
        "gas",
        "merged",
        "molecule",
        "failing",
        "brownian",
        "billiard",
        "sweep",
        "incomplete",
    ];
    let page = |name: &&'static str| {
        (
            *name,
            fs::read_to_string(folder.join(name).join("report.html")).unwrap(),
        )
    };
    let pages: Vec<(&str, String)> = names.iter().map(page).collect();
    let mut found = Vec::new();
    for (name, seen) in looked_at(browser, &pages) {
        let charts = seen["charts"].as_u64().unwrap();
        assert!(
            charts >= if name.starts_with("gas") { 12 } else { 1 },
            "{name}: {charts} charts"
        );
        assert!(
            seen["words"].as_u64().unwrap() > 100 && seen["tables"].as_u64().unwrap() >= 3,
            "{name}"
        );
        let faults = seen["faults"].as_array().unwrap();
        found.extend(
            faults
                .iter()
                .map(|fault| format!("{name}: {}", fault.as_str().unwrap())),
        );
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// A page with one chart and one table.
fn planted(chart: &Chart, cell: &str) -> String {
    let mut page = Page::new("Planted", "A page with a fault.");
    page.pictures(Layout::Full, &[(&chart.svg().unwrap(), "A chart.")]);
    page.table(&["name", "value"], &[vec![cell.to_owned(), "1".to_owned()]]);
    page.html()
}

#[test]
fn planted_faults_are_found() {
    let test = concat!(module_path!(), "::planted_faults_are_found");
    let Some(browser) = chromium::browser(test) else {
        return;
    };
    let axis = |label: &str| Axis::new(label, (0.0, 1.0));
    let line = |points: &[(f64, f64)]| Layer {
        name: "measured".to_owned(),
        ink: Ink::Blue,
        shape: LayerShape::Line(points.to_vec()),
    };
    let chart =
        |points: &[(f64, f64)]| Chart::new("Chart", axis("x"), axis("y"), vec![line(points)]);
    let sound = planted(&chart(&[(0.0, 0.0), (1.0, 1.0)]), "word");
    let cut = sound.replacen(
        ">Chart<",
        ">A heading far too long for the chart that it is the heading of, so that it is cut at both of its \
         ends, whatever the size of the letters in which it is written<",
        1,
    );
    let narrow = "</style><style>table { min-width: 0; width: 1px; } td:first-child { overflow-wrap: anywhere; white-space: normal !important; }</style>";
    let broken = sound
        .replacen("</style>", narrow, 1)
        .replacen(">word<", ">unbreakable<", 1);
    let wide = sound.replacen("A page with a fault.", &"w".repeat(300), 1);
    let loud = sound.replacen(
        "</main>",
        "</main><script nonce=probe>console.error('a fault')</script>",
        1,
    );
    let pages = [
        ("sound", sound.clone()),
        ("cut label", cut),
        ("empty chart", planted(&chart(&[]), "word")),
        ("broken word", broken),
        ("wide page", wide),
        ("console", loud),
    ];
    for (name, html) in &pages[1..] {
        assert_ne!(*html, sound, "{name} is planted");
    }
    for (name, seen) in looked_at(browser, &pages) {
        let faults: Vec<&str> = seen["faults"]
            .as_array()
            .unwrap()
            .iter()
            .filter_map(Value::as_str)
            .collect();
        match pages[1..]
            .iter()
            .find(|(planted, _)| name.starts_with(planted))
        {
            Some((planted, _)) => {
                assert!(
                    faults.iter().any(|fault| fault.starts_with(planted)),
                    "{name}: {faults:?}"
                );
            }
            None => assert!(faults.is_empty(), "{name}: {faults:?}"),
        }
    }
}
