//! `pickline run`.

use super::args::{Common, DialectArg, Format, RunArgs};
use super::dashboard::Screen;
use super::kept::{self, Kept};
use super::live::{NodeClock, PATIENCE, check_range, is_same_place, stop_flag, unix_now};
use super::node::Node;
use super::notify::Notify;
use super::progress::Bar;
use super::session::Session;
use super::settings::{default_strategy, parse_strategy};
use super::training::{Line, budget, distance};
use pickline::error::{Error, Result, shown};
use pickline::optimize::Environment;
use pickline::planning::{Allowance, Budget};
use pickline::plausible::{DECISION_TIME, TIMEOUT, TOLERANCE};
use pickline::station::Station;
use pickline::strategies::Blueprint;
use pickline_live::protocol::{check_station, schema};
use pickline_live::transport::{Dialect, Side};
use pickline_live::{ClockKind, Config, Timeouts};
use pickline_report::json_text;
use std::cell::OnceCell;
use std::time::Instant;

pub fn run(args: &RunArgs, session: &Session) -> Result<()> {
    if args.schema {
        return session.print(json_text(&schema())?.as_bytes());
    }
    #[cfg(feature = "mcap")]
    if let Some(file) = &args.kept.replay {
        return super::replay::replay(args, file, session);
    }
    session.log_into(args.transport.log());
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
    ])?;
    check_addresses(args)?;
    let dashboard = args.dashboard.as_deref();
    let access = &args.transport.access;
    access.check(Side::Node, &args.transport, dashboard)?;
    #[cfg(feature = "ros2")]
    if args.may_stop_belt && args.transport.ros2.ros2 {
        let cure = "leave it out, or use TCP or MQTT, which support belt_request";
        return Err(Error::input(
            "--may-stop-belt",
            "there is no ROS 2 topic for it",
            cure,
        ));
    }
    kept::check(args)?;
    let allowance = allowance(args.budget_ms, args.transport.clock())?;
    let remark = |text: &str| args.transport.remark(text);
    let (station, saved) = args.station.load_with_strategy(&remark)?;
    let (text, from) = match &args.strategy {
        Some(text) => (text.clone(), ""),
        None => default_strategy(saved, station.robots().len()),
    };
    let lead = lead_times(&args.lead, &station)?;
    let quiet = args.transport.quiet;
    let strategy = blueprint(&text, args.seed, quiet, &station, session, allowance)?;
    let config = Config {
        clock: args.transport.clock(),
        tolerance: args.tolerance,
        ack_timeout: args.ack_timeout,
        result_timeout: args.result_timeout,
        status_every: args.status_every,
        timeouts: Timeouts {
            belt: args.belt_timeout,
            robot: args.robot_timeout,
        },
        camera_delay: 1e-3 * args.camera_delay,
        lead,
        may_stop_belt: args.may_stop_belt,
        stop_margin: args.stop_margin,
        ..Config::default()
    };
    if let Some(distance) = distance(&strategy, &station) {
        remark(&distance.text);
    }
    let made = strategy.make();
    args.transport.remark(&format!(
        "running {}{from}, station {}",
        made.name(),
        args.station.station
    ));
    let dialect = dialect(args, &station)?;
    let screen = Screen::open(args, &station, &made.name())?;
    let began = Instant::now();
    let (controller, kept) = Kept::open(args, session, station, (&text, made), config)?;
    let hub = match args
        .transport
        .open(Side::Node, controller.station(), dialect)
    {
        Ok(hub) => hub,
        Err(error) => {
            kept.discard();
            return Err(error);
        }
    };
    let stopwatch = Box::new(move || began.elapsed().as_secs_f64());
    let mut node = Node {
        controller: controller.with_stopwatch(stopwatch),
        hub,
        clock: NodeClock::start(),
        ahead: 0.0,
        kept,
        notify: Notify::found(),
        screen,
        transport: &args.transport,
        talking: 0,
        held_back: None,
        status_every: args.status_every,
    };
    let gone = node.go(&stop_flag());
    // Messages already in the journal are still sent, even after an error.
    node.hub.close(PATIENCE)?;
    node.screen.close(&node.controller);
    gone.and(node.kept.finish())
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
            Error::input("--lead", problem, cure)
        })?;
        check_range("--lead", seconds, 0.0, 60.0, "s")?;
        if name.is_empty() && !text.contains('=') {
            lead.fill(seconds);
            continue;
        }
        let Some(index) = robots.iter().position(|robot| robot.name == name) else {
            let known: Vec<&str> = robots.iter().map(|robot| robot.name.as_str()).collect();
            let problem = format!("there is no robot `{}`", shown(name));
            return Err(Error::input(
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
            return Err(Error::input(
                "--dashboard",
                format!("{} is also the address of {flag}", shown(address)),
                "give each a different port, for example --dashboard 127.0.0.1:8090",
            ));
        }
    }
    Ok(())
}

/// The time or work budget of each decision on a live line.
///
/// # Errors
/// An invalid time.
pub fn allowance(ms: Option<f64>, clock: ClockKind) -> Result<Allowance> {
    Ok(Allowance {
        asked: budget(ms)?,
        otherwise: match clock {
            // The belt does not wait.
            ClockKind::System => Budget::LIVE,
            // The same stream gives the same output on every machine.
            ClockKind::Messages => Budget::EXPERIMENT,
        },
    })
}

/// The strategy of a live line, parsed from `text`.
///
/// # Errors
/// A text that is not a valid strategy.
pub fn blueprint(
    text: &str,
    seed: u64,
    quiet: bool,
    station: &Station,
    session: &Session,
    allowance: Allowance,
) -> Result<Blueprint> {
    let common = Common {
        seed,
        update_hz: 0.0,
        threads: None,
        format: Format::Table,
        out: None,
        force: false,
        quiet,
    };
    let bar = Bar::new(common.quiet);
    let environment = Environment {
        stop: session.stop(),
        progress: &bar,
    };
    let line = Line::new(&common, station, &environment);
    let strategy = parse_strategy(text, quiet)?;
    common.on_threads(|| line.put(&strategy, &OnceCell::new(), allowance))
}
