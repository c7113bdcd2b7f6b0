//! Every impulse Δp on a body, contact by contact (Montanari 2017, section 3.2, items 1 and 2).

use carom_engine::{Body, BodyKey, CollisionReport, Observer};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::body_frame::in_body_frame;

/// One contact of the observed body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Impulse {
    /// Time of the contact.
    pub time: f64,
    /// Index of the atom that was touched; `None` in the model of bounding circles, and for an edge
    /// touched between its ends.
    pub atom: Option<u32>,
    /// Index of the straight edge that was touched between its ends.
    pub edge: Option<u32>,
    /// Number of the other body, [`Body::id`](carom_engine::Body::id).
    pub other: u64,
    /// Unit vector along the impulse, from the other body to this one, in the frame of the box.
    pub normal: DVec2,
    /// The impulse on it, in the frame of the box (mass × length / time).
    pub impulse: DVec2,
    /// The impulse in the body's own frame (x′, y′) at the time of contact (mass × length / time).
    pub in_body_frame: DVec2,
}

/// Records up to `most` impulses on one body, and counts the others.
///
/// [`Self::take`] removes the recorded impulses, so that a long run needs no more memory.
///
/// ```
/// use carom_engine::{Scene, Simulation};
/// use carom_observers::ImpulseLog;
///
/// // A disc at rest, hit from the left.
/// let scene = Scene::from_toml(r#"
///     [[molecule]]
///     atoms = [{ at = [0, 0], radius = 0.05, mass = 1 }]
///     at = [0.5, 0.5]
///     [[molecule]]
///     atoms = [{ at = [0, 0], radius = 0.05, mass = 1 }]
///     at = [0.2, 0.5]
///     velocity = [1.0, 0.0]
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// let target = simulation.view().bodies().next().expect("there are two bodies").body.key();
/// let mut log = ImpulseLog::new(target, 100);
/// simulation.observe_until(0.3, &mut log)?;
/// let impulses = log.take();
/// assert_eq!(impulses.len(), 1);
/// assert!((impulses[0].impulse.x - 1.0).abs() < 1e-12 && impulses[0].normal.x == 1.0);
/// assert!(log.take().is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[doc(alias = "kicks")]
pub struct ImpulseLog {
    body: BodyKey,
    most: u64,
    seen: u64,
    impulses: Vec<Impulse>,
}

impl ImpulseLog {
    /// An empty log for one body that keeps the first `most` impulses.
    pub fn new(body: BodyKey, most: u64) -> Self {
        Self {
            body,
            most,
            seen: 0,
            impulses: Vec::new(),
        }
    }

    /// Removes and returns the impulses recorded since the last call.
    pub fn take(&mut self) -> Vec<Impulse> {
        std::mem::take(&mut self.impulses)
    }

    /// The number of impulses, recorded or not.
    pub fn seen(&self) -> u64 {
        self.seen
    }
}

impl Observer for ImpulseLog {
    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.body.is_among(bodies)
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        let Some((side, impulse)) = report.side_of(self.body) else {
            return;
        };
        // A contact without impulse is not recorded.
        if impulse == DVec2::ZERO {
            return;
        }
        self.seen += 1;
        if self.seen > self.most {
            return;
        }
        let is_first = report.sides[0].body.key() == self.body;
        let other = &report.sides[usize::from(is_first)];
        self.impulses.push(Impulse {
            time: report.time.to_f64(),
            atom: side.atom,
            edge: side.edge,
            other: other.body.id(),
            normal: if is_first {
                -report.normal
            } else {
                report.normal
            },
            impulse,
            in_body_frame: in_body_frame(impulse, side.before.orientation),
        });
    }
}
