//! The description of a scene: the contents of the box at the start, as TOML or built in code.
//!
//! Each struct here is a table of the scene file; unknown keys are errors. Lengths, masses and
//! times are in the user's units.

pub(crate) mod atom_spec;
pub(crate) mod bond_spec;
mod contained_gas;
pub(crate) mod container_spec;
pub(crate) mod distribution;
pub(crate) mod drag;
pub(crate) mod elasticity_spec;
pub(crate) mod ellipse_spec;
pub(crate) mod error;
pub(crate) mod expressions;
pub(crate) mod gas_spec;
pub(crate) mod gravity;
pub(crate) mod kick_momentum;
pub(crate) mod least_speed;
pub(crate) mod max_time;
pub(crate) mod measure_from;
pub(crate) mod measure_spec;
pub(crate) mod method_spec;
pub(crate) mod pair_spec;
pub(crate) mod piston_spec;
pub(crate) mod random;
pub(crate) mod reaction_spec;
pub(crate) mod region;
pub(crate) mod scene_text;
pub(crate) mod shear;
pub(crate) mod spelling;
pub(crate) mod stage_spec;
pub(crate) mod stop_spec;
pub(crate) mod thermostat_rule;
pub(crate) mod thermostat_target;
pub(crate) mod two_numbers;
pub(crate) mod units_spec;
pub(crate) mod wall_motion;
pub(crate) mod well_spec;

#[cfg(feature = "schema")]
use carom_geometry::{MAX_MAGNITUDE, MIN_MAGNITUDE, MIN_ROUNDING};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::{
    scene::{
        atom_spec::AtomSpec,
        bond_spec::BondSpec,
        container_spec::ContainerSpec,
        elasticity_spec::ElasticitySpec,
        ellipse_spec::EllipseSpec,
        gas_spec::{GasSpec, serialize_gases},
        gravity::GravitySpec,
        measure_from::MeasureFrom,
        measure_spec::MeasureSpec,
        method_spec::MethodSpec,
        pair_spec::{DiameterSpec, TransparentSpec},
        piston_spec::{PistonSpec, PushPistonSpec},
        reaction_spec::ReactionSpec,
        stage_spec::{HeatSpec, RelabelSpec, ThermostatSpec, VelocitySpec},
        stop_spec::StopSpec,
        two_numbers::{optional_vector, pairs, vector, vectors},
        units_spec::UnitsSpec,
        wall_motion::{MoveWallSpec, WallMotionSpec},
        well_spec::WellSpec,
    },
    world::body::Rotation,
};

/// A scene, read from a file or built in code.
///
/// ```
/// use carom_engine::{BumperSpec, GasSpec, Scene};
///
/// let mut scene = Scene::default();
/// scene.bumper.push(BumperSpec { radius: 0.05, at: [0.5, 0.5], tags: vec![] });
/// let gas = GasSpec { radius: Some(0.01.into()), mass: Some(1.0.into()), ..GasSpec::default() };
/// scene.gas.push(GasSpec { count: Some(100), ..gas });
/// let text = scene.to_toml();
/// assert_eq!(Scene::from_toml(&text)?, scene);
/// # Ok::<(), carom_engine::SceneError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Scene {
    /// The box and the seed.
    #[serde(rename = "box")]
    pub bounds: BoxSpec,
    /// Acceleration of all free bodies.
    #[serde(skip_serializing_if = "GravitySpec::is_none")]
    pub gravity: GravitySpec,
    /// Single molecules.
    pub molecule: Vec<MoleculeSpec>,
    /// Fixed discs.
    pub bumper: Vec<BumperSpec>,
    /// Walls, straight or curved, at rest or in a given motion.
    pub wall: Vec<WallSpec>,
    /// Walls with a mass, which contacts move.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub piston: Vec<PistonSpec>,
    /// Closed cavities that hold gases.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub container: Vec<ContainerSpec>,
    /// Many molecules of one kind each.
    #[serde(serialize_with = "serialize_gases")]
    pub gas: Vec<GasSpec>,
    /// Bodies tied to each other.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bond: Vec<BondSpec>,
    /// How the gases are placed.
    #[serde(skip_serializing_if = "StartSpec::is_default")]
    pub start: StartSpec,
    /// Coefficients of restitution.
    pub elasticity: ElasticitySpec,
    /// Pairs of bodies that do not see each other.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub transparent: Vec<TransparentSpec>,
    /// Discs whose contact distance is not the sum of their radii.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub diameter: Vec<DiameterSpec>,
    /// Discs that attract or repel each other in steps of the energy.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub well: Vec<WellSpec>,
    /// Reactions of bodies that collide.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub reaction: Vec<ReactionSpec>,
    /// How contacts are found and events ordered; exact by default. Used by `carom run`, not by
    /// [`Simulation::new`](crate::Simulation::new).
    #[serde(skip_serializing_if = "is_default")]
    pub method: MethodSpec,
    /// Duration of the run, and the quantities to observe.
    pub run: RunSpec,
    /// The stages of the run, in their order; without any, the run is one stage. Used by
    /// `carom run`, not by [`Simulation::new`](crate::Simulation::new).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stage: Vec<StageSpec>,
    /// Quantities to measure with parameters, besides those of `run.observe`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub measure: Vec<MeasureSpec>,
}

