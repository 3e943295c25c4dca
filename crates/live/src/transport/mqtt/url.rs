//! The URL of the broker. Read by hand: the crate `url` rewrites hosts and its errors name no cure, and
//! `percent-encoding` lets a `%` without digits pass, which is most likely a password written as it is.

use pickline::error::{Error, Result, nearest, shown};

/// A broker's address, with user and password.
#[derive(Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Broker {
    /// Host name or address.
    pub host: String,
    /// Port; by default 1883, or 8883 with TLS.
    pub port: u16,
    /// Whether the connection is encrypted.
    pub tls: bool,
    /// User name.
    pub user: Option<String>,
    /// Password; never printed.
    pub password: Option<String>,
}

impl std::fmt::Debug for Broker {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Broker({self})")
    }
}

/// Omits user and password.
impl std::fmt::Display for Broker {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let scheme = if self.tls { "mqtts" } else { "mqtt" };
        let host = if self.host.contains(':') {
            format!("[{}]", self.host)
        } else {
            self.host.clone()
        };
        write!(f, "{scheme}://{}:{}", shown(&host), self.port)
    }
}

impl Broker {
    /// Reads `mqtt://[USER[:PASSWORD]@]HOST[:PORT]`, or the same with `mqtts://`.
    ///
    /// # Errors
    /// The text is anything else. It is not quoted from where a password may begin.
    pub fn read(text: &str) -> Result<Self> {
        let Some((scheme, rest)) = text.split_once("://") else {
            return Err(wrong("this is not a URL: it has no ://".into()));
        };
        let tls = match scheme.to_ascii_lowercase().as_str() {
            "mqtt" => false,
            "mqtts" => true,
            other => {
                let meant = nearest(other, ["mqtt", "mqtts"]);
                let hint = meant.map_or(String::new(), |name| format!("; did you mean `{name}`?"));
                return Err(wrong(format!(
                    "there is no scheme `{}`{hint}",
                    shown(other)
                )));
            }
        };
        let (who, place) = match rest.rsplit_once('@') {
            Some((who, place)) => (Some(who), place),
            None => (None, rest),
        };
        let (host, port) = host_and_port(place, if tls { 8883 } else { 1883 })?;
        let (user, password) = match who {
            None => (None, None),
            Some(who) => {
                let (user, password) = match who.split_once(':') {
                    Some((user, password)) => (user, Some(password)),
                    None => (who, None),
                };
                let decoded = |text| {
                    decode(text).ok_or_else(|| {
                        wrong(
                            "user or password contain a % that is not followed by two hex digits"
                                .into(),
                        )
                    })
                };
                (Some(decoded(user)?), password.map(decoded).transpose()?)
            }
        };
        Ok(Self {
            host: host.to_owned(),
            port,
            tls,
            user,
            password,
        })
    }
}

fn wrong(problem: String) -> Error {
    let cure = "give mqtt://HOST:PORT, or mqtts://HOST:PORT for TLS";
    Error::usage("'mqtt'", problem, cure)
}

/// The host and the port of `place`, the port being `usual` where none is given.
fn host_and_port(place: &str, usual: u16) -> Result<(&str, u16)> {
    let place = place.strip_suffix('/').unwrap_or(place);
    let (host, port) = match place.strip_prefix('[').and_then(|p| p.split_once(']')) {
        Some((host, port)) => (
            host,
            port.strip_prefix(':').or(port.is_empty().then_some("")),
        ),
        None => match place.split_once(':') {
            Some((host, port)) => (host, Some(port)),
            None => (place, Some("")),
        },
    };
    let allowed = |c: char| c.is_alphanumeric() || ".-_:%".contains(c);
    if host.is_empty() || !host.chars().all(allowed) {
        return Err(wrong(format!("`{}` is not a valid host", shown(host))));
    }
    let port = match port {
        Some("") => Some(usual),
        Some(port) => port.parse().ok().filter(|port| *port > 0),
        None => None,
    };
    let Some(port) = port else {
        return Err(wrong(format!(
            "`{}` has no port from 1 to 65535",
            shown(place)
        )));
    };
    Ok((host, port))
}

/// Decodes %XX.
fn decode(text: &str) -> Option<String> {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let Some((&first, others)) = rest.split_first() {
        rest = others;
        if first != b'%' {
            bytes.push(first);
            continue;
        }
        let digits = std::str::from_utf8(rest.get(..2)?).ok()?;
        if !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
            return None;
        }
        bytes.push(u8::from_str_radix(digits, 16).ok()?);
        rest = &rest[2..];
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brokers_are_read() {
        for (text, host, port, tls) in [
            ("mqtt://line", "line", 1883, false),
            ("mqtts://line/", "line", 8883, true),
            ("MQTT://10.0.0.1:1884", "10.0.0.1", 1884, false),
            ("mqtt://[::1]:7", "::1", 7, false),
            ("mqtts://[::1]", "::1", 8883, true),
        ] {
            let broker = Broker::read(text).unwrap();
            assert_eq!(
                (broker.host.as_str(), broker.port, broker.tls),
                (host, port, tls)
            );
            assert_eq!(Broker::read(&broker.to_string()).unwrap(), broker);
        }
        let broker = Broker::read("mqtt://a%40b:p@%3a:@c:1").unwrap();
        assert_eq!(broker.user.as_deref(), Some("a@b"));
        assert_eq!(broker.password.as_deref(), Some("p@::"));
        assert_eq!(broker.to_string(), "mqtt://c:1");
        assert_eq!(format!("{broker:?}"), "Broker(mqtt://c:1)");
    }

    #[test]
    fn what_is_no_broker_is_refused_and_no_password_shown() {
        for text in [
            "",
            "line:1883",
            "http://line",
            "mqtt://",
            "mqtt://:1883",
            "mqtt://u:secret@",
            "mqtt://u:secret@line:0",
            "mqtt://u:secret@line:65536",
            "mqtt://u:secret@line:x",
            "mqtt://u:secret%zz@line",
            "mqtt://u:secret%2@line",
            "mqtt://u:secret@line/topic",
            "mqtt://[::1",
            "mqtt://[::1]7",
            "mqtt://u:secret@a\u{1b}b",
        ] {
            let error = Broker::read(text).unwrap_err().to_string();
            assert!(
                error.contains("'mqtt'") && error.contains("cure: "),
                "{error}"
            );
            assert!(
                !error.contains("secret") && !error.contains('\u{1b}'),
                "{error}"
            );
        }
    }
}
