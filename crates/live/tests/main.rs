//! Tests of the laboratory in a browser: one program.

mod browser;
mod page;
mod protocol;
mod saved_run;
