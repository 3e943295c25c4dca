//! Watches the node for `pickline run`: the log, the service manager and the dashboard.

use super::dashboard::Screen;
use super::live::announce;
use super::log::{LogLevel, kind_of};
use super::notify::Notify;
use super::remarks::Remarks;
use pickline_live::Controller;
use pickline_live::node::{NodeMonitor, NodeSummary, Severity};
use pickline_live::protocol::Status;
use pickline_live::transport::{Endpoint, Hub};

/// Receives what the node reports.
pub(crate) struct RunMonitor<'a> {
    /// Where remarks go.
    pub remarks: &'a Remarks,
    /// Whether only peers that authenticate may connect.
    pub is_closed: bool,
    /// The service manager, which expects keep-alives.
    pub notify: Notify,
    /// The dashboard; none once it is closed.
    pub screen: Option<Screen>,
}

impl NodeMonitor for RunMonitor<'_> {
    fn opened(&mut self, place: &Endpoint, hub: &Hub) {
        announce(self.remarks, place, hub, self.is_closed);
    }

    fn ready(&mut self) {
        self.notify.ready();
    }

    fn alive(&mut self) {
        self.notify.alive();
    }

    fn remark(&mut self, severity: Severity, kind: Option<&str>, text: &str) {
        let kind = kind.map_or_else(|| kind_of(text), str::to_owned);
        match severity {
            // Even if quiet: nobody would know that something has ended.
            Severity::Error => self.remarks.log().say(LogLevel::Error, text, text),
            Severity::Warning => self.remarks.say(LogLevel::Warning, &kind, text),
            Severity::Info => self.remarks.say(LogLevel::Info, &kind, text),
        }
    }

    fn status(&mut self, status: &Status) {
        let (picked, seen) = (status.picked, status.seen);
        self.notify
            .status(&format!("{picked} of {seen} items picked"));
    }

    fn line(&mut self, controller: &Controller, hub: &Hub) {
        if let Some(screen) = &mut self.screen {
            screen.show(controller, hub);
        }
    }

    fn stopping(&mut self) {
        self.notify.stopping();
    }

    fn finished(&mut self, summary: &NodeSummary) {
        // Print pending summaries before the final statistics.
        self.remarks.log().sum_up();
        let open = &summary.status.open_tasks;
        if summary.stopped && !open.is_empty() {
            let open: Vec<String> = open.iter().map(u64::to_string).collect();
            self.remarks
                .remark(&format!("stopped; open tasks: {}", open.join(", ")));
        }
        self.remarks.remark(&summary.to_string());
    }

    fn closed(&mut self, controller: &Controller) {
        if let Some(screen) = self.screen.take() {
            screen.close(controller);
        }
    }
}
