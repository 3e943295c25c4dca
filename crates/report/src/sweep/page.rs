//! The page of a sweep.

use super::charts::{CHARTS, method_words};
use super::report::{LimitReport, SweepReport};
use crate::page::{Cell, PageFigure, PageSection, PageTable, ReportPage, charts, escape};

/// The page for `report`.
pub(super) fn page(report: &SweepReport) -> String {
    let mut sections = charts(CHARTS, report);
    sections.push(PageSection::Table(
        "Limits".into(),
        limits(report),
        match report.limits.iter().any(|limit| lacks(report, limit)) {
            true => "A dash means: at no value of this sweep.".into(),
            false => String::new(),
        },
    ));
    sections.push(PageSection::Long(
        format!("All {} figures of the sweep", report.points.len()),
        points(report),
    ));
    sections.push(PageSection::List("Notes".into(), report.notes.clone()));
    let page = ReportPage {
        title: format!(
            "Sweep of {} on {} pattern{}",
            match report.sweep {
                "speed" => "belt speed",
                other => other,
            },
            report.patterns,
            if report.patterns == 1 { "" } else { "s" }
        ),
        subtitle: format!("Station {}", report.made.station),
        answer: answer(report),
        sections,
        made: &report.made,
    };
    page.html(report)
}

/// Whether some limit is outside the sweep.
fn lacks(report: &SweepReport, limit: &LimitReport) -> bool {
    match report.helps {
        true => limit.lowest.is_none(),
        false => [limit.highest, limit.first_miss].contains(&None),
    }
}

fn answer(report: &SweepReport) -> Vec<String> {
    let unit = report.unit_word();
    let line = |(j, limit): (usize, &LimitReport)| {
        let figure =
            |field: &str, value| PageFigure::exact(format!("limits.{j}.{field}"), value).html();
        let method = escape(&method_words(&limit.method));
        if report.helps {
            return match limit.lowest {
                Some(value) => format!(
                    "{method} picks everything from {} {unit} on.",
                    figure("lowest", value)
                ),
                None => format!("{method} never picks everything in this sweep."),
            };
        }
        let Some(highest) = limit.highest else {
            return format!("{method} misses an item even at the first value.");
        };
        let mut text = format!(
            "{method} picks everything up to {} {unit}",
            figure("highest", highest)
        );
        if let Some(percent) = limit.benefit_percent {
            let path = format!("limits.{j}.benefit_percent");
            text += &format!(
                " ({} % against the first)",
                PageFigure::new(path, percent, 1).html()
            );
        }
        text += &match limit.first_miss {
            Some(value) => format!(
                " and first misses an item at {}",
                figure("first_miss", value)
            ),
            None => " and misses nothing in this sweep".into(),
        };
        text + "."
    };
    let mut lines: Vec<String> = report.limits.iter().enumerate().map(line).collect();
    let chosen = report.recommendations(method_words).into_iter();
    lines.extend(chosen.map(|words| format!("Choose for {}.", escape(&words))));
    let avoided = report.avoided().into_iter();
    lines.extend(avoided.map(|words| format!("Avoid {}.", escape(&words))));
    if let Some(bounds) = &report.bounds {
        let words = bounds.words(report.helps, unit);
        let mut letters = words.chars();
        let first = letters.next().map(|c| c.to_ascii_uppercase());
        lines.push(format!(
            "{}.",
            escape(&String::from_iter(first.into_iter().chain(letters)))
        ));
    }
    lines
}

fn limits(report: &SweepReport) -> PageTable {
    let many = report.patterns > 1;
    let mut header = vec!["<method".to_owned()];
    let unit = match report.unit {
        "1" => String::new(),
        unit => format!(" [{unit}]"),
    };
    if report.helps {
        header.push(format!("everything from{unit}"));
    } else {
        header.extend([
            format!("everything up to{unit}"),
            "first miss at".into(),
            "everything again at".into(),
            "benefit [%]".into(),
        ]);
        if many {
            header.extend([
                "95 % of the patterns to 99 % up to".into(),
                "limits of the patterns: least".into(),
                "median".into(),
                "greatest".into(),
            ]);
        }
    }
    let row =
        |(j, limit): (usize, &LimitReport)| {
            let figure = |field: &str, value: Option<f64>| match value {
                Some(value) => PageFigure::exact(format!("limits.{j}.{field}"), value).into(),
                None => Cell::Text("\u{2013}".into()),
            };
            let mut row = vec![Cell::Words(method_words(&limit.method))];
            if report.helps {
                row.push(figure("lowest", limit.lowest));
                return (false, row);
            }
            let again: Vec<String> = limit.again.iter().map(f64::to_string).collect();
            row.extend([
                figure("highest", limit.highest),
                figure("first_miss", limit.first_miss),
                Cell::Words(again.join(", ")),
                Cell::or_empty(limit.benefit_percent.map(|percent| {
                    PageFigure::new(format!("limits.{j}.benefit_percent"), percent, 1)
                })),
            ]);
            if many {
                row.push(figure("highest_95_99", limit.highest_95_99));
                let own = limit.of_patterns.iter().enumerate();
                row.extend(own.map(|(k, value)| figure(&format!("of_patterns.{k}"), Some(*value))));
            }
            (false, row)
        };
    let mut rows: Vec<_> = report.limits.iter().enumerate().map(row).collect();
    if let Some(paper) = &report.paper {
        let own =
            |field: &str, value| Cell::from(PageFigure::exact(format!("paper.{field}"), value));
        let mut row = |name: &str, cell, benefit| {
            let words = Cell::Words(format!("the paper's {name}"));
            let mut row = vec![words, cell, Cell::empty(), Cell::empty(), benefit];
            row.resize_with(header.len(), Cell::empty);
            rows.push((false, row));
        };
        row(
            "robust GT",
            own("robust_gt", paper.robust_gt),
            Cell::empty(),
        );
        let benefit = PageFigure::new("paper.benefit_percent", paper.benefit_percent, 1);
        row("RL", own("rl", paper.rl), benefit.into());
    }
    PageTable { header, rows }
}

