//! The work of walls that move on the bodies that touch them.
//!
//! At each contact with a wall a body receives the impulse J from it, and the wall does the work
//! J · w (mass × length² / time²), with the velocity w of its surface at the point of contact. A
//! wall at rest does none. The sum over all walls is the work of the ledger.

use carom_engine::{Body, CollisionReport, Observer, View};
use carom_kinematics::EpochTime;
use serde::{Deserialize, Serialize};

use crate::Group;

/// Work of the walls of a group, and the contacts with them.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Group, WallWork};
///
/// let scene = Scene::from_toml(r#"
///     [[wall]]
///     x = 0.0
///     [[wall]]
///     tags = ["piston"]
///     x = 0.9
///     motion = { velocity = [-0.1, 0.0] }
///     [[gas]]
///     radius = 0.01
///     mass = 1.0
///     temperature = 1.0
///     count = 50
///     region.x = [0.0, 0.9]
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// let piston = simulation.find_tag("piston").expect("the scene names it");
/// let before = simulation.view().energy();
/// let mut work = WallWork::new(piston.into());
/// simulation.observe_until(2.0, &mut work)?;
/// assert!(work.work() > 0.0);
/// assert!((work.work() - (simulation.view().energy() - before)).abs() < 1e-11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "piston")]
pub struct WallWork {
    group: Group,
    work: f64,
    contacts: u64,
    start: Option<EpochTime>,
    duration: f64,
    series: Vec<WallWorkPoint>,
}

/// Totals since the start, at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WallWorkPoint {
    /// Time of the sample.
    pub time: f64,
    /// Work of the walls since the start (mass × length² / time²).
    pub work: f64,
    /// Contacts since the start.
    pub contacts: u64,
}

impl WallWork {
    /// The walls of this group; its other bodies have no effect.
    pub fn new(group: Group) -> Self {
        Self {
            group,
            work: 0.0,
            contacts: 0,
            start: None,
            duration: 0.0,
            series: Vec::new(),
        }
    }

    /// Work so far (mass × length² / time²); negative if the bodies have done work on the walls.
    pub fn work(&self) -> f64 {
        self.work
    }

    /// Contacts so far, with walls at rest too.
    pub fn contacts(&self) -> u64 {
        self.contacts
    }

    /// Time from the start to the last sample.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// The totals at each sample.
    pub fn series(&self) -> &[WallWorkPoint] {
        &self.series
    }

    fn is_wall(&self, body: &Body) -> bool {
        body.is_wall() && self.group.contains(body)
    }
}

/// The work of a wall, the side of this number, in a contact (mass × length² / time²); 0 for a wall
/// at rest.
pub(crate) fn work_of_wall(report: &CollisionReport<'_>, wall: usize) -> f64 {
    let side = &report.sides[wall];
    if side.before.is_at_rest() {
        return 0.0;
    }
    // The impulse of the report is that on the second body, and the normal points to it.
    let sign = if wall == 0 { 1.0 } else { -1.0 };
    let mut arm = side.arm;
    // An arm ends at the line of the wall, or on its surface if the contact is rough. The impulse
    // of a smooth contact is along the normal, where the two have one velocity.
    if side.body.wall_temperature().is_some() {
        arm += sign * side.body.reach() * report.normal;
    }
    sign * report.impulse.dot(side.before.velocity_of(arm))
}

impl Observer for WallWork {
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.is_wall(bodies[0]) | self.is_wall(bodies[1])
    }

    /// After an edit the sums continue.
    fn start(&mut self, view: &View<'_>) {
        self.start.get_or_insert(view.time());
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        let Some(wall) = report.sides.iter().position(|side| self.is_wall(side.body)) else {
            return;
        };
        self.work += work_of_wall(report, wall);
        self.contacts += 1;
    }

    fn sample(&mut self, view: &View<'_>) {
        let start = *self.start.get_or_insert(view.time());
        self.duration = view.time().since(start);
        self.series.push(WallWorkPoint {
            time: view.time().to_f64(),
            work: self.work,
            contacts: self.contacts,
        });
    }
}
