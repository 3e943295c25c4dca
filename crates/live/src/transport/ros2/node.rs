//! The node in the ROS graph: it is created and spun, and its subscriptions are read.

use super::messages::RosMessage;
use super::other_nodes::{NodeWatcher, Precedence};
use super::topics::{
    NodeSubscriptions, Publishers, StationSubscriptions, TopicFactory, TopicSubscription,
};
use super::turns::{Endless, Sent, Turns};
use super::{Ros2Settings, incoming, outgoing};
use crate::protocol::{Message, Rejected, Rejection};
use crate::transport::peer::{Peer, Waiting};
use crate::transport::{Origin, Side, TransportEvent};
use pickline::error::{Error, Result, shown};
use ros2_client::{Context, Node, NodeName, NodeOptions};
use rustdds::DomainParticipantBuilder;
use serde::de::DeserializeOwned;
use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::thread;
use std::time::Duration;
use tokio::sync::oneshot;

/// Interval of checks for other nodes.
const POLL_INTERVAL: Duration = Duration::from_millis(50);
/// Number of consecutive checks that must find the other side, so that both ends have found each
/// other.
const STEADY_POLLS: u32 = 10;
/// Time for delivering the last messages; there is no notification of delivery.
const DELIVERY_TIME: Duration = Duration::from_millis(500);
/// Pause before retrying a failed reader.
const READ_RETRY_DELAY: Duration = Duration::from_millis(10);

/// The name of this program's node.
fn node_name(side: Side) -> &'static str {
    match side {
        Side::Node => "pickline",
        Side::Station => "pickline_station",
    }
}

fn invalid_node(settings: &Ros2Settings, error: &str) -> Error {
    let (namespace, name) = (shown(&settings.namespace), node_name(settings.side));
    let problem = format!("{namespace}/{name} is not a valid node: {error}");
    let cure = "give a namespace of letters, digits and underscores, for example /line1";
    Error::usage("'ros2_namespace'", problem, cure)
}

/// Joins the DDS domain and creates the node.
fn create_node(settings: &Ros2Settings) -> Result<(Context, Node)> {
    let networks = settings.networks.clone();
    let participant = DomainParticipantBuilder::new(settings.domain)
        .with_only_networks(networks)
        .build()
        .map_err(|error| {
            let problem = format!("cannot start DDS in domain {}: {error}", settings.domain);
            let cure = "check the addresses and that the ports of the domain are free";
            Error::usage("'ros2'", problem, cure)
        })?;
    let failed = |error: String| invalid_node(settings, &error);
    let name = NodeName::new(&settings.namespace, node_name(settings.side));
    let name = name.map_err(|error| failed(error.to_string()))?;
    let options = NodeOptions::new()
        .enable_rosout(false)
        .start_parameter_services(false);
    let context = Context::from_domain_participant(participant);
    let context = context.map_err(|error| failed(error.to_string()))?;
    let node = context.new_node(name, options);
    let node = node.map_err(|error| failed(format!("{error:?}")))?;
    Ok((context, node))
}

/// Starts the node's threads.
pub(crate) fn start(
    number: u64,
    settings: &Ros2Settings,
    inbox: SyncSender<TransportEvent>,
) -> Result<Peer> {
    let (context, mut node) = create_node(settings)?;
    let watch = NodeWatcher::new(&context, &settings.namespace);
    let mut topics = TopicFactory {
        node: &mut node,
        settings,
    };
    let failed =
        |error: ros2_client::error::CreateError| invalid_node(settings, &error.to_string());
    let publishers = Arc::new(topics.publishers().map_err(failed)?);
    let subscriptions = match settings.side {
        Side::Node => Subscriptions::Node(Box::new(topics.node_subscriptions().map_err(failed)?)),
        Side::Station => {
            Subscriptions::Station(Box::new(topics.station_subscriptions().map_err(failed)?))
        }
    };
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_time()
        .build()
        .map_err(|error| Error::resources("'ros2'", error.to_string(), "free some memory"))?;
    let up = Arc::new(AtomicBool::new(false));
    let listener = Listener {
        number,
        settings: settings.clone(),
        turns: settings.turns.then(RefCell::default),
        up: Arc::clone(&up),
        inbox,
    };
    let (end, ended) = oneshot::channel();
    let same_publishers = Arc::clone(&publishers);
    let listening = thread::spawn(move || {
        runtime.block_on(async {
            let Ok(spinner) = node.spinner() else {
                return;
            };
            tokio::select! {
                _ = spinner.spin() => {}
                () = listener.listen(&subscriptions) => {}
                () = listener.monitor(&node, &same_publishers, &subscriptions, watch) => {}
                _ = ended => {}
            }
        });
    });
    let (settings, there) = (settings.clone(), Arc::clone(&up));
    let peer = Peer::start(up, move |waiting| {
        publish_all(waiting, &publishers, &settings, &there);
    });
    // Tell the others that this node leaves, so that they need not find out.
    Ok(peer.ending(move || {
        let _ = end.send(());
        let _ = listening.join();
    }))
}

