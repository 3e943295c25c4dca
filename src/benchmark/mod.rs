//! The public benchmark: instances with the best solutions that are known of them and with certified bounds, and
//! strategies and programs that are judged on them (`docs/benchmark.md`).
//!
//! | file | what it is |
//! |---|---|
//! | `manifest.rs` | the list of instances: what is known of each |
//! | `instance.rs` | an instance, and which of them are chosen |
//! | `judge.rs` | whose picks count, by the independent checker |
//! | `entrant.rs` | who takes part |
//! | `timed.rs` | the time that a strategy takes |
//! | `program.rs` | an outside program |
//! | `study.rs` | every entrant on every instance |
//! | `standing.rs` | how each entrant did on all of them |
//! | `keep.rs` | better solutions and tighter bounds, into the folder |

mod entrant;
mod instance;
mod judge;
mod keep;
mod manifest;
mod program;
mod standing;
mod timed;
mod study;

pub use entrant::{Entrant, Foresight};
pub use instance::{Instance, load_instances};
pub use judge::{Attempts, Solution, judge, picks_csv};
pub use keep::{Improved, check_keep, keep};
pub use manifest::{FoundBound, Known, MANIFEST};
pub use program::OutsideProgram;
pub use standing::{Standing, standings};
pub use study::{BenchmarkOptions, BenchmarkResult, BenchmarkStudy, Entry};