/// The periodic box, and the seed of all random numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct BoxSpec {
    /// Sides (length).
    #[cfg_attr(feature = "schema", schemars(inner(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE))))]
    #[serde(deserialize_with = "vector")]
    pub sides: [f64; 2],
    /// Seed; the streams for placement and velocities are derived from it.
    pub seed: u64,
    /// Index of the replica. Replicas differ in their random numbers only.
    pub replica: u64,
    /// Drag γ of all bodies (1/time): between contacts v' = −γ v and ω' = −γ ω. Default: 0.
    #[serde(skip_serializing_if = "is_zero")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = MAX_MAGNITUDE)))]
    #[doc(alias = "damping")]
    pub drag: f64,
    /// Shear rate γ (1/time): the images above and below the box move along x by ± γ Ly (Lees and
    /// Edwards). The velocities of the scene are those relative to the flow γ (y − Ly/2). Default:
    /// 0.
    #[serde(skip_serializing_if = "is_zero")]
    #[cfg_attr(feature = "schema", schemars(range(min = -MAX_MAGNITUDE, max = MAX_MAGNITUDE)))]
    #[doc(alias = "Lees-Edwards")]
    pub shear_rate: f64,
}

impl Default for BoxSpec {
    fn default() -> Self {
        Self {
            sides: [1.0, 1.0],
            seed: 0,
            replica: 0,
            drag: 0.0,
            shear_rate: 0.0,
        }
    }
}

