//! The node under test, and its peers' connections: one of the camera, one of the encoder, one
//! of each robot.

use crate::programs::{Program, let_pass};
use pickline_live::protocol::{Incoming, Outgoing, decode_outgoing, encode};
use std::collections::VecDeque;
use std::io::{BufRead as _, BufReader, Write as _};
use std::net::{Shutdown, TcpStream};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::Duration;

/// Nothing takes so long unless it is stuck.
const STUCK: Duration = Duration::from_secs(120);

/// What is heard of a connection.
enum Heard {
    /// Its hello is accepted.
    Welcome,
    Message(Box<Outgoing>),
    End,
}

/// The number of a connection, and what is heard of it.
type Said = (u64, Heard);

struct Connection {
    number: u64,
    stream: TcpStream,
}

/// The program, with those of its peers that are connected.
pub struct Node {
    arguments: String,
    /// What each peer says first.
    hellos: Vec<String>,
    program: Option<Program>,
    address: String,
    peers: Vec<Option<Connection>>,
    connections: u64,
    sender: Sender<Said>,
    inbox: Receiver<Said>,
    /// What came before an answer that was waited for.
    early: VecDeque<Said>,
}

impl Node {
    pub fn new(arguments: String, hellos: Vec<String>) -> Self {
        let (sender, inbox) = channel();
        Self {
            arguments,
            program: None,
            address: String::new(),
            peers: hellos.iter().map(|_| None).collect(),
            hellos,
            connections: 0,
            sender,
            inbox,
            early: VecDeque::new(),
        }
    }

    fn receive(&mut self, patience: Duration) -> Option<Said> {
        let early = self.early.pop_front();
        early.or_else(|| self.inbox.recv_timeout(patience).ok())
    }

    pub fn is_up(&self) -> bool {
        self.program.is_some()
    }

    pub fn is_connected(&self, peer: usize) -> bool {
        self.peers[peer].is_some()
    }

    /// Starts the program and waits until it listens.
    pub fn start(&mut self) {
        let program = Program::pickline(&self.arguments, &[]);
        program.remarks.wait_for("listening at ");
        let remarks = program.remarks.all();
        let mut places = remarks
            .iter()
            .filter_map(|line| line.split("listening at ").nth(1));
        self.address = places.next().unwrap().to_owned();
        self.program = Some(program);
    }

    /// Starts the program and kills it at once, `after` a while.
    pub fn start_in_vain(&mut self, after: Duration) {
        let mut program = Program::pickline(&self.arguments, &[]);
        let_pass(after);
        program.signal("KILL");
        program.finish();
    }

