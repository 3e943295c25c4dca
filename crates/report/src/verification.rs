//! What is wrong with the picks of a file.

use super::columns::TableColumns;
use super::csv_rows::{Column, CsvRows, Displayed, OptionalNumber};
use super::presentation::Presentation;
use super::provenance::Provenance;
use super::table::fixed;
use super::verb_report::{ResultFile, VerbReport};
use pickline::checker::{PicksFile, Terms, Violation, ViolationKind};
use pickline::error::{Error, counted, shown_number, significant};
use pickline::pattern::Pattern;
use pickline::station::Station;
use pickline::stats::quantile;
use serde::Serialize;
use std::collections::BTreeMap;

/// All that contradicts the model in a file of picks, as printed; the JSON field names are the
/// product's format.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct VerificationReport {
    /// Whether nothing contradicts the model.
    pub confirmed: bool,
    /// Number of items in the pattern.
    pub items: usize,
    /// Number of picks in the file.
    pub picks: usize,
    /// Number of failed attempts in the file.
    pub failures: usize,
    /// How far each time may be off [s].
    pub tolerance_s: f64,
    /// Everything that is wrong, in the order of the file.
    pub violations: Vec<ViolationReport>,
    /// Number of violations of each kind that occurs.
    pub violations_by_kind: BTreeMap<&'static str, usize>,
    /// Columns of the file that were ignored.
    pub ignored_columns: Vec<String>,
    /// Where the result comes from.
    pub made: Provenance,
}

/// One violation of the model.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct ViolationReport {
    /// Line of the file.
    pub line: usize,
    /// Name of the robot, or what the file has in its place.
    pub robot: String,
    /// Id of the item, or what the file has in its place.
    pub item: String,
    /// When the robot left for it [s]; `None` if the row names what does not exist.
    pub decide_s: Option<f64>,
    /// Start of the grasp [s]; `None` likewise.
    pub grasp_s: Option<f64>,
    /// Where the item was to be met: x and y [m]; `None` if the row does not say it.
    pub place: Option<[f64; 2]>,
    /// What it is about, in snake case.
    pub kind: &'static str,
    /// What is wrong, and what would be right.
    pub problem: String,
    /// The least tolerance with which it would be accepted [s]; `None` if none helps.
    pub accepted_from_s: Option<f64>,
}

impl VerificationReport {
    /// The report of `violations` of the attempts in `file`, judged by `terms`.
    pub fn new(
        station: &Station,
        pattern: &Pattern,
        file: &PicksFile,
        violations: &[Violation],
        terms: Terms,
        made: Provenance,
    ) -> Self {
        // What is unknown is told in the words of the file.
        let known = violations.iter();
        let known = known.filter(|violation| violation.kind != ViolationKind::Unknown);
        let known = known.map(|violation| {
            let (pick, _) = file.attempts[violation.attempt];
            let line = file.lines[violation.attempt];
            // As written, where the row names what does not exist.
            let written = || file.unknown.iter().find(|row| row.line == line);
            let robot = station.robots().get(pick.robot);
            let item = pattern.items().get(pick.item as usize);
            ViolationReport {
                line,
                robot: robot
                    .map(|robot| robot.name.clone())
                    .or_else(|| Some(written()?.robot.clone()))
                    .unwrap_or_default(),
                item: item
                    .map(|item| item.id.clone())
                    .or_else(|| Some(written()?.item.clone()))
                    .unwrap_or_default(),
                decide_s: Some(pick.decide),
                grasp_s: Some(pick.grasp),
                place: Some([pick.meet.x, pick.meet.y]).filter(|at| at[0].is_finite()),
                kind: violation.kind.name(),
                problem: violation.problem.clone(),
                accepted_from_s: violation.accepted_from,
            }
        });
        let unknown = file.unknown.iter().map(|row| ViolationReport {
            line: row.line,
            robot: row.robot.clone(),
            item: row.item.clone(),
            decide_s: None,
            grasp_s: None,
            place: None,
            kind: ViolationKind::Unknown.name(),
            problem: row.problem.clone(),
            accepted_from_s: None,
        });
        let mut all: Vec<ViolationReport> = known.chain(unknown).collect();
        all.sort_by_key(|violation| violation.line);
        let mut violations_by_kind = BTreeMap::new();
        for violation in &all {
            *violations_by_kind.entry(violation.kind).or_default() += 1;
        }
        let failures = file.attempts.iter().filter(|(_, cause)| cause.is_some());
        let failures = failures.count();
        Self {
            confirmed: all.is_empty(),
            items: pattern.len(),
            picks: file.attempts.len() - failures,
            failures,
            tolerance_s: terms.tolerance,
            violations: all,
            violations_by_kind,
            ignored_columns: file.ignored.clone(),
            made,
        }
    }

