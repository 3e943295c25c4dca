//! The dashboard: a page over HTTP that shows a live line in any number of browsers.
//!
//! It only looks on. The line hands over a view now and then and never waits: a thread of
//! its own writes it as JSON and sends it to whoever watches. Each browser is sent the
//! newest view when it has taken the one before, so a slow one leaves views out.

mod metrics;
mod page;
mod server;

pub use metrics::metrics;
pub use page::{DASHBOARD_PAGE, dashboard_line, dashboard_script, dashboard_style};

use pickline::error::{Error, Result};
use pickline_live::View;
use pickline_live::transport::{Access, listen_at};
use pickline::station::Station;
use hyper::body::Bytes;
use server::{Scraped, Texts};
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};
use std::sync::{Arc, Weak};
use std::thread;
use std::time::Duration;
use tokio::sync::watch;

/// The dashboard of one line.
#[derive(Debug)]
pub struct Dashboard {
    views: watch::Sender<Option<Arc<View>>>,
    /// Gone when the server has ended.
    texts: Weak<Texts>,
    /// Whether somebody waits for the next view.
    wanted: Arc<AtomicBool>,
    address: SocketAddr,
    /// Hears when every browser has been sent the last view.
    ended: Receiver<()>,
}

impl Dashboard {
    /// Opens it at `address`, for a line on `station` (as the user named it) under the
    /// strategy of this name, for whoever shows what `access` asks for.
    ///
    /// # Errors
    /// An address that is none, or cannot be listened at.
    pub fn open(
        address: &str,
        station: &Station,
        named: &str,
        strategy: &str,
        access: Access,
    ) -> Result<Self> {
        let listener = listen_at("--dashboard", address)?;
        let wrong = |error: std::io::Error| {
            Error::input(
                "--dashboard",
                format!("{address}: {error}"),
                "try again, or run without a dashboard",
            )
        };
        let at = listener.local_addr().map_err(wrong)?;
        listener.set_nonblocking(true).map_err(wrong)?;
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(wrong)?;
        let line = dashboard_line(station, named, strategy);
        let (views, seen) = watch::channel(None);
        let texts = Arc::new(watch::Sender::new(Bytes::new()));
        let weak = Arc::downgrade(&texts);
        let wanted = Arc::new(AtomicBool::new(false));
        let scraped = Scraped {
            views: seen.clone(),
            wanted: Arc::clone(&wanted),
            strategy: strategy.to_owned(),
        };
        let (done, ended) = sync_channel(1);
        thread::spawn(move || {
            runtime.block_on(server::serve(listener, access, line, scraped, seen, texts));
            let _ = done.send(());
        });
        Ok(Self {
            views,
            texts: weak,
            wanted,
            address: at,
            ended,
        })
    }

    /// Where it is.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Whether any browser watches, or somebody has asked for metrics.
    pub fn is_watched(&self) -> bool {
        let texts = self.texts.upgrade();
        self.wanted.load(Ordering::Relaxed) || texts.is_some_and(|texts| texts.receiver_count() > 0)
    }

    /// Shows a view, now or, to a browser that does not keep up, never.
    pub fn show(&self, view: View) {
        self.wanted.store(false, Ordering::Relaxed);
        self.views.send_replace(Some(Arc::new(view)));
    }

    /// Ends it when all browsers have the last view, or `patience` is over.
    pub fn close(self, patience: Duration) {
        drop(self.views);
        let _ = self.ended.recv_timeout(patience);
    }
}
