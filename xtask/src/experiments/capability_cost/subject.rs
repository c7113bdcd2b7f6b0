//! One variant as a run: the gas, the additional bodies, and the work at samples.

use std::{cell::Cell, f64::consts::PI, io, rc::Rc};

use anyhow::{Context, Result};
use carom::{
    Observer as _, Scene, Subscriptions,
    engine::{
        AtomSpec, BumperSpec, ChainSpec, DiameterSpec, ElasticityRule, GasSpec, MoleculeSpec,
        ReactionSpec, Rotation, Tag, TetherSpec, TransparentSpec, WallSpec, WellSpec,
    },
    observers::{TagFilter, write_extended_xyz},
};

use super::capability::{Capability, CapabilityLevel, Variant};
use carom_methods::AnySimulation;
use carom_runs::{
    append_file::AppendFiles,
    measures::{self, Measures, Of},
    output::{Existing, Folder},
};

/// Number of discs, and of additional bodies where a capability is used.
const DISCS: usize = 4000;
const OTHERS: usize = 200;

/// Area fraction of the discs.
const AREA_FRACTION: f64 = 0.5;

/// Time between samples: about three collisions of each disc.
pub const INTERVAL: f64 = 0.005;

/// Number of intervals until the initial lattice is lost.
pub const WARM_UP: u32 = 2;

/// A variant during its run.
pub struct CostSubject {
    simulation: AnySimulation,
    work: Work,
    intervals: u32,
}

/// Work in addition to running.
enum Work {
    /// None; the run is not sampled.
    None,
    Subscriptions(Subscriptions),
    Sample,
    Snapshots,
    Thermostat(Tag),
    Measures(Box<Measuring>),
}

/// The measures of a run, with the files that they append to.
struct Measuring {
    measures: Measures,
    files: AppendFiles,
    folder: Folder,
}

impl Measuring {
    fn new(scene: &Scene, simulation: &AnySimulation) -> Result<Self> {
        let name = format!(
            "carom-cost-{}-{}",
            std::process::id(),
            scene.run.observe.join("-").replace(':', "-")
        );
        let folder = Folder::create(&std::env::temp_dir().join(name), Existing::Replace)?;
        let mut measures = Measures::new(scene, &simulation.view())?;
        measures.sample(&simulation.view());
        Ok(Self {
            measures,
            files: AppendFiles::new(&folder),
            folder,
        })
    }
}

impl Drop for Measuring {
    fn drop(&mut self) {
        // A folder that stays behind is in the system's folder for temporary files.
        let _ = std::fs::remove_dir_all(self.folder.path());
    }
}

impl CostSubject {
    /// The initial state of a variant.
    ///
    /// # Errors
    /// The scene cannot be built.
    pub fn new(variant: Variant) -> Result<Self> {
        let scene = scene(variant);
        let mut simulation = AnySimulation::new(&scene)?;
        let work = match variant {
            Variant::With(Capability::Subscriptions, level) => {
                let mut subscriptions = Subscriptions::default();
                if level == CapabilityLevel::Used {
                    count(&mut subscriptions, TagFilter::Any);
                }
                Work::Subscriptions(subscriptions)
            }
            Variant::With(Capability::Tags, CapabilityLevel::Used) => {
                let tag = |name| {
                    simulation
                        .find_tag(name)
                        .context("the scene has no body with this tag")
                };
                let filter = TagFilter::Pair(tag("one")?, tag("three")?);
                let mut subscriptions = Subscriptions::default();
                count(&mut subscriptions, filter);
                Work::Subscriptions(subscriptions)
            }
            Variant::With(Capability::Snapshots, CapabilityLevel::Idle) => Work::Sample,
            Variant::With(Capability::Snapshots, CapabilityLevel::Used) => Work::Snapshots,
            Variant::With(Capability::Thermostat, CapabilityLevel::Used) => Work::Thermostat(
                simulation
                    .find_tag("gas")
                    .context("the scene has no body with this tag")?,
            ),
            Variant::With(Capability::Thermostat, CapabilityLevel::Idle) => {
                let key = simulation
                    .view()
                    .bodies()
                    .next()
                    .context("the scene is empty")?
                    .body
                    .key();
                let tag = simulation.tag(key, "unused")?;
                simulation.untag(key, "unused")?;
                Work::Thermostat(tag)
            }
            Variant::Measure(_) => Work::Measures(Box::new(Measuring::new(&scene, &simulation)?)),
            _ => Work::None,
        };
        Ok(Self {
            simulation,
            work,
            intervals: 0,
        })
    }

