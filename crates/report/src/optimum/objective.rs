//! How the figures of an objective are named and shown.

use crate::table::column;
use pickline::optimize::Risk;

/// An objective under a risk, as reports name it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ObjectiveFormat<'r> {
    /// Name of the objective.
    pub objective: &'static str,
    /// Unit of the objective, for example `1/min`.
    pub unit: &'static str,
    /// How values of several patterns are aggregated.
    pub risk: &'r str,
}

impl ObjectiveFormat<'_> {
    /// The unit for a column header; shares have none.
    pub(super) fn bracketed_unit(self) -> String {
        match self.unit {
            "1" => String::new(),
            unit => format!(" [{unit}]"),
        }
    }

    /// Whether the risk needs a column besides those of mean and worst.
    pub(super) fn has_risk_column(self) -> bool {
        ![Risk::Mean, Risk::Worst]
            .map(|r| r.to_string())
            .iter()
            .any(|risk| risk == self.risk)
    }

    /// The unit after a number; shares have none.
    pub(super) fn spaced_unit(self) -> String {
        match self.unit {
            "1" => String::new(),
            unit => format!(" {unit}"),
        }
    }

    /// The name in CSV files of a figure of the objective: `picking_rate_mean_per_min`.
    pub(super) fn column(self, figure: &str) -> String {
        let objective = self.objective.replace('-', "_");
        column(&format!("{objective}_{figure}"), self.unit)
    }

    /// Decimals suitable for the objective's unit.
    pub(super) fn digits(self) -> usize {
        match self.unit {
            "1/min" => 2,
            _ => 4,
        }
    }
}

/// An assignment as shown: `[SPT; FIFO]`.
pub(super) fn bracketed(names: &[&str]) -> String {
    format!("[{}]", names.join("; "))
}
