//! `pickline run`.

use super::access::TcpAddresses;
use super::args::{DialectArg, RunArgs};
use super::dashboard::{Screen, Served};
use super::live::{is_same_place, stop_flag};
use super::live_strategy::{allowance, live_strategy};
use super::monitor::RunMonitor;
use super::notify::Notify;
use super::remarks::Remarks;
#[cfg(feature = "mcap")]
use super::replay::ReplayPlan;
use super::session::Session;
use super::settings::{default_strategy, parse_strategy};
use pickline::error::{Error, Result, shown, shown_number};
use pickline::files;
use pickline::plausible::{DECISION_TIME, TIMEOUT, TOLERANCE};
use pickline::station::Station;
use pickline::strategies::{StrategySpec, policy_file};
use pickline::study::{BlueprintOptions, policy_distance};
use pickline_live::node::{self, Connections, NodeOptions, RunOrigin, unix_now};
use pickline_live::protocol::{check_station, schema};
use pickline_live::transport::{Dialect, Side};
use pickline_live::{ClockKind, Config, Timeouts, lead_times};
use pickline_report::json_text;

/// The program's name and version, as recorded.
const PROGRAM: &str = concat!("pickline ", env!("CARGO_PKG_VERSION"));

pub(crate) fn run(args: RunArgs, session: &Session) -> Result<()> {
    match args.resolve(session)? {
        RunPlan::Schema => session.print(json_text(&schema())?.as_bytes()),
        #[cfg(feature = "mcap")]
        RunPlan::Replay(plan) => plan.run(session),
        RunPlan::Line(plan) => plan.run(session),
    }
}

/// A resolved call.
enum RunPlan {
    /// Prints the schema of the protocol.
    Schema,
    /// Repeats a recorded run.
    #[cfg(feature = "mcap")]
    Replay(Box<ReplayPlan>),
    /// Runs a line.
    Line(Box<LinePlan>),
}

/// A line to run.
struct LinePlan {
    station: Station,
    station_name: String,
    strategy: StrategySpec,
    /// Where the strategy comes from, if it is a default.
    from: &'static str,
    planning: BlueprintOptions,
    options: NodeOptions,
    connections: Connections,
    dashboard: Option<Served>,
    remarks: Remarks,
    quiet: bool,
}

impl RunArgs {
    fn resolve(self, session: &Session) -> Result<RunPlan> {
        if self.schema {
            return Ok(RunPlan::Schema);
        }
        #[cfg(feature = "mcap")]
        if let Some(file) = &self.kept.replay {
            return Ok(RunPlan::Replay(Box::new(ReplayPlan {
                file: file.clone(),
                strategy: self.strategy.clone(),
                budget_ms: self.budget_ms,
                clock: self.transport.clock(),
                remarks: self.transport.remarks(),
                quiet: self.transport.quiet,
            })));
        }
        let plan = self.resolve_line(session)?;
        Ok(RunPlan::Line(Box::new(plan)))
    }

    fn resolve_line(self, session: &Session) -> Result<LinePlan> {
        let transport = &self.transport;
        let remarks = transport.remarks();
        session.log_into(remarks.log());
        self.check_addresses()?;
        self.check_belt_request()?;
        self.check_files()?;
        let allowance = allowance(self.budget_ms, transport.clock())?;
        let remark = |text: &str| remarks.remark(text);
        let (station, saved) = self.station.load_with_strategy(&remark)?;
        let (text, from) = match &self.strategy {
            Some(text) => (text.clone(), ""),
            None => default_strategy(saved, station.robots().len()),
        };
        let options = self.node_options(session, &station, &text)?;
        self.warn_of_values()?;
        let planning = BlueprintOptions::default()
            .with_seed(self.seed)
            .with_allowance(allowance);
        let dialect = self.dialect.resolve(transport.clock(), &station)?;
        let connections = transport.connections(Side::Node, &station, dialect)?;
        let dashboard = self.dashboard.as_ref().map(|address| -> Result<Served> {
            Ok(Served {
                address: address.clone(),
                title: self.station.title(),
                access: transport.access.listening()?,
            })
        });
        Ok(LinePlan {
            strategy: parse_strategy(&text, transport.quiet)?,
            station,
            from,
            planning,
            options,
            connections,
            dashboard: dashboard.transpose()?,
            remarks,
            quiet: transport.quiet,
            station_name: self.station.station,
        })
    }

