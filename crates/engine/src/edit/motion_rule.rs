//! The motions that thermostats give to bodies.
//!
//! Maxwell's distribution at kT: each component of the velocity is normal with variance kT/m, and
//! the angular velocity of a body that contacts turn with variance kT/I. A body does not turn if it
//! is locked; the spin of a round molecule is no degree of freedom and remains.

use std::f64::consts::TAU;

use carom_geometry::MAX_MAGNITUDE;
use carom_kinematics::{Motion, Orientation};
use glam::DVec2;

use crate::{
    contact::philox::{open_unit, philox},
    edit::thermostat::DrawKey,
    scene::{
        error::EditError,
        kick_momentum::KickMomentum,
        least_speed::MIN_SPEED,
        random::normal_pair_of,
        thermostat_rule::{LangevinStep, SelfPropulsion},
    },
    world::body::Body,
};

/// Largest number of thermal speeds that a drawn component can have: √(2 · 53 ln 2) = 8.6.
const MAX_THERMAL_SPEEDS: f64 = 8.6;

/// The random numbers of one body in one action.
pub(super) struct Draw([f64; 4]);

impl Draw {
    pub(super) fn new(body: &Body, key: DrawKey) -> Self {
        let bits = philox([key.seed, key.replica], [body.key().0, key.action, 0, 0]);
        Self(bits.map(open_unit))
    }

    /// Two numbers of the standard normal distribution.
    fn normal_pair(&self) -> DVec2 {
        let [one, two, ..] = self.0;
        normal_pair_of([one, two])
    }

    /// A number of the standard normal distribution, independent of [`Self::normal_pair`].
    fn normal(&self) -> f64 {
        let [.., three, four] = self.0;
        normal_pair_of([three, four]).x
    }

    fn direction(&self) -> DVec2 {
        Orientation::from_turns(self.0[0]).cos_sin()
    }
}

/// Velocity from Maxwell's distribution, and angular velocity if contacts turn the body.
pub(super) fn maxwell(
    body: &Body,
    motion: &Motion,
    temperature: f64,
    draw: &Draw,
) -> Result<Motion, EditError> {
    let [speed, spin] = thermal_speeds(body, temperature);
    let most = MAX_THERMAL_SPEEDS
        * if body.can_turn() {
            speed.max(spin)
        } else {
            speed
        };
    // NaN and negative temperatures are out of range as well.
    if !(temperature > 0.0
        && temperature <= MAX_MAGNITUDE
        && speed >= MIN_SPEED
        && most <= MAX_MAGNITUDE)
    {
        return Err(EditError::Energy(temperature));
    }
    Ok(Motion {
        velocity: speed * draw.normal_pair(),
        angular_velocity: if body.can_turn() {
            spin * draw.normal()
        } else {
            motion.angular_velocity
        },
        ..*motion
    })
}

/// √(kT/m) and √(kT/I), standard deviations of a component of the velocity (length per time) and of
/// the angular velocity (radians per time).
fn thermal_speeds(body: &Body, temperature: f64) -> [f64; 2] {
    let inertia = body.inertia();
    [inertia.inverse_mass, inertia.inverse_moment].map(|inverse| (temperature * inverse).sqrt())
}

/// A step of the Ornstein–Uhlenbeck process, exact for any length.
pub(super) fn langevin(body: &Body, motion: &Motion, step: &LangevinStep, draw: &Draw) -> Motion {
    let duration = step.friction * step.every;
    // The functions of `libm` give all processors the same bits.
    let kept = libm::exp(-duration);
    let renewed = (-libm::expm1(-2.0 * duration)).sqrt();
    let [speed, spin] = thermal_speeds(body, step.temperature).map(|thermal| renewed * thermal);
    Motion {
        velocity: kept * motion.velocity + speed * draw.normal_pair(),
        angular_velocity: if body.can_turn() {
            kept * motion.angular_velocity + spin * draw.normal()
        } else {
            motion.angular_velocity
        },
        ..*motion
    }
}

/// The axis of a round body in the first action of a self-propulsion: any, at random.
pub(super) fn first_axis(body: &Body, key: DrawKey) -> Orientation {
    // Another counter than that of the draw of the action.
    let bits = philox([key.seed, key.replica], [body.key().0, key.action, 1, 0]);
    Orientation::from_turns(open_unit(bits[0]))
}

