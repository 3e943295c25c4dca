//! The dashboard's server: what browsers that stall cost, and how it is asked for. The page
//! itself is tested in a browser, by `tests/browser/dashboard.mjs`.

use crate::common;
use pickline::station::built_in;
use pickline_dashboard::Dashboard;
use pickline_live::{ItemView, LineView};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

fn view(stamp: f64, items: usize) -> LineView {
    let mut item = ItemView::default();
    item.id = "i".repeat(100);
    (item.x, item.weight, item.fate) = (0.5, 1.0, "waiting");
    let mut view = LineView::default();
    view.status.stamp = stamp;
    (view.steady, view.belt_speed) = (true, 0.05);
    view.items = vec![item; items];
    view
}

fn watch(dashboard: &Dashboard) -> TcpStream {
    let address = dashboard.address();
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "GET /events HTTP/1.1\r\nHost: {address}\r\n\r\n").unwrap();
    stream
}

/// The stamps of the views that come, until the stream ends.
fn stamps(stream: TcpStream) -> Vec<f64> {
    let lines = BufReader::new(stream).split(b'\n').map(Result::unwrap);
    let data = lines.filter_map(|line| {
        let line = String::from_utf8(line).unwrap();
        line.strip_prefix("data: {\"status\"")
            .map(|rest| format!("{{\"status\"{rest}"))
    });
    let stamp = |json: String| {
        let view: serde_json::Value = serde_json::from_str(&json).unwrap();
        view["status"]["stamp"].as_f64().unwrap()
    };
    data.map(stamp).collect()
}

#[test]
fn a_slow_reader_delays_nobody_and_gets_the_newest() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let access = pickline_live::transport::Access::default();
    let dashboard = Dashboard::open("127.0.0.1:0", &station, "paper", "FIFO", access).unwrap();
    assert!(!dashboard.is_watched());
    let (stalled, slow) = (watch(&dashboard), watch(&dashboard));
    let limit = Instant::now() + Duration::from_secs(60);
    while !dashboard.is_watched() {
        assert!(Instant::now() < limit);
        std::thread::yield_now();
    }
    // Far more than the system keeps for a connection: 400 MB.
    for i in 0..2000 {
        dashboard.show(view(f64::from(i), 1500));
    }
    dashboard.show(view(9999.0, 1));
    let reader = std::thread::spawn(move || stamps(slow));
    dashboard.close(Duration::from_secs(5));
    let told = reader.join().unwrap();
    assert!(told.is_sorted() && told.len() < 1000, "{}", told.len());
    assert_eq!(told.last(), Some(&9999.0));
    drop(stalled);
}

/// What the server answers a request for this path, head and all.
fn get(address: SocketAddr, path: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {address}\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

/// `tests/metrics` holds them to the reference parser.
#[test]
fn metrics_are_of_now_or_not_at_all() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let access = pickline_live::transport::Access::default();
    let dashboard = Dashboard::open("127.0.0.1:0", &station, "paper", "a\"b", access).unwrap();
    let address = dashboard.address();
    dashboard.show(view(1.0, 1));
    // The line stands still: what it showed once is no answer.
    let answer = get(address, "/metrics");
    assert!(answer.starts_with("HTTP/1.1 503 "), "{answer}");
    assert!(dashboard.is_watched());
    dashboard.show(view(2.0, 1));
    assert!(!dashboard.is_watched());
    std::thread::scope(|scope| {
        let answer = scope.spawn(move || get(address, "/metrics"));
        while !dashboard.is_watched() {
            std::thread::yield_now();
        }
        dashboard.show(view(3.5, 1));
        let answer = answer.join().unwrap();
        assert!(answer.starts_with("HTTP/1.1 200 "), "{answer}");
        assert!(
            answer.contains("\npickline_stamp_seconds 3.5\n"),
            "{answer}"
        );
        assert!(answer.contains(r#"strategy="a\"b""#), "{answer}");
    });
    dashboard.close(Duration::from_secs(5));
}

#[test]
fn a_page_for_everybody_is_warned_of() {
    for (address, warned) in [("127.0.0.1:0", false), ("0.0.0.0:0", true)] {
        let output = common::pickline(&["run", "--insecure", "--dashboard", address]);
        assert!(output.status.success());
        let remarks = String::from_utf8(output.stderr).unwrap();
        assert!(remarks.contains("dashboard at http://"), "{remarks}");
        let warning = "anyone who can reach this address can watch the line";
        assert_eq!(remarks.contains(warning), warned, "{remarks}");
    }
}
