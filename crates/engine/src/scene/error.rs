//! Errors: invalid scenes and edits, and the reasons why a run ends early.

use carom_geometry::{EdgedShape, GeometryError, MAX_MAGNITUDE, Shape};
use carom_kinematics::EpochTime;
use carom_response::ElasticityError;
use thiserror::Error;

use crate::{
    scene::{least_speed::MIN_SPEED, max_time::MAX_TIME, spelling::did_you_mean},
    world::body::{BodyKey, BodyName},
};

/// A scene that cannot be built. The message names the entry.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The text is not TOML, or has unknown or missing keys.
    #[error("the scene file cannot be read: {0}")]
    Syntax(String),
    /// A number or a shape of an entry is out of range.
    #[error("{entry}: {reason}{}", nearest_shape(reason))]
    Geometry {
        /// The entry, such as `gas[0]`.
        entry: String,
        /// The reason.
        reason: GeometryError,
    },
    /// An elasticity is out of range.
    #[error("{entry}: {reason}")]
    Elasticity {
        /// The entry.
        entry: String,
        /// The reason.
        reason: ElasticityError,
    },
    /// A key of an entry is missing, or two keys exclude each other.
    #[error("{entry}: {problem}")]
    Entry {
        /// The entry.
        entry: String,
        /// Description of the problem.
        problem: String,
    },
    /// A body moves or turns so slowly that the squares of its speed underflow.
    #[error(
        "{entry}: {quantity} must be 0 or at least {MIN_SPEED:e}, but is {speed:e} (slower bodies would pass \
         through each other); choose a longer unit of time"
    )]
    TooSlow {
        /// The entry.
        entry: String,
        /// Name of the speed.
        quantity: &'static str,
        /// The speed (length per time).
        speed: f64,
    },
    /// Two bodies overlap at the start.
    #[error("{first} and {second} overlap by {}; move them apart", short(*depth))]
    Overlap {
        /// The first entry.
        first: String,
        /// The second entry.
        second: String,
        /// Depth of the overlap (length).
        depth: f64,
    },
    /// A gas does not fit into the box.
    #[error("{entry}: only {placed} of {requested} molecules can be placed without overlap; {}", room(*placed))]
    Full {
        /// The entry.
        entry: String,
        /// Number of molecules that could be placed.
        placed: usize,
        /// Number of molecules requested.
        requested: usize,
    },
    /// The gases jam before they have grown to their size: at this density they cannot be placed.
    #[error(
        "the gases jam at an area fraction of {}, below the {} that they would cover: {smaller} of {molecules} \
         molecules, with a share of {} of the area of the gases, are still smaller than in the scene, the smallest \
         by a factor of {smallest_scale:.4}, and no longer grow; reduce their number or their size",
        short(*reached),
        short(*requested),
        short(*area_share)
    )]
    Jammed {
        /// Area of the gases where they jam, as a share of the box.
        reached: f64,
        /// Area of the gases of the scene, as a share of the box.
        requested: f64,
        /// Number of molecules that have not reached their size.
        smaller: usize,
        /// Number of molecules of the gases.
        molecules: usize,
        /// Area of the molecules that have not reached their size, as a share of `requested`, from
        /// 0 to 1.
        area_share: f64,
        /// Scale of the smallest molecule, from 0 to 1, the size in the scene.
        smallest_scale: f64,
    },
    /// A run in which the gases grow or relax has ended early.
    #[error("the gases cannot be grown and relaxed: {0}")]
    Growth(Box<RunError>),
    /// The state of a growth is not one that a growth has written.
    #[error("the state of the growth {0}")]
    GrowthState(&'static str),
    /// The caller has interrupted the placement.
    #[error("the placement of the gases has been interrupted")]
    Interrupted,
    /// Two rules of elasticity of equal rank apply to a pair of existing bodies with different
    /// coefficients.
    #[error(
        "elasticity rules for {first:?} and {second:?} apply to the same bodies with different coefficients, {one} \
         and {other}; make them equal or remove one"
    )]
    AmbiguousElasticity {
        /// Tags of the first rule.
        first: Vec<String>,
        /// Tags of the second rule.
        second: Vec<String>,
        /// Coefficients of the first rule.
        one: String,
        /// Coefficients of the second rule.
        other: String,
    },
    /// The bodies do not fit the grid or the box.
    #[error("{entry}: {reason}")]
    Grid {
        /// The entries or bodies that cause the error, or the grid itself.
        entry: String,
        /// The reason.
        reason: GridError,
    },
}

