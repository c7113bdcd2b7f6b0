//! The settings of a process, from variables of its environment.

use std::{
    env,
    ffi::{CString, OsStr},
    os::unix::ffi::OsStrExt as _,
    sync::OnceLock,
};

use libc::c_int;

/// Variable: the absolute path of the folder whose files count. Without it nothing is changed.
pub const ROOT: &str = "CAROM_FAULTS_ROOT";
/// Variable: the file to which the record is appended.
pub const JOURNAL: &str = "CAROM_FAULTS_JOURNAL";
/// Variable: an existing folder for what renames replace, as hard links.
pub const REPLACED: &str = "CAROM_FAULTS_REPLACED";
/// Variable: the number of the call at which the fault occurs; 0 or none for no fault.
pub const CALL: &str = "CAROM_FAULTS_CALL";
/// Variable: the fault, see [`Fault`].
pub const FAULT: &str = "CAROM_FAULTS_FAULT";
/// Variable: what becomes of file locks, see [`Locks`].
pub const LOCKS: &str = "CAROM_FAULTS_LOCKS";

/// What happens at the chosen call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// `EIO`: the call fails, later ones succeed.
    Io,
    /// `ENOSPC`: this call fails, and all later ones that need space.
    NoSpace,
    /// `EINTR`: the call fails once, as if a signal had arrived.
    Interrupted,
    /// `SHORT`: half of the bytes are written; other calls than writes succeed.
    Short,
    /// `KILL`: the process is killed before the call.
    Kill,
}

/// What becomes of file locks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Locks {
    /// They are those of the system.
    Real,
    /// `ENOLCK`, `ENOSYS`: the call fails with this error.
    Fail(c_int),
    /// `GRANTED`: each process gets every lock, as on machines that do not share them.
    Granted,
}

/// The settings of a process.
#[derive(Debug)]
pub struct Settings {
    /// Folder whose files count.
    pub root: Vec<u8>,
    /// File of the record.
    pub journal: Option<CString>,
    /// Folder for replaced files.
    pub replaced: Option<Vec<u8>>,
    /// Number of the call with the fault; 0 for none.
    pub call: u64,
    /// The fault.
    pub fault: Fault,
    /// File locks.
    pub locks: Locks,
}

/// The settings of this process; `None` if it has none.
pub fn settings() -> Option<&'static Settings> {
    static SETTINGS: OnceLock<Option<Settings>> = OnceLock::new();
    SETTINGS.get_or_init(read).as_ref()
}

fn read() -> Option<Settings> {
    let bytes = |name: &str| env::var_os(name).map(|value| OsStr::as_bytes(&value).to_vec());
    let text = |name: &str| env::var(name).unwrap_or_default();
    Some(Settings {
        root: bytes(ROOT)?,
        journal: bytes(JOURNAL).and_then(|path| CString::new(path).ok()),
        replaced: bytes(REPLACED),
        call: text(CALL).parse().unwrap_or(0),
        fault: match &*text(FAULT) {
            "ENOSPC" => Fault::NoSpace,
            "EINTR" => Fault::Interrupted,
            "SHORT" => Fault::Short,
            "KILL" => Fault::Kill,
            _ => Fault::Io,
        },
        locks: match &*text(LOCKS) {
            "ENOLCK" => Locks::Fail(libc::ENOLCK),
            "ENOSYS" => Locks::Fail(libc::ENOSYS),
            "GRANTED" => Locks::Granted,
            _ => Locks::Real,
        },
    })
}
