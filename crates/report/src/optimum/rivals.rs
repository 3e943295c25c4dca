//! Strategies of any kind compared with the winner of a search.

use super::objective::{ObjectiveFormat, bracketed};
use crate::columns::TableColumns;
use crate::table::{fixed, interval};
use pickline::optimize::Rival;
use pickline::stats::Interval;
use serde::Serialize;

/// The winner and other strategies on the same patterns.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct RivalsReport {
    /// Description of the patterns.
    pub patterns: String,
    /// Number of patterns on which each strategy was scored.
    pub count: usize,
    /// The winner, then the others in the order requested.
    pub strategies: Vec<RivalReport>,
}

/// One of the strategies compared.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct RivalReport {
    /// The strategy as written on the command line.
    pub strategy: String,
    /// Mean of the objective over the patterns, in its unit.
    pub mean: f64,
    /// The objective aggregated under the risk used in the search.
    pub value: f64,
    /// 95 % interval of this one minus the winner; omitted for the winner and for a single pattern.
    #[serde(
        flatten,
        skip_serializing_if = "Option::is_none",
        serialize_with = "crate::ends::difference"
    )]
    pub difference: Option<Interval>,
    /// Mean share of the items picked.
    pub picked_share: f64,
    /// The objective on the worst pattern.
    pub worst: f64,
}

impl RivalsReport {
    /// The report of `rivals`, the winner first; `names` are the names of the others.
    pub fn new<'a>(
        rivals: &[Rival],
        best: &[&str],
        names: impl Iterator<Item = &'a str>,
        patterns: &str,
        count: usize,
    ) -> Self {
        let winner = format!("rules:{}", best.join(","));
        let names = std::iter::once(winner).chain(names.map(str::to_owned));
        let row = |(place, (rival, strategy)): (usize, (&Rival, String))| RivalReport {
            strategy,
            mean: rival.mean,
            value: rival.at_risk,
            difference: rival.difference.filter(|_| place > 0),
            picked_share: rival.picked_share,
            worst: rival.worst,
        };
        Self {
            patterns: patterns.to_owned(),
            count,
            strategies: rivals.iter().zip(names).enumerate().map(row).collect(),
        }
    }

    /// The table, preceded by a line that describes the patterns; `best` is the winner, and
    /// `validated` describes the patterns of the lines above.
    pub(super) fn to_table(
        &self,
        format: ObjectiveFormat,
        best: &[&str],
        validated: Option<&str>,
    ) -> String {
        let digits = format.digits();
        let unit = format.bracketed_unit();
        let risk = format!("{}{unit}", format.risk);
        let minus = format!("minus {}, 95 %", bracketed(best));
        let columns = TableColumns::new()
            .with("<strategy", |(_, line): &(usize, &RivalReport)| {
                line.strategy.clone()
            })
            .with(format!("mean{unit}"), |(_, line)| fixed(line.mean, digits))
            .with_if(format.has_risk_column(), risk, |(_, line)| {
                fixed(line.value, digits)
            })
            .with(minus, |(place, line)| match place {
                0 => String::new(),
                _ => interval(line.difference, digits),
            })
            .with("picked [%]", |(_, line)| {
                fixed(100.0 * line.picked_share, 1)
            })
            .with(format!("worst{unit}"), |(_, line)| {
                fixed(line.worst, digits)
            });
        let table = columns.table(self.strategies.iter().enumerate());
        let patterns = match validated == Some(self.patterns.as_str()) {
            true => "the same patterns",
            false => &self.patterns,
        };
        format!("beside    the winner and other strategies on {patterns}\n{table}")
    }
}
