//! Reactions: what becomes of two bodies that collide, by their tags, with a probability and above
//! a least energy.

#[cfg(feature = "schema")]
use carom_geometry::MAX_MAGNITUDE;
use serde::{Deserialize, Serialize};

use crate::scene::{MoleculeSpec, is_one, is_zero, one};

/// The word for a body that a reaction removes, in place of a tag.
pub(crate) const NOTHING: &str = "nothing";

/// A reaction of two bodies at their contact.
///
/// The contact takes place first, like any other, with its impulse. Then the reaction is decided:
/// it needs an energy of approach of at least `least_energy` just before the contact, and takes
/// place with `probability`, by a random number of its own. Rules are tried in their order, and at
/// most one of them acts at a contact. Bumpers, walls and molecules of fixed gases are bodies, too;
/// a wall can get another tag, but no reaction removes it.
///
/// ```
/// use carom_engine::{Scene, Simulation};
///
/// // A + A → 0, at one of ten contacts.
/// let scene = Scene::from_toml(r#"
///     [[reaction]]
///     between = ["A"]
///     probability = 0.1
///     becomes = ["nothing", "nothing"]
///     [[gas]]
///     tags = ["A"]
///     radius = 0.01
///     mass = 1.0
///     temperature = 1.0
///     count = 100
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// simulation.run_until(1.0)?;
/// let view = simulation.view();
/// let counts = view.reactions()[0].counts;
/// assert!(counts.reactions > 0);
/// assert_eq!(view.len() as u64, 100 - 2 * counts.reactions);
/// assert!((view.energy() - view.ledger().booked()).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[doc(alias = "chemical reaction")]
#[doc(alias = "annihilation")]
#[doc(alias = "coalescence")]
pub struct ReactionSpec {
    /// Two tags: a body of the first and a body of the second react. One tag: two bodies with it
    /// react. Each must be a tag of a body of the scene, or one that a stage or a reaction gives.
    #[cfg_attr(feature = "schema", schemars(length(min = 1, max = 2)))]
    pub between: Vec<String>,
    /// Probability of the reaction at a contact of enough energy, above 0 and at most 1. Default:
    /// 1.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    #[cfg_attr(feature = "schema", schemars(range(max = 1.0), extend("exclusiveMinimum" = 0.0)))]
    pub probability: f64,
    /// Least energy of the approach along the normal (mass × length² / time²), from 0 to 1e60:
    /// ½ μ u² just before the contact, with the speed u at which the surfaces approach and the
    /// reduced mass μ of the contact, which for discs is that of the two bodies. Default: 0.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = MAX_MAGNITUDE)))]
    #[doc(alias = "activation energy")]
    pub least_energy: f64,
    /// What becomes of the two bodies, in the order of `between`: the tag that each gets in place
    /// of that of `between`, or `"nothing"` for a body that is removed. With one tag in `between`,
    /// the first entry is for the body that was inserted earlier. Other tags of a body remain.
    /// Either this or `into`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(length(min = 2, max = 2)))]
    pub becomes: Vec<String>,
    /// The molecule that replaces both bodies, with the mass of the two. It gets their centre of
    /// mass, their momentum and, if it turns, their angular momentum about that centre; its x axis,
    /// turned by `orientation`, points from the first body to the second. Where it would overlap
    /// another body, the two only collide. Its place and motion must not be given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub into: Option<MoleculeSpec>,
}

impl Default for ReactionSpec {
    fn default() -> Self {
        Self {
            between: Vec::new(),
            probability: 1.0,
            least_energy: 0.0,
            becomes: Vec::new(),
            into: None,
        }
    }
}

impl ReactionSpec {
    /// The tags that bodies get by this reaction.
    pub fn given_tags(&self) -> impl Iterator<Item = &String> {
        let replaced = self.becomes.iter().filter(|tag| *tag != NOTHING);
        replaced.chain(self.into.iter().flat_map(|molecule| &molecule.tags))
    }

    /// The reaction in a line, such as `A + B → C + nothing`.
    pub fn equation(&self) -> String {
        let [first, second] =
            [self.between.first(), self.between.last()].map(|tag| tag.map_or("?", String::as_str));
        let product = match &self.into {
            Some(molecule) if molecule.tags.is_empty() => "a molecule".to_owned(),
            Some(molecule) => molecule.tags.join(" "),
            None if self.becomes.iter().all(|tag| tag == NOTHING) => NOTHING.to_owned(),
            None => self.becomes.join(" + "),
        };
        format!("{first} + {second} → {product}")
    }
}
