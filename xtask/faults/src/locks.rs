//! File locks that are refused, or given to everyone, as on file systems without locks.

use libc::c_int;

use crate::{
    calls::failed,
    settings::{Locks, settings},
};

/// Replaces `flock`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flock(descriptor: c_int, operation: c_int) -> c_int {
    match settings().map_or(Locks::Real, |settings| settings.locks) {
        Locks::Granted => 0,
        Locks::Fail(error) => {
            failed(error);
            -1
        }
        // SAFETY: the call takes numbers only.
        Locks::Real => unsafe { libc::syscall(libc::SYS_flock, descriptor, operation) as c_int },
    }
}
