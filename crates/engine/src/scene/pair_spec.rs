//! Rules for pairs of tags: bodies that do not see each other, and discs whose contact distance is
//! not the sum of their radii.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use crate::scene::{
    Scene, StageSpec, error::SceneError, reaction_spec::ReactionSpec, spelling::did_you_mean,
};

/// Smallest and largest factor of a rule of diameters. Beyond them a scene is most likely an error:
/// the largest contact distance sets the size of the cells.
pub(crate) const MIN_FACTOR: f64 = 1e-3;
/// See [`MIN_FACTOR`].
pub(crate) const MAX_FACTOR: f64 = 1e3;

/// Pairs of bodies that do not see each other: they pass through each other without a contact, and
/// may overlap. Bumpers, walls and the molecules of fixed gases are bodies, too.
///
/// ```
/// use carom_engine::{Scene, Simulation};
///
/// // An ideal gas in a box with walls.
/// let scene = Scene::from_toml(r#"
///     [[transparent]]
///     between = ["ideal"]
///     [[wall]]
///     x = 0.0
///     [[wall]]
///     y = 0.0
///     [[gas]]
///     tags = ["ideal"]
///     radius = 0.01
///     mass = 1.0
///     temperature = 1.0
///     count = 100
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// simulation.run_until(1.0)?;
/// let counters = simulation.view().counters();
/// assert!(counters.fixed_collisions > 0);
/// assert_eq!(counters.collisions, counters.fixed_collisions);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[doc(alias = "ideal gas")]
#[doc(alias = "semipermeable wall")]
#[doc(alias = "Widom-Rowlinson mixture")]
pub struct TransparentSpec {
    /// Two tags: bodies of the first and bodies of the second do not see each other. One tag:
    /// bodies with this tag do not see each other. Each must be a tag of a body of the scene, or
    /// one that a stage gives.
    #[cfg_attr(feature = "schema", schemars(length(min = 1, max = 2)))]
    pub between: Vec<String>,
}

/// Discs of two tags whose contact distance is not the sum of their radii.
///
/// ```
/// use carom_engine::{Scene, Simulation};
///
/// // Discs of radius 0.02 that touch those of the other kind at 0.02 instead of 0.04.
/// let scene = Scene::from_toml(r#"
///     [[diameter]]
///     between = ["a", "b"]
///     factor = 0.5
///     [[gas]]
///     tags = ["a"]
///     radius = 0.02
///     mass = 1.0
///     temperature = 1.0
///     count = 50
///     [[gas]]
///     tags = ["b"]
///     radius = 0.02
///     mass = 1.0
///     temperature = 1.0
///     count = 50
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// simulation.run_until(1.0)?;
/// assert_eq!(simulation.view().overlaps().pairs, 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[doc(alias = "non-additive")]
pub struct DiameterSpec {
    /// Two tags, or one for discs of one tag with each other. Bodies with these tags must be discs.
    #[cfg_attr(feature = "schema", schemars(length(min = 1, max = 2)))]
    pub between: Vec<String>,
    /// Factor on the sum of the two radii, from 0.001 to 1000.
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_FACTOR, max = MAX_FACTOR)))]
    pub factor: f64,
}

impl Scene {
    /// Refuses rules for pairs of tags, and reactions, that no body of the scene carries or gets.
    pub(crate) fn refuse_unknown_pairs(&self) -> Result<(), SceneError> {
        let singles = self.molecule.iter().map(|body| &body.tags);
        let bumpers = self.bumper.iter().map(|body| &body.tags);
        let walls = self.wall_tags();
        let gases = self.gas.iter().map(|gas| &gas.tags);
        let added = |stage: &'_ StageSpec| -> Vec<String> {
            let molecules = stage.add.iter().flat_map(|body| body.tags.iter());
            let walls = stage.add_wall.iter().flat_map(|body| body.tags.iter());
            let given = stage.tag.iter().map(|rule| &rule.name);
            molecules.chain(walls).chain(given).cloned().collect()
        };
        let mut known: BTreeSet<String> = self.stage.iter().flat_map(added).collect();
        known.extend(
            singles
                .chain(bumpers)
                .chain(walls)
                .chain(gases)
                .flatten()
                .cloned(),
        );
        let of_stages = self.stage.iter().flat_map(|stage| &stage.reaction);
        let reactions = self.reaction.iter().chain(of_stages.flatten());
        known.extend(reactions.flat_map(ReactionSpec::given_tags).cloned());
        let refuse = |entry: String, between: &[String]| {
            let unknown = between.iter().find(|tag| !known.contains(*tag));
            unknown.map_or(Ok(()), |tag| {
                let hint = did_you_mean(tag, known.iter().map(String::as_str));
                Err(SceneError::Entry {
                    entry,
                    problem: format!("no body in the scene carries the tag {tag:?}{hint}"),
                })
            })
        };
        for (index, rule) in self.transparent.iter().enumerate() {
            refuse(format!("transparent[{index}]"), &rule.between)?;
        }
        for (index, rule) in self.diameter.iter().enumerate() {
            refuse(format!("diameter[{index}]"), &rule.between)?;
        }
        for (index, rule) in self.well.iter().enumerate() {
            refuse(format!("well[{index}]"), &rule.between)?;
        }
        for (index, rule) in self.reaction.iter().enumerate() {
            refuse(format!("reaction[{index}]"), &rule.between)?;
        }
        for (number, stage) in self.stage.iter().enumerate() {
            for (index, rule) in stage.reaction.iter().flatten().enumerate() {
                let entry = format!("stage[{number}].reaction[{index}]");
                refuse(entry, &rule.between)?;
            }
            for (index, rule) in stage.well.iter().flatten().enumerate() {
                refuse(format!("stage[{number}].well[{index}]"), &rule.between)?;
            }
            for (index, rule) in stage.transparent.iter().flatten().enumerate() {
                let entry = format!("stage[{number}].transparent[{index}]");
                refuse(entry, &rule.between)?;
            }
        }
        Ok(())
    }
}
