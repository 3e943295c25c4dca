//! The topics: their names, quality of service and messages.

use super::messages::{
    BeltState, Detection3DArray, Due, LineStatus, RobotState, RosMessage, Task, TaskAck,
    TaskCancel, TaskResult, Tick,
};
use super::{Ros2Settings, incoming, outgoing};
use crate::protocol::{Incoming, Message, Outgoing};
use crate::transport::Side;
use ros2_client::error::{CreateError, WriteError};
use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{MessageTypeName, Name, Node, Publisher, QosProfile, Subscription};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::Arc;
use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;

/// Maximum number of messages that a reader has not acknowledged.
const WRITE_DEPTH: usize = 256;
/// Maximum number of received but unread messages per topic; beyond it the oldest are lost.
const READ_DEPTH: usize = 4096;
/// How long to wait for space before checking whether there are still readers.
const WRITE_TIMEOUT: Duration = Duration::from_millis(100);

/// Reliable transmission, without earlier messages for new readers.
fn reliable(depth: usize) -> QosProfile {
    QosProfile::publisher_default()
        .reliability_reliable(WhenFull::Wait(WRITE_TIMEOUT))
        .durability(Durability::Volatile)
        .history(History::KeepLast { depth })
}

/// The topics of one line.
pub(crate) struct TopicFactory<'a> {
    /// The node in the graph.
    pub node: &'a mut Node,
    /// The namespace of the topics, and which publishers are accepted.
    pub settings: &'a Ros2Settings,
}

impl TopicFactory<'_> {
    fn topic<M: RosMessage>(
        &self,
        name: &str,
        quality: &QosProfile,
    ) -> Result<rustdds::Topic, CreateError> {
        let name = Name::new(&self.settings.namespace, name).map_err(|error| {
            CreateError::BadParameter {
                reason: error.to_string(),
            }
        })?;
        let kind = MessageTypeName::new(M::PACKAGE, M::TYPE);
        self.node.create_topic(&name, kind, quality)
    }

    fn advertise<M: RosMessage + Serialize>(
        &mut self,
        name: &str,
    ) -> Result<Publisher<M>, CreateError> {
        let topic = self.topic::<M>(name, &reliable(WRITE_DEPTH))?;
        self.node.create_publisher(&topic, None)
    }

    fn subscribe<M: RosMessage + DeserializeOwned + 'static>(
        &mut self,
        name: &str,
    ) -> Result<TopicSubscription<M>, CreateError> {
        self.subscribe_with(name, &reliable(READ_DEPTH))
    }

    fn subscribe_with<M: RosMessage + DeserializeOwned + 'static>(
        &mut self,
        name: &str,
        quality: &QosProfile,
    ) -> Result<TopicSubscription<M>, CreateError> {
        let topic = self.topic::<M>(name, quality)?;
        Ok(TopicSubscription {
            topic: format!("{}/{name}", self.settings.namespace.trim_end_matches('/')).into(),
            subscription: self.node.create_subscription(&topic, None)?,
        })
    }

    /// Creates the publishers of this side.
    pub(crate) fn publishers(&mut self) -> Result<Publishers, CreateError> {
        let topics = match self.settings.side {
            Side::Node => SidePublishers::Node(Box::new(NodePublishers {
                tasks: self.advertise("tasks")?,
                cancels: self.advertise("cancels")?,
                status: self.advertise("status")?,
                due: self.advertise("due")?,
            })),
            Side::Station => SidePublishers::Station(Box::new(StationPublishers {
                detections: self.advertise("detections")?,
                belt: self.advertise("belt_state")?,
                robots: self.advertise("robot_states")?,
                acks: self.advertise("acks")?,
                results: self.advertise("results")?,
                tick: self.advertise("tick")?,
            })),
        };
        Ok(Publishers {
            topics,
            published: AtomicU32::new(0),
        })
    }

    /// Creates the subscriptions of the node.
    pub(crate) fn node_subscriptions(&mut self) -> Result<NodeSubscriptions, CreateError> {
        let mut quality = reliable(READ_DEPTH);
        if self.settings.best_effort {
            quality = quality.reliability_best_effort();
        }
        Ok(NodeSubscriptions {
            detections: self.subscribe_with("detections", &quality)?,
            belt: self.subscribe("belt_state")?,
            robots: self.subscribe("robot_states")?,
            acks: self.subscribe("acks")?,
            results: self.subscribe("results")?,
            tick: self.subscribe("tick")?,
        })
    }

    /// Creates the subscriptions of a station.
    pub(crate) fn station_subscriptions(&mut self) -> Result<StationSubscriptions, CreateError> {
        Ok(StationSubscriptions {
            tasks: self.subscribe("tasks")?,
            cancels: self.subscribe("cancels")?,
            status: self.subscribe("status")?,
            due: self.subscribe("due")?,
        })
    }
}

/// A subscription to a topic.
pub(crate) struct TopicSubscription<M> {
    /// Its full name.
    pub topic: Arc<str>,
    /// The typed reader of the topic.
    pub subscription: Subscription<M>,
}

/// The subscriptions of the node.
pub(crate) struct NodeSubscriptions {
    /// Detections.
    pub detections: TopicSubscription<Detection3DArray>,
    /// How the belt moves.
    pub belt: TopicSubscription<BeltState>,
    /// What the robots are doing.
    pub robots: TopicSubscription<RobotState>,
    /// Acknowledgements.
    pub acks: TopicSubscription<TaskAck>,
    /// Results of tasks.
    pub results: TopicSubscription<TaskResult>,
    /// Ends of the station's turns.
    pub tick: TopicSubscription<Tick>,
}

