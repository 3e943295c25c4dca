//! A certified bound.

use super::provenance::Provenance;
use super::table::{Table, fixed, interval};
use pickline::decision::Figures;
use pickline::experiment::CaseBound;
use pickline::pattern::Pattern;
use pickline::planning::bound::{Bound, BoundStop, certified_percent};
use pickline::stats::Interval;
use serde::Serialize;

/// A bound as printed and written; the JSON field names are the product's format.
#[derive(Debug, Clone, Serialize)]
pub struct BoundReport {
    /// Items in the pattern.
    pub items: usize,
    /// Items within reach of at least one robot.
    pub reachable: usize,
    /// Upper bound on the picks of every strategy.
    pub picks_upper_bound: usize,
    /// The same bound before rounding down to a whole number.
    pub picks_relaxed: f64,
    /// Upper bound on the sum of weights picked by any strategy; `None` if it was not requested
    /// and does not follow from the picks.
    pub weight_upper_bound: Option<f64>,
    /// Upper bound on the picking rate of every strategy [1/min]; `None` if no finite bound was
    /// found.
    pub picking_rate_upper_bound_per_min: Option<f64>,
    /// Upper bound on the weighted rate of every strategy [1/min].
    pub weighted_rate_upper_bound_per_min: Option<f64>,
    /// Lower bound on the end of every run [s].
    pub end_lower_bound_s: f64,
    /// Whether everything can be picked: `yes` (a schedule does so), `no` (proven) or `open`.
    pub all_picked: &'static str,
    /// Lower bound on the end of every run that picks everything [s]; `None` if there is no
    /// such run.
    pub all_picked_end_lower_bound_s: Option<f64>,
    /// The best schedule found during the search.
    pub schedule: Option<ScheduleReport>,
    /// Length of a time slot [s].
    pub slot_s: f64,
    /// Number of picks in time slots.
    pub arcs: usize,
    /// Steps of the prices: for picks and, if requested, for weight.
    pub iterations: usize,
    /// `optimal`: the schedule reaches the bound; `done`; `interrupted`: the bound still holds;
    /// `too_many_items`: time slots would be too coarse to be useful.
    pub stop_reason: &'static str,
    /// Remarks for the reader.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Where the result comes from.
    pub made: Provenance,
    #[serde(skip)]
    prices: Vec<(String, f64)>,
    /// Whether items have different weights, or the bound on weight was requested.
    #[serde(skip)]
    weighs: bool,
}

/// A schedule confirmed by the independent checker.
#[derive(Debug, Clone, Serialize)]
pub struct ScheduleReport {
    /// Number of items picked.
    pub picked: usize,
    /// Sum of the weights of those items.
    pub weight: f64,
    /// End of the schedule [s].
    pub end_s: f64,
    /// Picks per minute of the schedule.
    pub picking_rate_per_min: f64,
    /// Weighted picks per minute of the schedule.
    pub weighted_rate_per_min: f64,
    /// Picks of the schedule as a proven share of the optimum [%].
    pub certified_percent: f64,
}

/// A run compared with the bound of its pattern.
#[derive(Debug, Clone, Serialize)]
pub struct CertifiedReport {
    /// Upper bound on the picks of every strategy.
    pub picks_upper_bound: usize,
    /// Picks of the run as a proven share of the optimum [%], rounded down.
    pub certified_percent: f64,
    /// Upper bound on the picking rate of every strategy [1/min].
    pub picking_rate_upper_bound_per_min: Option<f64>,
    /// The run's rate as a proven share of the highest rate [%], rounded down.
    pub certified_rate_percent: Option<f64>,
    /// Whether the proof was cut short, so that `pickline bound` would prove more; omitted if
    /// not.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub cut_short: bool,
}

impl CertifiedReport {
    /// Compares `figures` with `bound`, a bound on picks.
    pub fn new(figures: &Figures, bound: &Bound) -> Self {
        let rate = figures.picking_rate();
        Self {
            picks_upper_bound: bound.value as usize,
            certified_percent: certified_percent(bound.earned(figures), bound.value),
            picking_rate_upper_bound_per_min: bound.rate,
            certified_rate_percent: bound.rate.map(|most| certified_percent(rate, most)),
            cut_short: bound.coarse && bound.stop != BoundStop::Optimal,
        }
    }

    /// One line for the terminal.
    pub(super) fn line(&self) -> String {
        let rate = match (
            self.certified_rate_percent,
            self.picking_rate_upper_bound_per_min,
        ) {
            (Some(percent), Some(most)) => format!(
                "; its rate at least {} % (at most {} picks/min)",
                fixed(percent, 1),
                rounded_up(most, 2)
            ),
            _ => String::new(),
        };
        let cut_short = if self.cut_short {
            "          cut short because the pattern is long: `pickline bound` searches longer and \
             proves more; a shorter --slot helps further\n"
        } else {
            ""
        };
        format!(
            "certified at least {} % of the optimum (no strategy picks more than {}){rate}\n{cut_short}",
            fixed(self.certified_percent, 1),
            self.picks_upper_bound
        )
    }
}

