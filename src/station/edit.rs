//! Edits station files without changing their comments and layout.

use super::file::Overrides;
use crate::error::{Error, Result};
use toml_edit::{DocumentMut, Item, Value, value};

/// The text of a station file with `strategy` as its strategy and the values of `overrides`.
/// Everything else stays as it is, including comments and layout.
///
/// # Errors
/// If the text is not valid TOML; messages call the file `name`.
pub fn edited(text: &str, name: &str, strategy: &str, overrides: Overrides) -> Result<String> {
    let (mark, body) = match text.strip_prefix('\u{feff}') {
        Some(body) => ("\u{feff}", body),
        None => ("", text),
    };
    let mut document: DocumentMut = body.parse().map_err(|error: toml_edit::TomlError| {
        let problem = format!("not valid TOML: {}", error.message().replace('\n', "; "));
        Error::input(name, problem, "fix the file, then save again").caused_by(error)
    })?;
    if let Some(robots) = overrides.robots {
        replace(&mut document["line"]["robots"], Value::from(robots as i64));
    }
    if let Some(speed) = overrides.belt_speed {
        replace(&mut document["belt"]["speed"], Value::from(speed));
    }
    if document.contains_key("strategy") {
        replace(&mut document["strategy"], Value::from(strategy));
    } else {
        let head = split_head(&mut document);
        document.insert("strategy", value(strategy));
        if let Some(mut key) = document.key_mut("strategy") {
            key.leaf_decor_mut().set_prefix(head);
        }
    }
    let mut text = document.to_string();
    if body.contains("\r\n") {
        text = text.replace("\r\n", "\n").replace('\n', "\r\n");
    }
    Ok(mark.to_owned() + &text)
}

/// Sets a value and keeps the comment after it.
fn replace(item: &mut Item, mut new: Value) {
    if let Some(old) = item.as_value() {
        *new.decor_mut() = old.decor().clone();
    }
    *item = Item::Value(new);
}

/// Detaches the comment at the head of the file from the first table, so that a key can be inserted
/// between them. A comment directly above the table stays there.
fn split_head(document: &mut DocumentMut) -> String {
    let first = document.iter().map(|(key, _)| key.to_owned()).next();
    let Some(Item::Table(table)) = first.and_then(|key| document.get_mut(&key)) else {
        return String::new();
    };
    let above = table.decor().prefix().and_then(|prefix| prefix.as_str());
    let above = above.unwrap_or_default().replace("\r\n", "\n");
    let (head, rest) = match above.rfind("\n\n") {
        Some(end) => above.split_at(end + 1),
        None => ("", above.as_str()),
    };
    // One empty line before and after the new key.
    let head = if head.is_empty() {
        String::new()
    } else {
        format!("{head}\n")
    };
    let rest = format!("\n{}", rest.trim_start_matches('\n'));
    table.decor_mut().set_prefix(rest);
    head
}

#[cfg(test)]
mod tests {
    use super::super::file::{commented_example, parse, parse_with_strategy};
    use super::*;

    const NONE: Overrides = Overrides {
        robots: None,
        belt_speed: None,
    };

    /// Checks that `other` contains all lines of `text` in order, and that a byte order mark stays
    /// first.
    fn keeps(text: &str, other: &str) -> bool {
        let mark = '\u{feff}';
        let mut lines = other.trim_start_matches(mark).lines();
        let mut before = text.trim_start_matches(mark).lines();
        before.all(|line| lines.any(|l| l == line))
            && text.starts_with(mark) == other.starts_with(mark)
    }

    #[test]
    fn a_strategy_is_added_and_changed_and_all_else_stays() {
        let listed = "# mine\n[belt] # here\nspeed = 0.05\nlength = 4\nwidth = 1.0\n\n# left\n[[robot]]\n\
             name = \"a\"\nbase = [1, -0.6]\nbin = [1.0, -0.5]\nreach = 0.8\nspeed = 0.5\n\
             grasp_time = 0\nrelease_time = 0.1\n";
        let example = commented_example();
        for text in [
            example,
            listed,
            &example.replace('\n', "\r\n"),
            &format!("\u{feff}{listed}"),
        ] {
            let before = parse(text, "t", NONE).unwrap();
            let mut saved = text.to_owned();
            for strategy in ["rules:SPT,FIFO", "rules:LD,LD"] {
                saved = edited(&saved, "t", strategy, NONE).unwrap();
                assert!(keeps(text, &saved), "{saved}");
                let (station, found) = parse_with_strategy(&saved, "t", NONE).unwrap();
                assert_eq!(station, before);
                assert_eq!(found.unwrap().text, strategy);
                assert_eq!(saved.matches("\nstrategy =").count().max(1), 1);
                assert_eq!(saved.contains('\r'), text.contains('\r'));
            }
            assert_eq!(saved.lines().count(), text.lines().count() + 2, "{saved}");
        }
    }

    #[test]
    fn overrides_are_written_with_it() {
        let overrides = Overrides {
            robots: Some(4),
            belt_speed: Some(0.07),
        };
        let saved = edited(
            commented_example(),
            "t",
            "rules:SPT,SPT,SPT,FIFO",
            overrides,
        )
        .unwrap();
        let expected = parse(commented_example(), "t", overrides).unwrap();
        assert_eq!(parse(&saved, "t", NONE).unwrap(), expected);
        assert!(saved.contains("# constant; every arm must be faster than this"));
    }
}
