//! The settings of a node.

use crate::transport::{Endpoint, HubOptions, Side};
use crate::{ClockKind, Config};
use pickline::station::Station;
use std::path::PathBuf;

/// Where the peers are, and on which terms they may connect.
#[derive(Debug)]
#[non_exhaustive]
pub struct Connections {
    /// Where the peers are.
    pub place: Endpoint,
    /// What holds for all of them.
    pub terms: HubOptions,
}

impl Connections {
    /// Peers of the line of `station` at `place`, in JSON and without authentication.
    pub fn new(place: Endpoint, station: &Station, clock: ClockKind) -> Self {
        let terms = HubOptions::new(Side::Node, station, clock);
        Self { place, terms }
    }

    /// With peers that connect on these terms.
    #[must_use]
    pub fn with_terms(mut self, terms: HubOptions) -> Self {
        self.terms = terms;
        self
    }
}

/// What a recording and a journal say about the run that wrote them.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct RunOrigin {
    /// The program and its version.
    pub program: String,
    /// The command line that started the run, for people who read it.
    pub command: String,
    /// How the strategy is written.
    pub strategy: String,
    /// Time budget for each decision of a strategy that looks ahead [ms], if there is one.
    pub budget_ms: Option<f64>,
    /// Seed of everything random.
    pub seed: u64,
}

impl RunOrigin {
    /// With this program and version.
    #[must_use]
    pub fn with_program(mut self, program: &str) -> Self {
        self.program = program.to_owned();
        self
    }

    /// With this command line.
    #[must_use]
    pub fn with_command(mut self, command: String) -> Self {
        self.command = command;
        self
    }

    /// With the strategy as it is written.
    #[must_use]
    pub fn with_strategy(mut self, strategy: &str) -> Self {
        self.strategy = strategy.to_owned();
        self
    }

    /// With this time budget for each decision [ms].
    #[must_use]
    pub fn with_budget_ms(mut self, budget_ms: impl Into<Option<f64>>) -> Self {
        self.budget_ms = budget_ms.into();
        self
    }

    /// With this seed of everything random.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }
}

/// The settings of a node.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct NodeOptions {
    pub(super) config: Config,
    pub(super) origin: RunOrigin,
    pub(super) journal: Option<PathBuf>,
    pub(super) sync: bool,
    #[cfg(feature = "mcap")]
    pub(super) record: Option<PathBuf>,
}

impl NodeOptions {
    /// With these settings of the controller.
    #[must_use]
    pub fn with_config(mut self, config: Config) -> Self {
        self.config = config;
        self
    }

    /// With this origin in the journal and the recording.
    #[must_use]
    pub fn with_origin(mut self, origin: RunOrigin) -> Self {
        self.origin = origin;
        self
    }

    /// With a journal in this file, from which a later run resumes. If `sync`, it is on the
    /// disk before a task is sent, so that it survives a power failure.
    #[must_use]
    pub fn with_journal(mut self, file: PathBuf, sync: bool) -> Self {
        self.journal = Some(file);
        self.sync = sync;
        self
    }

    /// Whether the journal is on the disk before a task is sent.
    pub fn syncs_journal(&self) -> bool {
        self.sync
    }

    /// With a recording of every message in this new file.
    #[cfg(feature = "mcap")]
    #[must_use]
    pub fn with_recording(mut self, file: PathBuf) -> Self {
        self.record = Some(file);
        self
    }
}
