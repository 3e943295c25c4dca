//! To the broker: nothing is forgotten before the broker has acknowledged it.

use super::inbound::News;
use super::topics::Topics;
use crate::protocol::{Message, Outgoing, encode};
use crate::transport::RETRY;
use rumqttc::{AsyncClient, PublishNoticeError, PublishOptions, PublishProperties};
use std::collections::{BTreeSet, VecDeque};
use std::pin::Pin;
use std::time::{SystemTime, UNIX_EPOCH};
use tokio::sync::mpsc::{Receiver, Sender};
use tokio::sync::watch;

/// Messages that the broker has not acknowledged, at most.
pub const WINDOW: usize = 64;
/// The node takes nothing that is older [s], so the broker need not keep it.
const OLD: u32 = crate::clock::OLDEST as u32;

/// Resolves when the broker has acknowledged a message, or has not.
type Delivery = Pin<Box<dyn Future<Output = Result<(), PublishNoticeError>> + Send>>;

/// A message as it is published.
#[derive(Debug, Clone)]
struct Parcel {
    topic: String,
    payload: String,
    /// After so long nobody needs it [s].
    expires: Option<u32>,
}

/// What publishes.
pub struct Outbound {
    /// The client.
    pub client: AsyncClient,
    /// The topics.
    pub topics: Topics,
    /// Whether stamps are times of this machine, so that messages can grow old.
    pub ages: bool,
    /// Where remarks go.
    pub news: Sender<News>,
    /// The connection that there is, 0 for none.
    pub current: watch::Receiver<u64>,
    /// The connection over which the peer can be talked to.
    pub ready: watch::Receiver<u64>,
}

impl Outbound {
    /// Publishes what comes until there is no more and the broker has it all.
    pub async fn run(mut self, mut outbox: Receiver<Message>) {
        let mut window: VecDeque<(Parcel, Delivery)> = VecDeque::new();
        let mut told = BTreeSet::new();
        let mut open = true;
        while open || !window.is_empty() {
            let waits = !window.is_empty();
            tokio::select! {
                // What the broker lost goes before what is new.
                biased;
                result = async {
                    match window.front_mut() {
                        Some((_, delivery)) => delivery.await,
                        None => Ok(()),
                    }
                }, if waits => {
                    let Some((parcel, _)) = window.pop_front() else { continue };
                    match result {
                        Ok(()) => {}
                        Err(PublishNoticeError::V5PubAck(reason)) => {
                            // Tasks and results are sent again, so this may pass.
                            let text = format!("the broker refuses {}: {reason:?}", parcel.topic);
                            if told.insert(text.clone()) {
                                let _ = self.news.send(News::Remark(text)).await;
                            }
                        }
                        // The connection was lost and the broker has forgotten this client.
                        Err(PublishNoticeError::SessionReset) => {
                            window.extend(self.publish(parcel).await);
                        }
                        Err(_) => {
                            tokio::time::sleep(RETRY).await;
                            window.extend(self.publish(parcel).await);
                        }
                    }
                }
                message = outbox.recv(), if open && window.len() < WINDOW => match message {
                    Some(message) => {
                        let parcel = self.parcel(&message);
                        window.extend(self.publish(parcel).await);
                    }
                    None => open = false,
                },
            }
        }
    }

    fn parcel(&self, message: &Message) -> Parcel {
        let mut payload = encode(message);
        payload.truncate(payload.trim_end().len());
        Parcel {
            topic: self.topics.of(message),
            payload,
            expires: self.ages.then(|| expiry(message)).flatten(),
        }
    }

    /// Hands a message to the connection; none when that has ended.
    async fn publish(&mut self, parcel: Parcel) -> Option<(Parcel, Delivery)> {
        // A broker that has restarted knows nobody yet, and would drop it.
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
            message_expiry_interval: parcel.expires,
            content_type: Some("application/json".into()),
            ..PublishProperties::default()
        });
        let (topic, payload) = (parcel.topic.clone(), parcel.payload.clone());
        let notice = self.client.publish_tracked(topic, payload, options).await;
        let delivery: Delivery = Box::pin(notice.ok()?.wait_completion_async());
        Some((parcel, delivery))
    }
}

/// After how long nobody needs `message` any more [s].
fn expiry(message: &Message) -> Option<u32> {
    match message {
        Message::FromNode(Outgoing::Task(task)) => {
            let now = SystemTime::now().duration_since(UNIX_EPOCH);
            let left = task.latest_start - now.unwrap_or_default().as_secs_f64();
            Some((left.ceil() as u32).max(1))
        }
        // It is made again after a second if it still stands.
        Message::FromNode(Outgoing::BeltRequest(_)) => Some(1),
        Message::FromNode(Outgoing::Status(_)) | Message::ToNode(_) => Some(OLD),
        // A robot that was away must still hear of it.
        Message::FromNode(Outgoing::Cancel(_) | Outgoing::Due(_))
        | Message::Hello(_)
        | Message::Answer(_) => None,
    }
}
