//! The settings of a node.

use crate::transport::{Access, Dialect, Endpoint, HubOptions, Side};
use crate::{ClockKind, Config};
use pickline::station::Station;
use std::path::PathBuf;

/// Maximum number of simultaneous peers over TCP, unless another number is given.
const USUAL_PEERS: usize = 64;

/// Where the peers are, and on which terms they may connect.
#[derive(Debug)]
pub struct Connections {
    /// Where the peers are.
    pub place: Endpoint,
    /// What holds for all of them.
    pub terms: HubOptions,
}

impl Connections {
    /// Peers of the line of `station` at `place`, in JSON and without authentication.
    pub fn new(place: Endpoint, station: &Station, clock: ClockKind) -> Self {
        let robots = station.robots().iter().map(|robot| robot.name.clone());
        let terms = HubOptions {
            side: Side::Node,
            waits: clock == ClockKind::Messages,
            robots: robots.collect(),
            access: Access::default(),
            most_peers: USUAL_PEERS,
            hello: None,
            dialect: Dialect::Json,
        };
        Self { place, terms }
    }
}

/// What a recording and a journal say about the run that wrote them.
#[derive(Debug, Clone, Default)]
pub struct RunOrigin {
    /// The program and its version.
    pub program: String,
    /// The command line.
    pub command: String,
    /// How the strategy is written.
    pub strategy: String,
    /// Time budget for each decision of a strategy that looks ahead [ms], if there is one.
    pub budget_ms: Option<f64>,
    /// Seed of everything random.
    pub seed: u64,
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
