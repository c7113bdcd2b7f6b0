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

/// Facts about a capability.
struct CapabilityEntry {
    capability: Capability,
    name: &'static str,
    /// Description of the scene at either level.
    idle: &'static str,
    used: &'static str,
    /// Sources that only this capability needs, relative to `crates`.
    sources: &'static [&'static str],
}

/// An entry for each capability, in the order of [`Capability`].
const ENTRIES: &[CapabilityEntry] = &[
    CapabilityEntry {
        capability: Capability::Turning,
        name: "turning molecules",
        idle: "one dumbbell among the discs",
        used: "200 dumbbells among the discs",
        sources: &[
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
    },
    CapabilityEntry {
        capability: Capability::Sides,
        name: "sides",
        idle: "one square among the discs",
        used: "200 squares among the discs",
        sources: &[
            "geometry/src/edged_shape.rs",
            "geometry/src/hull.rs",
            "geometry/src/interior.rs",
            "geometry/src/union.rs",
            "detection/src/lines.rs",
        ],
    },
    CapabilityEntry {
        capability: Capability::Locked,
        name: "locked rotation",
        idle: "the discs are locked, although they never rotate",
        used: "200 dumbbells of locked rotation among the discs",
        sources: &[],
    },
    CapabilityEntry {
        capability: Capability::Bumpers,
        name: "bumpers",
        idle: "one bumper as large as a disc",
        used: "200 bumpers as large as the discs",
        sources: &[],
    },
    CapabilityEntry {
        capability: Capability::Walls,
        name: "walls",
        idle: "one wall of a disc's length",
        used: "two walls across the box, which close it",
        sources: &[
            "geometry/src/edge.rs",
            "detection/src/edge_error.rs",
            "detection/src/edge_pair.rs",
            "detection/src/edges.rs",
            "detection/src/strip.rs",
            "engine/src/cells/walls.rs",
            "engine/src/world/wall.rs",
        ],
    },
    CapabilityEntry {
        capability: Capability::Tags,
        name: "tags",
        idle: "three tags on each disc that nothing uses",
        used: "three tags, and a subscription that filters by two of them",
        sources: &["engine/src/world/tags.rs", "observers/src/tag_filter.rs"],
    },
    CapabilityEntry {
        capability: Capability::ElasticityTable,
        name: "elasticity table",
        idle: "a rule for a tag that no disc carries",
        used: "a rule for all discs, e = 0.999, with its guard",
        sources: &[
            "engine/src/contact/elasticity_table.rs",
            "engine/src/contact/guard.rs",
        ],
    },
    CapabilityEntry {
        capability: Capability::Rough,
        name: "rough contacts",
        idle: "a rough rule for a tag that no disc carries",
        used: "all contacts are perfectly rough: the discs turn",
        sources: &["response/src/rough.rs"],
    },
    CapabilityEntry {
        capability: Capability::Subscriptions,
        name: "subscriptions",
        idle: "an empty list of subscriptions",
        used: "one subscription to every collision",
        sources: &[
            "engine/src/run/observer.rs",
            "engine/src/world/report.rs",
            "observers/src/subscriptions.rs",
        ],
    },
    CapabilityEntry {
        capability: Capability::Snapshots,
        name: "snapshots",
        idle: "samples, about three collisions of each disc apart",
        used: "samples with a snapshot at each",
        sources: &["engine/src/world/view.rs", "observers/src/extended_xyz.rs"],
    },
    CapabilityEntry {
        capability: Capability::Thermostat,
        name: "thermostat",
        idle: "at each sample, an energy reset of a tag without bodies",
        used: "at each sample, an energy reset of all discs",
        sources: &[
            "engine/src/edit/mod.rs",
            "observers/src/thermostat_ledger.rs",
        ],
    },
    CapabilityEntry {
        capability: Capability::SizeMixture,
        name: "size mixture",
        idle: "one disc three times as wide",
        used: "200 discs three times as wide",
        sources: &[
            "engine/src/cells/multi_cell/mod.rs",
            "engine/src/cells/multi_cell/covered.rs",
            "engine/src/cells/multi_cell/earliest_event.rs",
            "engine/src/cells/multi_cell/large_disc.rs",
            "engine/src/cells/multi_cell/listing.rs",
            "engine/src/cells/multi_cell/search.rs",
        ],
    },
    CapabilityEntry {
        capability: Capability::TransparentPairs,
        name: "transparent pairs",
        idle: "a factor of 1 on the diameters of the discs",
        used: "discs of two tags, which do not see each other",
        sources: &[
            "engine/src/cells/discs_by_pair.rs",
            "engine/src/cells/pair_classes.rs",
            "engine/src/world/pair_table.rs",
        ],
    },
    CapabilityEntry {
        capability: Capability::Bonds,
        name: "bonds",
        idle: "two discs tied to each other",
        used: "all discs in chains of 16",
        sources: &[
            "detection/src/tether.rs",
            "engine/src/start/bonds.rs",
            "engine/src/start/chains.rs",
            "engine/src/world/tethers.rs",
        ],
    },
    CapabilityEntry {
        capability: Capability::Wells,
        name: "wells",
        idle: "one disc with a well of 1.5 diameters",
        used: "all discs with wells of 1.5 diameters",
        sources: &["engine/src/start/wells.rs", "engine/src/world/wells.rs"],
    },
    CapabilityEntry {
        capability: Capability::Reactions,
        name: "reactions",
        idle: "discs of two tags with a reaction that no contact has the energy for",
        used: "discs of two tags, which they exchange at contacts",
        sources: &[
            "engine/src/contact/reaction_table.rs",
            "engine/src/world/reaction_record.rs",
        ],
    },
    CapabilityEntry {
        capability: Capability::Ellipses,
        name: "ellipses",
        idle: "one ellipse 2:1 among the discs",
        used: "200 ellipses 2:1 among the discs",
        sources: &[
            "detection/src/ellipses.rs",
            "detection/src/support_edge.rs",
            "detection/src/support_pair.rs",
            "geometry/src/ellipse.rs",
            "geometry/src/support.rs",
        ],
    },
    CapabilityEntry {
        capability: Capability::Arcs,
        name: "curved walls",
        idle: "half a circle of a disc's radius",
        used: "a circle of radius 0.4, discs on both sides",
        sources: &[
            "detection/src/arc_pair.rs",
            "detection/src/squared_gap.rs",
            "geometry/src/bend.rs",
        ],
    },
    CapabilityEntry {
        capability: Capability::MovingWalls,
        name: "moving walls",
        idle: "one wall of a disc's length that moves slowly",
        used: "a wall across the box that oscillates",
        sources: &[
            "detection/src/driven.rs",
            "engine/src/start/wall_motions.rs",
            "engine/src/world/drives.rs",
            "kinematics/src/drive.rs",
        ],
    },
    CapabilityEntry {
        capability: Capability::Pistons,
        name: "pistons",
        idle: "a piston of mass 1e9, beside a wall",
        used: "a piston of mass 100, beside a wall",
        sources: &["engine/src/start/pistons.rs", "engine/src/world/pistons.rs"],
    },
    CapabilityEntry {
        capability: Capability::Gravity,
        name: "gravity",
        idle: "gravity of 1e-9, on a floor",
        used: "gravity of 1, on a floor",
        sources: &["engine/src/scene/gravity.rs"],
    },
    CapabilityEntry {
        capability: Capability::Drag,
        name: "drag",
        idle: "a drag of 1e-9",
        used: "a drag of 1",
        sources: &["kinematics/src/drag_clock.rs"],
    },
    CapabilityEntry {
        capability: Capability::Shear,
        name: "shear",
        idle: "a shear rate of 1e-9",
        used: "a shear rate of 1",
        sources: &["engine/src/world/shear.rs"],
    },
];

// `Capability::entry` finds an entry by its index.
const _: () = {
    let mut index = 0;
    while index < ENTRIES.len() {
        assert!(ENTRIES[index].capability as usize == index);
        index += 1;
    }
};

impl Capability {
    /// All capabilities.
    pub fn all() -> impl Iterator<Item = Self> {
        ENTRIES.iter().map(|entry| entry.capability)
    }

    fn entry(self) -> &'static CapabilityEntry {
        &ENTRIES[self as usize]
    }

    /// Name of the capability.
    pub fn name(self) -> &'static str {
        self.entry().name
    }

    /// Description of the scene at this level.
    pub fn about(self, level: CapabilityLevel) -> &'static str {
        match level {
            CapabilityLevel::Idle => self.entry().idle,
            CapabilityLevel::Used => self.entry().used,
        }
    }

    /// Sources that only this capability needs. Some have none, such as bumpers, which are discs of
    /// inverse mass 0.
    pub fn sources(self) -> &'static [&'static str] {
        self.entry().sources
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
            .chain(Capability::all().flat_map(levels))
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
        for capability in Capability::all() {
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
