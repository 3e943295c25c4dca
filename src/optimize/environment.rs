//! The environment of long work: a stop flag, a receiver of progress reports, and the ledger of its units.

use crate::shards::Ledger;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Receives the progress of long work.
pub trait Progress: Sync {
    /// A stage of `total` steps begins; `unit` is the name of a step.
    fn begin(&self, stage: &str, total: u64, unit: &str);
    /// `steps` more steps are done.
    fn advance(&self, steps: u64);
    /// What is being done within a long step.
    fn doing(&self, text: &str);
    /// The best result so far, in words.
    fn incumbent(&self, text: &str);
    /// The stage that began last is over.
    fn end(&self);
}

/// Ignores all progress.
#[derive(Debug, Clone, Copy)]
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _: &str, _: u64, _: &str) {}
    fn advance(&self, _: u64) {}
    fn doing(&self, _: &str) {}
    fn incumbent(&self, _: &str) {}
    fn end(&self) {}
}

/// Tells when work should end soon with the result it has.
pub trait Stop: Sync {
    /// Whether work should end as soon as it has a result.
    fn is_set(&self) -> bool;
}

impl Stop for AtomicBool {
    fn is_set(&self) -> bool {
        self.load(Ordering::Relaxed)
    }
}

impl Environment<'static> {
    /// The environment of work that nobody stops or watches.
    pub const QUIET: Self = {
        static GO_ON: AtomicBool = AtomicBool::new(false);
        Self {
            stop: &GO_ON,
            progress: &Silent,
            ledger: Ledger::PLAIN,
        }
    };
}

/// Another stop signal, or a point in time.
pub(crate) struct Deadline<'a> {
    pub other: &'a dyn Stop,
    pub at: Option<Instant>,
}

impl Deadline<'_> {
    /// Whether the point in time has passed.
    pub(crate) fn passed(&self) -> bool {
        self.at.is_some_and(|at| Instant::now() >= at)
    }
}

impl Stop for Deadline<'_> {
    fn is_set(&self) -> bool {
        self.other.is_set() || self.passed()
    }
}

/// Stop signal, progress receiver and ledger, passed as arguments and never global. Calls that stop or
/// watch work, but do it all, end with `..Environment::QUIET`.
#[derive(Clone, Copy)]
pub struct Environment<'a> {
    /// Set by the caller to make the work end soon with the result it has.
    pub stop: &'a dyn Stop,
    /// Receives the progress.
    pub progress: &'a dyn Progress,
    /// Knows or records the units of the work, if it is done in shards.
    pub ledger: &'a Ledger,
}

impl Environment<'_> {
    /// Whether the work was asked to stop.
    pub fn stopped(&self) -> bool {
        self.stop.is_set()
    }
}
