//! What a contact changes: resolution, elasticity, and the limits within which it is exact.

pub(crate) mod contact_geometry;
pub(crate) mod elasticity_table;
pub(crate) mod guard;
pub(crate) mod joint_contact;
pub(crate) mod limits;
pub(crate) mod overlap;
pub(crate) mod philox;
pub(crate) mod reaction_table;
pub(crate) mod resolution;
pub(crate) mod separation;
pub(crate) mod separation_error;
pub(crate) mod simultaneous_contacts;
pub(crate) mod thermal_wall;
pub(crate) mod unresolved;
pub(crate) mod wall_meeting;
