//! A query to the detector as plain numbers, with its own scale.

use anyhow::{Result, ensure};
use carom_detection::encounters::Encounter;
use carom_geometry::{Atom, Molecule};
use carom_kinematics::{Orientation, RelativeMotion};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::edged_body::{EdgedBody, without_each};

/// The shape of a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CaseBody {
    /// Position x, y, radius and mass of each atom.
    Atoms(Vec<[f64; 4]>),
    /// A wall: x and y of the vector from end to end, and its radius.
    Wall([f64; 3]),
    /// Atoms with straight edges between them.
    Edged(EdgedBody),
}

/// A [`RelativeMotion`] as plain numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CaseFlight {
    /// From the centre of A to that of B (length).
    pub separation: [f64; 2],
    /// Velocity of B minus that of A (length per time).
    pub velocity: [f64; 2],
    /// Orientations (turns).
    pub turns: [f64; 2],
    /// Angular velocities (radians per time).
    pub spins: [f64; 2],
    /// Bound on the error of the separation (length).
    pub separation_error: f64,
    /// Bound on the error of the velocity (length per time).
    pub velocity_error: f64,
    /// Bounds on the errors of the orientations (radians).
    pub orientation_error: [f64; 2],
}

/// Number of values in a [`CaseFlight`].
const NUMBERS: usize = 12;

/// A query for the first contact of two bodies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Query {
    /// Class of the case.
    pub class: String,
    /// Horizon of the search (time).
    pub horizon: f64,
    /// The detector receives all lengths times two to this power.
    pub length_exponent: i32,
    /// The detector receives all times multiplied by two to this power.
    pub time_exponent: i32,
    /// The relative motion.
    pub flight: CaseFlight,
    /// The body A.
    pub a: CaseBody,
    /// The body B.
    pub b: CaseBody,
}

impl CaseBody {
    /// The shape of a molecule.
    pub fn new(molecule: &Molecule) -> Self {
        match (molecule.wall_edge(), molecule.atoms()) {
            (Some(face), [first, second]) => {
                let span = second.offset() - first.offset();
                Self::Wall([span.x, span.y, face.radius()])
            }
            _ if !molecule.edges().is_empty() => Self::Edged(EdgedBody::new(molecule)),
            (_, atoms) => Self::Atoms(
                atoms
                    .iter()
                    .map(|atom| [atom.offset().x, atom.offset().y, atom.radius(), atom.mass()])
                    .collect(),
            ),
        }
    }

    /// The molecule with all lengths multiplied by `factor`.
    ///
    /// # Errors
    /// The molecule is invalid.
    pub fn molecule(&self, factor: f64) -> Result<Molecule> {
        Ok(match self {
            Self::Atoms(atoms) => {
                let atom = |&[x, y, radius, mass]: &[f64; 4]| {
                    Atom::new(factor * DVec2::new(x, y), factor * radius, mass)
                };
                Molecule::new(atoms.iter().map(atom).collect::<Result<Vec<_>, _>>()?)?
            }
            Self::Wall([x, y, radius]) => {
                Molecule::wall(factor * DVec2::new(*x, *y), factor * radius)?
            }
            Self::Edged(body) => body.molecule(factor)?,
        })
    }

    /// All lengths of the body.
    pub fn lengths(&self) -> Vec<f64> {
        match self {
            Self::Atoms(atoms) => atoms
                .iter()
                .flat_map(|&[x, y, radius, _]| [x, y, radius])
                .collect(),
            Self::Wall(numbers) => numbers.to_vec(),
            Self::Edged(body) => body.lengths(),
        }
    }

    /// Mutable references to all numbers.
    pub fn numbers_mut(&mut self) -> Vec<&mut f64> {
        match self {
            Self::Atoms(atoms) => atoms.iter_mut().flatten().collect(),
            Self::Wall(numbers) => numbers.iter_mut().collect(),
            Self::Edged(body) => body.numbers_mut(),
        }
    }

    /// The body without one of its atoms or edges, for each of them.
    pub fn with_less(&self) -> Vec<Self> {
        match self {
            Self::Atoms(atoms) if atoms.len() > 1 => {
                let (first, second) = atoms.split_at(atoms.len() / 2);
                let halves = [first.to_vec(), second.to_vec()].into_iter();
                halves.chain(without_each(atoms)).map(Self::Atoms).collect()
            }
            Self::Edged(body) => body.with_less().into_iter().map(Self::Edged).collect(),
            _ => vec![],
        }
    }
}

impl CaseFlight {
    /// The numbers of a relative motion.
    pub fn new(motion: &RelativeMotion) -> Self {
        Self {
            separation: motion.separation.to_array(),
            velocity: motion.velocity.to_array(),
            turns: motion.orientation.map(Orientation::turns),
            spins: motion.angular_velocity,
            separation_error: motion.separation_error,
            velocity_error: motion.velocity_error,
            orientation_error: motion.orientation_error,
        }
    }

