//! A comparison as text for the terminal.

use super::report::ComparisonReport;
use crate::table::{Table, fixed, interval};

impl ComparisonReport {
    /// All methods and cases for the terminal.
    pub(super) fn text(&self) -> String {
        let mut header = vec!["<case", "<method"];
        let steady = self.is_steady();
        if steady {
            header.extend(["throughput [1/min]", "95 %", "flow [1/min]"]);
        }
        header.extend([
            "picked [%]",
            "time [s]",
            "picking rate [1/min]",
            "minus the first, 95 %",
            "benefit [%]",
        ]);
        let with_bound = self.cases.iter().any(|case| case.bound.is_some());
        if with_bound {
            header.push("certified [%]");
        }
        if self.with_paper {
            header.extend(["paper: picked [%]", "time [s]", "picking rate [1/min]"]);
        }
        let mut table = Table::new(&header);
        for case in &self.cases {
            for (i, result) in case.results.iter().enumerate() {
                let first = i == 0;
                let mut row = vec![
                    if first {
                        case.name.clone()
                    } else {
                        String::new()
                    },
                    self.methods[i].title.clone(),
                ];
                if steady {
                    row.extend(result.throughput.table_cells(1));
                }
                row.extend([
                    fixed(100.0 * result.picked_share, 1),
                    fixed(result.end_s, 1),
                    fixed(result.picking_rate_per_min, 1),
                    if first {
                        String::new()
                    } else {
                        interval(result.difference, 2)
                    },
                    if first {
                        String::new()
                    } else {
                        fixed(result.benefit_percent, 1)
                    },
                ]);
                if with_bound {
                    let percent = result.certified_percent;
                    row.push(percent.map_or(String::new(), |percent| fixed(percent, 1)));
                }
                if self.with_paper {
                    row.extend(match result.paper {
                        Some(p) => [
                            fixed(p.picked_percent, 0),
                            fixed(p.time_s, 1),
                            fixed(p.picking_rate_per_min, 1),
                        ],
                        None => [const { String::new() }; 3],
                    });
                }
                table.row(row);
            }
            if let Some(bound) = &case.bound {
                table.row(bound.row(if steady { 3 } else { 0 }, header.len()));
            }
        }
        let counts: Vec<String> = self
            .cases
            .iter()
            .map(|case| format!("{} of {}", case.patterns, case.name))
            .collect();
        let notes: String = self
            .notes
            .iter()
            .map(|note| format!("note      {note}\n"))
            .collect();
        let certified = if with_bound {
            "certified at least that share of the picks that the best strategy could make, \
             waiting and clairvoyance included\n"
        } else {
            ""
        };
        format!(
            "{}means over {}\n{certified}{notes}{}",
            table.render(),
            counts.join("; "),
            self.made.lines()
        )
    }
}
