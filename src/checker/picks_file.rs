//! The file of a run: CSV with a header and one attempt per line, as this or another program wrote
//! it.

use crate::csv_columns::{Columns, KnownColumns, metres, resembles, seconds, unit_factor};
use crate::csv_file::CsvFile;
use crate::decision::{FailureCause, Pick};
use crate::error::{Error, Result, known_names, nearest, shown};
use crate::pattern::Pattern;
use crate::station::{Robot, Station, robot_called};
use csv::StringRecord;
use nalgebra::Point2;
use std::collections::HashMap;

const ROBOT: usize = 0;
const ITEM: usize = 1;
const DECIDE: usize = 2;
const BIN: usize = 5;
const FAILURE: usize = 6;
const MEET_X: usize = 7;
const MEET_Y: usize = 8;

const KNOWN: KnownColumns = KnownColumns {
    names: &[
        "robot",
        "item",
        "decide_s",
        "grasp_s",
        "release_s",
        "bin",
        "failure",
        "meet_x_m",
        "meet_y_m",
    ],
    required: 5,
    find: known_column,
    is_misspelt: |column| resembles(column, KNOWN.names),
    beginning: "start it with the header `robot,item,decide_s,grasp_s,release_s,bin`; `pickline \
                simulate` writes one as picks.csv",
    needs: "the header needs robot, item, decide_s, grasp_s and release_s",
};

/// Where an item is met that does not exist, if the file does not say it.
const NOWHERE: Point2<f64> = Point2::new(f64::NAN, f64::NAN);

/// The attempts of a file.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct PicksFile {
    /// The attempts in the order of the file; those that failed with the cause. A robot, an item or a
    /// bin that does not exist has an index that is out of range.
    pub attempts: Vec<(Pick, Option<FailureCause>)>,
    /// The line of each attempt.
    pub lines: Vec<usize>,
    /// The robots, items and bins that do not exist.
    pub unknown: Vec<UnknownRow>,
    /// Names of the columns that were ignored.
    pub ignored: Vec<String>,
}

/// A row that names what does not exist.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct UnknownRow {
    /// Its line.
    pub line: usize,
    /// The robot, as written.
    pub robot: String,
    /// The item, as written.
    pub item: String,
    /// What is unknown, and what would be right.
    pub problem: String,
}

/// Parses the text of a file of picks by `station` from `pattern`, in any CSV variant that
/// `CsvFile` accepts; messages call it `name`. Columns are found by name and may be in any order.
/// The robot is given by name or by number, from 1, upstream first; the item by id; the bin by name,
/// and if it is not given it is the one that the item's class goes into. Times may include a unit:
/// `grasp_ms`. A failed attempt has its cause in `failure`: `grasp` or `out_of_reach`. Where the item
/// was met follows from its position at the grasp, unless `meet_x_m` and `meet_y_m` say it.
///
/// # Errors
/// The first line that cannot be read, with the cure; a file of which no item is in the pattern.
pub fn read_picks(
    text: &str,
    name: &str,
    station: &Station,
    pattern: &Pattern,
) -> Result<PicksFile> {
    let mut file = CsvFile::new(text, name);
    let columns = Columns::of(&mut file, &KNOWN)?;
    let items = pattern.items().iter().enumerate();
    let line_up = LineUp {
        station,
        pattern,
        numbers: items
            .map(|(index, item)| (item.id.as_str(), index))
            .collect(),
    };
    let mut read = PicksFile::default();
    let mut record = StringRecord::new();
    let mut strange = 0;
    while let Some(line) = file.next(&mut record)? {
        let row = PickRow::of(&mut file, &record, &columns)?;
        strange += usize::from(!line_up.numbers.contains_key(row.item));
        let (attempt, problems) = line_up.attempt(&row, &file, &columns)?;
        read.attempts.push(attempt);
        read.lines.push(line);
        read.unknown
            .extend(problems.into_iter().map(|problem| UnknownRow {
                line,
                robot: shown(row.robot),
                item: shown(row.item),
                problem,
            }));
    }
    if strange > 0 && strange == read.attempts.len() {
        return Err(Error::input(
            name,
            "none of its items is in the pattern",
            "give the pattern that these items were picked from",
        ));
    }
    read.ignored = columns.ignored;
    Ok(read)
}

fn known_column(name: &str) -> Option<(usize, f64)> {
    if let Some(known) = KNOWN.names.iter().position(|&column| column == name) {
        return Some((known, 1.0));
    }
    let times = ["decide", "grasp", "release"].iter().enumerate();
    let mut times = times.filter_map(|(place, quantity)| {
        unit_factor(name, quantity, seconds).map(|factor| (DECIDE + place, factor))
    });
    let places = [("meet_x", MEET_X), ("meet_y", MEET_Y)].into_iter();
    let mut places = places.filter_map(|(quantity, column)| {
        unit_factor(name, quantity, metres).map(|factor| (column, factor))
    });
    times.next().or_else(|| places.next())
}

