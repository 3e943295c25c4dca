//! `pickline optimize`.

use super::args::{OptimizeArgs, SearchArg};
use super::flags;
use super::outputs::WHOLE;
use super::pictures;
use super::progress::Bar;
use super::save::SaveTarget;
use super::session::Session;
use super::settings::parse_strategy;
use pickline::error::Result;
use pickline::optimize::{Environment, Grasp, Objective, Risk, SearchKind, SpeedScan, StopReason};
use pickline::pattern::PatternSet;
use pickline::plausible::SPEED_STEP;
use pickline::sim::Conditions;
use pickline::strategies::policy_file;
use pickline::study::{OptimizeOptions, OptimizeStudy, Optimized, ScoredPatterns};
use pickline_report::{OptimumReport, Presentation, Provenance, RivalsReport, ValidationReport};

pub fn run(args: &OptimizeArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    args.common.check()?;
    let chart = pictures::checked::<OptimumReport>(&args.pictures)?;
    let save = args.save.as_ref();
    let save = save.map(|file| SaveTarget::new(&args.station, file.as_deref()));
    let save = save.transpose()?;
    let conditions = args.conditions.resolve(&args.common)?;
    let station = args.station.load()?;
    args.conditions
        .check_on(&args.station, &args.common, &station)?;
    let patterns = args.set.resolve(&args.station)?;
    check_files(args, &patterns)?;
    let scan = SpeedScan::new(args.speed_step, &station)?;
    let objective = Objective::named(&args.objective, scan)?;
    let values = [("--speed-step", &SPEED_STEP, Some(args.speed_step))];
    args.station.check_values(&values)?;
    let options = options(args, patterns, conditions, scan, objective)?;
    let bar = Bar::new(args.common.quiet);
    let environment = Environment {
        stop: session.stop(),
        progress: &bar,
    };
    let report = args.common.on_threads(|| {
        let study = OptimizeStudy::new(&station, &options)?;
        args.station.check_set(study.set().drawn())?;
        let set = study.set().scored();
        args.common.remark(&format!(
            "optimizing {} for station {} ({} robots, belt at {} m/s)\non {}",
            objective.name(),
            args.station.station,
            station.robots().len(),
            station.belt().speed,
            set.description
        ));
        let optimized = study.run(&environment)?;
        let (name, seed) = (&args.station.station, args.common.seed);
        let command = session.command();
        let made = Provenance::new(&command, name, &station, &set.description, seed);
        Ok(report(&optimized, objective, set, made.under(&conditions)))
    })?;
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
            common.remark(&target.write(&station, &strategy)?);
        }
        None => {}
    }
    Ok(())
}

/// The settings of the search.
fn options(
    args: &OptimizeArgs,
    patterns: ScoredPatterns,
    conditions: Conditions,
    scan: SpeedScan,
    objective: Objective,
) -> Result<OptimizeOptions> {
    let mut options = OptimizeOptions::default()
        .with_seed(args.common.seed)
        .with_patterns(patterns)
        .with_conditions(conditions)
        .with_objective(objective)
        .with_scan(scan)
        .with_kind(match args.search {
            SearchArg::Auto => SearchKind::Auto,
            SearchArg::Exhaustive => SearchKind::Exhaustive,
            SearchArg::Grasp => SearchKind::Grasp,
            SearchArg::Both => SearchKind::Both,
        })
        .with_grasp(
            Grasp::default()
                .with_starts(args.starts)
                .with_alpha(args.alpha)
                .with_seed(args.common.seed),
        )
        .with_risk(args.risk.parse::<Risk>()?)
        .with_limits(args.limits.resolve()?)
        .with_bound(!args.no_bound);
    if let Some(fresh) = args.validate {
        options = options.with_validation(fresh);
    }
    args.strategy.iter().try_fold(options, |options, text| {
        Ok(options.with_strategy(parse_strategy(text, args.common.quiet)?))
    })
}

/// Checks that what is written is not also read.
fn check_files(args: &OptimizeArgs, patterns: &ScoredPatterns) -> Result<()> {
    let source = patterns.source();
    let files = source.files()?;
    let mut read = vec![args.station.file()];
    read.extend(files.iter().map(|file| ("--patterns", Some(&**file))));
    read.push(("--patterns", source.folder()));
    read.extend(args.strategy.iter().map(|s| ("--strategy", policy_file(s))));
    let saved = args.save.iter().flatten();
    let saved = saved.map(|file| ("--save", Some(file.as_path())));
    let written: Vec<_> = args.pictures.files().into_iter().chain(saved).collect();
    args.common
        .check_outputs::<OptimumReport>("optimize", &read, &written)
}

/// The report of a search on `set`.
fn report(
    optimized: &Optimized,
    objective: Objective,
    set: &PatternSet,
    made: Provenance,
) -> OptimumReport {
    let optimum = &optimized.optimum;
    let made = match optimum.stop {
        StopReason::Interrupted => made.of_parts(optimum.patterns, set.patterns.len(), "patterns"),
        _ => made,
    };
    let validation = optimized.validation.as_ref();
    let mut report = OptimumReport::new(
        optimum,
        &optimized.search,
        objective,
        &set.labels,
        validation.map(|(validation, on)| ValidationReport::new(validation, on)),
        flags::in_notes(&optimized.notes),
        made,
    );
    let best = optimum.ranking.best().assignment.names();
    report.beside = optimized.rivals.as_ref().map(|scored| {
        let names = scored.names.iter().map(String::as_str);
        RivalsReport::new(&scored.rivals, &best, names, &scored.patterns, scored.count)
    });
    report
}
