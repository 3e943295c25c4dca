//! `pickline optimize`.

use super::args::{OptimizeArgs, SearchArg};
use super::outputs::WHOLE;
use super::pattern_set;
use super::pictures;
use super::progress::Bar;
use super::save::Target;
use super::session::Session;
use super::settings::{other_luck, parse_strategy};
use super::training::distance;
use pickline::error::Result;
use pickline::optimize::{
    Environment, Evaluator, Grasp, Objective, Optimum, Risk, Search, SearchKind, SpeedScan,
    StopReason, chosen_flow, optimize, rivals, validate,
};
use pickline::pattern::{PatternSet, PatternSource, Recipe};
use pickline::plausible::SPEED_STEP;
use pickline::sim::Conditions;
use pickline::station::Station;
use pickline::strategies::{Blueprint, policy_file};
use pickline_report::{OptimumReport, Presentation, Provenance, RivalsReport, ValidationReport};
use std::time::Instant;

/// Default number of fresh patterns on which the winner is scored.
const MOST_FRESH: usize = 1000;
/// Maximum number of items in all of them; if they have more, there are fewer patterns.
const ITEMS_OF_FRESH: f64 = 150_000.0;
/// Minimum default number of fresh patterns, however long they are.
const FEWEST_FRESH: usize = 10;
/// Maximum number of fresh patterns after the time limit.
const FRESH_IN_A_HURRY: usize = 24;

pub fn run(args: &OptimizeArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    args.common.check()?;
    let chart = pictures::checked::<OptimumReport>(&args.pictures)?;
    let save = args.save.as_ref();
    let save = save.map(|file| Target::new(&args.station, file.as_deref()));
    let save = save.transpose()?;
    let job = Job::new(args)?;
    let bar = Bar::new(args.common.quiet);
    let environment = Environment {
        stop: session.stop(),
        progress: &bar,
    };
    let report = args
        .common
        .on_threads(|| job.report(session, &environment))?;
    let shown = Presentation {
        top: args.top,
        ..WHOLE
    };
    let (common, drawn) = (&args.common, args.pictures.draw(chart, &report, &shown));
    common.deliver(session, &report, &shown, drawn)?;
    match save {
        Some(_) if session.interrupted() => {
            common.remark("nothing is saved because the search was interrupted");
        }
        Some(target) => {
            let strategy = format!("rules:{}", report.best.join(","));
            common.remark(&target.write(&job.station, &strategy)?);
        }
        None => {}
    }
    Ok(())
}

/// The resolved arguments.
struct Job<'a> {
    args: &'a OptimizeArgs,
    station: Station,
    source: PatternSource,
    recipe: Recipe,
    objective: Objective,
    search: Search,
    conditions: Conditions,
    strategies: Vec<Blueprint>,
    /// Number of fresh patterns to score the winner on.
    fresh: usize,
}

