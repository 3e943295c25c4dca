//! What methods pick of each class of items.

use crate::bound::rounded_up;
use crate::columns::TableColumns;
use crate::csv_rows::{Displayed, OptionalNumber, high, low};
use crate::page::{Cell, PageFigure};
use crate::table::fixed;
use pickline::experiment::ClassResult;
use pickline::stats::Interval;
use serde::Serialize;

/// One class of items, over all patterns of a method.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct ClassReport {
    /// Name of the class; `None` for the items without one.
    pub name: Option<String>,
    /// Number of items of this class in all patterns together.
    pub items: usize,
    /// How many of them were picked.
    pub picked: usize,
    /// The share of them that was picked; `None` if they are not to be picked.
    pub recovery: Option<f64>,
    /// 95 % interval of that share; `None` for a single pattern.
    #[serde(flatten, serialize_with = "crate::ends::recovery")]
    pub recovery_interval: Option<Interval>,
    /// Upper bound on the picks of every strategy, whatever else it picks; omitted if not
    /// requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picks_upper_bound: Option<usize>,
    /// The picks as a proven share of the optimum for this class alone [%].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certified_percent: Option<f64>,
}

impl ClassReport {
    /// The reports of `results`, in their order.
    pub(crate) fn all(results: &[ClassResult]) -> Vec<Self> {
        let report = |result: &ClassResult| Self {
            name: result.class.clone(),
            items: result.items,
            picked: result.picked,
            recovery: result.recovery,
            recovery_interval: result.recovery_interval,
            picks_upper_bound: result.picks_bound,
            certified_percent: result.certified,
        };
        results.iter().map(report).collect()
    }

    /// The name in tables.
    pub(crate) fn title(&self) -> String {
        class_title(self.name.as_deref())
    }

    /// The columns of a CSV file.
    pub(crate) fn csv_columns(&self) -> ClassColumns<'_> {
        ClassColumns {
            class: self.name.as_deref().unwrap_or_default(),
            items: self.items,
            picked: self.picked,
            recovery: self.recovery.map(Displayed),
            recovery_low: low(self.recovery_interval),
            recovery_high: high(self.recovery_interval),
            picks_upper_bound: self.picks_upper_bound,
            certified_percent: self.certified_percent.map(Displayed),
        }
    }
}

/// The name of a class in tables; a dash for the items without one.
pub(crate) fn class_title(name: Option<&str>) -> String {
    name.unwrap_or("-").to_owned()
}

/// The figures of a class as columns of a CSV file.
#[derive(Debug, Default, Serialize)]
pub(crate) struct ClassColumns<'r> {
    /// Empty for the items without a class.
    class: &'r str,
    items: usize,
    picked: usize,
    /// Empty if they are not to be picked.
    recovery: OptionalNumber,
    recovery_low: OptionalNumber,
    recovery_high: OptionalNumber,
    picks_upper_bound: Option<usize>,
    certified_percent: OptionalNumber,
}

/// What tables explain below them.
pub(crate) const CLASSES_CAPTION: &str = "Recovery is the share of the items of a class that is \
     picked, over all patterns together; classes that are not to be picked have none.";
/// The same for tables with certificates.
pub(crate) const CERTIFIED_CAPTION: &str = "No strategy picks more items of a class than the bound, \
     even if it picks only those; certified is at least that share of it. Not all classes can reach \
     their bounds at once.";

/// A row of the text table of recoveries: where it stands, and the classes of one method.
pub(crate) struct RecoveryRow<'r> {
    /// What was varied: a case, or a value of a sweep; empty beside all methods but the first.
    pub group: String,
    /// The method's name; `None` for the bound.
    pub method: Option<&'r str>,
    /// The classes of the method; for the bound, of any.
    pub classes: &'r [ClassReport],
}

