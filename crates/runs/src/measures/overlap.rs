//! `overlap`: pairs that overlap by more than rounding, at each sample of the whole run.

use carom::OverlapCheck;
use carom_tables::{BlockMean, Totals};

use super::{Context, MeasureKind, Measured, Of, Results, Span, in_blocks, resumed};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "overlap",
    summary: "overlapping pairs at each sample; always checked",
    of: Of::System,
    span: Span::WholeRun,
    parameters: &[],
    figures: &[],
    start: |_| Ok(in_blocks(OverlapCheck::default())),
    resume: resumed::<OverlapCheck>,
};

impl Measured for OverlapCheck {
    fn results(&self, _: &[BlockMean], _: &Context<'_>) -> Results {
        let totals = Totals {
            overlapping_pairs: self.worst_pairs(),
            max_overlap: self.deepest(),
            ..Totals::default()
        };
        Results {
            totals,
            overlap_checks: self.checks(),
            ..Results::default()
        }
    }
}
