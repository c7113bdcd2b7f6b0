//! Tests of the experiments: one program.

mod billiard;
mod trade;
