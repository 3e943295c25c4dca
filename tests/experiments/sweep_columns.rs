//! Every column of a sweep, recomputed from single runs.

use super::support::*;
use crate::common::csv_rows;
use pickline::pattern::{Pattern, PatternSource, Recipe, load};
use pickline::planning::bound::{Bound, BoundOptions, upper_bound};
use pickline::sim::Scene;
use pickline::station::{self, Overrides, Station};
use serde_json::Value;

const METHODS: [&str; 3] = ["robust_gt", "greedy_gt", "rules:LPT,PP"];

/// A sweep as it was called for: its results, and every run of it made again.
struct Swept {
    values: Vec<f64>,
    /// [values][methods][patterns].
    runs: Vec<Vec<Vec<Raw>>>,
    /// [values][patterns].
    bounds: Vec<Vec<Bound>>,
    helps: bool,
    report: Value,
    table: String,
    csv: Vec<Vec<String>>,
}

impl Swept {
    fn new(
        arguments: &str,
        lines: Vec<(f64, Station)>,
        patterns: &[Pattern],
        methods: &dyn Fn(usize) -> Vec<&'static str>,
        helps: bool,
    ) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().to_str().unwrap();
        let table = run(&format!("sweep -q --out {out} {arguments}"));
        let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
        let of = |station: &Station, method: &str| -> Vec<Raw> {
            let run = |pattern: &Pattern| match method {
                "greedy" => assignments()
                    .iter()
                    .map(|rules| Raw::of(station, pattern, rules))
                    .reduce(|best, next| {
                        if next.rate() > best.rate() {
                            next
                        } else {
                            best
                        }
                    })
                    .unwrap(),
                rules => Raw::of(station, pattern, &rules.parse().unwrap()),
            };
            patterns.iter().map(run).collect()
        };
        let runs = |(_, station): &(f64, Station)| -> Vec<Vec<Raw>> {
            let methods = methods(station.robots().len());
            methods
                .into_iter()
                .map(|method| of(station, method))
                .collect()
        };
        let runs: Vec<_> = lines.iter().map(runs).collect();
        let bounds = lines.iter().zip(&runs).map(|((_, station), runs)| {
            let bound = |(place, pattern): (usize, &Pattern)| {
                let most = runs.iter().map(|runs| runs[place].picked).max().unwrap();
                let scene = Scene::new(station, pattern).unwrap();
                let options = BoundOptions::beside(most, pattern.len());
                upper_bound(&scene, &options, &mut |_, _| true).unwrap()
            };
            patterns.iter().enumerate().map(bound).collect()
        });
        Self {
            bounds: bounds.collect(),
            values: lines.iter().map(|line| line.0).collect(),
            runs,
            helps,
            report: serde_json::from_str(&read("sweep.json")).unwrap(),
            csv: csv_rows(&read("sweep.csv")),
            table,
        }
    }

    /// On which patterns the throughput counts: all values are compared on the same.
    fn counts(&self, value: usize, method: usize) -> Vec<bool> {
        let all: Vec<&[Raw]> = self.runs.iter().flatten().map(Vec::as_slice).collect();
        counted(&all).swap_remove(value * METHODS.len() + method)
    }

    fn expected(&self, value: usize, method: usize) -> Expected {
        let (runs, bounds) = (&self.runs[value][method], &self.bounds[value]);
        let mut to = Expected::new();
        add_throughput(&mut to, runs, &self.counts(value, method));
        add_rates(&mut to, runs);
        let of_patterns = |holds: &dyn Fn(&Raw) -> bool| {
            let count = runs.iter().filter(|run| holds(run)).count();
            Some(count as f64 / runs.len() as f64)
        };
        to.insert("value", Some(self.values[value]));
        to.insert("complete_share", of_patterns(&Raw::complete));
        to.insert(
            "nearly_complete_share",
            of_patterns(&|run| 100 * run.picked >= 99 * run.items),
        );
        let picked: usize = runs.iter().map(|run| run.picked).sum();
        let most: f64 = bounds.iter().map(|bound| bound.value).sum();
        let certified = (1000.0 * picked as f64 / most + 1e-9).floor() / 10.0;
        to.insert("certified_percent", Some(certified));
        let shares = bounds
            .iter()
            .zip(runs)
            .map(|(b, run)| b.value / run.items as f64);
        to.insert(
            "picked_share_upper_bound",
            Some(mean(&shares.collect::<Vec<_>>())),
        );
        let rates: Vec<f64> = bounds.iter().map(|b| b.rate.unwrap()).collect();
        to.insert("picking_rate_upper_bound", Some(mean(&rates)));
        // By the share of the flow, as the flow is that of the patterns.
        let steady = |value: usize| {
            let mut found = Expected::new();
            let counts = self.counts(value, method);
            add_throughput(&mut found, &self.runs[value][method], &counts);
            Some(found["throughput"]? / found["flow"]?)
        };
        let before = value.checked_sub(1).filter(|_| self.helps);
        let added = before.and_then(|before| {
            let robots = self.values[value] - self.values[before];
            Some((steady(value)? - steady(before)?) * to["flow"]? / robots)
        });
        to.insert("added_per_robot", added);
        to
    }

    /// For each value whether everything of every pattern is picked.
    fn complete(&self, method: usize) -> Vec<bool> {
        self.runs
            .iter()
            .map(|runs| runs[method].iter().all(Raw::complete))
            .collect()
    }

    /// The highest value before the first that does not hold.
    fn limit(&self, held: &[bool]) -> Option<f64> {
        let count = held.iter().take_while(|held| **held).count();
        (count > 0).then(|| self.values[count - 1])
    }

    fn check_points(&self) {
        let points = self.report["points"].as_array().unwrap();
        assert_eq!(points.len(), self.values.len() * METHODS.len());
        assert_eq!(self.csv.len(), 1 + points.len());
        for (i, (point, row)) in points.iter().zip(&self.csv[1..]).enumerate() {
            let (value, method) = (i / METHODS.len(), i % METHODS.len());
            let what = format!("{}, {}", self.values[value], METHODS[method]);
            let expected = self.expected(value, method);
            assert_object(point, &expected, &what);
            assert_eq!(point["method"], METHODS[method]);
            let mut in_csv = expected.clone();
            in_csv.insert("belt_speed_m_per_s", Some(self.values[value]));
            in_csv.insert("robots", Some(self.values[value]));
            assert_row(&self.csv[0], row, &["method"], &in_csv, &what);
        }
        let bounds = self.report["bounds"]["points"].as_array().unwrap();
        for (value, bound) in bounds.iter().enumerate() {
            let expected = self.expected(value, 0);
            for (key, name) in [
                ("picked_share", "picked_share_upper_bound"),
                ("picking_rate_per_min", "picking_rate_upper_bound"),
            ] {
                assert_near(
                    bound[key].as_f64(),
                    expected[name],
                    &format!("{bound}: {key}"),
                );
            }
        }
        let impossible = (0..self.values.len()).filter(|&value| {
            let (bounds, runs) = (&self.bounds[value], &self.runs[value][0]);
            bounds
                .iter()
                .zip(runs)
                .any(|(bound, run)| (bound.value as usize) < run.items)
        });
        let impossible: Vec<Value> = impossible.map(|value| self.values[value].into()).collect();
        assert_eq!(
            self.report["bounds"]["impossible"],
            Value::Array(impossible)
        );
    }

    fn check_limits(&self) {
        let first = self.limit(&self.complete(0));
        for (method, limit) in self.report["limits"].as_array().unwrap().iter().enumerate() {
            assert_eq!(limit["method"], METHODS[method]);
            let whole = self.complete(method);
            let value = |value: Option<f64>| value.map_or(Value::Null, Value::from);
            let highest = self.limit(&whole);
            assert_eq!(limit["highest"], value(highest), "{limit}");
            let miss = whole.iter().position(|whole| !whole);
            assert_eq!(
                limit["first_miss"],
                value(miss.map(|i| self.values[i])),
                "{limit}"
            );
            let again = (miss.unwrap_or(whole.len())..whole.len()).filter(|&i| whole[i]);
            let again: Vec<Value> = again.map(|i| self.values[i].into()).collect();
            assert_eq!(limit["again"], Value::Array(again), "{limit}");
            let tail = whole.iter().rev().take_while(|whole| **whole).count();
            let lowest = (tail > 0).then(|| self.values[whole.len() - tail]);
            assert_eq!(limit["lowest"], value(lowest), "{limit}");
            let nearly = |runs: &Vec<Vec<Raw>>| {
                let runs = &runs[method];
                let near = runs.iter().filter(|run| 100 * run.picked >= 99 * run.items);
                20 * near.count() >= 19 * runs.len()
            };
            let nearly: Vec<bool> = self.runs.iter().map(nearly).collect();
            assert_eq!(
                limit["highest_95_99"],
                value(self.limit(&nearly)),
                "{limit}"
            );
            let patterns = self.runs[0][0].len();
            let mut own: Vec<f64> = (0..patterns)
                .map(|pattern| {
                    let held = |runs: &Vec<Vec<Raw>>| runs[method][pattern].complete();
                    let held: Vec<bool> = self.runs.iter().map(held).collect();
                    self.limit(&held).unwrap_or(0.0)
                })
                .collect();
            own.sort_by(f64::total_cmp);
            let all: Vec<Value> = own.iter().map(|limit| (*limit).into()).collect();
            assert_eq!(limit["all_of_patterns"], Value::Array(all), "{limit}");
            let middle = own[(own.len() - 1).div_ceil(2)];
            for (place, expected) in [own[0], middle, own[own.len() - 1]].into_iter().enumerate() {
                assert_eq!(limit["of_patterns"][place], expected, "{limit}");
            }
            let more = highest.zip(first).filter(|_| method > 0 && !self.helps);
            let more = more.map(|(this, first)| 100.0 * (this / first - 1.0));
            assert_near(limit["benefit_percent"].as_f64(), more, "benefit");
        }
    }

    /// `digits` apart, the cells of the table are the numbers of the runs.
    fn check_table(&self, header: &[&str], weighs: bool) {
        let rows = table_rows(&self.table);
        assert_eq!(rows[0], header);
        for (i, row) in rows[1..].iter().enumerate() {
            let (value, method) = (i / METHODS.len(), i % METHODS.len());
            let figures = self.expected(value, method);
            let percent = |name: &str| shown(figures[name].map(|share| 100.0 * share), 1);
            let up = |value: f64, digits: i32| {
                let power = 10f64.powi(digits);
                shown(Some((power * value - 1e-9).ceil() / power), digits as usize)
            };
            let steady = header.contains(&"flow [1/min]");
            let mut expected = vec![if method == 0 {
                self.values[value].to_string()
            } else {
                String::new()
            }];
            if steady {
                let (low, high) = (figures["throughput_low"], figures["throughput_high"]);
                let figure = match figures["throughput"] {
                    None => "-".into(),
                    throughput => shown(throughput, 1),
                };
                expected.extend([
                    figure,
                    shown_interval(low, high, 1),
                    shown(figures["flow"], 1),
                ]);
            }
            if header.contains(&"added a robot [1/min]") {
                expected.push(shown(figures["added_per_robot"], 1));
            }
            expected.extend([percent("picked_share"), shown(figures["picking_rate"], 2)]);
            expected.extend(weighs.then(|| shown(figures["weighted_rate"], 2)));
            let (low, high) = (figures["picking_rate_low"], figures["picking_rate_high"]);
            expected.extend([
                shown_interval(low, high, 2),
                percent("complete_share"),
                percent("nearly_complete_share"),
                shown(figures["certified_percent"], 1),
            ]);
            let (share, rate) = ("picked_share_upper_bound", "picking_rate_upper_bound");
            expected.extend(match method {
                0 => [
                    up(100.0 * figures[share].unwrap(), 1),
                    up(figures[rate].unwrap(), 2),
                ],
                _ => [const { String::new() }; 2],
            });
            let found = [&row[..1], &row[2..]].concat();
            assert_eq!(found, expected, "{row:?}");
        }
    }
}

