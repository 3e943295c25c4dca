//! The page of a search.

use super::charts::CHARTS;
use super::objective::bracketed;
use super::report::{OptimumReport, RankedReport};
use super::rivals::{RivalReport, RivalsReport};
use super::validation::ValidationReport;
use crate::page::{Cell, PageFigure, PageSection, PageTable, ReportPage, charts, escape};
use crate::presentation::Presentation;
use pickline::stats::Interval;

/// The page for `report`, with the first lines of the ranking.
pub(super) fn page(report: &OptimumReport, shown: &Presentation) -> String {
    let top = shown.top;
    let mut sections = charts(CHARTS, report);
    let all = report.ranking.len();
    let remark = match all.saturating_sub(top) {
        0 => format!("All {all} assignments that were scored."),
        more => format!(
            "{more} more assignments were scored ({}).",
            shown.settings.top
        ),
    };
    let heading = "Ranking".to_owned();
    sections.push(PageSection::Table(heading, ranking(report, top), remark));
    if let Some(validation) = &report.validation {
        let patterns = format!("On {}.", validation.patterns);
        let heading = format!("{} on fresh patterns", bracketed(&report.best));
        sections.push(PageSection::Table(
            heading,
            validated(report, validation),
            patterns,
        ));
    }
    if let Some(beside) = &report.beside {
        let heading = format!("Other strategies compared with {}", bracketed(&report.best));
        let patterns = format!("On {}.", beside.patterns);
        sections.push(PageSection::Table(
            heading,
            rivals(report, beside),
            patterns,
        ));
    }
    let mut notes = report.search_notes(shown);
    notes.extend(report.notes.iter().cloned());
    sections.push(PageSection::List("Notes".into(), notes));
    let page = ReportPage {
        title: format!(
            "Best of {all} rule assignment{} for {} robot{}",
            if all == 1 { "" } else { "s" },
            report.best.len(),
            if report.best.len() == 1 { "" } else { "s" }
        ),
        subtitle: format!("Station {}", report.made.station),
        answer: answer(report),
        sections,
        made: &report.made,
    };
    page.html(report)
}

fn answer(report: &OptimumReport) -> Vec<String> {
    let (unit, digits) = (report.format().spaced_unit(), report.format().digits());
    let figure = |path: &str, value| PageFigure::new(path, value, digits).html();
    let best = &report.ranking[0];
    let tied = report
        .ranking
        .iter()
        .skip(1)
        .filter(|line| line.tied)
        .count();
    let ties = match tied {
        0 => "no other assignment is tied with it".to_owned(),
        1 => "1 other assignment is tied with it".to_owned(),
        n => format!("{n} other assignments are tied with it"),
    };
    let mut lines = vec![format!(
        "<strong>{}</strong> is best: {} {} {}{unit} over {} patterns; {ties}.",
        escape(&bracketed(&report.best)),
        escape(&report.risk),
        escape(&report.objective.replace('-', " ")),
        figure("ranking.0.value", best.value),
        PageFigure::exact("patterns", report.patterns as f64).html(),
    )];
    if let Some(validation) = &report.validation {
        let ends = validation.mean_interval;
        let interval = ends.map_or(String::new(), |Interval { low, high }| {
            format!(
                " (95 % interval {} to {})",
                figure("validation.mean_low", low),
                figure("validation.mean_high", high),
            )
        });
        lines.push(format!(
            "On {} fresh patterns its mean is {}{unit}{interval}.",
            PageFigure::exact("validation.count", validation.count as f64).html(),
            figure("validation.mean", validation.mean),
        ));
        if let Some(bound) = &validation.bound {
            let figure = |field: &str, value| {
                PageFigure::exact(format!("validation.bound.{field}"), value).html()
            };
            lines.push(format!(
                "Certified: there it makes at least {} % of the picks that the best strategy \
                 could make, waiting and clairvoyance included (the first {} patterns bounded).",
                figure("certified_percent", bound.certified_percent),
                figure("patterns", bound.patterns as f64)
            ));
        }
    }
    lines
}

