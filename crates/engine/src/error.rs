//! What a caller may do wrong, and how a run can end before its time.

use carom_geometry::{GeometryError, LARGEST};
use carom_kinematics::EpochTime;
use carom_response::ElasticityError;
use thiserror::Error;

use crate::{BodyKey, BodyName, LEAST_SPEED};

/// A scene that cannot be built; the entry is named.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The text is not TOML, or has unknown or missing keys.
    #[error("the scene file cannot be read: {0}")]
    Syntax(String),
    /// A number or shape of an entry is impossible.
    #[error("{entry}: {reason}")]
    Geometry {
        /// The entry, such as `gas[0]`.
        entry: String,
        /// What is wrong with it.
        reason: GeometryError,
    },
    /// An elasticity out of range.
    #[error("{entry}: {reason}")]
    Elasticity {
        /// The entry.
        entry: String,
        /// What is wrong with it.
        reason: ElasticityError,
    },
    /// A key of an entry is missing, or two keys exclude each other.
    #[error("{entry}: {problem}")]
    Entry {
        /// The entry.
        entry: String,
        /// What is wrong with it, in words.
        problem: String,
    },
    /// A body moves or turns so slowly that the squares of its speed underflow.
    #[error(
        "{entry}: {quantity} must be 0 or at least {LEAST_SPEED:e}, but is {speed:e}: bodies so slow would pass through each \
         other (a longer unit of time makes it larger)"
    )]
    TooSlow {
        /// The entry.
        entry: String,
        /// Which speed.
        quantity: &'static str,
        /// The speed (length per time).
        speed: f64,
    },
    /// Two bodies overlap at the start.
    #[error("{first} and {second} overlap by {depth:e}")]
    Overlap {
        /// The first entry.
        first: String,
        /// The second entry.
        second: String,
        /// How deep (length).
        depth: f64,
    },
    /// A gas does not fit.
    #[error("{entry}: only {placed} of {wanted} molecules can be placed without overlap")]
    Full {
        /// The entry.
        entry: String,
        /// How many places were found.
        placed: usize,
        /// How many were asked for.
        wanted: usize,
    },
    /// Two rules of elasticity of equal rank disagree on a pair of bodies that exist.
    #[error(
        "elasticity rules for {first:?} and {second:?} both apply to a pair of bodies, with {one} and {other}"
    )]
    AmbiguousElasticity {
        /// Tags of one rule.
        first: Vec<String>,
        /// Tags of the other.
        second: Vec<String>,
        /// Coefficient of the one.
        one: f64,
        /// Coefficient of the other.
        other: f64,
    },
    /// The grid or the box does not suit the bodies.
    #[error("{entry}: {reason}")]
    Grid {
        /// The entries or bodies that decide, or the grid itself.
        entry: String,
        /// What is wrong.
        reason: GridError,
    },
}

/// A grid too fine, or a box too small, for the bodies in it.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum GridError {
    /// With this fineness two bodies could touch from cells that are not adjacent.
    #[error(
        "a grid of fineness {fineness} is too fine: the largest safe fineness is {largest} \
         (two bodies reach {reach} from centre to centre)"
    )]
    TooFine {
        /// The fineness asked for.
        fineness: u32,
        /// The largest that misses nothing.
        largest: u32,
        /// Largest sum of two bounding radii (length).
        reach: f64,
        /// The two bodies, by their places in [`World::bodies`](crate::World::bodies).
        bodies: [usize; 2],
    },
    /// A fineness of 0, or more cells than can be stored.
    #[error("the fineness of a grid must be from 1 to 4096, but is {0}")]
    CellsPerSide(u32),
    /// A molecule could meet its own periodic image, or a pair reach across more than the box.
    #[error("the box is too small: bodies reach {reach} from centre to centre, its shorter side is {side}")]
    BoxTooSmall {
        /// Largest sum of two bounding radii, or twice one (length).
        reach: f64,
        /// The shorter side (length).
        side: f64,
        /// The two bodies, by their places in [`World::bodies`](crate::World::bodies); twice the same if it is one.
        bodies: [usize; 2],
    },
    /// Two bodies so small in so large a box that the rounding of places would show in their contacts.
    #[error(
        "the box is too large: atoms touch at {reach:e} from centre to centre, less than 1e-13 of its longer side of \
         {side:e}, so that places would be rounded by more than a thousandth of that"
    )]
    BoxTooLarge {
        /// Smallest sum of the radii of two atoms that may touch (length).
        reach: f64,
        /// The longer side (length).
        side: f64,
        /// The two bodies, by their places in [`World::bodies`](crate::World::bodies).
        bodies: [usize; 2],
    },
}

