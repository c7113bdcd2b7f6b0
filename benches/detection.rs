//! Time of one query, by kind of pair and detector: `cargo bench --bench detection`.
//!
//! Before the single times it prints three tables that do not depend on the machine: the time of
//! the golden-secant detector relative to the exact one, that of other shapes relative to tees, and
//! the growth of the time with the number of atoms.

use std::{hint::black_box, time::Instant};

use carom_detection::{
    Answer, Exact, GoldenSecant,
    encounters::{Class, Encounter},
};
use carom_geometry::{Molecule, Shape};
use carom_kinematics::{Orientation, RelativeMotion};
use criterion::{BenchmarkId, Criterion, criterion_group};
use glam::DVec2;

/// Two shapes of atoms of radius 1; B flies past A with the impact parameter `across`.
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
        Case {
            name: "skim reject",
            shapes: [Tee, Cross],
            across: 7.0,
            spins: [0.7, -0.4],
            hit: false,
        },
        Case {
            name: "disc-disc",
            shapes: [Disc, Disc],
            across: 0.6,
            spins: AT_REST,
            hit: true,
        },
        Case {
            name: "disc-tee hit",
            shapes: [Disc, Tee],
            across: 0.6,
            spins: [0.0, 0.7],
            hit: true,
        },
        Case {
            name: "disc-tee miss",
            shapes: [Disc, Tee],
            across: 4.5,
            spins: [0.0, 0.7],
            hit: false,
        },
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
        Case {
            name: "tee-cross hit",
            shapes: [Tee, Cross],
            across: 0.6,
            spins: [0.7, -0.4],
            hit: true,
        },
        Case {
            name: "tee-cross miss",
            shapes: [Tee, Cross],
            across: 6.3,
            spins: [0.7, -0.4],
            hit: false,
        },
    ]
};

impl Case {
    fn encounter(&self) -> Encounter {
        self.turned(0.0)
    }

    /// The encounter with both molecules turned at the start (by `turns`, and by three times as
    /// many).
    fn turned(&self, turns: f64) -> Encounter {
        let molecules = self
            .shapes
            .map(|shape| Molecule::named(shape, 1.0, 1.0).unwrap());
        let motion = RelativeMotion {
            orientation: [0.1 + turns, -0.3 + 3.0 * turns].map(Orientation::from_turns),
            angular_velocity: self.spins,
            ..RelativeMotion::exactly(DVec2::new(15.0, self.across), DVec2::new(-1.0, 0.0))
        };
        Encounter {
            molecules,
            motion,
            horizon: 100.0,
        }
    }
}

type Ask = fn(&Encounter) -> Answer;
const EXACT: Ask = |encounter| encounter.first_contact(&Exact::default());
const GOLDEN_SECANT: Ask = |encounter| encounter.first_contact(&GoldenSecant::default());

fn first_contact(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("first contact");
    for case in CASES {
        let encounter = case.encounter();
        for (name, ask) in [("exact", EXACT), ("golden-secant", GOLDEN_SECANT)] {
            let query = || ask(black_box(&encounter));
            assert_eq!(
                query().outcome.contact().is_some(),
                case.hit,
                "{} by {name}",
                case.name
            );
            group.bench_function(BenchmarkId::new(case.name, name), |bencher| {
                bencher.iter(query);
            });
        }
    }
}

