//! Warnings about pattern values that the model allows but that are implausible.

use super::item::{Item, Pattern};
use crate::error::{counted, listed, shown};
use crate::plausible::{ITEM_AREA, ITEM_GAP, OFF_CENTRE, Warning};
use crate::station::Station;
use std::collections::HashMap;

impl Pattern {
    /// The implausible values of the pattern, which the user knows as `name`.
    pub fn warnings(&self, name: &str) -> Vec<Warning> {
        let items = self.items();
        let place = |what: &str| format!("{name}: {what}");
        let widest = items.iter().map(|item| item.y.abs()).fold(0.0, f64::max);
        // Items are sorted by x0, the first one furthest downstream.
        let along = match items {
            [first, .., last] => (first.x0 - last.x0) / (items.len() - 1) as f64,
            _ => 0.0,
        };
        let mut areas: Vec<f64> = items.iter().filter_map(|item| item.area_cm2).collect();
        areas.sort_unstable_by(f64::total_cmp);
        let area = areas
            .get(areas.len() / 2)
            .copied()
            .filter(|area| *area > 0.0);
        [
            OFF_CENTRE.check(&place("y"), widest),
            ITEM_GAP.check(&place("x"), six_digits(along)),
            area.and_then(|area| ITEM_AREA.check(&place("median area_cm2"), area)),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

impl Pattern {
    /// Warns about items of the pattern, which the user knows as `name`, that no robot of `station`
    /// has a bin for although they are not unwanted. The first such class is named.
    pub fn check_bins(&self, name: &str, station: &Station) -> Option<Warning> {
        let has_no_bin = |item: &&Item| {
            let class = item.class.as_deref();
            let stated = class.and_then(|class| station.class(class));
            stated.is_none_or(|class| class.wanted) && !station.takes(station.class_id(class))
        };
        let mut counts: Vec<(&Option<String>, usize)> = Vec::new();
        let mut places: HashMap<&Option<String>, usize> = HashMap::new();
        for item in self.items().iter().filter(has_no_bin) {
            let place = *places.entry(&item.class).or_insert(counts.len());
            match counts.get_mut(place) {
                Some((_, count)) => *count += 1,
                None => counts.push((&item.class, 1)),
            }
        }
        let (class, _) = counts.first()?;
        let (shown_ones, others) = counts.split_at(counts.len().min(MOST_CLASSES));
        let mut parts: Vec<String> = shown_ones
            .iter()
            .map(|(class, count)| match class {
                Some(class) => format!("{} of class `{}`", counted(*count, "item"), shown(class)),
                None => format!("{} without a class", counted(*count, "item")),
            })
            .collect();
        if !others.is_empty() {
            let items: usize = others.iter().map(|(_, count)| count).sum();
            let classes = match others.len() {
                1 => "another class".to_owned(),
                count => format!("{count} other classes"),
            };
            parts.push(format!("{} of {classes}", counted(items, "item")));
        }
        let problem = format!(
            "no robot has a bin for {}, which will stay on the belt",
            listed(&parts)
        );
        let cure = match class {
            Some(_) => {
                "give a robot a bin for the class, or one without classes, which takes whatever \
                 the others do not name; or state the class with `wanted = false`"
            }
            None => {
                "give the items classes, by 'classes' (such as pet:0.4,hdpe:0.6) where patterns are \
                 generated or by the column class of a file; or give a robot a bin without classes"
            }
        };
        Some(Warning::new(format!("{name}: class"), problem, cure))
    }
}

/// More classes are not named one by one.
const MOST_CLASSES: usize = 4;

/// Computed values are shown with six digits.
fn six_digits(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use crate::pattern::{grid, parse};

    #[test]
    fn millimetres_are_warned_of_and_metres_are_not() {
        assert_eq!(grid(1.05, 0.15, 50).unwrap().warnings("p"), []);
        for (text, words) in [
            (
                "id,x,y\na,0,-300\nb,-150,150\n",
                &["p: y", "p: x", "300 mm is 0.3 m"][..],
            ),
            ("id,x,y\na,0,0\nb,-150,0\n", &["p: x", "150 mm is 0.15 m"]),
            (
                "id,x,y,area_cm2\na,0,0,8000\n",
                &["area_cm2", "square millimetres"],
            ),
        ] {
            let warnings = parse(text, "p").unwrap().warnings("p");
            let texts: Vec<String> = warnings.iter().map(|w| w.to_string()).collect();
            for word in words {
                assert!(texts.concat().contains(word), "{word} not in {texts:?}");
            }
        }
    }
}
