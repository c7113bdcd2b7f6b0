//! Blocks of time of an observer's record; their scatter gives its statistical error.
//!
//! The lengths of the blocks are those of [`Blocking`]: 32 to 63 blocks cover a run of any length.

use carom_engine::{Body, CollisionReport, Observer, View};
use carom_kinematics::EpochTime;
use carom_tables::Blocking;
use serde::{Deserialize, Serialize};

/// An observer whose records of two successive intervals of time can be added.
pub trait Additive {
    /// This observer with an empty record, ready to continue from now.
    #[must_use]
    fn emptied(&self) -> Self;

    /// Adds the record of the interval that follows.
    fn absorb(&mut self, later: &Self);
}

/// The record of an observer in blocks of time.
///
/// To omit the start of a run, begin to observe later. A later `start`, after an edit, changes
/// nothing.
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
    complete: Blocking<Block<O>>,
    open: Block<O>,
    began: Option<EpochTime>,
}

/// The record of one block.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Block<O> {
    /// Duration of the block (time).
    pub duration: f64,
    /// The record of the observer.
    pub observed: O,
}

impl<O: Additive> Blocks<O> {
    /// No blocks yet; `observer` must be empty.
    pub fn new(observer: O) -> Self {
        let open = Block { duration: 0.0, observed: observer };
        Self { complete: Blocking::default(), open, began: None }
    }

    /// The complete blocks in the order of time, all of the same number of samples.
    pub fn complete(&self) -> &[Block<O>] {
        self.complete.complete()
    }

    /// The sum of all blocks up to the last sample, including the incomplete one.
    pub fn total(&self) -> Block<O> {
        let mut total = Block { duration: 0.0, observed: self.open.observed.emptied() };
        for block in self.complete().iter().chain([&self.open]) {
            total.absorb(block);
        }
        total
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
    fn watches_any(&self) -> bool {
        self.open.observed.watches_any()
    }

    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.open.observed.watches(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        self.began.get_or_insert(view.time());
        self.open.observed.start(view);
    }

    fn pause(&mut self, view: &View<'_>) {
        self.open.observed.pause(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.open.observed.collision(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        let began = *self.began.get_or_insert(view.time());
        self.open.observed.sample(view);
        self.open.duration += view.time().since(began);
        self.began = Some(view.time());
        let open = &mut self.open;
        let close = || {
            let next = Block { duration: 0.0, observed: open.observed.emptied() };
            std::mem::replace(open, next)
        };
        self.complete.record(close, |earlier, later| earlier.absorb(&later));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_engine::{Scene, Simulation};

    /// Records the samples that it receives.
    #[derive(Debug, Default)]
    struct Diary(Vec<f64>);

    impl Observer for Diary {
        fn watches_any(&self) -> bool {
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
    fn blocks_are_contiguous_and_complete() {
        let scene = Scene::from_toml("[[bumper]]\nradius = 0.1\nat = [0.5, 0.5]\n").unwrap();
        for (samples, blocks, length) in [(0, 0, 1), (1, 1, 1), (63, 63, 1), (64, 32, 2), (391, 48, 8)] {
            let mut simulation = Simulation::new(&scene).unwrap();
            let mut diary = Blocks::new(Diary::default());
            diary.start(&simulation.view());
            for sample in 1..=samples {
                simulation.observe_until(0.5 * f64::from(sample), &mut ()).unwrap();
                diary.sample(&simulation.view());
            }
            assert_eq!(
                (diary.complete().len(), diary.complete.records_per_block()),
                (blocks, length),
                "{samples} samples"
            );
            for block in diary.complete() {
                assert_eq!(block.observed.0.len() as u64, length);
                assert_eq!(block.duration, 0.5 * length as f64);
            }
            // It filters as the observer of the open block, even if that changes after each sample.
            let view = simulation.view();
            let bumper = view.bodies().next().unwrap().body;
            assert_eq!(diary.watches([bumper; 2]), diary.open.observed.0.is_empty());
            let total = diary.total();
            let expected: Vec<f64> = (1..=samples).map(|sample| 0.5 * f64::from(sample)).collect();
            assert_eq!((total.duration, total.observed.0), (0.5 * f64::from(samples), expected));
        }
    }
}
