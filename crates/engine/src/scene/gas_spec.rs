//! The description of a gas: its molecules, their number, and their velocities at the start.

#[cfg(feature = "schema")]
use carom_geometry::{MAX_MAGNITUDE, MIN_MAGNITUDE, MIN_ROUNDING};
use serde::{Deserialize, Serialize, Serializer, ser::Error};

use crate::{
    scene::{
        atom_spec::AtomSpec,
        bond_spec::ChainSpec,
        distribution::Quantity,
        ellipse_spec::EllipseSpec,
        error::SceneError,
        is_false,
        region::Region,
        two_numbers::{pairs, vectors},
    },
    world::body::Rotation,
};

/// Most molecules of one kind. More exceed the memory and soon the range of their counters.
pub(crate) const MAX_MOLECULES: usize = 1 << 27;

/// The problem of a gas with two energies.
pub(crate) const TWO_ENERGIES: &str = "give either `energy` or `temperature`, not both";

/// The problem of a gas with two radii.
pub(crate) const TWO_RADII: &str = "give either `radius` or `atom_radius`, not both";

/// The problem of a gas with two masses.
pub(crate) const TWO_MASSES: &str = "give either `mass` or `atom_mass`, not both";

/// Many molecules of one shape, equal or of drawn sizes and masses, placed without overlap
/// ([`[start]`](crate::StartSpec)), with random velocities.
///
/// ```
/// use carom_engine::{Scene, Simulation};
///
/// let scene = Scene::from_toml(r#"
///     [[gas]]
///     shape = "dumbbell"
///     atom_radius = 0.005
///     atom_mass = 1.0
///     temperature = 2.5
///     velocities = "maxwell"
///     count = 300
/// "#)?;
/// let simulation = Simulation::new(&scene)?;
/// let temperature = simulation.view().temperature().expect("the molecules can move");
/// assert!((temperature / 2.5 - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct GasSpec {
    /// Tags of the molecules.
    pub tags: Vec<String>,
    /// A shape by name, as for a single molecule; `disc` if none of this, `atoms`, `ellipses` and
    /// `polygon` is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<String>,
    /// The list of atoms. Excludes `shape` and `polygon`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub atoms: Vec<AtomSpec>,
    /// The list of ellipses, after the `atoms` if both are given. No two parts may overlap.
    /// Excludes `shape`, `polygon` and `edges`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ellipses: Vec<EllipseSpec>,
    /// Pairs of atoms of the list with a straight edge between them, as indices from 0. Only with
    /// `atoms`.
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "pairs")]
    pub edges: Vec<[u32; 2]>,
    /// Half the thickness of each edge (length). Default: the smaller radius of the two atoms at
    /// its ends, which it must not exceed.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub edge_radius: Option<f64>,
    /// Whether closed lines of edges are hollow: other bodies may then be inside. Default: their
    /// interior belongs to the molecule.
    #[serde(skip_serializing_if = "is_false")]
    pub hollow: bool,
    /// Corners of a polygon, convex or not, whose sides do not cross (length), in any frame.
    /// Excludes `shape`, `atoms` and `ellipses`.
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "vectors")]
    pub polygon: Vec<[f64; 2]>,
    /// Radius of the corners of a polygon over its size, which is `size`, or the largest distance
    /// of two corners of `polygon`. All points within this radius of the polygon belong to it. At
    /// least 1e-10, and the radius at least 1e-10 of the largest distance of two corners. Default:
    /// 1e-6.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_ROUNDING, max = MAX_MAGNITUDE)))]
    pub rounding: Option<f64>,
    /// Size of a named shape with sides (length), as for a single molecule: a number, or a
    /// distribution from which each molecule draws its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<Quantity>,
    /// Radius of each atom of a named shape (length): a number, or a distribution from which each
    /// molecule draws its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub atom_radius: Option<Quantity>,
    /// Mass of each atom of a named shape (mass): a number, or a distribution, independent of that
    /// of the radius.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub atom_mass: Option<Quantity>,
    /// Radius of a disc (length); equivalent to `atom_radius`.
    ///
    /// Instead of a number also a distribution, from which each molecule draws its own: `{ uniform
    /// = [a, b] }`, `{ normal = [mean, deviation] }` or `{ values = [...], weights = [...] }`. So
    /// are `mass`, `atom_radius`, `atom_mass` and `scale`.
    #[doc(alias = "polydispersity")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<Quantity>,
    /// Mass of a disc (mass), equivalent to `atom_mass`; of a shape with sides or of a polygon, its
    /// mass, spread evenly over its area.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<Quantity>,
    /// A factor on all lengths of a molecule, for any shape. Masses stay, unless `density` sets
    /// them. Default: 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<Quantity>,
    /// Mass of a molecule per area that it covers (mass / length²), above 0.
    /// The atoms of a named shape share the mass equally, those of a list in proportion to their
    /// masses. Excludes `mass` and `atom_mass`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Mean kinetic energy of a molecule at the start (mass × length² / time²), from 0 to 1e60.
    /// With equal energies, that of each molecule, shared over its degrees of freedom by
    /// equipartition (see [`StartVelocities::EqualEnergy`] for molecules of different masses). A
    /// file gives either this or `temperature`; with `temperature`, this must be 0.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = MAX_MAGNITUDE)))]
    pub energy: f64,
    /// Temperature kT at the start (mass × length² / time²), from 0 to 1e60. Excludes `energy`.
    ///
    /// Let f₁ be the degrees of freedom of a molecule: 3 if contacts turn it, else 2. The total
    /// kinetic energy of N molecules is ½ f kT, with f as follows.
    ///
    /// * The gas starts without momentum (see `zero_momentum`): f = N f₁ − c m/M, with the number c
    ///   of axes along which momentum is conserved, the mass m of the gas, and the mass M of all
    ///   bodies that move. [`View::temperature`](crate::View::temperature) of the gas alone in the
    ///   box, where m/M = 1, is kT to rounding. If nothing else moves, several such gases of one
    ///   temperature have it together, and each such gas by itself has its own
    ///   ([`CentreOfMassFrame::thermal`](crate::CentreOfMassFrame::thermal)).
    /// * Other gases, and gases of one molecule: f = N f₁. `View::temperature` of such a gas alone
    ///   is kT to rounding where no momentum is conserved. Elsewhere it leaves out the energy of
    ///   the drift, and is random with the mean kT; for a single molecule that does not turn it is
    ///   `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = MAX_MAGNITUDE)))]
    pub temperature: Option<f64>,
    /// How the energy is shared among the molecules. Default: equally.
    #[serde(skip_serializing_if = "StartVelocities::is_default")]
    pub velocities: StartVelocities,
    /// The part of the box in which they are placed, such as `{ x = [0.0, 0.5] }`; the whole box if
    /// absent. With `start.from` the file has the places.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region: Option<Region>,
    /// Share of their region that they cover, which is the whole box if none is given, with
    /// overlaps of atoms counted once; rounded to the nearest number of molecules. Molecules of
    /// drawn sizes are drawn until the sum of their areas is nearest to this share, so that
    /// replicas may differ in their number. A share above 0 that rounds to no molecule is an error.
    /// Either this or `count`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0), extend("exclusiveMaximum" = 1.0)))]
    pub area_fraction: Option<f64>,
    /// Number of molecules. Alone, or, of equal molecules, with `area_fraction`: then the file
    /// gives no `box.sides`, and the box is the square in which so many molecules cover that
    /// share.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(max = MAX_MOLECULES)))]
    pub count: Option<usize>,
    /// Whether the total momentum of this gas is 0 at the start. `true`: molecules of equal energy
    /// have directions in opposite pairs (of an odd number, three directions are a third of a turn
    /// apart), and Maxwell velocities are drawn relative to their mean. `false`: velocities are
    /// independent of each other, and the gas drifts as a whole. Default: `true` where momentum is
    /// conserved along an axis, that is in a scene without fixed bodies, or whose only fixed bodies
    /// are parallel walls across the whole box.
    ///
    /// One molecule with energy cannot have momentum 0: for a gas of one molecule `true` is an
    /// error, and the default lets it move. The total momentum of a scene with such a gas, or with
    /// a `[[molecule]]` that moves, is therefore not 0 in general.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zero_momentum: Option<bool>,
    /// Whether the molecules turn (free) or not (locked).
    pub rotation: Rotation,
    /// How the molecules are tied to chains, rings or stars, in the order of their numbers. Chains
    /// are placed at random around single molecules, bumpers and walls, before all other gases;
    /// where they do not fit, those tied at their centres grow (`[start]`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[doc(alias = "polymer")]
    pub chain: Option<ChainSpec>,
    /// Whether the molecules never move: obstacles of infinite mass. They are placed one by one at
    /// random (random sequential addition), before the gases that move, and need no mass and no
    /// energy. `region`, `count` and `area_fraction` hold as for other gases.
    #[serde(skip_serializing_if = "is_false")]
    #[doc(alias = "Lorentz gas")]
    pub fixed: bool,
    /// Whether the molecules of a fixed gas may overlap each other, and other fixed bodies: their
    /// places are independent of each other. `area_fraction` is then the share 1 − exp(−n a) of
    /// their region that they are expected to cover, with the number n of molecules per area, and
    /// the area a of one of them. Only with `fixed`.
    #[serde(skip_serializing_if = "is_false")]
    #[doc(alias = "Poisson")]
    pub overlapping: bool,
}

