//! The format of log lines.

use std::time::{SystemTime, UNIX_EPOCH};

/// The severity of a remark. The numbers are those of syslog (RFC 5424, section 6.2.1),
/// which journald uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum LogLevel {
    /// The program or a part of it cannot continue.
    Error = 3,
    /// Something is wrong, but the line continues.
    Warning = 4,
    /// Information for the operator.
    Info = 6,
}

impl LogLevel {
    fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
            Self::Info => "info",
        }
    }
}

/// The format of a log line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Style {
    /// Only the text.
    Text,
    /// The text after its level, as journald expects it: `<4>text`.
    Journald,
    /// The text after the Unix time and the level: `1795656426.123 warning text`.
    Stamped,
}

impl Style {
    /// The journald format if stderr is connected to the journal, otherwise only the text.
    pub(crate) fn found() -> Self {
        match std::env::var("JOURNAL_STREAM") {
            Ok(stream) if leads_to(&stream) => Self::Journald,
            _ => Self::Text,
        }
    }

    /// `text` in this format, with a newline.
    pub(crate) fn line(self, level: LogLevel, text: &str) -> String {
        match self {
            Self::Text => format!("{text}\n"),
            // In the journal, each line is a separate entry.
            Self::Journald => {
                let lines = text.lines();
                lines
                    .map(|line| format!("<{}>{line}\n", level as u8))
                    .collect()
            }
            Self::Stamped => {
                let since = SystemTime::now().duration_since(UNIX_EPOCH);
                let stamp = since.unwrap_or_default().as_secs_f64();
                format!("{stamp:.3} {} {text}\n", level.name())
            }
        }
    }
}

/// Whether stderr is the stream with this device and inode (`DEVICE:INODE`). The check is
/// needed because programs inherit the variable even if their stderr is redirected.
#[cfg(unix)]
fn leads_to(stream: &str) -> bool {
    use std::os::fd::AsFd as _;
    use std::os::unix::fs::MetadataExt as _;
    let stderr = std::io::stderr().as_fd().try_clone_to_owned();
    let Ok(stderr) = stderr.map(std::fs::File::from) else {
        return false;
    };
    let found = stderr.metadata();
    found.is_ok_and(|found| stream == format!("{}:{}", found.dev(), found.ino()))
}

#[cfg(not(unix))]
fn leads_to(_: &str) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_for_journald_has_its_level() {
        let text = "camera: no word\n  cure: look";
        assert_eq!(
            Style::Journald.line(LogLevel::Warning, text),
            "<4>camera: no word\n<4>  cure: look\n"
        );
        assert_eq!(Style::Text.line(LogLevel::Error, "a"), "a\n");
        let stamped = Style::Stamped.line(LogLevel::Info, "a");
        let stamp = stamped.strip_suffix(" info a\n").unwrap();
        assert!(stamp.parse::<f64>().unwrap() > 1.7e9, "{stamped}");
    }
}
