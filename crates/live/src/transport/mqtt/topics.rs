//! The topics: which message goes to which, and what each means.

use crate::protocol::{Hello, Incoming, Message, Outgoing};
use crate::transport::Side;
use pickline::error::{Error, Result, shown};
use pickline::names::LONGEST_NAME;

impl Side {
    /// The topic under the prefix for its presence.
    pub(crate) fn presence(self) -> &'static str {
        match self {
            Self::Node => "node",
            Self::Station => "station",
        }
    }

    /// The kinds of messages that it receives.
    pub(crate) fn hears(self) -> &'static [&'static str] {
        match self {
            Self::Node => &Incoming::KINDS,
            Self::Station => &Outgoing::KINDS,
        }
    }
}

/// The content of a topic.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Topic<'a> {
    /// A message of this kind.
    Kind(&'a str),
    /// The presence of this side.
    Presence(Side),
}

/// The topics under one prefix.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct MqttTopics {
    prefix: String,
}

impl MqttTopics {
    /// The topics under `prefix`.
    ///
    /// # Errors
    /// The prefix is not a valid topic.
    pub(crate) fn new(prefix: &str) -> Result<Self> {
        let levels = prefix.split('/').all(|level| !level.is_empty());
        let letters = |c: char| !c.is_control() && !"+#".contains(c);
        let short = prefix.len() <= LONGEST_NAME;
        if levels && short && prefix.chars().all(letters) && !prefix.starts_with('$') {
            return Ok(Self {
                prefix: prefix.to_owned(),
            });
        }
        Err(Error::usage(
            "'mqtt_prefix'",
            format!("`{}` is not a valid topic prefix", shown(prefix)),
            "give words separated by /, without + and #, for example plant/line1",
        ))
    }

    /// The topic for the presence of `side`.
    pub(crate) fn presence(&self, side: Side) -> String {
        format!("{}/{}", self.prefix, side.presence())
    }

    /// The topic filter for a kind of message: the kind and any levels below it.
    pub(crate) fn filter(&self, kind: &str) -> String {
        format!("{}/{kind}/#", self.prefix)
    }

    /// The topic of `message`.
    pub(crate) fn of(&self, message: &Message) -> String {
        let (kind, whose) = match message {
            Message::ToNode(message) => (message.kind(), None),
            Message::FromNode(message) => (message.kind(), message.robot()),
            // Sent over streams only.
            Message::Hello(_) | Message::Answer(_) => (Hello::KIND, None),
        };
        match whose {
            Some(robot) => format!("{}/{kind}/{}", self.prefix, level(robot)),
            None => format!("{}/{kind}", self.prefix),
        }
    }

    /// The meaning of `topic` for `side`, if it has one.
    pub(crate) fn read<'a>(&self, side: Side, topic: &'a str) -> Option<Topic<'a>> {
        let rest = topic.strip_prefix(&self.prefix)?.strip_prefix('/')?;
        let kind = rest.split('/').next()?;
        if side.hears().contains(&kind) {
            return Some(Topic::Kind(kind));
        }
        let sides = [Side::Node, Side::Station].into_iter();
        let mut present = sides.filter(|side| side.presence() == rest);
        present.next().map(Topic::Presence)
    }
}

/// A name as one level of a topic: special characters are written as %XX.
fn level(name: &str) -> String {
    let mut level = String::new();
    for c in name.chars() {
        if "/+#%".contains(c) {
            level += &format!("%{:02X}", u32::from(c));
        } else {
            level.push(c);
        }
    }
    level
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocol::{Ack, Cancel};

    #[test]
    fn messages_have_their_topics() {
        let topics = MqttTopics::new("plant/line1").unwrap();
        let cancel = |robot: &str| {
            Message::from(Outgoing::Cancel(Cancel {
                stamp: 0.0,
                task: 1,
                robot: robot.into(),
                reason: "none".into(),
            }))
        };
        assert_eq!(topics.of(&cancel("r1")), "plant/line1/cancel/r1");
        assert_eq!(
            topics.of(&cancel("a/+#%\u{e9}")),
            "plant/line1/cancel/a%2F%2B%23%25\u{e9}"
        );
        let (stamp, task) = (0.0, 1);
        let ack = Incoming::Ack(Ack { stamp, task });
        assert_eq!(topics.of(&ack.into()), "plant/line1/ack");
        let read = |side, topic| topics.read(side, topic);
        assert_eq!(
            read(Side::Node, "plant/line1/ack/r1"),
            Some(Topic::Kind("ack"))
        );
        assert_eq!(read(Side::Node, "plant/line1/task/r1"), None);
        assert_eq!(
            read(Side::Station, "plant/line1/task/r1"),
            Some(Topic::Kind("task"))
        );
        let station = Topic::Presence(Side::Station);
        assert_eq!(read(Side::Node, "plant/line1/station"), Some(station));
        assert_eq!(read(Side::Node, "plant/line10/ack"), None);
    }

    #[test]
    fn what_is_no_prefix_is_refused() {
        for prefix in ["", "/a", "a/", "a//b", "a+", "#", "$SYS", "a\nb"] {
            let error = MqttTopics::new(prefix).unwrap_err().to_string();
            assert!(error.contains("'mqtt_prefix'"), "{error}");
        }
    }
}
