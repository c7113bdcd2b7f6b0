//! An observer together with what theory needs to know of the scene at its start.

use carom::{CollisionReport, Observer, View, engine::Body};
use serde::{Deserialize, Serialize};

/// An observer, and facts of the scene that its predictions depend on.
#[derive(Serialize, Deserialize)]
pub(super) struct Known<O, T> {
    pub(super) observer: O,
    pub(super) facts: T,
}

impl<O: Observer, T> Observer for Known<O, T> {
    fn watches_any(&self) -> bool {
        self.observer.watches_any()
    }

    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.observer.watches(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        self.observer.start(view);
    }

    fn pause(&mut self, view: &View<'_>) {
        self.observer.pause(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.observer.collision(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        self.observer.sample(view);
    }
}