fn points(report: &SweepReport) -> PageTable {
    let many = report.patterns > 1;
    let varied = match report.unit {
        "1" => report.sweep.to_owned(),
        unit => format!("{} [{unit}]", report.sweep),
    };
    let mut header = vec![varied, "<method".into()];
    let (steady, adds) = (report.is_steady(), report.adds());
    if steady {
        header.extend(Cell::THROUGHPUT.map(str::to_owned));
    }
    header.extend(adds.then(|| "added a robot [1/min]".to_owned()));
    header.push("picked [%]".into());
    header.extend(many.then(|| "95 %".to_owned()));
    header.push("picking rate [1/min]".into());
    header.extend(many.then(|| "95 %".to_owned()));
    header.extend(report.weighs.then(|| "weighted [1/min]".to_owned()));
    if many {
        header.extend(["complete [%]".into(), "to 99 % [%]".into()]);
    }
    if report.bounds.is_some() {
        header.extend(
            ["certified [%]", "bound: picked [%]", "picking rate [1/min]"].map(str::to_owned),
        );
    }
    let methods = report.limits.len();
    let rows = report.points.iter().enumerate().map(|(i, point)| {
        let path = |field: &str| format!("points.{i}.{field}");
        let percent = |field: &str, share| PageFigure::percent(path(field), share);
        let rate = |field: &str, value| PageFigure::new(path(field), value, 2);
        let first = i % methods == 0;
        let mut row = vec![
            match first {
                true => PageFigure::exact(path("value"), point.value).into(),
                false => Cell::empty(),
            },
            Cell::Words(point.title.clone()),
        ];
        if steady {
            row.extend(Cell::throughput(&point.throughput, &path));
        }
        let added = point.added_per_robot_per_min;
        let added = added.map(|added| PageFigure::new(path("added_per_robot_per_min"), added, 1));
        row.extend(adds.then(|| Cell::or_empty(added)));
        row.push(percent("picked_share", point.picked_share).into());
        if many {
            row.push(Cell::interval(
                ("picked_share_low", "picked_share_high"),
                point.picked_share_interval,
                percent,
            ));
        }
        row.push(rate("picking_rate_per_min", point.picking_rate_per_min).into());
        if many {
            row.push(Cell::interval(
                ("picking_rate_low", "picking_rate_high"),
                point.picking_rate_interval,
                rate,
            ));
        }
        let weighted = rate("weighted_rate_per_min", point.weighted_rate_per_min);
        row.extend(report.weighs.then(|| weighted.into()));
        if many {
            row.extend([
                percent("complete_share", point.complete_share).into(),
                percent("nearly_complete_share", point.nearly_complete_share).into(),
            ]);
        }
        if let Some(bounds) = &report.bounds {
            let place = i / methods;
            let bound = bounds.points.get(place).filter(|_| first);
            let path = |field: &str| format!("bounds.points.{place}.{field}");
            let rate = bound.and_then(|bound| bound.picking_rate_per_min);
            let certified = point.certified_percent;
            row.extend([
                Cell::or_empty(
                    certified
                        .map(|c| PageFigure::new(format!("points.{i}.certified_percent"), c, 1)),
                ),
                Cell::or_empty(
                    bound.map(|b| PageFigure::percent(path("picked_share"), b.picked_share)),
                ),
                Cell::or_empty(
                    rate.map(|rate| PageFigure::new(path("picking_rate_per_min"), rate, 2)),
                ),
            ]);
        }
        (first && methods > 1, row)
    });
    PageTable {
        rows: rows.collect(),
        header,
    }
}
