//! How the library's settings are written on the command line.

use pickline::error::spell_settings;
use pickline::study::Note;

/// Settings whose flags have other names, each with its flag. All others have the name of their flag
/// with `_` for `-`.
const RENAMED: [(&str, &str); 16] = [
    ("angle_deg", "angle"),
    ("area_cm2", "area"),
    ("default_p_grasp", "grasp-success"),
    ("delta", "race"),
    ("grasp_failures", "failing-grasps"),
    ("jitter", "jitter-ms"),
    ("kind", "search"),
    ("merge_distance_m", "merge-distance"),
    ("runs", "max-runs"),
    ("scale_m_per_px", "scale"),
    ("scan", "speed-step"),
    ("split_distance_m", "split-distance"),
    // `SweepOptions::with_axis`; another `axis` is that of the image of a recording.
    ("sweep_axis", "sweep"),
    ("training", "train-patterns"),
    ("until", "time-limit"),
    ("validation", "validate"),
];

/// The flag of a setting that a message of the library names: `--update-hz` for `update_hz`.
pub fn flag(setting: &str) -> String {
    let renamed = RENAMED.iter().find(|(name, _)| *name == setting);
    match renamed {
        Some((_, flag)) => format!("--{flag}"),
        None => format!("--{}", setting.replace('_', "-")),
    }
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
    use super::{RENAMED, flag};
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

    /// The code of the library, without comments.
    fn read_code(folder: &Path, code: &mut String) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                read_code(&path, code);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                let comment = |line: &&str| !line.trim_start().starts_with("//");
                for line in text.lines().filter(comment) {
                    *code += line;
                    code.push('\n');
                }
            }
        }
    }

    fn library_code() -> String {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let mut code = String::new();
        for folder in ["src", "crates/live/src", "crates/report/src"] {
            read_code(&root.join(folder), &mut code);
        }
        code
    }

    /// The settings that the library names.
    fn settings(code: &str) -> BTreeSet<String> {
        let settings = RefCell::new(BTreeSet::new());
        for line in code.lines() {
            spell_settings(line, |name| {
                settings.borrow_mut().insert(name.to_owned());
                String::new()
            });
        }
        settings.into_inner()
    }

    /// Settings that are no option of a struct: arguments of functions, variants of an enum, fields
    /// of `Timeouts`, and what chooses among files and functions.
    const ARGUMENTS: [&str; 21] = [
        "belt_timeout",
        "cases",
        "chart",
        "connect",
        "count",
        "dir",
        "fps",
        "imitate",
        "listen",
        "out",
        "partial",
        "preset",
        "radius",
        "record",
        "robot_timeout",
        "shard",
        "robust",
        "station",
        "svg",
        "timeout",
        "train_items",
    ];

    /// A setting has the name by which the library sets it.
    #[test]
    fn every_setting_that_the_library_names_is_one_of_its_options() {
        let code = library_code();
        let settings = settings(&code);
        let is_known = |setting: &&String| {
            // `no_bound` is `with_bound(false)`.
            let option = setting.strip_prefix("no_").unwrap_or(setting);
            let is_option = code.contains(&format!("fn with_{option}("));
            // Those of a transport begin with its name, because several have a `certificate`.
            let is_of_transport = ["mqtt", "ros2", "tls"]
                .iter()
                .any(|transport| option.starts_with(transport));
            let is_listed =
                ARGUMENTS.contains(&option) || RENAMED.iter().any(|(name, _)| *name == option);
            is_option || is_of_transport || is_listed
        };
        let unknown: Vec<&String> = settings.iter().filter(|s| !is_known(s)).collect();
        assert!(unknown.is_empty(), "{unknown:?}");
        let renamed = RENAMED.iter().map(|(name, _)| name);
        for name in renamed.chain(&ARGUMENTS) {
            assert!(settings.contains(*name), "{name} is not used");
        }
    }

    #[test]
    fn every_setting_that_the_library_names_is_a_flag() {
        let mut flags = BTreeSet::new();
        collect_flags(&crate::command(), &mut flags);
        let settings = settings(&library_code());
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
