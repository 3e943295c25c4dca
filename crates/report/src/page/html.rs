//! Text and data inside HTML.

/// `text` without characters that are special in HTML or XML.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
        .replace('\'', "&#39;")
}

/// `page` with its markers replaced, in the order in which they occur. Inserted text is not
/// searched for markers.
pub(crate) fn fill(page: &str, parts: &[(&str, &str)]) -> String {
    let mut filled = String::new();
    let mut rest = page;
    for (marker, content) in parts {
        if let Some((before, after)) = rest.split_once(marker) {
            filled.extend([before, content]);
            rest = after;
        }
    }
    filled + rest
}

/// The same JSON without characters that are special in HTML. They occur only inside strings,
/// where JSON has escapes for them.
pub(crate) fn inert(json: &str) -> String {
    json.replace('<', "\\u003c")
        .replace('>', "\\u003e")
        .replace('&', "\\u0026")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markers_in_what_is_filled_in_stay() {
        let page = fill("1<a>2<b>3", &[("<a>", "[<b>]"), ("<b>", "[<a>]")]);
        assert_eq!(page, "1[<b>]2[<a>]3");
    }

    #[test]
    fn inert_json_means_the_same() {
        let text = "</script><!--<b>\"'&";
        let json = serde_json::to_string(text).unwrap();
        let inert = inert(&json);
        assert!(!inert.contains(['<', '>', '&']));
        assert_eq!(serde_json::from_str::<String>(&inert).unwrap(), text);
    }

    #[test]
    fn escaped_text_has_no_markup() {
        let escaped = escape("<b class=\"a\" id='b'>&</b>");
        assert!(!escaped.contains(['<', '>', '"', '\'']));
        assert_eq!(escape("a & b"), "a &amp; b");
    }
}
