//! A page as a whole: one HTML file that needs no network, no build step and no script.

use super::html::{escape, fill, inert};
use super::table::PageTable;
use crate::charts::{Chart, ChartKind, for_page};
use crate::game_theory::spell_out;
use crate::origin::with_page_origin;
use crate::palette::series_css;
use crate::provenance::Provenance;
use serde::Serialize;

/// The style that every page begins with.
pub const BASE_STYLE: &str = include_str!("base.css");

const PAGE: &str = include_str!("report.html");
const STYLE: &str = include_str!("report.css");

/// The content of a page.
pub(crate) struct ReportPage<'a> {
    /// A short title.
    pub title: String,
    /// What stands below the title: the station.
    pub subtitle: String,
    /// The answer, one sentence per line, as HTML.
    pub answer: Vec<String>,
    /// Charts and tables from top to bottom.
    pub sections: Vec<PageSection>,
    /// Where the result comes from.
    pub made: &'a Provenance,
}

/// A part of a page.
pub(crate) enum PageSection {
    /// A chart; its name is unique on the page.
    Chart(&'static str, Chart),
    /// A table with its heading and a remark.
    Table(String, PageTable, String),
    /// A table too long to show at once, and its summary.
    Long(String, PageTable),
    /// A list with its heading.
    List(String, Vec<String>),
}

/// All charts for which `report` has the data.
pub(crate) fn charts<R>(kinds: &[ChartKind<R>], report: &R) -> Vec<PageSection> {
    let charts = kinds.iter();
    charts
        .filter_map(|kind| Some(PageSection::Chart(kind.name, (kind.chart)(report)?)))
        .collect()
}

impl ReportPage<'_> {
    /// The page as HTML, with `report` embedded as JSON.
    pub(crate) fn html(&self, report: &impl Serialize) -> String {
        // Reports can always be serialised as JSON.
        let data = serde_json::to_string(report).unwrap_or_default();
        let style = [BASE_STYLE, &series_css(), STYLE].concat();
        let answer = self.answer.iter().map(|line| format!("<p>{line}</p>\n"));
        let mut opening = [
            escape(&self.title),
            escape(&self.subtitle),
            answer.collect::<String>(),
        ];
        opening.iter_mut().any(spell_out);
        let [heading, subtitle, answer] = opening;
        let sections = self.sections.iter().map(PageSection::html);
        let page = fill(
            PAGE,
            &[
                ("/*title*/", &escape(&format!("pickline: {}", self.title))),
                ("/*style*/", &style),
                ("/*heading*/", &heading),
                ("/*subtitle*/", &subtitle),
                ("/*answer*/", &answer),
                ("/*sections*/", &sections.collect::<String>()),
                ("/*provenance*/", &provenance(self.made)),
                ("/*data*/", &inert(&data)),
            ],
        );
        with_page_origin(&page, &self.made.command)
    }
}

impl PageSection {
    fn html(&self) -> String {
        match self {
            Self::Chart(name, chart) => format!(
                "<section>\n<h2>{}</h2>\n<figure id=\"chart-{name}\"><div class=\"chart\" \
                 tabindex=\"0\" role=\"group\" aria-label=\"{0}\">{}</div>\n\
                 <figcaption>{}</figcaption></figure>\n</section>\n",
                escape(&chart.title),
                for_page(chart),
                escape(&chart.note())
            ),
            Self::Table(heading, table, remark) => {
                let remark = match remark.as_str() {
                    "" => String::new(),
                    words => format!("<p class=\"remark\">{}</p>\n", escape(words)),
                };
                format!(
                    "<section>\n<h2>{}</h2>\n{}{remark}</section>\n",
                    escape(heading),
                    table.html()
                )
            }
            Self::Long(summary, table) => format!(
                "<section class=\"long\">\n<details><summary>{}</summary>\n{}</details>\n</section>\n",
                escape(summary),
                table.html()
            ),
            Self::List(heading, lines) => {
                let lines = lines
                    .iter()
                    .map(|line| format!("<li>{}</li>\n", escape(line)));
                format!(
                    "<section>\n<h2>{}</h2>\n<ul>\n{}</ul>\n</section>\n",
                    escape(heading),
                    lines.collect::<String>()
                )
            }
        }
    }
}

fn provenance(made: &Provenance) -> String {
    let Provenance {
        program,
        command,
        station,
        station_hash,
        patterns,
        conditions,
        seed,
        partial,
    } = made;
    let seed = seed.map(|seed| seed.to_string()).unwrap_or_default();
    let conditions = conditions.join("; ");
    let partial = partial.clone().unwrap_or_default();
    let facts = [
        ("partial", "", &partial),
        ("program", "", program),
        ("command", " class=\"code\"", command),
        ("station", "", station),
        ("station hash", " class=\"code\"", station_hash),
        ("patterns", "", patterns),
        ("conditions", "", &conditions),
        ("seed", "", &seed),
    ];
    let known = facts.into_iter().filter(|(_, _, value)| !value.is_empty());
    let fact = |(name, class, value): (&str, &str, &String)| {
        format!("<dt>{name}</dt><dd{class}>{}</dd>\n", escape(value))
    };
    known.map(fact).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_has_every_marker_once_and_in_order() {
        let markers = [
            "title",
            "style",
            "heading",
            "subtitle",
            "answer",
            "sections",
            "provenance",
            "data",
        ];
        let mut last = 0;
        for marker in markers.map(|name| format!("/*{name}*/")) {
            assert_eq!(PAGE.matches(&marker).count(), 1, "{marker}");
            let place = PAGE.find(&marker).unwrap();
            assert!(place > last);
            last = place;
        }
        // Nothing that would close the element that contains the style.
        assert!(![BASE_STYLE, STYLE].concat().contains("</"));
    }
}