/// The table of recoveries for the terminal, with a column for each class of `all`, below the
/// header `group`; empty without classes.
pub(crate) fn recovery_table<'r>(
    group: &str,
    all: impl IntoIterator<Item = &'r ClassReport>,
    rows: Vec<RecoveryRow<'r>>,
) -> String {
    let mut names: Vec<Option<&str>> = Vec::new();
    for class in all {
        let name = class.name.as_deref();
        if class.recovery.is_some() && !names.contains(&name) {
            names.push(name);
        }
    }
    if names.is_empty() {
        return String::new();
    }
    names.sort_unstable();
    let columns = TableColumns::new()
        .with(group, |row: &RecoveryRow| row.group.clone())
        .with("<method", |row| match row.method {
            Some(title) => title.to_owned(),
            None => "bound of each class alone".to_owned(),
        });
    let columns = names.into_iter().fold(columns, |columns, name| {
        let header = match name {
            Some(name) => format!("{name} [%]"),
            None => "no class [%]".to_owned(),
        };
        columns.with(header, move |row| {
            let class = row.classes.iter().find(|c| c.name.as_deref() == name);
            class.map_or(String::new(), |class| row.cell(class))
        })
    });
    format!("recovery  of each class\n{}", columns.table(rows))
}

impl RecoveryRow<'_> {
    fn cell(&self, class: &ClassReport) -> String {
        let share = |share: Option<f64>| share.map_or(String::new(), |s| fixed(100.0 * s, 1));
        match self.method {
            Some(_) => share(class.recovery),
            None => {
                let most = class.picks_upper_bound.map(|most| most as f64);
                let most = most.map(|most| 100.0 * most / class.items as f64);
                most.map_or(String::new(), |most| rounded_up(most, 1))
            }
        }
    }
}

/// A row of the table of classes on a page.
pub(crate) struct ClassPageRow<'r> {
    /// What was varied: a case, or a value of a sweep.
    pub group: Cell,
    /// The method's name; empty in all of its rows but the first.
    pub method: &'r str,
    /// The class.
    pub class: &'r ClassReport,
    /// The path of the class in the report.
    pub path: String,
}

impl ClassPageRow<'_> {
    fn path(&self, field: &str) -> String {
        format!("{}.{field}", self.path)
    }

    fn exact(&self, field: &str, value: usize) -> PageFigure {
        PageFigure::exact(self.path(field), value as f64)
    }

    fn percent(&self, field: &str, share: f64) -> PageFigure {
        PageFigure::percent(self.path(field), share)
    }
}

/// The columns of the table of classes on a page, below the header `group`; with those of the
/// bound if it is known.
pub(crate) fn class_page_columns<'c, 'r: 'c>(
    group: &str,
    many: bool,
    bounded: bool,
) -> TableColumns<'c, ClassPageRow<'r>, Cell> {
    TableColumns::new()
        .with(group, |row: &ClassPageRow| row.group.clone())
        .with("<method", |row| Cell::Words(row.method.to_owned()))
        .with("<class", |row| Cell::Words(row.class.title()))
        .with("items", |row| row.exact("items", row.class.items).into())
        .with("picked", |row| row.exact("picked", row.class.picked).into())
        .with("recovery [%]", |row| {
            let recovery = row.class.recovery;
            Cell::or_dash(recovery.map(|share| row.percent("recovery", share)))
        })
        .with_if(many, "95 %", |row| {
            let names = ("recovery_low", "recovery_high");
            let interval = row.class.recovery_interval;
            Cell::interval(names, interval, |field, share| row.percent(field, share))
        })
        .with_if(bounded, "bound: picked", |row| {
            let most = row.class.picks_upper_bound;
            Cell::or_dash(most.map(|most| row.exact("picks_upper_bound", most)))
        })
        .with_if(bounded, "certified [%]", |row| {
            let certified = row
                .class
                .certified_percent
                .map(|percent| PageFigure::new(row.path("certified_percent"), percent, 1));
            Cell::or_dash(certified)
        })
}
