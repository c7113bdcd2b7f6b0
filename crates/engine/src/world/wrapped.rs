//! Journal of the periodic wraps in a scheduler, so that a step need not copy all bodies into the
//! world.

/// The bodies that a scheduler has moved by a side of the box since the world was last brought up
/// to date.
///
/// Bounded by the number of bodies: a longer journal costs more than a copy of all of them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Wrapped {
    bodies: Vec<u32>,
    most: usize,
    is_incomplete: bool,
}

impl Wrapped {
    /// Empties the journal at the start of an epoch of so many bodies.
    pub fn start(&mut self, bodies: usize) {
        self.bodies.clear();
        self.most = bodies;
        self.is_incomplete = false;
    }

    /// Notes that a body has been wrapped.
    #[inline]
    pub fn push(&mut self, body: u32) {
        if self.bodies.len() <= self.most {
            self.bodies.push(body);
        }
    }

    /// Notes that bodies have been wrapped without being noted.
    pub fn overflow(&mut self) {
        self.is_incomplete = true;
    }

    /// Takes the bodies noted, some of them perhaps more than once; `None` if they were too many to
    /// be noted.
    pub fn take(&mut self) -> Option<Vec<u32>> {
        let overflown = std::mem::take(&mut self.is_incomplete) || self.bodies.len() > self.most;
        let bodies = std::mem::take(&mut self.bodies);
        (!overflown).then_some(bodies)
    }

    pub fn heap_bytes(&self) -> usize {
        self.bodies.capacity() * size_of::<u32>()
    }
}
