//! The example of live control gives the tasks that the program gives.

use crate::common::pickline;
use crate::programs::feed;
use pickline_live::node::NodeMonitor;
use pickline_live::transport::{Endpoint, Hub};
use std::io::{Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::process::Command;
use std::sync::mpsc::{Sender, channel};

#[path = "../../crates/live/examples/run.rs"]
#[allow(dead_code)]
mod run_example;

/// Tells where the node listens.
struct Opened(Sender<SocketAddr>);

impl NodeMonitor for Opened {
    fn opened(&mut self, _: &Endpoint, hub: &Hub) {
        self.0.send(hub.address().unwrap()).unwrap();
    }
}

/// The tasks among the lines, which no decision time is part of.
fn tasks(lines: &str) -> Vec<&str> {
    let lines = lines.lines();
    lines
        .filter(|line| line.contains(r#""kind":"task""#))
        .collect()
}

#[test]
fn the_line_of_the_example_gets_the_tasks_of_the_program() {
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/../live/examples/run.rs");
    let source = std::fs::read_to_string(source).unwrap();
    assert!(source.lines().count() < 40);
    let stream = pickline(&["emulate", "--clock", "messages", "-q"]).stdout;
    assert!(stream.len() > 10_000);

    let (sender, receiver) = channel();
    let node = std::thread::spawn(move || {
        let place = Endpoint::Listen("127.0.0.1:0".into());
        run_example::run(place, &mut Opened(sender)).unwrap()
    });
    let mut peer = TcpStream::connect(receiver.recv().unwrap()).unwrap();
    peer.write_all(&stream).unwrap();
    peer.shutdown(Shutdown::Write).unwrap();
    let mut said = String::new();
    peer.read_to_string(&mut said).unwrap();
    let summary = node.join().unwrap();

    let mut command = Command::new(env!("CARGO_BIN_EXE_pickline"));
    command.args(["run", "--clock", "messages", "--strategy", "SPT,FIFO"]);
    let (output, fed) = feed(&mut command, &stream);
    fed.unwrap();
    let expected = String::from_utf8(output.stdout).unwrap();
    assert!(tasks(&expected).len() > 10, "{expected}");
    assert_eq!(tasks(&said), tasks(&expected));
    let printed = String::from_utf8(output.stderr).unwrap();
    let figures = summary.to_string();
    let figures = figures.split("; ").next().unwrap();
    assert!(printed.contains(figures), "{figures} is not in {printed}");
}
