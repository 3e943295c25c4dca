//! `pickline run --replay`: repeats a recorded run.

use super::live_strategy::{allowance, live_strategy};
use super::remarks::Remarks;
use super::session::Session;
use super::settings::parse_strategy;
use pickline::error::{Error, Result, shown};
use pickline::station::{Overrides, parse};
use pickline::study::BlueprintOptions;
use pickline_live::protocol::{Rejection, encode};
use pickline_live::recording::{RecordedEvent, RecordingEnd, RecordingEntry, RecordingReader};
use pickline_live::{ClockKind, Controller};
use serde_json::Value;
use std::collections::VecDeque;
use std::path::PathBuf;

/// How much output is printed at a time [bytes].
const BLOCK: usize = 1 << 16;

/// A replay, with the recording's own settings unless others are given.
pub(crate) struct ReplayPlan {
    /// The recording.
    pub file: PathBuf,
    /// Another strategy.
    pub strategy: Option<String>,
    /// Another budget of a decision [ms].
    pub budget_ms: Option<f64>,
    /// [`ClockKind::Messages`] to use the recorded timestamps even if the run used the system
    /// clock.
    pub clock: ClockKind,
    pub remarks: Remarks,
    pub quiet: bool,
}

impl ReplayPlan {
    /// Replays the recording and reports how far the output matches the recorded one.
    pub(crate) fn run(&self, session: &Session) -> Result<()> {
        let mut reader = RecordingReader::open(&self.file)?;
        let (controller, clock) = self.recorded_line(&mut reader, session)?;
        let mut replay = Replay {
            controller,
            clock,
            recorded: VecDeque::new(),
            said: VecDeque::new(),
            same: 0,
            difference: None,
            output: String::new(),
        };
        while let Some(entry) = reader.next_entry()? {
            replay.take(entry);
            replay.print(session, BLOCK)?;
        }
        if clock != reader.heading.config().map_or(clock, |config| config.clock) {
            replay.controller.finish();
            replay.collect();
        }
        replay.print(session, 0)?;
        let mut verdict = replay.verdict(reader.ending());
        for doubt in reader.doubts() {
            verdict += &format!("\n  {doubt}");
        }
        self.remarks.remark(&verdict);
        Ok(())
    }

    /// The line as it was when the recording began, and its clock.
    fn recorded_line(
        &self,
        reader: &mut RecordingReader,
        session: &Session,
    ) -> Result<(Controller, ClockKind)> {
        let name = &self.file.display().to_string();
        let heading = reader.heading.clone();
        let none = Overrides::default();
        let station = parse(&heading.station, "its station", none).map_err(|e| e.inside(name))?;
        let config = heading.config().ok_or_else(|| {
            let problem = format!("unknown clock `{}`", shown(&heading.clock));
            let cure = "give a file that `pickline run --record` wrote";
            Error::input(name, problem, cure)
        })?;
        let clock = match self.clock {
            ClockKind::Messages => ClockKind::Messages,
            ClockKind::System => config.clock,
        };
        let text = self.strategy.as_ref().unwrap_or(&heading.strategy);
        let recorded = self.strategy.is_none().then_some(heading.budget_ms);
        let allowance = allowance(self.budget_ms.or(recorded.flatten()), clock)?;
        let options = BlueprintOptions::default()
            .with_seed(heading.seed)
            .with_allowance(allowance);
        let strategy = parse_strategy(text, self.quiet)?;
        let strategy = live_strategy(&strategy, &options, self.quiet, &station, session)?.make();
        self.remarks.remark(&format!(
            "replaying {name}, recorded by {}: {}",
            heading.program, heading.command
        ));
        // With the system clock, the recorded requests for a status are repeated.
        let status_every = if clock == config.clock {
            config.status_every
        } else {
            0.0
        };
        let config = config.with_clock(clock).with_status_every(status_every);
        let made = match reader.state.take() {
            None => Controller::new(station, strategy, config),
            Some(state) => {
                let stamp = heading.restored_at;
                Controller::restore(station, strategy, config, state, stamp)
            }
        };
        let controller = made.map_err(|error| error.inside(name).into_input())?;
        Ok((controller, clock))
    }
}

struct Replay {
    controller: Controller,
    clock: ClockKind,
    /// Recorded lines still to be compared.
    recorded: VecDeque<String>,
    said: VecDeque<String>,
    /// Number of identical lines, from the first on.
    same: u64,
    /// The first two lines that differ.
    difference: Option<(String, String)>,
    /// Output still to be printed.
    output: String,
}

impl Replay {
    fn take(&mut self, entry: RecordingEntry) {
        match entry {
            RecordingEntry::In(message, received) => {
                // A refused message is refused and counted again.
                let _ = match self.clock {
                    ClockKind::System => self.controller.hear(message, received),
                    ClockKind::Messages => self.controller.handle(message),
                };
            }
            RecordingEntry::Out(line) => {
                if self.difference.is_none() {
                    self.recorded.push_back(line);
                }
            }
            RecordingEntry::Event(event) => self.happen(&event),
        }
        self.collect();
    }

