//! Starts from snapshots: bodies take the places, orientations and velocities of the file and
//! continue the run that wrote it; bad files are refused by line.

use carom::observers::write_extended_xyz;
use carom_engine::{Scene, Simulation, frame_of};
use glam::DVec2;

/// A scene with each kind of body: molecules free, locked and fixed, a bumper, a wall, two gases.
const ALL: &str = r#"
    [box]
    sides = [1.5, 1.0]
    seed = 4
    [[molecule]]
    shape = "tee"
    atom_radius = 0.02
    atom_mass = 0.5
    at = [0.3, 0.3]
    velocity = [0.5, -0.25]
    angular_velocity = 3.0
    [[molecule]]
    shape = "cross"
    atom_radius = 0.02
    atom_mass = 0.5
    at = [0.75, 0.25]
    rotation = "locked"
    [[molecule]]
    shape = "dumbbell"
    atom_radius = 0.02
    atom_mass = 1.0
    at = [0.5, 0.75]
    orientation = 0.3
    fixed = true
    [[bumper]]
    radius = 0.05
    at = [1.2, 0.75]
    [[wall]]
    y = 0.0
    [[gas]]
    radius = { uniform = [0.01, 0.02] }
    density = 1000.0
    temperature = 1.0
    count = 60
    [[gas]]
    shape = "dumbbell"
    atom_radius = 0.015
    atom_mass = 0.5
    temperature = 1.0
    count = 20
"#;

fn snapshot(simulation: &Simulation) -> String {
    let mut text = Vec::new();
    write_extended_xyz(&simulation.view(), &mut text).unwrap();
    String::from_utf8(text).unwrap()
}

fn from(scene: &str, text: &str) -> Scene {
    let mut scene = Scene::from_toml(scene).unwrap();
    scene.start.snapshot = Some(text.into());
    scene
}

/// Largest distances of places and velocities, and of orientations in turns.
fn differences(one: &Simulation, other: &Simulation) -> [f64; 4] {
    let sides = one.view().bounds().sides();
    let mut most = [0.0f64; 4];
    for (a, b) in one.view().bodies().zip(other.view().bodies()) {
        let apart = a.motion.position - b.motion.position;
        let turns = a.motion.orientation.turns() - b.motion.orientation.turns();
        // A disc has no orientation.
        let turned = if a.body.molecule().is_disc() {
            0.0
        } else {
            (turns - turns.round()).abs()
        };
        let all = [
            (apart - sides * (apart / sides).round()).length(),
            (a.motion.velocity - b.motion.velocity).length(),
            turned,
            (a.motion.angular_velocity - b.motion.angular_velocity).abs(),
        ];
        for (most, value) in most.iter_mut().zip(all) {
            *most = most.max(value);
        }
    }
    most
}

#[test]
fn a_run_continues_from_its_snapshot() {
    let mut first = Simulation::new(&Scene::from_toml(ALL).unwrap()).unwrap();
    first.run_until(0.3).unwrap();
    let text = snapshot(&first);
    let mut second = Simulation::new(&from(ALL, &text)).unwrap();
    let [place, velocity, turned, spin] = differences(&first, &second);
    assert!(place < 1e-15 && turned < 1e-15, "{place:e} {turned:e}");
    assert!(velocity < 1e-13 && spin < 1e-11, "{velocity:e} {spin:e}");
    // The two runs differ by rounding, which collisions amplify.
    first.run_until(0.31).unwrap();
    let collisions = first.view().counters().collisions;
    second.run_until(0.01).unwrap();
    assert!(second.view().counters().collisions > 5 && collisions > 5);
    let [place, velocity, ..] = differences(&first, &second);
    assert!(place < 1e-9 && velocity < 1e-6, "{place:e} {velocity:e}");
    // Twice the same text: the same bits.
    let mut third = Simulation::new(&from(ALL, &text)).unwrap();
    third.run_until(0.01).unwrap();
    assert_eq!(differences(&second, &third), [0.0; 4]);
}

#[test]
fn a_gas_of_discs_continues_to_the_bit() {
    let gas = "[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 200\n";
    let mut first = Simulation::new(&Scene::from_toml(gas).unwrap()).unwrap();
    first.run_until(0.2).unwrap();
    let second = Simulation::new(&from(gas, &snapshot(&first))).unwrap();
    assert_eq!(differences(&first, &second), [0.0; 4]);
    assert_eq!(
        first.view().energy().to_bits(),
        second.view().energy().to_bits()
    );
}

/// A snapshot with other columns, as of another program: the rows of the atoms that move, after
/// `columns` of each row.
fn reduced(text: &str, properties: &str, columns: impl Fn(&[&str]) -> String) -> String {
    let rows: Vec<String> = text
        .lines()
        .skip(2)
        .map(|line| line.split_whitespace().collect::<Vec<_>>())
        .filter(|words| words[0] != "X")
        .map(|words| columns(&words))
        .collect();
    let lattice = "Lattice=\"1.5 0.0 0.0 0.0 1.0 0.0 0.0 0.0 1.0\"";
    format!(
        "{}\n{lattice} Properties={properties} pbc=\"T T F\"\n{}\n",
        rows.len(),
        rows.join("\n")
    )
}

