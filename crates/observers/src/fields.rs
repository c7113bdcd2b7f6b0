//! Fields: density, velocity, temperature, stress and heat current over the place.
//!
//! Sums over the samples in each bin, of the bodies whose centre is in it: their number n, Σ m,
//! Σ m v, Σ ω, and the thermal energy Σ ½ m |v − u|² about the mean velocity u = Σ m v / Σ m of the
//! bin at that sample. Its mean is (n − 1) kT, so that kT is found without bias also where few
//! bodies are in a bin; a bin that never has two bodies has no kT. The area fraction counts the
//! exact part of each disc in each bin, and other molecules as a whole at their centre.
//!
//! The stress is the flux of momentum (Irving & Kirkwood 1950): Σ m v_a v_b, the mean of its values
//! at both ends of each interval between samples, and Σ r_a J_b over all contacts, with r from the
//! first body's centre to that of the touched image of the second and J the impulse on the second,
//! divided among the bins that r crosses. Velocities are those in the frame of the centre of mass,
//! as in [`PressureTensor`](crate::PressureTensor): the mean over the box is the pressure tensor.
//! Where the gas flows with the velocity u, ρ u_a u_b of it belongs to the flow. A contact with a
//! wall counts from the centre to the point of contact, so that the components with r along the
//! wall are those of the arm.
//!
//! The heat current is Σ e v, with e the kinetic energy of a body and its rotation, and Σ r ΔE over
//! all contacts, with ΔE half the difference of what the second and the first body gain; from a
//! fixed body or a wall to a moving one it is all that this one gains.
//!
//! A group has its own momenta and energies, and half of each contact with a body that is not in
//! it: the fields of tags that divide all bodies add up to those of all.

use std::ops::{Add, Mul};

use carom_engine::{Body, CollisionReport, Observer, Side, View};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{
    FieldBins, Group,
    field_bins::{Carried, ContactPart},
    helfand::energy,
    open_interval::OpenInterval,
};

/// Momenta 11, 12, 21, 22 and energies 1, 2 that flow, see [`ContactPart`].
const FLUXES: usize = 6;

/// Fields of a group of bodies in bins.
///
/// Number density and area fraction count fixed bodies too, but no walls; the other fields are
/// those of moving bodies. The first interval begins at `start`, or at the first sample without
/// one. An edit within an interval divides it if it is announced by [`Observer::pause`]; the
/// interval begins anew if it is not.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{FieldBins, Fields, Group};
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 400")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let bins = FieldBins::grid(&simulation.view().bounds(), [4, 4])?;
/// let mut fields = Fields::new(Group::All, bins);
/// fields.start(&simulation.view());
/// for sample in 1..=20 {
///     simulation.observe_until(0.1 * f64::from(sample), &mut fields)?;
///     fields.sample(&simulation.view());
/// }
/// let mean = |[sum, weight]: [f64; 2]| sum / weight;
/// assert!((mean(fields.density(5)) / 400.0 - 1.0).abs() < 0.1);
/// assert!((mean(fields.temperature(5)) - 1.0).abs() < 0.2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "hydrodynamic fields")]
#[doc(alias = "coarse graining")]
#[doc(alias = "stress")]
#[doc(alias = "heat current")]
pub struct Fields {
    group: Group,
    bins: FieldBins,
    samples: u64,
    sums: Vec<BinSums>,
    interval: Option<Interval>,
    /// Time integrals of the fluxes over the closed intervals.
    fluxes: Vec<[f64; FLUXES]>,
    duration: f64,
}

/// Sums over the samples in one bin.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct BinSums {
    /// Number of centres, fixed bodies included.
    bodies: f64,
    covered: f64,
    mass: f64,
    momentum: DVec2,
    /// Σ ½ m |v − u|², and Σ (n − 1) over the samples with n ≥ 1 moving bodies.
    thermal: [f64; 2],
    /// Σ ω, and the number of bodies that turn.
    spin: [f64; 2],
}

