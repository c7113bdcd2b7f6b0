//! The default scheduler: cell lists, one event a body, and a calendar queue.
//!
//! - **Small discs** live in the cells of a grid. A cell is as long as two of them reach. Each cell
//!   has one neighbour list, of all discs in the 3 × 3 cells around it, so a prediction reads one
//!   list and tests eight discs at a time (`discs`, `neighbour_lists`).
//! - **Discs of a dilute gas** live in larger cells, which hold a few discs each and have no
//!   neighbour lists. A disc keeps its earliest contact while crossings come before it (`dilute`,
//!   `cell_occupants`).
//! - **Molecules** live in cells where most bodies that move are molecules, together with any small
//!   discs (`molecules`). Statements below on discs then hold for every body in a cell, with the
//!   bounding radius as its radius.
//! - **Multi-cell bodies** are all others: molecules among discs, large bodies, fixed bodies. Each
//!   is listed in all cells that it can reach (`multi_cell`).
//!
//! # Prediction
//!
//! A body keeps its earliest event only. It is predicted against all its neighbours exactly when
//! (a) its motion changed, (b) it entered a new cell or was listed in new cells, or (c) its event
//! came due as a re-check, or stale because the partner has changed since. No other body is
//! predicted. In a dilute gas, case (b) tests only the discs that became adjacent (`dilute`).
//!
//! # Lemmas
//!
//! No contact is missed. Two bodies are *related* through an image while their cells are adjacent
//! through it (two discs), while the disc's cell lists the multi-cell body, or while two multi-cell
//! bodies are in each other's lists of neighbours. Below, t is the time of the first contact of a
//! related pair under the present motions, before the end of the epoch.
//!
//! 1. **Contact implies relation.** Two bodies that touch are related, as long as neither has
//!    crossed into another cell or left its shell. *Proof.* A cell is as long as two discs reach. A
//!    multi-cell body of bounding radius R is listed in all cells within R + r_max + h of the
//!    centre of its shell (r_max: radius of the largest disc, h: radius of the shell). If it is a
//!    disc, the cells inside it for every position in its shell are left out; they hold no other
//!    centre. Two multi-cell bodies are neighbours within R + R' + h + h'.
//! 2. **A relation begins with a prediction.** It begins when a body enters a cell or is listed
//!    anew, and this body is predicted right after the lists have changed.
//! 3. **The body predicted last has an event at t or before.** *Proof.* Call this body k. Neither
//!    motion has changed since its prediction, because a body whose motion changes is predicted at
//!    that moment and would be the last. By lemma 2 the relation did not begin later either. So the
//!    partner was a candidate of k. The event of k is the earliest of its contacts, its crossing or
//!    the exit from its shell, and its re-checks, whose times ("certified free until") are before
//!    the contact. A candidate is excluded only if its contact certainly does not precede the event
//!    that k keeps, or the end of the epoch (`f32_filter`); the end of the epoch never moves to a
//!    later time. Only a new prediction changes the event of k, and it includes the pair again.
//! 4. **The earliest event is never later than the next contact.** *Proof.* Lemma 3 holds for every
//!    related pair. A contact removes the events of both its bodies from the calendar; both bodies
//!    are predicted before the next event is taken, or a new epoch begins.
//! 5. **No event acts on an outdated motion.** *Proof.* Every change of a motion increments the
//!    body's version, and an event whose partner has another version is stale. The time of a stale
//!    event is a lower bound on the contact times of all candidates of its body, so nothing is lost
//!    if the body is predicted only when the event comes due.
//! 6. **One partner may be skipped.** Of two bodies that have just met, the prediction of the first
//!    may leave out the second. *Proof.* The first is not the body of the pair that is predicted
//!    last.
//!
//! # Epochs
//!
//! Every epoch starts from the state of the world alone: positions, lists and events are computed
//! anew. So the state at the end of an epoch determines the rest of the run. The order within lists
//! and bins affects no result and is not stored.

#![allow(
    clippy::inline_always,
    reason = "the loop is compiled anew for each instruction set, and calls cost as much as the work"
)]

mod body_record;
mod calendar;
mod candidates;
mod cell_occupants;
mod dilute;
mod discs;
mod f32_filter;
mod grid;
mod molecules;
mod multi_cell;
mod neighbour_lists;
mod prefetch;
mod simd;
mod walls;

use carom_detection::Detection;
use carom_kinematics::Motion;
use glam::DVec2;

