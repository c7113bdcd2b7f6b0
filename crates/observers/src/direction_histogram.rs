//! Directions of the impulses on bodies in their own frames (Montanari 2017, section 3.2, item 1).
//!
//! J is the impulse on the body (mass × length / time) and θ its orientation at contact. The
//! direction is the angle of R(−θ) J, counter-clockwise from +x′, in [0, 2π). Bin k of n covers
//! [2πk/n, 2π(k+1)/n). All impulses on one side of a straight edge have one direction; if that is
//! the limit of two bins, they count in the one that begins there.

use std::f64::consts::TAU;

use carom_engine::{Body, BodyKey, CollisionReport, Observer, View};
use carom_geometry::DIRECTION_ROUNDING;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{Group, body_frame::in_body_frame};

/// A histogram of the directions of the impulses on one body, or on each body of a group, in its
/// frame (x′, y′) at the time of contact.
///
/// A disc never turns, so a disc with orientation 0 keeps the axes of the box. To omit the start of
/// a run, begin to observe later.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::DirectionHistogram;
///
/// // A disc at rest, hit from the left: the impulse on it points along +x, in the first of four
/// // bins.
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
/// let target = simulation.view().bodies().next().expect("there are two bodies").body.key();
/// let mut directions = DirectionHistogram::new(target, 4);
/// directions.start(&simulation.view());
/// simulation.observe_until(0.3, &mut directions)?;
/// assert_eq!(directions.counts(), [1, 0, 0, 0]);
/// assert!((directions.total_impulse() - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DirectionHistogram {
    watched: Watched,
    counts: Vec<u64>,
    impulse: Vec<f64>,
    atom_counts: Vec<u64>,
    edge_counts: Vec<u64>,
}

/// The observed bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum Watched {
    Body(BodyKey),
    Group(Group),
}

impl Watched {
    #[inline]
    fn has(self, body: &Body) -> bool {
        match self {
            Self::Body(key) => body.key() == key,
            Self::Group(group) => group.contains(body) && !body.is_wall(),
        }
    }
}

impl DirectionHistogram {
    /// An empty histogram for one body, with at least one bin: `bins` = 0 is taken as 1.
    pub fn new(body: BodyKey, bins: usize) -> Self {
        Self::watching(Watched::Body(body), bins)
    }

    /// An empty histogram for all bodies of a group but walls, with at least one bin.
    pub fn of_group(group: Group, bins: usize) -> Self {
        Self::watching(Watched::Group(group), bins)
    }

    fn watching(watched: Watched, bins: usize) -> Self {
        let bins = bins.max(1);
        Self {
            watched,
            counts: vec![0; bins],
            impulse: vec![0.0; bins],
            atom_counts: Vec::new(),
            edge_counts: Vec::new(),
        }
    }

    /// Number of contacts in each bin.
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// Σ |J| in each bin (mass × length / time); divided by the duration, the force by direction.
    #[doc(alias = "momentum")]
    pub fn impulse(&self) -> &[f64] {
        &self.impulse
    }

    /// Number of contacts of each atom of the bodies, by its place in their lists; empty before the
    /// start. All 0 in the model of
    /// bounding circles, where no atom touches.
    pub fn atom_counts(&self) -> &[u64] {
        &self.atom_counts
    }

    /// Number of contacts of each straight edge of the bodies between its ends, by its place in
    /// their lists; empty before the start and for unions of discs.
    pub fn edge_counts(&self) -> &[u64] {
        &self.edge_counts
    }

    /// Number of contacts.
    pub fn hits(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Σ |J| of all contacts (mass × length / time).
    pub fn total_impulse(&self) -> f64 {
        self.impulse.iter().sum()
    }
}

impl Observer for DirectionHistogram {
    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        bodies.into_iter().any(|body| self.watched.has(body))
    }

    fn start(&mut self, view: &View<'_>) {
        for view in view.bodies().filter(|view| self.watched.has(view.body)) {
            let molecule = view.body.molecule();
            lengthen(&mut self.atom_counts, molecule.atoms().len());
            lengthen(&mut self.edge_counts, molecule.edges().len());
        }
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        // A contact without impulse has no direction, and bonds and wells do not act on surfaces.
        if report.impulse == DVec2::ZERO || !report.is_contact() {
            return;
        }
        for (side, impulse) in report.sides.iter().zip([-report.impulse, report.impulse]) {
            if !self.watched.has(side.body) {
                continue;
            }
            let direction = in_body_frame(impulse, side.before.orientation);
            let bins = self.counts.len();
            let bin = match side.edge {
                Some(_) => bin_of_peak(direction, bins),
                None => bin_of(direction, bins),
            };
            self.counts[bin] += 1;
            self.impulse[bin] += impulse.length();
            for (part, counts) in [
                (side.atom, &mut self.atom_counts),
                (side.edge, &mut self.edge_counts),
            ] {
                if let Some(part) = part.map(|part| part as usize) {
                    lengthen(counts, part + 1);
                    counts[part] += 1;
                }
            }
        }
    }
}

/// Adds zeros up to at least this length.
fn lengthen(counts: &mut Vec<u64>, length: usize) {
    counts.resize(length.max(counts.len()), 0);
}

/// The bin of a direction that many impulses share, to rounding: the next bin, if that begins
/// within rounding.
fn bin_of_peak(direction: DVec2, bins: usize) -> usize {
    let ahead = DVec2::from_angle(DIRECTION_ROUNDING * TAU).rotate(direction);
    bin_of(ahead, bins)
}

/// The bin of a direction, of `bins` equal bins counter-clockwise from +x.
pub(crate) fn bin_of(direction: DVec2, bins: usize) -> usize {
    let angle = libm::atan2(direction.y, direction.x);
    let turns = if angle < 0.0 { angle + TAU } else { angle } / TAU;
    // An angle just below 0 is rounded to a whole turn, which is the end of the last bin.
    ((turns * bins as f64) as usize).min(bins - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impulses_on_an_edge_share_a_bin_in_spite_of_rounding() {
        for (quarter, bin) in [(0, 0), (1, 18), (2, 36), (3, 54)] {
            let exact = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y][quarter];
            for off in [-1e-12, 0.0, 1e-12] {
                let direction = DVec2::from_angle(off).rotate(exact);
                assert_eq!(bin_of_peak(direction, 72), bin, "{direction}");
            }
        }
    }

    #[test]
    fn bins_run_counter_clockwise_from_x_and_cover_all_directions() {
        for bins in [1, 7, 360] {
            for bin in 0..bins {
                let angle = TAU * (bin as f64 + 0.5) / bins as f64;
                assert_eq!(bin_of(DVec2::from_angle(angle), bins), bin);
            }
        }
        assert_eq!(bin_of(DVec2::new(1.0, 0.0), 360), 0);
        assert_eq!(bin_of(DVec2::new(1.0, -0.0), 360), 0);
        assert_eq!(bin_of(DVec2::new(1.0, -1e-300), 360), 359);
        assert_eq!(bin_of(DVec2::new(-1.0, -0.0), 4), 2);
        assert_eq!(bin_of(DVec2::new(1e-200, -1e-200), 8), 7);
    }
}
