//! A part of the box in which a gas is placed.

use carom_geometry::PeriodicBox;
use glam::DVec2;
use rand::RngExt;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use crate::scene::{container_spec::Cavity, two_numbers::optional_range};

/// A rectangle along the axes, or a container, in which the centres of mass of a gas are placed.
///
/// It says where the molecules start, not where they stay: enclose a gas by walls to keep it. Walls
/// across the box keep it while it grows and relaxes, too ([`[start]`](crate::StartSpec)).
///
/// ```
/// use carom_engine::{Scene, Simulation};
///
/// let scene = Scene::from_toml(r#"
///     [[wall]]
///     x = 0.0
///     [[wall]]
///     x = 0.5
///     [[gas]]
///     region = { x = [0.0, 0.5] }
///     radius = 0.01
///     mass = 1.0
///     temperature = 1.0
///     count = 50
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// simulation.run_until(1.0)?;
/// assert!(simulation.view().bodies().skip(2).all(|disc| disc.motion.position.x < 0.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Region {
    /// First and last x (length), the last at most a side of the box beyond the first; beyond the
    /// box the region continues at its other side. Default: the whole side.
    #[serde(
        deserialize_with = "optional_range",
        skip_serializing_if = "Option::is_none"
    )]
    pub x: Option<[f64; 2]>,
    /// First and last y (length), as `x`. Default: the whole side.
    #[serde(
        deserialize_with = "optional_range",
        skip_serializing_if = "Option::is_none"
    )]
    pub y: Option<[f64; 2]>,
    /// Number of the [`[[container]]`](crate::ContainerSpec) in which the gas is placed, from 0;
    /// with `x` and `y`, in that part of it. Default: the only one, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub container: Option<usize>,
    /// The inside of that container.
    #[serde(skip)]
    pub(crate) inside: Option<Cavity>,
}

/// Most places that are drawn for one in a container. Fewer: parts of a container of 1 % of their
/// rectangle are not found. More: an empty part takes longer to be refused.
const MAX_DRAWS: usize = 2000;

impl Region {
    /// Validates the ends of both ranges.
    ///
    /// # Errors
    /// The reason why the region is none in such a box.
    pub(crate) fn check(&self, bounds: &PeriodicBox) -> Result<(), String> {
        for (axis, name, range) in [(0, "x", self.x), (1, "y", self.y)] {
            let Some([first, last]) = range else { continue };
            let side = bounds.sides()[axis];
            let is_good = first.abs() <= side && last > first && last - first <= side;
            if !is_good {
                return Err(format!(
                    "`region.{name}` must have a first end from -{side} to {side} and a last end above it by at most \
                     the side {side}, but is [{first:?}, {last:?}]"
                ));
            }
        }
        Ok(())
    }

    /// The first corner (length).
    pub(crate) fn corner(&self) -> DVec2 {
        let first = |range: Option<[f64; 2]>| range.map_or(0.0, |[first, _]| first);
        DVec2::new(first(self.x), first(self.y))
    }

    /// Its extent along both axes in a box (length).
    pub(crate) fn extent(&self, bounds: &PeriodicBox) -> DVec2 {
        let [x, y] = bounds.sides().to_array();
        let extent = |range: Option<[f64; 2]>, side: f64| {
            range.map_or(side, |[first, last]| (last - first).min(side))
        };
        DVec2::new(extent(self.x, x), extent(self.y, y))
    }

    /// A uniform place in it, in a box (length); any place of its rectangle if no place in the
    /// container is found.
    pub(crate) fn draw(&self, bounds: &PeriodicBox, random: &mut Pcg64) -> DVec2 {
        let mut draw = || {
            let share = DVec2::new(random.random(), random.random());
            self.corner() + share * self.extent(bounds)
        };
        let first = draw();
        if self.is_inside(bounds, first) {
            return first;
        }
        let mut drawn = std::iter::repeat_with(draw).take(MAX_DRAWS);
        drawn
            .find(|&place| self.is_inside(bounds, place))
            .unwrap_or(first)
    }

    /// Whether a place is inside the container, if there is one.
    fn is_inside(&self, bounds: &PeriodicBox, place: DVec2) -> bool {
        self.inside
            .is_none_or(|cavity| cavity.contains(bounds, place))
    }

    /// Its area in a box (length²).
    pub(crate) fn area(&self, bounds: &PeriodicBox) -> f64 {
        if let Some(cavity) = self.inside {
            return cavity.area();
        }
        let extent = self.extent(bounds);
        extent.x * extent.y
    }

