//! Translational and rotational temperature of a group of bodies (mass × length² / time²).
//!
//! kT_t = 2 Σ ½ m |v − V|² / Σ (2 − c m/M) over the moving bodies of the group, with V the velocity
//! of the frame of the centre of mass of all bodies, M their mass and c the number of conserved
//! components of momentum (see [`CentreOfMassFrame`](carom_engine::CentreOfMassFrame)); kT_r = 2 Σ
//! ½ I ω² / (number of bodies that turn). At equilibrium the mean of both is kT for each group, at
//! given energy and momentum exactly that of [`View::temperature`] (equipartition). They differ if
//! elasticities below 1 take energy from one of them.

use carom_engine::{Observer, View};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::Group;

/// Temperatures of a group at each sample.
///
/// The frame is that of all bodies, which moves with their centre of mass along each axis on which
/// momentum is conserved: a drift of the group relative to it counts as thermal.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::TemperatureByTag;
///
/// let scene = Scene::from_toml(r#"
///     [[gas]]
///     tags = ["hot"]
///     radius = 0.01
///     mass = 1.0
///     energy = 3.0
///     count = 100
///     [[gas]]
///     radius = 0.01
///     mass = 1.0
///     energy = 1.0
///     count = 100
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// let hot = simulation.find_tag("hot").expect("the scene names it");
/// let mut temperature = TemperatureByTag::new(hot.into());
/// temperature.sample(&simulation.view());
/// simulation.observe_until(5.0, &mut temperature)?;
/// temperature.sample(&simulation.view());
/// // 3 per disc at first, relative to the centre of mass; then it is shared: 2 per disc.
/// let points = temperature.series().iter();
/// let found: Vec<f64> = points.filter_map(|point| point.translation).collect();
/// assert!((found[0] - 3.0 / (1.0 - 1.0 / 200.0)).abs() < 1e-12);
/// assert!((found[1] - 2.0).abs() < 0.6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct TemperatureByTag {
    group: Group,
    series: Vec<TemperaturePoint>,
    /// Twice the energy and the degrees of freedom over all samples: translation, rotation.
    sums: [[f64; 2]; 2],
    /// Momentum in that frame over all samples, and the mass that has it.
    momentum: DVec2,
    mass: f64,
    /// Whether, at every sample, momentum was conserved along x and y and no other body had any:
    /// the
    /// velocity of the group's centre of mass is then 0 by the choice of the frame.
    rests: [bool; 2],
}

/// The temperatures at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TemperaturePoint {
    /// Time of the sample.
    pub time: f64,
    /// The number of bodies in the group that can move.
    pub bodies: usize,
    /// kT of the translation (mass × length² / time²); `None` without degrees of freedom.
    pub translation: Option<f64>,
    /// kT of the rotation (mass × length² / time²); `None` if no body of the group can turn.
    pub rotation: Option<f64>,
}

impl TemperatureByTag {
    /// Temperatures of a group.
    pub fn new(group: Group) -> Self {
        Self {
            group,
            rests: [true; 2],
            ..Self::default()
        }
    }

    /// The samples so far.
    pub fn series(&self) -> &[TemperaturePoint] {
        &self.series
    }

    /// [Σx, Σw] of the translation and of the rotation over all samples so far: x is twice the
    /// energy (mass × length² / time²), and w the number of degrees of freedom.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        self.sums.to_vec()
    }

    /// [Σx, Σw] of the velocity of the group's centre of mass along both axes over all samples so
    /// far: x is its momentum relative to the [frame](carom_engine::CentreOfMassFrame) of all
    /// bodies
    /// (mass × length / time), and w its mass.
    pub fn flow(&self) -> [[f64; 2]; 2] {
        self.momentum
            .to_array()
            .map(|momentum| [momentum, self.mass])
    }

    /// Whether the flow along x and along y is 0 by definition, because the group has all the
    /// momentum, and its frame moves with its centre of mass: what [`Self::flow`] has is rounding.
    pub fn flow_is_zero(&self) -> [bool; 2] {
        self.rests
    }
}

