//! Bins as circular doubly linked lists of bodies, so that insertion and removal have no branches.

use crate::cells::simd;

/// Previous and next body in a circular list.
type Link = [u32; 2];
const PREVIOUS: usize = 0;
const NEXT: usize = 1;

/// Width of a bin in mean intervals between events of the system. Smaller: more empty bins, and a
/// longer overflow list. Larger: more to sort. From 1.5 to 6 the run time is the same, and fewer
/// bins need less memory.
pub(super) const EVENTS_PER_BIN: f64 = 6.0;

/// Bodies for each bin of the ring. With this length of the ring, one body in twenty is in the
/// overflow list.
const BODIES_PER_BIN: u32 = 2;

/// The lists of all bins, and the overflow list.
#[derive(Debug, Clone, Default)]
pub(super) struct Links {
    /// A link for each body, then a head for each bin of the ring, then the head of the overflow
    /// list.
    links: Vec<Link>,
    bodies: u32,
}

impl Links {
    /// Number of bins for so many bodies.
    pub fn ring(bodies: u32) -> u32 {
        (bodies / BODIES_PER_BIN).max(1)
    }

    /// Makes all lists empty.
    pub fn lay_out(&mut self, bodies: u32, ring: u32) {
        self.bodies = bodies;
        self.links.clear();
        self.links.extend((0..=bodies + ring).map(|head| [head; 2]));
    }

    pub fn heap_bytes(&self) -> usize {
        self.links.capacity() * size_of::<Link>()
    }

    /// Whether all bins are empty, apart from the overflow list.
    pub fn is_empty(&self) -> bool {
        let last = self.links.len() as u32 - 1;
        (self.bodies..last).all(|bin| self.links[bin as usize][NEXT] == bin)
    }

    /// Removes a body from its list; its own link stays.
    #[inline(always)]
    pub fn unlink(&mut self, body: u32) {
        let [previous, next] = self.links[body as usize];
        self.links[previous as usize][NEXT] = next;
        self.links[next as usize][PREVIOUS] = previous;
    }

    /// Inserts a body into the list of a place in the ring.
    #[inline(always)]
    pub fn link(&mut self, body: u32, place: u32) {
        let head = self.bodies + place;
        let first = self.links[head as usize][NEXT];
        self.links[body as usize] = [head, first];
        self.links[head as usize][NEXT] = body;
        self.links[first as usize][PREVIOUS] = body;
    }

    /// Marks that a body is in no list.
    #[inline(always)]
    pub fn detach(&mut self, body: u32) {
        self.links[body as usize] = [body; 2];
    }

    /// Empties a bin; each body goes to `take`.
    #[inline(always)]
    pub fn empty(&mut self, place: u32, mut take: impl FnMut(u32)) {
        let head = self.bodies + place;
        let mut body = self.links[head as usize][NEXT];
        self.links[head as usize] = [head; 2];
        while body != head {
            let next = self.links[body as usize][NEXT];
            self.links[body as usize] = [body; 2];
            take(body);
            body = next;
        }
    }

    /// The bodies in a bin.
    pub fn bodies(&self, place: u32) -> impl Iterator<Item = u32> {
        let head = self.bodies + place;
        let after =
            move |body: u32| Some(self.links[body as usize][NEXT]).filter(|&next| next != head);
        std::iter::successors(after(head), move |&body| after(body))
    }

    /// Prefetches the link of a body.
    pub fn prefetch(&self, body: u32) {
        simd::prefetch(&self.links, body as usize);
    }
}
