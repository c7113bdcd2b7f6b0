//! What happens next: the simulation, its loop over events, windows of tiles, and checkpoints.

pub(crate) mod checkpoint;
pub(crate) mod epoch_loop;
pub(crate) mod max_time;
pub(crate) mod observer;
pub(crate) mod sampling;
pub mod scheduler;
pub(crate) mod simulation;
pub(crate) mod tiling;
pub(crate) mod window;
pub(crate) mod window_loop;
