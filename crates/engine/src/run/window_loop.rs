//! The loop over the windows of an epoch: it records the contacts that a scheduler has found at
//! once.

use carom_detection::Detection;
use carom_response::Response;

use crate::{
    contact::{
        reaction_table::ReactionTable, resolution::ContactPair,
        simultaneous_contacts::SimultaneousContacts, unresolved::Unresolved,
    },
    run::epoch_loop::{EpochEnd, EpochLoop},
    scene::error::RunError,
    scheduler::Scheduler,
    window::{RestartState, TimeWindow, WindowContact, WindowJob},
    world::counters::{Counters, Ledger},
};

impl<D: Detection, R: Response> EpochLoop<'_, D, R> {
    /// Runs in windows for as long as the scheduler can; returns how the loop has ended, or none if
    /// the rest is to be run contact by contact.
    pub(crate) fn run_windows<S: Scheduler>(
        &mut self,
        scheduler: &mut S,
    ) -> Result<Option<EpochEnd>, RunError> {
        let may_use_windows = self.most == u64::MAX;
        // Where bodies fall, contacts are resolved in the laboratory.
        let all_elastic = self.rules().all_elastic() && !self.world.has_gravity();
        let wants_log = self.observer.is_some();
        loop {
            let limit = self.limits.time();
            let window = scheduler.run_window(&WindowJob {
                world: self.world,
                detection: self.detection,
                rules: self.rules(),
                names: self.names,
                from: *self.now,
                stop: limit.min(self.target),
                limits: *self.limits,
                instant: self.simultaneous.time,
                may_use_windows,
                all_elastic,
                wants_log,
            });
            let Some(window) = window else {
                if let Some(restart) = scheduler.take_restart() {
                    self.replay(scheduler, restart)?;
                }
                return Ok(None);
            };
            if wants_log {
                self.record_all(&window)?;
            } else {
                self.count(&window);
            }
            *self.limits = window.limits;
            *self.contacts += window.contacts;
            *self.now = window.end;
            if let Some((time, bodies)) = window.last {
                self.simultaneous.repeats(bodies, time);
                if window.ends_epoch {
                    return Ok(Some(EpochEnd::WithContact(time)));
                }
            }
            let limit = self.limits.time();
            if window.end >= limit {
                return Ok(Some(EpochEnd::AtLimit(limit)));
            }
            if window.end >= self.target {
                return Ok(Some(EpochEnd::TargetReached));
            }
        }
    }

    /// Runs contact by contact.
    #[inline(never)]
    pub(crate) fn run_in_order<S: Scheduler>(
        self,
        scheduler: &mut S,
    ) -> Result<EpochEnd, RunError> {
        scheduler.run(self)
    }

    /// Runs the contacts since an earlier state once more, without recording them.
    #[cold]
    fn replay<S: Scheduler>(
        &mut self,
        scheduler: &mut S,
        restart: RestartState,
    ) -> Result<(), RunError> {
        let mut limits = restart.limits;
        self.world.last_contacts = restart.last_contacts;
        let (mut now, mut contacts) = (restart.from, 0);
        let again = EpochLoop {
            world: self.world,
            detection: self.detection,
            response: self.response,
            elasticity: self.elasticity,
            names: self.names,
            counters: &mut Counters::default(),
            ledger: &mut Ledger::default(),
            simultaneous: &mut SimultaneousContacts::default(),
            unresolved: &mut Unresolved::default(),
            reactions: &mut ReactionTable::default(),
            limits: &mut limits,
            now: &mut now,
            observer: None,
            target: *self.now,
            contacts: &mut contacts,
            most: u64::MAX,
        };
        let ended = again.run_in_order(scheduler)?;
        debug_assert!(
            matches!(ended, EpochEnd::TargetReached),
            "the epoch continues after these contacts"
        );
        debug_assert!(limits == *self.limits, "the limits have been recorded");
        Ok(())
    }

    /// Brings a scheduler that is ahead back to the present, under the present rules.
    pub(crate) fn come_back<S: Scheduler>(mut self, scheduler: &mut S) -> Result<(), RunError> {
        // A run to a number of contacts uses no windows.
        self.most = 0;
        self.run_windows(scheduler).map(drop)
    }

    /// Records all contacts of a window in order.
    fn record_all(&mut self, window: &TimeWindow) -> Result<(), RunError> {
        let mut discs = window.log.iter().peekable();
        for encounter in &window.encounters {
            while let Some(logged) = discs.next_if(|logged| logged.precedes(&encounter.contact)) {
                self.record_logged(logged)?;
            }
            let last_contacts = self.last_contacts(encounter.contact.bodies);
            let encounter = ContactPair {
                last_contacts,
                ..*encounter
            };
            let resolved = self.rules().resolve(&encounter);
            self.record(&encounter, &resolved)?;
        }
        discs.try_for_each(|logged| self.record_logged(logged))
    }

    /// Resolves an elastic contact of two discs once more, and records it.
    fn record_logged(&mut self, logged: &WindowContact) -> Result<(), RunError> {
        let contact = logged.event();
        let inverse_masses = self.world.inverse_masses(contact.bodies);
        let resolved = self
            .rules()
            .resolve_discs(contact.image, logged.flights, inverse_masses);
        self.record_discs(contact, logged.flights, resolved)
    }

    /// Counts the contacts of a window, and enters their energies into the ledger.
    fn count(&mut self, window: &TimeWindow) {
        self.counters.collisions += window.contacts;
        self.counters.fixed_collisions += window.with_fixed;
        self.counters.guarded_collisions += window.inelastic.guarded;
        for energy in &window.inelastic.energies {
            let slowing = self.world.clock.slowing(energy.time);
            self.ledger.spared += energy.spared.unwrap_or(0.0) * (slowing * slowing);
            self.ledger.book_loss(energy.lost, slowing);
            self.ledger.work += energy.work;
        }
        for &(body, time) in &window.inelastic.last_contacts {
            // Several tiles may have contacts of one fixed body; the latest counts.
            let last = &mut self.world.last_contacts[body as usize];
            *last = last.max(time);
        }
    }
}
