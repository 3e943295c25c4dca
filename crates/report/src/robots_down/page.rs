//! The page of a sweep over halted robots.

use super::charts::CHARTS;
use super::report::{HaltedPointReport, RobotsDownReport};
use crate::columns::TableColumns;
use crate::page::{Cell, PageFigure, PageSection, PageTable, ReportPage, charts, escape};
use crate::sweep::method_words;
use pickline::error::counted;

/// The page for `report`.
pub(super) fn page(report: &RobotsDownReport) -> String {
    let mut sections = charts(CHARTS, report);
    sections.push(PageSection::Long(
        format!("All {} figures", report.points.len()),
        points(report),
    ));
    sections.push(PageSection::List("Notes".into(), report.notes.clone()));
    let page = ReportPage {
        title: format!("One robot down, on {}", counted(report.patterns, "pattern")),
        subtitle: format!("Station {}", report.made.station),
        answer: answer(report),
        sections,
        made: &report.made,
    };
    page.html(report)
}

/// What each method still picks without the robot that it misses most.
fn answer(report: &RobotsDownReport) -> Vec<String> {
    let line = |(j, worst): (usize, Option<usize>)| {
        let method = escape(&method_words(&report.points[j].method));
        let Some(place) = worst else {
            return format!("{method} picks no less without any single robot.");
        };
        let point = &report.points[place];
        let loss = point.loss_percent.unwrap_or_default();
        format!(
            "{method} picks least without {}: {} % of the items, {} % fewer than with all robots.",
            escape(point.halted()),
            PageFigure::percent(format!("points.{place}.picked_share"), point.picked_share).html(),
            PageFigure::new(format!("points.{place}.loss_percent"), loss, 1).html(),
        )
    };
    let robots = report.points.len() > report.methods;
    let lines = report.worst().into_iter().enumerate().map(line);
    lines.filter(|_| robots).collect()
}

/// A row of the table of points.
struct HaltedRow<'r> {
    place: usize,
    point: &'r HaltedPointReport,
    /// Whether this is the first method with its robot.
    first: bool,
}

impl HaltedRow<'_> {
    fn path(&self, field: &str) -> String {
        format!("points.{}.{field}", self.place)
    }

    fn percent(&self, field: &str, share: f64) -> PageFigure {
        PageFigure::percent(self.path(field), share)
    }

    fn figure(&self, field: &str, value: f64, digits: usize) -> PageFigure {
        PageFigure::new(self.path(field), value, digits)
    }
}

fn points(report: &RobotsDownReport) -> PageTable {
    let many = report.patterns > 1;
    let columns = TableColumns::new()
        .with("<robot down", |row: &HaltedRow| match row.first {
            true => Cell::Words(row.point.halted().to_owned()),
            false => Cell::Words(String::new()),
        })
        .with("<method", |row| Cell::Words(row.point.title.clone()))
        .with_throughput(
            report.is_steady(),
            |row| &row.point.throughput,
            HaltedRow::path,
        )
        .with("picked [%]", |row| {
            row.percent("picked_share", row.point.picked_share).into()
        })
        .with_if(many, "95 %", |row| {
            let names = ("picked_share_low", "picked_share_high");
            let interval = row.point.picked_share_interval;
            Cell::interval(names, interval, |field, value| row.percent(field, value))
        })
        .with("picking rate [1/min]", |row| {
            let rate = row.point.picking_rate_per_min;
            row.figure("picking_rate_per_min", rate, 2).into()
        })
        .with_if(many, "95 %", |row| {
            let names = ("picking_rate_low", "picking_rate_high");
            let interval = row.point.picking_rate_interval;
            Cell::interval(names, interval, |field, value| row.figure(field, value, 2))
        })
        .with_if(report.weighs, "weighted [1/min]", |row| {
            let rate = row.point.weighted_rate_per_min;
            row.figure("weighted_rate_per_min", rate, 2).into()
        })
        .with("loss [%]", |row| {
            let loss = row.point.loss_percent;
            Cell::or_empty(loss.map(|loss| row.figure("loss_percent", loss, 1)))
        })
        .with_if(many, "95 %", |row| match row.point.loss_percent {
            Some(_) => {
                let names = ("loss_low", "loss_high");
                let interval = row.point.loss_interval;
                Cell::interval(names, interval, |field, value| row.figure(field, value, 1))
            }
            None => Cell::empty(),
        });
    let rows = report.points.iter().enumerate().map(|(place, point)| {
        let first = place % report.methods == 0;
        let row = HaltedRow {
            place,
            point,
            first,
        };
        (first && report.methods > 1, row)
    });
    PageTable::of(&columns, rows)
}
