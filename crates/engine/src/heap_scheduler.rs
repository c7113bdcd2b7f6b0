//! The thesis's scheduler: a plain grid, one heap of all future events, and versions that mark
//! outdated ones.
//!
//! It is algorithm 4 of Montanari (2017). Every pair in adjacent cells that will touch has an event
//! in a binary heap, with the versions of both bodies at the time of the prediction. An event is
//! dropped when it comes due if one of the versions has changed. Four defects of the original are
//! repaired: a grid that can miss contacts is refused (unless
//! [`CellsPerSide::Unchecked`](crate::CellsPerSide::Unchecked) is chosen), images follow from the
//! adjacency of cells, a crossing predicts only newly adjacent pairs, and ties have an order.
//!
//! # Lemmas
//!
//! No contact is missed on a grid that is not refused. Bodies i and j are *related* through an
//! image k of j while their cells are adjacent through k. A body and a wall are related while the
//! body's cell lists the wall; every cell from which the wall can be touched in the epoch lists it.
//!
//! 1. **Contact implies relation.** *Proof.* A cell is at least as long as any two bodies reach.
//!    Bodies with a bond, and discs in their well, are related at all times.
//! 2. **A relation begins with a prediction.** *Proof.* It begins at the start of an epoch, or when
//!    one of the two enters a cell; in both cases the pair is predicted at that moment.
//! 3. **A new motion is predicted.** When a motion changes, all related pairs of its body are
//!    predicted.
//! 4. **The heap holds the first contact of every related pair.** *Proof.* Let t be the time of
//!    this contact under the present motions. By lemmas 2 and 3 the pair was predicted after both
//!    motions began, up to the end of the epoch. So its event at t, or a re-check before t, is in
//!    the heap with the present versions. It is not dropped before t, because only a change of
//!    motion makes it stale.

use std::{cmp::Ordering, collections::BinaryHeap};

use carom_detection::{DISC_LANES, Detection, DiscLanes, Outcome};
use carom_geometry::Molecule;
use carom_kinematics::{Motion, RelativeMotion};

use glam::DVec2;
use smallvec::SmallVec;

use crate::{
    grid::{CellStep, CellsPerSide, Grid},
    scene::error::GridError,
    scheduler::{
        ContactEvent, EventLoop, EventQueue, Scheduler, StoredMotions, TouchingParts, ordered,
        separation_error,
    },
    world::{World, counters::SchedulerCounters, tethers::BondEnd, wrapped::Wrapped},
};

/// The thesis's scheduler: one heap of all predicted events, and a plain grid of cells.
#[doc(alias = "Thesis")]
#[derive(Debug, Clone)]
pub struct HeapScheduler {
    counts: [i32; 2],
    grid: Grid,
    heap: BinaryHeap<Entry>,
    motions: Vec<Motion>,
    windings: Vec<[i64; 2]>,
    wrapped: Wrapped,
    /// Incremented at each change of a body's motion; events predicted with an older version are
    /// stale.
    versions: Vec<u32>,
    limit: f64,
    /// Bound on the rounding of a separation in this epoch (length).
    separation_error: f64,
    /// Work of the shear so far, where bodies passed through the seam.
    work_of_shear: f64,
    /// Scratch space.
    neighbours: Neighbours,
    done: SchedulerCounters,
}

/// A predicted event. The heap is ordered by time; events at one time by bodies and kind.
#[derive(Debug, Clone, Copy)]
struct Entry {
    time: f64,
    bodies: [u32; 2],
    versions: [u32; 2],
    /// Image of the second body relative to the first along their paths without periodic wraps.
    image: [i64; 2],
    kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Contact(TouchingParts),
    Recheck,
    /// A bond is certified free until then.
    BondRecheck(u32),
    /// A piston reaches a stop; `bodies` holds it twice.
    Stop,
    /// The first body enters the next cell; `bodies` holds it twice.
    Crossing(CellStep),
}