fn ranking(report: &OptimumReport, top: usize) -> PageTable {
    let digits = report.format().digits();
    let unit = report.format().bracketed_unit();
    let by_risk = report.risk != "mean";
    let by_speed = report.ranking.iter().any(|line| line.max_speed.is_some());
    let mut header = vec!["#".to_owned(), "<assignment".into(), format!("mean{unit}")];
    header.extend(by_risk.then(|| format!("{}{unit}", report.risk)));
    header.extend([
        "best minus this, 95 %".into(),
        "<".into(),
        "picked [%]".into(),
        format!("worst{unit}"),
        "<on pattern".into(),
    ]);
    header.extend(by_speed.then(|| "max speed [m/s]".to_owned()));
    let row = |(i, line): (usize, &RankedReport)| {
        let path = |field: &str| format!("ranking.{i}.{field}");
        let figure = |field: &str, value| PageFigure::new(path(field), value, digits);
        let mut row = vec![
            Cell::Text((i + 1).to_string()),
            Cell::Words(bracketed(&line.assignment)),
            figure("mean", line.mean).into(),
        ];
        if by_risk {
            row.push(figure("value", line.value).into());
        }
        row.extend([
            match i {
                0 => Cell::empty(),
                _ => Cell::interval(("diff_low", "diff_high"), line.difference, figure),
            },
            Cell::Words(
                match (i, line.tied) {
                    (0, _) => "best",
                    (_, true) => "tied",
                    (_, false) => "",
                }
                .into(),
            ),
            PageFigure::percent(path("picked_share"), line.picked_share).into(),
            figure("worst", line.worst).into(),
            Cell::Words(line.worst_pattern.clone()),
        ]);
        if by_speed {
            let speed = line.max_speed;
            row.push(Cell::or_empty(
                speed.map(|speed| PageFigure::new(path("max_speed"), speed, 4)),
            ));
        }
        (false, row)
    };
    let lines = report.ranking.iter().take(top).enumerate();
    PageTable {
        rows: lines.map(row).collect(),
        header,
    }
}

fn validated(report: &OptimumReport, validation: &ValidationReport) -> PageTable {
    let digits = report.format().digits();
    let unit = report.format().bracketed_unit();
    let figure = |field: &str, value| PageFigure::new(format!("validation.{field}"), value, digits);
    let percent = |field: &str, share| PageFigure::percent(format!("validation.{field}"), share);
    let exact = |field: &str, value| PageFigure::exact(format!("validation.{field}"), value);
    let row = vec![
        exact("count", validation.count as f64).into(),
        figure("mean", validation.mean).into(),
        Cell::interval(("mean_low", "mean_high"), validation.mean_interval, figure),
        figure("value", validation.value).into(),
        figure("worst", validation.worst).into(),
        percent("picked_share", validation.picked_share).into(),
        exact("speed", validation.speed).into(),
        exact("complete", validation.complete as f64).into(),
        percent("complete_share", validation.complete_share).into(),
        Cell::Interval(
            percent("complete_low", validation.complete_interval.low),
            percent("complete_high", validation.complete_interval.high),
        ),
    ];
    PageTable {
        header: vec![
            "patterns".into(),
            format!("mean{unit}"),
            "95 %".into(),
            format!("{}{unit}", report.risk),
            format!("worst{unit}"),
            "picked [%]".into(),
            "at belt speed [m/s]".into(),
            "fully picked".into(),
            "[%]".into(),
            "95 %".into(),
        ],
        rows: vec![(false, row)],
    }
}

fn rivals(report: &OptimumReport, beside: &RivalsReport) -> PageTable {
    let digits = report.format().digits();
    let by_risk = report.format().has_risk_column();
    let row = |(i, line): (usize, &RivalReport)| {
        let path = |field: &str| format!("beside.strategies.{i}.{field}");
        let figure = |field: &str, value| PageFigure::new(path(field), value, digits);
        let mut row = vec![
            Cell::Words(line.strategy.clone()),
            figure("mean", line.mean).into(),
        ];
        row.extend(by_risk.then(|| figure("value", line.value).into()));
        row.extend([
            match line.difference {
                Some(Interval { low, high }) => {
                    Cell::Interval(figure("diff_low", low), figure("diff_high", high))
                }
                None => Cell::empty(),
            },
            PageFigure::percent(path("picked_share"), line.picked_share).into(),
            figure("worst", line.worst).into(),
        ]);
        (false, row)
    };
    PageTable {
        rows: beside.strategies.iter().enumerate().map(row).collect(),
        header: RivalsReport::header(report.format(), &report.best),
    }
}