    /// Runs for a number of intervals.
    ///
    /// # Errors
    /// The run fails.
    pub fn run(&mut self, intervals: u32) -> Result<()> {
        let begin = self.intervals;
        self.intervals += intervals;
        let at = |interval: u32| INTERVAL * f64::from(interval);
        match &mut self.work {
            Work::None => self.simulation.run_until(at(self.intervals))?,
            Work::Subscriptions(subscriptions) => {
                self.simulation
                    .observe_until(at(self.intervals), subscriptions)?;
            }
            Work::Measures(measuring) => {
                for interval in begin + 1..=self.intervals {
                    let Measuring {
                        measures, files, ..
                    } = measuring.as_mut();
                    self.simulation.observe_until(at(interval), measures)?;
                    measures.sample(&self.simulation.view());
                    measures.append(files)?;
                }
            }
            Work::Sample | Work::Snapshots | Work::Thermostat(_) => {
                for interval in begin + 1..=self.intervals {
                    self.simulation.run_until(at(interval))?;
                    match self.work {
                        Work::Snapshots => {
                            write_extended_xyz(&self.simulation.view(), &mut io::sink())?;
                        }
                        Work::Thermostat(tag) => self.simulation.reset_energy_of_tag(tag, 1.0)?,
                        _ => {}
                    }
                }
            }
        }
        Ok(())
    }

    /// Collisions so far.
    pub fn collisions(&self) -> u64 {
        self.simulation.view().counters().collisions
    }

    /// Memory for each body (bytes).
    pub fn bytes_per_body(&self) -> f64 {
        self.simulation.heap_bytes() as f64 / self.simulation.view().len() as f64
    }
}

/// Subscribes a counting closure.
fn count(subscriptions: &mut Subscriptions, filter: TagFilter) {
    let seen = Rc::new(Cell::new(0u64));
    subscriptions.subscribe_collisions(filter, move |_| seen.set(seen.get() + 1));
}

fn radius() -> f64 {
    (AREA_FRACTION / (PI * DISCS as f64)).sqrt()
}

/// The plain gas with a measure; one disc is a tracer, for measures of one body.
fn measured(mut scene: Scene, name: &str) -> Scene {
    let kind = measures::KINDS.iter().find(|kind| kind.name == name);
    scene.bounds.seed = 1;
    scene.run.sample_interval = INTERVAL;
    let tag = match kind.map(|kind| kind.of) {
        Some(Of::OneBody) => {
            scene.molecule = vec![MoleculeSpec {
                tags: vec!["tracer".to_owned()],
                ..disc_in_the_middle(radius(), 1.0)
            }];
            scene.gas[0].count = Some(DISCS - 1);
            ":tracer"
        }
        _ => "",
    };
    scene.run.observe = vec![format!("{name}{tag}")];
    scene
}

/// The scene of a variant.
pub fn scene(variant: Variant) -> Scene {
    let mut scene = Scene {
        gas: vec![discs(DISCS, radius(), 1.0)],
        ..Scene::default()
    };
    match variant {
        Variant::Plain(seed) => scene.bounds.seed = seed,
        Variant::With(capability, level) => {
            scene.bounds.seed = 1;
            add_capability(&mut scene, capability, level == CapabilityLevel::Used);
        }
        Variant::Measure(name) => return measured(scene, name),
    }
    scene
}

/// A gas of discs.
fn discs(count: usize, radius: f64, mass: f64) -> GasSpec {
    GasSpec {
        tags: vec!["gas".to_owned()],
        radius: Some(radius.into()),
        mass: Some(mass.into()),
        energy: 1.0,
        count: Some(count),
        ..GasSpec::default()
    }
}

/// A gas of discs with another tag.
fn tagged(tag: &str, count: usize) -> GasSpec {
    GasSpec {
        tags: ["gas", tag].map(str::to_owned).to_vec(),
        ..discs(count, radius(), 1.0)
    }
}

/// A gas of dumbbells that have the area of a disc.
fn dumbbells(count: usize, rotation: Rotation) -> GasSpec {
    GasSpec {
        shape: Some("dumbbell".to_owned()),
        atom_radius: Some((radius() / 2f64.sqrt()).into()),
        atom_mass: Some(0.5.into()),
        rotation,
        radius: None,
        mass: None,
        ..discs(count, radius(), 1.0)
    }
}

/// A gas of molecules of this shape and size (length).
fn shaped(count: usize, shape: &str, size: f64) -> GasSpec {
    GasSpec {
        shape: Some(shape.to_owned()),
        size: Some(size.into()),
        radius: None,
        ..discs(count, radius(), 1.0)
    }
}

/// A gas of this number of other molecules in the place of as many discs.
fn among_discs(count: usize, gas: impl FnOnce(usize) -> GasSpec) -> Vec<GasSpec> {
    vec![gas(count), discs(DISCS - count, radius(), 1.0)]
}

