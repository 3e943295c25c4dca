//! TCP connections: one thread accepts, connects, reads and writes all of them.
//!
//! A peer takes one descriptor. All messages go into one inbox; if it is full, the peers wait in
//! turn.

use super::connection::Connection;
use super::descriptors::is_short;
use super::dialect::{Dialect, DialectReader, DialectWriter};
use super::event::TransportEvent;
use super::lines::{InputLine, LineSplitter};
use super::origin::Origin;
use super::peer::{Peer, PeerSocket, QUEUE_CAPACITY};
use super::tls::{Stream, Tls};
use super::{INBOX_CAPACITY, RETRY_INTERVAL};
use crate::RemarkSetting;
use crate::protocol::Message;
use pickline::error::{Error, Result, shown};
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread;
use std::time::Duration;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _, ReadHalf, WriteHalf};
use tokio::net::TcpStream;
use tokio::runtime::Handle;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc, oneshot, watch};
use tokio::time::timeout;

/// A peer that reads nothing for this time is disconnected.
pub(super) const WRITE_TIMEOUT: Duration = Duration::from_secs(5);
/// Timeout for the TLS handshake.
const HANDSHAKE_TIMEOUT: Duration = Duration::from_secs(5);
/// Time for sending a last message.
pub(super) const CLOSE_TIMEOUT: Duration = Duration::from_millis(200);
/// Maximum number of connections that are not yet admitted; further ones wait.
const MOST_PENDING: usize = 64;
/// Pause after a failed accept, which means that too many files are open.
const ACCEPT_RETRY_DELAY: Duration = Duration::from_millis(100);
/// Size of the system's send buffer for a peer [bytes].
#[cfg(unix)]
const SEND_BUFFER_SIZE: usize = 1 << 16;
/// Number of bytes that are read at once, and collected before a write if there are that many.
const READ_BLOCK_SIZE: usize = 1 << 14;

/// A sender to the inbox for tasks that must not block.
#[derive(Debug, Clone)]
struct InboxSender {
    inbox: SyncSender<TransportEvent>,
    /// Free space in the inbox.
    room: Arc<Semaphore>,
}

impl InboxSender {
    /// Sends an event as soon as there is space. Returns whether there is a receiver.
    async fn send(&self, heard: TransportEvent) -> bool {
        match self.room.acquire().await {
            Ok(permit) => permit.forget(),
            Err(_) => return false,
        }
        // There is space for as many events as there are permits.
        self.inbox.try_send(heard).is_ok()
    }
}

/// The thread of all connections.
#[derive(Debug)]
pub(super) struct Tcp {
    handle: Handle,
    gate: InboxSender,
    tls: Option<Tls>,
    pending: Arc<Semaphore>,
    dialect: Dialect,
    /// Ends the thread when dropped.
    _stop: oneshot::Sender<()>,
}

