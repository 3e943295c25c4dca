//! The attempts of a run as CSV.

use super::report::RunReport;
use crate::csv_rows::{CsvRows, Displayed};
use serde::Serialize;

impl RunReport {
    /// The picks and failed attempts, one per line, in order of decision.
    pub(super) fn picks_csv(&self) -> CsvRows {
        let failures = self.failures.iter().map(|f| (&f.attempt, f.cause));
        let mut attempts: Vec<_> = self.picks.iter().map(|pick| (pick, "")).collect();
        attempts.extend(failures);
        attempts.sort_by(|(a, _), (b, _)| {
            let times = a.decide_s.total_cmp(&b.decide_s);
            times.then(a.robot.cmp(&b.robot))
        });
        let rows = attempts.into_iter().map(|(pick, failure)| AttemptRow {
            robot: &self.robots[pick.robot].name,
            item: &pick.item,
            decide_s: Displayed(pick.decide_s),
            grasp_s: Displayed(pick.grasp_s),
            release_s: Displayed(pick.release_s),
            bin: pick.bin.as_deref().unwrap_or_default(),
            meet_x_m: Displayed(pick.meet[0]),
            meet_y_m: Displayed(pick.meet[1]),
            failure,
        });
        let rows = CsvRows::of(rows);
        match self.robots.iter().all(|robot| robot.bins.is_empty()) {
            true => rows.without(&["bin"]),
            false => rows,
        }
    }
}

#[derive(Default, Serialize)]
struct AttemptRow<'r> {
    robot: &'r str,
    item: &'r str,
    decide_s: Displayed,
    grasp_s: Displayed,
    release_s: Displayed,
    /// Name of the bin; the column is left out if every robot has one bin for everything.
    bin: &'r str,
    meet_x_m: Displayed,
    meet_y_m: Displayed,
    /// Why the attempt failed; empty for a pick.
    failure: &'static str,
}
