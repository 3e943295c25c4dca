//! The node in the ROS graph: it is created and spun, and its subscriptions are read.

use super::messages::RosMessage;
use super::rivals::{Stance, Watch};
use super::turns::{Endless, Sent, Turns};
use super::wires::{Ear, Mouth, NodeEars, StationEars, Wires};
use super::{Settings, incoming, outgoing};
use crate::protocol::{Rejected, Rejection, encode};
use crate::transport::peer::{Peer, Waiting};
use crate::transport::{Heard, Origin, Side};
use pickline::error::{Error, Result, shown};
use ros2_client::{Context, Node, NodeName, NodeOptions};
use rustdds::DomainParticipantBuilder;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::thread;
use std::time::Duration;
use tokio::sync::oneshot;

/// Interval of checks for other nodes.
const GLANCE: Duration = Duration::from_millis(50);
/// Number of consecutive checks that must find the other side, so that both ends have found each
/// other.
const STEADY: u32 = 10;
/// Time for delivering the last messages; there is no notification of delivery.
const LINGER: Duration = Duration::from_millis(500);
/// Pause before retrying a failed reader.
const BREATH: Duration = Duration::from_millis(10);

/// Starts the node's threads.
pub fn start(number: u64, settings: &Settings, inbox: SyncSender<Heard>) -> Result<Peer> {
    let networks = settings.networks.clone();
    let participant = DomainParticipantBuilder::new(settings.domain)
        .with_only_networks(networks)
        .build()
        .map_err(|error| {
            let problem = format!("cannot start DDS in domain {}: {error}", settings.domain);
            let cure = "check the addresses and that the ports of the domain are free";
            Error::input("--ros2", problem, cure)
        })?;
    let name = match settings.side {
        Side::Node => "pickline",
        Side::Station => "pickline_station",
    };
    let failed = |error: String| {
        let problem = format!(
            "{}/{name} is not a valid node: {error}",
            shown(&settings.namespace)
        );
        let cure = "give a namespace of letters, digits and underscores, for example /line1";
        Error::input("--ros2-namespace", problem, cure)
    };
    let name = NodeName::new(&settings.namespace, name);
    let name = name.map_err(|error| failed(error.to_string()))?;
    let options = NodeOptions::new()
        .enable_rosout(false)
        .start_parameter_services(false);
    let context = Context::from_domain_participant(participant);
    let context = context.map_err(|error| failed(error.to_string()))?;
    let node = context.new_node(name, options);
    let mut node = node.map_err(|error| failed(format!("{error:?}")))?;
    let watch = Watch::new(&context, &settings.namespace);
    let mut wires = Wires {
        node: &mut node,
        settings,
    };
    let failed = |error: ros2_client::error::CreateError| failed(error.to_string());
    let mouth = Arc::new(wires.mouth().map_err(failed)?);
    let ears = match settings.side {
        Side::Node => Ears::Node(Box::new(wires.node_ears().map_err(failed)?)),
        Side::Station => Ears::Station(Box::new(wires.station_ears().map_err(failed)?)),
    };
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_time()
        .build()
        .map_err(|error| Error::resources("--ros2", error.to_string(), "free some memory"))?;
    let up = Arc::new(AtomicBool::new(false));
    let listener = Listener {
        number,
        settings: settings.clone(),
        turns: settings.turns.then(RefCell::default),
        up: Arc::clone(&up),
        inbox,
    };
    let (end, ended) = oneshot::channel();
    let mouth_too = Arc::clone(&mouth);
    let listening = thread::spawn(move || {
        runtime.block_on(async {
            let Ok(spinner) = node.spinner() else {
                return;
            };
            tokio::select! {
                _ = spinner.spin() => {}
                () = listener.listen(&ears) => {}
                () = listener.look_around(&node, &mouth_too, &ears, watch) => {}
                _ = ended => {}
            }
        });
    });
    let (settings, there) = (settings.clone(), Arc::clone(&up));
    let peer = Peer::start(up, move |waiting| {
        speak(waiting, &mouth, &settings, &there);
    });
    // Tell the others that this node leaves, so that they need not find out.
    Ok(peer.ending(move || {
        let _ = end.send(());
        let _ = listening.join();
    }))
}

/// Publishes the queued messages.
fn speak(waiting: &mut Waiting, mouth: &Mouth, settings: &Settings, there: &AtomicBool) {
    while let Some(message) = waiting.next() {
        // Messages of a station before the node is there would be lost.
        while settings.side == Side::Station && !there.load(Ordering::Relaxed) {
            thread::sleep(GLANCE);
        }
        // Only a message that cannot be serialized fails, and ours always can.
        let _ = mouth.say(&message, &settings.frame);
    }
    if settings.turns {
        mouth.end(&settings.frame);
    }
    thread::sleep(LINGER);
}

/// The error for a turn that no one ends.
fn endless() -> Error {
    Error::input(
        "--clock messages",
        "no station that takes turns publishes on the topic `tick`",
        "omit --clock messages, or let `pickline emulate --clock messages` play the station",
    )
}

/// The subscriptions of one side.
enum Ears {
    Node(Box<NodeEars>),
    Station(Box<StationEars>),
}

/// Passes received messages to the inbox.
struct Listener {
    number: u64,
    settings: Settings,
    /// With message time, the messages held until a turn is over.
    turns: Option<RefCell<Turns>>,
    /// Whether the other side is there.
    up: Arc<AtomicBool>,
    inbox: SyncSender<Heard>,
}

