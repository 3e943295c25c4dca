//! Decides which robot picks which item from a moving belt.
//!
//! # The problem
//!
//! A belt `0 <= x <= L`, `|y| <= W/2` moves along `+x` at `v` [m/s]. Robot `i` has
//! its base at `b`, reach `R`, an end effector of speed `u > v` and a bin at `g` that is
//! also its resting position. Leaving the bin at time `t` for an item that is then at
//! `p`, it meets the item after the positive root `tau` of
//!
//! ```text
//! | p + (v tau, 0) - g | = u tau
//! ```
//!
//! and is free again after `P = 2 tau + grasp time + release time`. It may leave only while the
//! departure time lies in the item's window `[open, close]`, that is, while the meeting point is
//! within reach and on the belt. Whenever a robot is free and has candidates, a *strategy* chooses
//! the item that it takes. A run is judged by its picking rate `60 k / T`: `k` of `n` items are
//! picked, and the run ends at `T`.
//!
//! The *combinatorial strategy* of Jermann et al. gives each robot one dispatching rule (FIFO, SPT,
//! LPT, SD, LD, PP) and searches for the assignment that performs best over many patterns.
//! `docs/model.md` in the repository gives the exact definitions.
//!
//! # Example
//!
//! ```
//! use pickline::{Scene, pattern::grid, simulate_rules, station};
//!
//! let station = station::built_in("paper")?.station(Some(2))?;
//! let pattern = grid(station.belt().width, 0.15, 50)?;
//! let scene = Scene::new(&station, &pattern)?;
//! let outcome = simulate_rules(&scene, &"SPT,FIFO".parse()?)?;
//! assert_eq!(outcome.figures.picked, 44);
//! pickline::checker::check(&station, &pattern, &outcome)?;
//! # Ok::<(), pickline::Error>(())
//! ```
//!
//! # Features
//!
//! - `onnx` (default): trained policies as strategies, and training them: writes ONNX files and
//!   runs them with tract, which is half of the build. Without it `policy` still describes what a
//!   policy was trained on, and the strategy `onnx` is refused with an explanation.
//!
//! # Where to look
//!
//! What most programs need is at the root of the crate:
//!
//! - to run one strategy: a [`Station`], a [`Pattern`], a [`Scene`] that puts one on the other, a
//!   [`Strategy`] or a [`RuleAssignment`] to run with [`simulate`] or [`simulate_rules`];
//! - to run a whole study: [`compare`], [`sweep`] and [`optimize`] with their options, a
//!   [`StrategySpec`] for every strategy to compare, and the [`Environment`], which stops long work
//!   and receives its progress;
//! - the [`Error`] of all of it.
//!
//! The modules hold what these are made of. Public is what a program that reads stations and
//! patterns, writes a strategy, judges one or trains one needs, and what the other crates of the
//! workspace share with the library: `files`, `names` and `plausible`. [`nn`] and [`rl::ppo`] are
//! public for training loops other than [`rl::Trainer`]: networks with their parameters and their
//! optimiser, the samples of a rollout and the clipped loss. How the rest is done (search operators,
//! relaxations, matrix products, parts of the event loop) is private.
//!
//! Options and results are `#[non_exhaustive]`: options are made from a default by their methods
//! `with_...`, as in `Grasp::default().with_starts(16)`, and both may get fields in any release.
//! The plain data of the model can be written out: [`Item`], [`Belt`], [`Robot`],
//! [`Outcome`] and what is in it, and what a strategy sees and answers
//! ([`decision`]). They get no field without a new major version.
//!
//! A module may use the modules above it in this list, never those below it
//! (`docs/architecture.md`).

pub mod error;
mod setters;
pub mod kinematics;
pub mod plausible;
pub mod names;
pub mod files;
mod toml_file;
mod csv_file;
mod csv_columns;
pub mod station;
pub mod pattern;
pub mod stats;
pub mod fit;
pub mod decision;
pub mod dispatch;
pub mod checker;
pub mod clearance;
pub mod sim;
pub mod throughput;
pub mod purity;
pub mod allocation;
pub mod planning;
pub mod nn;
pub mod policy;
pub mod strategies;
pub mod shards;
pub mod optimize;
pub mod rl;
pub mod experiment;
pub mod study;
pub mod benchmark;

pub use decision::{Outcome, Strategy};
pub use dispatch::RuleAssignment;
pub use error::{Error, ErrorKind, Result};
pub use optimize::Environment;
pub use pattern::{Item, Pattern};
pub use sim::{Scene, simulate, simulate_rules};
pub use station::{Belt, Robot, Station};
pub use strategies::StrategySpec;
pub use study::{CompareOptions, OptimizeOptions, SweepOptions, compare, optimize, sweep};
