//! A comparison of methods: the paper's Tables 2 and 3 for the user's own line.

use crate::bound::CaseBoundReport;
use crate::provenance::Provenance;
use crate::table::cell;
use crate::throughput::ThroughputReport;
use pickline::experiment::paper::{self, Printed};
use pickline::experiment::{CaseResult, Comparison, Method};
use pickline::stats::Interval;
use pickline::strategies::is_policy;
use serde::Serialize;

/// A comparison as printed and written; the JSON field names are the product's format.
#[derive(Debug, Clone, Serialize)]
pub struct ComparisonReport {
    /// The methods; the others are compared with the first.
    pub methods: Vec<MethodReport>,
    /// The cases.
    pub cases: Vec<CaseReport>,
    /// Remarks for the reader.
    pub notes: Vec<String>,
    /// Where the result comes from.
    pub made: Provenance,
    #[serde(skip)]
    pub(super) with_paper: bool,
}

/// One method.
#[derive(Debug, Clone, Serialize)]
pub struct MethodReport {
    /// Its name in files.
    pub id: String,
    /// Its name in tables.
    pub title: String,
}

/// One case: a kind of pattern, with the results of all methods.
#[derive(Debug, Clone, Serialize)]
pub struct CaseReport {
    /// Its name.
    pub name: String,
    /// Items in each pattern.
    pub items: usize,
    /// Number of patterns.
    pub patterns: usize,
    /// The results, one per method.
    pub results: Vec<ResultReport>,
    /// What no strategy can exceed, if the bound was requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound: Option<CaseBoundReport>,
    #[serde(skip)]
    pub(super) weighs: bool,
    #[serde(skip)]
    pub(super) runs: Vec<RunRow>,
}

/// One run as a row of a CSV file; what applies only to items with attributes is kept apart.
#[derive(Debug, Clone)]
pub(super) struct RunRow {
    pub(super) cells: [String; 11],
    pub(super) weighted_rate: f64,
}

/// One method on one case.
#[derive(Debug, Clone, Serialize)]
pub struct ResultReport {
    /// The method's name in files.
    pub method: String,
    /// Picks per minute in the steady state.
    #[serde(flatten)]
    pub throughput: ThroughputReport,
    /// Mean share of the items picked.
    pub picked_share: f64,
    /// Lower end of its 95 % interval; `None` for a single pattern, as for all intervals below.
    pub picked_share_low: Option<f64>,
    /// Upper end of its 95 % interval.
    pub picked_share_high: Option<f64>,
    /// Mean end of the run [s].
    pub end_s: f64,
    /// Mean picks per minute over the whole run.
    pub picking_rate_per_min: f64,
    /// Lower end of its 95 % interval.
    pub picking_rate_low: Option<f64>,
    /// Upper end of its 95 % interval.
    pub picking_rate_high: Option<f64>,
    /// Mean reward-weighted picks per minute.
    pub weighted_rate_per_min: f64,
    /// Lower end of the 95 % interval of this rate minus the first method's rate.
    pub diff_low: Option<f64>,
    /// Upper end of that interval.
    pub diff_high: Option<f64>,
    /// Excess of its mean rate over the first method's [%].
    pub benefit_percent: f64,
    /// Picks over all patterns as a proven share of the optimum [%].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certified_percent: Option<f64>,
    /// Its mean rate as a proven share of the highest rate [%].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certified_rate_percent: Option<f64>,
    /// The paper's figures for it, if the paper prints any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paper: Option<PrintedReport>,
}

/// The paper's own figures.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct PrintedReport {
    /// Items picked [%], Table 2.
    pub picked_percent: f64,
    /// Time [s], Table 2.
    pub time_s: f64,
    /// Picks per minute, Table 3.
    pub picking_rate_per_min: f64,
}

impl ComparisonReport {
    /// The report of `comparison`. `paper_cases`: its first cases are the paper's four;
    /// `with_paper`: the table shows the paper's figures.
    pub fn new(
        comparison: &Comparison,
        paper_cases: bool,
        with_paper: bool,
        mut notes: Vec<String>,
        made: Provenance,
    ) -> Self {
        let methods = &comparison.methods;
        let cases = comparison.cases.iter().enumerate().map(|(i, case)| {
            let printed = paper_cases.then(|| paper::CASES.get(i)).flatten();
            case_report(case, comparison, printed)
        });
        let cases: Vec<CaseReport> = cases.collect();
        notes.extend(throughput_note(&cases));
        notes.extend(changing_note(&cases));
        if with_paper {
            notes.extend(paper::REMARKS.map(str::to_owned));
        }
        Self {
            methods: methods
                .iter()
                .map(|method| MethodReport {
                    id: method.id().to_owned(),
                    title: method.title(),
                })
                .collect(),
            cases,
            notes,
            made,
            with_paper,
        }
    }

    /// Whether items of some case have attributes, so that weight differs from the count.
    pub(super) fn weighs(&self) -> bool {
        self.cases.iter().any(|case| case.weighs)
    }

