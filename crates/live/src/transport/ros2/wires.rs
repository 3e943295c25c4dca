//! The topics: their names, quality of service and messages.

use super::messages::{
    BeltState, Detection3DArray, Due, LineStatus, RobotState, RosMessage, Task, TaskAck,
    TaskCancel, TaskResult, Tick,
};
use super::{Settings, incoming, outgoing};
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
const DEPTH: usize = 256;
/// Maximum number of received but unread messages per topic; beyond it the oldest are lost.
const HEARD: usize = 4096;
/// How long to wait for space before checking whether there are still readers.
const ROOM: Duration = Duration::from_millis(100);

/// Reliable transmission, without earlier messages for new readers.
fn reliable(depth: usize) -> QosProfile {
    QosProfile::publisher_default()
        .reliability_reliable(WhenFull::Wait(ROOM))
        .durability(Durability::Volatile)
        .history(History::KeepLast { depth })
}

/// The topics of one line.
pub struct Wires<'a> {
    /// The node in the graph.
    pub node: &'a mut Node,
    /// The settings.
    pub settings: &'a Settings,
}

impl Wires<'_> {
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

    fn out<M: RosMessage + Serialize>(&mut self, name: &str) -> Result<Publisher<M>, CreateError> {
        let topic = self.topic::<M>(name, &reliable(DEPTH))?;
        self.node.create_publisher(&topic, None)
    }

    fn heard<M: RosMessage + DeserializeOwned + 'static>(
        &mut self,
        name: &str,
    ) -> Result<Ear<M>, CreateError> {
        self.heard_with(name, &reliable(HEARD))
    }

    fn heard_with<M: RosMessage + DeserializeOwned + 'static>(
        &mut self,
        name: &str,
        quality: &QosProfile,
    ) -> Result<Ear<M>, CreateError> {
        let topic = self.topic::<M>(name, quality)?;
        Ok(Ear {
            topic: format!("{}/{name}", self.settings.namespace.trim_end_matches('/')).into(),
            subscription: self.node.create_subscription(&topic, None)?,
        })
    }

    /// Creates the publishers of this side.
    pub fn mouth(&mut self) -> Result<Mouth, CreateError> {
        let topics = match self.settings.side {
            Side::Node => Topics::Node(Box::new(NodeMouth {
                tasks: self.out("tasks")?,
                cancels: self.out("cancels")?,
                status: self.out("status")?,
                due: self.out("due")?,
            })),
            Side::Station => Topics::Station(Box::new(StationMouth {
                detections: self.out("detections")?,
                belt: self.out("belt_state")?,
                robots: self.out("robot_states")?,
                acks: self.out("acks")?,
                results: self.out("results")?,
                tick: self.out("tick")?,
            })),
        };
        Ok(Mouth {
            topics,
            said: AtomicU32::new(0),
        })
    }

    /// Creates the subscriptions of the node.
    pub fn node_ears(&mut self) -> Result<NodeEars, CreateError> {
        let mut quality = reliable(HEARD);
        if self.settings.best_effort {
            quality = quality.reliability_best_effort();
        }
        Ok(NodeEars {
            detections: self.heard_with("detections", &quality)?,
            belt: self.heard("belt_state")?,
            robots: self.heard("robot_states")?,
            acks: self.heard("acks")?,
            results: self.heard("results")?,
            tick: self.heard("tick")?,
        })
    }

    /// Creates the subscriptions of a station.
    pub fn station_ears(&mut self) -> Result<StationEars, CreateError> {
        Ok(StationEars {
            tasks: self.heard("tasks")?,
            cancels: self.heard("cancels")?,
            status: self.heard("status")?,
            due: self.heard("due")?,
        })
    }
}

/// A subscription to a topic.
pub struct Ear<M> {
    /// Its full name.
    pub topic: Arc<str>,
    /// The subscription.
    pub subscription: Subscription<M>,
}

/// The subscriptions of the node.
pub struct NodeEars {
    /// Detections.
    pub detections: Ear<Detection3DArray>,
    /// How the belt moves.
    pub belt: Ear<BeltState>,
    /// What the robots are doing.
    pub robots: Ear<RobotState>,
    /// Acknowledgements.
    pub acks: Ear<TaskAck>,
    /// Results of tasks.
    pub results: Ear<TaskResult>,
    /// Ends of the station's turns.
    pub tick: Ear<Tick>,
}

