//! Shared by `run` and `emulate`: the transport, the signals.

use super::access::TcpAddresses;
use super::args::{ClockArg, LogFormatArg, TransportArgs};
use super::log::Style;
use super::remarks::Remarks;
use pickline::error::Result;
use pickline::station::Station;
use pickline_live::ClockKind;
use pickline_live::node::Connections;
use pickline_live::protocol::{Hello, Role};
use pickline_live::transport::{Access, Dialect, Endpoint, Hub, HubOptions, Side};
#[cfg(feature = "ros2")]
use std::net::IpAddr;
use std::net::{SocketAddr, ToSocketAddrs as _};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

impl TransportArgs {
    /// The kind of clock.
    pub(crate) fn clock(&self) -> ClockKind {
        match self.clock {
            ClockArg::System => ClockKind::System,
            ClockArg::Messages => ClockKind::Messages,
        }
    }

    /// The addresses for other programs; there is no dashboard.
    pub(crate) fn addresses(&self) -> TcpAddresses<'_> {
        TcpAddresses {
            listen: self.listen.as_deref(),
            connect: self.connect.as_deref(),
            dashboard: None,
        }
    }

    /// Where the peers of `side` are and on which terms they may connect, for the line of
    /// `station`.
    ///
    /// # Errors
    /// Contradictory flags, or files that cannot be read.
    pub(crate) fn connections(
        &self,
        side: Side,
        station: &Station,
        dialect: Dialect,
    ) -> Result<Connections> {
        let place = self.place(side)?;
        let access = match place {
            Endpoint::Listen(_) => self.access.listening()?,
            Endpoint::Connect(_) => self.access.connecting()?,
            _ => Access::default(),
        };
        let token = access.token.as_ref().map(|token| token.text().to_owned());
        let mut terms = HubOptions::new(side, station, self.clock())
            .with_access(access)
            .with_most_peers(self.access.max_peers.into())
            .with_dialect(dialect);
        if side == Side::Station {
            let robots = terms.robots.clone();
            terms = terms.with_hello(Hello {
                stamp: None,
                name: "emulate".into(),
                role: Role::Robot,
                robots,
                token,
            });
        }
        Ok(Connections::new(place, station, self.clock()).with_terms(terms))
    }

    #[cfg_attr(
        not(any(feature = "mqtt", feature = "ros2")),
        allow(unused_variables, clippy::unnecessary_wraps)
    )]
    fn place(&self, side: Side) -> Result<Endpoint> {
        #[cfg(feature = "mqtt")]
        if let Some(settings) = self.mqtt.resolve(side, self.clock())? {
            return Ok(Endpoint::Mqtt(Box::new(settings)));
        }
        #[cfg(feature = "ros2")]
        if let Some(settings) = self.ros2.resolve(side, self.clock())? {
            return Ok(Endpoint::Ros2(Box::new(settings)));
        }
        Ok(match (&self.listen, &self.connect) {
            (Some(address), _) => Endpoint::Listen(address.clone()),
            (None, Some(address)) => Endpoint::Connect(address.clone()),
            (None, None) => Endpoint::Stdio,
        })
    }

    /// Where remarks go.
    pub(crate) fn remarks(&self) -> Remarks {
        let style = match self.log_format {
            LogFormatArg::Auto => Style::found(),
            LogFormatArg::Text => Style::Text,
            LogFormatArg::Journald => Style::Journald,
            LogFormatArg::Stamped => Style::Stamped,
        };
        Remarks::on_stderr(style, self.quiet)
    }
}

/// Says where the program can be reached. `is_closed`: only peers that authenticate may
/// connect.
pub(crate) fn announce(remarks: &Remarks, place: &Endpoint, hub: &Hub, is_closed: bool) {
    match place {
        #[cfg(feature = "mqtt")]
        Endpoint::Mqtt(settings) => remarks.remark(&format!("using {}", settings.broker)),
        #[cfg(feature = "ros2")]
        Endpoint::Ros2(settings) => {
            let (domain, namespace) = (settings.domain, &settings.namespace);
            remarks.remark(&format!("using ROS domain {domain}, namespace {namespace}"));
            if !settings.networks.iter().all(IpAddr::is_loopback) {
                remarks.warn("anyone in these networks can control the line");
            }
        }
        _ => {}
    }
    if let Some(address) = hub.address() {
        remarks.remark(&format!("listening at {address}"));
        if !address.ip().is_loopback() && !is_closed {
            remarks.warn("anyone who can reach this address can control the line");
        }
    }
}

/// A flag that Ctrl-C and SIGTERM set; a second signal exits the program at once.
pub(crate) fn stop_flag() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    // If no handler can be set, a signal ends the program, as usual.
    let _ = ctrlc::set_handler(move || {
        if raised.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(super::INTERRUPTED));
        }
    });
    flag
}

/// Whether two addresses (HOST:PORT) are the same port of the same machine.
pub(crate) fn is_same_place(one: &str, other: &str) -> bool {
    // An invalid address is reported where it is used.
    let all = |address: &str| -> Vec<SocketAddr> {
        let found = address.to_socket_addrs();
        found.map(Iterator::collect).unwrap_or_default()
    };
    let others = all(other);
    all(one).iter().any(|a| {
        let same = |b: &&SocketAddr| {
            let any = a.ip().is_unspecified() || b.ip().is_unspecified();
            a.port() == b.port() && a.port() != 0 && (any || a.ip() == b.ip())
        };
        others.iter().find(same).is_some()
    })
}
