//! A few atoms of A against a few of B: a few steps for all pairs at once, then the pairs one by one.

use carom_geometry::{Atom, Circle, CircleTree};

use crate::{
    ErrorBound,
    atom_pair::{AtomPair, PairOutcome},
    flight::{Flight, Placement},
    search::Search,
    skimming::rounding_within,
    tolerance::{SHARED_STEPS, STEP_MARGIN},
};

/// Most atoms of one body in a block.
const MOST: usize = CircleTree::CROSSOVER;

/// Room for all pairs of a block, and for the unused end of its last row.
const LENGTH: usize = MOST * MOST + 1;

/// Some atoms of one body, by their indices.
#[derive(Clone, Copy)]
pub(crate) struct Atoms<'a> {
    pub(crate) all: &'a [Atom],
    pub(crate) indices: &'a [u32],
}

/// Two numbers side by side, the width of the vector registers that every x86-64 has.
type Lanes = [f64; 2];

/// Places and velocities about the centre of mass, and what bounds their change, of the atoms of one body.
#[derive(Default)]
struct Row {
    x: [Lanes; MOST.div_ceil(2)],
    y: [Lanes; MOST.div_ceil(2)],
    vx: [Lanes; MOST.div_ceil(2)],
    vy: [Lanes; MOST.div_ceil(2)],
    radius: [Lanes; MOST.div_ceil(2)],
    reach: [Lanes; MOST.div_ceil(2)],
    centripetal: [Lanes; MOST.div_ceil(2)],
}

/// One atom of a row.
struct Single {
    x: f64,
    y: f64,
    vx: f64,
    vy: f64,
    radius: f64,
    /// Radius of the circle about the centre of mass that the atom never leaves.
    reach: f64,
    centripetal: f64,
}

/// What the pairs of a block have in common: E of the bodies' bounding circles, which is not below that of any of
/// their atoms.
pub(crate) struct BlockSearch<'a> {
    pub(crate) flight: &'a Flight<'a>,
    error: ErrorBound,
    /// What the reach of any pair is inflated by.
    inflation: f64,
}

impl<'a> BlockSearch<'a> {
    pub(crate) fn new(flight: &'a Flight<'a>, radii: [f64; 2]) -> Self {
        let circles = radii.map(|radius| Circle { offset: glam::DVec2::ZERO, arm: radius, radius });
        Self {
            flight,
            error: ErrorBound::of_circles(flight.motion, flight.speed, flight.spin, &circles),
            inflation: rounding_within(flight.motion, radii[0] + radii[1]),
        }
    }

    /// Searches all pairs of the atoms `a` and `b`, none of which touch before `begin`, in the order of
    /// certified bounds; those beyond the best so far are left.
    pub(crate) fn search(&self, a: Atoms<'_>, b: Atoms<'_>, begin: f64, search: &mut Search) {
        // The body with more atoms goes along the rows.
        let along = usize::from(b.indices.len() >= a.indices.len());
        let (across, row) = if along == 1 { (a, b) } else { (b, a) };
        let mut room = [0.0; LENGTH];
        self.shared_step(across, row, along, &self.flight.at(begin), &mut room);
        let bounds = &mut room[..across.indices.len() * row.indices.len()];
        search.evaluations += bounds.len() as u32;
        // Again from where the soonest pair may be in contact. For a single atom against a row it would not pay.
        let again = if across.indices.len() > 1 { SHARED_STEPS } else { 0 };
        for _ in 0..again {
            let (_, soonest) = least(bounds);
            if soonest <= begin || soonest > search.limit() {
                break;
            }
            let mut later = [0.0; LENGTH];
            self.shared_step(across, row, along, &self.flight.at(soonest), &mut later);
            search.evaluations += bounds.len() as u32;
            for (bound, later) in bounds.iter_mut().zip(later) {
                *bound = bound.max(later);
            }
        }
        // The pair with the earliest bound, as long as it is that, and so on: mostly one or two pairs are ever wanted.
        let mut steps = [0; LENGTH];
        loop {
            let (next, bound) = least(bounds);
            let limit = search.limit();
            if bound > limit || bound == f64::INFINITY {
                break;
            }
            bounds[next] = f64::INFINITY;
            let (_, pause) = least(bounds);
            let (i, j) = (next as u32 / row.indices.len() as u32, next as u32 % row.indices.len() as u32);
            let (i, j) = (across.indices[i as usize], row.indices[j as usize]);
            let atoms = if along == 1 { [i, j] } else { [j, i] };
            let circles = [Circle::from(&a.all[atoms[0] as usize]), Circle::from(&b.all[atoms[1] as usize])];
            let pair = AtomPair::new(self.flight, circles);
            match pair.first_contact(bound, [pause, limit], &mut steps[next], search) {
                PairOutcome::Paused(time) => bounds[next] = time,
                outcome => search.record(outcome, atoms),
            }
        }
    }

