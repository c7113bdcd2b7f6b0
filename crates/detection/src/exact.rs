//! The certified detector: safe Newton steps on the gap, each proven to pass over no contact.
//!
//! For an atom pair let d(t) be the vector between the centres, s the sum of the radii, g = |d| − s the
//! gap, n = d/|d|, g' = n·d'. Free flight bounds the curvature for all time:
//! |d''| ≤ K = ω_A² r_A + ω_B² r_B.
//!
//! **Step.** For any fixed unit vector n, |d(t+h)| ≥ n·d(t+h) ≥ n·d + n·d' h − K h²/2, so with n taken
//! at t there is no contact before the root of g + g' h − K h²/2. Taking that root as the next time
//! converges quadratically to a transversal contact, and can never pass one.
//!
//! **Rounding.** The computed gap is off by at most E ([`ErrorBound`]). A pair is passed as free only
//! where the computed gap exceeds E, hence only where it is truly apart; so no contact deeper than 2 E is
//! missed, and every contact reported has a gap within 2 E.
//!
//! **In contact.** Where the gap is below E the sign of g' decides. g' has its own bound E' =
//! L (2 E/|d| + 8 u) + (|ω_A| + |ω_B|) E + δV, L = |V| + |ω_A| r_A + |ω_B| r_B (errors of the normal, of the
//! arms, and of the velocities that the motion came with). Closing faster than E': a contact, now. Deeper
//! than −E and closing faster than the velocities resolve: likewise. Else the pair has just collided, or
//! only touches: it is followed by steps to where g + (g' − E') h − K h²/2 reaches min(g, 0) − E, which skip
//! nothing deeper than the present gap less E.
//!
//! **Acceptance.** From concavity of the square root |d(t+h)| ≤ |d| + g' h + (K + |d'|²/|d|) h²/2, so a step
//! with (K + |d'|²/|d|) h² ≤ E lands on the contact to within E and is taken without looking again; the
//! last Newton correction −g/g' is guarded by the same bound.
//!
//! **Bound on the work.** Each pair has [`MOST_STEPS`] steps; a search that runs out answers "certified free
//! until", which is never wrong. When one pair runs out before another pair's contact, the answer is the
//! earlier time.

use carom_geometry::{Atom, Outline};
use carom_kinematics::{HALF_ULP as U, RelativeMotion};
use glam::DVec2;
use smallvec::SmallVec;

use crate::{
    Answer, Contact, Detection, DiscBatch, ErrorBound, LANES, Outcome, Touch, Window, disc_contact, skim,
    tolerance::{MOST_STEPS, STEP_MARGIN},
};

/// The certified detector; see the [crate](crate) and the table of detectors there.
///
/// ```
/// use carom_detection::{Detection, Exact, Outcome, Touch};
/// use carom_geometry::{Molecule, Shape};
/// use carom_kinematics::RelativeMotion;
/// use glam::DVec2;
///
/// // A dumbbell turns on the spot (arms 1, ω = 1) and strikes a disc at rest, 2 + √2 radii away:
/// // contact when the atoms' centres are 2 radii apart.
/// let dumbbell = Molecule::named(Shape::Dumbbell, 1.0, 1.0)?;
/// let disc = Molecule::disc(1.0, 1.0)?;
/// let pair = RelativeMotion {
///     angular_velocity: [1.0, 0.0],
///     ..RelativeMotion::exactly(DVec2::new(0.0, 2.5), DVec2::ZERO)
/// };
/// let answer = Exact::default().first_contact(dumbbell.outline(), disc.outline(), &pair, 10.0);
/// let Outcome::Contact(contact) = answer.outcome else { panic!("it is struck") };
/// // Law of cosines: 2² = 1² + 2.5² − 2 · 2.5 cos ψ, struck at a quarter turn less ψ.
/// let psi = f64::acos((1.0 + 6.25 - 4.0) / 5.0);
/// assert!((contact.time - (std::f64::consts::FRAC_PI_2 - psi)).abs() < 1e-15);
/// assert_eq!(contact.touch, Touch::Atoms(1, 0));
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Exact {
    /// Most steps for one atom pair; see [`MOST_STEPS`].
    pub most_steps: u32,
}

impl Default for Exact {
    fn default() -> Self {
        Self { most_steps: MOST_STEPS }
    }
}

impl Detection for Exact {
    fn first_contact(&self, a: Outline<'_>, b: Outline<'_>, motion: &RelativeMotion, horizon: f64) -> Answer {
        let free = Answer { outcome: Outcome::Free, evaluations: 0 };
        let Some(window) = skim(motion, a.bounding_radius + b.bounding_radius, horizon) else { return free };
        if turns(a, motion.angular_velocity[0]) || turns(b, motion.angular_velocity[1]) {
            turning(a, b, motion, window, self.most_steps)
        } else {
            straight(a, b, motion, window.end)
        }
    }

