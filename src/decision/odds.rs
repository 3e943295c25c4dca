//! What the line knows of an attempt's chances.

/// The probabilities that decide what an attempt at an item is worth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Odds {
    /// Probability that a grasp of the item succeeds.
    pub grasp: f64,
    /// Probability that the item is what it was reported as.
    pub detection: f64,
}

impl Odds {
    /// Nothing can go wrong.
    pub const SURE: Self = Self {
        grasp: 1.0,
        detection: 1.0,
    };
}

impl Default for Odds {
    fn default() -> Self {
        Self::SURE
    }
}
