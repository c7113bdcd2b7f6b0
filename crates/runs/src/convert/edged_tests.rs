//! Snapshots of bodies with straight edges, as GSD and back.

use std::fs;

use carom::{Scene, observers::write_extended_xyz};
use carom_methods::AnySimulation;
use glam::DVec2;
use serde_json::Value;

use super::{
    convert,
    tests::{chunks, floats, integers},
};

/// A notched polygon that turns, a dumbbell with a bar, and a disc. The corners have a radius of
/// 1e-6.
const SCENE: &str = r#"
    [[molecule]]
    tags = ["ell"]
    polygon = [[0.0, 0.0], [0.3, 0.0], [0.3, 0.1], [0.1, 0.1], [0.1, 0.3], [0.0, 0.3]]
    rounding = "1e-6/(0.3*sqrt(2))"
    mass = 5.0
    at = [0.3, 0.4]
    velocity = [1.0, 2.0]
    angular_velocity = 3.0
    orientation = 0.7
    [[molecule]]
    tags = ["bar"]
    atoms = [
        { at = [0.0, 0.0], radius = 0.04, mass = 1.0 },
        { at = [0.2, 0.0], radius = 0.04, mass = 1.0 },
    ]
    edges = [[0, 1]]
    edge_radius = 0.02
    at = [0.7, 0.7]
    [[bumper]]
    radius = 0.05
    at = [0.9, 0.1]
"#;

fn simulation(scene: &str) -> AnySimulation {
    AnySimulation::new(&Scene::from_toml(scene).unwrap()).unwrap()
}

fn snapshot(simulation: &AnySimulation) -> String {
    let mut text = Vec::new();
    write_extended_xyz(&simulation.view(), &mut text).unwrap();
    String::from_utf8(text).unwrap()
}

#[test]
fn the_comment_line_lists_edges_by_kind() {
    let text = snapshot(&simulation(SCENE));
    let comment = text.lines().nth(1).unwrap();
    assert!(
        comment.contains(
            " Edges=\"0 0 1 1.0 0 1 2 1.0 0 2 3 1.0 0 3 4 1.0 0 4 5 1.0 0 5 0 1.0 1 0 1 0.5\" Solid=\"0 1\" \
             Uniform=\"0\""
        ),
        "{comment}"
    );
    let disc = snapshot(&simulation("[[bumper]]\nradius = 0.05\nat = [0.9, 0.1]\n"));
    assert!(!disc.contains("Edges") && !disc.contains("Solid"));
}

#[test]
fn bodies_with_edges_are_particles_with_polygons_in_gsd() {
    let folder = tempfile::tempdir().unwrap();
    let simulation = simulation(SCENE);
    let (input, output) = (
        folder.path().join("in.extxyz"),
        folder.path().join("out.gsd"),
    );
    fs::write(&input, snapshot(&simulation)).unwrap();
    convert(&input, &output).unwrap();
    let bytes = fs::read(&output).unwrap();
    let chunks = chunks(&bytes);
    // The L, its six corners, the bar, its two discs, and the bumper.
    assert_eq!(
        integers(&chunks, 0, "particles/typeid"),
        [0, 3, 3, 3, 3, 3, 3, 1, 4, 4, 2]
    );
    let texts = |name: &str| -> Vec<String> {
        let (_, rows, columns, data) = &chunks[&(0, name.to_owned())];
        let texts: Vec<String> = data
            .chunks(*columns as usize)
            .map(|row| {
                String::from_utf8_lossy(row)
                    .trim_end_matches('\0')
                    .to_owned()
            })
            .collect();
        assert_eq!(texts.len() as u64, *rows);
        texts
    };
    assert_eq!(
        texts("particles/types"),
        ["ell", "bar", "fixed", "ell.atom", "bar.atom"]
    );
    let shapes: Vec<Value> = texts("particles/type_shapes")
        .iter()
        .map(|text| serde_json::from_str(text).unwrap())
        .collect();
    assert_eq!(shapes[0]["type"], "Polygon");
    let rounding = shapes[0]["rounding_radius"].as_f64().unwrap();
    assert!((rounding - 1e-6).abs() < 1e-18, "{rounding}");
    let vertices = shapes[0]["vertices"].as_array().unwrap();
    assert_eq!(vertices.len(), 6);
    let view = simulation.view();
    let ell = view.bodies().next().unwrap().body.molecule();
    for (vertex, atom) in vertices.iter().zip(ell.atoms()) {
        let found = DVec2::new(vertex[0].as_f64().unwrap(), vertex[1].as_f64().unwrap());
        assert!(found.distance(atom.offset()) < 1e-7);
    }
    // Arcs of the two discs and the sides of the bar.
    assert!(shapes[1]["type"] == "Polygon" && shapes[1]["vertices"].as_array().unwrap().len() > 60);
    assert_eq!(shapes[3]["type"], "Sphere");
    assert_centres(&simulation, &chunks);
}

/// The particle of the L has the place, the velocity and the mass of the body.
fn assert_centres(simulation: &AnySimulation, chunks: &super::tests::Chunks) {
    let view = simulation.view();
    let body = view.bodies().next().unwrap();
    let place = floats(chunks, 0, "particles/position");
    let expected = body.motion.position - 0.5;
    assert!((f64::from(place[0]) - expected.x).abs() < 1e-6);
    assert!((f64::from(place[1]) - expected.y).abs() < 1e-6);
    let velocity = floats(chunks, 0, "particles/velocity");
    assert!((velocity[0] - 1.0).abs() < 1e-5 && (velocity[1] - 2.0).abs() < 1e-5);
    let masses = floats(chunks, 0, "particles/mass");
    assert!((masses[0] - 5.0).abs() < 1e-6);
}
