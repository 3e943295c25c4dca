//! A sweep as text for the terminal.

use super::report::{BoundPoint, LimitReport, PointReport, SweepReport};
use crate::bound::rounded_up;
use crate::classes::{RecoveryRow, recovery_table};
use crate::columns::TableColumns;
use crate::game_theory::GT_LINE;
use crate::purity::purity_table;
use crate::table::{fixed, interval};

/// A row of the table: a method at a value.
struct SweepTextRow<'r> {
    point: &'r PointReport,
    /// Whether this is the first method at its value.
    first: bool,
    /// What no strategy can exceed; only beside the first method.
    bound: Option<&'r BoundPoint>,
}

impl SweepReport {
    /// All points and limits for the terminal.
    pub(super) fn text(&self) -> String {
        let many = self.patterns > 1;
        let methods = self.limits.len();
        let rows = self.points.iter().enumerate().map(|(i, point)| {
            let place = i / methods;
            let bounds = self.bounds.as_ref();
            let bound = bounds.and_then(|bounds| bounds.points.get(place));
            let first = i % methods == 0;
            // The bound is the same for all methods, so only the first one's row shows it.
            let bound = bound.filter(|_| first);
            SweepTextRow {
                point,
                first,
                bound,
            }
        });
        let mut text = self.columns(many).table(rows) + GT_LINE;
        if self.has_purity() {
            let rows: Vec<_> = self.purities().into_iter().flatten().collect();
            text += &purity_table(&self.varied(), &rows);
        }
        text += &self.recoveries();
        // What is below a threshold does not count as missed, so a limit would say nothing.
        let limits = self.limits.iter().filter(|_| !self.is_of_thresholds());
        for limit in limits {
            text += &self.limit_line(limit, many);
        }
        if let Some(thresholds) = &self.thresholds {
            for words in thresholds.words(str::to_owned) {
                text += &format!("choose    {words}\n");
            }
            text += &format!("training  {}\n", thresholds.trained_on);
        }
        for words in self.recommendations(str::to_owned) {
            text += &format!("choose    {words}\n");
        }
        if let Some(words) = self.avoided() {
            text += &format!("avoid     {words}\n");
        }
        let bounds = self.bounds.as_ref().filter(|_| !self.is_of_thresholds());
        if let Some(bounds) = bounds {
            text += &format!("bound     {}\n", bounds.words(self.helps, self.unit_word()));
        }
        if let Some(paper) = &self.paper {
            text += &format!(
                "paper     everything picked up to {} m/s by robust GT, {} m/s by RL (+{} %)\n",
                paper.robust_gt,
                paper.rl,
                fixed(paper.benefit_percent, 1)
            );
        }
        for note in &self.notes {
            text += &format!("note      {note}\n");
        }
        text + &self.made.lines()
    }

    /// The recovery of each class; empty without classes.
    fn recoveries(&self) -> String {
        let methods = self.limits.len();
        let mut rows = Vec::new();
        for (i, point) in self.points.iter().enumerate() {
            rows.push(RecoveryRow {
                group: match i % methods {
                    0 => point.value.to_string(),
                    _ => String::new(),
                },
                method: Some(&point.title),
                classes: &point.classes,
            });
            if self.bounds.is_some() && i % methods == methods - 1 {
                rows.push(RecoveryRow {
                    group: String::new(),
                    method: None,
                    classes: &point.classes,
                });
            }
        }
        recovery_table(&self.varied(), self.classes(), rows)
    }

    fn columns(&self, many: bool) -> TableColumns<'_, SweepTextRow<'_>, String> {
        let steady = self.is_steady();
        let bounded = self.bounds.is_some();
        let optional = |value: Option<f64>| value.map_or(String::new(), |value| fixed(value, 1));
        TableColumns::new()
            .with(self.varied(), |row: &SweepTextRow| match row.first {
                true => row.point.value.to_string(),
                false => String::new(),
            })
            .with("<method", |row| row.point.title.clone())
            .with_if(steady, "throughput [1/min]", |row| {
                row.point.throughput.shown(1)
            })
            .with_if(steady, "95 %", |row| row.point.throughput.shown_interval(1))
            .with_if(steady, "flow [1/min]", |row| row.point.throughput.flow(1))
            .with_if(self.adds(), "added a robot [1/min]", move |row| {
                optional(row.point.added_per_robot_per_min)
            })
            .with("picked [%]", |row| fixed(100.0 * row.point.picked_share, 1))
            .with("picking rate [1/min]", |row| {
                fixed(row.point.picking_rate_per_min, 2)
            })
            .with_if(self.weighs, "weighted [1/min]", |row| {
                fixed(row.point.weighted_rate_per_min, 2)
            })
            .with_if(many, "picking rate, 95 %", |row| {
                interval(row.point.picking_rate_interval, 2)
            })
            .with_if(many, "complete [%]", |row| {
                fixed(100.0 * row.point.complete_share, 1)
            })
            .with_if(many, "to 99 % [%]", |row| {
                fixed(100.0 * row.point.nearly_complete_share, 1)
            })
            .with_if(bounded, "certified [%]", move |row| {
                optional(row.point.certified_percent)
            })
            .with_if(bounded, "bound: picked [%]", |row| {
                let share = row.bound.map(|bound| bound.picked_share);
                share.map_or(String::new(), |share| rounded_up(100.0 * share, 1))
            })
            .with_if(bounded, "picking rate [1/min]", |row| {
                let rate = row.bound.and_then(|bound| bound.picking_rate_per_min);
                rate.map_or(String::new(), |rate| rounded_up(rate, 2))
            })
    }

    fn limit_line(&self, limit: &LimitReport, many: bool) -> String {
        let unit = self.unit_word();
        if self.helps {
            return match limit.lowest {
                Some(value) => format!(
                    "limit     {}: everything picked from {value} {unit} on\n",
                    limit.method
                ),
                None => format!("limit     {}: never everything picked\n", limit.method),
            };
        }
        let shown = |value: Option<f64>| match value {
            Some(value) => format!("{value} {unit}"),
            None => "below this sweep".to_owned(),
        };
        let again = if limit.again.is_empty() {
            String::new()
        } else {
            let values: Vec<String> = limit.again.iter().map(f64::to_string).collect();
            format!(", everything again at {}", values.join(", "))
        };
        let miss = match limit.first_miss {
            Some(value) => format!("first miss at {value}{again}"),
            None => "no miss in this sweep".into(),
        };
        let benefit = limit
            .benefit_percent
            .map(|percent| format!(" ({} % against the first)", fixed(percent, 1)))
            .unwrap_or_default();
        let mut text = match limit.highest {
            Some(highest) => format!(
                "limit     {}: everything picked up to {highest} {unit}{benefit}; {miss}\n",
                limit.method
            ),
            None => format!(
                "limit     {}: misses items already at the first value{again}\n",
                limit.method
            ),
        };
        if many {
            let [least, median, greatest] = limit.of_patterns;
            text += &format!(
                "          95 % of the patterns picked to 99 % up to {}; limits of the patterns \
                 {least} to {greatest}, median {median}\n",
                shown(limit.highest_95_99)
            );
        }
        text
    }
}
