//! The capabilities, and the definition of absent, idle and used for each.

use std::{fmt, str::FromStr};

use anyhow::{Error, bail};
use carom_runs::measures;

/// Measures of every run.
pub const EVERY_RUN: [&str; 3] = ["energy", "overlap", "collision-rate"];

/// An extension of a scene beyond equal elastic discs without observers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Capability {
    /// Molecules that rotate.
    Turning,
    /// Molecules with straight sides, which rotate.
    Sides,
    /// Molecules of locked rotation.
    Locked,
    /// Fixed discs.
    Bumpers,
    /// Straight walls.
    Walls,
    /// Tags on bodies.
    Tags,
    /// Rules of elasticity.
    ElasticityTable,
    /// Rough contacts.
    Rough,
    /// Callbacks for collisions.
    Subscriptions,
    /// Snapshots at samples.
    Snapshots,
    /// Resets of energy at samples.
    Thermostat,
    /// Discs of several sizes.
    SizeMixture,
    /// Pairs of bodies that do not see each other.
    TransparentPairs,
    /// Discs that are tied to each other.
    Bonds,
    /// Wells of discs.
    Wells,
    /// Reactions of discs that collide.
    Reactions,
    /// Ellipses, which rotate.
    Ellipses,
    /// Curved walls.
    Arcs,
    /// Walls that move.
    MovingWalls,
    /// Pistons.
    Pistons,
    /// Gravity.
    Gravity,
    /// A drag.
    Drag,
    /// Shear.
    Shear,
}

/// Degree of use of a capability.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CapabilityLevel {
    /// Requested, with no or almost no work to do.
    Idle,
    /// Used.
    Used,
}

/// A scene to run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variant {
    /// The gas of equal discs with a seed; a second seed shows the statistical error.
    Plain(u64),
    /// The gas with a capability.
    With(Capability, CapabilityLevel),
    /// The gas with a measure, by the name of its kind, sampled about every three collisions of a
    /// disc.
    Measure(&'static str),
}

impl Capability {
    /// All capabilities.
    pub const ALL: [Self; 23] = [
        Self::Turning,
        Self::Sides,
        Self::Locked,
        Self::Bumpers,
        Self::Walls,
        Self::Tags,
        Self::ElasticityTable,
        Self::Rough,
        Self::Subscriptions,
        Self::Snapshots,
        Self::Thermostat,
        Self::SizeMixture,
        Self::TransparentPairs,
        Self::Bonds,
        Self::Wells,
        Self::Reactions,
        Self::Ellipses,
        Self::Arcs,
        Self::MovingWalls,
        Self::Pistons,
        Self::Gravity,
        Self::Drag,
        Self::Shear,
    ];

