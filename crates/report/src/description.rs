//! Figures that describe a pattern.

use super::table::{Table, fixed};
use pickline::pattern::Description;
use serde::Serialize;

/// The figures of a pattern, and of its flow if the belt's speed is known.
#[derive(Debug, Clone, Serialize)]
pub struct DescriptionReport {
    /// Figures that do not depend on the belt.
    #[serde(flatten)]
    pub pattern: Description,
    /// Belt speed [m/s], if known.
    pub belt_speed: Option<f64>,
    /// Items per minute that pass a fixed point at that speed [1/min].
    pub flow_per_min: Option<f64>,
}

impl DescriptionReport {
    /// The figures of `pattern` on a belt with this speed [m/s], if it is known.
    pub fn new(pattern: Description, belt_speed: Option<f64>) -> Self {
        let flow = |speed: f64| Some(60.0 * pattern.items_per_m? * speed);
        Self {
            flow_per_min: belt_speed.and_then(flow),
            belt_speed,
            pattern,
        }
    }
}

/// The figures as a table.
pub fn description_table(report: &DescriptionReport) -> Table {
    let d = &report.pattern;
    let optional = |value: Option<f64>| value.map_or("-".into(), |v| fixed(v, 4));
    let mut table = Table::new(&["<figure", "value", "<unit"]);
    table.row(["items".to_owned(), d.items.to_string(), String::new()]);
    table.row([
        "length along the belt".into(),
        fixed(d.length_m, 4),
        "m".into(),
    ]);
    table.row([
        "width across the belt".into(),
        fixed(d.width_m, 4),
        "m".into(),
    ]);
    table.row([
        "across the belt, from the centre line".to_owned(),
        format!(
            "{} to {}",
            fixed(d.y_range_m[0], 4),
            fixed(d.y_range_m[1], 4)
        ),
        "m".into(),
    ]);
    table.row([
        "density".into(),
        optional(d.items_per_m),
        "items/m".to_owned(),
    ]);
    if let Some(speed) = report.belt_speed {
        table.row([
            format!("flow at {speed} m/s"),
            optional(report.flow_per_min),
            "items/min".into(),
        ]);
    }
    table.row([
        "nearest neighbour, minimum".into(),
        optional(d.nearest_min_m),
        "m".to_owned(),
    ]);
    table.row([
        "nearest neighbour, mean".into(),
        optional(d.nearest_mean_m),
        "m".to_owned(),
    ]);
    let [low, mean, high] = d.reward.map(|r| fixed(r, 4));
    table.row([
        "reward, minimum / mean / maximum".into(),
        format!("{low} / {mean} / {high}"),
        String::new(),
    ]);
    for (name, count) in [
        ("with an area", d.with_area),
        ("with a detection probability", d.with_p_detection),
        ("with a grasp probability", d.with_p_grasp),
        ("with an explicit weight", d.with_weight),
    ] {
        table.row([name.to_owned(), count.to_string(), "items".into()]);
    }
    for (class, count) in &d.classes {
        table.row([format!("class {class}"), count.to_string(), "items".into()]);
    }
    table
}
