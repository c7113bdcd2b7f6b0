//! Broad phase: lower bounds on the contact times of a query body with the bodies around it.
//!
//! Every candidate is replaced by its bounding circle, a disc. There are three bounds, of
//! increasing cost and tightness: the time at which the disc enters the query body's bounding
//! circle, its [rectangle](crate::rectangle), or its [atoms](crate::atom_row).
//!
//! # Lemmas
//! 1. **Rotating frame.** Let R be the rotation of the query body, ω its angular velocity and J the
//!    quarter turn. Let the centre of a disc be at d relative to the body's centre of mass and move
//!    with the relative velocity V. In the frame that moves and turns with the body the centre is
//!    at p = R⁻¹ d, with p' = R⁻¹ V − ω J p. *Proof.* (R⁻¹)' = −ω J R⁻¹.
//! 2. **Rounding.** Let e be the error of d in the lanes and δ the error of the angle of R. The
//!    error of p is at most e + δ |d|, and that of p' at most the error of V plus |ω| e + δ (|V| +
//!    |ω| |d|). The gap to a disc at p, and its rate, take fewer than 32 roundings each. The code
//!    subtracts 64 roundings from each.

use carom_geometry::Outline;
use carom_kinematics::{HALF_ULP as U, Motion};
use glam::DVec2;

use crate::{
    DiscLanes, atom_row::apart_from_atoms, rectangle::apart_from_rectangle,
    relative_disc::RelativeDisc,
};

/// The body whose contacts are computed, in its orientation at the time of the query.
#[derive(Debug, Clone, Copy)]
pub struct QueryBody<'a> {
    /// Its shape: atoms, bounding circle, face.
    pub outline: Outline<'a>,
    /// (cos θ, sin θ) of its orientation.
    pub rotation: DVec2,
    /// Bound on the error of θ (radians).
    pub rotation_error: f64,
    /// Angular velocity (radians per time).
    pub angular_velocity: f64,
}

impl<'a> QueryBody<'a> {
    /// A query body with the given outline and motion at `now` (time).
    #[inline]
    pub fn new(outline: Outline<'a>, motion: &Motion, now: f64) -> Self {
        let angular_velocity = motion.angular_velocity;
        let duration = now - motion.time;
        Self {
            outline,
            rotation: motion
                .orientation
                .turned(angular_velocity, duration)
                .cos_sin(),
            // As for a relative motion, plus the rounding of cosine and sine.
            rotation_error: U * (5.0 * (angular_velocity * duration).abs() + 8.0),
            angular_velocity,
        }
    }

    /// Lower bounds on the contact times with the discs of all lanes, from their circles and from
    /// this body's rectangle (time from now; infinite if there is no contact). A value past
    /// `horizon` only excludes contacts before `horizon`.
    #[inline(always)]
    pub(crate) fn contact_time_lower_bounds<const N: usize>(
        &self,
        lanes: &DiscLanes<N>,
        horizon: f64,
    ) -> [f64; N] {
        let mut times = lanes.entry_times();
        let Some(corners) = self.outline.rectangle() else {
            return times;
        };
        for (lane, time) in times.iter_mut().enumerate() {
            let later = apart_from_rectangle(
                corners,
                &self.relative_disc(lanes, lane),
                self.angular_velocity,
                horizon,
            );
            *time = if later > *time { later } else { *time };
        }
        times
    }

    /// A tighter lower bound for one disc within reach of this body's circle: from the atoms if
    /// they are few, from the rectangle otherwise.
    #[inline(always)]
    pub(crate) fn contact_time_lower_bound(&self, lanes: &DiscLanes<1>, horizon: f64) -> f64 {
        let Some(corners) = self.outline.rectangle() else {
            return 0.0;
        };
        let (disc, spin) = (self.relative_disc(lanes, 0), self.angular_velocity);
        match self.outline.rows() {
            [] => apart_from_rectangle(corners, &disc, spin, horizon),
            rows => apart_from_atoms(rows, &disc, spin),
        }
    }

