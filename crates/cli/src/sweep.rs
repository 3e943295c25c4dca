//! `pickline sweep`.

use super::args::SweepArgs;
use super::outputs::{FLAGS, WHOLE};
use super::pattern_set::USUAL_SET;
use super::progress::{Bar, Part};
use super::session::Session;
use super::settings::{DEFAULT_GRID, condition_notes, parse_strategy};
use super::training::{Judged, Line, Robust, distance};
use super::warnings::warn;
use super::{pictures, sweep_values};
use pickline::error::{Error, Result};
use pickline::experiment::{Axis, Method, Setting, sweep};
use pickline::optimize::Environment;
use pickline::pattern::{PatternSource, Recipe};
use pickline::planning::Allowance;
use pickline::sim::Conditions;
use pickline::station::Station;
use pickline::strategies::{Parsed, policy_file};
use pickline_report::{Provenance, SweepReport};

pub fn run(args: &SweepArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    args.common.check()?;
    let chart = pictures::checked::<SweepReport>(&args.pictures)?;
    let conditions = args.conditions.resolve(&args.common)?;
    let axis = Axis::named(&args.sweep)?;
    let remark = |text: &str| args.common.remark(text);
    let (station, saved) = args.station.load_with_strategy(&remark)?;
    let lines = sweep_values::lines(args, axis, &station)?;
    let mut texts = args.strategy.clone();
    let mut first_notes = Vec::new();
    match saved.filter(|saved| !texts.contains(saved)) {
        Some(saved) if axis == Axis::Robots => {
            remark(&format!(
                "ignoring {saved}, the strategy of the station file: it is for one number of robots"
            ));
        }
        Some(saved) => {
            first_notes.push(format!("{saved} is the strategy of the station file"));
            texts.insert(0, saved);
        }
        None => {}
    }
    let parse = |text: &String| parse_strategy(text, args.common.quiet);
    let strategies = texts.iter().map(parse);
    let strategies: Vec<Parsed> = strategies.collect::<Result<_>>()?;
    for strategy in &strategies {
        for (_, line) in &lines {
            strategy.alone(line.robots().len())?;
        }
    }
    let (source, shape) = args.feed.source(&args.patterns, &args.station)?;
    if matches!(source, PatternSource::Files(_)) && args.items.is_some() {
        return Err(Error::input(
            "--items",
            "does not apply to recorded patterns",
            "leave it out; recorded patterns have their own items",
        ));
    }
    let patterns = source.files()?;
    let mut read = vec![args.station.file()];
    read.extend(patterns.iter().map(|file| ("--patterns", Some(&**file))));
    read.push(("--patterns", source.folder()));
    read.extend(texts.iter().map(|s| ("--strategy", policy_file(s))));
    args.common
        .check_outputs::<SweepReport>("sweep", &read, &args.pictures.files())?;
    let mut recipe = Recipe {
        belt: *station.belt(),
        items: source.items(args.items, DEFAULT_GRID.1),
        shape,
        attributes: Default::default(),
        // A different seed from the training set's.
        seed: args.common.seed.wrapping_add(1),
    };
    let source = source.for_length(&args.patterns, &recipe, USUAL_SET)?;
    let mut set = source.build(&recipe)?;
    let generated = !matches!(source, PatternSource::Files(_));
    let usual = args.items.is_none() && recipe.items == DEFAULT_GRID.1;
    if generated && usual && axis != Axis::Speed {
        // These are scored by what they pick in the steady state.
        let items = sweep_values::items(&lines, &set.patterns, recipe.items)?;
        recipe.items = items;
        set = source.build(&recipe)?;
    }
    args.station.check_set(&set)?;
    args.conditions
        .check_on(&args.station, &args.common, &station)?;
    // Check the ends of the range; the values between them are no worse.
    if let [(_, first), .., (value, last)] = &lines[..] {
        let place = format!("--sweep {} at {value}", axis.name());
        let ends = [last, first].map(|line| line.warnings(&place));
        let known = station.warnings(&place);
        let new = ends.into_iter().find(|w| !w.is_empty() && *w != known);
        warn(args.station.strict, new.unwrap_or_default())?;
    }
    if chart.name == "limits" && (axis.helps() || set.patterns.len() < 2) {
        return Err(pictures::missing(chart));
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
    let papers_case = axis == Axis::Speed
        && source == PatternSource::Grid(DEFAULT_GRID.0)
        && recipe.items == DEFAULT_GRID.1
        && station.robots().len() == 2;
    let report = args.common.on_threads(|| {
        let training = Training {
            args,
            strategies: &strategies,
            source: &source,
            recipe: &recipe,
            conditions: &conditions,
            papers_case: papers_case && conditions.describe().is_empty(),
            environment: &environment,
        };
        let luck = conditions.with_seed(recipe.seed);
        let (settings, trained) = match axis {
            Axis::Speed => {
                let own = vec![(station.belt().speed, station.clone())];
                let (own, trained) = training.settings(axis, own)?;
                let patterns = &set.patterns;
                let settings = sweep_values::speeds(args, &own[0], patterns, &luck, &environment)?;
                (settings, trained)
            }
            _ => training.settings(axis, lines)?,
        };
        let distances = distances(&settings);
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
            vec![trained],
            first_notes,
            distances,
            condition_notes(&conditions, generated),
        ]
        .concat();
        Ok(SweepReport::new(
            &result,
            axis,
            &ids,
            papers_case,
            notes,
            &FLAGS,
            made,
        ))
    })?;
    let drawn = args.pictures.draw(chart, &report, &WHOLE);
    args.common.deliver(session, &report, &WHOLE, drawn)
}

