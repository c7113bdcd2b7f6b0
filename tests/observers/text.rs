//! Output formats: extended XYZ and a picture of a sample, read back.

use std::{fs, path::Path};

use carom::{
    Scene, Simulation,
    engine::{BumperSpec, GasSpec, MoleculeSpec, WallSpec},
    observers::{picture, write_extended_xyz},
};
use glam::DVec2;

use super::{disc, gas, tee};

/// One frame of extended XYZ.
struct Frame {
    lattice: Vec<f64>,
    time: f64,
    species: Vec<String>,
    /// The rows, without the species.
    rows: Vec<Vec<f64>>,
}

/// Reads frames back, with the columns given by `Properties`.
fn parse_frames(text: &str) -> Vec<Frame> {
    let mut lines = text.lines();
    let mut frames = Vec::new();
    while let Some(count) = lines.next() {
        let header = lines.next().unwrap();
        let quoted = |name: &str| {
            let from = header.find(&format!("{name}=\"")).unwrap() + name.len() + 2;
            header[from..].split('"').next().unwrap()
        };
        let plain = |name: &str| {
            let from = header.find(&format!(" {name}=")).unwrap() + name.len() + 2;
            header[from..].split(' ').next().unwrap()
        };
        assert_eq!(quoted("pbc"), "T T F");
        assert!(plain("Properties").starts_with(
            "species:S:1:pos:R:3:velo:R:3:molecule_id:I:1:atom:I:1:radius:R:1:angle:R:1"
        ));
        let fields: Vec<&str> = plain("Properties").split(':').collect();
        let columns: usize = fields
            .chunks(3)
            .map(|field| field[2].parse::<usize>().unwrap())
            .sum();
        let (mut species, mut rows) = (Vec::new(), Vec::new());
        for _ in 0..count.parse::<usize>().unwrap() {
            let mut row = lines.next().unwrap().split(' ');
            species.push(row.next().unwrap().to_owned());
            rows.push(
                row.map(|number| number.parse().unwrap())
                    .collect::<Vec<f64>>(),
            );
            assert_eq!(rows.last().unwrap().len(), columns - 1);
        }
        let lattice = quoted("Lattice")
            .split(' ')
            .map(|number| number.parse().unwrap())
            .collect();
        frames.push(Frame {
            lattice,
            time: plain("Time").parse().unwrap(),
            species,
            rows,
        });
    }
    frames
}

