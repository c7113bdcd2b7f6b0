//! The loop over the events of an epoch: it takes the earliest event, acts on it, and predicts the
//! bodies that it has changed.

use carom_detection::Detection;
use carom_kinematics::Motion;
use glam::DVec2;

use super::{
    body_record::RecordKind,
    cell_grid::CellContents,
    dispatch::dispatched,
    frame::CellFrame,
    prediction::predict_all,
    prefetch::prefetch_next,
    simd::{Kernel, KernelWork, dispatch},
    state::CellState,
};
use crate::{
    scheduler::{ContactEvent, EventLoop, EventQueue},
    world::World,
};

dispatched!(motions_changed(bodies: [u32; 2], motions: [Motion; 2]));

/// Runs a loop over the events, compiled in one piece with the chosen instruction set.
pub(super) fn run<L: EventLoop>(state: &mut CellState, events: L) -> L::End {
    struct Run<'a, L>(&'a mut CellState, L);
    impl<L: EventLoop> KernelWork for Run<'_, L> {
        type Output = L::End;

        #[inline(always)]
        fn with<K: Kernel>(self, kernel: K) -> L::End {
            self.1.run(&mut Events(self.0, kernel))
        }
    }
    dispatch(state.instructions, Run(state, events))
}

/// The events of an epoch, computed with a kernel.
struct Events<'a, K>(&'a mut CellState, K);

impl<K: Kernel> EventQueue for Events<'_, K> {
    #[inline(always)]
    fn next_contact<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        stop: f64,
    ) -> Option<ContactEvent> {
        self.0.next_contact(self.1, world, detection, stop)
    }

    #[inline(always)]
    fn motion(&self, body: u32) -> Motion {
        self.0.motion(body)
    }

    /// Out of line, so that the loop over the contacts of elastic discs stays small.
    fn motions_changed<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        bodies: [u32; 2],
        motions: [Motion; 2],
    ) {
        motions_changed(self.0, world, detection, bodies, motions);
    }

    #[cold]
    fn motion_changed<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        body: u32,
        motion: Motion,
    ) {
        self.0
            .motion_changed(self.1, world, detection, body, &motion);
    }

    #[inline(always)]
    fn inverse_masses(&self, world: &World, bodies: [u32; 2]) -> [f64; 2] {
        self.0.inverse_masses(world, bodies)
    }

    #[inline(always)]
    fn flight(&self, body: u32, time: f64) -> [DVec2; 2] {
        self.0.flight(body, time)
    }

    #[inline(always)]
    fn flights_changed<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        bodies: [u32; 2],
        time: f64,
        flights: [[DVec2; 2]; 2],
    ) {
        self.0
            .flights_changed(self.1, world, detection, bodies, time, flights);
    }
}

impl CellState {
    /// Begins an epoch that ends at `limit` (time).
    pub(super) fn begin_epoch<D: Detection>(&mut self, world: &World, detection: &D, limit: f64) {
        self.asks_detector = !detection.decides_discs_in_closed_form();
        self.lay_out(world, limit);
        self.list_multi_cell_bodies(world);
        // All bodies are predicted first: their waiting times give the mean interval between
        // events.
        predict_all(self, world, detection, 0.0);
        let interval = self.mean_interval();
        self.schedule_all(interval, 0.0);
    }

    /// Goes on at `now` in an epoch, after all records have been replaced, for events at this mean
    /// interval (times). Bodies that are not fixed live in cells; `spans` are the walls that move,
    /// each with the time since when it is listed (offset in the epoch).
    pub(super) fn resume(
        &mut self,
        world: &World,
        interval: f64,
        now: f64,
        spans: impl Iterator<Item = (u32, f64)>,
    ) {
        self.list_discs(|body| !world.bodies()[body].is_fixed());
        self.list_multi_cell_bodies(world);
        self.resume_spans(world, spans);
        // Other bodies than those of the journal have been wrapped.
        self.wrapped.overflow();
        self.schedule_all(interval, now);
    }

    #[inline(always)]
    fn next_contact<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        world: &World,
        detection: &D,
        stop: f64,
    ) -> Option<ContactEvent> {
        let is_large = self.is_large();
        loop {
            let (records, neighbour_lists) = (&self.records, &self.neighbour_lists);
            let (now, body) = self.calendar.take_soonest(records, stop, |calendar| {
                if is_large {
                    prefetch_next(calendar, records, neighbour_lists);
                }
            })?;
            let record = &self.records[body as usize];
            let kind = record.kind();
            if kind.is_contact() {
                let partner = record.partner();
                if self.records[partner as usize].version == record.partner_version {
                    // Both bodies are predicted after the contact, so the partner's event is void;
                    // in most cases it is this contact.
                    self.calendar.remove_if_next(partner);
                    let bodies = if body < partner {
                        [body, partner]
                    } else {
                        [partner, body]
                    };
                    return Some(if kind == RecordKind::Discs {
                        self.contact_of_discs(bodies, now)
                    } else {
                        self.contact_of_multi_cell_body(body, bodies, now)
                    });
                }
                self.count_stale(body);
            } else if kind.is_crossing() {
                if self.grid.is_dilute() {
                    let time = self.cross_dilute(kernel, detection, body, kind, now);
                    self.calendar.schedule(&self.records, body, time);
                    continue;
                }
                if self.seam.is_some() {
                    self.book_seam(world, body, kind);
                }
                self.cross(kernel, body, kind);
            } else if kind == RecordKind::Shell {
                if self.multi_cell.is_fixed(body) {
                    for reached in self.move_wall(world, body, now) {
                        self.predict_and_schedule(kernel, world, detection, reached, now);
                    }
                } else {
                    self.leave_shell(world, body, now);
                }
            } else if kind == RecordKind::Recheck {
                self.count_recheck(body);
            } else if kind == RecordKind::Stop {
                return Some(ContactEvent::stop(body, now));
            }
            self.predict_and_schedule(kernel, world, detection, body, now);
        }
    }
}

