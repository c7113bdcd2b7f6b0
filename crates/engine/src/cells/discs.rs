//! Event handling of small discs: prediction in lanes, crossings, contacts.

use std::hint::select_unpredictable as select;

use carom_detection::Detection;

use super::{
    body_record::RecordKind,
    dispatch::dispatched,
    frame::CellFrame,
    simd::{Kernel, NeighbourQuery, SoonestSlot, sooner},
    slot::INDEX_MASK,
    state::CellState,
};
use crate::{
    scheduler::{ContactEvent, TouchingParts},
    world::World,
};

dispatched!(predict_sheared_disc(disc: u32, now: f64));

impl<F: CellFrame> CellState<F> {
    /// Finds the earliest contact of a small disc with its neighbours, and its crossing.
    #[inline(always)]
    pub(super) fn query_neighbours<K: Kernel>(&self, kernel: K, disc: u32, now: f64) -> DiscEvents {
        let from = &self.records[disc as usize];
        let cell = self.neighbour_lists.index(from.cell());
        // Each arm builds its own query, since a shared one would be spilled to memory. There is no
        // branch on the result, which ends a long dependency chain.
        let (soonest, covered) = match (self.neighbour_lists.only_eight(cell), self.pair_constants)
        {
            // Bound again, so that the compiler specialises this arm.
            (Some((slots, false, is_covered)), pair_constants @ Some(_)) => {
                let query = NeighbourQuery {
                    pair_constants,
                    ..self.query(disc, now)
                };
                (
                    kernel
                        .soonest_of_eight::<false>(query, slots)
                        .in_slots(slots),
                    is_covered.then_some(cell),
                )
            }
            (Some((slots, true, is_covered)), pair_constants @ Some(_)) => {
                let query = NeighbourQuery {
                    pair_constants,
                    ..self.query(disc, now)
                };
                (
                    kernel
                        .soonest_of_eight::<true>(query, slots)
                        .in_slots(slots),
                    is_covered.then_some(cell),
                )
            }
            _ => self.query_any_list(kernel, disc, now, cell),
        };
        DiscEvents::new(now, soonest, covered, self.crossing(from, now))
    }

    /// Whether a disc sees others through the border of the box.
    #[inline(always)]
    pub(super) fn is_at_border(&self, disc: u32) -> bool {
        let cell = self.records[disc as usize].cell();
        self.neighbour_lists.list(cell).at_border
    }