/// The axis of a round body in the next action, after it has turned by a normal angle.
pub(super) fn turned_axis(axis: Orientation, rule: &SelfPropulsion, draw: &Draw) -> Orientation {
    Orientation::from_turns(axis.turns() + spin(rule, draw) * rule.every / TAU)
}

/// Angular velocity that turns a body by a normal angle until the next action (radians per time).
fn spin(rule: &SelfPropulsion, draw: &Draw) -> f64 {
    (2.0 * rule.rotational_diffusion / rule.every).sqrt() * draw.normal()
}

/// Velocity along the axis, and angular velocity of a body that contacts turn; see
/// [`SelfPropulsion`].
pub(super) fn active(
    body: &Body,
    motion: &Motion,
    axis: Orientation,
    rule: &SelfPropulsion,
    draw: &Draw,
) -> Motion {
    let random_speed = (2.0 * rule.translational_diffusion / rule.every).sqrt();
    Motion {
        velocity: rule.speed * axis.cos_sin() + random_speed * draw.normal_pair(),
        angular_velocity: if body.can_turn() {
            spin(rule, draw)
        } else {
            motion.angular_velocity
        },
        ..*motion
    }
}

/// A random direction with the present speed; `None` at rest.
pub(super) fn rotated(motion: &Motion, draw: &Draw) -> Option<Motion> {
    // The sum of squares may underflow to 0. The function of `libm` gives all processors the same
    // bits.
    let speed = libm::hypot(motion.velocity.x, motion.velocity.y);
    (speed > 0.0).then(|| Motion {
        velocity: speed * draw.direction(),
        ..*motion
    })
}

