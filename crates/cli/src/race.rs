//! `pickline optimize --race`.

use super::args::{Common, OptimizeArgs, StationChoice};
use super::outputs::{Outputs, WHOLE};
use super::progress::Bar;
use super::save::SaveTarget;
use super::session::Session;
use super::shards;
use pickline::error::{Result, counted};
use pickline::optimize::{Environment, Objective, SpeedScan};
use pickline::plausible::SPEED_STEP;
use pickline::sim::Conditions;
use pickline::station::Station;
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
    station: Station,
    objective: Objective,
    conditions: Conditions,
    options: RaceOptions,
    /// Number of lines of the table.
    top: usize,
    save: Option<SaveTarget>,
}

impl OptimizeArgs {
    /// The race for differences from `delta` on.
    fn resolve_race(self, delta: f64) -> Result<RacePlan> {
        self.common.check()?;
        let why = "in which each batch of patterns depends on those before";
        shards::refuse(&self.shards, "--race", why)?;
        let save = self.save.as_ref();
        let save = save.map(|file| SaveTarget::new(&self.station, file.as_deref()));
        let save = save.transpose()?;
        let conditions = self.conditions.resolve(&self.common)?;
        let station = self.station.load()?;
        self.station.check_conditions(&conditions, &station)?;
        let patterns = self.set.resolve(&self.station)?;
        self.check_files::<RaceReport>(&patterns)?;
        let scan = SpeedScan::new(self.speed_step, &station)?;
        let objective = Objective::named(&self.objective, scan)?;
        let values = [("--speed-step", &SPEED_STEP, Some(self.speed_step))];
        self.station.check_values(&values)?;
        let mut options = RaceOptions::new(delta)
            .with_seed(self.common.seed)
            .with_patterns(patterns)
            .with_conditions(conditions.clone())
            .with_objective(objective)
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
            station,
            objective,
            conditions,
            options,
            top: self.top,
            save,
        })
    }
}

impl RacePlan {
    fn run(&self, session: &Session) -> Result<()> {
        let report = self.common.on_threads(|| self.report(session))?;
        let shown = WHOLE.with_top(self.top);
        self.common
            .deliver(session, &report, &shown, Outputs::default())?;
        if let Some(target) = &self.save {
            target.keep(&self.common, session, &self.station, &report.best)?;
        }
        Ok(())
    }

    fn report(&self, session: &Session) -> Result<RaceReport> {
        let study = RaceStudy::new(&self.station, &self.options)?;
        self.common.remark(&format!(
            "racing for {} on station {} ({}, belt at {} m/s)\non {}",
            self.objective.name(),
            self.choice.station,
            counted(self.station.robots().len(), "robot"),
            self.station.belt().speed,
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
        let made = Provenance::new(&command, name, &self.station, &raced.description, seed);
        let made = made.under(&self.conditions);
        Ok(RaceReport::new(&raced, self.objective, &WHOLE, made))
    }
}
