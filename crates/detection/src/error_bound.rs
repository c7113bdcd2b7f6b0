//! The rounding bounds E and E': how far the computed gap of two atoms and its rate can be from the
//! exact values.
//!
//! # Lemmas
//! To first order in u, in the notation of [`ErrorBound`]:
//!
//! 1. **Flight.** The error of X + V t is at most u (|X| + 3 |V| t). *Proof.* The product takes u
//!    |V t|, the sum u |X + V t|, and the rounding of V, a difference of two velocities, u |V| t.
//! 2. **Arms.** The error of a rotated arm r is at most u r (4 |ω t| + 12). *Proof.* In turns, the
//!    angle takes 3 u |ω t| for the product, the conversion from radians and its constant 1/2π, and
//!    u (|ω t| + π) for the sum with the orientation. Removing whole turns and quarters is exact.
//!    The conversion back to radians takes 1.6 u (product and constant, at most π/4), cosine and
//!    sine 2 u together, and the rotation of r by them 3 u. In all this is u r (4 |ω t| + 10); 12
//!    is taken.
//! 3. **Gap.** The errors of the vector d and of the gap are at most E. *Proof.* To Lemmas 1 and 2
//!    the difference r_B − r_A adds u (r_A + r_B), d adds u |d|, its length 2 u |d|, s adds u s,
//!    and the gap u (|d| + s). With |d| ≤ |X| + |V| t + r_A + r_B these are 4 u more of each term,
//!    and 2 u s.
//! 4. **Rate.** The error of g' = n·d', with n = d/|d|, is at most E'. *Proof.* The error of the
//!    normal is at most 2 E/|d|. In d' = V + ω_B r_B^⊥ − ω_A r_A^⊥ the rotated arms add |ω| times
//!    their share of E, and the four operations 4 u L. The scalar product adds 2 u L, the length
//!    and the division by it 4 u L. In all this is 10 u L; 12 is taken.

use carom_geometry::{Atom, Circle};
use carom_kinematics::{HALF_ULP as U, RelativeMotion};
use glam::DVec2;

/// Bounds on the rounding of the gap between an atom of A and an atom of B, and of its rate.
///
/// With u = 2⁻⁵³, |·|₁ = |x| + |y|, X and V the relative position and velocity of the centres of
/// mass, r the arms of the atoms, s the sum of their radii, ω the angular velocities, and δ the
/// input errors of position, velocity and angles α:
///
/// E(t) = u (5 |X|₁ + 17 (r_A + r_B) + 2 s) + δX + r_A δα_A + r_B δα_B
///      + u (7 |V|₁ + 4 (|ω_A| r_A + |ω_B| r_B)) t
///
/// E'(t) = L (2 E/|d| + 12 u) + max(|ω_A|, |ω_B|) E + δV,  L = |V| + |ω_A| r_A + |ω_B| r_B
///
/// The source of the module proves both bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorBound {
    start: f64,
    rate: f64,
    /// L
    speed: f64,
    /// max(|ω_A|, |ω_B|)
    spin: f64,
    /// δV
    velocity: f64,
}

impl ErrorBound {
    /// The bounds for one pair of atoms.
    pub fn new(motion: &RelativeMotion, a: &Atom, b: &Atom) -> Self {
        let circles = [Circle::from(a), Circle::from(b)];
        Self::of_circles(
            motion,
            motion.velocity.length(),
            motion.angular_velocity,
            &circles,
        )
    }

    /// The bounds for a pair of circles, with |V| as `speed` and the angular velocities as `spin`.
    #[inline]
    pub(crate) fn of_circles(
        motion: &RelativeMotion,
        speed: f64,
        spin: [f64; 2],
        circles: &[Circle; 2],
    ) -> Self {
        let [a, b] = circles;
        let [spin_a, spin_b] = spin.map(f64::abs);
        let rim_speed = spin_a * a.arm + spin_b * b.arm;
        let places = 5.0 * one_norm(motion.separation)
            + 17.0 * (a.arm + b.arm)
            + 2.0 * (a.radius + b.radius);
        let given = motion.separation_error
            + (a.arm * motion.orientation_error[0] + b.arm * motion.orientation_error[1]);
        Self {
            start: U * places + given,
            rate: U * (7.0 * one_norm(motion.velocity) + 4.0 * rim_speed),
            speed: speed + rim_speed,
            spin: spin_a.max(spin_b),
            velocity: motion.velocity_error,
        }
    }

