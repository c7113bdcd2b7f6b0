//! What watches a replay: the physics that a user measures, and the list of all contacts.

use carom::{CollisionRate, CollisionReport, Observer, Pressure, View, kinematics::EpochTime};

/// Most atoms with counters of their own; hits on further ones are counted with the last.
pub const MOST_ATOMS: usize = 8;

/// Observers.
#[derive(Debug, Clone, Default)]
pub struct Measures {
    /// Pressure.
    pub pressure: Pressure,
    /// Collision rate.
    pub rate: CollisionRate,
    /// Hits by atom of molecules.
    pub hits: [u64; MOST_ATOMS],
}

impl Observer for Measures {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.pressure.collision(report);
        for side in &report.sides {
            if let Some(atom) = side.atom.filter(|_| !side.body.molecule().is_disc()) {
                self.hits[(atom as usize).min(MOST_ATOMS - 1)] += 1;
            }
        }
    }

    fn start(&mut self, view: &View<'_>) {
        self.pressure.start(view);
        self.rate.start(view);
    }

    fn sample(&mut self, view: &View<'_>) {
        self.pressure.sample(view);
        self.rate.sample(view);
    }
}

/// A contact: its time and its bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Time since the start of the interval.
    pub time: f64,
    /// Numbers of the two bodies.
    pub bodies: [u64; 2],
}

/// All contacts of an interval.
#[derive(Debug, Clone)]
pub struct Log {
    /// Start of the stretch.
    pub begin: EpochTime,
    /// In order of time.
    pub contacts: Vec<Contact>,
}

impl Observer for Log {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        let [a, b] = report.sides.each_ref().map(|side| side.body.id());
        let bodies = [a.min(b), a.max(b)];
        self.contacts.push(Contact { time: report.time.since(self.begin), bodies });
    }
}
