//! One measure of a run: when it begins, and which samples it receives.

use anyhow::{Context as _, Result, bail};
use carom::{CollisionReport, Observer, Scene, View, engine::Body};
use serde::{Deserialize, Serialize};

use crate::run::stages;

use super::{Kind, Label, Measure, Request, Selection, Span, overlap, request::find};

/// A sample counts as reached if its time is too early by this share: times of samples are rounded.
const ROUNDING: f64 = 1e-9;

/// A measure in progress.
pub(super) struct Entry {
    pub(super) head: Head,
    pub(super) kind: &'static Kind,
    pub(super) measure: Box<dyn Measure>,
}

/// What an entry needs besides its measure.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Head {
    kind: String,
    pub(super) label: Label,
    /// Whether the scene asks for its tables and files.
    pub(super) is_asked: bool,
    /// It begins at the first sample at or after this time, and ends with that at `until`.
    from: f64,
    until: f64,
    stage: Stage,
    /// Whether it receives the checks of the run, which have times of their own, and no samples.
    is_check: bool,
    /// It receives each sample of this number.
    pub(super) every: u64,
    /// Samples of the run since it began.
    seen: u64,
}

/// Whether a measure observes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum Stage {
    Waits,
    Observes,
    HasEnded,
}

impl Entry {
    /// Starts what a scene asks for.
    ///
    /// # Errors
    /// No body carries a tag, or a body is not unique.
    pub(super) fn begin(request: &Request, is_asked: bool, scene: &Scene, view: &View<'_>) -> Result<Self> {
        let selection = Selection::new(request, &scene.run, view)?;
        let measure = (request.kind.begin)(&selection).with_context(|| request.entry.clone())?;
        let is_measured = request.kind.span == Span::Measurement;
        let (from, until) = if is_measured { stages::window(scene) } else { (0.0, f64::INFINITY) };
        let head = Head {
            kind: request.kind.name.to_owned(),
            label: Label { tag: request.tag(), name: request.name.clone() },
            is_asked,
            from,
            until,
            stage: Stage::Waits,
            is_check: request.kind.name == overlap::KIND.name && scene.run.check_interval.is_some(),
            every: request.every,
            seen: 0,
        };
        Ok(Self { head, kind: request.kind, measure })
    }

    /// Restores a measure from a checkpoint.
    ///
    /// # Errors
    /// Its kind is unknown, or its state cannot be read.
    pub(super) fn resume(head: Head, bytes: &[u8]) -> Result<Self> {
        let Some(kind) = find(&head.kind) else { bail!("the measure '{}' is unknown", head.kind) };
        let measure = (kind.resume)(bytes)?;
        Ok(Self { head, kind, measure })
    }

    /// Gives the measure its last sample, if it lies between two of its own.
    pub(super) fn finish(&mut self, view: &View<'_>) {
        let is_between = self.head.seen > 0 && !(self.head.seen - 1).is_multiple_of(self.head.every);
        if self.is_open() && is_between {
            self.measure.finish(view);
        }
        self.head.stage = Stage::HasEnded;
    }

    /// Gives the measure a check of the run, if it receives them.
    pub(super) fn check(&mut self, view: &View<'_>) {
        if self.head.is_check {
            self.measure.sample(view);
        }
    }

    fn is_open(&self) -> bool {
        self.head.stage == Stage::Observes
    }
}

impl Observer for Entry {
    fn watches_any(&self) -> bool {
        self.is_open() && self.measure.watches_any()
    }

    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.is_open() && self.measure.watches(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        if self.is_open() {
            self.measure.start(view);
        }
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.measure.collision(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        let head = &mut self.head;
        if head.stage == Stage::HasEnded || head.is_check {
            return;
        }
        if head.stage == Stage::Waits {
            if view.time().to_f64() < head.from * (1.0 - ROUNDING) {
                return;
            }
            head.stage = Stage::Observes;
            self.measure.start(view);
        }
        if head.seen.is_multiple_of(head.every.max(1)) {
            self.measure.sample(view);
        }
        head.seen += 1;
        if view.time().to_f64() >= head.until * (1.0 - ROUNDING) {
            self.finish(view);
        }
    }
}
