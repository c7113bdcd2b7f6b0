//! Output for other programs: tables that agree with the histograms, and trajectories that ASE
//! reads back to the bit.

use std::{
    env,
    ffi::{OsStr, OsString},
    fs,
    path::Path,
    process::{Command, Stdio},
};

use crate::support::{succeeding, xtask_in};

/// The rows of a table of numbers.
fn rows(path: &Path) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(path).unwrap();
    let row = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect();
    text.lines().skip(1).map(row).collect()
}

/// A Python with these modules: `$PYTHON`, or `python3`. Without one the test is skipped.
fn python(test: &str, modules: &str) -> Option<OsString> {
    let python = env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let import = Command::new(&python)
        .args(["-c", &format!("import {modules}")])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    let there = import.is_ok_and(|status| status.success());
    if !there {
        let test = format!("{}::{test}", module_path!());
        carom_testkit::skipped::skipped(
            &test,
            format_args!("{} lacks one of {modules}", python.display()),
        );
    }
    there.then_some(python)
}

/// Runs a program in a folder; it must succeed.
fn run_program(python: &OsStr, folder: &Path, program: &str) {
    succeeding(
        Command::new(python)
            .current_dir(folder)
            .args(["-c", program]),
    );
}

/// Runs the mixture of the examples into `out`: six frames.
fn run_mixture(folder: &Path) {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/runs/examples/mixture.toml");
    let scene = scene.to_str().unwrap();
    xtask_in(
        folder,
        &["carom", "run", scene, "--until", "0.5", "--out", "out"],
    );
}

/// Converts the trajectory in `out`, and returns the number of frames.
fn converted(folder: &Path, name: &str) -> u64 {
    let trajectory = folder.join("out/trajectory.extxyz");
    carom_runs::convert::convert(&trajectory, &folder.join(name)).unwrap()
}

/// A tee in a gas that runs into `out`: every kick and the directions.
const KICKS: &str = "[[molecule]]\ntags = [\"tee\"]\nshape = \"tee\"\natom_radius = 0.005\natom_mass = 2.0\nat = [0.5, 0.5]\n\
                     [[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\narea_fraction = 0.5\n\
                     [run]\nuntil = 3.0\nsample_interval = 0.5\nmeasure_from = 0.5\nobserve = [\"impulses:tee\"]\n\
                     [[measure]]\nkind = \"kicks\"\nof = \"tee\"\nbins = 360\n";

#[test]
fn the_table_of_kicks_agrees_with_the_histogram() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    fs::write(folder.join("tee.toml"), KICKS).unwrap();
    xtask_in(folder, &["carom", "run", "tee.toml", "--out", "all"]);
    let (mut counts, mut atoms) = (vec![0.0; 360], vec![0.0; 5]);
    let kicks = rows(&folder.join("all/impulses.csv"));
    let kicks: Vec<_> = kicks.into_iter().filter(|kick| kick[0] >= 0.5).collect();
    assert!(kicks.len() > 500 && kicks.is_sorted_by_key(|kick| kick[0]));
    for kick in &kicks {
        let [time, atom, other, normal_x, normal_y, x, y, body_x, body_y] = kick[..] else {
            panic!("{kick:?}")
        };
        assert!(time <= 3.0 && other > 0.0, "{kick:?}");
        // Smooth discs: the impulse is along the normal, with the same magnitude in both frames.
        let size = x.hypot(y);
        assert!(
            (normal_x * size - x).abs() < 1e-12 * size
                && (normal_y * size - y).abs() < 1e-12 * size
        );
        assert!((body_x.hypot(body_y) - size).abs() < 1e-14 * size);
        counts[body_y.atan2(body_x).to_degrees().rem_euclid(360.0) as usize] += 1.0;
        atoms[atom as usize] += 1.0;
    }
    let column = |name: &str, column: usize| -> Vec<f64> {
        rows(&folder.join(name))
            .iter()
            .map(|row| row[column])
            .collect()
    };
    assert_eq!(counts, column("all/kicks-directions-tee.csv", 1));
    assert_eq!(atoms, column("all/kicks-tee.csv", 1));
}