impl GridError {
    /// Puts the names of the bodies before the error.
    pub(crate) fn named(self, name: impl Fn(usize) -> String) -> SceneError {
        let entry = match self {
            Self::TooFine { bodies: [a, b], .. }
            | Self::BoxTooSmall { bodies: [a, b], .. }
            | Self::BoxTooLarge { bodies: [a, b], .. } => {
                let (a, b) = (name(a), name(b));
                if a == b { a } else { format!("{a} and {b}") }
            }
            Self::CellsPerSide(_) => "the grid".to_owned(),
        };
        SceneError::Grid { entry, reason: self }
    }
}

/// An edit at a sample that cannot be made; nothing was changed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum EditError {
    /// The body is not, or no longer, in the system.
    #[error("the body is not, or no longer, in the system")]
    NoSuchBody(BodyKey),
    /// A body of zero energy has no direction to keep, so no energy can be given to it.
    #[error("the energy of {0} cannot be reset: it has none, hence no direction of motion")]
    NoEnergy(BodyName),
    /// An energy that is not positive, NaN or infinite, or that gives a speed beyond computing
    /// with.
    #[error("an energy must be positive and give a speed from {LEAST_SPEED:e} to {LARGEST:e}, but is {0:e}")]
    Energy(f64),
    /// The body is fixed and takes no energy and no rotation mode.
    #[error("{0} is fixed")]
    Fixed(BodyName),
    /// The system would not be a valid scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// Why a run ended before the time asked for. The system stays as it was at that instant.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RunError {
    /// A time that is NaN or infinite.
    #[error("a run must end at a finite time, not at {0}")]
    Time(f64),
    /// An interval between samples that is not a positive, finite time, or too short for the run.
    #[error("the interval between samples must be positive, finite and at least 2^-53 of the run, not {0:e}")]
    Interval(f64),
    /// One body has had too many contacts at one instant, or contacts without end that lose all energy: an inelastic
    /// collapse, which a guard prevents ([`ElasticitySpec::contact_time`](crate::ElasticitySpec::contact_time)).
    #[error("at time {time} {body} has had {contacts} contacts while time hardly moved on")]
    Stalled {
        /// When.
        time: EpochTime,
        /// Which body.
        body: BodyName,
        /// How many contacts.
        contacts: u32,
    },
    /// A body is so fast that the time in which it crosses the box a few times does not move the clock on.
    #[error(
        "at time {time} the fastest body allows a step of {stretch:e} only, which no longer moves time on"
    )]
    TimeStandsStill {
        /// When.
        time: EpochTime,
        /// How long the epoch would have been (time).
        stretch: f64,
    },
    /// One body turns or flies so much faster than another moves that the other's way is lost in the rounding of places: many
    /// epochs have gone by without a contact, each so short that the slow one hardly moves in it.
    ///
    /// At the earliest beyond 9e12 turns of the one, or 1e11 crossings of the box, while the other goes one side.
    #[error(
        "at time {time} {body}, of speed {speed:e} and spin {spin:e}, is too fast for {outpaced}, which moves by {way:e} \
         in an epoch and is lost in rounding"
    )]
    TimeScalesTooFarApart {
        /// When.
        time: EpochTime,
        /// The fastest body.
        body: BodyName,
        /// Its speed (length per time).
        speed: f64,
        /// Its angular velocity (radians per time).
        spin: f64,
        /// The slow body.
        outpaced: Box<BodyName>,
        /// How far that goes in an epoch (length).
        way: f64,
    },
    /// Contacts that lose energy, or edits, have left no body that moves with [`LEAST_SPEED`] or
    /// more, but some that move: the squares of their speeds underflow, and they would pass through
    /// each other.
    #[error(
        "at time {time} the fastest is {body}, of speed {speed:e}: to go on it must be at rest or have a speed of at least \
         {LEAST_SPEED:e}"
    )]
    TooSlow {
        /// When.
        time: EpochTime,
        /// The fastest body.
        body: BodyName,
        /// Its speed, or rim speed (length per time).
        speed: f64,
    },
    /// Speeds have grown beyond what can be computed with (superelastic contacts do this).
    #[error("at time {time} {body} is too fast to go on: speed {speed:e}")]
    BlowUp {
        /// When.
        time: EpochTime,
        /// Which body.
        body: BodyName,
        /// Its speed, or rim speed (length per time).
        speed: f64,
    },
}
