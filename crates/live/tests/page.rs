//! The page in a browser without a window: what a user sees and does, on a running gas.

use std::{fs, net::Ipv4Addr, net::SocketAddr, path::Path, thread};

use crate::browser::Browser;
use carom::Scene;
use carom_live::{LaboratoryEnd, Server};
use carom_runs::{
    checkpoint_file,
    interruption::Signals,
    resumable::{CHECKPOINT, last_state},
    run,
};
use carom_testkit::chromium;
use clap::Parser;
use serde_json::json;

const GAS: &str = r#"
    [box]
    seed = 3
    [[molecule]]
    tags = ["tee"]
    shape = "tee"
    atom_radius = 0.02
    atom_mass = 1.0
    at = [0.5, 0.5]
    [[wall]]
    tags = ["wall"]
    from = [0.1, 0.9]
    to = [0.3, 0.95]
    [[gas]]
    tags = ["gas"]
    radius = 0.012
    mass = 1.0
    energy = 1.0
    count = 300
    [run]
    until = 2.0
    sample_interval = 0.05
    observe = ["energy"]
"#;

/// Elements of the page without an accessible name.
const NAMELESS: &str = "[...document.querySelectorAll('button, input, select, canvas, summary')]
    .filter((e) => !e.hasAttribute('aria-hidden') && !(e.labels && e.labels.length) && !e.getAttribute('aria-label') && !e.textContent.trim())
    .map((e) => e.outerHTML).join()";

/// Functions for the expressions of these tests.
const HELPERS: &str = "void (window.picture = () => document.getElementById('bodies-canvas').toDataURL(),
    window.text = (id) => document.getElementById(id).textContent,
    window.press = (id) => document.getElementById(id).click(),
    window.key = (key) => document.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true })),
    window.put = (id, value) => { const e = document.getElementById(id); e.value = value;
        e.dispatchEvent(new Event('input')); e.dispatchEvent(new Event('change')); })";

#[derive(Debug, Parser)]
struct Run {
    #[command(flatten)]
    options: run::RunOptions,
}

/// Runs a scene file to its end and returns the bytes of its last state.
fn end_of(scene: &Path, out: &Path, more: &[&str]) -> Vec<u8> {
    let words = [
        "run",
        scene.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
    ];
    run::run(&Run::parse_from(words.iter().chain(more)).options).unwrap();
    checkpoint_file::encode(&last_state(&out.join(CHECKPOINT)).unwrap().state).unwrap()
}