    /// The relative motion with lengths and times multiplied by these factors.
    pub fn motion(&self, length: f64, time: f64) -> RelativeMotion {
        let speed = length / time;
        RelativeMotion {
            separation: length * DVec2::from(self.separation),
            velocity: speed * DVec2::from(self.velocity),
            orientation: self.turns.map(Orientation::from_turns),
            angular_velocity: self.spins.map(|spin| spin / time),
            separation_error: length * self.separation_error,
            velocity_error: speed * self.velocity_error,
            orientation_error: self.orientation_error,
        }
    }

    /// Mutable references to all numbers.
    pub fn numbers_mut(&mut self) -> Vec<&mut f64> {
        let Self {
            separation: [x, y],
            velocity: [u, v],
            turns: [turns_a, turns_b],
            spins: [spin_a, spin_b],
            separation_error,
            velocity_error,
            orientation_error: [error_a, error_b],
        } = self;
        vec![
            x,
            y,
            u,
            v,
            turns_a,
            turns_b,
            spin_a,
            spin_b,
            separation_error,
            velocity_error,
            error_a,
            error_b,
        ]
    }
}

impl Query {
    /// A query at scale 1 from an encounter.
    pub fn new(class: &str, encounter: &Encounter) -> Self {
        let [a, b] = encounter.molecules.each_ref().map(CaseBody::new);
        Self {
            class: class.to_owned(),
            horizon: encounter.horizon,
            length_exponent: 0,
            time_exponent: 0,
            flight: CaseFlight::new(&encounter.motion),
            a,
            b,
        }
    }

    /// The encounter at scale 1, for the reference.
    ///
    /// # Errors
    /// The bodies cannot be built.
    pub fn encounter(&self) -> Result<Encounter> {
        self.scaled(0, 0)
    }

    /// The encounter with lengths and times multiplied by powers of two, without rounding.
    ///
    /// # Errors
    /// The bodies cannot be built, or numbers leave the range in which the scaling is exact.
    pub fn scaled(&self, length_exponent: i32, time_exponent: i32) -> Result<Encounter> {
        let (length, time) = (exp2(length_exponent), exp2(time_exponent));
        let molecules = [self.a.molecule(length)?, self.b.molecule(length)?];
        if length_exponent != 0 {
            for (body, molecule) in [&self.a, &self.b].into_iter().zip(&molecules) {
                for (atom, base) in molecule.atoms().iter().zip(body.molecule(1.0)?.atoms()) {
                    ensure!(
                        atom.offset() == length * base.offset(),
                        "the scaling of an atom is not exact"
                    );
                }
            }
        }
        let motion = self.flight.motion(length, time);
        let horizon = time * self.horizon;
        ensure!(horizon.is_finite(), "the horizon is not finite");
        Ok(Encounter {
            molecules,
            motion,
            horizon,
        })
    }

    /// Queries with fewer atoms, without scaling, or with shorter numbers.
    pub fn simpler(&self) -> Vec<Self> {
        let mut list = Vec::new();
        list.extend(
            self.a
                .with_less()
                .into_iter()
                .map(|a| Self { a, ..self.clone() }),
        );
        list.extend(
            self.b
                .with_less()
                .into_iter()
                .map(|b| Self { b, ..self.clone() }),
        );
        if self.length_exponent != 0 {
            list.push(Self {
                length_exponent: 0,
                ..self.clone()
            });
        }
        if self.time_exponent != 0 {
            list.push(Self {
                time_exponent: 0,
                ..self.clone()
            });
        }
        for index in 0..NUMBERS {
            for simplify in [
                |_: f64| 0.0,
                |x: f64| round_to(x, 0),
                |x: f64| round_to(x, 2),
            ] {
                let mut simpler = self.clone();
                if let Some(number) = simpler.flight.numbers_mut().into_iter().nth(index) {
                    *number = simplify(*number);
                }
                if simpler != *self {
                    list.push(simpler);
                }
            }
        }
        let short = round_to(self.horizon, 1);
        if short != self.horizon && short > 0.0 {
            list.push(Self {
                horizon: short,
                ..self.clone()
            });
        }
        list
    }
}

/// Two to a power; 0 or infinite beyond the range of floats.
pub fn exp2(exponent: i32) -> f64 {
    libm::scalbn(1.0, exponent)
}

/// Rounds `x` to `digits` decimal digits after the first.
fn round_to(x: f64, digits: i32) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return x;
    }
    format!("{x:.*e}", digits as usize).parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_detection::encounters::Class;

    #[test]
    fn a_query_keeps_the_bits_of_its_encounter_in_toml() {
        for class in Class::ALL {
            let query = Query::new(&class.to_string(), &Encounter::draw(class, 5, 1));
            let text = toml::to_string(&query).unwrap();
            assert_eq!(toml::from_str::<Query>(&text).unwrap(), query);
            let rebuilt = query.encounter().unwrap();
            assert_eq!(CaseFlight::new(&rebuilt.motion), query.flight, "{class}");
        }
    }

    #[test]
    fn simpler_queries_differ_from_the_query() {
        let query = Query::new("generic", &Encounter::draw(Class::Generic, 5, 1));
        let simpler = query.simpler();
        assert!(!simpler.is_empty() && !simpler.contains(&query));
    }
}
