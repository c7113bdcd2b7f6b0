//! The multi-cell bodies listed in each cell: none in most, one in many, several where bodies are
//! close together.

use smallvec::SmallVec;

use super::Listed;
use crate::cells::slot::{INDEX_BITS, INDEX_MASK, image_code, image_of};

/// Image code that no slot has: the other bits are the index of a list in `several`.
const SEVERAL: u32 = 0xf << INDEX_BITS;

/// An empty slot.
const NONE: u32 = u32::MAX;

/// The multi-cell bodies listed in each cell.
#[derive(Debug, Clone, Default)]
pub(in crate::cells) struct CoveredCells {
    /// One word for each cell, because a disc in the cell waits for this memory access: the index
    /// of a body and the image in which it is seen, or the index of a list in `several`.
    slots: Vec<u32>,
    several: Vec<SmallVec<[Listed; 4]>>,
}

impl CoveredCells {
    /// Empties all cells.
    pub fn lay_out(&mut self, cells: usize) {
        self.slots.clear();
        self.slots.resize(cells, NONE);
        self.several.clear();
    }

    pub fn heap_bytes(&self) -> usize {
        self.slots.capacity() * size_of::<u32>()
            + self.several.capacity() * size_of::<SmallVec<[Listed; 4]>>()
    }

    /// Lists a body in a cell.
    pub fn enter(&mut self, cell: u32, body: Listed) {
        let slot = &mut self.slots[cell as usize];
        match *slot {
            NONE if body.image.iter().all(|boxes| boxes.abs() <= 1) => {
                *slot = body.index
                    | (image_code(body.image[0]) | image_code(body.image[1]) << 2) << INDEX_BITS;
            }
            old if old < SEVERAL || old == NONE => {
                *slot = SEVERAL | self.several.len() as u32;
                self.several.push(
                    (old != NONE)
                        .then(|| single(old))
                        .into_iter()
                        .chain([body])
                        .collect(),
                );
            }
            place => self.several[(place & INDEX_MASK) as usize].push(body),
        }
    }

    /// Removes a body from a cell, in all images, and returns whether the cell is then empty.
    pub fn leave(&mut self, cell: u32, body: u32) -> bool {
        let slot = &mut self.slots[cell as usize];
        match *slot {
            NONE => {}
            one if one < SEVERAL => {
                if one & INDEX_MASK == body {
                    *slot = NONE;
                }
            }
            place => {
                let listed = &mut self.several[(place & INDEX_MASK) as usize];
                listed.retain(|other| other.index != body);
                return listed.is_empty();
            }
        }
        *slot == NONE
    }

    /// Number of entries of a cell.
    #[inline]
    pub fn count(&self, cell: u32) -> usize {
        match self.slots[cell as usize] {
            NONE => 0,
            one if one < SEVERAL => 1,
            place => self.several[(place & INDEX_MASK) as usize].len(),
        }
    }

    /// An entry of a cell: a body, and the image in which the cell's discs appear in its frame.
    #[inline]
    pub fn get(&self, cell: u32, place: usize) -> Listed {
        match self.slots[cell as usize] {
            one if one < SEVERAL => single(one),
            several => self.several[(several & INDEX_MASK) as usize][place],
        }
    }
}

/// The single entry in a slot.
#[inline]
fn single(slot: u32) -> Listed {
    Listed {
        index: slot & INDEX_MASK,
        image: image_of(slot),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// After any sequence of changes, a cell holds the bodies listed there, each in its images.
        #[test]
        fn a_cell_holds_the_bodies_listed_in_it(
            moves in prop::collection::vec((0u32..3, 0u32..4, -2i32..3, -2i32..3, any::<bool>()), 0..60),
        ) {
            let mut cells = CoveredCells::default();
            cells.lay_out(3);
            let mut expected: [Vec<Listed>; 3] = Default::default();
            for (cell, index, x, y, enters) in moves {
                let there = &mut expected[cell as usize];
                if enters {
                    cells.enter(cell, Listed { index, image: [x, y] });
                    there.push(Listed { index, image: [x, y] });
                } else {
                    there.retain(|other| other.index != index);
                    prop_assert_eq!(cells.leave(cell, index), there.is_empty());
                }
                for (cell, there) in (0..).zip(&expected) {
                    prop_assert_eq!(cells.count(cell), there.len());
                    let listed: Vec<Listed> = (0..there.len()).map(|place| cells.get(cell, place)).collect();
                    prop_assert_eq!(&listed, there);
                }
            }
        }
    }
}