#[test]
fn extended_xyz_reads_back_to_the_bit() {
    let mut scene = Scene {
        molecule: vec![MoleculeSpec {
            velocity: [0.3, -0.2],
            angular_velocity: 2.0,
            ..tee(DVec2::new(0.5, 0.5), 0.7)
        }],
        ..Scene::default()
    };
    scene.bounds.sides = [1.0, 1.5];
    scene.bumper.push(BumperSpec {
        tags: vec![],
        radius: 0.03,
        at: [0.1, 0.1],
    });
    scene.gas.push(GasSpec {
        shape: Some("disc".into()),
        ..gas("gas", 30)
    });
    let mut simulation = Simulation::new(&scene).unwrap();
    let mut text = Vec::new();
    for time in [0.0, 1.0 / 3.0, 1.0 / 3.0 + 1e-7] {
        simulation.run_until(time).unwrap();
        write_extended_xyz(&simulation.view(), &mut text).unwrap();
    }
    let frames = parse_frames(std::str::from_utf8(&text).unwrap());
    assert_eq!(
        frames.iter().map(|frame| frame.time).collect::<Vec<_>>(),
        [0.0, 1.0 / 3.0, 1.0 / 3.0 + 1e-7]
    );
    for frame in &frames {
        assert_eq!(
            frame.lattice,
            [1.0, 0.0, 0.0, 0.0, 1.5, 0.0, 0.0, 0.0, 0.06]
        );
        assert_eq!(frame.rows.len(), 5 + 1 + 30);
        let (fixed, moving): (Vec<_>, Vec<_>) =
            frame.species.iter().partition(|species| *species == "X");
        assert_eq!(
            (fixed.len(), moving.iter().all(|species| *species == "H")),
            (1, true)
        );
        // The coordinate z and its velocity.
        assert!(frame.rows.iter().all(|row| row[2] == 0.0 && row[5] == 0.0));
        // Kinds: tee, bumper, gas.
        let kinds: Vec<f64> = frame.rows.iter().map(|row| row[12]).collect();
        assert_eq!(
            (kinds[0], kinds[4], kinds[5], kinds[6], kinds[35]),
            (0.0, 0.0, 1.0, 2.0, 2.0)
        );
        for row in &frame.rows {
            assert_eq!(
                [row[13], row[14], row[15], row[16]],
                [row[11] * row[3], row[11] * row[4], 0.0, row[11]]
            );
        }
    }
    let comment = std::str::from_utf8(&text).unwrap().lines().nth(1).unwrap();
    assert!(comment.contains("Kinds=\"tee fixed gas\""), "{comment}");
    // The last frame against its view: discs to the bit, atoms of the tee to rounding.
    let last = &frames[2];
    let view = simulation.view();
    let bodies: Vec<_> = view.bodies().collect();
    for (row, body) in last.rows[6..].iter().zip(&bodies[2..]) {
        let motion = body.motion;
        assert_eq!([row[0], row[1]], motion.position.to_array());
        assert_eq!([row[3], row[4]], motion.velocity.to_array());
        assert_eq!(
            [row[6], row[7], row[8], row[11]],
            [body.body.id() as f64, 0.0, 0.02, 1.0]
        );
        assert_eq!(row[9], motion.orientation.radians());
    }
    let tee = bodies[0].motion;
    for (index, row) in last.rows[..5].iter().enumerate() {
        let offset = bodies[0].body.molecule().atoms()[index].offset();
        let place = tee.position + DVec2::from_angle(tee.orientation.radians()).rotate(offset);
        assert!(
            (DVec2::new(row[0], row[1]) - place).length() < 1e-15,
            "atom {index}"
        );
        assert_eq!([row[6], row[7], row[8]], [0.0, index as f64, 0.01]);
        assert_eq!(
            [row[9], row[10], row[11]],
            [tee.orientation.radians(), tee.angular_velocity, 2.0]
        );
    }
}

#[test]
fn boxes_crossed_undo_the_jumps_of_positions_in_extended_xyz() {
    // A disc that crosses the border at x = 1 twice and that at y = 0 once.
    let molecule = vec![disc(
        DVec2::new(0.5, 0.25),
        DVec2::new(2.0, -0.5),
        0.05,
        3.0,
    )];
    let mut simulation = Simulation::new(&Scene {
        molecule,
        ..Scene::default()
    })
    .unwrap();
    let mut text = Vec::new();
    for time in [0.0, 1.0] {
        simulation.run_until(time).unwrap();
        write_extended_xyz(&simulation.view(), &mut text).unwrap();
    }
    let frames = parse_frames(std::str::from_utf8(&text).unwrap());
    let [start, end] = [&frames[0].rows[0], &frames[1].rows[0]];
    assert_eq!(
        (&start[17..20], &end[17..20]),
        (&[0.0; 3][..], &[2.0, -1.0, 0.0][..])
    );
    for (axis, moved) in [2.0, -0.5].into_iter().enumerate() {
        assert!((end[axis] + end[17 + axis] - start[axis] - moved).abs() < 1e-15);
    }
}

