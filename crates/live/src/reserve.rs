//! File descriptors that are kept free, so that a run can be saved while connections hold all
//! others that the system grants.

use std::{
    fs::File,
    io,
    sync::{Mutex, MutexGuard, PoisonError},
};

/// Number of descriptors in reserve: for two runs that are written at one time, each with a file,
/// its folder, and the pipes of a child process. Fewer: with all descriptors taken a run is lost.
/// More: fewer connections where the system grants few descriptors.
const RESERVED: usize = 16;

/// A file that exists on every system and holds a descriptor.
const NOTHING: &str = if cfg!(windows) { "NUL" } else { "/dev/null" };

/// The descriptors, and the number of users that have released them.
#[derive(Debug, Default)]
struct Held {
    files: Vec<File>,
    users: usize,
}

impl Held {
    fn fill(&mut self) -> io::Result<()> {
        while self.files.len() < RESERVED {
            self.files.push(File::open(NOTHING)?);
        }
        Ok(())
    }
}

/// Descriptors in reserve.
#[derive(Debug)]
pub struct Reserve(Mutex<Held>);

impl Reserve {
    /// Takes the descriptors.
    ///
    /// # Errors
    /// The system grants too few.
    pub fn new() -> io::Result<Self> {
        let mut held = Held::default();
        held.fill()?;
        Ok(Self(Mutex::new(held)))
    }

    fn lock(&self) -> MutexGuard<'_, Held> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Frees the descriptors until the returned value is dropped.
    pub fn release(&self) -> Released<'_> {
        let mut held = self.lock();
        held.users += 1;
        held.files.clear();
        drop(held);
        Released(self)
    }

    /// Takes descriptors that are missing; returns whether all are held, false while they are in
    /// use. No connection is accepted before that.
    ///
    /// # Errors
    /// Others have taken them.
    pub fn restore(&self) -> io::Result<bool> {
        let mut held = self.lock();
        if held.users > 0 {
            return Ok(false);
        }
        held.fill().map(|()| true)
    }
}

/// The descriptors of a [`Reserve`] are free.
#[derive(Debug)]
pub struct Released<'a>(&'a Reserve);

impl Drop for Released<'_> {
    fn drop(&mut self) {
        let mut held = self.0.lock();
        held.users -= 1;
        if held.users == 0 {
            // What another connection has taken meanwhile is taken back by `restore`.
            let _ = held.fill();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn descriptors_are_free_until_the_last_user_has_ended() {
        let reserve = Reserve::new().unwrap();
        assert!(reserve.restore().unwrap());
        let first = reserve.release();
        let second = reserve.release();
        assert_eq!(reserve.lock().files.len(), 0);
        drop(first);
        assert!(
            !reserve.restore().unwrap() && reserve.lock().files.is_empty(),
            "the second still writes"
        );
        drop(second);
        assert_eq!(reserve.lock().files.len(), RESERVED);
    }
}
