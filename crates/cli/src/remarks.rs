//! What a live program has to say, and whether it may.

use super::flags::flag;
use super::log::{Log, LogLevel, Style, kind_of};
use pickline::error::spell_settings;
use pickline_live::RemarkSetting;
use std::sync::Arc;

/// Remarks for the operator; a quiet program makes none.
#[derive(Debug, Clone)]
pub(crate) struct Remarks {
    log: Arc<Log>,
    quiet: bool,
}

impl Remarks {
    /// Remarks on stderr in this style.
    pub(crate) fn on_stderr(style: Style, quiet: bool) -> Self {
        Self {
            log: Arc::new(Log::on_stderr(style)),
            quiet,
        }
    }

    /// The log, in which errors are written even if quiet.
    pub(crate) fn log(&self) -> &Arc<Log> {
        &self.log
    }

    /// A remark, unless quiet.
    pub(crate) fn remark(&self, text: &str) {
        self.say(LogLevel::Info, &kind_of(text), text);
    }

    /// A warning, unless quiet.
    pub(crate) fn warn(&self, text: &str) {
        self.say(LogLevel::Warning, &kind_of(text), text);
    }

    /// A remark, unless quiet; repeated remarks of one `kind` are summed up. Settings are named by
    /// their flags.
    pub(crate) fn say(&self, level: LogLevel, kind: &str, text: &str) {
        if !self.quiet {
            self.log.say(level, &with_flags(kind), &with_flags(text));
        }
    }
}

/// A remark of the line with flags in place of its settings. What else stands in quotes may be a
/// name that a peer has given.
fn with_flags(text: &str) -> String {
    spell_settings(text, |name| match RemarkSetting::named(name) {
        Some(setting) => flag(setting.name()),
        None => format!("'{name}'"),
    })
}
