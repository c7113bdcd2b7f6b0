//! `events`, `events:A,B`: every contact between bodies of two tags, written while the run
//! continues.

use anyhow::Result;
use carom::observers::{ContactLog, TagFilter};
use carom_tables::BlockMean;

use super::{
    Context, Label, MeasureKind, Measured, Of, Results, Selection, Span, in_blocks, known::Known,
    resumed,
};
use crate::{
    append_file::AppendFiles,
    series::{EVENTS, EVENTS_OF_EDGES},
};

/// The contacts, and whether bodies other than walls have straight edges.
type Contacts = Known<ContactLog, bool>;

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "events",
    summary: "every contact: time, bodies, place, normal, impulse, relative velocity (0.2 kB each)",
    of: Of::Pair,
    span: Span::EveryContact,
    parameters: &[],
    figures: &[],
    start: |selection| {
        Ok(in_blocks(Known {
            observer: ContactLog::new(filter(selection)),
            facts: has_edges(selection),
        }))
    },
    resume: resumed::<Contacts>,
};

fn has_edges(selection: &Selection<'_>) -> bool {
    let bodies = selection.view.bodies().map(|view| view.body);
    bodies
        .filter(|body| !body.is_wall())
        .any(|body| !body.molecule().edges().is_empty())
}

fn filter(selection: &Selection<'_>) -> TagFilter {
    match selection.tags() {
        [Some(one), Some(other)] => TagFilter::Pair(one, other),
        [Some(one), None] => TagFilter::One(one),
        _ => TagFilter::Any,
    }
}

impl Measured for Contacts {
    fn results(&self, _: &[BlockMean], context: &Context<'_>) -> Results {
        Results {
            files: vec![context.label.file(EVENTS.name)],
            ..Results::default()
        }
    }

    fn append(&mut self, files: &mut AppendFiles, label: &Label) -> Result<()> {
        let format = if self.facts {
            &EVENTS_OF_EDGES
        } else {
            &EVENTS
        };
        files.append_new_to(&label.file(EVENTS.name), format, &self.observer.take())
    }
}
