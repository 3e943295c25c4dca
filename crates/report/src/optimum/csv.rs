//! A search as CSV.

use super::report::OptimumReport;
use super::rivals::RivalsReport;
use crate::table::{cell, without_empty_columns};

impl OptimumReport {
    /// The whole ranking as CSV.
    pub fn to_csv(&self) -> String {
        let header = vec![
            "rank".into(),
            "assignment".into(),
            self.format().column("mean"),
            self.format().column("value"),
            self.format().column("diff_low"),
            self.format().column("diff_high"),
            "tied".into(),
            "picked_share".into(),
            self.format().column("worst"),
            "worst_pattern".into(),
            "max_speed_m_per_s".into(),
        ];
        let rows = self.ranking.iter().enumerate().map(|(i, line)| {
            vec![
                (i + 1).to_string(),
                line.assignment.join(" "),
                line.mean.to_string(),
                line.value.to_string(),
                cell(line.diff_low),
                cell(line.diff_high),
                line.tied.to_string(),
                line.picked_share.to_string(),
                line.worst.to_string(),
                line.worst_pattern.clone(),
                line.max_speed.map(|v| v.to_string()).unwrap_or_default(),
            ]
        });
        let rows = std::iter::once(header).chain(rows);
        self.made.csv(without_empty_columns(rows))
    }

    /// The strategies beside the winner as CSV.
    pub fn rivals_csv(&self, beside: &RivalsReport) -> String {
        beside.to_csv(self.format(), &self.made)
    }
}