    /// That the picks contradict the model.
    ///
    /// # Errors
    /// [`Refuted`](pickline::ErrorKind), unless they are confirmed.
    pub fn verdict(&self) -> pickline::Result<()> {
        match self.violations.first() {
            None => Ok(()),
            Some(first) => Err(Error::refuted(format!(
                "{}, the first in line {}",
                counted(self.violations.len(), "violation"),
                first.line
            ))),
        }
    }

    fn text(&self) -> String {
        let place = |violation: &ViolationReport| {
            let place = violation.place;
            place.map_or("-".into(), |[x, y]| {
                format!("{}, {}", fixed(x, 3), fixed(y, 3))
            })
        };
        let optional = |value: Option<f64>| value.map_or("-".into(), |v| fixed(v, 3));
        let table = TableColumns::new()
            .with("line", |v: &&ViolationReport| v.line.to_string())
            .with("<robot", |v| v.robot.clone())
            .with("<item", |v| v.item.clone())
            .with("leaves [s]", |v| optional(v.decide_s))
            .with("<place x, y [m]", |v| place(v))
            .with("<violation", |v| v.problem.clone())
            .table(&self.violations);
        let table = match self.confirmed {
            true => String::new(),
            false => table,
        };
        let failed = match self.failures {
            0 => String::new(),
            failures => format!(" and {}", counted(failures, "failed attempt")),
        };
        let ignored = match self.ignored_columns.join(", ") {
            none if none.is_empty() => none,
            some => format!("ignored   columns {some}\n"),
        };
        format!(
            "{table}verdict   {}\nchecked   {}{failed}, of a pattern of {}\n{}{ignored}{}",
            self.verdict_text(),
            counted(self.picks, "pick"),
            counted(self.items, "item"),
            self.tolerance_line(),
            self.made.lines(),
        )
    }

    fn verdict_text(&self) -> String {
        if self.confirmed && self.picks + self.failures == 0 {
            return "confirmed: there are no picks that could contradict the model".to_owned();
        }
        if self.confirmed {
            return "confirmed: nothing contradicts the model".to_owned();
        }
        let kinds = self.violations_by_kind.iter();
        let kinds: Vec<String> = kinds
            .map(|(kind, count)| format!("{count} {kind}"))
            .collect();
        let count = counted(self.violations.len(), "violation");
        format!("rejected: {count} of the model ({})", kinds.join(", "))
    }

    /// With which tolerance those violations would be accepted that can be.
    fn tolerance_line(&self) -> String {
        let needed = self.violations.iter().filter_map(|v| v.accepted_from_s);
        let mut needed: Vec<f64> = needed.collect();
        if needed.is_empty() {
            return String::new();
        }
        needed.sort_unstable_by(f64::total_cmp);
        // Upwards: the tolerance that is named must do.
        let share = |share| shown_number(significant(quantile(&needed, share), 3, f64::ceil));
        format!(
            "tolerance {} s; {} of the violations would be accepted with {} s, half of them with {} s\n",
            shown_number(self.tolerance_s),
            needed.len(),
            share(1.0),
            share(0.5),
        )
    }

    fn rows(&self) -> CsvRows {
        CsvRows::of(self.violations.iter().map(|v| ViolationRow {
            line: v.line,
            robot: &v.robot,
            item: &v.item,
            decide_s: v.decide_s.map(Displayed),
            grasp_s: v.grasp_s.map(Displayed),
            x_m: v.place.map(|place| Displayed(place[0])),
            y_m: v.place.map(|place| Displayed(place[1])),
            kind: v.kind,
            problem: &v.problem,
            accepted_from_s: v.accepted_from_s.map(Displayed),
        }))
    }
}

#[derive(Default, Serialize)]
struct ViolationRow<'r> {
    line: usize,
    robot: &'r str,
    item: &'r str,
    decide_s: OptionalNumber,
    grasp_s: OptionalNumber,
    x_m: OptionalNumber,
    y_m: OptionalNumber,
    kind: &'static str,
    problem: &'r str,
    accepted_from_s: OptionalNumber,
}

impl VerbReport for VerificationReport {
    const FILES: &'static [ResultFile<Self>] = &[];

    fn provenance(&self) -> Option<&Provenance> {
        Some(&self.made)
    }

    fn to_table(&self, _shown: &Presentation) -> String {
        self.text()
    }

    fn to_csv(&self) -> String {
        self.rows().text(&self.made)
    }

    fn tables(&self) -> Vec<(&'static str, Vec<Column>)> {
        vec![("violations", self.rows().columns())]
    }
}
