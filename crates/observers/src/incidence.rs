//! The angles at which bodies meet fixed bodies and walls.
//!
//! Where all directions are equally probable, sin φ of the angle φ from the normal is uniform from
//! −1 to 1: Knudsen's cosine law in two dimensions, and the measure that an ergodic table conserves
//! from bounce to bounce.

use carom_engine::{Body, CollisionReport, Observer};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{AdaptiveHistogram, Group};

/// sin φ of the velocity of a centre of mass before each contact with a fixed body, relative to the
/// point of it that is touched; positive to the left of the normal that points from the fixed body.
///
/// The law of the cosine holds for bodies that do not turn, as smooth discs; the spin of others
/// adds to the velocity of the point that touches.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Group, Incidence};
///
/// // Downwards and to the left, 45° from the normal of the floor, which points up.
/// let scene = Scene::from_toml(r#"
///     [[wall]]
///     y = 0.0
///     [[molecule]]
///     shape = "disc"
///     atom_radius = 0.05
///     atom_mass = 1.0
///     at = [0.5, 0.5]
///     velocity = [-1.0, -1.0]
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut incidence = Incidence::new(Group::All, 4);
/// simulation.observe_until(0.5, &mut incidence)?;
/// assert_eq!(incidence.sines().counts(), [0, 0, 0, 1]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "boundary map")]
#[doc(alias = "cosine law")]
pub struct Incidence {
    group: Group,
    sines: AdaptiveHistogram,
}

impl Incidence {
    /// Observes the contacts of the free bodies of a group with fixed ones, in this number of equal
    /// bins from −1 to 1; 0 is taken as 1.
    pub fn new(group: Group, bins: usize) -> Self {
        Self {
            group,
            sines: AdaptiveHistogram::within(-1.0, 1.0, bins),
        }
    }

    /// sin φ of all contacts so far.
    pub fn sines(&self) -> &AdaptiveHistogram {
        &self.sines
    }
}

impl Observer for Incidence {
    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        bodies.into_iter().any(Body::is_fixed)
            && bodies
                .into_iter()
                .any(|body| body.is_free() && self.group.contains(body))
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        let [first, second] = &report.sides;
        if report.is_step || !self.watches([first.body, second.body]) {
            return;
        }
        let [of_first, of_second] = [first, second].map(|side| {
            let arm = if side.body.is_fixed() {
                side.arm
            } else {
                DVec2::ZERO
            };
            side.before.velocity_of(arm)
        });
        let velocity = of_second - of_first;
        // The normal points from the first body: with the fixed body second, both change their
        // signs, and sin φ none.
        let sine = velocity.dot(report.normal.perp()) / velocity.length();
        if sine.is_finite() {
            self.sines.add(sine.clamp(-1.0, 1.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_engine::{Scene, Simulation};

    fn observe(text: &str, until: f64) -> Incidence {
        let mut simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
        let mut incidence = Incidence::new(Group::All, 10);
        simulation.observe_until(until, &mut incidence).unwrap();
        incidence
    }

    /// χ² of ten bins with equal expectations is below 27.9 with the probability 0.999.
    fn is_uniform(incidence: &Incidence) -> bool {
        let counts = incidence.sines().counts();
        let expected = counts.iter().sum::<u64>() as f64 / counts.len() as f64;
        let square = |count: &u64| (*count as f64 - expected).powi(2) / expected;
        assert!(counts.len() == 10 && expected > 400.0, "{counts:?}");
        counts.iter().map(square).sum::<f64>() < 27.9
    }

    #[test]
    fn a_gas_meets_its_walls_by_the_law_of_the_cosine() {
        let gas =
            "[box]\nseed = 3\n[[gas]]\nradius = 0.02\nmass = 1.0\ntemperature = 1.0\ncount = 60\n";
        let walls =
            "[[wall]]\nx = 0.0\n[[wall]]\ny = 0.0\n[[bumper]]\nradius = 0.1\nat = [0.5, 0.5]\n";
        assert!(is_uniform(&observe(&format!("{walls}{gas}"), 40.0)));
    }

    /// In a circle each path keeps its angle: a few bins have all.
    #[test]
    fn a_dispersing_table_forgets_the_angle_and_a_circle_keeps_it() {
        let disc = "[box]\nsides = [5.0, 5.0]\nseed = 1\n[[gas]]\nradius = 0.001\nmass = 2.0\nenergy = 1.0\ncount = 1\n";
        let table =
            "[[wall]]\nx = 0.0\n[[wall]]\ny = 0.0\n[[bumper]]\nradius = 1.5\nat = [2.5, 2.5]\n";
        assert!(is_uniform(&observe(&format!("{disc}{table}"), 20000.0)));
        let circle = "[[container]]\ncircle = { at = [2.5, 2.5], radius = 1.001 }\n";
        let kept = observe(&format!("{disc}{circle}"), 1000.0);
        let occupied = kept.sines().counts().into_iter().filter(|count| *count > 0);
        assert_eq!(occupied.count(), 1);
    }

    /// A fixed body counts from either side of a report: added before or after the disc.
    #[test]
    fn the_sign_does_not_depend_on_the_order_of_the_bodies() {
        let disc = "[[molecule]]\nshape = \"disc\"\natom_radius = 0.05\natom_mass = 1.0\nat = [0.5, 0.5]\n\
                    velocity = [-1.0, -0.5]\n";
        let bumper = "[[bumper]]\nradius = 0.05\nat = [0.3, 0.38]\n";
        let of = |text: String| observe(&text, 0.4).sines().counts();
        let counts = of(format!("{disc}{bumper}"));
        assert_eq!(counts.iter().sum::<u64>(), 1);
        assert_eq!(counts, of(format!("{bumper}{disc}")));
    }

    /// A paddle that turns about its middle with ω = 1: 1/4 to the right its face rises with 1/4,
    /// and the disc falls on it with 1/2.
    #[test]
    fn the_velocity_is_relative_to_a_paddle_where_it_is_touched() {
        let paddle = "[[wall]]\nfrom = [0.1, 0.5]\nto = [0.9, 0.5]\nmotion = { turn = 1.0, about = [0.5, 0.5] }\n";
        let disc = |across: f64| {
            format!(
                "[[molecule]]\nshape = \"disc\"\natom_radius = 0.01\natom_mass = 1.0\nat = [{:?}, 0.5101]\n\
                 velocity = [{across:?}, -0.5]\n",
                0.75 - 1e-4 * across
            )
        };
        // tan φ = v_t/(1/2 + 1/4): 45° at v_t = 3/4.
        let counts = observe(&format!("{paddle}{}", disc(0.6)), 0.001)
            .sines()
            .counts();
        let sine = |across: f64| across / across.hypot(0.75);
        let bin = ((-sine(0.6) + 1.0) / 0.2) as usize;
        assert_eq!(counts.iter().sum::<u64>(), 1);
        assert_eq!(counts[bin], 1, "{counts:?} {bin}");
    }
}
