//! Text in charts: its size, its width, and the characters that it may contain.

/// Width of every chart [px]: shown across a printed page of 170 mm its text is 9 point.
pub(super) const WIDTH: f64 = 720.0;
/// Size of all text [px].
pub(super) const TEXT: u32 = 13;

/// Text that an XML file can contain: names come from users' files.
pub(super) fn clean(text: &str) -> String {
    text.replace(char::is_control, " ")
}

/// Text that kuva does not interpret as mathematics between dollar signs.
pub(super) fn label(text: &str) -> String {
    clean(text).replace('$', "\\$")
}

/// `text` cut to at most `most` characters.
pub(crate) fn short(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    let kept: String = text.chars().take(most - 1).collect();
    format!("{}\u{2026}", kept.trim_end())
}

/// Approximate width of `text` [px]. The reader's font is unknown, so this is a high estimate.
pub(super) fn width(text: &str) -> f64 {
    let per_character = |c: char| match c {
        'i' | 'j' | 'l' | 't' | 'f' | 'r' | 'I' | ' ' | '.' | ',' | ';' | ':' | '[' | ']' | '('
        | ')' => 0.38,
        'm' | 'w' | 'M' | 'W' => 0.92,
        'A'..='Z' => 0.70,
        c if c.is_ascii() => 0.60,
        _ => 1.0,
    };
    f64::from(TEXT) * text.chars().map(per_character).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_cut_between_characters() {
        assert_eq!(short("grid", 4), "grid");
        assert_eq!(short("gr\u{fc}n und blau", 6), "gr\u{fc}n\u{2026}");
    }
}
