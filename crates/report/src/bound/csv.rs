//! A bound as CSV.

use super::report::{BoundReport, ScheduleReport};
use crate::csv_rows::{CsvRows, Displayed, OptionalNumber};
use serde::Serialize;

#[derive(Default, Serialize)]
struct FigureRow {
    figure: &'static str,
    value: OptionalNumber,
}

#[derive(Default, Serialize)]
struct PriceRow<'r> {
    item: &'r str,
    price: Displayed,
}

impl BoundReport {
    /// The figures, one per line.
    pub(super) fn figures_csv(&self) -> CsvRows {
        let of = |figure: fn(&ScheduleReport) -> f64| self.schedule.as_ref().map(figure);
        let rows = [
            ("picks_upper_bound", Some(self.picks_upper_bound as f64)),
            ("picks_relaxed", Some(self.picks_relaxed)),
            ("weight_upper_bound", self.weight_upper_bound),
            (
                "picking_rate_upper_bound_per_min",
                self.picking_rate_upper_bound_per_min,
            ),
            (
                "weighted_rate_upper_bound_per_min",
                self.weighted_rate_upper_bound_per_min,
            ),
            ("end_lower_bound_s", Some(self.end_lower_bound_s)),
            (
                "all_picked_end_lower_bound_s",
                self.all_picked_end_lower_bound_s,
            ),
            ("schedule_picked", of(|s| s.picked as f64)),
            ("schedule_weight", of(|s| s.weight)),
            ("schedule_end_s", of(|s| s.end_s)),
        ];
        let rows = rows.map(|(figure, value)| FigureRow {
            figure,
            value: value.map(Displayed),
        });
        CsvRows::of(rows)
    }

    /// The price of every item: what picking it costs the other items.
    pub(super) fn prices_csv(&self) -> CsvRows {
        let rows = self.prices.iter().map(|(item, price)| PriceRow {
            item,
            price: Displayed(*price),
        });
        CsvRows::of(rows)
    }
}
