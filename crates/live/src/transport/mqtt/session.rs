//! The connection to the broker: established, maintained, re-established.

use super::inbound::{ConnectionCommand, ConnectionEvent, Inbound, Presence};
use super::outbound::Outbound;
use super::topics::MqttTopics;
use super::url::Broker;
use super::{probe, trouble};
use crate::ClockKind;
use crate::protocol::Message;
use crate::transport::{RETRY_INTERVAL, Side, TransportEvent};
use pickline::error::Error;
use rumqttc::mqttbytes::QoS;
use rumqttc::mqttbytes::v5::{LastWill, Packet, RetainForwardRule};
use rumqttc::{
    AsyncClient, ConnectionError, Event, EventLoop, MqttOptions, PublishOptions, SessionMode,
    SubscribeFilterInput, SubscribeNoticeError,
};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::SyncSender;
use std::thread;
use tokio::sync::mpsc::{Receiver, Sender, UnboundedReceiver, channel, unbounded_channel};
use tokio::sync::{oneshot, watch};

/// Maximum number of unhandled messages from the broker.
pub(crate) const RECEIVE_MAXIMUM: u16 = 512;
/// Size of the connection's request queue; small, because waiting messages are counted elsewhere.
pub(crate) const REQUEST_CAPACITY: usize = 64;
/// Space for messages that need no acknowledgement, and for connection events.
const SPARE_CAPACITY: usize = 256;
/// The remark, given once, if there is no space for them.
const FLOODED: &str = "messages with QoS 0 come faster than they can be handled; some are lost";

/// A connection and its settings.
pub(crate) struct BrokerSession {
    /// The number of the peer.
    pub number: u64,
    /// The address of the broker, for connecting and for remarks.
    pub broker: Broker,
    /// Which side this is.
    pub side: Side,
    /// The kind of clock.
    pub clock: ClockKind,
    /// The names of the topics of both sides.
    pub topics: MqttTopics,
    /// This side's client id, which its presence names.
    pub client: String,
    /// What the client library is to do; the last will is added when it runs.
    pub options: MqttOptions,
    /// Whether the peer is present.
    pub up: Arc<AtomicBool>,
    /// The hub's inbox, for messages and events.
    pub inbox: SyncSender<TransportEvent>,
}

impl BrokerSession {
    /// Runs until all of `outbox` is sent and, for a node, its leaving is published. `done` is
    /// notified when everything is sent; a station then ends with `end`.
    pub(crate) async fn run(
        mut self,
        outbox: Receiver<Message>,
        done: SyncSender<()>,
        end: oneshot::Receiver<()>,
    ) {
        let will = LastWill::new(
            self.topics.presence(self.side),
            self.presence("offline"),
            QoS::AtLeastOnce,
            true,
            None,
        );
        self.options.set_last_will(will);
        let builder = AsyncClient::builder(self.options.clone()).capacity(REQUEST_CAPACITY);
        let (client, connection) = builder.build();
        let (news, heard) = channel(usize::from(RECEIVE_MAXIMUM) + 2 * SPARE_CAPACITY);
        let (orders, todo) = unbounded_channel();
        // Number of the connection, from 1; 0 while there is none.
        let (number, current) = watch::channel(0);
        let (ready, is_ready) = watch::channel(0);
        let inbound = Inbound {
            number: self.number,
            side: self.side,
            topics: self.topics.clone(),
            client: self.client.clone(),
            up: Arc::clone(&self.up),
            ever_up: false,
            inbox: self.inbox.clone(),
            orders,
            ready,
        };
        thread::spawn(move || inbound.run(heard));
        let outbound = Outbound {
            client: client.clone(),
            topics: self.topics.clone(),
            ages: self.clock == ClockKind::System,
            news: news.clone(),
            current: current.clone(),
            ready: is_ready,
        };
        let speak = async {
            outbound.run(outbox).await;
            // Peers need not wait for this side any more.
            self.present(&client, "offline").await;
            if self.side == Side::Station {
                // The station still receives the node's last messages.
                let _ = done.send(());
                let _ = end.await;
            }
            let _ = client.disconnect().await;
            std::future::pending::<()>().await;
        };
        tokio::select! {
            () = self.keep(connection, &number, &news) => {}
            () = self.greet(&client, current.clone(), &news) => {}
            () = self.obey(&client, current, todo) => {}
            () = speak => {}
        }
    }

