//! Purity and recovery of the bins, where detections may be wrong: as JSON, CSV, text and tables of
//! pages.

use crate::columns::TableColumns;
use crate::csv_rows::{Displayed, OptionalNumber, high, low};
use crate::page::{Cell, PageFigure};
use crate::table::{fixed, interval};
use pickline::purity::{BinContent, BinContents, Purity, PurityByBin};
use pickline::stats::Interval;
use serde::Serialize;

/// What was put into one or several bins.
#[derive(Debug, Clone, Copy, Serialize)]
#[non_exhaustive]
pub struct BinContentReport {
    /// Number of items that were put in.
    pub binned: usize,
    /// How many of them belong there.
    pub rightly_binned: usize,
    /// Number of items on the belt that belong there, picked or not.
    pub due: usize,
    /// The share of what was put in that belongs there; `None` if nothing was put in.
    pub purity: Option<f64>,
    /// The share of what belongs there that was put in; `None` if nothing belongs there.
    pub recovery: Option<f64>,
}

impl BinContentReport {
    fn new(content: &BinContent) -> Self {
        Self {
            binned: content.binned,
            rightly_binned: content.rightly_binned,
            due: content.due,
            purity: content.purity(),
            recovery: content.recovery(),
        }
    }
}

/// A part of a result that belongs to the bins with one name.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct OfBin<T> {
    /// Name of the bin; bins of several robots with the same name are one.
    pub name: String,
    /// What belongs to it.
    #[serde(flatten)]
    pub of: T,
}

impl<T> OfBin<T> {
    /// The bins of a line that has more than one name of bins; otherwise the total says it all.
    fn all<S>(bins: &[(String, S)], report: impl Fn(&S) -> T) -> Vec<Self> {
        let several = bins.iter().filter(|_| bins.len() > 1);
        let of_bin = |(name, of): &(String, S)| Self {
            name: name.clone(),
            of: report(of),
        };
        several.map(of_bin).collect()
    }
}

/// What one run put into the bins.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct RunPurityReport {
    /// All bins together.
    #[serde(flatten)]
    pub total: BinContentReport,
    /// Each bin; omitted where all bins have the same name.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bins: Vec<OfBin<BinContentReport>>,
}

impl RunPurityReport {
    /// The report of `contents`.
    pub fn new(contents: &BinContents) -> Self {
        Self {
            total: BinContentReport::new(&contents.total),
            bins: OfBin::all(&contents.bins, BinContentReport::new),
        }
    }

    /// The bins for the terminal: a table if there are several, and a line.
    pub(crate) fn text(&self) -> String {
        let share = |share: Option<f64>| fixed(share.map_or(f64::NAN, |share| 100.0 * share), 1);
        let table = TableColumns::new()
            .with("<bin", |bin: &&OfBin<BinContentReport>| bin.name.clone())
            .with("binned", |bin| bin.of.binned.to_string())
            .with("rightly", |bin| bin.of.rightly_binned.to_string())
            .with("due", |bin| bin.of.due.to_string())
            .with("purity [%]", move |bin| share(bin.of.purity))
            .with("recovery [%]", move |bin| share(bin.of.recovery));
        let table = match self.bins.as_slice() {
            [] => String::new(),
            bins => table.table(bins),
        };
        let BinContentReport {
            binned,
            rightly_binned,
            due,
            purity,
            recovery,
        } = self.total;
        format!(
            "{table}purity    {} % ({rightly_binned} of {binned} binned belong there), recovery {} % \
             ({rightly_binned} of {due} due)\n",
            share(purity),
            share(recovery)
        )
    }
}

/// Purity and recovery over several runs, with intervals.
#[derive(Debug, Clone, Copy, Serialize)]
#[non_exhaustive]
pub struct PurityReport {
    /// The items of all runs together.
    #[serde(flatten)]
    pub content: BinContentReport,
    /// 95 % interval of the purity; `None` for a single run, as for the next.
    #[serde(flatten, serialize_with = "crate::ends::purity")]
    pub purity_interval: Option<Interval>,
    /// 95 % interval of the recovery.
    #[serde(flatten, serialize_with = "crate::ends::recovery")]
    pub recovery_interval: Option<Interval>,
}