/// The named shape nearest to an unknown one.
fn nearest_shape(reason: &GeometryError) -> String {
    match reason {
        GeometryError::UnknownShape(name) => {
            did_you_mean(name, Shape::NAMES.into_iter().chain(EdgedShape::NAMES))
        }
        _ => String::new(),
    }
}

/// A number from 0 on with four digits.
pub(crate) fn short(number: f64) -> String {
    if number >= 1e-3 {
        format!("{number:.4}")
    } else {
        format!("{number:.3e}")
    }
}

/// What to do if no more molecules can be placed.
fn room(placed: usize) -> &'static str {
    if placed == 0 {
        "there is no room for one: is it larger than the box, or is the box full?"
    } else {
        "reduce their number or their size"
    }
}

/// A grid too fine, or a box too small or too large, for the bodies in it.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum GridError {
    /// With so many cells, two bodies could touch from cells that are not adjacent.
    #[error(
        "a grid with {cells_per_side} cells per side is too fine: at most {largest} are safe \
         (two bodies can touch with centres {reach} apart)"
    )]
    TooFine {
        /// Cells per side requested.
        cells_per_side: u32,
        /// Largest number of cells per side with which no contact is missed.
        largest: u32,
        /// Largest sum of two bounding radii (length).
        reach: f64,
        /// Indices of the two bodies in [`World::bodies`](crate::World::bodies).
        bodies: [usize; 2],
    },
    /// Zero cells per side, or more than can be stored.
    #[error("the number of cells per side must be from 1 to 4096, but is {0}")]
    CellsPerSide(u32),
    /// A molecule could touch its own periodic image, or two bodies could touch across more than
    /// the box.
    #[error(
        "the box is too small: bodies reach {reach} from centre to centre, but its shorter side is {side}; \
         enlarge the box"
    )]
    BoxTooSmall {
        /// Largest sum of two bounding radii, or twice one (length).
        reach: f64,
        /// The shorter side (length).
        side: f64,
        /// Indices of the two bodies in [`World::bodies`](crate::World::bodies); equal for a single
        /// body.
        bodies: [usize; 2],
    },
    /// Two bodies so small in so large a box that the rounding of positions would affect their
    /// contacts.
    #[error(
        "the box is too large: atoms touch at {reach:e} from centre to centre, less than 1e-13 of its longer side, \
         {side:e}, so that positions would be rounded by more than a thousandth of that distance; shrink the box"
    )]
    BoxTooLarge {
        /// Smallest sum of the radii of two atoms that may touch (length).
        reach: f64,
        /// The longer side (length).
        side: f64,
        /// Indices of the two bodies in [`World::bodies`](crate::World::bodies).
        bodies: [usize; 2],
    },
    /// An ellipse or an arc, and a detector that does not search them.
    #[error("this detector does not search ellipses and arcs; use method.detector = \"exact\"")]
    Curve(usize),
    /// An arc and contacts that lose energy, without a guard against inelastic collapse.
    #[error(
        "contacts that lose energy need a guard beside arcs, `elasticity.contact_time` above 0, but it is 0: a body \
         that comes to rest against the inside of an arc follows it by contacts without end"
    )]
    UnguardedArc(usize),
    /// A body with sides or of ellipses in a world with arcs that it cannot be searched against.
    #[error(
        "a body of ellipses is not searched against arcs, and one with straight sides only from inside arcs that are \
         one-sided: use discs and molecules of discs, or for straight sides a `[[container]]`"
    )]
    BesideArc(usize),
    /// A wall that moves, and an arc: where the two would meet is not searched yet.
    #[error(
        "walls that move and curved walls cannot be in one system yet; use straight walls, or walls at rest"
    )]
    MovingWallAndArc(usize),
    /// A wall that turns, and a detector that does not search such walls.
    #[error("this detector does not search walls that turn; use method.detector = \"exact\"")]
    TurningWall(usize),
    /// Driven bodies, and a scheduler that does not run them.
    #[error("this scheduler runs neither walls that oscillate nor bodies that fall")]
    DrivenBodies,
    /// Pistons, and a scheduler that does not run them.
    #[error("this scheduler does not run pistons")]
    Pistons,
    /// A shear, and a scheduler that does not run it.
    #[error("this scheduler does not run a shear")]
    Shear,
    /// Bonds between bodies, and a scheduler that does not predict them.
    #[error("this scheduler does not run tethers")]
    Tethers,
    /// Wells of discs, and a scheduler that does not predict their steps.
    #[error("this scheduler does not run wells")]
    Wells,
    /// A gravity, and a detector that does not search bodies that fall.
    #[error("this detector does not search bodies that fall; use method.detector = \"exact\"")]
    Falling,
    /// A wall that oscillates, and a detector that does not search such walls.
    #[error("this detector does not search walls that oscillate; use method.detector = \"exact\"")]
    OscillatingWall(usize),
    /// A wall that turns, and an ellipse: contacts of the two are not searched yet.
    #[error(
        "walls that turn and ellipses cannot be in one system yet; use a wall that does not turn, or other shapes"
    )]
    TurningWallAndEllipse([usize; 2]),
    /// Atoms whose contacts change energy, and so small in this box that detection resolves their
    /// speed of separation only to more than a thousandth of their speed.
    #[error(
        "with elasticity {coefficient} the radii of touching parts must add up to at least {least:e} in this box, \
         but add up to {reach:e}: the rounding of positions would decide how fast they separate; enlarge them, \
         shrink the box, or use elasticity 1"
    )]
    UnresolvedElasticity {
        /// Smallest sum of the radii of two parts that may touch (length).
        reach: f64,
        /// Least allowed sum (length).
        least: f64,
        /// Coefficient of restitution of the pair.
        coefficient: f64,
        /// Indices of the two bodies in [`World::bodies`](crate::World::bodies).
        bodies: [usize; 2],
    },
}