    /// Maintains the connection and passes on what comes in. Returns when it has ended.
    async fn keep(
        &self,
        mut connection: EventLoop,
        number: &watch::Sender<u64>,
        news: &Sender<ConnectionEvent>,
    ) {
        let mut connected = 0;
        let mut told = String::new();
        let mut flooded = false;
        loop {
            match connection.poll().await {
                Ok(Event::Incoming(Packet::ConnAck(_))) => {
                    connected += 1;
                    // From now on the broker keeps missed messages.
                    let options = &mut connection.options;
                    options.set_session_mode(SessionMode::Persistent);
                    number.send_replace(connected);
                    if !told.is_empty() {
                        let text = format!("connected to {}", self.broker);
                        let _ = news.send(ConnectionEvent::Remark(text)).await;
                        told.clear();
                    }
                }
                Ok(Event::Incoming(Packet::Publish(publish))) => {
                    // The broker does not limit messages that need no acknowledgement.
                    let spare = news.capacity() > usize::from(RECEIVE_MAXIMUM) + SPARE_CAPACITY;
                    if publish.qos != QoS::AtMostOnce || spare {
                        let message = ConnectionEvent::Message(connected, publish);
                        let _ = news.send(message).await;
                    } else if !std::mem::replace(&mut flooded, true) {
                        let _ = news.send(ConnectionEvent::Remark(FLOODED.to_owned())).await;
                    }
                }
                Ok(_) => {}
                Err(ConnectionError::RequestsDone) => return,
                Err(error) => {
                    if number.send_replace(0) > 0 {
                        let _ = news.send(ConnectionEvent::Lost).await;
                    }
                    if let Some(error) = self.permanent(&error, connected > 0).await {
                        let _ = news.send(ConnectionEvent::Failed(error)).await;
                        return;
                    }
                    let text = format!(
                        "no connection to {}: {}",
                        self.broker,
                        trouble::told(&error)
                    );
                    if text != told {
                        let remark = ConnectionEvent::Remark(format!("{text}; retrying"));
                        let _ = news.send(remark).await;
                        told = text;
                    }
                    tokio::time::sleep(RETRY_INTERVAL).await;
                }
            }
        }
    }

    /// Why another attempt would fail too, if it would: the connection ended with `error`, and was
    /// ever established or not.
    async fn permanent(&self, error: &ConnectionError, was_connected: bool) -> Option<Error> {
        let taken_over = trouble::taken_over(error, &self.broker);
        if taken_over.is_some() || was_connected {
            return taken_over;
        }
        let fatal = trouble::fatal(error, &self.broker);
        if fatal.is_some() || self.broker.tls {
            return fatal;
        }
        self.never().await
    }

    /// Why there can be no connection, according to a probe of the broker.
    async fn never(&self) -> Option<Error> {
        let broker = self.broker.clone();
        let asked = tokio::task::spawn_blocking(move || probe::never(&broker));
        asked.await.ok().flatten()
    }

    /// Subscribes and publishes this side's presence, on every new connection.
    async fn greet(
        &self,
        client: &AsyncClient,
        mut current: watch::Receiver<u64>,
        news: &Sender<ConnectionEvent>,
    ) {
        loop {
            let connection = *current.borrow_and_update();
            if connection > 0 {
                let result = tokio::select! {
                    result = self.subscribe(client) => result,
                    _ = current.changed() => continue,
                };
                if let Err(error) = result {
                    let _ = news.send(ConnectionEvent::Failed(error)).await;
                    return;
                }
                tokio::select! {
                    here = self.present(client, "online") => if here {
                        let _ = news.send(ConnectionEvent::Greeted(connection)).await;
                    },
                    _ = current.changed() => continue,
                }
            }
            if current.changed().await.is_err() {
                return;
            }
        }
    }

    async fn subscribe(&self, client: &AsyncClient) -> Result<(), Error> {
        let filter = |topic: String, retained| {
            SubscribeFilterInput::new(topic, QoS::AtLeastOnce)
                .no_local(true)
                .retain_forward_rule(retained)
        };
        let kinds = self.side.hears().iter();
        // Retained messages may be outdated, so they are not requested.
        let kinds = kinds.map(|kind| filter(self.topics.filter(kind), RetainForwardRule::Never));
        let sides = [Side::Node, Side::Station].map(|side| {
            let topic = self.topics.presence(side);
            filter(topic, RetainForwardRule::OnEverySubscribe)
        });
        let filters: Vec<_> = kinds.chain(sides).collect();
        let Ok(notice) = client.subscribe_many_tracked(filters).await else {
            return Ok(());
        };
        match notice.wait_completion_async().await {
            Err(SubscribeNoticeError::V5SubAckFailure(reasons)) => Err(Error::usage(
                "'mqtt_prefix'",
                format!(
                    "{} refuses the subscriptions: {:?}",
                    self.broker, reasons[0]
                ),
                "allow this user to subscribe to the topics in docs/mqtt.md, or give another \
                 prefix",
            )),
            // A lost connection is followed by a new one.
            _ => Ok(()),
        }
    }

    /// Publishes this side's presence as a retained message. Returns whether the broker has it.
    async fn present(&self, client: &AsyncClient, state: &str) -> bool {
        let topic = self.topics.presence(self.side);
        let options = PublishOptions::at_least_once().retained();
        let notice = client.publish_tracked(topic, self.presence(state), options);
        match notice.await {
            Ok(notice) => notice.wait_completion_async().await.is_ok(),
            Err(_) => false,
        }
    }

    fn presence(&self, state: &str) -> String {
        let presence = Presence {
            state: state.to_owned(),
            client: self.client.clone(),
        };
        serde_json::to_string(&presence).unwrap_or_default()
    }

    /// Carries out the orders that follow from received messages.
    async fn obey(
        &self,
        client: &AsyncClient,
        mut current: watch::Receiver<u64>,
        mut todo: UnboundedReceiver<ConnectionCommand>,
    ) {
        while let Some(order) = todo.recv().await {
            match order {
                ConnectionCommand::Present => {
                    self.present(client, "online").await;
                }
                ConnectionCommand::Acknowledge(connection, publish) => {
                    // It cannot be acknowledged over another connection; the broker sends it again.
                    if *current.borrow_and_update() == connection {
                        tokio::select! {
                            _ = client.ack(&publish) => {}
                            _ = current.changed() => {}
                        }
                    }
                }
            }
        }
    }
}
