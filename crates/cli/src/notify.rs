//! Tells the service manager how it goes: ready, at work, ending (the protocol of
//! sd_notify(3), datagrams to the socket that `NOTIFY_SOCKET` names).

use std::time::{Duration, Instant};

/// The way to the service manager; says nothing where there is none.
pub struct Notify {
    #[cfg(unix)]
    socket: Option<Socket>,
    /// Time between two signs of life; none where nobody waits for them.
    every: Option<Duration>,
    next: Instant,
}

#[cfg(unix)]
type Socket = std::os::unix::net::UnixDatagram;

impl Notify {
    /// To the manager that has started this program, if one has.
    pub fn found() -> Self {
        let variable = |name: &str| std::env::var(name).ok();
        let of_us =
            variable("WATCHDOG_PID").is_none_or(|pid| pid == std::process::id().to_string());
        let limit = variable("WATCHDOG_USEC").and_then(|limit| limit.parse().ok());
        // Several fit into the limit, so that one that comes late costs nothing.
        let every = limit.map(|limit: u64| Duration::from_micros(limit / 4));
        Self {
            #[cfg(unix)]
            socket: variable("NOTIFY_SOCKET").and_then(|path| connected(&path).ok()),
            every: every.filter(|every| of_us && !every.is_zero()),
            next: Instant::now(),
        }
    }

    /// The line runs.
    pub fn ready(&self) {
        self.send("READY=1");
    }

    /// The line is at work, in words.
    pub fn status(&self, text: &str) {
        self.send(&format!("STATUS={}", text.replace('\n', " ")));
    }

    /// The line ends.
    pub fn stopping(&self) {
        self.send("STOPPING=1");
    }

    /// A sign of life, if one is due. To be called wherever the line's loop comes by.
    pub fn alive(&mut self) {
        let now = Instant::now();
        if let Some(every) = self.every.filter(|_| now >= self.next) {
            self.next = now + every;
            self.send("WATCHDOG=1");
        }
    }

    /// What finds no room is left out: the line does not wait for its manager.
    #[cfg(unix)]
    fn send(&self, text: &str) {
        if let Some(socket) = &self.socket {
            let _ = socket.send(text.as_bytes());
        }
    }

    #[cfg(not(unix))]
    fn send(&self, _: &str) {}
}

/// A socket to `path`; one that begins with `@` is in Linux's abstract name space.
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
