//! One peer: who it is, and a bounded queue of what is still to be written to it.

use super::identity::Identity;
use crate::protocol::Message;
use std::collections::VecDeque;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};
use tokio::sync::mpsc::error::{TryRecvError, TrySendError};
use tokio::sync::{mpsc, watch};

/// Messages that wait for one peer at most.
pub const QUEUE: usize = 1024;

/// What waits for a peer, for the thread that writes it.
#[derive(Debug)]
pub struct Waiting {
    messages: mpsc::Receiver<Message>,
}

impl Waiting {
    /// The next message, as soon as there is one; none once there will be no more.
    pub fn next(&mut self) -> Option<Message> {
        self.messages.blocking_recv()
    }

    /// The next message, if there is one already.
    ///
    /// # Errors
    /// There is none now, or there will be no more.
    pub fn try_next(&mut self) -> Result<Message, TryRecvError> {
        self.messages.try_recv()
    }
}

/// How a socket is disconnected before all is written to it.
#[derive(Debug)]
pub struct Socket {
    /// Who is at the other end.
    pub address: Option<SocketAddr>,
    /// Becomes true when the connection is to end at once.
    pub cut: watch::Sender<bool>,
    /// Whether one that takes nothing is waited for: it is not sent much, and says enough.
    pub is_patient: Arc<AtomicBool>,
}

/// What was said since a peer has come, while it is not known who it is.
#[derive(Debug)]
struct Newcomer {
    since: Instant,
    messages: Vec<Message>,
}

/// The side of a peer that is written to.
#[derive(Debug)]
pub struct Peer {
    /// Who it is.
    pub identity: Identity,
    /// Gone once nothing more is to be written.
    outbox: Option<mpsc::Sender<Message>>,
    /// What must not be lost and found the queue full; tasks are held then, so that it
    /// stays small.
    overflow: VecDeque<Message>,
    /// Of one that can be disconnected.
    socket: Option<Socket>,
    newcomer: Option<Newcomer>,
    /// Whether anybody is at the other end now.
    up: Arc<AtomicBool>,
    /// Hears when the writer has written all, and ended.
    written: std::sync::mpsc::Receiver<()>,
    /// What is left to do at the end.
    ending: Option<Ending>,
    /// When it has come.
    pub since: Instant,
    /// Whether it has said anything that was accepted.
    pub has_spoken: bool,
    /// Lines in a row that were no messages, or none of its own.
    pub refused: u32,
    /// Whether it is being disconnected, and what it still says is of no account.
    is_deaf: bool,
}

/// Something to be done at the end.
struct Ending(Box<dyn FnOnce() + Send>);

impl std::fmt::Debug for Ending {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Ending")
    }
}

impl Peer {
    /// Starts the thread of a peer that cannot be disconnected, which writes with `write`
    /// until nothing waits any more.
    pub fn start(up: Arc<AtomicBool>, write: impl FnOnce(&mut Waiting) + Send + 'static) -> Self {
        let (outbox, messages) = mpsc::channel(QUEUE);
        let (done, written) = std::sync::mpsc::sync_channel(1);
        let mut waiting = Waiting { messages };
        thread::spawn(move || {
            write(&mut waiting);
            // Whatever is still sent is of no use to anyone.
            while waiting.next().is_some() {}
            let _ = done.send(());
        });
        Self {
            up,
            ..Self::new(outbox, written, Identity::shared())
        }
    }

    /// A peer on a socket, which somebody else writes to. It is nobody yet: what is sent
    /// to it waits until it is [`Peer::known`].
    pub fn on_socket(
        outbox: mpsc::Sender<Message>,
        written: std::sync::mpsc::Receiver<()>,
        socket: Socket,
    ) -> Self {
        Self {
            socket: Some(socket),
            newcomer: Some(Newcomer {
                since: Instant::now(),
                messages: Vec::new(),
            }),
            ..Self::new(outbox, written, Identity::default())
        }
    }

    fn new(
        outbox: mpsc::Sender<Message>,
        written: std::sync::mpsc::Receiver<()>,
        identity: Identity,
    ) -> Self {
        Self {
            identity,
            outbox: Some(outbox),
            overflow: VecDeque::new(),
            socket: None,
            newcomer: None,
            up: Arc::new(AtomicBool::new(true)),
            written,
            ending: None,
            since: Instant::now(),
            has_spoken: false,
            refused: 0,
            is_deaf: false,
        }
    }

    /// The same peer, which does this at its end.
    #[cfg(any(feature = "mqtt", feature = "ros2"))]
    pub fn ending(self, end: impl FnOnce() + Send + 'static) -> Self {
        let ending = Some(Ending(Box::new(end)));
        Self { ending, ..self }
    }

