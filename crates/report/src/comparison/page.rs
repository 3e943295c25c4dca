//! The page of a comparison.

use super::charts::CHARTS;
use super::report::{CaseReport, ComparisonReport, MethodResultReport, PrintedReport};
use crate::bound::CaseBoundReport;
use crate::classes::{CERTIFIED_CAPTION, CLASSES_CAPTION, ClassPageRow, class_page_columns};
use crate::columns::TableColumns;
use crate::page::{Cell, PageFigure, PageSection, PageTable, ReportPage, charts, escape};
use crate::purity::{PURITY_CAPTION, purity_page_columns};
use pickline::stats::Interval;

/// The page for `report`.
pub(super) fn page(report: &ComparisonReport) -> String {
    let mut sections = charts(CHARTS, report);
    // The page's first figure, as in the tables.
    let is_first = |section: &PageSection| matches!(section, PageSection::Chart("throughput", _));
    if let Some(place) = sections.iter().position(is_first) {
        sections[..=place].rotate_right(1);
    }
    sections.extend(tables(report));
    sections.push(PageSection::List("Notes".into(), report.notes.clone()));
    let cases = report.cases.len();
    let page = ReportPage {
        title: format!(
            "Comparison of {} on {cases} case{}",
            match report.methods.len() {
                1 => "one method".to_owned(),
                methods => format!("{methods} methods"),
            },
            if cases == 1 { "" } else { "s" }
        ),
        subtitle: format!("Station {}", report.made.station),
        answer: answer(report),
        sections,
        made: &report.made,
    };
    page.html(report)
}

/// The tables, from top to bottom.
fn tables(report: &ComparisonReport) -> Vec<PageSection> {
    let counts = report.cases.iter();
    let counts = counts.map(|case| match case.patterns {
        1 => format!("one of {}", case.name),
        n => format!("{n} of {}", case.name),
    });
    let mut sections = vec![PageSection::Table(
        "Figures".into(),
        figures(report),
        format!(
            "Means with their 95 % intervals over the patterns: {}.",
            counts.collect::<Vec<_>>().join("; ")
        ),
    )];
    if let [first, _, ..] = report.methods.as_slice() {
        sections.push(PageSection::Table(
            format!("Compared with {}", first.title),
            differences(report),
            "Differences are paired over the patterns; a case of a single pattern has no \
             interval."
                .into(),
        ));
    }
    if report.cases.iter().any(|case| case.bound.is_some()) {
        sections.push(PageSection::Table(
            "Compared with the bound".into(),
            certified(report),
            "No strategy that obeys the model exceeds the bound, waiting and clairvoyance \
             included; certified is at least that share of the picks that the best strategy \
             could make. Means over the patterns."
                .into(),
        ));
    }
    if report.has_purity() {
        sections.push(PageSection::Table(
            "Purity and recovery".into(),
            purities(report),
            PURITY_CAPTION.into(),
        ));
    }
    if report.classes().next().is_some() {
        let bounded = report.cases.iter().any(|case| case.bound.is_some());
        let certified = if bounded { CERTIFIED_CAPTION } else { "" };
        sections.push(PageSection::Table(
            "Classes".into(),
            classes(report, bounded),
            format!("{CLASSES_CAPTION} {certified}").trim().to_owned(),
        ));
    }
    if report.with_paper {
        sections.push(PageSection::Table(
            "Compared with the paper".into(),
            printed(report),
            "What Jermann et al. print in their Tables 2 and 3.".into(),
        ));
    }
    sections
}

/// How each method performs, summarised over the cases.
fn answer(report: &ComparisonReport) -> Vec<String> {
    let methods = 0..report.methods.len();
    methods
        .map(|j| match j {
            0 => first_answer(report),
            _ => other_answer(report, j),
        })
        .collect()
}

