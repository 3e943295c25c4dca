//! What a name may be: of a robot, an item or a class.
//!
//! Names go through files, messages, topics and reports. One check serves all of them, so
//! that no station or pattern is accepted here and refused there.

use crate::error::{counted, shown};

/// Names are at most this long [characters].
pub const LONGEST_NAME: usize = 200;

/// Why a text is not a name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BadName {
    /// What is wrong, with the text.
    pub problem: String,
    /// What a name is expected to be instead.
    pub expected: String,
}

/// Checks that `text` can name something.
///
/// # Errors
/// A text that is empty, too long, has blanks at an end, or characters that cannot be seen.
pub fn check_name(text: &str) -> Result<(), BadName> {
    let wrong = |problem: &str, expected: String| {
        Err(BadName {
            problem: format!("`{}` {problem}", shown(text)),
            expected,
        })
    };
    if text.is_empty() || text.trim() != text {
        return wrong(
            "is empty or has blanks at an end",
            "a name without them".into(),
        );
    }
    if text.chars().nth(LONGEST_NAME).is_some() {
        let length = counted(text.chars().count(), "character");
        let problem = format!("is too long: {length}");
        return wrong(&problem, format!("at most {LONGEST_NAME} characters"));
    }
    if text.chars().any(is_hidden) {
        return wrong(
            "holds line breaks or control characters",
            "printable characters only".into(),
        );
    }
    Ok(())
}

/// Characters that break lines or show a text as another one: control characters, line and
/// paragraph separators, marks of direction (Unicode Technical Report 36, section 2.5).
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
            (" r1", "blanks"),
            ("r1 ", "blanks"),
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
