//! The figures of a live line in Prometheus' text format 0.0.4
//! (<https://prometheus.io/docs/instrumenting/exposition_formats/>).
//!
//! Each metric is one row of [`metrics`]; `docs/protocol.md` has the table of them.

use pickline_live::LineView;
use pickline_live::protocol::{SourceReport, Status};
use std::fmt::{Display, Write as _};

/// The states of a robot, as named in a status.
const ROBOT_STATES: [&str; 5] = ["idle", "busy", "fault", "silent", "unknown"];

/// The page of metrics for `view`; `strategy` is the name of the line's strategy.
pub fn metrics(view: &LineView, strategy: &str) -> String {
    let status = &view.status;
    let mut page = MetricsText::default();
    let version = env!("CARGO_PKG_VERSION");
    page.metric("pickline_info", "gauge", "Program and strategy; always 1.");
    page.sample(&[("version", version), ("strategy", strategy)], 1);
    page.single(
        "pickline_stamp_seconds",
        "gauge",
        "Time of these figures [s], on the clock of the messages.",
        status.stamp,
    );
    page.single(
        "pickline_belt_speed_metres_per_second",
        "gauge",
        "Last measured speed of the belt [m/s].",
        view.belt_speed,
    );
    page.single(
        "pickline_items_seen_total",
        "counter",
        "Items seen.",
        status.seen,
    );
    page.single(
        "pickline_items_picked_total",
        "counter",
        "Items picked.",
        status.picked,
    );
    let missed = "Items not picked, by reason; a late result may subtract one.";
    page.metric("pickline_items_missed", "gauge", missed);
    // Serializing covers every reason; counts by name always convert to JSON.
    let reasons = serde_json::to_value(status.missed).unwrap_or_default();
    for (reason, count) in reasons.as_object().into_iter().flatten() {
        page.sample(&[("reason", reason)], count);
    }
    for (name, help, count) in [
        (
            "pickline_items_on_belt",
            "Items that may still be picked.",
            status.on_belt,
        ),
        (
            "pickline_items_claimed",
            "Items that are assigned to a robot.",
            status.claimed,
        ),
        (
            "pickline_tasks_open",
            "Tasks without a result yet.",
            status.open_tasks.len() as u64,
        ),
        (
            "pickline_messages_queued",
            "Messages waiting to be sent.",
            status.queued,
        ),
    ] {
        page.single(name, "gauge", help, count);
    }
    if let Some(unwanted) = status.unwanted {
        let help = "Items that are left on the belt on purpose.";
        page.single("pickline_items_unwanted", "gauge", help, unwanted);
    }
    page.robots(status);
    page.sources(view);
    let help = "Messages that were refused, by reason.";
    page.metric("pickline_messages_rejected_total", "counter", help);
    for (reason, count) in &status.rejected {
        page.sample(&[("reason", reason)], count);
    }
    let help = "Unusual events, by kind.";
    page.metric("pickline_events_noted_total", "counter", help);
    for (event, count) in &status.noted {
        page.sample(&[("event", event)], count);
    }
    page.histogram(view);
    page.text
}

/// A page of metrics that is being written.
#[derive(Default)]
struct MetricsText {
    text: String,
    /// The metric whose samples are being written.
    name: &'static str,
}

// Writing into a string never fails.
impl MetricsText {
    /// The figures of each robot.
    fn robots(&mut self, status: &Status) {
        self.metric(
            "pickline_robot_picks_total",
            "counter",
            "Successful picks of a robot.",
        );
        for robot in &status.robots {
            self.sample(&[("robot", &robot.name)], robot.picked);
        }
        let help = "Failed attempts of a robot.";
        self.metric("pickline_robot_failures_total", "counter", help);
        for robot in &status.robots {
            self.sample(&[("robot", &robot.name)], robot.failed);
        }
        let help = "1 for the state that a robot is in, 0 for the others.";
        self.metric("pickline_robot_state", "gauge", help);
        for robot in &status.robots {
            let known = ROBOT_STATES.into_iter();
            let other = Some(&*robot.state).filter(|state| !ROBOT_STATES.contains(state));
            for state in known.chain(other) {
                let labels = [("robot", &*robot.name), ("state", state)];
                self.sample(&labels, u8::from(state == robot.state));
            }
        }
    }

