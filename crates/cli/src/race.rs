//! `pickline optimize --race`.

use super::args::{Common, OptimizeArgs, StationChoice};
use super::optimize::ScoredLine;
use super::outputs::{Outputs, WHOLE};
use super::progress::Bar;
use super::session::Session;
use super::shards;
use pickline::error::{Result, counted};
use pickline::optimize::Environment;
use pickline::study::{RaceOptions, RaceStudy};
use pickline_report::{Provenance, RaceReport};

pub(crate) fn run(args: OptimizeArgs, delta: f64, session: &Session) -> Result<()> {
    session.catch_interrupts();
    args.resolve_race(delta)?.run(session)
}

/// A resolved call.
struct RacePlan {
    common: Common,
    choice: StationChoice,
    line: ScoredLine,
    options: RaceOptions,
    /// Number of lines of the table.
    top: usize,
}

impl OptimizeArgs {
    /// The race for differences from `delta` on.
    fn resolve_race(self, delta: f64) -> Result<RacePlan> {
        self.common.check()?;
        let why = "in which each batch of patterns depends on those before";
        shards::refuse(&self.shards, "--race", why)?;
        let line = self.line::<RaceReport>()?;
        let mut options = RaceOptions::new(delta)
            .with_seed(self.common.seed)
            .with_patterns(line.patterns.clone())
            .with_conditions(line.conditions.clone())
            .with_objective(line.objective)
            .with_until(self.limits.resolve()?.until);
        if let Some(confidence) = self.race.confidence {
            options = options.with_confidence(confidence);
        }
        if let Some(most) = self.race.max_patterns {
            options = options.with_max_patterns(most);
        }
        Ok(RacePlan {
            common: self.common,
            choice: self.station,
            line,
            options,
            top: self.top,
        })
    }
}

impl RacePlan {
    fn run(&self, session: &Session) -> Result<()> {
        let report = self.common.on_threads(|| self.report(session))?;
        let shown = WHOLE.with_top(self.top);
        self.common
            .deliver(session, &report, &shown, Outputs::default())?;
        if let Some(target) = &self.line.save {
            target.keep(&self.common, session, &self.line.station, &report.best)?;
        }
        Ok(())
    }

    fn report(&self, session: &Session) -> Result<RaceReport> {
        let study = RaceStudy::new(&self.line.station, &self.options)?;
        self.common.remark(&format!(
            "racing for {} on station {} ({}, belt at {} m/s)\non {}",
            self.line.objective.name(),
            self.choice.station,
            counted(self.line.station.robots().len(), "robot"),
            self.line.station.belt().speed,
            study.description()
        ));
        let bar = Bar::new(self.common.quiet);
        let environment = Environment {
            stop: session.stop(),
            progress: &bar,
            ..Environment::QUIET
        };
        let raced = study.run(&environment)?;
        let (command, seed) = (session.command(), self.common.seed);
        let name = &self.choice.station;
        let made = Provenance::new(&command, name, &self.line.station, &raced.description, seed);
        let made = made.under(&self.line.conditions);
        Ok(RaceReport::new(&raced, self.line.objective, &WHOLE, made))
    }
}
