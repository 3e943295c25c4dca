//! The station file: TOML with SI units. Unknown keys are errors.

use super::arm_keys;
use super::belt::Belt;
use super::class::ItemClass;
use super::geometry::Station;
use super::line::{Line, LineBins};
use super::robot::{Bin, Robot, default_bin_name};
use crate::error::{Error, Result};
use crate::setters::setters;
use crate::toml_file::{File, Section};

/// The settings of [`Overrides`], as the places of errors.
pub(super) const BELT_SPEED: &str = "'belt_speed'";
pub(super) const ROBOTS: &str = "'robots'";

/// The strategy in the `strategy` key of a station file.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct SavedStrategy {
    /// The strategy as it is written, for example `rules:SPT,FIFO`.
    pub text: String,
    /// Where it was found, for messages.
    pub place: String,
}

/// Values that replace those of a station file or of a built-in station; none by default.
#[derive(Debug, Clone, Copy, Default)]
#[non_exhaustive]
pub struct Overrides {
    /// The number of identical robots on the line; `None` for as many as the station has.
    pub robots: Option<usize>,
    /// The speed of the belt [m/s]; `None` for the station's.
    pub belt_speed: Option<f64>,
}

setters!(Overrides {
    /// With this number of identical robots, or the station's.
    fn with_robots(robots: impl Into<Option<usize>>);
    /// With this speed of the belt [m/s], or the station's.
    fn with_belt_speed(belt_speed: impl Into<Option<f64>>);
});

/// Parses a station file; messages call it `name`.
///
/// # Errors
/// The first problem, with its line and key, the value found and the cure.
pub fn parse(text: &str, name: &str, overrides: Overrides) -> Result<Station> {
    parse_with_strategy(text, name, overrides).map(|(station, _)| station)
}

/// Like [`parse`], but also returns the strategy that the file names.
///
/// # Errors
/// See [`parse`].
pub fn parse_with_strategy(
    text: &str,
    name: &str,
    overrides: Overrides,
) -> Result<(Station, Option<SavedStrategy>)> {
    let file = File::new(name, text, "the output of `pickline station init`");
    file.read(|root| {
        let station = read(root, overrides)?;
        let Some(value) = root.table.get("strategy") else {
            return Ok((station, None));
        };
        file.remember("strategy", value);
        let saved = SavedStrategy {
            text: root.text("strategy")?,
            place: file.place("strategy"),
        };
        Ok((station, Some(saved)))
    })
}

fn read(root: &Section, overrides: Overrides) -> Result<Station> {
    read_checked(root, overrides).map_err(|error| {
        let is_override = matches!(error.place(), Some(BELT_SPEED | ROBOTS));
        match is_override {
            true => error.into_usage(),
            false => error,
        }
    })
}

fn read_checked(root: &Section, overrides: Overrides) -> Result<Station> {
    let file = root.file;
    root.only(&["strategy", "belt", "robot", "line", "class"])?;
    let place = |key: &str| match (key, overrides.belt_speed, overrides.robots) {
        ("belt.speed", Some(_), _) => BELT_SPEED.to_owned(),
        ("robot", _, Some(_)) => ROBOTS.to_owned(),
        _ => file.place(key),
    };
    let (belt, robots) = read_station(root, overrides, &place)?;
    let classes = read_classes(root)?;
    // If the belt speed was given beside the file, the file itself may be right.
    let too_slow = overrides.belt_speed.map(|_| BELT_SPEED);
    Station::checked(belt, robots, classes, &place, too_slow)
}

