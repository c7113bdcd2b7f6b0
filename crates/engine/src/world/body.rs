//! A body of the system: its shape, its inertia and its tags.

use std::{fmt, sync::Arc};

use carom_geometry::Molecule;
use carom_kinematics::Inertia;
use serde::{Deserialize, Serialize};

use crate::world::tags::{Tag, TagNames, Tags};

/// Handle of a body. It stays valid until the body is removed, and is never reused, even if the
/// batch that has added the body is refused.
///
/// Keys ascend in the order of insertion, which is also the order of the bodies in the world, in a
/// view and in a checkpoint, and the order of ties. Bodies are therefore found by binary search, a
/// view iterates through consecutive memory, and a resumed run has the same keys. A slot map has
/// none of these properties: it reuses the slots of removed bodies, so that its order depends on
/// the history of edits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct BodyKey(pub(crate) u64);

/// The handle of no body.
impl Default for BodyKey {
    fn default() -> Self {
        Self(u64::MAX)
    }
}

/// Whether a body can turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Rotation {
    /// Impulses change its angular velocity.
    #[default]
    Free,
    /// Its orientation is locked (Montanari 2017, equation 2.12).
    Locked,
}

/// The properties of a body that events do not change.
#[derive(Debug, Clone)]
pub struct Body {
    pub(crate) key: BodyKey,
    /// Shared by equal bodies: a gas of a million discs has one.
    pub(crate) kind: Arc<BodyKind>,
}

/// The properties that bodies of one kind share.
#[derive(Debug, Clone)]
pub(crate) struct BodyKind {
    pub(crate) molecule: Arc<Molecule>,
    pub(crate) inertia: Inertia,
    pub(crate) tags: Tags,
    /// Row and column of the body in the tables of elasticities and of pairs.
    pub(crate) tag_class: u32,
    /// Whether contacts with some body may have tangential impulses.
    pub(crate) has_rough_contacts: bool,
    /// kT of a wall that has a temperature (mass × length² / time²).
    pub(crate) temperature: Option<f64>,
}

impl BodyKind {
    /// Whether all properties are equal.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        (Arc::ptr_eq(&self.molecule, &other.molecule) || self.molecule == other.molecule)
            && self.inertia == other.inertia
            && self.tags == other.tags
            && self.tag_class == other.tag_class
            && self.has_rough_contacts == other.has_rough_contacts
            && self.temperature == other.temperature
    }
}

impl BodyKey {
    /// The handle of the body with this number ([`Body::id`]); no such body need exist.
    pub fn of_id(id: u64) -> Self {
        Self(id)
    }

    /// The number of the body, see [`Body::id`].
    pub fn id(self) -> u64 {
        self.0
    }

    /// Whether this is the handle of one of these two bodies.
    #[inline]
    pub fn is_among(self, bodies: [&Body; 2]) -> bool {
        (bodies[0].key == self) | (bodies[1].key == self)
    }
}

impl Body {
    /// Returns the handle of the body.
    pub fn key(&self) -> BodyKey {
        self.key
    }

    /// Number of the body in order of insertion, from 0; never reused. Refused batches leave gaps.
    pub fn id(&self) -> u64 {
        self.key.0
    }

    /// Shape and mass.
    pub fn molecule(&self) -> &Molecule {
        &self.kind.molecule
    }

    /// Whether this body is a straight wall.
    pub fn is_wall(&self) -> bool {
        self.kind.molecule.is_wall()
    }

    /// kT of a wall that gives it to the bodies that touch it (mass × length² / time²).
    #[doc(alias = "thermostat")]
    pub fn wall_temperature(&self) -> Option<f64> {
        self.kind.temperature
    }

    /// The mass: that of the molecule, or of a piston; infinite for other walls.
    pub fn mass(&self) -> f64 {
        if self.is_piston() {
            1.0 / self.kind.inertia.inverse_mass
        } else {
            self.kind.molecule.mass()
        }
    }

    /// Largest distance from the centre of mass at which the body can be touched (length): the
    /// bounding radius; for a wall, the distance from its edge.
    pub fn reach(&self) -> f64 {
        self.kind.molecule.wall_edge().map_or(
            self.kind.molecule.bounding_radius(),
            carom_geometry::Edge::radius,
        )
    }