#[test]
fn orientations_and_velocities_follow_from_those_of_the_atoms() {
    let mut first = Simulation::new(&Scene::from_toml(ALL).unwrap()).unwrap();
    first.run_until(0.3).unwrap();
    // Atoms wrapped into the box one by one, and momenta instead of velocities, as ASE writes them.
    let text = reduced(
        &snapshot(&first),
        "species:S:1:pos:R:3:momenta:R:3",
        |words| {
            let number = |index: usize| words[index].parse::<f64>().unwrap();
            let (x, y, mass) = (
                number(1).rem_euclid(1.5),
                number(2).rem_euclid(1.0),
                number(12),
            );
            format!(
                "Ar {x:?} {y:?} 0.0 {:?} {:?} 0.0",
                mass * number(4),
                mass * number(5)
            )
        },
    );
    let second = Simulation::new(&from(ALL, &text)).unwrap();
    let [place, velocity, turned, spin] = differences(&first, &second);
    assert!(place < 1e-14 && turned < 1e-13, "{place:e} {turned:e}");
    assert!(velocity < 1e-12 && spin < 1e-10, "{velocity:e} {spin:e}");
}

#[test]
fn velocities_that_the_file_lacks_are_drawn() {
    let mut first = Simulation::new(&Scene::from_toml(ALL).unwrap()).unwrap();
    let drawn = first.clone();
    first.run_until(0.3).unwrap();
    let text = reduced(&snapshot(&first), "species:S:1:pos:R:3", |words| {
        words[..4].join(" ")
    });
    let second = Simulation::new(&from(ALL, &text)).unwrap();
    let [place, velocity, turned, _] = differences(&first, &second);
    assert!(place < 1e-13 && turned < 1e-12, "{place:e} {turned:e}");
    assert!(velocity > 1.0);
    // They are those of the start on a lattice, with the energy and temperature of the scene.
    let [_, velocity, _, spin] = differences(&drawn, &second);
    assert_eq!([velocity, spin], [0.0; 2]);
}

fn refusal(scene: &str, text: &str) -> String {
    let frame = frame_of(text, None).unwrap();
    Simulation::new(&from(scene, frame))
        .map(|_| ())
        .expect_err("refused")
        .to_string()
}

#[test]
fn bad_snapshots_are_refused_by_line() {
    let scene = "[[gas]]\nradius = 0.1\nmass = 1.0\nenergy = 1.0\ncount = 2\n";
    let head = "Lattice=\"1 0 0 0 1 0 0 0 1\" Properties=species:S:1:pos:R:3";
    let good = format!("2\n{head}\nH 0.25 0.5 0\nH 0.75 0.5 0\n");
    assert!(Simulation::new(&from(scene, &good)).is_ok());
    for (from, to, expected) in [
        (
            "H 0.75",
            "H 0.35",
            "start.from: gas[0] of line 3 and gas[0] of line 4 overlap by 0.1",
        ),
        (
            "H 0.75",
            "H 1.15",
            "start.from: gas[0] of line 3 and gas[0] of line 4 overlap",
        ),
        (
            "H 0.75",
            "H 2.75",
            "line 4: [2.75, 0.5] is more than a side of the box away",
        ),
        (
            "H 0.75",
            "H NaN",
            "line 4: a finite number is expected, not \"NaN\"",
        ),
        (
            "1 0 0 0 1",
            "1 0 0 0 2",
            "line 2: the box of the file is 1 × 2, that of the scene 1 × 1",
        ),
        ("2\nL", "1\nL", "the number of atoms is expected"),
    ] {
        let text = good.replacen(from, to, 1);
        let message = match frame_of(&text, None) {
            Ok(_) => refusal(scene, &text),
            Err(problem) => problem,
        };
        assert!(message.contains(expected), "{to}: {message}");
    }
    let one = format!("1\n{head}\nH 0.25 0.5 0\n");
    assert!(
        refusal(scene, &one)
            .contains("line 1: the file has 1 atoms, the bodies of the scene have 2")
    );
    let radii = format!("2\n{head}:radius:R:1\nH 0.25 0.5 0 0.1\nH 0.75 0.5 0 0.2\n");
    assert!(refusal(scene, &radii).contains("line 4: the radius is 0.2, in the scene 0.1"));
    let fast = format!("2\n{head}:vel:R:3\nH 0.25 0.5 0 1e70 0 0\nH 0.75 0.5 0 0 0 0\n");
    assert!(refusal(scene, &fast).contains("start.from, line 3: the velocity must be"));
    let dumbbell = "[[gas]]\nshape = \"dumbbell\"\natom_radius = 0.1\natom_mass = 1.0\nenergy = 1.0\ncount = 1\n";
    assert!(refusal(dumbbell, &good).contains("away from its place in the molecule of line 3"));
    let bumper = format!(
        "[[bumper]]\nradius = 0.1\nat = [0.25, 0.6]\n{}",
        scene.replace("= 2", "= 1")
    );
    assert!(refusal(&bumper, &good).contains("line 3: a fixed body has another place"));
    let mut grown = from(scene, &good);
    grown.start.relax = Some(1.0);
    assert!(
        Simulation::new(&grown)
            .unwrap_err()
            .to_string()
            .contains("either `from`, or `placement`")
    );
    let unread = Scene::from_toml(&format!("[start]\nfrom = \"end.extxyz\"\n{scene}")).unwrap();
    assert!(
        Simulation::new(&unread)
            .unwrap_err()
            .to_string()
            .contains("has not been read")
    );
    assert_eq!(Scene::from_toml(&unread.to_toml()).unwrap(), unread);
}

#[test]
fn a_dumbbell_across_the_border_is_put_together() {
    let scene = "[[gas]]\nshape = \"dumbbell\"\natom_radius = 0.1\natom_mass = 1.0\nenergy = 1.0\ncount = 1\n";
    let text = "2\n\nH 0.95 0.5 0\nH 0.15 0.5 0\n";
    let simulation = Simulation::new(&from(scene, text)).unwrap();
    let motion = simulation.view().bodies().next().unwrap().motion;
    assert!(
        (motion.position - DVec2::new(0.05, 0.5)).length() < 1e-15,
        "{}",
        motion.position
    );
    assert!(motion.orientation.turns().abs() < 1e-15);
}
