//! Every figure of a class, recomputed from single runs.

use super::support::*;
use crate::common::csv_rows;
use pickline::dispatch::RuleAssignment;
use pickline::pattern::{Pattern, load};
use pickline::planning::bound::{BoundObjective, BoundOptions, upper_bound};
use pickline::sim::{Scene, simulate_rules};
use pickline::station::{self, Overrides, Station};
use serde_json::Value;
use std::path::{Path, PathBuf};

const METHODS: [(&str, &str); 2] = [("robust_gt", "PP,SPT"), ("rules:LPT,FIFO", "LPT,FIFO")];
/// By name, those without a class first.
const CLASSES: [Option<&str>; 4] = [None, Some("hdpe"), Some("pet"), Some("wood")];

/// The line of the other tables with two bins for two classes, a class that is not wanted, and no
/// bin for items without a class.
fn sorting() -> String {
    let plain = STATION.replace("bin_offset = 0.0\n", "");
    plain
        + "[[line.bin]]\nname = \"p\"\noffset = [0.1, 0.0]\nclasses = [\"pet\"]\n\
           [[line.bin]]\nname = \"h\"\noffset = [-0.1, 0.0]\nclasses = [\"hdpe\"]\n\
           [[class]]\nname = \"pet\"\nvalue = 3.0\n[[class]]\nname = \"wood\"\nwanted = false\n"
}

/// Dense columns of three, so that much is missed; the classes differ from pattern to pattern.
fn classed(first: usize) -> String {
    let rows = (0..72).map(|i| {
        let (column, row) = (i / 3, i % 3);
        let class = ["pet", "hdpe", "", "pet", "wood", "hdpe", "pet"][(5 * i + first * i / 3) % 7];
        let x = -0.07 * column as f64;
        format!("{i},{x},{},{class}\n", 0.2 * (row as f64 - 1.0))
    });
    format!("id,x,y,class\n{}", rows.collect::<String>())
}

struct Files {
    folder: tempfile::TempDir,
    station: Station,
    patterns: Vec<Pattern>,
}

impl Files {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("line.toml"), sorting()).unwrap();
        std::fs::create_dir(at("set")).unwrap();
        let pattern = |number: usize| {
            let file = at("set").join(format!("{number}.csv"));
            std::fs::write(&file, classed(number)).unwrap();
            load(&file).unwrap().pattern
        };
        let patterns = (0..3).map(pattern).collect();
        let line = at("line.toml");
        let station = station::load(line.to_str().unwrap(), Overrides::default()).unwrap();
        Self {
            patterns,
            station,
            folder,
        }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Items and picks of a class in each pattern that has it, and the bound on all of them.
    fn counts(&self, station: &Station, patterns: &[Pattern], of: (&str, Option<&str>)) -> Counts {
        let (rules, class) = of;
        let rules: RuleAssignment = rules.parse().unwrap();
        let mut counts = Counts::default();
        for pattern in patterns {
            let scene = Scene::new(station, pattern).unwrap();
            let outcome = simulate_rules(&scene, &rules).unwrap();
            let is_of = |item: usize| pattern.items()[item].class.as_deref() == class;
            let items = (0..pattern.len()).filter(|item| is_of(*item)).count();
            let picks = outcome.picks.iter();
            let picked = picks.filter(|pick| is_of(pick.item as usize)).count();
            counts.of_patterns.push((items as f64, picked as f64));
            counts.most += most(station, pattern, class);
        }
        counts
    }
}

/// The bound on a class: every item has a weight of its own, 1 for those of the class and 0 for all
/// others.
fn most(station: &Station, pattern: &Pattern, class: Option<&str>) -> f64 {
    let mut items = pattern.items().to_vec();
    for item in &mut items {
        item.weight = Some(f64::from(u8::from(item.class.as_deref() == class)));
    }
    let pattern = Pattern::new(items).unwrap();
    let scene = Scene::new(station, &pattern).unwrap();
    let options = BoundOptions::beside(0, pattern.len())
        .with_objective(BoundObjective::Weight)
        .with_ends(false);
    let bound = upper_bound(&scene, &options, &mut |_, _| true).unwrap();
    (bound.value + 1e-9).floor()
}

