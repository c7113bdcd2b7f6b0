use carom_detection::{Detection, Exact, GoldenSecant, FixedStep, Outcome};
use carom_geometry::{Atom, Interior, Molecule};
use carom_kinematics::{Orientation, RelativeMotion};
use glam::DVec2;
use std::collections::BTreeMap;
fn nums(s: &str) -> Vec<f64> { s.split(':').map(|x| x.parse().unwrap()).collect() }
fn main() {
    let text = std::fs::read_to_string("/work/shared/data/encounters-shapes.csv").unwrap();
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let col = |n: &str| head.iter().position(|h| *h == n).unwrap_or_else(|| panic!("{n} in {head:?}"));
    let mut table: BTreeMap<String, [u32; 6]> = BTreeMap::new();
    for line in lines {
        let f: Vec<&str> = line.split(',').collect();
        let body = |s: &str| {
            let atoms: Vec<Atom> = f[col(&format!("atoms{s}"))].split(';').filter(|x| !x.is_empty()).map(|t| { let n = nums(t); Atom::new(DVec2::new(n[0], n[1]), n[3], n[2]).unwrap() }).collect();
            let edges: Vec<([u32;2], f64)> = f[col(&format!("edges{s}"))].split(';').filter(|x| !x.is_empty()).map(|t| { let n = nums(t); ([n[0] as u32, n[1] as u32], n[2]) }).collect();
            Molecule::with_edges(atoms, &edges, Interior::Hollow)
        };
        if !f[col("ellipsesA")].is_empty() || !f[col("ellipsesB")].is_empty() { continue; }
        let (a, b) = (body("A").unwrap(), body("B").unwrap());
        let g = |n: &str| f[col(n)].parse::<f64>().unwrap();
        let motion = RelativeMotion {
            separation: DVec2::new(g("xB") - g("xA"), g("yB") - g("yA")),
            velocity: DVec2::new(g("vxB") - g("vxA"), g("vyB") - g("vyA")),
            orientation: [Orientation::from_radians(g("thA")), Orientation::from_radians(g("thB"))],
            angular_velocity: [g("wA"), g("wB")],
            ..RelativeMotion::exactly(DVec2::ZERO, DVec2::ZERO)
        };
        let end = g("window_end");
        let want = f[col("t_first")].parse::<f64>().ok();
        let row = table.entry(f[0].to_owned()).or_default();
        row[0] += 1;
        let methods: [&dyn Detection; 3] = [&Exact::default(), &GoldenSecant::default(), &FixedStep::default()];
        for (k, m) in methods.iter().enumerate() {
            let ans = m.first_contact(a.outline(), b.outline(), &motion, end);
            let ok = match (ans.outcome, want) {
                (Outcome::Contact(c), Some(w)) => (c.time - w).abs() <= 1e-9 * end,
                (Outcome::Free, None) => true,
                _ => false,
            };
            if !ok { row[1 + k] += 1; if k == 0 { println!("{} {}: {:?} want {:?} end {end}", f[0], f[1], ans, want); } }
            if k == 0 { row[4] += ans.evaluations; row[5] = row[5].max(ans.evaluations); }
        }
    }
    for (k, v) in table { println!("{k:24} pairs {} wrong exact {} golden {} step {} evals mean {:.1} max {}", v[0], v[1], v[2], v[3], v[4] as f64 / v[0] as f64, v[5]); }
}
