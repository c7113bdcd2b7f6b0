//! Shapes in the plane: rigid unions of discs and straight edges, their bounding circles and
//! excluded regions, straight walls, and the periodic box.
//!
//! Stable: its public items follow the policy of versions in the book (*Versions and releases*).
//!
//! ```
//! use carom_geometry::{Molecule, Shape};
//!
//! // The T of five touching discs of Montanari (2017), figure 3.1.
//! let tee = Molecule::named(Shape::Tee, 0.005, 2.0)?;
//! assert_eq!(tee.atoms().len(), 5);
//! assert!((tee.mass() - 10.0).abs() < 1e-15);
//! # Ok::<(), carom_geometry::GeometryError>(())
//! ```
//!
//! A molecule is a rigid union of *atoms* (discs with a mass), in the frame of its centre of mass,
//! and of *edges* between them: capsules and polygons are atoms and edges.
//! The crate has no notion of time or motion. Angles are counter-clockwise; mass, length and time
//! are in the user's units.

mod atom;
mod atom_row;
mod bend;
mod boundary;
mod boundary_point;
mod circle_tree;
mod contour;
mod covered_area;
mod edge;
mod edge_tangents;
mod edged_shape;
mod ellipse;
mod error;
mod excluded_region;
mod exposed_arc;
mod exposed_side;
mod gap;
mod hull;
mod interior;
mod limits;
mod molecule;
mod nearest;
mod outline;
mod periodic_box;
mod polygon_corners;
mod properties;
mod quadrature;
mod room;
mod shape;
mod support;
mod union;

pub use atom::Atom;
pub use bend::Bend;
pub use boundary_point::{BoundaryPart, BoundaryPoint};
pub use contour::{Contour, ContourPiece};
pub use edge::{Edge, HalfPlane};
pub use edge_tangents::{EdgeTangents, FacingEdge};
pub use edged_shape::{DEFAULT_ROUNDING, EdgedShape};
pub use ellipse::{Ellipse, MAX_ASPECT};
pub use error::GeometryError;
pub use excluded_region::{DIRECTION_ROUNDING, ExcludedRegion};
pub use exposed_arc::ExposedArc;
pub use exposed_side::{EdgeSide, ExposedSide};
pub use gap::{atom_tangents, edge_tangents, gap_between};
pub use interior::{Interior, MIN_ROUNDING};
pub use limits::{MAX_MAGNITUDE, MIN_MAGNITUDE};
pub use molecule::Molecule;
pub use nearest::Nearest;
pub use outline::Outline;
pub use periodic_box::PeriodicBox;
pub use room::{Scaled, room};
pub use shape::Shape;
pub use support::{FacingParts, FacingTangents, Support, SupportPoint, turned};

// Parts that the other layers share; no user of the library needs them.
#[doc(hidden)]
pub use atom_row::AtomRow;
#[doc(hidden)]
pub use circle_tree::{Circle, CircleTree, Node};
#[doc(hidden)]
pub use hull::HullSide;
#[doc(hidden)]
pub use interior::check_corner_count;
#[doc(hidden)]
pub use limits::{check_length, check_positive};
