//! Figures of single runs and statistics in plain code, to hold the columns of results to.

use crate::common::text;
use pickline::decision::Outcome;
use pickline::dispatch::RuleAssignment;
use pickline::optimize::{Environment, Silent};
use pickline::pattern::Pattern;
use pickline::sim::{Scene, simulate_rules};
use pickline::station::Station;
use pickline::throughput::{Steadiness, steady_state};
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

/// Two robots of short reach, so that a few metres of pattern have a steady state.
pub const STATION: &str = "[belt]\nspeed = 0.1\nwidth = 0.6\n[line]\nrobots = 2\n\
    first_base_x = 0.8\nspacing = 1.2\nbase_offset = 0.1\nbin_offset = 0.0\ntail = 0.3\n\
    reach = 0.55\nspeed = 0.6\ngrasp_time = 0.3\nrelease_time = 0.3\n";

/// A recorded pattern whose items have weights of their own: ten short columns of three.
pub fn weighted(first: usize) -> String {
    let rows = (0..30).map(|i| {
        let (column, row) = (i / 3, i % 3);
        let weight = 1 + (7 * (i + first)) % 5;
        let x = -0.13 * column as f64;
        format!("{i},{x},{},{weight}\n", 0.2 * (row as f64 - 1.0))
    });
    format!("id,x,y,weight\n{}", rows.collect::<String>())
}

/// What the program prints for a call whose arguments are parted by spaces.
pub fn run(call: &str) -> String {
    text(&call.split_whitespace().collect::<Vec<_>>())
}

/// An environment that nobody stops.
pub fn environment() -> Environment<'static> {
    static STOP: AtomicBool = AtomicBool::new(false);
    Environment {
        stop: &STOP,
        progress: &Silent,
        ..Environment::QUIET
    }
}

/// One run, counted here.
#[derive(Debug, Clone)]
pub struct Raw {
    pub items: usize,
    pub picked: usize,
    pub weight: f64,
    /// [s].
    pub end: f64,
    pub steady: Steadiness,
}

impl Raw {
    /// What `rules` make of `pattern`.
    pub fn of(station: &Station, pattern: &Pattern, rules: &RuleAssignment) -> Self {
        let scene = Scene::new(station, pattern).unwrap();
        Self::counted(&scene, &simulate_rules(&scene, rules).unwrap())
    }

    /// The figures of `outcome` from its picks, by the text of `docs/model.md`.
    pub fn counted(scene: &Scene, outcome: &Outcome) -> Self {
        let (items, belt) = (scene.pattern().items(), scene.station().belt());
        let mut left = vec![true; items.len()];
        let (mut weight, mut end) = (0.0, 0.0f64);
        for pick in &outcome.picks {
            left[pick.item as usize] = false;
            weight += items[pick.item as usize].weight.unwrap_or(0.5);
            end = end.max(pick.release);
        }
        for failure in &outcome.failures {
            end = end.max(failure.attempt.release);
        }
        for (item, _) in items.iter().zip(&left).filter(|(_, left)| **left) {
            end = end.max((belt.length - item.x0) / belt.speed);
        }
        Self {
            items: items.len(),
            picked: outcome.picks.len(),
            weight,
            end,
            steady: steady_state(scene, outcome),
        }
    }

    pub fn share(&self) -> f64 {
        self.picked as f64 / self.items as f64
    }

    pub fn rate(&self) -> f64 {
        60.0 * self.picked as f64 / self.end
    }

    pub fn weighted_rate(&self) -> f64 {
        60.0 * self.weight / self.end
    }

    pub fn complete(&self) -> bool {
        self.picked == self.items
    }
}

/// Student's t for 95 %, from one degree of freedom on.
const T: [f64; 9] = [
    12.706_204_736,
    4.302_652_730,
    3.182_446_305,
    2.776_445_105,
    2.570_581_836,
    2.446_911_851,
    2.364_624_252,
    2.306_004_135,
    2.262_157_163,
];

pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The mean of one figure of `runs`.
pub fn mean_of(runs: &[Raw], figure: impl Fn(&Raw) -> f64) -> f64 {
    mean(&runs.iter().map(figure).collect::<Vec<_>>())
}

