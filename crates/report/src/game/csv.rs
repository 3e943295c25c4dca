//! A solved game as CSV.

use super::report::{GameReport, ProfileReport};
use crate::csv_rows::{CsvRows, Displayed};
use crate::table::column;
use serde::Serialize;

#[derive(Default, Serialize)]
struct ProfileName {
    assignment: String,
}

/// A robot's payoff; named after the robot.
#[derive(Clone, Default, Serialize)]
struct PayoffColumn {
    payoff: Displayed,
}

/// A robot's own picks per minute; named after the robot.
#[derive(Clone, Default, Serialize)]
struct RateColumn {
    rate: Displayed,
}

#[derive(Default, Serialize)]
struct ProfileEnd {
    welfare: Displayed,
    equilibrium: &'static str,
    leads_to: String,
}

impl GameReport {
    /// All assignments with their payoffs.
    pub(super) fn payoffs_csv(&self) -> CsvRows {
        let row = |profile: &ProfileReport| {
            let payoffs = profile.payoffs.iter();
            let rates = profile.rates.iter();
            (
                ProfileName {
                    assignment: profile.assignment.join(" "),
                },
                payoffs
                    .map(|&payoff| PayoffColumn {
                        payoff: Displayed(payoff.value()),
                    })
                    .collect::<Vec<_>>(),
                rates
                    .map(|&rate| RateColumn {
                        rate: Displayed(rate.value()),
                    })
                    .collect::<Vec<_>>(),
                ProfileEnd {
                    welfare: Displayed(profile.welfare.value()),
                    equilibrium: profile.equilibrium,
                    leads_to: profile.leads_to.join(" "),
                },
            )
        };
        let count = self.robots.len();
        let template = (
            ProfileName::default(),
            vec![PayoffColumn::default(); count],
            vec![RateColumn::default(); count],
            ProfileEnd::default(),
        );
        let robots = robot_columns(&self.robots);
        let (mut payoffs, mut rates) = (robots.iter(), robots.iter());
        let of_robot = |name: &str, robot: Option<&String>| {
            let robot = robot.map_or("", String::as_str);
            column(&format!("{name}_{robot}"), self.unit)
        };
        CsvRows::like(&template, self.profiles.iter().map(row)).renamed(|name| match name {
            "payoff" => of_robot(name, payoffs.next()),
            "rate" => of_robot(name, rates.next()),
            "welfare" => column(name, self.unit),
            name => name.to_owned(),
        })
    }
}

/// The robots' names as parts of column names; their numbers, upstream first, if the names are
/// not unique.
fn robot_columns(names: &[String]) -> Vec<String> {
    let snake = |name: &String| {
        let part = |c: char| {
            if c.is_alphanumeric() {
                c.to_ascii_lowercase()
            } else {
                '_'
            }
        };
        name.chars().map(part).collect::<String>()
    };
    let parts: Vec<String> = names.iter().map(snake).collect();
    let distinct: std::collections::BTreeSet<&String> = parts.iter().collect();
    if distinct.len() == parts.len() {
        return parts;
    }
    (1..=names.len())
        .map(|number| format!("robot_{number}"))
        .collect()
}
