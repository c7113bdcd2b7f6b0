//! Bins as cache lines with the numbers of bodies. What does not fit into one line goes to
//! further ones; a body whose event has moved to another bin stays as a dead entry.
//!
//! Writes to bins are collected and made a little later: meanwhile their lines come from memory.

use crate::cells::simd;

/// Width of a bin in mean intervals between events of the system. Each event leaves two dead
/// entries on average, so that a line is nearly full. From 2 to 4 the run time is the same; smaller
/// needs more memory.
pub(super) const EVENTS_PER_BIN: f64 = 4.0;

/// Bins of the ring for each body: it then spans as many events as two for each body, and one body
/// in ten is in the overflow list.
const BINS_PER_BODY: f64 = 2.0 / EVENTS_PER_BIN;

/// Places of a line: the number of bodies, the bodies, and the line after it.
const LENGTH: usize = 16;
const CAPACITY: usize = LENGTH - 2;
const COUNT: usize = 0;
const NEXT: usize = LENGTH - 1;

/// No line.
const NONE: u32 = u32::MAX;

/// Number of writes that wait for their lines. Fewer: memory answers too late. More: they are
/// searched longer when a bin is opened.
const WAITING: usize = 16;

/// One cache line.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Line([u32; LENGTH]);

impl Line {
    const EMPTY: Self = {
        let mut places = [0; LENGTH];
        places[NEXT] = NONE;
        Self(places)
    };

    fn bodies(&self) -> &[u32] {
        &self.0[COUNT + 1..][..self.0[COUNT] as usize]
    }
}

/// The lines of all bins, and the overflow list.
#[derive(Debug, Clone, Default)]
pub(super) struct Lines {
    ring: Vec<Line>,
    /// Lines that are full, behind those of the ring.
    further: Vec<Line>,
    /// Those of them that are not used.
    free: Vec<u32>,
    /// Bodies later than the ring; an event that has moved here more than once is here as often.
    overflow: Vec<u32>,
    /// Writes that wait: place and body, in a ring from `oldest` on.
    waiting: [(u32, u32); WAITING],
    oldest: usize,
    count: usize,
}

impl Lines {
    /// Number of bins for so many bodies.
    pub fn ring(bodies: u32) -> u32 {
        ((BINS_PER_BODY * f64::from(bodies)) as u32).max(1)
    }

    /// Makes all bins empty.
    pub fn lay_out(&mut self, ring: u32) {
        self.ring.clear();
        self.ring.resize(ring as usize, Line::EMPTY);
        self.further.clear();
        self.free.clear();
        self.overflow.clear();
        (self.oldest, self.count) = (0, 0);
    }

    pub fn heap_bytes(&self) -> usize {
        (self.ring.capacity() + self.further.capacity()) * size_of::<Line>()
            + (self.free.capacity() + self.overflow.capacity()) * size_of::<u32>()
    }

    /// Whether all bins are empty, apart from the overflow list.
    pub fn is_empty(&self) -> bool {
        let is_empty = |line: &Line| line.0[COUNT] == 0 && line.0[NEXT] == NONE;
        self.count == 0 && self.ring.iter().all(is_empty)
    }

    /// The bodies that are later than the ring, with those whose event has moved.
    pub fn overflow(&self) -> &[u32] {
        &self.overflow
    }

    pub fn clear_overflow(&mut self) {
        self.overflow.clear();
    }

    /// The bodies in the first line of a bin.
    pub fn bodies(&self, place: u32) -> &[u32] {
        self.ring
            .get(place as usize)
            .map_or(&[], |line| line.bodies())
    }

    /// Inserts a body into the bin at a place of the ring, or beyond it into the overflow list.
    #[inline(always)]
    pub fn put(&mut self, body: u32, place: u32) {
        if place as usize >= self.ring.len() {
            self.overflow.push(body);
            return;
        }
        simd::prefetch(&self.ring, place as usize);
        if self.count == WAITING {
            let (oldest_place, oldest_body) = self.waiting[self.oldest];
            self.write(oldest_place, oldest_body);
            self.oldest = (self.oldest + 1) % WAITING;
            self.count -= 1;
        }
        self.waiting[(self.oldest + self.count) % WAITING] = (place, body);
        self.count += 1;
    }

    /// Makes all writes that wait.
    fn write_waiting(&mut self) {
        for index in 0..self.count {
            let (place, body) = self.waiting[(self.oldest + index) % WAITING];
            self.write(place, body);
        }
        self.count = 0;
    }

    #[inline(always)]
    fn write(&mut self, place: u32, body: u32) {
        let mut count = self.ring[place as usize].0[COUNT] as usize;
        if count == CAPACITY {
            count = self.make_room(place);
        }
        let line = &mut self.ring[place as usize].0;
        line[COUNT + 1 + count] = body;
        line[COUNT] = count as u32 + 1;
    }

    /// Moves a full line behind the one of the ring, which is empty then.
    #[cold]
    #[inline(never)]
    fn make_room(&mut self, place: u32) -> usize {
        let full = self.ring[place as usize];
        let index = if let Some(index) = self.free.pop() {
            self.further[index as usize] = full;
            index
        } else {
            self.further.push(full);
            self.further.len() as u32 - 1
        };
        self.ring[place as usize] = Line::EMPTY;
        self.ring[place as usize].0[NEXT] = index;
        0
    }

    /// Empties a bin; each body goes to `take`.
    #[inline(always)]
    pub fn empty(&mut self, place: u32, mut take: impl FnMut(u32)) {
        let waits = |index: usize| self.waiting[(self.oldest + index) % WAITING].0 == place;
        if (0..self.count).any(waits) {
            self.write_waiting();
        }
        let mut line = std::mem::replace(&mut self.ring[place as usize], Line::EMPTY);
        loop {
            for &body in line.bodies() {
                take(body);
            }
            let next = line.0[NEXT];
            if next == NONE {
                return;
            }
            line = self.further[next as usize];
            self.free.push(next);
        }
    }
}