/// Half of the 95 % interval of a mean about `centre`, of values that lie `distances` off it.
fn half(distances: impl Iterator<Item = f64> + Clone) -> f64 {
    let n = distances.clone().count();
    let squares: f64 = distances.map(|d| d * d).sum();
    T[n - 2] * (squares / (n - 1) as f64 / n as f64).sqrt()
}

/// The 95 % interval of a mean; none of a single value.
pub fn interval(values: &[f64]) -> Option<[f64; 2]> {
    let centre = mean(values);
    let half = (values.len() > 1).then(|| half(values.iter().map(|value| value - centre)))?;
    Some([centre - half, centre + half])
}

/// The interval of `a` minus `b`, paired.
pub fn paired(a: &[f64], b: &[f64]) -> Option<[f64; 2]> {
    let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    interval(&differences)
}

/// Expected figures by the names of their columns without units; none where a cell is empty.
pub type Expected = BTreeMap<&'static str, Option<f64>>;

/// On which patterns the runs of several methods or values are compared: on those on which
/// all of them have a steady state, if these are half of the patterns, else each on its own.
/// Who has fewer than half of his own takes no part.
pub fn counted(all: &[&[Raw]]) -> Vec<Vec<bool>> {
    let steady =
        |runs: &[Raw]| -> Vec<bool> { runs.iter().map(|run| run.steady.is_ok()).collect() };
    let own: Vec<Vec<bool>> = all.iter().map(|runs| steady(runs)).collect();
    let half = |of: &[bool]| {
        let count = of.iter().filter(|steady| **steady).count();
        count > 0 && 2 * count >= of.len()
    };
    let part: Vec<&Vec<bool>> = own.iter().filter(|own| half(own)).collect();
    let common = (0..own[0].len()).map(|pattern| part.iter().all(|own| own[pattern]));
    let common: Vec<bool> = common.collect();
    let beside = |own: &Vec<bool>| match half(own) && half(&common) {
        true => common.clone(),
        false => own.clone(),
    };
    own.iter().map(beside).collect()
}

/// Adds the throughput of `runs`, over those that `counts` says.
pub fn add_throughput(to: &mut Expected, runs: &[Raw], counts: &[bool]) {
    let steady = runs.iter().zip(counts).filter(|(_, counts)| **counts);
    let steady: Vec<_> = steady
        .map(|(run, _)| run.steady.as_ref().unwrap())
        .collect();
    let enough = !steady.is_empty() && 2 * steady.len() >= runs.len();
    let flow = |run: &Raw| match &run.steady {
        Ok(steady) => steady.flow,
        Err(unsteady) => unsteady.flow.unwrap(),
    };
    let flows: Vec<f64> = match enough {
        true => steady.iter().map(|steady| steady.flow).collect(),
        false => runs.iter().map(flow).collect(),
    };
    let flow = mean(&flows);
    to.insert("flow", Some(flow));
    to.insert("steady_patterns", Some(steady.len() as f64));
    let names = ["throughput", "throughput_low", "throughput_high"];
    to.extend(names.map(|name| (name, None)));
    if !enough {
        return;
    }
    let throughputs: Vec<f64> = steady.iter().map(|s| s.throughput).collect();
    let centre = mean(&throughputs);
    // Of the picked share: what a pattern's flow is off the mean is not the line's doing.
    let off = steady.iter().map(|s| s.throughput - centre / flow * s.flow);
    let [low, high] = match &steady[..] {
        [one] => one.interval.map(|i| [i.low, i.high]).unwrap(),
        _ => [centre - half(off.clone()), centre + half(off)],
    };
    let ends = [centre, low.max(0.0), high.min(flow.max(centre))];
    to.extend(names.into_iter().zip(ends.map(Some)));
}