    pub fn connect(&mut self, peer: usize) {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        stream.set_nodelay(true).unwrap();
        let _ = stream.write_all(self.hellos[peer].as_bytes());
        self.connections += 1;
        let number = self.connections;
        let (sender, reads) = (self.sender.clone(), stream.try_clone().unwrap());
        thread::spawn(move || {
            let mut reads = BufReader::new(reads);
            let mut line = Vec::new();
            // A line without an end was never said.
            while reads.read_until(b'\n', &mut line).is_ok() && line.ends_with(b"\n") {
                line.pop();
                let is_answer = line.windows(14).any(|part| part == br#""kind":"hello""#);
                let heard = if is_answer {
                    let accepted = line.windows(15).any(|part| part == br#""accepted":true"#);
                    assert!(accepted, "{}", String::from_utf8_lossy(&line));
                    Heard::Welcome
                } else {
                    Heard::Message(Box::new(decode_outgoing(&line).unwrap()))
                };
                let _ = sender.send((number, heard));
                line.clear();
            }
            let _ = sender.send((number, Heard::End));
        });
        self.peers[peer] = Some(Connection { number, stream });
        loop {
            let said = self
                .inbox
                .recv_timeout(STUCK)
                .expect("an answer to a hello");
            if matches!(said, (from, Heard::Welcome) if from == number) {
                return;
            }
            self.early.push_back(said);
        }
    }

    pub fn hang_up(&mut self, peer: usize) {
        if let Some(connection) = self.peers[peer].take() {
            let _ = connection.stream.shutdown(Shutdown::Both);
        }
    }

    /// Says a message, and what it was that one peer wants to say is lost if the node is gone.
    pub fn say(&mut self, peer: usize, message: &Incoming) {
        if let Some(connection) = &mut self.peers[peer] {
            let _ = connection.stream.write_all(encode(message).as_bytes());
        }
    }

    fn peer(&self, number: u64) -> Option<usize> {
        let is_it = |peer: &Option<Connection>| peer.as_ref().is_some_and(|c| c.number == number);
        self.peers.iter().position(is_it)
    }

    /// With message time: what is said until all `ticks` at `stamp` are answered, to all.
    pub fn until_due(&mut self, stamp: f64, ticks: usize) -> Vec<(usize, Outgoing)> {
        let mut said = Vec::new();
        let mut waits: Vec<usize> = self
            .peers
            .iter()
            .map(|p| ticks * usize::from(p.is_some()))
            .collect();
        while waits.iter().any(|waits| *waits > 0) {
            let Some((number, heard)) = self.receive(STUCK) else {
                panic!(
                    "no answer to the tick at {stamp}: {waits:?}, {:?}",
                    self.remarks()
                );
            };
            let Some(peer) = self.peer(number) else {
                continue;
            };
            match heard {
                Heard::Message(message) => {
                    if matches!(&*message, Outgoing::Due(due) if due.stamp == stamp) {
                        waits[peer] = waits[peer].saturating_sub(1);
                    }
                    said.push((peer, *message));
                }
                Heard::Welcome => {}
                Heard::End => panic!("the node has hung up on {peer}: {:?}", self.remarks()),
            }
        }
        said
    }

    /// What is said within `patience`.
    pub fn hear(&mut self, patience: Duration) -> Vec<(usize, Outgoing)> {
        let mut said = Vec::new();
        let mut next = self.receive(patience);
        while let Some((number, heard)) = next {
            if let Some(peer) = self.peer(number) {
                match heard {
                    Heard::Message(message) => said.push((peer, *message)),
                    Heard::Welcome => {}
                    Heard::End => panic!("the node has hung up on {peer}: {:?}", self.remarks()),
                }
            }
            next = self.receive(Duration::ZERO);
        }
        said
    }

    fn remarks(&self) -> Vec<String> {
        self.program
            .as_ref()
            .map_or(Vec::new(), |program| program.remarks.all())
    }

    /// What all connections say until they end.
    fn rest(&mut self) -> Vec<(usize, Outgoing)> {
        let mut said = Vec::new();
        while self.peers.iter().any(Option::is_some) {
            let (number, heard) = self.receive(STUCK).expect("an end");
            if let Some(peer) = self.peer(number) {
                match heard {
                    Heard::Message(message) => said.push((peer, *message)),
                    Heard::Welcome => {}
                    Heard::End => self.peers[peer] = None,
                }
            }
        }
        said
    }

    /// Kills the program; what it has said to the last.
    pub fn kill(&mut self) -> Vec<(usize, Outgoing)> {
        let mut program = self.program.take().expect("it runs");
        program.signal("KILL");
        program.finish();
        self.rest()
    }

    /// Ends the run; what it has said to the last, and its remarks.
    pub fn finish(&mut self, with_signal: bool) -> (Vec<(usize, Outgoing)>, String) {
        let mut program = self.program.take().expect("it runs");
        if with_signal {
            program.signal("TERM");
        } else {
            for connection in self.peers.iter().flatten() {
                let _ = connection.stream.shutdown(Shutdown::Write);
            }
        }
        let said = self.rest();
        let (code, remarks) = program.finish();
        assert_eq!(code, Some(0), "{remarks}");
        (said, remarks)
    }
}
