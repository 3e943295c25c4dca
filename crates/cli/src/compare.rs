//! `pickline compare`.

use super::args::{Common, CompareArgs, Pictures, StationChoice};
use super::outputs::WHOLE;
use super::pictures;
use super::progress::Bar;
use super::session::Session;
use super::settings::parse_strategy;
use pickline::error::{Result, counted};
use pickline::experiment::{Case, CaseSource, load_cases, with_attributes};
use pickline::files;
use pickline::optimize::Environment;
use pickline::pattern;
use pickline::plausible::FLOW;
use pickline::sim::Conditions;
use pickline::station::Station;
use pickline::strategies::policy_file;
use pickline::study::{CompareOptions, CompareStudy};
use pickline_report::{ChartKind, ComparisonReport, Provenance};
use std::path::Path;

pub(crate) fn run(args: CompareArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    args.resolve()?.run(session)
}

/// A resolved call.
struct ComparePlan {
    common: Common,
    choice: StationChoice,
    pictures: Pictures,
    chart: &'static ChartKind<ComparisonReport>,
    station: Station,
    cases: Vec<Case>,
    /// The name of the cases, or their file.
    cases_name: String,
    /// Number of patterns per random case.
    replicates: usize,
    /// Whether the paper's results are printed, too.
    with_paper: bool,
    conditions: Conditions,
    options: CompareOptions,
}

impl CompareArgs {
    fn resolve(self) -> Result<ComparePlan> {
        self.common.check()?;
        let chart = pictures::checked::<ComparisonReport>(&self.pictures)?;
        let conditions = self.conditions.resolve(&self.common)?;
        let conditions = self.detections.add_to(conditions);
        let conditions = self.outages.added_to(conditions)?;
        let remark = |text: &str| self.common.remark(text);
        let (station, saved) = self.station.load_with_strategy(&remark)?;
        let attributes = self.attributes.resolve()?;
        let cases = with_attributes(load_cases(&self.cases)?, &attributes)?;
        conditions.check_on(&station)?;
        self.station.check_conditions(&conditions, &station)?;
        self.check_cases(&cases, &station)?;
        self.check_files(&cases)?;
        let options = self.options(&station, saved, &conditions)?;
        Ok(ComparePlan {
            common: self.common,
            choice: self.station,
            pictures: self.pictures,
            chart,
            station,
            cases,
            cases_name: self.cases,
            replicates: self.replicates,
            with_paper: self.paper,
            conditions,
            options,
        })
    }

    /// The settings of the comparison; `saved` is the strategy of the station file.
    fn options(
        &self,
        station: &Station,
        saved: Option<String>,
        conditions: &Conditions,
    ) -> Result<CompareOptions> {
        let (seed, quiet) = (self.common.seed, self.common.quiet);
        let saved = saved.filter(|saved| !self.strategy.contains(saved));
        let saved = saved.map(|saved| parse_strategy(&saved, quiet));
        let options = CompareOptions::default()
            .with_seed(seed)
            .with_replicates(self.replicates)
            .with_conditions(conditions.clone())
            .with_station_strategy(saved.transpose()?)
            .with_training(self.training.resolve(station, seed, self.paper)?)
            .with_greedy(!self.no_greedy)
            .with_policy(!self.no_policy)
            .with_bound(!self.no_bound)
            .with_tune(self.tune)
            .with_reference(&self.reference);
        self.strategy.iter().try_fold(options, |options, text| {
            Ok(options.with_strategy(parse_strategy(text, quiet)?))
        })
    }

    /// Warns about implausible values in the cases, and says what their files lack.
    fn check_cases(&self, cases: &[Case], station: &Station) -> Result<()> {
        for case in cases {
            // The patterns of a case are alike, so one is enough.
            let patterns = case.patterns(station.belt(), 1, self.common.seed)?;
            for (_, pattern) in &patterns {
                self.station
                    .check_pattern(&case.name, pattern, Some(station))?;
            }
            match &case.source {
                CaseSource::File(path) => {
                    let loaded = pattern::load(path)?;
                    if !loaded.ignored.is_empty() {
                        let (name, file) = (&case.name, path.display());
                        let about = loaded.describe();
                        self.common
                            .remark(&format!("case {name}: {file} ({about})"));
                    }
                }
                CaseSource::Feed(_, flow) => {
                    let place = format!("{}: case {}: flow", self.cases, case.name);
                    self.station.check_values(&[(&place, &FLOW, *flow)])?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Checks that what is written is not also read.
    fn check_files(&self, cases: &[Case]) -> Result<()> {
        let mut read = vec![
            self.station.file(),
            ("--cases", Some(Path::new(&self.cases))),
        ];
        read.extend(cases.iter().map(|case| ("--cases", case.file())));
        read.extend(self.strategy.iter().map(|s| ("--strategy", policy_file(s))));
        self.common
            .check_outputs::<ComparisonReport>("compare", &read, &self.pictures.files())
    }
}

impl ComparePlan {
    fn run(&self, session: &Session) -> Result<()> {
        let study = CompareStudy::new(&self.station, &self.cases, &self.options)?;
        // A single method has nothing to differ from.
        if self.chart.name == "difference" && study.methods() < 2 {
            return Err(pictures::missing(self.chart));
        }
        self.common.remark(&format!(
            "comparing on station {} ({}, belt at {} m/s), cases {}",
            self.choice.station,
            counted(self.station.robots().len(), "robot"),
            self.station.belt().speed,
            self.cases_name
        ));
        let report = self.report(&study, session)?;
        let drawn = self.pictures.draw(self.chart, &report, &WHOLE);
        self.common.deliver(session, &report, &WHOLE, drawn)
    }

    fn report(&self, study: &CompareStudy, session: &Session) -> Result<ComparisonReport> {
        let bar = Bar::new(self.common.quiet);
        let environment = Environment {
            stop: session.stop(),
            progress: &bar,
            ledger: session.ledger(),
        };
        let compared = self.common.on_threads(|| study.run(&environment))?;
        let scored = format!(
            "cases {}, random ones {} each under the seeds {} and up",
            identified(&self.cases_name)?,
            counted(self.replicates, "pattern"),
            study.first_seed()
        );
        let (command, seed) = (session.command(), self.common.seed);
        let made = Provenance::new(&command, &self.choice.station, &self.station, &scored, seed)
            .under(&self.conditions)
            .without(session.missing_shards());
        let paper_cases = matches!(self.cases_name.as_str(), "paper" | "all");
        let with_paper = self.with_paper && paper_cases;
        Ok(ComparisonReport::of_study(
            &compared,
            paper_cases,
            with_paper,
            &WHOLE,
            made,
        ))
    }
}

/// The name of the cases; a user's file is identified by its content, not by its name.
fn identified(cases: &str) -> Result<String> {
    match Path::new(cases) {
        file if file.is_file() => {
            let hash = files::fingerprint(&files::read_text(file)?);
            Ok(format!("{cases} (hash {hash})"))
        }
        _ => Ok(cases.to_owned()),
    }
}
