//! x
use carom_detection::Exact;
use carom_engine::*;
use carom_response::Impact;
fn scene(name: &str) -> Scene {
    let mut scene = Scene::default();
    scene.bounds.seed = 1;
    let gas = |r: f64, phi: f64| GasSpec {
        radius: Some(r),
        mass: Some(1.0),
        energy: 1.0,
        area_fraction: Some(phi),
        ..Default::default()
    };
    let (name, arg) = name.split_once(':').unwrap_or((name, "0"));
    let arg: f64 = arg.parse().unwrap();
    match name {
        "gas" => scene.gas.push(gas(0.01, 0.5)),
        "n" => scene.gas.push(GasSpec {
            count: Some(arg as usize),
            area_fraction: None,
            ..gas((0.5 / arg / std::f64::consts::PI).sqrt(), 0.5)
        }),
        "tee" => {
            scene.molecule.push(MoleculeSpec {
                shape: Some("tee".into()),
                atom_radius: Some(0.01 * arg),
                atom_mass: Some(2.0),
                at: [0.5, 0.5],
                ..Default::default()
            });
            scene.bumper.push(BumperSpec { tags: vec![], radius: 0.0025, at: [0.1, 0.1] });
            scene.gas.push(gas(0.01, 0.5));
        }
        "tees" => {
            scene.gas.push(GasSpec {
                shape: Some("tee".into()),
                atom_radius: Some(0.005),
                atom_mass: Some(0.25),
                count: Some(arg as usize),
                energy: 1.5,
                ..Default::default()
            });
            scene.gas.push(gas(0.01, 0.45));
        }
        "rod" => {
            scene.molecule.push(MoleculeSpec {
                shape: Some("rod:50".into()),
                atom_radius: Some(0.0025),
                atom_mass: Some(0.0625),
                at: [0.5, 0.5],
                ..Default::default()
            });
            scene.gas.push(gas(0.01, 0.48));
        }
        "dumb" => {
            scene.gas.push(GasSpec {
                shape: Some("dumbbell".into()),
                atom_radius: Some((arg / 2000.0 / std::f64::consts::PI).sqrt()),
                atom_mass: Some(0.5),
                count: Some(1000),
                energy: 1.5,
                ..Default::default()
            });
        }
        "dilute" => {
            scene.gas.push(GasSpec { count: Some(arg as usize), area_fraction: None, ..gas(0.001, 0.5) })
        }
        "big" => {
            let r = 0.003568;
            scene.molecule.push(MoleculeSpec {
                atoms: vec![AtomSpec { at: [0.0, 0.0], radius: 20.0 * r, mass: 400.0 }],
                at: [0.5, 0.5],
                ..Default::default()
            });
            scene.gas.push(GasSpec { count: Some(10000), area_fraction: None, ..gas(r, 0.4) });
        }
        "mix" => {
            let r = (0.2 / 10000.0 / std::f64::consts::PI).sqrt();
            scene.gas.push(GasSpec { count: Some(10000), area_fraction: None, ..gas(r, 0.4) });
            scene.gas.push(GasSpec {
                count: Some(100),
                mass: Some(100.0),
                area_fraction: None,
                ..gas(10.0 * r, 0.4)
            });
        }
        _ => panic!(),
    }
    scene
}
fn run<S: Scheduler>(scene: &Scene, t: f64, o: S::Options) {
    let mut sim: Simulation<Exact, Impact, S> = Simulation::with(scene, Exact::default(), Impact, o).unwrap();
    println!("{} bodies", sim.view().len());
    let e0 = sim.view().energy();
    for i in 1..=5 {
        let start = cpu();
        let before = sim.view().counters().collisions;
        sim.run_until(t * i as f64 / 5.0).unwrap();
        let el = cpu() - start;
        let c = sim.view().counters().collisions - before;
        let o = sim.view().overlaps();
        println!(
            "t {} coll {} {:.1} ns/coll {:.2} M/s overlaps {} {:e} drift {:e} {:?}",
            sim.time(),
            c,
            el * 1e9 / c as f64,
            c as f64 / el / 1e6,
            o.pairs,
            o.deepest_length,
            (sim.view().energy() - e0) / e0,
            sim.view().counters()
        );
    }
}
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/schedstat").unwrap();
    s.split(' ').next().unwrap().parse::<f64>().unwrap() * 1e-9
}
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let s = scene(&a[2]);
    let t: f64 = a[3].parse().unwrap();
    match a[1].as_str() {
        "thesis" => run::<Thesis>(&s, t, Fineness::Automatic),
        "cells" => run::<Cells>(&s, t, Instructions::Widest),
        _ => run::<Cells>(&s, t, Instructions::Portable),
    }
}
