//! A comparison of methods: the paper's Tables 2 and 3 for the user's own line.

use crate::bound::CaseBoundReport;
use crate::classes::ClassReport;
use crate::csv_rows::{Displayed, OptionalNumber};
use crate::presentation::Presentation;
use crate::provenance::Provenance;
use crate::purity::{PageGroup, PurityByBinReport, PurityRow};
use crate::throughput::ThroughputReport;
use pickline::experiment::paper::{self, Printed};
use pickline::experiment::{CaseResult, Comparison, Method};
use pickline::stats::Interval;
use pickline::strategies::is_policy;
use pickline::study::Compared;
use serde::Serialize;

/// A comparison as printed and written; the JSON field names are the product's format.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct ComparisonReport {
    /// The methods; the others are compared with the first.
    pub methods: Vec<MethodReport>,
    /// The completed cases, in the order in which they were given.
    pub cases: Vec<CaseReport>,
    /// Remarks on how the figures are to be read.
    pub notes: Vec<String>,
    /// Where the result comes from.
    pub made: Provenance,
    #[serde(skip)]
    pub(super) with_paper: bool,
}

/// Names of a compared method.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct MethodReport {
    /// Name in files: `robust_gt`, `greedy_gt`, or the strategy as it is written.
    pub id: String,
    /// Name in tables, for people.
    pub title: String,
}

/// One case: a kind of pattern, with the results of all methods.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct CaseReport {
    /// Name of the case.
    pub name: String,
    /// Number of items in each pattern.
    pub items: usize,
    /// Number of patterns of the case.
    pub patterns: usize,
    /// The results, one per method.
    pub results: Vec<MethodResultReport>,
    /// What no strategy can exceed, if the bound was requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound: Option<CaseBoundReport>,
    #[serde(skip)]
    pub(super) weighs: bool,
    #[serde(skip)]
    pub(super) runs: Vec<RunRow>,
}

/// One run as a row of a CSV file.
#[derive(Debug, Clone, Default, Serialize)]
pub(super) struct RunRow {
    case: String,
    pattern_seed: u64,
    method: String,
    items: usize,
    picked: usize,
    end_s: Displayed,
    throughput_per_min: OptionalNumber,
    flow_per_min: OptionalNumber,
    picking_rate_per_min: Displayed,
    picks_upper_bound: Option<usize>,
    assignment: String,
    /// Left out unless detections may be wrong, as the next one.
    rightly_binned: Option<usize>,
    due: Option<usize>,
    /// Left out where no item has attributes.
    weighted_rate_per_min: Displayed,
}

/// One method on one case.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct MethodResultReport {
    /// The method's name in files.
    pub method: String,
    /// Picks per minute in the steady state.
    #[serde(flatten)]
    pub throughput: ThroughputReport,
    /// Mean share of the items picked.
    pub picked_share: f64,
    /// 95 % interval of that share; `None` for a single pattern, as for all intervals below.
    #[serde(flatten, serialize_with = "crate::ends::picked_share")]
    pub picked_share_interval: Option<Interval>,
    /// Mean end of the run [s].
    pub end_s: f64,
    /// Mean picks per minute over the whole run.
    pub picking_rate_per_min: f64,
    /// 95 % interval of that rate [1/min].
    #[serde(flatten, serialize_with = "crate::ends::picking_rate")]
    pub picking_rate_interval: Option<Interval>,
    /// Mean reward-weighted picks per minute.
    pub weighted_rate_per_min: f64,
    /// 95 % interval of its picking rate minus the first method's, paired over patterns [1/min].
    #[serde(flatten, serialize_with = "crate::ends::difference")]
    pub difference: Option<Interval>,
    /// Excess of its mean rate over the first method's [%].
    pub benefit_percent: f64,
    /// Picks over all patterns as a proven share of the optimum [%].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certified_percent: Option<f64>,
    /// Its mean rate as a proven share of the highest rate [%].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certified_rate_percent: Option<f64>,
    /// Purity and recovery of the bins; omitted unless detections may be wrong.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sorting: Option<PurityByBinReport>,
    /// What it picked of each class; omitted if no item has a class that matters on the station.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub classes: Vec<ClassReport>,
    /// The paper's figures for it, if the paper prints any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paper: Option<PrintedReport>,
}

/// The figures that the paper prints for a method on a case.
#[derive(Debug, Clone, Copy, Serialize)]
#[non_exhaustive]
pub struct PrintedReport {
    /// Items picked [%], Table 2.
    pub picked_percent: f64,
    /// Time [s], Table 2.
    pub time_s: f64,
    /// Picks per minute, Table 3.
    pub picking_rate_per_min: f64,
}