impl PurityReport {
    /// The report of `purity`.
    pub fn new(purity: &Purity) -> Self {
        Self {
            content: BinContentReport::new(&purity.content),
            purity_interval: purity.purity_interval,
            recovery_interval: purity.recovery_interval,
        }
    }

    /// The figures with their intervals, in words.
    pub(crate) fn words(&self) -> String {
        let share = |name: &str, share: Option<f64>, ends: Option<Interval>| {
            let ends = ends.map(|ends| ends.times(100.0));
            let ends = ends.map_or(String::new(), |ends| {
                format!(", 95 % interval {}", interval(Some(ends), 1))
            });
            match share {
                Some(share) => format!("{name} {} %{ends}", fixed(100.0 * share, 1)),
                None => format!("no {name}"),
            }
        };
        format!(
            "{}; {}",
            share("purity", self.content.purity, self.purity_interval),
            share("recovery", self.content.recovery, self.recovery_interval)
        )
    }
}

/// Purity and recovery over several runs, in total and for each bin.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct PurityByBinReport {
    /// All bins together.
    #[serde(flatten)]
    pub total: PurityReport,
    /// Each bin; omitted where all bins have the same name.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bins: Vec<OfBin<PurityReport>>,
}

impl PurityByBinReport {
    /// The report of `purity`.
    pub fn new(purity: &PurityByBin) -> Self {
        Self {
            total: PurityReport::new(&purity.total),
            bins: OfBin::all(&purity.bins, PurityReport::new),
        }
    }

    /// All bins together and then each, with its name and its path in this report.
    pub(crate) fn parts(&self) -> impl Iterator<Item = (Option<&str>, &PurityReport, String)> {
        let bins = self.bins.iter().enumerate();
        let bins = bins.map(|(place, bin)| {
            let path = format!("bins.{place}.");
            (Some(bin.name.as_str()), &bin.of, path)
        });
        std::iter::once((None, &self.total, String::new())).chain(bins)
    }
}

/// The columns of a CSV file with the purity of bins.
#[derive(Default, Serialize)]
pub(crate) struct PurityColumns<'r> {
    /// Empty for all bins together.
    bin: &'r str,
    binned: usize,
    rightly_binned: usize,
    due: usize,
    purity: OptionalNumber,
    purity_low: OptionalNumber,
    purity_high: OptionalNumber,
    recovery: OptionalNumber,
    recovery_low: OptionalNumber,
    recovery_high: OptionalNumber,
}

impl<'r> PurityColumns<'r> {
    /// The columns for the bin with this name, or for all.
    pub(crate) fn new(bin: Option<&'r str>, purity: &PurityReport) -> Self {
        let content = &purity.content;
        Self {
            bin: bin.unwrap_or_default(),
            binned: content.binned,
            rightly_binned: content.rightly_binned,
            due: content.due,
            purity: content.purity.map(Displayed),
            purity_low: low(purity.purity_interval),
            purity_high: high(purity.purity_interval),
            recovery: content.recovery.map(Displayed),
            recovery_low: low(purity.recovery_interval),
            recovery_high: high(purity.recovery_interval),
        }
    }
}

/// A row of a table of purities: a method at one value or on one case, in total or for a bin.
pub(crate) struct PurityRow<'r> {
    /// The value or the case; empty where it is that of the row above.
    pub group: PageGroup,
    /// The method; empty where it is that of the row above.
    pub method: &'r str,
    bin: Option<&'r str>,
    purity: &'r PurityReport,
    /// Where its figures are in the JSON report.
    path: String,
}

/// The value or the case of a row.
#[derive(Clone)]
pub(crate) enum PageGroup {
    Words(String),
    /// A value and its path in the JSON report.
    Value(f64, String),
}

impl PageGroup {
    fn text(&self) -> String {
        match self {
            Self::Words(words) => words.clone(),
            Self::Value(value, _) => value.to_string(),
        }
    }