impl<F: CellFrame> CellState<F> {
    #[inline(always)]
    pub(super) fn motions_changed<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        world: &World,
        detection: &D,
        bodies: [u32; 2],
        motions: [Motion; 2],
    ) {
        let now = motions[0].time;
        if world.has_reactions {
            for body in bodies {
                self.pair_classes.update_class(world, body);
            }
        }
        for (body, motion) in bodies.into_iter().zip(&motions) {
            if !self.multi_cell.is_fixed(body) {
                self.set_motion(kernel, body, motion.position, motion.velocity, now);
                self.multi_cell.set_motion(body, motion);
                if world.has_springs() {
                    self.multi_cell.set_drive(body, world.drive(body as usize));
                }
                self.molecules.set_motion(body, motion);
                self.update_occupant(kernel, body);
            }
        }
        let are_multi_cell = bodies.map(|body| self.multi_cell.is_multi_cell(body));
        if self.grid.contents() == CellContents::Discs && are_multi_cell == [false; 2] {
            return self.predict_two_discs(kernel, world, detection, bodies, now);
        }
        let skip_partner = self.skip_partner(bodies);
        if let Some([body, other]) = skip_partner {
            let time = self.predict_searching(world, detection, body, now, Some(other));
            self.calendar.schedule(&self.records, body, time);
        }
        for body in bodies {
            if self.multi_cell.is_fixed(body) {
                // The contact may have removed the event of a wall that moves.
                let until = self.multi_cell.listed_until(body);
                if until < f64::INFINITY {
                    self.calendar.schedule(&self.records, body, until);
                }
            } else if skip_partner.is_none_or(|[skip_partner, _]| body != skip_partner) {
                self.predict_and_schedule(kernel, world, detection, body, now);
            }
        }
    }

    /// Stores the new motion of a piston, which begins now, and predicts it anew.
    fn motion_changed<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        world: &World,
        detection: &D,
        body: u32,
        motion: &Motion,
    ) {
        let now = motion.time;
        self.set_motion(kernel, body, motion.position, motion.velocity, now);
        self.multi_cell.set_motion(body, motion);
        self.multi_cell.set_drive(body, world.drive(body as usize));
        self.predict_and_schedule(kernel, world, detection, body, now);
    }

    #[inline(always)]
    pub(super) fn flights_changed<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        world: &World,
        detection: &D,
        bodies: [u32; 2],
        time: f64,
        [places, velocities]: [[DVec2; 2]; 2],
    ) {
        if self.multi_cell.is_multi_cell(bodies[0]) | self.multi_cell.is_multi_cell(bodies[1]) {
            for ((body, place), velocity) in bodies.into_iter().zip(places).zip(velocities) {
                if !self.multi_cell.is_fixed(body) {
                    self.set_motion(kernel, body, place, velocity, time);
                    self.multi_cell.set_flight(body, time, place, velocity);
                }
            }
        } else {
            self.set_motion(kernel, bodies[0], places[0], velocities[0], time);
            self.set_motion(kernel, bodies[1], places[1], velocities[1], time);
            if self.grid.contents() == CellContents::Discs {
                return self.predict_two_discs(kernel, world, detection, bodies, time);
            }
        }
        for ((body, place), velocity) in bodies.into_iter().zip(places).zip(velocities) {
            self.molecules.set_flight(body, time, place, velocity);
            self.update_occupant(kernel, body);
        }
        for body in bodies {
            if !self.multi_cell.is_fixed(body) {
                self.predict_and_schedule(kernel, world, detection, body, time);
            }
        }
    }

    /// Predicts two small discs of a dense gas and schedules their events.
    #[inline(always)]
    fn predict_two_discs<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        world: &World,
        detection: &D,
        [a, b]: [u32; 2],
        now: f64,
    ) {
        // Both queries come before both writes, so that the processor executes the two independent
        // chains of operations in parallel.
        let (events_a, events_b) = (
            self.query_neighbours(kernel, a, now),
            self.query_neighbours(kernel, b, now),
        );
        let soonest = self.store_disc_event(world, detection, a, now, &events_a);
        self.calendar.schedule(&self.records, a, soonest);
        let soonest = self.store_disc_event(world, detection, b, now, &events_b);
        self.calendar.schedule(&self.records, b, soonest);
    }

    #[inline(always)]
    pub(super) fn predict_and_schedule<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        world: &World,
        detection: &D,
        body: u32,
        now: f64,
    ) {
        let time = self.predict(kernel, world, detection, body, now);
        self.calendar.schedule(&self.records, body, time);
    }
}
