//! A sweep: figures over one varied quantity, and up to which value everything is picked.

use super::bound::rounded_up;
use super::provenance::Provenance;
use super::table::{Table, cell, column, fixed, interval, without_empty_columns};
use super::throughput::ThroughputReport;
use pickline::clearance::MARGIN;
use pickline::experiment::{AS_GOOD, Axis, Limit, Sweep, SweepBound, SweepPoint, paper};
use pickline::stats::{self, Interval};
use pickline::throughput::UnsteadyReason;
use serde::Serialize;

/// A sweep as printed and written; the JSON field names are the product's format.
#[derive(Debug, Clone, Serialize)]
pub struct SweepReport {
    /// The varied quantity.
    pub sweep: &'static str,
    /// Unit of the varied quantity.
    pub unit: &'static str,
    /// Number of patterns.
    pub patterns: usize,
    /// All points, ordered by value, then by method.
    pub points: Vec<PointReport>,
    /// Up to which value each method picks everything.
    pub limits: Vec<LimitReport>,
    /// What no strategy can exceed, for each value; omitted if not requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bounds: Option<BoundsReport>,
    /// The paper's limits, if they are comparable with ours.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paper: Option<PaperLimits>,
    /// Remarks for the reader.
    pub notes: Vec<String>,
    /// Where the result comes from.
    pub made: Provenance,
    /// The values at which arms can meet.
    pub arms_can_meet: Vec<f64>,
    /// Number of planned values; more than were run if the user stopped the sweep.
    #[serde(skip)]
    planned: usize,
    #[serde(skip)]
    pub(super) helps: bool,
    #[serde(skip)]
    pub(super) weighs: bool,
}

/// One method at one value.
#[derive(Debug, Clone, Serialize)]
pub struct PointReport {
    /// The value.
    pub value: f64,
    /// The method's name in files.
    pub method: String,
    /// Its name in tables at this value.
    pub title: String,
    /// Picks per minute in the steady state.
    #[serde(flatten)]
    pub throughput: ThroughputReport,
    /// Throughput minus that at the previous value, per robot; omitted unless robots are swept.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub added_per_robot_per_min: Option<f64>,
    /// Mean share of the items picked.
    pub picked_share: f64,
    /// Lower end of its 95 % interval; `None` for a single pattern, as for the rate.
    pub picked_share_low: Option<f64>,
    /// Upper end of its 95 % interval.
    pub picked_share_high: Option<f64>,
    /// Mean picks per minute.
    pub picking_rate_per_min: f64,
    /// Lower end of its 95 % interval.
    pub picking_rate_low: Option<f64>,
    /// Upper end of its 95 % interval.
    pub picking_rate_high: Option<f64>,
    /// Mean reward-weighted picks per minute.
    pub weighted_rate_per_min: f64,
    /// Share of the patterns that were picked completely.
    pub complete_share: f64,
    /// Share of the patterns of which at least 99 % was picked.
    pub nearly_complete_share: f64,
    /// Picks over all patterns as a proven share of the optimum [%]; omitted if not requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certified_percent: Option<f64>,
}

/// What no strategy can exceed, along a sweep.
#[derive(Debug, Clone, Serialize)]
pub struct BoundsReport {
    /// The values at which no strategy picks every item of every pattern (proven).
    pub impossible: Vec<f64>,
    /// One point per value.
    pub points: Vec<BoundPoint>,
}

/// What no strategy can exceed at one value.
#[derive(Debug, Clone, Serialize)]
pub struct BoundPoint {
    /// The value.
    pub value: f64,
    /// Mean of the most items that can be picked, as a share of the items.
    pub picked_share: f64,
    /// Mean of the highest possible rates [1/min]; `None` if some pattern has no finite bound.
    pub picking_rate_per_min: Option<f64>,
}

impl BoundsReport {
    fn new(bounds: &[SweepBound], values: &[f64]) -> Self {
        let points = values.iter().zip(bounds);
        Self {
            impossible: points
                .clone()
                .filter(|(_, bound)| !bound.complete())
                .map(|(&value, _)| value)
                .collect(),
            points: points
                .map(|(&value, bound)| BoundPoint {
                    value,
                    picked_share: bound.picked_share,
                    picking_rate_per_min: bound.picking_rate,
                })
                .collect(),
        }
    }

