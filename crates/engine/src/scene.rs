//! The description of a scene: what is in the box at the start, as TOML or by code.
//!
//! Every struct here is a table of the scene file; unknown keys are errors. Lengths, masses and times are in
//! the user's units.

use serde::{Deserialize, Serialize};

use crate::{Rotation, SceneError};

/// A scene, as a file describes it and as the library builds it.
///
/// ```
/// use carom_engine::{BumperSpec, GasSpec, Scene};
///
/// let mut scene = Scene::default();
/// scene.bumper.push(BumperSpec { radius: 0.05, at: [0.5, 0.5], tags: vec![] });
/// scene.gas.push(GasSpec { radius: Some(0.01), mass: Some(1.0), count: Some(100), ..GasSpec::default() });
/// let text = scene.to_toml();
/// assert_eq!(Scene::from_toml(&text)?, scene);
/// # Ok::<(), carom_engine::SceneError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scene {
    /// The box and the seed.
    #[serde(rename = "box")]
    pub bounds: BoxSpec,
    /// Single molecules.
    pub molecule: Vec<MoleculeSpec>,
    /// Fixed discs.
    pub bumper: Vec<BumperSpec>,
    /// Fixed straight walls.
    pub wall: Vec<WallSpec>,
    /// Many molecules of one kind each.
    pub gas: Vec<GasSpec>,
    /// How much of the speed of approach comes back.
    pub elasticity: ElasticitySpec,
    /// How long to run and what to watch.
    pub run: RunSpec,
}

/// The periodic box, and the seed of all random numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BoxSpec {
    /// Sides (length).
    pub sides: [f64; 2],
    /// Seed; the streams for placement and velocities are derived from it.
    pub seed: u64,
    /// Which of many runs that differ in nothing but their random numbers.
    pub replica: u64,
}

impl Default for BoxSpec {
    fn default() -> Self {
        Self { sides: [1.0, 1.0], seed: 0, replica: 0 }
    }
}

/// One atom of a molecule given by its list.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AtomSpec {
    /// Offset in any frame (length).
    pub at: [f64; 2],
    /// Radius (length).
    pub radius: f64,
    /// Mass.
    pub mass: f64,
}

/// A single molecule.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MoleculeSpec {
    /// Names of groups it belongs to.
    pub tags: Vec<String>,
    /// A shape by name: `disc`, `dumbbell`, `rod:N`, `cross`, `tee`, `ring:N`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<String>,
    /// Or its atoms.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub atoms: Vec<AtomSpec>,
    /// Radius of each atom of a named shape (length).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub atom_radius: Option<f64>,
    /// Mass of each atom of a named shape.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub atom_mass: Option<f64>,
    /// Place of the centre of mass (length).
    pub at: [f64; 2],
    /// Radians, counter-clockwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation: Option<f64>,
    /// Or turns, where a half and a quarter are exact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation_turns: Option<f64>,
    /// Velocity (length / time).
    pub velocity: [f64; 2],
    /// Radians per time; must be 0 for a disc, a locked and a fixed molecule.
    pub angular_velocity: f64,
    /// Free or locked.
    pub rotation: Rotation,
    /// Nothing moves it: the limit of infinite mass.
    pub fixed: bool,
}

/// A fixed disc.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BumperSpec {
    /// Names of groups it belongs to.
    #[serde(default)]
    pub tags: Vec<String>,
    /// Radius (length).
    pub radius: f64,
    /// Place of the centre (length).
    pub at: [f64; 2],
}

/// A fixed straight wall, reflecting on both sides: from one point to another, or a line across the whole box.
///
/// ```
/// use carom_engine::{Scene, Simulation};
///
/// // A closed box: the lines close on themselves through the periodic borders. And a flap in it.
/// let scene = Scene::from_toml(r#"
///     [[wall]]
///     x = 0.0
///     [[wall]]
///     y = 0.0
///     [[wall]]
///     from = [0.5, 0.0]
///     to = [0.5, 0.3]
///     [[gas]]
///     radius = 0.02
///     mass = 1.0
///     energy = 1.0
///     count = 50
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// simulation.run_until(1.0)?;
/// assert_eq!(simulation.view().overlaps().pairs, 0);
/// assert!(simulation.view().counters().fixed_collisions > 10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WallSpec {
    /// Names of groups it belongs to.
    pub tags: Vec<String>,
    /// One end (length).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<[f64; 2]>,
    /// The other end (length); it need not lie in the box.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<[f64; 2]>,
    /// Or the line of all points with this x (length).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<f64>,
    /// Or the line of all points with this y (length).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<f64>,
    /// What is within this distance of it belongs to the wall (length); 0 for one without thickness.
    pub radius: f64,
}

