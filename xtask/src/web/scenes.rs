//! The scenes whose runs are compared between machines.

use anyhow::Result;
use carom_live::EXHIBITS;
use carom_runs::examples::Example;

/// The scene of a test of the Rust library, of the command and of Python, and the fingerprint of
/// its end.
pub const THREE_WAYS: (&str, &str) = (
    include_str!("../../../tests/data/three_ways.toml"),
    include_str!("../../../tests/data/three_ways.fingerprint"),
);

/// Shapes of gases that no scene of the gallery has, with their keys.
const SHAPES: [(&str, &str); 12] = [
    ("disc", "atom_radius = 0.015\natom_mass = 1.0"),
    ("dumbbell", "atom_radius = 0.01\natom_mass = 1.0"),
    ("rod:4", "atom_radius = 0.008\natom_mass = 1.0"),
    ("cross", "atom_radius = 0.008\natom_mass = 1.0"),
    ("tee", "atom_radius = 0.008\natom_mass = 1.0"),
    ("ring:8", "atom_radius = 0.006\natom_mass = 1.0"),
    ("capsule:2", "size = 0.02\nmass = 1.0"),
    ("square", "size = 0.03\nmass = 1.0"),
    ("rectangle:2", "size = 0.02\nmass = 1.0"),
    ("triangle", "size = 0.03\nmass = 1.0"),
    ("polygon:5", "size = 0.02\nmass = 1.0"),
    ("ellipse:2", "size = 0.02\nmass = 1.0"),
];

/// A gas of discs that grow from points until they are packed densely.
const GROWN: &str = r#"
[start]
placement = "grown"
[[gas]]
radius = 0.02
mass = 1.0
energy = 1.0
area_fraction = 0.7
[run]
until = 1.0
"#;

/// Discs between a heated wall and one that reflects.
const THERMAL_WALLS: &str = "
[[wall]]
x = 0.0
temperature = 2.0
[[wall]]
y = 0.0
[[gas]]
radius = 0.015
mass = 1.0
energy = 1.0
count = 200
[run]
until = 2.0
";

/// All scenes with their names: that of [`THREE_WAYS`] first, those of the gallery, and gases of
/// each shape.
///
/// # Errors
/// The gallery names a scene that is not an example.
pub fn all() -> Result<Vec<(String, String)>> {
    let mut all = vec![("three-ways".to_owned(), THREE_WAYS.0.to_owned())];
    for exhibit in EXHIBITS {
        let text = Example::named(exhibit.example)?.text;
        all.push((exhibit.name.to_owned(), text.to_owned()));
    }
    all.push(("grown".to_owned(), GROWN.to_owned()));
    all.push(("thermal-walls".to_owned(), THERMAL_WALLS.to_owned()));
    for (shape, keys) in SHAPES {
        let text = format!(
            "[[gas]]\nshape = \"{shape}\"\n{keys}\nenergy = 1.0\ncount = 80\n[run]\nuntil = 2.0\n"
        );
        all.push((shape.to_owned(), text));
    }
    Ok(all)
}
