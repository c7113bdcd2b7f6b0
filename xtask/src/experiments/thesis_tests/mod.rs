//! How do the processor times of the two performance tests of Montanari (2017), section 2.3, grow
//! with the size of the system?
//!
//! `cargo xtask experiment spheres` and `cargo xtask experiment pair`: the tests repeated with the
//! engine of the thesis and with the default one.

mod fits;
mod options;
mod pair;
mod report;
mod results;
mod run;
mod spheres;
mod timing;

pub use options::ThesisTestsOptions;
pub use pair::run as pair;
pub use spheres::run as spheres;
