//! Recognises the format of a file by its content.

use super::format::Format;

/// Recognises known but unsupported formats; returns the name and the cure.
pub(super) fn unread(text: &str) -> Option<(&'static str, &'static str)> {
    const XML: &str = "export MOT 1.1, COCO 1.0 or YOLO labels instead";
    if text.trim_start().starts_with('<') {
        return Some(match text {
            _ if text.contains("<annotations") => ("CVAT's XML", XML),
            _ if text.contains("<annotation>") => ("Pascal VOC's XML", XML),
            _ => ("XML", XML),
        });
    }
    let line = text.lines().find(|line| !line.trim().is_empty())?;
    let fields: Vec<&str> = line.split_whitespace().collect();
    let numbers = |range: std::ops::Range<usize>| {
        let mut range = range;
        range.all(|place| fields[place].parse::<f64>().is_ok())
    };
    let is_name = |place: usize| fields[place].starts_with(char::is_alphabetic);
    match fields.len() {
        17 | 18 if numbers(0..2) && is_name(2) && numbers(3..17) => Some((
            "KITTI's tracking labels",
            "write lines `frame,id,left,top,width,height,conf`: columns 1 and 2, the corners in \
             columns 7 to 10 (or give the corners and 'boxes' corners) and column 18",
        )),
        15 | 16 if is_name(0) && numbers(1..15) => Some((
            "KITTI's object labels",
            "they contain no frame; write lines `frame,id,left,top,width,height,conf` with id -1",
        )),
        _ => None,
    }
}

/// The format of `text`; MOT if nothing suggests another one.
pub(super) fn recognise(text: &str) -> Format {
    /// Number of lines to examine.
    const SAMPLE: usize = 200;
    if text.trim_start().starts_with(['[', '{']) {
        return Format::Coco;
    }
    let mut lines = text
        .lines()
        .filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
    if lines.clone().next().is_some_and(is_header) {
        return Format::Table;
    }
    let sample: Vec<Vec<&str>> = lines
        .by_ref()
        .take(SAMPLE)
        .map(|line| line.split_whitespace().collect())
        .collect();
    let shares = |from: usize, to: usize, least: usize, most: usize| {
        let share = |field: &&str| {
            field
                .parse::<f64>()
                .is_ok_and(|value| (0.0..=1.0).contains(&value))
        };
        let fits = |fields: &&Vec<&str>| {
            (least..=most).contains(&fields.len()) && fields[from..to].iter().all(share)
        };
        let count = sample.iter().filter(fits).count();
        // The last line may be incomplete.
        count > 0 && count + 1 >= sample.len()
    };
    if shares(2, 8, 8, 8) {
        Format::Yolo
    } else if shares(1, 5, 5, 7) {
        Format::Ultralytics
    } else {
        Format::Mot
    }
}

/// Whether a line contains names instead of numbers. It takes two of them, so that a single broken
/// number is not mistaken for a header.
fn is_header(line: &str) -> bool {
    let fields = line.split([',', ';', '\t']);
    let is_name = |field: &&str| {
        let field = field.trim().trim_matches('"');
        field.starts_with(|c: char| c.is_alphabetic()) && field.parse::<f64>().is_err()
    };
    fields.filter(is_name).count() > 1
}

/// What `text`, which is not a pattern, seems to be a recording of; `None` if this is uncertain.
pub(crate) fn recognised(text: &str) -> Option<String> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let format = recognise(text);
    let found = match format {
        Format::Coco => text.contains("\"bbox\""),
        Format::Table => {
            let header = text.lines().next().unwrap_or_default().to_lowercase();
            ["bb_left", "x_min", "xmin", "tracker_id", "track_id"]
                .iter()
                .any(|name| header.contains(name))
        }
        Format::Mot => {
            let first = text.lines().next().unwrap_or_default();
            let fields: Vec<&str> = match first.contains(';') {
                true => first.split(';').collect(),
                false => first.split([',', ' ', '\t']).collect(),
            };
            let number = |field: &&str| field.trim().replace(',', ".").parse().ok();
            let numbers: Option<Vec<f64>> = fields.iter().map(number).collect();
            numbers.is_some_and(|numbers| (6..=10).contains(&numbers.len()))
        }
        Format::Ultralytics | Format::Yolo => true,
    };
    found.then(|| format.to_string())
}

#[cfg(test)]
mod tests {
    use super::super::format::FORMATS;
    use super::*;

    #[test]
    fn forms_are_recognised_by_what_is_in_them() {
        for (text, format) in [
            ("1,1,10,20,4,6,0.5\n", Format::Mot),
            ("1 7 10 20 4 6 0.5\n2 7 20 20 4 6 0.5", Format::Mot),
            ("0,1,1,1,1,1,1\n", Format::Mot),
            ("", Format::Mot),
            ("frame,id,bb_left,bb_top\n1,1,1,1\n", Format::Table),
            ("x_min;y_min;x_max\n1;1;1\n", Format::Table),
            (
                "0 0.21 0.77 0.02 0.1\n1 0.2 0.7 0.02 0.1\n",
                Format::Ultralytics,
            ),
            ("0 0.21 0.77 0.02 0.1 0.9 3\n0 0.2\n", Format::Ultralytics),
            ("1 0 0.2 0.7 0.23 0.8 0.21 0.77\n", Format::Yolo),
            (" [{\"image_id\": 1}]", Format::Coco),
        ] {
            assert_eq!(recognise(text), format, "{text}");
        }
        for (format, name, _) in FORMATS {
            assert_eq!(name.parse::<Format>().unwrap(), format);
        }
        assert!(
            "mott"
                .parse::<Format>()
                .unwrap_err()
                .to_string()
                .contains("`mot`")
        );
    }

    #[test]
    fn patterns_are_taken_for_no_recordings() {
        for text in ["id,x,y\na,0,0\n", "name,a\n", "1,2,3\n", "[belt]\n", ""] {
            assert_eq!(recognised(text), None, "{text}");
        }
        assert!(recognised("1,1,10,20,4,6,0.5,-1,-1,-1\n").is_some());
        assert!(recognised("frame,id,bb_left,x,y\n").is_some());
    }
}
