//! JSON Lines over a pair of blocking byte streams: stdin and stdout.

use super::dialect::{Dialect, DialectReader, DialectWriter};
use super::lines::LineReader;
use super::peer::{Peer, Waiting};
use super::{Origin, TransportEvent};
use pickline::error::Error;
use std::io::{BufReader, BufWriter, Read, Write};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{SyncSender, TrySendError};
use std::thread;

/// Starts the threads of a peer on two streams. Its messages go to `inbox`, under its number.
pub(super) fn start(
    number: u64,
    reads: impl Read + Send + 'static,
    writes: impl Write + Send + 'static,
    dialect: Dialect,
    inbox: SyncSender<TransportEvent>,
) -> Peer {
    let told = inbox.clone();
    let (reader, writer) = dialect.reader_and_writer();
    thread::spawn(move || read_all(number, reads, reader, &inbox));
    Peer::start(Arc::new(AtomicBool::new(true)), move |waiting| {
        // Report from another thread if the inbox is full, because its reader may be waiting for
        // this thread to finish.
        if let Err(error) = write_all(BufWriter::new(writes), waiting, writer, &told)
            && let Err(TrySendError::Full(heard)) = told.try_send(unwritten(number, &error))
        {
            thread::spawn(move || told.send(heard));
        }
    })
}

/// The event for a stdout that cannot be written: it has left if its reader has closed it.
fn unwritten(number: u64, error: &std::io::Error) -> TransportEvent {
    match error.kind() {
        std::io::ErrorKind::BrokenPipe => TransportEvent::Left(number),
        _ => TransportEvent::Failed(Error::resources(
            "stdout",
            error.to_string(),
            "redirect it to where it can be written",
        )),
    }
}

fn read_all(
    peer: u64,
    reads: impl Read,
    mut reader: DialectReader,
    inbox: &SyncSender<TransportEvent>,
) {
    let mut lines = LineReader::new(BufReader::new(reads));
    while let Ok(Some((number, line))) = lines.next() {
        let origin = Origin::Line {
            connection: peer,
            peer: None,
            number,
        };
        for heard in reader.events(&origin, line) {
            if inbox.send(heard).is_err() {
                return;
            }
        }
    }
    let _ = inbox.send(TransportEvent::Left(peer));
}

/// Writes messages as they come, and flushes when there are none at the moment.
fn write_all(
    mut stream: impl Write,
    waiting: &mut Waiting,
    mut writer: DialectWriter,
    told: &SyncSender<TransportEvent>,
) -> std::io::Result<()> {
    while let Some(first) = waiting.next() {
        let mut next = Some(first);
        while let Some(message) = next {
            match writer.write(&message) {
                Ok(lines) => stream.write_all(lines.as_bytes())?,
                // If there is no space, only this remark is lost.
                Err(text) => drop(told.try_send(TransportEvent::Remark(text))),
            }
            next = waiting.try_next().ok();
        }
        stream.flush()?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::gate::Gate;
    use super::super::peer::QUEUE_CAPACITY;
    use super::*;
    use crate::protocol::{Ack, Incoming};
    use std::sync::mpsc::sync_channel;

    fn message(task: u64) -> Incoming {
        Incoming::Ack(Ack { stamp: 0.0, task })
    }

    #[test]
    fn a_stalled_stream_loses_nothing_that_matters() {
        let gate = Gate::default();
        let (inbox, _heard) = sync_channel(1);
        let mut peer = start(0, std::io::empty(), gate.clone(), Dialect::Json, inbox);
        let mut all = Vec::new();
        for i in 0..3 * QUEUE_CAPACITY as u64 {
            let matters = i % 3 == 0;
            // Until the queue is full there is space for everything.
            assert!(peer.try_send(message(i).into(), matters));
            if matters {
                all.push(i);
            }
        }
        assert!(peer.queued() >= QUEUE_CAPACITY);
        gate.open();
        while peer.queued() > 0 {
            peer.flush();
            thread::yield_now();
        }
        peer.close(std::time::Duration::from_secs(60));
        let written = gate.bytes();
        let numbers = written
            .split(|byte| *byte == b'\n')
            .filter(|l| !l.is_empty());
        let numbers = numbers.map(|line| match crate::protocol::decode(line) {
            Ok(Incoming::Ack(ack)) => ack.task,
            other => panic!("{other:?}"),
        });
        let numbers: Vec<u64> = numbers.collect();
        assert!(numbers.is_sorted());
        let mattering = numbers.iter().copied().filter(|i| i % 3 == 0);
        assert_eq!(mattering.collect::<Vec<u64>>(), all);
        // Half of the space is for messages that matter.
        assert!(numbers.len() - all.len() <= QUEUE_CAPACITY / 2);
    }
}
