//! `pickline compare`.

use super::args::CompareArgs;
use super::outputs::WHOLE;
use super::pictures;
use super::progress::Bar;
use super::session::Session;
use super::settings::{condition_notes, parse_strategy};
use super::training::{Judged, Line, distance, full_name};
use pickline::dispatch::RULES;
use pickline::error::{Error, Result, counted, known_names, shown};
use pickline::experiment::{Case, CaseSource, Draws, Method, add_bounds, compare, load_cases};
use pickline::files;
use pickline::optimize::Environment;
use pickline::pattern;
use pickline::planning::Allowance;
use pickline::plausible::FLOW;
use pickline::station::Station;
use pickline::strategies::{self, Parsed, policy_file};
use pickline_report::{ComparisonReport, Provenance};
use std::path::Path;

/// The highest accepted number of patterns per case; more are treated as a typing mistake.
const MOST_REPLICATES: usize = 100_000;

pub fn run(args: &CompareArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    args.common.check()?;
    let chart = pictures::checked::<ComparisonReport>(&args.pictures)?;
    let conditions = args.conditions.resolve(&args.common)?;
    if !(1..=MOST_REPLICATES).contains(&args.replicates) {
        return Err(Error::input(
            "--replicates",
            format!("{} patterns per case", args.replicates),
            format!("give 1 to {MOST_REPLICATES}"),
        ));
    }
    let remark = |text: &str| args.common.remark(text);
    let (station, saved) = args.station.load_with_strategy(&remark)?;
    let robots = station.robots().len();
    let cases = load_cases(&args.cases)?;
    args.conditions
        .check_on(&args.station, &args.common, &station)?;
    for case in &cases {
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
                    remark(&format!("case {name}: {file} ({})", loaded.describe()));
                }
            }
            CaseSource::Feed(_, flow) => {
                let place = format!("{}: case {}: flow", args.cases, case.name);
                args.station.check_values(&[(&place, &FLOW, *flow)])?;
            }
            _ => {}
        }
    }
    let mut read = vec![
        args.station.file(),
        ("--cases", Some(Path::new(&args.cases))),
    ];
    read.extend(cases.iter().map(|case| ("--cases", case.file())));
    read.extend(args.strategy.iter().map(|s| ("--strategy", policy_file(s))));
    args.common
        .check_outputs::<ComparisonReport>("compare", &read, &args.pictures.files())?;
    // A user's file is identified by its content, not by its name.
    let case_file = match Path::new(&args.cases) {
        file if file.is_file() => {
            let hash = files::fingerprint(&files::read_text(file)?);
            format!("{} (hash {hash})", args.cases)
        }
        _ => args.cases.clone(),
    };
    let mut texts = args.strategy.clone();
    let mut first_notes = Vec::new();
    if let Some(saved) = saved.filter(|saved| !texts.contains(saved)) {
        first_notes.push(format!("{saved} is the strategy of the station file"));
        texts.insert(0, saved);
    }
    // The paper's third column, unless another policy replaces it or the line is far from its
    // training.
    let has_policy = texts.iter().any(|text| strategies::is_policy(text));
    if strategies::HAS_POLICY && !args.no_policy && !has_policy {
        let policy = strategies::parse(strategies::POLICY)?.alone(robots)?;
        match distance(&policy, &station).filter(|distance| distance.far) {
            Some(distance) => first_notes.push(format!(
                "the built-in policy is left out: {}; --strategy {} runs it anyway",
                distance.text,
                strategies::POLICY
            )),
            None => texts.insert(0, strategies::POLICY.into()),
        }
    }
    let strategies: Vec<Parsed> = texts
        .iter()
        .map(|text| parse_strategy(text, args.common.quiet))
        .collect::<Result<_>>()?;
    for strategy in &strategies {
        // Report an error before the long search for robust GT.
        strategy.alone(robots)?;
    }
    let greedy = greedy(args, &cases, &station)?;
    first_notes.extend(greedy.clone().err());
    let greedy = greedy.is_ok() && !args.no_greedy;
    let reference = reference(args, greedy, &texts)?;
    // A single method has nothing to differ from.
    if chart.name == "difference" && !greedy && texts.is_empty() {
        return Err(pictures::missing(chart));
    }
    args.common.remark(&format!(
        "comparing on station {} ({}, belt at {} m/s), cases {}",
        args.station.station,
        counted(robots, "robot"),
        station.belt().speed,
        args.cases
    ));
    let bar = Bar::new(args.common.quiet);
    let environment = Environment {
        stop: session.stop(),
        progress: &bar,
    };
    // The training set uses the master seed, the tables use the seeds after it.
    let first_seed = args.common.seed.wrapping_add(1);
    let report = args.common.on_threads(|| {
        let line = Line::new(&args.common, &station, &environment).under(&conditions);
        let robust = line.robust(&args.training, || {
            if args.paper {
                return Ok(Judged::AsInThePaper);
            }
            line.like_cases(&cases, &args.training)
        })?;
        let mut notes = vec![robust.note];
        notes.extend(first_notes.iter().cloned());
        let mut methods = vec![Method::Robust(robust.rules)];
        if greedy {
            methods.push(Method::greedy(robots)?);
        }
        for strategy in &strategies {
            let blueprint = line.put(strategy, &robust.best_few, Allowance::default())?;
            notes.extend(full_name(&blueprint));
            notes.extend(distance(&blueprint, &station).map(|distance| distance.text));
            methods.push(Method::Strategy(blueprint));
        }
        // The others are compared against the first method.
        methods[..=reference].rotate_right(1);
        let mut comparison = compare(
            &station,
            methods,
            &cases,
            args.replicates,
            first_seed,
            &conditions,
            &environment,
        )?;
        if !args.no_bound {
            let draws = Draws {
                replicates: args.replicates,
                first_seed,
                conditions: &conditions,
            };
            add_bounds(&mut comparison, &station, draws, &environment)?;
        }
        let done = comparison.cases.len();
        let bounded = comparison.cases.iter().filter(|case| case.bound.is_some());
        let bounded = if args.no_bound { done } else { bounded.count() };
        let made = Provenance::new(
            &session.command(),
            &args.station.station,
            &station,
            &format!(
                "cases {}, random ones {} patterns each under the seeds {first_seed} and up",
                case_file, args.replicates
            ),
            args.common.seed,
        )
        .under(&conditions)
        .of_parts(done, comparison.planned, "cases")
        .of_parts(bounded, comparison.planned, "cases' bounds");
        let generated = cases.iter().all(Case::is_generated);
        notes.extend(condition_notes(&conditions, generated));
        let paper_cases = matches!(args.cases.as_str(), "paper" | "all");
        let with_paper = args.paper && paper_cases;
        Ok(ComparisonReport::new(
            &comparison,
            paper_cases,
            with_paper,
            notes,
            made,
        ))
    })?;
    let drawn = args.pictures.draw(chart, &report, &WHOLE);
    args.common.deliver(session, &report, &WHOLE, drawn)
}