    /// The settings of the node; `strategy` is the text of its strategy.
    ///
    /// # Errors
    /// A value out of range, or a lead time for a robot that the station does not have.
    fn node_options(
        &self,
        session: &Session,
        station: &Station,
        strategy: &str,
    ) -> Result<NodeOptions> {
        let config = Config::default()
            .with_clock(self.transport.clock())
            .with_tolerance(self.tolerance)
            .with_ack_timeout(self.ack_timeout)
            .with_result_timeout(self.result_timeout)
            .with_status_every(self.status_every)
            .with_timeouts(
                Timeouts::default()
                    .with_belt(self.belt_timeout)
                    .with_robot(self.robot_timeout),
            )
            .with_camera_delay(self.camera_delay()?)
            .with_lead(lead_times(&self.lead, station)?)
            .with_may_stop_belt(self.may_stop_belt)
            .with_stop_margin(self.stop_margin)
            .with_min_detection(self.min_detection);
        config.check(station)?;
        let mut options = NodeOptions::default().with_config(config).with_origin(
            RunOrigin::default()
                .with_program(PROGRAM)
                .with_command(session.command())
                .with_strategy(strategy)
                .with_budget_ms(self.budget_ms)
                .with_seed(self.seed),
        );
        if let Some(journal) = &self.kept.journal {
            options = options.with_journal(journal.clone(), self.kept.fsync);
        }
        #[cfg(feature = "mcap")]
        if let Some(record) = &self.kept.record {
            options = options.with_recording(record.clone());
        }
        Ok(options)
    }

    /// The delay of pictures [s]. It is checked here because the flag is in milliseconds, and so
    /// must be the message.
    ///
    /// # Errors
    /// A delay out of range.
    fn camera_delay(&self) -> Result<f64> {
        let (delay, allowed) = (1e-3 * self.camera_delay, Config::CAMERA_DELAYS);
        if allowed.contains(&delay) {
            return Ok(delay);
        }
        let [low, high] = [allowed.start(), allowed.end()].map(|end| shown_number(1e3 * end));
        Err(Error::usage(
            "--camera-delay",
            format!("{} is out of range", shown_number(self.camera_delay)),
            format!("give {low} to {high} ms"),
        ))
    }

    /// Warns about implausible values.
    ///
    /// # Errors
    /// With `--strict`, an implausible value.
    fn warn_of_values(&self) -> Result<()> {
        self.station.check_values(&[
            ("--tolerance", &TOLERANCE, Some(self.tolerance)),
            ("--ack-timeout", &TIMEOUT, Some(self.ack_timeout)),
            ("--result-timeout", &TIMEOUT, Some(self.result_timeout)),
            ("--budget-ms", &DECISION_TIME, self.budget_ms),
        ])
    }

    /// Checks that the dashboard has a separate address, and that no address is open to others
    /// by mistake.
    ///
    /// # Errors
    /// Two flags with the same address; as for
    /// [`AccessArgs::check`](super::args::AccessArgs::check).
    fn check_addresses(&self) -> Result<()> {
        let transport = &self.transport;
        let places = [
            ("--listen", &transport.listen),
            ("--connect", &transport.connect),
        ];
        for (flag, place) in places {
            if let (Some(address), Some(place)) = (&self.dashboard, place)
                && is_same_place(address, place)
            {
                return Err(Error::usage(
                    "--dashboard",
                    format!("{} is also the address of {flag}", shown(address)),
                    "give each a different port, for example --dashboard 127.0.0.1:8090",
                ));
            }
        }
        let addresses = TcpAddresses {
            dashboard: self.dashboard.as_deref(),
            ..transport.addresses()
        };
        transport.access.check(Side::Node, addresses)
    }

