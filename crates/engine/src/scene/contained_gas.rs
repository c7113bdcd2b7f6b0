//! The container in which a gas is placed.

use carom_geometry::PeriodicBox;

use crate::scene::{Scene, gas_spec::GasSpec, region::Region};

impl Scene {
    /// The entry of a gas, with the container in which it is placed.
    ///
    /// # Errors
    /// What is wrong with its region.
    pub(crate) fn contained_gas(
        &self,
        index: usize,
        bounds: &PeriodicBox,
    ) -> Result<GasSpec, String> {
        let mut spec = self.gas[index].clone();
        let region = spec.region.unwrap_or_default();
        let number = match (region.container, self.container.len()) {
            (None, 0) => return Ok(spec),
            (None, 1) => 0,
            (None, several) => {
                return Err(format!(
                    "the scene has {several} containers: say in which of them the gas is placed, as \
                     `region = {{ container = 0 }}`"
                ));
            }
            (Some(number), several) if number >= several => {
                return Err(format!(
                    "`region.container` must be below the number of containers, {several}, but is {number}"
                ));
            }
            (Some(number), _) => number,
        };
        let cavity = self.container[number].cavity(bounds.sides());
        let cavity = cavity.map_err(|reason| format!("container[{number}]: {reason}"))?;
        if spec.area_fraction.is_some() && (region.x.is_some() || region.y.is_some()) {
            return Err(
                "a part of a container has no known area: give `count`, or `region` without `x` and `y`"
                    .to_owned(),
            );
        }
        let [low, high] = cavity.extent();
        spec.region = Some(Region {
            x: region.x.or(Some([low.x, high.x])),
            y: region.y.or(Some([low.y, high.y])),
            container: Some(number),
            inside: Some(cavity),
        });
        Ok(spec)
    }
}
