//! Runs parry's `cast_shapes_nonlinear` on the same pairs in a separate process, because some of
//! its calls do not return.
//!
//! Each pair is sent as one line of numbers, bit by bit; each answer returns as one line.

use std::{
    io::{BufRead as _, BufReader, Write as _, stdin, stdout},
    process::{Child, ChildStdin, Command, Stdio},
    sync::mpsc::{Receiver, RecvTimeoutError, channel},
    thread,
    time::Duration,
};

use anyhow::{Context, Result, bail};
use carom_detection::{Answer, Contact, Exact, Outcome, Touch, encounters::Encounter};
use carom_geometry::{Atom, Interior, Molecule};
use carom_kinematics::{Orientation, RelativeMotion};
use carom_tables::averages::median;
use cpu_time::ThreadTime;
use glam::DVec2;
use parry2d_f64::{
    math::Pose,
    query::{NonlinearRigidMotion, cast_shapes_nonlinear},
    shape::{Ball, Compound, Shape},
};

/// A longer call counts as one that does not return: the limit is a hundred thousand times the time
/// of the exact detector.
const LIMIT: Duration = Duration::from_millis(100);

/// Shorter calls are repeated and timed with warm caches (seconds).
const SHORT: f64 = 1e-3;

/// Name of the command that starts the process.
pub const COMMAND: &str = "parry-worker";

/// Result of a call.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cast {
    /// It returned.
    Returned {
        /// Its answer.
        answer: Answer,
        /// Processor time relative to the exact detector in the same process.
        ratio: f64,
    },
    /// It did not return within `LIMIT`.
    Hung,
}

/// The process that runs parry.
pub struct ParryProcess {
    child: Child,
    questions: ChildStdin,
    answers: Receiver<String>,
}

impl ParryProcess {
    /// Starts this program again, with the command [`COMMAND`].
    ///
    /// # Errors
    /// The process cannot be started.
    pub fn start() -> Result<Self> {
        let program = std::env::current_exe().context("cannot find this program")?;
        let mut child = Command::new(program)
            .arg(COMMAND)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .context("cannot start a process for parry")?;
        let (Some(questions), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
            bail!("the process of parry has no pipes")
        };
        let (sender, answers) = channel();
        thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
        Ok(Self {
            child,
            questions,
            answers,
        })
    }

    /// Searches one pair. A process that does not answer is killed and replaced.
    ///
    /// # Errors
    /// The process cannot be reached or replaced.
    pub fn search(&mut self, encounter: &Encounter) -> Result<Cast> {
        writeln!(self.questions, "{}", to_line(encounter))
            .context("cannot reach the process of parry")?;
        match self.answers.recv_timeout(LIMIT) {
            Ok(line) => parse_answer(&line),
            // A call that panics ends its process and counts as not returning.
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {
                *self = Self::start()?;
                Ok(Cast::Hung)
            }
        }
    }
}