/// The open interval between two samples.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Interval {
    /// Momenta and energies that the bodies carry.
    carried: OpenInterval<Fluxes>,
    /// What contacts have carried so far.
    contacts: Vec<[f64; FLUXES]>,
    /// Velocity of the frame of the centre of mass.
    drift: DVec2,
}

/// The fluxes in all bins.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Fluxes(Vec<[f64; FLUXES]>);

impl Add for Fluxes {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        self.0
            .iter_mut()
            .zip(&other.0)
            .for_each(|(sum, more)| add(sum, more));
        self
    }
}

impl Mul<f64> for Fluxes {
    type Output = Self;

    fn mul(mut self, factor: f64) -> Self {
        self.0.iter_mut().flatten().for_each(|flux| *flux *= factor);
        self
    }
}

fn add(sum: &mut [f64; FLUXES], more: &[f64; FLUXES]) {
    sum.iter_mut()
        .zip(more)
        .for_each(|(sum, more)| *sum += more);
}

impl Fields {
    /// The fields of a group in bins, which must be those of its box.
    pub fn new(group: Group, bins: FieldBins) -> Self {
        let count = bins.len();
        Self {
            group,
            bins,
            samples: 0,
            sums: vec![BinSums::default(); count],
            interval: None,
            fluxes: vec![[0.0; FLUXES]; count],
            duration: 0.0,
        }
    }

    /// The bins.
    pub fn bins(&self) -> &FieldBins {
        &self.bins
    }

    /// Number of samples so far.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Number of centres found in a bin, over all samples.
    pub fn count(&self, bin: usize) -> u64 {
        self.bin(bin).bodies as u64
    }

    /// [Σx, Σw] of the number density in a bin: centres, and samples times its area (length²).
    pub fn density(&self, bin: usize) -> [f64; 2] {
        [self.bin(bin).bodies, self.sampled_area(bin)]
    }

    /// [Σx, Σw] of the area fraction in a bin: covered area and samples times its area (length²).
    pub fn area_fraction(&self, bin: usize) -> [f64; 2] {
        [self.bin(bin).covered, self.sampled_area(bin)]
    }

    /// [Σx, Σw] of both components of the mean velocity in a bin: momentum (mass × length / time)
    /// and mass, so that the mean is that of the mass that flows.
    pub fn velocity(&self, bin: usize) -> [[f64; 2]; 2] {
        let sums = self.bin(bin);
        sums.momentum
            .to_array()
            .map(|momentum| [momentum, sums.mass])
    }

    /// [Σx, Σw] of kT about the mean velocity in a bin: thermal energy (mass × length² / time²) and
    /// half the degrees of freedom.
    pub fn temperature(&self, bin: usize) -> [f64; 2] {
        self.bin(bin).thermal
    }

    /// [Σx, Σw] of the mean angular velocity in a bin: Σ ω (radians / time), and the number of
    /// bodies that turn.
    pub fn spin(&self, bin: usize) -> [f64; 2] {
        self.bin(bin).spin
    }

    /// [Σx, Σw] of the stress components 11, 12, 21 and 22 in a bin: x is the flux of momentum
    /// times duration and area (mass × length² / time), w is duration times area (time × length²).
    /// Component ab is the flux along a of the momentum along b.
    pub fn stress(&self, bin: usize) -> [[f64; 2]; 4] {
        let (flux, weight) = (self.flux(bin), self.duration * self.bins.area(bin));
        [0, 1, 2, 3].map(|component| [flux[component], weight])
    }

    /// [Σx, Σw] of both components of the heat current in a bin: x is the current times duration
    /// and area (mass × length³ / time²), w is duration times area (time × length²).
    pub fn heat_current(&self, bin: usize) -> [[f64; 2]; 2] {
        let (flux, weight) = (self.flux(bin), self.duration * self.bins.area(bin));
        [4, 5].map(|component| [flux[component], weight])
    }

    fn bin(&self, bin: usize) -> BinSums {
        self.sums.get(bin).copied().unwrap_or_default()
    }

