//! A peer: its identity, and a bounded queue of messages to it.

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

/// Maximum number of messages queued for a peer.
pub(super) const QUEUE_CAPACITY: usize = 1024;

/// The queue of a peer, for the thread that writes to it.
#[derive(Debug)]
pub(super) struct Waiting {
    messages: mpsc::Receiver<Message>,
}

impl Waiting {
    /// Waits for the next message; none once there will be no more.
    pub(super) fn next(&mut self) -> Option<Message> {
        self.messages.blocking_recv()
    }

    /// The next message, if there is one now.
    ///
    /// # Errors
    /// There is none now, or there will be no more.
    pub(super) fn try_next(&mut self) -> Result<Message, TryRecvError> {
        self.messages.try_recv()
    }
}

/// The means to disconnect a socket before everything is written.
#[derive(Debug)]
pub(super) struct PeerSocket {
    /// Who is at the other end.
    pub address: Option<SocketAddr>,
    /// Becomes true to end the connection at once.
    pub cut: watch::Sender<bool>,
    /// Whether to wait for the peer if it reads nothing, because it is sent little and mainly
    /// sends.
    pub waits_when_stalled: Arc<AtomicBool>,
}

/// Messages for a new peer while its identity is unknown.
#[derive(Debug)]
struct Newcomer {
    since: Instant,
    messages: Vec<Message>,
}

/// A peer, as seen by the sender of messages.
#[derive(Debug)]
pub(super) struct Peer {
    /// Its identity.
    pub identity: Identity,
    /// None once nothing more is to be written.
    outbox: Option<mpsc::Sender<Message>>,
    /// Messages that must not be lost and found the queue full. Tasks are held then, so it stays
    /// small.
    overflow: VecDeque<Message>,
    /// Its socket, if it can be disconnected.
    socket: Option<PeerSocket>,
    newcomer: Option<Newcomer>,
    /// Whether the other end is connected now.
    up: Arc<AtomicBool>,
    /// Notified when the writer has written everything and ended.
    written: std::sync::mpsc::Receiver<()>,
    /// An action at the end.
    ending: Option<CloseAction>,
    /// When it connected.
    pub since: Instant,
    /// Whether any message from it was accepted.
    pub has_spoken: bool,
    /// Number of invalid or disallowed lines in a row.
    pub refused: u32,
    /// Whether it is being disconnected, so that its further messages are ignored.
    is_dismissed: bool,
}

/// An action at the end.
struct CloseAction(Box<dyn FnOnce() + Send>);

impl std::fmt::Debug for CloseAction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Ending")
    }
}

impl Peer {
    /// Starts the thread of a peer that cannot be disconnected. It writes with `write` until the
    /// queue has ended.
    pub(super) fn start(
        up: Arc<AtomicBool>,
        write: impl FnOnce(&mut Waiting) + Send + 'static,
    ) -> Self {
        let (outbox, messages) = mpsc::channel(QUEUE_CAPACITY);
        let (done, written) = std::sync::mpsc::sync_channel(1);
        let mut waiting = Waiting { messages };
        thread::spawn(move || {
            write(&mut waiting);
            // Discard whatever is still sent.
            while waiting.next().is_some() {}
            let _ = done.send(());
        });
        Self {
            up,
            ..Self::new(outbox, written, Identity::shared())
        }
    }

