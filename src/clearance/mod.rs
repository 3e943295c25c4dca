//! How close the arms of a line come to each other.
//!
//! Nothing in the model keeps arms apart: strategies share out items, not space. This
//! module measures. An arm is the segment from its base to its tool point (`docs/model.md`,
//! arms that come close), without any thickness.
//!
//! | file | what it is |
//! |---|---|
//! | `segment.rs` | the distance of two segments |
//! | `motion.rs` | where each tool point is over time, and the smallest distance in a run |
//! | `polygon.rs` | convex polygons: hull, intersection, area, distance |
//! | `region.rs` | where an arm can ever be, and which of these regions overlap |

mod motion;
mod polygon;
mod region;
mod segment;

pub use motion::{Clearance, TOLERANCE, smallest};
pub use region::{Apart, MARGIN, Overlap, Shared, apart};