    #[inline(always)]
    fn relative_disc<const N: usize>(&self, lanes: &DiscLanes<N>, lane: usize) -> RelativeDisc {
        let (cos, sin) = (self.rotation.x, self.rotation.y);
        let spin = self.angular_velocity;
        let (dx, dy) = (lanes.separation[0][lane], lanes.separation[1][lane]);
        let (vx, vy) = (lanes.velocity[0][lane], lanes.velocity[1][lane]);
        let (x, y) = (cos * dx + sin * dy, cos * dy - sin * dx);
        let reach = lanes.contact_distance[lane];
        let distance = dx.abs() + dy.abs();
        let speed = vx.abs() + vy.abs();
        RelativeDisc {
            place: [x, y],
            rate: [
                (cos * vx + sin * vy) + spin * y,
                (cos * vy - sin * vx) - spin * x,
            ],
            distance,
            speed,
            radius: reach - self.outline.bounding_radius,
            error: lanes.separation_error
                + self.rotation_error * distance
                + 64.0 * U * (distance + reach),
            rate_error: lanes.velocity_error(lane)
                + spin.abs() * lanes.separation_error
                + (self.rotation_error + 64.0 * U) * (speed + spin.abs() * distance),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Detection, Exact};
    use carom_geometry::{Atom, Molecule, Shape, gap_between};
    use carom_kinematics::{Orientation, RelativeMotion};
    use proptest::prelude::*;

    /// A molecule that turns, some time after its motion was set, and another body.
    struct Encounter {
        molecule: Molecule,
        other: Molecule,
        motion: Motion,
        since: f64,
        pair: RelativeMotion,
    }

    impl Encounter {
        fn new(
            [molecule, other]: [Molecule; 2],
            motion: Motion,
            since: f64,
            (place, velocity): (DVec2, DVec2),
            (turns, spin): (f64, f64),
        ) -> Self {
            let pair = RelativeMotion {
                orientation: [
                    motion.orientation.turned(motion.angular_velocity, since),
                    Orientation::from_turns(turns),
                ],
                angular_velocity: [motion.angular_velocity, spin],
                ..RelativeMotion::exactly(place, velocity)
            };
            Self {
                molecule,
                other,
                motion,
                since,
                pair,
            }
        }

        fn query(&self) -> QueryBody<'_> {
            QueryBody::new(self.molecule.outline(), &self.motion, self.since)
        }

        fn gap(&self) -> f64 {
            let [a, b] = self.pair.orientation.map(Orientation::cos_sin);
            gap_between(&self.molecule, a, &self.other, b, self.pair.separation)
        }

        /// The bound for the other body alone, as a scheduler requests it.
        fn contact_time_lower_bounds(&self, horizon: f64) -> f64 {
            let lane = |v: DVec2| [[v.x], [v.y]];
            let lanes = DiscLanes {
                separation: lane(self.pair.separation),
                velocity: lane(self.pair.velocity),
                cross: [self.pair.separation.perp_dot(self.pair.velocity)],
                contact_distance: [self.molecule.bounding_radius() + self.other.bounding_radius()],
                separation_error: 0.0,
                speed: 0.0,
            };
            let [bound] =
                Exact::default().contact_time_lower_bounds(&self.query(), &lanes, horizon);
            if self.other.is_disc() {
                bound.max(Exact::default().contact_time_lower_bound(&self.query(), &lanes, horizon))
            } else {
                bound
            }
        }

        fn first_contact(&self, begin: f64, horizon: f64) -> Option<f64> {
            let (a, b) = (self.molecule.outline(), self.other.outline());
            let answer = Exact::default().first_contact_after(begin, a, b, &self.pair, horizon);
            answer.outcome.contact().map(|contact| contact.time)
        }
    }

    fn turning(turns: f64, spin: f64) -> Motion {
        Motion {
            orientation: Orientation::from_turns(turns),
            angular_velocity: spin,
            ..Motion::at_rest(DVec2::ZERO)
        }
    }

    fn shapes() -> impl Strategy<Value = Molecule> {
        let shape = prop_oneof![
            (2usize..20).prop_map(Shape::Rod),
            Just(Shape::Tee),
            Just(Shape::Cross),
            Just(Shape::Dumbbell),
            Just(Shape::Disc),
        ];
        shape.prop_map(|shape| Molecule::named(shape, 0.25, 1.0).unwrap())
    }