/// A single molecule.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct MoleculeSpec {
    /// Tags of the molecule.
    pub tags: Vec<String>,
    /// A shape by name: `disc`, `dumbbell`, `rod:N`, `cross`, `tee`, `ring:N` of equal atoms, or
    /// `capsule:L`, `square`, `rectangle:A`, `triangle`, `polygon:N`, `kite:A,B`, `ellipse:K` of a
    /// `size`. One of this, `polygon`, and `atoms` or `ellipses`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<String>,
    /// The list of atoms. Excludes `shape` and `polygon`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub atoms: Vec<AtomSpec>,
    /// The list of ellipses, after the `atoms` if both are given. No two parts may overlap.
    /// Excludes `shape`, `polygon` and `edges`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ellipses: Vec<EllipseSpec>,
    /// Pairs of atoms of the list with a straight edge between them, as indices from 0. Only with
    /// `atoms`.
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "pairs")]
    pub edges: Vec<[u32; 2]>,
    /// Half the thickness of each edge (length). Default: the smaller radius of the two atoms at
    /// its ends, which it must not exceed.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub edge_radius: Option<f64>,
    /// Whether closed lines of edges are hollow: other bodies may then be inside. Default: their
    /// interior belongs to the molecule.
    #[serde(skip_serializing_if = "is_false")]
    pub hollow: bool,
    /// Corners of a polygon, convex or not, whose sides do not cross (length), in any frame.
    /// Excludes `shape`, `atoms` and `ellipses`.
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "vectors")]
    pub polygon: Vec<[f64; 2]>,
    /// Radius of the corners of a polygon over its size, which is `size`, or the largest distance
    /// of two corners of `polygon`. All points within this radius of the polygon belong to it. At
    /// least 1e-10, and the radius at least 1e-10 of the largest distance of two corners. Default:
    /// 1e-6.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_ROUNDING, max = MAX_MAGNITUDE)))]
    pub rounding: Option<f64>,
    /// Size of a named shape with sides or of an ellipse (length): a side, for a rectangle the one
    /// that is not A times as long; the diameter of a capsule, whose straight part is L times as
    /// long; the cross diagonal of a kite, whose tips are A and B times as far from it; the longer
    /// axis of an ellipse, K times the shorter one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub size: Option<f64>,
    /// Mass of a shape with sides, of a polygon or of an ellipse, spread evenly over its area
    /// (mass).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub mass: Option<f64>,
    /// Mass per area (mass / length²). The atoms of a named shape share the mass equally, those of
    /// a list in proportion to their masses. Excludes `mass` and `atom_mass`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub density: Option<f64>,
    /// Radius of each atom of a named shape (length).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub atom_radius: Option<f64>,
    /// Mass of each atom of a named shape (mass).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub atom_mass: Option<f64>,
    /// Position of the centre of mass (length).
    #[serde(deserialize_with = "vector")]
    pub at: [f64; 2],
    /// Orientation (radians), counter-clockwise. Excludes `orientation_turns`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation: Option<f64>,
    /// Orientation (turns), in which a half and a quarter are exact. Excludes `orientation`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation_turns: Option<f64>,
    /// Velocity (length / time).
    #[serde(deserialize_with = "vector")]
    pub velocity: [f64; 2],
    /// Angular velocity (radians per time); must be 0 for a disc, a locked and a fixed molecule.
    pub angular_velocity: f64,
    /// Whether the molecule turns (free) or not (locked).
    pub rotation: Rotation,
    /// Whether the molecule never moves: the limit of infinite mass.
    pub fixed: bool,
}

/// A fixed disc.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct BumperSpec {
    /// Tags of the bumper.
    #[serde(default)]
    pub tags: Vec<String>,
    /// Radius (length).
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub radius: f64,
    /// Position of the centre (length).
    #[serde(deserialize_with = "vector")]
    pub at: [f64; 2],
}

/// A straight wall of infinite mass that reflects on both sides: a segment between two points, or a
/// line across the whole box.
///
/// ```
/// use carom_engine::{Scene, Simulation};
///
/// // A closed box, whose lines meet themselves across the periodic borders, with a flap inside.
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct WallSpec {
    /// Tags of the wall.
    pub tags: Vec<String>,
    /// One end (length). With `to`; excludes `x` and `y`.
    #[serde(
        deserialize_with = "optional_vector",
        skip_serializing_if = "Option::is_none"
    )]
    pub from: Option<[f64; 2]>,
    /// The other end (length); it may lie outside the box.
    #[serde(
        deserialize_with = "optional_vector",
        skip_serializing_if = "Option::is_none"
    )]
    pub to: Option<[f64; 2]>,
    /// The wall is an arc of a circle. Excludes `from`, `to`, `x` and `y`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arc: Option<ArcSpec>,
    /// The wall is the line of all points with this x (length).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<f64>,
    /// The wall is the line of all points with this y (length).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<f64>,
    /// Half the thickness (length): the wall includes all points within this distance of it; 0 for
    /// a wall without thickness.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = MAX_MAGNITUDE)))]
    pub radius: f64,
    /// Temperature kT (mass × length² / time²), from 1e-60 to 1e60: bodies leave the wall, on both
    /// sides, with random velocities of this temperature, whatever their velocities were. Their
    /// distribution is Maxwell's weighted by the speed at which the point of contact leaves, for
    /// molecules including their rotation ([`thermal_motion`](carom_response::thermal_motion)).
    /// Elasticities have no effect on such contacts. [`Ledger::heat`](crate::Ledger::heat) is the
    /// energy received. Without a temperature the wall is smooth and reflects. A body that turns
    /// leaves with a spin that is not the effect of its impulse: the change of its angular momentum
    /// is not r × J.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[doc(alias = "thermostat")]
    #[doc(alias = "diffuse reflection")]
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub temperature: Option<f64>,
    /// The motion of the wall from the start on, or from its insertion. Its work on the bodies that
    /// it meets is [`Ledger::work`](crate::Ledger::work). A run ends when the wall meets another
    /// wall or a fixed body from which it was apart. Default: at rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[doc(alias = "piston")]
    pub motion: Option<WallMotionSpec>,
}