    /// Starts a metric: its help text and its type.
    fn metric(&mut self, name: &'static str, kind: &str, help: &str) {
        self.name = name;
        let _ = write!(self.text, "# HELP {name} {help}\n# TYPE {name} {kind}\n");
    }

    /// A metric with a single sample without labels.
    fn single(&mut self, name: &'static str, kind: &str, help: &str, value: impl Display) {
        self.metric(name, kind, help);
        self.sample(&[], value);
    }

    /// A sample of the current metric.
    fn sample(&mut self, labels: &[(&str, &str)], value: impl Display) {
        self.part("", labels, value);
    }

    /// A sample of the current metric, with `suffix` appended to its name.
    fn part(&mut self, suffix: &str, labels: &[(&str, &str)], value: impl Display) {
        let _ = write!(self.text, "{}{suffix}", self.name);
        for (i, (label, text)) in labels.iter().enumerate() {
            let sign = if i == 0 { '{' } else { ',' };
            let _ = write!(self.text, "{sign}{label}=\"{}\"", escaped(text));
        }
        let end = if labels.is_empty() { "" } else { "}" };
        let _ = writeln!(self.text, "{end} {value}");
    }

    /// Age, clock offset and silence of each source.
    fn sources(&mut self, view: &LineView) {
        type SourceFigure = fn(&SourceReport) -> Option<f64>;
        let figures: [(&str, &str, SourceFigure); 3] = [
            (
                "pickline_source_age_seconds",
                "Time since the last message of a source [s].",
                |source| Some(source.age),
            ),
            (
                "pickline_source_offset_seconds",
                "Smallest time from a source's timestamp to the arrival of its message [s].",
                |source| source.offset,
            ),
            (
                "pickline_source_overdue",
                "1 if a source has been silent for longer than expected.",
                |source| Some(f64::from(u8::from(source.overdue))),
            ),
        ];
        for (name, help, figure) in figures {
            self.metric(name, "gauge", help);
            for source in &view.status.sources {
                let kind = serde_json::to_value(source.kind).unwrap_or_default();
                let kind = kind.as_str().unwrap_or_default();
                if let Some(value) = figure(source) {
                    self.sample(&[("source", &source.name), ("kind", kind)], value);
                }
            }
        }
    }

    /// The histogram of the decision times.
    fn histogram(&mut self, view: &LineView) {
        let times = &view.decision_times;
        let help = "Duration of decisions [s].";
        self.metric("pickline_decision_duration_seconds", "histogram", help);
        for (limit, count) in &times.within {
            self.part("_bucket", &[("le", &limit.to_string())], count);
        }
        self.part("_bucket", &[("le", "+Inf")], times.count);
        self.part("_sum", &[], times.sum);
        self.part("_count", &[], times.count);
    }
}

/// Escapes a label's value, because names come from outside.
fn escaped(text: &str) -> String {
    text.replace('\\', "\\\\")
        .replace('"', "\\\"")
        .replace('\n', "\\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line that takes every item has no such metric.
    #[test]
    fn unwanted_items_are_a_metric_of_lines_that_leave_them() {
        let mut view = LineView::default();
        assert!(!metrics(&view, "s").contains("unwanted"));
        view.status.unwanted = Some(7);
        let page = metrics(&view, "s");
        let samples = page.lines().filter(|line| line.contains("unwanted"));
        let samples: Vec<&str> = samples.filter(|line| !line.starts_with('#')).collect();
        assert_eq!(samples, ["pickline_items_unwanted 7"]);
    }
}
