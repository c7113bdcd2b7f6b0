//! Tests of the command `carom`: one program.

mod brownian;
mod commands;
mod console;
mod folders;
mod live;
mod measure_from;
mod page_layout;
mod refused;
mod stages;
mod sweep;
mod trade;
