//! A certified bound: what no strategy can do better, waiting and clairvoyance
//! included.
//!
//! Time is cut into slots; each robot's day becomes a network (`network`) in which every
//! schedule that the model allows is a path. That an item can be picked only once is
//! left to a price for each item (`dual`), good prices are found step by step (`ascent`)
//! and *any* prices give a true bound, which is what makes it certified. The same passes
//! bound what can be earned by each moment, and from that the end of a run and its rate
//! (`profile`). The prices also make a good schedule (`schedule`), so that one sees how
//! far the bound can be off. `docs/bound.md` has the mathematics and the proof.

mod ascent;
mod dual;
mod network;
mod options;
mod profile;
mod schedule;
mod solve;

pub use options::{Objective, Options};
pub use solve::{Bound, StopReason, certified_percent, upper_bound};
