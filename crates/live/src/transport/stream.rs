//! JSON Lines over a pair of blocking byte streams: stdin and stdout.

use super::dialect::{Dialect, Ear, Voice};
use super::lines::Lines;
use super::peer::{Peer, Waiting};
use super::{Heard, Origin};
use pickline::error::Error;
use std::io::{BufReader, BufWriter, Read, Write};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{SyncSender, TrySendError};
use std::thread;

/// Starts the threads of a peer on two streams. Its messages go to `inbox`, under its number.
pub fn start(
    number: u64,
    reads: impl Read + Send + 'static,
    writes: impl Write + Send + 'static,
    dialect: Dialect,
    inbox: SyncSender<Heard>,
) -> Peer {
    let told = inbox.clone();
    let (ear, voice) = dialect.of_a_peer();
    thread::spawn(move || read_all(number, reads, ear, &inbox));
    Peer::start(Arc::new(AtomicBool::new(true)), move |waiting| {
        // Report from another thread if the inbox is full, because its reader may be waiting for
        // this thread to finish.
        if let Err(error) = write_all(BufWriter::new(writes), waiting, voice, &told)
            && let Err(TrySendError::Full(heard)) = told.try_send(unwritten(number, &error))
        {
            thread::spawn(move || told.send(heard));
        }
    })
}

/// The event for a stdout that cannot be written: it has left if its reader has closed it.
fn unwritten(number: u64, error: &std::io::Error) -> Heard {
    match error.kind() {
        std::io::ErrorKind::BrokenPipe => Heard::Left(number),
        _ => Heard::Failed(Error::input(
            "stdout",
            error.to_string(),
            "redirect it to where it can be written",
        )),
    }
}

fn read_all(peer: u64, reads: impl Read, mut ear: Ear, inbox: &SyncSender<Heard>) {
    let mut lines = Lines::new(BufReader::new(reads));
    while let Ok(Some((number, line))) = lines.next() {
        let origin = Origin::Line {
            connection: peer,
            peer: None,
            number,
        };
        for heard in ear.heard(&origin, line) {
            if inbox.send(heard).is_err() {
                return;
            }
        }
    }
    let _ = inbox.send(Heard::Left(peer));
}

/// Writes messages as they come, and flushes when there are none at the moment.
fn write_all(
    mut stream: impl Write,
    waiting: &mut Waiting,
    mut voice: Voice,
    told: &SyncSender<Heard>,
) -> std::io::Result<()> {
    while let Some(first) = waiting.next() {
        let mut next = Some(first);
        while let Some(message) = next {
            match voice.say(&message) {
                Ok(lines) => stream.write_all(lines.as_bytes())?,
                // If there is no space, only this remark is lost.
                Err(text) => drop(told.try_send(Heard::Remark(text))),
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
    use super::super::peer::QUEUE;
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
        for i in 0..3 * QUEUE as u64 {
            let matters = i % 3 == 0;
            // Until the queue is full there is space for everything.
            assert!(peer.try_send(message(i).into(), matters));
            if matters {
                all.push(i);
            }
        }
        assert!(peer.queued() >= QUEUE);
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
        assert!(numbers.len() - all.len() <= QUEUE / 2);
    }
}
