//! Density of a gas at the boundary of a body: the momentum transferred by its contacts per time
//! and arc, kT ρ_c.
//!
//! Discs of radius r touch an atom of radius ρ with their centres on the circle of radius s = ρ + r
//! around it. φ is the angle of the contact normal in the frame of the body, and ds = s dφ counts
//! where no other atom is in the way. For elastic contacts at equilibrium Σ|J| / (t ds) = kT ρ_c(φ)
//! (mass / time²), whatever the mass of the body. ρ_c is the number of centres per area at contact,
//! n for an ideal gas (contact theorem; Henderson, Blum & Lebowitz 1979).

use std::f64::consts::TAU;

use carom_engine::{Body, BodyKey, CollisionReport, Observer, View};
use carom_geometry::{ExcludedRegion, GeometryError, check_positive};
use carom_kinematics::EpochTime;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{body_frame::in_body_frame, direction_histogram::bin_of};

/// Contacts of discs of one radius with one body, by the atom touched and the direction of the
/// normal.
///
/// To omit the start of a run, begin to observe later. A later `start`, after an edit, changes
/// nothing. If a body is so large that a disc does not fit between it and its own image, the
/// boundary computed here is too long.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::ContactDensity;
///
/// // One disc of speed 1 is an ideal gas of kT = ½ m v² and one body, on the area outside the
/// // excluded region of the bumper.
/// let scene = Scene::from_toml(r#"
///     [[bumper]]
///     radius = 0.2
///     at = [0.5, 0.5]
///     [[molecule]]
///     atoms = [{ at = [0, 0], radius = 0.05, mass = 1 }]
///     at = [0.0, 0.0]
///     velocity = [0.6, 0.8]
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// let bumper = simulation.view().bodies().find(|view| view.body.is_fixed()).expect("there is one").body.clone();
/// let mut contacts = ContactDensity::new(&bumper, 0.05, 12)?;
/// contacts.start(&simulation.view());
/// simulation.observe_until(20_000.0, &mut contacts)?;
/// contacts.sample(&simulation.view());
/// let density = 1.0 / (1.0 - std::f64::consts::PI * 0.25 * 0.25);
/// let pressure = contacts.mean().expect("time has passed");
/// assert!((pressure / (0.5 * density) - 1.0).abs() < 0.05);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ContactDensity {
    body: BodyKey,
    radius: f64,
    bins: usize,
    /// The boundary around each atom, bin by bin.
    atoms: Vec<Vec<Bin>>,
    others: u64,
    began: Option<EpochTime>,
    duration: f64,
}

#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct Bin {
    /// Length of the exposed arc.
    arc: f64,
    contacts: u64,
    /// Σ |J|.
    impulse: f64,
    /// Σ |J|².
    squares: f64,
}

/// The contacts on one piece of the boundary.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ContactPoint {
    /// Index of the atom touched.
    pub atom: usize,
    /// Index of the bin, of equal bins of the whole turn around the atom.
    pub bin: usize,
    /// Direction of the outward normal of the atom at the centre of the bin: radians,
    /// counter-clockwise from +x′.
    pub angle: f64,
    /// Length of the boundary of the excluded region in the bin.
    pub arc: f64,
    /// Number of contacts.
    pub contacts: u64,
    /// Σ|J| / (t ds), which is kT ρ_c at equilibrium (mass / time²).
    pub pressure: f64,
    /// Its standard error if contacts are independent, √(Σ|J|²) / (t ds) (mass / time²); 0 without
    /// contacts. The scatter of blocks of time gives the error without that assumption.
    pub standard_error: f64,
}

impl ContactDensity {
    /// Contacts of discs of `radius` (length) with a body, in `bins` equal bins of the whole turn
    /// around each of its atoms; `bins` = 0 is taken as 1. A wall has no such boundary, and
    /// straight edges of a molecule have no bins: their contacts count as [others](Self::others),
    /// and the perimeter is that of the arcs alone.
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if the radius is not positive and finite.
    pub fn new(body: &Body, radius: f64, bins: usize) -> Result<Self, GeometryError> {
        let radius = check_positive("the radius of the discs of a gas", radius)?;
        let (bins, molecule) = (bins.max(1), body.molecule());
        let bare = Bin::default();
        let mut atoms = Vec::new();
        if !body.is_wall() {
            let region = ExcludedRegion::new(molecule, radius)?;
            atoms.resize(molecule.atoms().len(), vec![bare; bins]);
            // A disc may have been placed in a pocket, where it touches the boundary.
            for arc in region.arcs().iter().chain(region.hidden_arcs()) {
                for (bin, from, to) in arc.sectors(bins, 0.0) {
                    atoms[arc.atom][bin].arc += arc.radius * (to - from);
                }
            }
        }
        Ok(Self {
            body: body.key(),
            radius,
            bins,
            atoms,
            others: 0,
            began: None,
            duration: 0.0,
        })
    }