    /// Whether a place, in any image of the box, is inside.
    pub(crate) fn contains(&self, bounds: &PeriodicBox, place: DVec2) -> bool {
        let (sides, extent) = (bounds.sides(), self.extent(bounds));
        let beyond = place - self.corner();
        let beyond = beyond - sides * (beyond / sides).floor();
        (beyond.x <= extent.x) & (beyond.y <= extent.y) && self.is_inside(bounds, place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{run::simulation::Simulation, scene::Scene};

    fn scene(region: &str, rest: &str) -> Scene {
        Scene::from_toml(&format!(
            "[box]\nsides = [2.0, 1.0]\nseed = 5\n[[gas]]\ntags = [\"gas\"]\nregion = {region}\nmass = 1.0\n\
             temperature = 1.0\n{rest}"
        ))
        .unwrap()
    }

    #[test]
    fn gases_are_placed_in_their_regions() {
        for (region, rest) in [
            ("{ x = [0.5, 1.0] }", "radius = 0.01\ncount = 300\n"),
            (
                "{ x = [1.75, 2.25], y = [0.25, 0.5] }",
                "radius = 0.01\narea_fraction = 0.4\n",
            ),
            (
                "{ y = [-0.125, 0.125] }",
                "radius = { uniform = [0.005, 0.02] }\ncount = 80\n",
            ),
            // Lower than a disc.
            ("{ y = [0.5, 0.51] }", "radius = 0.01\ncount = 15\n"),
        ] {
            let scene = scene(region, rest);
            let simulation = Simulation::new(&scene).unwrap();
            let (view, region) = (simulation.view(), scene.gas[0].region.unwrap());
            assert_eq!(view.overlaps().pairs, 0);
            for body in view.bodies() {
                assert!(
                    region.contains(&view.bounds(), body.motion.position),
                    "{:?}",
                    body.motion.position
                );
            }
        }
        // The area is that of the region.
        let half = scene(
            "{ x = [1.75, 2.25], y = [0.25, 0.5] }",
            "radius = 0.01\narea_fraction = 0.4\n",
        );
        assert_eq!(half.expected_bodies().unwrap(), 159);
    }

    #[test]
    fn walls_keep_the_gases_of_two_dense_channels_apart() {
        let text = "[box]\nsides = [2.0, 1.0]\n[start]\nplacement = \"grown\"\nrelax = 30\n\
                    [[wall]]\ny = 0.0\n[[wall]]\ny = 0.5\n\
                    [[gas]]\nregion = { y = [0.0, 0.5] }\nradius = 0.03\nmass = 1.0\ntemperature = 1.0\narea_fraction = 0.6\n\
                    [[gas]]\nregion = { y = [0.5, 1.0] }\nradius = 0.02\nmass = 1.0\ntemperature = 1.0\narea_fraction = 0.3\n";
        let scene = Scene::from_toml(text).unwrap();
        let simulation = Simulation::new(&scene).unwrap();
        let mut counts = [0; 2];
        for body in simulation
            .view()
            .bodies()
            .filter(|body| !body.body.is_fixed())
        {
            let upper = usize::from(body.motion.position.y > 0.5);
            assert_eq!(body.body.molecule().bounding_radius(), [0.03, 0.02][upper]);
            counts[upper] += 1;
        }
        assert_eq!(counts, [212, 239]);
    }

    #[test]
    fn regions_that_are_none_are_refused() {
        let bounds = PeriodicBox::new(DVec2::new(2.0, 1.0)).unwrap();
        for x in [
            [1.0, 1.0],
            [1.0, 0.5],
            [0.0, 2.5],
            [f64::NAN, 1.0],
            [0.0, f64::NAN],
            [3.0, 4.0],
        ] {
            let refused = Region {
                x: Some(x),
                y: None,
                ..Region::default()
            }
            .check(&bounds)
            .unwrap_err();
            assert!(refused.contains("region.x"), "{refused}");
        }
        let scene = scene("{ y = [0.0, 1.5] }", "radius = 0.01\ncount = 1\n");
        let refused = Simulation::new(&scene).unwrap_err().to_string();
        assert!(
            refused.contains("gas[0]") && refused.contains("region.y"),
            "{refused}"
        );
        let none =
            Scene::from_toml("[[gas]]\nregion = { z = [0, 1] }\nenergy = 1.0\n").unwrap_err();
        assert!(none.to_string().contains('z'), "{none}");
    }
}
