//! MQTT 5: messages are payloads; topics give their kind and robot.
//!
//! The broker is a permanent peer: its queue survives a lost connection, and a message is kept
//! until the broker has acknowledged it. That is not delivery to a robot, so robots still
//! acknowledge tasks, which are sent again until they do.

mod inbound;
mod outbound;
mod probe;
mod resume;
mod session;
mod settings;
mod tls;
mod topics;
mod trouble;
mod url;

use super::TransportEvent;
use super::peer::Peer;
use crate::ClockKind;
use pickline::error::{Error, Result};
use resume::Resume;
use rumqttc::{MqttOptions, Transport};
use session::{BrokerSession, RECEIVE_MAXIMUM, REQUEST_CAPACITY};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::SyncSender;
use std::thread;
use std::time::Duration;
use topics::MqttTopics;

pub use settings::MqttSettings;
pub use url::Broker;

/// Keep-alive interval [s]; the broker gives up a client after one and a half of them.
const KEEP_ALIVE: u16 = 30;
/// Larger packets than this [bytes] are not delivered at all; shorter payloads that are too long
/// for a line are refused and counted.
const LARGEST_PACKET: u32 = 1 << 20;
/// Time allowed for disconnecting from the broker.
const DISCONNECT_TIMEOUT: Duration = Duration::from_secs(1);
/// How long the broker keeps messages for an absent client [s]; the node refuses older ones.
const SESSION_EXPIRY: u32 = crate::clock::OLDEST as u32;

/// Starts the connection to a broker, which is retried until it works.
///
/// # Errors
/// The settings cannot work.
pub(super) fn start(
    number: u64,
    settings: &MqttSettings,
    inbox: SyncSender<TransportEvent>,
) -> Result<Peer> {
    let topics = MqttTopics::new(&settings.prefix)?;
    let client = settings.client_id.clone().unwrap_or_else(own_id);
    let options = options(settings, &client)?;
    let up = Arc::new(AtomicBool::new(false));
    let session = BrokerSession {
        number,
        broker: settings.broker.clone(),
        side: settings.side,
        clock: settings.clock,
        topics,
        client,
        options,
        up: Arc::clone(&up),
        inbox,
    };
    let (outbox, messages) = tokio::sync::mpsc::channel(1);
    let (done, ended) = std::sync::mpsc::sync_channel(1);
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|error| {
            let problem = format!("cannot set up the network: {error}");
            Error::resources("'mqtt'", problem, "free some memory").caused_by(error)
        })?;
    let (end, to_end) = tokio::sync::oneshot::channel();
    let (going, gone) = std::sync::mpsc::channel::<()>();
    thread::spawn(move || {
        runtime.block_on(session.run(messages, done, to_end));
        drop(going);
    });
    let peer = Peer::start(up, move |waiting| {
        while let Some(message) = waiting.next() {
            if outbox.blocking_send(message).is_err() {
                return;
            }
        }
        drop(outbox);
        // Wait until the broker has everything.
        let _ = ended.recv();
    });
    Ok(peer.ending(move || {
        let _ = end.send(());
        let _ = gone.recv_timeout(DISCONNECT_TIMEOUT);
    }))
}

/// A unique client id.
fn own_id() -> String {
    use std::hash::{BuildHasher, RandomState};
    let random = RandomState::new().hash_one(std::process::id());
    format!("pickline-{random:016x}")
}

fn options(settings: &MqttSettings, client: &str) -> Result<MqttOptions> {
    let broker = &settings.broker;
    let mut options = MqttOptions::new(client, (broker.host.clone(), broker.port));
    if let Some(user) = &broker.user {
        options.set_username(user.clone());
        if let Some(password) = &broker.password {
            options.set_credentials(user.clone(), password.clone().into_bytes());
        }
    }
    if broker.tls {
        options.set_transport(transport(settings)?);
    }
    options
        .set_keep_alive(KEEP_ALIVE)
        .set_receive_maximum(Some(RECEIVE_MAXIMUM))
        .set_max_packet_size(Some(LARGEST_PACKET))
        .set_session_expiry_interval(Some(SESSION_EXPIRY));
    options.set_ack_mode(rumqttc::AckMode::Manual);
    // The library allocates space for this many messages, by default 65,535.
    options.set_outgoing_inflight_upper_limit(2 * outbound::IN_FLIGHT_MAXIMUM as u16);
    // Send acknowledgements in batches, or they could not keep up with incoming messages.
    options.set_max_request_batch(REQUEST_CAPACITY);
    // Messages are short and must not wait for further ones.
    let mut network = options.network_options();
    network.set_tcp_nodelay(true);
    options.set_network_options(network);
    if settings.client_id.is_some() && settings.clock == ClockKind::System {
        // A program that reconnects under its id gets what it has missed.
        options.set_session_mode(rumqttc::SessionMode::Persistent);
        options.set_session_store(Resume::new(&options));
    }
    Ok(options)
}

fn transport(settings: &MqttSettings) -> Result<Transport> {
    let machines = "give the authority's certificate with 'mqtt_ca'";
    let Some(authorities) = settings.authorities.clone() else {
        return Transport::try_tls_with_default_config()
            .map_err(|error| Error::usage("'mqtt'", error.to_string(), machines).caused_by(error));
    };
    Ok(Transport::tls(
        authorities,
        settings.certificate.clone(),
        None,
    ))
}