    proptest! {
        #![proptest_config(ProptestConfig { max_global_rejects: 1 << 24, ..ProptestConfig::default() })]

        /// No contact is before the bound, and the bound is not trivial.
        #[test]
        fn no_contact_is_before_the_bound(
            count in 2usize..20, turns in -0.5..0.5f64, spin in -3.0..3.0f64, since in 0.0..10.0f64,
            places in prop::array::uniform8((-8.0..8.0f64, -8.0..8.0f64, -2.0..2.0f64, -2.0..2.0f64)),
            horizon in 0.1..4.0f64,
        ) {
            let rod = Molecule::named(Shape::Rod(count), 0.25, 1.0).unwrap();
            let disc = Molecule::disc(0.5, 1.0).unwrap();
            let motion = turning(turns, spin);
            let query = QueryBody::new(rod.outline(), &motion, since);
            let mut lanes = DiscLanes::empty(0.0, 0.0);
            for (lane, (x, y, vx, vy)) in places.into_iter().enumerate() {
                lanes.set(lane, DVec2::new(x, y), DVec2::new(vx, vy), rod.bounding_radius() + 0.5);
            }
            let bounds = Exact::default().contact_time_lower_bounds(&query, &lanes, horizon);
            let entries = lanes.entry_times();
            for (lane, (x, y, vx, vy)) in places.into_iter().enumerate() {
                let flight = (DVec2::new(x, y), DVec2::new(vx, vy));
                let encounter = Encounter::new([rod.clone(), disc.clone()], motion, since, flight, (0.0, 0.0));
                prop_assert!(bounds[lane] >= entries[lane]);
                if let Some(contact) = encounter.first_contact(0.0, horizon) {
                    prop_assert!(contact >= bounds[lane].min(horizon), "{contact} {}", bounds[lane]);
                }
            }
        }

        /// Also for pairs whose bounding circles overlap, and for two molecules. A search that
        /// begins at the bound finds the same contact, except for grazes, which are too rare to
        /// occur here.
        #[test]
        fn no_contact_of_one_pair_is_before_its_bound(
            molecule in shapes(), other in shapes(), turns in prop::array::uniform2(-0.5..0.5f64),
            spins in prop::array::uniform2(-20.0..20.0f64), since in 0.0..10.0f64,
            distance in 0.3..1.2f64, direction in -3.2..3.2f64, vx in -2.0..2.0f64, vy in -2.0..2.0f64,
            horizon in 0.01..4.0f64,
        ) {
            let reach = molecule.bounding_radius() + other.bounding_radius();
            let flight = (distance * reach * DVec2::from_angle(direction), DVec2::new(vx, vy));
            let motion = turning(turns[0], spins[0]);
            let encounter = Encounter::new([molecule, other], motion, since, flight, (turns[1], spins[1]));
            prop_assume!(encounter.gap() > 1e-12);
            let bound = encounter.contact_time_lower_bounds(horizon);
            let found = encounter.first_contact(0.0, horizon);
            if let Some(contact) = found {
                prop_assert!(contact >= bound.min(horizon), "{contact} {bound}");
            }
            match (found, encounter.first_contact(bound, horizon)) {
                (Some(one), Some(other)) => prop_assert!((one - other).abs() < 1e-11, "{one} {other}"),
                (one, other) => prop_assert_eq!(one, other),
            }
        }

        /// A disc that has just left an atom is certified free up to where it may return.
        #[test]
        fn a_pair_that_has_just_met_is_apart_until_it_may_meet_again(
            atom in 0usize..5, turns in -0.5..0.5f64, spin in -20.0..20.0f64, direction in -3.2..3.2f64,
            vx in -2.0..2.0f64, vy in -2.0..2.0f64,
        ) {
            let tee = Molecule::named(Shape::Tee, 0.25, 1.0).unwrap();
            let disc = Molecule::disc(0.5, 1.0).unwrap();
            let motion = turning(turns, spin);
            let arm = motion.orientation.cos_sin().rotate(tee.atoms()[atom].offset());
            let normal = DVec2::from_angle(direction);
            let flight = (arm + 0.75 * normal, DVec2::new(vx, vy));
            let encounter = Encounter::new([tee, disc], motion, 0.0, flight, (0.0, 0.0));
            // No other atom overlaps the disc.
            prop_assume!(encounter.gap() > -1e-15);
            let rate = normal.dot(DVec2::new(vx, vy) - spin * arm.perp());
            prop_assume!(rate.abs() > 0.02);
            let bound = encounter.contact_time_lower_bounds(10.0);
            let contact = encounter.first_contact(0.0, 10.0);
            if rate < 0.0 {
                prop_assert!(bound < 1e-12 && contact.is_some_and(|contact| contact < 1e-12), "{contact:?} {bound}");
            } else {
                // A disc that may return at once is left to the search.
                prop_assert!(bound > 0.0 || rate < 0.2);
                prop_assert!(contact.is_none_or(|contact| contact >= bound), "{contact:?} {bound}");
            }
        }
    }