#[test]
fn the_program_of_the_book_draws_the_histogram() {
    let Some(python) = python(
        "the_program_of_the_book_draws_the_histogram",
        "numpy, matplotlib",
    ) else {
        return;
    };
    let chapter = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/book/src/data.md");
    let chapter = fs::read_to_string(chapter).unwrap();
    let mut programs = chapter
        .split("```python\n")
        .skip(1)
        .filter_map(|rest| rest.split("```").next());
    let program = programs
        .find(|program| program.contains("impulses.csv"))
        .expect("a program in Python");
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("tee.toml"), KICKS).unwrap();
    xtask_in(
        root.path(),
        &["carom", "run", "tee.toml", "--out", "out/run-tee"],
    );
    succeeding(
        Command::new(python)
            .current_dir(root.path())
            .env("MPLBACKEND", "Agg")
            .args(["-W", "error", "-c", program]),
    );
    assert!(
        fs::metadata(root.path().join("directions.png"))
            .unwrap()
            .len()
            > 10_000
    );
}

#[test]
fn ase_reads_a_trajectory_back_to_the_bit() {
    let Some(python) = python(
        "ase_reads_a_trajectory_back_to_the_bit",
        "ase.io, json, sys",
    ) else {
        return;
    };
    let root = tempfile::tempdir().unwrap();
    run_mixture(root.path());
    let path = root.path().join("out/trajectory.extxyz");
    let program = "frames = ase.io.read(sys.argv[1], index=':')\n\
                   json.dump([[f.info['Time'], f.cell.lengths().tolist(), f.pbc.tolist(), exact(f.positions), \
                   exact(f.arrays['velo']), f.arrays['radius'].tolist(), f.arrays['molecule_id'].tolist()] \
                   for f in frames], sys.stdout)";
    // As text: some JSON readers lose the last bit.
    let exact = "exact = lambda rows: [[repr(x) for x in row] for row in rows.tolist()]";
    let program = format!("import ase.io, json, sys\n{exact}\n{program}");
    let output = succeeding(Command::new(python).args(["-c", &program]).arg(&path));
    let frames: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    let mut lines = text.lines();
    for (index, frame) in frames.as_array().unwrap().iter().enumerate() {
        let atoms: usize = lines.next().unwrap().parse().unwrap();
        let comment = lines.next().unwrap();
        let time = frame[0].as_f64().unwrap();
        assert!(
            (time - 0.1 * index as f64).abs() < 1e-12
                && comment.ends_with(&format!("Time={time:?}"))
        );
        assert_eq!(
            (frame[1][0].as_f64(), frame[1][1].as_f64()),
            (Some(1.0), Some(1.0))
        );
        assert_eq!(frame[2], serde_json::json!([true, true, false]));
        assert_eq!(frame[3].as_array().unwrap().len(), atoms);
        for (atom, line) in lines.by_ref().take(atoms).enumerate() {
            let cells: Vec<f64> = line
                .split(' ')
                .skip(1)
                .map(|cell| cell.parse().unwrap())
                .collect();
            let read = |column: usize, axis: usize| -> f64 {
                frame[column][atom][axis].as_str().unwrap().parse().unwrap()
            };
            for axis in 0..3 {
                assert_eq!(read(3, axis).to_bits(), cells[axis].to_bits());
                assert_eq!(read(4, axis).to_bits(), cells[3 + axis].to_bits());
            }
            assert_eq!(frame[6][atom].as_f64().unwrap(), cells[6]);
            assert!((frame[5][atom].as_f64().unwrap() - cells[8]).abs() < 1e-15);
        }
    }
    assert_eq!((frames.as_array().unwrap().len(), lines.next()), (6, None));
}

