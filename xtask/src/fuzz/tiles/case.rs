//! A gas, a division of its box into tiles, and the stops of a run, with actions between them.

use carom::{Scene, engine::Tiling};
use serde::{Deserialize, Serialize};

use crate::fuzz::random::{FuzzDraw, case_seed};

/// What moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Gas {
    /// Equal discs.
    Discs,
    /// Discs of two sizes and masses.
    Mixture,
    /// Dumbbells.
    Dumbbells,
    /// Molecules of the shape of a T, and as many discs.
    TeesAndDiscs,
}

/// A rule for the pairs of the first gas, a, and the second one, b.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PairRule {
    /// None.
    #[default]
    None,
    /// They do not see each other.
    Transparent,
    /// They touch at a larger distance; only if all are discs.
    Diameter,
    /// The first gas does not see walls.
    OpenWalls,
}

/// A run in tiles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TilesCase {
    /// What moves.
    pub gas: Gas,
    /// Number of discs of the same area.
    pub count: u32,
    /// Covered share of the box.
    pub area_fraction: f64,
    /// Seed of the scene.
    pub seed: u64,
    /// Elasticity of all contacts.
    pub elasticity: f64,
    /// Number of walls, at most three.
    pub walls: u32,
    /// Speed with which they move, turn or oscillate (length per time).
    #[serde(default)]
    pub wall_speed: f64,
    /// Acceleration towards the second wall, if there is one (length per time²).
    #[serde(default)]
    pub gravity: f64,
    /// The rule for pairs.
    #[serde(default)]
    pub pair_rule: PairRule,
    /// Number of bumpers along a side of the box.
    pub bumpers: u32,
    /// Numbers of the division: see [`Tiling`].
    pub threads: u32,
    /// Cells along a side.
    pub side: u32,
    /// Length of a window (mean free times).
    pub window: f64,
    /// Cells by which a border is wider than an influence travels.
    pub margin: u32,
    /// Cells that an influence travels in a mean free time.
    pub front: f64,
    /// Length of the run (mean free times of discs).
    pub length: f64,
    /// Number of stops.
    pub stops: u32,
    /// Whether contacts are reported.
    pub reports: bool,
    /// Share of the stops after which something else is done: see [`Action`].
    pub disturbed: f64,
    /// Contacts of each body after which an epoch ends.
    pub contacts_per_epoch: u64,
}

/// An action between two stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// Nothing.
    None,
    /// One contact.
    Step,
    /// A stretch in which reports are requested if they are not in others, and the reverse.
    OtherObserver,
    /// The run continues with a copy of itself.
    Clone,
    /// The epoch ends.
    EndEpoch,
    /// All contacts get this elasticity, with a guard against inelastic collapse or without.
    Elasticity(f64, f64),
    /// All velocities are reversed.
    Reverse,
}

impl TilesCase {
    /// The case of a seed.
    pub fn draw(seed: u64) -> Self {
        let draw = &mut FuzzDraw::new(seed);
        let gas = draw.one_of(&[
            Gas::Discs,
            Gas::Discs,
            Gas::Mixture,
            Gas::Dumbbells,
            Gas::TeesAndDiscs,
        ]);
        let densest = if matches!(gas, Gas::Discs | Gas::Mixture) {
            0.65
        } else {
            0.3
        };
        let rarely = |draw: &mut FuzzDraw, number: u32| if draw.happens(0.3) { number } else { 0 };
        // Of few stops, some are closer than a window; of many, all.
        let stops = if draw.happens(0.5) {
            draw.integer(1, 5)
        } else {
            draw.integer(20, 200)
        };
        Self {
            gas,
            count: draw.scale(1500.0, 8000.0) as u32,
            area_fraction: draw.between(0.1, densest),
            seed: draw.bits() >> 32,
            elasticity: if draw.happens(0.7) {
                1.0
            } else {
                draw.between(0.6, 1.003)
            },
            walls: rarely(draw, 3),
            wall_speed: if draw.happens(0.5) {
                0.0
            } else {
                draw.scale(0.01, 3.0)
            },
            gravity: if draw.happens(0.7) {
                0.0
            } else {
                draw.scale(0.1, 30.0)
            },
            pair_rule: draw.one_of(&[
                PairRule::None,
                PairRule::None,
                PairRule::Transparent,
                PairRule::Diameter,
                PairRule::OpenWalls,
            ]),
            bumpers: rarely(draw, 12),
            threads: draw.integer(1, 3) as u32,
            side: draw.integer(8, 30) as u32,
            window: draw.scale(0.2, 4.0),
            // Margins and fronts too small on purpose.
            margin: draw.integer(1, 5) as u32,
            front: draw.scale(0.3, 4.0),
            length: draw.scale(2.0, 20.0),
            stops: stops as u32,
            reports: draw.happens(0.5),
            disturbed: if draw.happens(0.5) {
                draw.scale(0.01, 1.0)
            } else {
                0.0
            },
            contacts_per_epoch: draw.one_of(&[1, 4, 64]),
        }
    }

