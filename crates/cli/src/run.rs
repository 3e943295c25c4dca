//! `pickline run`.

use super::args::{DialectArg, RunArgs};
use super::dashboard::{Screen, Served};
use super::live::{check_range, is_same_place, stop_flag};
use super::live_strategy::{allowance, live_strategy};
use super::monitor::RunMonitor;
use super::notify::Notify;
use super::session::Session;
use super::settings::default_strategy;
use pickline::error::{Error, Result, shown};
use pickline::files;
use pickline::plausible::{DECISION_TIME, TIMEOUT, TOLERANCE};
use pickline::station::Station;
use pickline::strategies::policy_file;
use pickline::study::{BlueprintOptions, policy_distance};
use pickline_live::node::{self, NodeOptions, RunOrigin, unix_now};
use pickline_live::protocol::{check_station, schema};
use pickline_live::transport::{Dialect, Side};
use pickline_live::{ClockKind, Config, Timeouts};
use pickline_report::json_text;

/// The program's name and version, as recorded.
const PROGRAM: &str = concat!("pickline ", env!("CARGO_PKG_VERSION"));

pub fn run(args: &RunArgs, session: &Session) -> Result<()> {
    if args.schema {
        return session.print(json_text(&schema())?.as_bytes());
    }
    #[cfg(feature = "mcap")]
    if let Some(file) = &args.kept.replay {
        return super::replay::replay(args, file, session);
    }
    let transport = &args.transport;
    let remarks = transport.remarks();
    session.log_into(remarks.log());
    check_values(args)?;
    check_addresses(args)?;
    let dashboard = args.dashboard.as_deref();
    transport.access.check(Side::Node, transport, dashboard)?;
    #[cfg(feature = "ros2")]
    if args.may_stop_belt && transport.ros2.ros2 {
        let cure = "leave it out, or use TCP or MQTT, which support belt_request";
        return Err(Error::usage(
            "--may-stop-belt",
            "there is no ROS 2 topic for it",
            cure,
        ));
    }
    check_files(args)?;
    let allowance = allowance(args.budget_ms, transport.clock())?;
    let remark = |text: &str| remarks.remark(text);
    let (station, saved) = args.station.load_with_strategy(&remark)?;
    let (text, from) = match &args.strategy {
        Some(text) => (text.clone(), ""),
        None => default_strategy(saved, station.robots().len()),
    };
    let options = node_options(args, session, &station, &text)?;
    let planning = BlueprintOptions::default()
        .with_seed(args.seed)
        .with_allowance(allowance);
    let strategy = live_strategy(&text, &planning, transport.quiet, &station, session)?;
    if let Some(distance) = policy_distance(&strategy, &station) {
        remark(&distance.to_string());
    }
    let strategy = strategy.make();
    remark(&format!(
        "running {}{from}, station {}",
        strategy.name(),
        args.station.station
    ));
    let connections = transport.connections(Side::Node, &station, dialect(args, &station)?)?;
    let served = dashboard.map(|address| Served {
        address,
        title: args.station.title(),
        access: &transport.access,
    });
    let screen = Screen::open(served, &station, &strategy.name(), &remarks)?;
    let mut monitor = RunMonitor {
        remarks: &remarks,
        is_closed: connections.terms.access.is_closed(),
        notify: Notify::found(),
        screen: Some(screen),
    };
    let stop = stop_flag();
    node::run(
        station,
        strategy,
        &options,
        connections,
        &mut monitor,
        &stop,
    )
    .map(|_| ())
}

/// The settings of the node; `strategy` is the text of its strategy.
fn node_options(
    args: &RunArgs,
    session: &Session,
    station: &Station,
    strategy: &str,
) -> Result<NodeOptions> {
    let config = Config::default()
        .with_clock(args.transport.clock())
        .with_tolerance(args.tolerance)
        .with_ack_timeout(args.ack_timeout)
        .with_result_timeout(args.result_timeout)
        .with_status_every(args.status_every)
        .with_timeouts(
            Timeouts::default()
                .with_belt(args.belt_timeout)
                .with_robot(args.robot_timeout),
        )
        .with_camera_delay(1e-3 * args.camera_delay)
        .with_lead(lead_times(&args.lead, station)?)
        .with_may_stop_belt(args.may_stop_belt)
        .with_stop_margin(args.stop_margin);
    let mut options = NodeOptions::default().with_config(config).with_origin(
        RunOrigin::default()
            .with_program(PROGRAM)
            .with_command(session.command())
            .with_strategy(strategy)
            .with_budget_ms(args.budget_ms)
            .with_seed(args.seed),
    );
    if let Some(journal) = &args.kept.journal {
        options = options.with_journal(journal.clone(), args.kept.fsync);
    }
    #[cfg(feature = "mcap")]
    if let Some(record) = &args.kept.record {
        options = options.with_recording(record.clone());
    }
    Ok(options)
}

