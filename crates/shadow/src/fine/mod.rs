//! The fine step, in the light's own space.
//!
//! [`Occluders`] finds what may block a face by its place in light space; what is found is measured against the face by
//! exact signs ([`polygon_blocker`], [`analytic_blocker`]); [`flat`] and [`patch`] divide the face and [`classify`]
//! proves its cells.

mod analytic_blocker;
mod borders;
mod classify;
mod clearance;
pub(crate) mod crowd;
mod field;
pub(crate) mod flat;
mod instance_tree;
pub(crate) mod lattice;
mod light_frame;
mod light_values;
pub(crate) mod occluders;
mod outline;
mod packed_tree;
mod passing;
pub(crate) mod patch;
mod pattern;
mod pile;
mod polygon_blocker;
pub(crate) mod raster;
mod receiver;
pub(crate) mod scan;
mod self_shadow;
mod sheet;
pub(crate) mod tally;

pub(crate) use classify::{Blockers, Entry};
pub(crate) use clearance::Clearance;
pub(crate) use instance_tree::tree_of;
pub(crate) use occluders::{Candidates, Occluders};
pub(crate) use polygon_blocker::FacetId;
pub(crate) use raster::{GiveUp, edge_table::EdgeTable};
pub(crate) use receiver::Receiver;