#[test]
fn mdanalysis_reads_a_converted_dump() {
    let test = "mdanalysis_reads_a_converted_dump";
    let Some(python) = python(test, "numpy, MDAnalysis") else {
        return;
    };
    let root = tempfile::tempdir().unwrap();
    run_mixture(root.path());
    assert_eq!(converted(root.path(), "out.lammpstrj"), 6);
    let program = r"
import MDAnalysis, numpy as np
universe = MDAnalysis.Universe('out.lammpstrj', format='LAMMPSDUMP', topology_format='LAMMPSDUMP',
                               additional_columns=True)
lines = open('out/trajectory.extxyz').read().splitlines()
atoms = int(lines[0])
assert len(universe.trajectory) == 6 and len(universe.atoms) == atoms
for frame, step in enumerate(universe.trajectory):
    rows = [line.split() for line in lines[frame * (atoms + 2) + 2:][:atoms]]
    places = np.array([[float(word) for word in row[1:3]] for row in rows])
    assert np.allclose(step.positions[:, :2], places, atol=1e-6) and np.ptp(step.positions[:, 2]) == 0
    assert np.allclose(step.dimensions[[0, 1, 3, 4, 5]], [1, 1, 90, 90, 90])
    time = float(lines[frame * (atoms + 2) + 1].rsplit('Time=')[1])
    assert (step.data['v_time'] == time).all()
";
    run_program(&python, root.path(), program);
}

#[test]
fn hoomd_and_ase_read_converted_trajectories() {
    let test = "hoomd_and_ase_read_converted_trajectories";
    let Some(python) = python(test, "numpy, ase.io, gsd.hoomd") else {
        return;
    };
    let root = tempfile::tempdir().unwrap();
    run_mixture(root.path());
    for name in ["out.gsd", "out.lammpstrj"] {
        assert_eq!(converted(root.path(), name), 6);
    }
    let program = r"
import ase.io, gsd.hoomd, numpy as np
frames = ase.io.read('out/trajectory.extxyz', index=':')
dump = ase.io.read('out.lammpstrj', index=':', format='lammps-dump-text')
with gsd.hoomd.open('out.gsd') as trajectory:
    assert len(frames) == len(dump) == len(trajectory) == 6
    for frame, dumped, converted in zip(frames, dump, trajectory):
        converted.validate()
        particles, sides = converted.particles, frame.cell.lengths()[:2]
        assert (dumped.positions[:, :2] == frame.positions[:, :2]).all()
        assert (np.abs(particles.position[:, :2]) <= sides / 2).all()
        places = particles.position[:, :2].astype(float) + sides / 2 + particles.image[:, :2] * sides
        moved = frame.positions[:, :2] + frame.arrays['map_shift'][:, :2] * sides
        assert np.abs(places - moved).max() < 1e-6 * sides.max()
        assert np.allclose(frame.get_velocities(), frame.arrays['velo'], rtol=1e-14, atol=0)
        assert particles.types == frame.info['Kinds'].split()[:len(particles.types)]
        assert np.allclose(particles.velocity, frame.arrays['velo'], rtol=1e-6, atol=1e-6)
        assert np.allclose(particles.diameter, 2 * frame.arrays['radius'], rtol=1e-6)
        assert np.allclose(particles.mass, frame.arrays['mass'], rtol=1e-6)
        turned = 2 * np.arctan2(particles.orientation[:, 3], particles.orientation[:, 0])
        assert np.allclose(np.cos(turned - frame.arrays['angle']), 1, atol=1e-6)
        assert (particles.typeid == frame.arrays['kind']).all()
        assert converted.configuration.dimensions == 2
        assert converted.log['time'][0] == frame.info['Time']
";
    run_program(&python, root.path(), program);
}