/// An arc of a circle, or the whole circle: a curved wall, of which both sides can be touched.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ArcSpec {
    /// Centre of the circle (length).
    #[serde(deserialize_with = "vector")]
    pub at: [f64; 2],
    /// Radius of the circle (length).
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub radius: f64,
    /// Direction from the centre to the first end (radians). Default: 0.
    #[serde(default)]
    pub from: f64,
    /// Direction from the centre to the last end (radians), counter-clockwise from the first by
    /// 0.002 to 2π − 0.002, or by 2π. Default: 2π.
    #[serde(default = "whole_turn")]
    pub to: f64,
    /// Whether only the inner side can be touched: for an arc that is part of a closed border,
    /// outside which there is no body. What comes from outside passes. Bodies with straight sides
    /// need it.
    #[serde(default, skip_serializing_if = "is_default")]
    pub one_sided: bool,
}

fn whole_turn() -> f64 {
    std::f64::consts::TAU
}

/// How the gases of a scene are placed, all together.
///
/// ```
/// use carom_engine::{Scene, Simulation};
///
/// // No lattice holds 60 tees at this density: they are grown.
/// let scene = Scene::from_toml(r#"
///     [start]
///     relax = 20
///     [[gas]]
///     shape = "tee"
///     atom_radius = 0.025
///     atom_mass = 1.0
///     energy = 1.0
///     count = 60
/// "#)?;
/// let simulation = Simulation::new(&scene)?;
/// let area: f64 = simulation.view().bodies().map(|body| body.body.molecule().area()).sum();
/// assert!(area > 0.58);
/// assert_eq!(simulation.view().overlaps().pairs, 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct StartSpec {
    /// The method. Default: a lattice if the gases fit on one, else growth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub placement: Option<Placement>,
    /// Relaxation before the run: collisions a molecule of the gases (two molecules share one
    /// collision), from 0 to 1e9. Default: 1000 after growth, 0 on a lattice.
    ///
    /// All contacts are elastic, whatever the elasticity of the scene; each `[[molecule]]` is held
    /// at its place, and has its own velocity at the end. The total energy of the gases is that of
    /// the scene, as is their momentum along an axis on which it is conserved; but collisions share
    /// the energy among all gases. Gases without energy are not relaxed. Dilute gases are relaxed
    /// for at most the time in which a molecule at the root mean square speed crosses the longer
    /// side of the box as many times.
    ///
    /// A state just grown is not in equilibrium: its pressure falls for about a thousand collisions
    /// a molecule.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 1e9)))]
    pub relax: Option<f64>,
    /// If true, no molecule of a gas is placed in a pocket of a `[[molecule]]`, such as the hole of
    /// a ring, which it could never leave. Only on a lattice: gases that do not fit on one are then
    /// refused. Default: false.
    #[serde(skip_serializing_if = "is_default")]
    pub empty_pockets: bool,
    /// A file of extended XYZ, a GSD file of HOOMD or a LAMMPS dump with the places of all atoms of
    /// the scene, relative to the folder of the scene file: bodies start there, with the
    /// orientations and velocities of the file if it has them. Excludes `placement` and `relax`.
    ///
    /// `carom run` writes such files as snapshots, and other programs do. The atoms are those of
    /// the single molecules, the bumpers and the gases, in order; fixed bodies may be left out. A
    /// box, a radius or a place of a fixed body other than in the scene is refused, as are overlaps
    /// and molecules with displaced atoms. Vectors have two components, or a third that is 0. Atoms
    /// may lie outside the box by up to one side.
    /// Orientations and velocities that the file lacks are drawn as for a gas on a lattice; a
    /// `[[molecule]]` then keeps its own. The run starts at time 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<String>,
    /// The frame of that file, from 0. Default: the last.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<usize>,
    /// CRC-32 (IEEE 802.3) of the text of that frame: another text is refused. `carom run` enters
    /// it, so that a run is resumed with the same start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub checksum: Option<u32>,
    /// The text of that frame. Programs set it, as [`frame_of`](crate::frame_of) returns it: the
    /// engine reads no files.
    #[serde(skip)]
    pub snapshot: Option<Arc<str>>,
}

