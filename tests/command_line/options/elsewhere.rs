//! Options whose effect is held by a test elsewhere, which fails without it.

use std::path::Path;

/// Verbs, options, and the test as file and function.
type Elsewhere = (
    &'static [&'static str],
    &'static [&'static str],
    &'static str,
);

const LINES: [&str; 2] = ["run", "emulate"];

const ELSEWHERE: &[Elsewhere] = &[
    (
        &[
            "optimize",
            "compare",
            "sweep",
            "game",
            "bound",
            "benchmark",
            "simulate",
            "station show",
            "pattern generate",
            "pattern import tracks",
        ],
        &["--force"],
        "command_line/outputs.rs no_output_replaces_files_of_others",
    ),
    (
        &LINES,
        &["--token"],
        "live/peers/access.rs with_a_token_nobody_is_accepted_without_it",
    ),
    #[cfg(feature = "tls")]
    (
        &LINES,
        &["--tls-cert", "--tls-key", "--tls-ca"],
        "live/peers/access.rs certificates_of_both_sides_are_asked_for",
    ),
    (
        &["run"],
        &["--fsync"],
        "../crates/cli/src/run.rs a_journal_is_synced_where_that_is_asked_for",
    ),
    #[cfg(feature = "onnx")]
    (
        &["train"],
        &["--out", "--steps", "--imitate", "--resume"],
        "learning/train_verb.rs a_training_leaves_its_policy_its_record_and_its_curve",
    ),
    #[cfg(feature = "onnx")]
    (
        &["train"],
        &["--plan"],
        "learning/train_verb.rs a_plan_changes_the_preset_and_a_record_is_a_plan",
    ),
    #[cfg(feature = "onnx")]
    (
        &["train"],
        &[
            "--preset",
            "--station",
            "--learning-rate",
            "--entropy",
            "--imitate-rounds",
            "--imitate-patterns",
            "--seed",
            "--strict",
            "--force",
            "--quiet",
        ],
        "learning/train_options.rs every_option_reaches_the_training",
    ),
    #[cfg(feature = "onnx")]
    (
        &["train"],
        &["--threads"],
        "learning/train_options.rs a_training_is_given_its_threads",
    ),
    #[cfg(feature = "mqtt")]
    (
        &LINES,
        &[
            "--mqtt",
            "--mqtt-prefix",
            "--mqtt-user",
            "--mqtt-password-file",
            "--mqtt-ca",
            "--mqtt-cert",
            "--mqtt-key",
        ],
        "mqtt/access.rs passwords_and_certificates_are_asked_for",
    ),
    #[cfg(feature = "mqtt")]
    (
        &LINES,
        &["--mqtt-client-id"],
        "mqtt/outages.rs the_last_will_reports_that_the_node_has_died",
    ),
    #[cfg(feature = "ros2")]
    (
        &LINES,
        &["--ros2", "--ros2-domain"],
        "ros2/main.rs run_and_emulate_find_each_other",
    ),
    #[cfg(feature = "ros2")]
    (
        &LINES,
        &["--ros2-namespace", "--ros2-network", "--ros2-frame"],
        "ros2/main.rs robots_and_camera_of_another_dds_implementation",
    ),
    #[cfg(feature = "ros2")]
    (
        &LINES,
        &["--ros2-best-effort"],
        "ros2/main.rs a_camera_that_is_not_reliable",
    ),
];

/// Verbs with an option that a test elsewhere holds.
pub fn options() -> impl Iterator<Item = (&'static [&'static str], &'static str)> {
    let each = |(verbs, options, _): &Elsewhere| {
        let (verbs, options) = (*verbs, *options);
        options.iter().map(move |option| (verbs, *option))
    };
    ELSEWHERE.iter().flat_map(each)
}

#[test]
fn the_tests_elsewhere_are_there() {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests");
    for (_, _, test) in ELSEWHERE {
        let (file, name) = test.split_once(' ').unwrap();
        let text = std::fs::read_to_string(tests.join(file)).unwrap();
        assert!(text.contains(&format!("fn {name}(")), "{test}");
    }
}
