//! The functions of the module.
#![allow(
    unsafe_code,
    reason = "names that a host calls, and functions that it provides, need attributes that count as unsafe"
)]

use std::{cell::RefCell, panic};

use carom_live::{LaboratoryOfPage, Outgoing};
use carom_runs::clock;

use crate::digest::digest;

#[link(wasm_import_module = "host")]
unsafe extern "C" {
    /// Milliseconds since any moment.
    safe fn now() -> f64;

    /// Shows the message of a panic, which ends the module.
    safe fn panicked(message: *const u8, length: usize);
}

/// The laboratory, and what passes between it and the host.
#[derive(Default)]
struct Module {
    laboratory: Option<LaboratoryOfPage>,
    request: Vec<u8>,
    message: Vec<u8>,
}

thread_local! {
    static MODULE: RefCell<Module> = RefCell::default();
}

fn with<T>(act: impl FnOnce(&mut Module) -> T) -> T {
    MODULE.with_borrow_mut(act)
}

fn prepare() {
    clock::set_source(|| now());
    panic::set_hook(Box::new(|panic| {
        let message = panic.to_string();
        panicked(message.as_ptr(), message.len());
    }));
}

/// Begins a laboratory.
#[unsafe(no_mangle)]
pub extern "C" fn carom_start() {
    prepare();
    with(|module| module.laboratory = LaboratoryOfPage::new());
}

/// The address of a buffer for a request of `length` bytes.
#[unsafe(no_mangle)]
pub extern "C" fn carom_room(length: usize) -> *mut u8 {
    with(|module| {
        module.request.clear();
        module.request.resize(length, 0);
        module.request.as_mut_ptr()
    })
}

/// Executes the request in the buffer.
#[unsafe(no_mangle)]
pub extern "C" fn carom_receive() {
    with(|module| {
        let text = String::from_utf8_lossy(&module.request);
        if let Some(laboratory) = &mut module.laboratory {
            laboratory.receive(&text);
        }
    });
}

/// Runs a piece; returns the time until there is something to do besides requests (milliseconds).
#[unsafe(no_mangle)]
pub extern "C" fn carom_advance() -> f64 {
    with(|module| {
        let laboratory = module.laboratory.as_mut();
        laboratory.map_or(1e3, |laboratory| 1e3 * laboratory.advance().as_secs_f64())
    })
}

/// Takes a message: 0 if none waits, 1 a text, 2 bytes.
#[unsafe(no_mangle)]
pub extern "C" fn carom_take() -> u32 {
    with(|module| {
        let next = module.laboratory.as_ref().and_then(LaboratoryOfPage::next);
        match next {
            None => 0,
            Some(Outgoing::Text(text)) => {
                module.message = text.into_bytes();
                1
            }
            Some(Outgoing::Binary(bytes)) => {
                module.message.clear();
                module.message.extend_from_slice(&bytes);
                2
            }
        }
    })
}

/// The address of the message that was taken last.
#[unsafe(no_mangle)]
pub extern "C" fn carom_message() -> *const u8 {
    with(|module| module.message.as_ptr())
}

/// The length of the message that was taken last (bytes).
#[unsafe(no_mangle)]
pub extern "C" fn carom_length() -> usize {
    with(|module| module.message.len())
}

/// Runs the scene in the buffer to its end; the message is the digest of its states, or the fault
/// of the scene.
#[unsafe(no_mangle)]
pub extern "C" fn carom_digest() {
    prepare();
    with(|module| {
        let text = String::from_utf8_lossy(&module.request);
        let found = digest(&text).unwrap_or_else(|error| format!("error: {error}"));
        module.message = found.into_bytes();
    });
}
