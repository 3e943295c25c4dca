//! The page of a sweep.

use super::chart_parts::method_words;
use super::charts::CHARTS;
use super::report::{BoundPoint, LimitReport, PointReport, SweepReport};
use super::thresholds::{ThresholdReport, ThresholdsReport};
use crate::classes::{ClassPageRow, class_page_columns};
use crate::columns::TableColumns;
use crate::page::{Cell, PageFigure, PageSection, PageTable, ReportPage, charts, escape};
use crate::purity::purity_page_columns;

/// The page for `report`.
pub(super) fn page(report: &SweepReport) -> String {
    let mut sections = charts(CHARTS, report);
    if report.is_of_thresholds() {
        // The chart of the purity, which is last in the table of charts, is this sweep's main one.
        sections.rotate_right(1);
        sections.extend(report.thresholds.as_ref().map(|thresholds| {
            PageSection::Table(
                "Thresholds".into(),
                chosen(thresholds),
                format!("Chosen on {}.", thresholds.trained_on),
            )
        }));
    } else {
        sections.push(PageSection::Table(
            "Limits".into(),
            limits(report),
            match report.limits.iter().any(|limit| lacks(report, limit)) {
                true => "A dash means: at no value of this sweep.".into(),
                false => String::new(),
            },
        ));
    }
    if report.has_purity() {
        sections.push(PageSection::Long(
            "Purity (the share of what is binned that belongs there) and recovery (of what is due) at \
             every value"
                .into(),
            purities(report),
        ));
    }
    sections.push(PageSection::Long(
        format!("All {} figures of the sweep", report.points.len()),
        points(report),
    ));
    if report.classes().next().is_some() {
        sections.push(PageSection::Long(
            "Recovery of each class: the share of its items that is picked, over all patterns \
             together"
                .into(),
            classes(report),
        ));
    }
    sections.push(PageSection::List("Notes".into(), report.notes.clone()));
    let page = ReportPage {
        title: format!(
            "Sweep of {} on {} pattern{}",
            match report.sweep {
                "speed" => "belt speed",
                "min-detection" => "the threshold of detections",
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

/// The purity and recovery of each method at the first and at the last threshold, and what is chosen.
fn threshold_answer(report: &SweepReport) -> Vec<String> {
    let methods = report.limits.len();
    let at = |place: usize| {
        let point = &report.points[place];
        let content = &point.sorting.as_ref()?.total.content;
        let share = |field: &str, share: f64| {
            PageFigure::percent(format!("points.{place}.sorting.{field}"), share).html()
        };
        Some(format!(
            "a purity of {} % and a recovery of {} % at {}",
            share("purity", content.purity?),
            share("recovery", content.recovery?),
            PageFigure::exact(format!("points.{place}.value"), point.value).html()
        ))
    };
    let line = |j: usize| {
        let own = (j..report.points.len()).step_by(methods);
        let ends = [own.clone().find_map(at), own.rev().find_map(at)];
        let ends: Vec<String> = ends.into_iter().flatten().collect();
        let method = escape(&method_words(&report.points[j].method));
        match ends.as_slice() {
            [first, last] if first != last => format!("{method} has {first}, and {last}."),
            [first, ..] => format!("{method} has {first}."),
            [] => format!("{method} puts nothing into any bin."),
        }
    };
    let mut lines: Vec<String> = (0..methods).map(line).collect();
    let chosen = report.thresholds.iter();
    let chosen = chosen.flat_map(|thresholds| thresholds.words(method_words));
    lines.extend(chosen.map(|words| format!("Choose for {}.", escape(&words))));
    lines
}

/// The threshold of each method for the wanted purity.
fn chosen(thresholds: &ThresholdsReport) -> PageTable {
    type Row<'r> = (usize, &'r ThresholdReport);
    let share = |row: &Row, field: &str, share: Option<f64>| {
        let path = format!("thresholds.methods.{}.{field}", row.0);
        Cell::or_dash(share.map(|share| PageFigure::percent(path, share)))
    };
    let ends = |row: &Row, names, ends| {
        Cell::interval(names, ends, |field, value| {
            let path = format!("thresholds.methods.{}.fresh.{field}", row.0);
            PageFigure::percent(path, value)
        })
    };
    let columns = TableColumns::new()
        .with("<method", |row: &Row| {
            Cell::Words(method_words(&row.1.method))
        })
        .with("threshold", |row| {
            let path = format!("thresholds.methods.{}.threshold", row.0);
            let value = row.1.threshold;
            Cell::or_dash(value.map(|value| PageFigure::exact(path, value)))
        })
        .with("purity in training [%]", move |row| {
            let trained = row.1.trained.and_then(|found| found.content.purity);
            share(row, "trained.purity", trained)
        })
        .with("purity on fresh patterns [%]", move |row| {
            let fresh = row.1.fresh.and_then(|found| found.content.purity);
            share(row, "fresh.purity", fresh)
        })
        .with("95 %", move |row| {
            let fresh = row.1.fresh.and_then(|found| found.purity_interval);
            ends(row, ("purity_low", "purity_high"), fresh)
        })
        .with("recovery on fresh patterns [%]", move |row| {
            let fresh = row.1.fresh.and_then(|found| found.content.recovery);
            share(row, "fresh.recovery", fresh)
        })
        .with("95 %", move |row| {
            let fresh = row.1.fresh.and_then(|found| found.recovery_interval);
            ends(row, ("recovery_low", "recovery_high"), fresh)
        });
    let methods = thresholds.methods.iter().enumerate();
    PageTable::of(&columns, methods.map(|row| (false, row)))
}

/// Purity and recovery at every value.
fn purities(report: &SweepReport) -> PageTable {
    let methods = report.limits.len();
    let points = report.purities().into_iter().enumerate();
    let rows = points.flat_map(|(i, rows)| {
        let begins = i % methods == 0;
        let rows = rows.into_iter().enumerate();
        rows.map(move |(place, row)| (begins && place == 0, row))
    });
    let group = report.varied();
    PageTable::of(&purity_page_columns(&group), rows)
}

fn answer(report: &SweepReport) -> Vec<String> {
    if report.is_of_thresholds() {
        return threshold_answer(report);
    }
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

/// A row of the table of limits: a method, or what the paper states.
enum LimitRow<'r> {
    Method(usize, &'r LimitReport),
    Paper(&'static str, PaperFigure<'r>, Option<f64>),
}

/// The field of a figure of the paper and its value.
type PaperFigure<'r> = (&'r str, f64);

impl LimitRow<'_> {
    fn name(&self) -> Cell {
        Cell::Words(match self {
            Self::Method(_, limit) => method_words(&limit.method),
            Self::Paper(name, ..) => format!("the paper's {name}"),
        })
    }

    /// The figure of a method, or a dash; empty for the paper.
    fn figure(&self, field: &str, of: impl Fn(&LimitReport) -> Option<f64>) -> Cell {
        match self {
            Self::Method(j, limit) => {
                let path = format!("limits.{j}.{field}");
                Cell::or_dash(of(limit).map(|value| PageFigure::exact(path, value)))
            }
            Self::Paper(..) => Cell::empty(),
        }
    }

    fn highest(&self) -> Cell {
        match self {
            Self::Method(..) => self.figure("highest", |limit| limit.highest),
            Self::Paper(_, (field, value), _) => {
                PageFigure::exact(format!("paper.{field}"), *value).into()
            }
        }
    }

    fn again(&self) -> Cell {
        match self {
            Self::Method(_, limit) => {
                let again: Vec<String> = limit.again.iter().map(f64::to_string).collect();
                Cell::Words(again.join(", "))
            }
            Self::Paper(..) => Cell::empty(),
        }
    }

    fn benefit(&self) -> Cell {
        let (path, percent) = match self {
            Self::Method(j, limit) => (format!("limits.{j}"), limit.benefit_percent),
            Self::Paper(_, _, percent) => ("paper".to_owned(), *percent),
        };
        let path = format!("{path}.benefit_percent");
        Cell::or_empty(percent.map(|percent| PageFigure::new(path, percent, 1)))
    }
}

fn limits(report: &SweepReport) -> PageTable {
    let many = report.patterns > 1;
    let unit = match report.unit {
        "1" => String::new(),
        unit => format!(" [{unit}]"),
    };
    let columns = TableColumns::new().with("<method", LimitRow::name);
    let columns = match report.helps {
        true => columns.with(format!("everything from{unit}"), |row| {
            row.figure("lowest", |limit| limit.lowest)
        }),
        false => {
            let columns = columns
                .with(format!("everything up to{unit}"), LimitRow::highest)
                .with("first miss at", |row| {
                    row.figure("first_miss", |limit| limit.first_miss)
                })
                .with("everything again at", LimitRow::again)
                .with("benefit [%]", LimitRow::benefit)
                .with_if(many, "95 % of the patterns to 99 % up to", |row| {
                    row.figure("highest_95_99", |limit| limit.highest_95_99)
                });
            let ends = ["limits of the patterns: least", "median", "greatest"];
            let ends = ends.into_iter().enumerate();
            ends.fold(columns, |columns, (k, name)| {
                columns.with_if(many, name, move |row| {
                    row.figure(&format!("of_patterns.{k}"), |limit| {
                        Some(limit.of_patterns[k])
                    })
                })
            })
        }
    };
    let limits = report.limits.iter().enumerate();
    let methods = limits.map(|(j, limit)| LimitRow::Method(j, limit));
    let paper = report.paper.iter().flat_map(|paper| {
        let benefit = Some(paper.benefit_percent);
        [
            LimitRow::Paper("robust GT", ("robust_gt", paper.robust_gt), None),
            LimitRow::Paper("RL", ("rl", paper.rl), benefit),
        ]
    });
    PageTable::of(&columns, methods.chain(paper).map(|row| (false, row)))
}

/// A row of the table of points.
struct PointRow<'r> {
    place: usize,
    point: &'r PointReport,
    /// Whether this is the first method at its value.
    first: bool,
    /// The place of the value and its bound; only beside the first method.
    bound: Option<(usize, &'r BoundPoint)>,
}

impl PointRow<'_> {
    fn path(&self, field: &str) -> String {
        format!("points.{}.{field}", self.place)
    }

    fn percent(&self, field: &str, share: f64) -> PageFigure {
        PageFigure::percent(self.path(field), share)
    }

    fn rate(&self, field: &str, value: f64) -> PageFigure {
        PageFigure::new(self.path(field), value, 2)
    }

    fn optional(&self, field: &str, value: Option<f64>) -> Cell {
        Cell::or_empty(value.map(|value| PageFigure::new(self.path(field), value, 1)))
    }

    /// A figure of the bound, or an empty cell.
    fn bound(
        &self,
        figure: impl Fn(&BoundPoint, &dyn Fn(&str) -> String) -> Option<PageFigure>,
    ) -> Cell {
        Cell::or_empty(self.bound.and_then(|(place, bound)| {
            figure(bound, &|field| format!("bounds.points.{place}.{field}"))
        }))
    }
}

fn point_columns(report: &SweepReport) -> TableColumns<'_, PointRow<'_>, Cell> {
    let many = report.patterns > 1;
    let columns = TableColumns::new()
        .with(report.varied(), |row: &PointRow| match row.first {
            true => PageFigure::exact(row.path("value"), row.point.value).into(),
            false => Cell::empty(),
        })
        .with("<method", |row| Cell::Words(row.point.title.clone()))
        .with_throughput(
            report.is_steady(),
            |row| &row.point.throughput,
            PointRow::path,
        )
        .with_if(report.adds(), "added a robot [1/min]", |row| {
            let added = row.point.added_per_robot_per_min;
            row.optional("added_per_robot_per_min", added)
        })
        .with("picked [%]", |row| {
            row.percent("picked_share", row.point.picked_share).into()
        })
        .with_if(many, "95 %", |row| {
            let names = ("picked_share_low", "picked_share_high");
            let interval = row.point.picked_share_interval;
            Cell::interval(names, interval, |field, value| row.percent(field, value))
        })
        .with("picking rate [1/min]", |row| {
            row.rate("picking_rate_per_min", row.point.picking_rate_per_min)
                .into()
        })
        .with_if(many, "95 %", |row| {
            let names = ("picking_rate_low", "picking_rate_high");
            let interval = row.point.picking_rate_interval;
            Cell::interval(names, interval, |field, value| row.rate(field, value))
        })
        .with_if(report.weighs, "weighted [1/min]", |row| {
            row.rate("weighted_rate_per_min", row.point.weighted_rate_per_min)
                .into()
        })
        .with_if(many, "complete [%]", |row| {
            row.percent("complete_share", row.point.complete_share)
                .into()
        })
        .with_if(many, "to 99 % [%]", |row| {
            let share = row.point.nearly_complete_share;
            row.percent("nearly_complete_share", share).into()
        });
    with_bound_columns(report, columns)
}

/// The same columns, followed by those of the bound if it is known.
fn with_bound_columns<'c>(
    report: &SweepReport,
    columns: TableColumns<'c, PointRow<'c>, Cell>,
) -> TableColumns<'c, PointRow<'c>, Cell> {
    let bounded = report.bounds.is_some();
    columns
        .with_if(bounded, "certified [%]", |row| {
            row.optional("certified_percent", row.point.certified_percent)
        })
        .with_if(bounded, "bound: picked [%]", |row| {
            row.bound(|bound, path| {
                let share = bound.picked_share;
                Some(PageFigure::percent(path("picked_share"), share))
            })
        })
        .with_if(bounded, "picking rate [1/min]", |row| {
            row.bound(|bound, path| {
                let rate = bound.picking_rate_per_min?;
                Some(PageFigure::new(path("picking_rate_per_min"), rate, 2))
            })
        })
}

