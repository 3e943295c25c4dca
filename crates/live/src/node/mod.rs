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
/// As for [`Config::check`](crate::Config::check); a strategy for another number of robots, a place
/// that cannot be opened, a journal that belongs to another line or cannot be written,
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
    // Before any file is created.
    options.config.check(&station)?;
    strategy.check_station(&station)?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Config;
    use crate::transport::Endpoint;
    use pickline::error::ErrorKind;
    use pickline::strategies::read_alone;

    #[test]
    fn wrong_settings_are_refused_before_a_file_is_created() {
        let folder = tempfile::tempdir().unwrap();
        let usual = Config::default();
        let short = "'strategy' [SPT]: 1 rule for 2 robots";
        for (rules, config, problem) in [
            (
                "SPT,FIFO",
                usual.clone().with_ack_timeout(0.0),
                "'ack_timeout': 0",
            ),
            (
                "SPT,FIFO",
                usual.clone().with_lead(vec![f64::NAN]),
                "'lead': NaN",
            ),
            ("SPT", usual, short),
        ] {
            let station = pickline::station::built_in("paper").unwrap();
            let station = station.station(Some(2)).unwrap();
            let robots = rules.split(',').count();
            let strategy = read_alone(rules, robots).unwrap().make();
            let connections = Connections::new(Endpoint::Stdio, &station, config.clock);
            let journal = folder.path().join("line.journal");
            let options = NodeOptions::default()
                .with_config(config)
                .with_journal(journal, false);
            let stop = AtomicBool::new(true);
            let ran = run(
                station,
                strategy,
                &options,
                connections,
                &mut Unwatched,
                &stop,
            );
            let error = ran.err().unwrap();
            assert_eq!(error.kind(), ErrorKind::Usage, "{error}");
            assert!(error.to_string().starts_with(problem), "{error}");
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        }
    }
}
