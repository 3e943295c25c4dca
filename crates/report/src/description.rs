//! Figures that describe a pattern.

use super::columns::TableColumns;
use super::csv_rows::CsvRows;
use super::presentation::Presentation;
use super::provenance::Provenance;
use super::table::fixed;
use super::verb_report::{ResultFile, VerbReport};
use pickline::pattern::Description;
use serde::Serialize;

/// The figures of a pattern, and of its flow if the belt's speed is known.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct DescriptionReport {
    /// Figures that do not depend on the belt.
    #[serde(flatten)]
    pub pattern: Description,
    /// Belt speed [m/s], if known.
    pub belt_speed: Option<f64>,
    /// Items per minute that pass a fixed point at that speed [1/min].
    pub flow_per_min: Option<f64>,
    /// Where the pattern comes from.
    #[serde(skip)]
    name: String,
}

impl DescriptionReport {
    /// The figures of `pattern` on a belt with this speed [m/s], if it is known.
    pub fn new(pattern: Description, belt_speed: Option<f64>) -> Self {
        let flow = |speed: f64| Some(60.0 * pattern.items_per_m? * speed);
        Self {
            flow_per_min: belt_speed.and_then(flow),
            belt_speed,
            pattern,
            name: String::new(),
        }
    }

    /// The same; `name` says where the pattern comes from.
    pub fn named(self, name: String) -> Self {
        Self { name, ..self }
    }
}

/// A figure as shown.
#[derive(Default, Serialize)]
struct FigureLine {
    figure: String,
    value: String,
    unit: &'static str,
}

impl DescriptionReport {
    fn lines(&self) -> Vec<FigureLine> {
        let d = &self.pattern;
        let mut lines = Vec::new();
        let mut line = |figure: &str, value: String, unit| {
            lines.push(FigureLine {
                figure: figure.to_owned(),
                value,
                unit,
            });
        };
        let optional = |value: Option<f64>| value.map_or("-".into(), |v| fixed(v, 4));
        line("items", d.items.to_string(), "");
        line("length along the belt", fixed(d.length_m, 4), "m");
        line("width across the belt", fixed(d.width_m, 4), "m");
        let [low, high] = d.y_range_m.map(|y| fixed(y, 4));
        let across = "across the belt, from the centre line";
        line(across, format!("{low} to {high}"), "m");
        line("density", optional(d.items_per_m), "items/m");
        if let Some(speed) = self.belt_speed {
            let flow = optional(self.flow_per_min);
            line(&format!("flow at {speed} m/s"), flow, "items/min");
        }
        let nearest = optional(d.nearest_min_m);
        line("nearest neighbour, minimum", nearest, "m");
        line("nearest neighbour, mean", optional(d.nearest_mean_m), "m");
        let [low, mean, high] = d.reward.map(|r| fixed(r, 4));
        let reward = format!("{low} / {mean} / {high}");
        line("reward, minimum / mean / maximum", reward, "");
        for (name, count) in [
            ("with an area", d.with_area),
            ("with a detection probability", d.with_p_detection),
            ("with a grasp probability", d.with_p_grasp),
            ("with an explicit weight", d.with_weight),
        ] {
            line(name, count.to_string(), "items");
        }
        if d.with_true_class > 0 {
            line("with a true class", d.with_true_class.to_string(), "items");
            line("of these misdetected", d.misdetected.to_string(), "items");
        }
        for (class, count) in &d.classes {
            line(&format!("class {class}"), count.to_string(), "items");
        }
        lines
    }
}

impl VerbReport for DescriptionReport {
    const FILES: &'static [ResultFile<Self>] = &[];

    fn provenance(&self) -> Option<&Provenance> {
        None
    }

    fn to_table(&self, _: &Presentation) -> String {
        let table = TableColumns::new()
            .with("<figure", |line: &FigureLine| line.figure.clone())
            .with("value", |line| line.value.clone())
            .with("<unit", |line| line.unit.to_owned())
            .table(self.lines());
        format!("{table}pattern   {}\n", self.name)
    }

    fn to_csv(&self) -> String {
        CsvRows::of(self.lines()).plain_text()
    }
}
