//! One peer: a thread that reads its lines, a thread that writes to it, a bounded queue.

use super::Heard;
use super::lines::{Line, next_line};
use std::collections::VecDeque;
use std::io::{BufReader, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread;

/// Lines that wait for one peer at most.
pub const QUEUE: usize = 1024;

/// The side of a peer that is written to.
#[derive(Debug)]
pub struct Peer {
    /// Gone once nothing more is to be written.
    outbox: Option<SyncSender<String>>,
    queued: Arc<AtomicUsize>,
    /// What must not be lost and found the queue full; the controller is held then, so
    /// that it stays small.
    overflow: VecDeque<String>,
    /// To be shut down when the peer stalls; none for stdout.
    socket: Option<TcpStream>,
    /// Hears when the writer has written all, and ended.
    written: Receiver<()>,
}

impl Peer {
    /// Starts the threads of a peer. What it says goes to `inbox`, under its number.
    pub fn start(
        number: u64,
        reads: impl Read + Send + 'static,
        writes: impl Write + Send + 'static,
        socket: Option<TcpStream>,
        inbox: SyncSender<Heard>,
    ) -> Self {
        let (outbox, lines) = sync_channel(QUEUE);
        let (done, written) = sync_channel(1);
        let queued = Arc::new(AtomicUsize::new(0));
        let waiting = Arc::clone(&queued);
        let closing = socket.as_ref().and_then(|socket| socket.try_clone().ok());
        thread::spawn(move || {
            // A peer that has gone is noticed by its reader.
            let _ = write_all(writes, &lines, &waiting);
            if let Some(socket) = closing {
                let _ = socket.shutdown(Shutdown::Write);
            }
            // Whatever is still sent is of no use to anyone.
            while lines.recv().is_ok() {
                waiting.fetch_sub(1, Ordering::Relaxed);
            }
            let _ = done.send(());
        });
        thread::spawn(move || {
            let mut stream = BufReader::new(reads);
            while let Ok(Some(line)) = next_line(&mut stream) {
                let heard = match line {
                    Line::Whole(line) => Heard::Line(number, line),
                    Line::TooLong => Heard::TooLong(number),
                };
                if inbox.send(heard).is_err() {
                    return;
                }
            }
            let _ = inbox.send(Heard::Left(number));
        });
        Self {
            outbox: Some(outbox),
            queued,
            overflow: VecDeque::new(),
            socket,
            written,
        }
    }

    /// How many lines wait for it.
    pub fn queued(&self) -> usize {
        self.queued.load(Ordering::Relaxed) + self.overflow.len()
    }

    /// Sends a line, waiting for room.
    pub fn send(&mut self, line: String) {
        if let Some(outbox) = &self.outbox {
            self.queued.fetch_add(1, Ordering::Relaxed);
            let _ = outbox.send(line);
        }
    }

    /// Sends a line if there is room; otherwise keeps it for later if it matters. Whether
    /// the peer keeps up: a socket that does not is shut down.
    pub fn try_send(&mut self, line: String, matters: bool) -> bool {
        self.flush();
        let refused = if self.overflow.is_empty() {
            self.pass(line)
        } else {
            Some(line)
        };
        let Some(line) = refused else {
            return true;
        };
        if let Some(socket) = &self.socket {
            let _ = socket.shutdown(Shutdown::Both);
            self.outbox = None;
            return false;
        }
        if matters {
            self.overflow.push_back(line);
        }
        true
    }

    /// Sends what was kept, as far as there is room.
    pub fn flush(&mut self) {
        while let Some(line) = self.overflow.pop_front() {
            if let Some(line) = self.pass(line) {
                self.overflow.push_front(line);
                break;
            }
        }
    }

    /// Gives the line back if there is no room.
    fn pass(&self, line: String) -> Option<String> {
        let outbox = self.outbox.as_ref()?;
        self.queued.fetch_add(1, Ordering::Relaxed);
        let Err(error) = outbox.try_send(line) else {
            return None;
        };
        self.queued.fetch_sub(1, Ordering::Relaxed);
        match error {
            TrySendError::Full(line) => Some(line),
            TrySendError::Disconnected(_) => None,
        }
    }

    /// Writes what is left, ends the stream, and waits for that at most `patience`.
    pub fn close(mut self, patience: std::time::Duration) {
        self.flush();
        self.outbox = None;
        let _ = self.written.recv_timeout(patience);
    }

    /// Ends the stream after what is still to be written; the peer may go on talking.
    pub fn finish_writing(&mut self) {
        self.flush();
        self.outbox = None;
    }
}

/// Writes lines as they come, and flushes when there is none for the moment.
fn write_all(
    mut stream: impl Write,
    lines: &Receiver<String>,
    waiting: &AtomicUsize,
) -> std::io::Result<()> {
    while let Ok(first) = lines.recv() {
        let mut next = Some(first);
        while let Some(line) = next {
            let result = stream.write_all(line.as_bytes());
            waiting.fetch_sub(1, Ordering::Relaxed);
            result?;
            next = lines.try_recv().ok();
        }
        stream.flush()?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Condvar, Mutex};

    /// A stream that takes nothing until it is opened.
    #[derive(Clone, Default)]
    struct Gate(Arc<(Mutex<Taken>, Condvar)>);

    #[derive(Default)]
    struct Taken {
        open: bool,
        bytes: Vec<u8>,
    }

    impl Gate {
        fn open(&self) {
            self.0.0.lock().unwrap().open = true;
            self.0.1.notify_all();
        }
    }

    impl Write for Gate {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            let state = self.0.0.lock().unwrap();
            let mut state = self.0.1.wait_while(state, |state| !state.open).unwrap();
            state.bytes.extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_stalled_stream_loses_nothing_that_matters() {
        let gate = Gate::default();
        let (inbox, _heard) = sync_channel(1);
        let mut peer = Peer::start(0, std::io::empty(), gate.clone(), None, inbox);
        let mut all = String::new();
        for i in 0..3 * QUEUE {
            let matters = i % 3 == 0;
            // Until the queue is full everything has room.
            let line = format!("{i}\n");
            assert!(peer.try_send(line.clone(), matters));
            if matters {
                all += &line;
            }
        }
        assert!(peer.queued() >= QUEUE);
        gate.open();
        while !peer.overflow.is_empty() {
            peer.flush();
            thread::yield_now();
        }
        peer.close(std::time::Duration::from_secs(60));
        let written = String::from_utf8(gate.0.0.lock().unwrap().bytes.clone()).unwrap();
        let numbers: Vec<usize> = written.lines().map(|line| line.parse().unwrap()).collect();
        assert!(numbers.is_sorted());
        let mattering = numbers.iter().filter(|i| **i % 3 == 0);
        assert_eq!(mattering.map(|i| format!("{i}\n")).collect::<String>(), all);
        assert!(numbers.len() < 3 * QUEUE);
    }

    #[test]
    fn a_socket_that_stalls_is_disconnected() {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let ours = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let theirs = listener.accept().unwrap().0;
        let (inbox, heard) = sync_channel(1);
        let (reads, writes) = (ours.try_clone().unwrap(), ours.try_clone().unwrap());
        let mut peer = Peer::start(7, reads, writes, Some(ours), inbox);
        let line = "x".repeat(60_000) + "\n";
        // The system's buffers and the queue are full at some time.
        while peer.try_send(line.clone(), true) {}
        assert!(matches!(heard.recv().unwrap(), Heard::Left(7)));
        drop(theirs);
    }
}
