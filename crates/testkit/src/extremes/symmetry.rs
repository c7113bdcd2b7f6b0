//! Symmetries of the dynamics: to the bit where the code promises it, elsewhere until chaos has
//! consumed the digits (6.6).

use anyhow::Result;
use carom::{
    Scene,
    engine::{MoleculeSpec, Rotation},
};
use glam::DVec2;

use super::{
    Effort, Engine, ExtremeCase, ExtremeFinding,
    bodies::{bumper, frozen, named},
    engine::{gas, in_box},
    watch::Watch,
};
use carom_methods::AnySimulation;

pub fn cases() -> Vec<ExtremeCase> {
    vec![
        ExtremeCase {
            id: "6.6 a",
            name: "velocities times 2^k, of an inelastic gas of molecules",
            must: "times divided by it, the same trajectories to the bit",
            run: scaled,
        },
        ExtremeCase {
            id: "6.6 b",
            name: "x and y exchanged, of discs and molecules that do not turn",
            must: "the mirrored trajectories to the bit",
            run: exchanged,
        },
        ExtremeCase {
            id: "6.6 c",
            name: "bodies in the opposite order",
            must: "the same trajectory of each to the bit",
            run: permuted,
        },
        ExtremeCase {
            id: "6.6 d",
            name: "a run cut into 97 pieces",
            must: "the same trajectories to the bit",
            run: in_pieces,
        },
        ExtremeCase {
            id: "6.6 e",
            name: "moved by half a box, turned by 90°, reflected, seen from a moving frame",
            must: "the same sequence of the first hundred collisions",
            run: to_rounding,
        },
    ]
}

/// Discs, free and locked molecules, and bumpers at a high area fraction.
fn reference_scene(engine: Engine, turning: bool) -> Result<Scene> {
    let rotation = if turning {
        Rotation::Free
    } else {
        Rotation::Locked
    };
    let mut scene = in_box(
        [1.0, 1.0],
        vec![MoleculeSpec {
            rotation,
            ..named("tee", 0.02, 0.5, [0.25, 0.25])
        }],
    );
    scene.bumper = vec![bumper(0.05, [0.75, 0.25])];
    scene.gas = vec![gas("disc", 0.02, 1.0, 80), gas("dumbbell", 0.015, 0.5, 12)];
    scene.gas[1].rotation = rotation;
    Ok(frozen(&engine.simulate(&scene)?.view()))
}

type State = Vec<[f64; 6]>;

fn state(run: &AnySimulation) -> State {
    let of = |m: carom::Motion| {
        let turns = m.orientation.turns();
        [
            m.position.x,
            m.position.y,
            m.velocity.x,
            m.velocity.y,
            turns,
            m.angular_velocity,
        ]
    };
    run.view().bodies().map(|body| of(body.motion)).collect()
}

fn after(engine: Engine, scene: &Scene, until: f64) -> Result<State> {
    let mut run = engine.simulate(scene)?;
    run.run_until(until)?;
    Ok(state(&run))
}

fn scaled(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let mut base = reference_scene(engine, true)?;
    base.elasticity.default = 0.95;
    let one = after(engine, &base, 2.0)?;
    let mut differ = 0;
    for exponent in [-60, -1, 1, 30] {
        let factor = 2f64.powi(exponent);
        let mut scene = base.clone();
        for molecule in &mut scene.molecule {
            molecule.velocity = molecule.velocity.map(|v| v * factor);
            molecule.angular_velocity *= factor;
        }
        let expected: State = one
            .iter()
            .map(|&[x, y, u, v, turns, spin]| [x, y, u * factor, v * factor, turns, spin * factor])
            .collect();
        differ += usize::from(after(engine, &scene, 2.0 / factor)? != expected);
    }
    Ok(vec![ExtremeFinding::never(
        "powers of two with different trajectories",
        differ,
    )])
}

