//! `pickline bound`.

use super::args::{BoundArgs, Common, ObjectiveArg, StationChoice};
use super::flags;
use super::outputs::{Outputs, WHOLE};
use super::progress::Bar;
use super::session::Session;
use super::settings::load_pattern;
use pickline::error::Result;
use pickline::optimize::Environment;
use pickline::pattern::Pattern;
use pickline::plausible::SLOT;
use pickline::sim::Conditions;
use pickline::station::Station;
use pickline::study::{BoundStudy, BoundStudyOptions};
use pickline_report::{BoundReport, Provenance};
use std::path::Path;

pub(crate) fn run(args: BoundArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    args.resolve()?.run(session)
}

/// A resolved call.
struct BoundPlan {
    common: Common,
    choice: StationChoice,
    station: Station,
    pattern: Pattern,
    /// What the pattern is called in results.
    pattern_name: String,
    /// What the pattern is called in errors.
    pattern_place: String,
    conditions: Conditions,
    options: BoundStudyOptions,
}

impl BoundArgs {
    fn resolve(self) -> Result<BoundPlan> {
        let common = &self.common;
        common.check()?;
        let mut options = BoundStudyOptions::default()
            .with_seed(common.seed)
            .with_weight(self.objective == ObjectiveArg::Weight)
            .with_iterations(self.iterations);
        options.check()?;
        let file = self.pattern.as_deref();
        let read = [self.station.file(), ("--pattern", file.map(Path::new))];
        common.check_outputs::<BoundReport>("bound", &read, &[])?;
        let conditions = self.conditions.resolve(common)?;
        options = options.with_conditions(conditions.clone());
        let station = self.station.load()?;
        self.station.check_conditions(&conditions, &station)?;
        let (pattern, pattern_name) = load_pattern(file, station.belt().width)?;
        let pattern_place = file.unwrap_or(&pattern_name).to_owned();
        self.station
            .check_pattern(&pattern_place, &pattern, Some(&station))?;
        self.station.check_values(&[("--slot", &SLOT, self.slot)])?;
        if let Some(slot) = self.slot {
            options = options.with_slot(slot);
        }
        if file.is_none() {
            let name = &self.station.station;
            common.remark(&format!("bounding {pattern_name}, station {name}"));
        }
        Ok(BoundPlan {
            common: self.common,
            choice: self.station,
            station,
            pattern,
            pattern_name,
            pattern_place,
            conditions,
            options,
        })
    }
}

impl BoundPlan {
    fn run(&self, session: &Session) -> Result<()> {
        let study = BoundStudy::new(&self.station, &self.pattern, &self.options);
        let study = study.map_err(|error| error.inside(&self.pattern_place))?;
        for note in study.notes() {
            self.common.remark(&flags::in_note(&note));
        }
        let bar = Bar::new(self.common.quiet);
        let environment = Environment {
            stop: session.stop(),
            progress: &bar,
            ..Environment::QUIET
        };
        let found = study.run(&environment)?;
        let made = Provenance::new(
            &session.command(),
            &self.choice.station,
            &self.station,
            &self.pattern_name,
            self.common.seed,
        )
        .under(&self.conditions);
        let report = BoundReport::of_study(&found, study.scene(), &WHOLE, made);
        self.common
            .deliver(session, &report, &WHOLE, Outputs::default())
    }
}
