//! How the library's settings are written on the command line.

use pickline::error::spell_settings;
use pickline::study::Note;

/// The flag of a setting that a message of the library names: `--update-hz` for `update_hz`.
pub(crate) fn flag(setting: &str) -> String {
    format!("--{}", setting.replace('_', "-"))
}

/// The texts of `notes`, with settings written as flags.
pub(crate) fn in_notes(notes: &[Note]) -> Vec<String> {
    notes.iter().map(in_note).collect()
}

/// The text of one note.
pub(crate) fn in_note(note: &Note) -> String {
    spell_settings(&note.to_string(), flag)
}

#[cfg(test)]
mod tests {
    use super::flag;
    use clap::Command;
    use pickline::error::spell_settings;
    use std::cell::RefCell;
    use std::collections::BTreeSet;
    use std::path::Path;

    fn collect_flags(command: &Command, flags: &mut BTreeSet<String>) {
        let own = command
            .get_arguments()
            .filter_map(|argument| argument.get_long());
        flags.extend(own.map(|name| format!("--{name}")));
        for verb in command.get_subcommands() {
            collect_flags(verb, flags);
        }
    }

    fn collect_settings(folder: &Path, settings: &RefCell<BTreeSet<String>>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                collect_settings(&path, settings);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let code = std::fs::read_to_string(&path).unwrap();
                let comment = |line: &&str| !line.trim_start().starts_with("//");
                for line in code.lines().filter(comment) {
                    spell_settings(line, |name| {
                        settings.borrow_mut().insert(name.to_owned());
                        String::new()
                    });
                }
            }
        }
    }

    #[test]
    fn every_setting_that_the_library_names_is_a_flag() {
        let mut flags = BTreeSet::new();
        collect_flags(&crate::command(), &mut flags);
        let settings = RefCell::default();
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        for folder in ["src", "crates/live/src", "crates/report/src"] {
            collect_settings(&root.join(folder), &settings);
        }
        let settings = settings.into_inner();
        assert!(settings.len() > 40, "{settings:?}");
        // The flags of a transport that is not built in are unknown.
        let is_built_in = |setting: &str| {
            let without =
                |transport: &str, is_built_in: bool| !is_built_in && setting.starts_with(transport);
            !without("mqtt", cfg!(feature = "mqtt")) && !without("ros2", cfg!(feature = "ros2"))
        };
        for setting in settings.into_iter().filter(|setting| is_built_in(setting)) {
            assert!(flags.contains(&flag(&setting)), "{setting} is no flag");
        }
    }
}
