//! The laboratory of `carom live` as a WebAssembly module, for a worker of a browser.
//!
//! Internal: a part of the program `carom`. Its public items serve the other crates of it, and
//! change without notice.
//!
//! The module has no imports but a clock and a channel for the message of a panic, and speaks the
//! messages of `carom live` (`crates/live/src/protocol.rs`). The worker is
//! `crates/web/src/worker.js`.
//!
//! | function | what it does |
//! | --- | --- |
//! | `carom_start` | begins a laboratory; the first message waits |
//! | `carom_room` | returns the address of a buffer for a request of so many bytes |
//! | `carom_receive` | executes the request in the buffer |
//! | `carom_advance` | runs a piece; returns the time until the next is due (milliseconds) |
//! | `carom_take` | takes a message: 0 if none waits, 1 a text, 2 bytes |
//! | `carom_message`, `carom_length` | address and length of that message |
//! | `carom_digest` | runs the scene in the buffer; the message is a digest of its states |
//!
//! On other targets the crate has the functions of Rust alone.

mod digest;
#[cfg(target_arch = "wasm32")]
mod exports;

pub use digest::digest;
