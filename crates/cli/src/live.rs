//! Shared by `run` and `emulate`: the transport, the clock, the signals.

use super::args::{ClockArg, LogFormatArg, TransportArgs};
use super::log::{Level, Log, Style, kind_of};
use pickline::error::{Error, Result, shown_number};
use pickline::station::Station;
use pickline_live::protocol::{Hello, Role};
use pickline_live::transport::{Access, Dialect, Endpoint, Hub, HubOptions, Side};
use pickline_live::{ClockKind, ClockReading, SteadyClock};
#[cfg(feature = "ros2")]
use std::net::IpAddr;
use std::net::{SocketAddr, ToSocketAddrs as _};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// How long to wait at the end for a peer that does not read the remaining output.
pub const PATIENCE: Duration = Duration::from_secs(2);
/// How often to check for signals.
pub const GLANCE: Duration = Duration::from_millis(50);

/// How long to wait for room when too much output is queued.
pub const BREATH: Duration = Duration::from_millis(1);

impl TransportArgs {
    /// The kind of clock.
    pub fn clock(&self) -> ClockKind {
        match self.clock {
            ClockArg::System => ClockKind::System,
            ClockArg::Messages => ClockKind::Messages,
        }
    }

    /// Opens the transport of `side` in this dialect, for the line of `station`, and prints
    /// its address.
    ///
    /// # Errors
    /// As for [`Hub::open`].
    pub fn open(&self, side: Side, station: &Station, dialect: Dialect) -> Result<Hub> {
        let place = self.place(side)?;
        let access = match place {
            Endpoint::Listen(_) => self.access.listening()?,
            Endpoint::Connect(_) => self.access.connecting()?,
            _ => Access::default(),
        };
        let robots: Vec<String> = station.robots().iter().map(|r| r.name.clone()).collect();
        let hello = (side == Side::Station).then(|| Hello {
            stamp: None,
            name: "emulate".into(),
            role: Role::Robot,
            robots: robots.clone(),
            token: access.token.as_ref().map(|token| token.text().to_owned()),
        });
        let is_closed = access.is_closed();
        let terms = HubOptions {
            side,
            waits: self.clock() == ClockKind::Messages,
            robots,
            access,
            most_peers: self.access.max_peers.into(),
            hello,
            dialect,
        };
        let hub = Hub::open(&place, terms)?;
        if let Some(address) = hub.address() {
            self.remark(&format!("listening at {address}"));
            if !address.ip().is_loopback() && !is_closed {
                self.warn("anyone who can reach this address can control the line");
            }
        }
        Ok(hub)
    }

    #[cfg_attr(
        not(any(feature = "mqtt", feature = "ros2")),
        allow(unused_variables, clippy::unnecessary_wraps)
    )]
    fn place(&self, side: Side) -> Result<Endpoint> {
        #[cfg(feature = "mqtt")]
        if let Some(settings) = self.mqtt.resolve(side, self.clock())? {
            self.remark(&format!("using {}", settings.broker));
            return Ok(Endpoint::Mqtt(Box::new(settings)));
        }
        #[cfg(feature = "ros2")]
        if let Some(settings) = self.ros2.resolve(side, self.clock())? {
            let (domain, namespace) = (settings.domain, &settings.namespace);
            self.remark(&format!("using ROS domain {domain}, namespace {namespace}"));
            if !settings.networks.iter().all(IpAddr::is_loopback) {
                self.warn("anyone in these networks can control the line");
            }
            return Ok(Endpoint::Ros2(Box::new(settings)));
        }
        Ok(match (&self.listen, &self.connect) {
            (Some(address), _) => Endpoint::Listen(address.clone()),
            (None, Some(address)) => Endpoint::Connect(address.clone()),
            (None, None) => Endpoint::Stdio,
        })
    }

    /// The log, which is opened at first use.
    pub fn log(&self) -> &Arc<Log> {
        let style = || match self.log_format {
            LogFormatArg::Auto => Style::found(),
            LogFormatArg::Text => Style::Text,
            LogFormatArg::Journald => Style::Journald,
            LogFormatArg::Stamped => Style::Stamped,
        };
        self.log.get_or_init(|| Arc::new(Log::on_stderr(style())))
    }

    /// A remark for the user, unless quiet.
    pub fn remark(&self, text: &str) {
        self.say(Level::Info, &kind_of(text), text);
    }

    /// A warning, unless quiet.
    pub fn warn(&self, text: &str) {
        self.say(Level::Warning, &kind_of(text), text);
    }

    /// A remark, unless quiet; repeated remarks of one `kind` are summed up.
    pub fn say(&self, level: Level, kind: &str, text: &str) {
        if !self.quiet {
            self.log().say(level, kind, text);
        }
    }
}

/// A flag that Ctrl-C and SIGTERM set; a second signal exits the program at once.
pub fn stop_flag() -> Arc<AtomicBool> {
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

/// Seconds since 1970.
pub fn unix_now() -> f64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.unwrap_or_default().as_secs_f64()
}

/// Combines the machine's two clocks into one that is never set.
#[derive(Debug)]
pub struct NodeClock {
    steady: SteadyClock,
    began: Instant,
}

impl Default for NodeClock {
    fn default() -> Self {
        Self::start()
    }
}

impl NodeClock {
    /// Starts it at the machine's time.
    pub fn start() -> Self {
        let mut clock = Self {
            steady: SteadyClock::default(),
            began: Instant::now(),
        };
        clock.read();
        clock
    }

    /// Reads the clock.
    pub fn read(&mut self) -> ClockReading {
        /// A longer reading means that the process was preempted between the two clocks.
        const AT_ONCE: Duration = Duration::from_millis(1);
        const TRIES: usize = 10;
        let mut best = (Duration::MAX, 0.0, 0.0);
        for _ in 0..TRIES {
            let before = self.began.elapsed();
            let wall = unix_now();
            let after = self.began.elapsed();
            let took = after.saturating_sub(before);
            if took < best.0 {
                best = (took, after.as_secs_f64(), wall);
            }
            if took <= AT_ONCE {
                break;
            }
        }
        let (_, monotonic, wall) = best;
        self.steady.read(monotonic, wall)
    }
}

/// The time from `now` until `stamp`, at least zero and at most [`GLANCE`].
pub fn until(stamp: Option<f64>, now: f64) -> Duration {
    let left = stamp.map_or(f64::INFINITY, |stamp| stamp - now);
    Duration::from_secs_f64(left.clamp(0.0, GLANCE.as_secs_f64()))
}

/// Whether two addresses (HOST:PORT) are the same port of the same machine.
pub fn is_same_place(one: &str, other: &str) -> bool {
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

/// Checks that a flag's value is in its range.
///
/// # Errors
/// A value outside the range.
pub fn check_range(flag: &str, value: f64, low: f64, high: f64, unit: &str) -> Result<()> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let problem = format!("{} is out of range", shown_number(value));
    let (low, high) = (shown_number(low), shown_number(high));
    Err(Error::input(
        flag,
        problem,
        format!("give {low} to {high} {unit}"),
    ))
}
