//! Multi-cell bodies: molecules among discs, large bodies and fixed bodies, each listed in all
//! cells that it can reach.
//!
//! A multi-cell body has a *shell*, a circle of radius h around the place where it was last listed.
//! It is listed in every cell that can hold the centre of a small disc that touches it while its
//! own centre is in the shell. These are the cells within R + r_max + h of the shell's centre (R:
//! its bounding radius, r_max: the radius of the largest small disc). A disc is not listed in cells
//! that lie wholly within R − h. The body leaves its shell as an event, which lists it anew. A cell
//! that lists a multi-cell body is *covered*.
//!
//! Two multi-cell bodies are neighbours while the centres of their shells are within R + R' + h +
//! h', each with the image in which it is seen. A fixed body has no shell and no events and is
//! listed once. A wall is listed near its face only, however long the face is: see `walls`.
//!
//! A wall that moves is listed for a span of time, in every cell from which it can be touched in
//! that span: h is then the largest distance of a point of the wall from its place in the middle of
//! the span. At the end of the span the wall is listed anew, and the bodies in the cells that it
//! has entered are predicted. Its motion never changes, so that it is not predicted itself.
//!
//! A piston, a wall that contacts push, is predicted like any body that moves, against the bodies
//! in the cells that list it. Its shell is a strip about the place where it was last listed.

mod covered;
mod earliest_event;
mod large_disc;
mod listing;
mod search;

use carom_detection::Part;
use carom_kinematics::{Drive, Motion};
use glam::DVec2;

pub(super) use self::{
    covered::CoveredCells,
    earliest_event::EarliestEvent,
    listing::{FixedBodyCells, cells_entered, cells_of_fixed_body},
    search::predict_multi_cell,
};
use super::candidates::Candidates;
use crate::{
    scheduler::TouchingParts,
    world::{body::Body, index_or_none::IndexOrNone, wall::StandingWall},
};

/// All multi-cell bodies of the system.
#[derive(Debug, Clone, Default)]
pub(super) struct MultiCellBodies {
    list: Vec<MultiCellBody>,
    /// Index in `list`, by body.
    index_of: Vec<IndexOrNone>,
    /// The contact that a body's event of kind `MultiCell` stands for, by body.
    pending: Vec<Pending>,
    /// The bodies listed in each cell, by their index in the system.
    pub(super) covered: CoveredCells,
    /// Whether some are not discs among discs.
    has_molecules: bool,
    around: Surroundings,
}

/// Scratch space: the bodies around a multi-cell body.
#[derive(Debug, Clone, Default)]
struct Surroundings {
    /// Bodies seen without a shift by an image.
    slots: Vec<u32>,
    /// Other bodies, with the images in which they are seen.
    seen: Vec<Listed>,
    candidates: Candidates<Listed>,
}

/// A body or a cell, and the image in which it is seen, in boxes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Listed {
    /// Index in the list of multi-cell bodies, index of a body in the system, or index of a cell.
    pub index: u32,
    pub image: [i32; 2],
}

/// The contact that an event of kind `MultiCell` stands for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pending {
    pub parts: TouchingParts,
    /// Image of the second body relative to the first along their paths without periodic wraps,
    /// modulo 2¹⁶.
    pub image: [i16; 2],
}

/// A multi-cell body, its shell, the cells that list it, and its neighbours.
#[derive(Debug, Clone)]
pub(super) struct MultiCellBody {
    body: u32,
    fixed: bool,
    /// Whether its contacts with bodies in cells are those of two discs.
    is_disc_among_discs: bool,
    /// The wall that the body is, if it is one; of a wall that moves its place in the middle of the
    /// span for which it is listed.
    wall: Option<StandingWall>,
    /// The span for which a fixed body is listed (offsets in the epoch, time).
    listed_from: f64,
    listed_until: f64,
    /// Bounding radius (length).
    pub radius: f64,
    motion: Motion,
    /// What it does beside uniform motion.
    drive: Option<Drive>,
    /// Centre and radius of the shell (length).
    pub centre: DVec2,
    pub shell: f64,
    /// Cells that list it, with the image in which their discs appear in its frame.
    cells: Vec<Listed>,
    /// Cells whose neighbour lists together hold every disc that can be in `cells`, with the image
    /// in which their discs appear in its frame.
    tiles: Vec<Listed>,
    /// Multi-cell bodies that it may touch, with the image in which they appear in its frame.
    neighbours: Vec<Listed>,
}