impl Tcp {
    /// Starts the thread.
    ///
    /// # Errors
    /// The system cannot provide the thread or its files.
    pub(super) fn start(
        inbox: SyncSender<TransportEvent>,
        tls: Option<Tls>,
        dialect: Dialect,
    ) -> Result<Self> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(|error| {
                let cure = "close other programs that have files open";
                let problem = format!("cannot set up the network: {error}");
                Error::resources("'listen'", problem, cure).caused_by(error)
            })?;
        let handle = runtime.handle().clone();
        let (stop, stopped) = oneshot::channel::<()>();
        thread::spawn(move || {
            let _ = runtime.block_on(stopped);
            runtime.shutdown_background();
        });
        let room = Arc::new(Semaphore::new(INBOX_CAPACITY));
        Ok(Self {
            handle,
            gate: InboxSender { inbox, room },
            tls,
            pending: Arc::new(Semaphore::new(MOST_PENDING)),
            dialect,
            _stop: stop,
        })
    }

    /// Notes that an event was taken out of the inbox.
    pub(super) fn free_inbox_slot(&self) {
        self.gate.room.add_permits(1);
    }

    /// Accepts connections.
    ///
    /// # Errors
    /// The listener cannot be polled.
    pub(super) fn listen(&self, listener: std::net::TcpListener) -> std::io::Result<()> {
        listener.set_nonblocking(true)?;
        let _in_runtime = self.handle.enter();
        let listener = tokio::net::TcpListener::from_std(listener)?;
        let accepting = Accepting {
            gate: self.gate.clone(),
            tls: self.tls.clone(),
            pending: Arc::clone(&self.pending),
        };
        self.handle.spawn(accepting.run(listener));
        Ok(())
    }

    /// Connects to `address` after a pause, and retries until it works. Waiting is reported once,
    /// and so is the connection that follows.
    pub(super) fn connect(&self, address: String, pause: Duration) {
        let (gate, tls) = (self.gate.clone(), self.tls.clone());
        let pending = Arc::clone(&self.pending);
        self.handle.spawn(async move {
            tokio::time::sleep(pause).await;
            let mut waits = false;
            loop {
                match connect(&address, tls.as_ref()).await {
                    Ok((stream, peer)) => {
                        if waits {
                            let text = format!("connected to {}", shown(&address));
                            gate.send(TransportEvent::Remark(text)).await;
                        }
                        let Ok(permit) = pending.acquire_owned().await else {
                            return;
                        };
                        let connection = Connection {
                            stream,
                            address: peer,
                            pending: permit,
                        };
                        gate.send(TransportEvent::Joined(connection)).await;
                        return;
                    }
                    Err(error) if !waits => {
                        waits = true;
                        let at = shown(&address);
                        let text = format!("no connection to {at}: {error}; retrying");
                        if !gate.send(TransportEvent::Remark(text)).await {
                            return;
                        }
                    }
                    Err(_) => {}
                }
                tokio::time::sleep(RETRY_INTERVAL).await;
            }
        });
    }

    /// Reads and writes a connection from now on, as the peer `number`. It is disconnected if it
    /// reads nothing for the time `deadline`, if there is one.
    pub(super) fn serve(
        &self,
        number: u64,
        connection: Connection,
        deadline: Option<Duration>,
    ) -> Peer {
        let (reads, writes) = tokio::io::split(connection.stream);
        let (outbox, waiting) = mpsc::channel(QUEUE_CAPACITY);
        let (done, written) = sync_channel(1);
        let (cut, is_cut) = watch::channel(false);
        let waits_when_stalled = Arc::new(AtomicBool::new(false));
        let (reader, writer) = self.dialect.reader_and_writer();
        let reader = ConnectionReader {
            dialect: self.dialect,
            reader,
            number,
            address: connection.address,
            gate: self.gate.clone(),
            cut: is_cut.clone(),
        };
        self.handle.spawn(reader.run(reads));
        let (gate, waits) = (self.gate.clone(), Arc::clone(&waits_when_stalled));
        self.handle.spawn(async move {
            let stalled = tokio::select! {
                biased;
                () = cut_off(is_cut) => false,
                stalled = write_all(writes, waiting, (writer, &gate), deadline, &waits) => stalled,
            };
            let _ = done.try_send(());
            if stalled {
                gate.send(TransportEvent::Stalled(number)).await;
            }
        });
        let socket = PeerSocket {
            address: connection.address,
            cut,
            waits_when_stalled,
        };
        Peer::on_socket(outbox, written, socket)
    }

    /// Sends one message to a connection and closes it.
    pub(super) fn reject(&self, connection: Connection, word: &Message) {
        // It has sent nothing yet, so its dialect is unknown.
        let line = self
            .dialect
            .reader_and_writer()
            .1
            .write(word)
            .unwrap_or_default();
        self.handle.spawn(async move {
            // The permit is held as long as the connection.
            let mut connection = connection;
            let farewell = async {
                connection.stream.write_all(line.as_bytes()).await?;
                connection.stream.shutdown().await?;
                // Read until it has gone, because closing with unread input would discard the
                // message.
                let mut rest = [0; 256];
                while connection.stream.read(&mut rest).await? > 0 {}
                std::io::Result::Ok(())
            };
            let _ = timeout(CLOSE_TIMEOUT, farewell).await;
        });
    }
}

