//! A library for `LD_PRELOAD` that makes one chosen call of the file system fail, ends the process
//! at a chosen call, withholds file locks, and records what a loss of power would take away.
//!
//! It replaces functions of the C library for one process and its children. Calls count if they
//! change files below the folder of [`settings::ROOT`]; the first has number 1. The variables of
//! the environment that configure it are in [`settings`], the lines that it records in [`journal`].
//!
//! # Unsafe code
//!
//! The functions have the names, types and contracts of those that they replace, and pass their
//! arguments on to the system call unchanged, except that a short write passes a smaller count.
//! They call no function of the C library that is replaced here, so they never call themselves.
#![cfg(target_os = "linux")]
#![allow(
    unsafe_code,
    reason = "a library that replaces functions of the C library"
)]
#![allow(
    clippy::missing_safety_doc,
    reason = "the contract of each function is that of the function of the C library that it replaces"
)]

pub mod calls;
pub mod descriptor;
pub mod files;
pub mod journal;
pub mod locks;
pub mod settings;
