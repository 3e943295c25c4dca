//! The rules for names of robots, items and classes.
//!
//! Names appear in files, messages, topics and reports. A single check covers all of them, so that
//! a name accepted in one place is not rejected in another.

use crate::error::{counted, shown};

/// Maximum length of a name [characters].
pub const LONGEST_NAME: usize = 200;

/// Why a text is not a valid name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BadName {
    /// The problem, including the text.
    pub problem: String,
    /// What a valid name looks like.
    pub expected: String,
}

/// Checks that `text` is a valid name.
///
/// # Errors
/// If the text is empty, too long, starts or ends with a space, or contains invisible characters.
pub fn check_name(text: &str) -> Result<(), BadName> {
    let wrong = |problem: &str, expected: String| {
        Err(BadName {
            problem: format!("`{}` {problem}", shown(text)),
            expected,
        })
    };
    if text.is_empty() || text.trim() != text {
        return wrong(
            "is empty, or starts or ends with a space",
            "a name without leading or trailing spaces".into(),
        );
    }
    if text.chars().nth(LONGEST_NAME).is_some() {
        let length = counted(text.chars().count(), "character");
        let problem = format!("is too long: {length}");
        return wrong(&problem, format!("at most {LONGEST_NAME} characters"));
    }
    if text.chars().any(is_hidden) {
        return wrong(
            "contains line breaks or control characters",
            "printable characters only".into(),
        );
    }
    Ok(())
}

/// Stands for "nothing that is to be picked" in the column `true_class` of a pattern, and for items
/// without a class in tables.
pub const NO_CLASS: &str = "-";

/// Checks that `text` can be the name of a class, which is not [`NO_CLASS`].
///
/// # Errors
/// As for [`check_name`].
pub fn check_class_name(text: &str) -> Result<(), BadName> {
    if text == NO_CLASS {
        return Err(BadName {
            problem: format!("`{NO_CLASS}` stands for no class"),
            expected: "a name".into(),
        });
    }
    check_name(text)
}

/// Characters that break lines or make a text look like another one: control characters, line and
/// paragraph separators, and direction marks (Unicode Technical Report 36, section 2.5).
fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_short_and_show_what_they_are() {
        for name in ["r1", "\u{e9}", "delta 1", "a,b", &"x".repeat(LONGEST_NAME)] {
            assert_eq!(check_name(name), Ok(()), "{name}");
        }
        for (name, word) in [
            ("", "empty"),
            (" r1", "ends with a space"),
            ("r1 ", "ends with a space"),
            ("r\u{7}", "control"),
            ("r\n1", "control"),
            ("r\u{202e}1", "control"),
            ("r\u{2028}1", "control"),
            (&"x".repeat(LONGEST_NAME + 1), "too long: 201 characters"),
        ] {
            let problem = check_name(name).unwrap_err().problem;
            assert!(problem.contains(word), "{problem}");
            assert!(!problem.contains(is_hidden), "{problem:?}");
        }
    }
}
