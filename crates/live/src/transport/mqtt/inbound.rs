//! From the broker to the inbox: a thread that may block, so that the connection never has to.

use super::topics::{MqttTopics, Topic};
use crate::protocol::{LONGEST_LINE, Rejected, Rejection};
use crate::transport::{Origin, Side, TransportEvent};
use pickline::error::{Error, shown};
use rumqttc::Publish;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use tokio::sync::mpsc::{Receiver, UnboundedSender};
use tokio::sync::watch;

/// Events for the inbox, in order.
#[derive(Debug)]
pub(crate) enum ConnectionEvent {
    /// A message, and the connection (counted from 1) that brought it.
    Message(u64, Publish),
    /// Over this connection the broker has accepted the subscriptions and this side's presence.
    Greeted(u64),
    /// The connection is lost.
    Lost,
    /// A remark for the user.
    Remark(String),
    /// A fatal error.
    Failed(Error),
}

/// What the connection must do in response to an event.
#[derive(Debug)]
pub(crate) enum ConnectionCommand {
    /// Acknowledge a message, if this connection still exists.
    Acknowledge(u64, Box<Publish>),
    /// Publish the presence of this side again.
    Present,
}

/// The presence of a side, which the broker retains.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Presence {
    /// `online` or `offline`.
    pub state: String,
    /// Client id of the sender.
    pub client: String,
}

/// The state of the thread.
#[derive(Debug)]
pub(crate) struct Inbound {
    /// The number of the peer.
    pub number: u64,
    /// Which side this is.
    pub side: Side,
    /// The names of the topics that messages come on.
    pub topics: MqttTopics,
    /// This side's client id.
    pub client: String,
    /// Whether the peer is present.
    pub up: Arc<AtomicBool>,
    /// Whether it was ever present.
    pub ever_up: bool,
    /// The hub's inbox, for messages and events.
    pub inbox: SyncSender<TransportEvent>,
    /// Orders to the connection.
    pub orders: UnboundedSender<ConnectionCommand>,
    /// The connection over which the peer is reachable.
    pub ready: watch::Sender<u64>,
}

impl Inbound {
    /// Passes on events until the connection or the receiver is gone.
    pub(crate) fn run(mut self, mut news: Receiver<ConnectionEvent>) {
        while let Some(news) = news.blocking_recv() {
            let (heard, order) = match news {
                ConnectionEvent::Message(connection, mut publish) => {
                    let heard = self.read(connection, &publish);
                    // The acknowledgement may have to wait, but the content need not be kept.
                    (publish.topic, publish.payload) = Default::default();
                    publish.properties = None;
                    let order = ConnectionCommand::Acknowledge(connection, Box::new(publish));
                    (heard, Some(order))
                }
                ConnectionEvent::Greeted(connection) if self.side == Side::Node => {
                    (self.rise(connection), None)
                }
                // The station waits for the node's presence.
                ConnectionEvent::Greeted(_) => (None, None),
                ConnectionEvent::Lost => {
                    let was_up = self.up.swap(false, Ordering::Relaxed);
                    (was_up.then_some(TransportEvent::Down(self.number)), None)
                }
                ConnectionEvent::Remark(text) => (Some(TransportEvent::Remark(text)), None),
                ConnectionEvent::Failed(error) => (Some(TransportEvent::Failed(error)), None),
            };
            if heard.is_some_and(|heard| self.inbox.send(heard).is_err()) {
                return;
            }
            // Only now is it safe, because the broker sends unacknowledged messages again.
            if let Some(order) = order {
                let _ = self.orders.send(order);
            }
        }
    }

    fn rise(&mut self, connection: u64) -> Option<TransportEvent> {
        self.ever_up = true;
        self.ready.send_replace(connection);
        let was_up = self.up.swap(true, Ordering::Relaxed);
        (!was_up).then_some(TransportEvent::Up(self.number))
    }

    fn read(&mut self, connection: u64, publish: &Publish) -> Option<TransportEvent> {
        let topic = String::from_utf8_lossy(&publish.topic);
        let origin = Origin::Topic(topic.as_ref().into());
        if topic.as_bytes() != &publish.topic[..] {
            let problem = "the topic is not valid UTF-8";
            let rejected = Rejected::new(Rejection::Syntax, problem);
            return Some(TransportEvent::Refused(origin, rejected));
        }
        let kind = match self.topics.read(self.side, &topic) {
            Some(Topic::Presence(side)) => return self.hear_presence(connection, side, publish),
            Some(Topic::Kind(kind)) => kind,
            None => return None,
        };
        if publish.payload.len() > LONGEST_LINE {
            return Some(TransportEvent::Refused(origin, Rejected::too_long()));
        }
        #[derive(Deserialize)]
        struct MessageKind {
            kind: String,
        }
        // Topics may have permissions, so a message must be of its topic's kind.
        if let Ok(said) = serde_json::from_slice::<MessageKind>(&publish.payload)
            && said.kind != kind
        {
            let problem = format!(
                "kind `{}`; expected `{kind}` on this topic",
                shown(&said.kind)
            );
            let rejected = Rejected::new(Rejection::Kind, problem);
            return Some(TransportEvent::Refused(origin, rejected));
        }
        Some(TransportEvent::Line(origin, publish.payload.to_vec()))
    }

    fn hear_presence(
        &mut self,
        connection: u64,
        side: Side,
        publish: &Publish,
    ) -> Option<TransportEvent> {
        let presence: Presence = serde_json::from_slice(&publish.payload).ok()?;
        let online = presence.state == "online";
        if side != self.side {
            return match (side, online) {
                (Side::Node, true) => self.rise(connection),
                (Side::Node, false) => {
                    let was_up = self.up.swap(false, Ordering::Relaxed);
                    was_up.then_some(TransportEvent::Ended(self.number))
                }
                // A retained presence is about an earlier station.
                (Side::Station, false) if !publish.retain => {
                    Some(TransportEvent::Ended(self.number))
                }
                (Side::Station, _) => None,
            };
        }
        if presence.client == self.client || side != Side::Node {
            return None;
        }
        // Two nodes would give each item to two robots. The first one stays.
        let other = shown(&presence.client);
        if self.ever_up {
            let _ = self.orders.send(ConnectionCommand::Present);
            return online.then(|| {
                TransportEvent::Remark(format!(
                    "another node, `{other}`, has started under the same topics"
                ))
            });
        }
        online.then(|| {
            TransportEvent::Failed(Error::usage(
                "'mqtt'",
                format!("another node, `{other}`, is running under the same topics"),
                "stop it, or give this node another 'mqtt_prefix'; if it has crashed, the broker \
                 notices within a minute",
            ))
        })
    }
}