    /// Whether some method reaches a steady state on some case.
    pub(super) fn is_steady(&self) -> bool {
        let mut results = self.cases.iter().flat_map(|case| &case.results);
        results.any(|result| result.throughput.throughput_per_min.is_some())
    }
}

/// The cases without a throughput, and why.
fn throughput_note(cases: &[CaseReport]) -> Option<String> {
    let missing = |case: &&CaseReport| {
        let mut results = case.results.iter();
        results.any(|result| result.throughput.no_throughput.is_some())
    };
    let without: Vec<&CaseReport> = cases.iter().filter(missing).collect();
    let results = without.first()?.results.iter();
    let why = results
        .filter_map(|r| r.throughput.no_throughput.as_ref())
        .next()?;
    let names: Vec<&str> = without.iter().map(|case| case.name.as_str()).collect();
    Some(format!(
        "no throughput on {}; on the first of these {why}",
        names.join("; ")
    ))
}

/// The cases in which the flow changes, so that the throughput is a mean over the pattern.
fn changing_note(cases: &[CaseReport]) -> Option<String> {
    let changing = |case: &&CaseReport| {
        let mut results = case.results.iter();
        results.any(|result| result.throughput.flow_changes)
    };
    let cases = cases.iter().filter(changing);
    let names: Vec<&str> = cases.map(|case| case.name.as_str()).collect();
    (!names.is_empty()).then(|| {
        format!(
            "throughput: the flow changes over patterns of {}; there it is the mean over the pattern",
            names.join("; ")
        )
    })
}

fn case_report(
    result: &CaseResult,
    comparison: &Comparison,
    printed: Option<&paper::PaperCase>,
) -> CaseReport {
    let paper = |method: &Method| -> Option<PrintedReport> {
        let Printed { picked, time, rate } = match method {
            Method::Robust(_) => printed?.robust,
            Method::Greedy(_) => printed?.greedy,
            // Compared with the paper's figures whatever the policy.
            Method::Strategy(other) if is_policy(other.name()) => printed?.rl,
            Method::Strategy(_) => return None,
        };
        Some(PrintedReport {
            picked_percent: picked,
            time_s: time,
            picking_rate_per_min: rate,
        })
    };
    let methods = &comparison.methods;
    let items = result.methods[0].runs[0].figures.items;
    let mut runs = Vec::new();
    for (i, seed) in result.seeds.iter().enumerate() {
        for (method, of) in methods.iter().zip(&result.methods) {
            let run = &of.runs[i];
            let f = &run.figures;
            let assignment = match method {
                Method::Robust(rules) => Some(rules),
                _ => run.chosen.as_ref(),
            };
            let steady = run.steady.as_ref();
            let flow = steady.map_or_else(|no| no.flow, |steady| Some(steady.flow));
            let cells = [
                result.case.name.clone(),
                // Also where nothing is random, so that the column holds whole numbers only.
                seed.unwrap_or(comparison.first_seed).to_string(),
                method.id().to_owned(),
                f.items.to_string(),
                f.picked.to_string(),
                f.end.to_string(),
                cell(steady.ok().map(|steady| steady.throughput)),
                cell(flow),
                f.picking_rate().to_string(),
                result
                    .bound
                    .as_ref()
                    .map_or(String::new(), |bound| bound.picks[i].to_string()),
                assignment
                    .map(|rules| rules.names().join(" "))
                    .unwrap_or_default(),
            ];
            runs.push(RunRow {
                cells,
                weighted_rate: f.weighted_rate(),
            });
        }
    }
    CaseReport {
        name: result.case.name.clone(),
        items,
        patterns: result.seeds.len(),
        weighs: result.weighs,
        bound: result.bound.as_ref().map(CaseBoundReport::new),
        results: methods
            .iter()
            .zip(&result.methods)
            .enumerate()
            .map(|(i, (method, of))| {
                let (picked_share_low, picked_share_high) =
                    Interval::ends(of.picked_share_interval);
                let (picking_rate_low, picking_rate_high) =
                    Interval::ends(of.picking_rate_interval);
                let (diff_low, diff_high) = Interval::ends(of.difference);
                ResultReport {
                    method: method.id().to_owned(),
                    throughput: ThroughputReport::new(&of.throughput),
                    picked_share: of.picked_share,
                    picked_share_low,
                    picked_share_high,
                    end_s: of.end,
                    picking_rate_per_min: of.picking_rate,
                    picking_rate_low,
                    picking_rate_high,
                    weighted_rate_per_min: of.weighted_rate,
                    diff_low,
                    diff_high,
                    benefit_percent: 100.0 * of.benefit,
                    certified_percent: result.bound.as_ref().map(|bound| bound.certified[i]),
                    certified_rate_percent: result.bound.as_ref().and_then(|b| b.certified_rate[i]),
                    paper: paper(method),
                }
            })
            .collect(),
        runs,
    }
}
