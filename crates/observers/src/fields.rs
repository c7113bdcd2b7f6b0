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

use carom_engine::{Body, BodyView, CollisionReport, Observer, Side, View};
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
/// let bins = FieldBins::grid(simulation.view().bounds(), [4, 4])?;
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

    fn members<'a>(&self, view: &View<'a>) -> impl Iterator<Item = BodyView<'a>> + use<'a> {
        let group = self.group;
        view.bodies()
            .filter(move |member| !member.body.is_wall() && group.contains(member.body))
    }

    /// What the bodies carry along, in the frame of this velocity.
    fn carried(&self, view: &View<'_>, drift: DVec2) -> Fluxes {
        let mut fluxes = vec![[0.0; FLUXES]; self.bins.len()];
        for member in self.members(view).filter(|member| !member.body.is_fixed()) {
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
        for member in self.members(view) {
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
        let mut carried = carried_by(report, &self.bins, interval.drift);
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
fn carried_by(report: &CollisionReport<'_>, bins: &FieldBins, drift: DVec2) -> Carried {
    let [first, second] = &report.sides;
    let separation = report.separation(bins.bounds());
    let from = first.before.position;
    let gain = |side: &Side<'_>| {
        energy(side.body, &side.after, drift) - energy(side.body, &side.before, drift)
    };
    let [gain_of_first, gain_of_second] = [gain(first), gain(second)];
    let half = if first.body.is_fixed() || second.body.is_fixed() {
        1.0
    } else {
        0.5
    };
    // From a centre to the point of contact; along the normal as far as the wall's own centre, which
    // counts for walls with a thickness.
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
