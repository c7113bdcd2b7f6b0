//! Paths of open files and of arguments, as absolute paths.

use std::{
    ffi::CStr,
    os::unix::ffi::OsStrExt as _,
    path::{Component, Path, PathBuf},
};

use libc::{c_char, c_int};

use crate::settings::settings;

/// Longest path that is recognised (bytes).
const MAX_PATH: usize = 4096;

/// The present path of an open file, where it lies below the watched folder.
pub fn watched_file(descriptor: c_int) -> Option<PathBuf> {
    let link = format!("/proc/self/fd/{descriptor}\0");
    let mut path = [0u8; MAX_PATH];
    // SAFETY: the link ends with a zero byte, and the buffer has the length that is passed.
    let length = unsafe {
        libc::syscall(
            libc::SYS_readlinkat,
            libc::AT_FDCWD,
            link.as_ptr().cast::<c_char>(),
            path.as_mut_ptr(),
            MAX_PATH,
        )
    };
    let path = path.get(..usize::try_from(length).ok()?)?;
    below_root(Path::new(std::ffi::OsStr::from_bytes(path)))
}

/// A path in an argument as an absolute path without `.` and `..`, where it lies below the watched
/// folder.
///
/// # Safety
/// `path` is a string that ends with a zero byte.
pub unsafe fn watched_path(path: *const c_char) -> Option<PathBuf> {
    // SAFETY: the caller passes a string that ends with a zero byte.
    let path = Path::new(std::ffi::OsStr::from_bytes(
        unsafe { CStr::from_ptr(path) }.to_bytes(),
    ));
    let path = if path.is_absolute() {
        path.to_owned()
    } else {
        std::env::current_dir().ok()?.join(path)
    };
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(plain.pop()),
            Component::CurDir => {}
            part => plain.push(part),
        }
    }
    below_root(&plain)
}

fn below_root(path: &Path) -> Option<PathBuf> {
    let root = &settings()?.root;
    path.starts_with(std::ffi::OsStr::from_bytes(root))
        .then(|| path.to_owned())
}
