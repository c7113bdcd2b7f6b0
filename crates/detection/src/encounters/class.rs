//! The classes of encounters and their difficulties.

use std::{fmt, str::FromStr};

use super::{
    Encounter, contacts, edged_flights, edged_grazes, edged_insides, edged_shapes, fast, flights,
    grazes, random::Draw, walls,
};

/// A class of encounters.
///
/// Its text form is `generic`, `graze_1e-8` and so on; see [`Class::ALL`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Class {
    /// Two equal small discs, far apart for their size; some pass each other.
    DiscT1,
    /// Molecules of one to five atoms with thermal velocities and angular velocities.
    Generic,
    /// As [`Self::Generic`], without rotation.
    ZeroOmega,
    /// As [`Self::Generic`]; one of the molecules turns.
    OneOmega,
    /// As [`Self::Generic`], with angular velocities 10² to 10⁴ times as large.
    LargeOmega,
    /// Sizes that differ by up to 10⁶; up to 10⁶ turns while the bodies move by the size of the
    /// pair.
    ExtremeRatio,
    /// Up to 10⁶ sizes away from each other; half of them up to 10⁹ sizes away from the origin.
    Far,
    /// Bounding circles that overlap at the start, while the atoms do not.
    Annulus,
    /// In contact to rounding, with arbitrary velocities.
    AfterCollision,
    /// In contact to rounding, just after an elastic collision.
    Rebound,
    /// An overlap of up to 27e-16 contact distances at the start, with arbitrary velocities.
    Overlap,
    /// 10⁴ to 10⁸ turns while the bounding circles overlap.
    Fast,
    /// A tangential pass with an overlap or a gap of 1e-9 to 1e-3 sizes.
    Grazing,
    /// A tangential pass with an overlap or a gap of 10^−n sizes.
    Graze(u8),
    /// Leaves a contact and returns after 10^−n natural times.
    Recontact(u8),
    /// Some atoms 10⁶ times heavier than others, in the other molecule or in the same one.
    MassRatio,
    /// Some atoms 10³ times smaller than others, in the other molecule or in the same one.
    SizeRatio,
    /// As [`Self::Generic`], at a temperature of 1e-12.
    Slow,
    /// Two rods of sixteen atoms.
    Linear16,
    /// Equal angular velocities and a gap that is constant or closes very slowly.
    MatchedSpins,
    /// A dumbbell inside a ring, with equal angular velocities and a constant gap, or drifting very
    /// slowly.
    Concentric,
    /// Rods of 2 to 256 atoms each.
    Rods,
    /// Round molecules of 2 to 256 atoms each.
    Blobs,
    /// A molecule of one to nine atoms flies at a wall: at its face, at an end, or past it.
    Wall,
    /// As [`Self::Wall`], with angular velocities 10² to 10⁴ times as large.
    WallLargeOmega,
    /// The lowest atom of a turning molecule overlaps a wall, or misses it, by 10^−n sizes.
    WallGraze(u8),
    /// Leaves a contact with a wall and returns after 10^−n natural times.
    WallRecontact(u8),
    /// Two squares with corners of 1e-9 to 0.1 sides.
    Squares,
    /// Two capsules, stout to slender.
    Capsules,
    /// Two capsules with a radius of 1e-6 lengths.
    Needles,
    /// Two triangles of height 1e-4 to 0.1 widths.
    SharpTriangles,
    /// Two polygons of 3 to 9 corners, most of them concave.
    Polygons,
    /// Two bodies in the shape of an L.
    Ells,
    /// Two regular polygons of sixteen sides, of sizes 1 : 1 to 1 : 3.5.
    SixteenGons,
    /// Two chains of discs of different radii, connected by thinner edges.
    BondedDiscs,
    /// A disc and a body with edges of any family.
    DiscAndEdges,
    /// An L begins in the notch of another.
    EllInNotch,
    /// A rod begins in the slot of a fork.
    RodInSlot,
    /// A small body begins in a hollow ring of 6 to 24 sides.
    InsideRing,
    /// A wall that turns, and a molecule of discs or a body with edges.
    TurningWall,
    /// Bodies with edges that turn by 10 to 300 radians while they move by the size of the pair.
    EdgedLargeOmega,
    /// As [`Self::EdgedLargeOmega`], by 10³ to 10⁵ radians.
    EdgedFast,
    /// Rectangles with equal spins and faces that are parallel to within 1e-12 to 1e-3, 1e-9 to
    /// 1e-2 apart.
    ParallelFaces,
    /// Bodies with edges, up to 10⁶ sizes away from each other.
    EdgedFar,
    /// A corner comes to a moving edge within 1e-12 to 1e-2 of its end, on it or beyond.
    EdgeEnd,
    /// A corner overlaps another corner or an edge by 10^−n sizes as it passes, or misses it by as
    /// much.
    CornerGraze(u8),
}