/// Publishes the queued messages.
fn publish_all(
    waiting: &mut Waiting,
    publishers: &Publishers,
    settings: &Ros2Settings,
    there: &AtomicBool,
) {
    while let Some(message) = waiting.next() {
        // Messages of a station before the node is there would be lost.
        while settings.side == Side::Station && !there.load(Ordering::Relaxed) {
            thread::sleep(POLL_INTERVAL);
        }
        // Only a message that cannot be serialized fails, and ours always can.
        let _ = publishers.publish(&message, &settings.frame);
    }
    if settings.turns {
        publishers.end(&settings.frame);
    }
    thread::sleep(DELIVERY_TIME);
}

/// The error for a turn that no one ends.
fn endless() -> Error {
    Error::usage(
        "'clock' messages",
        "no station that takes turns publishes on the topic `tick`",
        "omit 'clock' messages, or let `pickline emulate` with 'clock' messages play the station",
    )
}

/// The subscriptions of one side.
enum Subscriptions {
    Node(Box<NodeSubscriptions>),
    Station(Box<StationSubscriptions>),
}

/// Passes received messages to the inbox.
struct Listener {
    number: u64,
    settings: Ros2Settings,
    /// With message time, the messages held until a turn is over.
    turns: Option<RefCell<Turns>>,
    /// Whether the other side is there.
    up: Arc<AtomicBool>,
    inbox: SyncSender<TransportEvent>,
}

impl Listener {
    /// Reads the subscriptions for ever.
    async fn listen(&self, subscriptions: &Subscriptions) {
        let frame = self.settings.frame.as_str();
        match subscriptions {
            Subscriptions::Node(subscriptions) => {
                tokio::join!(
                    self.follow(&subscriptions.detections, |m| {
                        let seen = incoming::read_detections(&m, frame).into_iter();
                        let heard = seen.map(|message| event(&subscriptions.detections, message));
                        (None, heard.collect())
                    }),
                    self.follow_one(&subscriptions.belt, |m| incoming::read_belt(m, frame)),
                    self.follow_one(&subscriptions.robots, incoming::read_robot),
                    self.follow_one(&subscriptions.acks, incoming::read_ack),
                    self.follow_one(&subscriptions.results, incoming::read_result),
                    self.follow(&subscriptions.tick, |m| {
                        let heard = match m.last {
                            true => TransportEvent::Ended(self.number),
                            false => event(&subscriptions.tick, incoming::read_tick(&m)),
                        };
                        (Some(m.messages), vec![heard])
                    }),
                );
            }
            Subscriptions::Station(subscriptions) => {
                tokio::join!(
                    self.follow_one(&subscriptions.tasks, outgoing::read_task),
                    self.follow_one(&subscriptions.cancels, |m| Ok(outgoing::read_cancel(m))),
                    self.follow_one(&subscriptions.status, outgoing::read_status),
                    self.follow(&subscriptions.due, |m| {
                        // The node's last message is its status.
                        let heard = match m.last {
                            true => Vec::new(),
                            false => vec![event(&subscriptions.due, Ok(outgoing::read_due(&m)))],
                        };
                        (Some(m.messages), heard)
                    }),
                );
            }
        }
    }

