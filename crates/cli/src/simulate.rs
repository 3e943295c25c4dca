//! `pickline simulate`.

use super::args::SimulateArgs;
use super::flags;
use super::outputs::{Outputs, WHOLE};
use super::progress::Bar;
use super::session::Session;
use super::settings::{budget, default_strategy, load_pattern, parse_strategy};
use pickline::decision::Observer;
use pickline::error::Result;
use pickline::optimize::{Environment, bound_beside};
use pickline::planning::Allowance;
use pickline::plausible::DECISION_TIME;
use pickline::sim::{Scene, Trace, simulate_observed};
use pickline::strategies::policy_file;
use pickline::study::{BlueprintOptions, Note, blueprint, policy_distance};
use pickline::{checker, clearance};
use pickline_report::{
    CertifiedReport, ClearanceReport, Provenance, RunReport, check_replay, replay_page,
};
use std::path::Path;

pub fn run(args: &SimulateArgs, session: &Session) -> Result<()> {
    let common = &args.common;
    common.check()?;
    let conditions = args.conditions.resolve(common)?;
    let read = [
        args.station.file(),
        ("--pattern", args.pattern.as_deref().map(Path::new)),
        ("--strategy", args.strategy.as_deref().and_then(policy_file)),
    ];
    let written = [
        ("--trace", args.trace.as_deref()),
        ("--html", args.html.as_deref()),
    ];
    common.check_outputs::<RunReport>("simulate", &read, &written)?;
    let allowance = Allowance {
        asked: budget(args.budget_ms)?,
        ..Allowance::default()
    };
    let (station, saved) = args
        .station
        .load_with_strategy(&|text| common.remark(text))?;
    let robots = station.robots().len();
    let (pattern, pattern_name) = load_pattern(args.pattern.as_deref(), station.belt().width)?;
    args.conditions
        .check_on(&args.station, &args.common, &station)?;
    let values = [("--budget-ms", &DECISION_TIME, args.budget_ms)];
    args.station.check_values(&values)?;
    args.station
        .check_pattern(args.pattern.as_deref().unwrap_or(&pattern_name), &pattern)?;
    if args.html.is_some() {
        check_replay(&pattern).map_err(|error| error.at("--html"))?;
    }
    let (text, from) = match &args.strategy {
        Some(text) => (text.clone(), ""),
        None => default_strategy(saved, robots),
    };
    let bar = Bar::new(common.quiet);
    let environment = Environment {
        stop: session.stop(),
        progress: &bar,
    };
    let strategy = parse_strategy(&text, common.quiet)?;
    let options = BlueprintOptions::default()
        .with_seed(common.seed)
        .with_update_hz(common.update_hz)
        .with_allowance(allowance);
    let put = || blueprint(&strategy, &station, &options, &environment);
    let blueprint = common.on_threads(put)?;
    if let Some(distance) = policy_distance(&blueprint, &station) {
        common.remark(&distance.to_string());
    }
    let mut strategy = blueprint.make();
    if args.pattern.is_none() || args.strategy.is_none() {
        common.remark(&format!(
            "simulating {}{from} on {pattern_name}, station {}",
            strategy.name(),
            args.station.station
        ));
    }
    let scene = Scene::under(&station, &pattern, conditions)
        .map_err(|error| error.inside(args.pattern.as_deref().unwrap_or(&pattern_name)))?;
    if conditions.disturbances.never_fails(pattern.items()) {
        common.remark(&flags::in_note(&Note::NothingFails));
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
    let smallest = match args.check || args.html.is_some() {
        true => clearance::smallest(&station, &outcome),
        false => None,
    };
    let smallest = smallest.map(|found| ClearanceReport::new(&station, &found));
    if args.check {
        report.clearance.clone_from(&smallest);
    }
    if !args.no_bound {
        let bound = bound_beside(&scene, outcome.figures.picked, &environment)?;
        report.bound = Some(CertifiedReport::new(&outcome.figures, &bound));
    }
    let mut outputs = Outputs::default();
    if let Some(trace) = &trace {
        let origin = report.made.csv_comment();
        outputs.add(args.trace.as_deref(), || origin + &trace.to_csv());
    }
    outputs.add(args.html.as_deref(), || {
        replay_page(&scene, &args.station.title(), &report, smallest.as_ref())
    });
    common.deliver(session, &report, &WHOLE, outputs)
}
