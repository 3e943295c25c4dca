//! The library names options in errors and notes; the user knows them as flags.

use pickline::error::Error;
use pickline::study::Note;

/// The options of studies, and the flags that set them. An option whose name begins another
/// one comes after it.
const FLAGS: [(&str, &str); 13] = [
    ("training.given", "--robust"),
    ("training", "--train-patterns"),
    ("replicates", "--replicates"),
    ("reference", "--reference"),
    ("strategy", "--strategy"),
    ("default_p_grasp", "--grasp-success"),
    ("time_limit", "--time-limit"),
    ("items", "--items"),
    ("area", "--area"),
    ("p_detection", "--p-detection"),
    ("p_grasp", "--p-grasp"),
    ("sweep", "--sweep"),
    ("from", "--from"),
];

/// `error` with its option named by the flag that sets it: at the beginning of the place, and
/// in backticks in the cure.
pub fn in_error(error: Error) -> Error {
    match error {
        Error::Input {
            place,
            problem,
            cure,
        } => Error::input(in_place(place), problem, in_text(cure)),
        other => other,
    }
}

/// The texts of `notes`, with options named by the flags that set them.
pub fn in_notes(notes: &[Note]) -> Vec<String> {
    notes.iter().map(in_note).collect()
}

/// The text of one note.
pub fn in_note(note: &Note) -> String {
    in_text(note.to_string())
}

/// `place`, if it begins with the name of an option, with the flag instead.
fn in_place(place: String) -> String {
    let flagged = FLAGS.iter().find_map(|(option, flag)| {
        let rest = place.strip_prefix(option)?;
        let ends = rest.is_empty() || rest.starts_with([' ', ':']);
        ends.then(|| format!("{flag}{rest}"))
    });
    flagged.unwrap_or(place)
}

/// `text` with flags instead of the names in backticks.
fn in_text(text: String) -> String {
    FLAGS.iter().fold(text, |text, (option, flag)| {
        text.replace(&format!("`{option}`"), flag)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_named_by_their_flags_and_the_users_words_are_kept() {
        let error = Error::input(
            "training.given",
            "`items` is not a rule",
            "leave `items` and `training` out",
        );
        let text = in_error(error).to_string();
        assert_eq!(
            text,
            Error::input(
                "--robust",
                "`items` is not a rule",
                "leave --items and --train-patterns out"
            )
            .to_string()
        );
        let places = [
            ("sweep speed at 3", "--sweep speed at 3"),
            ("training: grid s=0.2", "--train-patterns: grid s=0.2"),
            ("items", "--items"),
            ("items.csv", "items.csv"),
            ("itemsized", "itemsized"),
        ];
        for (place, flagged) in places {
            assert_eq!(in_place(place.to_owned()), flagged);
        }
        let notes = [Note::NothingFails, Note::TimeLimit { fresh: 24 }];
        let texts = in_notes(&notes);
        assert!(texts[0].ends_with("give --grasp-success P for items without one"));
        assert!(texts[1].starts_with("--time-limit was reached"));
    }
}
