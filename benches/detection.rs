//! Time of one query, by kind of pair and detector: `cargo bench --bench detection`.

use std::hint::black_box;

use carom_detection::{Detection, Exact, GoldenSecant};
use carom_geometry::{Molecule, Shape};
use carom_kinematics::{Orientation, RelativeMotion};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use glam::DVec2;

/// Two shapes of atoms of radius 1, B flying past A with the impact parameter `across`.
struct Case {
    name: &'static str,
    shapes: [Shape; 2],
    across: f64,
    spins: [f64; 2],
    /// Whether they touch.
    hit: bool,
}

const CASES: [Case; 8] = {
    use Shape::{Cross, Disc, Dumbbell, Tee};
    const AT_REST: [f64; 2] = [0.0; 2];
    [
        Case { name: "skim reject", shapes: [Tee, Cross], across: 7.0, spins: [0.7, -0.4], hit: false },
        Case { name: "disc-disc", shapes: [Disc, Disc], across: 0.6, spins: AT_REST, hit: true },
        Case { name: "disc-tee hit", shapes: [Disc, Tee], across: 0.6, spins: [0.0, 0.7], hit: true },
        Case { name: "disc-tee miss", shapes: [Disc, Tee], across: 4.5, spins: [0.0, 0.7], hit: false },
        Case {
            name: "dumbbells hit",
            shapes: [Dumbbell, Dumbbell],
            across: 0.6,
            spins: [0.7, -0.4],
            hit: true,
        },
        Case {
            name: "dumbbells miss",
            shapes: [Dumbbell, Dumbbell],
            across: 3.8,
            spins: [0.3, 0.7],
            hit: false,
        },
        Case { name: "tee-cross hit", shapes: [Tee, Cross], across: 0.6, spins: [0.7, -0.4], hit: true },
        Case { name: "tee-cross miss", shapes: [Tee, Cross], across: 6.3, spins: [0.7, -0.4], hit: false },
    ]
};

fn first_contact(criterion: &mut Criterion) {
    let detectors: [(&str, &dyn Detection); 2] =
        [("exact", &Exact::default()), ("golden-secant", &GoldenSecant::default())];
    let mut group = criterion.benchmark_group("first contact");
    for case in CASES {
        let [a, b] = case.shapes.map(|shape| Molecule::named(shape, 1.0, 1.0).unwrap());
        let motion = RelativeMotion {
            orientation: [Orientation::from_turns(0.1), Orientation::from_turns(-0.3)],
            angular_velocity: case.spins,
            ..RelativeMotion::exactly(DVec2::new(15.0, case.across), DVec2::new(-1.0, 0.0))
        };
        for (name, detector) in detectors {
            let query = || detector.first_contact(a.outline(), b.outline(), black_box(&motion), 100.0);
            assert_eq!(query().outcome.contact().is_some(), case.hit, "{} by {name}", case.name);
            group.bench_function(BenchmarkId::new(case.name, name), |bencher| bencher.iter(query));
        }
    }
}

criterion_group!(benches, first_contact);
criterion_main!(benches);
