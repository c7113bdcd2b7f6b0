//! Disjoint sets of the bodies of a periodic box (union–find), with the windings of each set.
//!
//! Each body holds its image, in boxes, relative to that of its parent, so that the displacement
//! between any two bodies of a set along their connections is known. A connection of two bodies of
//! one set by another displacement closes a path around the box: the set wraps (Newman & Ziff,
//! Phys. Rev. E 64 (2001) 016706).

/// Sets of the bodies 0 … n − 1.
pub(crate) struct DisjointSets {
    /// The parent of each body; a root is its own.
    parents: Vec<usize>,
    /// The image of each body where its parent is in the image [0, 0] (boxes).
    images: Vec<[i64; 2]>,
    /// The set of each root; unused for other bodies.
    sets: Vec<WindingSet>,
}

/// A set of bodies that are connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct WindingSet {
    /// Number of its bodies.
    pub(crate) size: u64,
    /// Whether a path from a body to another image of it moves along x, and along y.
    pub(crate) wraps: [bool; 2],
}

impl DisjointSets {
    /// Sets of one body each.
    pub(crate) fn new(count: usize) -> Self {
        let alone = WindingSet {
            size: 1,
            wraps: [false; 2],
        };
        Self {
            parents: (0..count).collect(),
            images: vec![[0; 2]; count],
            sets: vec![alone; count],
        }
    }

    /// Connects a body with an image of another, or of itself (boxes).
    pub(crate) fn connect(&mut self, one: usize, other: usize, image: [i64; 2]) {
        let (root, start) = self.find(one);
        let (other_root, end) = self.find(other);
        let image = [0, 1].map(|axis| start[axis] + image[axis] - end[axis]);
        if root == other_root {
            for (wraps, boxes) in self.sets[root].wraps.iter_mut().zip(image) {
                *wraps |= boxes != 0;
            }
            return;
        }
        // The smaller set joins the larger one, so that paths to the root stay short.
        let (large, small, image) = if self.sets[root].size < self.sets[other_root].size {
            (other_root, root, image.map(|boxes| -boxes))
        } else {
            (root, other_root, image)
        };
        self.parents[small] = large;
        self.images[small] = image;
        let joined = self.sets[small];
        let set = &mut self.sets[large];
        set.size += joined.size;
        for (wraps, joined) in set.wraps.iter_mut().zip(joined.wraps) {
            *wraps |= joined;
        }
    }

    /// The root of a body, and the image of the body where the root is in [0, 0] (boxes).
    fn find(&mut self, mut body: usize) -> (usize, [i64; 2]) {
        let mut image = [0; 2];
        while self.parents[body] != body {
            // Path halving: each body on the way becomes a child of its grandparent.
            let parent = self.parents[body];
            self.parents[body] = self.parents[parent];
            self.images[body] = sum(self.images[body], self.images[parent]);
            image = sum(image, self.images[body]);
            body = self.parents[body];
        }
        (body, image)
    }

    /// All sets.
    pub(crate) fn sets(&self) -> impl Iterator<Item = WindingSet> + '_ {
        let roots = self.parents.iter().enumerate();
        roots
            .filter(|&(body, &parent)| body == parent)
            .map(|(body, _)| self.sets[body])
    }
}

fn sum(one: [i64; 2], other: [i64; 2]) -> [i64; 2] {
    [one[0] + other[0], one[1] + other[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_around_the_box_are_found_in_any_order_of_the_connections() {
        // A chain 0 → 1 → 2 → 3 that goes once around along x, and −2 times along y, if the last
        // connection closes it.
        let chain = [
            (0, 1, [0, 0]),
            (1, 2, [0, -1]),
            (2, 3, [1, 0]),
            (3, 0, [0, -1]),
        ];
        for first in 0..4 {
            let mut sets = DisjointSets::new(5);
            for step in 0..4 {
                let closed: Vec<WindingSet> = sets.sets().collect();
                assert_eq!(closed.len(), 5 - step);
                assert!(closed.iter().all(|set| set.wraps == [false; 2]));
                let (one, other, image) = chain[(first + step) % 4];
                sets.connect(one, other, image);
            }
            let mut found: Vec<WindingSet> = sets.sets().collect();
            found.sort_by_key(|set| set.size);
            let expected = [(1, [false; 2]), (4, [true; 2])];
            let expected = expected.map(|(size, wraps)| WindingSet { size, wraps });
            assert_eq!(found, expected);
            // A set that joins a set that wraps wraps, too.
            sets.connect(4, 2, [7, 7]);
            let set = WindingSet {
                size: 5,
                wraps: [true; 2],
            };
            assert_eq!(sets.sets().collect::<Vec<_>>(), [set]);
        }
        // A loop that closes where it began does not wrap; a body next to its own image does.
        let mut sets = DisjointSets::new(3);
        for (one, other, image) in [(0, 1, [1, 0]), (1, 2, [-2, 0]), (0, 2, [-1, 0])] {
            sets.connect(one, other, image);
        }
        assert!(sets.sets().all(|set| set.wraps == [false; 2]));
        sets.connect(2, 2, [0, 1]);
        assert!(sets.sets().all(|set| set.wraps == [false, true]));
    }
}
