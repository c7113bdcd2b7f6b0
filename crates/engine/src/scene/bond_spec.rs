//! Bonds: tethers between two points of two bodies, in lists or along the chains of a gas.

use carom_detection::Tether;
#[cfg(feature = "schema")]
use carom_geometry::{MAX_MAGNITUDE, MIN_MAGNITUDE};
use carom_response::Elasticity;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::scene::{
    is_default, is_one, one,
    two_numbers::{pairs_of_bodies, two_vectors},
};

/// Bonds of one kind between bodies of the scene.
///
/// The two points of a bond fly freely while their distance is between `min` and `max`. At `max`
/// the bond is taut, and the points bounce back; at `min` they bounce like surfaces that touch.
/// With a small `max` the two bodies are hinged at these points; the number of events of the bond
/// in a time goes as 1/`max`.
///
/// ```
/// use carom_engine::{Scene, Simulation};
///
/// // Three discs in a row, tied at their centres.
/// let scene = Scene::from_toml(r#"
///     [[bond]]
///     pairs = [[0, 1], [1, 2]]
///     tether = { max = 0.06 }
///     [[molecule]]
///     atoms = [{ at = [0, 0], radius = 0.02, mass = 1.0 }]
///     at = [0.40, 0.5]
///     velocity = [0.3, 0.1]
///     [[molecule]]
///     atoms = [{ at = [0, 0], radius = 0.02, mass = 1.0 }]
///     at = [0.45, 0.5]
///     velocity = [-0.2, 0.2]
///     [[molecule]]
///     atoms = [{ at = [0, 0], radius = 0.02, mass = 1.0 }]
///     at = [0.50, 0.5]
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// simulation.run_until(10.0)?;
/// let view = simulation.view();
/// assert!(view.counters().bond_collisions > 10);
/// for bond in view.bonds() {
///     assert!(bond.length > 0.04 - 1e-12 && bond.length < 0.06 + 1e-12);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[doc(alias = "hinge")]
#[doc(alias = "polymer")]
pub struct BondSpec {
    /// Pairs of bodies, each tied by one bond, as numbers from 0: first the `[[molecule]]`s, then
    /// the bumpers and walls, then the molecules of the gases, as in snapshots. Bodies that are
    /// added later continue the count.
    #[serde(deserialize_with = "pairs_of_bodies")]
    pub pairs: Vec<[u64; 2]>,
    /// What ties them. The first point of `points` is on the first body of each pair.
    pub tether: TetherSpec,
}

/// What ties two bodies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TetherSpec {
    /// Greatest distance of the two points (length).
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub max: f64,
    /// Least distance of the two points (length), below `max`. Default: 0, none. Bodies keep the
    /// distance of their surfaces in any case, unless they are `[[transparent]]`.
    #[serde(default, skip_serializing_if = "is_default")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = MAX_MAGNITUDE)))]
    pub min: f64,
    /// The two points, each from the centre of mass of its body and in the frame in which the
    /// atoms of the body are listed (length). Default: the centres of mass.
    #[serde(
        default,
        skip_serializing_if = "is_default",
        deserialize_with = "two_vectors"
    )]
    pub points: [[f64; 2]; 2],
    /// Share of the speed with which the points part or meet that they keep, from 0 to 1. Below 1,
    /// `elasticity.contact_time` must be above 0. Default: 1.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 1.0)))]
    pub elasticity: f64,
}

impl Default for TetherSpec {
    fn default() -> Self {
        Self {
            max: 0.0,
            min: 0.0,
            points: [[0.0; 2]; 2],
            elasticity: 1.0,
        }
    }
}

/// How the molecules of a gas are tied to each other.
///
/// ```
/// use carom_engine::{Scene, Simulation};
///
/// // Ten chains of eight discs.
/// let scene = Scene::from_toml(r#"
///     [[gas]]
///     radius = 0.01
///     mass = 1.0
///     temperature = 1.0
///     count = 80
///     chain = { members = 8, tether = { max = 0.03 } }
/// "#)?;
/// let simulation = Simulation::new(&scene)?;
/// assert_eq!(simulation.view().bonds().count(), 70);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ChainSpec {
    /// Number of molecules of a chain, at least 2; the number of molecules of the gas must be a
    /// multiple of it.
    #[cfg_attr(feature = "schema", schemars(range(min = 2)))]
    pub members: usize,
    /// Whether the last is tied to the first. At least 3 members, tied at their centres.
    #[serde(default, skip_serializing_if = "is_default")]
    pub ring: bool,
    /// Number of arms of a star, from 3 on: all equally long, and tied to the first molecule.
    /// Default: none, a chain. Excludes `ring`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub arms: usize,
    /// What ties two neighbours: the first point is on the one nearer to the start of the chain.
    pub tether: TetherSpec,
}

impl TetherSpec {
    /// The tether and its elasticity.
    ///
    /// # Errors
    /// A number is out of range.
    pub(crate) fn checked(&self) -> Result<(Tether, Elasticity), String> {
        let points = self.points.map(DVec2::from);
        let tether = Tether::new(points, [self.min, self.max]);
        let tether = tether.map_err(|reason| reason.to_string())?;
        let share = Some(self.elasticity).filter(|share| (0.0..=1.0).contains(share));
        let elasticity = share.and_then(|share| Elasticity::new(share).ok());
        let elasticity = elasticity.ok_or_else(|| {
            let given = self.elasticity;
            format!("`elasticity` of a tether must be from 0 to 1, but is {given:?}")
        })?;
        Ok((tether, elasticity))
    }
}

impl ChainSpec {
    /// The number of bonds of one chain.
    pub fn bonds(&self) -> usize {
        if self.ring {
            self.members
        } else {
            self.members.saturating_sub(1)
        }
    }

    /// The neighbour of member number `member`, from 1 on, to which it is tied and which is nearer
    /// to the start.
    pub(crate) fn before(&self, member: usize) -> usize {
        if self.arms == 0 {
            return member - 1;
        }
        let length = (self.members - 1) / self.arms;
        if (member - 1).is_multiple_of(length) {
            0
        } else {
            member - 1
        }
    }

    /// Refuses numbers that do not fit each other, for a gas of `count` molecules.
    pub(crate) fn check(&self, count: usize) -> Result<(), String> {
        self.tether.checked()?;
        let members = self.members;
        if members < 2 {
            return Err(format!(
                "`chain.members` must be at least 2, but is {members}"
            ));
        }
        if !count.is_multiple_of(members) {
            return Err(format!(
                "the {count} molecules are not a whole number of chains of {members} members: give a `count` that is a \
                 multiple of `chain.members`"
            ));
        }
        if self.ring && (members < 3 || self.arms > 0) {
            return Err("a `chain.ring` has at least 3 members and no `arms`".to_owned());
        }
        if self.ring && self.tether.points != [[0.0; 2]; 2] {
            return Err(
                "the members of a `chain.ring` are tied at their centres: leave out `points`"
                    .to_owned(),
            );
        }
        let arms = self.arms;
        if arms > 0 && (arms < 3 || !(members - 1).is_multiple_of(arms)) {
            return Err(format!(
                "a star of {arms} `arms` has at least 3, all equally long: one member and a multiple of the number of \
                 arms, but it has {members} members"
            ));
        }
        Ok(())
    }
}