impl Entry {
    fn rank(&self) -> (u32, u32, u8) {
        let kind = match self.kind {
            Kind::Crossing(_) => 0,
            Kind::Recheck | Kind::BondRecheck(_) => 1,
            Kind::Contact(_) => 2,
            Kind::Stop => 3,
        };
        (self.bodies[0], self.bodies[1], kind)
    }
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        // The heap returns the largest entry first; the reversed order makes this the earliest.
        other
            .time
            .total_cmp(&self.time)
            .then_with(|| other.rank().cmp(&self.rank()))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Entry {}

impl Scheduler for HeapScheduler {
    type Options = CellsPerSide;

    // Larger: stale events outnumber the others in the heap.
    const CONTACTS_PER_EPOCH: u64 = 8;
    const RUNS_DRIVEN_BODIES: bool = true;
    const RUNS_PISTONS: bool = true;
    const RUNS_SHEAR: bool = true;
    const RUNS_TETHERS: bool = true;
    const RUNS_WELLS: bool = true;

    fn new(cells_per_side: &CellsPerSide, world: &World) -> Result<Self, GridError> {
        Ok(Self {
            counts: Grid::counts_for(world, *cells_per_side)?,
            grid: Grid::default(),
            heap: BinaryHeap::new(),
            motions: Vec::new(),
            windings: Vec::new(),
            wrapped: Wrapped::default(),
            versions: Vec::new(),
            limit: 0.0,
            separation_error: 0.0,
            work_of_shear: 0.0,
            neighbours: Neighbours::default(),
            done: SchedulerCounters::default(),
        })
    }

    fn begin_epoch<D: Detection>(&mut self, world: &World, detection: &D, limit: f64) {
        self.heap.clear();
        self.limit = limit;
        self.separation_error = separation_error(world);
        self.motions.clone_from(&world.motions);
        self.windings.clone_from(&world.windings);
        self.work_of_shear = world.work_of_shear();
        self.grid.fill(
            world,
            (&mut self.motions, &mut self.windings),
            self.counts,
            limit,
        );
        self.wrapped.start(world.bodies.len());
        self.versions.clear();
        self.versions.resize(world.bodies.len(), 0);
        let mut neighbours = self.take_scratch();
        for body in 0..world.bodies().len() as u32 {
            if world.bodies()[body as usize].is_fixed() {
                continue;
            }
            neighbours.clear();
            // Each pair once; fixed bodies are not predicted themselves.
            let counts = |other: u32| other > body || world.bodies()[other as usize].is_fixed();
            self.gather(world, body, &mut neighbours, counts);
            self.predict(world, detection, body, &neighbours, 0.0);
            self.predict_bonds(world, body, counts, 0.0);
            self.predict_steps(world, body, counts, 0.0);
            self.schedule_crossing(world, body, 0.0);
        }
        self.neighbours = neighbours;
    }

    fn run<L: EventLoop>(&mut self, events: L) -> L::End {
        events.run(self)
    }

    fn store(&self, state: &mut StoredMotions<'_>) {
        state.set_work_of_shear(self.work_of_shear);
        for (body, (motion, winding)) in self.motions.iter().zip(&self.windings).enumerate() {
            state.set(body as u32, *motion, *winding);
        }
    }

    fn store_changes(&mut self, state: &mut StoredMotions<'_>, contact: &[u32]) {
        let Some(wrapped) = self.wrapped.take() else {
            return self.store(state);
        };
        state.set_work_of_shear(self.work_of_shear);
        for &body in wrapped.iter().chain(contact) {
            state.set(
                body,
                self.motions[body as usize],
                self.windings[body as usize],
            );
        }
    }

    fn heap_bytes(&self) -> usize {
        self.grid.heap_bytes()
            + self.heap.capacity() * size_of::<Entry>()
            + self.motions.capacity() * size_of::<Motion>()
            + self.windings.capacity() * size_of::<[i64; 2]>()
            + self.wrapped.heap_bytes()
            + self.versions.capacity() * size_of::<u32>()
            + self.neighbours.0.capacity() * size_of::<(u32, [i32; 2])>()
    }