/// A method to place gases.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Placement {
    /// Sites of a triangular lattice of bounding circles: for low densities.
    Lattice,
    /// Growth of the molecules from a dilute state; see [`Growth`](crate::Growth). For all
    /// densities up to jamming.
    #[doc(alias = "compression")]
    Grown,
}

impl StartSpec {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Duration of the run, and the quantities to observe.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct RunSpec {
    /// End of the run (time).
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0.0)))]
    pub until: f64,
    /// Interval between samples, for snapshots and time series (time); the old key `standby` is
    /// also read.
    #[serde(alias = "standby")]
    #[doc(alias = "standby")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0.0)))]
    pub sample_interval: f64,
    /// Interval between snapshots (time). Default: `sample_interval`. Only with `snapshots`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0.0)))]
    pub snapshot_interval: Option<f64>,
    /// Interval between checks for overlaps (time). Default: `sample_interval`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0.0)))]
    pub check_interval: Option<f64>,
    /// Quantities are averaged from the first sample at or after this time on, so that the approach
    /// to equilibrium does not count (time); from 0 to less than `until`. `"auto"`: the
    /// measurement starts when no mean changes any more, which is judged after 64 samples, and then
    /// after twice as many as before. The short form of a stage that is not measured, and not
    /// allowed with stages.
    #[serde(skip_serializing_if = "MeasureFrom::is_start")]
    pub measure_from: MeasureFrom,
    /// Names of the quantities to measure; `carom measures` lists them.
    pub observe: Vec<String>,
    /// Format of snapshots; none if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub snapshots: Option<String>,
    /// Whether the report includes an animation of the motion.
    #[serde(skip_serializing_if = "is_true")]
    pub animation: bool,
    /// Start of the animation (time); from 0 to less than `until`.
    #[serde(skip_serializing_if = "is_zero")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub animation_from: f64,
    /// What ends the run before `until`; nothing if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stop: Option<StopSpec>,
    /// The units of the figures and charts on the page, and of the figures in the terminal:
    /// `"reduced"`, which takes the diameter and the mass of the discs of the first gas that moves,
    /// and its `temperature`; or `{ length = σ, mass = m, energy = ε }` in the units of the scene,
    /// each from 1e-60 to 1e60. The unit of time is σ √(m/ε). All other entries, files, `--json`
    /// and the results in Python keep the units of the scene. Default: those of the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[doc(alias = "lj")]
    pub units: Option<UnitsSpec>,
}

