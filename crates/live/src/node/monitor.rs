//! Who watches a node, and what it tells them.

use crate::Controller;
use crate::protocol::{Latency, Status};
use crate::transport::{Endpoint, Hub};
use std::fmt;

/// How serious a remark is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// A part of the node cannot continue.
    Error,
    /// Something is wrong, but the line continues.
    Warning,
    /// Information for the operator.
    Info,
}

/// Watches a node. The methods are called from the node's loop and must not block. Each does
/// nothing unless it is implemented.
pub trait NodeMonitor {
    /// The node can be reached at `place`.
    fn opened(&mut self, place: &Endpoint, hub: &Hub) {
        let _ = (place, hub);
    }

    /// The line is running.
    fn ready(&mut self) {}

    /// The node's loop goes on; called in every iteration.
    fn alive(&mut self) {}

    /// A remark for the operator. Remarks of the same `kind`, if there is one, repeat each
    /// other with other figures.
    fn remark(&mut self, severity: Severity, kind: Option<&str>, text: &str) {
        let _ = (severity, kind, text);
    }

    /// A status is sent.
    fn status(&mut self, status: &Status) {
        let _ = status;
    }

    /// The state of the line may have changed.
    fn line(&mut self, controller: &Controller, hub: &Hub) {
        let _ = (controller, hub);
    }

    /// No new tasks are given.
    fn stopping(&mut self) {}

    /// The last status is sent.
    fn finished(&mut self, summary: &NodeSummary) {
        let _ = summary;
    }

    /// The connections are closed.
    fn closed(&mut self, controller: &Controller) {
        let _ = controller;
    }
}

/// The monitor of a node that nobody watches.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unwatched;

impl NodeMonitor for Unwatched {}

/// What a node did, from its beginning to its end.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct NodeSummary {
    /// The figures at the end.
    pub status: Status,
    /// How long decisions took.
    pub latency: Latency,
    /// Whether it was asked to stop.
    pub stopped: bool,
}

impl fmt::Display for NodeSummary {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (status, latency) = (&self.status, &self.latency);
        let unwanted = status.unwanted_words();
        write!(
            f,
            "{} of {} items picked, {} missed, {} on the belt, {} claimed{unwanted}; {} decisions, \
             p50 {:.3} ms, p99 {:.3} ms, max {:.3} ms",
            status.picked,
            status.wanted(),
            status.missed.total(),
            status.on_belt,
            status.claimed,
            latency.decisions,
            latency.p50_ms,
            latency.p99_ms,
            latency.max_ms,
        )
    }
}