impl SceneError {
    /// The problem of an entry.
    pub(crate) fn of_entry(entry: &str, problem: impl Into<String>) -> Self {
        Self::Entry {
            entry: entry.to_owned(),
            problem: problem.into(),
        }
    }
}

impl GridError {
    /// Adds the names of the bodies to the error.
    pub(crate) fn named(self, name: impl Fn(usize) -> String) -> SceneError {
        let entry = match self {
            Self::TooFine { bodies: [a, b], .. }
            | Self::BoxTooSmall { bodies: [a, b], .. }
            | Self::BoxTooLarge { bodies: [a, b], .. }
            | Self::UnresolvedElasticity { bodies: [a, b], .. }
            | Self::TurningWallAndEllipse([a, b]) => {
                let (a, b) = (name(a), name(b));
                if a == b { a } else { format!("{a} and {b}") }
            }
            Self::Curve(body)
            | Self::BesideArc(body)
            | Self::UnguardedArc(body)
            | Self::MovingWallAndArc(body)
            | Self::OscillatingWall(body)
            | Self::TurningWall(body) => name(body),
            Self::CellsPerSide(_) => "the grid".to_owned(),
            Self::Falling => "gravity".to_owned(),
            Self::DrivenBodies | Self::Pistons | Self::Shear | Self::Tethers | Self::Wells => {
                "the scheduler".to_owned()
            }
        };
        SceneError::Grid {
            entry,
            reason: self,
        }
    }
}

