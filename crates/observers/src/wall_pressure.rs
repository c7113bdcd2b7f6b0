//! The pressure of a gas on plane walls, from the momentum of its contacts, and its density over
//! the distance from them.
//!
//! p = Σ J·n / (t l), with the impulses J on the bodies, the normal n away from the wall, and the
//! length l of all sides of the walls: that of the gas where it is not disturbed by the walls. A
//! thermal wall can give a molecule that turns an impulse towards itself, which counts as negative.
//! Far from the walls the density is n, so that p = p(n) of the equation of state. At the walls the
//! density of centres is p/kT for smooth elastic contacts of a gas at equilibrium (contact theorem;
//! Henderson, Blum & Lebowitz 1979).
//!
//! p is the mean over both sides of the walls. What a gas on one side gives to them is the net
//! force per length, f = Σ J / (t l') along the axis across the walls, with their length l'. A
//! floor carries the weight of what lies on it.
//!
//! Walls may move: impulses do not depend on the frame, and distances are those from the places of
//! the walls at each sample.

use carom_engine::{Body, BodyView, CollisionReport, Observer, View};
use carom_kinematics::EpochTime;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::Group;

/// A wall crosses the box if it is shorter than the side by no more than this share.
const ROUNDING: f64 = 1e-9;

/// Momentum given to parallel walls across the box, and the centres of moving bodies over their
/// distance from the nearest wall.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Group, WallPressure};
///
/// let scene = Scene::from_toml(r#"
///     [[wall]]
///     y = 0.0
///     [[gas]]
///     radius = 0.001
///     mass = 1.0
///     temperature = 1.0
///     count = 100
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut walls = WallPressure::new(&simulation.view(), Group::All, 10, 0.1)?;
/// walls.start(&simulation.view());
/// for sample in 1..=200 {
///     simulation.observe_until(0.1 * f64::from(sample), &mut walls)?;
///     walls.sample(&simulation.view());
/// }
/// // A gas so thin is ideal: p = n kT.
/// let [impulse, duration_and_length] = walls.momentum();
/// assert!((impulse / duration_and_length / 100.0 - 1.0).abs() < 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct WallPressure {
    walls: Group,
    /// The axis across the walls: 0 for walls x = …, 1 for y = ….
    axis: usize,
    /// Places of the walls along it, in the box, in ascending order (length).
    planes: Vec<f64>,
    /// Side of the box across the walls (length).
    across: f64,
    /// Side of the box along the walls (length).
    along: f64,
    /// Distance from the walls from which the gas counts as undisturbed (length).
    far: f64,
    width: f64,
    impulse: f64,
    net_impulse: f64,
    counts: Vec<u64>,
    far_count: u64,
    /// Samples since the walls have stood at `planes`.
    samples: u64,
    /// Areas of the layers, and of the places far from the walls, summed over the samples before
    /// (length²): those of walls that move differ.
    areas_before: Vec<f64>,
    start: Option<EpochTime>,
    duration: f64,
}

/// The density of centres in a layer along the walls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallLayer {
    /// Distance of its middle from the nearest wall (length).
    pub distance: f64,
    /// Centres found in it at all samples.
    pub count: u64,
    /// Samples times the area of the layer (length²).
    pub area: f64,
}

/// Why there is no pressure on walls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum WallsError {
    /// The group has no wall.
    #[error("there is no such wall")]
    None,
    /// A wall is a segment, or walls along both axes cross each other.
    #[error("the walls must be parallel lines across the whole box: all `x = …` or all `y = …`")]
    NotParallel,
}

/// Parallel walls that cross the whole box.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct WallsAcross {
    /// The axis across the walls: 0 for walls x = …, 1 for y = ….
    pub axis: usize,
    /// Places of the walls along it, in the box, in ascending order (length).
    pub places: Vec<f64>,
}

impl WallsAcross {
    /// The walls of a group; its other bodies have no effect.
    ///
    /// # Errors
    /// [`WallsError`] if there is no wall, or if one of them is not a line across the box parallel
    /// to the others.
    pub fn new(view: &View<'_>, walls: Group) -> Result<Self, WallsError> {
        let sides = view.bounds().sides();
        let is_wall = |body: &BodyView<'_>| body.body.is_wall() && walls.contains(body.body);
        let (mut axis, mut places) = (None, Vec::new());
        for wall in view.bodies().filter(is_wall) {
            let [from, to] = wall.wall().ok_or(WallsError::NotParallel)?;
            let span = (to - from).abs();
            let own = [0, 1].into_iter().find(|&axis| {
                span[axis] == 0.0 && span[1 - axis] >= (1.0 - ROUNDING) * sides[1 - axis]
            });
            let own = own.ok_or(WallsError::NotParallel)?;
            if *axis.get_or_insert(own) != own {
                return Err(WallsError::NotParallel);
            }
            places.push(from[own].rem_euclid(sides[own]));
        }
        let axis = axis.ok_or(WallsError::None)?;
        places.sort_by(f64::total_cmp);
        Ok(Self { axis, places })
    }
}