/// Rules between tags, and velocities drawn from Maxwell's distribution.
fn sets_rules_and_draws_velocities(page: &mut Browser) {
    // A rule between two tags, which is replaced and dropped.
    for elasticity in ["0.7", "0.6"] {
        page.eval(&format!(
            "put('rule-a', 'tee'); put('rule-b', 'gas'); put('rule-e', {elasticity}); press('set-rule')"
        ));
        page.until(&format!(
            "text('rules') === 'tee with gas: {elasticity} Remove'"
        ));
    }
    page.eval("document.querySelector('#rules button').click()");
    page.until("text('rules') === '' && text('message').startsWith('Rule removed')");
    assert_eq!(
        page.eval("text('elasticity-text')"),
        "1",
        "the elasticity of all others is kept"
    );
    // Two edits at once, before the state after the first is reported: neither undoes the other.
    page.eval(
        "put('tag', 'gas'); put('tag-energy', 1); press('hold'); put('tag', 'tee'); press('hold');
         put('rule-a', 'tee'); put('rule-e', 0.5); press('set-rule'); put('rule-a', 'gas'); press('set-rule')",
    );
    page.until(
        "text('tags').match(/kept at 1 by a thermostat/g)?.length === 2 && document.querySelectorAll('#rules li').length === 2",
    );
    page.eval("press('release'); put('tag', 'gas'); press('release')");
    // The focus stays where rules are dropped.
    for left in [1, 0] {
        page.eval(
            "document.querySelector('#rules button').focus(); document.activeElement.click()",
        );
        page.until(&format!(
            "document.querySelectorAll('#rules button').length === {left}"
        ));
        let focus = if left > 0 {
            "#rules button"
        } else {
            "#set-rule"
        };
        assert_eq!(
            page.eval(&format!(
                "document.activeElement === document.querySelector('{focus}')"
            )),
            true
        );
    }
    page.until("!text('tags').includes('kept')");
    page.eval("press('release')");
    page.until("text('message') === 'Refused: no thermostat acts on gas'");
    // After Back, the slider shows the elasticity of the bookmark even if it has the focus.
    page.eval("press('bookmark')");
    page.until("text('message').startsWith('Bookmark')");
    page.eval("document.getElementById('elasticity').focus(); put('elasticity', 0.95)");
    page.until("text('message').startsWith('Elasticity 0.95 at')");
    page.eval("press('back')");
    page.until(
        "document.getElementById('elasticity').value === '1' && text('elasticity-text') === '1'",
    );
    assert_eq!(page.eval("document.activeElement.id"), "elasticity");
    // Velocities drawn from Maxwell's distribution.
    page.eval(
        "put('tag', 'gas'); put('heat-kind', 'maxwell'); put('tag-energy', 2); press('set-energy')",
    );
    page.until(
        "text('message').startsWith('Velocities of gas drawn at kT = 2') && Number(text('energy')) > 500",
    );
}

/// A wall is chosen by keys, has an outline, and is announced; what is removed is no longer chosen.
fn chooses_walls_by_keys(page: &mut Browser) {
    page.until("text('rate') === 'paused' && text('about').includes('No body is chosen')");
    page.eval("window.before = document.getElementById('over').toDataURL(); key('p')");
    page.until("text('about').startsWith('wall') && text('about').includes('fixed')");
    assert_eq!(
        page.eval("text('announcement')"),
        "Chosen: wall 1, tags wall, fixed"
    );
    page.until("document.getElementById('over').toDataURL() !== before");
    keep_picture(page, "live-chosen-wall");
    // Energy cannot be set, in words, and the tag of the edit does not remain.
    page.eval("press('heat-body')");
    page.until("text('message').includes('fixed: they have no energy')");
    page.until("!text('tags').includes('body-1')");
    // Tags come and go.
    page.eval("put('body-tag', 'mine'); press('tag-body')");
    page.until("text('about').includes('wall, mine')");
    page.eval("press('untag-body')");
    page.until("!text('about').includes('mine')");
    page.eval("press('untag-body')");
    page.until("text('message').includes('does not have the tag “mine”')");
    page.eval("press('tag-body')");
    page.until("[...document.getElementById('tag').options].some(({ value }) => value === 'mine')");
    page.eval("put('tag', 'mine'); press('untag')");
    page.until("!text('about').includes('mine')");
    page.eval("put('tag', 'wall'); press('remove')");
    page.until("text('about') === 'Body 1 is no longer there.'");
    page.until(
        "document.getElementById('chosen-view').hidden && document.querySelector('.chosen').hidden",
    );
    assert_eq!(
        page.eval("document.getElementById('follow').disabled"),
        true
    );
    // A wall with a temperature.
    page.eval(
        "put('shape', 'wall'); put('at-x', 0.1); put('at-y', 0.9); put('to-x', 0.3); put('to-y', 0.95);
         put('wall-kt', -1); press('place')",
    );
    page.until("text('message').startsWith('Refused') && text('message').includes('temperature')");
    page.eval("put('wall-kt', 2); press('place')");
    page.until("text('tags').includes('new')");
    page.eval("put('tag', 'new'); press('remove')");
    page.until("!text('tags').includes('new')");
    // Walls are no bodies.
    assert_eq!(page.eval("text('bodies')"), "301");
}