async fn connect(
    address: &str,
    tls: Option<&Tls>,
) -> std::io::Result<(Stream, Option<SocketAddr>)> {
    let stream = TcpStream::connect(address).await?;
    prepare(&stream);
    let peer = stream.peer_addr().ok();
    let Some(tls) = tls else {
        return Ok((Box::new(stream), peer));
    };
    let host = address.rsplit_once(':').map_or(address, |(host, _)| host);
    match timeout(HANDSHAKE_TIMEOUT, tls.connect(host, stream)).await {
        Ok(stream) => Ok((stream?, peer)),
        Err(_) => Err(std::io::Error::other("it does not answer with TLS")),
    }
}

/// Sets the options for sending. A connection that is gone is noticed when it is read.
fn prepare(stream: &TcpStream) {
    // Tasks are short and must not wait for further ones.
    let _ = stream.set_nodelay(true);
    // Messages in the system's buffer are not counted as queued and grow old; by default it holds
    // megabytes.
    #[cfg(unix)]
    let _ =
        nix::sys::socket::setsockopt(stream, nix::sys::socket::sockopt::SndBuf, &SEND_BUFFER_SIZE);
}

/// Accepts connections.
struct Accepting {
    gate: InboxSender,
    tls: Option<Tls>,
    pending: Arc<Semaphore>,
}

impl Accepting {
    async fn run(self, listener: tokio::net::TcpListener) {
        // Reported once, until the problem is over.
        let mut troubled = false;
        loop {
            // Only a few connections wait for admission; others wait to be accepted.
            let Ok(permit) = Arc::clone(&self.pending).acquire_owned().await else {
                return;
            };
            let trouble = match listener.accept().await {
                Ok((stream, address)) if is_short(&stream) => Some(format!(
                    "{address} was turned away: this process is almost out of file descriptors; \
                     allow more with `ulimit -n`, or fewer peers with {}",
                    RemarkSetting::MaxPeers
                )),
                Ok((stream, address)) => {
                    self.take(stream, address, permit);
                    None
                }
                Err(error) => {
                    tokio::time::sleep(ACCEPT_RETRY_DELAY).await;
                    Some(format!("cannot accept connections: {error}; retrying"))
                }
            };
            let was_troubled = std::mem::replace(&mut troubled, trouble.is_some());
            if let Some(text) = trouble.filter(|_| !was_troubled)
                && !self.gate.send(TransportEvent::Remark(text)).await
            {
                return;
            }
        }
    }

    /// Passes on a connection, after the TLS handshake if TLS is used.
    fn take(&self, stream: TcpStream, address: SocketAddr, permit: OwnedSemaphorePermit) {
        prepare(&stream);
        let gate = self.gate.clone();
        let tls = self.tls.clone();
        tokio::spawn(async move {
            let stream: Stream = match tls {
                None => Box::new(stream),
                Some(tls) => match timeout(HANDSHAKE_TIMEOUT, tls.accept(stream)).await {
                    Ok(Ok(stream)) => stream,
                    Ok(Err(error)) => {
                        let text = format!(
                            "{address} was turned away: the TLS handshake failed: \
                                            {error}"
                        );
                        gate.send(TransportEvent::Remark(text)).await;
                        return;
                    }
                    // A port scanner.
                    Err(_) => return,
                },
            };
            let connection = Connection {
                stream,
                address: Some(address),
                pending: permit,
            };
            gate.send(TransportEvent::Joined(connection)).await;
        });
    }
}

/// Waits until the connection must end at once; possibly for ever.
async fn cut_off(mut cut: watch::Receiver<bool>) {
    if cut.wait_for(|cut| *cut).await.is_err() {
        std::future::pending::<()>().await;
    }
}