    fn happen(&mut self, event: &RecordedEvent) {
        match event {
            RecordedEvent::Step {
                stamp,
                held,
                held_robots,
                ahead,
            } => {
                if self.clock == ClockKind::System {
                    let all: Vec<usize> = (0..self.robots()).collect();
                    self.controller.set_clock_ahead(*ahead);
                    self.controller.hold(if *held { &all } else { held_robots });
                    self.controller.advance(*stamp);
                }
            }
            RecordedEvent::Joined {} => self.controller.send_again(),
            RecordedEvent::Connected {} => self.controller.repeat(),
            RecordedEvent::Welcomed {} => self.controller.send_open_tasks(),
            RecordedEvent::Spoken { robot } => {
                // May be out of range in a recording that was edited.
                if *robot < self.robots() {
                    self.controller.send_again_to(*robot);
                }
            }
            RecordedEvent::Refused { reason } => {
                if let Some(reason) = Rejection::named(reason) {
                    self.controller.count_rejected(reason);
                }
            }
            RecordedEvent::Report { last, queued } => self.controller.report(*last, *queued),
            RecordedEvent::Finished {} => self.controller.finish(),
            RecordedEvent::Stopped {} => self.controller.stop(),
        }
    }

    fn robots(&self) -> usize {
        self.controller.station().robots().len()
    }

    /// Collects the controller's output and compares it with the recorded output.
    fn collect(&mut self) {
        for message in self.controller.take_output() {
            let line = encode(&message);
            if self.difference.is_none() {
                self.said.push_back(line.trim_end().to_owned());
            }
            self.output += &line;
        }
        while self.difference.is_none()
            && let (Some(said), Some(recorded)) = (self.said.front(), self.recorded.front())
        {
            if said == recorded || is_same_status(said, recorded) {
                self.same += 1;
                self.said.pop_front();
                self.recorded.pop_front();
            } else {
                self.difference = Some((recorded.clone(), said.clone()));
            }
        }
    }

    fn print(&mut self, session: &Session, most: usize) -> Result<()> {
        if self.output.len() > most {
            session.print(self.output.as_bytes())?;
            self.output.clear();
        }
        Ok(())
    }

    fn verdict(&self, ending: RecordingEnd) -> String {
        let same = match self.same {
            1 => "1 message is".to_owned(),
            same => format!("{same} messages are"),
        };
        let mut text = match (&self.difference, self.recorded.front()) {
            (Some((recorded, said)), _) => format!(
                "{same} as recorded, then they differ\n  recorded: {recorded}\n  \
                 now:      {said}"
            ),
            (None, Some(recorded)) => format!(
                "{same} as recorded, then the recording has more\n  \
                 recorded: {recorded}"
            ),
            // A truncated recording lacks the last answers.
            (None, None) if !self.said.is_empty() && ending == RecordingEnd::Whole => {
                let more = &self.said[0];
                format!("{same} as recorded, then the replay has more\n  now:      {more}")
            }
            (None, None) if self.same == 1 => format!("{same} as recorded"),
            (None, None) => format!("all {same} as recorded"),
        };
        let ending = match ending {
            RecordingEnd::Whole => return text,
            RecordingEnd::Open => "the recording was not finished and ends here",
            RecordingEnd::Torn => "the recording ends within a record and is replayed up to there",
        };
        // On a separate line after a recorded line, which may be long.
        text += if text.contains('\n') { "\n  " } else { "; " };
        text + ending
    }
}

/// Whether two statuses differ only in the decision times, which always vary, and in fields
/// that the recording version did not send.
fn is_same_status(said: &str, recorded: &str) -> bool {
    let status = |line: &str| match serde_json::from_str(line) {
        Ok(Value::Object(mut fields)) if fields.get("kind") == Some(&"status".into()) => {
            fields.remove("latency");
            Some(Value::Object(fields))
        }
        _ => None,
    };
    match (status(said), status(recorded)) {
        (Some(said), Some(recorded)) => has_all(&said, &recorded),
        _ => false,
    }
}

/// Whether `said` has every field of `recorded` with the same value; it may have more. Counts
/// by reason must match exactly: an additional reason is a difference.
fn has_all(said: &Value, recorded: &Value) -> bool {
    match (said, recorded) {
        (Value::Object(said), Value::Object(recorded)) => {
            recorded.iter().all(|(name, value)| match said.get(name) {
                Some(own) if ["rejected", "noted"].contains(&name.as_str()) => own == value,
                Some(own) => has_all(own, value),
                None => false,
            })
        }
        (Value::Array(said), Value::Array(recorded)) => {
            let pairs = || said.iter().zip(recorded);
            said.len() == recorded.len() && pairs().all(|(own, value)| has_all(own, value))
        }
        (said, recorded) => said == recorded,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_status_without_a_field_of_later_versions_is_the_same() {
        let status = |layout: &str, seen: u32| {
            format!(
                "{{\"v\":1,\"kind\":\"status\",\"stamp\":1.0,\"last\":false,{layout}\"seen\":{seen},\
                 \"picked\":0,\"picked_share\":0.0,\"picks_per_min\":0.0,\"missed\":{{\
                 \"unreachable\":0,\"grasp_failed\":0,\"no_result\":0,\"passed_over\":0,\"busy\":0}},\
                 \"on_belt\":8,\"claimed\":0,\"open_tasks\":[],\"queued\":0,\"rejected\":{{}},\
                 \"noted\":{{}},\"robots\":[]}}"
            )
        };
        let layout = "\"layout\":\"542b1be4f7f7c276\",";
        let now = status(layout, 8);
        assert!(is_same_status(&now, &status("", 8)));
        assert!(!is_same_status(&now, &status("", 7)));
        let counted = now.replace(r#""rejected":{}"#, r#""rejected":{"stamp":1}"#);
        assert!(!is_same_status(&counted, &now));
        assert!(!is_same_status(&now, &status("\"layout\":\"0\",", 8)));
    }
}