/// Texts that are read out do not change while the gas runs, and what has not changed is not
/// written.
fn is_quiet(page: &mut Browser) {
    page.eval(
        "window.written = [];
         window.watch = new MutationObserver((all) => written.push(...all.map(({ target }) => target.id)));
         document.querySelectorAll('[aria-live], [role=status], [role=alert], output, #elasticity-text, #play, #rules')
             .forEach((e) => watch.observe(e, { childList: true, characterData: true, subtree: true }))",
    );
    page.eval("new Promise((done) => setTimeout(done, 1500))");
    assert_eq!(page.eval("watch.disconnect(), written.join()"), "");
}

/// The picture comes back after the graphics driver has taken its context away.
fn survives_a_lost_context(page: &mut Browser) {
    let has_lost = page.eval(
        "(window.context = document.getElementById('bodies-canvas').getContext('webgl2')) !== null
         && (context = context.getExtension('WEBGL_lose_context')) !== null && (context.loseContext(), true)",
    );
    if has_lost == true {
        page.until("document.getElementById('bodies-canvas').getContext('webgl2').isContextLost()");
        page.eval("context.restoreContext()");
        page.until("!document.getElementById('bodies-canvas').getContext('webgl2').isContextLost() && picture().length > 10000");
        page.faults.retain(|fault| !fault.contains("CONTEXT_LOST"));
    }
}

/// A second page watches on its own.
fn another_page_watches(program: &str, address: &str) {
    let mut page = Browser::start(program);
    page.show([1280, 800], false);
    page.call("Page.navigate", &json!({ "url": address }));
    page.until(
        "document.readyState === 'complete' && document.getElementById('bodies').textContent === '301'",
    );
    page.eval(HELPERS);
    page.until("text('message').startsWith('Another page controls the run')");
    assert_eq!(
        page.eval("document.getElementById('play').matches(':disabled')"),
        true
    );
    page.eval("key('n')");
    page.until("text('about').includes('tee') && text('about').includes('speed')");
    page.eval("press('follow'); press('closer')");
    page.until("document.getElementById('follow').ariaPressed === 'true'");
    assert_eq!(
        page.eval("document.getElementById('remove-body').matches(':disabled')"),
        true
    );
    page.eval("document.getElementById('unchoose').focus(); press('unchoose')");
    page.until(
        "text('about').includes('No body is chosen') && document.activeElement.id === 'over'",
    );
    assert_eq!(page.faults, Vec::<String>::new());
}

/// A server, and a browser with its page.
struct Opened {
    page: Browser,
    signals: Signals,
    served: thread::JoinHandle<anyhow::Result<LaboratoryEnd>>,
    /// The folder of the server, which is removed at the end.
    _root: tempfile::TempDir,
}

impl Opened {
    /// Stops the server; the browser keeps its page.
    fn stop(self) -> Browser {
        self.signals.interrupt();
        self.served.join().unwrap().unwrap();
        self.page
    }
}

/// Opens the page of a server that has no scene, the gallery. Without a browser there is none, and
/// the test of `what` counts as skipped.
fn gallery(what: &str) -> Option<Opened> {
    let program = chromium::browser(what)?;
    let root = tempfile::tempdir().unwrap();
    let signals = Signals::default();
    let any = SocketAddr::new(Ipv4Addr::LOCALHOST.into(), 0);
    let server = Server::bind(any, root.path(), signals.clone()).unwrap();
    let address = server.address_for_once().unwrap();
    let served = thread::spawn(move || server.serve(None));
    let mut page = Browser::start(program);
    page.call("Page.navigate", &json!({ "url": address }));
    page.until(
        "document.readyState === 'complete' && document.querySelectorAll('#gallery button').length > 5",
    );
    page.eval(HELPERS);
    Some(Opened {
        page,
        signals,
        served,
        _root: root,
    })
}