impl<'a> Job<'a> {
    fn new(args: &'a OptimizeArgs) -> Result<Self> {
        let conditions = args.conditions.resolve(&args.common)?;
        let station = args.station.load()?;
        args.conditions
            .check_on(&args.station, &args.common, &station)?;
        let (source, shape) = args.set.feed.source(&args.set.patterns, &args.station)?;
        let patterns = source.files()?;
        let mut read = vec![args.station.file()];
        read.extend(patterns.iter().map(|file| ("--patterns", Some(&**file))));
        read.push(("--patterns", source.folder()));
        read.extend(args.strategy.iter().map(|s| ("--strategy", policy_file(s))));
        let saved = args.save.iter().flatten();
        let saved = saved.map(|file| ("--save", Some(file.as_path())));
        let written: Vec<_> = args.pictures.files().into_iter().chain(saved).collect();
        args.common
            .check_outputs::<OptimumReport>("optimize", &read, &written)?;
        let seed = args.common.seed;
        let recipe = pattern_set::recipe(&args.set, seed, &source, shape, &station)?;
        let source = source.for_length(&args.set.patterns, &recipe, pattern_set::USUAL_SET)?;
        let fresh = match args.validate {
            Some(count) => count,
            // Fewer long patterns are as informative.
            None => {
                let afforded = ITEMS_OF_FRESH / source.expected_items(&recipe)?.max(1.0);
                (afforded as usize).clamp(FEWEST_FRESH, MOST_FRESH)
            }
        };
        source.check_fresh(&recipe, fresh)?;
        let scan = SpeedScan::new(args.speed_step, &station)?;
        let values = [("--speed-step", &SPEED_STEP, Some(args.speed_step))];
        args.station.check_values(&values)?;
        let robots = station.robots().len();
        let strategies = args
            .strategy
            .iter()
            .map(|text| parse_strategy(text, args.common.quiet)?.alone(robots));
        let grasp = Grasp {
            starts: args.starts,
            alpha: args.alpha,
            seed: args.common.seed,
        };
        Ok(Self {
            objective: Objective::named(&args.objective, scan)?,
            search: Search {
                kind: match args.search {
                    SearchArg::Auto => SearchKind::Auto,
                    SearchArg::Exhaustive => SearchKind::Exhaustive,
                    SearchArg::Grasp => SearchKind::Grasp,
                    SearchArg::Both => SearchKind::Both,
                },
                grasp: grasp.checked()?,
                risk: args.risk.parse::<Risk>()?,
                scan: Some(scan),
                limits: args.limits.resolve()?,
            },
            conditions,
            fresh,
            strategies: strategies.collect::<Result<_>>()?,
            args,
            station,
            source,
            recipe,
        })
    }

    fn report(&self, session: &Session, environment: &Environment) -> Result<OptimumReport> {
        let args = self.args;
        let set = pattern_set::build(&self.source, &self.recipe, &self.station)?;
        args.station.check_set(&set)?;
        let set = pattern_set::with_luck(set, &self.source, &self.conditions);
        args.common.remark(&format!(
            "optimizing {} for station {} ({} robots, belt at {} m/s)\non {}",
            self.objective.name(),
            args.station.station,
            self.station.robots().len(),
            self.station.belt().speed,
            set.description
        ));
        let evaluator = self.evaluator(&set, &self.conditions)?;
        let optimum = optimize(&evaluator, &self.search, environment)?;
        let until = self.search.limits.until;
        let short = until.is_some_and(|until| Instant::now() >= until);
        let count = match short {
            true => self.fresh.min(FRESH_IN_A_HURRY),
            false => self.fresh,
        };
        let fresh = self.fresh(count, environment)?;
        let luck = other_luck(&self.conditions);
        let on_fresh = fresh.as_ref().map(|fresh| self.evaluator(fresh, &luck));
        let on_fresh = on_fresh.transpose()?;
        let validation = match (&fresh, &on_fresh) {
            (Some(fresh), Some(on)) => {
                let certify = !short && !args.no_bound;
                self.validation(fresh, on, &optimum, certify, environment)?
            }
            _ => None,
        };
        let (judged, on) = (fresh.as_ref().unwrap_or(&set), on_fresh.as_ref());
        let beside = self.beside(judged, on.unwrap_or(&evaluator), &optimum, environment)?;
        let mut notes = self.notes(&set, &evaluator, &optimum);
        let unlike = |blueprint| distance(blueprint, &self.station).map(|found| found.text);
        notes.extend(self.strategies.iter().filter_map(unlike));
        if short {
            notes.push(format!(
                "--time-limit was reached: validated on at most {FRESH_IN_A_HURRY} fresh patterns, \
                 without a bound"
            ));
        }
        if environment.stopped() {
            notes.push(
                "interrupted: what is missing above (patterns, tie-breaking by max speed, \
                 validation, other strategies) was not done; run again for a reliable result"
                    .to_owned(),
            );
        } else if validation.is_none() && self.fresh > 0 {
            notes.push(format!(
                "no validation: cannot draw fresh patterns like {}",
                self.source
            ));
        }
        let mut made = Provenance::new(
            &session.command(),
            &args.station.station,
            &self.station,
            &set.description,
            args.common.seed,
        )
        .under(&self.conditions);
        if environment.stopped() {
            made = made.of_parts(optimum.patterns, set.patterns.len(), "patterns");
        }
        let mut report = OptimumReport::new(
            &optimum,
            &self.search,
            self.objective,
            &set.labels,
            validation,
            notes,
            made,
        );
        report.beside = beside;
        if environment.stopped() {
            // Even if the search was complete and only later work was interrupted.
            report.stop_reason = StopReason::Interrupted.name();
        }
        Ok(report)
    }