/// Many molecules of one kind, placed without overlap, moving in random directions.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GasSpec {
    /// Names of groups they belong to.
    pub tags: Vec<String>,
    /// A shape by name; `disc` if neither this nor atoms are given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<String>,
    /// Or the atoms.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub atoms: Vec<AtomSpec>,
    /// Radius of each atom of a named shape (length).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub atom_radius: Option<f64>,
    /// Mass of each atom of a named shape.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub atom_mass: Option<f64>,
    /// Radius of a disc: the same as `atom_radius` (length).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// Mass of a disc: the same as `atom_mass`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Energy of each at the start, shared over its degrees of freedom by equipartition
    /// (mass × length² / time²).
    pub energy: f64,
    /// Share of the whole box that they cover, with overlaps of atoms counted once; rounded to the
    /// nearest number of molecules. A share above 0 that rounds to no molecule is refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub area_fraction: Option<f64>,
    /// Or how many there are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
    /// Whether the total momentum of this gas is 0 at the start: all have one speed, and their
    /// directions are drawn in opposite pairs (three of an odd number a third of a turn apart). If
    /// absent, so it is wherever momentum is conserved along an axis: in a scene without fixed
    /// bodies, or whose only fixed bodies are parallel walls across the whole box. `false`:
    /// directions are independent of each other, and the gas drifts as a whole.
    ///
    /// One molecule with energy cannot have momentum 0: `true` is refused for a gas of one, and if
    /// absent, it moves. The total momentum of a scene with such a gas, or with a `[[molecule]]`
    /// that moves, is therefore not 0 in general.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zero_momentum: Option<bool>,
    /// Free or locked.
    pub rotation: Rotation,
}

/// Elasticity of contacts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ElasticitySpec {
    /// Where no rule applies.
    pub default: f64,
    /// Guard against inelastic collapse, for contacts of elasticity below 1: one that follows on the last ones of both
    /// bodies (of the one that moves, if the other is fixed) within this time loses no energy. In units of the time in
    /// which the two, as they come together, move by the smaller one's diameter. Molecules that turn also part no slower
    /// than with this share of the speed at which they move past each other. 0, which is no guard, or from 1e-5 to 1.
    ///
    /// Larger: more contacts of a dense gas are spared that should lose energy, in proportion (of discs at an area
    /// fraction of 0.5, about as many as this number says). Smaller: bodies that lie against each other have more
    /// contacts, and in the end such flat ones that rounding lets turning molecules sink into each other; at 0 they may
    /// have contacts without end. What is spared stands in [`Counters::guarded_collisions`](crate::Counters::guarded_collisions)
    /// and [`Ledger::spared`](crate::Ledger::spared).
    #[doc(alias = "inelastic collapse")]
    pub contact_time: f64,
    /// Rules by tags.
    pub pair: Vec<ElasticityRule>,
}

impl Default for ElasticitySpec {
    fn default() -> Self {
        Self { default: 1.0, contact_time: 1e-4, pair: Vec::new() }
    }
}

/// Elasticity of contacts between bodies of certain tags.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ElasticityRule {
    /// Two tags, or one: then contacts of bodies with that tag with anything.
    pub between: Vec<String>,
    /// The coefficient of restitution.
    pub coefficient: f64,
}

/// How long to run, and what to watch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RunSpec {
    /// When the run ends (time).
    pub until: f64,
    /// Interval of snapshots and series (time); also read as `standby`.
    #[serde(alias = "standby")]
    #[doc(alias = "standby")]
    pub sample_interval: f64,
    /// What is measured.
    pub observe: Vec<String>,
    /// Format of snapshots; none if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub snapshots: Option<String>,
    /// Whether the report has an animation of the flights.
    #[serde(skip_serializing_if = "is_true")]
    pub animation: bool,
    /// When the animation starts (time); from 0 to before `until`.
    #[serde(skip_serializing_if = "is_zero")]
    pub animation_from: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_true(value: &bool) -> bool {
    *value
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Default for RunSpec {
    fn default() -> Self {
        Self {
            until: 1.0,
            sample_interval: 1.0,
            observe: Vec::new(),
            snapshots: None,
            animation: true,
            animation_from: 0.0,
        }
    }
}

impl Scene {
    /// Reads a scene from the text of a scene file.
    ///
    /// # Errors
    /// [`SceneError::Syntax`] with line and key if the text is not TOML or has unknown or missing keys. What
    /// the numbers mean is checked when a simulation is built.
    pub fn from_toml(text: &str) -> Result<Self, SceneError> {
        let scene: Self = toml::from_str(text).map_err(|error| SceneError::Syntax(error.to_string()))?;
        let table: toml::Table = text.parse().map_err(|error| SceneError::Syntax(format!("{error}")))?;
        require(&table, "molecule", "at")?;
        require(&table, "gas", "energy")?;
        Ok(scene)
    }

    /// The scene as the text of a scene file.
    ///
    /// # Panics
    /// Never: a scene is plain data.
    pub fn to_toml(&self) -> String {
        toml::to_string_pretty(self).expect("a scene is plain data, which TOML can always hold")
    }
}

/// Refuses entries that leave out a key without which they would be something else than meant: by code there is a default
/// to start from, in a file its absence is a slip.
fn require(table: &toml::Table, entries: &str, key: &str) -> Result<(), SceneError> {
    let Some(toml::Value::Array(list)) = table.get(entries) else { return Ok(()) };
    match list.iter().position(|entry| entry.get(key).is_none()) {
        None => Ok(()),
        Some(index) => Err(SceneError::Entry {
            entry: format!("{entries}[{index}]"),
            problem: format!("`{key}` is missing"),
        }),
    }
}