    /// Whether anybody is at the other end now.
    pub fn is_up(&self) -> bool {
        self.up.load(Ordering::Relaxed) && !self.is_deaf
    }

    /// Whether it is on a socket, and can be disconnected.
    pub fn is_on_socket(&self) -> bool {
        self.socket.is_some()
    }

    /// Whether what it says does not count any more.
    pub fn is_deaf(&self) -> bool {
        self.is_deaf
    }

    /// How many messages wait for it.
    pub fn queued(&self) -> usize {
        let outbox = self.outbox.as_ref();
        let queued = outbox.map_or(0, |outbox| outbox.max_capacity() - outbox.capacity());
        let kept = self.newcomer.as_ref().map_or(0, |new| new.messages.len());
        queued + self.overflow.len() + kept
    }

    /// Whether so much waits that no more should be added than has to be.
    pub fn is_half_full(&self) -> bool {
        self.queued() > QUEUE / 2
    }

    /// How it is called where the user is told of it.
    pub fn title(&self) -> String {
        let address = self.socket.as_ref().and_then(|socket| socket.address);
        let address = address.map_or("the peer".to_owned(), |address| address.to_string());
        match (self.identity.role(), self.identity.name()) {
            (Some(role), Some(name)) => {
                format!(
                    "{address} ({} `{}`)",
                    role.name(),
                    pickline::error::shown(name)
                )
            }
            _ => address,
        }
    }

    /// For how long it has been there without anybody knowing who it is, if so.
    pub fn unknown_for(&self) -> Option<Duration> {
        self.newcomer.as_ref().map(|new| new.since.elapsed())
    }

    /// Who it is is known, or no longer waited for; returns what was kept back for it.
    pub fn known(&mut self) -> Vec<Message> {
        if let Some(socket) = &self.socket {
            let is_patient = self.identity.is_source();
            socket.is_patient.store(is_patient, Ordering::Relaxed);
        }
        self.newcomer.take().map_or(Vec::new(), |new| new.messages)
    }

    /// Sends a message, waiting for room.
    pub fn send(&mut self, message: Message) {
        if let Some(new) = &mut self.newcomer {
            new.messages.push(message);
        } else if let Some(outbox) = &self.outbox {
            let _ = outbox.blocking_send(message);
        }
    }

    /// Sends a message if there is room; otherwise keeps it for later if it matters. Whether
    /// the peer keeps up: a socket that does not is to be disconnected.
    pub fn try_send(&mut self, message: Message, matters: bool) -> bool {
        self.flush();
        if let Some(new) = &mut self.newcomer {
            new.messages.push(message);
            return new.messages.len() <= QUEUE;
        }
        // What does not matter must not take the room that tasks need, and is of no use to
        // a camera that does not read.
        let most = if self.identity.is_source() {
            1
        } else {
            QUEUE / 2
        };
        if !matters && (self.queued() >= most || !self.is_up()) {
            return true;
        }
        let refused = if self.overflow.is_empty() {
            self.pass(message)
        } else {
            Some(message)
        };
        let Some(message) = refused else {
            return true;
        };
        if self.socket.is_some() {
            return false;
        }
        if matters {
            self.overflow.push_back(message);
        }
        true
    }

    /// Sends what was kept, as far as there is room.
    pub fn flush(&mut self) {
        while let Some(message) = self.overflow.pop_front() {
            if let Some(message) = self.pass(message) {
                self.overflow.push_front(message);
                break;
            }
        }
    }

    /// Gives the message back if there is no room.
    fn pass(&self, message: Message) -> Option<Message> {
        match self.outbox.as_ref()?.try_send(message) {
            Err(TrySendError::Full(message)) => Some(message),
            Ok(()) | Err(TrySendError::Closed(_)) => None,
        }
    }

    /// Disconnects it at once. What it has said so far counts.
    pub fn cut(&mut self) {
        self.outbox = None;
        self.newcomer = None;
        self.up.store(false, Ordering::Relaxed);
        if let Some(socket) = &self.socket {
            socket.cut.send_replace(true);
        }
    }

    /// Disconnects it after a last word. What it says from here on does not count.
    pub fn dismiss(&mut self, last: Message) {
        self.newcomer = None;
        self.pass(last);
        self.outbox = None;
        self.is_deaf = true;
    }

    /// Writes what is left, ends the stream, and waits for that at most `patience`.
    pub fn close(mut self, patience: Duration) {
        self.flush();
        self.outbox = None;
        let _ = self.written.recv_timeout(patience);
        if let Some(Ending(end)) = self.ending.take() {
            end();
        }
    }

    /// Ends the stream after what is still to be written; the peer may go on talking.
    pub fn finish_writing(&mut self) {
        self.flush();
        self.outbox = None;
    }
}
