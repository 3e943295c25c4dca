//! `pickline game`.

use super::args::{GameArgs, PayoffArg};
use super::pattern_set;
use super::progress::Bar;
use super::session::Session;
use super::settings::json;
use crate::error::Result;
use crate::files;
use crate::optimize::Environment;
use crate::optimize::game::{LineGame, PayoffKind, check_size};
use crate::pattern::{PatternSource, Recipe};
use crate::report::{GameReport, Provenance};
use crate::station::Station;
use std::path::Path;

/// What is written into the folder for result files.
const FILES: [&str; 3] = ["game.json", "payoffs.csv", "game.nfg"];

pub fn run(args: &GameArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    args.common.check()?;
    files::check_target(args.nfg.as_deref())?;
    let station = args.station.load()?;
    check_size(&station)?;
    let (source, shape) = args.set.feed.source(&args.set.patterns)?;
    let nfg = [(
        "--nfg",
        args.nfg.as_deref().filter(|file| *file != Path::new("-")),
    )];
    pattern_set::check_apart(&args.common, &FILES, &args.station, &source, &nfg)?;
    let seed = args.common.seed;
    let recipe = pattern_set::recipe(&args.set, seed, &source, shape, &station)?;
    let solve = || report(args, session, &station, &source, &recipe);
    let report = args.common.on_threads(solve)?;
    args.common.write_out(FILES[0], &json(&report)?)?;
    args.common.write_out(FILES[1], &report.to_csv())?;
    args.common.write_out(FILES[2], &report.nfg)?;
    if let Some(file) = &args.nfg {
        session.print_or_write(Some(file), report.nfg.as_bytes())?;
        if file.as_path() == Path::new("-") {
            // What is piped to Gambit must be the game alone.
            return Ok(());
        }
    }
    let text = args
        .common
        .render(|| report.to_table(args.top), || report.to_csv(), &report)?;
    session.print(text.as_bytes())
}

fn report(
    args: &GameArgs,
    session: &Session,
    station: &Station,
    source: &PatternSource,
    recipe: &Recipe,
) -> Result<GameReport> {
    let payoff = match args.payoff {
        PayoffArg::Own => PayoffKind::Own,
        PayoffArg::Total => PayoffKind::Total,
    };
    let set = pattern_set::build(source, recipe, station)?;
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
    let hz = args.common.update_hz;
    let line = LineGame::new(station, &set.patterns, payoff, hz, &environment)?;
    let mut notes = pattern_set::notes(&set, line.independent, line.patterns);
    if line.patterns < set.patterns.len() {
        notes.push(format!(
            "interrupted: the game is over {} of {} patterns",
            line.patterns,
            set.patterns.len()
        ));
    }
    let made = Provenance::new(
        &session.command(),
        &args.station.station,
        station,
        &set.description,
        args.common.seed,
    );
    Ok(GameReport::new(
        &line,
        payoff,
        set.patterns.len(),
        notes,
        made,
    ))
}
