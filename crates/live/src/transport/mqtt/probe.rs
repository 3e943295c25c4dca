//! Finds out what a broker without a usable answer is.
//!
//! A broker that only speaks MQTT 3.1.1 refuses with an answer that is shorter than in MQTT 5, so
//! the library keeps waiting for the rest. This module connects once more by hand; the first bytes
//! of the answer show what is there (OASIS MQTT 3.1.1, section 3.2; MQTT 5.0, section 3.2).

use super::url::Broker;
use pickline::error::Error;
use std::io::{Read as _, Write as _};
use std::net::{TcpStream, ToSocketAddrs as _};
use std::time::Duration;

/// Timeout for an answer.
const PROBE_TIMEOUT: Duration = Duration::from_secs(2);

/// What the first bytes of an answer show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ProbeAnswer {
    /// An answer of MQTT 3.1.1.
    Mqtt3,
    /// An answer of MQTT 5.
    Mqtt5,
    /// A TLS record.
    Tls,
    /// A response of a web server.
    Http,
    /// It neither speaks MQTT nor TLS.
    Other,
    /// The connection was closed without an answer.
    Closed,
    /// No answer, or no connection.
    Nothing,
}

/// Why `broker` can never be used without TLS; none if it may still work.
pub(crate) fn never(broker: &Broker) -> Option<Error> {
    let wrong = |problem: String, cure: String| Some(Error::usage("'mqtt'", problem, cure));
    let old = || {
        wrong(
            format!("{broker} does not speak MQTT 5 but an older version, usually 3.1.1"),
            "use a broker that speaks MQTT 5 (mosquitto 1.6 or later), or enable MQTT 5 in its \
             settings"
                .into(),
        )
    };
    match ask(broker, 5) {
        ProbeAnswer::Mqtt3 => old(),
        ProbeAnswer::Closed if ask(broker, 4) == ProbeAnswer::Mqtt3 => old(),
        ProbeAnswer::Tls => wrong(
            format!("{broker} speaks TLS"),
            format!("write mqtts://{}:{}", broker.host, broker.port),
        ),
        ProbeAnswer::Http => wrong(
            format!("a web server answers at {broker}, not an MQTT broker"),
            "give the broker's port for MQTT over TCP, usually 1883".into(),
        ),
        ProbeAnswer::Other => wrong(
            format!("what answers at {broker} is not an MQTT broker"),
            "check host and port; MQTT usually uses port 1883".into(),
        ),
        ProbeAnswer::Mqtt5 | ProbeAnswer::Closed | ProbeAnswer::Nothing => None,
    }
}

/// Sends a CONNECT with this version of the protocol; 4 is MQTT 3.1.1.
fn ask(broker: &Broker, version: u8) -> ProbeAnswer {
    let connect = || -> std::io::Result<Vec<u8>> {
        let places = (broker.host.as_str(), broker.port).to_socket_addrs()?;
        let mut last = std::io::Error::from(std::io::ErrorKind::NotFound);
        for place in places {
            match TcpStream::connect_timeout(&place, PROBE_TIMEOUT) {
                Ok(mut stream) => {
                    stream.set_read_timeout(Some(PROBE_TIMEOUT))?;
                    stream.set_write_timeout(Some(PROBE_TIMEOUT))?;
                    stream.write_all(&request(version))?;
                    let mut bytes = vec![0; 4];
                    let mut known = 0;
                    while known < bytes.len() {
                        match stream.read(&mut bytes[known..]) {
                            Ok(0) => break,
                            Ok(more) => known += more,
                            Err(_) if known > 0 => break,
                            Err(error) => return Err(error),
                        }
                    }
                    bytes.truncate(known);
                    return Ok(bytes);
                }
                Err(error) => last = error,
            }
        }
        Err(last)
    };
    match connect() {
        Ok(bytes) => read(&bytes),
        Err(error) if error.kind() == std::io::ErrorKind::ConnectionReset => ProbeAnswer::Closed,
        Err(_) => ProbeAnswer::Nothing,
    }
}

/// A CONNECT packet without a client id.
fn request(version: u8) -> Vec<u8> {
    // Name and version of the protocol, a clean session, 10 s keep-alive.
    let mut body = vec![0, 4, b'M', b'Q', b'T', b'T', version, 2, 0, 10];
    if version == 5 {
        // No properties.
        body.push(0);
    }
    body.extend([0, 0]);
    let mut packet = vec![0x10, body.len() as u8];
    packet.extend(body);
    packet
}

fn read(bytes: &[u8]) -> ProbeAnswer {
    match *bytes {
        [] => ProbeAnswer::Closed,
        [0x20, 2, ..] => ProbeAnswer::Mqtt3,
        [0x20, length, ..] if length > 2 => ProbeAnswer::Mqtt5,
        [0xe0, ..] => ProbeAnswer::Mqtt5,
        [0x15 | 0x16, 3, ..] => ProbeAnswer::Tls,
        [b'H', b'T', b'T', b'P', ..] | [b'<', ..] => ProbeAnswer::Http,
        _ => ProbeAnswer::Other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_tell_who_is_there() {
        for (bytes, answer) in [
            (&[0x20, 2, 0, 1][..], ProbeAnswer::Mqtt3),
            (&[0x20, 3, 0, 0], ProbeAnswer::Mqtt5),
            (&[0x15, 3, 1, 0], ProbeAnswer::Tls),
            (b"HTTP", ProbeAnswer::Http),
            (b"SSH-", ProbeAnswer::Other),
            (&[], ProbeAnswer::Closed),
        ] {
            assert_eq!(read(bytes), answer, "{bytes:?}");
        }
        assert_eq!(request(4).len(), 14);
        assert_eq!(request(5)[1], 13);
    }
}