    fn disc_contacts(&self, batch: &DiscBatch, times: &mut [f64; LANES]) {
        batch.contact_times(times);
    }
}

fn turns(body: Outline<'_>, spin: f64) -> bool {
    spin != 0.0 && body.atoms.iter().any(|atom| atom.arm() != 0.0)
}

/// Bodies that do not turn: each atom pair is a pair of discs.
fn straight(a: Outline<'_>, b: Outline<'_>, motion: &RelativeMotion, horizon: f64) -> Answer {
    let rotations = motion.orientation.map(|orientation| orientation.cos_sin());
    let mut best: Option<Contact> = None;
    for (i, atom_a) in a.atoms.iter().enumerate() {
        let arm_a = rotations[0].rotate(atom_a.offset());
        for (j, atom_b) in b.atoms.iter().enumerate() {
            let arm_b = rotations[1].rotate(atom_b.offset());
            let d = motion.separation + (arm_b - arm_a);
            let sigma = atom_a.radius() + atom_b.radius();
            let errors = (ErrorBound::new(motion, atom_a, atom_b).at(0.0), motion.velocity_error);
            let time = disc_contact(d, motion.velocity, sigma, errors);
            if time <= horizon && best.is_none_or(|found| time < found.time) {
                best = Some(Contact { time, touch: Touch::Atoms(i as u32, j as u32) });
            }
        }
    }
    Answer {
        outcome: best.map_or(Outcome::Free, Outcome::Contact),
        evaluations: (a.atoms.len() * b.atoms.len()) as u32,
    }
}

/// Bodies that turn: one shared first step, then the atom pairs in the order of their certified bounds,
/// capped by the earliest contact so far.
fn turning(
    a: Outline<'_>,
    b: Outline<'_>,
    motion: &RelativeMotion,
    window: Window,
    most_steps: u32,
) -> Answer {
    let mut evaluations = 0;
    let mut queue: SmallVec<[(f64, u32, u32); 32]> = SmallVec::new();
    for (i, atom_a) in a.atoms.iter().enumerate() {
        for (j, atom_b) in b.atoms.iter().enumerate() {
            let pair = AtomPair::new(motion, atom_a, atom_b);
            evaluations += 1;
            let bound = pair.certified_free_until(window.begin);
            if bound <= window.end {
                queue.push((bound, i as u32, j as u32));
            }
        }
    }
    queue.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then_with(|| (x.1, x.2).cmp(&(y.1, y.2))));
    let mut best: Option<Contact> = None;
    let mut out_of_budget = f64::INFINITY;
    for (bound, i, j) in queue {
        let limit = best.map_or(window.end, |found| found.time);
        if bound > limit {
            break;
        }
        let pair = AtomPair::new(motion, &a.atoms[i as usize], &b.atoms[j as usize]);
        let begin = Window { begin: bound, end: limit };
        match pair.first_contact(begin, most_steps, &mut evaluations) {
            PairOutcome::Contact(time) if best.is_none_or(|found| time < found.time) => {
                best = Some(Contact { time, touch: Touch::Atoms(i, j) });
            }
            PairOutcome::Contact(_) | PairOutcome::Free => {}
            PairOutcome::OutOfBudget(time) => out_of_budget = out_of_budget.min(time),
        }
    }
    let outcome = match best {
        Some(contact) if contact.time <= out_of_budget => Outcome::Contact(contact),
        _ if out_of_budget.is_finite() => Outcome::FreeUntil(out_of_budget),
        _ => Outcome::Free,
    };
    Answer { outcome, evaluations }
}

/// How the search for one atom pair ended.
enum PairOutcome {
    Contact(f64),
    Free,
    OutOfBudget(f64),
}

/// One atom of A and one of B in flight.
struct AtomPair<'a> {
    motion: &'a RelativeMotion,
    offsets: [DVec2; 2],
    /// Sum of the radii, s.
    contact_distance: f64,
    /// K: bound on |d''| for all time.
    curvature: f64,
    /// L: bound on |d'| for all time.
    speed: f64,
    error: ErrorBound,
}

/// The gap at one moment.
struct Gap {
    /// g
    gap: f64,
    /// g'
    rate: f64,
    /// |d|
    distance: f64,
    /// E
    error: f64,
    /// K + |d'|²/|d|: bound on the upward curvature of the gap.
    upper_curvature: f64,
}

