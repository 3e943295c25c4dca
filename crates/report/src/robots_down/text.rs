//! A sweep over halted robots as text for the terminal.

use super::report::{HaltedPointReport, RobotsDownReport};
use crate::columns::TableColumns;
use crate::game_theory::GT_LINE;
use crate::table::{fixed, interval};

impl RobotsDownReport {
    /// All points for the terminal, and which robot each method misses most.
    pub(super) fn text(&self) -> String {
        let many = self.patterns > 1;
        let steady = self.is_steady();
        let rows = self.points.iter().enumerate().map(|(place, point)| {
            // The robot stands beside the first method only.
            (place % self.methods == 0, point)
        });
        let table = TableColumns::new()
            .with(
                "<robot down",
                |(first, point): &(bool, &HaltedPointReport)| match first {
                    true => point.halted().to_owned(),
                    false => String::new(),
                },
            )
            .with("<method", |(_, point)| point.title.clone())
            .with_if(steady, "throughput [1/min]", |(_, point)| {
                point.throughput.shown(1)
            })
            .with_if(steady, "95 %", |(_, point)| {
                point.throughput.shown_interval(1)
            })
            .with_if(steady, "flow [1/min]", |(_, point)| {
                point.throughput.flow(1)
            })
            .with("picked [%]", |(_, point)| {
                fixed(100.0 * point.picked_share, 1)
            })
            .with("picking rate [1/min]", |(_, point)| {
                fixed(point.picking_rate_per_min, 2)
            })
            .with_if(self.weighs, "weighted [1/min]", |(_, point)| {
                fixed(point.weighted_rate_per_min, 2)
            })
            .with("loss [%]", |(_, point)| {
                point
                    .loss_percent
                    .map_or(String::new(), |loss| fixed(loss, 1))
            })
            .with_if(many, "loss, 95 %", |(_, point)| match point.loss_percent {
                Some(_) => interval(point.loss_interval, 1),
                None => String::new(),
            })
            .table(rows);
        let mut text = table + GT_LINE;
        for words in self.worst_in_words(str::to_owned) {
            text += &format!("worst     {words}\n");
        }
        for note in &self.notes {
            text += &format!("note      {note}\n");
        }
        text + &self.made.lines()
    }

    /// Which halted robot costs each method most; `named` gives the name of a method.
    pub(super) fn worst_in_words(&self, named: impl Fn(&str) -> String) -> Vec<String> {
        let words = |(j, worst): (usize, Option<usize>)| {
            let method = named(&self.points[j].method);
            match worst.map(|place| &self.points[place]) {
                Some(point) => format!(
                    "{method}: without {}, {} % fewer picks",
                    point.halted(),
                    fixed(point.loss_percent.unwrap_or_default(), 1)
                ),
                None if self.points[j].picked_share == 0.0 => {
                    format!("{method}: nothing is picked with all robots either")
                }
                None => format!("{method}: no single robot is missed"),
            }
        };
        let robots = self.points.len() > self.methods;
        let worst = self.worst().into_iter().enumerate().map(words);
        worst.filter(|_| robots).collect()
    }
}
