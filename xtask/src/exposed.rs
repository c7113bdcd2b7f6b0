//! From which sides a round probe can touch a molecule: the exposed arcs of its excluded region's boundary.
//!
//! The centre of a probe of radius r touching atom i lies on the circle of radius s = aᵢ + r about the atom's
//! centre. The excluded region is the union of these circles' discs; the parts of circle i that no other disc
//! covers are the exposed arcs of atom i. On each arc the normal's direction is the arc's own angle.
//!
//! At equilibrium an ideal gas strikes each piece ds of the boundary alike: the impulse per time is nkT ds whatever
//! the molecule's mass and whether it turns, and the number of contacts per time is n √(kT / 2πμ) ds with the
//! reduced mass 1/μ = 1/m + 1/M + (r × n̂)²/I (kinetic theory of gases; Santaló (1976), "Integral geometry and
//! geometric probability", for the geometry). So both histograms follow from the arcs alone.

use std::f64::consts::{PI, TAU};

use carom::Molecule;
use glam::DVec2;

/// An arc of directions of the normal from which the probe can touch one atom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// Which atom.
    pub atom: usize,
    /// Where it begins (radians, from 0 to 2π).
    pub start: f64,
    /// Where it ends, counter-clockwise from the start (radians).
    pub end: f64,
    /// Radius of the arc: atom and probe together (length).
    pub radius: f64,
    /// Centre of the atom from the centre of mass (length).
    pub centre: DVec2,
}

/// The boundary of the region that a molecule denies to a probe's centre.
///
/// A hole inside the molecule that is wide enough for the probe counts, though nothing gets there from outside.
#[derive(Debug, Clone, PartialEq)]
pub struct Boundary {
    arcs: Vec<Arc>,
    atoms: usize,
}

/// Exposed arcs shorter than this are roundings of circles that meet in one point (radians).
const SHORTEST: f64 = 1e-12;

impl Boundary {
    /// The boundary for a round probe of `radius` (length), in the molecule's own frame.
    pub fn of(molecule: &Molecule, radius: f64) -> Self {
        let circles: Vec<(DVec2, f64)> =
            molecule.atoms().iter().map(|atom| (atom.offset(), atom.radius() + radius)).collect();
        let arcs = (0..circles.len()).flat_map(|atom| exposed(&circles, atom)).collect();
        Self { arcs, atoms: circles.len() }
    }

    /// The arcs, by atom and then by angle.
    pub fn arcs(&self) -> &[Arc] {
        &self.arcs
    }

    /// Length of the boundary.
    pub fn perimeter(&self) -> f64 {
        self.arcs.iter().map(|arc| arc.radius * arc.angle()).sum()
    }

    /// Of all directions of the normal, how many expose this atom (radians).
    pub fn exposed_angle(&self, atom: usize) -> f64 {
        self.arcs.iter().filter(|arc| arc.atom == atom).map(Arc::angle).sum()
    }

    /// How many atoms can be touched with the normal in this direction (radians): N(φ).
    pub fn exposure(&self, normal: f64) -> usize {
        let inside = |arc: &&Arc| (normal - arc.start).rem_euclid(TAU) < arc.angle();
        self.arcs.iter().filter(inside).count()
    }

    /// Atoms that the probe can never touch.
    pub fn unreachable(&self) -> Vec<usize> {
        (0..self.atoms).filter(|&atom| self.exposed_angle(atom) == 0.0).collect()
    }

    /// ∫ weight ds over the boundary, where the weight may depend on the arc and on the direction of the normal.
    pub fn integral(&self, weight: impl Fn(&Arc, f64) -> f64) -> f64 {
        self.arcs.iter().map(|arc| arc.integral(arc.start, arc.end, &weight)).sum()
    }

    /// ∫ weight ds over the arcs of each atom.
    pub fn by_atom(&self, weight: impl Fn(&Arc, f64) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.atoms];
        for arc in &self.arcs {
            sums[arc.atom] += arc.integral(arc.start, arc.end, &weight);
        }
        sums
    }

    /// ∫ weight ds over each of equal sectors of the direction of the impulse on the molecule, which is opposite
    /// to the normal; from direction 0 counter-clockwise.
    pub fn by_impulse_direction(&self, sectors: usize, weight: impl Fn(&Arc, f64) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; sectors];
        let width = TAU / sectors as f64;
        for arc in &self.arcs {
            // Direction of the impulse, within one turn of the start.
            let shift = PI;
            let mut from = arc.start;
            let mut sector = ((from + shift) / width).floor();
            while from < arc.end {
                let to = ((sector + 1.0) * width - shift).min(arc.end);
                if to > from {
                    sums[(sector as usize) % sectors] += arc.integral(from, to, &weight);
                    from = to;
                }
                sector += 1.0;
            }
        }
        sums
    }
}