impl Drop for ParryProcess {
    fn drop(&mut self) {
        // The process may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Main loop of the process: searches pairs from standard input until it ends.
///
/// # Errors
/// A line is not a pair.
pub fn work() -> Result<()> {
    for line in stdin().lines() {
        let encounter = from_line(&line?)?;
        let exact = exact_seconds(&encounter);
        let (outcome, mut seconds) = cast(&encounter);
        if seconds < SHORT {
            // The exact detector has warm caches here, so this call is repeated too.
            let mut again = [(); 3].map(|()| cast(&encounter).1);
            seconds = median(&mut again).unwrap_or(seconds);
        }
        let word = match outcome.contact() {
            Some(contact) => format!("{:x}", contact.time.to_bits()),
            None if matches!(outcome, Outcome::Unresolved(_)) => "unsupported".to_owned(),
            None => "free".to_owned(),
        };
        let mut output = stdout().lock();
        writeln!(output, "{word} {:x}", (seconds / exact).to_bits())?;
        output.flush()?;
    }
    Ok(())
}

fn parse_answer(line: &str) -> Result<Cast> {
    let (word, ratio) = line
        .split_once(' ')
        .context("the answer of parry does not have two words")?;
    let number = |text| {
        u64::from_str_radix(text, 16)
            .map(f64::from_bits)
            .context("the answer of parry is not a number")
    };
    let outcome = match word {
        "free" => Outcome::Free,
        "unsupported" => Outcome::Unresolved(0.0),
        _ => Outcome::Contact(Contact {
            time: number(word)?,
            touch: Touch::BoundingCircles,
        }),
    };
    Ok(Cast::Returned {
        answer: Answer {
            outcome,
            evaluations: 0,
        },
        ratio: number(ratio)?,
    })
}

/// Answer and processor time of parry (seconds).
fn cast(encounter: &Encounter) -> (Outcome, f64) {
    let motion = &encounter.motion;
    let body = |index: usize, place: DVec2, velocity: DVec2| {
        let start = Pose::new(place, motion.orientation[index].radians());
        NonlinearRigidMotion::new(start, DVec2::ZERO, velocity, motion.angular_velocity[index])
    };
    let motions = [
        body(0, DVec2::ZERO, DVec2::ZERO),
        body(1, motion.separation, motion.velocity),
    ];
    let shapes = encounter.molecules.each_ref().map(parry_shape);
    let begun = ThreadTime::now();
    let hit = cast_shapes_nonlinear(
        &motions[0],
        &*shapes[0],
        &motions[1],
        &*shapes[1],
        0.0,
        encounter.horizon,
        false,
    );
    let seconds = begun.elapsed().as_secs_f64();
    let outcome = match hit {
        Ok(Some(hit)) => Outcome::Contact(Contact {
            time: hit.time_of_impact,
            touch: Touch::BoundingCircles,
        }),
        Ok(None) => Outcome::Free,
        Err(_) => Outcome::Unresolved(0.0),
    };
    (outcome, seconds)
}

fn parry_shape(molecule: &Molecule) -> Box<dyn Shape> {
    if molecule.is_disc() {
        Box::new(Ball::new(molecule.bounding_radius()))
    } else {
        Box::new(Compound::from(molecule))
    }
}

/// Processor time of one query of the exact detector (seconds): the median of a few batches.
fn exact_seconds(encounter: &Encounter) -> f64 {
    let mut times: Vec<f64> = (0..5)
        .map(|_| {
            let begun = ThreadTime::now();
            for _ in 0..20 {
                std::hint::black_box(encounter.first_contact(&Exact::default()));
            }
            begun.elapsed().as_secs_f64() / 20.0
        })
        .collect();
    median(&mut times).unwrap_or(f64::NAN)
}

/// Encodes a pair as the bits of all its numbers.
fn to_line(encounter: &Encounter) -> String {
    let motion = &encounter.motion;
    let mut numbers = vec![
        motion.separation.x,
        motion.separation.y,
        motion.velocity.x,
        motion.velocity.y,
        motion.orientation[0].turns(),
        motion.orientation[1].turns(),
        motion.angular_velocity[0],
        motion.angular_velocity[1],
        encounter.horizon,
    ];
    for molecule in &encounter.molecules {
        // A wall is encoded as a molecule without atoms, with its span and thickness.
        if let (Some(face), [_, end]) = (molecule.wall_edge(), molecule.atoms()) {
            numbers.extend([
                0.0,
                2.0 * end.offset().x,
                2.0 * end.offset().y,
                face.radius(),
            ]);
            continue;
        }
        numbers.extend([molecule.atoms().len(), molecule.edges().len()].map(|count| count as f64));
        for atom in molecule.atoms() {
            numbers.extend([atom.offset().x, atom.offset().y, atom.radius(), atom.mass()]);
        }
        for edge in molecule.edges() {
            numbers.extend(edge.ends().unwrap_or_default().map(f64::from));
            numbers.push(edge.radius());
        }
        // A mass that is not spread evenly is that of the atoms.
        let even = if molecule.is_uniform() {
            molecule.mass()
        } else {
            0.0
        };
        let is_hollow = molecule.interior() == Interior::Hollow;
        numbers.extend([even, f64::from(u8::from(is_hollow))]);
    }
    let words: Vec<String> = numbers
        .iter()
        .map(|number| format!("{:x}", number.to_bits()))
        .collect();
    words.join(" ")
}

fn from_line(line: &str) -> Result<Encounter> {
    let mut numbers = line.split(' ').map(|word| {
        u64::from_str_radix(word, 16)
            .map(f64::from_bits)
            .context("the line of a pair holds a word that is not a number")
    });
    let mut next = || numbers.next().context("the line of a pair is too short")?;
    let separation = DVec2::new(next()?, next()?);
    let velocity = DVec2::new(next()?, next()?);
    let orientation = [
        Orientation::from_turns(next()?),
        Orientation::from_turns(next()?),
    ];
    let angular_velocity = [next()?, next()?];
    let horizon = next()?;
    let molecules = [molecule_from(&mut next)?, molecule_from(&mut next)?];
    let motion = RelativeMotion {
        orientation,
        angular_velocity,
        ..RelativeMotion::exactly(separation, velocity)
    };
    Ok(Encounter {
        molecules,
        motion,
        horizon,
    })
}

fn molecule_from(next: &mut impl FnMut() -> Result<f64>) -> Result<Molecule> {
    let count = next()? as usize;
    if count == 0 {
        return Ok(Molecule::wall(DVec2::new(next()?, next()?), next()?)?);
    }
    let edge_count = next()? as usize;
    let mut atoms = Vec::new();
    for _ in 0..count {
        let (offset, radius, mass) = (DVec2::new(next()?, next()?), next()?, next()?);
        atoms.push(Atom::new(offset, radius, mass)?);
    }
    let mut edges = Vec::new();
    for _ in 0..edge_count {
        edges.push(([next()? as u32, next()? as u32], next()?));
    }
    let (even, hollow) = (next()?, next()?);
    let interior = if hollow == 0.0 {
        Interior::Solid
    } else {
        Interior::Hollow
    };
    Ok(if even > 0.0 {
        Molecule::uniform(atoms, &edges, interior, even)?
    } else {
        Molecule::with_edges(atoms, &edges, interior)?
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_detection::encounters::Class;

    #[test]
    fn a_pair_is_decoded_as_it_was_encoded() {
        for class in [
            Class::Generic,
            Class::Recontact(6),
            Class::Rods,
            Class::Wall,
            Class::Squares,
            Class::BondedDiscs,
            Class::InsideRing,
            Class::TurningWall,
        ] {
            for index in 0..8 {
                let sent = Encounter::draw(class, 1, index);
                let received = from_line(&to_line(&sent)).unwrap();
                assert_eq!(received.motion, sent.motion);
                assert_eq!(received.horizon, sent.horizon);
                for (one, other) in sent.molecules.iter().zip(&received.molecules) {
                    assert_eq!(one.atoms().len(), other.atoms().len());
                    assert_eq!(one.edges().len(), other.edges().len());
                    assert_eq!(one.interior(), other.interior());
                    // The centre of mass is computed again, with rounding.
                    let off = one.atoms()[0].offset() - other.atoms()[0].offset();
                    assert!(off.length() <= 1e-15 * one.bounding_radius());
                }
            }
        }
        assert!(from_line("3ff0000000000000 7").is_err());
    }

    #[test]
    fn parry_finds_discs_that_meet_head_on() {
        let disc = || Molecule::disc(0.5, 1.0).unwrap();
        let motion = RelativeMotion::exactly(DVec2::new(3.0, 0.0), DVec2::new(-1.0, 0.0));
        let (outcome, seconds) = cast(&Encounter {
            molecules: [disc(), disc()],
            motion,
            horizon: 10.0,
        });
        let time = outcome.contact().expect("a contact").time;
        assert!((time - 2.0).abs() < 1e-2, "{time}");
        assert!(seconds >= 0.0);
    }

    #[test]
    fn answers_are_read_back() {
        let ratio = 2.5f64;
        let cast = parse_answer(&format!("free {:x}", ratio.to_bits())).unwrap();
        let answer = Answer {
            outcome: Outcome::Free,
            evaluations: 0,
        };
        assert_eq!(cast, Cast::Returned { answer, ratio });
        assert!(parse_answer("free").is_err() && parse_answer("xyz 0").is_err());
    }
}
