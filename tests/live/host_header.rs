//! Which `Host` the dashboard answers at a loopback address: a page of another site, whose name
//! was made to mean this machine, must not read the line.

use pickline::station::built_in;
use pickline_dashboard::Dashboard;
use pickline_live::transport::Access;
use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

fn dashboard(address: &str) -> Dashboard {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    Dashboard::open(address, &station, "paper", "FIFO", Access::default()).unwrap()
}

/// What comes of a request for `path` with these lines in its head: the status, and the whole.
fn ask(address: SocketAddr, path: &str, head: &str) -> (u16, String) {
    let mut stream = TcpStream::connect(address).unwrap();
    stream
        .set_read_timeout(Some(Duration::from_secs(20)))
        .unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\n{head}\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let status = answer.split(' ').nth(1).unwrap().parse().unwrap();
    (status, answer)
}

/// PORT stands for the dashboard's own.
const OWN: [&str; 14] = [
    "127.0.0.1:PORT",
    "127.0.0.1",
    // Another port, as behind a forwarded one.
    "127.0.0.1:1",
    "127.0.0.2:PORT",
    "192.168.1.5:PORT",
    "localhost:PORT",
    "localhost",
    "LOCALHOST:PORT",
    "LocalHost:1",
    "[::1]:PORT",
    "[::1]",
    "[fe80::1]:80",
    "[0:0:0:0:0:0:0:1]:80",
    "0.0.0.0:PORT",
];

const OTHERS: [&str; 19] = [
    "",
    "evil.example",
    "evil.example:PORT",
    // Names that mean this machine, where somebody has made them so.
    "rebind.evil.example:PORT",
    "127.0.0.1.evil.example:PORT",
    "127.0.0.1.nip.io:PORT",
    "localhost.evil.example:PORT",
    "evil-localhost:PORT",
    "localhostevil:PORT",
    "sub.localhost:PORT",
    "localhost.:PORT",
    "127.0.0.1.:PORT",
    "LOCALHOST.EVIL.EXAMPLE",
    "2130706433:PORT",
    "127.1:PORT",
    "evil.example@127.0.0.1",
    "localhost:evil.example",
    "[::1].evil.example:PORT",
    "[localhost]:PORT",
];

#[test]
fn a_loopback_dashboard_answers_addresses_and_localhost_only() {
    let dashboard = dashboard("127.0.0.1:0");
    let address = dashboard.address();
    let port = address.port().to_string();
    for (hosts, expected) in [(&OWN[..], 200), (&OTHERS[..], 403)] {
        for host in hosts {
            let head = format!("Host: {}\r\n", host.replace("PORT", &port));
            let (status, answer) = ask(address, "/dashboard.css", &head);
            assert_eq!(status, expected, "{host}: {answer}");
            let says_why = answer.ends_with("open this page by its IP address or as localhost\n");
            assert_eq!(says_why, expected == 403, "{host}: {answer}");
        }
    }
    // Nobody is answered who names no host.
    assert_eq!(ask(address, "/dashboard.css", "").0, 403);
    assert_eq!(
        ask(address, "/dashboard.css", "X-Host: localhost\r\n").0,
        403
    );
    dashboard.close(Duration::from_secs(5));
}

/// Whatever is asked for, what belongs to the line is behind the check.
#[test]
fn nothing_of_the_line_is_sent_under_another_name() {
    let dashboard = dashboard("127.0.0.1:0");
    let address = dashboard.address();
    for path in [
        "/",
        "/dashboard.css",
        "/dashboard.js",
        "/events",
        "/metrics",
        "/none",
    ] {
        let (status, answer) = ask(address, path, "Host: evil.example\r\n");
        let (head, body) = answer.split_once("\r\n\r\n").unwrap();
        assert_eq!(
            (status, body),
            (403, "open this page by its IP address or as localhost\n"),
            "{path}"
        );
        assert!(!head.to_lowercase().contains("access-control"), "{head}");
    }
    let wanted = [
        ("/", "text/html"),
        ("/dashboard.css", "text/css"),
        ("/dashboard.js", "text/javascript"),
    ];
    for (path, kind) in wanted {
        let (status, answer) = ask(address, path, "Host: localhost\r\n");
        assert_eq!(status, 200, "{path}");
        let answer = answer.to_lowercase();
        assert!(
            answer.contains(&format!("content-type: {kind}; charset=utf-8")),
            "{path}"
        );
        assert!(answer.contains("x-content-type-options: nosniff"), "{path}");
        assert!(
            answer.contains("content-security-policy: default-src 'none'"),
            "{path}"
        );
        assert!(answer.contains("cache-control: no-store"), "{path}");
        assert!(answer.contains("referrer-policy: no-referrer"), "{path}");
    }
    assert_eq!(ask(address, "/none", "Host: localhost\r\n").0, 404);
    assert_eq!(ask(address, "/favicon.ico", "Host: localhost\r\n").0, 204);
    dashboard.close(Duration::from_secs(5));
}

/// At an address that other machines reach it has a name there, which nobody here knows.
#[test]
fn a_dashboard_for_other_machines_answers_any_name() {
    let dashboard = dashboard("0.0.0.0:0");
    let address = SocketAddr::from(([127, 0, 0, 1], dashboard.address().port()));
    for host in ["line-3.plant.example:8090", "localhost", "127.0.0.1", "plc"] {
        assert_eq!(
            ask(address, "/dashboard.css", &format!("Host: {host}\r\n")).0,
            200,
            "{host}"
        );
    }
    dashboard.close(Duration::from_secs(5));
}

/// It only shows: any other method is refused before anything else is looked at.
#[test]
fn nothing_but_get_is_answered() {
    let dashboard = dashboard("127.0.0.1:0");
    let address = dashboard.address();
    for method in ["POST", "PUT", "DELETE", "HEAD", "OPTIONS", "PATCH"] {
        let mut stream = TcpStream::connect(address).unwrap();
        let head = "Host: localhost\r\nContent-Length: 0\r\n";
        write!(stream, "{method} / HTTP/1.1\r\n{head}\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        assert!(answer.starts_with("HTTP/1.1 405 "), "{method}: {answer}");
        assert!(answer.to_lowercase().contains("allow: get\r\n"), "{answer}");
    }
    dashboard.close(Duration::from_secs(5));
}