/// A figure of the `j`-th method as HTML, where it is lowest and where it is highest over the
/// cases that have it; one of them if they are the same case.
fn span(
    report: &ComparisonReport,
    j: usize,
    field: &str,
    of: impl Fn(&MethodResultReport) -> Option<f64>,
) -> Option<(String, Option<String>)> {
    let cases = report.cases.iter().enumerate();
    let values = cases.filter_map(|(i, case)| Some((i, of(&case.results[j])?)));
    let values: Vec<(usize, f64)> = values.collect();
    let order = |a: &&(usize, f64), b: &&(usize, f64)| a.1.total_cmp(&b.1);
    let least = values.iter().min_by(order)?;
    let most = values.iter().max_by(order)?;
    let shown = |&(case, value): &(usize, f64)| {
        PageFigure::new(format!("cases.{case}.results.{j}.{field}"), value, 1).html()
    };
    Some((shown(least), (least != most).then(|| shown(most))))
}

/// The rates of the first method.
fn first_answer(report: &ComparisonReport) -> String {
    let title = escape(&report.methods[0].title);
    let rate = span(report, 0, "picking_rate_per_min", |result| {
        Some(result.picking_rate_per_min)
    });
    let rate = match rate.unwrap_or_default() {
        (least, None) => format!("a picking rate of {least}/min"),
        (least, Some(most)) => {
            format!("a picking rate of {least} to {most}/min, depending on the case")
        }
    };
    let throughput = span(report, 0, "throughput_per_min", |result| {
        result.throughput.throughput_per_min
    });
    match throughput {
        None => format!("{title} has {rate}."),
        Some((least, None)) => format!("{title} has a throughput of {least}/min and {rate}."),
        Some((least, Some(most))) => {
            format!("{title} has a throughput of {least} to {most}/min and {rate}.")
        }
    }
}

/// How the `j`-th method differs from the first.
fn other_answer(report: &ComparisonReport, j: usize) -> String {
    let title = escape(&report.methods[j].title);
    let benefit = span(report, j, "benefit_percent", |result| {
        Some(result.benefit_percent)
    });
    let range = match benefit.unwrap_or_default() {
        (least, None) => format!("{least} %"),
        (least, Some(most)) => format!("{least} to {most} %"),
    };
    let cases = report.cases.iter();
    let intervals: Vec<Interval> = cases
        .filter_map(|case| case.results[j].difference)
        .collect();
    let better = intervals.iter().filter(|ends| ends.low > 0.0).count();
    let worse = intervals.iter().filter(|ends| ends.high < 0.0).count();
    let proven = match (intervals.len(), better, worse) {
        (0, _, _) => String::new(),
        (n, 0, 0) => format!("; the difference is proven on none of the {n} random cases"),
        (n, better, 0) => format!("; proven better on {better} of the {n} random cases"),
        (n, 0, worse) => format!("; proven worse on {worse} of the {n} random cases"),
        (n, better, worse) => {
            format!("; proven better on {better} and worse on {worse} of the {n} random cases")
        }
    };
    format!("{title} changes the picking rate by {range} compared with the first method{proven}.")
}

/// A row of a table: a method on a case.
struct MethodPageRow<'r> {
    case: &'r CaseReport,
    result: &'r MethodResultReport,
    title: &'r str,
    /// Places of the case and of the method.
    places: (usize, usize),
    /// Whether this is the first row of its case.
    begins: bool,
}

impl MethodPageRow<'_> {
    fn path(&self, field: &str) -> String {
        let (case, method) = self.places;
        format!("cases.{case}.results.{method}.{field}")
    }

    fn percent(&self, field: &str, share: f64) -> PageFigure {
        PageFigure::percent(self.path(field), share)
    }

    fn figure(&self, field: &str, value: f64, digits: usize) -> PageFigure {
        PageFigure::new(self.path(field), value, digits)
    }

    fn rate(&self, field: &str, value: f64) -> PageFigure {
        self.figure(field, value, 2)
    }
}

