//! The engines under test, and helpers that build scenes.

use carom::{
    CellScheduler, Detection, Exact, GoldenSecant, HeapScheduler, Impact, Orientation, Scene, SceneError,
    Scheduler, Simulation,
    engine::{GasSpec, MoleculeSpec},
};
use glam::DVec2;

/// A detector and a scheduler: the parts in which the compared engines differ.
pub trait Engine: 'static {
    /// The detector of contacts.
    type Detector: Detection + Default + Clone + 'static;
    /// The scheduler of events.
    type Scheduler: Scheduler;
    /// Name in tables.
    const NAME: &'static str;

    /// Builds a simulation of the scene.
    ///
    /// # Errors
    /// The scene cannot be built.
    fn simulate(scene: &Scene) -> Result<Run<Self>, SceneError> {
        Simulation::with(
            scene,
            Self::Detector::default(),
            Impact,
            <Self::Scheduler as Scheduler>::Options::default(),
        )
    }
}

/// A simulation with the parts of an engine.
pub type Run<E> = Simulation<<E as Engine>::Detector, Impact, <E as Engine>::Scheduler>;

/// The exact detector with the fast scheduler.
pub enum Ours {}

impl Engine for Ours {
    type Detector = Exact;
    type Scheduler = CellScheduler;
    const NAME: &'static str = "Exact, CellScheduler";
}

/// The golden-section and secant search of the thesis, with a heap of all events.
pub enum Theses {}

impl Engine for Theses {
    type Detector = GoldenSecant;
    type Scheduler = HeapScheduler;
    const NAME: &'static str = "GoldenSecant, HeapScheduler";
}

/// A gas with energy 1 for each molecule.
pub fn gas(shape: &str, radius: f64, atom_mass: f64, count: usize) -> GasSpec {
    GasSpec {
        shape: Some(shape.to_owned()),
        radius: Some(radius),
        mass: Some(atom_mass),
        energy: 1.0,
        count: Some(count),
        ..GasSpec::default()
    }
}

/// Single molecules in a box.
pub fn in_box(sides: [f64; 2], molecule: Vec<MoleculeSpec>) -> Scene {
    let mut scene = Scene { molecule, ..Scene::default() };
    scene.bounds.sides = sides;
    scene.bounds.seed = 20_261_122;
    scene
}

/// Unit vectors in evenly spread directions that never repeat: multiples of the golden ratio of a
/// turn.
pub fn directions() -> impl Iterator<Item = DVec2> {
    (1..).map(|k: u32| Orientation::from_turns(f64::from(k) * 0.618_033_988_749_894_9).cos_sin())
}