fn read_station(
    root: &Section,
    overrides: Overrides,
    place: &dyn Fn(&str) -> String,
) -> Result<(Belt, Vec<Robot>)> {
    let belt = root.section("belt")?;
    belt.only(&["speed", "length", "width"])?;
    let speed = match (belt.optional("speed")?, overrides.belt_speed) {
        (_, Some(speed)) => speed,
        (Some(speed), None) => speed,
        (None, None) => return Err(belt.missing("speed")),
    };
    let length = belt.optional("length")?;
    let width = belt.number("width")?;
    let (robots, length) = match (root.table.get("robot"), root.table.get("line")) {
        (Some(_), None) => {
            if overrides.robots.is_some() {
                return Err(Error::usage(
                    ROBOTS,
                    format!("`{}` lists its robots one by one", root.file.name),
                    "drop the flag, or describe identical robots with a [line] table",
                ));
            }
            let robots = read_robots(root)?;
            (robots, length.ok_or_else(|| belt.missing("length"))?)
        }
        (None, Some(_)) => {
            let line = read_line(&root.section("line")?, overrides)?;
            line.check(place)?;
            // Errors in derived values are reported at the keys of the line.
            for i in 0..line.robots {
                alias_to_line(root.file, i, &line);
            }
            if length.is_none() {
                root.file.alias("belt.length", "line");
            }
            let length = length.unwrap_or_else(|| line.belt_length());
            (line.place(width), length)
        }
        (Some(_), Some(_)) => {
            return Err(root.wrong(
                "line",
                "the file has both [[robot]] and [line]".into(),
                "keep one of them".into(),
            ));
        }
        (None, None) => {
            return Err(Error::input(
                root.file.name,
                "the file has no robots",
                "add [[robot]] tables, or a [line] table for identical robots",
            ));
        }
    };
    let belt = Belt {
        speed,
        length,
        width,
    };
    Ok((belt, robots))
}

/// Lets errors in robot `index` of a line name the keys of the line.
fn alias_to_line(file: &File, index: usize, line: &Line) {
    let robot = format!("robot[{index}]");
    for key in arm_keys::KEYS {
        file.alias(&format!("{robot}.{key}"), &format!("line.{key}"));
    }
    file.alias(&format!("{robot}.rest"), "line.rest");
    file.alias(&format!("{robot}.base"), "line");
    file.alias(&format!("{robot}.bin"), "line");
    file.alias(&format!("{robot}.bin[0].at"), "line");
    file.alias(&format!("{robot}.bin[0].release_time"), "line.release_time");
    if let LineBins::AtBase(bins) = &line.bins {
        for bin in 0..bins.len() {
            let keys = [("at", "offset")]
                .into_iter()
                .chain(BIN_KEYS.map(|key| (key, key)));
            for (key, of_line) in keys {
                file.alias(
                    &format!("{robot}.bin[{bin}].{key}"),
                    &format!("line.bin[{bin}].{of_line}"),
                );
            }
        }
    }
}

/// The keys of a bin beside its position.
const BIN_KEYS: [&str; 3] = ["name", "classes", "release_time"];

fn read_robots(root: &Section) -> Result<Vec<Robot>> {
    let mut list = Vec::new();
    for robot in root.tables("robot")? {
        let place = ["name", "base", "bin", "reach"];
        let times = ["grasp_time", "release_time", "rest"];
        robot.only(&[&place[..], &arm_keys::KEYS[..], &times[..]].concat())?;
        let release_time = robot.number("release_time")?;
        let bins = if robot.has_tables("bin") {
            read_bins(&robot, "at", release_time)?
        } else {
            let key = |key: &str| format!("{}.{key}", robot.path);
            robot.file.alias(&key("bin[0].at"), &key("bin"));
            robot
                .file
                .alias(&key("bin[0].release_time"), &key("release_time"));
            vec![Bin::only(robot.point("bin")?, release_time)]
        };
        list.push(Robot {
            name: robot.text("name")?,
            base: robot.point("base")?,
            reach: robot.number("reach")?,
            arm: arm_keys::read(&robot)?,
            grasp_time: robot.number("grasp_time")?,
            rest: robot.optional_point("rest")?.unwrap_or(bins[0].at),
            bins,
        });
    }
    Ok(list)
}