use self::{
    body_record::{BodyRecord, Kind},
    calendar::Calendar,
    cell_occupants::CellOccupants,
    f32_filter::Units,
    grid::CellGrid,
    molecules::Molecules,
    multi_cell::MultiCellBodies,
    neighbour_lists::NeighbourLists,
    prefetch::prefetch_next,
    simd::{Available, Kernel, PairConstants, Portable},
};
use crate::{
    CellsPerSide, GridError, HeapScheduler, Scheduler, SchedulerCounters, World,
    grid::Grid,
    scheduler::{ContactEvent, EventLoop, StoredMotions, separation_error},
    wrapped::Wrapped,
};

/// Instruction set that [`CellScheduler`] computes with. All give the same bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Instructions {
    /// The best one that this processor supports: AVX-512 (F, VL, DQ, BW), else as [`Self::Avx2`].
    #[default]
    Widest,
    /// AVX2 where the processor supports it, else as [`Self::Portable`]. Some percent slower than
    /// AVX-512.
    Avx2,
    /// Instructions that every processor of this architecture supports. The slowest.
    Portable,
}

impl Instructions {
    /// The instruction set that [`CellScheduler`] uses on this processor if `self` is chosen: the
    /// best supported one, up to `self`.
    ///
    /// ```
    /// use carom_engine::Instructions;
    ///
    /// // Every processor has these.
    /// assert_eq!(Instructions::Portable.on_this_processor(), Instructions::Portable);
    /// // `Widest` is AVX-512, where the processor has it.
    /// let best = Instructions::Widest.on_this_processor();
    /// assert_eq!(best.on_this_processor(), best);
    /// ```
    #[must_use]
    pub fn on_this_processor(self) -> Self {
        simd::available(self).instructions()
    }
}

/// The default scheduler: cell lists, one event a body, and a calendar queue.
///
/// The source of its module has the design and a proof that no contact is missed. [`HeapScheduler`]
/// runs a box too small for three cells a side, because it searches every image. It also runs a
/// single moving body among fixed ones, for which neighbour lists of moving bodies do not pay.
#[doc(alias = "Cells")]
#[doc(alias = "cell lists")]
#[derive(Debug, Clone)]
pub struct CellScheduler(Layout);

#[derive(Debug, Clone)]
enum Layout {
    Grid(Box<State>),
    Fallback(Box<HeapScheduler>),
}

/// State of the scheduler during an epoch.
#[derive(Debug, Clone)]
struct State {
    instructions: Available,
    grid: CellGrid,
    /// One for each body, and the dummy.
    records: Vec<BodyRecord>,
    /// Boxes left behind, modulo 2¹⁶: within an epoch a body leaves only a few behind.
    windings: Vec<[i16; 2]>,
    wrapped: Wrapped,
    calendar: Calendar,
    neighbour_lists: NeighbourLists,
    /// Takes the place of the neighbour lists in a dilute gas.
    occupants: CellOccupants,
    molecules: Molecules,
    multi_cell: MultiCellBodies,
    /// End of the epoch; later events are not needed (offset in the epoch).
    limit: f64,
    /// Bound on the rounding of a separation in this epoch (length).
    separation_error: f64,
    /// Sides of the box (length).
    sides: [f64; 2],
    /// Constants of a pair of small discs, if all have one radius.
    pair_constants: Option<PairConstants>,
    /// Inverse mass of the bodies that live in cells, if all have the same (1/mass).
    inverse_mass: Option<f64>,
    done: SchedulerCounters,
}

impl Scheduler for CellScheduler {
    type Options = Instructions;

    const CONTACTS_PER_EPOCH: u64 = 64;

    fn new(instructions: &Instructions, world: &World) -> Result<Self, GridError> {
        // Also rejects a box in which a molecule can touch its own image.
        Grid::counts_for(world, CellsPerSide::Given(1))?;
        let grid = if world.is_billiard() { None } else { CellGrid::new(world) };
        let Some(grid) = grid else {
            return HeapScheduler::new(&CellsPerSide::Automatic, world)
                .map(|fallback| Self(Layout::Fallback(Box::new(fallback))));
        };
        Ok(Self(Layout::Grid(Box::new(State {
            instructions: simd::available(*instructions),
            grid,
            records: Vec::new(),
            windings: Vec::new(),
            wrapped: Wrapped::default(),
            calendar: Calendar::default(),
            neighbour_lists: NeighbourLists::default(),
            occupants: CellOccupants::default(),
            molecules: Molecules::default(),
            multi_cell: MultiCellBodies::default(),
            limit: 0.0,
            separation_error: 0.0,
            sides: world.bounds().sides().to_array(),
            pair_constants: None,
            inverse_mass: None,
            done: SchedulerCounters::default(),
        }))))
    }