    /// Reads a topic whose messages stand for one message each and end no turn.
    async fn follow_one<R, M: Into<Message>>(
        &self,
        topic: &TopicSubscription<R>,
        read: impl Fn(&R) -> std::result::Result<M, Rejected>,
    ) where
        R: RosMessage + DeserializeOwned + 'static,
    {
        let one = |message: R| (None, vec![event(topic, read(&message))]);
        self.follow(topic, one).await;
    }

    /// Passes on the messages of a topic. For a message that ends a turn, `read` also returns how
    /// many came before it.
    async fn follow<R>(
        &self,
        topic: &TopicSubscription<R>,
        read: impl Fn(R) -> (Option<u32>, Vec<TransportEvent>),
    ) where
        R: RosMessage + DeserializeOwned + 'static,
    {
        loop {
            let heard = match topic.subscription.async_take().await {
                Ok((message, info)) => {
                    let (end, heard) = read(message);
                    match &self.turns {
                        Some(turns) => {
                            let at = info.source_timestamp().map_or(0, |time| time.to_nanos());
                            let sent = Sent::new(info.publisher_gid().as_bytes(), at);
                            let taken = turns.borrow_mut().take(sent, heard, end);
                            taken.unwrap_or_else(|Endless| vec![TransportEvent::Failed(endless())])
                        }
                        None => heard,
                    }
                }
                Err(error) => {
                    tokio::time::sleep(READ_RETRY_DELAY).await;
                    let problem = format!("cannot read a {}/{}: {error}", R::PACKAGE, R::TYPE);
                    let refused = Rejected::new(Rejection::Syntax, problem);
                    vec![TransportEvent::Refused(
                        Origin::Topic(Arc::clone(&topic.topic)),
                        refused,
                    )]
                }
            };
            // A turn begins once both sides know of each other, or the first tasks would wait.
            while self.turns.is_some() && !heard.is_empty() && !self.up.load(Ordering::Relaxed) {
                tokio::time::sleep(POLL_INTERVAL).await;
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
    async fn monitor(
        &self,
        node: &Node,
        publishers: &Publishers,
        subscriptions: &Subscriptions,
        mut watch: NodeWatcher,
    ) {
        let mut steady = 0;
        loop {
            tokio::time::sleep(POLL_INTERVAL).await;
            let hears = match subscriptions {
                Subscriptions::Node(_) => {
                    let stance = watch.look(self.up.load(Ordering::Relaxed));
                    let heard = self.report_other_node(stance);
                    if heard.is_some_and(|heard| self.inbox.send(heard).is_err()) {
                        return;
                    }
                    matches!(stance, Precedence::Stay | Precedence::Warn)
                }
                Subscriptions::Station(subscriptions) => {
                    subscriptions.tasks.subscription.get_publisher_count(node) > 0
                }
            };
            let there = hears && publishers.has_subscribers(node);
            steady = if there { steady + 1 } else { 0 };
            let heard = match (self.up.load(Ordering::Relaxed), there) {
                (false, true) if steady >= STEADY_POLLS => TransportEvent::Up(self.number),
                (true, false) if self.settings.side == Side::Node => {
                    TransportEvent::Down(self.number)
                }
                (true, false) => TransportEvent::Ended(self.number),
                _ => continue,
            };
            self.up.store(there, Ordering::Relaxed);
            if self.inbox.send(heard).is_err() {
                return;
            }
        }
    }
    /// The event for another node under the same namespace.
    fn report_other_node(&self, stance: Precedence) -> Option<TransportEvent> {
        let problem = format!("another node sends tasks under {}", self.settings.namespace);
        match stance {
            Precedence::Stay | Precedence::Wait => None,
            Precedence::Warn => Some(TransportEvent::Remark(problem)),
            Precedence::GiveWay => Some(TransportEvent::Failed(Error::usage(
                "'ros2'",
                problem,
                "stop it, or give this node another 'ros2_namespace'",
            ))),
        }
    }
}

/// The inbox event for a message.
fn event<R>(
    topic: &TopicSubscription<R>,
    message: std::result::Result<impl Into<Message>, Rejected>,
) -> TransportEvent {
    let origin = Origin::Topic(Arc::clone(&topic.topic));
    match message {
        Ok(message) => TransportEvent::Message(origin, Box::new(message.into())),
        Err(rejected) => TransportEvent::Refused(origin, rejected),
    }
}
