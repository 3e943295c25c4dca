//! Settings in messages, and how a program spells them.

/// The text with each setting, a name of at least two letters or digits in single quotes such as
/// `'update_hz'`, replaced by what `spelling` makes of the name. Apostrophes and other quoted texts
/// stay.
pub fn spell_settings(text: &str, spelling: impl Fn(&str) -> String) -> String {
    let mut spelled = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find('\'') {
        let (before, quoted) = (&rest[..at], &rest[at + 1..]);
        spelled.push_str(before);
        let is_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        let name = &quoted[..quoted.find(|c| !is_name(c)).unwrap_or(quoted.len())];
        let is_setting = name.len() > 1
            && name.starts_with(|c: char| c.is_ascii_lowercase())
            && !before.ends_with(char::is_alphanumeric)
            && quoted[name.len()..].starts_with('\'');
        if is_setting {
            spelled.push_str(&spelling(name));
            rest = &quoted[name.len() + 1..];
        } else {
            spelled.push('\'');
            rest = quoted;
        }
    }
    spelled + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_spelled_as_the_program_does_and_other_quotes_stay() {
        let flag = |name: &str| format!("--{}", name.replace('_', "-"));
        for (text, spelled) in [
            (
                "give 'update_hz' or 'flow' 60",
                "give --update-hz or --flow 60",
            ),
            (
                "a robot's arm, the robots' arms",
                "a robot's arm, the robots' arms",
            ),
            ("'two words', 'x' and '", "'two words', 'x' and '"),
            ("'ros2' on '10'", "--ros2 on '10'"),
            ("none", "none"),
        ] {
            assert_eq!(spell_settings(text, flag), spelled);
        }
    }
}