    /// Simpler cases, the simplest first.
    pub fn simpler(&self) -> Vec<Self> {
        let half = |number: u32| number / 2;
        let all = [
            Self {
                length: 0.5 * self.length,
                ..self.clone()
            },
            Self {
                count: half(self.count).max(500),
                ..self.clone()
            },
            Self {
                stops: half(self.stops).max(1),
                ..self.clone()
            },
            Self {
                gas: Gas::Discs,
                ..self.clone()
            },
            Self {
                elasticity: 1.0,
                ..self.clone()
            },
            Self {
                walls: half(self.walls),
                ..self.clone()
            },
            Self {
                wall_speed: 0.0,
                ..self.clone()
            },
            Self {
                gravity: 0.0,
                ..self.clone()
            },
            Self {
                pair_rule: PairRule::None,
                ..self.clone()
            },
            Self {
                bumpers: half(self.bumpers),
                ..self.clone()
            },
            Self {
                threads: 1,
                ..self.clone()
            },
            Self {
                reports: false,
                ..self.clone()
            },
            Self {
                disturbed: 0.0,
                ..self.clone()
            },
        ];
        all.into_iter()
            .filter(|case| case != self && case.length > 0.1)
            .collect()
    }

    /// The action after a stop.
    pub fn action(&self, stop: u32) -> Action {
        let draw = &mut FuzzDraw::new(case_seed(self.seed, u64::from(stop)));
        if !draw.happens(self.disturbed) {
            return Action::None;
        }
        let elasticity = draw.one_of(&[0.5, 0.9, 1.0, 1.0]);
        let contact_time = draw.one_of(&[0.0, 1e-4, 1e-2]);
        draw.one_of(&[
            Action::Step,
            Action::Step,
            Action::OtherObserver,
            Action::Clone,
            Action::EndEpoch,
            Action::Elasticity(elasticity, contact_time),
            Action::Reverse,
        ])
    }

    /// Radius of a disc (length).
    fn radius(&self) -> f64 {
        (self.area_fraction / (std::f64::consts::PI * f64::from(self.count))).sqrt()
    }

    /// The length of the run (time): a disc of energy 1 and mass 1 flies about 0.35 diameters over
    /// the covered share between two contacts.
    pub fn until(&self) -> f64 {
        self.length * 0.5 * self.radius() / self.area_fraction
    }

    /// The division.
    pub fn tiling(&self) -> Tiling {
        let &Self {
            side,
            window,
            margin,
            front,
            ..
        } = self;
        let threads = self.threads as usize;
        Tiling {
            threads,
            least_bodies: 1,
            least_molecules: 1,
            side,
            window,
            margin,
            front,
        }
    }