/// An edit that cannot be made. It has changed nothing.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum EditError {
    /// The body has never been in the system, or has been removed.
    #[error("body {} is not, or no longer, in the system", .0.0)]
    NoSuchBody(BodyKey),
    /// A body at rest has no direction of motion, so its energy cannot be scaled.
    #[error(
        "the energy of {0} cannot be reset: the body is at rest and has no direction of motion"
    )]
    NoEnergy(BodyName),
    /// An energy that is not positive and finite, or that gives a speed out of range.
    #[error(
        "an energy must be positive and give a speed from {MIN_SPEED:e} to {MAX_MAGNITUDE:e}, but is {0:e}"
    )]
    Energy(f64),
    /// The body is fixed: its velocity, its energy and its rotation cannot be changed.
    #[error(
        "{0} is fixed: neither its motion, its energy nor its rotation can be changed; give the bodies that move a tag \
         of their own"
    )]
    Fixed(BodyName),
    /// The orientation of the body is locked, or it is a single disc.
    #[error(
        "{0} cannot turn, since it is locked or a single disc: unlock it, or give neither an angular velocity nor a \
         rotational diffusion"
    )]
    CannotTurn(BodyName),
    /// The body is no wall: only walls are given a motion that contacts do not change.
    #[error("{0} is no wall, and only walls are moved: give a body that is not fixed a velocity")]
    NotWall(BodyName),
    /// A force on a body that is no piston.
    #[error("{0} is no piston, and only pistons are pushed by a force (`[[piston]]`)")]
    NotPiston(BodyName),
    /// The edited system would not be a valid scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// The reason why contacts follow each other in almost no time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum StallCause {
    /// Contacts of elasticity below 1, without a guard, lose ever more of the speed of separation.
    #[error(
        "inelastic collapse, infinitely many contacts in a finite time; set `elasticity.contact_time` (from 1e-5 to \
         1, for example 1e-4), below which contacts are elastic"
    )]
    InelasticCollapse,
    /// Contacts of elasticity below 1, although a guard makes contacts elastic that follow others
    /// within its contact time.
    #[error(
        "inelastic collapse, which the present `elasticity.contact_time` does not prevent; increase it (at most 1), \
         or give the bodies more free space"
    )]
    GuardedCollapse,
    /// No contact loses energy: the bodies touch on several sides and cannot move.
    #[error(
        "no contact loses energy, so the bodies have no free space to move; place them farther apart, or reduce \
         their size or number"
    )]
    NoFreeSpace,
}