    /// What is proven about the limits, in words; `helps`: larger values make picking easier.
    pub(super) fn words(&self, helps: bool, unit: &str) -> String {
        let nearest = if helps {
            self.impossible.last()
        } else {
            self.impossible.first()
        };
        let Some(nearest) = nearest else {
            return "that some strategy picks everything is refuted at no value of this sweep"
                .into();
        };
        let (side, beyond) = match helps {
            true => (
                "below",
                self.points.iter().filter(|p| p.value <= *nearest).count(),
            ),
            false => (
                "above",
                self.points.iter().filter(|p| p.value >= *nearest).count(),
            ),
        };
        let further = match (beyond, beyond == self.impossible.len()) {
            (1, _) => String::new(),
            (_, true) => format!(" or at any value {side} it"),
            (_, false) => format!(
                ", nor at {} of the values {side} it",
                self.impossible.len() - 1
            ),
        };
        let unit = unit_of(*nearest, unit);
        format!("no strategy picks everything at {nearest} {unit}{further}; that is proven")
    }
}

/// `unit` in the singular or plural, as `value` requires.
fn unit_of(value: f64, unit: &str) -> &str {
    match unit {
        "robots" if value == 1.0 => "robot",
        unit => unit,
    }
}

/// Up to which value one method picks everything.
#[derive(Debug, Clone, Serialize)]
pub struct LimitReport {
    /// The method's name in files.
    pub method: String,
    /// Highest value up to which every item of every pattern is picked.
    pub highest: Option<f64>,
    /// First value at which an item is missed.
    pub first_miss: Option<f64>,
    /// Values above that at which everything is picked again.
    pub again: Vec<f64>,
    /// Lowest value from which every item of every pattern is picked.
    pub lowest: Option<f64>,
    /// Highest value up to which at least 99 % is picked of 95 % of the patterns.
    pub highest_95_99: Option<f64>,
    /// Minimum, median and maximum of the limits of single patterns; 0 is below the sweep.
    pub of_patterns: [f64; 3],
    /// The limits of single patterns in ascending order, if there are several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub all_of_patterns: Vec<f64>,
    /// Excess over the first method's limit [%].
    pub benefit_percent: Option<f64>,
    /// The recommended value; `None` in a sweep of the belt speed, without a throughput, and if
    /// arms can meet at every value.
    pub recommended: Option<f64>,
}

/// The paper's belt speed limits on the grid of 0.15 m.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct PaperLimits {
    /// Robust GT [m/s].
    pub robust_gt: f64,
    /// The RL policy [m/s].
    pub rl: f64,
    /// Excess of the RL policy's limit over robust GT's [%].
    pub benefit_percent: f64,
}

/// A note that limits on short patterns are not limits of the line, if there are any.
fn short_limit(sweep: &Sweep) -> Option<String> {
    let mut points = sweep.points.iter().flatten();
    let enough = points
        .clone()
        .filter_map(|point| match point.throughput.missing {
            Some(UnsteadyReason::Short { items, .. }) => items,
            _ => None,
        });
    let enough = match enough.max() {
        Some(items) => format!("{items} items or more"),
        None => "more items".to_owned(),
    };
    let short = |point: &SweepPoint| {
        let missing = &point.throughput.missing;
        point.throughput.mean.is_none() && matches!(missing, Some(UnsteadyReason::Short { .. }))
    };
    points.any(short).then(|| {
        format!(
            "a limit on patterns as short as these is that of the patterns: the line picks \
             everything of a few items also where it cannot keep up with their flow for long; for the \
             limit of the line give patterns of {enough} (--items)"
        )
    })
}

