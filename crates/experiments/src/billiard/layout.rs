//! Where the obstacles of a billiard are.

use anyhow::{Context, Result, ensure};
use carom_tables::with_error;
use clap::ValueEnum;
use glam::DVec2;
use rand::{Rng, RngExt as _};

/// Arrangement of the fixed obstacles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum ObstacleLayout {
    /// One obstacle in a square box: a square lattice
    #[default]
    Square,
    /// Two obstacles in a box of sides 1 : √3: a triangular lattice
    Triangular,
    /// Obstacles at random places, different in each flight, with no overlap of the regions that
    /// they exclude
    Random,
}

/// Least distance of two obstacles, by the distance at which they can be touched at most. Below 2,
/// the regions that they exclude could overlap, and no prediction would hold.
pub const MIN_DISTANCE: f64 = 2.2;

/// Largest share of the box for random obstacles with half of the least distance as their radius;
/// random sequential placement jams at 0.547 (Hinrichsen, Feder and Jøssang, J. Stat. Phys. 44
/// (1986) 793).
const MAX_FILLED: f64 = 0.4;

/// Largest number of random places tried for one body. At [`MAX_FILLED`], and for the mover at any
/// layout, more than one place in fifty is free.
const MAX_TRIES: usize = 2000;

/// Name of a choice on the command line.
pub fn name_of(choice: &impl ValueEnum) -> String {
    choice
        .to_possible_value()
        .map_or_else(String::new, |value| value.get_name().to_owned())
}

/// Fixed obstacles in a periodic box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Obstacles {
    /// Their arrangement.
    pub layout: ObstacleLayout,
    /// Their number.
    pub count: u16,
    /// Shorter side of the box (length); on a lattice the distance of neighbours.
    pub side: f64,
}

impl Obstacles {
    /// Obstacles that can be touched within a distance of `reach` (length). Without a side, it is
    /// four times that for each obstacle.
    ///
    /// # Errors
    /// The number does not fit the layout, or the box is too small.
    pub fn new(
        layout: ObstacleLayout,
        count: Option<u16>,
        side: Option<f64>,
        reach: f64,
    ) -> Result<Self> {
        let (usual, ready) = match layout {
            ObstacleLayout::Square => (1, 4.0 * reach),
            ObstacleLayout::Triangular => (2, 4.0 * reach),
            ObstacleLayout::Random => {
                let usual = count.unwrap_or(16);
                (usual, 4.0 * reach * f64::from(usual).sqrt())
            }
        };
        let (count, side) = (count.unwrap_or(usual), side.unwrap_or(ready));
        ensure!(
            count == usual,
            "--obstacles {count}: the layout {} has {usual}; --layout random has any number",
            name_of(&layout)
        );
        let disc = 0.25 * std::f64::consts::PI * (MIN_DISTANCE * reach).powi(2);
        let crowded = (f64::from(count) * disc / MAX_FILLED).sqrt();
        let least = if count > 2 {
            crowded
        } else {
            MIN_DISTANCE * reach
        };
        ensure!(
            side.is_finite() && side > least,
            "--side {side}: it must be finite and more than {}, so that the regions around all obstacles stay \
             apart; the radii of molecule and disc add up to {}",
            with_error(least, None),
            with_error(reach, None)
        );
        Ok(Self {
            layout,
            count,
            side,
        })
    }

    /// Sides of the box (length).
    pub fn sides(&self) -> DVec2 {
        let height = if self.layout == ObstacleLayout::Triangular {
            3f64.sqrt()
        } else {
            1.0
        };
        self.side * DVec2::new(1.0, height)
    }

    /// Area of the box by the number of obstacles (length²).
    pub fn area_of_one(&self) -> f64 {
        self.sides().x * self.sides().y / f64::from(self.count)
    }

    /// Places of the obstacles (length). `reach` is that of [`Self::new`].
    ///
    /// # Errors
    /// No free place was found.
    pub fn places(&self, reach: f64, random: &mut impl Rng) -> Result<Vec<DVec2>> {
        let at = |share: f64| share * self.sides();
        match self.layout {
            ObstacleLayout::Square => Ok(vec![at(0.5)]),
            ObstacleLayout::Triangular => Ok(vec![at(0.25), at(0.75)]),
            ObstacleLayout::Random => {
                let mut places: Vec<DVec2> = Vec::new();
                for _ in 0..self.count {
                    let is_free = |place: &DVec2| {
                        let distance = |other: &DVec2| self.nearest(*place - *other).length();
                        places
                            .iter()
                            .all(|other| distance(other) > MIN_DISTANCE * reach)
                    };
                    let place = self.free_place(random, is_free)?;
                    places.push(place);
                }
                Ok(places)
            }
        }
    }

    /// A random place in the box that `is_free` accepts.
    ///
    /// # Errors
    /// None was found.
    pub fn free_place(
        &self,
        random: &mut impl Rng,
        is_free: impl Fn(&DVec2) -> bool,
    ) -> Result<DVec2> {
        let mut place =
            || self.sides() * DVec2::new(random.random::<f64>(), random.random::<f64>());
        let found = std::iter::repeat_with(&mut place)
            .take(MAX_TRIES)
            .find(is_free);
        found.context("no free place was found in the box")
    }

    /// The shortest of all periodic images of a vector.
    fn nearest(&self, vector: DVec2) -> DVec2 {
        vector - self.sides() * (vector / self.sides()).round()
    }
}
