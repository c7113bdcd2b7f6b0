//! A closed cavity that holds a gas: a circle, a stadium, or a mushroom.

use std::f64::consts::{FRAC_PI_2, PI};

use carom_geometry::{MAX_MAGNITUDE, MIN_MAGNITUDE, PeriodicBox};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::scene::{ArcSpec, Scene, WallSpec, two_numbers::vector};

/// A cavity: walls that enclose a part of the box. Give one of `circle`, `stadium` and `mushroom`.
///
/// Its walls are straight walls and arcs ([`WallSpec`]), fixed, with the tags and the temperature
/// given here. Nothing may be outside. In a scene with one container every gas without
/// a region is placed in it; with several containers, or in a part of one, a gas names its own
/// ([`Region::container`](crate::Region::container)).
///
/// ```
/// use carom_engine::{Scene, Simulation};
/// use glam::DVec2;
///
/// let scene = Scene::from_toml(r#"
///     [[container]]
///     circle = { at = [0.5, 0.5], radius = 0.45 }
///     [[gas]]
///     radius = 0.01
///     mass = 1.0
///     temperature = 1.0
///     area_fraction = 0.2
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// simulation.run_until(0.5)?;
/// let discs = simulation.view();
/// let inside = discs.bodies().skip(1).all(|disc| disc.motion.position.distance(DVec2::splat(0.5)) <= 0.44 + 1e-12);
/// assert!(inside);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
#[doc(alias = "cavity")]
#[doc(alias = "billiard table")]
pub struct ContainerSpec {
    /// Tags of all its walls.
    pub tags: Vec<String>,
    /// A circle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub circle: Option<CircleSpec>,
    /// Two half circles and two straight sides between them (Bunimovich, Commun. Math. Phys. 65
    /// (1979) 295).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stadium: Option<StadiumSpec>,
    /// A half circle on a stem (Bunimovich, Chaos 11 (2001) 802).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mushroom: Option<MushroomSpec>,
    /// Temperature kT of its walls (mass × length² / time²), as [`WallSpec::temperature`].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub temperature: Option<f64>,
}

/// A circle: its centre and its radius.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CircleSpec {
    /// Centre (length).
    #[serde(deserialize_with = "vector")]
    pub at: [f64; 2],
    /// Radius (length).
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub radius: f64,
}

/// A stadium along x.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct StadiumSpec {
    /// Centre (length).
    #[serde(deserialize_with = "vector")]
    pub at: [f64; 2],
    /// Radius of the half circles (length).
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub radius: f64,
    /// Length of the straight sides.
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub straight: f64,
}

/// A half circle above a stem.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MushroomSpec {
    /// Centre of the half circle (length).
    #[serde(deserialize_with = "vector")]
    pub at: [f64; 2],
    /// Radius of the half circle (length).
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub radius: f64,
    /// Width and height of the stem (length); its width is below the diameter of the half circle.
    #[serde(deserialize_with = "vector")]
    pub stem: [f64; 2],
}

/// A cavity of valid lengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cavity {
    /// Centre of the circle, of the stadium or of the half circle (length).
    at: DVec2,
    /// Radius of the arcs (length).
    radius: f64,
    table: Table,
}

/// What a cavity has besides its arcs.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Table {
    Circle,
    Stadium {
        /// Half the length of the straight sides.
        half: f64,
    },
    Mushroom {
        /// Half the width of the stem (length).
        half: f64,
        /// Height of the stem (length).
        height: f64,
    },
}

impl Scene {
    /// The tags of each wall and of each container.
    pub fn wall_tags(&self) -> impl Iterator<Item = &Vec<String>> {
        let walls = self.wall.iter().map(|wall| &wall.tags);
        let walls = walls.chain(self.container.iter().map(|container| &container.tags));
        walls.chain(self.piston.iter().map(|piston| &piston.tags))
    }

    /// Number of walls, with pistons and those of valid containers.
    pub fn wall_count(&self) -> usize {
        let sides = DVec2::from(self.bounds.sides);
        let cavities = self
            .container
            .iter()
            .map(|container| container.cavity(sides));
        let of_containers = cavities.flatten().map(|cavity| cavity.walls().len());
        self.wall.len() + of_containers.sum::<usize>() + self.piston.len()
    }

    /// Whether a wall has a temperature.
    pub fn has_heated_walls(&self) -> bool {
        let walls = self.wall.iter().map(|wall| wall.temperature);
        let containers = self.container.iter().map(|container| container.temperature);
        walls
            .chain(containers)
            .any(|temperature| temperature.is_some())
    }
}