/// The subscriptions of a station.
pub(crate) struct StationSubscriptions {
    /// Tasks.
    pub tasks: TopicSubscription<Task>,
    /// Cancels.
    pub cancels: TopicSubscription<TaskCancel>,
    /// Statuses.
    pub status: TopicSubscription<LineStatus>,
    /// Ends of the node's turns.
    pub due: TopicSubscription<Due>,
}

/// The publishers of the node.
pub(crate) struct NodePublishers {
    tasks: Publisher<Task>,
    cancels: Publisher<TaskCancel>,
    status: Publisher<LineStatus>,
    due: Publisher<Due>,
}

/// The publishers of a station.
pub(crate) struct StationPublishers {
    detections: Publisher<Detection3DArray>,
    belt: Publisher<BeltState>,
    robots: Publisher<RobotState>,
    acks: Publisher<TaskAck>,
    results: Publisher<TaskResult>,
    tick: Publisher<Tick>,
}

/// The publishers of one side.
enum SidePublishers {
    /// Tasks, cancels and statuses.
    Node(Box<NodePublishers>),
    /// Detections, states and results.
    Station(Box<StationPublishers>),
}

/// The publishers of one side, with a count of messages.
pub(crate) struct Publishers {
    topics: SidePublishers,
    /// Messages published in this turn.
    published: AtomicU32,
}

impl Publishers {
    /// Publishes a message. There is no space while readers have not acknowledged earlier ones.
    pub(crate) fn publish(&self, message: &Message, frame: &str) -> Result<(), String> {
        let published = self.published.load(Relaxed);
        match (&self.topics, message) {
            (SidePublishers::Node(publishers), Message::FromNode(message)) => match message {
                Outgoing::Task(task) => publish(&publishers.tasks, outgoing::task(task, frame)),
                Outgoing::Cancel(cancel) => {
                    publish(&publishers.cancels, outgoing::cancel(cancel, frame))
                }
                Outgoing::Status(status) => {
                    publish(&publishers.status, outgoing::status(status, frame))
                }
                // No topic carries it; a line over ROS 2 is not asked for them.
                Outgoing::BeltRequest(_) => Ok(()),
                Outgoing::Due(due) => {
                    publish(&publishers.due, outgoing::due(Some(due), published, frame))
                }
            },
            (SidePublishers::Station(publishers), Message::ToNode(message)) => match message {
                Incoming::Detection(seen) => {
                    publish(&publishers.detections, incoming::detections(seen, frame))
                }
                Incoming::Belt(belt) => publish(&publishers.belt, incoming::belt(belt, frame)),
                Incoming::Robot(robot) => {
                    publish(&publishers.robots, incoming::robot(robot, frame))
                }
                Incoming::Ack(ack) => publish(&publishers.acks, incoming::ack(ack, frame)),
                Incoming::Result(report) => {
                    publish(&publishers.results, incoming::result(report, frame))
                }
                // A station has no operator.
                Incoming::Pause(_)
                | Incoming::Resume(_)
                | Incoming::Drain(_)
                | Incoming::Stop(_) => Ok(()),
                Incoming::Tick { stamp } => publish(
                    &publishers.tick,
                    incoming::tick(Some(*stamp), published, frame),
                ),
            },
            // Each side only sends its own messages.
            _ => Ok(()),
        }?;
        let turn_ends = matches!(
            message,
            Message::FromNode(Outgoing::Due(_)) | Message::ToNode(Incoming::Tick { .. })
        );
        self.published
            .store(if turn_ends { 0 } else { published + 1 }, Relaxed);
        Ok(())
    }

    /// Publishes that nothing more comes, so that the other side does not wait for it.
    pub(crate) fn end(&self, frame: &str) {
        let published = self.published.load(Relaxed);
        // Peers that have left need not know.
        let _ = match &self.topics {
            SidePublishers::Node(publishers) => {
                publish(&publishers.due, outgoing::due(None, published, frame))
            }
            SidePublishers::Station(publishers) => {
                publish(&publishers.tick, incoming::tick(None, published, frame))
            }
        };
    }

    /// Whether there are readers for all messages that must not be lost.
    pub(crate) fn has_subscribers(&self, node: &Node) -> bool {
        match &self.topics {
            SidePublishers::Node(publishers) => publishers.tasks.get_subscription_count(node) > 0,
            SidePublishers::Station(publishers) => {
                let counts = [
                    publishers.detections.get_subscription_count(node),
                    publishers.belt.get_subscription_count(node),
                    publishers.robots.get_subscription_count(node),
                    publishers.acks.get_subscription_count(node),
                    publishers.results.get_subscription_count(node),
                ];
                counts.iter().all(|count| *count > 0)
            }
        }
    }
}

/// Publishes a message, waiting for space as long as necessary.
fn publish<M: Serialize + std::fmt::Debug>(
    publisher: &Publisher<M>,
    message: M,
) -> Result<(), String> {
    let mut message = message;
    loop {
        match publisher.publish(message) {
            Ok(()) => return Ok(()),
            Err(WriteError::WouldBlock { data }) => message = data,
            Err(error) => return Err(error.to_string()),
        }
    }
}
