//! What the classes of items are worth.

/// A class of items, such as a material.
#[derive(Debug, Clone, PartialEq)]
pub struct ItemClass {
    /// Name, unique in the station; the `class` of items.
    pub name: String,
    /// Factor of the weight of its items, 0 or more; 1 by default.
    pub value: f64,
    /// Whether its items are to be picked. Unwanted items ride to the end of the belt and are
    /// counted apart.
    pub wanted: bool,
}

impl ItemClass {
    /// A wanted class of value 1.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            value: 1.0,
            wanted: true,
        }
    }
}