    fn counters(&self) -> SchedulerCounters {
        self.done
    }
}

impl EventQueue for HeapScheduler {
    fn next_contact<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        stop: f64,
    ) -> Option<ContactEvent> {
        while let Some(&entry) = self.heap.peek() {
            if entry.time > stop {
                return None;
            }
            self.heap.pop();
            let [a, b] = entry.bodies;
            if entry.versions != [self.versions[a as usize], self.versions[b as usize]] {
                self.done.stale += 1;
                continue;
            }
            match entry.kind {
                Kind::Contact(parts) => {
                    let image = self.present_image(&entry);
                    return Some(ContactEvent {
                        time: entry.time,
                        bodies: entry.bodies,
                        image,
                        parts,
                    });
                }
                Kind::Recheck => {
                    self.done.rechecks += 1;
                    let image = self.present_image(&entry).map(|boxes| boxes as i32);
                    self.predict_pair(world, detection, [a, b], image, entry.time);
                }
                Kind::BondRecheck(bond) => {
                    self.done.rechecks += 1;
                    self.predict_bond(world, bond, [a, b], entry.time);
                }
                Kind::Stop => return Some(ContactEvent::stop(a, entry.time)),
                Kind::Crossing(step) => self.cross(world, detection, a, step, entry.time),
            }
        }
        None
    }

    fn motion(&self, body: u32) -> Motion {
        self.motions[body as usize]
    }

    fn motions_changed<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        bodies: [u32; 2],
        motions: [Motion; 2],
    ) {
        let now = motions[0].time;
        for (body, motion) in bodies.into_iter().zip(motions) {
            if !world.bodies[body as usize].is_fixed() {
                self.motions[body as usize] = motion;
                self.versions[body as usize] = self.versions[body as usize].wrapping_add(1);
            }
        }
        let mut neighbours = self.take_scratch();
        for (turn, &body) in bodies.iter().enumerate() {
            // Where a stop reflects a piston, both bodies are the piston.
            if world.bodies()[body as usize].is_fixed() || (turn == 1 && body == bodies[0]) {
                continue;
            }
            neighbours.clear();
            let counts = |other: u32| {
                // The prediction of the first body includes the pair itself.
                let is_predicted =
                    turn == 1 && other == bodies[0] && !world.bodies()[other as usize].is_fixed();
                other != body && !is_predicted
            };
            self.gather(world, body, &mut neighbours, counts);
            self.predict(world, detection, body, &neighbours, now);
            self.predict_bonds(world, body, counts, now);
            self.predict_steps(world, body, counts, now);
            self.schedule_crossing(world, body, now);
        }
        self.neighbours = neighbours;
    }
}

/// Neighbours to predict a body against, with their images.
#[derive(Debug, Clone, Default)]
struct Neighbours(Vec<(u32, [i32; 2])>);

impl Neighbours {
    fn clear(&mut self) {
        self.0.clear();
    }

    fn push(&mut self, body: u32, image: [i32; 2]) {
        self.0.push((body, image));
    }

    /// Adds a piston or its partner, of which `molecule` is not the piston, in the box and in its
    /// nearest images: along the axis of the piston, and along the piston too if an atom of the
    /// molecule can be beyond the border, where the next image of the piston is. So can a disc in a
    /// frame that falls, along which the piston rises.
    fn push_images(&mut self, world: &World, body: u32, axis: usize, molecule: &Molecule) {
        let stays_inside = molecule.is_disc() && world.gravity == DVec2::ZERO;
        let sideways = if stays_inside { 0..=0 } else { -1..=1 };
        for aside in sideways {
            for boxes in -1..=1 {
                let mut image = [aside; 2];
                image[axis] = boxes;
                self.push(body, image);
            }
        }
    }
}