    /// The certified step with K for every pair: until when each is certainly free, row by row.
    ///
    /// The gap less E and its rate less E' are used, so no gap is below 0 up to there. Each row is written in whole
    /// lanes, the next one over its unused end.
    fn shared_step(
        &self,
        across: Atoms<'_>,
        row: Atoms<'_>,
        along: usize,
        at: &Placement,
        bounds: &mut [f64; LENGTH],
    ) {
        let error = self.error.at(at.time);
        let [constant, over_distance] = self.error.rate_terms(error);
        let sign = if along == 1 { 1.0 } else { -1.0 };
        let (separation, velocity) = (sign * at.separation, sign * self.flight.motion.velocity);
        let speed_squared = velocity.length_squared();
        let cross = self.flight.motion.separation.perp_dot(velocity);
        let row_of_pairs = Row::new(self.flight, row, at, along);
        let count = row.indices.len();
        for (i, &index) in across.indices.iter().enumerate() {
            let atom = Single::new(self.flight, &across.all[index as usize], at, 1 - along);
            for pair in 0..count.div_ceil(2).min(MOST.div_ceil(2)) {
                let first = i * count + 2 * pair;
                let Some(to) = bounds.get_mut(first..first + 2) else { break };
                for (lane, bound) in to.iter_mut().enumerate() {
                    let x = separation.x + (row_of_pairs.x[pair][lane] - atom.x);
                    let y = separation.y + (row_of_pairs.y[pair][lane] - atom.y);
                    let vx = velocity.x + (row_of_pairs.vx[pair][lane] - atom.vx);
                    let vy = velocity.y + (row_of_pairs.vy[pair][lane] - atom.vy);
                    let k = row_of_pairs.centripetal[pair][lane] + atom.centripetal;
                    let distance = (x * x + y * y).sqrt();
                    let gap = (distance - (row_of_pairs.radius[pair][lane] + atom.radius)) - error;
                    let rate = ((x * vx + y * vy) - over_distance) / distance - constant;
                    let root = (rate * rate + 2.0 * k * gap).sqrt();
                    let closing = rate < 0.0;
                    let above = if closing { 2.0 * gap } else { rate + root };
                    let below = if closing { root - rate } else { k };
                    let step = above / below * (1.0 - STEP_MARGIN);
                    // Touching pairs get no step, nor does what is no number.
                    let step = if (gap > 0.0) & (step >= 0.0) { step } else { 0.0 };
                    // The centres pass each other out of reach: see `skim`.
                    let reach = row_of_pairs.reach[pair][lane] + (atom.reach + self.inflation);
                    let passes = reach * reach * speed_squared < cross * cross;
                    *bound = if passes { f64::INFINITY } else { at.time + step };
                }
            }
        }
    }
}

impl Single {
    #[inline]
    fn new(flight: &Flight<'_>, atom: &Atom, at: &Placement, body: usize) -> Self {
        let spin = flight.spin[body];
        let arm = at.arm(body, atom.offset());
        let velocity = spin * arm.perp();
        Self {
            x: arm.x,
            y: arm.y,
            vx: velocity.x,
            vy: velocity.y,
            radius: atom.radius(),
            reach: atom.arm() + atom.radius(),
            centripetal: spin * spin * atom.arm(),
        }
    }
}

impl Row {
    #[inline]
    fn new(flight: &Flight<'_>, atoms: Atoms<'_>, at: &Placement, body: usize) -> Self {
        let mut row = Self::default();
        for (k, &index) in atoms.indices.iter().enumerate().take(MOST) {
            let atom = Single::new(flight, &atoms.all[index as usize], at, body);
            let (pair, lane) = (k / 2, k % 2);
            row.x[pair][lane] = atom.x;
            row.y[pair][lane] = atom.y;
            row.vx[pair][lane] = atom.vx;
            row.vy[pair][lane] = atom.vy;
            row.radius[pair][lane] = atom.radius;
            row.reach[pair][lane] = atom.reach;
            row.centripetal[pair][lane] = atom.centripetal;
        }
        row
    }
}

/// Index and value of the least.
#[inline]
fn least(values: &[f64]) -> (usize, f64) {
    let mut least = (0, f64::INFINITY);
    for (index, &value) in values.iter().enumerate() {
        if value < least.1 {
            least = (index, value);
        }
    }
    least
}
