//! Are the standard errors of measures as large as the scatter of replicas?
//!
//! `cargo xtask experiment errors`: many short runs of one gas that differ in their random numbers.
//! The mean squared error, as each run estimates it from its blocks, over the variance of the mean
//! among the runs is 1 on average; with a probability of 99 % it lies in a band given by Fisher's
//! F.

mod report;
mod results;
mod run;

pub use run::run;