#[derive(Default)]
struct Counts {
    of_patterns: Vec<(f64, f64)>,
    most: f64,
}

impl Counts {
    fn expected(&self, is_wanted: bool) -> Expected {
        let items: f64 = self.of_patterns.iter().map(|(items, _)| items).sum();
        let picked: f64 = self.of_patterns.iter().map(|(_, picked)| picked).sum();
        let share = picked / items;
        let mean_items = items / self.of_patterns.len() as f64;
        let off = self.of_patterns.iter();
        let off: Vec<f64> = off.map(|(n, k)| (k - share * n) / mean_items).collect();
        // About a mean of 0.
        let half = interval(&off).map(|ends| ends[1] - mean(&off));
        let ends = half.map(|half| [(share - half).max(0.0), (share + half).min(1.0)]);
        let wanted = |value: Option<f64>| value.filter(|_| is_wanted);
        Expected::from([
            ("items", Some(items)),
            ("picked", Some(picked)),
            ("patterns", Some(self.of_patterns.len() as f64)),
            ("recovery", wanted(Some(share))),
            ("recovery_low", wanted(ends.map(|ends| ends[0]))),
            ("recovery_high", wanted(ends.map(|ends| ends[1]))),
            ("picks_upper_bound", wanted(Some(self.most))),
            (
                "certified_percent",
                wanted(Some((1000.0 * picked / self.most + 1e-9).floor() / 10.0)),
            ),
        ])
    }
}

fn is_wanted(class: Option<&str>) -> bool {
    matches!(class, Some("pet" | "hdpe"))
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap()
}

/// Holds the classes of a result to `files`, and the rows of the CSV file from `row` on.
fn assert_classes(
    result: &Value,
    (header, rows): (&[String], &[Vec<String>]),
    expected: impl Fn(Option<&str>) -> Expected,
    what: &str,
) {
    let classes = result["classes"].as_array().unwrap();
    assert_eq!((classes.len(), rows.len()), (CLASSES.len(), CLASSES.len()));
    for ((class, row), name) in classes.iter().zip(rows).zip(CLASSES) {
        let what = format!("{what}, {name:?}");
        assert_eq!(class["name"].as_str(), name);
        let mut of = expected(name);
        let mut in_csv = of.clone();
        if name.is_none() {
            // Its name is null.
            of.insert("name", None);
        }
        assert_object(class, &of, &what);
        in_csv.insert("belt_speed_m_per_s", None);
        let words = ["case", "method", "class", "belt_speed_m_per_s"];
        assert_row(header, row, &words, &in_csv, &what);
        let column = header.iter().position(|name| name == "class").unwrap();
        assert_eq!(row[column], name.unwrap_or_default());
    }
}