    fn begin_epoch<D: Detection>(&mut self, world: &World, detection: &D, limit: f64) {
        match &mut self.0 {
            Layout::Grid(state) => state.begin_epoch(world, detection, limit),
            Layout::Fallback(fallback) => fallback.begin_epoch(world, detection, limit),
        }
    }

    fn run<L: EventLoop>(&mut self, events: L) -> L::End {
        match &mut self.0 {
            Layout::Grid(state) => simd::run(state, events),
            Layout::Fallback(fallback) => events.run(&mut **fallback),
        }
    }

    fn store(&self, state: &mut StoredMotions<'_>) {
        match &self.0 {
            Layout::Grid(cells) => {
                (0..cells.windings.len() as u32).for_each(|body| cells.store_body(state, body));
            }
            Layout::Fallback(fallback) => fallback.store(state),
        }
    }

    fn store_changes(&mut self, state: &mut StoredMotions<'_>, contact: &[u32]) {
        match &mut self.0 {
            Layout::Grid(cells) => {
                let Some(wrapped) = cells.wrapped.take() else { return self.store(state) };
                wrapped.iter().chain(contact).for_each(|&body| cells.store_body(state, body));
            }
            Layout::Fallback(fallback) => fallback.store_changes(state, contact),
        }
    }

    fn heap_bytes(&self) -> usize {
        match &self.0 {
            Layout::Grid(state) => state.heap_bytes(),
            Layout::Fallback(fallback) => fallback.heap_bytes(),
        }
    }

    fn counters(&self) -> SchedulerCounters {
        match &self.0 {
            Layout::Grid(state) => state.done,
            Layout::Fallback(fallback) => fallback.counters(),
        }
    }
}

impl State {
    fn begin_epoch<D: Detection>(&mut self, world: &World, detection: &D, limit: f64) {
        self.limit = limit;
        self.separation_error = separation_error(world);
        self.windings.clear();
        self.windings.extend(world.windings().iter().map(|winding| winding.map(|boxes| boxes as i16)));
        self.wrapped.begin(world.bodies().len());
        self.records.clear();
        self.records.reserve_exact(world.bodies().len() + 1);
        for (body, motion) in world.bodies().iter().zip(world.motions()) {
            let mut record = BodyRecord::new(motion, body.kind.molecule.bounding_radius());
            record.set_cell(self.grid.cell_of(motion.position));
            self.records.push(record);
        }
        let bodies = self.records.len();
        self.records.push(BodyRecord::dummy());
        let [columns, rows] = self.grid.counts();
        self.multi_cell.clear();
        self.molecules.clear();
        if self.grid.is_dilute() {
            let velocities = world.motions().iter().map(|motion| motion.velocity);
            let reach = 2.0 * self.grid.largest_small();
            let units = Units::new(reach, world.bounds().sides(), limit, velocities);
            self.occupants.lay_out([columns, rows], bodies as u32, units);
        } else {
            let in_cells = world.bodies().iter().zip(&self.records).enumerate();
            let in_cells = in_cells.filter(|(_, (body, _))| !self.grid.is_multi_cell(body));
            let discs = in_cells.map(|(index, (_, record))| (index as u32, record.cell()));
            self.neighbour_lists.list_all([columns, rows], bodies as u32, discs);
        }
        if self.grid.holds_molecules() {
            self.molecules.take_over(world.motions());
            self.multi_cell.expect_contacts(bodies);
        }
        for (index, body) in world.bodies().iter().enumerate() {
            if self.grid.is_dilute() {
                let record = &self.records[index];
                self.occupants.enter(Portable, index as u32, record.cell(), record.flight);
            } else if self.grid.is_multi_cell(body) {
                let among_molecules = self.grid.holds_molecules();
                self.multi_cell.add(index as u32, body, &world.motions()[index], bodies, among_molecules);
            }
        }
        self.pair_constants =
            self.grid.common_radius(world).map(|radius| PairConstants::new(radius, self.separation_error));
        self.inverse_mass = self.grid.common_inverse_mass(world);
        self.list_multi_cell_bodies(world);
        // All bodies are predicted first: their waiting times give the mean interval between
        // events.
        simd::predict_all(self, world, detection);
        let interval = self.mean_interval();
        self.calendar.lay_out(bodies, interval);
        for body in 0..bodies as u32 {
            self.calendar.schedule(&self.records, body, self.records[body as usize].time);
        }
    }

