//! `pickline sweep`.

use super::args::{Common, Pictures, StationChoice, SweepArgs};
use super::outputs::WHOLE;
use super::pictures;
use super::progress::Bar;
use super::session::Session;
use super::settings::parse_strategy;
use super::warnings::warn;
use pickline::error::Result;
use pickline::experiment::{Axis, ROBOTS_DOWN};
use pickline::optimize::Environment;
use pickline::sim::Conditions;
use pickline::station::Station;
use pickline::study::{ScoredPatterns, SweepOptions, SweepStudy};
use pickline_report::{ChartKind, Provenance, SweepReport};

pub(crate) fn run(args: SweepArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    match args.sweep == ROBOTS_DOWN {
        true => args.resolve_robots_down()?.run(session),
        false => args.resolve()?.run(session),
    }
}

/// A resolved call.
struct SweepPlan {
    common: Common,
    choice: StationChoice,
    pictures: Pictures,
    chart: &'static ChartKind<SweepReport>,
    station: Station,
    axis: Axis,
    conditions: Conditions,
    options: SweepOptions,
}

impl SweepArgs {
    fn resolve(self) -> Result<SweepPlan> {
        self.common.check()?;
        let axis = Axis::named(&self.sweep)?;
        let mut pictures = self.pictures.clone();
        if axis == Axis::MinDetection && pictures.chart.is_none() {
            pictures.chart = Some("purity".into());
        }
        let chart = pictures::checked::<SweepReport>(&pictures)?;
        let conditions = self.conditions.resolve(&self.common)?;
        let conditions = self.outages.added_to(conditions)?;
        let mut conditions = self.detections.add_to(conditions);
        // As the library does, for the provenance.
        conditions.disturbances.misdetections |= axis == Axis::MinDetection;
        let remark = |text: &str| self.common.remark(text);
        let (station, saved) = self.station.load_with_strategy(&remark)?;
        let saved = self.fitting(axis, saved);
        let patterns = self
            .feed
            .patterns(&self.patterns, self.items, &self.station)?
            .with_attributes(self.attributes.resolve()?);
        self.check_files::<SweepReport>(&patterns, saved.as_deref())?;
        let options = self.options(axis, patterns, saved, &conditions, &station)?;
        Ok(SweepPlan {
            common: self.common,
            choice: self.station,
            pictures,
            chart,
            station,
            axis,
            conditions,
            options,
        })
    }

    /// The strategy of the station file, unless it is given too or is for one number of robots.
    fn fitting(&self, axis: Axis, saved: Option<String>) -> Option<String> {
        let saved = saved.filter(|saved| !self.strategy.contains(saved))?;
        if axis == Axis::Robots {
            self.common.remark(&format!(
                "ignoring {saved}, the strategy of the station file: it is for one number of robots"
            ));
            return None;
        }
        Some(saved)
    }

    /// The settings of the sweep; `saved` is the strategy of the station file.
    fn options(
        &self,
        axis: Axis,
        patterns: ScoredPatterns,
        saved: Option<String>,
        conditions: &Conditions,
        station: &Station,
    ) -> Result<SweepOptions> {
        let (seed, quiet) = (self.common.seed, self.common.quiet);
        let saved = saved.map(|saved| parse_strategy(&saved, quiet));
        let choice = self.station.clone();
        let mut options = SweepOptions::default()
            .with_axis(axis)
            .with_robots(move |robots| choice.clone().with_robots(robots).resolve())
            .with_patterns(patterns)
            .with_seed(seed)
            .with_conditions(conditions.clone())
            .with_station_strategy(saved.transpose()?)
            .with_greedy(self.greedy)
            .with_tune(self.tune)
            .with_bound(!self.no_bound);
        if let Some(purity) = self.purity {
            options = options.with_purity(purity);
        }
        let training = &self.training;
        options = options.with_named_training(
            training.robust.as_deref(),
            training.train_patterns.as_deref(),
            training.train_items,
            (station, seed),
        )?;
        if let Some(from) = self.from {
            options = options.with_from(from);
        }
        if let Some(to) = self.to {
            options = options.with_to(to);
        }
        if let Some(step) = self.step {
            options = options.with_step(step);
        }
        self.strategy.iter().try_fold(options, |options, text| {
            Ok(options.with_strategy(parse_strategy(text, quiet)?))
        })
    }
}

impl SweepPlan {
    fn run(&self, session: &Session) -> Result<()> {
        let study = SweepStudy::new(&self.station, &self.options)?;
        let set = study.set();
        self.choice.check_set(set, &self.station)?;
        self.choice
            .check_conditions(&self.conditions, &self.station)?;
        self.check_ends(&study)?;
        if self.chart.name == "limits" && (self.axis.helps() || set.patterns.len() < 2) {
            return Err(pictures::missing(self.chart));
        }
        self.common.remark(&format!(
            "sweeping {} on station {}, on {}",
            self.axis.name(),
            self.choice.station,
            set.description
        ));
        let report = self.report(&study, session)?;
        let drawn = self.pictures.draw(self.chart, &report, &WHOLE);
        self.common.deliver(session, &report, &WHOLE, drawn)
    }

    fn report(&self, study: &SweepStudy, session: &Session) -> Result<SweepReport> {
        let bar = Bar::new(self.common.quiet);
        let environment = Environment {
            stop: session.stop(),
            progress: &bar,
            ledger: session.ledger(),
        };
        let swept = self.common.on_threads(|| study.run(&environment))?;
        let (command, scored) = (session.command(), &study.set().description);
        let (name, seed) = (&self.choice.station, self.common.seed);
        let made =
            Provenance::new(&command, name, &self.station, scored, seed).under(&self.conditions);
        let made = made.without(session.missing_shards());
        let with_paper = study.is_papers_case();
        Ok(SweepReport::of_study(
            &swept, self.axis, with_paper, &WHOLE, made,
        ))
    }

    /// Warns about implausible lines at the ends of the range; the values between them are no
    /// worse.
    fn check_ends(&self, study: &SweepStudy) -> Result<()> {
        let Some([first, last]) = study.ends() else {
            return Ok(());
        };
        let new = [last, first].into_iter().find_map(|(value, line)| {
            let place = format!("--sweep {} at {value}", self.axis.name());
            let warnings = line.warnings(&place);
            let is_new = !warnings.is_empty() && warnings != self.station.warnings(&place);
            is_new.then_some(warnings)
        });
        warn(self.choice.strict, new.unwrap_or_default())
    }
}