/// The reason why a run ended before its target time. The system remains at the time at which it
/// stopped.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RunError {
    /// A time that is NaN, infinite, or beyond [`MAX_TIME`].
    #[error("a run must end at a finite time of at most {MAX_TIME:e}, not at {0:?}")]
    Time(f64),
    /// A time before the present, by more than its rounding.
    #[error("a run cannot end at {until:?}, before its present time {now}: time only advances")]
    Past {
        /// The time requested.
        until: f64,
        /// The present time.
        now: EpochTime,
    },
    /// An interval between samples that is not positive and finite, or too short for the run.
    #[error(
        "the interval between samples must be positive, finite and at least 2^-53 of the run, but is {0:e}"
    )]
    Interval(f64),
    /// A body has had too many contacts at one instant, or very many contacts in a short time that
    /// lose all energy.
    #[error("at time {time} {body} has had {contacts} contacts in almost no time: {cause}")]
    Stalled {
        /// Time of the stall.
        time: EpochTime,
        /// The body.
        body: BodyName,
        /// Number of contacts.
        contacts: u32,
        /// What lets the contacts follow each other without time between them.
        cause: StallCause,
    },
    /// A body is so fast that the time in which it crosses the box a few times is lost in the
    /// rounding of the clock.
    #[error(
        "at time {time} the fastest body allows a step of only {stretch:e}, which is lost in the rounding of the time; \
         reduce its speed"
    )]
    TimeStandsStill {
        /// Time at which the run stopped.
        time: EpochTime,
        /// Length of the epoch (time).
        stretch: f64,
    },
    /// A body turns or moves so much faster than another that the motion of the slow one is lost in
    /// the rounding of positions: many epochs have passed without a contact, each so short that the
    /// slow body hardly moves in it.
    ///
    /// This needs at least 9e12 turns of the fast body, or 1e11 crossings of the box, while the
    /// slow one travels one side.
    #[error(
        "at time {time} {body}, of speed {speed:e} and angular velocity {spin:e}, is too fast compared with \
         {outpaced}, which travels {way:e} in an epoch, less than the rounding of its position"
    )]
    TimeScalesTooFarApart {
        /// Time at which the run stopped.
        time: EpochTime,
        /// The fastest body.
        body: BodyName,
        /// Its speed (length per time).
        speed: f64,
        /// Its angular velocity (radians per time).
        spin: f64,
        /// The slow body.
        outpaced: Box<BodyName>,
        /// Distance that the slow body travels in an epoch (length).
        way: f64,
    },
    /// After contacts that lose energy, or after edits, some bodies move, but none as fast as
    /// [`MIN_SPEED`]. The squares of their speeds underflow, and they would pass through each
    /// other.
    #[error(
        "at time {time} the fastest is {body}, of speed {speed:e}; to continue, it must be at rest or have a speed of \
         at least {MIN_SPEED:e}"
    )]
    TooSlow {
        /// Time at which the run stopped.
        time: EpochTime,
        /// The fastest body.
        body: BodyName,
        /// Its speed of centre or rim (length per time).
        speed: f64,
    },
    /// A wall that moves has met another wall or a fixed body, from which it was apart.
    #[error(
        "at time {time} {wall}, which moves, meets {other}: neither can give way, so that no body could be between \
         them; end the run before, or give the walls other motions from an earlier time on (`[[stage.move_wall]]`)"
    )]
    WallsMeet {
        /// Time of the meeting.
        time: EpochTime,
        /// The wall.
        wall: BodyName,
        /// What it meets.
        other: Box<BodyName>,
    },
    /// Walls that move have given the bodies far more energy than they had: they close on bodies
    /// that have no way out, whose contacts follow each other ever faster.
    #[error(
        "at time {time} the kinetic energy is {energy:e}, more than {limit:e}: {wall} squeezes bodies that have no way \
         out, and their contacts would become infinitely many; end the run before, or give the wall another motion \
         from an earlier time on (`[[stage.move_wall]]`)"
    )]
    Squeezed {
        /// Time at which the run stopped.
        time: EpochTime,
        /// The fastest wall.
        wall: BodyName,
        /// Kinetic energy (mass × length² / time²).
        energy: f64,
        /// Largest allowed energy (mass × length² / time²).
        limit: f64,
    },
    /// A reaction would leave a system that cannot be run.
    #[error("at time {time} the reaction {reaction} cannot take place: {reason}")]
    Reaction {
        /// Time at which the run stopped.
        time: EpochTime,
        /// The reaction in a line.
        reaction: String,
        /// The reason.
        reason: Box<EditError>,
    },
    /// A speed has grown out of range (for example by superelastic contacts).
    #[error(
        "at time {time} {body} is too fast to continue: its speed is {speed:e}, at most {MAX_MAGNITUDE:e} is allowed"
    )]
    BlowUp {
        /// Time at which the run stopped.
        time: EpochTime,
        /// The body.
        body: BodyName,
        /// Its speed, including that of the rim (length per time).
        speed: f64,
    },
}