    fn heap_bytes(&self) -> usize {
        self.records.capacity() * size_of::<BodyRecord>()
            + self.windings.capacity() * size_of::<[i16; 2]>()
            + self.wrapped.heap_bytes()
            + self.calendar.heap_bytes()
            + self.neighbour_lists.heap_bytes()
            + self.occupants.heap_bytes()
            + self.molecules.heap_bytes()
            + self.multi_cell.heap_bytes()
    }

    /// Stores the motion of a body, and the number of boxes that it has left behind.
    fn store_body(&self, state: &mut StoredMotions<'_>, body: u32) {
        let (before, now) = (state.winding(body), self.windings[body as usize]);
        let winding =
            [0, 1].map(|axis| before[axis] + i64::from(now[axis].wrapping_sub(before[axis] as i16)));
        state.set(body, self.motion(body), winding);
    }

    /// Index of the dummy, the record in unused slots.
    fn dummy(&self) -> u32 {
        self.records.len() as u32 - 1
    }

    /// Mean time between events of the system, from the median waiting time of its bodies: with
    /// rate λ each, half of them have waited ln 2 / λ. Bodies that begin on the border of a cell
    /// and move outwards have an event at time 0, which has no relation to their later ones; the
    /// estimate uses the other bodies. If there are none, it is the time in which the fastest body
    /// crosses a cell.
    fn mean_interval(&self) -> f64 {
        let mut times: Vec<f64> =
            self.records.iter().map(|record| record.time).filter(|t| t.is_finite()).collect();
        let bodies = times.len();
        times.retain(|&time| time > 0.0);
        if times.is_empty() {
            let cell = self.grid.side().min_element() / self.grid.box_sides().min_element();
            return self.limit * cell / self.records.len() as f64;
        }
        let middle = times.len() / 2;
        let (_, median, _) = times.select_nth_unstable_by(middle, f64::total_cmp);
        *median / (std::f64::consts::LN_2 * bodies as f64)
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
                    let bodies = if body < partner { [body, partner] } else { [partner, body] };
                    return Some(if kind == Kind::Discs {
                        self.contact_of_discs(bodies, now)
                    } else {
                        self.contact_of_multi_cell_body(body, bodies, now)
                    });
                }
                self.done.stale += 1;
            } else if kind.is_crossing() {
                if self.grid.is_dilute() {
                    let time = self.cross_dilute(kernel, detection, body, kind, now);
                    self.calendar.schedule(&self.records, body, time);
                    continue;
                }
                self.cross(kernel, body, kind);
            } else if kind == Kind::Shell {
                self.leave_shell(world, body, now);
            } else if kind == Kind::Recheck {
                self.done.rechecks += 1;
            }
            self.predict_and_schedule(kernel, world, detection, body, now);
        }
    }

    #[inline(always)]
    fn motions_changed<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        world: &World,
        detection: &D,
        bodies: [u32; 2],
        motions: [Motion; 2],
    ) {
        let now = motions[0].time;
        for (body, motion) in bodies.into_iter().zip(&motions) {
            if !self.multi_cell.is_fixed(body) {
                self.set_motion(kernel, body, motion.position, motion.velocity, now);
                self.multi_cell.set_motion(body, motion);
                self.molecules.set_motion(body, motion);
                self.update_occupant(kernel, body);
            }
        }
        let skip_partner = self.skip_partner(bodies);
        if let Some([body, other]) = skip_partner {
            let time = self.predict_searching(world, detection, body, now, Some(other));
            self.calendar.schedule(&self.records, body, time);
        }
        for body in bodies {
            if !self.multi_cell.is_fixed(body)
                && skip_partner.is_none_or(|[skip_partner, _]| body != skip_partner)
            {
                self.predict_and_schedule(kernel, world, detection, body, now);
            }
        }
    }

    #[inline(always)]
    fn flights_changed<D: Detection, K: Kernel>(
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
            if !self.grid.is_dilute() & !self.grid.holds_molecules() {
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

    /// Sets the motion of a body that is at `place` with `velocity` at `time`.
    #[inline(always)]
    fn set_motion<K: Kernel>(&mut self, kernel: K, body: u32, place: DVec2, velocity: DVec2, time: f64) {
        let record = &mut self.records[body as usize];
        let origin = place - velocity * time;
        kernel.write(&mut record.flight, [origin.x, origin.y, velocity.x, velocity.y]);
        record.version = record.version.wrapping_add(1);
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
        let (events_a, events_b) =
            (self.query_neighbours(kernel, a, now), self.query_neighbours(kernel, b, now));
        let soonest = self.store_disc_event(world, detection, a, now, &events_a);
        self.calendar.schedule(&self.records, a, soonest);
        let soonest = self.store_disc_event(world, detection, b, now, &events_b);
        self.calendar.schedule(&self.records, b, soonest);
    }

    #[inline(always)]
    fn predict_and_schedule<D: Detection, K: Kernel>(
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

    #[inline(always)]
    fn predict_all<D: Detection, K: Kernel>(&mut self, kernel: K, world: &World, detection: &D) {
        for body in 0..world.bodies().len() as u32 {
            self.predict(kernel, world, detection, body, 0.0);
        }
    }

    /// Finds a body's earliest event, writes it into the body's record, and returns its time.
    #[inline(always)]
    fn predict<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        world: &World,
        detection: &D,
        body: u32,
        now: f64,
    ) -> f64 {
        if self.multi_cell.is_multi_cell(body) | self.grid.holds_molecules() {
            self.predict_searching(world, detection, body, now, None)
        } else if self.grid.is_dilute() {
            self.predict_dilute(kernel, detection, body, now)
        } else {
            let events = self.query_neighbours(kernel, body, now);
            self.store_disc_event(world, detection, body, now, &events)
        }
    }

    /// Inverse masses of two discs (1/mass). If all bodies in cells have the same, it is not read
    /// from the bodies.
    #[inline(always)]
    fn inverse_masses(&self, world: &World, bodies: [u32; 2]) -> [f64; 2] {
        match self.inverse_mass {
            Some(inverse_mass)
                if !(self.multi_cell.is_multi_cell(bodies[0]) | self.multi_cell.is_multi_cell(bodies[1])) =>
            {
                [inverse_mass; 2]
            }
            _ => bodies.map(|body| world.bodies[body as usize].kind.inertia.inverse_mass),
        }
    }

    #[inline(always)]
    fn flight(&self, body: u32, time: f64) -> [DVec2; 2] {
        if let Some(motion) = self.multi_cell.motion(body) {
            return [motion.position_at(time), motion.velocity];
        }
        let record = &self.records[body as usize];
        [record.origin() + record.velocity() * time, record.velocity()]
    }

    #[inline]
    fn motion(&self, body: u32) -> Motion {
        if let Some(motion) = self.multi_cell.motion(body).or_else(|| self.molecules.motion(body)) {
            return *motion;
        }
        let record = &self.records[body as usize];
        Motion { velocity: record.velocity(), ..Motion::at_rest(record.origin()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AtomSpec, MoleculeSpec, Scene, Simulation};
    use carom_detection::Exact;
    use carom_response::Impact;

    #[test]
    fn bins_are_as_wide_for_a_lattice_on_borders_of_cells_as_for_any() {
        // All discs on a border leave a cell at time 0, which has no relation to their later
        // events. An interval estimated from these times would be 0, and all events would be in one
        // bin.
        const SIDE: usize = 64;
        let interval = |shift: f64| {
            let step = 1.0 / SIDE as f64;
            let disc = |k: usize| {
                // Directions spread evenly over a quarter turn, by the golden ratio.
                let angle = std::f64::consts::FRAC_PI_2 * ((k as f64 * 0.618_033_988_749_895) % 1.0);
                MoleculeSpec {
                    atoms: vec![AtomSpec { at: [0.0; 2], radius: 0.45 * step, mass: 1.0 }],
                    at: [((k % SIDE) as f64 + shift) * step, ((k / SIDE) as f64 + shift) * step],
                    velocity: [-angle.cos(), -angle.sin()],
                    ..MoleculeSpec::default()
                }
            };
            let scene = Scene { molecule: (0..SIDE * SIDE).map(disc).collect(), ..Scene::default() };
            let mut simulation = Simulation::<Exact, Impact, CellScheduler>::new(&scene).unwrap();
            simulation.scheduler.begin_epoch(&simulation.world, &simulation.detection, 1.0);
            match &simulation.scheduler.0 {
                Layout::Grid(state) => state.mean_interval(),
                Layout::Fallback(_) => panic!("64 discs a side have a grid"),
            }
        };
        let (inside, on_borders) = (interval(0.37), interval(0.0));
        let ratio = on_borders / inside;
        assert!(ratio > 0.05 && ratio < 20.0, "{on_borders} against {inside}");
    }
}