impl MultiCellBody {
    /// A body that is listed nowhere yet; `among_molecules` if bodies in cells may be molecules.
    pub fn new(
        index: u32,
        body: &Body,
        motion: &Motion,
        drive: Option<&Drive>,
        among_molecules: bool,
    ) -> Self {
        Self {
            body: index,
            fixed: body.is_fixed(),
            is_disc_among_discs: body.kind.molecule.is_disc()
                && !among_molecules
                && drive.is_none(),
            wall: StandingWall::new(body, motion),
            listed_from: 0.0,
            listed_until: f64::INFINITY,
            radius: body.kind.molecule.bounding_radius(),
            motion: *motion,
            drive: drive.copied(),
            centre: motion.position,
            shell: 0.0,
            cells: Vec::new(),
            tiles: Vec::new(),
            neighbours: Vec::new(),
        }
    }
}

impl MultiCellBody {
    /// Whether it is a wall that contacts push.
    fn is_piston(&self) -> bool {
        !self.fixed && self.wall.is_some()
    }

    /// Its motion now, in the falling frame.
    fn motion_at(&self, now: f64) -> Motion {
        match &self.drive {
            None => self.motion.at(now),
            Some(drive) => drive.applied(&self.motion, now),
        }
    }

    /// A bound on the speed of a piston until `limit` (offset in the epoch).
    fn max_speed(&self, limit: f64) -> f64 {
        let of_drive = self.drive.map_or(0.0, |drive| drive.max_speed(limit));
        self.motion.velocity.length() + of_drive
    }

    /// Whether it is a fixed body that moves.
    fn is_moving_fixed(&self) -> bool {
        self.fixed && (!self.motion.is_at_rest() || self.drive.is_some())
    }
}

impl MultiCellBodies {
    pub fn clear(&mut self) {
        self.list.clear();
        self.index_of.clear();
        self.pending.clear();
        self.has_molecules = false;
    }

    /// Makes room for the contacts of this many bodies.
    pub fn expect_contacts(&mut self, bodies: usize) {
        self.pending.resize(bodies, Pending::NOTHING);
    }

    /// The contact that the event of a body stands for.
    #[inline]
    pub fn pending(&self, body: u32) -> Pending {
        self.pending[body as usize]
    }

    /// The contacts of all bodies; empty if no event can be one of a multi-cell body.
    pub fn all_pending(&self) -> &[Pending] {
        &self.pending
    }

    /// Number of bodies listed in a cell.
    pub fn covered_count(&self, cell: u32) -> usize {
        if self.list.is_empty() {
            0
        } else {
            self.covered.count(cell)
        }
    }

    /// Replaces the contact of a body, if there can be one.
    pub fn set_pending(&mut self, body: u32, pending: Pending) {
        if let Some(old) = self.pending.get_mut(body as usize) {
            *old = pending;
        }
    }

    /// Adds a body; `among_molecules` if bodies in cells may be molecules.
    pub fn add(
        &mut self,
        index: u32,
        body: &Body,
        motion: &Motion,
        drive: Option<&Drive>,
        bodies: usize,
        among_molecules: bool,
    ) {
        self.index_of.resize(bodies, IndexOrNone::NONE);
        self.expect_contacts(bodies);
        self.index_of[index as usize] = IndexOrNone::new(self.list.len());
        let multi_cell_body = MultiCellBody::new(index, body, motion, drive, among_molecules);
        self.has_molecules |= !multi_cell_body.is_disc_among_discs;
        self.list.push(multi_cell_body);
    }

    /// Whether all are discs among discs.
    #[inline]
    pub fn are_large_discs(&self) -> bool {
        !self.has_molecules
    }

