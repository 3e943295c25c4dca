//! Items and the validated, sorted pattern.

use crate::error::{Error, Result, shown, shown_number};
use crate::names::check_name;
use crate::station::Station;
use std::collections::HashMap;

/// Positions past this [m] are refused: no belt is that long.
pub(super) const LARGEST: f64 = 1e6;
/// More items than this in one pattern would not fit into memory with comfort.
pub(super) const MOST_ITEMS: usize = 10_000_000;

/// Whether `value` is a probability.
pub(super) fn is_share(value: f64) -> bool {
    (0.0..=1.0).contains(&value)
}

/// Whether `value` is an area [cm^2] or a weight.
pub(super) fn is_amount(value: f64) -> bool {
    (0.0..=1e12).contains(&value)
}

/// One item on the belt.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Item {
    /// Name, unique in its pattern.
    pub id: String,
    /// Position along the travel at time 0 [m], at most 0.
    pub x0: f64,
    /// Position across the belt [m]; items do not slide.
    pub y: f64,
    /// Area seen from above [cm^2].
    pub area_cm2: Option<f64>,
    /// Probability that the detection is a real item.
    pub p_detection: Option<f64>,
    /// Probability that a grasp succeeds.
    pub p_grasp: Option<f64>,
    /// Explicit weight; wins over the one that follows from the columns above.
    pub weight: Option<f64>,
    /// What it is, for reports.
    pub class: Option<String>,
}

/// The logistic function.
pub fn sigmoid(z: f64) -> f64 {
    1.0 / (1.0 + (-z).exp())
}

impl Item {
    /// An item of which only the position is known [m].
    pub fn at(id: impl Into<String>, x0: f64, y: f64) -> Self {
        Self {
            id: id.into(),
            x0,
            y,
            ..Self::default()
        }
    }

    /// The object-specific reward `r = p_detection p_grasp sigmoid(A / 100 cm^2)`
    /// (Jermann et al., equation 2), or the explicit weight. A missing probability
    /// is 1 and a missing area 0, so 0.5 when nothing is known.
    pub fn reward(&self) -> f64 {
        self.weight.unwrap_or_else(|| {
            self.p_detection.unwrap_or(1.0)
                * self.p_grasp.unwrap_or(1.0)
                * sigmoid(self.area_cm2.unwrap_or(0.0) / 100.0)
        })
    }

    /// What the model forbids about this item on its own: the field, the value's
    /// problem and the cure.
    fn problem(&self) -> Option<(&'static str, String, &'static str)> {
        let position = |value: f64| value.is_finite() && value.abs() <= LARGEST;
        let share = |value: &Option<f64>| value.is_none_or(is_share);
        let amount = |value: &Option<f64>| value.is_none_or(is_amount);
        let class = self.class.as_deref().filter(|class| !class.is_empty());
        if self.id.is_empty() {
            Some(("id", "the id is empty".into(), "give every item an id"))
        } else if let Err(bad) = check_name(&self.id) {
            let cure = "give ids that fit on one line, of at most 200 printable characters, \
                        without blanks at an end";
            Some(("id", bad.problem, cure))
        } else if let Some(Err(bad)) = class.map(check_name) {
            let cure = "give classes that fit on one line, of at most 200 printable \
                        characters, without blanks at an end";
            Some(("class", bad.problem, cure))
        } else if !position(self.x0) {
            let cure = "give metres in the belt frame";
            Some((
                "x",
                format!("{} is not a position", shown_number(self.x0)),
                cure,
            ))
        } else if self.x0 > 0.0 {
            Some((
                "x",
                format!(
                    "the item is at x = {} m at time 0, past the belt's start",
                    shown_number(self.x0)
                ),
                "shift the pattern so that every x is 0 or less",
            ))
        } else if !position(self.y) {
            let cure = "give metres from the centre line";
            Some((
                "y",
                format!("{} is not a position", shown_number(self.y)),
                cure,
            ))
        } else if !amount(&self.area_cm2) {
            let value = shown_number(self.area_cm2.unwrap_or_default());
            let cure = "give cm^2, 0 or more, or leave the field empty";
            Some(("area_cm2", format!("{value} is not an area"), cure))
        } else if !share(&self.p_detection) {
            let value = shown_number(self.p_detection.unwrap_or_default());
            let cure = "give a number from 0 to 1, or leave the field empty";
            Some(("p_detection", format!("{value} is not a probability"), cure))
        } else if !share(&self.p_grasp) {
            let value = shown_number(self.p_grasp.unwrap_or_default());
            let cure = "give a number from 0 to 1, or leave the field empty";
            Some(("p_grasp", format!("{value} is not a probability"), cure))
        } else if !amount(&self.weight) {
            let value = shown_number(self.weight.unwrap_or_default());
            let cure = "give a number, 0 or more, or leave the field empty";
            Some(("weight", format!("{value} is not a weight"), cure))
        } else {
            None
        }
    }
}

/// The items of one run, sorted stably by `x0`, the furthest downstream first. An
/// item's index is its place in this order; ids never break ties.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    items: Vec<Item>,
}

impl Pattern {
    /// Whether some item has an attribute that its weight follows from; without, weights say
    /// no more than counts.
    pub fn has_attributes(&self) -> bool {
        let has = |item: &Item| {
            let attributes = [item.area_cm2, item.p_detection, item.p_grasp, item.weight];
            attributes.iter().any(Option::is_some)
        };
        self.items.iter().any(has)
    }

    /// Checks and sorts the items.
    ///
    /// # Errors
    /// No item at all, a value that the model forbids, an item ahead of x = 0, an id
    /// twice.
    pub fn new(items: Vec<Item>) -> Result<Self> {
        Self::checked(items, "pattern", &|i| format!("item {}", i + 1))
    }