/// Adds mean and interval of the shares picked and of the rates.
pub fn add_rates(to: &mut Expected, runs: &[Raw]) {
    let shares: Vec<f64> = runs.iter().map(Raw::share).collect();
    let rates: Vec<f64> = runs.iter().map(Raw::rate).collect();
    let shares_95 = interval(&shares).map(|ends| ends.map(|end| end.clamp(0.0, 1.0)));
    to.insert("picked_share", Some(mean(&shares)));
    to.insert("picked_share_low", shares_95.map(|ends| ends[0]));
    to.insert("picked_share_high", shares_95.map(|ends| ends[1]));
    let rates_95 = interval(&rates).map(|ends| ends.map(|end| end.max(0.0)));
    to.insert("picking_rate", Some(mean(&rates)));
    to.insert("picking_rate_low", rates_95.map(|ends| ends[0]));
    to.insert("picking_rate_high", rates_95.map(|ends| ends[1]));
    to.insert("weighted_rate", Some(mean_of(runs, Raw::weighted_rate)));
}

pub fn assert_near(found: Option<f64>, expected: Option<f64>, what: &str) {
    let near = match (found, expected) {
        (Some(found), Some(expected)) => (found - expected).abs() <= 1e-7 * expected.abs().max(1.0),
        (None, None) => true,
        _ => false,
    };
    assert!(near, "{what}: {found:?}, expected {expected:?}");
}

/// The name of a column without its unit.
pub fn plain_name(column: &str) -> String {
    column.replace("_per_min", "")
}

/// Holds the numbers of a JSON object to `expected`; every one of them must be expected.
pub fn assert_object(object: &Value, expected: &Expected, what: &str) {
    for (name, value) in object.as_object().unwrap() {
        if value.is_number() || value.is_null() {
            let plain = plain_name(name);
            let of = expected.get(plain.as_str());
            let of = of.unwrap_or_else(|| panic!("{what}: nothing is known of {name}"));
            assert_near(value.as_f64(), *of, &format!("{what}: {name}"));
        }
    }
}

/// Holds the numbers of a row of a CSV file to `expected`. Columns named in `words` hold
/// text, all others must be expected.
pub fn assert_row(
    header: &[String],
    row: &[String],
    words: &[&str],
    expected: &Expected,
    what: &str,
) {
    for (name, cell) in header.iter().zip(row) {
        if words.contains(&name.as_str()) {
            continue;
        }
        let plain = plain_name(name);
        let of = expected.get(plain.as_str());
        let of = of.unwrap_or_else(|| panic!("{what}: nothing is known of {name}"));
        let found = (!cell.is_empty()).then(|| cell.parse().unwrap());
        assert_near(found, *of, &format!("{what}: {name}"));
    }
}

/// The cells of the rows of a table for a terminal, its header first.
pub fn table_rows(text: &str) -> Vec<Vec<String>> {
    let lines = text.lines().filter(|line| line.starts_with('|'));
    let cells = |line: &str| -> Vec<String> {
        let inner = line.trim().trim_start_matches('|').trim_end_matches('|');
        inner
            .split('|')
            .map(|cell| cell.trim().to_owned())
            .collect()
    };
    let rows = lines.map(cells);
    rows.filter(|row| !row[0].starts_with("--") && !row[0].starts_with(":-"))
        .collect()
}

/// A number as tables show it; nothing where there is none.
pub fn shown(value: Option<f64>, digits: usize) -> String {
    let text = value.map_or(String::new(), |value| format!("{value:.digits$}"));
    match text.strip_prefix('-') {
        Some(rest) if rest.trim_matches(['0', '.']).is_empty() => rest.to_owned(),
        _ => text,
    }
}

/// An interval as tables show it.
pub fn shown_interval(low: Option<f64>, high: Option<f64>, digits: usize) -> String {
    match low {
        Some(_) => format!("{} to {}", shown(low, digits), shown(high, digits)),
        None => "-".into(),
    }
}

/// Every assignment of two robots, in registry order.
pub fn assignments() -> Vec<RuleAssignment> {
    let rules = ["FIFO", "SPT", "LPT", "SD", "LD", "PP"];
    let all = rules
        .iter()
        .flat_map(|a| rules.iter().map(move |b| format!("{a},{b}")));
    all.map(|text| text.parse().unwrap()).collect()
}