impl HeapScheduler {
    /// Takes the scratch space, emptied; the caller puts it back.
    fn take_scratch(&mut self) -> Neighbours {
        let mut neighbours = std::mem::take(&mut self.neighbours);
        neighbours.clear();
        neighbours
    }

    /// Adds the neighbours of a body that count: all bodies in adjacent cells, the walls that its
    /// cell lists, and all pistons; of a piston all bodies that are no walls.
    fn gather(
        &self,
        world: &World,
        body: u32,
        neighbours: &mut Neighbours,
        counts: impl Fn(u32) -> bool,
    ) {
        if let Some(axis) = world.bodies()[body as usize].axis_of_piston() {
            for other in (0..world.bodies().len() as u32).filter(|&other| counts(other)) {
                let partner = &world.bodies()[other as usize];
                if !partner.is_wall() {
                    neighbours.push_images(world, other, axis, partner.molecule());
                }
            }
            return;
        }
        for cell in self.grid.around(body) {
            for &other in cell.bodies.iter().filter(|&&other| counts(other)) {
                neighbours.push(other, cell.image);
            }
        }
        neighbours.0.extend_from_slice(self.grid.walls(body));
        Self::gather_pistons(world, body, neighbours, counts);
    }

    /// Adds the pistons that count, in the images that a body in the box may touch in an epoch.
    fn gather_pistons(
        world: &World,
        body: u32,
        neighbours: &mut Neighbours,
        counts: impl Fn(u32) -> bool,
    ) {
        for piston in world.pistons().map(|piston| piston as u32) {
            if let Some(axis) = world.bodies()[piston as usize].axis_of_piston()
                && piston != body
                && counts(piston)
            {
                let molecule = world.bodies()[body as usize].molecule();
                neighbours.push_images(world, piston, axis, molecule);
            }
        }
    }

