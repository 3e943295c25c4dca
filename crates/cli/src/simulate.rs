//! `pickline simulate`.

use super::args::{Common, SimulateArgs, StationChoice};
use super::flags;
use super::outputs::{Outputs, WHOLE};
use super::progress::Bar;
use super::session::Session;
use super::settings::{budget, default_strategy, load_pattern, parse_strategy};
use pickline::error::Result;
use pickline::optimize::Environment;
use pickline::pattern::Pattern;
use pickline::planning::Allowance;
use pickline::plausible::DECISION_TIME;
use pickline::sim::Conditions;
use pickline::station::Station;
use pickline::strategies::{Blueprint, StrategySpec, policy_file};
use pickline::study::{SimulateOptions, SimulateStudy, SimulatedRun, blueprint, policy_distance};
use pickline_report::{
    CertifiedReport, ClearanceReport, Provenance, RunReport, check_replay, replay_page,
};
use std::path::{Path, PathBuf};

pub(crate) fn run(args: SimulateArgs, session: &Session) -> Result<()> {
    args.resolve()?.run(session)
}

/// A resolved call.
struct SimulatePlan {
    common: Common,
    choice: StationChoice,
    station: Station,
    pattern: Pattern,
    /// What the pattern is called in remarks.
    pattern_name: String,
    /// What the pattern is called in errors.
    pattern_place: String,
    strategy: StrategySpec,
    /// Where the strategy comes from, if it is a default.
    from: &'static str,
    /// Whether the line or the strategy is a default, which gives a note.
    has_defaults: bool,
    conditions: Conditions,
    options: SimulateOptions,
    check: bool,
    trace: Option<PathBuf>,
    html: Option<PathBuf>,
}

impl SimulateArgs {
    fn resolve(self) -> Result<SimulatePlan> {
        let common = &self.common;
        common.check()?;
        let conditions = self.conditions.resolve(common)?;
        let conditions = self.detections.add_to(conditions);
        let conditions = self.outages.added_to(conditions)?;
        self.check_files()?;
        let allowance = Allowance::default().with_asked(budget(self.budget_ms)?);
        let (station, saved) = self
            .station
            .load_with_strategy(&|text| common.remark(text))?;
        let (pattern, pattern_name) = load_pattern(self.pattern.as_deref(), station.belt().width)?;
        let pattern_place = self.pattern.clone().unwrap_or_else(|| pattern_name.clone());
        conditions.check_on(&station)?;
        self.station.check_conditions(&conditions, &station)?;
        let values = [("--budget-ms", &DECISION_TIME, self.budget_ms)];
        self.station.check_values(&values)?;
        self.station
            .check_pattern(&pattern_place, &pattern, Some(&station))?;
        if self.html.is_some() {
            check_replay(&pattern).map_err(|error| error.at("--html"))?;
        }
        let has_defaults = self.pattern.is_none() || self.strategy.is_none();
        let (text, from) = match self.strategy {
            Some(text) => (text, ""),
            None => default_strategy(saved, station.robots().len()),
        };
        let options = SimulateOptions::default()
            .with_seed(common.seed)
            .with_conditions(conditions.clone())
            .with_allowance(allowance)
            .with_trace(self.trace.is_some())
            .with_check(self.check)
            .with_clearance(self.check || self.html.is_some())
            .with_bound(!self.no_bound);
        Ok(SimulatePlan {
            strategy: parse_strategy(&text, common.quiet)?,
            common: self.common,
            choice: self.station,
            station,
            pattern,
            pattern_name,
            pattern_place,
            from,
            has_defaults,
            conditions,
            options,
            check: self.check,
            trace: self.trace,
            html: self.html,
        })
    }

    /// Checks that what is written is not also read.
    fn check_files(&self) -> Result<()> {
        let read = [
            self.station.file(),
            ("--pattern", self.pattern.as_deref().map(Path::new)),
            ("--strategy", self.strategy.as_deref().and_then(policy_file)),
        ];
        let written = [
            ("--trace", self.trace.as_deref()),
            ("--html", self.html.as_deref()),
        ];
        self.common
            .check_outputs::<RunReport>("simulate", &read, &written)
    }
}

impl SimulatePlan {
    fn run(&self, session: &Session) -> Result<()> {
        let bar = Bar::before_a_line(self.common.quiet);
        let environment = Environment {
            stop: session.stop(),
            progress: &bar,
            ..Environment::QUIET
        };
        let blueprint = self.put_strategy(&environment)?;
        let (station, pattern) = (&self.station, &self.pattern);
        let study = SimulateStudy::new(station, pattern, &self.options);
        let study = study.map_err(|error| error.inside(&self.pattern_place))?;
        for note in study.notes() {
            self.common.remark(&flags::in_note(&note));
        }
        let run = study.run(&blueprint, &environment)?;
        self.deliver(&study, &run, session)
    }

    /// The strategy on the line, with a remark if the line is far from a policy's training.
    fn put_strategy(&self, environment: &Environment) -> Result<Blueprint> {
        let put = || {
            let options = self.options.blueprint();
            blueprint(&self.strategy, &self.station, &options, environment)
        };
        let blueprint = self.common.on_threads(put)?;
        if let Some(distance) = policy_distance(&blueprint, &self.station) {
            self.common.remark(&distance.to_string());
        }
        if self.has_defaults {
            self.common.remark(&format!(
                "simulating {}{} on {}, station {}",
                blueprint.make().name(),
                self.from,
                self.pattern_name,
                self.choice.station
            ));
        }
        Ok(blueprint)
    }

    /// Prints and writes the report of a run.
    fn deliver(&self, study: &SimulateStudy, run: &SimulatedRun, session: &Session) -> Result<()> {
        let (scene, outcome) = (study.scene(), &run.outcome);
        let made = Provenance::new(
            &session.command(),
            &self.choice.station,
            &self.station,
            &self.pattern_name,
            self.common.seed,
        )
        .under(&self.conditions);
        let mut report = RunReport::new(run.strategy.clone(), scene, outcome, made);
        let clearance = run.clearance.as_ref();
        let clearance = clearance.map(|found| ClearanceReport::new(&self.station, found));
        if self.check {
            report.checked = Some(true);
            report.clearance.clone_from(&clearance);
        }
        let bound = run.bound.as_ref();
        report.bound = bound.map(|bound| CertifiedReport::new(&outcome.figures, bound));
        report.certify_classes(&run.class_bounds);
        let mut outputs = Outputs::default();
        if let Some(trace) = &run.trace {
            let origin = report.made.csv_comment();
            outputs.add(self.trace.as_deref(), || origin + &trace.to_csv());
        }
        outputs.add(self.html.as_deref(), || {
            replay_page(scene, &self.choice.title(), &report, clearance.as_ref())
        });
        self.common.deliver(session, &report, &WHOLE, outputs)
    }
}
