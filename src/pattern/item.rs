//! Items and the validated, sorted pattern.

use crate::error::{Error, Result, shown, shown_number};
use crate::names::{check_class_name, check_name};
use crate::station::{ClassId, Station};
use std::collections::HashMap;

/// Positions beyond this [m] are rejected: no belt is that long.
pub(super) const LARGEST: f64 = 1e6;
/// Maximum number of items in a pattern, to limit memory use.
pub(crate) const MOST_ITEMS: usize = 10_000_000;

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
    /// Explicit weight; overrides the one computed from the fields above.
    pub weight: Option<f64>,
    /// The class that the item is reported as.
    pub class: Option<String>,
    /// The class that the item was recorded to be of, or [`Item::NOTHING`]; `None` if that is not
    /// known. Only counts where detections may be wrong.
    pub true_class: Option<String>,
}

/// The cure for a class that is not a name.
const CLASS_CURE: &str = "give classes on one line, with at most 200 printable characters and no \
     leading or trailing spaces";

/// The logistic function.
fn sigmoid(z: f64) -> f64 {
    1.0 / (1.0 + (-z).exp())
}

impl Item {
    /// The true class of a detection where there was no item of any class.
    pub const NOTHING: &'static str = "-";

    /// An item of which only the position [m] is known.
    pub fn at(id: impl Into<String>, x0: f64, y: f64) -> Self {
        Self {
            id: id.into(),
            x0,
            y,
            ..Self::default()
        }
    }

    /// The object-specific reward `r = p_detection p_grasp sigmoid(A / 100 cm^2)` (Jermann et al.,
    /// equation 2), or the explicit weight. A missing probability counts as 1 and a missing area as
    /// 0, so the reward is 0.5 if nothing is known.
    pub fn reward(&self) -> f64 {
        self.weight.unwrap_or_else(|| {
            self.p_detection.unwrap_or(1.0)
                * self.p_grasp.unwrap_or(1.0)
                * sigmoid(self.area_cm2.unwrap_or(0.0) / 100.0)
        })
    }

    /// Its class on `station`.
    pub fn class_on(&self, station: &Station) -> ClassId {
        station.class_id(self.class.as_deref())
    }

    /// The weight on `station`: the explicit weight, or the reward times the value of the class.
    #[inline]
    pub fn weight_on(&self, station: &Station) -> f64 {
        match self.weight {
            Some(weight) => weight,
            None => station.value_of(self.class_on(station)) * self.reward(),
        }
    }

    /// What the model forbids about this item alone: the field, the problem with its value, and the
    /// cure.
    fn problem(&self) -> Option<(&'static str, String, &'static str)> {
        let position = |value: f64| value.is_finite() && value.abs() <= LARGEST;
        let share = |value: &Option<f64>| value.is_none_or(is_share);
        let amount = |value: &Option<f64>| value.is_none_or(is_amount);
        let (class, true_class) = (self.class.as_deref(), self.true_class.as_deref());
        let class = class.filter(|class| !class.is_empty());
        let bad_class = class.and_then(|class| check_class_name(class).err());
        let true_class = true_class.filter(|class| !class.is_empty());
        let bad_true_class = true_class.and_then(|class| check_name(class).err());
        if self.id.is_empty() {
            Some(("id", "the id is empty".into(), "give every item an id"))
        } else if let Err(bad) = check_name(&self.id) {
            let cure = "give ids on one line, with at most 200 printable characters and \
                        no leading or trailing spaces";
            Some(("id", bad.problem, cure))
        } else if let Some(bad) = bad_class {
            Some(("class", bad.problem, CLASS_CURE))
        } else if let Some(bad) = bad_true_class {
            Some(("true_class", bad.problem, CLASS_CURE))
        } else if !position(self.x0) {
            let cure = "give metres in the belt frame";
            Some((
                "x",
                format!("{} is not a valid position", shown_number(self.x0)),
                cure,
            ))
        } else if self.x0 > 0.0 {
            Some((
                "x",
                format!(
                    "the item is at x = {} m at time 0, beyond the start of the belt",
                    shown_number(self.x0)
                ),
                "shift the pattern so that every x is 0 or less",
            ))
        } else if !position(self.y) {
            let cure = "give metres from the belt's centre line";
            Some((
                "y",
                format!("{} is not a valid position", shown_number(self.y)),
                cure,
            ))
        } else if !amount(&self.area_cm2) {
            let value = shown_number(self.area_cm2.unwrap_or_default());
            let cure = "give cm^2, 0 or more, or no value";
            Some(("area_cm2", format!("{value} is not a valid area"), cure))
        } else if !share(&self.p_detection) {
            let value = shown_number(self.p_detection.unwrap_or_default());
            let cure = "give a number from 0 to 1, or no value";
            Some(("p_detection", format!("{value} is not a probability"), cure))
        } else if !share(&self.p_grasp) {
            let value = shown_number(self.p_grasp.unwrap_or_default());
            let cure = "give a number from 0 to 1, or no value";
            Some(("p_grasp", format!("{value} is not a probability"), cure))
        } else if !amount(&self.weight) {
            let value = shown_number(self.weight.unwrap_or_default());
            let cure = "give a number, 0 or more, or no value";
            Some(("weight", format!("{value} is not a valid weight"), cure))
        } else {
            None
        }
    }
}