fn line(text: &str, folder: &std::path::Path) -> String {
    let file = folder.join("line.toml");
    std::fs::write(&file, text).unwrap();
    file.to_str().unwrap().to_owned()
}

#[test]
fn a_sweep_of_the_speed_is_that_of_its_runs() {
    let folder = tempfile::tempdir().unwrap();
    let slow = STATION.replace("grasp_time = 0.3", "grasp_time = 0.8");
    let line = line(&slow, folder.path());
    let none = Overrides::default();
    let station = station::load(&line, none).unwrap();
    // The seed after the master seed.
    let recipe = Recipe::new(*station.belt(), 60, 4);
    let source: PatternSource = "random:50/min:3".parse().unwrap();
    let patterns = source.build(&recipe).unwrap().patterns;
    let values = [0.02, 0.04, 0.06, 0.08, 0.1, 0.12, 0.14];
    let swept = Swept::new(
        &format!(
            "--station {line} --seed 3 --patterns random:50/min:3 --items 60 --from 0.02 --to \
             0.14 --step 0.02 --robust SPT,FIFO --greedy --strategy rules:LPT,PP"
        ),
        values
            .map(|v| (v, station.with_belt_speed(v).unwrap()))
            .to_vec(),
        &patterns,
        &|_| vec!["SPT,FIFO", "greedy", "LPT,PP"],
        false,
    );
    swept.check_points();
    swept.check_limits();
    let header = [
        "speed [m/s]",
        "method",
        "throughput [1/min]",
        "95 %",
        "flow [1/min]",
        "picked [%]",
        "picking rate [1/min]",
        "picking rate, 95 %",
        "complete [%]",
        "to 99 % [%]",
        "certified [%]",
        "bound: picked [%]",
        "picking rate [1/min]",
    ];
    swept.check_table(&header, false);
    // Some of the values are within the limits, and the methods' limits differ.
    let limits = |key: &str| -> Vec<Value> {
        let limits = swept.report["limits"].as_array().unwrap().iter();
        limits.map(|limit| limit[key].clone()).collect()
    };
    let highest = limits("highest");
    assert!(
        highest[0].is_number() && highest[1] != highest[2],
        "{highest:?}"
    );
    assert!(limits("first_miss")[0].is_number());
    for limit in swept.report["limits"].as_array().unwrap() {
        let words = format!(
            "limit     {}: everything picked up to {} m/s",
            limit["method"].as_str().unwrap(),
            limit["highest"]
        );
        assert!(
            swept.table.contains(&words),
            "{words} not in {}",
            swept.table
        );
        let benefit = limit["benefit_percent"].as_f64();
        let benefit = benefit.map(|more| format!(" ({more:.1} % against the first)"));
        let miss = match limit["first_miss"].as_f64() {
            Some(value) => format!("first miss at {value}"),
            None => "no miss in this sweep".into(),
        };
        let words = format!("{words}{}; {miss}", benefit.unwrap_or_default());
        assert!(
            swept.table.contains(&words),
            "{words} not in {}",
            swept.table
        );
    }
}