/// The bins of a robot or of a line; `position` is the key of their position, `release_time` [s]
/// applies to those without one.
fn read_bins(owner: &Section, position: &str, release_time: f64) -> Result<Vec<Bin>> {
    let read = |(index, bin): (usize, Section)| {
        bin.only(&[&[position][..], &BIN_KEYS[..]].concat())?;
        let name = bin.optional_text("name")?;
        let own = bin.optional("release_time")?;
        if own.is_none() {
            let [of_bin, of_owner] =
                [&bin.path, &owner.path].map(|path| format!("{path}.release_time"));
            owner.file.alias(&of_bin, &of_owner);
        }
        Ok(Bin {
            name: name.unwrap_or_else(|| default_bin_name(index)),
            at: bin.point(position)?,
            classes: bin.optional_texts("classes")?,
            release_time: own.unwrap_or(release_time),
        })
    };
    let tables = owner.tables("bin")?;
    tables.into_iter().enumerate().map(read).collect()
}

fn read_line(line: &Section, overrides: Overrides) -> Result<Line> {
    let places = [
        "robots",
        "first_base_x",
        "spacing",
        "base_offset",
        "bin_offset",
        "bin",
        "tail",
        "reach",
    ];
    let times = ["grasp_time", "release_time", "rest"];
    line.only(&[&places[..], &arm_keys::KEYS[..], &times[..]].concat())?;
    let robots = match (overrides.robots, line.optional_count("robots")?) {
        (Some(count), _) | (None, Some(count)) => count,
        (None, None) => return Err(line.missing("robots")),
    };
    line.file.alias("robot", "line.robots");
    let release_time = line.number("release_time")?;
    let bins = match (line.table.contains_key("bin"), line.optional("bin_offset")?) {
        (true, Some(_)) => {
            return Err(line.wrong(
                "bin_offset",
                "the line has both bin_offset and [[line.bin]]".into(),
                "keep one of them; [[line.bin]] gives the offset of each bin from the base".into(),
            ));
        }
        (true, None) => LineBins::AtBase(read_bins(line, "offset", release_time)?),
        (false, _) => LineBins::AtEdge(line.number("bin_offset")?),
    };
    Ok(Line {
        robots,
        first_base_x: line.number("first_base_x")?,
        spacing: line.number("spacing")?,
        base_offset: line.number("base_offset")?,
        bins,
        rest: line.optional_point("rest")?.map(|rest| rest.coords),
        tail: line.number("tail")?,
        reach: line.number("reach")?,
        arm: arm_keys::read(line)?,
        grasp_time: line.number("grasp_time")?,
        release_time,
    })
}

fn read_classes(root: &Section) -> Result<Vec<ItemClass>> {
    let read = |class: Section| {
        class.only(&["name", "value", "wanted"])?;
        Ok(ItemClass {
            name: class.text("name")?,
            value: class.optional("value")?.unwrap_or(1.0),
            wanted: class.optional_bool("wanted")?.unwrap_or(true),
        })
    };
    root.tables("class")?.into_iter().map(read).collect()
}