/// The rows of the methods from the `first` on for which `has` holds, case by case.
fn rows(
    report: &ComparisonReport,
    first: usize,
    has: impl Fn(&MethodResultReport) -> bool,
) -> Vec<(bool, MethodPageRow<'_>)> {
    let mut rows = Vec::new();
    for (i, case) in report.cases.iter().enumerate() {
        let results = case.results.iter().enumerate().skip(first);
        let results = results.filter(|(_, result)| has(result));
        for (place, (j, result)) in results.enumerate() {
            let begins = place == 0;
            let row = MethodPageRow {
                case,
                result,
                title: &report.methods[j].title,
                places: (i, j),
                begins,
            };
            rows.push((begins && i > 0, row));
        }
    }
    rows
}

/// The first columns of every table.
fn named<'c, 'r: 'c>() -> TableColumns<'c, MethodPageRow<'r>, Cell> {
    TableColumns::new()
        .with("<case", |row: &MethodPageRow| {
            let name = if row.begins { &row.case.name } else { "" };
            Cell::Words(name.to_owned())
        })
        .with("<method", |row| Cell::Words(row.title.to_owned()))
}

fn figures(report: &ComparisonReport) -> PageTable {
    let columns = named()
        .with_throughput(
            report.is_steady(),
            |row| &row.result.throughput,
            MethodPageRow::path,
        )
        .with("picked [%]", |row| {
            row.percent("picked_share", row.result.picked_share).into()
        })
        .with("95 %", |row| {
            let names = ("picked_share_low", "picked_share_high");
            let interval = row.result.picked_share_interval;
            Cell::interval(names, interval, |field, value| row.percent(field, value))
        })
        .with("time [s]", |row| {
            row.figure("end_s", row.result.end_s, 1).into()
        })
        .with("picking rate [1/min]", |row| {
            row.rate("picking_rate_per_min", row.result.picking_rate_per_min)
                .into()
        })
        .with("95 %", |row| {
            let names = ("picking_rate_low", "picking_rate_high");
            let interval = row.result.picking_rate_interval;
            Cell::interval(names, interval, |field, value| row.rate(field, value))
        })
        .with_if(report.weighs(), "weighted [1/min]", |row| {
            row.rate("weighted_rate_per_min", row.result.weighted_rate_per_min)
                .into()
        });
    PageTable::of(&columns, rows(report, 0, |_| true))
}

/// Purity and recovery of each method's bins.
fn purities(report: &ComparisonReport) -> PageTable {
    let methods = report.purities().into_iter();
    let rows = methods.flat_map(|rows| {
        let rows = rows.into_iter().enumerate();
        rows.map(|(place, row)| (place == 0, row))
    });
    PageTable::of(&purity_page_columns("<case"), rows)
}

fn differences(report: &ComparisonReport) -> PageTable {
    let columns = named()
        .with("picking rate minus the first's, 95 % [1/min]", |row| {
            let names = ("diff_low", "diff_high");
            Cell::interval(names, row.result.difference, |field, value| {
                row.rate(field, value)
            })
        })
        .with("benefit [%]", |row| {
            row.figure("benefit_percent", row.result.benefit_percent, 1)
                .into()
        });
    PageTable::of(&columns, rows(report, 1, |_| true))
}

/// What each method picks of each class.
fn classes(report: &ComparisonReport, bounded: bool) -> PageTable {
    let many = report.cases.iter().any(|case| case.patterns > 1);
    let mut classes = Vec::new();
    for (_, row) in rows(report, 0, |result| !result.classes.is_empty()) {
        for (place, class) in row.result.classes.iter().enumerate() {
            let begins = row.begins && place == 0;
            let group = if begins { row.case.name.as_str() } else { "" };
            let of_class = ClassPageRow {
                group: Cell::Words(group.to_owned()),
                method: if place == 0 { row.title } else { "" },
                class,
                path: row.path(&format!("classes.{place}")),
            };
            classes.push((place == 0, of_class));
        }
    }
    PageTable::of(&class_page_columns("<case", many, bounded), classes)
}

/// A row of the table of bounds: the bound of a case, or a method compared with it.
enum BoundRow<'r> {
    Bound(usize, &'r CaseReport, &'r CaseBoundReport),
    Method(MethodPageRow<'r>),
}

