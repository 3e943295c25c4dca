//! MQTT 5: the messages as payloads, their kinds and robots as topics.
//!
//! The broker is a peer that is kept: what waits for it survives a lost connection, and a
//! message is forgotten only when the broker has acknowledged it. That is not delivery to a
//! robot, so tasks are still acknowledged by their robots and sent again until they are.

mod inbound;
mod outbound;
mod probe;
mod resume;
mod session;
mod tls;
mod topics;
mod trouble;
mod url;

use super::peer::Peer;
use super::{Heard, Side};
use pickline::error::{Error, Result};
use crate::ClockKind;
use resume::Resume;
use rumqttc::{MqttOptions, Transport};
use session::Session;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::SyncSender;
use std::thread;
use std::time::Duration;
use topics::Topics;

pub use url::Broker;

/// Time between two signs of life [s]; the broker misses a client after one and a half.
const KEEP_ALIVE: u16 = 30;
/// Messages from the broker that are not handled yet, at most.
const UNHEEDED: u16 = 512;
/// Packets larger than this [bytes] are not even delivered; payloads that are too long for
/// a line but shorter are refused and counted.
const LARGEST_PACKET: u32 = 1 << 20;
/// Requests that the connection has not taken yet; few, as what waits is counted elsewhere.
const REQUESTS: usize = 64;
/// How long the broker is given to take leave.
const FAREWELL: Duration = Duration::from_secs(1);
/// How long the broker keeps what is meant for a client that is away [s]: the node takes
/// nothing that is older.
const KEPT: u32 = crate::clock::OLDEST as u32;

/// How to talk over a broker.
#[derive(Debug, Clone)]
pub struct Settings {
    /// The broker.
    pub broker: Broker,
    /// What all topics begin with.
    pub prefix: String,
    /// Client id; one of its own for every run when none.
    pub client_id: Option<String>,
    /// Certificates of the authorities that are trusted (PEM); those of the machine when
    /// none.
    pub authorities: Option<Vec<u8>>,
    /// Certificate and key of this client (PEM).
    pub certificate: Option<(Vec<u8>, Vec<u8>)>,
    /// Which of the two programs this is.
    pub side: Side,
    /// Where the time comes from.
    pub clock: ClockKind,
}

/// Starts talking to a broker. Connecting goes on until it works.
///
/// # Errors
/// Settings that cannot work.
pub(super) fn start(number: u64, settings: &Settings, inbox: SyncSender<Heard>) -> Result<Peer> {
    let topics = Topics::new(&settings.prefix)?;
    let client = settings.client_id.clone().unwrap_or_else(own_id);
    let options = options(settings, &client)?;
    let up = Arc::new(AtomicBool::new(false));
    let session = Session {
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
            Error::input("--mqtt", format!("no network: {error}"), "free some memory")
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
        // Until the broker has it all.
        let _ = ended.recv();
    });
    Ok(peer.ending(move || {
        let _ = end.send(());
        let _ = gone.recv_timeout(FAREWELL);
    }))
}

/// A client id that no other program has.
fn own_id() -> String {
    use std::hash::{BuildHasher, RandomState};
    let random = RandomState::new().hash_one(std::process::id());
    format!("pickline-{random:016x}")
}

fn options(settings: &Settings, client: &str) -> Result<MqttOptions> {
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
        .set_receive_maximum(Some(UNHEEDED))
        .set_max_packet_size(Some(LARGEST_PACKET))
        .set_session_expiry_interval(Some(KEPT));
    options.set_ack_mode(rumqttc::AckMode::Manual);
    // The library keeps room for as many messages as there may be, else 65,535.
    options.set_outgoing_inflight_upper_limit(2 * outbound::WINDOW as u16);
    // Acknowledgements leave together, or they could not keep up with what comes in.
    options.set_max_request_batch(REQUESTS);
    // Messages are short and must not wait for more of them.
    let mut network = options.network_options();
    network.set_tcp_nodelay(true);
    options.set_network_options(network);
    if settings.client_id.is_some() && settings.clock == ClockKind::System {
        // A program that comes back under its id gets what it has missed.
        options.set_session_mode(rumqttc::SessionMode::Persistent);
        options.set_session_store(Resume::new(&options));
    }
    Ok(options)
}

fn transport(settings: &Settings) -> Result<Transport> {
    let machines = "give the authority's certificate with --mqtt-ca";
    let Some(authorities) = settings.authorities.clone() else {
        return Transport::try_tls_with_default_config()
            .map_err(|error| Error::input("--mqtt", error.to_string(), machines));
    };
    Ok(Transport::tls(
        authorities,
        settings.certificate.clone(),
        None,
    ))
}
