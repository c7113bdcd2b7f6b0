//! Converted trajectories are read back by readers written here, number by number.

use std::{collections::HashMap, fs, path::PathBuf};

use super::*;

const HEAD: &str = "Lattice=\"2.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0 0.2\" Properties=species:S:1:pos:R:3:velo:R:3:\
                    molecule_id:I:1:atom:I:1:radius:R:1:angle:R:1:angular_velocity:R:1:mass:R:1:kind:I:1:\
                    map_shift:I:3 Kinds=\"rod wall+hot\" pbc=\"T T F\"";

/// A dumbbell at the border of the box and a fixed disc; in the second frame the dumbbell has
/// moved.
fn two_frames() -> String {
    format!(
        "3\n{HEAD} Time=0.0 Walls=\"0.5 0.0 0.5 1.0 0.0\"\n\
         H 1.95 0.25 0.0 0.1 -0.2 0.0 7 0 0.1 0.0 0.5 1.5 0 -3 1 0\n\
         H 2.05 0.25 0.0 0.1 0.3 0.0 7 1 0.1 0.0 0.5 1.5 0 -3 1 0\n\
         X 0.5 -0.125 0.0 0.0 0.0 0.0 9 0 0.05 0.0 0.0 1.0 1 0 0 0\n\
         3\n{HEAD} Time=0.1\n\
         H 0.1 0.3333333333333333 0.0 0.1 -0.2 0.0 7 0 0.1 1.5707963267948966 0.5 1.5 0 -3 1 0\n\
         H 0.1 0.4333333333333333 0.0 0.1 0.3 0.0 7 1 0.1 1.5707963267948966 0.5 1.5 0 -3 1 0\n\
         X 0.5 -0.125 0.0 0.0 0.0 0.0 9 0 0.05 0.0 0.0 1.0 1 0 0 0\n"
    )
}

/// Converts a text and returns the content of the output.
fn converted(text: &str, name: &str) -> Result<Vec<u8>> {
    let folder = tempfile::tempdir()?;
    let (input, output): (PathBuf, PathBuf) =
        (folder.path().join("in.extxyz"), folder.path().join(name));
    fs::write(&input, text)?;
    let result = convert(&input, &output);
    let files = fs::read_dir(folder.path())?.count();
    assert_eq!(
        files,
        if result.is_ok() { 2 } else { 1 },
        "nothing else is left behind"
    );
    result?;
    Ok(fs::read(output)?)
}

/// The chunks of a GSD file by frame and name: type, rows, columns, bytes.
pub(super) type Chunks = HashMap<(u64, String), (u8, u64, u32, Vec<u8>)>;

/// A strict reader of the GSD 2.0 file layer.
pub(super) fn chunks(file: &[u8]) -> Chunks {
    let u64_at = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().unwrap());
    let u32_at = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
    assert_eq!(
        (u64_at(0), u32_at(40), u32_at(44)),
        (0x65DF_65DF_65DF_65DF, 0x1_0004, 0x2_0000)
    );
    assert_eq!(&file[48 + 64..48 + 64 + 6], b"hoomd\0");
    let (index, entries) = (u64_at(8) as usize, u64_at(16) as usize);
    let (names_at, names_length) = (u64_at(24) as usize, 64 * u64_at(32) as usize);
    assert_eq!(names_at, index + 32 * entries);
    assert_eq!(names_at + names_length, file.len());
    assert_eq!(file.last(), Some(&0));
    let names: Vec<String> = file[names_at..]
        .split(|byte| *byte == 0)
        .take_while(|name| !name.is_empty())
        .map(|name| String::from_utf8(name.to_vec()).unwrap())
        .collect();
    let mut end = 256;
    let mut last = (0, 0);
    let mut found = Chunks::new();
    for entry in (0..entries).map(|entry| index + 32 * entry) {
        let id = u16::from_le_bytes(file[entry + 28..entry + 30].try_into().unwrap());
        let (frame, rows, at, columns) = (
            u64_at(entry),
            u64_at(entry + 8),
            u64_at(entry + 16) as usize,
            u32_at(entry + 24),
        );
        let kind = file[entry + 30];
        assert!(entry == index || (frame, id) > last, "entries are in order");
        last = (frame, id);
        let length =
            rows as usize * columns as usize * [0, 1, 2, 4, 8, 1, 2, 4, 8, 4, 8][kind as usize];
        assert!(at >= 256 && at + length <= index && file[entry + 31] == 0);
        end = end.max(at + length);
        let data = file[at..at + length].to_vec();
        found.insert(
            (frame, names[id as usize].clone()),
            (kind, rows, columns, data),
        );
    }
    assert_eq!(end, index, "there is no gap between data and index");
    found
}

