//! `pickline optimize`.

use super::args::{Common, OptimizeArgs, Pictures, SearchArg, StationChoice};
use super::outputs::WHOLE;
use super::pictures;
use super::progress::Bar;
use super::save::SaveTarget;
use super::session::Session;
use super::settings::parse_strategy;
use super::shards;
use pickline::error::{Result, counted};
use pickline::optimize::{Environment, Grasp, Objective, Risk, SearchKind, SpeedScan};
use pickline::plausible::SPEED_STEP;
use pickline::sim::Conditions;
use pickline::station::Station;
use pickline::strategies::policy_file;
use pickline::study::{OptimizeOptions, OptimizeStudy, ScoredPatterns};
use pickline_report::{ChartKind, OptimumReport, Provenance, VerbReport};

pub(crate) fn run(args: OptimizeArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    args.resolve()?.run(session)
}

/// A resolved call.
struct OptimizePlan {
    common: Common,
    choice: StationChoice,
    pictures: Pictures,
    chart: &'static ChartKind<OptimumReport>,
    line: ScoredLine,
    options: OptimizeOptions,
    /// Number of lines of the ranking in the table.
    top: usize,
}

/// A line with what its assignments are scored on.
pub(super) struct ScoredLine {
    pub(super) station: Station,
    pub(super) patterns: ScoredPatterns,
    pub(super) conditions: Conditions,
    pub(super) objective: Objective,
    /// The speeds that are tried for the largest belt speed.
    pub(super) scan: SpeedScan,
    /// Where the best assignment is saved.
    pub(super) save: Option<SaveTarget>,
}

impl OptimizeArgs {
    fn resolve(self) -> Result<OptimizePlan> {
        self.common.check()?;
        if self.limits.time_limit.is_some() {
            let why = "as the same time gives other results on other machines";
            shards::refuse(&self.shards, "--time-limit", why)?;
        }
        let chart = pictures::checked::<OptimumReport>(&self.pictures)?;
        let line = self.line::<OptimumReport>()?;
        let options = self.options(&line)?;
        Ok(OptimizePlan {
            common: self.common,
            choice: self.station,
            pictures: self.pictures,
            chart,
            line,
            options,
            top: self.top,
        })
    }

    /// What is optimised, and on what, by the search or by the race whose report is `R`.
    ///
    /// # Errors
    /// Settings, stations and patterns that are invalid or do not fit each other; files that would be read
    /// and written.
    pub(super) fn line<R: VerbReport>(&self) -> Result<ScoredLine> {
        let save = self.save.as_ref();
        let save = save.map(|file| SaveTarget::new(&self.station, file.as_deref()));
        let save = save.transpose()?;
        let conditions = self.conditions.resolve(&self.common)?;
        let station = self.station.load()?;
        self.station.check_conditions(&conditions, &station)?;
        let patterns = self.set.resolve(&self.station)?;
        self.check_files::<R>(&patterns)?;
        let scan = SpeedScan::new(self.speed_step, &station)?;
        let objective = Objective::named(&self.objective, scan)?;
        let values = [("--speed-step", &SPEED_STEP, Some(self.speed_step))];
        self.station.check_values(&values)?;
        Ok(ScoredLine {
            station,
            patterns,
            conditions,
            objective,
            scan,
            save,
        })
    }

    /// The settings of the search.
    fn options(&self, line: &ScoredLine) -> Result<OptimizeOptions> {
        let mut options = OptimizeOptions::default()
            .with_seed(self.common.seed)
            .with_patterns(line.patterns.clone())
            .with_conditions(line.conditions.clone())
            .with_objective(line.objective)
            .with_scan(line.scan)
            .with_kind(match self.search {
                SearchArg::Auto => SearchKind::Auto,
                SearchArg::Exhaustive => SearchKind::Exhaustive,
                SearchArg::Grasp => SearchKind::Grasp,
                SearchArg::Both => SearchKind::Both,
                SearchArg::Exact => SearchKind::Exact,
            })
            .with_grasp(
                Grasp::default()
                    .with_starts(self.starts)
                    .with_alpha(self.alpha)
                    .with_seed(self.common.seed),
            )
            .with_risk(self.risk.parse::<Risk>()?)
            .with_limits(self.limits.resolve()?)
            .with_bound(!self.no_bound);
        if let Some(fresh) = self.validate {
            options = options.with_validation(fresh);
        }
        self.strategy.iter().try_fold(options, |options, text| {
            Ok(options.with_strategy(parse_strategy(text, self.common.quiet)?))
        })
    }

    /// Checks that what is written is not also read.
    fn check_files<R: VerbReport>(&self, patterns: &ScoredPatterns) -> Result<()> {
        let source = patterns.source();
        let files = source.files()?;
        let mut read = vec![self.station.file()];
        read.extend(files.iter().map(|file| ("--patterns", Some(&**file))));
        read.push(("--patterns", source.folder()));
        read.extend(self.strategy.iter().map(|s| ("--strategy", policy_file(s))));
        let saved = self.save.iter().flatten();
        let saved = saved.map(|file| ("--save", Some(file.as_path())));
        let written: Vec<_> = self.pictures.files().into_iter().chain(saved).collect();
        self.common.check_outputs::<R>("optimize", &read, &written)
    }
}

impl OptimizePlan {
    fn run(&self, session: &Session) -> Result<()> {
        let report = self.common.on_threads(|| self.report(session))?;
        let shown = WHOLE.with_top(self.top);
        let drawn = self.pictures.draw(self.chart, &report, &shown);
        self.common.deliver(session, &report, &shown, drawn)?;
        if let Some(target) = &self.line.save {
            target.keep(&self.common, session, &self.line.station, &report.best)?;
        }
        Ok(())
    }

    fn report(&self, session: &Session) -> Result<OptimumReport> {
        let study = OptimizeStudy::new(&self.line.station, &self.options)?;
        self.choice
            .check_set(study.set().drawn(), &self.line.station)?;
        let set = study.set().scored();
        self.common.remark(&format!(
            "optimizing {} for station {} ({}, belt at {} m/s)\non {}",
            self.line.objective.name(),
            self.choice.station,
            counted(self.line.station.robots().len(), "robot"),
            self.line.station.belt().speed,
            set.description
        ));
        let bar = Bar::new(self.common.quiet);
        let environment = Environment {
            stop: session.stop(),
            progress: &bar,
            ledger: session.ledger(),
        };
        let optimized = study.run(&environment)?;
        let (command, seed) = (session.command(), self.common.seed);
        let (name, station) = (&self.choice.station, &self.line.station);
        let made = Provenance::new(&command, name, station, &set.description, seed);
        let made = made.under(&self.line.conditions);
        let made = made.without(session.missing_shards());
        Ok(OptimumReport::of_study(
            &optimized,
            self.line.objective,
            set,
            &WHOLE,
            made,
        ))
    }
}
