//! Numbers of calls, and which of them fails.

use std::sync::atomic::{AtomicU64, Ordering};

use libc::c_int;

use crate::settings::{Fault, settings};

/// Kind of a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// It needs space: bytes, a new file, a new folder.
    NeedsSpace,
    /// It needs none.
    Other,
}

/// What becomes of a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// It is made, and has this number.
    Made(u64),
    /// It writes half of its bytes, and has this number.
    Short(u64),
    /// It fails.
    Failed,
}

/// Counts a call that is about to be made, and returns what becomes of it. Sets `errno` where it
/// fails. Does not return if the process is to be killed.
pub fn fate(kind: Kind) -> Fate {
    static CALLS: AtomicU64 = AtomicU64::new(0);
    let number = CALLS.fetch_add(1, Ordering::SeqCst) + 1;
    let Some(settings) = settings() else {
        return Fate::Made(number);
    };
    let is_chosen = number == settings.call;
    let is_later = settings.call > 0 && number > settings.call;
    match settings.fault {
        Fault::Io if is_chosen => failed(libc::EIO),
        Fault::NoSpace if is_chosen || is_later && kind == Kind::NeedsSpace => failed(libc::ENOSPC),
        Fault::Interrupted if is_chosen => failed(libc::EINTR),
        Fault::Short if is_chosen => Fate::Short(number),
        Fault::Kill if is_chosen => {
            // SAFETY: these calls take numbers only.
            unsafe {
                let process = libc::syscall(libc::SYS_getpid);
                libc::syscall(libc::SYS_kill, process, libc::SIGKILL);
                loop {
                    libc::syscall(libc::SYS_sched_yield);
                }
            }
        }
        _ => Fate::Made(number),
    }
}

/// Sets `errno` of this thread.
pub fn failed(error: c_int) -> Fate {
    // SAFETY: the C library returns the place of the number for this thread.
    unsafe { *libc::__errno_location() = error };
    Fate::Failed
}