pub(super) fn floats(chunks: &Chunks, frame: u64, name: &str) -> Vec<f32> {
    let (kind, .., data) = &chunks[&(frame, name.to_owned())];
    assert_eq!(*kind, 9, "{name}");
    data.chunks(4)
        .map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap()))
        .collect()
}

pub(super) fn integers(chunks: &Chunks, frame: u64, name: &str) -> Vec<i32> {
    let (kind, .., data) = &chunks[&(frame, name.to_owned())];
    assert!(*kind == 7 || *kind == 3, "{name}");
    data.chunks(4)
        .map(|bytes| i32::from_le_bytes(bytes.try_into().unwrap()))
        .collect()
}

#[test]
fn gsd_holds_the_atoms_in_a_box_about_the_origin() {
    let chunks = chunks(&converted(&two_frames(), "out.gsd").unwrap());
    assert_eq!(
        floats(&chunks, 0, "configuration/box"),
        [2.0, 1.0, 0.0, 0.0, 0.0, 0.0]
    );
    let places = floats(&chunks, 0, "particles/position");
    for (found, expected) in places
        .iter()
        .zip([0.95, -0.25, 0.0, -0.95, -0.25, 0.0, -0.5, 0.375, 0.0])
    {
        assert!((found - expected).abs() < 1e-7, "{places:?}");
    }
    assert_eq!(
        integers(&chunks, 0, "particles/image"),
        [-3, 1, 0, -2, 1, 0, 0, -1, 0]
    );
    assert_eq!(integers(&chunks, 0, "particles/body"), [7, 7, -1]);
    assert_eq!(integers(&chunks, 0, "particles/typeid"), [0, 0, 1]);
    assert_eq!(floats(&chunks, 0, "particles/diameter"), [0.2, 0.2, 0.1]);
    assert_eq!(floats(&chunks, 0, "particles/mass"), [1.5, 1.5, 1.0]);
    assert_eq!(
        floats(&chunks, 0, "particles/velocity")[..3],
        [0.1, -0.2, 0.0]
    );
    assert_eq!(
        chunks[&(0, "particles/types".to_owned())],
        (5, 2, 9, b"rod\0\0\0\0\0\0wall+hot\0".to_vec())
    );
    let (.., shapes) = &chunks[&(0, "particles/type_shapes".to_owned())];
    let shapes = String::from_utf8(shapes.clone()).unwrap();
    let expected =
        "{\"type\": \"Sphere\", \"diameter\": 0.2}\0{\"type\": \"Sphere\", \"diameter\": 0.1}\0";
    assert_eq!(shapes, expected);
    assert_eq!(chunks[&(0, "log/walls".to_owned())].1, 1);
    // A quarter turn; time with every digit; nothing twice.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    assert_eq!(
        floats(&chunks, 1, "particles/orientation")[..4],
        [half, 0.0, 0.0, half]
    );
    assert_eq!(chunks[&(1, "log/time".to_owned())].3, 0.1f64.to_le_bytes());
    assert_eq!(
        chunks[&(1, "configuration/step".to_owned())].3,
        1u64.to_le_bytes()
    );
    for name in [
        "particles/N",
        "particles/mass",
        "particles/types",
        "configuration/box",
        "log/walls",
    ] {
        assert!(!chunks.contains_key(&(1, name.to_owned())), "{name}");
    }
}

