//! How a scene is placed: from its entries to the bodies at time 0.

pub(crate) mod body_builder;
pub(crate) mod bonds;
pub(crate) mod chains;
pub(crate) mod contents;
pub(crate) mod drawn_molecules;
pub(crate) mod expected_bodies;
pub(crate) mod fitted_box;
pub(crate) mod fixed_gas;
pub(crate) mod pistons;
pub(crate) mod place;
pub(crate) mod placement;
pub(crate) mod pockets;
pub(crate) mod selection;
pub(crate) mod shape_template;
pub(crate) mod single_bodies;
pub(crate) mod sites;
pub(crate) mod snapshot;
pub(crate) mod species;
pub(crate) mod start_from;
pub(crate) mod velocities;
pub(crate) mod wall_motions;
pub(crate) mod wells;
