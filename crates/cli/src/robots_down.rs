//! `pickline sweep --sweep robots-down`.

use super::args::{Common, Pictures, StationChoice, SweepArgs};
use super::flags;
use super::outputs::WHOLE;
use super::pictures;
use super::progress::Bar;
use super::session::Session;
use super::settings::parse_strategy;
use super::shards;
use pickline::error::{Error, Result};
use pickline::experiment::ROBOTS_DOWN;
use pickline::optimize::Environment;
use pickline::sim::Conditions;
use pickline::station::Station;
use pickline::study::{RobotsDownOptions, RobotsDownStudy, ScoredPatterns};
use pickline_report::{ChartKind, Provenance, RobotsDownReport};

/// A resolved call.
pub(super) struct RobotsDownPlan {
    common: Common,
    choice: StationChoice,
    pictures: Pictures,
    chart: &'static ChartKind<RobotsDownReport>,
    station: Station,
    conditions: Conditions,
    options: RobotsDownOptions,
}

impl SweepArgs {
    /// The sweep over halted robots; the value of `--sweep` is known to be that.
    pub(super) fn resolve_robots_down(self) -> Result<RobotsDownPlan> {
        self.common.check()?;
        let chart = pictures::checked::<RobotsDownReport>(&self.pictures)?;
        self.check_flags()?;
        let conditions = self.conditions.resolve(&self.common)?;
        let conditions = self.outages.added_to(conditions)?;
        let remark = |text: &str| self.common.remark(text);
        let (station, saved) = self.station.load_with_strategy(&remark)?;
        let saved = saved.filter(|saved| !self.strategy.contains(saved));
        let patterns = self
            .feed
            .patterns(&self.patterns, self.items, &self.station)?
            .with_attributes(self.attributes.resolve()?);
        self.check_files::<RobotsDownReport>(&patterns, saved.as_deref())?;
        self.station.check_conditions(&conditions, &station)?;
        let options = self.robots_down_options(patterns, saved, &conditions, &station)?;
        Ok(RobotsDownPlan {
            common: self.common,
            choice: self.station,
            pictures: self.pictures,
            chart,
            station,
            conditions,
            options,
        })
    }

    /// Refuses the ends and the step of a range, as robots are halted one by one, and what asks for
    /// the purity of bins, which is not reported.
    fn check_flags(&self) -> Result<()> {
        let halted = format!("--sweep {ROBOTS_DOWN}");
        shards::refuse(&self.shards, &halted, "which is not split")?;
        let given = [
            ("--from", self.from.is_some()),
            ("--to", self.to.is_some()),
            ("--step", self.step.is_some()),
            ("--purity", self.purity.is_some()),
            ("--misdetections", self.detections.misdetections),
        ];
        let given = given.iter().find(|(_, is_given)| *is_given);
        given.map_or(Ok(()), |(flag, _)| {
            Err(Error::usage(
                *flag,
                format!(
                    "does not apply to --sweep {ROBOTS_DOWN}, which only halts every robot in turn"
                ),
                "leave it out",
            ))
        })
    }

    fn robots_down_options(
        &self,
        patterns: ScoredPatterns,
        saved: Option<String>,
        conditions: &Conditions,
        station: &Station,
    ) -> Result<RobotsDownOptions> {
        let (seed, quiet) = (self.common.seed, self.common.quiet);
        let saved = saved.map(|saved| parse_strategy(&saved, quiet));
        let options = RobotsDownOptions::default()
            .with_scored_patterns(patterns)
            .with_seed(seed)
            .with_conditions(conditions.clone())
            .with_station_strategy(saved.transpose()?)
            .with_training(self.training.resolve(station, seed, false)?)
            .with_greedy(self.greedy)
            .with_tune(self.tune);
        self.strategy.iter().try_fold(options, |options, text| {
            Ok(options.with_strategy(parse_strategy(text, quiet)?))
        })
    }
}

impl RobotsDownPlan {
    pub(super) fn run(&self, session: &Session) -> Result<()> {
        let study = RobotsDownStudy::new(&self.station, &self.options)?;
        let set = study.set();
        self.choice.check_set(set, &self.station)?;
        self.common.remark(&format!(
            "halting each robot of station {} in turn, on {}",
            self.choice.station, set.description
        ));
        let report = self.report(&study, session)?;
        let drawn = self.pictures.draw(self.chart, &report, &WHOLE);
        self.common.deliver(session, &report, &WHOLE, drawn)
    }

    fn report(&self, study: &RobotsDownStudy, session: &Session) -> Result<RobotsDownReport> {
        let bar = Bar::new(self.common.quiet);
        let environment = Environment {
            stop: session.stop(),
            progress: &bar,
            ..Environment::QUIET
        };
        let found = self.common.on_threads(|| study.run(&environment))?;
        let (command, scored) = (session.command(), &study.set().description);
        let (name, seed) = (&self.choice.station, self.common.seed);
        let halted = &found.robots_down;
        let made = Provenance::new(&command, name, &self.station, scored, seed)
            .under(&self.conditions)
            .of_parts(halted.halted.len(), halted.planned, "robots");
        Ok(RobotsDownReport::new(
            halted,
            flags::in_notes(&found.notes),
            made,
        ))
    }
}
