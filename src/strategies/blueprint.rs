//! A strategy for a known line, which is created again for every run.

use crate::decision::Strategy;
use crate::dispatch::RuleAssignment;
use crate::error::Result;
use crate::planning::Allowance;
use crate::policy::Trained;
use std::fmt;
use std::sync::Arc;

/// The line for which a strategy is created.
pub(crate) struct Setup<'a> {
    /// Number of robots.
    pub robots: usize,
    /// Finds assignments that perform well on the line, best first. Only strategies that need
    /// them call it, because it may run a search.
    pub bases: &'a dyn Fn() -> Result<Vec<RuleAssignment>>,
    /// Budget of a decision of a strategy that plans, unless its options set one.
    pub allowance: Allowance,
}

/// A strategy read once and created again for every run: runs share nothing, so they can run in
/// any order and in parallel.
#[derive(Clone)]
pub struct Blueprint {
    name: String,
    make: Arc<dyn Fn() -> Box<dyn Strategy> + Send + Sync>,
    trained: Option<Arc<Trained>>,
}

impl Blueprint {
    pub(super) fn new(
        name: String,
        make: impl Fn() -> Box<dyn Strategy> + Send + Sync + 'static,
    ) -> Self {
        Self {
            name,
            make: Arc::new(make),
            trained: None,
        }
    }

    /// The same, of a policy that was trained on this.
    #[cfg(feature = "onnx")]
    pub(super) fn trained_on(self, trained: Option<Trained>) -> Self {
        Self {
            trained: trained.map(Arc::new),
            ..self
        }
    }

    /// The same under another name.
    pub(crate) fn called(self, name: &str) -> Self {
        Self {
            name: name.to_owned(),
            ..self
        }
    }

    /// How the strategy is written, as [`parse`](super::parse) reads it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What it was trained on, if it is a policy with this information.
    pub(crate) fn trained(&self) -> Option<&Trained> {
        self.trained.as_deref()
    }

    /// The strategy at the start of a run.
    pub fn make(&self) -> Box<dyn Strategy> {
        (self.make)()
    }
}

impl fmt::Debug for Blueprint {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_tuple("Blueprint").field(&self.name).finish()
    }
}
