//! The page of a comparison.

use super::charts::CHARTS;
use super::report::{
    CaseReport, ComparisonReport, MethodReport, MethodResultReport, PrintedReport,
};
use crate::bound::CaseBoundReport;
use crate::columns::Columns;
use crate::page::{Cell, PageFigure, PageSection, PageTable, ReportPage, charts, escape};

/// The page for `report`.
pub(super) fn page(report: &ComparisonReport) -> String {
    let mut sections = charts(CHARTS, report);
    // The page's first figure, as in the tables.
    let is_first = |section: &PageSection| matches!(section, PageSection::Chart("throughput", _));
    if let Some(place) = sections.iter().position(is_first) {
        sections[..=place].rotate_right(1);
    }
    let counts = report.cases.iter();
    let counts = counts.map(|case| match case.patterns {
        1 => format!("one of {}", case.name),
        n => format!("{n} of {}", case.name),
    });
    sections.push(PageSection::Table(
        "Figures".into(),
        figures(report),
        format!(
            "Means with their 95 % intervals over the patterns: {}.",
            counts.collect::<Vec<_>>().join("; ")
        ),
    ));
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
    if report.with_paper {
        sections.push(PageSection::Table(
            "Compared with the paper".into(),
            printed(report),
            "What Jermann et al. print in their Tables 2 and 3.".into(),
        ));
    }
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

/// How each method performs, summarised over the cases.
fn answer(report: &ComparisonReport) -> Vec<String> {
    let methods = report.methods.iter().enumerate();
    let line = |(j, method): (usize, &MethodReport)| {
        let title = escape(&method.title);
        // The cases with the lowest and highest figure.
        let ends = |of: &dyn Fn(&CaseReport) -> f64| {
            let order =
                |a: &usize, b: &usize| of(&report.cases[*a]).total_cmp(&of(&report.cases[*b]));
            let all = || 0..report.cases.len();
            (
                all().min_by(order).unwrap_or(0),
                all().max_by(order).unwrap_or(0),
            )
        };
        let figure = |case: usize, field: &str, value: f64| {
            PageFigure::new(format!("cases.{case}.results.{j}.{field}"), value, 1).html()
        };
        if j == 0 {
            let rate = |case: &CaseReport| case.results[0].picking_rate_per_min;
            let (least, most) = ends(&rate);
            let shown =
                |case: usize| figure(case, "picking_rate_per_min", rate(&report.cases[case]));
            let rate = match least == most {
                true => format!("a picking rate of {}/min", shown(least)),
                false => format!(
                    "a picking rate of {} to {}/min, depending on the case",
                    shown(least),
                    shown(most)
                ),
            };
            let steady = report.cases.iter().enumerate().filter_map(|(i, case)| {
                let throughput = case.results[0].throughput.throughput_per_min?;
                Some((i, throughput))
            });
            let steady: Vec<(usize, f64)> = steady.collect();
            let order = |a: &&(usize, f64), b: &&(usize, f64)| a.1.total_cmp(&b.1);
            if let (Some(least), Some(most)) =
                (steady.iter().min_by(order), steady.iter().max_by(order))
            {
                let shown = |of: &(usize, f64)| figure(of.0, "throughput_per_min", of.1);
                let throughput = match least == most {
                    true => format!("a throughput of {}/min", shown(least)),
                    false => format!("a throughput of {} to {}/min", shown(least), shown(most)),
                };
                return format!("{title} has {throughput} and {rate}.");
            }
            return format!("{title} has {rate}.");
        }
        let benefit = |case: &CaseReport| case.results[j].benefit_percent;
        let (least, most) = ends(&benefit);
        let shown = |case: usize| figure(case, "benefit_percent", benefit(&report.cases[case]));
        let range = match least == most {
            true => format!("{} %", shown(least)),
            false => format!("{} to {} %", shown(least), shown(most)),
        };
        let count = |holds: &dyn Fn(f64, f64) -> bool| {
            let results = report.cases.iter();
            let ends = results.filter_map(|case| {
                let result = &case.results[j];
                result.difference
            });
            ends.filter(|ends| holds(ends.low, ends.high)).count()
        };
        let better = count(&|low, _| low > 0.0);
        let worse = count(&|_, high| high < 0.0);
        let several = count(&|_, _| true);
        let proven = match (several, better, worse) {
            (0, _, _) => String::new(),
            (n, 0, 0) => format!("; the difference is proven on none of the {n} random cases"),
            (n, better, 0) => format!("; proven better on {better} of the {n} random cases"),
            (n, 0, worse) => format!("; proven worse on {worse} of the {n} random cases"),
            (n, better, worse) => {
                format!("; proven better on {better} and worse on {worse} of the {n} random cases")
            }
        };
        format!(
            "{title} changes the picking rate by {range} compared with the first method{proven}."
        )
    };
    methods.map(line).collect()
}

/// A row of a table: a method on a case.
struct Row<'r> {
    case: &'r CaseReport,
    result: &'r MethodResultReport,
    title: &'r str,
    /// Places of the case and of the method.
    places: (usize, usize),
    /// Whether this is the first row of its case.
    begins: bool,
}

impl Row<'_> {
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
) -> Vec<(bool, Row<'_>)> {
    let mut rows = Vec::new();
    for (i, case) in report.cases.iter().enumerate() {
        let results = case.results.iter().enumerate().skip(first);
        let results = results.filter(|(_, result)| has(result));
        for (place, (j, result)) in results.enumerate() {
            let begins = place == 0;
            let row = Row {
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
fn named<'c, 'r: 'c>() -> Columns<'c, Row<'r>, Cell> {
    Columns::new()
        .with("<case", |row: &Row| {
            let name = if row.begins { &row.case.name } else { "" };
            Cell::Words(name.to_owned())
        })
        .with("<method", |row| Cell::Words(row.title.to_owned()))
}

fn figures(report: &ComparisonReport) -> PageTable {
    let columns = named()
        .with_throughput(report.is_steady(), |row| &row.result.throughput, Row::path)
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

/// A row of the table of bounds: the bound of a case, or a method compared with it.
enum BoundRow<'r> {
    Bound(usize, &'r CaseReport, &'r CaseBoundReport),
    Method(Row<'r>),
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
    let columns = Columns::new()
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
    let paper = |row: &Row, field: &str, digits, of: fn(&PrintedReport) -> f64| {
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
