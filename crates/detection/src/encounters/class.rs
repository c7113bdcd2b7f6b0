//! The classes of encounters and their difficulties.

use std::{fmt, str::FromStr};

use super::{Encounter, contacts, fast, flights, grazes, random::Draw, walls};

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
}

impl Class {
    /// All classes; those with a parameter at selected values.
    pub const ALL: [Self; 41] = [
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
    ];

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
