//! Predictions of kinetic theory for the kicks: directions, rates and magnitudes.

use std::f64::consts::{PI, TAU};

use carom::{
    Molecule,
    geometry::{BoundaryPoint, ExcludedRegion, GeometryError},
};
use glam::DVec2;

/// Predictions for a molecule in the gas.
#[derive(Debug, Clone)]
pub struct Prediction {
    /// Boundary of the region excluded to gas centres.
    pub boundary: ExcludedRegion,
    /// Radius of the gas discs (length).
    pub gas_radius: f64,
    /// Mass of a gas disc.
    pub gas_mass: f64,
    inverse_mass: f64,
    inverse_moment: f64,
}

impl Prediction {
    /// Predictions for a molecule, which contacts may turn, in a gas of discs of this radius
    /// (length) and mass.
    ///
    /// # Errors
    /// The radius of the gas discs is out of range.
    pub fn new(
        molecule: &Molecule,
        turns: bool,
        [gas_radius, gas_mass]: [f64; 2],
    ) -> Result<Self, GeometryError> {
        Ok(Self {
            boundary: ExcludedRegion::new(molecule, gas_radius)?,
            gas_radius,
            gas_mass,
            inverse_mass: 1.0 / molecule.mass(),
            inverse_moment: if turns {
                1.0 / molecule.moment_of_inertia()
            } else {
                0.0
            },
        })
    }

    /// Predictions for a molecule that contacts may move and turn, in a gas of discs of this radius
    /// (length) and mass.
    ///
    /// # Errors
    /// The molecule is a wall, or the radius of the gas discs is out of range.
    pub fn with(
        molecule: &Molecule,
        [moves, turns]: [bool; 2],
        gas: [f64; 2],
    ) -> Result<Self, GeometryError> {
        let moving = Self::new(molecule, turns, gas)?;
        let inverse_mass = if moves { moving.inverse_mass } else { 0.0 };
        Ok(Self {
            inverse_mass,
            ..moving
        })
    }

    /// Area fraction of gas discs of this number density (1 / length²).
    pub fn area_fraction(&self, density: f64) -> f64 {
        density * PI * self.gas_radius * self.gas_radius
    }

    /// Share of the impulse in each sector of directions, in a dilute gas: N(φ) of the opposite
    /// direction, normalised.
    pub fn impulse_shares(&self, sectors: usize) -> Vec<f64> {
        self.boundary.direction_shares(sectors)
    }

    /// Share of the contacts in each sector of directions, in a dilute gas.
    pub fn count_shares(&self, sectors: usize) -> Vec<f64> {
        let whole = self.boundary.integral(|contact| self.frequency(contact));
        let parts = self
            .boundary
            .by_impulse_direction(sectors, |contact| self.frequency(contact));
        parts.iter().map(|part| part / whole).collect()
    }

    /// Share of the contacts on each atom, and then on each straight edge, in a dilute gas.
    pub fn part_shares(&self) -> Vec<f64> {
        let mut parts = self.boundary.by_atom(|contact| self.frequency(contact));
        parts.extend(self.boundary.by_edge(|contact| self.frequency(contact)));
        let whole: f64 = parts.iter().sum();
        parts.iter().map(|part| part / whole).collect()
    }

    /// Contacts per time in an ideal gas: n √(kT / 2π) ∮ μ^(−1/2) ds.
    pub fn ideal_rate(&self, density: f64, temperature: f64) -> f64 {
        let integral = self.boundary.integral(|contact| self.frequency(contact));
        density * (temperature / TAU).sqrt() * integral
    }

    /// Share of the velocity that the molecule loses at a contact on average, along the axis along
    /// which it loses least, and share of the angular velocity; 0 for one that contacts do not
    /// turn.
    ///
    /// Kinetic theory with uncorrelated contacts: the friction is n √(8kT/π) ∮ μ^(1/2) (a·n)² ds,
    /// with a a unit vector, and n √(8kT/π) ∮ μ^(1/2) l² ds for the rotation, with the lever arm l.
    /// The rate of contacts is n √(kT/2π) ∮ μ^(−1/2) ds; the quotient has no n and kT.
    pub fn forgotten_at_a_contact(&self) -> [f64; 2] {
        let contacts = self.contacts();
        self.forgotten().map(|sum| sum / contacts)
    }

    /// ∮ μ^(−1/2) ds: proportional to the contacts per time of a gas of given density.
    pub fn contacts(&self) -> f64 {
        self.boundary.integral(|contact| self.frequency(contact))
    }