impl BoundReport {
    /// The report of the bound on `picks` for `pattern`, with the bound on `weight` if it was
    /// requested.
    pub fn new(pattern: &Pattern, picks: &Bound, weight: Option<&Bound>, made: Provenance) -> Self {
        let main = weight.unwrap_or(picks);
        // If all items weigh the same, weight is picks in another unit.
        let first = pattern.items()[0].reward();
        let equal = pattern.items().iter().all(|item| item.reward() == first);
        // Rounded up by more than the product's rounding error.
        let as_weight = |picks: f64| first * picks * (1.0 + 1e-12);
        let least = |found: Option<f64>, follows: Option<f64>| match (found, follows) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        let schedule = main.schedule.as_ref();
        let complete = [Some(picks), weight].into_iter().flatten().any(|bound| {
            let figures = bound.schedule.as_ref().map(|s| s.figures);
            figures.is_some_and(|figures| figures.complete())
        });
        // Both bounds hold, so the tighter one counts.
        let ends = [Some(picks), weight].into_iter().flatten();
        let end = ends.clone().map(|bound| bound.end).fold(0.0, f64::max);
        let all_end = ends.map(|bound| bound.all_end.unwrap_or(f64::INFINITY));
        let all_end = all_end.fold(0.0, f64::max);
        Self {
            items: pattern.len(),
            reachable: picks.reachable,
            picks_upper_bound: picks.value as usize,
            picks_relaxed: picks.relaxed,
            weight_upper_bound: least(
                weight.map(|bound| bound.value),
                equal.then(|| as_weight(picks.value)),
            ),
            picking_rate_upper_bound_per_min: picks.rate,
            weighted_rate_upper_bound_per_min: least(
                weight.and_then(|bound| bound.rate),
                picks.rate.filter(|_| equal).map(as_weight),
            ),
            end_lower_bound_s: end,
            all_picked: match all_end.is_finite() {
                _ if complete => "yes",
                true => "open",
                false => "no",
            },
            all_picked_end_lower_bound_s: Some(all_end).filter(|end| end.is_finite()),
            schedule: schedule.map(|outcome| ScheduleReport {
                picked: outcome.figures.picked,
                weight: outcome.figures.weight,
                end_s: outcome.figures.end,
                picking_rate_per_min: outcome.figures.picking_rate(),
                weighted_rate_per_min: outcome.figures.weighted_rate(),
                certified_percent: certified_percent(main.earned(&outcome.figures), main.value),
            }),
            slot_s: main.slot_s,
            arcs: main.arcs,
            iterations: picks.iterations + weight.map_or(0, |bound| bound.iterations),
            stop_reason: main.stop.name(),
            notes: Vec::new(),
            made,
            weighs: weight.is_some() || pattern.has_attributes(),
            prices: pattern
                .items()
                .iter()
                .map(|item| item.id.clone())
                .zip(main.prices.iter().copied())
                .collect(),
        }
    }

    /// The figures by their names in files; `None` becomes an empty field.
    fn rows(&self) -> Vec<(&'static str, Option<String>)> {
        let text = |value: Option<f64>| value.map(|value| value.to_string());
        let of = |figure: fn(&ScheduleReport) -> f64| text(self.schedule.as_ref().map(figure));
        vec![
            (
                "picks_upper_bound",
                Some(self.picks_upper_bound.to_string()),
            ),
            ("picks_relaxed", text(Some(self.picks_relaxed))),
            ("weight_upper_bound", text(self.weight_upper_bound)),
            (
                "picking_rate_upper_bound_per_min",
                text(self.picking_rate_upper_bound_per_min),
            ),
            (
                "weighted_rate_upper_bound_per_min",
                text(self.weighted_rate_upper_bound_per_min),
            ),
            ("end_lower_bound_s", text(Some(self.end_lower_bound_s))),
            (
                "all_picked_end_lower_bound_s",
                text(self.all_picked_end_lower_bound_s),
            ),
            ("schedule_picked", of(|s| s.picked as f64)),
            ("schedule_weight", of(|s| s.weight)),
            ("schedule_end_s", of(|s| s.end_s)),
        ]
    }

    /// The figures as CSV, one per line.
    pub fn to_csv(&self) -> String {
        let header = ["figure", "value"].map(str::to_owned);
        let rows = self.rows().into_iter();
        let rows = rows.map(|(name, value)| [name.to_owned(), value.unwrap_or_default()]);
        self.made.csv(std::iter::once(header).chain(rows))
    }

    /// The price of every item as CSV: what picking it costs the other items.
    pub fn prices_csv(&self) -> String {
        let header = ["item", "price"].map(str::to_owned);
        let rows = self.prices.iter();
        let rows = rows.map(|(id, price)| [id.clone(), price.to_string()]);
        self.made.csv(std::iter::once(header).chain(rows))
    }

