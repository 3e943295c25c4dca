//! What is refused: other servers, bad messages, wrong usage.

use super::last_status;
use crate::broker::Broker;
use crate::programs::Program;
use std::io::{Read as _, Write as _};
use std::net::TcpListener;

/// A server on a free port that says `answer` to whoever speaks to it, and hangs up or not.
fn server(answer: &'static [u8], hangs_up: bool) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    std::thread::spawn(move || {
        let mut kept = Vec::new();
        for stream in listener.incoming() {
            let mut stream = stream.unwrap();
            let _ = stream.read(&mut [0; 256]);
            let _ = stream.write_all(answer);
            if !hangs_up {
                kept.push(stream);
            }
        }
    });
    port
}

#[test]
fn a_broker_without_mqtt_5_is_reported() {
    for (answer, hangs_up, words) in [
        // Return code 1 of MQTT 3.1.1: unacceptable protocol version.
        (
            &[0x20, 2, 0, 1][..],
            true,
            "does not speak MQTT 5 but an older version",
        ),
        (
            &[0x20, 2, 0, 1],
            false,
            "does not speak MQTT 5 but an older version",
        ),
        (
            b"HTTP/1.1 400 Bad Request\r\n\r\n",
            true,
            "a web server answers at",
        ),
        (b"SSH-2.0-OpenSSH_9.2\r\n", false, "is not an MQTT broker"),
        // An alert of TLS.
        (&[0x15, 3, 3, 0, 2, 2, 40], true, "write mqtts://127.0.0.1:"),
    ] {
        let port = server(answer, hangs_up);
        for verb in ["run", "emulate"] {
            let arguments = format!("{verb} --mqtt mqtt://127.0.0.1:{port}");
            let (code, remarks) = Program::pickline(&arguments, &[]).finish();
            assert_eq!(code, Some(2), "{remarks}");
            assert!(
                remarks.contains(words) && remarks.contains("cure: "),
                "{remarks}"
            );
        }
    }
}

#[test]
fn bad_messages_are_refused_and_the_stream_goes_on() {
    let broker = Broker::open();
    let watcher = broker.watch();
    let mut node = Program::pickline(
        &format!("run --clock messages --mqtt {}", broker.url()),
        &[],
    );
    watcher.said.wait_for("online");
    let idle = r#"{"kind":"robot","stamp":100,"name":"r1","state":"idle"}"#;
    let tick = |stamp: f64| format!(r#"{{"kind":"tick","stamp":{stamp}}}"#);
    broker.publish("pickline/robot/r1", idle, "0");
    broker.publish("pickline/robot", "{", "1");
    broker.publish("pickline/ack/r1", &tick(100.0), "1");
    broker.publish("pickline/detection", &"x".repeat(70_000), "2");
    broker.publish("pickline/detection/camera", "\u{1b}", "1");
    broker.publish("pickline/nonsense", "{", "1");
    let item = r#"{"kind":"detection","stamp":100,"id":"a","x":0.5,"y":-0.2}"#;
    broker.publish("pickline/detection/camera", item, "1");
    broker.publish("pickline/tick", &tick(101.0), "1");
    watcher.said.wait_for("pickline/task/r1 ");
    node.signal("TERM");
    let (code, remarks) = node.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert_eq!(remarks.matches("refused (").count(), 4, "{remarks}");
    assert!(
        remarks.contains("topic pickline/ack/r1: refused (kind): kind `tick`; expected `ack`")
            && remarks.contains("topic pickline/detection/camera: refused (syntax): "),
        "{remarks}"
    );
    watcher.said.wait_for("\"last\":true");
    let refused = [("kind", 1), ("syntax", 2), ("too_long", 1)];
    let refused = refused.map(|(reason, count)| (reason.to_owned(), count));
    assert_eq!(last_status(&watcher.said.all()).rejected, refused.into());
}

#[test]
fn wrong_usage_is_refused() {
    for (arguments, word) in [
        ("--mqtt line:1883", "--mqtt"),
        ("--mqtt http://line", "--mqtt"),
        ("--mqtt mqtt://u:secret@line:0", "--mqtt"),
        ("--mqtt mqtt://127.0.0.1 --mqtt-prefix a/#", "--mqtt-prefix"),
        ("--mqtt mqtt://127.0.0.1 --mqtt-ca /dev/null", "--mqtt-ca"),
        ("--mqtt mqtts://127.0.0.1 --mqtt-ca /dev/null", "/dev/null"),
        (
            "--mqtt mqtt://127.0.0.1 --mqtt-password-file /dev/null",
            "/dev/null",
        ),
        ("--mqtt mqtt://127.0.0.1 --listen 127.0.0.1:0", "--listen"),
        ("--mqtt-user me", "--mqtt"),
    ] {
        for verb in ["run", "emulate"] {
            let (code, remarks) = Program::pickline(&format!("{verb} {arguments}"), &[]).finish();
            assert_eq!(code, Some(2), "{arguments}: {remarks}");
            assert!(
                remarks.contains(word) && !remarks.contains("secret"),
                "{remarks}"
            );
        }
    }
}
