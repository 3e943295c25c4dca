//! Gives the boxes of a recording the names of their classes.

use super::class_names::ClassNames;
use super::formats::FileLines;
use super::listing::named;
use crate::error::{Error, Result, shown};

/// Replaces the class ids of all boxes of `lines` by their `names`; messages call the recording
/// `file`.
///
/// # Errors
/// An id without a name, a class that is a name already, or a recording without classes.
pub(super) fn name_classes(names: &ClassNames, lines: &mut FileLines, file: &str) -> Result<()> {
    let mut unnamed: Vec<String> = Vec::new();
    let mut first = String::new();
    let mut used: Vec<&str> = Vec::new();
    for line in &mut lines.lines {
        let Ok(row) = &mut line.row else { continue };
        // -1 stands for a box without a class.
        let Some(class) = row.class.take().filter(|class| class != "-1") else {
            continue;
        };
        if let Some((id, name)) = names.find(&class) {
            row.class = Some(name.to_owned());
            if !used.contains(&id) {
                used.push(id);
            }
        } else if !unnamed.contains(&class) {
            if unnamed.is_empty() {
                first = match &line.file {
                    Some(part) => format!("{file}/{part}:{}", line.number),
                    None => format!("{file}:{}", line.number),
                };
            }
            unnamed.push(class);
        }
    }
    if let Some(class) = unnamed.first() {
        return Err(without_name(&first, class, &unnamed));
    }
    if used.is_empty() {
        return Err(Error::usage(
            "'class_names'",
            format!("no box of {file} has a class"),
            "leave it out, or give a recording with class ids",
        ));
    }
    let named_ids = used.len();
    lines.remarks.push(format!("{named_ids} class ids named"));
    let idle: Vec<&str> = names.ids().filter(|id| !used.contains(id)).collect();
    if !idle.is_empty() {
        let ids = named(idle.iter().copied());
        lines
            .remarks
            .push(format!("named class ids without a box: {ids}"));
    }
    Ok(())
}

/// The error for the classes `unnamed`, the first of which, `class`, stands at `place`.
fn without_name(place: &str, class: &str, unnamed: &[String]) -> Error {
    if class.parse::<u32>().is_err() {
        return Error::input(
            place,
            format!("class `{}` is a name, not a class id", shown(class)),
            "leave out 'class_names': the classes of this recording have names",
        );
    }
    let all: Vec<String> = unnamed
        .iter()
        .map(|class| shown(class).to_string())
        .collect();
    let more = match all.len() {
        1 => String::new(),
        _ => format!(
            "; without one are {}",
            named(all.iter().map(String::as_str))
        ),
    };
    Error::input(
        place,
        format!("class id {class} has no name{more}"),
        format!("add it to 'class_names', such as {class}:wood"),
    )
}

#[cfg(test)]
mod tests {
    use super::super::class_names::ClassNames;
    use super::super::import::import_text;
    use super::super::options::{ImageAxis, ImportOptions};

    fn options(names: &str) -> ImportOptions {
        with(names.parse().unwrap())
    }

    fn with(names: ClassNames) -> ImportOptions {
        ImportOptions::new(10.0, 0.001, ImageAxis::X, 0.1).with_class_names(names)
    }

    /// Tracks with the class ids 1, 2, none and again 1.
    fn recording() -> String {
        let mut text = String::new();
        for (track, class) in [(1, 1), (2, 2), (3, -1), (4, 1)] {
            for frame in 1..6 {
                let left = 10 * frame + 200 * track;
                text += &format!(
                    "{frame},{track},{left},{},40,20,0.9,{class},1\n",
                    60 * track
                );
            }
        }
        text
    }

    #[test]
    fn class_ids_become_names() {
        let lines = "\u{feff}# of the detector\r\n1: pet\r\n\r\n2: hdpe\r\n";
        for names in [
            "1:pet,2:hdpe".parse().unwrap(),
            " 2 : hdpe , 01:pet ".parse().unwrap(),
            ClassNames::from_lines(lines, "names.txt").unwrap(),
        ] {
            let import = import_text(&recording(), "t.txt", &with(names)).unwrap();
            let items = import.pattern.items().iter();
            let mut classes: Vec<_> = items.map(|i| (&*i.id, i.class.as_deref())).collect();
            classes.sort_unstable();
            let (pet, hdpe) = (Some("pet"), Some("hdpe"));
            let expected = [("1", pet), ("2", hdpe), ("3", None), ("4", pet)];
            assert_eq!(classes, expected);
        }
        // Several ids may be one class, and a name on a line may have commas.
        let names = ClassNames::from_lines("1:PET, clear\n2:PET, clear", "names.txt").unwrap();
        let one = import_text(&recording(), "t.txt", &with(names)).unwrap();
        let is_pet = |item: &&crate::pattern::Item| item.class.as_deref() == Some("PET, clear");
        assert_eq!(one.pattern.items().iter().filter(is_pet).count(), 3);
    }

    #[test]
    fn names_without_boxes_are_told() {
        let import = import_text(&recording(), "t.txt", &options("1:pet,2:hdpe,7:wood")).unwrap();
        let remarks = import.report.remarks;
        assert!(
            remarks.contains(&"2 class ids named".to_owned()),
            "{remarks:?}"
        );
        assert!(
            remarks.contains(&"named class ids without a box: 7".to_owned()),
            "{remarks:?}"
        );
    }

    #[test]
    fn an_id_without_a_name_is_an_error_with_its_line() {
        let error = import_text(&recording(), "t.txt", &options("1:pet")).unwrap_err();
        let message = error.to_string();
        for words in ["t.txt:6", "class id 2 has no name", "such as 2:wood"] {
            assert!(message.contains(words), "{words} not in {message}");
        }
        let text = "frame,tracker_id,x_min,y_min,x_max,y_max,class_name\n1,1,0,0,40,20,PET\n\
                    2,1,10,0,50,20,PET\n";
        let message = import_text(text, "t.csv", &options("1:pet"))
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("class `PET` is a name, not a class id"),
            "{message}"
        );
        let text = recording()
            .replace(",1,1\n", ",-1,1\n")
            .replace(",2,1\n", ",-1,1\n");
        let message = import_text(&text, "t.txt", &options("1:pet"))
            .unwrap_err()
            .to_string();
        assert!(message.contains("no box of t.txt has a class"), "{message}");
    }
}