/// The subscriptions of a station.
pub struct StationEars {
    /// Tasks.
    pub tasks: Ear<Task>,
    /// Cancels.
    pub cancels: Ear<TaskCancel>,
    /// Statuses.
    pub status: Ear<LineStatus>,
    /// Ends of the node's turns.
    pub due: Ear<Due>,
}

/// The publishers of the node.
pub struct NodeMouth {
    tasks: Publisher<Task>,
    cancels: Publisher<TaskCancel>,
    status: Publisher<LineStatus>,
    due: Publisher<Due>,
}

/// The publishers of a station.
pub struct StationMouth {
    detections: Publisher<Detection3DArray>,
    belt: Publisher<BeltState>,
    robots: Publisher<RobotState>,
    acks: Publisher<TaskAck>,
    results: Publisher<TaskResult>,
    tick: Publisher<Tick>,
}

/// The publishers of one side.
enum Topics {
    /// The node.
    Node(Box<NodeMouth>),
    /// A station.
    Station(Box<StationMouth>),
}

/// The publishers of one side, with a count of messages.
pub struct Mouth {
    topics: Topics,
    /// Messages published in this turn.
    said: AtomicU32,
}

impl Mouth {
    /// Publishes a message. There is no space while readers have not acknowledged earlier ones.
    pub fn say(&self, message: &Message, frame: &str) -> Result<(), String> {
        let said = self.said.load(Relaxed);
        match (&self.topics, message) {
            (Topics::Node(mouth), Message::FromNode(message)) => match message {
                Outgoing::Task(task) => publish(&mouth.tasks, outgoing::task(task, frame)),
                Outgoing::Cancel(cancel) => {
                    publish(&mouth.cancels, outgoing::cancel(cancel, frame))
                }
                Outgoing::Status(status) => publish(&mouth.status, outgoing::status(status, frame)),
                // No topic carries it; `run` refuses --may-stop-belt over ROS 2.
                Outgoing::BeltRequest(_) => Ok(()),
                Outgoing::Due(due) => publish(&mouth.due, outgoing::due(Some(due), said, frame)),
            },
            (Topics::Station(mouth), Message::ToNode(message)) => match message {
                Incoming::Detection(seen) => {
                    publish(&mouth.detections, incoming::detections(seen, frame))
                }
                Incoming::Belt(belt) => publish(&mouth.belt, incoming::belt(belt, frame)),
                Incoming::Robot(robot) => publish(&mouth.robots, incoming::robot(robot, frame)),
                Incoming::Ack(ack) => publish(&mouth.acks, incoming::ack(ack, frame)),
                Incoming::Result(report) => {
                    publish(&mouth.results, incoming::result(report, frame))
                }
                // A station has no operator.
                Incoming::Pause(_)
                | Incoming::Resume(_)
                | Incoming::Drain(_)
                | Incoming::Stop(_) => Ok(()),
                Incoming::Tick { stamp } => {
                    publish(&mouth.tick, incoming::tick(Some(*stamp), said, frame))
                }
            },
            // Each side only sends its own messages.
            _ => Ok(()),
        }?;
        let turn_ends = matches!(
            message,
            Message::FromNode(Outgoing::Due(_)) | Message::ToNode(Incoming::Tick { .. })
        );
        self.said
            .store(if turn_ends { 0 } else { said + 1 }, Relaxed);
        Ok(())
    }

    /// Publishes that nothing more comes, so that the other side does not wait for it.
    pub fn end(&self, frame: &str) {
        let said = self.said.load(Relaxed);
        // Peers that have left need not know.
        let _ = match &self.topics {
            Topics::Node(mouth) => publish(&mouth.due, outgoing::due(None, said, frame)),
            Topics::Station(mouth) => publish(&mouth.tick, incoming::tick(None, said, frame)),
        };
    }

    /// Whether there are readers for all messages that must not be lost.
    pub fn is_heard(&self, node: &Node) -> bool {
        match &self.topics {
            Topics::Node(mouth) => mouth.tasks.get_subscription_count(node) > 0,
            Topics::Station(mouth) => {
                let counts = [
                    mouth.detections.get_subscription_count(node),
                    mouth.belt.get_subscription_count(node),
                    mouth.robots.get_subscription_count(node),
                    mouth.acks.get_subscription_count(node),
                    mouth.results.get_subscription_count(node),
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
