//! A closed cavity that holds a gas: a circle, a stadium, or a mushroom.

use std::f64::consts::{FRAC_PI_2, PI};

use carom_geometry::{MAX_MAGNITUDE, MIN_MAGNITUDE, PeriodicBox};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::scene::{ArcSpec, Scene, WallSpec};

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
    pub at: [f64; 2],
    /// Radius of the half circle (length).
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub radius: f64,
    /// Width and height of the stem (length); its width is below the diameter of the half circle.
    pub stem: [f64; 2],
}

/// A cavity of valid lengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Cavity {
    Circle {
        at: DVec2,
        radius: f64,
    },
    Stadium {
        at: DVec2,
        radius: f64,
        /// Half the length of the straight sides.
        half: f64,
    },
    Mushroom {
        at: DVec2,
        radius: f64,
        /// Half the width of the stem.
        half: f64,
        height: f64,
    },
}

impl Scene {
    /// The tags of each wall and of each container.
    pub fn wall_tags(&self) -> impl Iterator<Item = &Vec<String>> {
        let walls = self.wall.iter().map(|wall| &wall.tags);
        walls.chain(self.container.iter().map(|container| &container.tags))
    }

    /// Number of walls, with those of the containers.
    pub fn wall_count(&self) -> usize {
        let of_container = |container: &ContainerSpec| match (container.stadium, container.mushroom)
        {
            (None, None) => 1,
            (Some(_), _) => 4,
            (None, Some(_)) => 6,
        };
        self.wall.len() + self.container.iter().map(of_container).sum::<usize>()
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
        let cavity = match (self.circle, self.stadium, self.mushroom) {
            (Some(CircleSpec { at, radius }), None, None) => Cavity::Circle {
                at: at.into(),
                radius,
            },
            (
                None,
                Some(StadiumSpec {
                    at,
                    radius,
                    straight,
                }),
                None,
            ) => Cavity::Stadium {
                at: at.into(),
                radius,
                half: 0.5 * straight,
            },
            (None, None, Some(MushroomSpec { at, radius, stem })) => Cavity::Mushroom {
                at: at.into(),
                radius,
                half: 0.5 * stem[0],
                height: stem[1],
            },
            _ => return Err("give one of `circle`, `stadium` and `mushroom`".to_owned()),
        };
        let (at, lengths) = match cavity {
            Cavity::Circle { at, radius } => (at, vec![radius]),
            Cavity::Stadium { at, radius, half } => (at, vec![radius, half]),
            Cavity::Mushroom {
                at,
                radius,
                half,
                height,
            } => (at, vec![radius, half, height]),
        };
        if let Some(wrong) = lengths
            .iter()
            .find(|length| !(MIN_MAGNITUDE..=MAX_MAGNITUDE).contains(*length))
        {
            return Err(format!(
                "the lengths of a container must be from {MIN_MAGNITUDE:e} to {MAX_MAGNITUDE:e}, but one is {wrong:?}"
            ));
        }
        if let Cavity::Mushroom { radius, half, .. } = cavity
            && half >= radius
        {
            return Err(format!(
                "the width of the stem must be below the diameter of the half circle, {}, but is {}",
                2.0 * radius,
                2.0 * half
            ));
        }
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
        match self {
            Self::Circle { at, radius } => vec![arc(at, radius, [0.0, 2.0 * PI])],
            Self::Stadium { at, radius, half } => {
                let (right, left) = (at + half * DVec2::X, at - half * DVec2::X);
                let up = radius * DVec2::Y;
                vec![
                    arc(right, radius, [-FRAC_PI_2, FRAC_PI_2]),
                    line(right + up, left + up),
                    arc(left, radius, [FRAC_PI_2, 3.0 * FRAC_PI_2]),
                    line(left - up, right - up),
                ]
            }
            Self::Mushroom {
                at,
                radius,
                half,
                height,
            } => {
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
        match self {
            Self::Circle { at, radius } => [at - radius, at + radius],
            Self::Stadium { at, radius, half } => {
                let reach = DVec2::new(half + radius, radius);
                [at - reach, at + reach]
            }
            Self::Mushroom {
                at, radius, height, ..
            } => [at - DVec2::new(radius, height), at + DVec2::splat(radius)],
        }
    }

    /// Its area (length²).
    pub(crate) fn area(self) -> f64 {
        match self {
            Self::Circle { radius, .. } => PI * radius * radius,
            Self::Stadium { radius, half, .. } => PI * radius * radius + 4.0 * half * radius,
            Self::Mushroom {
                radius,
                half,
                height,
                ..
            } => FRAC_PI_2 * radius * radius + 2.0 * half * height,
        }
    }

    /// Whether a place, in any image of the box, is inside.
    pub(crate) fn contains(self, bounds: &PeriodicBox, place: DVec2) -> bool {
        let [low, high] = self.extent();
        let middle = 0.5 * (low + high);
        let beyond = place - middle;
        let place = middle + (beyond - bounds.sides() * (beyond / bounds.sides()).round());
        match self {
            Self::Circle { at, radius } => place.distance(at) <= radius,
            Self::Stadium { at, radius, half } => {
                let from_middle = (place - at).abs();
                DVec2::new((from_middle.x - half).max(0.0), from_middle.y).length() <= radius
            }
            Self::Mushroom {
                at,
                radius,
                half,
                height,
            } => {
                let from_cap = place - at;
                let is_in_stem = from_cap.x.abs() <= half && from_cap.y >= -height;
                (from_cap.y >= 0.0 || is_in_stem)
                    && from_cap.length() <= radius.max(half.hypot(height))
                    && (from_cap.y < 0.0 || from_cap.length() <= radius)
            }
        }
    }
}