/// A gas of discs that cross the box several times, with what freud computes, too.
const FREUD: &str = "[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100\n\
                     [run]\nuntil = 4.0\nsample_interval = 0.1\nsnapshots = \"extxyz\"\n\
                     [[measure]]\nkind = \"correlation\"\nof = \"gas\"\n\
                     [[measure]]\nkind = \"pair-distribution\"\nof = \"gas\"\nmax = 0.2\nbins = 20\n";

#[test]
fn freud_finds_the_displacements_and_the_pair_distribution_of_the_run() {
    let test = "freud_finds_the_displacements_and_the_pair_distribution_of_the_run";
    let Some(python) = python(test, "numpy, gsd.hoomd, freud") else {
        return;
    };
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("gas.toml"), FREUD).unwrap();
    xtask_in(root.path(), &["carom", "run", "gas.toml", "--out", "out"]);
    assert_eq!(converted(root.path(), "out.gsd"), 41);
    let program = r"
import csv, freud, gsd.hoomd, numpy as np
def column(name, column):
    return np.array([float(row[column]) for row in csv.DictReader(open(name))])
with gsd.hoomd.open('out.gsd') as frames:
    frames = list(frames)
box = freud.box.Box.from_box(frames[0].configuration.box)
assert box.is2D and frames[0].particles.types == ['gas']
assert frames[0].particles.type_shapes == [{'type': 'Sphere', 'diameter': 0.04}]
positions = np.array([frame.particles.position for frame in frames])
images = np.array([frame.particles.image for frame in frames])
assert np.abs(images).max() > 1
msd = freud.msd.MSD(box, mode='window').compute(positions, images).msd
ours = column('out/correlation-gas.csv', 'mean_square_displacement')
# The first lags, of which all origins are taken; the sums of freud are in single precision.
assert np.allclose(msd[:10], ours[:10], rtol=1e-4, atol=1e-6), (msd[:10], ours[:10])
assert ours[9] > 0.02
rdf = freud.density.RDF(bins=20, r_max=0.2, normalization_mode='finite_size')
for place in positions:
    rdf.compute((box, place), reset=False)
ours = column('out/pair-distribution-gas.csv', 'g')
# A pair at the border of two bins may change over in single precision.
assert np.allclose(rdf.rdf, ours, atol=0.02), (rdf.rdf, ours)
assert ours.max() > 1 and ours[0] == 0
";
    run_program(&python, root.path(), program);
}

/// Discs and rods, of which freud computes the order of the last frame.
const ORDER: &str = "[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 200\n\
                     [[gas]]\ntags = [\"rods\"]\nshape = \"rod:3\"\natom_radius = 0.01\natom_mass = 1.0\nenergy = 1.0\n\
                     count = 60\n[run]\nuntil = 4.0\nsample_interval = 0.1\nsnapshots = \"extxyz\"\n\
                     observe = [\"hexatic-order:gas\", \"defects:gas\", \"nematic:rods\"]\n\
                     [[measure]]\nkind = \"hexatic-order\"\nof = \"gas\"\nname = \"four\"\nn = 4\nneighbours = \"delaunay\"\n\
                     [[measure]]\nkind = \"hexatic-order\"\nof = \"gas\"\nname = \"weighted\"\nneighbours = \"voronoi\"\n";

#[test]
fn freud_finds_the_bond_order_the_neighbours_and_the_nematic_order_of_the_run() {
    let test = "freud_finds_the_bond_order_the_neighbours_and_the_nematic_order_of_the_run";
    let Some(python) = python(test, "numpy, ase.io, freud") else {
        return;
    };
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("order.toml"), ORDER).unwrap();
    xtask_in(root.path(), &["carom", "run", "order.toml", "--out", "out"]);
    let program = r"
import ase.io, csv, freud, numpy as np
frames = ase.io.read('out/trajectory.extxyz', index=':')
assert len(frames) == 41
def column(name, column):
    return np.array([float(row[column]) for row in csv.DictReader(open('out/' + name))])
