use carom_engine::{GasSpec, Scene, Simulation, Tiling};
use std::time::Instant;
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/schedstat").unwrap();
    s.split(' ').next().unwrap().parse::<f64>().unwrap()
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let count: usize = args[1].parse().unwrap();
    let contacts: f64 = args[2].parse().unwrap();
    let rounds: usize = args[3].parse().unwrap();
    let fill = 0.5;
    let radius = (fill / (std::f64::consts::PI * count as f64)).sqrt();
    let gas = GasSpec {
        radius: Some(radius),
        mass: Some(1.0),
        energy: 1.0,
        count: Some(count),
        ..GasSpec::default()
    };
    let scene = Scene { gas: vec![gas], ..Scene::default() };
    let chi = (1.0 - 7.0 / 16.0 * fill) / ((1.0f64 - fill) * (1.0 - fill));
    let tau = 1.0 / (4.0 * radius * count as f64 * chi * std::f64::consts::PI.sqrt());
    let tilings: Vec<Tiling> = args[4..]
        .iter()
        .map(|a| {
            if a == "none" {
                return Tiling::NONE;
            }
            let p: Vec<f64> = a.split(',').map(|x| x.parse().unwrap()).collect();
            Tiling {
                threads: p[0] as usize,
                least_bodies: 1,
                side: p[1] as u32,
                window: p[2],
                margin: p[3] as u32,
                front: p[4],
            }
        })
        .collect();
    let base = Simulation::new(&scene).unwrap();
    let mut sims: Vec<Simulation> = tilings
        .iter()
        .map(|t| {
            let mut s = base.clone();
            s.set_tiling(t);
            s
        })
        .collect();
    for r in 0..=rounds {
        for (k, s) in sims.iter_mut().enumerate() {
            let before = s.view().counters().collisions;
            let (w0, c0) = (Instant::now(), cpu());
            let t = (r + 1) as f64 * contacts * tau;
            s.run_until(t).unwrap();
            let n = (s.view().counters().collisions - before) as f64;
            let c = s.tile_counters();
            println!(
                "{r} {:12} wall {:7.1} cpu {:7.1} ns  n {n} work {:.3} win {} tiles {} rep {} cut {} ref {} bytes/body {}",
                args[4 + k],
                w0.elapsed().as_nanos() as f64 / n,
                (cpu() - c0) / n,
                c.computed as f64 / c.contacts.max(1) as f64,
                c.windows,
                c.tiles,
                c.repeated,
                c.cut,
                c.refused,
                s.heap_bytes() / count
            );
        }
    }
}
