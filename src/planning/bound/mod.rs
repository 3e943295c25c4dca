//! A certified bound for every strategy, including those that wait or know the future.
//!
//! Time is divided into slots. Each robot's day becomes a network (`network`) in which every
//! schedule that the model allows is a path. A price for each item (`dual`) replaces the
//! condition that an item can be picked only once. Good prices are found step by step
//! (`ascent`), but *any* prices give a valid bound, which is why it is certified. The same
//! passes bound what can be earned by each moment, and from that the end of a run and its rate
//! (`profile`). `search` leads the steps with slots of one length, `solve` from longer slots to shorter
//! ones. The prices also give a good schedule (`schedule`), which shows how tight the
//! bound is. `docs/bound.md` has the mathematics and the proof.

mod ascent;
mod dual;
mod network;
mod options;
mod profile;
mod schedule;
mod search;
mod solve;

pub use options::{BoundObjective, BoundOptions};
pub use solve::{Bound, BoundStop, certified_percent, upper_bound};
