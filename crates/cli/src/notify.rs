//! Notifies the service manager: ready, alive, stopping (the protocol of sd_notify(3),
//! datagrams to the socket that `NOTIFY_SOCKET` names).

use std::time::{Duration, Instant};

/// The connection to the service manager; does nothing if there is none.
pub(crate) struct Notify {
    #[cfg(unix)]
    socket: Option<Socket>,
    /// Time between two keep-alives; `None` if none are expected.
    every: Option<Duration>,
    next: Instant,
}

#[cfg(unix)]
type Socket = std::os::unix::net::UnixDatagram;

impl Notify {
    /// Connects to the service manager that started this program, if any.
    pub(crate) fn found() -> Self {
        let variable = |name: &str| std::env::var(name).ok();
        let of_us =
            variable("WATCHDOG_PID").is_none_or(|pid| pid == std::process::id().to_string());
        let limit = variable("WATCHDOG_USEC").and_then(|limit| limit.parse().ok());
        // Several fit into the limit, so that a late one does no harm.
        let every = limit.map(|limit: u64| Duration::from_micros(limit / 4));
        Self {
            #[cfg(unix)]
            socket: variable("NOTIFY_SOCKET").and_then(|path| connected(&path).ok()),
            every: every.filter(|every| of_us && !every.is_zero()),
            next: Instant::now(),
        }
    }

    /// Reports that the line is running.
    pub(crate) fn ready(&self) {
        self.send("READY=1");
    }

    /// Reports the line's status as text.
    pub(crate) fn status(&self, text: &str) {
        self.send(&format!("STATUS={}", text.replace('\n', " ")));
    }

    /// Reports that the line is stopping.
    pub(crate) fn stopping(&self) {
        self.send("STOPPING=1");
    }

    /// Sends a keep-alive, if one is due. Must be called in every iteration of the main loop.
    pub(crate) fn alive(&mut self) {
        let now = Instant::now();
        if let Some(every) = self.every.filter(|_| now >= self.next) {
            self.next = now + every;
            self.send("WATCHDOG=1");
        }
    }

    /// Drops the message if there is no room: the line does not wait for the service manager.
    #[cfg(unix)]
    fn send(&self, text: &str) {
        if let Some(socket) = &self.socket {
            let _ = socket.send(text.as_bytes());
        }
    }

    #[cfg(not(unix))]
    fn send(&self, _: &str) {}
}

/// A socket connected to `path`; a leading `@` means Linux's abstract namespace.
#[cfg(unix)]
fn connected(path: &str) -> std::io::Result<Socket> {
    let socket = Socket::unbound()?;
    socket.set_nonblocking(true)?;
    match path.strip_prefix('@') {
        #[cfg(target_os = "linux")]
        Some(name) => {
            use std::os::linux::net::SocketAddrExt as _;
            let address = std::os::unix::net::SocketAddr::from_abstract_name(name)?;
            socket.connect_addr(&address)?;
        }
        _ => socket.connect(path)?,
    }
    Ok(socket)
}