impl Class {
    /// All classes; those with a parameter at selected values.
    pub const ALL: [Self; 62] = [
        Self::DiscT1,
        Self::Generic,
        Self::ZeroOmega,
        Self::OneOmega,
        Self::LargeOmega,
        Self::ExtremeRatio,
        Self::Far,
        Self::Annulus,
        Self::AfterCollision,
        Self::Rebound,
        Self::Overlap,
        Self::Fast,
        Self::Grazing,
        Self::Graze(6),
        Self::Graze(8),
        Self::Graze(10),
        Self::Graze(12),
        Self::Graze(14),
        Self::Graze(15),
        Self::Recontact(3),
        Self::Recontact(6),
        Self::Recontact(9),
        Self::Recontact(12),
        Self::MassRatio,
        Self::SizeRatio,
        Self::Slow,
        Self::Linear16,
        Self::MatchedSpins,
        Self::Concentric,
        Self::Rods,
        Self::Blobs,
        Self::Wall,
        Self::WallLargeOmega,
        Self::WallGraze(6),
        Self::WallGraze(8),
        Self::WallGraze(10),
        Self::WallGraze(12),
        Self::WallGraze(14),
        Self::WallRecontact(3),
        Self::WallRecontact(6),
        Self::WallRecontact(9),
        Self::Squares,
        Self::Capsules,
        Self::Needles,
        Self::SharpTriangles,
        Self::Polygons,
        Self::Ells,
        Self::SixteenGons,
        Self::BondedDiscs,
        Self::DiscAndEdges,
        Self::EllInNotch,
        Self::RodInSlot,
        Self::InsideRing,
        Self::TurningWall,
        Self::EdgedLargeOmega,
        Self::EdgedFast,
        Self::ParallelFaces,
        Self::EdgedFar,
        Self::EdgeEnd,
        Self::CornerGraze(9),
        Self::CornerGraze(13),
        Self::CornerGraze(15),
    ];

    /// Whether a body of this class has straight edges that turn; walls at rest do not count.
    pub fn has_edges(self) -> bool {
        self.number() >= Self::Squares.number()
    }

    /// The number of the class, which selects its stream of random numbers.
    pub(super) fn number(self) -> u64 {
        let (kind, parameter) = match self {
            Self::DiscT1 => (0, 0),
            Self::Generic => (1, 0),
            Self::ZeroOmega => (2, 0),
            Self::OneOmega => (3, 0),
            Self::LargeOmega => (4, 0),
            Self::ExtremeRatio => (5, 0),
            Self::Far => (6, 0),
            Self::Annulus => (7, 0),
            Self::AfterCollision => (8, 0),
            Self::Rebound => (9, 0),
            Self::Overlap => (10, 0),
            Self::Fast => (11, 0),
            Self::Grazing => (12, 0),
            Self::Graze(exponent) => (13, exponent),
            Self::Recontact(exponent) => (14, exponent),
            Self::MassRatio => (15, 0),
            Self::SizeRatio => (16, 0),
            Self::Slow => (17, 0),
            Self::Linear16 => (18, 0),
            Self::MatchedSpins => (19, 0),
            Self::Concentric => (20, 0),
            Self::Rods => (21, 0),
            Self::Blobs => (22, 0),
            Self::Wall => (23, 0),
            Self::WallLargeOmega => (24, 0),
            Self::WallGraze(exponent) => (25, exponent),
            Self::WallRecontact(exponent) => (26, exponent),
            Self::Squares => (27, 0),
            Self::Capsules => (28, 0),
            Self::Needles => (29, 0),
            Self::SharpTriangles => (30, 0),
            Self::Polygons => (31, 0),
            Self::Ells => (32, 0),
            Self::SixteenGons => (33, 0),
            Self::BondedDiscs => (34, 0),
            Self::DiscAndEdges => (35, 0),
            Self::EllInNotch => (36, 0),
            Self::RodInSlot => (37, 0),
            Self::InsideRing => (38, 0),
            Self::TurningWall => (39, 0),
            Self::EdgedLargeOmega => (40, 0),
            Self::EdgedFast => (41, 0),
            Self::ParallelFaces => (42, 0),
            Self::EdgedFar => (43, 0),
            Self::EdgeEnd => (44, 0),
            Self::CornerGraze(exponent) => (45, exponent),
        };
        256 * kind + u64::from(parameter)
    }