impl BoundRow<'_> {
    fn case(&self) -> Cell {
        match self {
            Self::Bound(_, case, _) => Cell::Words(case.name.clone()),
            Self::Method(_) => Cell::Words(String::new()),
        }
    }

    fn name(&self) -> Cell {
        match self {
            Self::Bound(..) => Cell::Words("bound".into()),
            Self::Method(row) => Cell::Words(row.title.to_owned()),
        }
    }

    fn picked(&self) -> Cell {
        match self {
            Self::Bound(i, _, bound) => {
                let path = format!("cases.{i}.bound.picked_share");
                PageFigure::percent(path, bound.picked_share).into()
            }
            Self::Method(row) => row.percent("picked_share", row.result.picked_share).into(),
        }
    }

    fn rate(&self) -> Cell {
        match self {
            Self::Bound(i, _, bound) => {
                let path = format!("cases.{i}.bound.picking_rate_per_min");
                let rate = bound.picking_rate_per_min;
                Cell::or_empty(rate.map(|rate| PageFigure::new(path, rate, 2)))
            }
            Self::Method(row) => row
                .rate("picking_rate_per_min", row.result.picking_rate_per_min)
                .into(),
        }
    }

    /// A proven share of the optimum; empty for the bound itself.
    fn certified(&self, field: &str, of: fn(&MethodResultReport) -> Option<f64>) -> Cell {
        match self {
            Self::Bound(..) => Cell::empty(),
            Self::Method(row) => {
                let percent = of(row.result);
                Cell::or_empty(percent.map(|percent| row.figure(field, percent, 1)))
            }
        }
    }
}

fn certified(report: &ComparisonReport) -> PageTable {
    let columns = TableColumns::new()
        .with("<case", BoundRow::case)
        .with("<method", BoundRow::name)
        .with("picked [%]", BoundRow::picked)
        .with("picking rate [1/min]", BoundRow::rate)
        .with("certified: picks [%]", |row| {
            row.certified("certified_percent", |result| result.certified_percent)
        })
        .with("rate [%]", |row| {
            row.certified("certified_rate_percent", |result| {
                result.certified_rate_percent
            })
        });
    let mut methods = rows(report, 0, |_| true).into_iter().peekable();
    let mut all = Vec::new();
    for (i, case) in report.cases.iter().enumerate() {
        if let Some(bound) = &case.bound {
            all.push((i > 0, BoundRow::Bound(i, case, bound)));
        }
        while let Some((_, row)) = methods.next_if(|(_, row)| row.places.0 == i) {
            if case.bound.is_some() {
                all.push((false, BoundRow::Method(row)));
            }
        }
    }
    PageTable::of(&columns, all)
}

fn printed(report: &ComparisonReport) -> PageTable {
    let paper = |row: &MethodPageRow, field: &str, digits, of: fn(&PrintedReport) -> f64| {
        let value = row.result.paper.as_ref().map(of);
        let path = row.path(&format!("paper.{field}"));
        Cell::or_empty(value.map(|value| PageFigure::new(path, value, digits)))
    };
    let columns = named()
        .with("picked [%]: ours", |row| {
            row.percent("picked_share", row.result.picked_share).into()
        })
        .with("paper", move |row| {
            paper(row, "picked_percent", 0, |paper| paper.picked_percent)
        })
        .with("time [s]: ours", |row| {
            row.figure("end_s", row.result.end_s, 1).into()
        })
        .with("paper", move |row| {
            paper(row, "time_s", 1, |paper| paper.time_s)
        })
        .with("picking rate [1/min]: ours", |row| {
            let rate = row.result.picking_rate_per_min;
            row.figure("picking_rate_per_min", rate, 1).into()
        })
        .with("paper", move |row| {
            paper(row, "picking_rate_per_min", 1, |paper| {
                paper.picking_rate_per_min
            })
        });
    PageTable::of(&columns, rows(report, 0, |result| result.paper.is_some()))
}
