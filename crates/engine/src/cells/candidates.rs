//! Candidates of the narrow phase: bodies that may be touched before the earliest event so far,
//! lowest bound first.

use std::hint::select_unpredictable as select;

/// A body that may be touched.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate<T> {
    /// Lower bound on the contact time (from now).
    pub bound: f64,
    pub item: T,
    /// Whether the bound is as tight as it can be without a search.
    pub is_tight: bool,
}

impl<T> Candidate<T> {
    /// A candidate without a bound on its contact time but the present.
    pub fn unbounded(item: T) -> Self {
        Self {
            bound: 0.0,
            item,
            is_tight: true,
        }
    }

    /// The candidate with another representation of its body.
    pub fn map<U>(self, name: impl FnOnce(T) -> U) -> Candidate<U> {
        Candidate {
            bound: self.bound,
            item: name(self.item),
            is_tight: self.is_tight,
        }
    }
}

/// A set of candidates.
#[derive(Debug, Clone)]
pub(super) struct Candidates<T>(Vec<Candidate<T>>);

impl<T> Default for Candidates<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T: Copy> Candidates<T> {
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Keeps the candidates of whose bodies this holds.
    pub fn retain(&mut self, keeps: impl Fn(T) -> bool) {
        self.0.retain(|candidate| keeps(candidate.item));
    }

    pub fn push(&mut self, candidate: Candidate<T>) {
        self.0.push(candidate);
    }

    /// Appends the bodies whose bounds (time from now) satisfy `is_wanted`; `item` returns none for
    /// an empty lane.
    #[inline(always)]
    pub fn sift<const N: usize>(
        &mut self,
        bounds: [f64; N],
        is_wanted: impl Fn(f64) -> bool,
        item: impl Fn(usize) -> Option<T>,
    ) {
        // As many bits as an `f64` has, so that the compiler vectorises the loop in registers of
        // `f64`.
        let mut requested = 0;
        for (lane, &bound) in bounds.iter().enumerate() {
            requested |= if is_wanted(bound) { 1_u64 << lane } else { 0 };
        }
        while requested != 0 {
            let lane = requested.trailing_zeros() as usize % N;
            requested &= requested - 1;
            if let Some(item) = item(lane) {
                self.0.push(Candidate {
                    bound: bounds[lane],
                    item,
                    is_tight: false,
                });
            }
        }
    }

    /// Removes and returns the candidate with the lowest bound; of equal ones that of the body
    /// inserted first.
    #[inline]
    pub fn take_least(&mut self, body: impl Fn(&T) -> u32) -> Option<Candidate<T>> {
        let mut least = 0;
        let mut soonest = (f64::INFINITY, u32::MAX);
        for (place, candidate) in self.0.iter().enumerate() {
            let this = (candidate.bound, body(&candidate.item));
            let is_sooner = (this.0 < soonest.0) | ((this.0 == soonest.0) & (this.1 < soonest.1));
            least = select(is_sooner, place, least);
            soonest = (
                select(is_sooner, this.0, soonest.0),
                select(is_sooner, this.1, soonest.1),
            );
        }
        (!self.0.is_empty()).then(|| self.0.swap_remove(least))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_bound_comes_first_and_of_equal_ones_the_body_inserted_first() {
        let mut candidates = Candidates::default();
        let item = [7, 3, 9, 4, 1, 8, 2, 6];
        let bounds = [2.0, 1.0, f64::INFINITY, 1.0, 0.0, f64::NAN, 5.0, 3.0];
        // The last lane is empty.
        candidates.sift(
            bounds,
            |bound| bound < 4.0,
            |lane| (lane < 7).then(|| item[lane]),
        );
        candidates.sift([1.0], |bound| bound < 4.0, |_| Some(5));
        let mut order = Vec::new();
        while let Some(candidate) = candidates.take_least(|&body| body) {
            order.push((candidate.bound, candidate.item));
        }
        assert_eq!(order, [(0.0, 1), (1.0, 3), (1.0, 4), (1.0, 5), (2.0, 7)]);
    }

    #[test]
    fn candidates_with_infinite_bounds_are_returned_as_well() {
        let mut candidates = Candidates::default();
        candidates.sift([f64::INFINITY; 2], |_| true, |lane| Some(lane as u32));
        assert_eq!(
            candidates
                .take_least(|&body| body)
                .map(|candidate| candidate.item),
            Some(0)
        );
        assert_eq!(
            candidates
                .take_least(|&body| body)
                .map(|candidate| candidate.item),
            Some(1)
        );
        assert!(candidates.take_least(|&body| body).is_none());
    }
}
