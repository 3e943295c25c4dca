//! What several integration tests share.
#![allow(dead_code)]

use nalgebra::Point2;
use pickline::dispatch::RuleAssignment;
use pickline::pattern::{Item, Pattern};
use pickline::station::{Belt, Robot, Station};
use proptest::prelude::*;

/// Runs the program.
pub fn pickline(arguments: &[&str]) -> std::process::Output {
    std::process::Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(arguments)
        .output()
        .unwrap()
}

/// Runs the program in `folder`.
pub fn pickline_in(folder: &std::path::Path, arguments: &[&str]) -> std::process::Output {
    std::process::Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// What the program prints when it succeeds.
pub fn text(arguments: &[&str]) -> String {
    let output = pickline(arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {stderr}");
    String::from_utf8(output.stdout).unwrap()
}

/// The rows of a CSV file, its header first, without the comment lines at its head.
pub fn csv_rows(text: &str) -> Vec<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .has_headers(false)
        .from_reader(text.as_bytes());
    let row = |row: csv::StringRecord| row.iter().map(str::to_owned).collect();
    reader.records().map(|r| row(r.unwrap())).collect()
}

/// The cells of one column of a CSV file.
pub fn csv_column(text: &str, name: &str) -> Vec<String> {
    let rows = csv_rows(text);
    let place = rows[0].iter().position(|column| column == name);
    let place = place.unwrap_or_else(|| panic!("no column {name} in {:?}", rows[0]));
    rows[1..].iter().map(|row| row[place].clone()).collect()
}

/// Random stations of 1 to 6 unlike robots, with overlapping and disjoint windows,
/// bins anywhere near the belt, dwell times of 0 included.
pub fn stations() -> impl Strategy<Value = Station> {
    let robot = (
        0.0..2.5f64,   // distance to the base before
        -1.5..1.5f64,  // base y
        -0.8..0.8f64,  // bin x relative to the base
        -1.0..1.0f64,  // bin y
        0.2..1.4f64,   // reach
        1.05..12.0f64, // arm speed over belt speed
        prop_oneof![Just(0.0), 0.0..2.0f64],
        prop_oneof![Just(0.0), 0.0..2.0f64],
    );
    let robots = prop::collection::vec(robot, 1..=6);
    (0.01..0.3f64, 0.5..14.0f64, 0.2..2.0f64, robots).prop_map(|(speed, length, width, robots)| {
        let mut x = 0.0;
        let robots = robots
            .into_iter()
            .enumerate()
            .map(
                |(i, (gap, y, bin_x, bin_y, reach, faster, grasp_time, release_time))| {
                    x += gap;
                    Robot::new(
                        format!("r{}", i + 1),
                        Point2::new(x, y),
                        Point2::new(x + bin_x, bin_y),
                        reach,
                        pickline::kinematics::Arm::constant(speed * faster),
                    )
                    .with_dwell(grasp_time, release_time)
                },
            )
            .collect();
        let belt = Belt {
            speed,
            length,
            width,
        };
        Station::new(belt, robots).unwrap()
    })
}

/// Stations of like robots in a line, whose windows are mostly disjoint.
pub fn lines() -> impl Strategy<Value = Station> {
    (
        1usize..=4,
        0.02..0.2f64,
        1.2..2.4f64,
        0.3..1.3f64,
        0.0..0.6f64,
    )
        .prop_map(|(robots, speed, spacing, width, dwell)| {
            let line = pickline::station::Line {
                robots,
                first_base_x: 1.2,
                spacing,
                base_offset: 0.1,
                bins: pickline::station::LineBins::AtEdge(0.0),
                rest: None,
                tail: 0.4,
                reach: 0.8,
                arm: pickline::kinematics::Arm::constant(0.5),
                grasp_time: dwell,
                release_time: dwell,
            };
            Station::new(line.belt(speed, width), line.place(width)).unwrap()
        })
}

/// Up to `most` items on the belt of `station`, on a coarse lattice as often as not so
/// that equal positions and equal keys occur.
pub fn patterns(width: f64, most: usize) -> impl Strategy<Value = Pattern> {
    let free = (-4.0..=0.0f64, -0.5..=0.5f64, 0.0..1.0f64);
    let lattice = (0..12i32, -2..=2i32, 0..3i32)
        .prop_map(|(c, r, w)| (-0.25 * f64::from(c), 0.25 * f64::from(r), f64::from(w)));
    let items = prop::collection::vec(prop_oneof![free, lattice], 1..=most);
    items.prop_map(move |items| {
        let items = items
            .into_iter()
            .enumerate()
            .map(|(i, (x0, y, weight))| Item {
                weight: Some(weight),
                ..Item::at(i.to_string(), x0, y * width)
            })
            .collect();
        Pattern::new(items).unwrap()
    })
}

/// A station with a pattern on it and a rule for each robot.
pub fn cases(
    stations: impl Strategy<Value = Station>,
    most: usize,
) -> impl Strategy<Value = (Station, Pattern, RuleAssignment)> {
    stations.prop_flat_map(move |station| {
        let robots = station.robots().len();
        let width = station.belt().width;
        let rule = (0..pickline::dispatch::RULES.len())
            .prop_map(|i| pickline::dispatch::Rule::all().nth(i).unwrap());
        let rules = prop::collection::vec(rule, robots).prop_map(RuleAssignment::new);
        (Just(station), patterns(width, most), rules)
    })
}
