//! One peer: a bounded queue, and a thread that writes what is in it.

use crate::live::protocol::Message;
use std::collections::VecDeque;
use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, TrySendError, sync_channel};
use std::thread;
use std::time::Duration;

/// Messages that wait for one peer at most.
pub const QUEUE: usize = 1024;

/// What waits for a peer, for the thread that writes it.
#[derive(Debug)]
pub struct Waiting {
    messages: Receiver<Message>,
    queued: Arc<AtomicUsize>,
}

impl Waiting {
    /// The next message, as soon as there is one; none once there will be no more.
    pub fn next(&self) -> Option<Message> {
        let message = self.messages.recv().ok()?;
        self.queued.fetch_sub(1, Ordering::Relaxed);
        Some(message)
    }

    /// The next message, if there is one already.
    ///
    /// # Errors
    /// There is none now, or there will be no more.
    pub fn try_next(&self) -> Result<Message, TryRecvError> {
        let message = self.messages.try_recv()?;
        self.queued.fetch_sub(1, Ordering::Relaxed);
        Ok(message)
    }
}

/// The side of a peer that is written to.
#[derive(Debug)]
pub struct Peer {
    /// Gone once nothing more is to be written.
    outbox: Option<SyncSender<Message>>,
    queued: Arc<AtomicUsize>,
    /// What must not be lost and found the queue full; the controller is held then, so
    /// that it stays small.
    overflow: VecDeque<Message>,
    /// To be shut down when the peer stalls; none where that cannot be done.
    socket: Option<TcpStream>,
    /// Whether anybody is at the other end now.
    up: Arc<AtomicBool>,
    /// Hears when the writer has written all, and ended.
    written: Receiver<()>,
    /// What is left to do at the end.
    ending: Option<Ending>,
}

/// Something to be done at the end.
struct Ending(Box<dyn FnOnce() + Send>);

impl std::fmt::Debug for Ending {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Ending")
    }
}

impl Peer {
    /// Starts the thread of a peer, which writes with `write` until nothing waits any more.
    /// A peer with a `socket` is disconnected when it does not keep up.
    pub fn start(
        socket: Option<TcpStream>,
        up: Arc<AtomicBool>,
        write: impl FnOnce(&Waiting) + Send + 'static,
    ) -> Self {
        let (outbox, messages) = sync_channel(QUEUE);
        let (done, written) = sync_channel(1);
        let queued = Arc::new(AtomicUsize::new(0));
        let waiting = Waiting {
            messages,
            queued: Arc::clone(&queued),
        };
        thread::spawn(move || {
            write(&waiting);
            // Whatever is still sent is of no use to anyone.
            while waiting.next().is_some() {}
            let _ = done.send(());
        });
        Self {
            outbox: Some(outbox),
            queued,
            overflow: VecDeque::new(),
            socket,
            up,
            written,
            ending: None,
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
        self.up.load(Ordering::Relaxed)
    }

    /// How many messages wait for it.
    pub fn queued(&self) -> usize {
        self.queued.load(Ordering::Relaxed) + self.overflow.len()
    }

    /// Sends a message, waiting for room.
    pub fn send(&mut self, message: Message) {
        if let Some(outbox) = &self.outbox {
            self.queued.fetch_add(1, Ordering::Relaxed);
            let _ = outbox.send(message);
        }
    }

    /// Sends a message if there is room; otherwise keeps it for later if it matters. Whether
    /// the peer keeps up: a socket that does not is shut down.
    pub fn try_send(&mut self, message: Message, matters: bool) -> bool {
        self.flush();
        // What does not matter must not take the room that tasks need.
        let room = self.socket.is_some() || self.queued() < QUEUE / 2;
        let left_out = !room || !self.is_up();
        if left_out && !matters {
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
        if let Some(socket) = &self.socket {
            let _ = socket.shutdown(Shutdown::Both);
            self.outbox = None;
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
        let outbox = self.outbox.as_ref()?;
        self.queued.fetch_add(1, Ordering::Relaxed);
        let Err(error) = outbox.try_send(message) else {
            return None;
        };
        self.queued.fetch_sub(1, Ordering::Relaxed);
        match error {
            TrySendError::Full(message) => Some(message),
            TrySendError::Disconnected(_) => None,
        }
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
