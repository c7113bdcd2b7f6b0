//! Gaps between two discs at their reported contacts, a measure of the rounding error.

use carom::{CollisionReport, Observer, PeriodicBox};

/// Largest allowed gap or overlap at a contact, in units of ε × side of the box. A larger overlap
/// would violate the guarantee of the engine.
pub const MAX_ROUNDINGS: f64 = 16.0;

/// Observer of the extreme gaps of all contacts between discs.
#[derive(Debug, Clone)]
pub struct GapStatistics {
    bounds: PeriodicBox,
    /// Deepest overlap and largest gap at a contact, in units of ε × longer side of the box.
    pub deepest: f64,
    pub farthest: f64,
    /// Number of contacts examined.
    pub contacts: u64,
}

impl GapStatistics {
    /// An observer for contacts in a box.
    pub fn new(bounds: &PeriodicBox) -> Self {
        Self {
            bounds: *bounds,
            deepest: 0.0,
            farthest: 0.0,
            contacts: 0,
        }
    }
}

impl Observer for GapStatistics {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        let [a, b] = &report.sides;
        let [radius_a, radius_b] = [a, b].map(|side| side.body.molecule().bounding_radius());
        let gap = (report.separation().length() - (radius_a + radius_b))
            / (f64::EPSILON * self.bounds.sides().max_element());
        self.deepest = self.deepest.max(-gap);
        self.farthest = self.farthest.max(gap);
        self.contacts += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{Exact, HeapScheduler, Impact, Scene, Simulation, engine::CellsPerSide};

    use carom_testkit::extremes::{bodies::disc, engine::in_box};

    #[test]
    fn two_discs_meet_within_rounding_also_across_the_border() {
        let molecules = vec![
            disc(0.1, 1.0, [0.1, 0.5], [-1.0, 0.3]),
            disc(0.1, 1.0, [0.8, 0.55], [0.0, 0.3]),
        ];
        let scene: Scene = in_box([1.0, 1.0], molecules);
        let mut run = Simulation::<Exact, Impact, HeapScheduler>::with(
            &scene,
            Exact::default(),
            Impact,
            CellsPerSide::Automatic,
        )
        .unwrap();
        let mut gaps = GapStatistics::new(&run.view().bounds());
        run.observe_until(40.0, &mut gaps).unwrap();
        assert!(gaps.contacts >= 10, "{gaps:?}");
        assert!(gaps.deepest.max(gaps.farthest) <= MAX_ROUNDINGS, "{gaps:?}");
    }
}
