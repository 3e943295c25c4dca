//! The file of recorded moves: CSV with a header and one move per line.

use super::timed_move::TimedMove;
use crate::csv_columns::{Columns, KnownColumns, metres, resembles, seconds, unit_factor};
use crate::csv_file::CsvFile;
use crate::error::{Error, Result};
use crate::station::{Station, robot_called};
use csv::StringRecord;
use nalgebra::Point2;

const KNOWN: KnownColumns = KnownColumns {
    names: &[
        "robot",
        "from_x",
        "from_y",
        "meet_x",
        "meet_y",
        "depart_s",
        "grasp_s",
        "bin_x",
        "bin_y",
        "release_s",
    ],
    required: 5,
    find: known_column,
    is_misspelt: |column| resembles(column, KNOWN.names),
    beginning: "start it with the header \
                `robot,from_x,from_y,meet_x,meet_y,depart_s,grasp_s,bin_x,bin_y,release_s`",
    needs: "the header needs robot, from_x, from_y, meet_x and meet_y [m]",
};

/// Indices of the times in [`KNOWN`], and of the places' x, which y follows.
const TIMES: [(usize, &str); 3] = [(5, "depart"), (6, "grasp"), (9, "release")];
const PLACES: [usize; 3] = [1, 3, 7];

/// The moves of a file.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct MovesFile {
    /// The moves, in the order of the file; each has a time.
    pub moves: Vec<TimedMove>,
    /// Number of rows without two times that belong together.
    pub without_times: usize,
    /// Names of the columns that were ignored.
    pub ignored: Vec<String>,
}

/// Parses the text of a file of moves by robots of `station`, in any CSV variant that `CsvFile`
/// accepts; messages call it `name`. Robots are given by name or by number, from 1, upstream first.
/// All columns but the robot and the first two places may be missing, and so may their fields. Names
/// may include a unit: `from_x_mm`, `grasp [ms]`.
///
/// # Errors
/// The first line that cannot be read or whose times run backwards, with the cure.
pub fn read_moves(text: &str, name: &str, station: &Station) -> Result<MovesFile> {
    let mut file = CsvFile::new(text, name);
    let columns = Columns::of(&mut file, &KNOWN)?;
    let mut read = MovesFile::default();
    let mut record = StringRecord::new();
    while let Some(line) = file.next(&mut record)? {
        let row = read_move(&mut file, &record, &columns, station, line)?;
        let has_way_out = row.depart.is_some() && row.grasp.is_some();
        let begins = row.depart.is_some() || row.grasp.is_some();
        let has_way_home = begins && row.release.is_some() && row.bin.is_some();
        if has_way_out || has_way_home {
            read.moves.push(row);
        } else {
            read.without_times += 1;
        }
    }
    if read.moves.is_empty() {
        return Err(Error::input(
            name,
            "no row has two times that belong together",
            "give depart_s and grasp_s, or one of them with release_s, bin_x and bin_y",
        ));
    }
    read.ignored = columns.ignored;
    Ok(read)
}

fn known_column(name: &str) -> Option<(usize, f64)> {
    if let Some(known) = KNOWN.names.iter().position(|&column| column == name) {
        return Some((known, 1.0));
    }
    let times = TIMES.into_iter();
    let mut times = times.filter_map(|(column, quantity)| {
        unit_factor(name, quantity, seconds).map(|factor| (column, factor))
    });
    let places = PLACES.into_iter().flat_map(|column| [column, column + 1]);
    let mut places = places.filter_map(|column| {
        unit_factor(name, KNOWN.names[column], metres).map(|factor| (column, factor))
    });
    times.next().or_else(|| places.next())
}

fn read_move(
    file: &mut CsvFile,
    record: &StringRecord,
    columns: &Columns,
    station: &Station,
    line: usize,
) -> Result<TimedMove> {
    let robot = robot_called(columns.text(record, 0), station);
    let robot = robot.map_err(|no| Error::input(columns.place_of(file, 0), no.problem, no.cure))?;
    let mut number = |column: usize| -> Result<Option<f64>> {
        let value = columns.number(file, record, column)?;
        match value.filter(|value| !value.is_finite()) {
            None => Ok(value),
            Some(value) => Err(Error::input(
                columns.place_of(file, column),
                format!("{value} is not a measured value"),
                "give a number, or leave the field empty",
            )),
        }
    };
    let mut points = [None; 3];
    for (point, x) in points.iter_mut().zip(PLACES) {
        *point = number(x)?
            .zip(number(x + 1)?)
            .map(|(x, y)| Point2::new(x, y));
    }
    let [depart, grasp, release] = [number(5)?, number(6)?, number(9)?];
    let [Some(from), Some(meet), bin] = points else {
        let missing = if points[0].is_none() { 1 } else { 3 };
        let place = columns.place_of(file, missing);
        return Err(Error::input(
            place,
            "the place is not complete",
            "give x and y in metres",
        ));
    };
    let known = [
        (depart, "depart_s"),
        (grasp, "grasp_s"),
        (release, "release_s"),
    ];
    let known = known
        .into_iter()
        .filter_map(|(time, name)| Some((time?, name)));
    for pair in known.collect::<Vec<_>>().windows(2) {
        let [(earlier, first), (later, second)] = [pair[0], pair[1]];
        if later < earlier {
            return Err(Error::input(
                format!("{}:{line}: {second}", file.name()),
                format!("{later} s is before {first}, {earlier} s"),
                "correct the times, or leave the line out",
            ));
        }
    }
    Ok(TimedMove {
        depart,
        grasp,
        bin,
        release,
        ..TimedMove::new(robot, line as u64, from, meet)
    })
}