    /// The shares of [`Self::forgotten_at_a_contact`] times [`Self::contacts`].
    pub fn forgotten(&self) -> [f64; 2] {
        let over = |weight: &dyn Fn(DVec2, f64) -> f64| {
            self.boundary.integral(|contact| {
                let normal = DVec2::from_angle(contact.normal);
                weight(normal, contact.foot.perp_dot(normal)) / self.frequency(contact)
            })
        };
        let [xx, yy] = [
            over(&|normal, _| normal.x * normal.x),
            over(&|normal, _| normal.y * normal.y),
        ];
        let xy = over(&|normal, _| normal.x * normal.y);
        // The smaller eigenvalue of a symmetric matrix.
        let least = 0.5 * (xx + yy) - (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
        let levers = over(&|_, lever| lever * lever);
        [self.inverse_mass * least, self.inverse_moment * levers].map(|sum| 4.0 * sum)
    }

    /// μ^(−1/2); the number of contacts on a piece of the boundary is proportional to it.
    fn frequency(&self, contact: &BoundaryPoint) -> f64 {
        let lever = contact.lever();
        (1.0 / self.gas_mass + self.inverse_mass + lever * lever * self.inverse_moment).sqrt()
    }

    /// Density of gas centres at the boundary of a single disc of radius R, relative to the mean:
    /// χ = 1/(1 − η) + (9/16) (2Rr/(R + r)) (η/r)/(1 − η)² (Jenkins and Mancini, J. Appl. Mech. 54
    /// (1987) 27).
    pub fn contact_density_of_disc(&self, radius: f64, density: f64) -> f64 {
        let fraction = self.area_fraction(density);
        let free = 1.0 - fraction;
        let harmonic = 2.0 * radius / (radius + self.gas_radius);
        1.0 / free + 9.0 / 16.0 * harmonic * fraction / (free * free)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{Shape, geometry::Atom};

    /// Radius and mass of the gas discs of the thesis.
    const GAS: [f64; 2] = [0.01, 1.0];

    /// The tee of the thesis with atoms of half the gas radius.
    fn tee() -> Molecule {
        Molecule::named(Shape::Tee, 0.005, 2.0).unwrap()
    }

    /// Predictions for the tee, free to turn or locked.
    fn of_tee(turns: bool) -> Prediction {
        Prediction::new(&tee(), turns, GAS).unwrap()
    }

    /// Predictions for a disc of the area and mass of the tee.
    fn of_disc() -> Prediction {
        let radius = (tee().area() / PI).sqrt();
        Prediction::new(&Molecule::disc(radius, tee().mass()).unwrap(), false, GAS).unwrap()
    }

    /// Exposed angles of an L of five touching discs of radius a, four in a column and one beside
    /// the lowest, for a probe of radius 2a: circles of radius 3a at distances 2a and 2√2 a.
    #[test]
    fn exposed_arcs_of_an_l() {
        let at = [(0.0, 6.0), (0.0, 4.0), (0.0, 2.0), (0.0, 0.0), (2.0, 0.0)];
        let atom = |(x, y)| Atom::new(DVec2::new(x, y), 1.0, 1.0).unwrap();
        let ell = Molecule::new(at.map(atom)).unwrap();
        let region = ExcludedRegion::new(&ell, 2.0).unwrap();
        let (side, diagonal) = ((1.0f64 / 3.0).acos(), (2f64.sqrt() / 3.0).acos());
        let expected = [
            TAU - 2.0 * side,
            TAU - 4.0 * side,
            (0.75 * PI - side - diagonal) + (PI - 2.0 * side),
            1.5 * PI - 2.0 * side,
            1.75 * PI - diagonal - side,
        ];
        for (atom, angle) in expected.into_iter().enumerate() {
            assert!((region.exposed_angle(atom) - angle).abs() < 1e-12, "{atom}");
        }
        assert!((region.perimeter() - 3.0 * expected.iter().sum::<f64>()).abs() < 1e-11);
    }

    /// A gas disc cannot touch the small atom between two large ones, nor the inside of a ring.
    #[test]
    fn what_the_gas_cannot_touch() {
        let atom = |x: f64, radius| Atom::new(DVec2::new(x, 0.0), radius, 1.0).unwrap();
        let hidden = Molecule::new([atom(-1.0, 1.0), atom(0.0, 0.2), atom(1.0, 1.0)]).unwrap();
        let region = ExcludedRegion::new(&hidden, 0.5).unwrap();
        assert_eq!(region.unreachable(), [1]);
        // Two circles of radius 3/2 at distance 2.
        let lost = 2.0 * (2.0f64 / 3.0).acos();
        assert!((region.perimeter() - 2.0 * 1.5 * (TAU - lost)).abs() < 1e-12);
        // Twelve atoms around a hole in which the gas disc would fit, but which it cannot enter.
        let ring = Molecule::named(Shape::Ring(12), 0.5, 1.0).unwrap();
        let region = ExcludedRegion::new(&ring, 0.5).unwrap();
        assert!(!region.hidden_arcs().is_empty() && region.pocket_area() > 0.0);
        assert!(region.unreachable().is_empty());
        // Each atom: a full turn less the angle towards its neighbours and the pocket.
        let turn = TAU / 12.0;
        for atom in 0..12 {
            let expected = PI - 2.0 * 0.5f64.acos() + turn;
            assert!((region.exposed_angle(atom) - expected).abs() < 1e-12);
        }
    }

    /// ∮ n ds = 0 for any closed boundary: at equilibrium in an ideal gas no molecule is pushed,
    /// and none is turned, ∮ r × n ds = 0.
    #[test]
    fn the_mean_force_and_torque_of_an_ideal_gas_are_zero() {
        for shape in [Shape::Tee, Shape::Rod(7), Shape::Ring(9), Shape::Cross] {
            let molecule = Molecule::named(shape, 0.3, 1.0).unwrap();
            let region = ExcludedRegion::new(&molecule, 0.4).unwrap();
            let mean = |weight: &dyn Fn(&BoundaryPoint) -> f64| region.integral(weight).abs();
            let [x, y] = [
                mean(&|contact| contact.normal.cos()),
                mean(&|contact| contact.normal.sin()),
            ];
            let torque = mean(&|contact| contact.lever());
            assert!(x.max(y).max(torque) < 1e-9, "{shape}: {x} {y} {torque}");
        }
    }

    #[test]
    fn a_locked_molecule_is_hit_in_proportion_to_its_boundary() {
        let locked = of_tee(false);
        for (count, impulse) in locked
            .count_shares(360)
            .iter()
            .zip(locked.impulse_shares(360))
        {
            assert!((count - impulse).abs() < 1e-15);
        }
        // √1.1 times the rate of a fixed body.
        assert!((locked.ideal_rate(1.0, 1.0) - 0.068_821_26).abs() < 1e-8);
        assert!((locked.boundary.perimeter() - 0.164_481_17).abs() < 1e-8);
    }

    #[test]
    fn a_free_molecule_is_hit_more_often_far_from_its_centre() {
        let (free, locked) = (of_tee(true), of_tee(false));
        assert!((free.ideal_rate(1.0, 1.0) - 0.070_917_76).abs() < 1e-8);
        assert!(free.part_shares()[4] > locked.part_shares()[4]);
        assert!((free.count_shares(360).iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }

    /// A fixed square of side 4 r and sharp corners: sides 16 r of the perimeter 16 r + 2π r.
    #[test]
    fn the_sides_of_a_square_have_peaks_and_the_corners_the_rest() {
        let square = carom::geometry::EdgedShape::Square;
        let square = square.molecule(4.0 * GAS[0], 1e-9, 1.0).unwrap();
        let prediction = Prediction::with(&square, [false, false], GAS).unwrap();
        let shares = prediction.part_shares();
        let side = 4.0 / (16.0 + TAU);
        for share in &shares[4..] {
            assert!((share / side - 1.0).abs() < 1e-6, "{share}");
        }
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!((shares[4..].iter().sum::<f64>() - 0.71803).abs() < 1e-5);
        let directions = prediction.count_shares(360);
        let corner = (1.0 - 4.0 * side) / 360.0;
        for peak in [0, 90, 180, 270] {
            assert!((directions[peak] - side - corner).abs() < 1e-6);
        }
        assert!((directions[45] - corner).abs() < 1e-6);
    }

    #[test]
    fn the_disc_is_hit_isotropically() {
        let prediction = of_disc();
        for share in prediction.count_shares(360) {
            assert!((share * 360.0 - 1.0).abs() < 1e-12);
        }
    }

    /// The friction of a disc in a dilute gas is n R √(8π μ kT), with R the sum of the radii.
    #[test]
    fn a_disc_loses_its_velocity_by_friction() {
        let prediction = of_disc();
        let [velocity, spin] = prediction.forgotten_at_a_contact();
        let (mass, reduced) = (10.0, 10.0 / 11.0);
        let reach = prediction.boundary.perimeter() / TAU;
        let friction = reach * (8.0 * PI * reduced).sqrt();
        assert!(
            (velocity * prediction.ideal_rate(1.0, 1.0) / (friction / mass) - 1.0).abs() < 1e-9
        );
        assert_eq!(spin, 0.0);
        // A locked tee loses less along x′ than along y′; a free one also loses its rotation.
        let [free, locked] = [true, false].map(of_tee);
        assert!(
            free.forgotten_at_a_contact()[1] > 0.01 && locked.forgotten_at_a_contact()[1] == 0.0
        );
    }

    /// For equal discs the formula reduces to Henderson's χ = (1 − 7η/16)/(1 − η)², here 3.125.
    #[test]
    fn contact_density_of_a_gas_disc() {
        let tee = of_tee(true);
        let half = 0.5 / (PI * tee.gas_radius * tee.gas_radius);
        assert!((tee.contact_density_of_disc(tee.gas_radius, half) - 3.125).abs() < 1e-12);
    }
}