#[test]
fn the_classes_of_a_comparison_are_those_of_its_runs() {
    let files = Files::new();
    let cases = "[[case]]\nname = \"a\"\npattern = \"set/0.csv\"\n\
                 [[case]]\nname = \"b\"\npattern = \"set/1.csv\"\n";
    std::fs::write(files.path("cases.toml"), cases).unwrap();
    let (line, list) = (files.path("line.toml"), files.path("cases.toml"));
    let table = run(&format!(
        "compare -q --no-policy --no-greedy --station {} --cases {} --robust PP,SPT --strategy \
         rules:LPT,FIFO --out {}",
        line.display(),
        list.display(),
        files.path("out").display()
    ));
    let report: Value = serde_json::from_str(&read(&files.path("out"), "compare.json")).unwrap();
    let csv = csv_rows(&read(&files.path("out"), "classes.csv"));
    let mut rows = csv[1..].chunks(CLASSES.len());
    for (number, case) in report["cases"].as_array().unwrap().iter().enumerate() {
        for (place, (method, rules)) in METHODS.into_iter().enumerate() {
            let patterns = &files.patterns[number..=number];
            let expected = |class: Option<&str>| {
                let counts = files.counts(&files.station, patterns, (rules, class));
                counts.expected(is_wanted(class))
            };
            let result = &case["results"][place];
            assert_eq!(result["method"], method);
            let rows = rows.next().unwrap();
            assert_classes(result, (&csv[0], rows), expected, method);
        }
    }
    // The table has the recoveries of the wanted classes, and what is at most possible.
    let rows = table_rows(&table);
    let header = rows.iter().position(|row| row.len() == 4).unwrap();
    assert_eq!(rows[header], ["case", "method", "hdpe [%]", "pet [%]"]);
    for (number, name) in ["a", "b"].into_iter().enumerate() {
        let patterns = &files.patterns[number..=number];
        for place in 0..3 {
            let row = &rows[header + 1 + 3 * number + place];
            assert_eq!(row[0], if place == 0 { name } else { "" });
            for (column, class) in ["hdpe", "pet"].into_iter().enumerate() {
                let rules = METHODS[place.min(1)].1;
                let of = files.counts(&files.station, patterns, (rules, Some(class)));
                let of = of.expected(true);
                let share = match place {
                    2 => {
                        (1000.0 * of["picks_upper_bound"].unwrap() / of["items"].unwrap() - 1e-9)
                            .ceil()
                            / 10.0
                    }
                    _ => 100.0 * of["recovery"].unwrap(),
                };
                assert_eq!(
                    row[2 + column],
                    shown(Some(share), 1),
                    "{name} {class} {place}"
                );
            }
        }
    }
    // The methods differ in what they prefer, or the columns could stand in for each other.
    let pet = |place: usize| &report["cases"][0]["results"][place]["classes"][2]["picked"];
    assert_ne!(pet(0), pet(1));
}

#[test]
fn the_classes_of_a_sweep_are_those_of_its_runs() {
    let files = Files::new();
    run(&format!(
        "sweep -q --station {} --patterns {} --from 0.08 --to 0.16 --step 0.08 --robust PP,SPT \
         --strategy rules:LPT,FIFO --out {}",
        files.path("line.toml").display(),
        files.path("set").display(),
        files.path("out").display()
    ));
    let report: Value = serde_json::from_str(&read(&files.path("out"), "sweep.json")).unwrap();
    let csv = csv_rows(&read(&files.path("out"), "classes.csv"));
    let mut rows = csv[1..].chunks(CLASSES.len());
    let points = report["points"].as_array().unwrap();
    assert_eq!(points.len(), 4);
    for point in points {
        let rules = METHODS
            .iter()
            .find(|(method, _)| point["method"] == *method);
        let speed = point["value"].as_f64().unwrap();
        let station = files.station.with_belt_speed(speed).unwrap();
        let expected = |class: Option<&str>| {
            let counts = files.counts(&station, &files.patterns, (rules.unwrap().1, class));
            counts.expected(is_wanted(class))
        };
        let rows = rows.next().unwrap();
        assert_eq!(rows[0][0].parse(), Ok(speed));
        assert_classes(point, (&csv[0], rows), expected, &point.to_string());
    }
}

/// Neither in what is printed nor in what is written.
#[test]
fn patterns_without_classes_have_no_figures_of_classes() {
    let files = Files::new();
    let plain = classed(0)
        .replace("pet", "")
        .replace("hdpe", "")
        .replace("wood", "");
    std::fs::write(files.path("plain.csv"), plain).unwrap();
    let (set, line) = (files.path("set"), files.path("line.toml"));
    std::fs::write(files.path("paper.toml"), STATION).unwrap();
    for (station, pattern) in [
        (&line, &files.path("plain.csv")),
        (&files.path("paper.toml"), &set.join("0.csv")),
    ] {
        let out = tempfile::tempdir().unwrap();
        run(&format!(
            "sweep -q --station {} --patterns {} --from 0.1 --to 0.1 --step 0.1 --robust PP,SPT \
             --out {}",
            station.display(),
            pattern.display(),
            out.path().display()
        ));
        assert!(!out.path().join("classes.csv").exists());
        assert!(!read(out.path(), "sweep.json").contains("\"classes\""));
    }
}