    /// The scene.
    ///
    /// # Errors
    /// Numbers out of range, from a file.
    pub fn scene(&self) -> Result<Scene, carom::SceneError> {
        let Self {
            area_fraction,
            seed,
            elasticity,
            ..
        } = self;
        let radius = self.radius();
        let gas = |tag: &str, shape: &str, size: f64, share: f64, mass: f64| {
            let shape = if shape.is_empty() {
                format!("radius = {}\nmass = {mass:?}", radius * size)
            } else {
                format!(
                    "shape = \"{shape}\"\natom_radius = {}\natom_mass = {mass:?}",
                    radius * size
                )
            };
            format!(
                "[[gas]]\ntags = [\"{tag}\"]\n{shape}\nenergy = 1.0\narea_fraction = {:?}\n",
                share * area_fraction
            )
        };
        let gases = match self.gas {
            Gas::Discs => gas("a", "", 1.0, 0.5, 1.0) + &gas("b", "", 1.0, 0.5, 1.0),
            Gas::Mixture => gas("a", "", 1.0, 0.6, 1.0) + &gas("b", "", 0.7, 0.4, 0.2),
            Gas::Dumbbells => gas("a", "dumbbell", 0.7, 1.0, 0.5),
            Gas::TeesAndDiscs => gas("a", "tee", 0.5, 0.7, 0.3) + &gas("b", "", 0.5, 0.1, 1.0),
        };
        let walls = self.walls();
        let rules = self.gravity() + self.pair_rule();
        let places =
            (0..self.bumpers).flat_map(|row| (0..self.bumpers).map(move |column| [column, row]));
        let bumpers = places.map(|place| {
            let [x, y] = place.map(|number| (f64::from(number) + 0.31) / f64::from(self.bumpers));
            format!(
                "[[bumper]]\nat = [{x:?}, {y:?}]\nradius = {:?}\n",
                radius * (0.5 + f64::from(place[0] % 4))
            )
        });
        let solid: String = walls.into_iter().chain(bumpers).collect();
        Scene::from_toml(&format!(
            "[box]\nseed = {seed}\n[elasticity]\ndefault = {elasticity:?}\n{rules}{solid}{gases}"
        ))
    }

    /// The walls: a line that moves to the right, one that oscillates by some diameters, and a
    /// segment that turns.
    fn walls(&self) -> Vec<String> {
        let speed = self.wall_speed;
        let amplitude = 4.0 * self.radius();
        let walls = [
            ("x = 0.0", format!("{{ velocity = [{speed:?}, 0.0] }}")),
            (
                "y = 0.51",
                format!(
                    "{{ amplitude = [0.0, {amplitude:?}], frequency = {:?} }}",
                    speed / amplitude
                ),
            ),
            (
                "from = [0.2, 0.1]\nto = [0.9, 0.4]\nradius = 0.003",
                format!("{{ turn = {:?} }}", speed / 0.38),
            ),
        ];
        let walls = walls.iter().take(self.walls as usize);
        walls
            .map(|(place, motion)| {
                let motion = if speed > 0.0 {
                    format!("motion = {motion}\n")
                } else {
                    String::new()
                };
                format!("[[wall]]\ntags = [\"wall\"]\n{place}\n{motion}")
            })
            .collect()
    }

    /// The gravity, if there is a floor; larger distances of contact are refused beside bumpers
    /// that move in the falling frame.
    fn gravity(&self) -> String {
        let is_refused = self.pair_rule == PairRule::Diameter && self.bumpers > 0;
        if self.gravity == 0.0 || self.walls < 2 || is_refused {
            return String::new();
        }
        format!("[gravity]\nacceleration = [0.0, {:?}]\n", -self.gravity)
    }

    /// The rule for pairs, if the bodies of the case carry its tags.
    fn pair_rule(&self) -> &'static str {
        let are_two = self.gas != Gas::Dumbbells;
        let are_discs = matches!(self.gas, Gas::Discs | Gas::Mixture);
        match self.pair_rule {
            PairRule::Transparent if are_two => "[[transparent]]\nbetween = [\"a\", \"b\"]\n",
            PairRule::Diameter if are_discs => {
                "[[diameter]]\nbetween = [\"a\", \"b\"]\nfactor = 1.15\n"
            }
            PairRule::OpenWalls if self.walls > 0 => {
                "[[transparent]]\nbetween = [\"a\", \"wall\"]\n"
            }
            PairRule::None | PairRule::Transparent | PairRule::Diameter | PairRule::OpenWalls => "",
        }
    }
}
