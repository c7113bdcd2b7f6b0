//! Tests of the experiments: one program.

mod trade;
