//! The tables of a run for the terminal.

use super::report::{BinRunReport, ClassRunReport, RobotRunReport, RunReport};
use crate::classes::class_title;
use crate::clearance::ClearanceReport;
use crate::columns::TableColumns;
use crate::presentation::Presentation;
use crate::purity::RunPurityReport;
use crate::table::fixed;
use std::collections::BTreeMap;

impl RunReport {
    /// The run as text for the terminal.
    pub(super) fn text(&self, shown: &Presentation) -> String {
        let steady = self.throughput.throughput_per_min.is_some();
        let robots = TableColumns::new()
            .with("<robot", |robot: &&RobotRunReport| robot.name.clone())
            .with("picked", |robot| robot.picked.to_string())
            .with("busy [s]", |robot| fixed(robot.busy_s, 1))
            .with("utilisation [%]", |robot| {
                fixed(100.0 * robot.utilisation, 1)
            })
            .with_if(self.downtimes.is_some(), "down [s]", |robot| {
                robot.down_s.map_or(String::new(), |down| fixed(down, 1))
            })
            .with_if(steady, "in the steady state [%]", |robot| {
                let share = robot.utilisation_steady;
                share.map_or(String::new(), |share| fixed(100.0 * share, 1))
            })
            .table(&self.robots);
        let checked = match self.checked {
            Some(true) => "checked   confirmed by the independent checker\n",
            _ => "",
        };
        let weighted = match self.weighs {
            true => format!(", weighted {} /min", fixed(self.weighted_rate_per_min, 2)),
            false => String::new(),
        };
        format!(
            "{}{}{}strategy  {}\npicked    {} of {} ({} %) in {} s\n\
             rate      {} picks/min over the whole run{weighted}\n\
             {}{}{}{}{checked}{}{}{}",
            self.throughput.line(),
            robots,
            self.classes_table(),
            self.strategy,
            self.picked,
            self.items,
            fixed(100.0 * self.picked_share, 1),
            fixed(self.end_s, 1),
            fixed(self.picking_rate_per_min, 2),
            self.missed_line(),
            self.unwanted_line(),
            self.sorting
                .as_ref()
                .map_or(String::new(), RunPurityReport::text),
            self.failed_line(),
            self.clearance
                .as_ref()
                .map_or(String::new(), ClearanceReport::line),
            self.bound
                .as_ref()
                .map_or(String::new(), |bound| bound.line(shown)),
            self.made.lines(),
        )
    }

    /// How many items were missed for which reason.
    fn missed_line(&self) -> String {
        let reasons = self.missed_by_reason.iter();
        let reasons = reasons.filter(|(_, count)| **count > 0);
        let reasons: Vec<String> = reasons
            .map(|(reason, count)| format!("{count} {reason}"))
            .collect();
        match reasons.len() {
            0 => "missed    nothing\n".to_owned(),
            _ => format!("missed    {}\n", reasons.join(", ")),
        }
    }

    /// How many items were left on purpose for which reason, if any were.
    fn unwanted_line(&self) -> String {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for left in &self.unwanted {
            *counts.entry(left.reason).or_default() += 1;
        }
        let counts: Vec<String> = counts
            .iter()
            .map(|(reason, count)| format!("{count} {reason}"))
            .collect();
        match counts.len() {
            0 => String::new(),
            _ => format!("left      {}\n", counts.join(", ")),
        }
    }

    /// The items of each class and the bins that they went into, if the station sorts.
    fn classes_table(&self) -> String {
        if self.classes.is_empty() {
            return String::new();
        }
        let mut certified = self.classes.iter();
        let bounded = certified.any(|class| class.picks_upper_bound.is_some());
        let classes = TableColumns::new()
            .with("<class", |class: &&ClassRunReport| {
                class_title(class.name.as_deref())
            })
            .with("items", |class| class.items.to_string())
            .with("picked", |class| class.picked.to_string())
            .with("recovery [%]", |class| {
                class
                    .recovery
                    .map_or("-".to_owned(), |share| fixed(100.0 * share, 1))
            })
            .with_if(bounded, "bound: picked", |class| {
                let most = class.picks_upper_bound;
                most.map_or("-".to_owned(), |most| most.to_string())
            })
            .with_if(bounded, "certified [%]", |class| {
                let certified = class.certified_percent;
                certified.map_or("-".to_owned(), |percent| fixed(percent, 1))
            })
            .table(&self.classes);
        let bins = self.robots.iter().flat_map(|robot| {
            let bins = robot.bins.iter();
            bins.map(move |bin| (robot.name.as_str(), bin))
        });
        let bins: Vec<(&str, &BinRunReport)> = bins.collect();
        let bins = TableColumns::new()
            .with("<robot", |(robot, _): &&(&str, &BinRunReport)| {
                (*robot).to_owned()
            })
            .with("<bin", |(_, bin)| bin.name.clone())
            .with("picked", |(_, bin)| bin.picked.to_string())
            .table(&bins);
        format!("{classes}{bins}")
    }

    /// How many attempts of which robot failed, if any did.
    fn failed_line(&self) -> String {
        let robots = self.robots.iter();
        let robots: Vec<String> = robots.map(|r| format!("{} {}", r.name, r.failed)).collect();
        match self.failures.len() {
            0 => String::new(),
            count => format!("failed    {count} attempts ({})\n", robots.join(", ")),
        }
    }
}