impl ContainerSpec {
    /// The cavity in a box of these sides (length).
    ///
    /// # Errors
    /// What is wrong with it.
    pub(crate) fn cavity(&self, sides: DVec2) -> Result<Cavity, String> {
        let (at, radius, table, lengths) = match (self.circle, self.stadium, self.mushroom) {
            (Some(circle), None, None) => (circle.at, circle.radius, Table::Circle, vec![]),
            (None, Some(stadium), None) => {
                let half = 0.5 * stadium.straight;
                let lengths = vec![stadium.straight];
                (stadium.at, stadium.radius, Table::Stadium { half }, lengths)
            }
            (None, None, Some(mushroom)) => {
                let [width, height] = mushroom.stem;
                let half = 0.5 * width;
                let table = Table::Mushroom { half, height };
                (mushroom.at, mushroom.radius, table, vec![width, height])
            }
            _ => return Err("give one of `circle`, `stadium` and `mushroom`".to_owned()),
        };
        let at = DVec2::from(at);
        let is_length = |length: &&f64| (MIN_MAGNITUDE..=MAX_MAGNITUDE).contains(*length);
        let mut all = std::iter::once(&radius).chain(&lengths);
        if let Some(wrong) = all.find(|length| !is_length(length)) {
            return Err(format!(
                "the lengths of a container must be from {MIN_MAGNITUDE:e} to {MAX_MAGNITUDE:e}, but one is {wrong:?}"
            ));
        }
        if let Table::Mushroom { half, .. } = table
            && half >= radius
        {
            return Err(format!(
                "the width of the stem must be below the diameter of the half circle, {}, but is {}",
                2.0 * radius,
                2.0 * half
            ));
        }
        let cavity = Cavity { at, radius, table };
        let [low, high] = cavity.extent();
        let is_inside = |place: DVec2| place.is_finite() && place.abs().max_element() < 1e9;
        if !(is_inside(at) && (high - low).cmple(sides * (1.0 + 1e-9)).all()) {
            return Err(format!(
                "the container must fit into the box of sides {} and {}, but is {} wide and {} high",
                sides.x,
                sides.y,
                high.x - low.x,
                high.y - low.y
            ));
        }
        Ok(cavity)
    }

    /// Its walls.
    pub(crate) fn walls(&self, cavity: Cavity) -> Vec<WallSpec> {
        let with = |wall: WallSpec| WallSpec {
            tags: self.tags.clone(),
            temperature: self.temperature,
            ..wall
        };
        cavity.walls().into_iter().map(with).collect()
    }
}

impl Cavity {
    fn walls(self) -> Vec<WallSpec> {
        let arc = |at: DVec2, radius: f64, [from, to]: [f64; 2]| WallSpec {
            arc: Some(ArcSpec {
                at: at.to_array(),
                radius,
                from,
                to,
                one_sided: true,
            }),
            ..WallSpec::default()
        };
        let line = |from: DVec2, to: DVec2| WallSpec {
            from: Some(from.to_array()),
            to: Some(to.to_array()),
            ..WallSpec::default()
        };
        let Self { at, radius, table } = self;
        match table {
            Table::Circle => vec![arc(at, radius, [0.0, 2.0 * PI])],
            Table::Stadium { half } => {
                let (right, left) = (at + half * DVec2::X, at - half * DVec2::X);
                let up = radius * DVec2::Y;
                vec![
                    arc(right, radius, [-FRAC_PI_2, FRAC_PI_2]),
                    line(right + up, left + up),
                    arc(left, radius, [FRAC_PI_2, 3.0 * FRAC_PI_2]),
                    line(left - up, right - up),
                ]
            }
            Table::Mushroom { half, height } => {
                let (rim, stem) = (radius * DVec2::X, half * DVec2::X);
                let foot = at - height * DVec2::Y;
                vec![
                    arc(at, radius, [0.0, PI]),
                    line(at - rim, at - stem),
                    line(at - stem, foot - stem),
                    line(foot - stem, foot + stem),
                    line(foot + stem, at + stem),
                    line(at + stem, at + rim),
                ]
            }
        }
    }

    /// Its lower left and its upper right corner (length).
    pub(crate) fn extent(self) -> [DVec2; 2] {
        let Self { at, radius, table } = self;
        let [down, up] = match table {
            Table::Circle => [DVec2::splat(radius); 2],
            Table::Stadium { half } => [DVec2::new(half + radius, radius); 2],
            Table::Mushroom { height, .. } => [DVec2::new(radius, height), DVec2::splat(radius)],
        };
        [at - down, at + up]
    }

    /// Its area (length²).
    pub(crate) fn area(self) -> f64 {
        let circle = PI * self.radius * self.radius;
        match self.table {
            Table::Circle => circle,
            Table::Stadium { half } => circle + 4.0 * half * self.radius,
            Table::Mushroom { half, height } => 0.5 * circle + 2.0 * half * height,
        }
    }

    /// Whether a place, in any image of the box, is inside.
    pub(crate) fn contains(self, bounds: &PeriodicBox, place: DVec2) -> bool {
        let [low, high] = self.extent();
        let middle = 0.5 * (low + high);
        let from_centre = middle + bounds.nearest_image(place - middle) - self.at;
        let DVec2 { x, y } = from_centre;
        match self.table {
            Table::Stadium { half } => (x.abs() - half).max(0.0).hypot(y) <= self.radius,
            Table::Mushroom { half, height } if y < 0.0 => x.abs() <= half && y >= -height,
            Table::Circle | Table::Mushroom { .. } => from_centre.length() <= self.radius,
        }
    }
}