/// A box that a shear has tilted: each atom with its image is where it was.
#[test]
fn a_tilted_box_keeps_its_tilt() {
    let tilted = |tilt: &str| HEAD.replacen("2.0 0.0 0.0 0.0", &format!("2.0 0.0 0.0 {tilt}"), 1);
    let atoms = "H 0.1 0.9 0.0 0.0 0.0 0.0 7 0 0.1 0.0 0.0 1.5 0 -3 2 0\n\
        H 1.9 0.1 0.0 0.0 0.0 0.0 8 0 0.1 0.0 0.0 1.5 0 0 0 0\n";
    let frame = |tilt: &str, time: &str| format!("2\n{} Time={time}\n{atoms}", tilted(tilt));
    let text = frame("0.5", "0.0") + &frame("-0.75", "0.1");
    let lines = String::from_utf8(converted(&text, "out.lammpstrj").unwrap()).unwrap();
    for bounds in [
        "ITEM: BOX BOUNDS xy xz yz pp pp pp\n0.0 2.5 0.5\n0.0 1.0 0.0\n-0.1 0.1 0.0\n",
        "ITEM: BOX BOUNDS xy xz yz pp pp pp\n-0.75 2.0 -0.75\n0.0 1.0 0.0\n-0.1 0.1 0.0\n",
    ] {
        assert!(lines.contains(bounds), "{lines}");
    }
    let chunks = chunks(&converted(&text, "out.gsd").unwrap());
    for (frame, tilt) in [(0, 0.5_f32), (1, -0.75)] {
        assert_eq!(
            floats(&chunks, frame, "configuration/box"),
            [2.0, 1.0, 0.0, tilt, 0.0, 0.0]
        );
        let places = floats(&chunks, frame, "particles/position");
        let images = integers(&chunks, frame, "particles/image");
        for (atom, (place, expected)) in places
            .chunks(3)
            .zip([[0.1 - 6.0 + 2.0 * tilt, 2.9], [1.9, 0.1]])
            .enumerate()
        {
            // Within the parallelogram about the origin.
            assert!((place[0] - tilt * place[1]).abs() <= 1.0 && place[1].abs() <= 0.5);
            let [columns, rows] = [0, 1].map(|axis| images[3 * atom + axis] as f32);
            let found = [
                place[0] + 1.0 + 2.0 * columns + tilt * (rows + 0.5),
                place[1] + 0.5 + rows,
            ];
            for axis in 0..2 {
                // The origin of GSD is the middle of the parallelogram.
                let shift = if axis == 0 { 0.5 * tilt } else { 0.0 };
                let off = found[axis] - shift - expected[axis];
                assert!(off.abs() < 1e-5, "{frame} {atom}: {found:?}");
            }
        }
    }
}

#[test]
fn a_frame_of_another_number_of_atoms_is_whole() {
    let one =
        format!("1\n{HEAD} Time=0.2\nX 0.5 0.5 0.0 0.0 0.0 0.0 9 0 0.05 0.0 0.0 1.0 1 0 0 0\n");
    let chunks = chunks(&converted(&(two_frames() + &one), "out.gsd").unwrap());
    assert_eq!(integers(&chunks, 2, "particles/N"), [1]);
    for name in [
        "particles/mass",
        "particles/types",
        "particles/typeid",
        "particles/diameter",
    ] {
        assert!(chunks.contains_key(&(2, name.to_owned())), "{name}");
    }
}

#[test]
fn a_dump_keeps_every_digit() {
    let text = String::from_utf8(converted(&two_frames(), "out.lammpstrj").unwrap()).unwrap();
    let frames: Vec<&str> = text.split_inclusive("ITEM: TIMESTEP\n").skip(1).collect();
    let lines: Vec<&str> = frames[1].lines().collect();
    assert!(
        text.starts_with("ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n3\n"),
        "{text}"
    );
    assert_eq!(
        lines[..7],
        [
            "1",
            "ITEM: NUMBER OF ATOMS",
            "3",
            "ITEM: BOX BOUNDS pp pp pp",
            "0.0 2.0",
            "0.0 1.0",
            "-0.1 0.1"
        ]
    );
    assert_eq!(
        lines[7],
        "ITEM: ATOMS id mol type x y z ix iy iz vx vy vz radius mass angle omegaz v_time"
    );
    assert_eq!(
        lines[8],
        "1 7 1 0.1 0.3333333333333333 0.0 -3 1 0 0.1 -0.2 0.0 0.1 1.5 1.5707963267948966 0.5 0.1"
    );
    assert_eq!(
        lines[10],
        "3 9 2 0.5 -0.125 0.0 0 0 0 0.0 0.0 0.0 0.05 1.0 0.0 0.0 0.1"
    );
    assert_eq!((frames.len(), lines.len()), (2, 11));
}

