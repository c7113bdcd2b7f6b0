//! Memory that a WebAssembly module can still take.

use super::AvailableMemory;

/// Size of a page of memory, and of all that 32-bit addresses reach (bytes).
const PAGE: u64 = 1 << 16;
const REACH: u64 = 1 << 32;

/// The memory that 32-bit addresses leave. The host may refuse to give as much.
pub fn available() -> Option<AvailableMemory> {
    let taken = PAGE * core::arch::wasm32::memory_size(0) as u64;
    Some(AvailableMemory {
        bytes: REACH.saturating_sub(taken),
        of: "WebAssembly with 32-bit addresses",
    })
}
