//! MOTChallenge text: `frame,id,left,top,width,height,conf[,class,visibility]` or
//! `[,x,y,z]`.

use super::{Format, Line, Lines, boxed, class, frame, number, track_id};
use crate::pattern::tracking::options::{Boxes, Options};

/// The longest form; whatever follows is passed over.
const FIELDS: usize = 10;
/// Where a class stands, if anywhere, from 0.
const CLASS: usize = 7;

/// The first fields of a line, and how many of all its fields are filled. Commas or
/// semicolons separate where there are any, blanks and tabs elsewhere.
fn split_fields(line: &str) -> (usize, [&str; FIELDS]) {
    let mut fields = [""; FIELDS];
    let mut filled = 0;
    let separator = [',', ';'].into_iter().find(|&c| line.contains(c));
    let all: Box<dyn Iterator<Item = &str>> = match separator {
        Some(separator) => Box::new(line.split(separator).map(str::trim)),
        None => Box::new(line.split_whitespace()),
    };
    for (place, field) in all.enumerate() {
        filled += usize::from(!field.is_empty());
        if let Some(slot) = fields.get_mut(place) {
            *slot = field;
        }
    }
    (filled, fields)
}

/// Whether column 8 holds classes: a whole number in every good line, and nothing that
/// would make it the x of a place in the world, which comes with y and z.
fn has_classes(lines: &[(usize, usize, [&str; FIELDS])]) -> bool {
    let good = |fields: &[&str; FIELDS]| fields[..6].iter().all(|f| f.parse::<f64>().is_ok());
    let whole = |fields: &[&str; FIELDS]| {
        fields[CLASS]
            .parse::<f64>()
            .is_ok_and(|n| n.fract() == 0.0 && (0.0..1e6).contains(&n))
    };
    let alone = |fields: &[&str; FIELDS]| {
        let rest = &fields[CLASS + 1..];
        rest[1].is_empty() || rest.iter().all(|f| f.parse() == Ok(-1.0))
    };
    // The last line may be cut off.
    let but_last = &lines[..lines.len().saturating_sub(1)];
    let mut boxes = but_last
        .iter()
        .map(|line| &line.2)
        .filter(|fields| good(fields))
        .peekable();
    boxes.peek().is_some() && boxes.all(|fields| whole(fields) && alone(fields))
}

pub(super) fn read(text: &str, options: &Options) -> Lines {
    // Without the blank end, the last line that `lines` gives is the last one written.
    let lines: Vec<(usize, usize, [&str; FIELDS])> = text
        .trim_end()
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty())
        .map(|(index, line)| {
            let (filled, fields) = split_fields(line);
            (index + 1, filled, fields)
        })
        .collect();
    let classes = has_classes(&lines);
    let boxes = options.boxes.unwrap_or_default();
    let line = |&(number, filled, ref fields): &(usize, usize, [&str; FIELDS])| Line {
        file: None,
        number,
        filled,
        row: read_box(fields, classes, boxes),
    };
    let remark = classes.then(|| "classes from column 8".to_owned());
    Lines {
        format: Format::Mot,
        boxes,
        lines: lines.iter().map(line).collect(),
        remarks: remark.into_iter().collect(),
        cure: match boxes {
            Boxes::Sizes => {
                "give lines `frame,id,left,top,width,height,conf` with frames from 0 or 1, or one \
                 of the other forms of `pickline pattern import tracks --help`"
            }
            Boxes::Corners => {
                "leave out --boxes corners if the boxes are left,top,width,height, or give \
                 lines `frame,id,left,top,right,bottom,conf`"
            }
            Boxes::Centres => {
                "leave out --boxes centres if the boxes are left,top,width,height, or give \
                 lines `frame,id,xc,yc,width,height,conf`"
            }
        },
    }
}

fn read_box(
    fields: &[&str; FIELDS],
    classes: bool,
    boxes: Boxes,
) -> std::result::Result<super::Row, String> {
    let frame = frame(number(fields[0], "frame")?)?;
    let id = track_id(number(fields[1], "id")?)?;
    let left = number(fields[2], "left")?;
    let top = number(fields[3], "top")?;
    let width = number(fields[4], "width")?;
    let height = number(fields[5], "height")?;
    let mut row = boxed(frame, id, [left, top, width, height], boxes)?;
    if !fields[6].is_empty() {
        row.confidence = Some(number(fields[6], "confidence")?);
    }
    if classes {
        row.class = class(fields[CLASS]);
    }
    Ok(row)
}
