//! The fast scheduler with longer or shorter epochs, at whose start all events are predicted anew.

use carom::{
    CellScheduler, Detection, Instructions, Scheduler,
    engine::{
        GridError, SchedulerCounters, World,
        scheduler::{EventLoop, StoredMotions},
    },
};

/// [`CellScheduler`] with a given number of contacts of each moving body in an epoch.
#[derive(Debug, Clone)]
pub struct Epochs<const CONTACTS: u64>(CellScheduler);

impl<const CONTACTS: u64> Scheduler for Epochs<CONTACTS> {
    type Options = Instructions;

    const CONTACTS_PER_EPOCH: u64 = CONTACTS;

    fn new(options: &Instructions, world: &World) -> Result<Self, GridError> {
        CellScheduler::new(options, world).map(Self)
    }

    fn begin_epoch<D: Detection>(&mut self, world: &World, detection: &D, limit: f64) {
        self.0.begin_epoch(world, detection, limit);
    }

    fn run<L: EventLoop>(&mut self, events: L) -> L::End {
        self.0.run(events)
    }

    fn store(&self, state: &mut StoredMotions<'_>) {
        self.0.store(state);
    }

    fn store_changes(&mut self, state: &mut StoredMotions<'_>, contact: &[u32]) {
        self.0.store_changes(state, contact);
    }

    fn heap_bytes(&self) -> usize {
        self.0.heap_bytes()
    }

    fn counters(&self) -> SchedulerCounters {
        self.0.counters()
    }
}
