//! `pickline simulate`.

use super::args::SimulateArgs;
use super::flags;
use super::outputs::{Outputs, WHOLE};
use super::progress::Bar;
use super::session::Session;
use super::settings::{budget, default_strategy, load_pattern, parse_strategy};
use pickline::decision::{Observer, Outcome, Strategy};
use pickline::error::Result;
use pickline::optimize::{Environment, bound_beside};
use pickline::pattern::Pattern;
use pickline::planning::Allowance;
use pickline::plausible::DECISION_TIME;
use pickline::sim::{Scene, Trace, simulate_observed};
use pickline::station::Station;
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
    check_files(args)?;
    let allowance = Allowance::default().with_asked(budget(args.budget_ms)?);
    let (station, saved) = args
        .station
        .load_with_strategy(&|text| common.remark(text))?;
    let (pattern, pattern_name) = load_pattern(args.pattern.as_deref(), station.belt().width)?;
    let pattern_place = args.pattern.as_deref().unwrap_or(&pattern_name);
    check_values(args, &station, &pattern, pattern_place)?;
    let (text, from) = match &args.strategy {
        Some(text) => (text.clone(), ""),
        None => default_strategy(saved, station.robots().len()),
    };
    let bar = Bar::new(common.quiet);
    let environment = Environment {
        stop: session.stop(),
        progress: &bar,
    };
    let mut strategy = make_strategy(args, &text, allowance, &station, &environment)?;
    if args.pattern.is_none() || args.strategy.is_none() {
        common.remark(&format!(
            "simulating {}{from} on {pattern_name}, station {}",
            strategy.name(),
            args.station.station
        ));
    }
    let scene = Scene::under(&station, &pattern, conditions)
        .map_err(|error| error.inside(pattern_place))?;
    if conditions.disturbances.never_fails(pattern.items()) {
        common.remark(&flags::in_note(&Note::NothingFails));
    }
    let mut trace = args.trace.as_ref().map(|_| Trace::new(&station, &pattern));
    let observer = trace.as_mut().map(|trace| trace as &mut dyn Observer);
    let outcome = simulate_observed(&scene, strategy.as_mut(), observer)?;
    let name = &args.station.station;
    let made = Provenance::new(
        &session.command(),
        name,
        &station,
        &pattern_name,
        common.seed,
    )
    .under(&conditions);
    let mut report = RunReport::new(strategy.name(), &scene, &outcome, made);
    let clearance = add_checks(&mut report, args, &scene, &outcome, &environment)?;
    let mut outputs = Outputs::default();
    if let Some(trace) = &trace {
        let origin = report.made.csv_comment();
        outputs.add(args.trace.as_deref(), || origin + &trace.to_csv());
    }
    outputs.add(args.html.as_deref(), || {
        replay_page(&scene, &args.station.title(), &report, clearance.as_ref())
    });
    common.deliver(session, &report, &WHOLE, outputs)
}

/// Checks that what is written is not also read.
fn check_files(args: &SimulateArgs) -> Result<()> {
    let read = [
        args.station.file(),
        ("--pattern", args.pattern.as_deref().map(Path::new)),
        ("--strategy", args.strategy.as_deref().and_then(policy_file)),
    ];
    let written = [
        ("--trace", args.trace.as_deref()),
        ("--html", args.html.as_deref()),
    ];
    args.common
        .check_outputs::<RunReport>("simulate", &read, &written)
}

/// Warns about implausible values; `place` is where the pattern comes from.
fn check_values(
    args: &SimulateArgs,
    station: &Station,
    pattern: &Pattern,
    place: &str,
) -> Result<()> {
    args.conditions
        .check_on(&args.station, &args.common, station)?;
    let values = [("--budget-ms", &DECISION_TIME, args.budget_ms)];
    args.station.check_values(&values)?;
    args.station.check_pattern(place, pattern)?;
    if args.html.is_some() {
        check_replay(pattern).map_err(|error| error.at("--html"))?;
    }
    Ok(())
}

/// The strategy `text` on `station`, with a remark if the line is far from a policy's training.
fn make_strategy(
    args: &SimulateArgs,
    text: &str,
    allowance: Allowance,
    station: &Station,
    environment: &Environment,
) -> Result<Box<dyn Strategy>> {
    let strategy = parse_strategy(text, args.common.quiet)?;
    let options = BlueprintOptions::default()
        .with_seed(args.common.seed)
        .with_update_hz(args.common.update_hz)
        .with_allowance(allowance);
    let put = || blueprint(&strategy, station, &options, environment);
    let blueprint = args.common.on_threads(put)?;
    if let Some(distance) = policy_distance(&blueprint, station) {
        args.common.remark(&distance.to_string());
    }
    Ok(blueprint.make())
}

/// Adds to `report` what was asked for: the independent checker's verdict, the smallest distance
/// between arms, the bound. Returns that distance if the report or the replay needs it.
fn add_checks(
    report: &mut RunReport,
    args: &SimulateArgs,
    scene: &Scene,
    outcome: &Outcome,
    environment: &Environment,
) -> Result<Option<ClearanceReport>> {
    let station = scene.station();
    if args.check {
        checker::check(station, scene.pattern(), outcome)?;
        report.checked = Some(true);
    }
    let smallest = match args.check || args.html.is_some() {
        true => clearance::smallest(station, outcome),
        false => None,
    };
    let smallest = smallest.map(|found| ClearanceReport::new(station, &found));
    if args.check {
        report.clearance.clone_from(&smallest);
    }
    if !args.no_bound {
        let bound = bound_beside(scene, outcome.figures.picked, environment)?;
        report.bound = Some(CertifiedReport::new(&outcome.figures, &bound));
    }
    Ok(smallest)
}