    fn flux(&self, bin: usize) -> [f64; FLUXES] {
        self.fluxes.get(bin).copied().unwrap_or_default()
    }

    fn sampled_area(&self, bin: usize) -> f64 {
        self.samples as f64 * self.bins.area(bin)
    }

    /// What the bodies carry along, in the frame of this velocity.
    fn carried(&self, view: &View<'_>, drift: DVec2) -> Fluxes {
        let mut fluxes = vec![[0.0; FLUXES]; self.bins.len()];
        for member in self
            .group
            .molecules(view)
            .filter(|member| member.body.is_free())
        {
            let place = member.motion.position;
            let Some(sum) = self.bins.bin(place).and_then(|bin| fluxes.get_mut(bin)) else {
                continue;
            };
            let velocity = self.bins.components(place, member.motion.velocity - drift);
            let momentum = velocity / member.body.inertia().inverse_mass;
            let energy = energy(member.body, &member.motion, drift);
            add(
                sum,
                &[
                    velocity.x * momentum.x,
                    velocity.x * momentum.y,
                    velocity.y * momentum.x,
                    velocity.y * momentum.y,
                    energy * velocity.x,
                    energy * velocity.y,
                ],
            );
        }
        Fluxes(fluxes)
    }

    fn open_interval(&mut self, view: &View<'_>, drift: DVec2, now: Fluxes) {
        self.interval = Some(Interval {
            carried: OpenInterval::new(view.time(), now),
            contacts: vec![[0.0; FLUXES]; self.bins.len()],
            drift,
        });
    }

    fn close_interval(&mut self, view: &View<'_>, now: &Fluxes) {
        let Some(interval) = self.interval.take() else {
            return;
        };
        let duration = interval.carried.duration(view.time());
        if duration <= 0.0 {
            return;
        }
        let Fluxes(mean) = interval.carried.mean(view.time(), now.clone()) * duration;
        for (sum, (carried, contacts)) in self
            .fluxes
            .iter_mut()
            .zip(mean.iter().zip(&interval.contacts))
        {
            add(sum, carried);
            add(sum, contacts);
        }
        self.duration += duration;
    }

    /// Density, velocity and temperature at a sample.
    fn count_bodies(&mut self, view: &View<'_>) {
        let mut now = vec![Moving::default(); self.bins.len()];
        for member in self.group.molecules(view) {
            let place = member.motion.position;
            let molecule = member.body.molecule();
            let bin = self.bins.bin(place);
            let sums = &mut self.sums;
            if molecule.is_disc() {
                self.bins
                    .cover(place, molecule.bounding_radius(), |bin, area| {
                        if let Some(sums) = sums.get_mut(bin) {
                            sums.covered += area;
                        }
                    });
            }
            let Some((bin, sums)) = bin.and_then(|bin| Some((bin, sums.get_mut(bin)?))) else {
                continue;
            };
            sums.bodies += 1.0;
            if !molecule.is_disc() {
                sums.covered += molecule.area();
            }
            if member.body.is_fixed() {
                continue;
            }
            if member.body.can_turn() {
                add_to(&mut sums.spin, member.motion.angular_velocity);
            }
            let mass = molecule.mass();
            let velocity = self.bins.components(place, member.motion.velocity);
            now[bin].count(mass, velocity);
        }
        for (sums, now) in self.sums.iter_mut().zip(now) {
            sums.mass += now.mass;
            sums.momentum += now.mass * now.mean;
            sums.thermal[0] += now.thermal;
            sums.thermal[1] += (now.bodies - 1.0).max(0.0);
        }
        self.samples += 1;
    }
}

fn add_to([sum, count]: &mut [f64; 2], value: f64) {
    *sum += value;
    *count += 1.0;
}

/// The moving bodies of a bin at one sample, with the running mean of their velocities (Welford,
/// Technometrics 4 (1962) 419), which loses no digits where the gas flows fast.
#[derive(Debug, Clone, Copy, Default)]
struct Moving {
    bodies: f64,
    mass: f64,
    mean: DVec2,
    thermal: f64,
}