/// A station file that explains every key, equivalent to the built-in `paper`.
pub fn commented_example() -> &'static str {
    include_str!("example.toml")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::station::BUILT_INS;
    use crate::station::load;
    use crate::station::to_toml;

    const GOOD: &str = "[belt]\nspeed = 0.05\nlength = 4\nwidth = 1.0\n\n[[robot]]\nname = \"a\"\n\
        base = [1, -0.6]\nbin = [1.0, -0.5]\nreach = 0.8\nspeed = 0.5\ngrasp_time = 0\nrelease_time = 0.1\n";

    #[test]
    fn reads_back_what_it_writes() {
        for built_in in BUILT_INS {
            for robots in 1..5 {
                let station = built_in.station(Some(robots)).unwrap();
                let again = parse(&to_toml(&station), "t", Overrides::default()).unwrap();
                assert_eq!(station, again);
            }
        }
    }

    #[test]
    fn the_commented_example_is_the_default_station() {
        for robots in [None, Some(1), Some(3)] {
            let overrides = Overrides {
                robots,
                belt_speed: None,
            };
            let example = parse(commented_example(), "example", overrides).unwrap();
            assert_eq!(example, load("paper", overrides).unwrap());
        }
    }

    #[test]
    fn messages_name_line_and_key() {
        for (from, to, words) in [
            (
                "speed = 0.05",
                "sped = 0.05",
                &["t:2: belt.sped", "did you mean `speed`"][..],
            ),
            ("reach = 0.8", "reach = -1", &["t:10: robot[0].reach", "-1"]),
            (
                "reach = 0.8",
                "reach = nan",
                &["t:10: robot[0].reach", "NaN"],
            ),
            ("reach = 0.8\n", "", &["t:6: robot[0].reach", "missing"]),
            (
                "speed = 0.5\n",
                "speed = 0.05\n",
                &["t:11: robot[0].speed", "faster than the belt"],
            ),
            (
                "width = 1.0",
                "width = \"1\"",
                &["t:4: belt.width", "not a number"],
            ),
            (
                "bin = [1.0, -0.5]",
                "bin = 3",
                &["t:9: robot[0].bin", "not a position"],
            ),
            ("[belt]", "[belt", &["t:1", "not valid TOML"]),
            ("[belt]", "belt = 1\n[other]", &["other", "unknown key"]),
        ] {
            let text = GOOD.replace(from, to);
            let message = parse(&text, "t", Overrides::default())
                .unwrap_err()
                .to_string();
            for word in words {
                assert!(message.contains(word), "{word} not in {message}");
            }
        }
        assert!(parse(&GOOD.replace('\n', "\r\n"), "t", Overrides::default()).is_ok());
        assert!(parse(&format!("\u{feff}{GOOD}"), "t", Overrides::default()).is_ok());
    }

    #[test]
    fn a_line_is_blamed_by_its_own_keys() {
        let good = commented_example();
        let line_of = |key: &str| {
            let starts = |line: &str| line.starts_with(key);
            let after = good.lines().position(|line| line == "[line]").unwrap();
            1 + after + good.lines().skip(after).position(starts).unwrap()
        };
        for (key, value, word) in [
            ("robots", "0", "no robots"),
            ("robots", "1000000000", "1000000000 robots"),
            ("robots", "2.5", "2.5 is not a valid count"),
            ("first_base_x", "nan", "NaN"),
            ("spacing", "-1", "-1 is not a valid length"),
            ("base_offset", "1e300", "1e300 is not a valid position"),
            ("tail", "inf", "inf is not a valid length"),
            ("reach", "0", "0 is not a usable size"),
            ("speed", "1e400", "1e400 is not a number"),
            ("speed", "0.05", "not faster than the belt"),
            ("grasp_time", "-0.1", "-0.1 is not a valid dwell time"),
        ] {
            let line = line_of(key);
            let mut lines: Vec<_> = good.lines().map(str::to_owned).collect();
            lines[line - 1] = format!("{key} = {value}");
            let error = parse(&lines.join("\n"), "t", Overrides::default()).unwrap_err();
            let message = error.to_string();
            let place = format!("t:{line}: line.{key}: ");
            assert!(message.starts_with(&place), "{place} not in {message}");
            assert!(message.contains(word), "{word} not in {message}");
        }
        let hex = good.replace("robots = 2", "robots = 0x1_0");
        let station = parse(&hex, "t", Overrides::default()).unwrap();
        assert_eq!(station.robots().len(), 16);
    }

    #[test]
    fn a_flag_that_asks_for_too_much_is_blamed() {
        let with = |robots, belt_speed| Overrides { robots, belt_speed };
        for (overrides, flag) in [
            (with(None, Some(0.5)), "'belt_speed': "),
            (with(None, Some(-1.0)), "'belt_speed': "),
            (with(Some(0), None), "'robots': the station has no robots"),
            (with(Some(usize::MAX), None), "'robots': "),
        ] {
            for name in ["paper", "file"] {
                let result = match name {
                    "file" => parse(commented_example(), "t", overrides),
                    _ => load(name, overrides),
                };
                let message = result.unwrap_err().to_string();
                assert!(message.starts_with(flag), "{message}");
            }
        }
    }

    #[test]
    fn robots_flag_needs_a_line() {
        let overrides = Overrides {
            robots: Some(3),
            belt_speed: None,
        };
        let message = parse(GOOD, "t", overrides).unwrap_err().to_string();
        assert!(message.starts_with("'robots'"), "{message}");
    }
}