    #[inline(always)]
    pub fn is_multi_cell(&self, body: u32) -> bool {
        self.get(body).is_some()
    }

    #[inline(always)]
    pub fn is_fixed(&self, body: u32) -> bool {
        self.get(body).is_some_and(|index| self.list[index].fixed)
    }

    /// End of the span for which a fixed body is listed (offset in the epoch, time); infinite for
    /// a body at rest.
    pub fn listed_until(&self, body: u32) -> f64 {
        self.get(body)
            .map_or(f64::INFINITY, |index| self.list[index].listed_until)
    }

    /// Start of the span for which a fixed body is listed (offset in the epoch, time).
    pub fn listed_from(&self, body: u32) -> f64 {
        self.get(body)
            .map_or(0.0, |index| self.list[index].listed_from)
    }

    pub fn heap_bytes(&self) -> usize {
        let of = |multi_cell_body: &MultiCellBody| {
            multi_cell_body.cells.capacity()
                + multi_cell_body.tiles.capacity()
                + multi_cell_body.neighbours.capacity()
        };
        let listed: usize = self.list.iter().map(of).sum();
        self.list.capacity() * size_of::<MultiCellBody>()
            + listed * size_of::<Listed>()
            + self.index_of.capacity() * size_of::<IndexOrNone>()
            + self.pending.capacity() * size_of::<Pending>()
            + self.covered.heap_bytes()
    }

    /// Sets the motion of a body, if it is a multi-cell body.
    #[inline]
    pub fn set_motion(&mut self, body: u32, motion: &Motion) {
        if let Some(index) = self.get(body) {
            self.list[index].motion = *motion;
        }
    }

    /// Sets what a body does beside uniform motion, if it is a multi-cell body.
    pub fn set_drive(&mut self, body: u32, drive: Option<Drive>) {
        if let Some(index) = self.get(body) {
            self.list[index].drive = drive;
        }
    }

    /// Sets the position and velocity of a body at a time and keeps its rotation, if it is a
    /// multi-cell body.
    #[inline]
    pub fn set_flight(&mut self, body: u32, time: f64, position: DVec2, velocity: DVec2) {
        if let Some(index) = self.get(body) {
            let motion = &mut self.list[index].motion;
            *motion = Motion {
                position,
                velocity,
                ..motion.at(time)
            };
        }
    }

    /// The motion of a body, if it is a multi-cell body.
    #[inline]
    pub fn motion(&self, body: u32) -> Option<&Motion> {
        self.get(body).map(|index| &self.list[index].motion)
    }

    #[inline(always)]
    fn get(&self, body: u32) -> Option<usize> {
        self.index_of.get(body as usize)?.get()
    }
}

impl Surroundings {
    fn clear(&mut self) {
        self.slots.clear();
        self.seen.clear();
        self.candidates.clear();
    }
}

impl Pending {
    pub const NOTHING: Self = Self {
        parts: TouchingParts::Discs,
        image: [0; 2],
    };

    /// All its bits.
    pub fn to_words(self) -> [u64; 2] {
        let pair = |low: u32, high: u32| u64::from(low) | u64::from(high) << 32;
        let part = |part| match part {
            Part::Atom(index) => index,
            Part::BoundingCircle => u32::MAX,
        };
        let (kind, parts) = match self.parts {
            TouchingParts::Discs => (0, 0),
            TouchingParts::Atoms(i, j) => (1, pair(i, j)),
            TouchingParts::BoundingCircles => (2, 0),
            TouchingParts::EdgeOfA { edge, part: of_b } => (3, pair(part(of_b), edge)),
            TouchingParts::EdgeOfB { edge, part: of_a } => (4, pair(part(of_a), edge)),
            TouchingParts::Bond(bond, bound) => (5, pair(bond, bound as u32)),
            TouchingParts::Step(bound) => (6, u64::from(bound as u32)),
        };
        let [x, y] = self.image.map(|boxes| u32::from(boxes as u16));
        [pair(x | y << 16, kind), parts]
    }
}
