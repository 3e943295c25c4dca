//! What long work is given from outside: a stop flag and somewhere to report progress.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Is told how far long work has come.
pub trait Progress: Sync {
    /// A stage of `total` steps begins; `unit` is what they are called.
    fn begin(&self, stage: &str, total: u64, unit: &str);
    /// So many more steps are done.
    fn advance(&self, steps: u64);
    /// What is being done within a step that takes long.
    fn doing(&self, text: &str);
    /// The best found so far.
    fn incumbent(&self, text: &str);
    /// The stage is over.
    fn end(&self);
}

/// Says nothing.
#[derive(Debug, Clone, Copy)]
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _: &str, _: u64, _: &str) {}
    fn advance(&self, _: u64) {}
    fn doing(&self, _: &str) {}
    fn incumbent(&self, _: &str) {}
    fn end(&self) {}
}

/// Says when work should end soon with what it has.
pub trait Stop: Sync {
    /// Whether it should.
    fn is_set(&self) -> bool;
}

impl Stop for AtomicBool {
    fn is_set(&self) -> bool {
        self.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
impl Environment<'static> {
    /// Work that nobody stops or watches.
    pub(super) const QUIET: Self = {
        static GO_ON: AtomicBool = AtomicBool::new(false);
        Self {
            stop: &GO_ON,
            progress: &Silent,
        }
    };
}

/// Another stop signal, or a time that has come.
pub(super) struct Deadline<'a> {
    pub other: &'a dyn Stop,
    pub at: Option<Instant>,
}

impl Deadline<'_> {
    /// Whether the time has come.
    pub fn passed(&self) -> bool {
        self.at.is_some_and(|at| Instant::now() >= at)
    }
}

impl Stop for Deadline<'_> {
    fn is_set(&self) -> bool {
        self.other.is_set() || self.passed()
    }
}

/// Stop signal and progress sink, passed in and never global.
#[derive(Clone, Copy)]
pub struct Environment<'a> {
    /// Set from outside to make the work end soon with what it has.
    pub stop: &'a dyn Stop,
    /// Where progress goes.
    pub progress: &'a dyn Progress,
}

impl Environment<'_> {
    /// Whether the work was asked to end.
    pub fn stopped(&self) -> bool {
        self.stop.is_set()
    }
}
