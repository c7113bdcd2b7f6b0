//! A few atoms of A against a few of B: one step for all pairs at once, then the pairs one by one.

use carom_geometry::{Atom, Circle, CircleTree};

use crate::{
    ErrorBound, Window,
    atom_pair::AtomPair,
    flight::{Flight, Placement},
    search::Search,
    skim,
};

/// Most atoms of one body in a block, and most pairs of them.
const MOST: usize = CircleTree::CROSSOVER;
const MOST_PAIRS: usize = MOST * MOST;

/// Some atoms of one body, by their indices.
#[derive(Clone, Copy)]
pub(crate) struct Atoms<'a> {
    pub(crate) all: &'a [Atom],
    pub(crate) indices: &'a [u32],
}

/// Places and velocities about the centre of mass, and what bounds their change, of the atoms of a block.
struct Row {
    count: usize,
    x: [f64; MOST],
    y: [f64; MOST],
    vx: [f64; MOST],
    vy: [f64; MOST],
    radius: [f64; MOST],
    centripetal: [f64; MOST],
}

/// What the pairs of a block have in common: E of the bodies' bounding circles, which is not below that of any of
/// their atoms.
pub(crate) struct BlockSearch<'a> {
    pub(crate) flight: &'a Flight<'a>,
    pub(crate) error: ErrorBound,
}

impl<'a> BlockSearch<'a> {
    pub(crate) fn new(flight: &'a Flight<'a>, radii: [f64; 2]) -> Self {
        let circles = radii.map(|radius| Circle { offset: glam::DVec2::ZERO, arm: radius, radius });
        Self { flight, error: ErrorBound::of_circles(flight.motion, flight.speed, flight.spin, &circles) }
    }

    /// Searches all pairs of the atoms `a` and `b`, none of which touch before `begin`, in the order of a first
    /// certified step; what that puts beyond the best so far is left.
    pub(crate) fn search(&self, a: Atoms<'_>, b: Atoms<'_>, begin: f64, search: &mut Search) {
        let mut bounds = [0.0; MOST_PAIRS];
        let mut pairs = [(0, 0); MOST_PAIRS];
        let count = self.first_step(a, b, &self.flight.at(begin), search.limit(), (&mut bounds, &mut pairs));
        search.evaluations += (a.indices.len() * b.indices.len()) as u32;
        for left in (1..=count).rev() {
            // Selection by repeated minimum: mostly one or two pairs are ever wanted.
            let (next, bound) = least(&bounds[..left]);
            let limit = search.limit();
            if bound > limit {
                break;
            }
            let (i, j) = pairs[next];
            (bounds[next], pairs[next]) = (bounds[left - 1], pairs[left - 1]);
            let atoms = [a.indices[i as usize], b.indices[j as usize]];
            let circles = [Circle::from(&a.all[atoms[0] as usize]), Circle::from(&b.all[atoms[1] as usize])];
            let pair = AtomPair::new(self.flight, circles);
            if let Some(window) = skim(self.flight.motion, pair.reach(), limit) {
                let window = Window { begin: window.begin.max(bound), ..window };
                if window.begin <= window.end {
                    let outcome = pair.first_contact(window, search.most_steps, &mut search.evaluations);
                    search.record(outcome, atoms);
                }
            }
        }
    }

    /// The certified step with K for every pair: fills in until when those pairs are free that are not so up to
    /// `limit`, and says how many they are.
    ///
    /// The gap less E and its rate less E' are used, so no gap is below 0 up to there.
    fn first_step(
        &self,
        a: Atoms<'_>,
        b: Atoms<'_>,
        at: &Placement,
        limit: f64,
        (bounds, pairs): (&mut [f64; MOST_PAIRS], &mut [(u8, u8); MOST_PAIRS]),
    ) -> usize {
        let (row_a, row_b) = (Row::new(self.flight, a, at, 0), Row::new(self.flight, b, at, 1));
        let error = self.error.at(at.time);
        let [constant, over_distance] = self.error.rate_terms(error);
        let (separation, velocity) = (at.separation, self.flight.motion.velocity);
        let mut steps = [0.0; MOST];
        let mut count = 0;
        for i in 0..row_a.count {
            for (j, step) in steps.iter_mut().enumerate().take(row_b.count) {
                let x = separation.x + (row_b.x[j] - row_a.x[i]);
                let y = separation.y + (row_b.y[j] - row_a.y[i]);
                let vx = velocity.x + (row_b.vx[j] - row_a.vx[i]);
                let vy = velocity.y + (row_b.vy[j] - row_a.vy[i]);
                let k = row_a.centripetal[i] + row_b.centripetal[j];
                let distance = (x * x + y * y).sqrt();
                let inverse = 1.0 / distance;
                let gap = ((distance - (row_a.radius[i] + row_b.radius[j])) - error).max(0.0);
                let rate = ((x * vx + y * vy) - over_distance) * inverse - constant;
                let root = (rate * rate + 2.0 * k * gap).sqrt();
                let (above, below) = if rate < 0.0 { (2.0 * gap, root - rate) } else { (rate + root, k) };
                // Touching pairs get no step, whatever their rate.
                *step = if gap > 0.0 { above / below } else { 0.0 };
            }
            for (j, step) in steps.iter().enumerate().take(row_b.count) {
                let bound = at.time + step * (1.0 - crate::tolerance::STEP_MARGIN);
                // Written so that what is no number stays in.
                if !(bound > limit) {
                    bounds[count] = if bound.is_nan() { at.time } else { bound };
                    pairs[count] = (i as u8, j as u8);
                    count += 1;
                }
            }
        }
        count
    }
}

impl Row {
    #[inline]
    fn new(flight: &Flight<'_>, atoms: Atoms<'_>, at: &Placement, body: usize) -> Self {
        let spin = flight.spin[body];
        let mut row = Self {
            count: atoms.indices.len(),
            x: [0.0; MOST],
            y: [0.0; MOST],
            vx: [0.0; MOST],
            vy: [0.0; MOST],
            radius: [0.0; MOST],
            centripetal: [0.0; MOST],
        };
        for (lane, &index) in atoms.indices.iter().enumerate() {
            let atom = &atoms.all[index as usize];
            let arm = at.arm(body, atom.offset());
            let velocity = spin * arm.perp();
            (row.x[lane], row.y[lane]) = (arm.x, arm.y);
            (row.vx[lane], row.vy[lane]) = (velocity.x, velocity.y);
            row.radius[lane] = atom.radius();
            row.centripetal[lane] = spin * spin * atom.arm();
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