impl Listener {
    /// Reads the subscriptions for ever.
    async fn listen(&self, ears: &Ears) {
        let frame = self.settings.frame.as_str();
        match ears {
            Ears::Node(ears) => {
                tokio::join!(
                    self.follow(&ears.detections, |m| {
                        let seen = incoming::read_detections(&m, frame).into_iter();
                        let heard = seen.map(|message| heard(&ears.detections, message));
                        (None, heard.collect())
                    }),
                    self.follow_one(&ears.belt, |m| incoming::read_belt(m, frame)),
                    self.follow_one(&ears.robots, incoming::read_robot),
                    self.follow_one(&ears.acks, incoming::read_ack),
                    self.follow_one(&ears.results, incoming::read_result),
                    self.follow(&ears.tick, |m| {
                        let heard = match m.last {
                            true => Heard::Ended(self.number),
                            false => heard(&ears.tick, Ok(incoming::read_tick(&m))),
                        };
                        (Some(m.messages), vec![heard])
                    }),
                );
            }
            Ears::Station(ears) => {
                tokio::join!(
                    self.follow_one(&ears.tasks, |m| Ok(outgoing::read_task(m))),
                    self.follow_one(&ears.cancels, |m| Ok(outgoing::read_cancel(m))),
                    self.follow_one(&ears.status, |m| Ok(outgoing::read_status(m))),
                    self.follow(&ears.due, |m| {
                        // The node's last message is its status.
                        let heard = match m.last {
                            true => Vec::new(),
                            false => vec![heard(&ears.due, Ok(outgoing::read_due(&m)))],
                        };
                        (Some(m.messages), heard)
                    }),
                );
            }
        }
    }

    /// Reads a topic whose messages stand for one message each and end no turn.
    async fn follow_one<R, M: Serialize>(
        &self,
        ear: &Ear<R>,
        read: impl Fn(&R) -> std::result::Result<M, Rejected>,
    ) where
        R: RosMessage + DeserializeOwned + 'static,
    {
        let one = |message: R| (None, vec![heard(ear, read(&message))]);
        self.follow(ear, one).await;
    }

    /// Passes on the messages of a topic. For a message that ends a turn, `read` also returns how
    /// many came before it.
    async fn follow<R>(&self, ear: &Ear<R>, read: impl Fn(R) -> (Option<u32>, Vec<Heard>))
    where
        R: RosMessage + DeserializeOwned + 'static,
    {
        loop {
            let heard = match ear.subscription.async_take().await {
                Ok((message, info)) => {
                    let (end, heard) = read(message);
                    match &self.turns {
                        Some(turns) => {
                            let at = info.source_timestamp().map_or(0, |time| time.to_nanos());
                            let sent = Sent::new(info.publisher_gid().as_bytes(), at);
                            let taken = turns.borrow_mut().take(sent, heard, end);
                            taken.unwrap_or_else(|Endless| vec![Heard::Failed(endless())])
                        }
                        None => heard,
                    }
                }
                Err(error) => {
                    tokio::time::sleep(BREATH).await;
                    let problem = format!("cannot read a {}/{}: {error}", R::PACKAGE, R::TYPE);
                    let refused = Rejected::new(Rejection::Syntax, problem);
                    vec![Heard::Refused(
                        Origin::Topic(Arc::clone(&ear.topic)),
                        refused,
                    )]
                }
            };
            // A turn begins once both sides know of each other, or the first tasks would wait.
            while self.turns.is_some() && !heard.is_empty() && !self.up.load(Ordering::Relaxed) {
                tokio::time::sleep(GLANCE).await;
            }
            for heard in heard {
                // Waiting here blocks only this node, because DDS has its own threads.
                if self.inbox.send(heard).is_err() {
                    return;
                }
            }
        }
    }

    /// Reports when the other side comes or goes.
    async fn look_around(&self, node: &Node, mouth: &Mouth, ears: &Ears, mut watch: Watch) {
        let mut steady = 0;
        loop {
            tokio::time::sleep(GLANCE).await;
            let hears = match ears {
                Ears::Node(_) => {
                    let stance = watch.look(self.up.load(Ordering::Relaxed));
                    let heard = self.tell_of_rivals(stance);
                    if heard.is_some_and(|heard| self.inbox.send(heard).is_err()) {
                        return;
                    }
                    matches!(stance, Stance::Stay | Stance::Warn)
                }
                Ears::Station(ears) => ears.tasks.subscription.get_publisher_count(node) > 0,
            };
            let there = hears && mouth.is_heard(node);
            steady = if there { steady + 1 } else { 0 };
            let heard = match (self.up.load(Ordering::Relaxed), there) {
                (false, true) if steady >= STEADY => Heard::Up(self.number),
                (true, false) if self.settings.side == Side::Node => Heard::Down(self.number),
                (true, false) => Heard::Ended(self.number),
                _ => continue,
            };
            self.up.store(there, Ordering::Relaxed);
            if self.inbox.send(heard).is_err() {
                return;
            }
        }
    }
    /// The event for another node under the same namespace.
    fn tell_of_rivals(&self, stance: Stance) -> Option<Heard> {
        let problem = format!("another node sends tasks under {}", self.settings.namespace);
        match stance {
            Stance::Stay | Stance::Wait => None,
            Stance::Warn => Some(Heard::Remark(problem)),
            Stance::GiveWay => Some(Heard::Failed(Error::input(
                "--ros2",
                problem,
                "stop it, or give this node another --ros2-namespace",
            ))),
        }
    }
}

/// The inbox event for a message.
fn heard<R, M: Serialize>(ear: &Ear<R>, message: std::result::Result<M, Rejected>) -> Heard {
    let origin = Origin::Topic(Arc::clone(&ear.topic));
    match message {
        Ok(message) => {
            let mut line = encode(&message).into_bytes();
            line.truncate(line.trim_ascii_end().len());
            Heard::Line(origin, line)
        }
        Err(rejected) => Heard::Refused(origin, rejected),
    }
}