    /// Name of the capability.
    pub fn name(self) -> &'static str {
        match self {
            Self::Turning => "turning molecules",
            Self::Sides => "sides",
            Self::Locked => "locked rotation",
            Self::Bumpers => "bumpers",
            Self::Walls => "walls",
            Self::Tags => "tags",
            Self::ElasticityTable => "elasticity table",
            Self::Rough => "rough contacts",
            Self::Subscriptions => "subscriptions",
            Self::Snapshots => "snapshots",
            Self::Thermostat => "thermostat",
            Self::SizeMixture => "size mixture",
            Self::TransparentPairs => "transparent pairs",
            Self::Bonds => "bonds",
            Self::Wells => "wells",
            Self::Reactions => "reactions",
            Self::Ellipses => "ellipses",
            Self::Arcs => "curved walls",
            Self::MovingWalls => "moving walls",
            Self::Pistons => "pistons",
            Self::Gravity => "gravity",
            Self::Drag => "drag",
            Self::Shear => "shear",
        }
    }

    /// Description of the scene at this level.
    pub fn about(self, level: CapabilityLevel) -> &'static str {
        match (self, level) {
            (Self::Turning, CapabilityLevel::Idle) => "one dumbbell among the discs",
            (Self::Turning, CapabilityLevel::Used) => "200 dumbbells among the discs",
            (Self::Sides, CapabilityLevel::Idle) => "one square among the discs",
            (Self::Sides, CapabilityLevel::Used) => "200 squares among the discs",
            (Self::Locked, CapabilityLevel::Idle) => {
                "the discs are locked, although they never rotate"
            }
            (Self::Locked, CapabilityLevel::Used) => {
                "200 dumbbells of locked rotation among the discs"
            }
            (Self::Bumpers, CapabilityLevel::Idle) => "one bumper as large as a disc",
            (Self::Bumpers, CapabilityLevel::Used) => "200 bumpers as large as the discs",
            (Self::Walls, CapabilityLevel::Idle) => "one wall of a disc's length",
            (Self::Walls, CapabilityLevel::Used) => "two walls across the box, which close it",
            (Self::Tags, CapabilityLevel::Idle) => "three tags on each disc that nothing uses",
            (Self::Tags, CapabilityLevel::Used) => {
                "three tags, and a subscription that filters by two of them"
            }
            (Self::ElasticityTable, CapabilityLevel::Idle) => {
                "a rule for a tag that no disc carries"
            }
            (Self::ElasticityTable, CapabilityLevel::Used) => {
                "a rule for all discs, e = 0.999, with its guard"
            }
            (Self::Rough, CapabilityLevel::Idle) => "a rough rule for a tag that no disc carries",
            (Self::Rough, CapabilityLevel::Used) => {
                "all contacts are perfectly rough: the discs turn"
            }
            (Self::Subscriptions, CapabilityLevel::Idle) => "an empty list of subscriptions",
            (Self::Subscriptions, CapabilityLevel::Used) => "one subscription to every collision",
            (Self::Snapshots, CapabilityLevel::Idle) => {
                "samples, about three collisions of each disc apart"
            }
            (Self::Snapshots, CapabilityLevel::Used) => "samples with a snapshot at each",
            (Self::Thermostat, CapabilityLevel::Idle) => {
                "at each sample, an energy reset of a tag without bodies"
            }
            (Self::Thermostat, CapabilityLevel::Used) => {
                "at each sample, an energy reset of all discs"
            }
            (Self::SizeMixture, CapabilityLevel::Idle) => "one disc three times as wide",
            (Self::SizeMixture, CapabilityLevel::Used) => "200 discs three times as wide",
            (Self::TransparentPairs, CapabilityLevel::Idle) => {
                "a factor of 1 on the diameters of the discs"
            }
            (Self::TransparentPairs, CapabilityLevel::Used) => {
                "discs of two tags, which do not see each other"
            }
            (Self::Bonds, CapabilityLevel::Idle) => "two discs tied to each other",
            (Self::Bonds, CapabilityLevel::Used) => "all discs in chains of 16",
            (Self::Wells, CapabilityLevel::Idle) => "one disc with a well of 1.5 diameters",
            (Self::Wells, CapabilityLevel::Used) => "all discs with wells of 1.5 diameters",
            (Self::Reactions, CapabilityLevel::Idle) => {
                "discs of two tags with a reaction that no contact has the energy for"
            }
            (Self::Reactions, CapabilityLevel::Used) => {
                "discs of two tags, which they exchange at contacts"
            }
            (Self::Ellipses, CapabilityLevel::Idle) => "one ellipse 2:1 among the discs",
            (Self::Ellipses, CapabilityLevel::Used) => "200 ellipses 2:1 among the discs",
            (Self::Arcs, CapabilityLevel::Idle) => "half a circle of a disc's radius",
            (Self::Arcs, CapabilityLevel::Used) => "a circle of radius 0.4, discs on both sides",
            (Self::MovingWalls, CapabilityLevel::Idle) => {
                "one wall of a disc's length that moves slowly"
            }
            (Self::MovingWalls, CapabilityLevel::Used) => "a wall across the box that oscillates",
            (Self::Pistons, CapabilityLevel::Idle) => "a piston of mass 1e9, beside a wall",
            (Self::Pistons, CapabilityLevel::Used) => "a piston of mass 100, beside a wall",
            (Self::Gravity, CapabilityLevel::Idle) => "gravity of 1e-9, on a floor",
            (Self::Gravity, CapabilityLevel::Used) => "gravity of 1, on a floor",
            (Self::Drag, CapabilityLevel::Idle) => "a drag of 1e-9",
            (Self::Drag, CapabilityLevel::Used) => "a drag of 1",
            (Self::Shear, CapabilityLevel::Idle) => "a shear rate of 1e-9",
            (Self::Shear, CapabilityLevel::Used) => "a shear rate of 1",
        }
    }

    /// Sources that only this capability needs. Some have none, such as bumpers, which are discs of
    /// inverse mass 0.
    pub fn sources(self) -> &'static [&'static str] {
        match self {
            Self::Turning => &[
                "kinematics/src/orientation.rs",
                "detection/src/atom_block.rs",
                "detection/src/atom_pair.rs",
                "detection/src/circle_descent.rs",
                "detection/src/error_bound.rs",
                "detection/src/exact.rs",
                "detection/src/flight.rs",
                "detection/src/gap_search.rs",
                "detection/src/safe_step.rs",
                "detection/src/search.rs",
                "detection/src/skimming.rs",
                "geometry/src/circle_tree.rs",
            ],
            Self::Sides => &[
                "geometry/src/edged_shape.rs",
                "geometry/src/hull.rs",
                "geometry/src/interior.rs",
                "geometry/src/union.rs",
                "detection/src/lines.rs",
            ],
            Self::Walls => &[
                "geometry/src/edge.rs",
                "detection/src/edge_error.rs",
                "detection/src/edge_pair.rs",
                "detection/src/edges.rs",
                "detection/src/strip.rs",
                "engine/src/cells/walls.rs",
                "engine/src/world/wall.rs",
            ],
            Self::Tags => &["engine/src/world/tags.rs", "observers/src/tag_filter.rs"],
            Self::ElasticityTable => &[
                "engine/src/contact/elasticity_table.rs",
                "engine/src/contact/guard.rs",
            ],
            Self::Rough => &["response/src/rough.rs"],
            Self::Subscriptions => &[
                "engine/src/run/observer.rs",
                "engine/src/world/report.rs",
                "observers/src/subscriptions.rs",
            ],
            Self::Snapshots => &["engine/src/world/view.rs", "observers/src/extended_xyz.rs"],
            Self::Thermostat => &[
                "engine/src/edit/mod.rs",
                "observers/src/thermostat_ledger.rs",
            ],
            Self::SizeMixture => &[
                "engine/src/cells/multi_cell/mod.rs",
                "engine/src/cells/multi_cell/covered.rs",
                "engine/src/cells/multi_cell/earliest_event.rs",
                "engine/src/cells/multi_cell/large_disc.rs",
                "engine/src/cells/multi_cell/listing.rs",
                "engine/src/cells/multi_cell/search.rs",
            ],
            Self::TransparentPairs => &[
                "engine/src/cells/discs_by_pair.rs",
                "engine/src/cells/pair_classes.rs",
                "engine/src/world/pair_table.rs",
            ],
            Self::Bonds => &[
                "detection/src/tether.rs",
                "engine/src/start/bonds.rs",
                "engine/src/start/chains.rs",
                "engine/src/world/tethers.rs",
            ],
            Self::Wells => &["engine/src/start/wells.rs", "engine/src/world/wells.rs"],
            Self::Reactions => &[
                "engine/src/contact/reaction_table.rs",
                "engine/src/world/reaction_record.rs",
            ],
            Self::Ellipses => &[
                "detection/src/ellipses.rs",
                "detection/src/support_edge.rs",
                "detection/src/support_pair.rs",
                "geometry/src/ellipse.rs",
                "geometry/src/support.rs",
            ],
            Self::Arcs => &[
                "detection/src/arc_pair.rs",
                "detection/src/squared_gap.rs",
                "geometry/src/bend.rs",
            ],
            Self::MovingWalls => &[
                "detection/src/driven.rs",
                "engine/src/start/wall_motions.rs",
                "engine/src/world/drives.rs",
                "kinematics/src/drive.rs",
            ],
            Self::Pistons => &["engine/src/start/pistons.rs", "engine/src/world/pistons.rs"],
            Self::Gravity => &["engine/src/scene/gravity.rs"],
            Self::Drag => &["kinematics/src/drag_clock.rs"],
            Self::Shear => &["engine/src/world/shear.rs"],
            Self::Locked | Self::Bumpers => &[],
        }
    }
}