    /// The bound as text for the terminal.
    pub fn to_table(&self) -> String {
        let up = |value: Option<f64>, digits: usize| {
            value.map_or("-".to_owned(), |value| rounded_up(value, digits))
        };
        let of = |figure: &dyn Fn(&ScheduleReport) -> String| {
            self.schedule.as_ref().map_or("-".to_owned(), figure)
        };
        let mut table = Table::new(&["<figure", "no strategy beats", "a schedule has", "<unit"]);
        table.row([
            "items picked, at most".to_owned(),
            self.picks_upper_bound.to_string(),
            of(&|s| s.picked.to_string()),
            format!("of {}", self.items),
        ]);
        if self.weighs && self.weight_upper_bound.is_some() {
            table.row([
                "weight picked, at most".to_owned(),
                up(self.weight_upper_bound, 3),
                of(&|s| fixed(s.weight, 3)),
                String::new(),
            ]);
        }
        table.row([
            "picking rate, at most".to_owned(),
            up(self.picking_rate_upper_bound_per_min, 2),
            of(&|s| fixed(s.picking_rate_per_min, 2)),
            "1/min".into(),
        ]);
        if self.weighs && self.weighted_rate_upper_bound_per_min.is_some() {
            table.row([
                "weighted rate, at most".to_owned(),
                up(self.weighted_rate_upper_bound_per_min, 2),
                of(&|s| fixed(s.weighted_rate_per_min, 2)),
                "1/min".into(),
            ]);
        }
        table.row([
            "end of the run, at least".to_owned(),
            rounded_down(self.end_lower_bound_s, 1),
            of(&|s| fixed(s.end_s, 1)),
            "s".into(),
        ]);
        let all = match (self.all_picked, self.all_picked_end_lower_bound_s) {
            ("no", _) | (_, None) => "not everything can be picked (proven)".to_owned(),
            (all_picked, Some(end)) => format!(
                "{}; no run that picks everything ends before {} s",
                if all_picked == "yes" {
                    "everything can be picked: the schedule does so"
                } else {
                    "whether everything can be picked is open"
                },
                rounded_down(end, 1)
            ),
        };
        let share = self.schedule.as_ref().map_or(String::new(), |schedule| {
            format!(
                "schedule  certified: at least {} % of the optimum, confirmed by the independent checker\n",
                fixed(schedule.certified_percent, 1)
            )
        });
        format!(
            "{}{share}all       {all}\nreach     {} of {} items are within reach\n\
             search    {} steps, slots of {} s, {} picks in slots, {}\n{}{}",
            table.render(),
            self.reachable,
            self.items,
            self.iterations,
            self.slot_s,
            self.arcs,
            self.stop_reason.replace('_', " "),
            self.notes
                .iter()
                .map(|note| format!("note      {note}\n"))
                .collect::<String>(),
            self.made.lines(),
        )
    }
}

/// An upper bound rounded up to `digits` decimals.
pub(crate) fn rounded_up(value: f64, digits: usize) -> String {
    let power = 10f64.powi(digits as i32);
    // A value that is only a rounding error above a printable number is that number.
    fixed(((value * power) * (1.0 - 1e-11)).ceil() / power, digits)
}

/// A lower bound rounded down to `digits` decimals.
fn rounded_down(value: f64, digits: usize) -> String {
    let power = 10f64.powi(digits as i32);
    fixed(((value * power) * (1.0 + 1e-11)).floor() / power, digits)
}

/// The bound for one case of a comparison.
#[derive(Debug, Clone, Serialize)]
pub struct CaseBoundReport {
    /// Mean of the most items that can be picked from a pattern.
    pub picks_upper_bound: f64,
    /// The same as a share of the items.
    pub picked_share: f64,
    /// Mean of the highest possible rates [1/min].
    pub picking_rate_per_min: Option<f64>,
    /// 95 % interval of that mean minus the first method's rate, paired over patterns; `None`
    /// for a single pattern.
    pub difference: Option<Interval>,
    /// Excess over the first method's mean rate [%].
    pub benefit_percent: Option<f64>,
}

impl CaseBoundReport {
    pub(super) fn new(bound: &CaseBound) -> Self {
        Self {
            picks_upper_bound: bound.picks.iter().sum::<usize>() as f64 / bound.picks.len() as f64,
            picked_share: bound.picked_share,
            picking_rate_per_min: bound.picking_rate,
            difference: bound.difference,
            benefit_percent: bound.benefit.map(|benefit| 100.0 * benefit),
        }
    }

    /// Its row in a comparison of `columns` columns; `before` columns after the methods' names
    /// stay empty.
    pub(super) fn row(&self, before: usize, columns: usize) -> Vec<String> {
        let up = |value: Option<f64>| value.map_or(String::new(), |value| rounded_up(value, 1));
        let mut row = vec![String::new(), "bound: no strategy beats".to_owned()];
        row.resize(2 + before, String::new());
        row.extend([
            rounded_up(100.0 * self.picked_share, 1),
            String::new(),
            up(self.picking_rate_per_min),
            interval(self.difference.map(|d| (d.low, d.high)), 2),
            up(self.benefit_percent),
        ]);
        row.resize(columns, String::new());
        row
    }
}