    /// E, the bound on the gap at `time` (length).
    #[inline]
    pub fn at(&self, time: f64) -> f64 {
        self.start + self.rate * time
    }

    /// E', the bound on the rate of the gap at `time`, with the centres `distance` apart (length
    /// per time).
    pub fn of_rate(&self, time: f64, distance: f64) -> f64 {
        let [constant, over_distance] = self.rate_terms(self.at(time));
        constant + over_distance / distance
    }

    /// E' for a given E, as a constant term and the numerator of a term in 1/|d|.
    #[inline]
    pub(crate) fn rate_terms(&self, error: f64) -> [f64; 2] {
        [
            12.0 * U * self.speed + self.spin * error + self.velocity,
            2.0 * self.speed * error,
        ]
    }

    /// max(|ω_A|, |ω_B|) (per time).
    #[inline]
    pub(crate) fn spin(&self) -> f64 {
        self.spin
    }

    /// L, a bound on |d'| at any time (length per time).
    #[inline]
    pub(crate) fn speed(&self) -> f64 {
        self.speed
    }
}

pub(crate) fn one_norm(v: DVec2) -> f64 {
    v.x.abs() + v.y.abs()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::{atom_pair::AtomPair, flight::Flight, gap_search::GapFunction};
    use carom_kinematics::{Motion, Orientation};
    use dashu_float::{FBig, round::mode::HalfEven};

    pub(crate) type Big = FBig<HalfEven, 2>;

    /// About 48 decimal digits; the largest angles below take nine of them.
    pub(crate) const PRECISION: usize = 160;

    pub(crate) fn big(x: f64) -> Big {
        Big::try_from(x).unwrap().with_precision(PRECISION).value()
    }

    /// An arm turned by the exact angle, and its derivative.
    pub(crate) fn arm(
        offset: DVec2,
        orientation: Orientation,
        spin: f64,
        time: f64,
        pi: &Big,
    ) -> [[Big; 2]; 2] {
        let angle = big(2.0 * orientation.turns()) * pi + big(spin) * big(time);
        let (sin, cos) = angle.sin_cos();
        let (x, y) = (big(offset.x), big(offset.y));
        let turned = [&x * &cos - &y * &sin, &x * &sin + &y * &cos];
        let derivative = [-(big(spin) * &turned[1]), big(spin) * &turned[0]];
        [turned, derivative]
    }

    /// g and g' to about 40 digits, and |d|.
    fn exact(motion: &RelativeMotion, atoms: [&Atom; 2], time: f64, pi: &Big) -> (Big, Big, f64) {
        let [a, b] = [0, 1].map(|body| {
            arm(
                atoms[body].offset(),
                motion.orientation[body],
                motion.angular_velocity[body],
                time,
                pi,
            )
        });
        let component = |k: usize| {
            let d = big(motion.separation[k])
                + big(motion.velocity[k]) * big(time)
                + (&b[0][k] - &a[0][k]);
            (d, big(motion.velocity[k]) + (&b[1][k] - &a[1][k]))
        };
        let ((x, vx), (y, vy)) = (component(0), component(1));
        let distance = (&x * &x + &y * &y).sqrt();
        let rate = (&x * vx + &y * vy) / &distance;
        let length = distance.to_f64().value();
        (
            distance - (big(atoms[0].radius()) + big(atoms[1].radius())),
            rate,
            length,
        )
    }

    /// Numbers between −1 and 1 (SplitMix64; Steele, Lea and Flood 2014).
    pub(crate) struct Random(pub(crate) u64);

    impl Random {
        pub(crate) fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let mut z = self.0;
            z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            (z ^ (z >> 31)) as i64 as f64 / 2f64.powi(63)
        }

        pub(crate) fn vector(&mut self) -> DVec2 {
            DVec2::new(self.next(), self.next())
        }
    }

    /// Worst |computed − exact| over the bound, of g and of g', among `count` random states.
    fn worst_ratios(count: u32, distance: f64, spin: f64, duration: f64) -> [f64; 2] {
        let pi = Big::pi(PRECISION);
        let mut random = Random(2017);
        let mut worst = [0.0f64; 2];
        for _ in 0..count {
            let atoms = [0, 1]
                .map(|_| Atom::new(random.vector(), random.next().abs() + 1e-3, 1.0).unwrap());
            let motion = RelativeMotion {
                orientation: [0, 1].map(|_| Orientation::from_turns(0.5 * random.next())),
                angular_velocity: [0, 1].map(|_| spin * random.next()),
                ..RelativeMotion::exactly(distance * random.vector(), random.vector())
            };
            let time = duration * random.next().abs();
            let (a, b) = (atoms[0].outline(), atoms[1].outline());
            let flight = Flight::new(a, b, &motion);
            let pair = AtomPair::new(&flight, [Circle::from(&atoms[0]), Circle::from(&atoms[1])]);
            let now = pair.gap(&pair.pose(time));
            let (gap, rate, length) = exact(&motion, [&atoms[0], &atoms[1]], time, &pi);
            let off = |computed: f64, exact: Big| (big(computed) - exact).to_f64().value().abs();
            let bound = ErrorBound::new(&motion, &atoms[0], &atoms[1]);
            worst[0] = worst[0].max(off(now.value, gap) / bound.at(time));
            worst[1] = worst[1].max(off(now.rate, rate) / bound.of_rate(time, length));
        }
        worst
    }

    /// Tests states near the start, at the origin of time, after 10⁸ turns, and a million sizes
    /// away.
    fn check(count: u32) {
        for (distance, spin, duration) in [
            (3.0, 3.0, 3.0),
            (2.0, 1.0, 0.0),
            (3.0, 1e8, 6.0),
            (1e6, 3.0, 1e6),
        ] {
            let [gap, rate] = worst_ratios(count / 4, distance, spin, duration);
            eprintln!(
                "distance {distance:e}, spin {spin:e}: worst |error|/E {gap:.2}, |error|/E' {rate:.2}"
            );
            assert!(gap <= 1.0 && rate <= 1.0, "{gap} {rate}");
            // The bounds are not trivially wide.
            assert!(gap > 0.05 && rate > 0.01, "{gap} {rate}");
        }
    }

    #[test]
    fn bounds_hold_for_random_states() {
        check(4_000);
    }

    /// Searches for the state with the largest ratio. From the worst of some random states on,
    /// single numbers are changed in their last or leading digits, and changes that raise the ratio
    /// are kept. Returns the largest ratio.
    pub(crate) fn directed_search<const N: usize>(
        random: &mut Random,
        starts: u32,
        changes: u32,
        state: impl Fn(&mut Random) -> [f64; N],
        ratio: impl Fn(&[f64; N]) -> f64,
    ) -> f64 {
        let mut worst = (0.0, [0.0; N]);
        for _ in 0..starts {
            let state = state(random);
            let found = ratio(&state);
            if found > worst.0 {
                worst = (found, state);
            }
        }
        for change in 0..changes {
            let mut state = worst.1;
            let number = (random.next().abs() * N as f64) as usize % N;
            state[number] *= match change % 3 {
                0 => 1.0 + 4.0 * f64::EPSILON * random.next(),
                1 => 1.0 + 1e-8 * random.next(),
                _ => 1.0 + 0.1 * random.next(),
            };
            let found = ratio(&state);
            if found > worst.0 {
                worst = (found, state);
            }
        }
        worst.0
    }

    /// Error over bound of the gap and of its rate for two atoms in a state of 16 numbers.
    fn ratios(state: &[f64; 16], pi: &Big) -> [f64; 2] {
        let [
            ax,
            ay,
            ar,
            bx,
            by,
            br,
            x,
            y,
            vx,
            vy,
            turns_a,
            turns_b,
            spin_a,
            spin_b,
            time,
            _,
        ] = *state;
        let atom =
            |x, y, radius: f64| Atom::new(DVec2::new(x, y), radius.abs() + 1e-9, 1.0).unwrap();
        let atoms = [atom(ax, ay, ar), atom(bx, by, br)];
        let motion = RelativeMotion {
            orientation: [turns_a, turns_b].map(Orientation::from_turns),
            angular_velocity: [spin_a, spin_b],
            ..RelativeMotion::exactly(DVec2::new(x, y), DVec2::new(vx, vy))
        };
        let time = time.abs();
        let flight = Flight::new(atoms[0].outline(), atoms[1].outline(), &motion);
        let pair = AtomPair::new(&flight, [Circle::from(&atoms[0]), Circle::from(&atoms[1])]);
        let now = pair.gap(&pair.pose(time));
        let (gap, rate, length) = exact(&motion, [&atoms[0], &atoms[1]], time, pi);
        let off = |computed: f64, exact: Big| (big(computed) - exact).to_f64().value().abs();
        let bound = ErrorBound::new(&motion, &atoms[0], &atoms[1]);
        [
            off(now.value, gap) / bound.at(time),
            off(now.rate, rate) / bound.of_rate(time, length),
        ]
    }

    #[test]
    fn no_directed_search_exceeds_the_bounds() {
        let pi = Big::pi(PRECISION);
        let mut random = Random(18);
        for which in 0..2 {
            // Each term of the bounds alone: positions, arms, radii, rotation, flight; then all
            // together.
            for scale in [
                [1.0, 1e-6, 1e-6, 1e-9, 1e-9, 0.0],
                [1e-6, 1.0, 1e-6, 1e-9, 1.0, 1e-6],
                [1e-6, 1e-6, 1.0, 1e-9, 1e-9, 0.0],
                [1e-6, 1.0, 1e-6, 1e-9, 1e6, 1.0],
                [1e-3, 1e-6, 1e-6, 1.0, 1e-9, 1e6],
                [1.0; 6],
            ] {
                let [place, arm, radius, velocity, spin, time] = scale;
                let scales = [
                    arm, arm, radius, arm, arm, radius, place, place, velocity, velocity, 0.5, 0.5,
                    spin, spin, time, 0.0,
                ];
                let state = |random: &mut Random| scales.map(|scale| scale * random.next());
                let worst = directed_search(&mut random, 100, 600, state, |state| {
                    ratios(state, &pi)[which]
                });
                assert!(worst <= 1.0, "number {which}, {scale:?}: {worst}");
            }
        }
    }

    #[test]
    fn relative_motions_are_within_their_errors() {
        let pi = Big::pi(PRECISION);
        let mut random = Random(19);
        let motion_of = |state: &[f64], since: f64| Motion {
            position: DVec2::new(state[0], state[1]),
            velocity: DVec2::new(state[2], state[3]),
            orientation: Orientation::from_turns(state[4]),
            angular_velocity: state[5],
            time: since,
        };
        let off = |computed: f64, exact: Big| (big(computed) - exact).to_f64().value().abs();
        let ratios = |state: &[f64; 16]| {
            let [a, b] = [
                motion_of(&state[..6], state[12]),
                motion_of(&state[6..12], state[13]),
            ];
            let (time, shift) = (state[14], state[15]);
            let pair = RelativeMotion::between(&a, &b, DVec2::new(shift, 0.0), time);
            let place = |motion: &Motion, axis: usize| {
                big(motion.position[axis])
                    + big(motion.velocity[axis]) * (big(time) - big(motion.time))
            };
            let dx = off(pair.separation.x, place(&b, 0) - place(&a, 0) + big(shift));
            let dy = off(pair.separation.y, place(&b, 1) - place(&a, 1));
            let radians = |motion: &Motion| {
                big(2.0 * motion.orientation.turns()) * &pi
                    + big(motion.angular_velocity) * (big(time) - big(motion.time))
            };
            let turned = |index: usize, motion: &Motion| {
                let exact = radians(motion) - big(2.0 * pair.orientation[index].turns()) * &pi;
                let turns = (&exact / (&pi * big(2.0))).round();
                (exact - turns * &pi * big(2.0)).to_f64().value().abs()
                    / pair.orientation_error[index]
            };
            [
                dx.hypot(dy) / pair.separation_error,
                turned(0, &a).max(turned(1, &b)),
            ]
        };
        for which in 0..2 {
            for spin in [1.0, 1e3, 1e9] {
                let scales = [
                    1.0, 1.0, 1.0, 1.0, 0.5, spin, 1.0, 1.0, 1.0, 1.0, 0.5, spin, 1e-16, 1.0, 2.0,
                    1.0,
                ];
                let state = |random: &mut Random| scales.map(|scale| scale * random.next());
                let worst =
                    directed_search(&mut random, 200, 1500, state, |state| ratios(state)[which]);
                assert!(
                    worst > 0.2 && worst <= 1.0,
                    "number {which}, spin {spin:e}: {worst}"
                );
            }
        }
        // A state at which the error exceeds 4 |ω Δt| u, in place of 5 |ω Δt| u, by 1.5 %.
        let spin = 1_075_499_723.352_964_4;
        let turns = -0.282_691_642_053_091_7;
        let mut state = [0.0; 16];
        (state[4], state[5], state[12], state[14]) = (
            turns,
            spin,
            1.110_221_965_833_972_5e-16,
            1.000_089_908_950_030_8,
        );
        let worst = ratios(&state)[1];
        assert!(worst > 0.8 && worst <= 1.0, "{worst}");
    }
}
