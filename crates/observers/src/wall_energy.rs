//! The energy that bodies receive from walls: heat from walls with a temperature, and work of walls
//! that move.
//!
//! At each contact with a wall a body receives ΔE = ½ m (v′² − v²) + ½ I (ω′² − ω²) (mass × length²
//! / time²). The work of a wall that moves is J · w, with the impulse J on the body and the
//! velocity w of the surface at the point of contact; a wall at rest does none. The rest of ΔE is
//! the heat of a wall with a temperature. The sums over all walls are the heat and the work of the
//! ledger.

use std::{fmt::Debug, marker::PhantomData};

use carom_engine::{Body, CollisionReport, Observer, Side, View};
use carom_kinematics::EpochTime;
use serde::{Deserialize, Serialize};

use crate::Group;

/// Heat received from the walls of a group that have a temperature, and the contacts with them.
///
/// ```
/// use carom_engine::{Scene, Simulation};
/// use carom_observers::{Group, WallHeat};
///
/// let mut simulation = Simulation::new(&Scene::from_toml(r#"
///     [[wall]]
///     tags = ["hot"]
///     x = 0.0
///     temperature = 2.0
///     [[wall]]
///     x = 0.5
///     temperature = 1.0
///     [[gas]]
///     radius = 0.01
///     mass = 1.0
///     temperature = 1.0
///     count = 50
/// "#)?)?;
/// let hot = simulation.find_tag("hot").expect("the scene names it");
/// let mut heat = (WallHeat::new(Group::All), WallHeat::new(hot.into()));
/// simulation.observe_until(20.0, &mut heat)?;
/// // The hot wall heats the gas, and the other takes most of that away.
/// assert!(heat.1.energy() > 10.0 * heat.0.energy().abs());
/// let booked = simulation.view().ledger().heat;
/// assert!((heat.0.energy() - booked).abs() < 1e-10 * heat.1.energy());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias = "thermostat")]
#[doc(alias = "heat flux")]
pub type WallHeat = WallEnergy<HeatFromWalls>;

/// Work of the walls of a group, and the contacts with them, those with walls at rest too.
///
/// ```
/// use carom_engine::{Scene, Simulation};
/// use carom_observers::WallWork;
///
/// let mut simulation = Simulation::new(&Scene::from_toml(r#"
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
///     count = 100
///     region.x = [0.0, 0.9]
/// "#)?)?;
/// let piston = simulation.find_tag("piston").expect("the scene names it");
/// let before = simulation.view().energy();
/// let mut work = WallWork::new(piston.into());
/// simulation.observe_until(2.0, &mut work)?;
/// assert!(work.energy() > 0.0);
/// assert!((work.energy() - (simulation.view().energy() - before)).abs() < 1e-11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias = "piston")]
pub type WallWork = WallEnergy<WorkOfWalls>;

/// An energy that bodies receive at contacts with walls.
pub trait FromWalls: Debug + Clone {
    /// Whether a wall can give such an energy.
    fn is_given_by(wall: &Body) -> bool;

    /// The energy that a body, one side of a contact, receives from the wall at the other (mass ×
    /// length² / time²).
    fn received(report: &CollisionReport<'_>, body: &Side<'_>) -> f64;
}

/// Heat from walls with a temperature.
#[derive(Debug, Clone)]
pub struct HeatFromWalls;

/// Work of walls.
#[derive(Debug, Clone)]
pub struct WorkOfWalls;

/// The energy of one kind that bodies receive from the walls of a group, and the contacts with
/// them: [`WallHeat`] or [`WallWork`].
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct WallEnergy<K> {
    group: Group,
    energy: f64,
    contacts: u64,
    start: Option<EpochTime>,
    duration: f64,
    series: Vec<WallEnergyPoint>,
    #[serde(skip)]
    kind: PhantomData<K>,
}

/// Totals since the start, at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WallEnergyPoint {
    /// Time of the sample.
    pub time: f64,
    /// Energy received since the start (mass × length² / time²).
    pub energy: f64,
    /// Contacts since the start.
    pub contacts: u64,
}

impl FromWalls for HeatFromWalls {
    fn is_given_by(wall: &Body) -> bool {
        wall.wall_temperature().is_some()
    }

    fn received(report: &CollisionReport<'_>, body: &Side<'_>) -> f64 {
        body.energy_change() - report.work
    }
}

impl FromWalls for WorkOfWalls {
    fn is_given_by(wall: &Body) -> bool {
        wall.is_wall()
    }

    fn received(report: &CollisionReport<'_>, _: &Side<'_>) -> f64 {
        report.work
    }
}

impl<K: FromWalls> WallEnergy<K> {
    /// The walls of this group; its other bodies have no effect.
    pub fn new(group: Group) -> Self {
        Self {
            group,
            energy: 0.0,
            contacts: 0,
            start: None,
            duration: 0.0,
            series: Vec::new(),
            kind: PhantomData,
        }
    }

    /// Energy received so far (mass × length² / time²); negative if the walls have taken energy.
    pub fn energy(&self) -> f64 {
        self.energy
    }

    /// Contacts so far.
    pub fn contacts(&self) -> u64 {
        self.contacts
    }

    /// Time from the start to the last sample.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// The totals at each sample.
    pub fn series(&self) -> &[WallEnergyPoint] {
        &self.series
    }

    fn is_wall(&self, body: &Body) -> bool {
        K::is_given_by(body) && self.group.contains(body)
    }
}

impl<K: FromWalls> Observer for WallEnergy<K> {
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
        self.energy += K::received(report, &report.sides[1 - wall]);
        self.contacts += 1;
    }

    fn sample(&mut self, view: &View<'_>) {
        let start = *self.start.get_or_insert(view.time());
        self.duration = view.time().since(start);
        self.series.push(WallEnergyPoint {
            time: view.time().to_f64(),
            energy: self.energy,
            contacts: self.contacts,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_engine::{Scene, Simulation};

    #[test]
    fn an_edit_restarts_neither_heat_nor_time() {
        let scene = Scene::from_toml(
            "[[wall]]\nx = 0.0\ntemperature = 2.0\n[[gas]]\nradius = 0.01\nmass = 1.0\ntemperature = 1.0\ncount = 20",
        )
        .unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        let mut heat = WallHeat::new(Group::All);
        heat.start(&simulation.view());
        for time in [1.0, 2.0] {
            simulation.observe_until(time, &mut heat).unwrap();
            simulation
                .edit(|batch| batch.reset_energy_of_all(1.0))
                .unwrap();
            heat.start(&simulation.view());
            heat.sample(&simulation.view());
        }
        assert_eq!(heat.duration(), 2.0);
        assert!((heat.energy() - simulation.view().ledger().heat).abs() < 1e-12);
        assert!(heat.contacts() > 20);
    }
}