/// Reads a peer.
struct ConnectionReader {
    dialect: Dialect,
    reader: DialectReader,
    number: u64,
    address: Option<SocketAddr>,
    gate: InboxSender,
    cut: watch::Receiver<bool>,
}

impl ConnectionReader {
    async fn run(mut self, reads: ReadHalf<Stream>) {
        tokio::select! {
            biased;
            () = cut_off(self.cut.clone()) => {}
            () = self.read_all(reads) => {}
        }
        self.gate.send(TransportEvent::Left(self.number)).await;
    }

    async fn read_all(&mut self, mut reads: ReadHalf<Stream>) {
        let mut lines = LineSplitter::default();
        let mut block = vec![0; READ_BLOCK_SIZE];
        let mut is_new = true;
        loop {
            // A broken connection has ended too.
            let count = reads.read(&mut block).await.unwrap_or(0);
            if count == 0 {
                if let Some((number, line)) = lines.end() {
                    self.hand_on(number, line).await;
                }
                return;
            }
            let mut bytes = &block[..count];
            if is_new && !bytes.trim_ascii().is_empty() {
                is_new = false;
                if !self.dialect.may_begin(bytes) {
                    // A browser, a scanner or TLS: nothing that it sends is meant for a line.
                    let start = String::from_utf8_lossy(&bytes[..bytes.len().min(40)]);
                    let start = start.lines().next().unwrap_or_default().to_owned();
                    self.gate
                        .send(TransportEvent::Foreign(self.number, start))
                        .await;
                    // Discard input until it is disconnected.
                    while reads.read(&mut block).await.unwrap_or(0) > 0 {}
                    return;
                }
            }
            while let Some((number, line)) = lines.next(&mut bytes) {
                if !self.hand_on(number, line).await {
                    return;
                }
            }
        }
    }

    async fn hand_on(&mut self, number: u64, line: InputLine) -> bool {
        let origin = Origin::Line {
            connection: self.number,
            peer: self.address,
            number,
        };
        for heard in self.reader.events(&origin, line) {
            if !self.gate.send(heard).await {
                return false;
            }
        }
        true
    }
}

/// Writes messages as they come until there will be no more, and ends the stream. Returns whether
/// the other side has stopped reading. If `waits` is set, it waits for such a peer.
async fn write_all(
    mut stream: WriteHalf<Stream>,
    mut waiting: mpsc::Receiver<Message>,
    (mut writer, gate): (DialectWriter, &InboxSender),
    deadline: Option<Duration>,
    waits: &AtomicBool,
) -> bool {
    let mut block = String::new();
    while let Some(message) = waiting.recv().await {
        block.clear();
        let mut next = Some(message);
        while let Some(message) = next {
            match writer.write(&message) {
                Ok(lines) => block += &lines,
                Err(text) => drop(gate.send(TransportEvent::Remark(text)).await),
            }
            next = (block.len() < READ_BLOCK_SIZE)
                .then(|| waiting.try_recv().ok())
                .flatten();
        }
        let mut rest = block.as_bytes();
        while !rest.is_empty() {
            let write = stream.write(rest);
            match timeout(deadline.unwrap_or(Duration::MAX), write).await {
                // A connection that is gone is noticed when it is read.
                Ok(Ok(0) | Err(_)) => return false,
                Ok(Ok(count)) => rest = &rest[count..],
                Err(_) if waits.load(Ordering::Relaxed) => {}
                Err(_) => return true,
            }
        }
        loop {
            match timeout(deadline.unwrap_or(Duration::MAX), stream.flush()).await {
                Ok(Ok(())) => break,
                Ok(Err(_)) => return false,
                Err(_) if waits.load(Ordering::Relaxed) => {}
                Err(_) => return true,
            }
        }
    }
    let _ = timeout(CLOSE_TIMEOUT, stream.shutdown()).await;
    false
}
