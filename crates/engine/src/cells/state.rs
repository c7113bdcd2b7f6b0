//! The state of the cell scheduler: the records of all bodies, their lists, and the calendar.
//!
//! A state is a workspace: nothing outside it is written during an epoch, so any number of states
//! can work side by side.

use std::borrow::Cow;

use carom_geometry::Molecule;
use carom_kinematics::Motion;
use glam::DVec2;
use wide::f64x2;

use super::{
    body_record::{BodyRecord, RecordKind},
    calendar::Calendar,
    cell_grid::CellGrid,
    cell_occupants::CellOccupants,
    f32_filter::Units,
    frame::{CellFrame, Numbering, WholeBox},
    molecules::Molecules,
    multi_cell::MultiCellBodies,
    neighbour_lists::NeighbourLists,
    pair_classes::PairClasses,
    prefetch::MIN_BODIES,
    simd::{AvailableInstructions, Kernel, NeighbourQuery, PairConstants, Portable},
};
use crate::{
    scheduler::{StoredMotions, separation_error},
    world::{World, counters::SchedulerCounters, shear::Seam, wrapped::Wrapped},
};

/// Constants of an epoch, which all workspaces of a system share.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct EpochConstants {
    /// End of the epoch; later events are not needed (offset in the epoch).
    pub limit: f64,
    /// Bound on the rounding of a separation in this epoch (length).
    pub separation_error: f64,
    /// Constants of a pair of small discs, if all have one radius.
    pub pair_constants: Option<PairConstants>,
    /// Inverse mass of the bodies that live in cells, if all have the same (1/mass).
    pub inverse_mass: Option<f64>,
}

impl EpochConstants {
    /// The constants of an epoch that ends at `limit` (offset in it, time).
    pub fn new(world: &World, grid: &CellGrid, limit: f64) -> Self {
        let separation_error = separation_error(world);
        let radius = grid.common_radius(world);
        Self {
            limit,
            separation_error,
            pair_constants: radius.map(|radius| PairConstants::new(radius, separation_error)),
            inverse_mass: grid.common_inverse_mass(world),
        }
    }
}

/// State of the scheduler during an epoch.
#[derive(Debug, Clone)]
pub(super) struct CellState<F: CellFrame = WholeBox> {
    pub(super) instructions: AvailableInstructions,
    pub(super) grid: CellGrid,
    /// How its bodies are numbered.
    pub(super) bodies: F::Bodies,
    /// One for each body, and the dummy.
    pub(super) records: Vec<BodyRecord>,
    /// Boxes left behind, modulo 2¹⁶: within an epoch a body leaves only a few behind.
    pub(super) windings: Vec<[i16; 2]>,
    pub(super) wrapped: Wrapped,
    pub(super) calendar: Calendar,
    pub(super) neighbour_lists: NeighbourLists<F>,
    /// Takes the place of the neighbour lists in a dilute gas.
    pub(super) occupants: CellOccupants,
    pub(super) molecules: Molecules,
    pub(super) multi_cell: MultiCellBodies,
    pub(super) pair_classes: PairClasses,
    /// End of the epoch; later events are not needed (offset in the epoch).
    pub(super) limit: f64,
    /// Bound on the rounding of a separation in this epoch (length).
    pub(super) separation_error: f64,
    /// Sides of the box (length).
    pub(super) sides: [f64; 2],
    /// Constants of a pair of small discs, if all have one radius.
    pub(super) pair_constants: Option<PairConstants>,
    /// Inverse mass of the bodies that live in cells, if all have the same (1/mass).
    pub(super) inverse_mass: Option<f64>,
    /// Whether the detector decides all contacts of discs, not the closed form.
    pub(super) asks_detector: bool,
    /// The seam of a sheared box.
    pub(super) seam: Option<Seam>,
    /// Work of the shear so far, where bodies passed through the seam.
    pub(super) work_of_shear: f64,
    pub(super) done: SchedulerCounters,
}

impl<F: CellFrame> CellState<F> {
    /// An empty workspace for a frame in a grid.
    pub(super) fn new(instructions: AvailableInstructions, grid: CellGrid, frame: F) -> Self {
        Self {
            instructions,
            sides: grid.box_sides().to_array(),
            grid,
            bodies: F::Bodies::default(),
            records: Vec::new(),
            windings: Vec::new(),
            wrapped: Wrapped::default(),
            calendar: Calendar::default(),
            neighbour_lists: NeighbourLists::new(frame),
            occupants: CellOccupants::default(),
            molecules: Molecules::default(),
            multi_cell: MultiCellBodies::default(),
            pair_classes: PairClasses::default(),
            limit: 0.0,
            separation_error: 0.0,
            pair_constants: None,
            inverse_mass: None,
            asks_detector: false,
            seam: None,
            work_of_shear: 0.0,
            done: SchedulerCounters::default(),
        }
    }