    /// The observed body.
    pub fn body(&self) -> BodyKey {
        self.body
    }

    /// Number of bins of the whole turn around each atom.
    pub fn turn_bins(&self) -> usize {
        self.bins
    }

    /// Number of atoms of the body; 0 for a wall.
    pub fn atoms(&self) -> usize {
        self.atoms.len()
    }

    /// Length of the boundary in a bin of an atom that the discs can touch (length).
    pub fn arc(&self, atom: usize, bin: usize) -> f64 {
        self.atoms
            .get(atom)
            .and_then(|bins| bins.get(bin))
            .map_or(0.0, |bin| bin.arc)
    }

    /// Every bin that contains a piece of the boundary, for every atom; empty before any time has
    /// passed.
    pub fn points(&self) -> Vec<ContactPoint> {
        if self.duration <= 0.0 {
            return Vec::new();
        }
        let point = |atom: usize, index: usize, bin: &Bin| {
            let norm = self.duration * bin.arc;
            ContactPoint {
                atom,
                bin: index,
                angle: TAU * (index as f64 + 0.5) / self.bins as f64,
                arc: bin.arc,
                contacts: bin.contacts,
                pressure: bin.impulse / norm,
                standard_error: bin.squares.sqrt() / norm,
            }
        };
        let bins = self.atoms.iter().enumerate().flat_map(|(atom, boundary)| {
            boundary
                .iter()
                .enumerate()
                .map(move |(index, bin)| (atom, index, bin))
        });
        bins.filter(|(_, _, bin)| bin.arc > 0.0)
            .map(|(atom, index, bin)| point(atom, index, bin))
            .collect()
    }

    /// Σ|J| of the contacts in one bin around an atom (mass × length / time); 0 if there is no such
    /// bin.
    pub fn impulse(&self, atom: usize, bin: usize) -> f64 {
        self.atoms
            .get(atom)
            .and_then(|bins| bins.get(bin))
            .map_or(0.0, |bin| bin.impulse)
    }

    /// Σ|J| / (t P) over the whole boundary (mass / time²): kT times the mean of ρ_c along it.
    /// `None` before any time has passed, or if the body has no exposed boundary.
    pub fn mean(&self) -> Option<f64> {
        let (time, perimeter) = (self.duration, self.perimeter());
        let impulse: f64 = self.all_bins().map(|bin| bin.impulse).sum();
        (time > 0.0 && perimeter > 0.0).then(|| impulse / (time * perimeter))
    }

    /// Length P of the boundary of the region that the centres of the discs cannot enter.
    pub fn perimeter(&self) -> f64 {
        self.all_bins().map(|bin| bin.arc).sum()
    }

    /// The number of other contacts that changed a momentum: with molecules, with discs of another
    /// radius, or without an atom that touches, as in the model of bounding circles.
    pub fn others(&self) -> u64 {
        self.others
    }

    /// The duration of the observation (time).
    pub fn duration(&self) -> f64 {
        self.duration
    }

    fn all_bins(&self) -> impl Iterator<Item = &Bin> {
        self.atoms.iter().flatten()
    }

    fn watched_until(&mut self, time: EpochTime) {
        let began = *self.began.get_or_insert(time);
        self.duration = self.duration.max(time.since(began));
    }
}

impl Observer for ContactDensity {
    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.body.is_among(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        self.began.get_or_insert(view.time());
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        let Some((side, impulse)) = report.side_of(self.body) else {
            return;
        };
        self.watched_until(report.time);
        // A contact without impulse has no direction, and bonds and wells do not act on surfaces.
        if impulse == DVec2::ZERO || !report.is_contact() {
            return;
        }
        let partner = report
            .sides
            .iter()
            .find(|side| side.body.key() != self.body);
        let is_of_the_gas = partner.is_some_and(|partner| {
            let molecule = partner.body.molecule();
            molecule.is_disc() && molecule.bounding_radius() == self.radius
        });
        let boundary = side
            .atom
            .filter(|_| is_of_the_gas)
            .and_then(|atom| self.atoms.get_mut(atom as usize));
        // The impulse points inwards.
        let index = bin_of(-in_body_frame(impulse, side.before.orientation), self.bins);
        // A boundary read from a damaged file may have fewer bins.
        let Some(bin) = boundary.and_then(|boundary| boundary.get_mut(index)) else {
            self.others += 1;
            return;
        };
        bin.contacts += 1;
        bin.impulse += impulse.length();
        bin.squares += impulse.length_squared();
    }

    fn sample(&mut self, view: &View<'_>) {
        if view.body(self.body).is_some() {
            self.watched_until(view.time());
        }
    }
}