/// The items of one run in stable order of `x0`, furthest downstream first. The index of an item is
/// its place in this order; ids never break ties.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    items: Vec<Item>,
}

impl Pattern {
    /// Whether some item has an attribute from which a weight is computed. If not, weights add
    /// nothing to counts.
    pub fn has_attributes(&self) -> bool {
        let has = |item: &Item| {
            let attributes = [item.area_cm2, item.p_detection, item.p_grasp, item.weight];
            attributes.iter().any(Option::is_some)
        };
        self.items.iter().any(has)
    }

    /// Whether weights on `station` say more than counts: items have attributes, or classes of
    /// different value.
    pub fn weighs_on(&self, station: &Station) -> bool {
        let is_valued = |item: &Item| station.value_of(item.class_on(station)) != 1.0;
        self.has_attributes() || self.items.iter().any(is_valued)
    }

    /// Creates a pattern after checking and sorting the items.
    ///
    /// # Errors
    /// If there are no items, the model forbids a value, an item is ahead of x = 0, or an id is not
    /// unique.
    pub fn new(items: Vec<Item>) -> Result<Self> {
        Self::checked(items, "pattern", &|i| format!("item {}", i + 1))
    }

    /// Items at the given (along, across) positions [m], numbered in order.
    pub(super) fn numbered(places: Vec<(f64, f64)>) -> Result<Self> {
        let item = |(i, (x, y)): (usize, (f64, f64))| Item::at((i + 1).to_string(), x, y);
        Self::new(places.into_iter().enumerate().map(item).collect())
    }

    /// Like [`Pattern::new`]; messages call the pattern `name` and item `i` of the input
    /// `place(i)`.
    pub(super) fn checked(
        mut items: Vec<Item>,
        name: &str,
        place: &dyn Fn(usize) -> String,
    ) -> Result<Self> {
        if items.is_empty() {
            return Err(Error::input(
                name,
                "the pattern has no items",
                "give at least one item, or generate a pattern with `pickline pattern generate`",
            ));
        }
        if items.len() > MOST_ITEMS {
            return Err(Error::input(
                name,
                format!("{} items", items.len()),
                format!("a pattern has at most {MOST_ITEMS} items"),
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
                    format!(
                        "`{}` is already the id of {}",
                        shown(&item.id),
                        place(first)
                    ),
                    "give every item a unique id",
                ));
            }
        }
        for item in &mut items {
            // -0.0 and 0.0 are the same position; using a single zero simplifies sorting and
            // output.
            item.x0 += 0.0;
        }
        items.sort_by(|a, b| b.x0.total_cmp(&a.x0));
        Ok(Self { items })
    }

    /// The items in order, furthest downstream first.
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// Number of items, never 0.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// The cure for items beside a belt whose edges are at +/- `edge` [m]. If they would lie on the
    /// belt in another unit, it suggests that unit.
    fn cure_beside(&self, edge: f64) -> String {
        let furthest = self.items.iter().map(|item| item.y.abs());
        let furthest = furthest.fold(0.0, f64::max);
        // A position of ten belt widths is not explained by a pattern for a wider belt.
        let unit = [("centimetres", "cm", 0.01), ("millimetres", "mm", 0.001)]
            .into_iter()
            .find(|(_, _, metres)| furthest > 10.0 * edge && furthest * metres <= edge);
        match unit {
            Some((unit, short, _)) => format!(
                "if the positions are in {unit}, state this in the header: `x [{short}]` and \
                 `y [{short}]`; the default is metres"
            ),
            None => "use a station with a wider belt (belt.width), or a pattern made for this one"
                .to_owned(),
        }
    }

    /// Checks that every item is on the station's belt.
    ///
    /// # Errors
    /// The first item that is beside the belt.
    pub fn check_on(&self, station: &Station) -> Result<()> {
        let edge = station.belt().width / 2.0;
        // Rounding may put a row at the very edge slightly outside.
        match self.items.iter().find(|item| item.y.abs() > edge + 1e-9) {
            None => Ok(()),
            Some(item) => Err(Error::input(
                format!("y of item `{}`", shown(&item.id)),
                format!(
                    "{} m is beside the belt, which covers |y| <= {} m",
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
            (Item::at(" a", 0.0, 0.0), "ends with a space"),
            (Item::at("a", 0.1, 0.0), "beyond the start of the belt"),
            (Item::at("a", f64::NAN, 0.0), "x of item"),
            (Item::at("a", 0.0, f64::INFINITY), "y of item"),
        ] {
            let message = Pattern::new(vec![item]).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
        let twice = vec![Item::at("a", 0.0, 0.0), Item::at("a", -1.0, 0.0)];
        for (items, word) in [(twice, "`a` is already the id of"), (vec![], "has no item")] {
            let message = Pattern::new(items).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }
}
