//! A solved game as CSV.

use super::report::GameReport;
use crate::table::column;
use pickline::optimize::game::Payoff;

impl GameReport {
    /// All assignments with their payoffs as CSV.
    pub fn to_csv(&self) -> String {
        let robots = robot_columns(&self.robots);
        let each = |what: &str| {
            let name = |robot: &String| column(&format!("{what}_{robot}"), self.unit);
            robots.iter().map(name).collect::<Vec<_>>()
        };
        let header = [
            vec!["assignment".to_owned()],
            each("payoff"),
            each("rate"),
            vec![
                column("welfare", self.unit),
                "equilibrium".to_owned(),
                "leads_to".to_owned(),
            ],
        ]
        .concat();
        let rows = self.profiles.iter().map(|profile| {
            let texts = |values: &[Payoff]| values.iter().map(Payoff::to_string).collect();
            [
                vec![profile.assignment.join(" ")],
                texts(&profile.payoffs),
                texts(&profile.rates),
                vec![
                    profile.welfare.to_string(),
                    profile.equilibrium.to_owned(),
                    profile.leads_to.join(" "),
                ],
            ]
            .concat()
        });
        self.made.csv(std::iter::once(header).chain(rows))
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
