//! `pickline run --replay`: a recorded run again.

use super::args::RunArgs;
use super::run::{allowance, blueprint};
use super::session::Session;
use pickline::error::{Error, Result, shown};
use pickline_live::protocol::{Rejection, encode};
use pickline_live::recording::{Ending, Entry, Event, Reader};
use pickline_live::{ClockKind, Config, Controller};
use pickline::station::{Overrides, parse};
use serde_json::Value;
use std::collections::VecDeque;
use std::path::Path;

/// What is printed at once [bytes].
const BLOCK: usize = 1 << 16;

/// Runs the recording in `file` again, with its own settings unless others are given, and
/// tells how far the output is the recorded one.
pub fn replay(args: &RunArgs, file: &Path, session: &Session) -> Result<()> {
    let mut reader = Reader::open(file)?;
    let name = file.display().to_string();
    let heading = reader.heading.clone();
    let none = Overrides {
        robots: None,
        belt_speed: None,
    };
    let station = parse(&heading.station, "its station", none).map_err(|e| e.inside(&name))?;
    let config = heading.config().ok_or_else(|| {
        let problem = format!("its clock is `{}`", shown(&heading.clock));
        Error::input(
            &name,
            problem,
            "give a file that `pickline run --record` wrote",
        )
    })?;
    let by_stamps = args.transport.clock() == ClockKind::Messages;
    let clock = if by_stamps {
        ClockKind::Messages
    } else {
        config.clock
    };
    let text = args.strategy.as_ref().unwrap_or(&heading.strategy);
    let recorded = args.strategy.is_none().then_some(heading.budget_ms);
    let allowance = allowance(args.budget_ms.or(recorded.flatten()), clock)?;
    let quiet = args.transport.quiet;
    let strategy = blueprint(text, heading.seed, quiet, &station, session, allowance)?.make();
    args.transport.remark(&format!(
        "replaying {name}, which {} made by: {}",
        heading.program, heading.command
    ));
    // Where the system clock ruled, statuses were asked for, and are again.
    let status_every = if clock == config.clock {
        config.status_every
    } else {
        0.0
    };
    let config = Config {
        clock,
        status_every,
        ..config
    };
    let controller = match reader.state.take() {
        None => Controller::new(station, strategy, config),
        Some(state) => {
            let stamp = heading.restored_at;
            let made = Controller::restore(station, strategy, config, state, stamp);
            made.map_err(|error| error.inside(&name))?
        }
    };
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
    args.transport.remark(&verdict);
    Ok(())
}

struct Replay {
    controller: Controller,
    clock: ClockKind,
    /// Lines that are still to be compared.
    recorded: VecDeque<String>,
    said: VecDeque<String>,
    /// Lines that are the same, from the first on.
    same: u64,
    /// The first two lines that are not.
    difference: Option<(String, String)>,
    /// What is still to be printed.
    output: String,
}

impl Replay {
    fn take(&mut self, entry: Entry) {
        match entry {
            Entry::In(message, received) => {
                // What was refused is refused again, and counted.
                let _ = match self.clock {
                    ClockKind::System => self.controller.hear(message, received),
                    ClockKind::Messages => self.controller.handle(message),
                };
            }
            Entry::Out(line) => {
                if self.difference.is_none() {
                    self.recorded.push_back(line);
                }
            }
            Entry::Event(event) => self.happen(&event),
        }
        self.collect();
    }

    fn happen(&mut self, event: &Event) {
        match event {
            Event::Step {
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
            Event::Joined {} => self.controller.send_again(),
            Event::Connected {} => self.controller.repeat(),
            Event::Welcomed {} => self.controller.tell_open(),
            Event::Spoken { robot } => {
                // Of a recording that somebody has changed.
                if *robot < self.robots() {
                    self.controller.send_again_to(*robot);
                }
            }
            Event::Refused { reason } => {
                if let Some(reason) = Rejection::named(reason) {
                    self.controller.count_rejected(reason);
                }
            }
            Event::Report { last, queued } => self.controller.report(*last, *queued),
            Event::Finished {} => self.controller.finish(),
            Event::Stopped {} => self.controller.stop(),
        }
    }

    fn robots(&self) -> usize {
        self.controller.station().robots().len()
    }

    /// Takes what the controller says, and compares it with what was recorded.
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

    fn verdict(&self, ending: Ending) -> String {
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
            // A recording that was cut off lacks the last answers.
            (None, None) if !self.said.is_empty() && ending == Ending::Whole => {
                let more = &self.said[0];
                format!("{same} as recorded, then there are more\n  now:      {more}")
            }
            (None, None) if self.same == 1 => format!("{same} as recorded"),
            (None, None) => format!("all {same} as recorded"),
        };
        let ending = match ending {
            Ending::Whole => return text,
            Ending::Open => "the recording was not finished, and goes no further",
            Ending::Torn => {
                "the recording stops in the midst of a record, and is replayed up to there"
            }
        };
        // Not at the end of a recorded line, which may be long.
        text += if text.contains('\n') { "\n  " } else { "; " };
        text + ending
    }
}

/// Whether two statuses differ in nothing but how long decisions took, which is never the
/// same, and what the version that recorded did not send.
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

/// Whether `said` has every field of `recorded` with its value, whatever else it has. Counts by
/// reason are not fields: one more is another count.
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