/// Whether greedy GT (game theory) can be found on the patterns of `cases` in about a minute,
/// or a note that it is left out.
fn greedy(
    args: &CompareArgs,
    cases: &[Case],
    station: &Station,
) -> Result<std::result::Result<(), String>> {
    let robots = station.robots().len();
    let (mut items, mut most) = (0.0, 0);
    for case in cases {
        let patterns = if case.is_random() { args.replicates } else { 1 };
        let one = case.patterns(station.belt(), 1, args.common.seed)?;
        let length: usize = one.iter().map(|(_, pattern)| pattern.len()).sum();
        items += patterns as f64 * length as f64;
        most = most.max(patterns);
    }
    Ok(match Method::greedy_limit(robots, most, items) {
        Some(afforded) if !args.no_greedy => {
            let cure = match afforded {
                0 => String::new(),
                afforded => format!("; --replicates {afforded} includes it"),
            };
            Err(format!(
                "greedy GT (game theory) is left out: trying {}^{robots} assignments on every \
                 pattern would take minutes{cure}",
                RULES.len()
            ))
        }
        _ => Ok(()),
    })
}

/// The index of the method that the others are compared against.
fn reference(args: &CompareArgs, greedy: bool, texts: &[String]) -> Result<usize> {
    let mut ids = vec!["robust_gt"];
    if greedy {
        ids.push("greedy_gt");
    }
    ids.extend(texts.iter().map(String::as_str));
    let place = ids.iter().position(|id| *id == args.reference);
    place.ok_or_else(|| {
        Error::input(
            "--reference",
            format!(
                "`{}` is not one of the compared methods",
                shown(&args.reference)
            ),
            known_names(&args.reference, &ids),
        )
    })
}
