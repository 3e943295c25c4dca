//! Runs a line: what the camera, the belt and the robots report comes in, tasks go out.
//!
//! Over stdin and stdout, for example with `pickline emulate --clock messages`.

use pickline::error::Result;
use pickline::{station, strategies};
use pickline_live::node::{self, Connections, NodeMonitor, NodeOptions, NodeSummary, Unwatched};
use pickline_live::transport::Endpoint;
use pickline_live::{ClockKind, Config};
use std::sync::atomic::AtomicBool;

fn main() -> Result<()> {
    let summary = run(Endpoint::Stdio, &mut Unwatched)?;
    eprintln!("{summary}");
    Ok(())
}

/// Runs the line of two robots for the peers at `place`.
pub fn run(place: Endpoint, monitor: &mut dyn NodeMonitor) -> Result<NodeSummary> {
    let station = station::built_in("paper")?.station(Some(2))?;
    let strategy = strategies::read_alone("rules:SPT,FIFO", 2)?.make();
    let config = Config::default().with_clock(ClockKind::Messages);
    let connections = Connections::new(place, &station, config.clock);
    let options = NodeOptions::default().with_config(config);
    let stop = AtomicBool::new(false);
    node::run(station, strategy, &options, connections, monitor, &stop)
}
