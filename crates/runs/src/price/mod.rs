//! The price of a method: what it saves and what it gets wrong, from short replays from common
//! states, exactly and with the method.

mod course;
mod growth;
mod of_run;
mod replay;
mod setting;
mod timing;

pub use self::{
    course::{Course, CourseState, Reached, build, contacts, mean_time},
    growth::growth,
    of_run::{GROWTH, MAX_REPLAY, PRICE, Price, of_run},
    replay::{ReplayLog, ReplayTally, ReplayedContact, TOLERANCE, add, interval},
    setting::Setting,
    timing::{TimeRatio, TimedRun, TimingLimits, Turn, time},
};
