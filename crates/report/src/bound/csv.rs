//! A bound as CSV.

use super::report::{BoundReport, ScheduleReport};

impl BoundReport {
    /// The figures by their names in files; `None` becomes an empty field.
    fn rows(&self) -> Vec<(&'static str, Option<String>)> {
        let text = |value: Option<f64>| value.map(|value| value.to_string());
        let of = |figure: fn(&ScheduleReport) -> f64| text(self.schedule.as_ref().map(figure));
        vec![
            (
                "picks_upper_bound",
                Some(self.picks_upper_bound.to_string()),
            ),
            ("picks_relaxed", text(Some(self.picks_relaxed))),
            ("weight_upper_bound", text(self.weight_upper_bound)),
            (
                "picking_rate_upper_bound_per_min",
                text(self.picking_rate_upper_bound_per_min),
            ),
            (
                "weighted_rate_upper_bound_per_min",
                text(self.weighted_rate_upper_bound_per_min),
            ),
            ("end_lower_bound_s", text(Some(self.end_lower_bound_s))),
            (
                "all_picked_end_lower_bound_s",
                text(self.all_picked_end_lower_bound_s),
            ),
            ("schedule_picked", of(|s| s.picked as f64)),
            ("schedule_weight", of(|s| s.weight)),
            ("schedule_end_s", of(|s| s.end_s)),
        ]
    }

    /// The figures as CSV, one per line.
    pub fn to_csv(&self) -> String {
        let header = ["figure", "value"].map(str::to_owned);
        let rows = self.rows().into_iter();
        let rows = rows.map(|(name, value)| [name.to_owned(), value.unwrap_or_default()]);
        self.made.csv(std::iter::once(header).chain(rows))
    }

    /// The price of every item as CSV: what picking it costs the other items.
    pub fn prices_csv(&self) -> String {
        let header = ["item", "price"].map(str::to_owned);
        let rows = self.prices.iter();
        let rows = rows.map(|(id, price)| [id.clone(), price.to_string()]);
        self.made.csv(std::iter::once(header).chain(rows))
    }
}
