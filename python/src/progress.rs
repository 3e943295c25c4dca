//! The progress of long work, told to a Python callable from the thread that waits for the work.

use pickline::optimize::Progress;
use pyo3::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// How far a stage of the work is.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Stage {
    done: u64,
    total: u64,
    what: String,
}

/// Keeps the progress for who asks for it: threads of the work never wait for Python.
#[derive(Default)]
pub(crate) struct Watched(Mutex<Stage>);

impl Watched {
    fn stage(&self) -> MutexGuard<'_, Stage> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Calls `watcher` with how far the work is, unless that is what it was `told` last. Returns what it
    /// raises.
    pub(crate) fn tell(
        &self,
        watcher: &Bound<'_, PyAny>,
        told: &mut Option<Stage>,
    ) -> Option<PyErr> {
        let stage = self.stage().clone();
        if stage.what.is_empty() || told.as_ref() == Some(&stage) {
            return None;
        }
        let called = watcher.call1((stage.done, stage.total, &stage.what));
        *told = Some(stage);
        called.err()
    }
}

impl Progress for Watched {
    fn begin(&self, stage: &str, total: u64, unit: &str) {
        *self.stage() = Stage {
            done: 0,
            total,
            what: format!("{stage} [{unit}]"),
        };
    }

    fn advance(&self, steps: u64) {
        self.stage().done += steps;
    }

    fn doing(&self, _: &str) {}

    fn incumbent(&self, _: &str) {}

    fn end(&self) {}
}
