//! `pickline sweep`.

use super::args::SweepArgs;
use super::flags;
use super::outputs::WHOLE;
use super::pictures;
use super::progress::Bar;
use super::session::Session;
use super::settings::parse_strategy;
use super::warnings::warn;
use pickline::error::Result;
use pickline::experiment::Axis;
use pickline::optimize::Environment;
use pickline::sim::Conditions;
use pickline::station::Station;
use pickline::strategies::policy_file;
use pickline::study::{ScoredPatterns, SweepOptions, SweepStudy};
use pickline_report::{Provenance, SweepReport};

pub fn run(args: &SweepArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    args.common.check()?;
    let chart = pictures::checked::<SweepReport>(&args.pictures)?;
    let conditions = args.conditions.resolve(&args.common)?;
    let axis = Axis::named(&args.sweep)?;
    let remark = |text: &str| args.common.remark(text);
    let (station, saved) = args.station.load_with_strategy(&remark)?;
    let saved = fitting(args, axis, saved);
    let patterns = args
        .feed
        .patterns(&args.patterns, args.items, &args.station)?;
    check_files(args, &patterns, saved.as_deref())?;
    let options = options(args, axis, patterns, saved, conditions, &station)?;
    let study = SweepStudy::new(&station, &options)?;
    args.station.check_set(study.set())?;
    args.conditions
        .check_on(&args.station, &args.common, &station)?;
    check_ends(args, axis, &study, &station)?;
    if chart.name == "limits" && (axis.helps() || study.set().patterns.len() < 2) {
        return Err(pictures::missing(chart));
    }
    remark(&format!(
        "sweeping {} on station {}, on {}",
        axis.name(),
        args.station.station,
        study.set().description
    ));
    let bar = Bar::new(args.common.quiet);
    let environment = Environment {
        stop: session.stop(),
        progress: &bar,
    };
    let swept = args.common.on_threads(|| study.run(&environment));
    let swept = swept?;
    let (name, seed) = (&args.station.station, args.common.seed);
    let (command, scored) = (session.command(), &study.set().description);
    let made = Provenance::new(&command, name, &station, scored, seed)
        .under(&conditions)
        .of_parts(swept.sweep.values.len(), swept.sweep.planned, "values");
    let report = SweepReport::new(
        &swept.sweep,
        axis,
        &swept.methods,
        study.is_papers_case(),
        flags::in_notes(&swept.notes),
        flags::flag,
        made,
    );
    let drawn = args.pictures.draw(chart, &report, &WHOLE);
    args.common.deliver(session, &report, &WHOLE, drawn)
}

/// The strategy of the station file, unless it is given too or is for one number of robots.
fn fitting(args: &SweepArgs, axis: Axis, saved: Option<String>) -> Option<String> {
    let saved = saved.filter(|saved| !args.strategy.contains(saved))?;
    if axis == Axis::Robots {
        args.common.remark(&format!(
            "ignoring {saved}, the strategy of the station file: it is for one number of robots"
        ));
        return None;
    }
    Some(saved)
}

/// The settings of the sweep; `saved` is the strategy of the station file.
fn options(
    args: &SweepArgs,
    axis: Axis,
    patterns: ScoredPatterns,
    saved: Option<String>,
    conditions: Conditions,
    station: &Station,
) -> Result<SweepOptions> {
    let (seed, quiet) = (args.common.seed, args.common.quiet);
    let saved = saved.map(|saved| parse_strategy(&saved, quiet));
    let choice = args.station.clone();
    let mut options = SweepOptions::default()
        .with_axis(axis)
        .with_robots(move |robots| choice.clone().with_robots(robots).resolve())
        .with_patterns(patterns)
        .with_seed(seed)
        .with_conditions(conditions)
        .with_station_strategy(saved.transpose()?)
        .with_training(args.training.resolve(station, seed, false)?)
        .with_greedy(args.greedy)
        .with_bound(!args.no_bound);
    if let Some(from) = args.from {
        options = options.with_from(from);
    }
    if let Some(to) = args.to {
        options = options.with_to(to);
    }
    if let Some(step) = args.step {
        options = options.with_step(step);
    }
    args.strategy.iter().try_fold(options, |options, text| {
        Ok(options.with_strategy(parse_strategy(text, quiet)?))
    })
}

/// Checks that what is written is not also read.
fn check_files(args: &SweepArgs, patterns: &ScoredPatterns, saved: Option<&str>) -> Result<()> {
    let source = patterns.source();
    let files = source.files()?;
    let mut read = vec![args.station.file()];
    read.extend(files.iter().map(|file| ("--patterns", Some(&**file))));
    read.push(("--patterns", source.folder()));
    let strategies = saved.into_iter().chain(args.strategy.iter().map(|s| &**s));
    read.extend(strategies.map(|s| ("--strategy", policy_file(s))));
    args.common
        .check_outputs::<SweepReport>("sweep", &read, &args.pictures.files())
}

/// Warns about implausible lines at the ends of the range; the values between them are no
/// worse.
fn check_ends(args: &SweepArgs, axis: Axis, study: &SweepStudy, station: &Station) -> Result<()> {
    let Some([(_, first), (value, last)]) = study.ends() else {
        return Ok(());
    };
    let place = format!("--sweep {} at {value}", axis.name());
    let ends = [last, first].map(|line| line.warnings(&place));
    let known = station.warnings(&place);
    let new = ends.into_iter().find(|w| !w.is_empty() && *w != known);
    warn(args.station.strict, new.unwrap_or_default())
}
