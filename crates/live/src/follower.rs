//! The impulses on one body, and where it was at each: its path between contacts is straight.

use std::collections::VecDeque;

use carom::{BodyKey, CollisionReport, EpochTime, Observer, View, engine::Body};
use glam::DVec2;

/// Largest number of corners that are kept: impulses, and changes of the velocity by edits and
/// thermostats. A thermostat that acts more often than the body has contacts leaves fewer impulses.
const MAX_CORNERS: usize = 200;

/// One contact of the body.
#[derive(Debug, Clone, Copy)]
struct Corner {
    time: EpochTime,
    /// Place relative to that at the first corner, across the borders of the box (length).
    place: DVec2,
    velocity: DVec2,
    /// Impulse on the body (mass × length / time); 0 where the record begins, and where an edit or
    /// a thermostat has changed the velocity.
    impulse: DVec2,
}

/// Records the impulses on one body, or nothing.
#[derive(Debug, Clone, Default)]
pub struct Follower {
    key: Option<BodyKey>,
    corners: VecDeque<Corner>,
}

/// A contact, as a page draws it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kick {
    /// Time since the contact.
    pub age: f64,
    /// Place of the body at the contact, relative to its present place along its path (length).
    pub place: DVec2,
    /// Impulse on the body (mass × length / time).
    pub impulse: DVec2,
}

impl Follower {
    /// Records the impulses on this body from now on.
    pub fn choose(&mut self, key: Option<BodyKey>, view: &View<'_>) {
        self.key = key;
        self.restart(view);
    }

    /// Forgets the impulses so far: the state of the run has been replaced.
    pub fn restart(&mut self, view: &View<'_>) {
        self.corners.clear();
        self.start(view);
    }

    /// Adds a corner at the present place.
    fn turn(&mut self, time: EpochTime, velocity: DVec2, impulse: DVec2) {
        let last = self.corners.back();
        let place = last.map_or(DVec2::ZERO, |last| {
            last.place + last.velocity * time.since(last.time)
        });
        if self.corners.len() >= MAX_CORNERS {
            self.corners.pop_front();
        }
        self.corners.push_back(Corner {
            time,
            place,
            velocity,
            impulse,
        });
    }

    /// The body, if one is chosen.
    pub fn chosen(&self) -> Option<BodyKey> {
        self.key
    }

    /// The contacts so far, the last first; the path goes through them. The oldest entry is where
    /// the record begins.
    pub fn kicks(&self, now: EpochTime) -> Vec<Kick> {
        let Some(last) = self.corners.back() else {
            return Vec::new();
        };
        let present = last.place + last.velocity * now.since(last.time);
        let kick = |corner: &Corner| Kick {
            age: now.since(corner.time),
            place: corner.place - present,
            impulse: corner.impulse,
        };
        self.corners.iter().rev().map(kick).collect()
    }
}

impl Observer for Follower {
    fn watches_any(&self) -> bool {
        self.key.is_some()
    }

    fn watches(&self, bodies: [&Body; 2]) -> bool {
        bodies.iter().any(|body| Some(body.key()) == self.key)
    }

    /// An edit or a thermostat may have changed the velocity: the path has a corner here.
    fn start(&mut self, view: &View<'_>) {
        let Some(body) = self.key.and_then(|key| view.body(key)) else {
            self.key = None;
            self.corners.clear();
            return;
        };
        if self
            .corners
            .back()
            .is_none_or(|last| last.velocity != body.motion.velocity)
        {
            self.turn(view.time(), body.motion.velocity, DVec2::ZERO);
        }
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        let Some((side, impulse)) = self.key.and_then(|key| report.side_of(key)) else {
            return;
        };
        self.turn(report.time, side.after.velocity, impulse);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{Scene, Simulation};

    #[test]
    fn the_path_leads_through_the_corners_across_the_borders() {
        // A disc between two bumpers, along x through the border of the box.
        let scene = Scene::from_toml(
            "[[molecule]]\nshape = \"disc\"\natom_radius = 0.05\natom_mass = 2.0\nat = [0.9, 0.5]\nvelocity = [1.0, 0.0]\n\
             [[bumper]]\nradius = 0.1\nat = [0.3, 0.5]\n[[bumper]]\nradius = 0.1\nat = [0.7, 0.5]\n",
        )
        .unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        let mut follower = Follower::default();
        follower.choose(Some(BodyKey::of_id(0)), &simulation.view());
        // To 1.15, back to 0.85, and on to 0.9.
        simulation
            .observe_until(0.25 + 0.3 + 0.05, &mut follower)
            .unwrap();
        let kicks = follower.kicks(simulation.view().time());
        let near = |one: DVec2, x: f64| (one - DVec2::new(x, 0.0)).length() < 1e-12;
        assert_eq!(kicks.len(), 3);
        assert!(
            near(kicks[0].place, -0.05)
                && near(kicks[0].impulse, 4.0)
                && (kicks[0].age - 0.05).abs() < 1e-12
        );
        assert!(near(kicks[1].place, 0.25) && near(kicks[1].impulse, -4.0));
        assert!(near(kicks[2].place, 0.0) && kicks[2].impulse == DVec2::ZERO);
        // A thermostat changes the velocity; the impulses before remain.
        simulation.reset_energy(BodyKey::of_id(0), 4.0).unwrap();
        follower.start(&simulation.view());
        follower.start(&simulation.view());
        simulation.observe_until(0.65, &mut follower).unwrap();
        let kicks = follower.kicks(simulation.view().time());
        assert_eq!(kicks.len(), 4);
        assert!(near(kicks[0].place, -0.1) && kicks[0].impulse == DVec2::ZERO);
        assert!(near(kicks[1].place, -0.15) && near(kicks[1].impulse, 4.0));
        follower.restart(&simulation.view());
        assert_eq!(follower.kicks(simulation.view().time()).len(), 1);
    }
}
