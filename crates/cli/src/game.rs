//! `pickline game`.

use super::args::{GameArgs, PayoffArg};
use super::flags;
use super::outputs::{Outputs, WHOLE};
use super::progress::Bar;
use super::session::Session;
use pickline::error::Result;
use pickline::optimize::Environment;
use pickline::optimize::game::{LineGame, PayoffKind, check_size};
use pickline::sim::Conditions;
use pickline::station::Station;
use pickline::study::{ScoredPatterns, set_notes};
use pickline_report::{GameReport, Presentation, Provenance};
use std::path::Path;

pub fn run(args: &GameArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    args.common.check()?;
    let conditions = args.conditions.resolve(&args.common)?;
    let station = args.station.load()?;
    args.conditions
        .check_on(&args.station, &args.common, &station)?;
    check_size(&station)?;
    let scored = args.set.resolve(&args.station)?;
    let source = scored.source();
    let nfg = [(
        "--nfg",
        args.nfg.as_deref().filter(|file| *file != Path::new("-")),
    )];
    let patterns = source.files()?;
    let mut read = vec![args.station.file()];
    read.extend(patterns.iter().map(|file| ("--patterns", Some(&**file))));
    read.push(("--patterns", source.folder()));
    args.common
        .check_outputs::<GameReport>("game", &read, &nfg)?;
    let solve = || report(args, session, &station, &scored, &conditions);
    let report = args.common.on_threads(solve)?;
    let mut outputs = Outputs::default();
    outputs.add(nfg[0].1, || report.nfg.clone());
    let shown = Presentation {
        top: args.top,
        ..WHOLE
    };
    match nfg[0].1 {
        // The output piped to Gambit must contain only the game.
        None if args.nfg.is_some() => {
            let game = &report.nfg;
            args.common.deliver_as(session, game, &report, outputs)
        }
        _ => args.common.deliver(session, &report, &shown, outputs),
    }
}

fn report(
    args: &GameArgs,
    session: &Session,
    station: &Station,
    patterns: &ScoredPatterns,
    conditions: &Conditions,
) -> Result<GameReport> {
    let payoff = match args.payoff {
        PayoffArg::Own => PayoffKind::Own,
        PayoffArg::Total => PayoffKind::Total,
    };
    let set = patterns.draw(station, args.common.seed, conditions);
    let set = set?;
    args.station.check_set(set.drawn())?;
    let set = set.scored();
    args.common.remark(&format!(
        "solving the game of station {} ({} robots, belt at {} m/s), payoff {}\non {}",
        args.station.station,
        station.robots().len(),
        station.belt().speed,
        payoff.name(),
        set.description
    ));
    let bar = Bar::new(args.common.quiet);
    let environment = Environment {
        stop: session.stop(),
        progress: &bar,
    };
    let line = LineGame::new(station, &set.patterns, payoff, conditions, &environment)?;
    let notes = set_notes(set, conditions, line.independent, line.patterns);
    let made = Provenance::new(
        &session.command(),
        &args.station.station,
        station,
        &set.description,
        args.common.seed,
    )
    .under(conditions)
    .of_parts(line.patterns, set.patterns.len(), "patterns");
    Ok(GameReport::new(
        &line,
        payoff,
        set.patterns.len(),
        flags::in_notes(&notes),
        made,
    ))
}