    #[test]
    fn no_directed_search_exceeds_the_bounds_on_place_and_rate() {
        use crate::error_bound::tests::{Big, PRECISION, Random, big, directed_search};
        let tee = Molecule::named(Shape::Tee, 0.25, 1.0).unwrap();
        let pi = Big::pi(PRECISION);
        let ratios = |state: &[f64; 9]| {
            let [x, y, vx, vy, turns, spin, since, until, radius] = *state;
            let motion = Motion {
                time: since,
                ..turning(turns, spin)
            };
            let query = QueryBody::new(tee.outline(), &motion, until);
            let mut lanes = DiscLanes::empty(0.0, 0.0);
            lanes.set(
                0,
                DVec2::new(x, y),
                DVec2::new(vx, vy),
                tee.bounding_radius() + radius.abs(),
            );
            let disc = query.relative_disc(&lanes, 0);
            let turned = big(spin) * (big(until) - big(since));
            let (sin, cos) = (big(2.0 * motion.orientation.turns()) * &pi + turned).sin_cos();
            let back =
                |x: f64, y: f64| [&cos * big(x) + &sin * big(y), &cos * big(y) - &sin * big(x)];
            let ([px, py], [qx, qy]) = (back(x, y), back(vx, vy));
            let exact_rate = [qx + big(spin) * &py, qy - big(spin) * &px];
            let off = |computed: f64, exact: &Big| (big(computed) - exact).to_f64().value();
            let place = off(disc.place[0], &px).hypot(off(disc.place[1], &py));
            let rate = off(disc.rate[0], &exact_rate[0]).hypot(off(disc.rate[1], &exact_rate[1]));
            [place / disc.error, rate / disc.rate_error]
        };
        let mut random = Random(21);
        for which in 0..2 {
            for [place, velocity, spin, time] in [
                [1.0, 1.0, 1.0, 1.0],
                [1.0, 1e-9, 1e6, 1.0],
                [1e-3, 1.0, 1e3, 1e-6],
                [1.0, 1e-9, 1e9, 1.0],
            ] {
                let scales = [place, place, velocity, velocity, 0.5, spin, time, time, 1.0];
                let state = |random: &mut Random| scales.map(|scale| scale * random.next());
                let worst =
                    directed_search(&mut random, 200, 800, state, |state| ratios(state)[which]);
                // Half of the bound is for the gap and its rate, which are computed next.
                assert!(worst <= 1.0, "number {which}, {scales:?}: {worst}");
            }
        }
    }

    #[test]
    fn a_disc_beside_a_resting_rod_is_apart_until_it_comes_to_its_side() {
        let rod = Molecule::named(Shape::Rod(50), 0.25, 1.0).unwrap();
        let query = QueryBody::new(rod.outline(), &Motion::at_rest(DVec2::ZERO), 0.0);
        let mut lanes = DiscLanes::empty(0.0, 0.0);
        lanes.set(
            0,
            DVec2::new(3.0, 2.75),
            DVec2::new(0.3, -1.0),
            rod.bounding_radius() + 0.5,
        );
        assert_eq!(lanes.entry_times()[0], 0.0);
        let bound = Exact::default().contact_time_lower_bounds(&query, &lanes, 10.0)[0];
        assert!((bound - 2.0).abs() < 1e-12, "{bound}");
    }