/// Checks the values of flags, and warns about implausible ones.
///
/// # Errors
/// A value out of range.
fn check_values(args: &RunArgs) -> Result<()> {
    check_range("--tolerance", args.tolerance, 0.0, 1.0, "m")?;
    check_range("--ack-timeout", args.ack_timeout, 1e-3, 1e3, "s")?;
    check_range("--result-timeout", args.result_timeout, 1e-3, 1e4, "s")?;
    let or_never = "s, or 0 to disable it";
    for (flag, value) in [
        ("--belt-timeout", args.belt_timeout),
        ("--robot-timeout", args.robot_timeout),
    ] {
        if let Some(value) = value.filter(|value| *value != 0.0) {
            check_range(flag, value, 0.01, 1e4, or_never)?;
        }
    }
    check_range("--camera-delay", args.camera_delay, -1e4, 1e4, "ms")?;
    if args.status_every != 0.0 {
        let least = match args.transport.clock() {
            ClockKind::System => 0.01,
            // Time may jump by an hour, which sends all its statuses at once.
            ClockKind::Messages => 0.1,
        };
        let unit = "s, or 0 for only the last one";
        check_range("--status-every", args.status_every, least, 1e6, unit)?;
    }
    check_range("--stop-margin", args.stop_margin, 0.0, 1e3, "s")?;
    args.station.check_values(&[
        ("--tolerance", &TOLERANCE, Some(args.tolerance)),
        ("--ack-timeout", &TIMEOUT, Some(args.ack_timeout)),
        ("--result-timeout", &TIMEOUT, Some(args.result_timeout)),
        ("--budget-ms", &DECISION_TIME, args.budget_ms),
    ])
}

/// Checks, before the work begins, that the journal and the recording can be written and are
/// not input files. Existing content is checked when they are opened: a journal must belong
/// to this line, and a recording must not replace a file.
///
/// # Errors
/// A file that cannot be written, or that is used twice.
fn check_files(args: &RunArgs) -> Result<()> {
    let read = [
        args.station.file(),
        ("--strategy", args.strategy.as_deref().and_then(policy_file)),
    ];
    #[cfg(feature = "mcap")]
    let record = args.kept.record.as_deref();
    #[cfg(not(feature = "mcap"))]
    let record = None;
    let written = [
        ("--journal", args.kept.journal.as_deref()),
        ("--record", record),
    ];
    for file in written.iter().filter_map(|(_, file)| *file) {
        files::check_target(file)?;
        files::try_target(file)?;
    }
    files::check_apart(&read, &written)
}

/// The dialect of protocol lines.
///
/// # Errors
/// A station that the dialect cannot represent.
fn dialect(args: &RunArgs, station: &Station) -> Result<Dialect> {
    match args.dialect {
        DialectArg::Json => Ok(Dialect::Json),
        DialectArg::Csv => {
            check_station(station)?;
            let is_real = args.transport.clock() == ClockKind::System;
            Ok(Dialect::Csv(is_real.then_some(unix_now)))
        }
    }
}

/// The lead time of each robot [s], from `S` for all and `NAME=S` for one.
///
/// # Errors
/// A value that is not a time, or a robot that the station does not have.
fn lead_times(given: &[String], station: &Station) -> Result<Vec<f64>> {
    let robots = station.robots();
    let mut lead = vec![0.0; robots.len()];
    // A value for one robot overrides a value for all robots, whatever their order.
    let (one, all): (Vec<&String>, Vec<&String>) = given.iter().partition(|t| t.contains('='));
    for text in all.into_iter().chain(one) {
        let (name, time) = text.rsplit_once('=').unwrap_or(("", text));
        let seconds: f64 = time.trim().parse().map_err(|_| {
            let problem = format!("`{}` is not a time", shown(text));
            let cure = "give seconds for all robots, such as 0.1, or for one robot, such as r1=0.1";
            Error::usage("--lead", problem, cure)
        })?;
        check_range("--lead", seconds, 0.0, 60.0, "s")?;
        if name.is_empty() && !text.contains('=') {
            lead.fill(seconds);
            continue;
        }
        let Some(index) = robots.iter().position(|robot| robot.name == name) else {
            let known: Vec<&str> = robots.iter().map(|robot| robot.name.as_str()).collect();
            let problem = format!("there is no robot `{}`", shown(name));
            return Err(Error::usage(
                "--lead",
                problem,
                format!("give one of {}", known.join(", ")),
            ));
        };
        lead[index] = seconds;
    }
    Ok(lead)
}

/// Checks that the dashboard has a separate address.
///
/// # Errors
/// Two flags with the same address.
fn check_addresses(args: &RunArgs) -> Result<()> {
    let places = [
        ("--listen", &args.transport.listen),
        ("--connect", &args.transport.connect),
    ];
    for (flag, place) in places {
        if let (Some(address), Some(place)) = (&args.dashboard, place)
            && is_same_place(address, place)
        {
            return Err(Error::usage(
                "--dashboard",
                format!("{} is also the address of {flag}", shown(address)),
                "give each a different port, for example --dashboard 127.0.0.1:8090",
            ));
        }
    }
    Ok(())
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
            let options = node_options(&args, &session, &station, "rules:SPT,FIFO").unwrap();
            assert_eq!(options.syncs_journal(), expected);
        }
    }
}