/// Adds a capability to a gas of discs.
fn add_capability(scene: &mut Scene, capability: Capability, used: bool) {
    let others = if used { OTHERS } else { 1 };
    let radius = radius();
    match capability {
        Capability::Turning => {
            scene.gas = among_discs(others, |count| dumbbells(count, Rotation::Free));
        }
        // Squares and ellipses have the area of a disc.
        Capability::Sides => {
            let size = radius * PI.sqrt();
            scene.gas = among_discs(others, |count| shaped(count, "square", size));
        }
        Capability::Ellipses => {
            let size = 2.0 * radius * 2f64.sqrt();
            scene.gas = among_discs(others, |count| shaped(count, "ellipse:2", size));
        }
        Capability::Locked if used => {
            scene.gas = among_discs(others, |count| dumbbells(count, Rotation::Locked));
        }
        Capability::Locked => scene.gas[0].rotation = Rotation::Locked,
        Capability::Bumpers => {
            scene.bumper = bumpers(others);
            scene.gas[0].count = Some(DISCS - others);
        }
        Capability::Walls => scene.wall = walls(used),
        Capability::SizeMixture if used => {
            // Each large disc has the area of nine; the total area fraction stays one half.
            scene.gas = vec![
                discs(OTHERS, 3.0 * radius, 9.0),
                discs(DISCS - 9 * OTHERS, radius, 1.0),
            ];
        }
        Capability::SizeMixture => {
            scene.molecule = vec![disc_in_the_middle(3.0 * radius, 9.0)];
            scene.gas[0].count = Some(DISCS - 9);
        }
        Capability::Bonds if used => scene.gas = vec![chains(DISCS, 16)],
        Capability::Bonds => scene.gas = among_discs(2, |count| chains(count, 2)),
        Capability::Tags
        | Capability::ElasticityTable
        | Capability::Rough
        | Capability::TransparentPairs
        | Capability::Wells
        | Capability::Reactions => add_rules(scene, capability, used),
        Capability::Arcs
        | Capability::MovingWalls
        | Capability::Pistons
        | Capability::Gravity
        | Capability::Drag
        | Capability::Shear => {
            let gas = std::mem::take(&mut scene.gas);
            *scene = beside_the_gas(capability, used);
            scene.bounds.seed = 1;
            scene.gas = gas;
        }
        Capability::Subscriptions | Capability::Snapshots | Capability::Thermostat => {}
    }
}

/// Bumpers as large as the discs, in rows of 20.
fn bumpers(count: usize) -> Vec<BumperSpec> {
    (0..count)
        .map(|index| BumperSpec {
            tags: Vec::new(),
            radius: radius(),
            at: [
                0.05 * (0.5 + (index % 20) as f64),
                0.1 * (0.5 + (index / 20) as f64),
            ],
        })
        .collect()
}

/// Two walls across the box, or a single wall of the length of a disc.
fn walls(used: bool) -> Vec<WallSpec> {
    if used {
        let across = |x, y| WallSpec {
            x,
            y,
            ..WallSpec::default()
        };
        return vec![across(Some(0.0), None), across(None, Some(0.0))];
    }
    vec![WallSpec {
        from: Some([0.5, 0.5]),
        to: Some([0.5 + radius(), 0.5]),
        ..WallSpec::default()
    }]
}

fn disc_in_the_middle(radius: f64, mass: f64) -> MoleculeSpec {
    MoleculeSpec {
        atoms: vec![AtomSpec {
            at: [0.0; 2],
            radius,
            mass,
        }],
        at: [0.5, 0.5],
        ..MoleculeSpec::default()
    }
}

/// A gas of discs in chains of this length.
fn chains(count: usize, members: usize) -> GasSpec {
    GasSpec {
        chain: Some(ChainSpec {
            members,
            ring: false,
            arms: 0,
            tether: TetherSpec {
                max: 2.6 * radius(),
                ..TetherSpec::default()
            },
        }),
        ..discs(count, radius(), 1.0)
    }
}

