//! `events`, `events:A,B`: every contact between bodies of two tags, written while the run
//! continues.

use anyhow::Result;
use carom::observers::{ContactLog, TagFilter};
use carom_tables::BlockMean;

use super::{
    Context, Label, MeasureKind, Measured, Of, Results, Selection, Span, in_blocks, resumed,
};
use crate::{append_file::AppendFiles, series::EVENTS};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "events",
    summary: "every contact: time, bodies, place, normal, impulse, relative velocity (0.2 kB each)",
    of: Of::Pair,
    span: Span::EveryContact,
    parameters: &[],
    figures: &[],
    start: |selection| Ok(in_blocks(ContactLog::new(filter(selection)))),
    resume: resumed::<ContactLog>,
};

fn filter(selection: &Selection<'_>) -> TagFilter {
    match selection.tags() {
        [Some(one), Some(other)] => TagFilter::Pair(one, other),
        [Some(one), None] => TagFilter::One(one),
        _ => TagFilter::Any,
    }
}

impl Measured for ContactLog {
    fn results(&self, _: &[BlockMean], context: &Context<'_>) -> Results {
        Results {
            files: vec![context.label.file(EVENTS.name)],
            ..Results::default()
        }
    }

    fn append(&mut self, files: &mut AppendFiles, label: &Label) -> Result<()> {
        files.append_new_to(&label.file(EVENTS.name), &EVENTS, &self.take())
    }
}