    /// Reads the motions and lays out all lists for an epoch that ends at `limit` (time);
    /// multi-cell bodies are in no list yet.
    pub(super) fn lay_out(&mut self, world: &World, limit: f64) {
        self.set_constants(&EpochConstants::new(world, &self.grid, limit));
        self.windings.clear();
        self.windings.extend(
            world
                .windings()
                .iter()
                .map(|winding| winding.map(|boxes| boxes as i16)),
        );
        self.wrapped.start(world.bodies().len());
        (self.seam, self.work_of_shear) = (world.seam_at(0.0), world.work_of_shear());
        let mut motions = Cow::Borrowed(world.motions());
        let mut columns = Vec::new();
        if let Some(seam) = self.seam {
            for (motion, winding) in motions.to_mut().iter_mut().zip(&mut self.windings) {
                let (across, boxes) = seam.enter_cells(motion);
                winding[0] = winding[0].wrapping_add(boxes as i16);
                columns.push(across);
            }
        }
        self.records.clear();
        self.records.reserve_exact(world.bodies().len() + 1);
        for (index, (body, motion)) in world.bodies().iter().zip(motions.iter()).enumerate() {
            let mut record = BodyRecord::new(motion, body.kind.molecule.bounding_radius());
            let across = columns.get(index).copied().unwrap_or(motion.position.x);
            record.set_cell(self.grid.cell_of(DVec2::new(across, motion.position.y)));
            self.records.push(record);
        }
        let bodies = self.records.len();
        self.push_dummy();
        let [columns, rows] = self.grid.counts();
        self.multi_cell.clear();
        self.pair_classes
            .lay_out(world, &self.grid, self.separation_error);
        self.molecules.clear();
        if self.grid.is_dilute() {
            let velocities = world.motions().iter().map(|motion| motion.velocity);
            let reach = 2.0 * self.grid.largest_small();
            let units = Units::new(reach, world.bounds().sides(), limit, velocities);
            self.occupants
                .lay_out([columns, rows], bodies as u32, units);
        } else {
            let grid = self.grid.clone();
            self.list_discs(|body| !grid.is_multi_cell(&world.bodies()[body]));
        }
        if self.grid.keeps_motions() {
            self.molecules.take_over(&motions);
        }
        if self.grid.holds_molecules()
            || world.is_sheared()
            || world.is_tethered()
            || world.has_wells()
        {
            self.multi_cell.expect_contacts(bodies);
        }
        for (index, body) in world.bodies().iter().enumerate() {
            if self.grid.is_dilute() {
                let record = &self.records[index];
                self.occupants
                    .enter(Portable, index as u32, record.cell(), record.flight);
            } else if self.grid.is_multi_cell(body) {
                let among_molecules = self.grid.holds_molecules();
                self.multi_cell.add(
                    index as u32,
                    body,
                    &world.motions()[index],
                    world.drive(index).as_ref(),
                    bodies,
                    among_molecules,
                );
            }
        }
    }

    pub(super) fn set_constants(&mut self, constants: &EpochConstants) {
        let EpochConstants {
            limit,
            separation_error,
            pair_constants,
            inverse_mass,
        } = *constants;
        (self.limit, self.separation_error) = (limit, separation_error);
        (self.pair_constants, self.inverse_mass) = (pair_constants, inverse_mass);
    }

    /// Schedules the events of all bodies from `start` on, for events at this mean interval
    /// (times).
    pub(super) fn schedule_all(&mut self, interval: f64, start: f64) {
        let bodies = self.dummy();
        self.calendar.lay_out(bodies as usize, interval, start);
        for body in 0..bodies {
            self.calendar
                .schedule(&self.records, body, self.records[body as usize].time);
        }
    }

    /// Releases the memory of the bodies, until the next epoch or [`Self::resume`].
    pub(super) fn release(&mut self) {
        self.records = Vec::new();
        self.windings = Vec::new();
        self.wrapped = Wrapped::default();
        self.calendar = Calendar::default();
        self.neighbour_lists = NeighbourLists::new(self.neighbour_lists.frame().clone());
    }

    /// Lists the bodies that live in cells, in their cells.
    pub(super) fn list_discs(&mut self, is_in_cells: impl Fn(usize) -> bool + Clone) {
        let bodies = self.dummy();
        let in_cells = self.records[..bodies as usize].iter().enumerate();
        let in_cells = in_cells.filter(move |&(body, _)| is_in_cells(body));
        let in_cells = in_cells.map(|(body, record)| (body as u32, record.cell()));
        self.neighbour_lists
            .list_all(self.grid.counts(), bodies, in_cells);
    }

