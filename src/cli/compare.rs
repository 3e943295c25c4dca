//! `pickline compare`.

use super::args::{CompareArgs, Format};
use super::progress::Bar;
use super::session::Session;
use super::settings::json;
use crate::dispatch::RuleAssignment;
use crate::error::{Error, Result};
use crate::experiment::{Method, compare, load_cases};
use crate::optimize::{
    Environment, Evaluator, Grasp, Objective, Risk, Search, SearchKind, SpeedScan, optimize,
};
use crate::pattern::{PatternSource, Recipe};
use crate::report::{ComparisonReport, Provenance};
use crate::station::Station;

/// More patterns than this a case are taken for a slip of the pen.
const MOST_REPLICATES: usize = 100_000;

pub fn run(args: &CompareArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    args.common.check()?;
    if !(1..=MOST_REPLICATES).contains(&args.replicates) {
        return Err(Error::input(
            "--replicates",
            format!("{} patterns a case", args.replicates),
            format!("give 1 to {MOST_REPLICATES}"),
        ));
    }
    let station = args.station.load()?;
    let robots = station.robots().len();
    let cases = load_cases(&args.cases)?;
    let mut others = Vec::new();
    if !args.no_greedy {
        others.push(Method::greedy(robots)?);
    }
    for text in &args.strategy {
        others.push(Method::strategy(text, robots)?);
    }
    args.common.remark(&format!(
        "comparing on station {} ({robots} robots, belt at {} m/s), cases {}",
        args.station.station,
        station.belt().speed,
        args.cases
    ));
    let bar = Bar::new(args.common.quiet);
    let environment = Environment {
        stop: session.stop(),
        progress: &bar,
    };
    // The training set has the master seed, the tables those after it.
    let first_seed = args.common.seed.wrapping_add(1);
    let report = args.common.on_threads(|| {
        let (robust, note) = robust(args, &station, &environment)?;
        let methods = std::iter::once(Method::Robust(robust))
            .chain(others)
            .collect();
        let comparison = compare(
            &station,
            methods,
            &cases,
            args.replicates,
            first_seed,
            args.update_hz,
            &environment,
        )?;
        let made = Provenance::new(
            &session.command(),
            &args.station.station,
            &station,
            &format!(
                "cases {}, random ones {} patterns each under the seeds {first_seed} and up",
                args.cases, args.replicates
            ),
            args.common.seed,
        );
        let paper_cases = matches!(args.cases.as_str(), "paper" | "all");
        let with_paper = args.paper && paper_cases;
        Ok(ComparisonReport::new(
            &comparison,
            paper_cases,
            with_paper,
            vec![note],
            made,
        ))
    })?;
    let text = match args.common.format {
        Format::Table => report.to_table(),
        Format::Json => json(&report)?,
        Format::Csv => report.picking_rate_csv(),
    };
    args.common
        .write_out("picked_time.csv", &report.picked_time_csv())?;
    args.common
        .write_out("picking_rate.csv", &report.picking_rate_csv())?;
    args.common.write_out("runs.csv", &report.runs_csv())?;
    args.common.write_out("compare.json", &json(&report)?)?;
    session.print(text.as_bytes())
}

/// The robust assignment and where it comes from: given, or optimised on the balanced
/// set.
fn robust(
    args: &CompareArgs,
    station: &Station,
    environment: &Environment,
) -> Result<(RuleAssignment, String)> {
    if let Some(text) = &args.robust {
        let rules = text
            .parse::<RuleAssignment>()
            .map_err(|e| e.at("--robust"))?;
        let rules = rules
            .for_robots(station.robots().len())
            .map_err(|e| e.at("--robust"))?;
        return Ok((rules, "robust GT as given (--robust)".into()));
    }
    let recipe = Recipe {
        width: station.belt().width,
        items: args.train_items,
        attributes: Default::default(),
        seed: args.common.seed,
    };
    let set = "balanced".parse::<PatternSource>()?.build(&recipe)?;
    let objective = Objective::PickingRate;
    let evaluator = Evaluator::new(station, &set.patterns, objective, args.update_hz)?;
    let search = Search {
        kind: SearchKind::Auto,
        grasp: Grasp {
            seed: args.common.seed,
            ..Grasp::default()
        },
        risk: Risk::Mean,
        scan: SpeedScan::default(),
    };
    let optimum = optimize(&evaluator, &search, environment)?;
    if environment.stopped() {
        return Err(Error::Interrupted);
    }
    let best = optimum.ranking.best().assignment.clone();
    let note = format!("robust GT is the best on {}", set.description);
    Ok((best, note))
}