    /// As [`Pattern::new`]; `name` is the whole, `place` names item `i` as given.
    pub(super) fn checked(
        mut items: Vec<Item>,
        name: &str,
        place: &dyn Fn(usize) -> String,
    ) -> Result<Self> {
        if items.is_empty() {
            return Err(Error::input(
                name,
                "the pattern has no item",
                "give at least one item, or generate one with `pickline pattern generate`",
            ));
        }
        if items.len() > MOST_ITEMS {
            return Err(Error::input(
                name,
                format!("{} items", items.len()),
                format!("a pattern has at most {MOST_ITEMS}"),
            ));
        }
        let mut seen: HashMap<&str, usize> = HashMap::with_capacity(items.len());
        for (i, item) in items.iter().enumerate() {
            if let Some((field, problem, cure)) = item.problem() {
                return Err(Error::input(
                    format!("{}: {field} of item `{}`", place(i), shown(&item.id)),
                    problem,
                    cure,
                ));
            }
            if let Some(first) = seen.insert(&item.id, i) {
                return Err(Error::input(
                    format!("{}: id", place(i)),
                    format!("`{}` is also the id of {}", shown(&item.id), place(first)),
                    "give every item an id of its own",
                ));
            }
        }
        for item in &mut items {
            // -0.0 and 0.0 are one place; a single zero keeps sorting and output plain.
            item.x0 += 0.0;
        }
        items.sort_by(|a, b| b.x0.total_cmp(&a.x0));
        Ok(Self { items })
    }

    /// The items, furthest downstream first.
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// How many items; never 0.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// What to do about items beside a belt that ends at `edge` [m] on either side: where
    /// they would lie on it in another unit, that unit.
    fn cure_beside(&self, edge: f64) -> String {
        let furthest = self.items.iter().map(|item| item.y.abs());
        let furthest = furthest.fold(0.0, f64::max);
        // Ten belts wide is no belt of another station.
        let unit = [("centimetres", "cm", 0.01), ("millimetres", "mm", 0.001)]
            .into_iter()
            .find(|(_, _, metres)| furthest > 10.0 * edge && furthest * metres <= edge);
        match unit {
            Some((unit, short, _)) => format!(
                "if the positions are in {unit}, say so in the header: `x [{short}]` and \
                 `y [{short}]`; patterns are in metres"
            ),
            None => "use a station with a wider belt (belt.width), or a pattern made for this one"
                .to_owned(),
        }
    }

    /// Checks that every item lies on the station's belt.
    ///
    /// # Errors
    /// The first item beside the belt.
    pub fn check_on(&self, station: &Station) -> Result<()> {
        let edge = station.belt().width / 2.0;
        // A row on the very edge may be off by the rounding of its own product.
        match self.items.iter().find(|item| item.y.abs() > edge + 1e-9) {
            None => Ok(()),
            Some(item) => Err(Error::input(
                format!("y of item `{}`", shown(&item.id)),
                format!(
                    "{} m lies beside the belt, which covers |y| <= {} m",
                    shown_number(item.y),
                    shown_number(edge)
                ),
                self.cure_beside(edge),
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reward_follows_the_paper() {
        let mut item = Item::at("a", 0.0, 0.0);
        assert_eq!(item.reward(), 0.5);
        item.area_cm2 = Some(100.0);
        item.p_grasp = Some(0.5);
        assert!((item.reward() - 0.5 / (1.0 + (-1.0f64).exp())).abs() < 1e-15);
        item.weight = Some(2.0);
        assert_eq!(item.reward(), 2.0);
    }

    #[test]
    fn sorting_is_stable_and_downstream_first() {
        let items = vec![
            Item::at("a", -1.0, 0.1),
            Item::at("b", 0.0, 0.2),
            Item::at("c", -1.0, 0.0),
            Item::at("d", -0.0, 0.3),
        ];
        let pattern = Pattern::new(items).unwrap();
        let ids: Vec<_> = pattern.items().iter().map(|i| i.id.as_str()).collect();
        assert_eq!(ids, ["b", "d", "a", "c"]);
    }

    #[test]
    fn positions_in_another_unit_are_cured_by_the_unit() {
        let station = crate::station::built_in("paper")
            .unwrap()
            .station(None)
            .unwrap();
        let cure = |y: f64| {
            let pattern = Pattern::new(vec![Item::at("a", 0.0, y)]).unwrap();
            pattern.check_on(&station).unwrap_err().to_string()
        };
        let half = station.belt().width / 2.0;
        assert!(
            cure(900.0 * half).contains("`y [mm]`"),
            "{}",
            cure(900.0 * half)
        );
        assert!(cure(90.0 * half).contains("`y [cm]`"));
        assert!(cure(1.2 * half).contains("a wider belt"));
        assert!(cure(2000.0 * half).contains("a wider belt"));
    }

    #[test]
    fn bad_items_are_named() {
        for (item, word) in [
            (Item::at("", 0.0, 0.0), "id is empty"),
            (Item::at("a\nb", 0.0, 0.0), "line break"),
            (Item::at(" a", 0.0, 0.0), "blanks"),
            (Item::at("a", 0.1, 0.0), "past the belt's start"),
            (Item::at("a", f64::NAN, 0.0), "x of item"),
            (Item::at("a", 0.0, f64::INFINITY), "y of item"),
        ] {
            let message = Pattern::new(vec![item]).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
        let twice = vec![Item::at("a", 0.0, 0.0), Item::at("a", -1.0, 0.0)];
        for (items, word) in [(twice, "`a` is also the id of"), (vec![], "has no item")] {
            let message = Pattern::new(items).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }
}