impl SweepReport {
    /// The report of `sweep` over `axis`. `ids` are the methods' names in files; `with_paper`:
    /// this is the paper's case.
    pub fn new(
        sweep: &Sweep,
        axis: Axis,
        ids: &[String],
        with_paper: bool,
        notes: Vec<String>,
        made: Provenance,
    ) -> Self {
        let added = |place: usize, method: usize| {
            let before = place.checked_sub(1).filter(|_| axis == Axis::Robots)?;
            let of = |place: usize| &sweep.points[place][method].throughput;
            let robots = sweep.values[place] - sweep.values[before];
            let (here, before) = (of(place), of(before));
            // The flow differs only if other patterns have a steady state.
            let share = here.share()? - before.share()?;
            Some(share * here.flow? / robots)
        };
        let added = &added;
        let points = sweep.values.iter().zip(&sweep.points).enumerate();
        let points = points.flat_map(|(place, (&value, points))| {
            let methods = ids.iter().zip(points).enumerate();
            methods.map(move |(method, (id, point))| {
                let (picked_share_low, picked_share_high) =
                    Interval::ends(point.picked_share_interval);
                let (picking_rate_low, picking_rate_high) =
                    Interval::ends(point.picking_rate_interval);
                PointReport {
                    value,
                    method: id.clone(),
                    title: point.title.clone(),
                    throughput: ThroughputReport::new(&point.throughput),
                    added_per_robot_per_min: added(place, method),
                    picked_share: point.picked_share,
                    picked_share_low,
                    picked_share_high,
                    picking_rate_per_min: point.picking_rate,
                    picking_rate_low,
                    picking_rate_high,
                    weighted_rate_per_min: point.weighted_rate,
                    complete_share: point.complete_share,
                    nearly_complete_share: point.nearly_complete_share,
                    certified_percent: point.certified,
                }
            })
        });
        let first = sweep.complete(0).highest;
        let limit = |(method, id): (usize, &String)| {
            let Limit {
                highest,
                first_miss,
                again,
                lowest,
            } = sweep.complete(method);
            let mut of_patterns = sweep.limits(method);
            of_patterns.sort_by(f64::total_cmp);
            LimitReport {
                method: id.clone(),
                highest,
                first_miss,
                again,
                lowest,
                highest_95_99: sweep.nearly_complete(method, 0.95).highest,
                of_patterns: [0.0, 0.5, 1.0].map(|share| stats::quantile(&of_patterns, share)),
                all_of_patterns: match of_patterns.len() {
                    1 => Vec::new(),
                    _ => of_patterns,
                },
                benefit_percent: first
                    .zip(highest)
                    .filter(|_| method > 0 && !axis.helps())
                    .map(|(first, this)| 100.0 * (this / first - 1.0)),
                recommended: match axis {
                    Axis::Speed => None,
                    _ => sweep.recommended(method),
                },
            }
        };
        let points: Vec<PointReport> = points.collect();
        let throughputs = points.iter().map(|point| &point.throughput);
        let mut notes = notes;
        notes.extend(ThroughputReport::note(throughputs));
        notes.extend(short_limit(sweep).filter(|_| axis == Axis::Speed));
        let meet = sweep.values.iter().zip(&sweep.arms_meet);
        let (robust_gt, rl) = paper::SPEED_LIMITS;
        Self {
            planned: sweep.planned,
            helps: axis.helps(),
            sweep: axis.name(),
            unit: axis.unit(),
            patterns: sweep.limits(0).len(),
            points,
            arms_can_meet: meet
                .filter(|(_, meet)| **meet)
                .map(|(value, _)| *value)
                .collect(),
            weighs: sweep.weighs,
            limits: ids.iter().enumerate().map(limit).collect(),
            bounds: sweep
                .bounds
                .as_ref()
                .map(|bounds| BoundsReport::new(bounds, &sweep.values)),
            paper: with_paper.then(|| PaperLimits {
                robust_gt,
                rl,
                benefit_percent: 100.0 * (rl / robust_gt - 1.0),
            }),
            notes,
            made,
        }
    }