impl WallPressure {
    /// The walls of a group; its other bodies have no effect. `bins` (at least 1) layers reach to
    /// the middle between the walls. The density far from the walls is that of the centres at least
    /// `far` (length) away.
    ///
    /// # Errors
    /// [`WallsError`] if there is no wall, or if one of them is not a line across the box parallel
    /// to the others.
    pub fn new(view: &View<'_>, walls: Group, bins: usize, far: f64) -> Result<Self, WallsError> {
        let WallsAcross {
            axis,
            places: planes,
        } = WallsAcross::new(view, walls)?;
        let sides = view.bounds().sides();
        let (across, bins) = (sides[axis], bins.max(1));
        let mut walls = Self {
            walls,
            axis,
            planes,
            across,
            along: sides[1 - axis],
            far,
            width: 0.0,
            impulse: 0.0,
            net_impulse: 0.0,
            counts: vec![0; bins],
            far_count: 0,
            samples: 0,
            areas_before: vec![0.0; bins + 1],
            start: None,
            duration: 0.0,
        };
        walls.width = 0.5 * walls.gaps().fold(0.0, f64::max) / bins as f64;
        Ok(walls)
    }

    /// Distances between neighbouring walls, once round the box (length).
    fn gaps(&self) -> impl Iterator<Item = f64> {
        let next = self.planes.iter().skip(1).copied();
        let first_again = self.planes.first().map(|first| first + self.across);
        self.planes
            .iter()
            .zip(next.chain(first_again))
            .map(|(from, to)| to - from)
    }

    /// Area of the places at distances between these from the nearest wall (length²).
    fn area(&self, from: f64, to: f64) -> f64 {
        let depth = |gap: f64| 2.0 * ((0.5 * gap).min(to) - from).max(0.0);
        self.along * self.gaps().map(depth).sum::<f64>()
    }

    /// Distance of a place from the nearest wall (length).
    fn distance(&self, place: f64) -> f64 {
        let to = |plane: &f64| {
            let away = (place - plane).rem_euclid(self.across);
            away.min(self.across - away)
        };
        self.planes.iter().map(to).fold(f64::INFINITY, f64::min)
    }

    /// Σ J·n (mass × length / time), and the time times the length of all sides of the walls (time
    /// × length): their ratio is the pressure.
    pub fn momentum(&self) -> [f64; 2] {
        [
            self.impulse,
            self.duration * 2.0 * self.along * self.planes.len() as f64,
        ]
    }

    /// Σ J along the axis across the walls, of the impulses J on them (mass × length / time), and
    /// the time times the length of the walls (time × length): their ratio is the net force per
    /// length.
    pub fn net_momentum(&self) -> [f64; 2] {
        [
            self.net_impulse,
            self.duration * self.along * self.planes.len() as f64,
        ]
    }

    /// Centres found far from the walls at all samples, and that area summed over the samples
    /// (length²): their ratio is the density. The area is 0 if the walls are too near to each
    /// other.
    pub fn far_from_walls(&self) -> [f64; 2] {
        [
            self.far_count as f64,
            self.areas().last().copied().unwrap_or(0.0),
        ]
    }

    /// The layers from the walls to the middle between them.
    pub fn layers(&self) -> Vec<WallLayer> {
        let areas = self.areas();
        let layer = |(bin, (&count, area)): (usize, (&u64, f64))| {
            let [from, to] = [bin, bin + 1].map(|edge| edge as f64 * self.width);
            WallLayer {
                distance: 0.5 * (from + to),
                count,
                area,
            }
        };
        let layers = self.counts.iter().zip(areas);
        layers.enumerate().map(layer).collect()
    }

    /// Areas of the layers, and then of the places far from the walls, summed over the samples
    /// (length²).
    fn areas(&self) -> Vec<f64> {
        let bins = self.counts.len();
        let area = |(bin, before): (usize, &f64)| {
            let [from, to] = [bin, bin + 1].map(|edge| edge as f64 * self.width);
            // The last layer ends at the middle: rounding leaves nothing beyond.
            let area = match bin {
                _ if bin == bins => self.area(self.far, f64::INFINITY),
                _ if bin + 1 == bins => self.area(from, f64::INFINITY),
                _ => self.area(from, to),
            };
            before + self.samples as f64 * area
        };
        self.areas_before.iter().enumerate().map(area).collect()
    }

    /// Takes the places of walls that have moved since the last sample.
    fn follow(&mut self, view: &View<'_>) {
        if let Ok(walls) = WallsAcross::new(view, self.walls)
            && walls.axis == self.axis
            && walls.places != self.planes
        {
            self.areas_before = self.areas();
            (self.samples, self.planes) = (0, walls.places);
        }
    }

    fn is_wall(&self, body: &Body) -> bool {
        body.is_wall() && self.walls.contains(body)
    }
}

