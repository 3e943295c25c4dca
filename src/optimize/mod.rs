//! Finds the best rule for each robot: objectives, the evaluator with common random numbers,
//! exhaustive search and GRASP, the ranking with its ties, validation.

mod beside;
mod environment;
mod evaluator;
mod exact;
pub mod game;
mod grasp;
mod grasp_walk;
mod objective;
mod optimum;
mod partial_scores;
mod ranking;
mod rivals;
mod screening;
mod search;
mod selection;
mod speed_limit;
mod validation;

pub use beside::bound_beside;
pub(crate) use beside::part_bound_beside;
pub(crate) use environment::Deadline;
pub use environment::{Environment, Progress, Silent, Stop};
pub use evaluator::{Evaluation, Evaluator, Score};
pub use exact::Proof;
pub use grasp::{Grasp, GraspOutcome};
pub use objective::{Objective, Risk};
pub use optimum::find_optimum;
pub use ranking::{FRONT_RUNNERS, Ranked, Ranking, TieBreak};
pub use rivals::{Rival, rivals};
pub use search::{Limits, MostRuns, Optimum, Search, SearchKind, StopReason};
pub use selection::{Dropped, FIRST_OBSERVATIONS, Selection, SelectionOptions};
pub use speed_limit::SpeedScan;
pub(crate) use validation::chosen_flow;
pub use validation::{Certificate, Validation, ValidationOptions, validate};
