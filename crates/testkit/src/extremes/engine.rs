//! The engines under test, and helpers that build scenes.

use carom::{
    CellsPerSide, Exact, GoldenSecant, Instructions, Orientation, Scene, SceneError,
    engine::{GasSpec, MoleculeSpec},
};
use carom_methods::{AnyDetector, AnySimulation, Method, Order};
use glam::DVec2;

/// A detector and a scheduler: the parts in which the compared engines differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Engine {
    /// The exact detector with the fast scheduler.
    Default,
    /// The golden-section and secant search of the thesis, with a heap of all events.
    Thesis,
}

impl Engine {
    /// Name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Default => "Exact, CellScheduler",
            Self::Thesis => "GoldenSecant, HeapScheduler",
        }
    }

    /// The detector of contacts.
    pub fn detector(self) -> AnyDetector {
        match self {
            Self::Default => AnyDetector::Exact(Exact::default()),
            Self::Thesis => AnyDetector::GoldenSecant(GoldenSecant::default()),
        }
    }

    /// Builds a simulation of the scene.
    ///
    /// # Errors
    /// The scene cannot be built.
    pub fn simulate(self, scene: &Scene) -> Result<AnySimulation, SceneError> {
        let order = match self {
            Self::Default => Order::Cells(Instructions::Widest),
            Self::Thesis => Order::Heap(CellsPerSide::Automatic),
        };
        AnySimulation::with(
            scene,
            &Method {
                detector: self.detector(),
                order,
                ..Method::default()
            },
        )
    }
}

/// A gas with energy 1 for each molecule.
pub fn gas(shape: &str, radius: f64, atom_mass: f64, count: usize) -> GasSpec {
    GasSpec {
        shape: Some(shape.to_owned()),
        radius: Some(radius.into()),
        mass: Some(atom_mass.into()),
        energy: 1.0,
        count: Some(count),
        ..GasSpec::default()
    }
}

/// Single molecules in a box.
pub fn in_box(sides: [f64; 2], molecule: Vec<MoleculeSpec>) -> Scene {
    let mut scene = Scene {
        molecule,
        ..Scene::default()
    };
    scene.bounds.sides = sides;
    scene.bounds.seed = 20_261_122;
    scene
}

/// Unit vectors in evenly spread directions that never repeat: multiples of the golden ratio of a
/// turn.
pub fn directions() -> impl Iterator<Item = DVec2> {
    (1..).map(|k: u32| Orientation::from_turns(f64::from(k) * 0.618_033_988_749_894_9).cos_sin())
}