impl GasSpec {
    /// The radius of an atom or of a disc, if there is one; `None` if there are two.
    #[expect(clippy::option_option, reason = "two and none are different")]
    pub(crate) fn one_radius(&self) -> Option<Option<&Quantity>> {
        one([self.radius.as_ref(), self.atom_radius.as_ref()])
    }

    /// The mass of an atom or of a disc, if there is one; `None` if there are two.
    #[expect(clippy::option_option, reason = "two and none are different")]
    pub(crate) fn one_mass(&self) -> Option<Option<&Quantity>> {
        one([self.mass.as_ref(), self.atom_mass.as_ref()])
    }

    /// The sum of the areas of molecules over the area in which they cover this share.
    pub(crate) fn sum_of_areas(&self, share: f64) -> f64 {
        if self.overlapping {
            -libm::log1p(-share)
        } else {
            share
        }
    }

    /// Refuses what only molecules that move have of a fixed gas, and overlaps of one that is not
    /// fixed.
    pub(crate) fn check_fixed(&self) -> Result<(), String> {
        if !self.fixed {
            return if self.overlapping {
                Err(
                    "`overlapping` goes with `fixed = true`; molecules that move and may overlap are \
                     `[[transparent]]`"
                        .to_owned(),
                )
            } else {
                Ok(())
            };
        }
        let given = [
            ("energy", self.energy != 0.0),
            ("temperature", self.temperature.is_some()),
            ("velocities", self.velocities != StartVelocities::default()),
            ("zero_momentum", self.zero_momentum.is_some()),
            ("chain", self.chain.is_some()),
        ];
        match given.into_iter().find(|(_, is_given)| *is_given) {
            None => Ok(()),
            Some((key, _)) => Err(format!(
                "a gas of `fixed` molecules never moves and has no `{key}`: leave it out"
            )),
        }
    }