impl ComparisonReport {
    /// The report of a study made as `made` says, which is completed by how far it got.
    /// `paper_cases` and `with_paper` are as for [`ComparisonReport::new`].
    pub fn of_study(
        compared: &Compared,
        paper_cases: bool,
        with_paper: bool,
        shown: &Presentation,
        made: Provenance,
    ) -> Self {
        let comparison = &compared.comparison;
        let (done, planned) = (comparison.cases.len(), comparison.planned);
        let made = made.of_parts(done, planned, "cases").of_parts(
            compared.bounded,
            planned,
            "cases' bounds",
        );
        let notes = shown.notes(&compared.notes);
        Self::new(comparison, paper_cases, with_paper, notes, made)
    }

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

    /// Whether detections may be wrong, so that bins have a purity.
    pub(super) fn has_purity(&self) -> bool {
        let mut results = self.cases.iter().flat_map(|case| &case.results);
        results.any(|result| result.sorting.is_some())
    }

    /// The purities of every method on every case, as rows of a table.
    pub(super) fn purities(&self) -> Vec<Vec<PurityRow<'_>>> {
        let mut rows = Vec::new();
        for (i, case) in self.cases.iter().enumerate() {
            for (j, result) in case.results.iter().enumerate() {
                let name = if j == 0 { case.name.as_str() } else { "" };
                let path = format!("cases.{i}.results.{j}.sorting");
                let group = PageGroup::Words(name.to_owned());
                let purity = result.sorting.as_ref();
                let method = &self.methods[j].title;
                rows.extend(purity.map(|purity| PurityRow::all(group, method, purity, &path)));
            }
        }
        rows
    }

    /// Every class of every method on every case.
    pub(super) fn classes(&self) -> impl Iterator<Item = &ClassReport> {
        let results = self.cases.iter().flat_map(|case| &case.results);
        results.flat_map(|result| &result.classes)
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
    let methods = comparison.methods.iter().zip(&result.methods).enumerate();
    let bound = result.bound.as_ref();
    CaseReport {
        name: result.case.name.clone(),
        items: result.methods[0].runs[0].figures.items,
        patterns: result.seeds.len(),
        weighs: result.weighs,
        bound: bound.map(CaseBoundReport::new),
        results: methods
            .map(|(i, (method, of))| MethodResultReport {
                method: method.id().to_owned(),
                throughput: ThroughputReport::new(&of.throughput),
                picked_share: of.picked_share,
                picked_share_interval: of.picked_share_interval,
                end_s: of.end,
                picking_rate_per_min: of.picking_rate,
                picking_rate_interval: of.picking_rate_interval,
                weighted_rate_per_min: of.weighted_rate,
                difference: of.difference,
                benefit_percent: 100.0 * of.benefit,
                certified_percent: bound.map(|bound| bound.certified[i]),
                certified_rate_percent: bound.and_then(|bound| bound.certified_rate[i]),
                sorting: of.purity.as_ref().map(PurityByBinReport::new),
                classes: ClassReport::all(&of.classes),
                paper: printed.and_then(|printed| printed_report(method, printed)),
            })
            .collect(),
        runs: run_rows(result, comparison),
    }
}

/// The paper's figures for `method` on a case.
fn printed_report(method: &Method, case: &paper::PaperCase) -> Option<PrintedReport> {
    let Printed { picked, time, rate } = match method {
        Method::Robust(_) => case.robust,
        Method::Greedy(_) => case.greedy,
        // Compared with the paper's figures whatever the policy.
        Method::Strategy(other) if is_policy(other.name()) => case.rl,
        Method::Strategy(_) => return None,
    };
    Some(PrintedReport {
        picked_percent: picked,
        time_s: time,
        picking_rate_per_min: rate,
    })
}

/// Every run of a case, pattern by pattern.
fn run_rows(result: &CaseResult, comparison: &Comparison) -> Vec<RunRow> {
    let mut rows = Vec::new();
    for (i, seed) in result.seeds.iter().enumerate() {
        for (method, of) in comparison.methods.iter().zip(&result.methods) {
            let run = &of.runs[i];
            let figures = &run.figures;
            let total = run.contents.as_ref().map(|contents| contents.total);
            let assignment = match method {
                Method::Robust(rules) => Some(rules),
                _ => run.chosen.as_ref(),
            };
            let steady = run.steady.as_ref();
            let flow = steady.map_or_else(|no| no.flow, |steady| Some(steady.flow));
            rows.push(RunRow {
                case: result.case.name.clone(),
                // Also where nothing is random, so that the column holds whole numbers only.
                pattern_seed: seed.unwrap_or(comparison.first_seed),
                method: method.id().to_owned(),
                items: figures.items,
                picked: figures.picked,
                end_s: Displayed(figures.end),
                throughput_per_min: steady.ok().map(|steady| Displayed(steady.throughput)),
                flow_per_min: flow.map(Displayed),
                picking_rate_per_min: Displayed(figures.picking_rate()),
                picks_upper_bound: result.bound.as_ref().map(|bound| bound.picks[i]),
                assignment: assignment
                    .map(|rules| rules.names().join(" "))
                    .unwrap_or_default(),
                rightly_binned: total.map(|total| total.rightly_binned),
                due: total.map(|total| total.due),
                weighted_rate_per_min: Displayed(figures.weighted_rate()),
            });
        }
    }
    rows
}
