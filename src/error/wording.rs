//! Names, values and counts as messages write them.

/// The known name most similar to `given`, for "did you mean" hints. `None` if no name is similar
/// enough to be a typing mistake.
pub fn nearest<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known
        .into_iter()
        .map(|name| {
            let distance = strsim::damerau_levenshtein(&given.to_lowercase(), &name.to_lowercase());
            (distance, name)
        })
        .filter(|(distance, name)| *distance <= 1 + name.chars().count() / 3)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name)
}

/// "did you mean `x`? known: a, b, c", the usual cure for an unknown name.
pub fn known_names(given: &str, known: &[&str]) -> String {
    let mut once: Vec<&str> = Vec::with_capacity(known.len());
    for name in known {
        if !once.contains(name) {
            once.push(name);
        }
    }
    let list = once.join(", ");
    match nearest(given, known.iter().copied()) {
        Some(name) => format!("did you mean `{name}`? known: {list}"),
        None => format!("known: {list}"),
    }
}

/// Several things in a sentence: `a`, `a and b`, `a, b and c`.
pub fn listed(things: &[impl AsRef<str>]) -> String {
    match things {
        [] => String::new(),
        [only] => only.as_ref().to_owned(),
        [first @ .., last] => {
            let first: Vec<&str> = first.iter().map(AsRef::as_ref).collect();
            format!("{} and {}", first.join(", "), last.as_ref())
        }
    }
}

/// A value from a file as messages show it: control characters escaped, long text truncated.
pub fn shown(value: &str) -> String {
    const MOST: usize = 60;
    let mut text: String = value
        .chars()
        .take(MOST)
        .flat_map(char::escape_debug)
        .collect();
    if value.chars().nth(MOST).is_some() {
        text.push_str("...");
    }
    text
}

/// A count with a noun whose plural takes an s: `1 rule`, `2 rules`.
pub fn counted(count: usize, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

/// A count with its digits in groups of three: `1,999`.
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A number as messages show it: with an exponent if it would otherwise be hundreds of digits long.
pub fn shown_number(value: f64) -> String {
    let short = format!("{value:?}");
    if short.contains('e') {
        short
    } else {
        value.to_string()
    }
}

/// A computed number rounded to `digits` significant digits, which hides rounding noise: `316.665`
/// for 316.6654896958023.
pub fn rounded(value: f64, digits: usize) -> String {
    let short = format!("{value:.0$e}", digits.saturating_sub(1));
    shown_number(short.parse().unwrap_or(value))
}

/// `value` rounded by `round` to this number of significant digits, for limits that must be kept from
/// one side.
pub fn significant(value: f64, digits: i32, round: impl Fn(f64) -> f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let digits = digits - 1 - value.abs().log10().floor() as i32;
    // Dividing by a power of ten gives the shortest decimal; a product may not.
    if digits >= 0 {
        let scale = 10f64.powi(digits);
        round(value * scale) / scale
    } else {
        let scale = 10f64.powi(-digits);
        round(value / scale) * scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_finds_typing_mistakes_and_nothing_unrelated() {
        let known = ["speed", "length", "width"];
        assert_eq!(nearest("sped", known), Some("speed"));
        assert_eq!(nearest("WIDHT", known), Some("width"));
        assert_eq!(nearest("colour", known), None);
    }

    #[test]
    fn numbers_are_shown_as_one_would_write_them() {
        for (value, text) in [
            (-1.0, "-1"),
            (0.05, "0.05"),
            (1e300, "1e300"),
            (1e-9, "1e-9"),
        ] {
            assert_eq!(shown_number(value), text);
        }
        assert_eq!(shown_number(f64::NAN), "NaN");
        assert_eq!(rounded(316.6654896958023, 6), "316.665");
        assert_eq!(rounded(-284.34000000000003, 9), "-284.34");
        assert_eq!(rounded(f64::NAN, 9), "NaN");
    }

    #[test]
    fn shown_cuts_and_escapes() {
        assert_eq!(shown("a\u{7}b"), "a\\u{7}b");
        assert_eq!(shown(&"x".repeat(100)), format!("{}...", "x".repeat(60)));
    }
}
