//! What a call of a verb may write, checked before the work begins: no output is also an input or
//! another output, none replaces a file that is not a result of the same verb unless that is
//! forced, and every folder is tested by writing to it.

use crate::origin::is_result_of;
use crate::verb_report::VerbReport;
use pickline::error::{Error, Result};
use pickline::files::{self, Named};
use pickline::pattern::is_pattern_name;
use pickline::strategies::weight_files;
use std::path::{Path, PathBuf};

/// Larger files are not results of this program [bytes].
const LARGEST_RESULT: u64 = 1 << 30;

/// The setting that names the folder of the result files.
const OUT: &str = "'out'";

/// Protects files from being overwritten by the results of a verb.
#[derive(Debug, Clone, Copy)]
pub struct OutputProtection<'v> {
    verb: &'v str,
    force: bool,
}

impl<'v> OutputProtection<'v> {
    /// The protection for `verb`, such as `pattern generate`: it may replace its own results only.
    pub const fn of(verb: &'v str) -> Self {
        let force = false;
        Self { verb, force }
    }

    /// The same, but with `force` any file may be replaced that the call does not read.
    #[must_use]
    pub const fn with_force(self, force: bool) -> Self {
        Self { force, ..self }
    }

    /// Checks everything that a call writes: `written`, and the result files of its report `R` in
    /// the folder `out`.
    ///
    /// # Errors
    /// As for [`OutputProtection::check`]; a folder that cannot be created.
    pub fn check_report<R: VerbReport>(
        &self,
        out: Option<&Path>,
        read: &Named,
        written: &Named,
    ) -> Result<()> {
        let Some(folder) = out else {
            return self.check(read, written);
        };
        files::check_folder(folder)?;
        let names = R::file_names().into_iter();
        let results: Vec<PathBuf> = names.map(|name| folder.join(name)).collect();
        let results: Vec<_> = results
            .iter()
            .map(|file| (OUT, Some(file.as_path())))
            .collect();
        files::check_apart(&results, written)?;
        if folder.exists() {
            return self.check(read, &[written, &results].concat());
        }
        // A folder that does not exist yet has no files to protect, and another output may go into
        // it.
        let parts = |path: &Path| path.components().collect::<PathBuf>();
        let is_in_folder = |file: &Path| parts(files::folder_of(file)) == parts(folder);
        let elsewhere = written.iter().copied();
        let elsewhere = elsewhere.filter(|(_, file)| !file.is_some_and(is_in_folder));
        self.check(read, &elsewhere.collect::<Vec<_>>())
    }

    /// Checks the files that a call writes, before any of them is written.
    ///
    /// # Errors
    /// A file that cannot be written, that is also an input or another output, or that already
    /// exists and is not a result of the verb, unless that is forced.
    pub fn check(&self, read: &Named, written: &Named) -> Result<()> {
        for file in written.iter().filter_map(|(_, file)| *file) {
            files::check_target(file)?;
        }
        check_not_inputs(read, written)?;
        // A policy's weights may be in separate files next to it.
        let mut weights = Vec::new();
        for (setting, file) in read {
            let file = file.filter(|file| file.is_file());
            let beside = file.map(weight_files).into_iter().flatten();
            weights.extend(beside.map(|file| (*setting, file)));
        }
        let weights = weights
            .iter()
            .map(|(setting, file)| (*setting, Some(&**file)));
        let read: Vec<_> = read.iter().copied().chain(weights).collect();
        files::check_apart(&read, written)?;
        for (setting, file) in written {
            let Some(file) = file else { continue };
            if !self.force {
                self.check_replaceable(setting, file)?;
            }
            files::try_target(file)?;
        }
        Ok(())
    }

    /// Checks that `file` may be replaced by a result of the verb. An empty file may always be
    /// replaced.
    fn check_replaceable(&self, setting: &str, file: &Path) -> Result<()> {
        let Ok(about) = std::fs::metadata(file) else {
            return Ok(());
        };
        if !about.is_file() || about.len() == 0 {
            return Ok(());
        }
        let refused = |problem: &str| {
            Err(Error::path(
                setting,
                format!("{} {problem}", file.display()),
                "name another file, or add 'force' to overwrite it",
            ))
        };
        if about.permissions().readonly() {
            return refused("exists and is read-only");
        }
        let content = match about.len() {
            ..=LARGEST_RESULT => std::fs::read(file).unwrap_or_default(),
            _ => Vec::new(),
        };
        let verb = self.verb;
        if is_result_of(&content, verb) {
            return Ok(());
        }
        refused(&format!("exists and was not written by `pickline {verb}`"))
    }
}

/// Checks that no output goes into a folder of input patterns: the next call would read it as one
/// of them.
fn check_not_inputs(read: &Named, written: &Named) -> Result<()> {
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    let folders = read.iter().filter_map(|(setting, path)| {
        let folder = path.filter(|path| path.is_dir())?;
        Some((setting, folder, real(folder)?))
    });
    for (from, folder, folder_real) in folders {
        for (setting, file) in written {
            let Some(file) = file.filter(|file| is_pattern_name(file)) else {
                continue;
            };
            if real(files::folder_of(file)).as_ref() == Some(&folder_real) {
                return Err(Error::usage(
                    *setting,
                    format!(
                        "{} would be among the patterns in {from} {}",
                        file.display(),
                        folder.display()
                    ),
                    "use another folder",
                ));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::origin::origin_comment;

    #[test]
    fn only_force_replaces_what_another_verb_wrote() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("result.csv");
        let written = [("'svg'", Some(path.as_path()))];
        let check = |verb, force| {
            let protection = OutputProtection::of(verb).with_force(force);
            protection.check(&[], &written)
        };
        assert!(check("compare", false).is_ok());
        std::fs::write(&path, origin_comment("pickline compare --svg a")).unwrap();
        assert!(check("compare", false).is_ok());
        assert!(check("sweep", true).is_ok());
        let message = check("sweep", false).unwrap_err().to_string();
        for words in ["'svg'", "not written by `pickline sweep`", "add 'force'"] {
            assert!(message.contains(words), "{message}");
        }
        // Not even force overwrites an input.
        let read = [("'station'", Some(path.as_path()))];
        let protection = OutputProtection::of("compare").with_force(true);
        assert!(protection.check(&read, &written).is_err());
    }
}