    fn cross<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        body: u32,
        step: CellStep,
        now: f64,
    ) {
        self.done.crossings += 1;
        let mut walls_before: SmallVec<[(u32, [i32; 2]); 4]> =
            SmallVec::from_slice(self.grid.walls(body));
        let wrapped = self.grid.enter(body, step);
        if wrapped != 0 {
            let motion = &mut self.motions[body as usize];
            if step.axis == 1 && world.is_sheared() {
                let (after, gained) = world.pass_seam(body, motion, wrapped);
                *motion = after;
                self.work_of_shear += gained;
            } else {
                let side = world.bounds.sides()[step.axis];
                motion.position[step.axis] -= f64::from(wrapped) * side;
            }
            self.windings[body as usize][step.axis] += i64::from(wrapped);
            self.wrapped.push(body);
            walls_before
                .iter_mut()
                .for_each(|(_, image)| image[step.axis] -= wrapped);
        }
        let mut neighbours = self.take_scratch();
        for cell in self.grid.ahead(body, step) {
            for &other in cell.bodies {
                if other != body {
                    neighbours.push(other, cell.image);
                }
            }
        }
        let walls = self
            .grid
            .walls(body)
            .iter()
            .filter(|wall| !walls_before.contains(wall));
        neighbours.0.extend(walls);
        if wrapped != 0 {
            Self::gather_pistons(world, body, &mut neighbours, |_| true);
        }
        self.predict(world, detection, body, &neighbours, now);
        self.neighbours = neighbours;
        self.schedule_crossing(world, body, now);
    }

    /// Predicts a body against neighbours: discs in batches, others one by one.
    fn predict<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        body: u32,
        neighbours: &Neighbours,
        now: f64,
    ) {
        let by_pair = world.pairs.is_active();
        let shape = &world.bodies()[body as usize].kind.molecule;
        if !shape.is_disc() {
            for &(other, image) in &neighbours.0 {
                if by_pair && world.pair_factor([body, other]) == 0.0 {
                    continue;
                }
                self.predict_pair(world, detection, [body, other], image, now);
            }
            return;
        }
        let own_speed = self.motions[body as usize].velocity.abs().element_sum();
        let speed = own_speed + world.speed_of_images().abs();
        let radius = shape.bounding_radius();
        let empty = DiscLanes::empty(self.separation_error, speed);
        let (mut lanes, mut partners) = (empty, SmallVec::<[(u32, [i32; 2]); DISC_LANES]>::new());
        for &(other, image) in &neighbours.0 {
            let factor = if by_pair {
                world.pair_factor([body, other])
            } else {
                1.0
            };
            if factor == 0.0 {
                continue;
            }
            let partner = &world.bodies()[other as usize].kind.molecule;
            if !partner.is_disc() || world.drive(other as usize).is_some() {
                self.predict_pair(world, detection, [body, other], image, now);
                continue;
            }
            let relative = self.relative_motion(world, [body, other], image.map(i64::from), now);
            let sigma = factor * (radius + partner.bounding_radius());
            lanes.set(
                partners.len(),
                relative.separation,
                relative.velocity,
                sigma,
            );
            partners.push((other, image));
            if partners.len() == DISC_LANES {
                self.predict_discs(detection, body, &lanes, &partners, now);
                lanes = empty;
                partners.clear();
            }
        }
        if !partners.is_empty() {
            self.predict_discs(detection, body, &lanes, &partners, now);
        }
    }

    fn predict_discs<D: Detection>(
        &mut self,
        detection: &D,
        body: u32,
        lanes: &DiscLanes,
        partners: &[(u32, [i32; 2])],
        now: f64,
    ) {
        self.done.pairs += partners.len() as u64;
        let times = detection.disc_contacts(lanes);
        for (&(other, image), time) in partners.iter().zip(times) {
            if now + time <= self.limit {
                self.schedule(
                    [body, other],
                    image.map(i64::from),
                    now + time,
                    Kind::Contact(TouchingParts::Discs),
                );
            }
        }
    }

    fn predict_pair<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        pair: [u32; 2],
        image: [i32; 2],
        now: f64,
    ) {
        self.done.pairs += 1;
        // The body inserted first is A, so that ties between atoms do not depend on the order of
        // the query.
        let (pair, image) = ordered(pair, image.map(i64::from));
        let relative = self.relative_motion(world, pair, image, now);
        let times = [0.0, self.limit - now];
        let outlines = pair.map(|body| world.bodies[body as usize].molecule().outline());
        let answer = world.first_contact(detection, pair, outlines, &relative, now, times);
        let outcome = answer.outcome.map(TouchingParts::from);
        self.schedule_outcome(pair, image, outcome, now, Kind::Recheck);
    }

    /// Schedules what the search of a pair has found: a contact, or that it is to go on later.
    fn schedule_outcome(
        &mut self,
        pair: [u32; 2],
        image: [i64; 2],
        outcome: Outcome<TouchingParts>,
        now: f64,
        recheck: Kind,
    ) {
        let (later, kind) = match outcome {
            Outcome::Free => return,
            Outcome::Contact(contact) => (now + contact.time, Kind::Contact(contact.touch)),
            Outcome::FreeUntil(time) => ((now + time).max(now.next_up()), recheck),
            Outcome::Unresolved(time) => {
                self.done.unresolved += 1;
                ((now + time).max(now.next_up()), recheck)
            }
            // The pair is predicted again in the next epoch, which starts from other numbers.
            Outcome::OutOfRange => {
                self.done.unresolved += 1;
                return;
            }
        };
        if later <= self.limit {
            self.schedule(pair, image, later, kind);
        }
    }

    /// Predicts the bonds of a body with the bodies that count.
    fn predict_bonds(&mut self, world: &World, body: u32, counts: impl Fn(u32) -> bool, now: f64) {
        for &BondEnd { bond, partner } in world.bonds_of(body) {
            if counts(partner) {
                self.predict_bond(world, bond, world.bonds()[bond as usize].bodies, now);
            }
        }
    }

    fn predict_bond(&mut self, world: &World, bond: u32, bodies: [u32; 2], now: f64) {
        self.done.pairs += 1;
        let motions = bodies.map(|body| &self.motions[body as usize]);
        let (outcome, image) = world.first_bond_event(bond, motions, now, self.limit - now);
        self.schedule_outcome(bodies, image, outcome, now, Kind::BondRecheck(bond));
    }

    /// Predicts the steps of a disc in the wells of the discs that count.
    fn predict_steps(&mut self, world: &World, body: u32, counts: impl Fn(u32) -> bool, now: f64) {
        for partner in world.in_wells_of(body).filter(|&partner| counts(partner)) {
            self.done.pairs += 1;
            let bodies = [body.min(partner), body.max(partner)];
            let motions = bodies.map(|body| &self.motions[body as usize]);
            let (outcome, image) = world.first_step(bodies, motions, now, self.limit - now);
            // In closed form: the search never ends with a time until which the pair is free.
            self.schedule_outcome(bodies, image, outcome, now, Kind::Recheck);
        }
    }

    fn schedule(&mut self, pair: [u32; 2], image: [i64; 2], time: f64, kind: Kind) {
        let (pair, image) = ordered(pair, image);
        let [winding_a, winding_b] = pair.map(|body| self.windings[body as usize]);
        let path_image = [0, 1].map(|axis| image[axis] - (winding_b[axis] - winding_a[axis]));
        let versions = pair.map(|body| self.versions[body as usize]);
        self.heap.push(Entry {
            time,
            bodies: pair,
            versions,
            image: path_image,
            kind,
        });
    }

    /// Schedules the time at which a body enters another cell, or a piston reaches a stop.
    fn schedule_crossing(&mut self, world: &World, body: u32, now: f64) {
        let (time, kind) = if world.bodies()[body as usize].is_piston() {
            let motion = &self.motions[body as usize];
            (world.stop_time(body, motion, now), Kind::Stop)
        } else {
            let (time, step) = self.next_crossing(body, now);
            (time, Kind::Crossing(step))
        };
        if time <= self.limit {
            self.heap.push(Entry {
                time,
                bodies: [body; 2],
                versions: [self.versions[body as usize]; 2],
                image: [0; 2],
                kind,
            });
        }
    }

    /// The time at which a body enters another cell, and that cell.
    fn next_crossing(&self, body: u32, now: f64) -> (f64, CellStep) {
        let motion = &self.motions[body as usize];
        let place = self.grid.place(body);
        let (near, far) = (self.grid.corner(place), self.grid.far_corner(place));
        if let Some(seam) = self.grid.seam() {
            let (time, axis, direction) = seam.next_crossing(motion, [near, far], now);
            return (time, CellStep { axis, direction });
        }
        let mut soonest = (
            f64::INFINITY,
            CellStep {
                axis: 0,
                direction: 0,
            },
        );
        for axis in 0..2 {
            let velocity = motion.velocity[axis];
            // A velocity of exactly 0 never crosses; 0/0 and 1/−0 must not be formed.
            if velocity == 0.0 {
                continue;
            }
            let (border, direction) = if velocity > 0.0 {
                (far[axis], 1)
            } else {
                (near[axis], -1)
            };
            let time = (motion.time + (border - motion.position[axis]) / velocity).max(now);
            if time < soonest.0 {
                soonest = (time, CellStep { axis, direction });
            }
        }
        soonest
    }
}

impl HeapScheduler {
    fn relative_motion(
        &self,
        world: &World,
        pair: [u32; 2],
        image: [i64; 2],
        now: f64,
    ) -> RelativeMotion {
        let motions = pair.map(|body| &self.motions[body as usize]);
        world.relative_motion(pair, motions, image, now)
    }

    /// The image of an entry's second body relative to the present wrapped positions.
    fn present_image(&self, entry: &Entry) -> [i64; 2] {
        let [a, b] = entry.bodies.map(|body| self.windings[body as usize]);
        [0, 1].map(|axis| entry.image[axis] + (b[axis] - a[axis]))
    }
}
