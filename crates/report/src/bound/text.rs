//! A bound as text for the terminal.

use super::report::{BoundReport, ScheduleReport};
use super::rounding::{rounded_down, rounded_up};
use crate::columns::TableColumns;
use crate::table::fixed;

impl BoundReport {
    /// The bound as text for the terminal.
    pub(super) fn text(&self) -> String {
        let table = self.figures();
        let all = match (self.all_picked, self.all_picked_end_lower_bound_s) {
            ("yes", None) => "there is nothing to pick".to_owned(),
            ("no", _) | (_, None) => "not everything can be picked (proven)".to_owned(),
            (all_picked, Some(end)) => format!(
                "{}; no run that picks everything ends before {} s",
                if all_picked == "yes" {
                    "everything can be picked: the schedule does so"
                } else {
                    "whether everything can be picked is open"
                },
                rounded_down(end, 1)
            ),
        };
        let share = self.schedule.as_ref().map_or(String::new(), |schedule| {
            format!(
                "schedule  certified: at least {} % of the optimum, confirmed by the independent checker\n",
                fixed(schedule.certified_percent, 1)
            )
        });
        format!(
            "{}{share}all       {all}\nreach     {} of {} are within reach\n\
             search    {} steps, slots of {} s, {} picks in slots, {}\n{}{}",
            table,
            self.reachable,
            self.of(" items"),
            self.iterations,
            self.slot_s,
            self.arcs,
            self.stop_reason.replace('_', " "),
            self.notes
                .iter()
                .map(|note| format!("note      {note}\n"))
                .collect::<String>(),
            self.made.lines(),
        )
    }

    /// The number of items that are to be picked, with `noun`, and of all items if these are more.
    fn of(&self, noun: &str) -> String {
        match self.wanted {
            Some(wanted) => format!("{wanted} wanted{noun} ({} in all)", self.items),
            None => format!("{}{noun}", self.items),
        }
    }

    /// The table of the figures.
    fn figures(&self) -> String {
        let up = |value: Option<f64>, digits: usize| {
            value.map_or("-".to_owned(), |value| rounded_up(value, digits))
        };
        let of = |figure: &dyn Fn(&ScheduleReport) -> String| {
            self.schedule.as_ref().map_or("-".to_owned(), figure)
        };
        let line = |figure, bound, schedule, unit: &str| BoundLine {
            figure,
            bound,
            schedule,
            unit: unit.to_owned(),
        };
        let mut lines = vec![line(
            "items picked, at most",
            self.picks_upper_bound.to_string(),
            of(&|s| s.picked.to_string()),
            &format!("of {}", self.of("")),
        )];
        if self.weighs && self.weight_upper_bound.is_some() {
            lines.push(line(
                "weight picked, at most",
                up(self.weight_upper_bound, 3),
                of(&|s| fixed(s.weight, 3)),
                "",
            ));
        }
        lines.push(line(
            "picking rate, at most",
            up(self.picking_rate_upper_bound_per_min, 2),
            of(&|s| fixed(s.picking_rate_per_min, 2)),
            "1/min",
        ));
        if self.weighs && self.weighted_rate_upper_bound_per_min.is_some() {
            lines.push(line(
                "weighted rate, at most",
                up(self.weighted_rate_upper_bound_per_min, 2),
                of(&|s| fixed(s.weighted_rate_per_min, 2)),
                "1/min",
            ));
        }
        lines.push(line(
            "end of the run, at least",
            rounded_down(self.end_lower_bound_s, 1),
            of(&|s| fixed(s.end_s, 1)),
            "s",
        ));
        TableColumns::new()
            .with("<figure", |line: &BoundLine| line.figure.to_owned())
            .with("no strategy beats", |line| line.bound.clone())
            .with("a schedule has", |line| line.schedule.clone())
            .with("<unit", |line| line.unit.clone())
            .table(lines)
    }
}

/// A line of the table of figures.
struct BoundLine {
    figure: &'static str,
    bound: String,
    schedule: String,
    unit: String,
}