impl Moving {
    fn count(&mut self, mass: f64, velocity: DVec2) {
        self.bodies += 1.0;
        self.mass += mass;
        let before = velocity - self.mean;
        self.mean += before * (mass / self.mass);
        self.thermal += 0.5 * mass * before.dot(velocity - self.mean);
    }
}

impl Observer for Fields {
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        bodies.into_iter().any(|body| self.group.contains(body))
    }

    fn start(&mut self, view: &View<'_>) {
        let drift = view.centre_of_mass_frame().velocity();
        let now = self.carried(view, drift);
        let continues = self.interval.as_mut().is_some_and(|interval| {
            interval.drift = drift;
            interval.carried.proceed(view.time(), now.clone())
        });
        if !continues {
            self.open_interval(view, drift, now);
        }
    }

    fn pause(&mut self, view: &View<'_>) {
        let drift = view.centre_of_mass_frame().velocity();
        let now = self.carried(view, drift);
        if let Some(interval) = &mut self.interval {
            interval.carried.pause(view.time(), now);
        }
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        let Some(interval) = &mut self.interval else {
            return;
        };
        let members = report
            .sides
            .iter()
            .filter(|side| self.group.contains(side.body));
        let share = members.map(|side| share(side, report)).sum::<f64>();
        let mut carried = carried_by(report, interval.drift);
        carried.momentum *= share;
        carried.energy *= share;
        self.bins.divide(&carried, |part| {
            let ContactPart {
                bin,
                momentum: [m11, m12, m21, m22],
                energy: [e1, e2],
            } = part;
            if let Some(sum) = interval.contacts.get_mut(bin) {
                add(sum, &[m11, m12, m21, m22, e1, e2]);
            }
        });
    }

    fn sample(&mut self, view: &View<'_>) {
        self.count_bodies(view);
        let drift = view.centre_of_mass_frame().velocity();
        let now = self.carried(view, drift);
        self.close_interval(view, &now);
        self.open_interval(view, drift, now);
    }
}

/// The share of a contact that belongs to one of its sides: all of a contact with a wall belongs to
/// the body that hits it.
fn share(side: &Side<'_>, report: &CollisionReport<'_>) -> f64 {
    let hits_wall = report.sides.iter().any(|side| side.body.is_wall());
    match (hits_wall, side.body.is_wall()) {
        (true, true) => 0.0,
        (true, false) => 1.0,
        (false, _) => 0.5,
    }
}

/// What a contact carries, and over which way.
fn carried_by(report: &CollisionReport<'_>, drift: DVec2) -> Carried {
    let [first, second] = &report.sides;
    let separation = report.separation();
    let from = first.before.position;
    let gain = |side: &Side<'_>| {
        energy(side.body, &side.after, drift) - energy(side.body, &side.before, drift)
    };
    let [gain_of_first, gain_of_second] = [gain(first), gain(second)];
    let half = if first.body.is_free() && second.body.is_free() {
        0.5
    } else {
        1.0
    };
    // From a centre to the point of contact; along the normal as far as the wall's own centre, so
    // that walls with a thickness count as in the pressure tensor.
    let reach =
        |arm: DVec2, separation: DVec2| arm + report.normal * report.normal.dot(separation - arm);
    let (from, way) = if second.body.is_wall() {
        (from, reach(report.point - from, separation))
    } else if first.body.is_wall() {
        let centre = from + separation;
        let way = reach(centre - report.point, separation);
        (centre - way, way)
    } else {
        (from, separation)
    };
    Carried {
        from,
        way,
        momentum: report.impulse,
        energy: half * (gain_of_second - gain_of_first),
    }
}

#[cfg(test)]
mod tests {
    use carom_engine::{Scene, Simulation};
    use carom_geometry::PeriodicBox;

    use super::*;
    use crate::{PressureTensor, WallHeat};

