//! Thermal motion: velocities, energy and temperature relative to the centre of mass.
//!
//! A motion of the whole system is not thermal. Along an axis on which momentum is conserved, the
//! velocity V = P / M of the centre of mass is constant, and the temperature is that of the
//! velocities relative to it. Momentum along each axis is conserved as follows:
//!
//! * without fixed bodies, along both;
//! * with straight walls across the whole box that are parallel to an axis, along that axis only;
//! * with any other wall or fixed body, along neither.
//!
//! The geometry alone decides. This is correct for each response with impulses along the contact
//! normal, such as [`Impact`](carom_response::Impact). A response with a tangential impulse, such
//! as friction, also changes the momentum along a straight wall; this is not taken into account.
//!
//! With V = 0 along an axis without conservation, and c = 0, 1 or 2 conserved components, the
//! equipartition theorem in the ensemble of fixed P gives, for a group of n of the bodies,
//!
//! ⟨Σ ½ mᵢ |vᵢ − V|² + ½ Iᵢ ωᵢ²⟩ = ½ f kT, f = Σ (2 − c mᵢ / M) + turning degrees of freedom,
//!
//! because the variance of a component of vᵢ − V is (1/mᵢ − 1/M) kT. For all bodies this is
//! kT = 2 (K − P²/2M) / (2 (N − 1) + turning degrees of freedom) (Rapaport 2004, section 2.4).
//!
//! Under shear ([`BoxSpec::shear_rate`](crate::BoxSpec::shear_rate)) velocities are thermal
//! relative to the flow γ (y − Ly/2) along x too, and momentum relative to it is conserved along
//! both axes.
//!
//! All bodies count as one system. Two or more parallel walls across the whole box divide it into
//! the same number of rooms, each of which conserves its own momentum along the walls. Then the
//! relative motion of the rooms counts as thermal, and f is too large by the number of rooms less
//! 1: 2 N − 1 instead of 2 N − 2 for the discs of two rooms.

use carom_kinematics::{Motion, kinetic_energy};
use glam::{BVec2, DVec2};

use crate::world::{
    World,
    body::Body,
    view::{BodyView, View},
};

/// The frame that moves with the centre of mass along each axis on which momentum is conserved, and
/// is at rest along the others. Under shear it moves with the flow in addition.
///
/// ```
/// use carom_engine::{Scene, Simulation};
/// use glam::DVec2;
///
/// // The wall reflects along x; along y the gas drifts forever.
/// let scene = Scene::from_toml(r#"
///     [[wall]]
///     x = 0.0
///     [[molecule]]
///     atoms = [{ at = [0, 0], radius = 0.1, mass = 1 }]
///     at = [0.3, 0.2]
///     velocity = [1.0, 5.0]
///     [[molecule]]
///     atoms = [{ at = [0, 0], radius = 0.1, mass = 3 }]
///     at = [0.3, 0.7]
///     velocity = [0.0, 1.0]
/// "#)?;
/// let simulation = Simulation::new(&scene)?;
/// let frame = simulation.view().centre_of_mass_frame();
/// assert_eq!(frame.conserves_momentum(), [false, true]);
/// assert_eq!(frame.velocity(), DVec2::new(0.0, 2.0));
/// // ½ (1 + 3²) + ½ 3 (1²), over 2 + 1 degrees of freedom.
/// let thermal = frame.thermal(simulation.view().bodies());
/// assert_eq!((thermal.energy(), thermal.degrees_of_freedom), (6.5, 3.0));
/// assert_eq!(simulation.view().temperature(), Some(2.0 * 6.5 / 3.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[doc(alias = "barycentric")]
#[non_exhaustive]
pub struct CentreOfMassFrame {
    mass: f64,
    velocity: DVec2,
    conserved: BVec2,
    /// The flow under shear: its rate of change along y (1/time), and where it is 0 (length).
    flow: [f64; 2],
}

/// Thermal energy of a group of bodies and its degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct ThermalEnergy {
    /// Number of bodies of the group that can move.
    pub bodies: usize,
    /// Σ ½ m |v − V|² (mass × length² / time²).
    pub translation: f64,
    /// Σ ½ I ω² over the bodies that can turn (mass × length² / time²).
    pub rotation: f64,
    /// Σ (2 − c m / M) over the bodies that can move, with the number c of conserved components of
    /// momentum, plus one for each body that can turn. A round molecule adds none, since its
    /// angular velocity never changes (see
    /// [`Molecule::is_round`](carom_geometry::Molecule::is_round)).
    pub degrees_of_freedom: f64,
}

impl CentreOfMassFrame {
    /// The frame at an offset in the epoch (time), of which the world holds the motions.
    pub(crate) fn new(world: &World, offset: f64) -> Self {
        let flow = [world.shear_rate, 0.5 * world.bounds.sides().y];
        // Without shear the velocities of the motions, which are those of the view but for a drag.
        let peculiar = |index: usize| {
            let motion = &world.motions[index];
            if world.shear_rate == 0.0 {
                return motion.velocity;
            }
            let (motion, _) = world.wrapped_at(&motion.at(offset), offset);
            motion.velocity - world.flow_at(motion.position)
        };
        let moving = || {
            let bodies = world.bodies.iter().enumerate();
            bodies
                .filter(|(_, body)| body.is_free())
                .map(|(index, body)| (body, peculiar(index)))
        };
        let conserved = conserved_momentum(world);
        let mass: f64 = moving().map(|(body, _)| mass(body)).sum();
        // Velocities relative to that of the first body: if all are equal, V is that velocity to
        // the bit.
        let origin = moving()
            .next()
            .map_or(DVec2::ZERO, |(_, velocity)| velocity);
        let momentum: DVec2 = moving()
            .map(|(body, velocity)| mass_times(body, velocity - origin))
            .sum();
        let velocity = if mass > 0.0 {
            origin + momentum / mass
        } else {
            DVec2::ZERO
        };
        Self {
            mass,
            velocity: DVec2::select(conserved, velocity, DVec2::ZERO),
            conserved,
            flow,
        }
    }