found = {'local': [], 'global': [], 'four': [], 'weighted': [], 'five': [], 'seven': [], 'nematic': []}
box = freud.box.Box.square(1)
for frame in frames:
    is_disc = np.isclose(frame.arrays['radius'], 0.02)
    assert is_disc.sum() == 200 and len(is_disc) == 380
    places = frame.positions[is_disc] - [0.5, 0.5, 0]
    six = freud.order.Hexatic(k=6).compute((box, places), neighbors={'num_neighbors': 6}).particle_order
    found['local'].append(np.abs(six).mean())
    found['global'].append(np.abs(six.mean()))
    voronoi = freud.locality.Voronoi().compute((box, places))
    order = lambda k, weighted: freud.order.Hexatic(k=k, weighted=weighted).compute(
        (box, places), neighbors=voronoi.nlist).particle_order
    found['four'].append(np.abs(order(4, False)).mean())
    found['weighted'].append(np.abs(order(6, True)).mean())
    counts = np.bincount(voronoi.nlist.neighbor_counts, minlength=8)
    found['five'].append(counts[5])
    found['seven'].append(counts[7])
    angle = frame.arrays['angle'][~is_disc]
    nematic = freud.order.Nematic()
    nematic.compute(np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1))
    # The tensor of freud is that of three dimensions, (3 <u u> - 1)/2.
    found['nematic'].append((4 * nematic.order - 1) / 3)
for name, file, what in [('local', 'hexatic-order-gas', 'local'), ('global', 'hexatic-order-gas', 'global'),
                         ('four', 'hexatic-order-four', 'local'), ('weighted', 'hexatic-order-weighted', 'local'),
                         ('five', 'defects-gas', 'five'), ('seven', 'defects-gas', 'seven'),
                         ('nematic', 'nematic-rods', 'order')]:
    ours = column(file + '.csv', what)
    difference = np.abs(np.array(found[name]) - ours)
    # freud computes in single precision: an edge of a cell that is as short as its rounding appears or
    # is lost, which changes numbers of neighbours, and nothing that is weighted by the edge.
    frames_that_may_differ = 2 if name in ('four', 'five', 'seven') else 0
    assert (difference > 1e-6).sum() <= frames_that_may_differ, (name, difference, found[name], ours)
";
    run_program(&python, root.path(), program);
}

#[test]
fn ovito_reads_places_images_and_kinds() {
    let Some(python) = python("ovito_reads_places_images_and_kinds", "numpy, ovito.io") else {
        return;
    };
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("gas.toml"), FREUD).unwrap();
    xtask_in(root.path(), &["carom", "run", "gas.toml", "--out", "out"]);
    for name in ["out.gsd", "out.lammpstrj"] {
        assert_eq!(converted(root.path(), name), 41);
    }
    let program = r"
import csv, numpy as np
from ovito.io import import_file
ours = [float(row['mean_square_displacement']) for row in csv.DictReader(open('out/correlation-gas.csv'))]
for name in ['out/trajectory.extxyz', 'out.gsd', 'out.lammpstrj']:
    frames = import_file(name)
    assert frames.source.num_frames == 41, name
    places = []
    for index in range(41):
        data = frames.compute(index)
        sides = np.diag(np.asarray(data.cell)[:, :3])[:2]
        image = np.asarray(data.particles['Periodic Image'])[:, :2]
        order = np.argsort(np.asarray(data.particles['Particle Identifier'])) if name.endswith('trj') else slice(None)
        places.append((np.asarray(data.particles.positions)[:, :2] + image * sides)[order])
    places = np.array(places)
    squares = ((places[9:] - places[:-9]) ** 2).sum(axis=2).mean()
    assert abs(squares / ours[9] - 1) < 1e-4, (name, squares, ours[9])
kinds = import_file('out.gsd').compute(0).particles.particle_types.types
assert [kind.name for kind in kinds] == ['gas']
";
    run_program(&python, root.path(), program);
}
