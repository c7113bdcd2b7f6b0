//! Searches a few atoms of A against a few of B: the first steps for all pairs at once (structure
//! of arrays), then the pairs one by one.

use carom_geometry::{Atom, Circle, CircleTree};
use glam::DVec2;

use crate::{
    ErrorBound, Parts, Phase, Touch,
    atom_pair::AtomPair,
    flight::{Flight, Pose},
    gap_search::GapFunction,
    search::{PairOutcome, Search},
    skimming::rounding_within,
    tolerance::{SHARED_STEPS, STEP_MARGIN},
    trace::Recorder,
};

/// The most atoms of one body in a block.
const MAX_ATOMS: usize = CircleTree::CROSSOVER;

/// The number of lanes of the longest row: whole SIMD registers.
const MAX_LANES: usize = MAX_ATOMS.next_multiple_of(2);

/// The number of pairs that a block can hold.
const LENGTH: usize = MAX_ATOMS * MAX_LANES;

/// Atoms of one body, by index.
#[derive(Clone, Copy)]
pub(crate) struct Atoms<'a> {
    pub(crate) all: &'a [Atom],
    pub(crate) indices: &'a [u32],
}

/// The atoms of one body in its frame, as a structure of arrays with `N` lanes. The last atom fills
/// the unused lanes.
struct Row<const N: usize> {
    x: [f64; N],
    y: [f64; N],
    radius: [f64; N],
    arm: [f64; N],
    /// Radii of the circles about the centre of mass inside which the atoms stay.
    reach: [f64; N],
}

/// One atom: its position and velocity relative to the centre of mass, its radius and the bound ω²
/// r on its acceleration.
struct Single {
    place: DVec2,
    velocity: DVec2,
    radius: f64,
    centripetal: f64,
}

/// Data common to all pairs of a block. `error` is E of the bodies' bounding circles, which is at
/// least that of any of their atoms.
pub(crate) struct BlockSearch<'a> {
    pub(crate) flight: &'a Flight<'a>,
    error: ErrorBound,
    /// The rounding that is added to the reach of each pair.
    inflation: f64,
}

impl<'a> BlockSearch<'a> {
    pub(crate) fn new(flight: &'a Flight<'a>, radii: [f64; 2]) -> Self {
        let circles = radii.map(|radius| Circle {
            offset: DVec2::ZERO,
            arm: radius,
            radius,
        });
        Self {
            flight,
            error: ErrorBound::of_circles(flight.motion, flight.speed, flight.spin, &circles),
            inflation: rounding_within(flight.motion, radii[0] + radii[1]),
        }
    }

    /// Searches all pairs of the atoms `a` and `b` in the order of their certified bounds, and
    /// skips pairs whose bound is later than the limit of the search. No pair may touch before
    /// `begin`.
    pub(crate) fn search<R: Recorder>(
        &self,
        a: Atoms<'_>,
        b: Atoms<'_>,
        begin: f64,
        search: &mut Search<R>,
    ) {
        // The body with more atoms is along the rows.
        let along = usize::from(b.indices.len() >= a.indices.len());
        let (across, row) = if along == 1 { (a, b) } else { (b, a) };
        let mut room = [f64::INFINITY; LENGTH];
        let stride = match row.indices.len() {
            ..=2 => self.first_bounds::<2, R>([across, row], along, begin, &mut room, search),
            3..=4 => self.first_bounds::<4, R>([across, row], along, begin, &mut room, search),
            _ => self.first_bounds::<MAX_LANES, R>([across, row], along, begin, &mut room, search),
        };
        let bounds = &mut room[..across.indices.len().min(MAX_ATOMS) * stride];
        // The pair with the earliest bound first. Mostly only one or two pairs are searched.
        let mut steps = [0; LENGTH];
        loop {
            let [(next, bound), (_, pause)] = two_least(bounds);
            let limit = search.limit();
            if bound > limit {
                break;
            }
            let (i, j) = (next as u32 / stride as u32, next as u32 % stride as u32);
            let (i, j) = (across.indices[i as usize], row.indices[j as usize]);
            let atoms = if along == 1 { [i, j] } else { [j, i] };
            let circles = [
                Circle::from(&a.all[atoms[0] as usize]),
                Circle::from(&b.all[atoms[1] as usize]),
            ];
            let pair = AtomPair::new(self.flight, circles);
            search
                .recorder
                .concerns(|| Parts::Pair(Touch::Atoms(atoms[0], atoms[1])));
            bounds[next] = match pair.first_contact(bound, [pause, limit], &mut steps[next], search)
            {
                PairOutcome::Paused(time) => time,
                outcome => {
                    search.record(outcome, atoms);
                    f64::INFINITY
                }
            }
        }
    }

