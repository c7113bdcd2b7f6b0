//! `impulses:TAG`: every impulse on one body, written while the run continues.

use anyhow::Result;
use carom::observers::ImpulseLog;
use carom_tables::BlockMean;

use super::{
    Context, Default, Label, MeasureKind, Measured, Of, Parameter, Results, Span, in_blocks,
    known::Known, resumed,
};
use crate::{
    append_file::AppendFiles,
    series::{IMPULSES, IMPULSES_OF_EDGES},
};

/// The impulses, and whether the body has straight edges.
type Impulses = Known<ImpulseLog, bool>;

/// Its name in `run.observe`.
pub(crate) const NAME: &str = "impulses";

pub(super) const KIND: MeasureKind = MeasureKind {
    name: NAME,
    summary: "every impulse on the only body with the tag, as a table",
    of: Of::OneBody,
    span: Span::EveryContact,
    parameters: &[Parameter::records(
        "max",
        Default::Number(1e6),
        "largest number of rows (0.2 kB each)",
    )],
    figures: &[],
    start: |selection| {
        let body = selection.only_body()?.body;
        Ok(in_blocks(Known {
            observer: ImpulseLog::new(body.key(), selection.whole("max") as u64),
            facts: !body.molecule().edges().is_empty(),
        }))
    },
    resume: resumed::<Impulses>,
};

/// The file's name has no tag.
fn file(label: &Label) -> String {
    Label {
        tag: None,
        ..label.clone()
    }
    .file(IMPULSES.name)
}

impl Measured for Impulses {
    fn results(&self, _: &[BlockMean], context: &Context<'_>) -> Results {
        Results {
            files: vec![file(context.label)],
            ..Results::default()
        }
    }

    fn append(&mut self, files: &mut AppendFiles, label: &Label) -> Result<()> {
        let format = if self.facts {
            &IMPULSES_OF_EDGES
        } else {
            &IMPULSES
        };
        files.append_new_to(&file(label), format, &self.observer.take())
    }
}
