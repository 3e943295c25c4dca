//! The page of a search.

use super::charts::CHARTS;
use super::objective::bracketed;
use super::report::{OptimumReport, RankedReport};
use super::rivals::{RivalReport, RivalsReport};
use super::validation::ValidationReport;
use crate::columns::TableColumns;
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
        more => shown.spelled(&format!("{more} more assignments were scored ('top').")),
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
    type RankingLine<'r> = (usize, &'r RankedReport);
    let digits = report.format().digits();
    let unit = report.format().bracketed_unit();
    let by_speed = report.ranking.iter().any(|line| line.max_speed.is_some());
    let path = |i: &usize, field: &str| format!("ranking.{i}.{field}");
    let figure =
        move |i: &usize, field: &str, value| PageFigure::new(path(i, field), value, digits);
    let columns = TableColumns::new()
        .with("#", |(i, _): &RankingLine| Cell::Text((i + 1).to_string()))
        .with("<assignment", |(_, line)| {
            Cell::Words(bracketed(&line.assignment))
        })
        .with(format!("mean{unit}"), move |(i, line)| {
            figure(i, "mean", line.mean).into()
        })
        .with_if(
            report.risk != "mean",
            format!("{}{unit}", report.risk),
            move |(i, line)| figure(i, "value", line.value).into(),
        )
        .with("best minus this, 95 %", move |(i, line)| match i {
            0 => Cell::empty(),
            _ => Cell::interval(
                ("diff_low", "diff_high"),
                line.difference,
                |field, value| figure(i, field, value),
            ),
        })
        .with("<", |(i, line)| Cell::Words(line.standing(*i).into()))
        .with("picked [%]", move |(i, line)| {
            PageFigure::percent(path(i, "picked_share"), line.picked_share).into()
        })
        .with(format!("worst{unit}"), move |(i, line)| {
            figure(i, "worst", line.worst).into()
        })
        .with("<on pattern", |(_, line)| {
            Cell::Words(line.worst_pattern.clone())
        })
        .with_if(by_speed, "max speed [m/s]", move |(i, line)| {
            let speed = line.max_speed;
            Cell::or_empty(speed.map(|speed| PageFigure::new(path(i, "max_speed"), speed, 4)))
        });
    let lines = report.ranking.iter().take(top).enumerate();
    PageTable::of(&columns, lines.map(|line| (false, line)))
}

fn validated(report: &OptimumReport, validation: &ValidationReport) -> PageTable {
    let digits = report.format().digits();
    let unit = report.format().bracketed_unit();
    let path = |field: &str| format!("validation.{field}");
    let figure = move |field: &str, value| PageFigure::new(path(field), value, digits);
    let percent = move |field: &str, share| PageFigure::percent(path(field), share);
    let exact = move |field: &str, value| PageFigure::exact(path(field), value);
    let columns = TableColumns::new()
        .with("patterns", move |v: &&ValidationReport| {
            exact("count", v.count as f64).into()
        })
        .with(format!("mean{unit}"), move |v| {
            figure("mean", v.mean).into()
        })
        .with("95 %", move |v| {
            Cell::interval(("mean_low", "mean_high"), v.mean_interval, figure)
        })
        .with(format!("{}{unit}", report.risk), move |v| {
            figure("value", v.value).into()
        })
        .with(format!("worst{unit}"), move |v| {
            figure("worst", v.worst).into()
        })
        .with("picked [%]", move |v| {
            percent("picked_share", v.picked_share).into()
        })
        .with("at belt speed [m/s]", move |v| {
            exact("speed", v.speed).into()
        })
        .with("fully picked", move |v| {
            exact("complete", v.complete as f64).into()
        })
        .with("[%]", move |v| {
            percent("complete_share", v.complete_share).into()
        })
        .with("95 %", move |v| {
            let ends = Some(v.complete_interval);
            Cell::interval(("complete_low", "complete_high"), ends, percent)
        });
    PageTable::of(&columns, [(false, validation)])
}

fn rivals(report: &OptimumReport, beside: &RivalsReport) -> PageTable {
    type RivalLine<'r> = (usize, &'r RivalReport);
    let format = report.format();
    let (digits, unit) = (format.digits(), format.bracketed_unit());
    let path = |i: &usize, field: &str| format!("beside.strategies.{i}.{field}");
    let figure =
        move |i: &usize, field: &str, value| PageFigure::new(path(i, field), value, digits);
    let columns = TableColumns::new()
        .with("<strategy", |(_, line): &RivalLine| {
            Cell::Words(line.strategy.clone())
        })
        .with(format!("mean{unit}"), move |(i, line)| {
            figure(i, "mean", line.mean).into()
        })
        .with_if(
            format.has_risk_column(),
            format!("{}{unit}", report.risk),
            move |(i, line)| figure(i, "value", line.value).into(),
        )
        .with(
            format!("minus {}, 95 %", bracketed(&report.best)),
            move |(i, line)| match line.difference {
                Some(ends) => {
                    let names = ("diff_low", "diff_high");
                    Cell::interval(names, Some(ends), |field, value| figure(i, field, value))
                }
                None => Cell::empty(),
            },
        )
        .with("picked [%]", move |(i, line)| {
            PageFigure::percent(path(i, "picked_share"), line.picked_share).into()
        })
        .with(format!("worst{unit}"), move |(i, line)| {
            figure(i, "worst", line.worst).into()
        });
    let lines = beside.strategies.iter().enumerate();
    PageTable::of(&columns, lines.map(|line| (false, line)))
}