/// One row, before its names are looked up.
struct PickRow<'r> {
    robot: &'r str,
    item: &'r str,
    bin: &'r str,
    failure: &'r str,
    /// When it was decided, the grasp began, and the item was in the bin [s].
    times: [f64; 3],
    /// Where the item was met, if the file says it [m].
    meet: Option<Point2<f64>>,
}

impl<'r> PickRow<'r> {
    fn of(file: &mut CsvFile, record: &'r StringRecord, columns: &Columns) -> Result<Self> {
        let mut number = |column: usize| columns.number(file, record, column);
        let times = [number(DECIDE)?, number(DECIDE + 1)?, number(DECIDE + 2)?];
        let meet = (number(MEET_X)?, number(MEET_Y)?);
        for (place, time) in times.iter().enumerate() {
            if !time.is_some_and(f64::is_finite) {
                let problem = match time {
                    None => "the field is empty".to_owned(),
                    Some(time) => format!("{time} is not a time"),
                };
                let place = columns.place_of(file, DECIDE + place);
                return Err(Error::input(place, problem, "give seconds, such as 7.25"));
            }
        }
        for (column, at) in [(MEET_X, meet.0), (MEET_Y, meet.1)] {
            if let Some(at) = at.filter(|at| !at.is_finite()) {
                return Err(Error::input(
                    columns.place_of(file, column),
                    format!("{at} is not a position"),
                    "give metres, such as 1.25, or leave the field empty",
                ));
            }
        }
        Ok(Self {
            robot: columns.text(record, ROBOT),
            item: columns.text(record, ITEM),
            bin: columns.text(record, BIN),
            failure: columns.text(record, FAILURE),
            times: times.map(Option::unwrap_or_default),
            meet: meet.0.zip(meet.1).map(|(x, y)| Point2::new(x, y)),
        })
    }
}

/// What the names in a file refer to.
struct LineUp<'a> {
    station: &'a Station,
    pattern: &'a Pattern,
    /// The index of each item, by its id.
    numbers: HashMap<&'a str, usize>,
}

type Attempted = (Pick, Option<FailureCause>);

impl LineUp<'_> {
    /// The attempt of a row, and what it names that does not exist.
    ///
    /// # Errors
    /// A failure that is none, or that lacks a place.
    fn attempt(
        &self,
        row: &PickRow,
        file: &CsvFile,
        columns: &Columns,
    ) -> Result<(Attempted, Vec<String>)> {
        let cause = cause_of(row, file, columns)?;
        let mut problems = Vec::new();
        let mut known = |result: std::result::Result<usize, String>| {
            result.map_err(|problem| problems.push(problem)).ok()
        };
        let robot = robot_called(row.robot, self.station);
        let robot = known(robot.map_err(|no| format!("{}; {}", no.problem, no.cure)));
        let item = known(self.item(row.item));
        let it = item.map(|item| &self.pattern.items()[item]);
        let bin = robot.and_then(|robot| {
            let robot = &self.station.robots()[robot];
            let class = it.and_then(|it| it.class.as_deref());
            known(bin_called(robot, class, row.bin))
        });
        let [decide, grasp, release] = row.times;
        let belt = self.station.belt();
        let at_grasp = it.map(|it| Point2::new(it.x0 + belt.speed * grasp, it.y));
        let pick = Pick {
            robot: robot.unwrap_or(usize::MAX),
            item: item
                .and_then(|item| item.try_into().ok())
                .unwrap_or(u32::MAX),
            bin: bin.and_then(|bin| bin.try_into().ok()).unwrap_or(u16::MAX),
            decide,
            grasp,
            release,
            meet: row.meet.or(at_grasp).unwrap_or(NOWHERE),
        };
        Ok(((pick, cause), problems))
    }

    fn item(&self, text: &str) -> std::result::Result<usize, String> {
        let unknown = || format!("there is no item `{}` in the pattern", shown(text));
        self.numbers.get(text).copied().ok_or_else(unknown)
    }
}

/// The index of the robot's bin with this name; without a name, of the one for this class.
fn bin_called(
    robot: &Robot,
    class: Option<&str>,
    text: &str,
) -> std::result::Result<usize, String> {
    if text.is_empty() {
        // The checker says what is wrong with an item that goes into no bin.
        return Ok(robot.bin_for(class).unwrap_or_default());
    }
    let named = robot.bins.iter().position(|bin| bin.name == text);
    named.ok_or_else(|| {
        let names: Vec<&str> = robot.bins.iter().map(|bin| bin.name.as_str()).collect();
        format!(
            "there is no bin `{}`; {}",
            shown(text),
            known_bins(text, &names)
        )
    })
}