/// The velocity after a momentum has been added.
pub(super) fn kicked(body: &Body, motion: &Motion, momentum: KickMomentum, draw: &Draw) -> Motion {
    let momentum = match momentum {
        KickMomentum::Magnitude(magnitude) => magnitude * draw.direction(),
        KickMomentum::Vector(vector) => DVec2::from(vector),
    };
    Motion {
        velocity: motion.velocity + body.inertia().inverse_mass * momentum,
        ..*motion
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{run::simulation::Simulation, scene::Scene};

    const ACTIONS: u64 = 40_000;

    const KEY: DrawKey = DrawKey {
        seed: 5,
        replica: 2,
        action: 8,
    };

    /// A disc of mass 2 and a tee of mass 5, at orientation 0.3 turns.
    fn bodies() -> [(Body, Motion); 2] {
        let molecule = |shape: &str, mass: f64, x: f64| {
            format!(
                "[[molecule]]\nshape = \"{shape}\"\natom_radius = 0.1\natom_mass = {mass}\nat = [{x}, 0.5]\n\
                 velocity = [3.0, 0.0]\norientation_turns = 0.3\n"
            )
        };
        let text = molecule("disc", 2.0, 0.2) + &molecule("tee", 1.0, 0.7);
        let scene = Scene::from_toml(&format!("box.sides = [2.0, 2.0]\n{text}")).unwrap();
        let world = Simulation::new(&scene).unwrap().world;
        [0, 1].map(|index| (world.bodies[index].clone(), world.motions[index]))
    }

    /// Mean and variance of a quantity of many draws, each with five standard errors of a normal
    /// quantity.
    fn moments(body: &Body, mut quantity: impl FnMut(&Draw) -> f64) -> [f64; 2] {
        let values: Vec<f64> = (0..ACTIONS)
            .map(|action| quantity(&Draw::new(body, DrawKey { action, ..KEY })))
            .collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let square = |value: &f64| (value - mean) * (value - mean);
        [
            mean,
            values.iter().map(square).sum::<f64>() / values.len() as f64,
        ]
    }

    fn assert_moments([mean, variance]: [f64; 2], expected: [f64; 2]) {
        let count = ACTIONS as f64;
        let errors = [
            (expected[1] / count).sqrt(),
            expected[1] * (2.0 / count).sqrt(),
        ];
        assert!(
            (mean - expected[0]).abs() <= 5.0 * errors[0]
                && (variance - expected[1]).abs() <= 5.0 * errors[1],
            "{mean} {variance}, expected {expected:?}"
        );
    }

    #[test]
    fn a_langevin_step_has_the_moments_of_the_ornstein_uhlenbeck_process() {
        let step = LangevinStep {
            friction: 2.0,
            temperature: 1.5,
            every: 0.35,
        };
        let (kept, renewed) = ((-0.7f64).exp(), 1.0 - (-1.4f64).exp());
        for (body, motion) in bodies() {
            let of = |draw: &Draw| langevin(&body, &motion, &step, draw);
            let variance = renewed * 1.5 * body.inertia().inverse_mass;
            assert_moments(
                moments(&body, |draw| of(draw).velocity.x),
                [3.0 * kept, variance],
            );
            assert_moments(moments(&body, |draw| of(draw).velocity.y), [0.0, variance]);
            let turning = if body.can_turn() {
                renewed * 1.5 * body.inertia().inverse_moment
            } else {
                0.0
            };
            let spin = moments(&body, |draw| of(draw).angular_velocity);
            assert_moments(spin, [0.0, turning]);
        }
    }

    #[test]
    fn a_long_langevin_step_is_a_draw_from_maxwells_distribution() {
        let step = LangevinStep {
            friction: 1e3,
            temperature: 1.5,
            every: 1.0,
        };
        for (body, motion) in bodies() {
            let draw = Draw::new(&body, KEY);
            let drawn = maxwell(&body, &motion, 1.5, &draw).unwrap();
            assert_eq!(langevin(&body, &motion, &step, &draw), drawn);
        }
    }

    #[test]
    fn axes_turn_by_normal_angles_and_velocities_lie_along_them() {
        let rule = SelfPropulsion {
            speed: 2.0,
            rotational_diffusion: 0.5,
            translational_diffusion: 0.0,
            every: 0.01,
        };
        for (body, motion) in bodies() {
            let axis = motion.orientation;
            // The turn in the action, or in the time until the next.
            let angle = moments(&body, |draw| {
                if body.can_turn() {
                    active(&body, &motion, axis, &rule, draw).angular_velocity * rule.every
                } else {
                    (turned_axis(axis, &rule, draw).turns() - 0.3) * TAU
                }
            });
            assert_moments(angle, [0.0, 2.0 * 0.5 * 0.01]);
            let draw = Draw::new(&body, KEY);
            let after = active(&body, &motion, axis, &rule, &draw);
            assert_eq!(after.velocity, 2.0 * axis.cos_sin());
            assert_eq!(body.can_turn(), after.angular_velocity != 0.0);
        }
    }

    #[test]
    fn first_axes_have_no_direction() {
        let [(body, _), _] = bodies();
        for component in 0..2 {
            let mut action = 0;
            let found = moments(&body, |_| {
                action += 1;
                first_axis(&body, DrawKey { action, ..KEY }).cos_sin()[component]
            });
            assert_moments(found, [0.0, 0.5]);
        }
    }

    #[test]
    fn translational_diffusion_adds_a_velocity_of_its_variance() {
        let rule = SelfPropulsion {
            speed: 2.0,
            rotational_diffusion: 0.0,
            translational_diffusion: 0.3,
            every: 0.1,
        };
        let [(body, motion), _] = bodies();
        let axis = motion.orientation.cos_sin();
        for component in 0..2 {
            let found = moments(&body, |draw| {
                active(&body, &motion, motion.orientation, &rule, draw).velocity[component]
            });
            assert_moments(found, [2.0 * axis[component], 2.0 * 0.3 / 0.1]);
        }
    }

    #[test]
    fn rotations_keep_speeds_and_kicks_add_momenta() {
        for (body, motion) in bodies() {
            let speed = |draw: &Draw| rotated(&motion, draw).unwrap().velocity.length();
            let [mean, variance] = moments(&body, speed);
            assert!((mean - 3.0).abs() < 1e-12 && variance < 1e-24);
            let along = moments(&body, |draw| rotated(&motion, draw).unwrap().velocity.x);
            assert_moments(along, [0.0, 4.5]);
            let mass = body.inertia().inverse_mass.recip();
            let momentum = |draw: &Draw, kick: KickMomentum| {
                mass * (kicked(&body, &motion, kick, draw).velocity - motion.velocity)
            };
            let magnitude = KickMomentum::Magnitude(4.0);
            let [mean, variance] = moments(&body, |draw| momentum(draw, magnitude).length());
            assert!((mean - 4.0).abs() < 1e-12 && variance < 1e-24);
            let [mean, _] = moments(&body, |draw| {
                let vector = momentum(draw, KickMomentum::Vector([1.0, -2.0]));
                (vector - DVec2::new(1.0, -2.0)).length()
            });
            assert!(mean < 1e-14);
        }
    }
}
