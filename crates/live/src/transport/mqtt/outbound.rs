//! To the broker: every message is kept until the broker has acknowledged it.

use super::inbound::ConnectionEvent;
use super::topics::MqttTopics;
use crate::protocol::{Message, Outgoing, encode};
use crate::transport::RETRY_INTERVAL;
use rumqttc::{AsyncClient, PublishNoticeError, PublishOptions, PublishProperties};
use std::collections::{BTreeSet, VecDeque};
use std::pin::Pin;
use std::time::{SystemTime, UNIX_EPOCH};
use tokio::sync::mpsc::{Receiver, Sender};
use tokio::sync::watch;

/// Maximum number of messages that the broker has not acknowledged.
pub(crate) const IN_FLIGHT_MAXIMUM: usize = 64;
/// The node refuses older messages [s], so the broker need not keep them.
const MESSAGE_EXPIRY: u32 = crate::clock::OLDEST as u32;

/// Resolves when the broker has acknowledged or refused a message.
type Delivery = Pin<Box<dyn Future<Output = Result<(), PublishNoticeError>> + Send>>;

/// A message ready to be published.
#[derive(Debug, Clone)]
struct PendingPublish {
    topic: String,
    payload: String,
    /// Time after which it is obsolete [s].
    expires: Option<u32>,
}

/// Publishes this side's messages.
pub(crate) struct Outbound {
    /// Hands messages to the connection.
    pub client: AsyncClient,
    /// The names of the topics to publish on.
    pub topics: MqttTopics,
    /// Whether timestamps are by this machine's clock, so that messages can expire.
    pub ages: bool,
    /// Receiver of remarks.
    pub news: Sender<ConnectionEvent>,
    /// The present connection; 0 for none.
    pub current: watch::Receiver<u64>,
    /// The connection over which the peer is reachable.
    pub ready: watch::Receiver<u64>,
}

impl Outbound {
    /// Publishes messages until there are no more and the broker has them all.
    pub(crate) async fn run(mut self, mut outbox: Receiver<Message>) {
        let mut window: VecDeque<(PendingPublish, Delivery)> = VecDeque::new();
        let mut told = BTreeSet::new();
        let mut open = true;
        while open || !window.is_empty() {
            let waits = !window.is_empty();
            tokio::select! {
                // Messages that the broker lost go before new ones.
                biased;
                result = async {
                    match window.front_mut() {
                        Some((_, delivery)) => delivery.await,
                        None => Ok(()),
                    }
                }, if waits => {
                    let Some((pending, _)) = window.pop_front() else { continue };
                    match result {
                        Ok(()) => {}
                        Err(PublishNoticeError::V5PubAck(reason)) => {
                            // Tasks and results are sent again, so this is not fatal.
                            let text = format!("the broker refuses {}: {reason:?}", pending.topic);
                            if told.insert(text.clone()) {
                                let _ = self.news.send(ConnectionEvent::Remark(text)).await;
                            }
                        }
                        // The connection was lost and the broker has forgotten this client.
                        Err(PublishNoticeError::SessionReset) => {
                            window.extend(self.publish(pending).await);
                        }
                        Err(_) => {
                            tokio::time::sleep(RETRY_INTERVAL).await;
                            window.extend(self.publish(pending).await);
                        }
                    }
                }
                message = outbox.recv(), if open && window.len() < IN_FLIGHT_MAXIMUM => match message {
                    Some(message) => {
                        let pending = self.to_publish(&message);
                        window.extend(self.publish(pending).await);
                    }
                    None => open = false,
                },
            }
        }
    }

    fn to_publish(&self, message: &Message) -> PendingPublish {
        let mut payload = encode(message);
        payload.truncate(payload.trim_end().len());
        PendingPublish {
            topic: self.topics.of(message),
            payload,
            expires: self.ages.then(|| expiry(message)).flatten(),
        }
    }

    /// Passes a message to the connection; none if that has ended.
    async fn publish(&mut self, pending: PendingPublish) -> Option<(PendingPublish, Delivery)> {
        // A restarted broker has no subscribers yet and would drop it.
        loop {
            let current = *self.current.borrow_and_update();
            if current > 0 && *self.ready.borrow_and_update() == current {
                break;
            }
            tokio::select! {
                change = self.current.changed() => change.ok()?,
                change = self.ready.changed() => change.ok()?,
            }
        }
        let options = PublishOptions::at_least_once().properties(PublishProperties {
            message_expiry_interval: pending.expires,
            content_type: Some("application/json".into()),
            ..PublishProperties::default()
        });
        let (topic, payload) = (pending.topic.clone(), pending.payload.clone());
        let notice = self.client.publish_tracked(topic, payload, options).await;
        let delivery: Delivery = Box::pin(notice.ok()?.wait_completion_async());
        Some((pending, delivery))
    }
}

/// Time after which `message` is obsolete [s].
fn expiry(message: &Message) -> Option<u32> {
    match message {
        Message::FromNode(Outgoing::Task(task)) => {
            let now = SystemTime::now().duration_since(UNIX_EPOCH);
            let left = task.latest_start - now.unwrap_or_default().as_secs_f64();
            Some((left.ceil() as u32).max(1))
        }
        // A request is repeated after a second if it still applies.
        Message::FromNode(Outgoing::BeltRequest(_)) => Some(1),
        Message::FromNode(Outgoing::Status(_)) | Message::ToNode(_) => Some(MESSAGE_EXPIRY),
        // A robot that was away must still get it.
        Message::FromNode(Outgoing::Cancel(_) | Outgoing::Due(_))
        | Message::Hello(_)
        | Message::Answer(_) => None,
    }
}
