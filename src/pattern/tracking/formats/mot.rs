//! MOTChallenge text: `frame,id,left,top,width,height,conf[,class,visibility]` or `[,x,y,z]`.

use super::fields::{boxed, class, frame, number, track_id};
use super::format::Format;
use super::lines::{FileLine, FileLines, FileRow};
use crate::error::{Error, Result};
use crate::pattern::tracking::options::{Boxes, ImportOptions};

/// Number of fields in the longest form; further fields are ignored.
const FIELDS: usize = 10;
/// Index of the class, if there is one, from 0.
const CLASS: usize = 7;

/// The first fields of a line, and how many of all its fields are filled. The separators are commas
/// or semicolons if there are any, otherwise spaces and tabs.
fn split_fields(line: &str) -> (usize, [&str; FIELDS]) {
    let mut fields = [""; FIELDS];
    let mut filled = 0;
    let separator = [';', ','].into_iter().find(|&c| line.contains(c));
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

/// The content of column 8.
#[derive(Clone, Copy, PartialEq)]
enum Eighth {
    /// Empty, or always -1.
    Nothing,
    Classes,
    /// Something else, with the reason why it is not a class.
    Other(&'static str),
}

/// Determines the content of column 8 from the form of most lines. Classes are whole numbers or
/// names, and -1 means none. The x of a world position, which is followed by y and z, is not a
/// class.
fn eighth(lines: &[(usize, usize, [&str; FIELDS])]) -> Eighth {
    let good = |fields: &&[&str; FIELDS]| fields[..6].iter().all(|f| f.parse::<f64>().is_ok());
    // The last line may be incomplete.
    let but_last = match lines {
        [one] => std::slice::from_ref(one),
        more => &more[..more.len().saturating_sub(1)],
    };
    let (mut classes, mut others, mut places) = (0_usize, 0_usize, 0_usize);
    for fields in but_last.iter().map(|line| &line.2).filter(good) {
        match fields[CLASS].parse::<f64>() {
            _ if fields[CLASS].is_empty() => continue,
            Ok(-1.0) => continue,
            Ok(number) if number.fract() == 0.0 && (0.0..1e6).contains(&number) => classes += 1,
            Ok(_) => others += 1,
            Err(_) => {
                classes += 1;
                continue;
            }
        }
        // A visibility is a fraction; a y rarely is throughout a recording.
        let rest = |place: usize| fields[CLASS + place].parse::<f64>();
        if let (Ok(y), Ok(z)) = (rest(1), rest(2)) {
            places += usize::from(!(0.0..=1.0).contains(&y) && (y != -1.0 || z != -1.0));
        }
    }
    match classes + others {
        0 => Eighth::Nothing,
        all if others * 2 > all => Eighth::Other("it contains fractions, as a world position does"),
        all if places * 2 > all => Eighth::Other("columns 9 and 10 make it a world position"),
        _ => Eighth::Classes,
    }
}

/// Whether the numbers have decimal commas: fields are separated by semicolons, spaces or tabs, no
/// number has a point, and every field is a number after replacing its comma.
fn has_decimal_commas(text: &str) -> bool {
    /// Number of lines to examine.
    const SAMPLE: usize = 200;
    let mut lines = text.lines().filter(|line| !line.trim().is_empty());
    let whole = lines.by_ref().take(SAMPLE).collect::<Vec<_>>();
    let is_number =
        |field: &str| !field.ends_with(',') && field.replacen(',', ".", 1).parse::<f64>().is_ok();
    let fits = |line: &&&str| {
        let fields: Vec<&str> = match line.contains(';') {
            true => line.split(';').map(str::trim).collect(),
            false => line.split_whitespace().collect(),
        };
        fields.len() >= 6 && fields[..6].iter().all(|field| is_number(field))
    };
    let some = whole.iter().any(|line| line.contains(','));
    // The last line may be incomplete.
    some && !text.contains('.') && whole.iter().filter(fits).count() + 1 >= whole.len().max(2)
}

/// Rejects a file whose first two columns are id and frame instead of frame and id. Read as frame
/// and id, every track would consist of the boxes of one image, which are far apart, while boxes
/// with the same number in column 1 belong to one object, which moves little by little.
fn refuse_swapped(lines: &[FileLine], name: &str) -> Result<()> {
    /// Minimum ratio of the two distances between boxes.
    const APART: f64 = 4.0;
    /// Minimum number of pairs of boxes for a conclusion.
    const LEAST: usize = 20;
    let rows: Vec<(i64, i64, f64, f64)> = lines
        .iter()
        .filter_map(|line| {
            let row = line.row.as_ref().ok()?;
            let (width, height) = row.size.unwrap_or_default();
            let centre = (row.left + width / 2.0, row.top + height / 2.0);
            Some((i64::from(row.frame), row.id?, centre.0, centre.1))
        })
        .collect();
    let step = |frame_first: bool, quantile: f64| {
        let mut rows: Vec<(i64, i64, f64, f64)> = match frame_first {
            true => rows.iter().map(|&(f, id, x, y)| (id, f, x, y)).collect(),
            false => rows.clone(),
        };
        rows.sort_by_key(|&(id, frame, ..)| (id, frame));
        let pairs = rows.windows(2).filter(|pair| pair[0].0 == pair[1].0);
        let mut steps: Vec<f64> = pairs
            .map(|pair| (pair[1].2 - pair[0].2).hypot(pair[1].3 - pair[0].3))
            .collect();
        steps.sort_by(f64::total_cmp);
        (steps.len() >= LEAST).then(|| steps[(steps.len() as f64 * quantile) as usize])
    };
    // Items detected twice put many boxes of one image close together, but not most.
    match step(true, 0.5).zip(step(false, 0.8)) {
        Some((as_said, swapped)) if swapped > 0.0 && as_said > APART * swapped => {
            Err(Error::input(
                name,
                format!(
                    "the first two columns seem to be id and frame, not frame and id: boxes with \
                 the same number in column 2 are {as_said:.0} pixels apart (median), those with \
                 the same number in column 1 mostly less than {swapped:.0}"
                ),
                "write the frame into column 1 and the track's id into column 2",
            ))
        }
        _ => Ok(()),
    }
}

pub(super) fn read(text: &str, name: &str, options: &ImportOptions) -> Result<FileLines> {
    let mut remarks = Vec::new();
    let points;
    let text = if has_decimal_commas(text) {
        remarks.push("numbers with decimal commas".to_owned());
        points = text.replace(',', ".");
        &points
    } else {
        text
    };
    // Without trailing whitespace, so that the last line is the last one that was written.
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
    let eighth = eighth(&lines);
    let boxes = options.boxes.unwrap_or_default();
    let line = |&(number, filled, ref fields): &(usize, usize, [&str; FIELDS])| FileLine {
        file: None,
        number,
        filled,
        row: read_box(fields, eighth == Eighth::Classes, boxes),
    };
    let lines: Vec<FileLine> = lines.iter().map(line).collect();
    refuse_swapped(&lines, name)?;
    match eighth {
        Eighth::Nothing => {}
        Eighth::Classes => remarks.push("classes from column 8".to_owned()),
        Eighth::Other(cause) => {
            remarks.push(format!("column 8 is not a class: {cause}"));
        }
    }
    Ok(FileLines {
        format: Format::Mot,
        boxes,
        lines,
        remarks,
        cure: match boxes {
            Boxes::Sizes => {
                "give lines `frame,id,left,top,width,height,conf` with frames from 0 or 1, or one \
                 of the other formats of `pickline help pattern import tracks`"
            }
            Boxes::Corners => {
                "omit 'boxes' corners if the boxes are left,top,width,height, or give \
                 lines `frame,id,left,top,right,bottom,conf`"
            }
            Boxes::Centres => {
                "omit 'boxes' centres if the boxes are left,top,width,height, or give \
                 lines `frame,id,xc,yc,width,height,conf`"
            }
        },
    })
}

fn read_box(
    fields: &[&str; FIELDS],
    classes: bool,
    boxes: Boxes,
) -> std::result::Result<FileRow, String> {
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
        // -1 means no class, and fractions between classes are ignored.
        row.class = class(fields[CLASS]).filter(|class| {
            class
                .parse::<f64>()
                .map_or(true, |number| number.fract() == 0.0 && number >= 0.0)
        });
    }
    Ok(row)
}