/// A stage of a run: edits at its start, thermostats while it lasts, and whether it is measured.
///
/// A stage starts where the one before it ends, the first at time 0. Its edits are made together or
/// not at all, in the order `remove`, `add`, `add_wall`, `move_wall`, `push_piston`, `tag`,
/// `untag`, `elasticity`, `drag`, `gravity`, `shear_rate`, `transparent`, `well`, `reaction`,
/// `unbond`, `bond`, `lock`, `unlock`, `set_energy`, `set_velocity`; those of the first stage
/// before the first sample. At one instant, first a sample
/// is taken, then a stage starts, then thermostats act in the order of their list. Instants that
/// differ by less than 1e-9 of the shortest interval of the run are one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct StageSpec {
    /// A name, for `carom check` and the report.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// End of the stage (time), later than that of the stage before.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0.0)))]
    pub until: f64,
    /// Whether the quantities of `run.observe` are averaged over this stage. Stages that are
    /// measured must follow on one another: their samples form one average. Default: `true`.
    #[serde(skip_serializing_if = "is_true")]
    pub measure: bool,
    /// Tags of bodies to remove.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub remove: Vec<String>,
    /// Molecules to add.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub add: Vec<MoleculeSpec>,
    /// Walls to add.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub add_wall: Vec<WallSpec>,
    /// Walls whose motion is replaced.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub move_wall: Vec<MoveWallSpec>,
    /// Pistons whose force is replaced.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub push_piston: Vec<PushPistonSpec>,
    /// Tags that bodies get.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tag: Vec<RelabelSpec>,
    /// Tags that bodies lose.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub untag: Vec<RelabelSpec>,
    /// The elasticity of all contacts from here on; it replaces `[elasticity]` as a whole.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[doc(alias = "quench")]
    pub elasticity: Option<ElasticitySpec>,
    /// The drag of all bodies from here on (1/time); it replaces `box.drag`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = MAX_MAGNITUDE)))]
    pub drag: Option<f64>,
    /// The gravity from here on (length per time squared); it replaces `gravity.acceleration`.
    #[serde(
        skip_serializing_if = "Option::is_none",
        deserialize_with = "optional_vector"
    )]
    #[cfg_attr(feature = "schema", schemars(inner(range(min = -MAX_MAGNITUDE, max = MAX_MAGNITUDE))))]
    pub gravity: Option<[f64; 2]>,
    /// The shear rate from here on (1/time); it replaces `box.shear_rate`. Velocities do not
    /// change.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = -MAX_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub shear_rate: Option<f64>,
    /// Pairs of bodies that do not see each other from here on; it replaces `[[transparent]]` as a
    /// whole. Bodies that overlap and would see each other again are refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transparent: Option<Vec<TransparentSpec>>,
    /// The wells from here on; it replaces `[[well]]` as a whole. Velocities do not change.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub well: Option<Vec<WellSpec>>,
    /// The reactions from here on; it replaces `[[reaction]]` as a whole.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reaction: Option<Vec<ReactionSpec>>,
    /// Bonds that are added.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bond: Vec<BondSpec>,
    /// Tags of bodies that lose all their bonds.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unbond: Vec<String>,
    /// Tags of bodies whose orientation is locked.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lock: Vec<String>,
    /// Tags of bodies that can turn again.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unlock: Vec<String>,
    /// Bodies whose energies are set once.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub set_energy: Vec<HeatSpec>,
    /// Bodies whose velocities are set once.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub set_velocity: Vec<VelocitySpec>,
    /// Thermostats that act at regular times while the stage lasts.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub thermostat: Vec<ThermostatSpec>,
}

impl Default for StageSpec {
    fn default() -> Self {
        Self {
            name: None,
            until: 0.0,
            measure: true,
            remove: Vec::new(),
            add: Vec::new(),
            add_wall: Vec::new(),
            move_wall: Vec::new(),
            push_piston: Vec::new(),
            tag: Vec::new(),
            untag: Vec::new(),
            elasticity: None,
            drag: None,
            gravity: None,
            shear_rate: None,
            transparent: None,
            well: None,
            reaction: None,
            bond: Vec::new(),
            unbond: Vec::new(),
            lock: Vec::new(),
            unlock: Vec::new(),
            set_energy: Vec::new(),
            set_velocity: Vec::new(),
            thermostat: Vec::new(),
        }
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_false(value: &bool) -> bool {
    !*value
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_true(value: &bool) -> bool {
    *value
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_one(value: &f64) -> bool {
    *value == 1.0
}

fn one() -> f64 {
    1.0
}

impl Default for RunSpec {
    fn default() -> Self {
        Self {
            until: 1.0,
            sample_interval: 1.0,
            snapshot_interval: None,
            check_interval: None,
            measure_from: MeasureFrom::default(),
            observe: Vec::new(),
            snapshots: None,
            animation: true,
            animation_from: 0.0,
            stop: None,
            units: None,
        }
    }
}