#[test]
fn controls_work_while_a_scene_is_open_and_the_server_is_there() {
    let Some(mut opened) = gallery("the controls of carom live") else {
        return;
    };
    let page = &mut opened.page;
    let disabled = "[...document.querySelectorAll('.writes')].map((part) => part.disabled).join()";
    assert_eq!(page.eval(disabled), "true,true,true,true,true");
    page.eval("[...document.querySelectorAll('#gallery button')].find((e) => e.textContent.includes('sinai')).click()");
    page.until("text('bodies') === '2'");
    page.until(&format!("{disabled} === 'false,true,false,false,false'"));
    // The selector shows the open scene, and leads to the gallery and back.
    let scene = "document.getElementById('scene').value";
    page.until(&format!("{scene} === 'sinai'"));
    page.eval("put('scene', '*')");
    page.until("!document.getElementById('gallery').hidden");
    assert_eq!(page.eval(scene), "sinai");
    page.eval("press('leave-gallery')");
    page.until("document.getElementById('gallery').hidden");
    page.eval("key('n')");
    page.until("text('about').startsWith('body')");
    assert_eq!(page.faults, Vec::<String>::new());
    let mut page = opened.stop();
    page.until("text('title') === 'not connected'");
    assert_eq!(page.eval(disabled), "true,true,true,true,true");
    page.eval("key('b')");
    page.until("text('message') === 'Refused: the page is not connected'");
}

#[test]
fn a_scene_file_is_written_in_the_page_and_its_fault_is_shown_by_line() {
    let Some(mut opened) = gallery("the editor of carom live") else {
        return;
    };
    let page = &mut opened.page;
    page.eval("press('edit')");
    page.until("document.activeElement.id === 'scene-text'");
    assert_eq!(
        page.eval("document.getElementById('copy-link').hidden"),
        true
    );
    let gas = "[[gas]]\\nradius = 0.01\\nmass = 1.0\\nenergy = 1.0\\ncount = 20";
    page.eval(&format!(
        "put('scene-text', '{gas}\\nlevity = 1'); press('run-scene')"
    ));
    page.until("text('scene-fault').includes('levity')");
    let selected = "((e) => e.value.slice(e.selectionStart, e.selectionEnd))(document.getElementById('scene-text'))";
    assert_eq!(page.eval(selected), "levity = 1");
    page.eval(&format!("put('scene-text', '{gas}'); press('run-scene')"));
    page.until("text('bodies') === '20' && document.getElementById('editor').hidden");
    page.until("Number(text('time')) > 0");
    assert_eq!(page.faults, Vec::<String>::new());
    opened.stop();
}

/// An empty field does not count as 0.
fn refuses_empty_fields(page: &mut Browser) {
    for (field, button, name) in [
        ("tag-energy", "set-energy", "energy or kT"),
        ("tag-energy", "hold", "energy or kT"),
        ("rule-e", "set-rule", "elasticity between these tags"),
        ("at-x", "place", "x"),
    ] {
        page.eval(&format!(
            "document.getElementById('{field}').closest('details').open = true;
             window.before = document.getElementById('{field}').value; put('{field}', ''); press('{button}')"
        ));
        page.until(&format!(
            "text('message').startsWith('Refused: the field “{name}” must hold a number')"
        ));
        assert_eq!(page.eval("document.activeElement.id"), field);
        page.eval(&format!("put('{field}', before)"));
    }
    assert_eq!(page.eval("text('bodies')"), "301");
}

/// Writes what the page shows into the folder that the environment names, as base64.
fn keep_picture(page: &mut Browser, name: &str) {
    let Ok(folder) = std::env::var("CAROM_PICTURES") else {
        return;
    };
    let shot = page.call("Page.captureScreenshot", &json!({}));
    fs::write(
        format!("{folder}/{name}.base64"),
        shot["data"].as_str().unwrap(),
    )
    .unwrap();
}

