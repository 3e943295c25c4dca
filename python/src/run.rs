//! A simulated run, kept for the forms in which the program shows it.

use crate::report::{Forms, shown};
use pickline::clearance;
use pickline::decision::Outcome;
use pickline::experiment::ClassBound;
use pickline::planning::bound::Bound;
use pickline::sim::{Conditions, Scene};
use pickline_report::{
    CertifiedReport, ClearanceReport, Column, Provenance, RunReport, VerbReport, check_replay,
    json_text, replay_page,
};
use std::sync::Arc;

/// A run, of which every form is made when it is asked for.
pub(crate) struct Run {
    pub station: Arc<pickline::Station>,
    pub pattern: Arc<pickline::Pattern>,
    /// What the user calls the station.
    pub name: String,
    /// With the seed of the run.
    pub conditions: Conditions,
    pub strategy: String,
    pub outcome: Outcome,
    pub bound: Option<Bound>,
    pub class_bounds: Vec<ClassBound>,
    pub made: Provenance,
}

impl Run {
    /// Calls `with` with the scene and the report.
    fn shown<T>(
        &self,
        with: impl FnOnce(&Scene, &RunReport) -> pickline::Result<T>,
    ) -> pickline::Result<T> {
        let scene = Scene::under(&self.station, &self.pattern, self.conditions.clone())?;
        let made = self.made.clone();
        let mut report = RunReport::new(self.strategy.clone(), &scene, &self.outcome, made);
        report.checked = Some(true);
        let bound = self.bound.as_ref();
        report.bound = bound.map(|bound| CertifiedReport::new(&self.outcome.figures, bound));
        report.certify_classes(&self.class_bounds);
        with(&scene, &report)
    }
}

impl Forms for Run {
    fn text(&self) -> pickline::Result<String> {
        self.shown(|_, report| Ok(report.to_table(shown())))
    }

    fn csv(&self) -> pickline::Result<String> {
        self.shown(|_, report| Ok(report.to_csv()))
    }

    fn json(&self) -> pickline::Result<String> {
        self.shown(|_, report| json_text(report))
    }

    /// The page that replays the run, if it has not more items than a page can show.
    fn page(&self) -> pickline::Result<Option<String>> {
        if check_replay(&self.pattern).is_err() {
            return Ok(None);
        }
        self.shown(|scene, report| {
            let found = clearance::smallest(&self.station, &self.outcome);
            let found = found.map(|found| ClearanceReport::new(&self.station, &found));
            Ok(Some(replay_page(scene, &self.name, report, found.as_ref())))
        })
    }

    /// None: ``simulate`` hands over its tables itself.
    fn tables(&self) -> Vec<(&'static str, Vec<Column>)> {
        Vec::new()
    }
}
