//! How close the arms of a line come to each other.
//!
//! The model does not keep arms apart: strategies divide the items, not the space. This module only
//! measures. An arm is the segment from its base to its tool point (`docs/model.md`, arms that come
//! close), without thickness.
//!
//! | file | content |
//! |---|---|
//! | `segment.rs` | the distance between two segments |
//! | `motion.rs` | the position of each tool point over time, and the smallest distance in a run |
//! | `polygon.rs` | convex polygons: hull, intersection, area, distance |
//! | `region.rs` | the region that an arm can occupy, and which of these regions overlap |

mod motion;
mod polygon;
mod region;
mod segment;

pub use motion::{Clearance, TOLERANCE, smallest};
pub use region::{Apart, MARGIN, Overlap, Shared, apart};