    /// All points and limits for the terminal.
    pub fn to_table(&self) -> String {
        let varied = match self.unit {
            "1" => self.sweep.to_owned(),
            unit => format!("{} [{unit}]", self.sweep),
        };
        let many = self.patterns > 1;
        let mut header = vec![varied.as_str(), "<method"];
        let (steady, adds) = (self.is_steady(), self.adds());
        if steady {
            header.extend(["throughput [1/min]", "95 %", "flow [1/min]"]);
        }
        header.extend(adds.then_some("added a robot [1/min]"));
        header.extend(["picked [%]", "picking rate [1/min]"]);
        header.extend(self.weighs.then_some("weighted [1/min]"));
        if many {
            header.extend(["picking rate, 95 %", "complete [%]", "to 99 % [%]"]);
        }
        let mut bounds = self.bounds.as_ref().map(|bounds| bounds.points.iter());
        if bounds.is_some() {
            header.extend(["certified [%]", "bound: picked [%]", "picking rate [1/min]"]);
        }
        let mut table = Table::new(&header);
        let mut before = None;
        for point in &self.points {
            let mut row = vec![
                if before == Some(point.value) {
                    String::new()
                } else {
                    point.value.to_string()
                },
                point.title.clone(),
            ];
            if steady {
                row.extend(point.throughput.table_cells(1));
            }
            let added = point.added_per_robot_per_min;
            row.extend(adds.then(|| added.map_or(String::new(), |added| fixed(added, 1))));
            row.extend([
                fixed(100.0 * point.picked_share, 1),
                fixed(point.picking_rate_per_min, 2),
            ]);
            row.extend(self.weighs.then(|| fixed(point.weighted_rate_per_min, 2)));
            if many {
                row.extend([
                    interval(point.picking_rate_low.zip(point.picking_rate_high), 2),
                    fixed(100.0 * point.complete_share, 1),
                    fixed(100.0 * point.nearly_complete_share, 1),
                ]);
            }
            let first = before != Some(point.value);
            if let Some(bounds) = &mut bounds {
                // It is the same for all methods, so only the first one's row shows it.
                let bound = if first { bounds.next() } else { None };
                let rate = bound.and_then(|bound| bound.picking_rate_per_min);
                row.extend([
                    point
                        .certified_percent
                        .map_or(String::new(), |c| fixed(c, 1)),
                    bound.map_or(String::new(), |b| rounded_up(100.0 * b.picked_share, 1)),
                    rate.map_or(String::new(), |rate| rounded_up(rate, 2)),
                ]);
            }
            table.row(row);
            before = Some(point.value);
        }
        let mut text = table.render();
        for limit in &self.limits {
            text += &self.limit_line(limit, many);
        }
        for words in self.recommendations(str::to_owned) {
            text += &format!("choose    {words}\n");
        }
        if let Some(words) = self.avoided() {
            text += &format!("avoid     {words}\n");
        }
        if let Some(bounds) = &self.bounds {
            text += &format!("bound     {}\n", bounds.words(self.helps, self.unit_word()));
        }
        if let Some(paper) = &self.paper {
            text += &format!(
                "paper     everything picked up to {} m/s by robust GT, {} m/s by RL (+{} %)\n",
                paper.robust_gt,
                paper.rl,
                fixed(paper.benefit_percent, 1)
            );
        }
        for note in &self.notes {
            text += &format!("note      {note}\n");
        }
        text + &self.made.lines()
    }

    /// Whether there is a throughput at some point.
    pub(super) fn is_steady(&self) -> bool {
        let mut points = self.points.iter();
        points.any(|point| point.throughput.throughput_per_min.is_some())
    }

    /// Whether it is known how much a further robot adds.
    pub(super) fn adds(&self) -> bool {
        let mut points = self.points.iter();
        points.any(|point| point.added_per_robot_per_min.is_some())
    }

    /// Recommended values, one sentence per method; empty in a sweep of the belt speed, which
    /// is the user's choice. `named` gives the name of a method.
    pub(super) fn recommendations(&self, named: impl Fn(&str) -> String) -> Vec<String> {
        if self.sweep == "speed" {
            return Vec::new();
        }
        let unit = self.unit_word();
        // Values that were not run may be better.
        let values = self.points.len() / self.limits.len();
        let gaps = || {
            let points = self.points.iter().step_by(self.limits.len());
            let values: Vec<f64> = points.map(|point| point.value).collect();
            values.windows(2).any(|pair| pair[1] > pair[0] + 1.0)
        };
        let least = match self.sweep {
            "robots" => "the fewest",
            _ => "the least",
        };
        let least = match (values < self.planned, self.sweep) {
            (true, _) => format!(
                "{least} of the {values} (of {}) values that were run",
                self.planned
            ),
            (_, "robots") if gaps() => format!("{least} of the numbers that were run"),
            _ => least.to_owned(),
        };
        let line = |(j, limit): (usize, &LimitReport)| match limit.recommended {
            Some(value) => {
                let mut of_method = self.points.iter().skip(j).step_by(self.limits.len());
                let point = of_method.find(|point| point.value == value);
                let throughput = point.map_or("-".into(), |point| point.throughput.shown(1));
                let unit = unit_of(value, unit);
                format!(
                    "{}: {value} {unit}, {least} with at least {} % of the highest throughput; \
                     {throughput} picks/min",
                    named(&limit.method),
                    100.0 * AS_GOOD
                )
            }
            None if !self.is_steady() => format!(
                "{}: nothing, because there is no throughput (see the note)",
                named(&limit.method)
            ),
            None => format!(
                "{}: nothing, because arms can come too close at every value",
                named(&limit.method)
            ),
        };
        self.limits.iter().enumerate().map(line).collect()
    }

