//! What items truly are, where detections may be wrong.

use super::disturbances::Disturbances;
use crate::pattern::{Item, random_stream};
use rand::RngExt;

/// Derives the seed of detections from the master seed, so that they are independent of patterns,
/// grasps and positions.
const DETECTIONS: u64 = 0x6465_7465_6374_6564;

/// What an item truly is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrueClass<'i> {
    /// An item of this class, or one without a class.
    Of(Option<&'i str>),
    /// Nothing that is to be picked.
    Nothing,
}

impl Disturbances {
    /// The probability that `item` is what it is reported as, as far as it is known beforehand.
    pub fn p_detection(&self, item: &Item) -> f64 {
        match self.misdetections {
            true => item.p_detection.unwrap_or(1.0),
            false => 1.0,
        }
    }

    /// What `item`, with index `index` in its pattern, truly is. It is what was recorded, if
    /// anything was. Otherwise it is of the class that it is reported as with its `p_detection`, and
    /// nothing else. Without misdetections it is what it is reported as.
    ///
    /// The draw depends on seed and item alone, and no strategy learns of it.
    pub fn true_class<'i>(&self, index: u32, item: &'i Item) -> TrueClass<'i> {
        let reported = TrueClass::Of(item.class.as_deref());
        match item.true_class.as_deref() {
            _ if !self.misdetections => reported,
            Some(class) if item.class.as_deref() == Some(class) => reported,
            Some(Item::NOTHING) => TrueClass::Nothing,
            Some(class) => TrueClass::Of(Some(class)),
            None => {
                let p = self.p_detection(item);
                let mut rng = random_stream(self.seed ^ DETECTIONS, u64::from(index));
                match rng.random::<f64>() < p {
                    true => reported,
                    false => TrueClass::Nothing,
                }
            }
        }
    }

    /// Whether it is random what one of `items` truly is.
    pub fn draws_detections(&self, items: &[Item]) -> bool {
        let is_drawn = |item: &Item| {
            let p = self.p_detection(item);
            item.true_class.is_none() && p > 0.0 && p < 1.0
        };
        self.misdetections && items.iter().any(is_drawn)
    }

    /// Whether misdetections are enabled but all of `items` are certainly what they are reported as.
    pub fn never_misdetects(&self, items: &[Item]) -> bool {
        let is_certain = |item: &Item| match &item.true_class {
            Some(_) => item.true_class == item.class,
            None => self.p_detection(item) == 1.0,
        };
        self.misdetections && items.iter().all(is_certain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn item(class: Option<&str>, true_class: Option<&str>, p_detection: Option<f64>) -> Item {
        Item {
            class: class.map(str::to_owned),
            true_class: true_class.map(str::to_owned),
            p_detection,
            ..Item::at("a", 0.0, 0.0)
        }
    }

    fn wrong(seed: u64) -> Disturbances {
        Disturbances::default()
            .with_misdetections(true)
            .with_seed(seed)
    }

    #[test]
    fn what_was_recorded_wins_over_any_probability() {
        use TrueClass::{Nothing, Of};
        for (class, recorded, p, truth) in [
            (Some("pet"), Some("pet"), 0.0, Of(Some("pet"))),
            (Some("pet"), Some("wood"), 1.0, Of(Some("wood"))),
            (Some("pet"), Some("-"), 1.0, Nothing),
            (Some("-"), Some("-"), 0.0, Of(Some("-"))),
            (None, Some("pet"), 1.0, Of(Some("pet"))),
            (Some("pet"), None, 1.0, Of(Some("pet"))),
            (Some("pet"), None, 0.0, Nothing),
            (None, None, 1.0, Of(None)),
            (None, None, 0.0, Nothing),
        ] {
            let item = item(class, recorded, Some(p));
            for seed in 0..20 {
                assert_eq!(wrong(seed).true_class(3, &item), truth, "{item:?}");
            }
            let plain = Disturbances::default().true_class(3, &item);
            assert_eq!(plain, Of(class), "{item:?}");
        }
        // A detection without a probability is right.
        let sure = item(Some("pet"), None, None);
        assert_eq!(wrong(1).true_class(0, &sure), Of(Some("pet")));
    }

    #[test]
    fn detections_are_right_with_their_probability_whatever_else_is_random() {
        let doubtful = item(None, None, Some(0.7));
        let rights = |draw: &dyn Fn(u32) -> TrueClass<'static>| -> Vec<bool> {
            let is_right = |i: u32| draw(i) == TrueClass::Of(None);
            (0..4000).map(is_right).collect()
        };
        let of = |truth: TrueClass| match truth {
            TrueClass::Nothing => TrueClass::Nothing,
            TrueClass::Of(_) => TrueClass::Of(None),
        };
        let by_item = rights(&|i| of(wrong(5).true_class(i, &doubtful)));
        let by_seed = rights(&|i| of(wrong(u64::from(i)).true_class(5, &doubtful)));
        for drawn in [&by_item, &by_seed] {
            let share = drawn.iter().filter(|right| **right).count() as f64 / 4000.0;
            assert!((share - 0.7).abs() < 0.03, "{share}");
        }
        assert_ne!(by_item, by_seed);
        // Other than the grasps of the same items under the same seed.
        let slippery = Item {
            p_grasp: Some(0.7),
            ..doubtful.clone()
        };
        let grasps = wrong(5).with_grasp_failures(true);
        let held: Vec<bool> = (0..4000)
            .map(|i| grasps.grasp_succeeds(i, &slippery, 0))
            .collect();
        assert_ne!(by_item, held);
        // And the same whether or not grasps fail, too.
        let both = rights(&|i| of(grasps.true_class(i, &slippery)));
        assert_eq!(by_item, both);
    }

    #[test]
    fn it_is_known_where_nothing_can_be_wrong_and_where_nothing_is_random() {
        for (items, never, random) in [
            (vec![item(None, None, None)], true, false),
            (vec![item(None, None, Some(1.0))], true, false),
            (vec![item(None, None, Some(0.9))], false, true),
            (vec![item(None, None, Some(0.0))], false, false),
            (vec![item(Some("a"), Some("a"), Some(0.9))], true, false),
            (vec![item(Some("a"), Some("b"), Some(0.9))], false, false),
            (vec![item(None, Some("b"), None)], false, false),
            (vec![], true, false),
        ] {
            assert_eq!(wrong(1).never_misdetects(&items), never, "{items:?}");
            assert_eq!(wrong(1).draws_detections(&items), random, "{items:?}");
            let plain = Disturbances::default();
            assert!(!plain.never_misdetects(&items) && !plain.draws_detections(&items));
        }
    }
}