    /// A peer on a socket, which another thread writes to. Its identity is unknown at first:
    /// messages to it wait until it is [`Peer::identify`].
    pub(super) fn on_socket(
        outbox: mpsc::Sender<Message>,
        written: std::sync::mpsc::Receiver<()>,
        socket: PeerSocket,
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
            is_dismissed: false,
        }
    }

    /// The same peer, with an action at its end.
    #[cfg(any(feature = "mqtt", feature = "ros2"))]
    pub(crate) fn ending(self, end: impl FnOnce() + Send + 'static) -> Self {
        let ending = Some(CloseAction(Box::new(end)));
        Self { ending, ..self }
    }

    /// Whether the other end is connected now.
    pub(super) fn is_up(&self) -> bool {
        self.up.load(Ordering::Relaxed) && !self.is_dismissed
    }

    /// Whether it is on a socket, so that it can be disconnected.
    pub(super) fn is_on_socket(&self) -> bool {
        self.socket.is_some()
    }

    /// Whether its messages are ignored from now on.
    pub(super) fn is_dismissed(&self) -> bool {
        self.is_dismissed
    }

    /// Number of messages queued for it.
    pub(super) fn queued(&self) -> usize {
        let outbox = self.outbox.as_ref();
        let queued = outbox.map_or(0, |outbox| outbox.max_capacity() - outbox.capacity());
        let kept = self.newcomer.as_ref().map_or(0, |new| new.messages.len());
        queued + self.overflow.len() + kept
    }

    /// Whether its queue is more than half full, so that only necessary messages should be added.
    pub(super) fn is_half_full(&self) -> bool {
        self.queued() > QUEUE_CAPACITY / 2
    }

    /// Its title in reports to the user.
    pub(super) fn title(&self) -> String {
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

    /// How long it has been connected with an unknown identity, if that is so.
    pub(super) fn unknown_for(&self) -> Option<Duration> {
        self.newcomer.as_ref().map(|new| new.since.elapsed())
    }

    /// Its identity is known, or no longer waited for. Returns the messages held back for it.
    pub(super) fn identify(&mut self) -> Vec<Message> {
        if let Some(socket) = &self.socket {
            let waits_when_stalled = self.identity.is_source();
            socket
                .waits_when_stalled
                .store(waits_when_stalled, Ordering::Relaxed);
        }
        self.newcomer.take().map_or(Vec::new(), |new| new.messages)
    }

    /// Sends a message, waiting for space in the queue.
    pub(super) fn send(&mut self, message: Message) {
        if let Some(new) = &mut self.newcomer {
            new.messages.push(message);
        } else if let Some(outbox) = &self.outbox {
            let _ = outbox.blocking_send(message);
        }
    }

    /// Sends a message if there is space; otherwise keeps it for later if it matters. Returns
    /// whether the peer keeps up; a socket that does not should be disconnected.
    pub(super) fn try_send(&mut self, message: Message, matters: bool) -> bool {
        self.flush();
        if let Some(new) = &mut self.newcomer {
            new.messages.push(message);
            return new.messages.len() <= QUEUE_CAPACITY;
        }
        // Unimportant messages must not take the space that tasks need, and are useless to a camera
        // that does not read.
        let most = if self.identity.is_source() {
            1
        } else {
            QUEUE_CAPACITY / 2
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

    /// Sends the kept messages, as far as there is space.
    pub(super) fn flush(&mut self) {
        while let Some(message) = self.overflow.pop_front() {
            if let Some(message) = self.pass(message) {
                self.overflow.push_front(message);
                break;
            }
        }
    }

    /// Queues the message, or returns it if there is no space.
    fn pass(&self, message: Message) -> Option<Message> {
        match self.outbox.as_ref()?.try_send(message) {
            Err(TrySendError::Full(message)) => Some(message),
            Ok(()) | Err(TrySendError::Closed(_)) => None,
        }
    }

    /// Disconnects it at once. Its messages so far count.
    pub(super) fn disconnect(&mut self) {
        self.outbox = None;
        self.newcomer = None;
        self.up.store(false, Ordering::Relaxed);
        if let Some(socket) = &self.socket {
            socket.cut.send_replace(true);
        }
    }

    /// Disconnects it after a last message. Its further messages are ignored.
    pub(super) fn dismiss(&mut self, last: Message) {
        self.newcomer = None;
        self.pass(last);
        self.outbox = None;
        self.is_dismissed = true;
    }

    /// Writes the remaining messages and ends the stream, within `timeout`.
    pub(super) fn close(mut self, timeout: Duration) {
        self.flush();
        self.outbox = None;
        let _ = self.written.recv_timeout(timeout);
        if let Some(CloseAction(end)) = self.ending.take() {
            end();
        }
    }

    /// Ends the stream once everything is written. The peer may keep sending.
    pub(super) fn finish_writing(&mut self) {
        self.flush();
        self.outbox = None;
    }
}
