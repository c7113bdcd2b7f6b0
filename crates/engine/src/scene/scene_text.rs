//! Scenes as text: reading a scene file, with what a file must give, and writing one.

use crate::{
    scene::{
        Scene, error::SceneError, expressions::evaluated, gas_spec::energy_or_temperature,
        spelling::plain_words,
    },
    start::fitted_box::fit_box,
};

impl Scene {
    /// Reads a scene from the text of a scene file. Where a number stands, an expression may stand
    /// as a string, such as `"sqrt(3)/2"`: numbers, `pi`, + − * / ^, parentheses, and `sqrt`,
    /// `exp`, `ln`, `sin`, `cos`, `tan`.
    ///
    /// # Errors
    /// [`SceneError::Syntax`] with line and key if the text is not TOML or has unknown or missing
    /// keys. Values are checked when a simulation is built.
    pub fn from_toml(text: &str) -> Result<Self, SceneError> {
        let text = &evaluated(text);
        let syntax = |error: toml::de::Error| SceneError::Syntax(plain_words(&error, text));
        let mut scene: Self = toml::from_str(text).map_err(syntax)?;
        let table: toml::Table = text.parse().map_err(syntax)?;
        require(&table, "molecule", "at", "")?;
        energy_or_temperature(&table)?;
        scene.finish_stages(&table)?;
        fit_box(&mut scene, &table)?;
        Ok(scene)
    }

    /// Returns the scene as the text of a scene file.
    ///
    /// # Panics
    /// Never: a scene is plain data.
    pub fn to_toml(&self) -> String {
        toml::to_string_pretty(self).expect("a scene is plain data, which TOML can always hold")
    }
}

impl Scene {
    /// Validates the presence of the keys of stages, and sets the end of the run to that of the
    /// last stage.
    fn finish_stages(&mut self, table: &toml::Table) -> Result<(), SceneError> {
        let Some(last) = self.stage.last() else {
            return Ok(());
        };
        require(table, "stage", "until", "")?;
        let stages = table
            .get("stage")
            .and_then(toml::Value::as_array)
            .into_iter()
            .flatten();
        for (index, stage) in stages.filter_map(toml::Value::as_table).enumerate() {
            for (entries, keys) in [
                ("add", &["at"][..]),
                ("tag", &["name"]),
                ("untag", &["name"]),
                ("set_energy", &["tag"]),
                ("thermostat", &["tag", "every"]),
            ] {
                keys.iter().try_for_each(|key| {
                    require(stage, entries, key, &format!("stage[{index}]."))
                })?;
            }
        }
        let end = last.until;
        let is_given = table
            .get("run")
            .is_some_and(|run| run.get("until").is_some());
        if is_given && self.run.until != end {
            let disordered = self
                .stage
                .windows(2)
                .position(|pair| pair[1].until <= pair[0].until);
            let and = disordered.map_or_else(String::new, |index| {
                let [before, after] = [index, index + 1].map(|index| self.stage[index].until);
                format!(
                    "; and stage[{}] ends at {after}, no later than the stage before it, {before}",
                    index + 1
                )
            });
            let problem = format!(
                "`until` = {} differs from the end of the last stage, {end}: leave it out{and}",
                self.run.until
            );
            return Err(SceneError::Entry {
                entry: "run".to_owned(),
                problem,
            });
        }
        self.run.until = end;
        Ok(())
    }
}

/// Refuses entries without a key that the file must give. In code the key has a default; in a file
/// its absence is most likely an error.
fn require(table: &toml::Table, entries: &str, key: &str, before: &str) -> Result<(), SceneError> {
    let Some(toml::Value::Array(list)) = table.get(entries) else {
        return Ok(());
    };
    match list.iter().position(|entry| entry.get(key).is_none()) {
        None => Ok(()),
        Some(index) => Err(SceneError::Entry {
            entry: format!("{before}{entries}[{index}]"),
            problem: format!("`{key}` is missing"),
        }),
    }
}
