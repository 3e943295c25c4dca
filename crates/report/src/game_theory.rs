//! "GT", the paper's abbreviation for game theory, spelled out where it is first printed.

/// The line of a table that spells it out.
pub(crate) const GT_LINE: &str =
    "GT        game theory, the paper's term for assignments of dispatching rules\n";

/// "GT" spelled out.
const EXPLAINED: &str = "GT (game theory)";

/// Spells out the first "GT" of `text`, unless it is already. Returns whether `text` has one.
pub(crate) fn spell_out(text: &mut String) -> bool {
    let is_part = |c: char| c.is_alphanumeric();
    let mut places = text.match_indices("GT");
    let word = places.find(|(at, found)| {
        let (before, after) = (&text[..*at], &text[at + found.len()..]);
        !before.ends_with(is_part) && !after.starts_with(is_part)
    });
    let Some((at, found)) = word else {
        return false;
    };
    let end = at + found.len();
    if !text[at..].starts_with(EXPLAINED) {
        text.replace_range(at..end, EXPLAINED);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_gt_is_spelled_out() {
        for (text, expected) in [
            ("robust GT, greedy GT", "robust GT (game theory), greedy GT"),
            ("a GT (game theory)", "a GT (game theory)"),
            ("onnx:LGT.onnx; GT", "onnx:LGT.onnx; GT (game theory)"),
            ("none", "none"),
        ] {
            let mut spelled = text.to_owned();
            assert_eq!(spell_out(&mut spelled), text != "none");
            assert_eq!(spelled, expected);
        }
    }
}