/// The failure of a row; `None` for a pick.
fn cause_of(row: &PickRow, file: &CsvFile, columns: &Columns) -> Result<Option<FailureCause>> {
    let cause = match row.failure {
        "" => return Ok(None),
        text => FailureCause::named(text),
    };
    let wrong =
        |problem: String, cure: &str| Error::input(columns.place_of(file, FAILURE), problem, cure);
    match cause {
        None => Err(wrong(
            format!("unknown failure `{}`", shown(row.failure)),
            "write grasp or out_of_reach, or nothing for a pick",
        )),
        Some(FailureCause::OutOfReach) if row.meet.is_none() => Err(wrong(
            "it is not known where the robot went to".into(),
            "give meet_x_m and meet_y_m, where the item was expected [m]",
        )),
        Some(cause) => Ok(Some(cause)),
    }
}

/// The bins that there are, and which of them was probably meant.
fn known_bins(text: &str, names: &[&str]) -> String {
    match nearest(text, names.iter().copied()) {
        Some(_) => known_names(text, names),
        None => format!("known: {}", names.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern;
    use crate::station::built_in;

    fn read(text: &str) -> Result<PicksFile> {
        let station = built_in("paper").unwrap().station(None).unwrap();
        let pattern = pattern::parse("id,x,y\na,0,0.1\nb,-1,0\n", "p").unwrap();
        read_picks(text, "t", &station, &pattern)
    }

    #[test]
    fn other_programs_may_have_written_it() {
        let plain = read("robot,item,decide_s,grasp_s,release_s\nr1,a,1.5,2,3.25\n").unwrap();
        let (pick, cause) = plain.attempts[0];
        assert_eq!((pick.robot, pick.bin, cause), (0, 0, None));
        assert_eq!((pick.decide, pick.grasp, pick.release), (1.5, 2.0, 3.25));
        assert_eq!(plain.lines, [2]);
        for text in [
            "# from the controller\nitem;release_s;robot;grasp_s;decide_s;note\na;3,25;1;2,0;1,5;x\n",
            "Robot\tItem\tDecide [ms]\tGrasp_ms\trelease\tbin\n1\ta\t1500\t2000\t3.25\tb1\n",
        ] {
            let read = read(text).unwrap();
            assert_eq!(read.attempts, plain.attempts, "{text}");
        }
    }

    #[test]
    fn what_is_unknown_is_listed_with_what_would_be_right() {
        let text = "robot,item,decide_s,grasp_s,release_s,bin\nr1,a,1,2,3,\nr9,a,1,2,3,\n0,a,1,2,3,\n\
                    r1,c,1,2,3,\nr1,a,1,2,3,b2\n";
        let read = read(text).unwrap();
        // They are attempts nevertheless: a robot that took them was busy.
        assert_eq!(read.attempts.len(), 5);
        let found: Vec<_> = read
            .unknown
            .iter()
            .map(|row| (row.line, row.problem.as_str()))
            .collect();
        for ((line, problem), (at, words)) in found.into_iter().zip([
            (3, "no robot `r9`; did you mean `r1`? known: r1, r2"),
            (4, "no robot `0`; robots are counted from 1 to 2"),
            (5, "no item `c`"),
            (6, "no bin `b2`; did you mean `b1`?"),
        ]) {
            assert_eq!(line, at);
            assert!(problem.contains(words), "{problem}");
        }
    }

    #[test]
    fn messages_name_line_and_column() {
        let header = "robot,item,decide_s,grasp_s,release_s,failure\n";
        for (text, words) in [
            (String::new(), &["t: ", "empty", "robot,item"][..]),
            (
                "robot,item,decide_s,grasp_s\n".into(),
                &["t:1", "`release_s` is missing"],
            ),
            (
                "robot,item,decide_s,grasp_s,relaese_s\n".into(),
                &["t:1: column 5", "did you mean `release_s`"],
            ),
            (
                format!("{header}r1,a,1,x,3,\n"),
                &["t:2: grasp_s", "`x` is not a number"],
            ),
            (
                format!("{header}r1,a,1,,3,\n"),
                &["t:2: grasp_s", "the field is empty"],
            ),
            (
                format!("{header}r1,a,1,nan,3,\n"),
                &["t:2: grasp_s", "NaN is not a time"],
            ),
            (
                "robot,item,decide_s,grasp_s,release_s,meet_x_m,meet_y_m\nr1,a,1,2,3,nan,0\n"
                    .into(),
                &["t:2: meet_x_m", "NaN is not a position"],
            ),
            (
                "robot,item,decide_s,grasp_s,release_s,meet_x_m,meet_y_m\nr1,a,1,2,3,,-inf\n"
                    .into(),
                &["t:2: meet_y_m", "-inf is not a position"],
            ),
            (
                format!("{header}r1,a,1,2,3,lost\n"),
                &["t:2: failure", "`lost`", "write grasp"],
            ),
            (
                format!("{header}r1,a,1,2,3,out_of_reach\n"),
                &["t:2: failure", "give meet_x_m"],
            ),
            (
                format!("{header}r1,x,1,2,3,\nr2,y,1,2,3,\n"),
                &["t: none of its items is in the pattern"],
            ),
        ] {
            let message = read(&text).unwrap_err().to_string();
            for word in words {
                assert!(message.contains(word), "{word} not in {message}");
            }
        }
    }
}
