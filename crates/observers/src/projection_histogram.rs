//! Components of the impulses on a body along one of its own axes (Montanari 2017, section 3.2,
//! item 2).
//!
//! J is the impulse on the body (mass × length / time) and θ its orientation at contact. Each
//! contact counts with the x′ or y′ component of R(−θ) J. In a range of the half-width w, bin k of
//! n
//! covers [−w + 2wk/n, −w + 2w(k+1)/n).

use carom_engine::{Body, BodyKey, CollisionReport, Observer};
use carom_geometry::{GeometryError, check_positive};
use serde::{Deserialize, Serialize};

use crate::{AdaptiveHistogram, body_frame::in_body_frame};

/// An axis of a body's own frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum BodyAxis {
    /// x′.
    X,
    /// y′.
    Y,
}

/// A histogram of the components of the impulses on one body along one of its axes.
///
/// ```
/// use carom_engine::BodyKey;
/// use carom_observers::{BodyAxis, ProjectionHistogram};
///
/// let along_x = ProjectionHistogram::new(BodyKey::default(), BodyAxis::X, 5.0, 100)?;
/// assert_eq!(along_x.components().bins().edges()[..2], [-5.0, -4.9]);
/// assert!(ProjectionHistogram::new(BodyKey::default(), BodyAxis::X, 0.0, 100).is_err());
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProjectionHistogram {
    body: BodyKey,
    axis: BodyAxis,
    components: AdaptiveHistogram,
    sum: f64,
    sum_of_squares: f64,
}

impl ProjectionHistogram {
    /// An empty histogram from −`half_width` to `half_width` (mass × length / time), with at least
    /// one bin: `bins` = 0 is taken as 1.
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if the half-width is not positive and finite.
    pub fn new(
        body: BodyKey,
        axis: BodyAxis,
        half_width: f64,
        bins: usize,
    ) -> Result<Self, GeometryError> {
        let half_width = check_positive("the half-width of a histogram", half_width)?;
        let components = AdaptiveHistogram::within(-half_width, half_width, bins);
        Ok(Self {
            components,
            ..Self::adaptive(body, axis, bins)
        })
    }

    /// An empty histogram whose range follows the impulses, so that none is lost, with at least
    /// `bins` bins; an odd number is rounded up, and 0 is taken as 2.
    pub fn adaptive(body: BodyKey, axis: BodyAxis, bins: usize) -> Self {
        let components = AdaptiveHistogram::of_components(bins.div_ceil(2));
        Self {
            body,
            axis,
            components,
            sum: 0.0,
            sum_of_squares: 0.0,
        }
    }

    /// The distribution of the components, one entry for each contact (mass × length / time).
    pub fn components(&self) -> &AdaptiveHistogram {
        &self.components
    }

    /// Number of contacts.
    pub fn hits(&self) -> u64 {
        self.components.total()
    }

    /// Mean of all components, including those outside the bins (mass × length / time); `None`
    /// without contacts.
    pub fn mean(&self) -> Option<f64> {
        (self.hits() > 0).then(|| self.sum / self.hits() as f64)
    }

    /// Mean square of all components (mass² × length² / time²); `None` without contacts.
    pub fn mean_square(&self) -> Option<f64> {
        (self.hits() > 0).then(|| self.sum_of_squares / self.hits() as f64)
    }
}

impl Observer for ProjectionHistogram {
    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.body.is_among(bodies)
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        let Some((side, impulse)) = report.side_of(self.body) else {
            return;
        };
        let own = in_body_frame(impulse, side.before.orientation);
        let component = match self.axis {
            BodyAxis::X => own.x,
            BodyAxis::Y => own.y,
        };
        self.sum += component;
        self.sum_of_squares += component * component;
        self.components.add(component);
    }
}
