//! `pickline sweep`.

use super::args::SweepArgs;
use super::outputs::Outputs;
use super::progress::Bar;
use super::session::Session;
use super::settings::{DEFAULT_GRID, condition_notes, json, parse_strategy};
use super::training::{Line, Robust};
use super::warnings::warn;
use super::{pictures, sweep_values};
use crate::error::{Error, Result};
use crate::experiment::{Axis, Method, Setting, sweep};
use crate::optimize::Environment;
use crate::pattern::{PatternSource, Recipe};
use crate::planning::Allowance;
use crate::report::{Provenance, SWEEP_CHARTS, SweepReport, sweep_page};
use crate::station::Station;
use crate::strategies::{Parsed, policy_file};

/// What is written into the folder for result files.
const FILES: [&str; 2] = ["sweep.csv", "sweep.json"];

pub fn run(args: &SweepArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    args.common.check()?;
    let chart = pictures::checked(&args.pictures, SWEEP_CHARTS)?;
    let conditions = args.conditions.resolve(&args.common)?;
    let axis = Axis::named(&args.sweep)?;
    let station = args.station.load()?;
    let lines = sweep_values::lines(args, axis, &station)?;
    let parse = |text: &String| parse_strategy(text, args.common.quiet);
    let strategies = args.strategy.iter().map(parse);
    let strategies: Vec<Parsed> = strategies.collect::<Result<_>>()?;
    for strategy in &strategies {
        for (_, line) in &lines {
            strategy.alone(line.robots().len())?;
        }
    }
    let (source, shape) = args.feed.source(&args.patterns)?;
    if matches!(source, PatternSource::Files(_)) && args.items.is_some() {
        return Err(Error::input(
            "--items",
            "has no meaning for recorded patterns",
            "leave it out; recorded patterns hold their own items",
        ));
    }
    let patterns = source.files()?;
    let mut read = vec![args.station.file()];
    read.extend(patterns.iter().map(|file| ("--patterns", Some(&**file))));
    read.extend(args.strategy.iter().map(|s| ("--strategy", policy_file(s))));
    args.common
        .check_outputs("sweep", &FILES, &read, &args.pictures.files())?;
    let mut recipe = Recipe {
        belt: *station.belt(),
        items: source.items(args.items, DEFAULT_GRID.1),
        shape,
        attributes: Default::default(),
        // Another seed than the training set's.
        seed: args.common.seed.wrapping_add(1),
    };
    let mut set = source.build(&recipe)?;
    let generated = !matches!(source, PatternSource::Files(_));
    let usual = args.items.is_none() && recipe.items == DEFAULT_GRID.1;
    if generated && usual && axis != Axis::Speed {
        // These are judged by what they pick in the steady state.
        recipe.items = sweep_values::items(&lines, &set.patterns, recipe.items)?;
        set = source.build(&recipe)?;
    }
    args.station.check_set(&set)?;
    args.conditions.check_on(&args.station, &station)?;
    // The ends of the range; what lies between them is no worse.
    if let [(_, first), .., (value, last)] = &lines[..] {
        let place = format!("--sweep {} at {value}", axis.name());
        let ends = [last, first].map(|line| line.warnings(&place));
        let known = station.warnings(&place);
        let new = ends.into_iter().find(|w| !w.is_empty() && *w != known);
        warn(args.station.strict, new.unwrap_or_default())?;
    }
    if chart.name == "limits" && (axis.helps() || set.patterns.len() < 2) {
        return Err(chart.missing());
    }
    args.common.remark(&format!(
        "sweeping {} on station {}, on {}",
        axis.name(),
        args.station.station,
        set.description
    ));
    let bar = Bar::new(args.common.quiet);
    let environment = Environment {
        stop: session.stop(),
        progress: &bar,
    };
    let report = args.common.on_threads(|| {
        let luck = conditions.with_seed(recipe.seed);
        let trained = |lines| settings(args, &strategies, axis, &station, lines, &environment);
        let settings = match axis {
            Axis::Speed => {
                let own = trained(vec![(station.belt().speed, station.clone())])?;
                sweep_values::speeds(args, &own[0], &set.patterns, &luck, &environment)?
            }
            _ => trained(lines)?,
        };
        let result = sweep(
            &settings,
            &set.patterns,
            &luck,
            !args.no_bound,
            &environment,
        )?;
        let ids: Vec<String> = settings[0]
            .methods
            .iter()
            .map(|m| m.id().to_owned())
            .collect();
        let papers_case = axis == Axis::Speed
            && source == PatternSource::Grid(DEFAULT_GRID.0)
            && recipe.items == DEFAULT_GRID.1
            && station.robots().len() == 2;
        let made = Provenance::new(
            &session.command(),
            &args.station.station,
            &station,
            &set.description,
            args.common.seed,
        )
        .under(&conditions)
        .of_parts(result.values.len(), result.planned, "values");
        let notes = [
            notes(args, axis),
            condition_notes(&conditions, &args.training, generated),
        ]
        .concat();
        Ok(SweepReport::new(
            &result,
            axis,
            &ids,
            papers_case,
            notes,
            made,
        ))
    })?;
    let mut outputs = Outputs::default();
    let (common, whole) = (&args.common, json(&report)?);
    outputs.add_out(common, FILES[0], || report.to_csv());
    outputs.add_out(common, FILES[1], || whole);
    let page = || sweep_page(&report);
    let drawn = args
        .pictures
        .draw(&mut outputs, chart, &report, &report.made, page);
    let text = common.render(|| report.to_table(), || report.to_csv(), &report)?;
    outputs.deliver(session, &text).and(drawn)
}

/// The methods at every value. Robust GT is found once for a belt speed sweep, at the
/// station's own speed, and for every line of the other sweeps, as each is another line.
fn settings(
    args: &SweepArgs,
    strategies: &[Parsed],
    axis: Axis,
    station: &Station,
    lines: Vec<(f64, Station)>,
    environment: &Environment,
) -> Result<Vec<Setting>> {
    let once = match axis {
        Axis::Speed => Some(Line::new(&args.common, station, environment).robust(&args.training)?),
        _ => None,
    };
    let setting = |(value, station): (f64, Station)| {
        let line = Line::new(&args.common, &station, environment);
        let own;
        let robust: &Robust = match &once {
            Some(robust) => robust,
            None => {
                own = line.robust(&args.training)?;
                &own
            }
        };
        let mut methods = vec![Method::Robust(robust.rules.clone())];
        if args.greedy {
            methods.push(Method::greedy(station.robots().len())?);
        }
        for strategy in strategies {
            let blueprint = line.put(strategy, &robust.best_few, Allowance::default())?;
            methods.push(Method::Strategy(blueprint));
        }
        Ok(Setting {
            value,
            station,
            methods,
        })
    };
    lines.into_iter().map(setting).collect()
}

fn notes(args: &SweepArgs, axis: Axis) -> Vec<String> {
    let trained = match (&args.training.robust, axis) {
        (Some(_), _) => "robust GT as given (--robust)".to_owned(),
        (None, Axis::Speed) => format!(
            "robust GT is the best on the balanced set of {} items a pattern at the station's \
             own belt speed, seed {}",
            args.training.train_items, args.common.seed
        ),
        (None, _) => format!(
            "robust GT is found for every line on the balanced set of {} items a pattern, seed {}",
            args.training.train_items, args.common.seed
        ),
    };
    vec![trained]
}
