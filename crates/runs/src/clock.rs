//! Clocks of the machine and of the processor.
//!
//! WebAssembly without a system has neither, and [`std::time::Instant`] panics there: the program
//! that embeds the module sets one clock for all with `set_source`.

#[cfg(not(target_arch = "wasm32"))]
pub use {
    cpu_time::{ProcessTime, ThreadTime},
    std::time::Instant,
};

#[cfg(target_arch = "wasm32")]
pub use embedded::{Instant, Instant as ProcessTime, Instant as ThreadTime, set_source};

/// A clock from outside.
#[cfg(target_arch = "wasm32")]
mod embedded {
    use std::{
        ops::{Add, Sub},
        sync::OnceLock,
        time::Duration,
    };

    static SOURCE: OnceLock<fn() -> f64> = OnceLock::new();

    /// Sets the source of the time, in milliseconds since any moment. Only the first call has an
    /// effect. Without a source the time is always 0.
    pub fn set_source(source: fn() -> f64) {
        SOURCE.get_or_init(|| source);
    }

    /// A moment of the clock.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub struct Instant(Duration);

    impl Instant {
        /// The present.
        pub fn now() -> Self {
            let milliseconds = SOURCE.get().map_or(0.0, |source| source());
            Self(Duration::try_from_secs_f64(1e-3 * milliseconds).unwrap_or_default())
        }

        /// The duration since this moment; 0 if it is in the future.
        pub fn elapsed(&self) -> Duration {
            Self::now().duration_since(*self)
        }

        /// The duration since an earlier moment; 0 if that is later.
        pub fn duration_since(&self, earlier: Self) -> Duration {
            self.0.saturating_sub(earlier.0)
        }

        /// The duration since an earlier moment; 0 if that is later.
        pub fn saturating_duration_since(&self, earlier: Self) -> Duration {
            self.duration_since(earlier)
        }
    }

    impl Add<Duration> for Instant {
        type Output = Self;

        fn add(self, duration: Duration) -> Self {
            Self(self.0 + duration)
        }
    }

    impl Sub for Instant {
        type Output = Duration;

        fn sub(self, earlier: Self) -> Duration {
            self.duration_since(earlier)
        }
    }
}
