//! The heat that bodies receive from walls with a temperature.
//!
//! At each contact with such a wall a body receives ΔE = ½ m (v′² − v²) + ½ I (ω′² − ω²) (mass ×
//! length² / time²), of which the work of a wall that moves is no heat. The sum over all walls is
//! the heat of the ledger.

use carom_engine::{Body, CollisionReport, Observer, View};
use carom_kinematics::{EpochTime, kinetic_energy};
use serde::{Deserialize, Serialize};

use crate::{Group, wall_work::work_of_wall};

/// Heat received from the walls of a group that have a temperature, and the contacts with them.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Group, WallHeat};
///
/// let scene = Scene::from_toml(r#"
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
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// let hot = simulation.find_tag("hot").expect("the scene names it");
/// let mut heat = (WallHeat::new(Group::All), WallHeat::new(hot.into()));
/// simulation.observe_until(20.0, &mut heat)?;
/// // The hot wall heats the gas, and the other takes most of that away.
/// assert!(heat.1.heat() > 10.0 * heat.0.heat().abs());
/// assert!((heat.0.heat() - simulation.view().ledger().heat).abs() < 1e-10 * heat.1.heat());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "thermostat")]
#[doc(alias = "heat flux")]
pub struct WallHeat {
    group: Group,
    heat: f64,
    contacts: u64,
    start: Option<EpochTime>,
    duration: f64,
    series: Vec<WallHeatPoint>,
}

/// Totals since the start, at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WallHeatPoint {
    /// Time of the sample.
    pub time: f64,
    /// Heat received since the start (mass × length² / time²).
    pub heat: f64,
    /// Contacts since the start.
    pub contacts: u64,
}

impl WallHeat {
    /// The walls of this group; its other bodies have no effect.
    pub fn new(group: Group) -> Self {
        Self {
            group,
            heat: 0.0,
            contacts: 0,
            start: None,
            duration: 0.0,
            series: Vec::new(),
        }
    }

    /// Heat received so far (mass × length² / time²); negative if the walls have cooled the gas.
    pub fn heat(&self) -> f64 {
        self.heat
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
    pub fn series(&self) -> &[WallHeatPoint] {
        &self.series
    }

    fn is_wall(&self, body: &Body) -> bool {
        body.wall_temperature().is_some() && self.group.contains(body)
    }
}

impl Observer for WallHeat {
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
        let side = &report.sides[1 - wall];
        let inertia = side.body.inertia();
        let gained = kinetic_energy(&side.after, inertia) - kinetic_energy(&side.before, inertia);
        self.heat += gained - work_of_wall(report, wall);
        self.contacts += 1;
    }

    fn sample(&mut self, view: &View<'_>) {
        let start = *self.start.get_or_insert(view.time());
        self.duration = view.time().since(start);
        self.series.push(WallHeatPoint {
            time: view.time().to_f64(),
            heat: self.heat,
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
        assert!((heat.heat() - simulation.view().ledger().heat).abs() < 1e-12);
        assert!(heat.contacts() > 20);
    }
}
