//! Connections over TCP: one thread accepts or connects, reads and writes them all.
//!
//! A peer takes one descriptor. What it says goes into the one inbox; where that is full
//! the peers wait, each as long as the others.

use super::descriptors::is_short;
use super::dialect::{Dialect, Ear, Voice};
use super::lines::{Line, Splitter};
use super::peer::{Peer, QUEUE, Socket};
use super::tls::{Stream, Tls};
use super::{Heard, INBOX, Origin, RETRY};
use pickline::error::{Error, Result, shown};
use crate::protocol::Message;
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

/// A peer that takes nothing for so long is disconnected.
pub const WRITE_TIME: Duration = Duration::from_secs(5);
/// How long the other side may take to agree on TLS.
const HANDSHAKE_TIME: Duration = Duration::from_secs(5);
/// How long a last word may take.
pub const FAREWELL_TIME: Duration = Duration::from_millis(200);
/// Connections that nobody has decided about yet, at most; more wait.
const NEWCOMERS: usize = 64;
/// Pause after a connection that could not be accepted: too many files are open.
const PAUSE: Duration = Duration::from_millis(100);
/// What the system may buffer for a peer [bytes].
#[cfg(unix)]
const BUFFER: usize = 1 << 16;
/// Bytes that are read at once, and written at once at least if there are as many.
const BLOCK: usize = 1 << 14;

/// A connection that nobody has decided about yet.
pub struct Connection {
    stream: Stream,
    /// Who is at the other end.
    pub address: Option<SocketAddr>,
    _newcomer: OwnedSemaphorePermit,
}

impl std::fmt::Debug for Connection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Connection").field(&self.address).finish()
    }
}

/// The way into the inbox, for those that must not block.
#[derive(Debug, Clone)]
struct Gate {
    inbox: SyncSender<Heard>,
    /// Room in the inbox.
    room: Arc<Semaphore>,
}

impl Gate {
    /// Hands on what was heard as soon as there is room; whether anybody hears it.
    async fn send(&self, heard: Heard) -> bool {
        match self.room.acquire().await {
            Ok(permit) => permit.forget(),
            Err(_) => return false,
        }
        // There is room for as many as there are permits.
        self.inbox.try_send(heard).is_ok()
    }
}

/// The thread of all connections.
#[derive(Debug)]
pub struct Tcp {
    handle: Handle,
    gate: Gate,
    tls: Option<Tls>,
    newcomers: Arc<Semaphore>,
    dialect: Dialect,
    /// Ends the thread when it is dropped.
    _stop: oneshot::Sender<()>,
}

