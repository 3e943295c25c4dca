//! Turns the ROS 2 arguments into transport settings.

use super::args::Ros2Args;
use pickline::error::{Error, Result, shown};
use pickline_live::ClockKind;
use pickline_live::transport::Side;
use pickline_live::transport::ros2::Ros2Settings;

/// The environment variable that sets the domain of all ROS 2 programs.
const DOMAIN: &str = "ROS_DOMAIN_ID";
/// The last domain whose ports are in range.
const LAST_DOMAIN: u16 = 232;

impl Ros2Args {
    /// The settings for the graph; `None` without `--ros2`.
    ///
    /// # Errors
    /// An invalid domain.
    pub(crate) fn resolve(&self, side: Side, clock: ClockKind) -> Result<Option<Ros2Settings>> {
        if !self.ros2 {
            return Ok(None);
        }
        let namespace = format!("/{}", self.ros2_namespace.trim_start_matches('/'));
        let mut settings = Ros2Settings::new(&namespace, side, clock)
            .with_domain(self.domain()?)
            .with_frame(&self.ros2_frame)
            .with_best_effort(self.ros2_best_effort);
        if !self.ros2_network.is_empty() {
            settings = settings.with_networks(self.ros2_network.clone());
        }
        Ok(Some(settings))
    }

    fn domain(&self) -> Result<u16> {
        let wrong = |place: &str, value: &str| {
            let problem = format!("`{}` is not a DDS domain", shown(value));
            Error::usage(place, problem, format!("give 0 to {LAST_DOMAIN}"))
        };
        if let Some(domain) = self.ros2_domain {
            return (domain <= LAST_DOMAIN)
                .then_some(domain)
                .ok_or_else(|| wrong("--ros2-domain", &domain.to_string()));
        }
        let Ok(text) = std::env::var(DOMAIN) else {
            return Ok(0);
        };
        let domain = text.trim().parse().ok();
        domain
            .filter(|domain| *domain <= LAST_DOMAIN)
            .ok_or_else(|| wrong(DOMAIN, &text))
    }
}