    /// Whether the total momentum along x and along y is conserved.
    pub fn conserves_momentum(&self) -> [bool; 2] {
        self.conserved.into()
    }

    /// Velocity of the frame (length / time): P / M along an axis on which momentum is conserved, 0
    /// along any other. Under shear, where the flow is 0.
    pub fn velocity(&self) -> DVec2 {
        self.velocity
    }

    /// Velocity of the frame at a place in the box (length / time): under shear with the flow
    /// there, elsewhere that of [`Self::velocity`].
    #[inline]
    pub fn velocity_at(&self, place: DVec2) -> DVec2 {
        let [rate, middle] = self.flow;
        if rate == 0.0 {
            return self.velocity;
        }
        self.velocity + DVec2::new(rate * (place.y - middle), 0.0)
    }

    /// Thermal energy of these bodies, which must be from the view from which the frame is taken;
    /// fixed bodies do not count. A piston has one degree of freedom, in the frame of the box.
    pub fn thermal<'a>(&self, bodies: impl IntoIterator<Item = BodyView<'a>>) -> ThermalEnergy {
        let mut thermal = ThermalEnergy::default();
        let (mut mass_of_group, mut turning, mut pistons) = (0.0, 0, 0);
        for BodyView { body, motion, .. } in bodies.into_iter().filter(|view| !view.body.is_fixed())
        {
            let at_rest = Motion {
                velocity: DVec2::ZERO,
                ..motion
            };
            if body.is_piston() {
                thermal.translation += kinetic_energy(&motion, body.inertia());
                pistons += 1;
                continue;
            }
            let relative = motion.velocity - self.velocity_at(motion.position);
            thermal.bodies += 1;
            thermal.translation += 0.5 * mass_times(body, relative).dot(relative);
            if body.can_turn() {
                thermal.rotation += kinetic_energy(&at_rest, body.inertia());
                turning += 1;
            }
            mass_of_group += mass(body);
        }
        thermal.degrees_of_freedom = f64::from(pistons);
        if thermal.bodies > 0 {
            let components = f64::from(self.conserved.bitmask().count_ones());
            let share_of_mass = mass_of_group / self.mass;
            thermal.degrees_of_freedom +=
                (2 * thermal.bodies + turning) as f64 - components * share_of_mass;
        }
        thermal
    }
}

impl ThermalEnergy {
    /// Translation and rotation together (mass × length² / time²).
    pub fn energy(&self) -> f64 {
        self.translation + self.rotation
    }

    /// kT, twice the energy over the degrees of freedom (mass × length² / time²); `None` without
    /// degrees of freedom, as for a single disc with conserved momentum.
    pub fn temperature(&self) -> Option<f64> {
        (self.degrees_of_freedom > 0.0).then(|| 2.0 * self.energy() / self.degrees_of_freedom)
    }
}

impl View<'_> {
    /// The frame relative to which velocities are thermal.
    pub fn centre_of_mass_frame(&self) -> CentreOfMassFrame {
        CentreOfMassFrame::new(self.world, self.offset)
    }

    /// kT of all bodies (mass × length² / time²), relative to the centre of mass along axes with
    /// conserved momentum; `None` if no body can have a thermal motion.
    ///
    /// All bodies count as one system. Where k ≥ 2 parallel walls across the whole box divide it
    /// into k rooms, the drift of the rooms relative to each other along the walls counts as
    /// thermal, and there are k − 1 degrees of freedom too many. The error is of the order of k
    /// over the number of bodies if the momentum of each room is 0; a simulation of each room alone
    /// avoids it.
    pub fn temperature(&self) -> Option<f64> {
        self.centre_of_mass_frame()
            .thermal(self.bodies())
            .temperature()
    }
}

/// The axes along which no fixed body and no piston can change the momentum of the molecules.
pub(crate) fn conserved_momentum(world: &World) -> BVec2 {
    let fixed = world
        .bodies
        .iter()
        .zip(&world.motions)
        .filter(|(body, _)| !body.is_free());
    fixed.fold(BVec2::TRUE, |conserved, (body, motion)| {
        conserved & !broken_by(body, motion)
    })
}

/// The axes along which a contact with a fixed body changes momentum.
fn broken_by(fixed: &Body, motion: &Motion) -> BVec2 {
    // A wall without end points crosses the whole box, and all its normals are parallel.
    // One that has a temperature gives momentum along it, too.
    if fixed.wall_temperature().is_some() {
        return BVec2::TRUE;
    }
    match fixed
        .molecule()
        .wall_edge()
        .filter(|edge| fixed.molecule().atoms().is_empty() && edge.bend().is_none())
    {
        Some(edge) => motion
            .orientation
            .cos_sin()
            .rotate(edge.normal())
            .cmpne(DVec2::ZERO),
        None => BVec2::TRUE,
    }
}

fn mass(body: &Body) -> f64 {
    1.0 / body.inertia().inverse_mass
}

fn mass_times(body: &Body, velocity: DVec2) -> DVec2 {
    velocity / body.inertia().inverse_mass
}