    /// Finds the earliest event of a disc in a sheared box that sees no images, and writes it into
    /// its record.
    #[inline(always)]
    pub(super) fn predict_sheared_disc<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        world: &World,
        detection: &D,
        disc: u32,
        now: f64,
    ) {
        let cell = self
            .neighbour_lists
            .index(self.records[disc as usize].cell());
        let (soonest, covered) = self.query_any_list(kernel, disc, now, cell);
        let crossing = self.crossing_in_any_cells(disc, now);
        let events = DiscEvents::new(now, soonest, covered, crossing);
        self.store_disc_event(world, detection, disc, now, &events);
    }

    /// [`Self::query_neighbours`] for any neighbour list: the earliest contact, and the cell if it
    /// is covered.
    #[inline(always)]
    fn query_any_list<K: Kernel>(
        &self,
        kernel: K,
        disc: u32,
        now: f64,
        cell: u32,
    ) -> (SoonestSlot, Option<u32>) {
        let list = self.neighbour_lists.list_of(cell);
        let soonest = match list.plain() {
            Some((first, second)) => {
                let soonest = kernel
                    .soonest_of_eight::<false>(self.query(disc, now), first)
                    .in_slots(first);
                match second {
                    None => soonest,
                    Some(second) => soonest.or(kernel
                        .soonest_of_eight::<false>(self.query(disc, now), second)
                        .in_slots(second)),
                }
            }
            None => kernel.soonest_of_list(&self.query(disc, now), &list),
        };
        (soonest, list.is_covered().then_some(cell))
    }

    /// Writes the earliest event of a small disc, a contact with another or a crossing, into its
    /// record, and returns its time.
    ///
    /// The time ends a long dependency chain, and only rare branches depend on it: the processor
    /// can start the following work before the time is known.
    #[inline(always)]
    pub(super) fn write_disc_event<D: Detection>(
        &mut self,
        detection: &D,
        disc: u32,
        now: f64,
        events: &DiscEvents,
    ) -> f64 {
        let DiscEvents {
            mut contact_time,
            mut partner,
            is_ambiguous,
            covered: _,
            crossing_time,
            crossing,
        } = *events;
        if is_ambiguous | self.asks_detector {
            let soonest;
            (soonest, partner) = self.resolve_with_detector(detection, disc, now);
            contact_time = now + soonest;
        }
        self.write_earlier_event(disc, (contact_time, partner), (crossing_time, crossing))
    }

    /// Writes the earlier of a contact (time and partner) and a crossing into the record of a small
    /// disc, and returns its time.
    #[inline(always)]
    pub(super) fn write_earlier_event(
        &mut self,
        disc: u32,
        (contact_time, partner): (f64, u32),
        (crossing_time, crossing): (f64, RecordKind),
    ) -> f64 {
        let meets = contact_time <= crossing_time;
        let time = if crossing_time < contact_time {
            crossing_time
        } else {
            contact_time
        };
        let kind = select(meets, RecordKind::Discs, crossing);
        let partner = select(meets, partner, 0);
        let version = self.records[partner as usize].version;
        self.records[disc as usize].set_event(time, kind, partner, version);
        time
    }

    /// The earliest contact as the detector finds it: time from now (infinite for none) and
    /// partner. Needed where pairs may be in contact already, several discs are touched at one
    /// time, or the detector does not use the closed form. Of contacts at one time it is that with
    /// the disc inserted first.
    #[cold]
    #[inline(never)]
    fn resolve_with_detector<D: Detection>(
        &self,
        detection: &D,
        disc: u32,
        now: f64,
    ) -> (f64, u32) {
        let query = self.query(disc, now);
        let list = self.neighbour_lists.list(query.from.cell());
        let mut soonest = (f64::INFINITY, 0);
        list.for_each_slots8(|slots| {
            soonest = sooner(
                soonest,
                query.resolve_with_detector(detection, slots, list.at_border),
            );
        });
        soonest
    }

    /// Moves a disc into the next cell, and wraps its position at the border of the box.
    #[inline(always)]
    pub(super) fn cross<K: Kernel>(&mut self, kernel: K, disc: u32, kind: RecordKind) {
        let (axis, direction) = kind.direction();
        let record = &mut self.records[disc as usize];
        let from = record.cell();
        self.done.crossings += u64::from(self.neighbour_lists.frame().owns(from));
        if let Some(next) = self.grid.next(record.cell_along(axis), axis, direction) {
            record.set_cell_along(axis, next);
            let to = record.cell();
            self.neighbour_lists
                .step(kernel, disc, from, to, axis, direction);
        } else {
            self.wrap(disc, axis, direction);
        }
    }

    #[cold]
    fn wrap(&mut self, disc: u32, axis: usize, direction: i32) {
        self.neighbour_lists
            .leave(disc, self.records[disc as usize].cell());
        self.wrap_place(disc, axis, direction);
        self.neighbour_lists
            .enter(disc, self.records[disc as usize].cell());
    }

    /// The contact of two discs; the image follows from their cells, which are adjacent.
    #[inline(always)]
    pub(super) fn contact_of_discs(&self, bodies: [u32; 2], time: f64) -> ContactEvent {
        let (a, b) = (
            self.records[bodies[0] as usize].cell(),
            self.records[bodies[1] as usize].cell(),
        );
        let steps = [
            i32::from(b[0]) - i32::from(a[0]),
            i32::from(b[1]) - i32::from(a[1]),
        ];
        let is_next = |steps: i32| ((steps + 1) as u32) < 3;
        let mut image = [0; 2];
        if !(is_next(steps[0]) & is_next(steps[1])) {
            image = steps.map(|steps| i64::from(steps < -1) - i64::from(steps > 1));
        }
        ContactEvent {
            time,
            bodies,
            image,
            parts: TouchingParts::Discs,
        }
    }
}

impl<F: CellFrame> CellState<F> {
    /// [`Self::write_disc_event`] of a disc that may also touch a multi-cell body.
    #[inline(always)]
    pub(super) fn store_disc_event<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        disc: u32,
        now: f64,
        events: &DiscEvents,
    ) -> f64 {
        let time = self.write_disc_event(detection, disc, now, events);
        if let Some(cell) = events.covered {
            if self.multi_cell.are_large_discs() && detection.decides_discs_in_closed_form() {
                return self.search_large_discs(disc, cell, now);
            }
            self.search_covered_cell(world, detection, disc, cell, now, None);
            return self.records[disc as usize].time;
        }
        time
    }
}

/// The earliest contact and the crossing of a disc, before they are compared.
#[derive(Debug, Clone, Copy)]
pub(super) struct DiscEvents {
    /// Time of the earliest contact (offset in the epoch, infinite for none), and its partner.
    contact_time: f64,
    partner: u32,
    /// Whether the detector must decide the contact.
    is_ambiguous: bool,
    /// Its cell, if a multi-cell body is listed there.
    covered: Option<u32>,
    crossing_time: f64,
    crossing: RecordKind,
}

impl DiscEvents {
    #[inline(always)]
    fn new(
        now: f64,
        soonest: SoonestSlot,
        covered: Option<u32>,
        (crossing_time, crossing): (f64, RecordKind),
    ) -> Self {
        Self {
            contact_time: now + soonest.time,
            partner: soonest.slot & INDEX_MASK,
            is_ambiguous: soonest.is_ambiguous,
            covered,
            crossing_time,
            crossing,
        }
    }
}
