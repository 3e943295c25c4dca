//! A pattern's figures.

use super::table::{Table, fixed};
use crate::pattern::Description;

/// The figures of a pattern, with the items per minute that it brings at
/// `belt_speed` [m/s].
pub fn description_table(d: &Description, belt_speed: f64) -> Table {
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
        "across, from the centre line".to_owned(),
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
    table.row([
        format!("arrival at {belt_speed} m/s"),
        optional(d.items_per_m.map(|density| 60.0 * density * belt_speed)),
        "items/min".into(),
    ]);
    table.row([
        "nearest neighbour, least".into(),
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
        "reward, least / mean / most".into(),
        format!("{low} / {mean} / {high}"),
        String::new(),
    ]);
    for (name, count) in [
        ("with an area", d.with_area),
        ("with a detection probability", d.with_p_detection),
        ("with a grasp probability", d.with_p_grasp),
        ("with a weight of their own", d.with_weight),
    ] {
        table.row([name.to_owned(), count.to_string(), "items".into()]);
    }
    for (class, count) in &d.classes {
        table.row([format!("class {class}"), count.to_string(), "items".into()]);
    }
    table
}