impl Observer for TemperatureByTag {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let members = || view.bodies().filter(|view| self.group.contains(view.body));
        let frame = view.centre_of_mass_frame();
        let thermal = frame.thermal(members());
        let turning = members().filter(|view| view.body.can_turn()).count() as f64;
        for member in members().filter(|view| view.body.is_free()) {
            let mass = member.body.molecule().mass();
            self.momentum +=
                mass * (member.motion.velocity - frame.velocity_at(member.motion.position));
            self.mass += mass;
        }
        let others = || view.bodies().filter(|view| !self.group.contains(view.body));
        let has_all = others().all(|other| !other.body.is_free());
        for (rests, conserved) in self.rests.iter_mut().zip(frame.conserves_momentum()) {
            *rests &= conserved && has_all;
        }
        let now = [
            [
                2.0 * thermal.translation,
                thermal.degrees_of_freedom - turning,
            ],
            [2.0 * thermal.rotation, turning],
        ];
        let [translation, rotation] =
            now.map(|[energy, freedom]| (freedom > 0.0).then(|| energy / freedom));
        for (sum, term) in self.sums.iter_mut().zip(now) {
            *sum = [sum[0] + term[0], sum[1] + term[1]];
        }
        let time = view.time().to_f64();
        self.series.push(TemperaturePoint {
            time,
            bodies: thermal.bodies,
            translation,
            rotation,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_engine::{Scene, Simulation};

    #[test]
    fn temperatures_by_hand() {
        // A disc and a dumbbell of mass 2 each; the wall fixes the frame along x.
        let scene = r#"
            [[wall]]
            x = 0.0
            [[molecule]]
            tags = ["disc"]
            atoms = [{ at = [0, 0], radius = 0.1, mass = 2 }]
            at = [0.3, 0.2]
            velocity = [1.0, 5.0]
            [[molecule]]
            tags = ["dumbbell"]
            shape = "dumbbell"
            atom_radius = 0.1
            atom_mass = 1.0
            at = [0.5, 0.7]
            velocity = [0.0, 1.0]
            angular_velocity = 4.0
        "#;
        let simulation = Simulation::new(&Scene::from_toml(scene).unwrap()).unwrap();
        let mut all = TemperatureByTag::new(Group::All);
        all.sample(&simulation.view());
        // Along x the frame is that of the box; along y it moves with the centre of mass.
        assert_eq!(all.flow(), [[2.0, 4.0], [0.0, 4.0]]);
        assert_eq!(all.flow_is_zero(), [false, true]);
        let found = |group: Group| {
            let mut temperature = TemperatureByTag::new(group);
            temperature.sample(&simulation.view());
            (temperature.series()[0], temperature.sums())
        };
        let tagged = |name| Group::Tagged(simulation.find_tag(name).unwrap());
        let mut of_disc = TemperatureByTag::new(tagged("disc"));
        of_disc.sample(&simulation.view());
        assert_eq!(
            (of_disc.flow(), of_disc.flow_is_zero()),
            ([[2.0, 2.0], [4.0, 2.0]], [false; 2])
        );
        // V = (0, 3): relative velocities (1, 2) and (0, −2); 2 − 1/2 degrees of freedom each.
        let (disc, _) = found(tagged("disc"));
        assert_eq!(
            (disc.bodies, disc.translation, disc.rotation),
            (1, Some(10.0 / 1.5), None)
        );
        let rotor = simulation
            .view()
            .tagged(simulation.find_tag("dumbbell").unwrap())
            .next()
            .unwrap();
        let moment = 1.0 / rotor.body.inertia().inverse_moment;
        let (dumbbell, sums) = found(tagged("dumbbell"));
        assert!((dumbbell.translation.unwrap() - 8.0 / 1.5).abs() < 1e-13);
        assert!((dumbbell.rotation.unwrap() - 16.0 * moment).abs() < 1e-13);
        assert!((sums[1][0] - 16.0 * moment).abs() < 1e-13 && sums[1][1] == 1.0);
        let (all, sums) = found(Group::All);
        assert_eq!((all.bodies, sums[0][1]), (2, 3.0));
        assert!((all.translation.unwrap() - 18.0 / 3.0).abs() < 1e-13);
        // The engine's temperature is the mean, weighted with the degrees of freedom.
        let together = (sums[0][0] + sums[1][0]) / (sums[0][1] + sums[1][1]);
        assert!((together / simulation.view().temperature().unwrap() - 1.0).abs() < 1e-13);
    }

    #[test]
    fn equipartition_of_a_mixture() {
        let scene = r#"
            [[gas]]
            tags = ["heavy"]
            shape = "dumbbell"
            atom_radius = 0.01
            atom_mass = 5.0
            energy = 2.0
            count = 40
            [[gas]]
            tags = ["light"]
            radius = 0.01
            mass = 1.0
            energy = 1.0
            count = 40
        "#;
        let mut simulation = Simulation::new(&Scene::from_toml(scene).unwrap()).unwrap();
        simulation.run_until(20.0).unwrap();
        let groups =
            ["heavy", "light"].map(|name| Group::Tagged(simulation.find_tag(name).unwrap()));
        let mut both = (
            TemperatureByTag::new(groups[0]),
            TemperatureByTag::new(groups[1]),
        );
        let mut blocks = [Vec::new(), Vec::new(), Vec::new()];
        for block in 1..=30 {
            let before = [both.0.sums()[0], both.0.sums()[1], both.1.sums()[0]];
            for sample in 1..=5 {
                simulation
                    .run_until(20.0 + f64::from(block) * 2.5 + 0.5 * f64::from(sample))
                    .unwrap();
                both.sample(&simulation.view());
            }
            let after = [both.0.sums()[0], both.0.sums()[1], both.1.sums()[0]];
            for ((series, after), before) in blocks.iter_mut().zip(after).zip(before) {
                series.push((after[0] - before[0], after[1] - before[1]));
            }
        }
        // E = 120; 158 translations and 40 rotations.
        let kt = 2.0 * 120.0 / 198.0;
        for series in blocks {
            let estimate = crate::Estimate::of_ratio(series).unwrap();
            assert!(
                (estimate.mean - kt).abs() < 5.0 * estimate.standard_error,
                "{estimate:?} {kt}"
            );
            assert!(estimate.standard_error < 0.05 * kt);
        }
    }
}