#[test]
fn velocities_in_extended_xyz_are_those_of_the_atoms() {
    // A tee that turns without other bodies: the difference quotient of the positions of its atoms
    // over a short time.
    let spinning = MoleculeSpec {
        velocity: [0.3, -0.2],
        angular_velocity: 2.0,
        ..tee(DVec2::new(0.5, 0.5), 0.7)
    };
    let mut simulation = Simulation::new(&Scene {
        molecule: vec![spinning],
        ..Scene::default()
    })
    .unwrap();
    let h = 1e-5;
    let mut text = Vec::new();
    for time in [0.4 - h, 0.4, 0.4 + h] {
        simulation.run_until(time).unwrap();
        write_extended_xyz(&simulation.view(), &mut text).unwrap();
    }
    let frames = parse_frames(std::str::from_utf8(&text).unwrap());
    for atom in 0..5 {
        let place =
            |frame: usize| DVec2::new(frames[frame].rows[atom][0], frames[frame].rows[atom][1]);
        let measured = (place(2) - place(0)) / (2.0 * h);
        let written = DVec2::new(frames[1].rows[atom][3], frames[1].rows[atom][4]);
        assert!(
            (measured - written).length() < 1e-9,
            "atom {atom}: {measured} against {written}"
        );
    }
    assert_ne!(
        frames[1].rows[0][3], frames[1].rows[4][3],
        "the atoms move differently"
    );
}

/// A line across the box, and a segment that reaches across its upper border.
fn walled() -> Scene {
    let segment = WallSpec {
        from: Some([0.25, 0.75]),
        to: Some([0.5, 1.25]),
        radius: 0.01,
        tags: vec!["<flap>".to_owned()],
        ..WallSpec::default()
    };
    let line = WallSpec {
        x: Some(0.75),
        ..WallSpec::default()
    };
    Scene {
        wall: vec![line, segment],
        gas: vec![gas("gas", 5)],
        ..Scene::default()
    }
}

