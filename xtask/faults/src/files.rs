//! The functions of the C library by which files are opened, written, flushed, renamed, truncated
//! and removed.

use std::{
    os::unix::ffi::OsStrExt as _,
    path::Path,
    sync::atomic::{AtomicU64, Ordering},
};

use libc::{c_char, c_int, c_long, c_void, iovec, mode_t, off_t, size_t, ssize_t};

use crate::{
    calls::{Fate, Kind, fate},
    descriptor::{watched_file, watched_path},
    journal::{note, note_path},
    settings::settings,
};

/// Result of a failed call.
const FAILED: c_int = -1;

// The variable argument of `open` is passed like a fixed one on all Linux systems of carom.

/// Replaces `open`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn open(path: *const c_char, flags: c_int, mode: mode_t) -> c_int {
    // SAFETY: the contract of `open`.
    unsafe { open_at(libc::AT_FDCWD, path, flags, mode) }
}

/// Replaces `open64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn open64(path: *const c_char, flags: c_int, mode: mode_t) -> c_int {
    // SAFETY: the contract of `open64`.
    unsafe { open_at(libc::AT_FDCWD, path, flags, mode) }
}

/// Opens a file, and counts it if it is opened for writing.
unsafe fn open_at(folder: c_int, path: *const c_char, flags: c_int, mode: mode_t) -> c_int {
    let is_written = flags & (libc::O_WRONLY | libc::O_RDWR | libc::O_CREAT) != 0;
    let watched = if is_written {
        // SAFETY: the caller passes a string.
        unsafe { watched_path(path) }
    } else {
        None
    };
    let number = match watched.as_ref().map(|_| fate(Kind::NeedsSpace)) {
        Some(Fate::Failed) => return FAILED,
        Some(Fate::Made(number) | Fate::Short(number)) => number,
        None => 0,
    };
    let is_new = watched.as_ref().is_some_and(|path| !exists(path));
    // SAFETY: the arguments of the caller.
    let opened = unsafe { libc::syscall(libc::SYS_openat, folder, path, flags, mode) } as c_int;
    if let Some(path) = watched
        && opened >= 0
        && (is_new || flags & libc::O_TRUNC != 0)
    {
        note_path(number, "open", &path);
    }
    opened
}

fn exists(path: &Path) -> bool {
    let mut name = path.as_os_str().as_bytes().to_vec();
    name.push(0);
    // SAFETY: the name ends with a zero byte.
    let found = unsafe {
        libc::syscall(
            libc::SYS_faccessat,
            libc::AT_FDCWD,
            name.as_ptr().cast::<c_char>(),
            libc::F_OK,
        )
    };
    found == 0
}

/// Counts a call on an open file, makes it, and records it. `make` gets true for a short write.
fn on_file(descriptor: c_int, kind: Kind, name: &str, make: impl FnOnce(bool) -> c_long) -> c_long {
    let Some(path) = watched_file(descriptor) else {
        return make(false);
    };
    let (number, is_short) = match fate(kind) {
        Fate::Failed => return c_long::from(FAILED),
        Fate::Made(number) => (number, false),
        Fate::Short(number) => (number, true),
    };
    let done = make(is_short);
    if done >= 0 {
        note_path(number, name, &path);
    }
    done
}

fn shortened(count: size_t, is_short: bool) -> size_t {
    if is_short { count.div_ceil(2) } else { count }
}

/// Replaces `write`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn write(descriptor: c_int, bytes: *const c_void, count: size_t) -> ssize_t {
    // SAFETY: the arguments of the caller, with at most its count.
    let make = |is_short| unsafe {
        libc::syscall(
            libc::SYS_write,
            descriptor,
            bytes,
            shortened(count, is_short),
        )
    };
    on_file(descriptor, Kind::NeedsSpace, "write", make) as ssize_t
}

/// Replaces `writev`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn writev(descriptor: c_int, parts: *const iovec, count: c_int) -> ssize_t {
    // SAFETY: the arguments of the caller, with at most its count.
    let make = |is_short| unsafe {
        libc::syscall(
            libc::SYS_writev,
            descriptor,
            parts,
            if is_short { count.min(1) } else { count },
        )
    };
    on_file(descriptor, Kind::NeedsSpace, "write", make) as ssize_t
}

/// Replaces `copy_file_range`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn copy_file_range(
    from: c_int,
    from_offset: *mut off_t,
    to: c_int,
    to_offset: *mut off_t,
    count: size_t,
    flags: u32,
) -> ssize_t {
    // SAFETY: the arguments of the caller, with at most its count.
    let make = |is_short| unsafe {
        let count = shortened(count, is_short);
        libc::syscall(
            libc::SYS_copy_file_range,
            from,
            from_offset,
            to,
            to_offset,
            count,
            flags,
        )
    };
    on_file(to, Kind::NeedsSpace, "write", make) as ssize_t
}

/// Replaces `fsync`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fsync(descriptor: c_int) -> c_int {
    flushed(descriptor, libc::SYS_fsync)
}

/// Replaces `fdatasync`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fdatasync(descriptor: c_int) -> c_int {
    flushed(descriptor, libc::SYS_fdatasync)
}

