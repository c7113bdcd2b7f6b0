//! A moving disc in the frame of a molecule, with the rounding errors of its position and velocity.

/// A disc in the frame that moves and turns with a molecule: position p = R⁻¹ d and velocity p' =
/// R⁻¹ V − ω J p; see [`query_body`](crate::query_body).
pub(crate) struct RelativeDisc {
    /// p (length).
    pub(crate) place: [f64; 2],
    /// p' (length / time).
    pub(crate) rate: [f64; 2],
    /// Upper bound on |d| (length).
    pub(crate) distance: f64,
    /// Upper bound on |V| (length / time).
    pub(crate) speed: f64,
    /// Radius of the disc (length).
    pub(crate) radius: f64,
    /// Bound on the rounding of a gap to the disc (length).
    pub(crate) error: f64,
    /// Bound on the rounding of the rate of a gap to the disc (length / time).
    pub(crate) rate_error: f64,
}
