//! A comparison as text for the terminal.

use super::report::{CaseReport, ComparisonReport, MethodResultReport, PrintedReport};
use crate::bound::{CaseBoundReport, rounded_up};
use crate::classes::{RecoveryRow, recovery_table};
use crate::columns::TableColumns;
use crate::game_theory::GT_LINE;
use crate::purity::purity_table;
use crate::table::{fixed, interval};

/// A row of the table: a method on a case, or the bound of a case.
struct ComparisonTextRow<'r> {
    case: &'r CaseReport,
    /// Place of the method; `None` for the bound.
    place: Option<usize>,
}

impl ComparisonTextRow<'_> {
    /// The cell of a method, or of the bound.
    fn cell(
        &self,
        method: impl Fn(&MethodResultReport) -> String,
        bound: impl Fn(&CaseBoundReport) -> String,
    ) -> String {
        match (self.place, &self.case.bound) {
            (Some(place), _) => method(&self.case.results[place]),
            (None, Some(of)) => bound(of),
            (None, None) => String::new(),
        }
    }

    /// The cell of a method; empty for the bound.
    fn method(&self, cell: impl Fn(&MethodResultReport) -> String) -> String {
        self.cell(cell, |_| String::new())
    }

    /// The cell of a method that is compared with the first, or of the bound.
    fn other(
        &self,
        method: impl Fn(&MethodResultReport) -> String,
        bound: impl Fn(&CaseBoundReport) -> String,
    ) -> String {
        match self.place {
            Some(0) => String::new(),
            _ => self.cell(method, bound),
        }
    }

    /// The cell of a figure that the paper prints; empty if there is none.
    fn paper(&self, cell: impl Fn(&PrintedReport) -> String) -> String {
        self.method(|result| result.paper.as_ref().map_or(String::new(), &cell))
    }
}

impl ComparisonReport {
    /// All methods and cases for the terminal.
    pub(super) fn text(&self) -> String {
        let rows = self.cases.iter().flat_map(|case| {
            let methods = (0..case.results.len()).map(Some);
            let bound = case.bound.as_ref().map(|_| None);
            let places = methods.chain(bound);
            places.map(move |place| ComparisonTextRow { case, place })
        });
        let table = self.columns().table(rows);
        let counts = self.cases.iter();
        let counts = counts.map(|case| format!("{} of {}", case.patterns, case.name));
        let counts: Vec<String> = counts.collect();
        let notes = self.notes.iter().map(|note| format!("note      {note}\n"));
        let certified = match self.is_bounded() {
            true => {
                "certified at least that share of the picks that the best strategy could make, \
                 waiting and clairvoyance included\n"
            }
            false => "",
        };
        format!(
            "{table}{GT_LINE}{}{}means over {}\n{certified}{}{}",
            self.purity_text(),
            self.recoveries(),
            counts.join("; "),
            notes.collect::<String>(),
            self.made.lines()
        )
    }

    /// Purity and recovery; empty unless detections may be wrong.
    fn purity_text(&self) -> String {
        let rows: Vec<_> = self.purities().into_iter().flatten().collect();
        match rows.is_empty() {
            true => String::new(),
            false => purity_table("<case", &rows),
        }
    }

    /// The recovery of each class; empty without classes.
    fn recoveries(&self) -> String {
        let mut rows = Vec::new();
        for case in &self.cases {
            let results = case.results.iter().zip(&self.methods).enumerate();
            rows.extend(results.map(|(place, (result, method))| RecoveryRow {
                group: match place {
                    0 => case.name.clone(),
                    _ => String::new(),
                },
                method: Some(&method.title),
                classes: &result.classes,
            }));
            rows.extend(case.bound.as_ref().map(|_| RecoveryRow {
                group: String::new(),
                method: None,
                classes: &case.results[0].classes,
            }));
        }
        rows.retain(|row| !row.classes.is_empty());
        recovery_table("<case", self.classes(), rows)
    }

    fn is_bounded(&self) -> bool {
        self.cases.iter().any(|case| case.bound.is_some())
    }

    fn columns(&self) -> TableColumns<'_, ComparisonTextRow<'_>, String> {
        let steady = self.is_steady();
        let up = |value: Option<f64>| value.map_or(String::new(), |value| rounded_up(value, 1));
        let percent = |value: Option<f64>| value.map_or(String::new(), |value| fixed(value, 1));
        let none = |_: &CaseBoundReport| String::new();
        let columns = TableColumns::new()
            .with("<case", |row: &ComparisonTextRow| match row.place {
                Some(0) => row.case.name.clone(),
                _ => String::new(),
            })
            .with("<method", |row| match row.place {
                Some(place) => self.methods[place].title.clone(),
                None => "bound: no strategy beats".to_owned(),
            })
            .with_if(steady, "throughput [1/min]", |row| {
                row.method(|result| result.throughput.shown(1))
            })
            .with_if(steady, "95 %", |row| {
                row.method(|result| result.throughput.shown_interval(1))
            })
            .with_if(steady, "flow [1/min]", |row| {
                row.method(|result| result.throughput.flow(1))
            })
            .with("picked [%]", |row| {
                row.cell(
                    |result| fixed(100.0 * result.picked_share, 1),
                    |bound| rounded_up(100.0 * bound.picked_share, 1),
                )
            })
            .with("time [s]", |row| {
                row.method(|result| fixed(result.end_s, 1))
            })
            .with("picking rate [1/min]", move |row| {
                row.cell(
                    |result| fixed(result.picking_rate_per_min, 1),
                    |bound| up(bound.picking_rate_per_min),
                )
            })
            .with("minus the first, 95 %", |row| {
                row.other(
                    |result| interval(result.difference, 2),
                    |bound| interval(bound.difference, 2),
                )
            })
            .with("benefit [%]", move |row| {
                row.other(
                    |result| fixed(result.benefit_percent, 1),
                    |bound| up(bound.benefit_percent),
                )
            })
            .with_if(self.is_bounded(), "certified [%]", move |row| {
                row.cell(|result| percent(result.certified_percent), none)
            });
        self.with_paper_columns(columns)
    }

    /// The same columns, followed by the figures that the paper prints if they are shown.
    fn with_paper_columns<'c>(
        &self,
        columns: TableColumns<'c, ComparisonTextRow<'c>, String>,
    ) -> TableColumns<'c, ComparisonTextRow<'c>, String> {
        columns
            .with_if(self.with_paper, "paper: picked [%]", |row| {
                row.paper(|paper| fixed(paper.picked_percent, 0))
            })
            .with_if(self.with_paper, "time [s]", |row| {
                row.paper(|paper| fixed(paper.time_s, 1))
            })
            .with_if(self.with_paper, "picking rate [1/min]", |row| {
                row.paper(|paper| fixed(paper.picking_rate_per_min, 1))
            })
    }
}
