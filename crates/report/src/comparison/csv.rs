//! A comparison as CSV.

use super::report::ComparisonReport;
use crate::table::cell;
use crate::throughput::ThroughputReport;

impl ComparisonReport {
    /// Throughput as CSV: each method's picks per minute in the steady state of each case.
    pub fn throughput_csv(&self) -> String {
        let mut header = vec!["case", "method"];
        header.extend(ThroughputReport::COLUMNS);
        header.extend(["steady_patterns", "patterns"]);
        let mut rows = vec![header.into_iter().map(str::to_owned).collect::<Vec<_>>()];
        for case in &self.cases {
            for result in &case.results {
                let mut row = vec![case.name.clone(), result.method.clone()];
                row.extend(result.throughput.cells());
                row.push(result.throughput.steady_patterns.to_string());
                row.push(case.patterns.to_string());
                rows.push(row);
            }
        }
        self.made.csv(rows)
    }

    /// Table 2 of the paper as CSV: items picked and time taken.
    pub fn picked_time_csv(&self) -> String {
        let header = ["case", "method", "picked_share", "end_s", "patterns"];
        let mut rows = vec![header.map(str::to_owned)];
        for case in &self.cases {
            for result in &case.results {
                rows.push([
                    case.name.clone(),
                    result.method.clone(),
                    result.picked_share.to_string(),
                    result.end_s.to_string(),
                    case.patterns.to_string(),
                ]);
            }
        }
        self.made.csv(rows)
    }

    /// Table 3 of the paper as CSV: each method's picking rate on each case, its excess over
    /// the first method, and the upper bound for every strategy.
    pub fn picking_rate_csv(&self) -> String {
        let header = [
            "case",
            "method",
            "picking_rate_per_min",
            "picking_rate_low_per_min",
            "picking_rate_high_per_min",
            "benefit_percent",
            "diff_low_per_min",
            "diff_high_per_min",
            "picking_rate_upper_bound_per_min",
            "patterns",
        ];
        let mut rows = vec![header.map(str::to_owned)];
        for case in &self.cases {
            let bound = case.bound.as_ref().and_then(|b| b.picking_rate_per_min);
            for (place, result) in case.results.iter().enumerate() {
                // The first method has nothing to compare with.
                let other = |value: Option<f64>| cell(value.filter(|_| place > 0));
                rows.push([
                    case.name.clone(),
                    result.method.clone(),
                    result.picking_rate_per_min.to_string(),
                    cell(result.picking_rate_low),
                    cell(result.picking_rate_high),
                    other(Some(result.benefit_percent)),
                    other(result.diff_low),
                    other(result.diff_high),
                    cell(bound),
                    case.patterns.to_string(),
                ]);
            }
        }
        self.made.csv(rows)
    }

    /// Every run as CSV.
    pub fn runs_csv(&self) -> String {
        let header = [
            "case",
            "pattern_seed",
            "method",
            "items",
            "picked",
            "end_s",
            "throughput_per_min",
            "flow_per_min",
            "picking_rate_per_min",
            "picks_upper_bound",
            "assignment",
        ];
        let weighs = self.weighs();
        let mut header = header.map(str::to_owned).to_vec();
        header.extend(weighs.then(|| "weighted_rate_per_min".to_owned()));
        let rows = self.cases.iter().flat_map(|case| &case.runs).map(|run| {
            let mut row = run.cells.to_vec();
            row.extend(weighs.then(|| run.weighted_rate.to_string()));
            row
        });
        self.made.csv(std::iter::once(header).chain(rows))
    }
}