    fn bounds(simulation: &Simulation) -> PeriodicBox {
        simulation.view().bounds()
    }

    /// A run with samples at equal intervals, with an edit between two of them.
    fn observed(simulation: &mut Simulation, observer: &mut impl Observer, samples: u32) {
        observer.start(&simulation.view());
        for sample in 1..=samples {
            let until = 0.2 * f64::from(sample);
            simulation.observe_until(until - 0.05, observer).unwrap();
            observer.pause(&simulation.view());
            if let Some(tag) = simulation.find_tag("heated") {
                simulation
                    .reset_energy_of_tag(tag, 1.0 + f64::from(sample))
                    .unwrap();
            }
            observer.start(&simulation.view());
            simulation.observe_until(until, observer).unwrap();
            observer.sample(&simulation.view());
        }
    }

    const GAS: &str = r#"
        [box]
        sides = [2.0, 1.0]
        [[gas]]
        tags = ["heated"]
        radius = 0.02
        mass = 1.0
        energy = 1.0
        count = 150
        [[gas]]
        tags = ["dumbbells"]
        shape = "dumbbell"
        atom_radius = 0.02
        atom_mass = 2.0
        energy = 1.0
        count = 50
    "#;

    /// The sum of the stress over all bins, times duration and area.
    fn total(fields: &Fields) -> [f64; 4] {
        let bins = 0..fields.bins().len();
        bins.fold([0.0; 4], |mut total, bin| {
            for (sum, [stress, _]) in total.iter_mut().zip(fields.stress(bin)) {
                *sum += stress;
            }
            total
        })
    }

    #[test]
    fn the_mean_stress_is_the_pressure_tensor() {
        // Of components with r along a wall, only those of forces normal to the wall count: others
        // depend on where the middle of the wall is.
        let free = [true; 4];
        let smooth = [true, true, false, true];
        let thermal = [true, true, false, false];
        for (more, counts) in [
            ("", free),
            ("[[bumper]]\nradius = 0.1\nat = [1.9, 0.5]", free),
            ("[[wall]]\nx = 0.0\nradius = 0.01", smooth),
            ("[[wall]]\nx = 0.7\ntemperature = 2.0", thermal),
        ] {
            let scene = Scene::from_toml(&format!("{GAS}\n{more}")).unwrap();
            let mut simulation = Simulation::new(&scene).unwrap();
            let bounds = bounds(&simulation);
            let all = |bins| Fields::new(Group::All, bins);
            let mut grid = all(FieldBins::grid(&bounds, [7, 5]).unwrap());
            let mut columns = all(FieldBins::grid(&bounds, [50, 1]).unwrap());
            let centre = DVec2::new(0.3, 0.2);
            let mut rings = all(FieldBins::around_point(&bounds, centre, 1.2, 9).unwrap());
            let mut layers = all(FieldBins::beside_wall(&bounds, 0, 0.7, 1.0, 8).unwrap());
            let mut tensor = PressureTensor::default();
            let mut observers = (
                (&mut tensor, &mut grid),
                (&mut columns, (&mut rings, &mut layers)),
            );
            observed(&mut simulation, &mut observers, 4);
            let sums = tensor.sums();
            let area = bounds.area();
            let expected = [0, 1, 2, 3].map(|component: usize| area * sums[component][0]);
            let close = |found: f64, expected: f64| {
                let allowed = 1e-12 * area * sums[0][0];
                assert!(
                    (found - expected).abs() < allowed,
                    "{more}: {found} {expected}"
                );
            };
            for fields in [&grid, &columns] {
                let found = total(fields);
                for component in (0..4).filter(|&component| counts[component]) {
                    close(found[component], expected[component]);
                }
                assert!((fields.duration / sums[0][1] - 1.0).abs() < 1e-12);
            }
            let [rr, _, _, tt] = total(&rings);
            let [nn, _, _, along] = total(&layers);
            close(nn, expected[0]);
            if counts[3] {
                close(rr + tt, expected[0] + expected[3]);
                close(along, expected[3]);
            }
        }
    }

