//! Random removal from an ordered list: each removal takes O(log n), and the rest keeps its order.

/// The remaining elements of a list of fixed length (a Fenwick tree of their counts).
#[doc(alias = "binary indexed tree")]
pub(crate) struct Remaining {
    /// Node i, from 1 on, counts the remaining elements among the last (i & −i) up to i.
    tree: Vec<u32>,
    taken: Vec<bool>,
    len: usize,
}

impl Remaining {
    /// All elements of a list of length `len`, at most 2³² − 1.
    pub fn all(len: usize) -> Self {
        let tree = (0..=len)
            .map(|node| (node & node.wrapping_neg()) as u32)
            .collect();
        Self {
            tree,
            taken: vec![false; len],
            len,
        }
    }

    /// Number of remaining elements.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Removes the remaining element number `rank`, from 0; `rank` must be below [`Self::len`].
    pub fn take(&mut self, rank: usize) {
        let (mut before, mut rank) = (0, rank as u32);
        let mut stride = self.taken.len().checked_ilog2().map_or(0, |bits| 1 << bits);
        while stride > 0 {
            let node = before + stride;
            if let Some(&count) = self.tree.get(node)
                && count <= rank
            {
                rank -= count;
                before = node;
            }
            stride /= 2;
        }
        self.taken[before] = true;
        self.len -= 1;
        let mut node = before + 1;
        while let Some(count) = self.tree.get_mut(node) {
            *count -= 1;
            node += node & node.wrapping_neg();
        }
    }

    /// Removes all other elements from a list of the same length.
    pub fn keep<T>(&self, list: &mut Vec<T>) {
        let mut taken = self.taken.iter();
        list.retain(|_| taken.next().is_none_or(|&taken| !taken));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn elements_are_taken_as_by_removal_from_a_list() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(5);
        for len in [1, 2, 3, 7, 8, 9, 64, 1000] {
            let mut remaining = Remaining::all(len);
            let mut list: Vec<usize> = (0..len).collect();
            while remaining.len() > 0 {
                assert_eq!(remaining.len(), list.len());
                let rank = random.random_range(0..list.len());
                list.remove(rank);
                remaining.take(rank);
                let mut kept: Vec<usize> = (0..len).collect();
                remaining.keep(&mut kept);
                assert_eq!(kept, list);
            }
        }
    }
}
