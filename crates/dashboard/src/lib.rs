//! The dashboard: a page over HTTP that shows a live line in any number of browsers.
//!
//! It is read-only. The line hands over a view now and then and never waits: a separate thread
//! writes the view as JSON and sends it to all browsers. Each browser gets the newest view once it
//! has received the previous one, so a slow browser skips views.

mod metrics;
mod page;
mod server;

pub use metrics::metrics;
pub use page::{DASHBOARD_PAGE, dashboard_line, dashboard_script, dashboard_style};

use hyper::body::Bytes;
use pickline::error::{Error, Result};
use pickline::station::Station;
use pickline_live::LineView;
use pickline_live::transport::{Access, listen_at};
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
    views: watch::Sender<Option<Arc<LineView>>>,
    /// Dropped when the server has ended.
    texts: Weak<Texts>,
    /// Whether a request is waiting for the next view.
    wanted: Arc<AtomicBool>,
    address: SocketAddr,
    /// Receives a message once every browser has been sent the last view.
    ended: Receiver<()>,
}

impl Dashboard {
    /// Starts the dashboard at `address`, for a line on `station` (`named` as the user wrote it)
    /// under the strategy called `strategy`. Browsers must meet the requirements of `access`.
    ///
    /// # Errors
    /// `address` is not a valid address, or the server cannot listen there.
    pub fn open(
        address: &str,
        station: &Station,
        named: &str,
        strategy: &str,
        access: Access,
    ) -> Result<Self> {
        let listener = listen_at("'dashboard'", address)?;
        let wrong = |error: std::io::Error| {
            let cure = "try again, or run without a dashboard";
            Error::resources("'dashboard'", format!("{address}: {error}"), cure).caused_by(error)
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

    /// The address that the server listens on.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Whether any browser is connected, or metrics were requested.
    pub fn is_watched(&self) -> bool {
        let texts = self.texts.upgrade();
        self.wanted.load(Ordering::Relaxed) || texts.is_some_and(|texts| texts.receiver_count() > 0)
    }

    /// Shows a view. A browser that lags behind may never get it.
    pub fn show(&self, view: LineView) {
        self.wanted.store(false, Ordering::Relaxed);
        self.views.send_replace(Some(Arc::new(view)));
    }

    /// Stops the server once all browsers have the last view, or after `timeout`.
    pub fn close(self, timeout: Duration) {
        drop(self.views);
        let _ = self.ended.recv_timeout(timeout);
    }
}