fn exchanged(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let base = reference_scene(engine, false)?;
    let mut mirrored = base.clone();
    for molecule in &mut mirrored.molecule {
        let swap = |[x, y]: [f64; 2]| [y, x];
        // The atoms are turned instead of the body, so that no rotation has to be mirrored.
        let turn = carom::Orientation::from_turns(molecule.orientation_turns.take().unwrap_or(0.0))
            .cos_sin();
        for atom in &mut molecule.atoms {
            atom.at = swap(turn.rotate(DVec2::from(atom.at)).to_array());
        }
        (molecule.at, molecule.velocity) = (swap(molecule.at), swap(molecule.velocity));
    }
    let mut straight = mirrored.clone();
    for molecule in &mut straight.molecule {
        let swap = |[x, y]: [f64; 2]| [y, x];
        molecule
            .atoms
            .iter_mut()
            .for_each(|atom| atom.at = swap(atom.at));
        (molecule.at, molecule.velocity) = (swap(molecule.at), swap(molecule.velocity));
    }
    let expected: State = after(engine, &straight, 3.0)?
        .iter()
        .map(|&[x, y, u, v, turns, spin]| [y, x, v, u, turns, spin])
        .collect();
    let differ = after(engine, &mirrored, 3.0)? != expected;
    Ok(vec![ExtremeFinding::never(
        "trajectories that differ",
        usize::from(differ),
    )])
}

fn permuted(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let base = reference_scene(engine, true)?;
    let mut reversed = base.clone();
    reversed.molecule.reverse();
    let mut found = after(engine, &reversed, 3.0)?;
    found.reverse();
    Ok(vec![ExtremeFinding::never(
        "trajectories that differ",
        usize::from(found != after(engine, &base, 3.0)?),
    )])
}

fn in_pieces(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let base = reference_scene(engine, true)?;
    let mut run = engine.simulate(&base)?;
    for piece in 1..=97 {
        run.run_until(3.0 * f64::from(piece) / 97.0)?;
    }
    let differ = state(&run) != after(engine, &base, 3.0)?;
    Ok(vec![ExtremeFinding::never(
        "trajectories that differ",
        usize::from(differ),
    )])
}

fn to_rounding(engine: Engine, _: Effort) -> Result<Vec<ExtremeFinding>> {
    let base = reference_scene(engine, true)?;
    let sequence = |scene: &Scene| -> Result<Vec<[u64; 2]>> {
        let mut run = engine.simulate(scene)?;
        let mut watch = Watch::default();
        for _ in 0..100 {
            run.step(1e3, &mut watch)?;
        }
        Ok(watch
            .bodies
            .iter()
            .map(|[a, b]| [*a.min(b), *a.max(b)])
            .collect())
    };
    let expected = sequence(&base)?;
    let changed = |change: &dyn Fn(&mut MoleculeSpec)| -> Result<usize> {
        let mut scene = base.clone();
        scene.molecule.iter_mut().for_each(change);
        Ok(usize::from(sequence(&scene)? != expected))
    };
    let turn = |quarter: bool, [x, y]: [f64; 2]| if quarter { [1.0 - y, x] } else { [-y, x] };
    let moved = changed(&|molecule| molecule.at = molecule.at.map(|x| (x + 0.5) % 1.0))?;
    let shifted = changed(&|molecule| molecule.at = molecule.at.map(|x| x + 3.0))?;
    let turned = changed(&|molecule| {
        molecule.at = turn(true, molecule.at);
        molecule.velocity = turn(false, molecule.velocity);
        molecule.orientation_turns = molecule.orientation_turns.map(|turns| turns + 0.25);
    })?;
    let reflected = changed(&|molecule| {
        molecule.at[0] = 1.0 - molecule.at[0];
        molecule.velocity[0] *= -1.0;
        molecule.angular_velocity *= -1.0;
        molecule
            .atoms
            .iter_mut()
            .for_each(|atom| atom.at[0] *= -1.0);
        molecule.orientation_turns = molecule.orientation_turns.map(|turns| -turns);
    })?;
    // Fixed bodies would have to move, so they are left out.
    let mut free = base.clone();
    free.molecule.retain(|molecule| !molecule.fixed);
    let mut boosted = free.clone();
    boosted.molecule.iter_mut().for_each(|molecule| {
        molecule.velocity = [molecule.velocity[0] + 0.5, molecule.velocity[1] - 0.25];
    });
    let boost = usize::from(sequence(&boosted)? != sequence(&free)?);
    Ok(vec![
        ExtremeFinding::never("moved by half a box: different sequences", moved),
        ExtremeFinding::never("moved by three boxes: different sequences", shifted),
        ExtremeFinding::never("turned by 90°: different sequences", turned),
        ExtremeFinding::never("reflected: different sequences", reflected),
        ExtremeFinding::never("seen from a moving frame: different sequences", boost),
    ])
}