    /// Whether molecules have different sizes.
    pub(crate) fn has_drawn_sizes(&self) -> bool {
        let given = [&self.radius, &self.atom_radius, &self.size, &self.scale];
        given.into_iter().flatten().any(|given| !given.is_one())
    }
}

#[expect(clippy::option_option, reason = "two and none are different")]
fn one(given: [Option<&Quantity>; 2]) -> Option<Option<&Quantity>> {
    match given {
        [Some(_), Some(_)] => None,
        [first, second] => Some(first.or(second)),
    }
}

/// How the molecules of a gas share its energy at the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum StartVelocities {
    /// All molecules have the same energy and the same share of it in rotation; directions are
    /// random. Contacts lead to Maxwell's distribution within a few collisions a molecule. In a gas
    /// of different masses that starts without momentum, the velocity of the centre of mass is
    /// subtracted, and energies differ by a share of about 1/√N.
    #[default]
    EqualEnergy,
    /// Each component of velocity and each angular velocity is drawn from a normal distribution,
    /// with variances kT/m and kT/I, where masses may differ. Then all are multiplied by one
    /// factor, so that the total energy is the same as with equal energies: the distribution is
    /// that of a gas at equilibrium with this energy, and, if it starts without momentum, with
    /// momentum 0.
    #[doc(alias = "Boltzmann")]
    #[doc(alias = "Gaussian")]
    Maxwell,
}

impl StartVelocities {
    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Refuses gases of a scene file with neither or both of `energy` and `temperature`. In code the
/// energy has a default; in a file its absence is most likely an error.
pub(crate) fn energy_or_temperature(table: &toml::Table) -> Result<(), SceneError> {
    let Some(toml::Value::Array(gases)) = table.get("gas") else {
        return Ok(());
    };
    for (index, gas) in gases.iter().enumerate() {
        let problem = match ["energy", "temperature"].map(|key| gas.get(key).is_some()) {
            [false, false] if gas.get("fixed").and_then(toml::Value::as_bool) == Some(true) => {
                continue;
            }
            [false, false] => "`energy` or `temperature` is missing",
            [true, true] => TWO_ENERGIES,
            _ => continue,
        };
        return Err(SceneError::Entry {
            entry: format!("gas[{index}]"),
            problem: problem.to_owned(),
        });
    }
    Ok(())
}

/// Writes gases as in a file, which must not give two energies: without the energy 0 of those with
/// a temperature and of fixed ones.
pub(crate) fn serialize_gases<S: Serializer>(
    gases: &[GasSpec],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    struct Written<'a>(&'a GasSpec);
    impl Serialize for Written<'_> {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            let has_other = self.0.temperature.is_some() || self.0.fixed;
            if !has_other || self.0.energy != 0.0 {
                return self.0.serialize(serializer);
            }
            let mut table = toml::Table::try_from(self.0).map_err(S::Error::custom)?;
            table.remove("energy");
            table.serialize(serializer)
        }
    }
    serializer.collect_seq(gases.iter().map(Written))
}