fn many_atoms(criterion: &mut Criterion) {
    for (name, class) in [("rods", Class::Rods), ("blobs", Class::Blobs)] {
        let mut group = criterion.benchmark_group(format!("{name} of N atoms"));
        for size in [0, 3, 7] {
            let hits = encounters(class, size, Kind::Hit);
            group.bench_function(BenchmarkId::new("exact", 2 << size), |bencher| {
                let mut next = (0..hits.len()).cycle();
                bencher.iter(|| EXACT(black_box(&hits[next.next().unwrap()])));
            });
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Hit,
    Miss,
}

/// Encounters of molecules of 2 << `size` atoms, whose bounding circles meet.
fn encounters(class: Class, size: u64, kind: Kind) -> Vec<Encounter> {
    let drawn = (0..1000u64).map(|round| Encounter::draw(class, 1, 8 * round + size));
    let asked = drawn.filter(|encounter| {
        let answer = EXACT(encounter);
        let hit = answer.outcome.contact().is_some();
        answer.evaluations > 0 && hit == (kind == Kind::Hit)
    });
    asked.take(20).collect()
}

/// Seconds for one query, averaged over several; the minimum of many rounds, since other load on
/// the machine only adds time.
fn seconds(ask: Ask, encounters: &[Encounter], rounds: u32) -> f64 {
    let round = |_| {
        let begun = Instant::now();
        for encounter in encounters {
            black_box(ask(black_box(encounter)));
        }
        begun.elapsed().as_secs_f64() / encounters.len() as f64
    };
    (0..rounds).map(round).fold(f64::INFINITY, f64::min)
}

/// Prints the time of the golden-secant detector relative to that of the exact one, measured
/// alternately, on pairs that differ only in their orientations.
#[expect(clippy::print_stdout, reason = "prints a table")]
fn ratios() {
    println!("time of golden-secant over exact");
    for case in CASES {
        let turned = (0..100).map(|part| case.turned(0.01 * f64::from(part)));
        let encounters: Vec<Encounter> = turned
            .filter(|encounter| EXACT(encounter).outcome.contact().is_some() == case.hit)
            .collect();
        let mut ratios: Vec<f64> = (0..15)
            .map(|_| seconds(GOLDEN_SECANT, &encounters, 1) / seconds(EXACT, &encounters, 20))
            .collect();
        ratios.sort_by(f64::total_cmp);
        let exact = 1e9 * seconds(EXACT, &encounters, 50);
        let ratio = ratios[ratios.len() / 2];
        println!(
            "{:>15}: {ratio:6.1}   exact {exact:6.0} ns, {} pairs",
            case.name,
            encounters.len()
        );
    }
}

/// Encounters of two equal molecules of this bounding radius that turn and fly past each other at
/// random impact parameters, of those that hit or miss; their bounding circles meet.
fn of_equal(molecule: &Molecule, reach: f64, kind: Kind) -> Vec<Encounter> {
    let mut share = 0.5f64;
    let mut next = || {
        share = (share * 997.13 + 0.3717) % 1.0;
        share
    };
    let drawn = std::iter::repeat_with(|| {
        let across = (2.0 * next() - 1.0) * 2.0 * reach;
        let spins = [2.0 * next() - 1.0, 2.0 * next() - 1.0];
        let motion = RelativeMotion {
            orientation: [next(), next()].map(Orientation::from_turns),
            angular_velocity: spins,
            ..RelativeMotion::exactly(DVec2::new(15.0, across), DVec2::new(-1.0, 0.0))
        };
        Encounter {
            molecules: [molecule.clone(), molecule.clone()],
            motion,
            horizon: 100.0,
        }
    });
    let asked = drawn.filter(|encounter| {
        let answer = EXACT(encounter);
        let hit = answer.outcome.contact().is_some();
        answer.evaluations > 0 && hit == (kind == Kind::Hit)
    });
    asked.take(300).collect()
}

/// Prints the time of bodies with sides, of ellipses and of dumbbells relative to that of tees with
/// the same bounding circle, measured alternately.
#[expect(clippy::print_stdout, reason = "prints a table")]
fn shapes() {
    let tee = Molecule::named(Shape::Tee, 1.0, 1.0).unwrap();
    let reach = tee.bounding_radius();
    let ellipse = |ratio: f64| Molecule::ellipse([reach, reach / ratio], 1.0).unwrap();
    let dumbbell = Molecule::named(Shape::Dumbbell, 0.5 * reach, 1.0).unwrap();
    let regular = |corners: u32| {
        let corner = |index| {
            let turn = f64::from(index) / f64::from(corners);
            reach * DVec2::from_angle(std::f64::consts::TAU * turn)
        };
        let corners: Vec<DVec2> = (0..corners).map(corner).collect();
        Molecule::polygon(&corners, 1e-6 * reach, 1.0).unwrap()
    };
    // The straight part is twice the diameter.
    let capsule = Molecule::capsule(4.0 * reach / 3.0, reach / 3.0, 1.0).unwrap();
    let bodies = [
        ("tee", tee),
        ("dumbbell", dumbbell),
        ("square", regular(4)),
        ("capsule:2", capsule),
        ("polygon:16", regular(16)),
        ("ellipse:2", ellipse(2.0)),
        ("ellipse:5", ellipse(5.0)),
        ("ellipse:20", ellipse(20.0)),
    ];
    println!("time of a pair over that of two tees");
    for kind in [Kind::Hit, Kind::Miss] {
        let lists = bodies
            .each_ref()
            .map(|(_, body)| of_equal(body, reach, kind));
        let mut least = bodies.each_ref().map(|_| f64::INFINITY);
        for _ in 0..200 {
            for (least, list) in least.iter_mut().zip(&lists) {
                *least = least.min(seconds(EXACT, list, 1));
            }
        }
        for ((name, _), time) in bodies.iter().zip(least) {
            let ratio = time / least[0];
            println!("{name:>15} {kind:?}: {ratio:6.2}   {:6.0} ns", 1e9 * time);
        }
    }
}

/// Prints the growth of the time of the exact detector with the number of atoms of each molecule.
#[expect(clippy::print_stdout, reason = "prints a table")]
fn growth() {
    println!(
        "ns for a query of N against N atoms, N = 2, 4, … 256, and the exponent log2(t(256)/t(2))/7"
    );
    for (name, class) in [("rods", Class::Rods), ("blobs", Class::Blobs)] {
        for kind in [Kind::Hit, Kind::Miss] {
            let times: Vec<f64> = (0..8)
                .map(|size| 1e9 * seconds(EXACT, &encounters(class, size, kind), 50))
                .collect();
            let row: Vec<String> = times.iter().map(|time| format!("{time:7.0}")).collect();
            let exponent = (times[7] / times[0]).log2() / 7.0;
            println!(
                "{name:>6} {kind:?}: {}  exponent {exponent:.2}",
                row.join(" ")
            );
        }
    }
}

criterion_group!(benches, first_contact, many_atoms);

fn main() {
    // `cargo test --benches` only checks that it runs.
    if std::env::args().any(|argument| argument == "--bench") {
        ratios();
        shapes();
        growth();
    }
    benches();
    Criterion::default().configure_from_args().final_summary();
}