#[test]
fn bad_input_is_refused_by_line_and_column() {
    let good = two_frames();
    let with = |old: &str, new: &str| good.replacen(old, new, 1);
    for (text, expected) in [
        (String::new(), "the file is empty"),
        (with("3\n", "three\n"), "line 1: 'three' is not the number"),
        (with("H 2.05", "H nan"), "line 4: column pos"),
        (
            with("0.1 0.3 0.0 7 1 0.1", "0.1 0.3 0.0 7 1 -0.1"),
            "line 4: column radius: -0.1 is not positive",
        ),
        (
            with(" 0.5 1.5 0 -3 1 0\n", " 0.5 1.5\n"),
            "line 3: the column kind is missing",
        ),
        (with(" Time=0.0", ""), "line 2: the entry Time=… is missing"),
        (with("pos:R:3", "pos:R:2"), "line 2: Properties: pos"),
        (
            with("2.05 0.25 0.0", "2.05 0.25 0.5"),
            "line 4: column pos: there must be two numbers [x, y] and a third that is 0, but there is [2.05, 0.25, 0.5]",
        ),
        (
            with("0.1 -0.2 0.0", "0.1 -0.2 -3"),
            "line 3: column velo: there must be two numbers [x, y]",
        ),
        (
            with("mass:R:1:", ""),
            "line 2: Properties: the column mass is missing",
        ),
        (with("2.0 0.0", "2.0 0.5"), "line 2: Lattice"),
        (
            with("Lattice=\"2.0", "Lattice=\"0.0"),
            "line 2: Lattice: the side 0 is not positive",
        ),
        (with("\"T T F\"", "\"T T F"), "line 2"),
        (
            good[..good.rfind('X').unwrap()].to_owned(),
            "of the 3 atoms of this frame",
        ),
        (with("H 1.95", "H 1e300"), "frame 0"),
    ] {
        let error = converted(&text, "out.gsd").unwrap_err();
        let message = format!("{error:#}");
        assert!(
            message.contains("in.extxyz") && message.contains(expected),
            "{expected}: {message}"
        );
    }
    let message = format!("{:#}", converted(&good, "out.xyz").unwrap_err());
    assert!(
        message.contains(".gsd, .lammpstrj, .dump, .data or .npy"),
        "{message}"
    );
}

#[test]
fn bonds_are_kept_as_pairs_of_particles() {
    let text = two_frames().replacen(" Time=0.0", " Bonds=\"1 2\" Time=0.0", 1);
    let found = chunks(&converted(&text, "out.gsd").unwrap());
    assert_eq!(integers(&found, 0, "bonds/N"), [1]);
    assert_eq!(integers(&found, 0, "bonds/group"), [1, 2]);
    // The bond is gone in the second frame.
    assert_eq!(integers(&found, 1, "bonds/N"), [0]);
    assert!(
        !chunks(&converted(&two_frames(), "out.gsd").unwrap())
            .contains_key(&(0, "bonds/N".to_owned()))
    );
    // A data file has the last frame.
    let both = text.replace(" Time=0.1", " Bonds=\"0 2\" Time=0.1");
    let data = String::from_utf8(converted(&both, "out.data").unwrap()).unwrap();
    assert!(
        data.contains("3 atoms\n2 atom types\n1 bonds\n1 bond types\n"),
        "{data}"
    );
    assert!(data.ends_with("\nBonds\n\n1 1 1 3\n"), "{data}");
    assert!(data.contains("\n3 1 2 0.5 -0.125 0.0 0 0 0\n"), "{data}");
    let beyond = two_frames().replacen(" Time=0.0", " Bonds=\"1 3\" Time=0.0", 1);
    let error = converted(&beyond, "out.gsd").unwrap_err();
    assert!(format!("{error:#}").contains("no atom 3"), "{error:#}");
}
