//! How a file names the command that wrote it, and how that is read back before the
//! file is overwritten.

use super::page::escape;
use serde_json::Value;

/// The first line of a CSV file written by `command`. Readers skip it as a comment.
pub fn origin_comment(command: &str) -> String {
    format!("# {}\n", origin(command))
}

/// `svg` with the `command` that wrote it in its description.
pub fn with_origin(svg: &str, command: &str) -> String {
    // After the opening tag, where every SVG accepts a description.
    let Some(place) = svg
        .find("<svg")
        .and_then(|at| Some(at + svg[at..].find('>')? + 1))
    else {
        return svg.to_owned();
    };
    let (open, rest) = svg.split_at(place);
    format!("{open}\n<desc>{}</desc>{rest}", escape(&origin(command)))
}

/// The HTML `page` with the `command` that wrote it at the top.
pub(crate) fn with_page_origin(page: &str, command: &str) -> String {
    // After the document type, which must come first.
    match page.split_once('\n') {
        Some((first, rest)) => {
            format!(
                "{first}\n{PAGE_MARK}{} -->\n{rest}",
                escape(&origin(command))
            )
        }
        None => page.to_owned(),
    }
}

/// The beginning of the second line of our pages.
const PAGE_MARK: &str = "<!-- made by ";

fn origin(command: &str) -> String {
    let version = env!("CARGO_PKG_VERSION");
    // A file name may contain line breaks, which would end the comment.
    let command = command.replace(char::is_control, " ");
    format!("pickline {version}; {command}")
}

/// Whether `content` is a file that the subcommand `verb` wrote, judging by the file itself. A
/// file that only mentions the subcommand, such as a script that calls it, does not count.
pub(crate) fn is_result_of(content: &[u8], verb: &str) -> bool {
    let Ok(text) = std::str::from_utf8(content) else {
        // Policies are the only results that are not text.
        let has = |words: &str| content.windows(words.len()).any(|w| w == words.as_bytes());
        return has("pickline.training") && has(&format!("\"command\":\"pickline {verb}"));
    };
    let called = format!("pickline {verb}");
    match text.trim_start_matches('\u{feff}').trim_start() {
        text if text.starts_with("# pickline ") => {
            let mut comments = text
                .lines()
                .take_while(|line| line.starts_with('#'))
                .take(20);
            comments.any(|line| is_call(line, &called))
        }
        // Earlier versions name the call in the last field of every row.
        text if text
            .lines()
            .next()
            .is_some_and(|line| line.ends_with(",made")) =>
        {
            text.lines()
                .nth(1)
                .is_some_and(|line| is_call(line, &called))
        }
        text if text.starts_with('{') => is_json_of(text, &called),
        text if text.starts_with("<svg") || text.starts_with("<?xml") => {
            let about = text.split_once("<desc>").map_or("", |(_, rest)| rest);
            let about = about.split_once("</desc>").map_or("", |(about, _)| about);
            is_call(about, &called)
        }
        text if text.starts_with("<!doctype html>") || text.starts_with("<!DOCTYPE html>") => {
            let second = text.lines().nth(1).unwrap_or_default();
            let mark = second.strip_prefix(PAGE_MARK);
            mark.is_some_and(|mark| is_call(mark, &called))
        }
        // Gambit's format: players and strategies, then a comment.
        text if text.starts_with("NFG 1 R ") => {
            text.lines().take(6).any(|line| is_call(line, &called))
        }
        // A learning curve; it must not depend on whether the training was resumed.
        text => verb == "train" && text.starts_with("steps,seconds,answers,agreement,"),
    }
}

/// Whether a line of provenance names the call `called` after the program and its version.
fn is_call(line: &str, called: &str) -> bool {
    ["; ", ": ", "# "].iter().any(|before| {
        let marked = format!("{before}{called}");
        line.match_indices(&marked).any(|(at, found)| {
            let next = line[at + found.len()..].chars().next();
            next.is_none_or(|c| !c.is_alphanumeric() && c != '-')
        })
    })
}

/// Reports and training records name the call. A checkpoint is recognised by its parts, because
/// a resumed training must write the same checkpoint as an uninterrupted one.
fn is_json_of(text: &str, called: &str) -> bool {
    let Ok(Value::Object(fields)) = serde_json::from_str(text) else {
        return false;
    };
    let made = fields.get("made").and_then(|made| made.get("command"));
    match made.or_else(|| fields.get("command")) {
        Some(Value::String(command)) => is_call(&format!("; {command}"), called),
        _ => {
            let parts = ["stations", "trainer", "score"];
            called == "pickline train"
                && fields.len() == parts.len()
                && parts.iter().all(|part| fields.contains_key(*part))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_known_and_what_mentions_a_verb_is_not_one() {
        let comment = origin_comment("pickline pattern generate grid\n--seed 2");
        assert_eq!(comment.lines().count(), 1);
        let svg = with_origin("<svg width=\"1\">\n<g/></svg>", "pickline station show");
        let page = with_page_origin("<!doctype html>\n<html>", "pickline compare --html a");
        for (content, verb) in [
            (comment.as_str(), "pattern generate"),
            (
                "# pickline 0.1.0\n# pickline sweep --robots 2\nx\n1\n",
                "sweep",
            ),
            ("# pickline 0.1.0; pickline sweep; station\nx\n1\n", "sweep"),
            ("{\"made\": {\"command\": \"pickline bound\"}}", "bound"),
            ("{\"command\": \"pickline train --out a.onnx\"}", "train"),
            ("{\"score\": 1, \"stations\": [], \"trainer\": 2}", "train"),
            (&svg, "station show"),
            (&page, "compare"),
            (
                "NFG 1 R \"a\" { }\n\n{ }\n\"made by pickline 1: pickline game\"\n",
                "game",
            ),
        ] {
            assert!(is_result_of(content.as_bytes(), verb), "{content}");
            assert!(!is_result_of(content.as_bytes(), "simulate"), "{content}");
        }
        for content in [
            "",
            "id,x,y\na,0,0\n",
            "#!/bin/sh\npickline simulate --html a.html\n",
            "# My notes\npickline 0.1.0; pickline simulate\n",
            "# pickline 0.1.0; pickline simulated\n",
            "{\"command\": \"make; pickline\"}",
            "{\"made\": \"pickline simulate\"}",
            "<html>pickline simulate</html>",
            "<!doctype html>\n<script>{\"command\":\"pickline simulate\"}</script>",
            "<!doctype html>\n<p>\n<!-- made by pickline 0.1.0; pickline simulate -->",
            "<svg><text>; pickline simulate</text></svg>",
            "[belt]\nspeed = 1\n",
        ] {
            assert!(!is_result_of(content.as_bytes(), "simulate"), "{content}");
        }
        assert!(!is_result_of(b"\xff pickline train", "train"));
    }
}
