//! How a report is shown; none of it changes the result.

use pickline::error::spell_settings;

/// How a report is shown.
#[derive(Debug, Clone, Copy)]
pub struct Presentation {
    /// Most lines of a ranking, of equilibria or of cycles; what is left out is counted.
    pub top: usize,
    /// What the reader calls a setting that texts refer to, such as `time_limit`: for example the
    /// flag of a program. Used as in [`spell_settings`].
    pub spelling: fn(&str) -> String,
}

impl Default for Presentation {
    /// The whole report, with settings by the names that they have in the library.
    fn default() -> Self {
        Self {
            top: usize::MAX,
            spelling: str::to_owned,
        }
    }
}

impl Presentation {
    /// `text` with the settings as the reader calls them.
    pub(crate) fn spelled(&self, text: &str) -> String {
        spell_settings(text, self.spelling)
    }
}