    /// The radius of the smallest part that can be touched (length): an atom, or the edge of a
    /// wall.
    pub(crate) fn smallest_reach(&self) -> f64 {
        let wall = self.kind.molecule.wall_edge();
        wall.map_or_else(|| self.smallest_atom(), carom_geometry::Edge::radius)
    }

    /// Whether any atom is an ellipse.
    #[inline]
    pub(crate) fn has_ellipses(&self) -> bool {
        !self.kind.molecule.ellipses().is_empty()
    }

    /// The radius of the smallest atom (length), or half the width of an ellipse; infinite for a
    /// wall across the box, which has none.
    pub(crate) fn smallest_atom(&self) -> f64 {
        let molecule = &self.kind.molecule;
        let half_widths = (0..molecule.atoms().len()).map(|atom| molecule.shape_of(atom).axes()[1]);
        half_widths.fold(f64::INFINITY, f64::min)
    }

    /// The least radius of curvature of an atom (length): its radius, or b²/a at the tip of an
    /// ellipse; infinite for a wall across the box, which has none.
    pub(crate) fn sharpest_curvature(&self) -> f64 {
        let molecule = &self.kind.molecule;
        let radii = (0..molecule.atoms().len()).map(|atom| {
            let [a, b] = molecule.shape_of(atom).axes();
            if a == b { a } else { b * (b / a) }
        });
        radii.fold(f64::INFINITY, f64::min)
    }

    /// Inverse mass and inverse moment, 0 where fixed or locked.
    pub fn inertia(&self) -> &Inertia {
        &self.kind.inertia
    }

    /// Tags in ascending order.
    pub fn tags(&self) -> &[Tag] {
        &self.kind.tags
    }

    /// Whether the body carries `tag`.
    pub fn has_tag(&self, tag: Tag) -> bool {
        self.kind.tags.binary_search(&tag).is_ok()
    }

    /// Whether this body never moves.
    #[doc(alias = "bumper")]
    pub fn is_fixed(&self) -> bool {
        self.kind.inertia.is_fixed()
    }

    /// Whether this is a wall with a mass, which contacts push along its normal.
    #[inline]
    pub fn is_piston(&self) -> bool {
        !self.is_fixed() && self.is_wall()
    }

    /// The axis along which this moves if it is a piston: 0 for x, 1 for y.
    pub fn axis_of_piston(&self) -> Option<usize> {
        self.axis_across().filter(|_| self.is_piston())
    }

    /// The axis along the normal of a wall across the box, fixed or a piston: 0 for x, 1 for y.
    /// `None` for any other body.
    pub(crate) fn axis_across(&self) -> Option<usize> {
        let molecule = self.molecule();
        let edge = molecule.wall_edge()?;
        edge.is_line().then(|| usize::from(edge.along().x != 0.0))
    }

    /// Whether this is a molecule that moves: neither fixed nor a piston.
    #[inline]
    pub fn is_free(&self) -> bool {
        !self.is_fixed() && !self.is_wall()
    }

    /// Whether the body does not turn: its orientation is locked, or it is fixed.
    pub fn is_locked(&self) -> bool {
        self.kind.inertia.inverse_moment == 0.0
    }

    /// Whether contacts change the angular velocity of the body: it is not locked, and not round
    /// (see [`Molecule::is_round`]) unless it has rough contacts.
    pub fn can_turn(&self) -> bool {
        !self.is_locked() && (self.kind.has_rough_contacts || !self.molecule().is_round())
    }
}

/// A body in an error message: its handle, its number and its tags.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BodyName {
    /// Handle.
    pub key: BodyKey,
    /// Number in order of insertion, from 0.
    pub id: u64,
    /// Names of its tags.
    pub tags: Vec<String>,
}

impl BodyName {
    #[cold]
    pub(crate) fn new(body: &Body, names: &TagNames) -> Self {
        let tags = body
            .kind
            .tags
            .iter()
            .map(|&tag| names.name(tag).to_owned())
            .collect();
        Self {
            key: body.key(),
            id: body.id(),
            tags,
        }
    }
}

impl fmt::Display for BodyName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "body {}", self.id)?;
        match &self.tags[..] {
            [] => Ok(()),
            [tag] => write!(f, " (tag {tag})"),
            tags => write!(f, " (tags {})", tags.join(", ")),
        }
    }
}
