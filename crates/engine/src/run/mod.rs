//! What happens next: the simulation, its loop over events, windows of tiles, and checkpoints.

pub(crate) mod build;
pub(crate) mod checkpoint;
pub(crate) mod epoch_loop;
pub(crate) mod growth;
pub(crate) mod invariants;
pub(crate) mod observer;
pub(crate) mod sampling;
pub(crate) mod saved_bonds;
pub(crate) mod saved_elasticity;
pub(crate) mod saved_reactions;
pub(crate) mod saved_wells;
pub(crate) mod simulation;
pub(crate) mod window_loop;
