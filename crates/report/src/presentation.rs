//! How a report is shown; none of it changes the result.

use pickline::error::spell_settings;
use pickline::study::Note;

/// How a report is shown on the terminal.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
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
        Self::whole(str::to_owned)
    }
}

impl Presentation {
    /// The whole report, with settings as `spelling` names them.
    pub const fn whole(spelling: fn(&str) -> String) -> Self {
        Self {
            top: usize::MAX,
            spelling,
        }
    }

    /// With at most this number of lines of a ranking, of equilibria or of cycles.
    #[must_use]
    pub const fn with_top(self, top: usize) -> Self {
        Self { top, ..self }
    }

    /// The texts of `notes`, with the settings as the reader calls them.
    pub fn notes(&self, notes: &[Note]) -> Vec<String> {
        let notes = notes.iter();
        notes.map(|note| self.spelled(&note.to_string())).collect()
    }

    /// `text` with the settings as the reader calls them.
    pub(crate) fn spelled(&self, text: &str) -> String {
        spell_settings(text, self.spelling)
    }
}