#[test]
fn a_sweep_of_robots_is_that_of_its_runs() {
    let folder = tempfile::tempdir().unwrap();
    let line = line(
        &STATION.replace("grasp_time = 0.3", "grasp_time = 1.5"),
        folder.path(),
    );
    let set = folder.path().join("set");
    std::fs::create_dir(&set).unwrap();
    // Long enough for a steady state, of unlike weights.
    let patterns: Vec<Pattern> = (0..2)
        .map(|n: usize| {
            let file = set.join(format!("{n}.csv"));
            let rows = (0..150).map(|i: usize| {
                let x = -0.08 * i as f64 - 0.01 * ((i * i + 3 * n) % 5) as f64;
                let (y, weight) = (0.1 * ((5 * i + n) % 6) as f64 - 0.25, 1 + (7 * (i + n)) % 5);
                format!("{i},{x},{y},{weight}\n")
            });
            std::fs::write(
                &file,
                format!("id,x,y,weight\n{}", rows.collect::<String>()),
            )
            .unwrap();
            load(&file).unwrap().pattern
        })
        .collect();
    let with = |robots| {
        let count = Overrides::default().with_robots(robots);
        (robots as f64, station::load(&line, count).unwrap())
    };
    // For every number of robots another robust GT; the same rules whatever their number.
    let swept = Swept::new(
        &format!(
            "--station {line} --sweep robots --from 2 --to 2 --patterns {} --robust SPT,FIFO \
             --greedy --strategy rules:LPT,PP",
            set.display()
        ),
        vec![with(2)],
        &patterns,
        &|_| vec!["SPT,FIFO", "greedy", "LPT,PP"],
        true,
    );
    swept.check_points();
    let header = [
        "robots",
        "method",
        "throughput [1/min]",
        "95 %",
        "flow [1/min]",
        "picked [%]",
        "picking rate [1/min]",
        "weighted [1/min]",
        "picking rate, 95 %",
        "complete [%]",
        "to 99 % [%]",
        "certified [%]",
        "bound: picked [%]",
        "picking rate [1/min]",
    ];
    swept.check_table(&header, true);
    let weighted = swept.csv[0].contains(&"weighted_rate_per_min".to_owned());
    assert!(weighted, "{:?}", swept.csv[0]);
    // What every further robot adds is what it picks more a minute, a robot.
    let call = format!(
        "sweep -q --format json --station {line} --sweep robots --from 1 --to 3 --step 2 \
         --no-bound --patterns {}",
        set.display()
    );
    let report: Value = serde_json::from_str(&run(&call)).unwrap();
    let point = |place: usize, key: &str| report["points"][place][key].as_f64();
    let (few, many) = (
        point(0, "throughput_per_min"),
        point(1, "throughput_per_min"),
    );
    assert_eq!(point(0, "added_per_robot_per_min"), None);
    let added = (many.unwrap() - few.unwrap()) / 2.0;
    assert!(added > 1.0, "{added}");
    assert_near(
        point(1, "added_per_robot_per_min"),
        Some(added),
        "added a robot",
    );
}
