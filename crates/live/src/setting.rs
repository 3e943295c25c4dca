//! The settings that a remark can name as its cure.

use std::fmt;

/// A setting that a remark names. Its name stands in single quotes, as a setting does in an error,
/// so that a program can write its own words for it ([`pickline::error::spell_settings`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum RemarkSetting {
    /// By how much the timestamps of pictures are late: `camera_delay` of [`Config`](crate::Config).
    CameraDelay,
    /// How long the belt may be silent: `belt` of [`Timeouts`](crate::Timeouts).
    BeltTimeout,
    /// How long a robot may be silent: `robot` of [`Timeouts`](crate::Timeouts).
    RobotTimeout,
    /// How many peers may be connected over TCP: `most_peers` of
    /// [`HubOptions`](crate::transport::HubOptions).
    MaxPeers,
}

impl RemarkSetting {
    const ALL: [Self; 4] = [
        Self::CameraDelay,
        Self::BeltTimeout,
        Self::RobotTimeout,
        Self::MaxPeers,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::CameraDelay => "camera_delay",
            Self::BeltTimeout => "belt_timeout",
            Self::RobotTimeout => "robot_timeout",
            Self::MaxPeers => "max_peers",
        }
    }

    /// The setting with this name, if there is one.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|setting| setting.name() == name)
    }
}

impl fmt::Display for RemarkSetting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "'{}'", self.name())
    }
}