#[test]
fn walls_are_in_the_comment_line_of_extended_xyz() {
    let simulation = Simulation::new(&walled()).unwrap();
    let mut text = Vec::new();
    write_extended_xyz(&simulation.view(), &mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    let frames = parse_frames(&text);
    assert_eq!(frames[0].rows.len(), 5, "only atoms have lines");
    // The middle of the segment, at (0.375, 1.0), is wrapped to (0.375, 0.0).
    let walls = "Walls=\"0.75 0.0 0.75 1.0 0.0 0.25 -0.25 0.5 0.25 0.01\"";
    assert!(text.lines().nth(1).unwrap().ends_with(walls), "{text}");
}

#[test]
fn pictures_of_the_chapter_on_shapes_are_current() {
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/book/src");
    let read = |name: &str| fs::read_to_string(book.join(name)).unwrap();
    let chapter = read("shapes.md");
    let mut listings = chapter.split("```toml\n").skip(1);
    for name in ["pictures/shapes.svg", "pictures/sides.svg"] {
        let scene = listings.next().and_then(|rest| rest.split("```").next());
        let scene = Scene::from_toml(scene.unwrap()).unwrap();
        let simulation = Simulation::new(&scene).unwrap();
        let renew = "copy `start.svg` of `carom run` with the listing";
        assert!(
            picture(&simulation.view(), 720) == read(name),
            "{name}: {renew}"
        );
    }
}

#[test]
fn walls_are_lines_of_the_picture_and_continue_across_the_border() {
    let simulation = Simulation::new(&walled()).unwrap();
    let svg = picture(&simulation.view(), 1000);
    assert!(
        svg.matches("<circle").count() >= 5 && !svg.contains("r=\"0.000\""),
        "{svg}"
    );
    // The segment in place and one box up, 20 pixels thick, y downwards.
    for [y1, y2] in [[1250.0, 750.0], [250.0, -250.0]] {
        let line = format!(
            "<line x1=\"250.000\" y1=\"{y1:.3}\" x2=\"500.000\" y2=\"{y2:.3}\" stroke=\"#4d4d4d\" stroke-width=\"20.000\""
        );
        assert!(svg.contains(&line), "{line} is not in\n{svg}");
    }
    assert!(svg.contains("x1=\"750.000\" y1=\"1000.000\" x2=\"750.000\" y2=\"0.000\""));
    assert_eq!(svg.matches("<line").count(), 3);
    assert!(svg.contains("&lt;flap&gt;"));
}

/// Centres and radii of the circles of an SVG of one box of `size` pixels, in box lengths, y
/// upwards.
fn circles(svg: &str, size: f64) -> Vec<(DVec2, f64)> {
    let number = |tag: &str, name: &str| -> f64 {
        let from = tag.find(&format!(" {name}=\"")).unwrap() + name.len() + 3;
        tag[from..].split('"').next().unwrap().parse().unwrap()
    };
    let circle = |tag: &str| {
        let (x, y, r) = (number(tag, "cx"), number(tag, "cy"), number(tag, "r"));
        (DVec2::new(x / size, 1.0 - y / size), r / size)
    };
    svg.split("<circle").skip(1).map(circle).collect()
}

#[test]
fn picture_shows_each_atom_and_its_images_across_borders() {
    let molecule = vec![
        disc(DVec2::new(0.5, 0.5), DVec2::ZERO, 0.05, 1.0),
        disc(DVec2::new(0.98, 0.5), DVec2::ZERO, 0.05, 1.0),
        disc(DVec2::new(0.5, 0.03), DVec2::ZERO, 0.05, 1.0),
        disc(DVec2::new(0.99, 0.98), DVec2::ZERO, 0.05, 1.0),
        // Near the corner, but the circle does not reach the point (0, 0).
        disc(DVec2::new(0.08, 0.08), DVec2::ZERO, 0.04, 1.0),
    ];
    let simulation = Simulation::new(&Scene {
        molecule,
        ..Scene::default()
    })
    .unwrap();
    let svg = picture(&simulation.view(), 1000);
    let seen = circles(&svg, 1000.0);
    let planted = [
        (0.5, 0.5),
        (0.98, 0.5),
        (-0.02, 0.5),
        (0.5, 0.03),
        (0.5, 1.03),
        (0.99, 0.98),
        (-0.01, 0.98),
        (0.99, -0.02),
        (-0.01, -0.02),
        (0.08, 0.08),
    ];
    assert_eq!(seen.len(), planted.len(), "{svg}");
    for (x, y) in planted {
        let at = DVec2::new(x, y);
        assert_eq!(
            seen.iter()
                .filter(|(place, _)| (place - at).length() < 1e-5)
                .count(),
            1,
            "({x}, {y})"
        );
    }
}

#[test]
fn picture_of_a_dense_gas_shows_all_images_that_reach_the_box() {
    let mut scene = Scene {
        molecule: vec![tee(DVec2::new(0.99, 0.995), 0.4)],
        ..Scene::default()
    };
    scene.molecule[0].tags = vec!["<tee> & co".into()];
    scene.gas.extend([gas("hot", 150), gas("cold", 150)]);
    let mut simulation = Simulation::new(&scene).unwrap();
    simulation.run_until(0.4).unwrap();
    let view = simulation.view();
    let mut expected = 0;
    for (centre, radius) in view
        .bodies()
        .flat_map(|body| body.atoms().collect::<Vec<_>>())
    {
        for image in 0..25 {
            let place = centre + DVec2::new(f64::from(image % 5 - 2), f64::from(image / 5 - 2));
            let nearest = place.clamp(DVec2::ZERO, DVec2::ONE);
            expected += usize::from(place.distance(nearest) < radius);
        }
    }
    let svg = picture(&view, 2000);
    assert!(expected > 305 + 20, "{expected}");
    assert_eq!(circles(&svg, 2000.0).len(), expected);
    // Three kinds of bodies, two of which differ only in their tag, have different colours. A tag's
    // name cannot break the document.
    let colours: Vec<&str> = svg
        .split("<g fill=\"")
        .skip(1)
        .map(|rest| &rest[..7])
        .collect();
    assert_eq!(colours.len(), 3);
    assert!(colours[0] != colours[1] && colours[1] != colours[2] && colours[2] != colours[0]);
    assert!(svg.contains("<title>&lt;tee&gt; &amp; co</title>"));
}