/// For every policy, at how many values the line differs from its training, and how it differs
/// at the first of them.
fn distances(settings: &[Setting]) -> Vec<String> {
    let methods = settings.first().map_or(0, |setting| setting.methods.len());
    let of_method = |method: usize| {
        let found: Vec<(f64, String)> = settings
            .iter()
            .filter_map(|setting| match &setting.methods[method] {
                Method::Strategy(blueprint) => {
                    let found = distance(blueprint, &setting.station)?;
                    Some((setting.value, found.text))
                }
                _ => None,
            })
            .collect();
        let (value, text) = found.first()?;
        let (count, all) = (found.len(), settings.len());
        Some(format!(
            "at {count} of {all} values, first at {value}: {text}"
        ))
    };
    (0..methods).filter_map(of_method).collect()
}

/// The inputs for the methods of a sweep.
struct Training<'a> {
    args: &'a SweepArgs,
    strategies: &'a [Parsed],
    source: &'a PatternSource,
    recipe: &'a Recipe,
    conditions: &'a Conditions,
    /// Whether it is the paper's own sweep, whose results are shown next to ours.
    papers_case: bool,
    environment: &'a Environment<'a>,
}

impl Training<'_> {
    /// Robust GT (game theory) of one line.
    fn robust(&self, station: &Station, environment: &Environment) -> Result<Robust> {
        let (args, training) = (self.args, &self.args.training);
        let line = Line::new(&args.common, station, environment).under(self.conditions);
        line.robust(training, || {
            if self.papers_case {
                return Ok(Judged::AsInThePaper);
            }
            line.like(self.source, training, self.recipe)
        })
    }

    /// The methods on every line, and a note on where robust GT comes from; it is found for
    /// each line separately.
    fn settings(&self, axis: Axis, lines: Vec<(f64, Station)>) -> Result<(Vec<Setting>, String)> {
        let mut note = String::new();
        let count = lines.len();
        let setting = |(place, (value, station)): (usize, (f64, Station))| {
            let within = Part {
                whole: self.environment.progress,
                part: format!("{} {value} ({}/{count})", axis.name(), place + 1),
            };
            let environment = Environment {
                progress: &within,
                ..*self.environment
            };
            let robust = self.robust(&station, &environment)?;
            robust.note.clone_into(&mut note);
            let line = Line::new(&self.args.common, &station, &environment);
            let mut methods = vec![Method::Robust(robust.rules.clone())];
            if self.args.greedy {
                methods.push(Method::greedy(station.robots().len())?);
            }
            for strategy in self.strategies {
                let blueprint = line.put(strategy, &robust.best_few, Allowance::default())?;
                methods.push(Method::Strategy(blueprint));
            }
            Ok(Setting {
                value,
                station,
                methods,
            })
        };
        let settings: Result<Vec<Setting>> = lines.into_iter().enumerate().map(setting).collect();
        let settings = settings?;
        if self.args.training.robust.is_none() {
            note += match axis {
                Axis::Speed => ", found at the station's own belt speed",
                _ => ", found for every line",
            };
        }
        Ok((settings, note))
    }
}
