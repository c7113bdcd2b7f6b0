//! Tests of the laboratory in a browser: one program.

mod browser;
mod laboratory_of_page;
mod page;
mod protocol;
mod saved_run;
