//! How a report is shown; none of it changes the result.

/// How a report is shown on the terminal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Presentation {
    /// Most lines of a ranking, of equilibria or of cycles; what is left out is counted.
    pub top: usize,
    /// How the reader knows the settings that texts refer to.
    pub settings: SettingNames,
}

impl Default for Presentation {
    fn default() -> Self {
        Self {
            top: usize::MAX,
            settings: SettingNames::default(),
        }
    }
}

/// What the reader calls the settings that texts refer to, such as the flags of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SettingNames {
    /// What the reader calls the setting [`Presentation::top`].
    pub top: &'static str,
    /// The time after which a search ends.
    pub time_limit: &'static str,
    /// The number of runs after which a search ends.
    pub max_runs: &'static str,
    /// The number of items in each pattern.
    pub items: &'static str,
    /// The length of a bound's time slots.
    pub slot: &'static str,
}

impl Default for SettingNames {
    fn default() -> Self {
        Self {
            top: "top",
            time_limit: "its time limit",
            max_runs: "max_runs",
            items: "items",
            slot: "slot",
        }
    }
}