    /// Checks that the belt can be asked to stop over the chosen transport.
    ///
    /// # Errors
    /// A transport without a message for it.
    fn check_belt_request(&self) -> Result<()> {
        #[cfg(feature = "ros2")]
        if self.may_stop_belt && self.transport.ros2.ros2 {
            let cure = "leave it out, or use TCP or MQTT, which support belt_request";
            return Err(Error::usage(
                "--may-stop-belt",
                "there is no ROS 2 topic for it",
                cure,
            ));
        }
        Ok(())
    }

    /// Checks, before the work begins, that the journal and the recording can be written and are
    /// not input files. Existing content is checked when they are opened: a journal must belong
    /// to this line, and a recording must not replace a file.
    ///
    /// # Errors
    /// A file that cannot be written, or that is used twice.
    fn check_files(&self) -> Result<()> {
        let read = [
            self.station.file(),
            ("--strategy", self.strategy.as_deref().and_then(policy_file)),
        ];
        #[cfg(feature = "mcap")]
        let record = self.kept.record.as_deref();
        #[cfg(not(feature = "mcap"))]
        let record = None;
        let written = [
            ("--journal", self.kept.journal.as_deref()),
            ("--record", record),
        ];
        for file in written.iter().filter_map(|(_, file)| *file) {
            files::check_target(file)?;
            files::try_target(file)?;
        }
        files::check_apart(&read, &written)
    }
}

impl DialectArg {
    /// The dialect of protocol lines.
    ///
    /// # Errors
    /// A station that the dialect cannot represent.
    fn resolve(self, clock: ClockKind, station: &Station) -> Result<Dialect> {
        match self {
            Self::Json => Ok(Dialect::Json),
            Self::Csv => {
                check_station(station)?;
                let is_real = clock == ClockKind::System;
                Ok(Dialect::Csv(is_real.then_some(unix_now)))
            }
        }
    }
}

impl LinePlan {
    fn run(self, session: &Session) -> Result<()> {
        let (station, remarks) = (self.station, self.remarks);
        let put = &self.planning;
        let strategy = live_strategy(&self.strategy, put, self.quiet, &station, session)?;
        if let Some(distance) = policy_distance(&strategy, &station) {
            remarks.remark(&distance.to_string());
        }
        let strategy = strategy.make();
        remarks.remark(&format!(
            "running {}{}, station {}",
            strategy.name(),
            self.from,
            self.station_name
        ));
        let screen = Screen::open(self.dashboard, &station, &strategy.name(), &remarks)?;
        let mut monitor = RunMonitor {
            remarks: &remarks,
            is_closed: self.connections.terms.access.is_closed(),
            notify: Notify::found(),
            screen: Some(screen),
        };
        let (options, stop) = (&self.options, stop_flag());
        let connections = self.connections;
        node::run(station, strategy, options, connections, &mut monitor, &stop).map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Cli, Command};
    use clap::Parser as _;

    #[test]
    fn a_journal_is_synced_where_that_is_asked_for() {
        let flags = [
            "pickline",
            "run",
            "-q",
            "--journal",
            "line.journal",
            "--fsync",
        ];
        for (count, expected) in [(flags.len() - 1, false), (flags.len(), true)] {
            let Command::Run(args) = Cli::try_parse_from(&flags[..count]).unwrap().command else {
                unreachable!();
            };
            let station = args.station.resolve().unwrap();
            let session = Session::new(Vec::new());
            let options = args
                .node_options(&session, &station, "rules:SPT,FIFO")
                .unwrap();
            assert_eq!(options.syncs_journal(), expected);
        }
    }
}