    /// Patterns that were not used in the search, drawn with the next seed.
    fn fresh(&self, count: usize, environment: &Environment) -> Result<Option<PatternSet>> {
        if count == 0 || environment.stopped() {
            return Ok(None);
        }
        let recipe = Recipe {
            seed: self.recipe.seed.wrapping_add(1),
            ..self.recipe
        };
        let fresh = self.source.draw_fresh(&recipe, count)?;
        if fresh.is_some() || !self.conditions.disturbances.any() {
            return Ok(fresh);
        }
        // The same patterns with different luck are also fresh.
        let set = pattern_set::build(&self.source, &self.recipe, &self.station)?;
        Ok(Some(pattern_set::with_draws(set, count)))
    }

    /// The evaluator that scores assignments and strategies on `set`.
    fn evaluator<'s>(
        &'s self,
        set: &'s PatternSet,
        conditions: &Conditions,
    ) -> Result<Evaluator<'s>> {
        Evaluator::new(&self.station, &set.patterns, self.objective, conditions)
    }

    /// Scores the winner on the `fresh` patterns of `evaluator`.
    fn validation(
        &self,
        fresh: &PatternSet,
        evaluator: &Evaluator,
        optimum: &Optimum,
        certify: bool,
        environment: &Environment,
    ) -> Result<Option<ValidationReport>> {
        let best = optimum.ranking.best();
        let flow = chosen_flow(self.objective, best);
        let validation = validate(
            evaluator,
            &best.assignment,
            flow,
            self.search.risk,
            &other_luck(&self.conditions),
            certify,
            environment,
        )?;
        Ok(validation.map(|v| ValidationReport::new(&v, &fresh.description)))
    }

    /// Scores the requested strategies and the winner on `set`, the patterns of `evaluator`.
    fn beside(
        &self,
        set: &PatternSet,
        evaluator: &Evaluator,
        optimum: &Optimum,
        environment: &Environment,
    ) -> Result<Option<RivalsReport>> {
        if self.strategies.is_empty() || environment.stopped() {
            return Ok(None);
        }
        let best = &optimum.ranking.best().assignment;
        let risk = self.search.risk;
        let rivals = rivals(evaluator, best, &self.strategies, risk, environment)?;
        Ok(rivals.map(|rivals| {
            let names = self.strategies.iter().map(Blueprint::name);
            let count = set.patterns.len();
            RivalsReport::new(&rivals, &best.names(), names, &set.description, count)
        }))
    }

    fn notes(&self, set: &PatternSet, evaluator: &Evaluator, optimum: &Optimum) -> Vec<String> {
        let count = evaluator.pattern_count();
        let independent = evaluator.independent_patterns();
        let mut notes = pattern_set::notes(set, &self.conditions, independent, count);
        let best = optimum.ranking.best();
        if matches!(self.objective, Objective::MaxSpeed(_)) {
            notes.push(match chosen_flow(self.objective, best) {
                Some(_) if optimum.patterns < evaluator.pattern_count() => {
                    "no flow is chosen: not all patterns were evaluated".to_owned()
                }
                Some(flow) => {
                    format!("chosen flow: {flow} m/s, the smallest speed limit of these patterns")
                }
                None => "no flow can be chosen: for some pattern no belt speed picks everything"
                    .to_owned(),
            });
        }
        notes
    }
}