/// On a phone the page scrolls, below numbers and messages.
fn keeps_numbers_in_sight(page: &mut Browser, height: u32) {
    page.eval("scrollTo(0, document.documentElement.scrollHeight)");
    page.until("scrollY > 1000");
    for id in ["numbers", "message"] {
        let place = format!("document.getElementById('{id}').getBoundingClientRect()");
        let [top, bottom] =
            ["top", "bottom"].map(|side| page.eval(&format!("{place}.{side}")).as_f64().unwrap());
        assert!(
            top >= 0.0 && bottom > top && bottom < 0.35 * f64::from(height),
            "{id}: {top} {bottom}"
        );
    }
}

#[test]
#[expect(clippy::too_many_lines, reason = "one course with many looks")]
fn a_user_watches_edits_and_saves_a_gas() {
    let Some(program) = chromium::browser("the page of carom live") else {
        return;
    };
    let root = tempfile::tempdir().unwrap();
    let signals = Signals::default();
    let any = SocketAddr::new(Ipv4Addr::LOCALHOST.into(), 0);
    let server = Server::bind(any, &root.path().join("saved"), signals.clone()).unwrap();
    let address = server.address().to_owned();
    let served = thread::spawn(move || {
        server.serve(Some(("gas".to_owned(), Scene::from_toml(GAS).unwrap())))
    });

    let mut page = Browser::start(program);
    page.show([1300, 850], false);
    page.call("Page.navigate", &json!({ "url": address }));
    page.until(
        "document.readyState === 'complete' && document.getElementById('bodies').textContent === '301'",
    );
    page.eval(HELPERS);
    // Slower than it could run, so that the run of its scene throughout takes no longer.
    page.eval("put('speed', 97)");
    // What belongs to a chosen body or to a bookmark is hidden without one, and the selector shows
    // the open scene.
    assert_eq!(
        page.eval(
            "['chosen-view', 'back', 'release'].map((id) => document.getElementById(id).hidden).join()"
        ),
        "true,true,true"
    );
    assert_eq!(
        page.eval("document.getElementById('scene').selectedOptions[0].textContent"),
        "gas"
    );
    // The picture moves while the gas runs, and stands while it is paused.
    page.until("picture().length > 10000");
    page.eval("press('play')");
    page.until("text('play') === 'Pause' && Number(text('time')) > 0.05");
    // The mean free time is some hundredths.
    page.until("/^\\d+\\.\\d{2,4}$/.test(text('time'))");
    page.eval("window.first = picture()");
    page.until("picture() !== first");
    page.eval("key(' ')");
    page.until("text('play') === 'Play' && text('rate') === 'paused'");
    let later = "new Promise((done) => setTimeout(() => done(picture() + text('time')), 400))";
    // A few frames may be under way.
    let mut pictures = (0..10).map(|_| page.eval(later)).collect::<Vec<_>>();
    pictures.dedup();
    assert!(
        pictures.len() < 5,
        "the picture stands while the run is paused"
    );

    // One contact; the colours of speeds; a body with its path.
    page.eval("press('one')");
    page.until("text('message').startsWith('One collision')");
    page.eval("window.first = picture(); put('colour', 'speed')");
    page.until("picture() !== first && text('legend').includes('speed')");
    page.eval("key('n')");
    page.until("text('about').includes('tee')");
    page.eval("press('follow')");

    // The slider changes the elasticity: the gas loses energy.
    page.eval("press('unchoose'); press('play')");
    page.until("Number(text('energy')) > 299");
    page.eval("put('elasticity', 0.4)");
    page.until("Number(text('energy')) < 150");
    page.eval("put('elasticity', 1)");
    page.until("text('message').startsWith('Elasticity 1 at')");

    sets_rules_and_draws_velocities(&mut page);

    refuses_empty_fields(&mut page);

    // An impossible edit is refused in words; a possible one is made.
    page.eval("put('shape', 'disc'); put('radius', 0.3); press('place')");
    page.until("text('message').startsWith('Refused') && text('message').includes('overlap')");
    assert_eq!(page.eval("text('bodies')"), "301");
    page.eval("press('play')");
    chooses_walls_by_keys(&mut page);
    survives_a_lost_context(&mut page);
    page.eval("press('play')");
    page.until("text('play') === 'Pause'");
    is_quiet(&mut page);
    another_page_watches(program, &address);

    // A measure grows, with its figures.
    page.eval("put('kind', 'temperature'); put('of', 'gas'); press('measure')");
    page.until("document.querySelectorAll('#measures svg path').length > 0");
    // One with a parameter, which is refused in words and then accepted.
    page.eval(
        "put('kind', 'correlation');
         window.max = document.querySelector('#parameters [data-parameter=max]'); max.value = -1; press('measure')",
    );
    page.until("text('message').startsWith('Refused') && text('message').includes('max')");
    page.eval("max.value = 0.2; press('measure')");
    page.until("document.querySelectorAll('#measures section').length === 2");
    // Its displacements are drawn by their logarithms, with powers beside them, and the velocities
    // over their value at 0.
    page.until(
        "text('measures').includes('thin: ∝ t²') && text('measures').includes('over its first value')",
    );
    page.until(
        "text('measures').includes('lag (time)') && !text('measures').includes('time (time)')",
    );
    assert_eq!(
        page.eval("text('saves').includes('begin anew there')"),
        true
    );

    // No part is wider than the page, and every control has a name, on all screens.
    for (size, is_dark) in [
        ([1280, 800], false),
        ([1280, 800], true),
        ([390, 844], false),
        ([390, 844], true),
    ] {
        page.show(size, is_dark);
        page.until("Number(text('frames')) >= 0 && picture().length > 1000");
        let width = page
            .eval("document.documentElement.scrollWidth")
            .as_u64()
            .unwrap();
        assert!(width <= u64::from(size[0]), "{width} at {size:?}");
        let ground = page
            .eval("getComputedStyle(document.body).backgroundColor")
            .as_str()
            .unwrap()
            .to_owned();
        assert_eq!(
            ground,
            if is_dark {
                "rgb(21, 24, 28)"
            } else {
                "rgb(251, 251, 249)"
            }
        );
        assert_eq!(page.eval(NAMELESS), "", "{size:?}");
        let canvas = page
            .eval("document.getElementById('over').clientHeight")
            .as_u64()
            .unwrap();
        assert!(canvas > 250, "{canvas} at {size:?}");
        keep_picture(
            &mut page,
            &format!(
                "live-{}-{}",
                size[0],
                if is_dark { "dark" } else { "light" }
            ),
        );
        if size[0] < 600 {
            keeps_numbers_in_sight(&mut page, size[1]);
            keep_picture(
                &mut page,
                &format!(
                    "live-{}-{}-end",
                    size[0],
                    if is_dark { "dark" } else { "light" }
                ),
            );
            page.eval("scrollTo(0, 0)");
        }
    }

    // A saved run resumes to the bit.
    page.eval("press('save')");
    page.until("text('saved').includes('--resume') && text('saved').includes('measured-before')");
    page.until("/^Saved at t = .*the page showed t = .*the series of the page continue/.test(text('message'))");
    assert_eq!(page.faults, Vec::<String>::new());
    drop(page);
    signals.interrupt();
    assert!(served.join().unwrap().unwrap().saved.is_some());
    let folder = root.path().join("saved/1");
    for file in ["temperature-gas.csv", "correlation-gas.csv", "figures.csv"] {
        assert!(folder.join("measured-before").join(file).exists(), "{file}");
    }
    let copy = root.path().join("copy.toml");
    fs::copy(folder.join("config.toml"), &copy).unwrap();
    let resumed = end_of(&folder.join("config.toml"), &folder, &["--resume"]);
    assert!(resumed == end_of(&copy, &root.path().join("throughout"), &[]));
}