    fn cell(&self) -> Cell {
        match self {
            Self::Words(words) => Cell::Words(words.clone()),
            Self::Value(value, path) => PageFigure::exact(path.clone(), *value).into(),
        }
    }
}

impl<'r> PurityRow<'r> {
    /// The rows of a method whose figures are at `path`: all bins together, then each.
    pub(crate) fn all(
        group: PageGroup,
        method: &'r str,
        purity: &'r PurityByBinReport,
        path: &str,
    ) -> Vec<Self> {
        let row = |(bin, of, place): (Option<&'r str>, &'r PurityReport, String)| Self {
            group: match bin {
                None => group.clone(),
                Some(_) => PageGroup::Words(String::new()),
            },
            method: if bin.is_none() { method } else { "" },
            bin,
            purity: of,
            path: format!("{path}.{place}"),
        };
        purity.parts().map(row).collect()
    }

    fn bin(&self) -> String {
        self.bin.unwrap_or("all").to_owned()
    }

    fn share(&self, field: &str, share: Option<f64>) -> Cell {
        let figure = |share| PageFigure::percent(format!("{}{field}", self.path), share);
        Cell::or_dash(share.map(figure))
    }

    fn ends(&self, names: (&str, &str), ends: Option<Interval>) -> Cell {
        Cell::interval(names, ends, |field, value| {
            PageFigure::percent(format!("{}{field}", self.path), value)
        })
    }

    fn count(&self, field: &str, count: usize) -> Cell {
        PageFigure::new(format!("{}{field}", self.path), count as f64, 0).into()
    }
}

/// The purities of `rows` for the terminal, below the header `group`.
pub(crate) fn purity_table(group: &str, rows: &[PurityRow]) -> String {
    let bins = rows.iter().any(|row| row.bin.is_some());
    let ends = |ends: Option<Interval>| interval(ends.map(|ends| ends.times(100.0)), 1);
    let many = rows.iter().any(|row| row.purity.purity_interval.is_some());
    let share = |share: Option<f64>| fixed(share.map_or(f64::NAN, |share| 100.0 * share), 1);
    TableColumns::new()
        .with(group, |row: &&PurityRow| row.group.text())
        .with("<method", |row| row.method.to_owned())
        .with_if(bins, "<bin", |row| row.bin())
        .with("binned", |row| row.purity.content.binned.to_string())
        .with("purity [%]", move |row| share(row.purity.content.purity))
        .with_if(many, "95 %", move |row| ends(row.purity.purity_interval))
        .with("recovery [%]", move |row| {
            share(row.purity.content.recovery)
        })
        .with_if(many, "95 %", move |row| ends(row.purity.recovery_interval))
        .table(rows)
}

/// The columns of a page's table of purities, below the header `group`.
pub(crate) fn purity_page_columns<'c, 'r: 'c>(
    group: &str,
) -> TableColumns<'c, PurityRow<'r>, Cell> {
    TableColumns::new()
        .with(group, |row: &PurityRow| row.group.cell())
        .with("<method", |row| Cell::Words(row.method.to_owned()))
        .with("<bin", |row| Cell::Words(row.bin()))
        .with("binned", |row| {
            row.count("binned", row.purity.content.binned)
        })
        .with("rightly binned", |row| {
            row.count("rightly_binned", row.purity.content.rightly_binned)
        })
        .with("due", |row| row.count("due", row.purity.content.due))
        .with("purity [%]", |row| {
            row.share("purity", row.purity.content.purity)
        })
        .with("95 %", |row| {
            row.ends(("purity_low", "purity_high"), row.purity.purity_interval)
        })
        .with("recovery [%]", |row| {
            row.share("recovery", row.purity.content.recovery)
        })
        .with("95 %", |row| {
            let names = ("recovery_low", "recovery_high");
            row.ends(names, row.purity.recovery_interval)
        })
}

/// What a page says about a table of purities.
pub(crate) const PURITY_CAPTION: &str = "Purity: the share of what was put into a bin that belongs \
     there. Recovery: the share of what belongs there (due) that was put in. All items of all \
     patterns together.";
