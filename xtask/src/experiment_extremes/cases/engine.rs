//! The engines that are put to the test, and scenes in a few words.

use carom::{
    Cells, Detection, Exact, GoldenSecant, Impact, Orientation, Scene, SceneError, Scheduler, Simulation,
    Thesis,
    engine::{AtomSpec, BodyView, BumperSpec, GasSpec, MoleculeSpec, Rotation, View},
};
use glam::DVec2;

/// A detector and a scheduler: what is exchanged between the engines that are compared.
pub trait Engine: 'static {
    /// How contacts are found.
    type Detector: Detection + Default + Clone + 'static;
    /// How events are ordered.
    type Scheduler: Scheduler;
    /// What it is called in tables.
    const NAME: &'static str;

    /// A simulation of the scene.
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

/// A simulation by such an engine.
pub type Run<E> = Simulation<<E as Engine>::Detector, Impact, <E as Engine>::Scheduler>;

/// The exact detector with the fast scheduler.
pub enum Ours {}

impl Engine for Ours {
    type Detector = Exact;
    type Scheduler = Cells;
    const NAME: &'static str = "Exact, Cells";
}

/// The thesis's search and the thesis's heap of all events.
pub enum Theses {}

impl Engine for Theses {
    type Detector = GoldenSecant;
    type Scheduler = Thesis;
    const NAME: &'static str = "GoldenSecant, Thesis";
}

/// One disc.
pub fn disc(radius: f64, mass: f64, at: [f64; 2], velocity: [f64; 2]) -> MoleculeSpec {
    MoleculeSpec { velocity, ..named("disc", radius, mass, at) }
}

/// A molecule at rest, by the name of its shape.
pub fn named(shape: &str, atom_radius: f64, atom_mass: f64, at: [f64; 2]) -> MoleculeSpec {
    MoleculeSpec {
        shape: Some(shape.to_owned()),
        atom_radius: Some(atom_radius),
        atom_mass: Some(atom_mass),
        at,
        ..MoleculeSpec::default()
    }
}

/// A fixed disc.
pub fn bumper(radius: f64, at: [f64; 2]) -> BumperSpec {
    BumperSpec { tags: Vec::new(), radius, at }
}

/// A gas of energy 1 each.
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

/// Unit vectors in directions that are spread evenly and never repeat: multiples of the golden ratio of a turn.
pub fn directions() -> impl Iterator<Item = DVec2> {
    (1..).map(|k: u32| Orientation::from_turns(f64::from(k) * 0.618_033_988_749_894_9).cos_sin())
}

/// The bodies of a view as single molecules that begin where the view stands; walls are left out.
pub fn frozen(view: &View<'_>) -> Scene {
    let spec = |body: &BodyView<'_>| MoleculeSpec {
        atoms: body
            .body
            .molecule()
            .atoms()
            .iter()
            .map(|atom| AtomSpec { at: atom.offset().to_array(), radius: atom.radius(), mass: atom.mass() })
            .collect(),
        at: body.motion.position.to_array(),
        orientation_turns: Some(body.motion.orientation.turns()),
        velocity: body.motion.velocity.to_array(),
        angular_velocity: body.motion.angular_velocity,
        rotation: if body.body.is_locked() { Rotation::Locked } else { Rotation::Free },
        fixed: body.body.is_fixed(),
        ..MoleculeSpec::default()
    };
    let molecules = view.bodies().filter(|body| !body.body.is_wall()).map(|body| spec(&body)).collect();
    in_box(view.bounds().sides().to_array(), molecules)
}