impl fmt::Display for CapabilityLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Idle => "idle",
            Self::Used => "used",
        })
    }
}

/// Measures of bodies that have an axis.
const OF_AXES: [&str; 4] = ["nematic", "tetratic", "k-atic", "body-frame-diffusion"];

impl Variant {
    /// Every run's own measures, which are those of `energy`, then each other measure with them.
    /// The plain gas has no wall whose heat could be measured, no piston and no bonds, and its
    /// discs have no axes; the Lyapunov exponents of so many bodies cost more than the gas.
    pub fn measures() -> impl Iterator<Item = Self> {
        let others = |name: &&str| {
            !EVERY_RUN[1..].contains(name)
                && !OF_AXES.contains(name)
                && !name.starts_with("wall-")
                && !["piston", "lyapunov", "chains", "chain-relaxation"].contains(name)
        };
        measures::KINDS
            .iter()
            .map(|kind| kind.name)
            .filter(others)
            .map(Self::Measure)
    }

    /// All variants: the plain gas first, the plain gas with another seed second.
    pub fn all() -> Vec<Self> {
        let levels = |capability| {
            [CapabilityLevel::Idle, CapabilityLevel::Used]
                .map(|level| Self::With(capability, level))
        };
        [Self::Plain(1), Self::Plain(2)]
            .into_iter()
            .chain(Capability::ALL.into_iter().flat_map(levels))
            .chain(Self::measures())
            .collect()
    }
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Plain(seed) => write!(f, "plain {seed}"),
            Self::With(capability, level) => write!(f, "{} {level}", capability.name()),
            Self::Measure(name) => write!(f, "measure {name}"),
        }
    }
}

impl FromStr for Variant {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        match Self::all()
            .into_iter()
            .find(|variant| variant.to_string() == name)
        {
            Some(variant) => Ok(variant),
            None => bail!("no variant '{name}'"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn every_source_of_a_capability_exists() {
        // A renamed source would count nothing, and the capability would seem free.
        let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates");
        for capability in Capability::ALL {
            for source in capability.sources() {
                assert!(
                    crates.join(source).is_file(),
                    "{}: {source}",
                    capability.name()
                );
            }
        }
    }
}