/// Adds a capability that consists of rules for tags.
fn add_rules(scene: &mut Scene, capability: Capability, used: bool) {
    let two_kinds = || ["one", "other"].map(|tag| tagged(tag, DISCS / 2)).to_vec();
    match capability {
        Capability::Tags => {
            scene.gas[0].tags = ["one", "two", "three"].map(str::to_owned).to_vec();
        }
        Capability::ElasticityTable => {
            let (tag, coefficient) = if used {
                ("gas", 0.999)
            } else {
                ("unused", 0.5)
            };
            scene.elasticity.pair = vec![ElasticityRule {
                between: vec![tag.to_owned()],
                coefficient: coefficient.into(),
                ..ElasticityRule::default()
            }];
        }
        Capability::Rough => {
            let tag = if used { "gas" } else { "unused" };
            scene.elasticity.pair = vec![ElasticityRule {
                between: vec![tag.to_owned()],
                tangential: 1.0,
                ..ElasticityRule::default()
            }];
        }
        Capability::TransparentPairs if used => {
            scene.gas = two_kinds();
            scene.transparent = vec![TransparentSpec {
                between: ["one", "other"].map(str::to_owned).to_vec(),
            }];
        }
        Capability::TransparentPairs => {
            scene.diameter = vec![DiameterSpec {
                between: vec!["gas".to_owned()],
                factor: 1.0,
            }];
        }
        Capability::Wells => {
            let wells = if used { DISCS / 2 } else { 1 };
            scene.gas = vec![tagged("one", wells), tagged("other", DISCS - wells)];
            let between: &[&str] = if used { &["gas"] } else { &["one", "other"] };
            scene.well = vec![WellSpec {
                between: between.iter().map(|&tag| tag.to_owned()).collect(),
                steps: vec![[1.5, -1.0]],
            }];
        }
        Capability::Reactions => {
            scene.gas = two_kinds();
            scene.reaction = vec![ReactionSpec {
                between: ["one", "other"].map(str::to_owned).to_vec(),
                becomes: ["other", "one"].map(str::to_owned).to_vec(),
                least_energy: if used { 0.0 } else { 1e30 },
                ..ReactionSpec::default()
            }];
        }
        _ => {}
    }
}

/// What a scene has besides its gas, where that alone has the capability.
fn beside_the_gas(capability: Capability, used: bool) -> Scene {
    let radius = radius();
    let text = match (capability, used) {
        (Capability::Arcs, true) => "[[wall]]\narc = { at = [0.5, 0.5], radius = 0.4 }".to_owned(),
        (Capability::Arcs, false) => {
            format!(
                "[[wall]]\narc = {{ at = [0.5, 0.5], radius = {radius}, from = 0.0, to = 3.0 }}"
            )
        }
        (Capability::MovingWalls, true) => {
            "[[wall]]\ny = 0.5\nmotion = { amplitude = [0.0, 0.01], frequency = 100.0 }".to_owned()
        }
        (Capability::MovingWalls, false) => format!(
            "[[wall]]\nfrom = [0.5, 0.5]\nto = [{}, 0.5]\nmotion = {{ velocity = [0.0, 1e-6] }}",
            0.5 + radius
        ),
        (Capability::Pistons, true) => {
            "[[wall]]\nx = 0.0\n[[piston]]\nx = 0.5\nmass = 100.0".to_owned()
        }
        (Capability::Pistons, false) => {
            "[[wall]]\nx = 0.0\n[[piston]]\nx = 0.5\nmass = 1e9".to_owned()
        }
        (Capability::Gravity, _) => {
            let acceleration = if used { 1.0 } else { 1e-9 };
            format!("[gravity]\nacceleration = [0.0, -{acceleration:?}]\n[[wall]]\ny = 0.0")
        }
        (Capability::Drag, _) => format!("[box]\ndrag = {:?}", if used { 1.0 } else { 1e-9 }),
        (Capability::Shear, _) => {
            format!("[box]\nshear_rate = {:?}", if used { 1.0 } else { 1e-9 })
        }
        _ => String::new(),
    };
    Scene::from_toml(&text).expect("the scene is well formed")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_variant_runs_and_matches_its_description() {
        for variant in Variant::all() {
            let mut subject = CostSubject::new(variant).unwrap();
            subject.run(1).unwrap();
            // Two gases of half the discs that do not see each other have half the collisions.
            assert!(subject.collisions() > 500, "{variant}");
            let view = subject.simulation.view();
            assert_eq!(view.overlaps().pairs, 0, "{variant}");
            let is_no_wall = |body: &carom::engine::BodyView<'_>| !body.body.is_wall();
            let bodies = view.bodies().filter(is_no_wall).count();
            let expected = match variant {
                Variant::With(Capability::SizeMixture, CapabilityLevel::Used) => DISCS - 8 * OTHERS,
                Variant::With(Capability::SizeMixture, CapabilityLevel::Idle) => DISCS - 8,
                _ => DISCS,
            };
            assert_eq!(bodies, expected, "{variant}");
        }
    }

    #[test]
    fn capabilities_that_only_observe_change_no_collision() {
        let collisions = |variant| {
            let mut subject = CostSubject::new(variant).unwrap();
            subject.run(2).unwrap();
            subject.collisions()
        };
        let plain = collisions(Variant::Plain(1));
        for capability in [
            Capability::Tags,
            Capability::Subscriptions,
            Capability::Snapshots,
            Capability::Locked,
            Capability::ElasticityTable,
        ] {
            assert_eq!(
                collisions(Variant::With(capability, CapabilityLevel::Idle)),
                plain,
                "{capability:?}"
            );
        }
        assert_eq!(
            collisions(Variant::With(Capability::Tags, CapabilityLevel::Used)),
            plain
        );
    }
}