    /// The values at which arms can meet, in words.
    pub(super) fn avoided(&self) -> Option<String> {
        let meet = &self.arms_can_meet;
        let (first, last) = (meet.first()?, meet.last()?);
        let range = match meet.len() {
            1 => first.to_string(),
            count => format!("{first} to {last} ({count} values)"),
        };
        let unit = self.unit_word();
        // The belt's speed moves no arm.
        let words = format!("{range} {unit}: arms can meet, or come closer than {MARGIN} m");
        (self.sweep != "speed").then_some(words)
    }

    /// The unit as written after a value.
    pub(super) fn unit_word(&self) -> &'static str {
        match self.unit {
            "1" => self.sweep,
            unit => unit,
        }
    }

    fn limit_line(&self, limit: &LimitReport, many: bool) -> String {
        let unit = self.unit_word();
        if self.helps {
            return match limit.lowest {
                Some(value) => format!(
                    "limit     {}: everything picked from {value} {unit} on\n",
                    limit.method
                ),
                None => format!("limit     {}: never everything picked\n", limit.method),
            };
        }
        let shown = |value: Option<f64>| match value {
            Some(value) => format!("{value} {unit}"),
            None => "below this sweep".to_owned(),
        };
        let again = if limit.again.is_empty() {
            String::new()
        } else {
            let values: Vec<String> = limit.again.iter().map(f64::to_string).collect();
            format!(", everything again at {}", values.join(", "))
        };
        let miss = match limit.first_miss {
            Some(value) => format!("first miss at {value}{again}"),
            None => "no miss in this sweep".into(),
        };
        let benefit = limit
            .benefit_percent
            .map(|percent| format!(" ({} % against the first)", fixed(percent, 1)))
            .unwrap_or_default();
        let mut text = match limit.highest {
            Some(highest) => format!(
                "limit     {}: everything picked up to {highest} {unit}{benefit}; {miss}\n",
                limit.method
            ),
            None => format!(
                "limit     {}: misses items already at the first value{again}\n",
                limit.method
            ),
        };
        if many {
            let [least, median, greatest] = limit.of_patterns;
            text += &format!(
                "          95 % of the patterns picked to 99 % up to {}; limits of the patterns \
                 {least} to {greatest}, median {median}\n",
                shown(limit.highest_95_99)
            );
        }
        text
    }

    /// Every point as CSV.
    pub fn to_csv(&self) -> String {
        let varied = match self.sweep {
            "speed" => "belt_speed",
            other => other,
        };
        let varied = column(varied, self.unit);
        let mut header = vec![varied.as_str(), "method"];
        header.extend(ThroughputReport::COLUMNS);
        let adds = self.adds();
        header.extend(adds.then_some("added_per_robot_per_min"));
        header.extend([
            "picked_share",
            "picked_share_low",
            "picked_share_high",
            "picking_rate_per_min",
            "picking_rate_low_per_min",
            "picking_rate_high_per_min",
            "complete_share",
            "nearly_complete_share",
            "certified_percent",
            "picked_share_upper_bound",
            "picking_rate_upper_bound_per_min",
        ]);
        header.extend(self.weighs.then_some("weighted_rate_per_min"));
        let header: Vec<String> = header.into_iter().map(str::to_owned).collect();
        let methods = self.limits.len();
        let rows = self.points.iter().enumerate().map(|(i, point)| {
            let bound = self.bounds.as_ref().map(|b| &b.points[i / methods]);
            let mut row = vec![point.value.to_string(), point.method.clone()];
            let figures = [
                Some(point.picked_share),
                point.picked_share_low,
                point.picked_share_high,
                Some(point.picking_rate_per_min),
                point.picking_rate_low,
                point.picking_rate_high,
                Some(point.complete_share),
                Some(point.nearly_complete_share),
                point.certified_percent,
                bound.map(|bound| bound.picked_share),
                bound.and_then(|bound| bound.picking_rate_per_min),
            ];
            row.extend(point.throughput.cells());
            row.extend(adds.then(|| cell(point.added_per_robot_per_min)));
            row.extend(figures.map(cell));
            row.extend(self.weighs.then(|| point.weighted_rate_per_min.to_string()));
            row
        });
        let rows = std::iter::once(header).chain(rows);
        self.made.csv(without_empty_columns(rows))
    }
}