    pub(super) fn draw(self, draw: &mut Draw, index: u64) -> Encounter {
        // 2, 4, … 256 atoms in turn.
        let atoms = 2 << (index % 8);
        match self {
            Self::DiscT1 => flights::small_discs(draw),
            Self::Generic => flights::generic(draw, 1.0),
            Self::ZeroOmega => flights::spinning(draw, [0.0, 0.0]),
            Self::OneOmega => flights::spinning(
                draw,
                if index.is_multiple_of(2) {
                    [1.0, 0.0]
                } else {
                    [0.0, 1.0]
                },
            ),
            Self::LargeOmega => flights::large_omega(draw),
            Self::ExtremeRatio => fast::extreme_ratio(draw),
            Self::Far => flights::far(draw, index.is_multiple_of(2)),
            Self::Annulus => contacts::annulus(draw),
            Self::AfterCollision => contacts::after_collision(draw),
            Self::Rebound => contacts::rebound(draw),
            Self::Overlap => contacts::overlap(draw),
            Self::Fast => fast::fast(draw),
            Self::Grazing => grazes::grazing(draw),
            Self::Graze(exponent) => grazes::graze(draw, exponent),
            Self::Recontact(exponent) => contacts::recontact(draw, exponent),
            Self::MassRatio => flights::mass_ratio(draw, index.is_multiple_of(2)),
            Self::SizeRatio => flights::size_ratio(draw, index.is_multiple_of(2)),
            Self::Slow => flights::generic(draw, 1e-12),
            Self::Linear16 => flights::rods(draw, 16),
            Self::MatchedSpins => fast::matched_spins(draw),
            Self::Concentric => fast::concentric(draw),
            Self::Rods => flights::rods(draw, atoms),
            Self::Blobs => flights::blobs(draw, atoms),
            Self::Wall => walls::fly_at(draw, [1.0, 1.0]),
            Self::WallLargeOmega => walls::fly_at(draw, [1e2, 1e4]),
            Self::WallGraze(exponent) => walls::graze(draw, exponent),
            Self::WallRecontact(exponent) => walls::recontact(draw, exponent),
            Self::Squares => edged_flights::of_family(draw, edged_shapes::square),
            Self::Capsules => edged_flights::of_family(draw, edged_shapes::capsule),
            Self::Needles => edged_flights::of_family(draw, edged_shapes::needle),
            Self::SharpTriangles => edged_flights::of_family(draw, edged_shapes::sharp_triangle),
            Self::Polygons => edged_flights::of_family(draw, edged_shapes::star),
            Self::Ells => edged_flights::of_family(draw, edged_shapes::ell),
            Self::SixteenGons => edged_flights::sixteen_gons(draw),
            Self::BondedDiscs => edged_flights::of_family(draw, edged_shapes::bonded_discs),
            Self::DiscAndEdges => edged_flights::disc_and_edges(draw),
            Self::EllInNotch => edged_insides::ell_in_notch(draw),
            Self::RodInSlot => edged_insides::rod_in_slot(draw),
            Self::InsideRing => edged_insides::inside_ring(draw),
            Self::TurningWall => edged_flights::turning_wall(draw),
            Self::EdgedLargeOmega => edged_flights::spinning(draw, [10.0, 300.0]),
            Self::EdgedFast => edged_flights::spinning(draw, [1e3, 1e5]),
            Self::ParallelFaces => edged_flights::parallel_faces(draw),
            Self::EdgedFar => edged_flights::far(draw),
            Self::EdgeEnd => edged_grazes::edge_end(draw),
            Self::CornerGraze(exponent) => edged_grazes::corner_graze(draw, exponent),
        }
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::DiscT1 => "disc_t1",
            Self::Generic => "generic",
            Self::ZeroOmega => "zero_omega",
            Self::OneOmega => "one_omega",
            Self::LargeOmega => "large_omega",
            Self::ExtremeRatio => "extreme_ratio",
            Self::Far => "far",
            Self::Annulus => "annulus",
            Self::AfterCollision => "after_collision",
            Self::Rebound => "rebound",
            Self::Overlap => "overlap",
            Self::Fast => "fast",
            Self::Grazing => "grazing",
            Self::Graze(exponent) => return f.pad(&format!("graze_1e-{exponent}")),
            Self::Recontact(exponent) => return f.pad(&format!("recontact_1e-{exponent}")),
            Self::MassRatio => "mass_ratio",
            Self::SizeRatio => "size_ratio",
            Self::Slow => "slow",
            Self::Linear16 => "linear16",
            Self::MatchedSpins => "matched_spins",
            Self::Concentric => "concentric",
            Self::Rods => "rods",
            Self::Blobs => "blobs",
            Self::Wall => "wall",
            Self::WallLargeOmega => "wall_large_omega",
            Self::WallGraze(exponent) => return f.pad(&format!("wall_graze_1e-{exponent}")),
            Self::WallRecontact(exponent) => {
                return f.pad(&format!("wall_recontact_1e-{exponent}"));
            }
            Self::Squares => "squares",
            Self::Capsules => "capsules",
            Self::Needles => "needles",
            Self::SharpTriangles => "sharp_triangles",
            Self::Polygons => "polygons",
            Self::Ells => "ells",
            Self::SixteenGons => "sixteen_gons",
            Self::BondedDiscs => "bonded_discs",
            Self::DiscAndEdges => "disc_and_edges",
            Self::EllInNotch => "ell_in_notch",
            Self::RodInSlot => "rod_in_slot",
            Self::InsideRing => "inside_ring",
            Self::TurningWall => "turning_wall",
            Self::EdgedLargeOmega => "edged_large_omega",
            Self::EdgedFast => "edged_fast",
            Self::ParallelFaces => "parallel_faces",
            Self::EdgedFar => "edged_far",
            Self::EdgeEnd => "edge_end",
            Self::CornerGraze(exponent) => return f.pad(&format!("corner_graze_1e-{exponent}")),
        })
    }
}

/// Parses the name of a class; the error is the unknown text.
impl FromStr for Class {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|class| class.to_string() == text)
            .ok_or_else(|| text.to_owned())
    }
}