    #[test]
    fn fields_of_tags_add_up_to_those_of_all() {
        let mut simulation = Simulation::new(&Scene::from_toml(GAS).unwrap()).unwrap();
        let bounds = bounds(&simulation);
        let tag = |name| Group::from(simulation.find_tag(name).unwrap());
        let of = |group| Fields::new(group, FieldBins::grid(&bounds, [4, 4]).unwrap());
        let (mut one, mut other) = (of(tag("heated")), of(tag("dumbbells")));
        let mut all = of(Group::All);
        observed(&mut simulation, &mut (&mut one, (&mut other, &mut all)), 3);
        for bin in 0..16 {
            let sum =
                |of: fn(&Fields, usize) -> f64| [of(&one, bin) + of(&other, bin), of(&all, bin)];
            for [parts, whole] in [
                sum(|fields, bin| fields.density(bin)[0]),
                sum(|fields, bin| fields.area_fraction(bin)[0]),
                sum(|fields, bin| fields.velocity(bin)[0][0]),
                sum(|fields, bin| fields.spin(bin)[0]),
                sum(|fields, bin| fields.stress(bin)[0][0]),
                sum(|fields, bin| fields.stress(bin)[1][0]),
                sum(|fields, bin| fields.heat_current(bin)[1][0]),
            ] {
                assert!(
                    (parts - whole).abs() < 1e-10 * whole.abs().max(1.0),
                    "{parts} {whole}"
                );
            }
        }
    }

    #[test]
    fn a_uniform_gas_has_flat_fields_and_no_heat_current() {
        let scene =
            "[box]\nseed = 4\n[[gas]]\nradius = 0.01\nmass = 1.0\ntemperature = 1.5\ncount = 400";
        let mut simulation = Simulation::new(&Scene::from_toml(scene).unwrap()).unwrap();
        let bins = FieldBins::grid(&bounds(&simulation), [3, 3]).unwrap();
        let mut fields = Fields::new(Group::All, bins);
        observed(&mut simulation, &mut fields, 200);
        let mean = |[sum, weight]: [f64; 2]| sum / weight;
        let pressure = mean(fields.stress(0)[0]);
        for bin in 0..9 {
            assert!((mean(fields.density(bin)) / 400.0 - 1.0).abs() < 0.02);
            assert!((mean(fields.area_fraction(bin)) / 0.12566 - 1.0).abs() < 0.02);
            assert!((mean(fields.temperature(bin)) / 1.5 - 1.0).abs() < 0.03);
            assert!((mean(fields.stress(bin)[3]) / pressure - 1.0).abs() < 0.04);
            let current = mean(fields.heat_current(bin)[0]) / (pressure * 1.5_f64.sqrt());
            assert!(current.abs() < 0.03, "{current}");
            assert!(mean(fields.velocity(bin)[0]).abs() < 0.05);
        }
    }

