//! Random gases in random tiles, with borders that are often too narrow, and random actions between
//! random stops: each run must have the bits of the run in the global order, at each stop and in
//! each report.

pub mod case;

use anyhow::Result;
use carom::{
    Observer, RunError, Simulation,
    engine::{CollisionReport, ElasticitySpec, TileCounters, Tiling},
};

use self::case::{Action, TilesCase};
use super::subject::{Report, Subject, read_toml, write_toml};

/// The fuzzer of tiles.
#[derive(Debug, Clone, Copy, Default)]
pub struct TilesFuzzer;

impl Subject for TilesFuzzer {
    type Case = TilesCase;
    const NAME: &'static str = "tiles";
    const TIME_LIMIT: u64 = 120;

    fn draw(&self, seed: u64) -> TilesCase {
        TilesCase::draw(seed)
    }

    fn check(&self, case: &TilesCase) -> Report {
        let mut report = Report::default();
        let scene = match case.scene() {
            Ok(scene) => scene,
            Err(error) => {
                report.fail("scene", error.to_string());
                return report;
            }
        };
        let Ok(base) = Simulation::new(&scene) else {
            // Molecules that find no place.
            report.count("not built", 1);
            return report;
        };
        let [(expected, _), (found, tiles)] = [Tiling::NONE, case.tiling()].map(|tiling| {
            let mut simulation = base.clone();
            simulation.set_tiling(&tiling);
            let computed = run(case, &mut simulation);
            (computed, simulation.tile_counters())
        });
        if let Some((number, _)) = expected
            .iter()
            .zip(&found)
            .enumerate()
            .find(|(_, (one, other))| one != other)
        {
            report.fail(
                "bits",
                format!("number {number} of {} differs; {tiles:?}", expected.len()),
            );
        } else if expected.len() != found.len() {
            report.fail(
                "bits",
                format!(
                    "{} numbers, then {}; {tiles:?}",
                    expected.len(),
                    found.len()
                ),
            );
        }
        count(&mut report, &tiles);
        report
    }

    fn simpler(&self, case: &TilesCase) -> Vec<TilesCase> {
        case.simpler()
    }

    fn write(&self, case: &TilesCase) -> (String, Vec<u8>) {
        write_toml(case)
    }

    fn read(&self, ending: &str, bytes: &[u8]) -> Result<TilesCase> {
        read_toml(ending, bytes)
    }
}

fn count(report: &mut Report, tiles: &TileCounters) {
    let counts = [
        ("windows", tiles.windows),
        ("contacts", tiles.contacts),
        ("tiles", tiles.tiles),
        ("tiles repeated", tiles.repeated),
        ("windows cut", tiles.cut),
        ("windows given up", tiles.given_up),
        ("windows refused", tiles.refused),
        ("cases without tiles", u64::from(tiles.tiles == 0)),
    ];
    for (name, number) in counts {
        report.count(name, number);
    }
}

/// Runs a case; returns the bits of all it has computed: motions and counts at each stop, reports,
/// energies, and the error with which it ended.
fn run(case: &TilesCase, simulation: &mut Simulation) -> Vec<u64> {
    let mut bits = Bits::default();
    simulation.set_contacts_per_epoch(case.contacts_per_epoch);
    for stop in 1..=case.stops {
        let until = case.until() * f64::from(stop) / f64::from(case.stops);
        let action = case.action(stop);
        let reports = case.reports != (action == Action::OtherObserver);
        let ended = if reports {
            simulation.observe_until(until, &mut bits).map(drop)
        } else {
            simulation.run_until(until).map(drop)
        };
        let ended = ended.and_then(|()| act(action, simulation, &mut bits));
        bits.add_state(simulation);
        if let Err(error) = ended {
            bits.0.extend(error.to_string().bytes().map(u64::from));
            break;
        }
    }
    bits.0
}

fn act(action: Action, simulation: &mut Simulation, bits: &mut Bits) -> Result<(), RunError> {
    match action {
        Action::None | Action::OtherObserver => {}
        Action::Step => drop(simulation.step(f64::MAX, bits)?),
        Action::Clone => *simulation = simulation.clone(),
        Action::EndEpoch => drop(simulation.end_epoch_here()),
        Action::Elasticity(default, contact_time) => {
            let rules = ElasticitySpec {
                default,
                contact_time,
                ..ElasticitySpec::default()
            };
            simulation.set_elasticity(&rules).expect("it is in range");
        }
        Action::Reverse => simulation.reverse(),
    }
    Ok(())
}

/// Numbers as bits, in the order in which they were computed.
#[derive(Debug, Default)]
struct Bits(Vec<u64>);

impl Bits {
    fn add_state(&mut self, simulation: &Simulation) {
        let view = simulation.view();
        for body in view.bodies() {
            let motion = body.motion;
            let [place, velocity] = [motion.position, motion.velocity];
            let turning = [motion.orientation.turns(), motion.angular_velocity];
            self.0
                .extend([place.x, place.y, velocity.x, velocity.y].map(f64::to_bits));
            self.0.extend(turning.map(f64::to_bits));
            self.0.extend(body.winding.map(|boxes| boxes as u64));
        }
        let (counters, ledger) = (view.counters(), view.ledger());
        self.0.extend([
            counters.collisions,
            counters.fixed_collisions,
            counters.guarded_collisions,
        ]);
        self.0
            .extend([ledger.lost, ledger.spared].map(f64::to_bits));
    }
}

impl Observer for Bits {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.0.push(report.time.to_f64().to_bits());
        for side in &report.sides {
            self.0.push(side.body.id());
            self.0
                .extend(side.after.velocity.to_array().map(f64::to_bits));
            self.0.push(side.after.angular_velocity.to_bits());
        }
        self.0.extend(report.image.map(|boxes| boxes as u64));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fuzz::random::case_seed;

    #[test]
    fn cases_survive_their_file_and_some_repeat_tiles() {
        let mut total = Report::default();
        for index in 0..3 {
            let case = TilesFuzzer.draw(case_seed(2, index));
            let (ending, text) = TilesFuzzer.write(&case);
            assert_eq!(TilesFuzzer.read(&ending, &text).unwrap(), case);
            let report = TilesFuzzer.check(&case);
            assert_eq!(report.failure, None, "{case:?}");
            total.add(&report);
        }
        let count = |name: &str| {
            total
                .counts
                .iter()
                .find(|(known, _)| known == name)
                .map_or(0, |it| it.1)
        };
        assert!(
            count("windows") > 10 && count("tiles repeated") > 10,
            "{total:?}"
        );
    }
}