impl Tcp {
    /// Starts the thread.
    ///
    /// # Errors
    /// A system that has no room for it.
    pub fn start(inbox: SyncSender<Heard>, tls: Option<Tls>, dialect: Dialect) -> Result<Self> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(|error| {
                let cure = "close other programs that have files open";
                Error::input("--listen", format!("no network: {error}"), cure)
            })?;
        let handle = runtime.handle().clone();
        let (stop, stopped) = oneshot::channel::<()>();
        thread::spawn(move || {
            let _ = runtime.block_on(stopped);
            runtime.shutdown_background();
        });
        let room = Arc::new(Semaphore::new(INBOX));
        Ok(Self {
            handle,
            gate: Gate { inbox, room },
            tls,
            newcomers: Arc::new(Semaphore::new(NEWCOMERS)),
            dialect,
            _stop: stop,
        })
    }

    /// Something was taken out of the inbox.
    pub fn taken(&self) {
        self.gate.room.add_permits(1);
    }

    /// Takes in whoever connects.
    ///
    /// # Errors
    /// A listener that cannot be waited for.
    pub fn listen(&self, listener: std::net::TcpListener) -> std::io::Result<()> {
        listener.set_nonblocking(true)?;
        let _in_runtime = self.handle.enter();
        let listener = tokio::net::TcpListener::from_std(listener)?;
        let accepting = Accepting {
            gate: self.gate.clone(),
            tls: self.tls.clone(),
            newcomers: Arc::clone(&self.newcomers),
        };
        self.handle.spawn(accepting.run(listener));
        Ok(())
    }

    /// Connects to `address` after a pause, trying until it works. That it has to be waited
    /// for is told once, and that somebody is there then.
    pub fn connect(&self, address: String, pause: Duration) {
        let (gate, tls) = (self.gate.clone(), self.tls.clone());
        let newcomers = Arc::clone(&self.newcomers);
        self.handle.spawn(async move {
            tokio::time::sleep(pause).await;
            let mut waits = false;
            loop {
                match connect(&address, tls.as_ref()).await {
                    Ok((stream, peer)) => {
                        if waits {
                            let text = format!("connected to {}", shown(&address));
                            gate.send(Heard::Remark(text)).await;
                        }
                        let Ok(permit) = newcomers.acquire_owned().await else {
                            return;
                        };
                        let connection = Connection {
                            stream,
                            address: peer,
                            _newcomer: permit,
                        };
                        gate.send(Heard::Joined(connection)).await;
                        return;
                    }
                    Err(error) if !waits => {
                        waits = true;
                        let at = shown(&address);
                        let text = format!("nobody to talk to at {at}: {error}; trying again");
                        if !gate.send(Heard::Remark(text)).await {
                            return;
                        }
                    }
                    Err(_) => {}
                }
                tokio::time::sleep(RETRY).await;
            }
        });
    }

    /// Reads and writes a connection from now on, as the peer of this number. With a
    /// `deadline` it is disconnected when it takes nothing for so long.
    pub fn serve(&self, number: u64, connection: Connection, deadline: Option<Duration>) -> Peer {
        let (reads, writes) = tokio::io::split(connection.stream);
        let (outbox, waiting) = mpsc::channel(QUEUE);
        let (done, written) = sync_channel(1);
        let (cut, is_cut) = watch::channel(false);
        let is_patient = Arc::new(AtomicBool::new(false));
        let (ear, voice) = self.dialect.of_a_peer();
        let reader = Reader {
            dialect: self.dialect,
            ear,
            number,
            address: connection.address,
            gate: self.gate.clone(),
            cut: is_cut.clone(),
        };
        self.handle.spawn(reader.run(reads));
        let (gate, patient) = (self.gate.clone(), Arc::clone(&is_patient));
        self.handle.spawn(async move {
            let stalled = tokio::select! {
                biased;
                () = cut_off(is_cut) => false,
                stalled = write_all(writes, waiting, (voice, &gate), deadline, &patient) => stalled,
            };
            let _ = done.try_send(());
            if stalled {
                gate.send(Heard::Stalled(number)).await;
            }
        });
        let socket = Socket {
            address: connection.address,
            cut,
            is_patient,
        };
        Peer::on_socket(outbox, written, socket)
    }

    /// Says one word to a connection and closes it.
    pub fn turn_away(&self, connection: Connection, word: &Message) {
        // It has said nothing yet; whatever it speaks, this is all it hears.
        let line = self.dialect.of_a_peer().1.say(word).unwrap_or_default();
        self.handle.spawn(async move {
            // The newcomers' permit lives as long.
            let mut connection = connection;
            let farewell = async {
                connection.stream.write_all(line.as_bytes()).await?;
                connection.stream.shutdown().await?;
                // Until it has gone: to close on what it has said would void the word.
                let mut rest = [0; 256];
                while connection.stream.read(&mut rest).await? > 0 {}
                std::io::Result::Ok(())
            };
            let _ = timeout(FAREWELL_TIME, farewell).await;
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
    match timeout(HANDSHAKE_TIME, tls.connect(host, stream)).await {
        Ok(stream) => Ok((stream?, peer)),
        Err(_) => Err(std::io::Error::other("it does not answer in TLS")),
    }
}

/// Sets how a connection is sent to. One that has gone is noticed when it is read.
fn prepare(stream: &TcpStream) {
    // Tasks are short and must not wait for more of them.
    let _ = stream.set_nodelay(true);
    // What waits in the system waits unseen, and grows old: megabytes, if it is let.
    #[cfg(unix)]
    let _ = nix::sys::socket::setsockopt(stream, nix::sys::socket::sockopt::SndBuf, &BUFFER);
}

/// What takes connections in.
struct Accepting {
    gate: Gate,
    tls: Option<Tls>,
    newcomers: Arc<Semaphore>,
}

impl Accepting {
    async fn run(self, listener: tokio::net::TcpListener) {
        // Said once, until it is over.
        let mut troubled = false;
        loop {
            // Those that wait for a decision are few; the others wait to be accepted.
            let Ok(permit) = Arc::clone(&self.newcomers).acquire_owned().await else {
                return;
            };
            let trouble = match listener.accept().await {
                Ok((stream, address)) if is_short(&stream) => Some(format!(
                    "{address} was turned away: this process may open few more files; allow it \
                     more with `ulimit -n`, or fewer peers with --max-peers"
                )),
                Ok((stream, address)) => {
                    self.take(stream, address, permit);
                    None
                }
                Err(error) => {
                    tokio::time::sleep(PAUSE).await;
                    Some(format!("no connection can be taken: {error}; trying again"))
                }
            };
            let was_troubled = std::mem::replace(&mut troubled, trouble.is_some());
            if let Some(text) = trouble.filter(|_| !was_troubled)
                && !self.gate.send(Heard::Remark(text)).await
            {
                return;
            }
        }
    }

    /// Hands a connection on, once both sides agree on TLS if there is to be any.
    fn take(&self, stream: TcpStream, address: SocketAddr, permit: OwnedSemaphorePermit) {
        prepare(&stream);
        let gate = self.gate.clone();
        let tls = self.tls.clone();
        tokio::spawn(async move {
            let stream: Stream = match tls {
                None => Box::new(stream),
                Some(tls) => match timeout(HANDSHAKE_TIME, tls.accept(stream)).await {
                    Ok(Ok(stream)) => stream,
                    Ok(Err(error)) => {
                        let text = format!("{address} was turned away: no TLS with it: {error}");
                        gate.send(Heard::Remark(text)).await;
                        return;
                    }
                    // Somebody who looks which ports are open.
                    Err(_) => return,
                },
            };
            let connection = Connection {
                stream,
                address: Some(address),
                _newcomer: permit,
            };
            gate.send(Heard::Joined(connection)).await;
        });
    }
}

/// Waits until the connection is to end at once; for ever, if it never is.
async fn cut_off(mut cut: watch::Receiver<bool>) {
    if cut.wait_for(|cut| *cut).await.is_err() {
        std::future::pending::<()>().await;
    }
}

/// What reads a peer.
struct Reader {
    dialect: Dialect,
    ear: Ear,
    number: u64,
    address: Option<SocketAddr>,
    gate: Gate,
    cut: watch::Receiver<bool>,
}

impl Reader {
    async fn run(mut self, reads: ReadHalf<Stream>) {
        tokio::select! {
            biased;
            () = cut_off(self.cut.clone()) => {}
            () = self.read_all(reads) => {}
        }
        self.gate.send(Heard::Left(self.number)).await;
    }

    async fn read_all(&mut self, mut reads: ReadHalf<Stream>) {
        let mut lines = Splitter::default();
        let mut block = vec![0; BLOCK];
        let mut is_new = true;
        loop {
            // One that breaks has gone too.
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
                    // A browser, a scanner or TLS: nothing that it says is meant for a line.
                    let start = String::from_utf8_lossy(&bytes[..bytes.len().min(40)]);
                    let start = start.lines().next().unwrap_or_default().to_owned();
                    self.gate.send(Heard::Foreign(self.number, start)).await;
                    // Until it is disconnected.
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

    async fn hand_on(&mut self, number: u64, line: Line) -> bool {
        let origin = Origin::Line {
            connection: self.number,
            peer: self.address,
            number,
        };
        for heard in self.ear.heard(&origin, line) {
            if !self.gate.send(heard).await {
                return false;
            }
        }
        true
    }
}

/// Writes messages as they come until there will be no more, and ends the stream; whether
/// the other side takes nothing any more. Where it takes nothing and is `patient`, it is
/// waited for.
async fn write_all(
    mut stream: WriteHalf<Stream>,
    mut waiting: mpsc::Receiver<Message>,
    (mut voice, gate): (Voice, &Gate),
    deadline: Option<Duration>,
    patient: &AtomicBool,
) -> bool {
    let mut block = String::new();
    while let Some(message) = waiting.recv().await {
        block.clear();
        let mut next = Some(message);
        while let Some(message) = next {
            match voice.say(&message) {
                Ok(lines) => block += &lines,
                Err(text) => drop(gate.send(Heard::Remark(text)).await),
            }
            next = (block.len() < BLOCK)
                .then(|| waiting.try_recv().ok())
                .flatten();
        }
        let mut rest = block.as_bytes();
        while !rest.is_empty() {
            let write = stream.write(rest);
            match timeout(deadline.unwrap_or(Duration::MAX), write).await {
                // One that has gone is noticed when it is read.
                Ok(Ok(0) | Err(_)) => return false,
                Ok(Ok(count)) => rest = &rest[count..],
                Err(_) if patient.load(Ordering::Relaxed) => {}
                Err(_) => return true,
            }
        }
        loop {
            match timeout(deadline.unwrap_or(Duration::MAX), stream.flush()).await {
                Ok(Ok(())) => break,
                Ok(Err(_)) => return false,
                Err(_) if patient.load(Ordering::Relaxed) => {}
                Err(_) => return true,
            }
        }
    }
    let _ = timeout(FAREWELL_TIME, stream.shutdown()).await;
    false
}