impl Observer for WallPressure {
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.is_wall(bodies[0]) | self.is_wall(bodies[1])
    }

    /// After an edit the sums continue.
    fn start(&mut self, view: &View<'_>) {
        self.start.get_or_insert(view.time());
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        // The impulse is that on the second body.
        let on_second = report.impulse[self.axis];
        let is_second = self.is_wall(report.sides[1].body);
        self.impulse += on_second * report.normal[self.axis].signum();
        self.net_impulse += if is_second { on_second } else { -on_second };
    }

    fn sample(&mut self, view: &View<'_>) {
        let start = *self.start.get_or_insert(view.time());
        self.duration = view.time().since(start);
        self.follow(view);
        self.samples += 1;
        for body in view.bodies().filter(|body| body.body.is_free()) {
            let distance = self.distance(body.motion.position[self.axis]);
            let last = self.counts.len() - 1;
            self.counts[((distance / self.width) as usize).min(last)] += 1;
            self.far_count += u64::from(distance >= self.far);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_engine::{Scene, Simulation};

    fn walls(text: &str, bins: usize, far: f64) -> Result<WallPressure, WallsError> {
        let simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
        WallPressure::new(&simulation.view(), Group::All, bins, far)
    }

    /// Σ J·n by the places of the centres of mass, and the number of impulses towards the wall.
    #[derive(Default)]
    struct ByPlace {
        impulse: f64,
        towards: u32,
    }

    impl Observer for ByPlace {
        fn collision(&mut self, report: &CollisionReport<'_>) {
            let side = report.sides.iter().find(|side| !side.body.is_wall());
            let side = side.expect("only walls are fixed");
            // The wall is at x = 0 of a box of 4, its other side at x = 4.
            let away = (2.0 - side.before.position.x.rem_euclid(4.0)).signum();
            let along = away * side.momentum_change().x;
            self.impulse += along;
            self.towards += u32::from(along < 0.0);
        }
    }

    #[test]
    fn an_impulse_towards_a_thermal_wall_counts_as_negative() {
        let text = "[box]\nsides = [4.0, 3.0]\n[[wall]]\nx = 0.0\ntemperature = 1.0\n\
                    [[molecule]]\nshape = \"rod:5\"\natom_radius = 0.1\natom_mass = 0.2\nat = [2.0, 1.0]\n\
                    velocity = [1.0, 0.0]\n";
        let mut simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
        let walls = WallPressure::new(&simulation.view(), Group::All, 4, 0.3).unwrap();
        let mut observers = (walls, ByPlace::default());
        observers.start(&simulation.view());
        simulation.observe_until(1000.0, &mut observers).unwrap();
        let (walls, expected) = observers;
        assert!(expected.towards > 0, "{}", expected.towards);
        let [found, _] = walls.momentum();
        assert!(
            (found / expected.impulse - 1.0).abs() < 1e-9,
            "{found} {}",
            expected.impulse
        );
    }

    #[test]
    fn one_disc_between_two_walls_gives_them_its_momentum() {
        let text = "[box]\nsides = [2.0, 3.0]\n[[wall]]\nx = 0.5\n[[wall]]\nx = 1.5\n\
                    [[molecule]]\nshape = \"disc\"\natom_radius = 0.1\natom_mass = 3.0\nat = [1.0, 1.0]\n\
                    velocity = [4.0, 0.0]\n";
        let mut simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
        let mut walls = WallPressure::new(&simulation.view(), Group::All, 4, 0.3).unwrap();
        walls.start(&simulation.view());
        // Contacts at 0.1, 0.3, … : 10 up to 2.
        for sample in 1..=200 {
            simulation
                .observe_until(0.01 * f64::from(sample), &mut walls)
                .unwrap();
            walls.sample(&simulation.view());
        }
        let [impulse, norm] = walls.momentum();
        assert!(
            (impulse - 10.0 * 24.0).abs() < 1e-9 && (norm - 2.0 * 2.0 * 3.0 * 2.0).abs() < 1e-12
        );
        // Its centre is always at least 0.1 away, and half of the time at least 0.3.
        let layers = walls.layers();
        assert_eq!(layers.iter().map(|layer| layer.count).sum::<u64>(), 200);
        let areas: Vec<f64> = layers.iter().map(|layer| layer.area / 200.0).collect();
        assert!(
            areas.iter().all(|area| (area - 1.5).abs() < 1e-12),
            "{areas:?}"
        );
        let [far, area] = walls.far_from_walls();
        assert!(
            (far / 200.0 - 0.5).abs() < 0.02 && (area / 200.0 - 2.4).abs() < 1e-12,
            "{far} {area}"
        );
    }

    #[test]
    fn walls_that_do_not_enclose_a_gas_are_refused() {
        assert_eq!(walls("", 1, 0.1).unwrap_err(), WallsError::None);
        let segment = "[[wall]]\nfrom = [0.1, 0.5]\nto = [0.9, 0.5]\n";
        assert_eq!(walls(segment, 1, 0.1).unwrap_err(), WallsError::NotParallel);
        let crossed = "[[wall]]\nx = 0.0\n[[wall]]\ny = 0.0\n";
        assert_eq!(walls(crossed, 1, 0.1).unwrap_err(), WallsError::NotParallel);
        // Nothing is as far away as this.
        assert_eq!(
            walls("[[wall]]\nx = 0.0\n", 3, 0.6)
                .unwrap()
                .far_from_walls(),
            [0.0, 0.0]
        );
    }
}
