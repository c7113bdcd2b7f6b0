//! The record: one line for each call that has succeeded, with fields separated by tabs.
//!
//! | line | meaning |
//! | --- | --- |
//! | number, `open`, path | the file was created or emptied |
//! | number, `write`, path | bytes were written |
//! | number, `truncate`, path, length | the file has this length |
//! | number, `sync`, path, length | the content is on disk up to this length |
//! | number, `syncdir`, path | the entries of the folder are on disk |
//! | number, `rename`, from, to, link | `link` is what `to` was before, or empty |
//! | number, `mkdir`, path | the folder was made |
//! | 0, `remove`, path | the file was removed; these calls have no numbers |

use std::{os::unix::ffi::OsStrExt as _, path::Path, sync::OnceLock};

use libc::{c_int, c_void};

use crate::settings::settings;

/// Lowest descriptor of the record, so that the numbers of other files stay.
const MIN_DESCRIPTOR: c_int = 500;

/// Appends a line.
pub fn note(number: u64, kind: &str, fields: &[&[u8]]) {
    let Some(descriptor) = descriptor() else {
        return;
    };
    let mut line = format!("{number}\t{kind}").into_bytes();
    for field in fields {
        line.push(b'\t');
        line.extend_from_slice(field);
    }
    line.push(b'\n');
    // A record that cannot be written is noticed by its reader.
    // SAFETY: the line has the length that is passed.
    unsafe {
        libc::syscall(
            libc::SYS_write,
            descriptor,
            line.as_ptr().cast::<c_void>(),
            line.len(),
        )
    };
}

/// Appends a line about a file.
pub fn note_path(number: u64, kind: &str, path: &Path) {
    note(number, kind, &[path.as_os_str().as_bytes()]);
}

/// The open file of the record.
fn descriptor() -> Option<c_int> {
    static DESCRIPTOR: OnceLock<Option<c_int>> = OnceLock::new();
    *DESCRIPTOR.get_or_init(|| {
        let path = settings()?.journal.as_ref()?;
        let flags = libc::O_WRONLY | libc::O_CREAT | libc::O_APPEND | libc::O_CLOEXEC;
        // SAFETY: the path ends with a zero byte; the descriptors are those just opened.
        let moved = unsafe {
            let first = libc::syscall(
                libc::SYS_openat,
                libc::AT_FDCWD,
                path.as_ptr(),
                flags,
                0o600,
            );
            let moved = libc::syscall(
                libc::SYS_fcntl,
                first,
                libc::F_DUPFD_CLOEXEC,
                MIN_DESCRIPTOR,
            );
            libc::syscall(libc::SYS_close, first);
            moved
        };
        c_int::try_from(moved).ok().filter(|moved| *moved >= 0)
    })
}