impl Arc {
    /// How far it goes round (radians).
    pub fn angle(&self) -> f64 {
        self.end - self.start
    }

    /// Three-point Gauss rule on pieces of at most one degree: exact to rounding for what varies with a molecule's
    /// shape.
    fn integral(&self, from: f64, to: f64, weight: &impl Fn(&Self, f64) -> f64) -> f64 {
        let pieces = ((to - from) / (PI / 180.0)).ceil().max(1.0) as usize;
        let step = (to - from) / pieces as f64;
        let offset = 0.6f64.sqrt();
        let piece = |index: usize| {
            let middle = from + (index as f64 + 0.5) * step;
            let at = |node: f64| weight(self, middle + 0.5 * step * node);
            (5.0 * (at(-offset) + at(offset)) + 8.0 * at(0.0)) / 18.0
        };
        self.radius * step * (0..pieces).map(piece).sum::<f64>()
    }
}

/// The exposed arcs of one circle of a union.
fn exposed(circles: &[(DVec2, f64)], atom: usize) -> Vec<Arc> {
    let (centre, radius) = circles[atom];
    let arc = |start, end| Arc { atom, start, end, radius, centre };
    let mut covered: Vec<(f64, f64)> = Vec::new();
    for (other, &(other_centre, other_radius)) in circles.iter().enumerate() {
        if other == atom {
            continue;
        }
        let to_other = other_centre - centre;
        let distance = to_other.length();
        // The point at angle φ is inside the other circle where cos(φ − β) exceeds this (law of cosines).
        let cosine =
            (radius * radius + distance * distance - other_radius * other_radius) / (2.0 * radius * distance);
        if cosine >= 1.0 {
            continue;
        }
        if cosine <= -1.0 {
            return Vec::new();
        }
        let half = cosine.acos();
        let start = (to_other.y.atan2(to_other.x) - half).rem_euclid(TAU);
        covered.push((start, start + 2.0 * half));
    }
    if covered.is_empty() {
        return vec![arc(0.0, TAU)];
    }
    covered.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Once round from the first covered piece's start: the gaps between pieces are exposed.
    let first = covered[0].0;
    let mut reached = first;
    let mut arcs = Vec::new();
    for &(start, end) in covered.iter().chain([&(first + TAU, first + TAU)]) {
        if start - reached > SHORTEST {
            let from = reached.rem_euclid(TAU);
            arcs.push(arc(from, from + (start - reached)));
        }
        reached = reached.max(end);
    }
    arcs
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{Atom, Shape};

    fn tee(size: f64) -> Boundary {
        Boundary::of(&Molecule::named(Shape::Tee, 0.01 * size, 2.0).unwrap(), 0.01)
    }

    fn close(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-9, "{found} is not {expected}");
    }

    #[test]
    fn a_lone_disc_is_exposed_all_round() {
        let disc = Boundary::of(&Molecule::disc(0.3, 1.0).unwrap(), 0.2);
        close(disc.perimeter(), TAU * 0.5);
        assert_eq!(disc.exposure(1.0), 1);
        assert!(disc.unreachable().is_empty());
    }

    /// Two circles of radius s at distance d: each loses 2 acos(d / 2s).
    #[test]
    fn a_dumbbell_loses_where_its_circles_overlap() {
        let dumbbell = Boundary::of(&Molecule::named(Shape::Dumbbell, 0.5, 1.0).unwrap(), 0.5);
        let lost = 2.0 * 0.5f64.acos();
        close(dumbbell.exposed_angle(0), TAU - lost);
        close(dumbbell.exposed_angle(1), TAU - lost);
        close(dumbbell.perimeter(), 2.0 * (TAU - lost));
    }

    /// Closed forms from the triangles of three touching circles; s = 3a.
    #[test]
    fn tee_of_relative_size_one_half() {
        let tee = tee(0.5);
        let (third, root) = ((1.0f64 / 3.0).acos(), (2.0f64.sqrt() / 3.0).acos());
        let a = 1.75 * PI - root - third;
        let d = 2.0 * (0.5 * PI - third + 0.25 * PI - root);
        let expected = [a, PI - 2.0 * third, a, d, PI + 2.0 * (0.5 * PI - third)];
        for (atom, angle) in expected.into_iter().enumerate() {
            close(tee.exposed_angle(atom), angle);
        }
        assert!((tee.exposed_angle(0).to_degrees() - 182.5967).abs() < 1e-4);
        assert!((tee.exposed_angle(3).to_degrees() - 5.1935).abs() < 1e-4);
        assert!((tee.perimeter() - 0.164_481_17).abs() < 1e-8);
        assert!(tee.unreachable().is_empty());
        // Levels between the steps at 19.471°, 70.529°, 109.471°, 160.529°, 196.875°, 199.471°, 253.126°, …
        let levels = [
            (10.0, 2),
            (45.0, 1),
            (90.0, 3),
            (135.0, 1),
            (180.0, 2),
            (198.0, 3),
            (225.0, 2),
            (270.0, 1),
            (315.0, 2),
            (342.0, 3),
            (350.0, 2),
        ];
        for (degrees, count) in levels {
            assert_eq!(tee.exposure(f64::to_radians(degrees)), count, "{degrees}°");
        }
    }

    /// s = 5a: the inner corner is too narrow for the probe to reach the middle of the stem.
    #[test]
    fn tee_of_relative_size_one_quarter() {
        let tee = tee(0.25);
        let a = PI + 0.6f64.acos() - 0.2f64.acos();
        for (atom, angle) in [a, PI - 2.0 * 0.2f64.acos(), a, 0.0, PI].into_iter().enumerate() {
            close(tee.exposed_angle(atom), angle);
        }
        assert!((tee.perimeter() - 0.111_790_09).abs() < 1e-8);
        assert_eq!(tee.unreachable(), [3]);
        for (degrees, count) in [(40.0, 1), (90.0, 3), (140.0, 1), (200.0, 2), (270.0, 1), (330.0, 2)] {
            assert_eq!(tee.exposure(f64::to_radians(degrees)), count, "{degrees}°");
        }
    }

    /// A free tee of mass 10 in an ideal gas of mass 1, kT = 1: rate and shares from an independent quadrature with
    /// the moment of inertia of uniform discs.
    #[test]
    fn shares_of_contacts_of_a_free_tee() {
        let molecule = Molecule::named(Shape::Tee, 0.005, 2.0).unwrap();
        let inverse_moment = 1.0 / molecule.moment_of_inertia();
        let weight = |arc: &Arc, normal: f64| {
            let lever = arc.centre.perp_dot(DVec2::from_angle(normal));
            (1.0 + 0.1 + lever * lever * inverse_moment).sqrt()
        };
        let boundary = tee(0.5);
        let rate = boundary.integral(weight) / TAU.sqrt();
        assert!((rate - 0.070_917_76).abs() < 1e-8, "{rate}");
        let shares: Vec<f64> =
            boundary.by_atom(weight).iter().map(|part| part / boundary.integral(weight)).collect();
        for (share, expected) in shares.iter().zip([0.28947, 0.06018, 0.28947, 0.00807, 0.35280]) {
            assert!((share - expected).abs() < 5e-6, "{shares:?}");
        }
    }

    #[test]
    fn sectors_add_up_and_lie_opposite_to_the_normal() {
        let tee = tee(0.5);
        let sectors = tee.by_impulse_direction(360, |_, _| 1.0);
        close(sectors.iter().sum::<f64>(), tee.perimeter());
        let level = 0.015 * 1f64.to_radians();
        // The flat top of the bar exposes three atoms; what strikes it pushes down, to 270°.
        close(sectors[270] / level, 3.0);
        close(sectors[90] / level, 1.0);
        close(sectors[0] / level, 2.0);
        // Sectors without a step have a whole number of atoms.
        let whole =
            sectors.iter().filter(|part| ((*part / level).round() - *part / level).abs() < 1e-9).count();
        assert_eq!(whole, 360 - 10);
    }

    #[test]
    fn an_atom_inside_another_is_unreachable() {
        let big = Atom::new(DVec2::ZERO, 1.0, 1.0).unwrap();
        let small = Atom::new(DVec2::new(0.3, 0.0), 0.1, 1.0).unwrap();
        let molecule = Molecule::new([big, small]).unwrap();
        assert_eq!(Boundary::of(&molecule, 0.5).unreachable(), [1]);
    }
}
