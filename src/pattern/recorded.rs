//! Recorded patterns: a file, or all those in a folder.

use super::item::Pattern;
use crate::error::{Error, Result, counted};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The patterns of a file or a folder.
pub(super) struct RecordedPatterns {
    /// One label per pattern: the name of its file.
    pub labels: Vec<String>,
    /// The patterns, in the order of the files' names.
    pub patterns: Vec<Pattern>,
    /// The columns that no file's reader knows.
    ignored: BTreeSet<String>,
}

impl RecordedPatterns {
    /// Reads the pattern files at `path`.
    ///
    /// # Errors
    /// A folder without pattern files, or the first problem in a file.
    pub(super) fn load(path: &Path) -> Result<Self> {
        let files = files_of(path)?;
        if files.is_empty() {
            return Err(Error::usage(
                format!("'patterns' {}", path.display()),
                "the folder contains no .csv file",
                "add pattern files to it, or give a single file",
            ));
        }
        let mut recorded = Self {
            labels: Vec::with_capacity(files.len()),
            patterns: Vec::with_capacity(files.len()),
            ignored: BTreeSet::new(),
        };
        for file in &files {
            let loaded = super::file::load(file)?;
            recorded.patterns.push(loaded.pattern);
            recorded.ignored.extend(loaded.ignored);
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            recorded.labels.push(name.into_owned());
        }
        Ok(recorded)
    }

    /// Where the patterns come from, in words: `path`, and a hash of all items.
    pub(super) fn description(&self, path: &Path) -> String {
        let mut description = format!(
            "{} from {} (hash {})",
            counted(self.patterns.len(), "recorded pattern"),
            path.display(),
            hash_of(&self.patterns)
        );
        if !self.ignored.is_empty() {
            let names: Vec<&str> = self.ignored.iter().map(String::as_str).collect();
            description += &format!(", columns ignored: {}", names.join(", "));
        }
        description
    }
}

/// A hash of all items of `patterns`.
fn hash_of(patterns: &[Pattern]) -> String {
    let all: String = patterns.iter().map(super::file::to_csv).collect();
    crate::files::fingerprint(&all)
}

/// Patterns that a caller has, in words, with a hash of all items.
pub(crate) fn describe_given(patterns: &[Pattern]) -> String {
    let hash = hash_of(patterns);
    format!("{} (hash {hash})", counted(patterns.len(), "given pattern"))
}

/// Whether a file with this name is read as a pattern in a folder.
pub fn is_pattern_name(file: &Path) -> bool {
    let extension = file.extension();
    extension.is_some_and(|e| e.eq_ignore_ascii_case("csv"))
}

/// The pattern files at `path`: a single file, or all those in a folder.
pub(super) fn files_of(path: &Path) -> Result<Vec<PathBuf>> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let mut files = Vec::new();
    for entry in std::fs::read_dir(path).map_err(|e| Error::read(path, e))? {
        let file = entry.map_err(|e| Error::read(path, e))?.path();
        if is_pattern_name(&file) {
            files.push(file);
        }
    }
    // The order within a folder depends on the file system; names do not.
    files.sort();
    Ok(files)
}
