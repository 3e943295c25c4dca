//! `pickline simulate`.

use super::args::SimulateArgs;
use super::progress::Bar;
use super::session::Session;
use super::settings::{NOTHING_FAILS, json, load_pattern};
use super::training::{Line, budget};
use crate::decision::Observer;
use crate::error::Result;
use crate::optimize::{Environment, bound_beside};
use crate::planning::Allowance;
use crate::report::{CertifiedReport, Provenance, RunReport, check_replay, replay_page};
use crate::sim::{Scene, Trace, simulate_observed};
use crate::strategies::{self, policy_file};
use crate::{checker, files};
use std::cell::OnceCell;
use std::path::Path;

/// What is written into the folder for result files.
const FILES: [&str; 2] = ["run.json", "picks.csv"];

pub fn run(args: &SimulateArgs, session: &Session) -> Result<()> {
    let common = &args.common;
    common.check()?;
    let conditions = args.conditions.resolve(common)?;
    files::check_target(args.trace.as_deref())?;
    files::check_target(args.html.as_deref())?;
    let read = [
        args.station.file(),
        ("--pattern", args.pattern.as_deref().map(Path::new)),
        ("--strategy", args.strategy.as_deref().and_then(policy_file)),
    ];
    let written = [
        ("--trace", args.trace.as_deref()),
        ("--html", args.html.as_deref()),
    ];
    common.check_apart(&FILES, &read, &written)?;
    let allowance = Allowance {
        asked: budget(args.budget_ms)?,
        ..Allowance::default()
    };
    let station = args.station.load()?;
    let robots = station.robots().len();
    let (pattern, pattern_name) = load_pattern(args.pattern.as_deref(), station.belt().width)?;
    if args.html.is_some() {
        check_replay(&pattern)?;
    }
    let text = match &args.strategy {
        Some(text) => text.clone(),
        None => strategies::default_strategy(robots),
    };
    let bar = Bar::new(common.quiet);
    let environment = Environment {
        stop: session.stop(),
        progress: &bar,
    };
    let line = Line::new(common, &station, &environment);
    let strategy = strategies::parse(&text)?;
    let put = || line.put(&strategy, &OnceCell::new(), allowance);
    let mut strategy = common.on_threads(put)?.make();
    if args.pattern.is_none() || args.strategy.is_none() {
        common.remark(&format!(
            "simulating {} on {pattern_name}, station {}",
            strategy.name(),
            args.station.station
        ));
    }
    let scene = Scene::under(&station, &pattern, conditions)
        .map_err(|error| error.inside(args.pattern.as_deref().unwrap_or(&pattern_name)))?;
    if conditions.disturbances.never_fails(pattern.items()) {
        common.remark(NOTHING_FAILS);
    }
    let mut trace = args.trace.as_ref().map(|_| Trace::new(&station, &pattern));
    let observer = trace.as_mut().map(|trace| trace as &mut dyn Observer);
    let outcome = simulate_observed(&scene, strategy.as_mut(), observer)?;
    let made = Provenance::new(
        &session.command(),
        &args.station.station,
        &station,
        &pattern_name,
        common.seed,
    )
    .under(&conditions);
    let mut report = RunReport::new(strategy.name(), &scene, &outcome, made);
    if args.check {
        checker::check(&station, &pattern, &outcome)?;
        report.checked = Some(true);
    }
    if !args.no_bound {
        let bound = bound_beside(&scene, outcome.figures.picked, &environment)?;
        report.bound = Some(CertifiedReport::new(&outcome.figures, &bound));
    }
    if let (Some(file), Some(trace)) = (&args.trace, &trace) {
        let text = report.made.csv_comment() + &trace.to_csv();
        files::write_whole(file, text.as_bytes())?;
    }
    if let Some(file) = &args.html {
        files::write_whole(file, replay_page(&scene, &report).as_bytes())?;
    }
    common.write_out(FILES[0], &json(&report)?)?;
    common.write_out(FILES[1], &report.to_csv())?;
    let text = common.render(|| report.to_table(), || report.to_csv(), &report)?;
    session.print(text.as_bytes())
}