impl<'a> AtomPair<'a> {
    fn new(motion: &'a RelativeMotion, a: &Atom, b: &Atom) -> Self {
        let [spin_a, spin_b] = motion.angular_velocity.map(f64::abs);
        let (arm_a, arm_b) = (a.arm(), b.arm());
        Self {
            motion,
            offsets: [a.offset(), b.offset()],
            contact_distance: a.radius() + b.radius(),
            curvature: spin_a * spin_a * arm_a + spin_b * spin_b * arm_b,
            speed: motion.velocity.length() + (spin_a * arm_a + spin_b * arm_b),
            error: ErrorBound::new(motion, a, b),
        }
    }

    fn gap(&self, time: f64) -> Gap {
        let motion = self.motion;
        let arm = |body: usize| {
            let spin = motion.angular_velocity[body];
            motion.orientation[body].turned(spin, time).cos_sin().rotate(self.offsets[body])
        };
        let (arm_a, arm_b) = (arm(0), arm(1));
        let d = (motion.separation + motion.velocity * time) + (arm_b - arm_a);
        let velocity = motion.velocity
            + (motion.angular_velocity[1] * arm_b.perp() - motion.angular_velocity[0] * arm_a.perp());
        let distance = d.length();
        let rate = if distance > 0.0 { d.dot(velocity) / distance } else { 0.0 };
        Gap {
            gap: distance - self.contact_distance,
            rate,
            distance,
            error: self.error.at(time),
            upper_curvature: self.curvature + velocity.length_squared() / distance,
        }
    }

    /// A time up to which the pair is certainly apart, by one step from `begin`; `begin` itself if it may
    /// be in contact there.
    fn certified_free_until(&self, begin: f64) -> f64 {
        let now = self.gap(begin);
        if now.gap > now.error { begin + self.free_step(&now) } else { begin }
    }

    fn first_contact(&self, window: Window, most_steps: u32, evaluations: &mut u32) -> PairOutcome {
        let mut time = window.begin;
        for _ in 0..most_steps {
            let now = self.gap(time);
            *evaluations += 1;
            let step = if now.gap > now.error {
                let step = self.free_step(&now);
                if now.rate < 0.0 && now.upper_curvature * step * step <= now.error {
                    return contact_within(time + step, window.end);
                }
                step
            } else if self.closes(&now) {
                return contact_within(time + polish(&now), window.end);
            } else {
                self.touching_step(&now)
            };
            time = (time + step).max(time.next_up());
            if time > window.end {
                return PairOutcome::Free;
            }
        }
        PairOutcome::OutOfBudget(time)
    }

    /// Root of g + g' h − K h²/2, in the form that does not cancel, shortened by the rounding of h.
    fn free_step(&self, now: &Gap) -> f64 {
        let k = self.curvature;
        let root = (now.rate * now.rate + 2.0 * k * now.gap).sqrt();
        let step =
            if now.rate < 0.0 { 2.0 * now.gap / (root - now.rate) } else { parting_step(now.rate, root, k) };
        step * (1.0 - STEP_MARGIN)
    }

    /// Whether a pair within E of contact, or overlapping, is in contact rather than leaving or touching.
    fn closes(&self, now: &Gap) -> bool {
        let resolved = self.motion.velocity_error;
        let threshold = if now.gap < -now.error { resolved } else { self.rate_error(now) };
        now.rate < -threshold
    }

    /// E': bound on the rounding of g'.
    fn rate_error(&self, now: &Gap) -> f64 {
        let [spin_a, spin_b] = self.motion.angular_velocity.map(f64::abs);
        let turning = (spin_a + spin_b) * now.error;
        self.speed * (2.0 * now.error / now.distance + 8.0 * U) + turning + self.motion.velocity_error
    }

    /// Step of a pair that leaves or touches: to where the bound from below reaches min(g, 0) − E.
    fn touching_step(&self, now: &Gap) -> f64 {
        let k = self.curvature;
        let rate = if now.distance > now.error { now.rate - self.rate_error(now) } else { 0.0 };
        let root = (rate * rate + 2.0 * k * (now.gap - now.gap.min(0.0) + now.error)).sqrt();
        let step = if rate < 0.0 {
            2.0 * (now.gap - now.gap.min(0.0) + now.error) / (root - rate)
        } else {
            parting_step(rate, root, k)
        };
        step * (1.0 - STEP_MARGIN)
    }
}

/// (g' + root) / K for a pair that parts; without curvature it never comes back.
fn parting_step(rate: f64, root: f64, curvature: f64) -> f64 {
    if curvature == 0.0 { f64::INFINITY } else { (rate + root) / curvature }
}

/// The last Newton correction towards g = 0, where it provably lands within E of it.
fn polish(now: &Gap) -> f64 {
    let correction = -now.gap / now.rate;
    let safe = now.gap > 0.0 && now.upper_curvature * correction * correction <= now.error;
    if safe { correction } else { 0.0 }
}

fn contact_within(time: f64, limit: f64) -> PairOutcome {
    if time <= limit { PairOutcome::Contact(time) } else { PairOutcome::Free }
}
