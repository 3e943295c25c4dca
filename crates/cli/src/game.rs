//! `pickline game`.

use super::args::{Common, GameArgs, PayoffArg, StationChoice};
use super::flags;
use super::outputs::{Outputs, WHOLE};
use super::progress::Bar;
use super::session::Session;
use pickline::error::{Result, counted};
use pickline::optimize::Environment;
use pickline::optimize::game::{PayoffKind, check_size};
use pickline::sim::Conditions;
use pickline::station::Station;
use pickline::study::{GameOptions, GameStudy};
use pickline_report::{GameReport, Provenance};
use std::path::{Path, PathBuf};

pub(crate) fn run(args: GameArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    args.resolve()?.run(session)
}

/// A resolved call.
struct GamePlan {
    common: Common,
    choice: StationChoice,
    station: Station,
    conditions: Conditions,
    payoff: PayoffKind,
    options: GameOptions,
    nfg: NfgTarget,
    /// Number of equilibria and cycles in the table.
    top: usize,
}

/// Where the game for Gambit goes.
enum NfgTarget {
    Nowhere,
    /// Printed instead of the result.
    Stdout,
    File(PathBuf),
}

impl NfgTarget {
    fn of(file: Option<PathBuf>) -> Self {
        match file {
            None => Self::Nowhere,
            Some(file) if file == Path::new("-") => Self::Stdout,
            Some(file) => Self::File(file),
        }
    }

    fn file(&self) -> Option<&Path> {
        match self {
            Self::File(file) => Some(file),
            Self::Nowhere | Self::Stdout => None,
        }
    }
}

impl GameArgs {
    fn resolve(self) -> Result<GamePlan> {
        let common = &self.common;
        common.check()?;
        let conditions = self.conditions.resolve(common)?;
        let station = self.station.load()?;
        self.station.check_conditions(&conditions, &station)?;
        check_size(&station)?;
        let patterns = self.set.resolve(&self.station)?;
        let nfg = NfgTarget::of(self.nfg);
        let source = patterns.source();
        let files = source.files()?;
        let mut read = vec![self.station.file()];
        read.extend(files.iter().map(|file| ("--patterns", Some(&**file))));
        read.push(("--patterns", source.folder()));
        common.check_outputs::<GameReport>("game", &read, &[("--nfg", nfg.file())])?;
        let payoff = match self.payoff {
            PayoffArg::Own => PayoffKind::Own,
            PayoffArg::Total => PayoffKind::Total,
        };
        let options = GameOptions::default()
            .with_seed(common.seed)
            .with_patterns(patterns)
            .with_conditions(conditions.clone())
            .with_payoff(payoff);
        Ok(GamePlan {
            common: self.common,
            choice: self.station,
            station,
            conditions,
            payoff,
            options,
            nfg,
            top: self.top,
        })
    }
}

impl GamePlan {
    fn run(&self, session: &Session) -> Result<()> {
        let report = self.common.on_threads(|| self.report(session))?;
        let mut outputs = Outputs::default();
        outputs.add(self.nfg.file(), || report.nfg.clone());
        let shown = WHOLE.with_top(self.top);
        match self.nfg {
            // The output piped to Gambit must contain only the game.
            NfgTarget::Stdout => {
                let game = &report.nfg;
                self.common.deliver_as(session, game, &report, outputs)
            }
            _ => self.common.deliver(session, &report, &shown, outputs),
        }
    }

    fn report(&self, session: &Session) -> Result<GameReport> {
        let study = GameStudy::new(&self.station, &self.options)?;
        self.choice.check_set(study.set().drawn(), &self.station)?;
        let set = study.set().scored();
        self.common.remark(&format!(
            "solving the game of station {} ({}, belt at {} m/s), payoff {}\non {}",
            self.choice.station,
            counted(self.station.robots().len(), "robot"),
            self.station.belt().speed,
            self.payoff.name(),
            set.description
        ));
        let bar = Bar::new(self.common.quiet);
        let environment = Environment {
            stop: session.stop(),
            progress: &bar,
            ..Environment::QUIET
        };
        let game = study.run(&environment)?;
        let made = Provenance::new(
            &session.command(),
            &self.choice.station,
            &self.station,
            &set.description,
            self.common.seed,
        )
        .under(&self.conditions)
        .of_parts(game.line.patterns, game.planned, "patterns");
        Ok(GameReport::new(
            &game.line,
            self.payoff,
            game.planned,
            flags::in_notes(&game.notes),
            made,
        ))
    }
}
