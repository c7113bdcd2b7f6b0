//! What an observer sees, cut into blocks of time, so that the scatter of the blocks tells its statistical error.
//!
//! A block is 2ᵏ samples long. When there are 64 of them, neighbours are joined and k goes up by one: 32 to 63 blocks cover
//! a run of any length, without its end being known beforehand (blocking; Flyvbjerg & Petersen 1989).

use carom_engine::{Body, CollisionReport, Observer, View};
use carom_kinematics::EpochTime;
use serde::{Deserialize, Serialize};

/// So many blocks are joined in pairs. Fewer: errors are less certain than 1/√(2 · 32), an eighth. More: long runs have blocks
/// that remember each other.
const MOST: usize = 64;

/// An observer whose records of two neighbouring intervals of time add up to the record of both.
pub trait Additive {
    /// The same observer with an empty record, ready to go on from here.
    #[must_use]
    fn emptied(&self) -> Self;

    /// Adds the record of the interval that follows this one's.
    fn absorb(&mut self, later: &Self);
}

/// An observer's record, block by block of time.
///
/// To leave out the start of a run, begin to observe later; a later `start`, after an edit, changes nothing.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Blocks, DirectionHistogram};
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.05\nmass = 1.0\nenergy = 1.0\ncount = 60")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let disc = simulation.view().bodies().next().expect("there are sixty").body.key();
/// let mut blocks = Blocks::new(DirectionHistogram::new(disc, 4));
/// blocks.start(&simulation.view());
/// for sample in 1..=10 {
///     simulation.observe_until(f64::from(sample), &mut blocks)?;
///     blocks.sample(&simulation.view());
/// }
/// assert_eq!(blocks.complete().len(), 10);
/// let hits: u64 = blocks.complete().iter().map(|block| block.observed.hits()).sum();
/// assert_eq!(blocks.total().observed.hits(), hits);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Blocks<O> {
    complete: Vec<Block<O>>,
    open: Block<O>,
    began: Option<EpochTime>,
    /// How many samples the open block has seen, and how many it takes.
    samples: u64,
    length: u64,
}

/// The record of one block.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Block<O> {
    /// How long it lasted (time).
    pub duration: f64,
    /// What was seen.
    pub observed: O,
}

impl<O: Additive> Blocks<O> {
    /// No block yet of what this observer, still empty, will see.
    pub fn new(observer: O) -> Self {
        let open = Block { duration: 0.0, observed: observer };
        Self { complete: Vec::new(), open, began: None, samples: 0, length: 1 }
    }

    /// The blocks that are complete, in the order of time and all of one number of samples.
    pub fn complete(&self) -> &[Block<O>] {
        &self.complete
    }

    /// All together, up to the last sample, what is in no complete block included.
    pub fn total(&self) -> Block<O> {
        let mut total = Block { duration: 0.0, observed: self.open.observed.emptied() };
        for block in self.complete.iter().chain([&self.open]) {
            total.absorb(block);
        }
        total
    }

    fn close(&mut self) {
        let next = Block { duration: 0.0, observed: self.open.observed.emptied() };
        self.complete.push(std::mem::replace(&mut self.open, next));
        self.samples = 0;
        if self.complete.len() < MOST {
            return;
        }
        self.length *= 2;
        let mut joined: Vec<Block<O>> = Vec::with_capacity(MOST);
        for (index, block) in self.complete.drain(..).enumerate() {
            match joined.last_mut() {
                Some(last) if index % 2 == 1 => last.absorb(&block),
                _ => joined.push(block),
            }
        }
        self.complete = joined;
    }
}

impl<O: Additive> Block<O> {
    /// Adds the block that follows.
    pub fn absorb(&mut self, later: &Self) {
        self.duration += later.duration;
        self.observed.absorb(&later.observed);
    }
}

impl<O: Observer + Additive> Observer for Blocks<O> {
    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.open.observed.watches(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        self.began.get_or_insert(view.time());
        self.open.observed.start(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.open.observed.collision(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        let began = *self.began.get_or_insert(view.time());
        self.open.observed.sample(view);
        self.open.duration += view.time().since(began);
        self.began = Some(view.time());
        self.samples += 1;
        if self.samples == self.length {
            self.close();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_engine::{Scene, Simulation};

    /// Which samples it has been told of.
    #[derive(Debug, Default)]
    struct Diary(Vec<f64>);

    impl Observer for Diary {
        fn watches(&self, _: [&Body; 2]) -> bool {
            self.0.is_empty()
        }

        fn sample(&mut self, view: &View<'_>) {
            self.0.push(view.time().to_f64());
        }
    }

    impl Additive for Diary {
        fn emptied(&self) -> Self {
            Self::default()
        }

        fn absorb(&mut self, later: &Self) {
            self.0.extend(&later.0);
        }
    }

    #[test]
    fn blocks_follow_each_other_and_lose_nothing() {
        let scene = Scene::from_toml("[[bumper]]\nradius = 0.1\nat = [0.5, 0.5]\n").unwrap();
        for (samples, blocks, length) in [(0, 0, 1), (1, 1, 1), (63, 63, 1), (64, 32, 2), (391, 48, 8)] {
            let mut simulation = Simulation::new(&scene).unwrap();
            let mut diary = Blocks::new(Diary::default());
            diary.start(&simulation.view());
            for sample in 1..=samples {
                simulation.observe_until(0.5 * f64::from(sample), &mut ()).unwrap();
                diary.sample(&simulation.view());
            }
            assert_eq!((diary.complete().len(), diary.length), (blocks, length), "{samples} samples");
            for block in diary.complete() {
                assert_eq!(block.observed.0.len() as u64, length);
                assert_eq!(block.duration, 0.5 * length as f64);
            }
            // It wants what its open block wants, even if that is another after each sample.
            let view = simulation.view();
            let bumper = view.bodies().next().unwrap().body;
            assert_eq!(diary.watches([bumper; 2]), diary.open.observed.0.is_empty());
            let total = diary.total();
            let expected: Vec<f64> = (1..=samples).map(|sample| 0.5 * f64::from(sample)).collect();
            assert_eq!((total.duration, total.observed.0), (0.5 * f64::from(samples), expected));
        }
    }
}
