//! Every contact between bodies of two tags: place, normal, impulse and relative velocity.

use carom_engine::{Body, CollisionReport, Observer, View};
use carom_geometry::PeriodicBox;
use carom_kinematics::Motion;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::TagFilter;

/// One contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LoggedContact {
    /// Time of the contact.
    pub time: f64,
    /// Numbers of the bodies, [`Body::id`]: the one inserted earlier first.
    pub bodies: [u64; 2],
    /// Indices of the atoms that touch; `None` in the model of bounding circles, and for an edge or
    /// a wall touched between its ends.
    pub atoms: [Option<u32>; 2],
    /// Indices of the straight edges that are touched between their ends; 0 for a wall.
    pub edges: [Option<u32>; 2],
    /// The point of contact, in the box (length).
    pub point: DVec2,
    /// Unit vector from the first body to the second.
    pub normal: DVec2,
    /// Impulse on the second body (mass × length / time).
    pub impulse: DVec2,
    /// Velocity of the second body relative to the first at the point of contact, before the
    /// contact and with rotation (length / time). Its component along the normal is negative.
    pub relative_velocity: DVec2,
    /// Coefficient of restitution of the contact.
    pub elasticity: f64,
}

/// Records contacts until they are [taken](Self::take).
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{ContactLog, TagFilter};
///
/// // A disc at rest, hit from the left.
/// let scene = Scene::from_toml(r#"
///     [[molecule]]
///     atoms = [{ at = [0, 0], radius = 0.05, mass = 1 }]
///     at = [0.5, 0.5]
///     [[molecule]]
///     atoms = [{ at = [0, 0], radius = 0.05, mass = 1 }]
///     at = [0.2, 0.5]
///     velocity = [1.0, 0.0]
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut log = ContactLog::new(TagFilter::Any);
/// log.start(&simulation.view());
/// simulation.observe_until(0.3, &mut log)?;
/// let contacts = log.take();
/// assert_eq!(contacts.len(), 1);
/// // The first body is on the right.
/// assert!((contacts[0].point.x - 0.45).abs() < 1e-12 && contacts[0].normal.x == -1.0);
/// assert!((contacts[0].relative_velocity.x - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[doc(alias = "events")]
pub struct ContactLog {
    filter: TagFilter,
    /// `None` before `start`: nothing is recorded.
    bounds: Option<PeriodicBox>,
    contacts: Vec<LoggedContact>,
}

impl ContactLog {
    /// An empty log of the contacts whose tags pass the filter.
    pub fn new(filter: TagFilter) -> Self {
        Self {
            filter,
            bounds: None,
            contacts: Vec::new(),
        }
    }

    /// Removes and returns the contacts recorded since the last call.
    pub fn take(&mut self) -> Vec<LoggedContact> {
        std::mem::take(&mut self.contacts)
    }
}

impl Observer for ContactLog {
    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.filter.matches(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        self.bounds = Some(view.bounds());
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        let bodies = report.sides.each_ref().map(|side| side.body);
        // Surfaces do not touch at a step of a well.
        let counts = self.filter.matches(bodies) && !report.is_step;
        let Some(bounds) = self.bounds.filter(|_| counts) else {
            return;
        };
        let [first, second] = &report.sides;
        // The first body's image is the reference of the point; the second is shifted to it.
        let at_point = |motion: &Motion, centre: DVec2| {
            motion.velocity + motion.angular_velocity * (report.point - centre).perp()
        };
        let centre = first.before.position;
        let [a, b] = [
            at_point(&first.before, centre),
            at_point(&second.before, centre + report.separation()),
        ];
        self.contacts.push(LoggedContact {
            time: report.time.to_f64(),
            bodies: bodies.map(Body::id),
            atoms: [first.atom, second.atom],
            edges: [first.edge, second.edge],
            point: bounds.wrap(report.point).0,
            normal: report.normal,
            impulse: report.impulse,
            relative_velocity: b - a,
            elasticity: report.elasticity.coefficient(),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_engine::{Scene, Simulation};

    /// Impulse, approach speed and elasticity of each contact obey Newton's law of restitution:
    /// J·n = −(1 + e) μ v·n, with μ = 1/2 for discs of mass 1.
    #[test]
    fn contacts_of_two_tags_obey_the_law_of_restitution() {
        let scene = Scene::from_toml(
            r#"
            [box]
            seed = 3
            [elasticity]
            default = 0.9
            [[gas]]
            tags = ["one"]
            radius = 0.02
            mass = 1.0
            energy = 1.0
            count = 60
            [[gas]]
            tags = ["two"]
            radius = 0.02
            mass = 1.0
            energy = 1.0
            count = 60
        "#,
        )
        .unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        let tag = |name| simulation.find_tag(name).unwrap();
        let filters = [
            TagFilter::Any,
            TagFilter::Pair(tag("one"), tag("two")),
            TagFilter::Pair(tag("one"), tag("one")),
            TagFilter::Pair(tag("two"), tag("two")),
        ];
        let mut logs: Vec<ContactLog> = filters.map(ContactLog::new).into();
        logs.start(&simulation.view());
        simulation.observe_until(1.0, &mut logs).unwrap();
        let [all, mixed, one, two] = [0, 1, 2, 3].map(|log| logs[log].take());
        assert_eq!(all.len() as u64, simulation.view().counters().collisions);
        assert_eq!(all.len(), mixed.len() + one.len() + two.len());
        assert!(mixed.len() > 100 && one.len() > 50 && two.len() > 50);
        for contact in &all {
            let normal_speed = contact.relative_velocity.dot(contact.normal);
            let expected = -(1.0 + contact.elasticity) * 0.5 * normal_speed;
            assert!(normal_speed < 0.0, "{contact:?}");
            assert!(
                (contact.impulse.dot(contact.normal) / expected - 1.0).abs() < 1e-9,
                "{contact:?}"
            );
            assert!((0.0..1.0).contains(&contact.point.x) && (0.0..1.0).contains(&contact.point.y));
        }
        // Ids of the second gas follow those of the first.
        assert!(
            mixed
                .iter()
                .all(|contact| contact.bodies[0] < 60 && contact.bodies[1] >= 60)
        );
    }
}