/// Counts a flush. The flush itself is left out: the system does not lose power.
fn flushed(descriptor: c_int, call: c_long) -> c_int {
    let Some(path) = watched_file(descriptor) else {
        // SAFETY: the call takes numbers only.
        return unsafe { libc::syscall(call, descriptor) as c_int };
    };
    let number = match fate(Kind::Other) {
        Fate::Failed => return FAILED,
        Fate::Made(number) | Fate::Short(number) => number,
    };
    // SAFETY: zero bytes are a valid value of this structure of numbers, which the call fills.
    let status = unsafe {
        let mut status: libc::stat = std::mem::zeroed();
        libc::fstat(descriptor, &raw mut status);
        status
    };
    let path = path.as_os_str().as_bytes();
    if status.st_mode & libc::S_IFMT == libc::S_IFDIR {
        note(number, "syncdir", &[path]);
    } else {
        note(
            number,
            "sync",
            &[path, status.st_size.to_string().as_bytes()],
        );
    }
    0
}

/// Replaces `ftruncate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ftruncate(descriptor: c_int, length: off_t) -> c_int {
    truncated(descriptor, length)
}

/// Replaces `ftruncate64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ftruncate64(descriptor: c_int, length: off_t) -> c_int {
    truncated(descriptor, length)
}

fn truncated(descriptor: c_int, length: off_t) -> c_int {
    // SAFETY: the call takes numbers only.
    let make = || unsafe { libc::syscall(libc::SYS_ftruncate, descriptor, length) as c_int };
    let Some(path) = watched_file(descriptor) else {
        return make();
    };
    let number = match fate(Kind::Other) {
        Fate::Failed => return FAILED,
        Fate::Made(number) | Fate::Short(number) => number,
    };
    let done = make();
    if done == 0 {
        note(
            number,
            "truncate",
            &[path.as_os_str().as_bytes(), length.to_string().as_bytes()],
        );
    }
    done
}

/// Replaces `rename`. What is replaced is kept as a hard link.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rename(from: *const c_char, to: *const c_char) -> c_int {
    // SAFETY: the arguments of the caller.
    let make = || unsafe {
        libc::syscall(
            libc::SYS_renameat2,
            libc::AT_FDCWD,
            from,
            libc::AT_FDCWD,
            to,
            0,
        ) as c_int
    };
    // SAFETY: the caller passes strings.
    let watched = unsafe { (watched_path(from), watched_path(to)) };
    let (Some(from_path), Some(to_path)) = watched else {
        return make();
    };
    let number = match fate(Kind::Other) {
        Fate::Failed => return FAILED,
        Fate::Made(number) | Fate::Short(number) => number,
    };
    // SAFETY: the caller passes a string.
    let link = unsafe { keep_replaced(to) };
    let done = make();
    if done == 0 {
        let [from, to] = [&from_path, &to_path].map(|path| path.as_os_str().as_bytes());
        note(number, "rename", &[from, to, &link]);
    }
    done
}

/// Links a file that is about to be replaced, and returns the path of the link; nothing if there is
/// no such file, or no folder for it.
unsafe fn keep_replaced(path: *const c_char) -> Vec<u8> {
    static LINKS: AtomicU64 = AtomicU64::new(0);
    let Some(folder) = settings().and_then(|settings| settings.replaced.as_ref()) else {
        return vec![];
    };
    let number = LINKS.fetch_add(1, Ordering::SeqCst);
    let mut link = folder.clone();
    // SAFETY: the call takes no argument.
    let process = unsafe { libc::syscall(libc::SYS_getpid) };
    link.extend_from_slice(format!("/{process}-{number}\0").as_bytes());
    // SAFETY: both paths end with a zero byte.
    let done = unsafe {
        let link = link.as_ptr().cast::<c_char>();
        libc::syscall(
            libc::SYS_linkat,
            libc::AT_FDCWD,
            path,
            libc::AT_FDCWD,
            link,
            0,
        )
    };
    link.pop();
    if done == 0 { link } else { vec![] }
}

/// Replaces `mkdir`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mkdir(path: *const c_char, mode: mode_t) -> c_int {
    // SAFETY: the arguments of the caller.
    let make = || unsafe { libc::syscall(libc::SYS_mkdirat, libc::AT_FDCWD, path, mode) as c_int };
    // SAFETY: the caller passes a string.
    let Some(watched) = (unsafe { watched_path(path) }) else {
        return make();
    };
    let number = match fate(Kind::NeedsSpace) {
        Fate::Failed => return FAILED,
        Fate::Made(number) | Fate::Short(number) => number,
    };
    let done = make();
    if done == 0 {
        note_path(number, "mkdir", &watched);
    }
    done
}

/// Replaces `unlink`, which is recorded and never fails by a fault.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn unlink(path: *const c_char) -> c_int {
    // SAFETY: the arguments of the caller.
    let done = unsafe { libc::syscall(libc::SYS_unlinkat, libc::AT_FDCWD, path, 0) as c_int };
    // SAFETY: the caller passes a string.
    if let (0, Some(path)) = (done, unsafe { watched_path(path) }) {
        note_path(0, "remove", &path);
    }
    done
}
