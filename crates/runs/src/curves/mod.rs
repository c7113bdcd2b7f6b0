//! Curves over the lag: errors of their means, and the coefficients that are read from them.

mod coefficient;
mod transport;

pub(crate) use coefficient::{Coefficient, Reading};
pub(crate) use transport::{
    MIN_PAIRS, Taken, TransportCurve, error_at_lag, error_of_sum, joined_at,
};
