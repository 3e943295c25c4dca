//! Where a pattern is written.

use crate::session::Session;
use pickline::error::Result;
use pickline::files;
use pickline::pattern::{Pattern, to_csv};
use pickline_report::origin_comment;
use std::path::{Path, PathBuf};

/// The file of `--output`, unless it is stdout.
pub(super) fn written(output: Option<PathBuf>) -> Option<PathBuf> {
    output.filter(|file| file != Path::new("-"))
}

/// Writes `pattern` to `file`, with the command line that made it, or prints it.
pub(super) fn write_pattern(
    file: Option<&Path>,
    pattern: &Pattern,
    session: &Session,
) -> Result<()> {
    let text = to_csv(pattern);
    match file {
        Some(file) => {
            let origin = origin_comment(&session.command());
            files::write_whole(file, (origin + &text).as_bytes())
        }
        None => session.print(text.as_bytes()),
    }
}
