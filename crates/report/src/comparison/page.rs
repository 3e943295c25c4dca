//! The page of a comparison.

use super::charts::CHARTS;
use super::report::{CaseReport, ComparisonReport, MethodReport, MethodResultReport};
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

/// One row per method from `first` on, case by case. `cells` gets the case, the method and the
/// path of its figures, and returns `None` to omit the row.
fn rows(
    report: &ComparisonReport,
    first: usize,
    cells: impl Fn(&CaseReport, &MethodResultReport, &dyn Fn(&str) -> String) -> Option<Vec<Cell>>,
) -> Vec<(bool, Vec<Cell>)> {
    let mut rows = Vec::new();
    for (i, case) in report.cases.iter().enumerate() {
        let mut begins = true;
        for (j, result) in case.results.iter().enumerate().skip(first) {
            let path = |field: &str| format!("cases.{i}.results.{j}.{field}");
            let Some(cells) = cells(case, result, &path) else {
                continue;
            };
            let name = if begins { case.name.as_str() } else { "" };
            let mut row = vec![
                Cell::Words(name.into()),
                Cell::Words(report.methods[j].title.clone()),
            ];
            row.extend(cells);
            rows.push((begins && i > 0, row));
            begins = false;
        }
    }
    rows
}

fn table(header: &[&str], rows: Vec<(bool, Vec<Cell>)>) -> PageTable {
    let header = ["<case", "<method"].iter().chain(header);
    PageTable {
        header: header.map(|&name| name.to_owned()).collect(),
        rows,
    }
}

fn figures(report: &ComparisonReport) -> PageTable {
    let (steady, weighs) = (report.is_steady(), report.weighs());
    let cells = |_: &CaseReport, result: &MethodResultReport, path: &dyn Fn(&str) -> String| {
        let percent = |field: &str, share| PageFigure::percent(path(field), share);
        let rate = |field: &str, value| PageFigure::new(path(field), value, 2);
        let mut cells = match steady {
            true => Cell::throughput(&result.throughput, path),
            false => Vec::new(),
        };
        cells.extend([
            percent("picked_share", result.picked_share).into(),
            Cell::interval(
                ("picked_share_low", "picked_share_high"),
                result.picked_share_interval,
                percent,
            ),
            PageFigure::new(path("end_s"), result.end_s, 1).into(),
            rate("picking_rate_per_min", result.picking_rate_per_min).into(),
            Cell::interval(
                ("picking_rate_low", "picking_rate_high"),
                result.picking_rate_interval,
                rate,
            ),
        ]);
        let weighted = rate("weighted_rate_per_min", result.weighted_rate_per_min);
        cells.extend(weighs.then(|| weighted.into()));
        Some(cells)
    };
    let mut header = Vec::new();
    header.extend(steady.then_some(Cell::THROUGHPUT).into_iter().flatten());
    header.extend([
        "picked [%]",
        "95 %",
        "time [s]",
        "picking rate [1/min]",
        "95 %",
    ]);
    header.extend(weighs.then_some("weighted [1/min]"));
    table(&header, rows(report, 0, cells))
}

fn differences(report: &ComparisonReport) -> PageTable {
    let cells = |_: &CaseReport, result: &MethodResultReport, path: &dyn Fn(&str) -> String| {
        Some(vec![
            Cell::interval(
                ("diff_low", "diff_high"),
                result.difference,
                |field, value| PageFigure::new(path(field), value, 2),
            ),
            PageFigure::new(path("benefit_percent"), result.benefit_percent, 1).into(),
        ])
    };
    let header = [
        "picking rate minus the first's, 95 % [1/min]",
        "benefit [%]",
    ];
    table(&header, rows(report, 1, cells))
}

fn certified(report: &ComparisonReport) -> PageTable {
    let mut rows = Vec::new();
    for (i, case) in report.cases.iter().enumerate() {
        let Some(bound) = &case.bound else { continue };
        let path = |field: &str| format!("cases.{i}.bound.{field}");
        let rate = bound
            .picking_rate_per_min
            .map(|rate| PageFigure::new(path("picking_rate_per_min"), rate, 2));
        let cells = vec![
            Cell::Words(case.name.clone()),
            Cell::Words("bound".into()),
            PageFigure::percent(path("picked_share"), bound.picked_share).into(),
            Cell::or_empty(rate),
            Cell::empty(),
            Cell::empty(),
        ];
        rows.push((i > 0, cells));
        for (j, result) in case.results.iter().enumerate() {
            let path = |field: &str| format!("cases.{i}.results.{j}.{field}");
            let share = |field, percent: Option<f64>| {
                Cell::or_empty(percent.map(|percent| PageFigure::new(path(field), percent, 1)))
            };
            let rate =
                PageFigure::new(path("picking_rate_per_min"), result.picking_rate_per_min, 2);
            rows.push((
                false,
                vec![
                    Cell::Words(String::new()),
                    Cell::Words(report.methods[j].title.clone()),
                    PageFigure::percent(path("picked_share"), result.picked_share).into(),
                    rate.into(),
                    share("certified_percent", result.certified_percent),
                    share("certified_rate_percent", result.certified_rate_percent),
                ],
            ));
        }
    }
    let header = [
        "picked [%]",
        "picking rate [1/min]",
        "certified: picks [%]",
        "rate [%]",
    ];
    table(&header, rows)
}

fn printed(report: &ComparisonReport) -> PageTable {
    let cells = |_: &CaseReport, result: &MethodResultReport, path: &dyn Fn(&str) -> String| {
        let paper = result.paper?;
        let rate = |field, value| PageFigure::new(path(field), value, 1).into();
        Some(vec![
            PageFigure::percent(path("picked_share"), result.picked_share).into(),
            PageFigure::new(path("paper.picked_percent"), paper.picked_percent, 0).into(),
            rate("end_s", result.end_s),
            rate("paper.time_s", paper.time_s),
            rate("picking_rate_per_min", result.picking_rate_per_min),
            rate("paper.picking_rate_per_min", paper.picking_rate_per_min),
        ])
    };
    let header = [
        "picked [%]: ours",
        "paper",
        "time [s]: ours",
        "paper",
        "picking rate [1/min]: ours",
        "paper",
    ];
    table(&header, rows(report, 0, cells))
}
