//! What the generated patterns of a set have in common.

use super::attributes::Attributes;
use super::feed::FeedShape;
use super::item::MOST_ITEMS;
use crate::setters::setters;
use crate::station::Belt;

/// The parameters that all generated patterns of a set share.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Recipe {
    /// The belt: its width, and the speed to which the flow of a feed refers.
    pub belt: Belt,
    /// Items per pattern; for a profile, at most this many.
    pub items: usize,
    /// Parameters of the feeds other than the flow.
    pub shape: FeedShape,
    /// What the items have besides their position.
    pub attributes: Attributes,
    /// Master seed: each pattern of the set has its own stream of it.
    pub seed: u64,
}

impl Recipe {
    /// Patterns of `items` items for `belt`, with the default shape of feeds and no attributes,
    /// drawn from `seed`.
    pub fn new(belt: Belt, items: usize, seed: u64) -> Self {
        Self {
            belt,
            items,
            shape: FeedShape::default(),
            attributes: Attributes::default(),
            seed,
        }
    }

    /// The part of the description that does not depend on the source, for provenance.
    pub(super) fn describe(&self) -> String {
        let items = match self.items {
            MOST_ITEMS => "every item of the profile".to_owned(),
            items => format!("{items} items a pattern"),
        };
        format!(
            "{items}, {}, seed {}",
            self.attributes.describe(),
            self.seed
        )
    }
}

setters!(Recipe {
    /// With this number of items in each pattern.
    fn with_items(items: usize);
    /// With these parameters of the feeds.
    fn with_shape(shape: FeedShape);
    /// With these attributes of the items.
    fn with_attributes(attributes: Attributes);
    /// With this master seed.
    fn with_seed(seed: u64);
});
