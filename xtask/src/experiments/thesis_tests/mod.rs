//! The two performance tests of Montanari (2017), section 2.3, repeated: `experiment spheres` and
//! `experiment pair`.

mod fits;
mod options;
mod pair;
mod report;
mod spheres;
mod timing;

pub use options::Options;
pub use pair::run as pair;
pub use spheres::run as spheres;