    /// Writes the time up to which each pair is certified free, row by row, and returns the number
    /// `N` of lanes in a row. The time is infinite for pairs that are never within reach of each
    /// other, and for lanes without an atom.
    fn first_bounds<const N: usize, R: Recorder>(
        &self,
        [across, row]: [Atoms<'_>; 2],
        along: usize,
        begin: f64,
        room: &mut [f64; LENGTH],
        search: &mut Search<R>,
    ) -> usize {
        let bounds = &mut room[..across.indices.len().min(MAX_ATOMS) * N];
        let lanes = Row::<N>::new(row);
        self.start(across, &lanes, bounds);
        let pairs = (across.indices.len() * row.indices.len()) as u32;
        self.shared_step(across, &lanes, along, &self.flight.at(begin), bounds);
        search.evaluations += pairs;
        record_bounds::<N, R>([across, row], along, begin, bounds, &mut search.recorder);
        // Another shared step from the earliest bound. It pays less for few rows.
        let again = across.indices.len().saturating_sub(1).min(SHARED_STEPS);
        let mut before = begin;
        for _ in 0..again {
            let soonest =
                bounds.iter().fold(
                    f64::INFINITY,
                    |least, &bound| if bound < least { bound } else { least },
                );
            if soonest <= before || soonest > search.limit() {
                break;
            }
            self.shared_step(across, &lanes, along, &self.flight.at(soonest), bounds);
            search.evaluations += pairs;
            record_bounds::<N, R>([across, row], along, soonest, bounds, &mut search.recorder);
            before = soonest;
        }
        if row.indices.len() < N {
            bounds
                .iter_mut()
                .skip(N - 1)
                .step_by(N)
                .for_each(|bound| *bound = f64::INFINITY);
        }
        N
    }

    /// Initializes the bounds without evaluating a gap: 0, or infinite if the centres pass each
    /// other beyond the reach of the pair, as in [`skim`](crate::skim).
    #[inline]
    fn start<const N: usize>(&self, across: Atoms<'_>, row: &Row<N>, bounds: &mut [f64]) {
        let motion = self.flight.motion;
        let speed_squared = motion.velocity.length_squared();
        let cross = motion.separation.perp_dot(motion.velocity);
        for (&index, bounds) in across.indices.iter().zip(bounds.chunks_exact_mut(N)) {
            let atom = &across.all[index as usize];
            let other = atom.arm() + atom.radius();
            for (lane, bound) in bounds.iter_mut().enumerate() {
                let reach = (row.reach[lane] + other) + self.inflation;
                *bound = if reach * reach * speed_squared < cross * cross {
                    f64::INFINITY
                } else {
                    0.0
                };
            }
        }
    }

    /// Advances the bound of each pair by one certified step with the curvature bound K, where that
    /// is later than the present bound.
    ///
    /// The step uses the gap less E and its rate less E', so that no gap falls below 0. It takes
    /// the root in the form for a falling gap for all pairs. For a widening gap this form cancels;
    /// the square root is enlarged by more than the resulting error.
    #[inline]
    fn shared_step<const N: usize>(
        &self,
        across: Atoms<'_>,
        row: &Row<N>,
        along: usize,
        at: &Pose,
        bounds: &mut [f64],
    ) {
        let error = self.error.at(at.time);
        let [constant, over_distance] = self.error.rate_terms(error);
        let sign = if along == 1 { 1.0 } else { -1.0 };
        let (separation, velocity) = (sign * at.separation, sign * self.flight.motion.velocity);
        let spin = self.flight.spin[along];
        let turned = at.arm(along, DVec2::X);
        for (&index, bounds) in across.indices.iter().zip(bounds.chunks_exact_mut(N)) {
            let atom = Single::new(self.flight, &across.all[index as usize], at, 1 - along);
            let mut later = [0.0; N];
            for (lane, later) in later.iter_mut().enumerate() {
                let arm_x = turned.x * row.x[lane] - turned.y * row.y[lane];
                let arm_y = turned.y * row.x[lane] + turned.x * row.y[lane];
                let x = separation.x + (arm_x - atom.place.x);
                let y = separation.y + (arm_y - atom.place.y);
                let vx = velocity.x + (-spin * arm_y - atom.velocity.x);
                let vy = velocity.y + (spin * arm_x - atom.velocity.y);
                let k = spin * spin * row.arm[lane] + atom.centripetal;
                let distance = (x * x + y * y).sqrt();
                let gap = (distance - (row.radius[lane] + atom.radius)) - error;
                // Touching pairs and NaN get no step.
                let gap = if gap > 0.0 { gap } else { 0.0 };
                let rate = ((x * vx + y * vy) - over_distance) / distance - constant;
                let root = (rate * rate + 2.0 * k * gap).sqrt() * (1.0 + STEP_MARGIN);
                let step = 2.0 * gap / (root - rate);
                let step = if step > 0.0 { step } else { 0.0 };
                *later = at.time + step * (1.0 - STEP_MARGIN);
            }
            for (bound, later) in bounds.iter_mut().zip(later) {
                *bound = if later > *bound { later } else { *bound };
            }
        }
    }
}

impl<const N: usize> Row<N> {
    #[inline]
    fn new(atoms: Atoms<'_>) -> Self {
        // There is at least one atom: bodies without atoms are walls and are not searched here.
        let last = atoms.indices.len() - 1;
        let atoms: [&Atom; N] =
            std::array::from_fn(|lane| &atoms.all[atoms.indices[lane.min(last)] as usize]);
        Self {
            x: atoms.map(|atom| atom.offset().x),
            y: atoms.map(|atom| atom.offset().y),
            radius: atoms.map(Atom::radius),
            arm: atoms.map(Atom::arm),
            reach: atoms.map(|atom| atom.arm() + atom.radius()),
        }
    }
}

impl Single {
    #[inline]
    fn new(flight: &Flight<'_>, atom: &Atom, at: &Pose, body: usize) -> Self {
        let spin = flight.spin[body];
        let place = at.arm(body, atom.offset());
        Self {
            place,
            velocity: spin * place.perp(),
            radius: atom.radius(),
            centripetal: spin * spin * atom.arm(),
        }
    }
}

/// Records a shared step at `time`: each pair is certified free up to its bound.
#[inline(always)]
fn record_bounds<const N: usize, R: Recorder>(
    [across, row]: [Atoms<'_>; 2],
    along: usize,
    time: f64,
    bounds: &[f64],
    recorder: &mut R,
) {
    if !R::RECORDS {
        return;
    }
    for (&i, bounds) in across.indices.iter().zip(bounds.chunks_exact(N)) {
        for (&j, &bound) in row.indices.iter().zip(bounds) {
            let touch = if along == 1 {
                Touch::Atoms(i, j)
            } else {
                Touch::Atoms(j, i)
            };
            recorder.concerns(|| Parts::Pair(touch));
            recorder.step(Phase::Shared, time, Some(bound));
        }
    }
}

/// Index and value of the least and of the second least number.
#[inline]
fn two_least(values: &[f64]) -> [(usize, f64); 2] {
    let mut least = [(0, f64::INFINITY); 2];
    for found in values.iter().copied().enumerate() {
        if found.1 < least[0].1 {
            least = [found, least[0]];
        } else if found.1 < least[1].1 {
            least[1] = found;
        }
    }
    least
}
