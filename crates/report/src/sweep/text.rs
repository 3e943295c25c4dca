//! A sweep as text for the terminal.

use super::report::{LimitReport, SweepReport};
use crate::bound::rounded_up;
use crate::table::{Table, fixed, interval};

impl SweepReport {
    /// All points and limits for the terminal.
    pub(super) fn text(&self) -> String {
        let varied = match self.unit {
            "1" => self.sweep.to_owned(),
            unit => format!("{} [{unit}]", self.sweep),
        };
        let many = self.patterns > 1;
        let mut header = vec![varied.as_str(), "<method"];
        let (steady, adds) = (self.is_steady(), self.adds());
        if steady {
            header.extend(["throughput [1/min]", "95 %", "flow [1/min]"]);
        }
        header.extend(adds.then_some("added a robot [1/min]"));
        header.extend(["picked [%]", "picking rate [1/min]"]);
        header.extend(self.weighs.then_some("weighted [1/min]"));
        if many {
            header.extend(["picking rate, 95 %", "complete [%]", "to 99 % [%]"]);
        }
        let mut bounds = self.bounds.as_ref().map(|bounds| bounds.points.iter());
        if bounds.is_some() {
            header.extend(["certified [%]", "bound: picked [%]", "picking rate [1/min]"]);
        }
        let mut table = Table::new(&header);
        let mut before = None;
        for point in &self.points {
            let mut row = vec![
                if before == Some(point.value) {
                    String::new()
                } else {
                    point.value.to_string()
                },
                point.title.clone(),
            ];
            if steady {
                row.extend(point.throughput.table_cells(1));
            }
            let added = point.added_per_robot_per_min;
            row.extend(adds.then(|| added.map_or(String::new(), |added| fixed(added, 1))));
            row.extend([
                fixed(100.0 * point.picked_share, 1),
                fixed(point.picking_rate_per_min, 2),
            ]);
            row.extend(self.weighs.then(|| fixed(point.weighted_rate_per_min, 2)));
            if many {
                row.extend([
                    interval(point.picking_rate_interval, 2),
                    fixed(100.0 * point.complete_share, 1),
                    fixed(100.0 * point.nearly_complete_share, 1),
                ]);
            }
            let first = before != Some(point.value);
            if let Some(bounds) = &mut bounds {
                // It is the same for all methods, so only the first one's row shows it.
                let bound = if first { bounds.next() } else { None };
                let rate = bound.and_then(|bound| bound.picking_rate_per_min);
                row.extend([
                    point
                        .certified_percent
                        .map_or(String::new(), |c| fixed(c, 1)),
                    bound.map_or(String::new(), |b| rounded_up(100.0 * b.picked_share, 1)),
                    rate.map_or(String::new(), |rate| rounded_up(rate, 2)),
                ]);
            }
            table.row(row);
            before = Some(point.value);
        }
        let mut text = table.render();
        for limit in &self.limits {
            text += &self.limit_line(limit, many);
        }
        for words in self.recommendations(str::to_owned) {
            text += &format!("choose    {words}\n");
        }
        if let Some(words) = self.avoided() {
            text += &format!("avoid     {words}\n");
        }
        if let Some(bounds) = &self.bounds {
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