    /// Discs on a lattice with v_x = 3 y, twice as many for x > ½.
    #[test]
    fn a_planted_shear_flow_and_a_planted_step_of_density_are_read_back() {
        let disc = |x: f64, y: f64| {
            format!(
                "[[molecule]]\natoms = [{{ at = [0, 0], radius = 0.004, mass = 1 }}]\nat = [{x}, {y}]\n\
                 velocity = [{}, 0.0]\n",
                3.0 * y
            )
        };
        let left = (0..10).flat_map(|i| (0..20).map(move |j| (0.025 + 0.05 * f64::from(i), j)));
        let right = (0..20).flat_map(|i| (0..20).map(move |j| (0.5125 + 0.025 * f64::from(i), j)));
        let all = left.chain(right);
        let scene: String = all
            .map(|(x, j)| disc(x, 0.025 + 0.05 * f64::from(j)))
            .collect();
        let simulation = Simulation::new(&Scene::from_toml(&scene).unwrap()).unwrap();
        let bounds = bounds(&simulation);
        let mut columns = Fields::new(Group::All, FieldBins::grid(&bounds, [10, 1]).unwrap());
        let mut rows = Fields::new(Group::All, FieldBins::grid(&bounds, [1, 20]).unwrap());
        let mut rings = Fields::new(
            Group::All,
            FieldBins::around_point(&bounds, DVec2::new(0.75, 0.5), 0.25, 5).unwrap(),
        );
        for fields in [&mut columns, &mut rows, &mut rings] {
            fields.sample(&simulation.view());
        }
        let mean = |[sum, weight]: [f64; 2]| sum / weight;
        for bin in 0..10 {
            let expected = if bin < 5 { 400.0 } else { 800.0 };
            assert!((mean(columns.density(bin)) / expected - 1.0).abs() < 1e-12);
            let covered = expected * std::f64::consts::PI * 0.004 * 0.004;
            assert!((mean(columns.area_fraction(bin)) / covered - 1.0).abs() < 1e-12);
            // A shear within the bin is no thermal motion of its own, but it counts as one.
            assert!(mean(columns.temperature(bin)) > 0.1);
        }
        for bin in 0..20 {
            let y = 0.05 * (bin as f64 + 0.5);
            assert!((mean(rows.velocity(bin)[0]) / (3.0 * y) - 1.0).abs() < 1e-12);
            assert!(mean(rows.temperature(bin)).abs() < 1e-28);
            assert_eq!(mean(rows.velocity(bin)[1]), 0.0);
        }
        // A shear about a point has no mean radial and an angular velocity of −½ · 3 r.
        let radial = mean(rings.velocity(4)[0]);
        let turning = mean(rings.velocity(4)[1]);
        assert!(
            radial.abs() < 0.02 && (turning / (-1.5 * 0.225) - 1.0).abs() < 0.1,
            "{radial} {turning}"
        );
    }

    #[test]
    fn heat_flows_from_the_hot_wall_to_the_cold_one() {
        let scene = r#"
            [box]
            sides = [4.0, 1.0]
            seed = 2
            [[wall]]
            x = 0.0
            temperature = 1.0
            [[wall]]
            x = 2.0
            temperature = 3.0
            tags = ["hot"]
            [[gas]]
            radius = 0.02
            mass = 1.0
            temperature = 2.0
            count = 200
        "#;
        let mut simulation = Simulation::new(&Scene::from_toml(scene).unwrap()).unwrap();
        let bins = FieldBins::grid(&bounds(&simulation), [8, 1]).unwrap();
        let mut fields = Fields::new(Group::All, bins);
        simulation.run_until(5.0).unwrap();
        fields.start(&simulation.view());
        let hot = simulation.find_tag("hot").unwrap();
        let mut heat = WallHeat::new(hot.into());
        heat.start(&simulation.view());
        for sample in 1..=300 {
            simulation
                .observe_until(5.0 + 0.2 * f64::from(sample), &mut (&mut fields, &mut heat))
                .unwrap();
            fields.sample(&simulation.view());
            heat.sample(&simulation.view());
        }
        let mean = |[sum, weight]: [f64; 2]| sum / weight;
        let currents: Vec<f64> = (0..8)
            .map(|bin| mean(fields.heat_current(bin)[0]))
            .collect();
        // What the wall gives flows away from it on both sides.
        let half = |currents: &[f64]| currents.iter().sum::<f64>() / 4.0;
        let [left, right] = [half(&currents[..4]), half(&currents[4..])];
        let given = heat.energy() / heat.duration();
        assert!(
            given > 0.0 && ((right - left) / given - 1.0).abs() < 0.1,
            "{left} {right} {given}"
        );
        assert!(left < 0.0 && right > 0.0, "{currents:?}");
        for (half, mean) in [(&currents[..4], left), (&currents[4..], right)] {
            assert!(
                half.iter()
                    .all(|current| (current / mean - 1.0).abs() < 0.2),
                "{currents:?}"
            );
        }
        assert!(mean(fields.temperature(0)) < mean(fields.temperature(3)));
    }
}