    #[test]
    fn a_disc_over_an_atom_of_a_resting_dumbbell_is_apart_until_it_touches_it() {
        let [dumbbell, disc] =
            [Shape::Dumbbell, Shape::Disc].map(|shape| Molecule::named(shape, 1.0, 1.0));
        // Falls on the atom at x = 1.
        let flight = (DVec2::new(1.0, 2.5), DVec2::new(0.0, -1.0));
        let pair = [dumbbell.unwrap(), disc.unwrap()];
        let encounter = Encounter::new(pair, turning(0.0, 0.0), 0.0, flight, (0.0, 0.0));
        let bound = encounter.contact_time_lower_bounds(10.0);
        assert!((bound - 0.5).abs() < 1e-12, "{bound}");
    }

    /// An atom on a circle approaches a disc inside that circle, which moves on in a straight line:
    /// g − ω² a t²/2.
    #[test]
    fn the_bounds_are_reached_by_a_disc_within_the_circle_of_an_atom() {
        let atoms = [-10.0, 10.0].map(|x| Atom::new(DVec2::new(x, 0.0), 1.0, 1.0).unwrap());
        let pair = || {
            [
                Molecule::new(atoms).unwrap(),
                Molecule::disc(1.0, 1.0).unwrap(),
            ]
        };
        let spin = 0.5;
        let acceleration = spin * spin * 10.0;
        // Beside the atom at the same velocity; and touching the atom and leaving it.
        let gap = 1e-3;
        let (beside, leaving) = (
            f64::sqrt(2.0 * gap / acceleration),
            2.0 * 0.05 / acceleration,
        );
        for (gap, away, expected) in [(gap, 0.0, beside), (0.0, 0.05, leaving)] {
            let flight = (DVec2::new(8.0 - gap, 0.0), DVec2::new(-away, spin * 10.0));
            let encounter = Encounter::new(pair(), turning(0.0, spin), 0.0, flight, (0.0, 0.0));
            let bound = encounter.contact_time_lower_bounds(10.0);
            let contact = encounter
                .first_contact(0.0, 10.0)
                .expect("the atom reaches the disc");
            assert!((bound / expected - 1.0).abs() < 1e-9, "{bound} {expected}");
            assert!(
                (1.0..1.01).contains(&(contact / bound)),
                "{contact} {bound}"
            );
        }
    }

    /// At the smallest allowed sizes and angular velocities, where squared velocities are still
    /// representable.
    #[test]
    fn the_bound_holds_where_products_are_all_but_zero() {
        for (size, spin) in [
            (1e-60, 1e-20),
            (1e-60, 1e-43),
            (1e-60, 1e-60),
            (1.0, 1e-100),
            (1.0, 1e-120),
            (1e60, 1.0),
        ] {
            let atoms = [-size, size].map(|x| Atom::new(DVec2::new(x, 0.0), size, 1.0).unwrap());
            let pair = [
                Molecule::new(atoms).unwrap(),
                Molecule::disc(size, 1.0).unwrap(),
            ];
            let flight = (DVec2::new(size, 2.2 * size), DVec2::ZERO);
            let encounter = Encounter::new(pair, turning(0.0, spin), 0.0, flight, (0.0, 0.0));
            let horizon = 1.0 / spin;
            let bound = encounter.contact_time_lower_bounds(horizon);
            let contact = encounter
                .first_contact(0.0, horizon)
                .expect("an atom reaches the disc");
            assert!(
                bound <= contact,
                "{size:e}, {spin:e}: {bound:e} {contact:e}"
            );
            let again = encounter.first_contact(bound, horizon);
            assert!(
                again.is_some_and(|again| (again / contact - 1.0).abs() < 1e-9),
                "{again:?} {contact:e}"
            );
        }
    }

    #[test]
    fn a_search_that_begins_after_its_end_finds_nothing() {
        let flight = (DVec2::new(4.0, 0.0), DVec2::NEG_X);
        let pair =
            [Shape::Dumbbell, Shape::Disc].map(|shape| Molecule::named(shape, 0.5, 1.0).unwrap());
        let encounter = Encounter::new(pair, turning(0.0, 1.0), 0.0, flight, (0.0, 0.0));
        assert!(encounter.first_contact(0.0, 10.0).is_some());
        for begin in [11.0, f64::INFINITY] {
            assert_eq!(encounter.first_contact(begin, 10.0), None);
        }
    }
}