    pub(super) fn heap_bytes(&self) -> usize {
        self.records.capacity() * size_of::<BodyRecord>()
            + self.windings.capacity() * size_of::<[i16; 2]>()
            + self.wrapped.heap_bytes()
            + self.calendar.heap_bytes()
            + self.neighbour_lists.heap_bytes()
            + self.occupants.heap_bytes()
            + self.molecules.heap_bytes()
            + self.multi_cell.heap_bytes()
            + self.pair_classes.heap_bytes()
    }

    /// Stores the motion of a body, and the number of boxes that it has left behind.
    pub(super) fn store_body(&self, state: &mut StoredMotions<'_>, body: u32) {
        state.set_wrapped(body, self.motion(body), self.windings[body as usize]);
    }

    /// Appends the dummy after the records of all bodies.
    pub(super) fn push_dummy(&mut self) {
        self.records.push(BodyRecord::dummy());
    }

    /// Index of the dummy, the record in unused slots.
    pub(super) fn dummy(&self) -> u32 {
        self.records.len() as u32 - 1
    }

    /// Mean time between events of the system, from the median waiting time of its bodies: with
    /// rate λ each, half of them have waited ln 2 / λ. Bodies that begin on the border of a cell
    /// and move outwards have an event at time 0, which has no relation to their later ones; the
    /// estimate uses the other bodies. If there are none, it is the time in which the fastest body
    /// crosses a cell.
    pub(super) fn mean_interval(&self) -> f64 {
        let mut times: Vec<f64> = self
            .records
            .iter()
            .map(|record| record.time)
            .filter(|t| t.is_finite())
            .collect();
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

    /// Whether the system is so large that prefetching pays.
    pub(super) fn is_large(&self) -> bool {
        self.records.len() >= MIN_BODIES && !self.grid.is_dilute()
    }

    /// Sets the motion of a body that is at `place` with `velocity` at `time`.
    #[inline(always)]
    pub(super) fn set_motion<K: Kernel>(
        &mut self,
        kernel: K,
        body: u32,
        place: DVec2,
        velocity: DVec2,
        time: f64,
    ) {
        let record = &mut self.records[body as usize];
        let origin = place - velocity * time;
        kernel.write(
            &mut record.flight,
            [origin.x, origin.y, velocity.x, velocity.y],
        );
        record.version = record.version.wrapping_add(1);
    }

    /// The shape of a body.
    #[inline(always)]
    pub(super) fn molecule<'a>(&self, world: &'a World, body: u32) -> &'a Molecule {
        &world.bodies()[self.bodies.among_all(body) as usize]
            .kind
            .molecule
    }

    /// Whether this workspace counts the events of a body.
    #[inline(always)]
    fn counts(&self, body: u32) -> bool {
        self.neighbour_lists
            .frame()
            .owns(self.records[body as usize].cell())
    }

    /// Counts searches of a body for its first contact with others.
    #[inline(always)]
    pub(super) fn count_pairs(&mut self, body: u32, pairs: u64) {
        self.done.pairs += if self.counts(body) { pairs } else { 0 };
    }

    /// Counts a search of a body that ended without certainty.
    #[cold]
    pub(super) fn count_unresolved(&mut self, body: u32) {
        self.done.unresolved += u64::from(self.counts(body));
    }

    /// Counts a prediction of a body that came due after its partner had changed.
    #[inline(always)]
    pub(super) fn count_stale(&mut self, body: u32) {
        self.done.stale += u64::from(self.counts(body));
    }

    /// Counts a re-check of a body.
    pub(super) fn count_recheck(&mut self, body: u32) {
        self.done.rechecks += u64::from(self.counts(body));
    }

    /// Inverse masses of two discs (1/mass). If all bodies in cells have the same, it is not read
    /// from the bodies.
    #[inline(always)]
    pub(super) fn inverse_masses(&self, world: &World, bodies: [u32; 2]) -> [f64; 2] {
        match self.inverse_mass {
            Some(inverse_mass)
                if !(self.multi_cell.is_multi_cell(bodies[0])
                    | self.multi_cell.is_multi_cell(bodies[1])) =>
            {
                [inverse_mass; 2]
            }
            _ => world.inverse_masses(bodies.map(|body| self.bodies.among_all(body))),
        }
    }

    #[inline(always)]
    pub(super) fn flight(&self, body: u32, time: f64) -> [DVec2; 2] {
        if let Some(motion) = self.multi_cell.motion(body) {
            return [motion.position_at(time), motion.velocity];
        }
        let record = &self.records[body as usize];
        [
            record.origin() + record.velocity() * time,
            record.velocity(),
        ]
    }

    #[inline]
    pub(super) fn motion(&self, body: u32) -> Motion {
        if let Some(motion) = self
            .multi_cell
            .motion(body)
            .or_else(|| self.molecules.motion(body))
        {
            return *motion;
        }
        self.records[body as usize].motion()
    }

    #[inline(always)]
    pub(super) fn query(&self, disc: u32, now: f64) -> NeighbourQuery<'_> {
        let from = &self.records[disc as usize];
        NeighbourQuery {
            records: &self.records,
            from,
            now,
            separation_error: self.separation_error,
            sides: self.sides,
            pair_constants: self.pair_constants,
        }
    }

    /// Time and direction in which a disc leaves its cell. Infinite for a velocity of exactly 0,
    /// for which the quotient 0/0 is discarded.
    #[inline(always)]
    pub(super) fn crossing(&self, record: &BodyRecord, now: f64) -> (f64, RecordKind) {
        // Both axes in one register.
        let pair = |first: usize| f64x2::new([record.flight[first], record.flight[first + 1]]);
        let (origin, velocity) = (pair(0), pair(2));
        let side = f64x2::new(self.grid.side().to_array());
        let cell = f64x2::new(record.cell().map(f64::from));
        let goes_down = velocity.simd_lt(f64x2::ZERO);
        let border = (cell + goes_down.bitselect(f64x2::ZERO, f64x2::ONE)) * side;
        let time = (border - origin) / velocity;
        let [x, y] = velocity
            .simd_eq(f64x2::ZERO)
            .bitselect(f64x2::splat(f64::INFINITY), time)
            .to_array();
        let axis = u32::from(y < x);
        let kind = RecordKind::crossing(axis, goes_down.to_bitmask() >> axis & 1);
        let time = if y < x { y } else { x };
        (if time > now { time } else { now }, kind)
    }

    /// [`Self::crossing`] of a body in cells that may shear.
    #[inline(always)]
    pub(super) fn crossing_in_any_cells(&self, body: u32, now: f64) -> (f64, RecordKind) {
        match &self.seam {
            Some(seam) => self.crossing_under_shear(seam, body, now),
            None => self.crossing(&self.records[body as usize], now),
        }
    }

    /// Variant of [`Self::crossing`] in cells that shear.
    fn crossing_under_shear(&self, seam: &Seam, body: u32, now: f64) -> (f64, RecordKind) {
        let side = self.grid.side();
        let [column, row] = self.records[body as usize].cell().map(f64::from);
        let near = DVec2::new(column, row);
        let corners = [near, near + 1.0].map(|corner| corner * side);
        let (time, axis, direction) = seam.next_crossing(&self.motion(body), corners, now);
        let kind = RecordKind::crossing(axis as u32, (direction < 0).into());
        (time, kind)
    }

    /// Adds the energy that a body gains if this crossing takes it through the seam.
    pub(super) fn book_seam(&mut self, world: &World, body: u32, kind: RecordKind) {
        let (axis, direction) = kind.direction();
        let row = self.records[body as usize].cell_along(1);
        if axis == 1 && self.grid.next(row, 1, direction).is_none() {
            let (_, gained) = world.pass_seam(body, &self.motion(body), direction);
            self.work_of_shear += gained;
        }
    }

    /// Wraps a disc that crosses the border of the box to the other side.
    pub(super) fn wrap_place(&mut self, disc: u32, axis: usize, direction: i32) {
        let record = &mut self.records[disc as usize];
        record.flight[axis] -= f64::from(direction) * self.grid.box_sides()[axis];
        record.set_cell_along(
            axis,
            if direction > 0 {
                0
            } else {
                (self.grid.counts()[axis] - 1) as u16
            },
        );
        let winding = &mut self.windings[disc as usize][axis];
        *winding = winding.wrapping_add(direction as i16);
        self.wrapped.push(disc);
        self.wrap_motion(disc, axis, direction);
    }

    /// Wraps a molecule's motion into the box after its record, so that both agree to the bit.
    #[inline]
    pub(super) fn wrap_motion(&mut self, body: u32, axis: usize, direction: i32) {
        if let Some(motion) = self.molecules.motions.get_mut(body as usize) {
            match self.seam {
                Some(seam) if axis == 1 => *motion = seam.brought_back(motion, direction),
                _ => motion.position[axis] -= f64::from(direction) * self.sides[axis],
            }
            self.records[body as usize].set_motion(motion);
        }
    }

    /// Stores a disc's flight with the occupants of its cell, in a dilute gas.
    #[inline(always)]
    pub(super) fn update_occupant<K: Kernel>(&mut self, kernel: K, disc: u32) {
        if self.grid.is_dilute() {
            let record = &self.records[disc as usize];
            self.occupants
                .set_flight(kernel, disc, record.cell(), record.flight);
        }
    }
}