/// What each method picks of each class at every value.
fn classes(report: &SweepReport) -> PageTable {
    let mut rows = Vec::new();
    for (i, point) in report.points.iter().enumerate() {
        for (place, class) in point.classes.iter().enumerate() {
            let first = i % report.limits.len() == 0 && place == 0;
            let row = ClassPageRow {
                group: match first {
                    true => PageFigure::exact(format!("points.{i}.value"), point.value).into(),
                    false => Cell::empty(),
                },
                method: if place == 0 { &point.title } else { "" },
                class,
                path: format!("points.{i}.classes.{place}"),
            };
            rows.push((place == 0, row));
        }
    }
    let (many, bounded) = (report.patterns > 1, report.bounds.is_some());
    PageTable::of(&class_page_columns(&report.varied(), many, bounded), rows)
}

fn points(report: &SweepReport) -> PageTable {
    let methods = report.limits.len();
    let rows = report.points.iter().enumerate().map(|(place, point)| {
        let first = place % methods == 0;
        let value = place / methods;
        let bounds = report.bounds.as_ref().filter(|_| first);
        let bound = bounds.and_then(|bounds| bounds.points.get(value));
        let row = PointRow {
            place,
            point,
            first,
            bound: bound.map(|bound| (value, bound)),
        };
        (first && methods > 1, row)
    });
    PageTable::of(&point_columns(report), rows)
}
