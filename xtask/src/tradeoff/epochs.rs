//! The fast scheduler with epochs of another length: everything is predicted anew more often, or less.

use carom::{
    Cells, Detection, Instructions, Scheduler,
    engine::{ContactEvent, GridError, SchedulerCounters, World},
    kinematics::Motion,
};
use glam::DVec2;

/// [`Cells`], with so many contacts of each moving body in an epoch.
#[derive(Debug, Clone)]
pub struct Epochs<const CONTACTS: u64>(Cells);

impl<const CONTACTS: u64> Scheduler for Epochs<CONTACTS> {
    type Options = Instructions;

    const CONTACTS_PER_EPOCH: u64 = CONTACTS;

    fn new(options: &Instructions, world: &World) -> Result<Self, GridError> {
        Cells::new(options, world).map(Self)
    }

    fn begin_epoch<D: Detection>(&mut self, world: &World, detection: &D, limit: f64) {
        self.0.begin_epoch(world, detection, limit);
    }

    fn next_contact<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        stop: f64,
    ) -> Option<ContactEvent> {
        self.0.next_contact(world, detection, stop)
    }

    fn motion(&self, body: u32) -> Motion {
        self.0.motion(body)
    }

    fn motions_changed<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        bodies: [u32; 2],
        motions: [Motion; 2],
    ) {
        self.0.motions_changed(world, detection, bodies, motions);
    }

    fn flight(&self, body: u32, time: f64) -> [DVec2; 2] {
        self.0.flight(body, time)
    }

    fn flights_changed<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        bodies: [u32; 2],
        time: f64,
        flights: [[DVec2; 2]; 2],
    ) {
        self.0.flights_changed(world, detection, bodies, time, flights);
    }

    fn store(&self, world: &mut World) {
        self.0.store(world);
    }

    fn heap_bytes(&self) -> usize {
        self.0.heap_bytes()
    }

    fn counters(&self) -> SchedulerCounters {
        self.0.counters()
    }
}
