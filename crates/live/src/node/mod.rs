//! The node that runs a line: it connects the controller with its peers, keeps its journal and
//! its recording, and lets a [`NodeMonitor`] tell people and machines how it goes.
//!
//! [`run`] is one call for all of that. `pickline run` is this call with its arguments.

mod clock;
mod event_loop;
mod kept;
mod monitor;
mod options;

pub use clock::{CLOSE_TIMEOUT, POLL_INTERVAL, ROOM_INTERVAL, unix_now, until};
pub use monitor::{NodeMonitor, NodeSummary, Severity, Unwatched};
pub use options::{Connections, NodeOptions, RunOrigin};

use crate::transport::Hub;
use event_loop::EventLoop;
use kept::KeptFiles;
use pickline::decision::Strategy;
use pickline::error::Result;
use pickline::station::Station;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Runs the line of `station` with `strategy` until `stop` is set or no peer has more to send,
/// then sends the final status. With a journal that is not empty, the run resumes where it ends.
///
/// # Errors
/// A place that cannot be opened, a journal that belongs to another line or cannot be written,
/// a recording that cannot be written, a peer's error after which the line cannot continue, or
/// detections that all lie outside the line.
pub fn run(
    station: Station,
    strategy: Box<dyn Strategy>,
    options: &NodeOptions,
    connections: Connections,
    monitor: &mut dyn NodeMonitor,
    stop: &AtomicBool,
) -> Result<NodeSummary> {
    let began = Instant::now();
    let (controller, kept) = KeptFiles::open(options, station, strategy, monitor)?;
    let hub = match Hub::open(&connections.place, connections.terms) {
        Ok(hub) => hub,
        Err(error) => {
            kept.discard();
            return Err(error);
        }
    };
    monitor.opened(&connections.place, &hub);
    let stopwatch = Box::new(move || began.elapsed().as_secs_f64());
    let controller = controller.with_stopwatch(stopwatch);
    EventLoop::new(controller, hub, kept, monitor, options).run(stop)
}
