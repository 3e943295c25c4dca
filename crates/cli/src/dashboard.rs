//! The dashboard of `pickline run`.

use super::remarks::Remarks;
use pickline::error::Result;
use pickline::station::Station;
use pickline_live::Controller;
use pickline_live::transport::{Access, Hub};

#[cfg(feature = "dashboard")]
pub(crate) use served::Screen;
#[cfg(not(feature = "dashboard"))]
pub(crate) use unserved::Screen;

/// Where the dashboard is asked for.
#[cfg_attr(
    not(feature = "dashboard"),
    allow(dead_code, reason = "a build without the dashboard refuses it unread")
)]
pub(crate) struct Served {
    /// Its address, HOST:PORT.
    pub address: String,
    /// The title of the station.
    pub title: String,
    /// Who may watch.
    pub access: Access,
}

#[cfg(feature = "dashboard")]
mod served {
    use super::*;
    use pickline_dashboard::Dashboard;
    use pickline_live::Trend;
    use std::time::{Duration, Instant};

    /// Minimum time between two views.
    const PERIOD: Duration = Duration::from_millis(100);
    /// Views take at most 1 / `SHARE` of the line's time.
    const SHARE: u32 = 20;
    /// How long to wait at the end for browsers that do not read the last view.
    const CLOSE_TIMEOUT: Duration = Duration::from_secs(1);

    /// The dashboard, if there is one.
    pub(crate) struct Screen {
        dashboard: Option<Dashboard>,
        next: Instant,
        trend: Trend,
    }

    impl Screen {
        /// Opens the dashboard, if one is asked for, and prints its address.
        ///
        /// # Errors
        /// As for [`Dashboard::open`].
        pub(crate) fn open(
            served: Option<Served>,
            station: &Station,
            strategy: &str,
            remarks: &Remarks,
        ) -> Result<Self> {
            let open = |served: Served| -> Result<Dashboard> {
                let Served {
                    address,
                    title,
                    access,
                } = served;
                let (scheme, is_closed) = (access.scheme(), access.is_closed());
                let dashboard = Dashboard::open(&address, station, &title, strategy, access)?;
                let at = dashboard.address();
                remarks.remark(&format!("dashboard at {scheme}://{at}/"));
                if !at.ip().is_loopback() && !is_closed {
                    remarks.warn("anyone who can reach this address can watch the line");
                }
                Ok(dashboard)
            };
            Ok(Self {
                dashboard: served.map(open).transpose()?,
                next: Instant::now(),
                trend: Trend::default(),
            })
        }

        /// Shows the line's current state, if it is watched and the last view is not too recent.
        pub(crate) fn show(&mut self, controller: &Controller, hub: &Hub) {
            let Some(dashboard) = &self.dashboard else {
                return;
            };
            self.trend.note(controller);
            let began = Instant::now();
            if began >= self.next && dashboard.is_watched() {
                let mut view = controller.view(hub.queued() as u64);
                view.trend = self.trend.view();
                dashboard.show(view);
                self.next = began + PERIOD.max(SHARE * began.elapsed());
            }
        }

        /// Shows the line's final state, and closes.
        pub(crate) fn close(self, controller: &Controller) {
            let Some(dashboard) = self.dashboard else {
                return;
            };
            let mut view = controller.view(0);
            view.trend = self.trend.view();
            view.status.last = true;
            dashboard.show(view);
            dashboard.close(CLOSE_TIMEOUT);
        }
    }
}

#[cfg(not(feature = "dashboard"))]
mod unserved {
    use super::*;
    use pickline::error::Error;

    /// Replaces the dashboard in a build without it.
    pub(crate) struct Screen;

    impl Screen {
        /// Opens nothing.
        ///
        /// # Errors
        /// If a dashboard is asked for.
        pub(crate) fn open(
            served: Option<Served>,
            _: &Station,
            _: &str,
            _: &Remarks,
        ) -> Result<Self> {
            match served {
                None => Ok(Self),
                Some(_) => Err(Error::usage(
                    "--dashboard",
                    "pickline was built without the feature `dashboard`",
                    "build it with that feature, which is on by default, or leave out the flag",
                )),
            }
        }

        /// Shows nothing.
        pub(crate) fn show(&mut self, _: &Controller, _: &Hub) {}

        /// Closes nothing.
        pub(crate) fn close(self, _: &Controller) {}
    }
}
