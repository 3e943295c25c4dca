//! The kinds of charts that a report has, by name.

use super::chart::Chart;
use super::draw;
use crate::provenance::Provenance;
use pickline::error::{Error, Result, known_names, shown};

/// What errors name as their place.
const PLACE: &str = "chart";

/// A kind of chart for a report `R`; the first of a report's kinds is its main chart.
#[derive(Debug)]
pub struct ChartKind<R> {
    /// Its name, unique among those of the report.
    pub name: &'static str,
    /// Makes the chart; `None` if the report lacks the data.
    pub(crate) chart: fn(&R) -> Option<Chart>,
    /// What the report needs for this chart, in words; settings are in single quotes, as in
    /// [`pickline::error::spell_settings`].
    pub needs: &'static str,
}

impl<R> ChartKind<R> {
    /// The kind with this name; the first if there is none.
    ///
    /// # Errors
    /// The name is unknown; the message suggests the nearest known one.
    pub fn named<'a>(kinds: &'a [Self], name: Option<&str>) -> Result<&'a Self> {
        let wanted = name.or_else(|| kinds.first().map(|kind| kind.name));
        let wanted = wanted.unwrap_or_default();
        let found = kinds.iter().find(|kind| kind.name == wanted);
        found.ok_or_else(|| {
            let names: Vec<&str> = kinds.iter().map(|kind| kind.name).collect();
            Error::usage(
                PLACE,
                format!("this report has no chart `{}`", shown(wanted)),
                known_names(wanted, &names),
            )
        })
    }

    /// The error for a report that lacks the data for this chart.
    pub fn missing(&self) -> Error {
        Error::usage(
            PLACE,
            format!("there is no data for the chart `{}`", self.name),
            format!("it needs {}", self.needs),
        )
    }

    /// The chart of `report` as an SVG file for a paper that states how it was `made`.
    ///
    /// # Errors
    /// The report lacks the data for this chart.
    pub fn svg(&self, report: &R, made: Option<&Provenance>) -> Result<String> {
        let chart = (self.chart)(report).ok_or_else(|| self.missing())?;
        Ok(draw::for_paper(chart, made))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_charts_name_the_nearest() {
        let kinds = [ChartKind::<()> {
            name: "rate",
            chart: |()| None,
            needs: "nothing",
        }];
        assert_eq!(ChartKind::named(&kinds, None).unwrap().name, "rate");
        let message = ChartKind::named(&kinds, Some("rat"))
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("chart: this report has no chart") && message.contains("`rate`"),
            "{message}"
        );
    }
}
