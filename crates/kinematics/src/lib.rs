//! Free flight: the position and orientation of a rigid body at time t, with constant velocity and
//! angular velocity.
//!
//! Stable: its public items follow the policy of versions in the book (*Versions and releases*).
//!
//! ```
//! use carom_kinematics::{Motion, Orientation};
//! use glam::DVec2;
//!
//! let motion = Motion {
//!     position: DVec2::ZERO,
//!     velocity: DVec2::X,
//!     orientation: Orientation::from_turns(0.25),
//!     angular_velocity: std::f64::consts::PI,
//!     time: 1.0,
//! };
//! let later = motion.at(1.5);
//! assert_eq!(later.position, DVec2::new(0.5, 0.0));
//! assert_eq!(later.orientation.turns(), 0.5);
//! ```
//!
//! Each body has its own *subjective time*, the time at which its motion last changed. Two bodies
//! are compared at a common time and in one periodic image ([`RelativeMotion`], algorithm 1 of
//! Montanari 2017).
//!
//! Positions are lengths, velocities length per time, angular velocities radians per time,
//! counter-clockwise. Orientations are stored in turns, in which the reduction of a large angle is
//! exact.

mod conserved;
mod drag_clock;
mod drive;
mod epoch_time;
mod error_free;
mod motion;
mod orientation;
mod relative_motion;

pub use conserved::{Inertia, angular_momentum, kinetic_energy, momentum};
pub use drag_clock::DragClock;
pub use drive::{Drive, DriveBounds, DriveDeviation};
pub use epoch_time::EpochTime;
pub use motion::Motion;
pub use orientation::Orientation;
pub use relative_motion::RelativeMotion;

// Parts that the other layers share; no user of the library needs them.
#[doc(hidden)]
pub use error_free::{two_product, two_sum};
#[doc(hidden)]
pub use orientation::Turning;
#[doc(hidden)]
pub use relative_motion::HALF_ULP;
