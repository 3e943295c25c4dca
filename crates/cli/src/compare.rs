//! `pickline compare`.

use super::args::CompareArgs;
use super::flags;
use super::outputs::WHOLE;
use super::pictures;
use super::progress::Bar;
use super::session::Session;
use super::settings::parse_strategy;
use pickline::error::{Result, counted};
use pickline::experiment::{Case, CaseSource, load_cases};
use pickline::files;
use pickline::optimize::Environment;
use pickline::pattern;
use pickline::plausible::FLOW;
use pickline::sim::Conditions;
use pickline::station::Station;
use pickline::strategies::policy_file;
use pickline::study::{CompareOptions, CompareStudy};
use pickline_report::{ComparisonReport, Provenance};
use std::path::Path;

pub fn run(args: &CompareArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    args.common.check()?;
    let chart = pictures::checked::<ComparisonReport>(&args.pictures)?;
    let conditions = args.conditions.resolve(&args.common)?;
    let remark = |text: &str| args.common.remark(text);
    let (station, saved) = args.station.load_with_strategy(&remark)?;
    let cases = load_cases(&args.cases)?;
    args.conditions
        .check_on(&args.station, &args.common, &station)?;
    check_cases(args, &cases, &station)?;
    check_files(args, &cases)?;
    let options = options(args, &station, saved, conditions)?;
    let study = CompareStudy::new(&station, &cases, &options)?;
    // A single method has nothing to differ from.
    if chart.name == "difference" && study.methods() < 2 {
        return Err(pictures::missing(chart));
    }
    remark(&format!(
        "comparing on station {} ({}, belt at {} m/s), cases {}",
        args.station.station,
        counted(station.robots().len(), "robot"),
        station.belt().speed,
        args.cases
    ));
    let bar = Bar::new(args.common.quiet);
    let environment = Environment {
        stop: session.stop(),
        progress: &bar,
    };
    let compared = args.common.on_threads(|| study.run(&environment))?;
    let (done, planned) = (compared.comparison.cases.len(), compared.comparison.planned);
    let scored = format!(
        "cases {}, random ones {} patterns each under the seeds {} and up",
        identified(&args.cases)?,
        args.replicates,
        study.first_seed()
    );
    let (name, seed) = (&args.station.station, args.common.seed);
    let made = Provenance::new(&session.command(), name, &station, &scored, seed)
        .under(&conditions)
        .of_parts(done, planned, "cases")
        .of_parts(compared.bounded, planned, "cases' bounds");
    let paper_cases = matches!(args.cases.as_str(), "paper" | "all");
    let report = ComparisonReport::new(
        &compared.comparison,
        paper_cases,
        args.paper && paper_cases,
        flags::in_notes(&compared.notes),
        made,
    );
    let drawn = args.pictures.draw(chart, &report, &WHOLE);
    args.common.deliver(session, &report, &WHOLE, drawn)
}

/// The settings of the comparison; `saved` is the strategy of the station file.
fn options(
    args: &CompareArgs,
    station: &Station,
    saved: Option<String>,
    conditions: Conditions,
) -> Result<CompareOptions> {
    let (seed, quiet) = (args.common.seed, args.common.quiet);
    let saved = saved.filter(|saved| !args.strategy.contains(saved));
    let saved = saved.map(|saved| parse_strategy(&saved, quiet));
    let options = CompareOptions::default()
        .with_seed(seed)
        .with_replicates(args.replicates)
        .with_conditions(conditions)
        .with_station_strategy(saved.transpose()?)
        .with_training(args.training.resolve(station, seed, args.paper)?)
        .with_greedy(!args.no_greedy)
        .with_policy(!args.no_policy)
        .with_bound(!args.no_bound)
        .with_reference(&args.reference);
    args.strategy.iter().try_fold(options, |options, text| {
        Ok(options.with_strategy(parse_strategy(text, quiet)?))
    })
}

/// Warns about implausible values in the cases, and says what their files lack.
fn check_cases(args: &CompareArgs, cases: &[Case], station: &Station) -> Result<()> {
    for case in cases {
        // The patterns of a case are alike, so one is enough.
        let patterns = case.patterns(station.belt(), 1, args.common.seed)?;
        for (_, pattern) in &patterns {
            args.station.check_pattern(&case.name, pattern)?;
        }
        match &case.source {
            CaseSource::File(path) => {
                let loaded = pattern::load(path)?;
                if !loaded.ignored.is_empty() {
                    let (name, file) = (&case.name, path.display());
                    let about = loaded.describe();
                    args.common
                        .remark(&format!("case {name}: {file} ({about})"));
                }
            }
            CaseSource::Feed(_, flow) => {
                let place = format!("{}: case {}: flow", args.cases, case.name);
                args.station.check_values(&[(&place, &FLOW, *flow)])?;
            }
            _ => {}
        }
    }
    Ok(())
}

/// Checks that what is written is not also read.
fn check_files(args: &CompareArgs, cases: &[Case]) -> Result<()> {
    let mut read = vec![
        args.station.file(),
        ("--cases", Some(Path::new(&args.cases))),
    ];
    read.extend(cases.iter().map(|case| ("--cases", case.file())));
    read.extend(args.strategy.iter().map(|s| ("--strategy", policy_file(s))));
    args.common
        .check_outputs::<ComparisonReport>("compare", &read, &args.pictures.files())
}

/// The name of the cases; a user's file is identified by its content, not by its name.
fn identified(cases: &str) -> Result<String> {
    match Path::new(cases) {
        file if file.is_file() => {
            let hash = files::fingerprint(&files::read_text(file)?);
            Ok(format!("{cases} (hash {hash})"))
        }
        _ => Ok(cases.to_owned()),
    }
}
