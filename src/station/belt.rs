//! The conveyor.

/// The conveyor. It covers `0 <= x <= length`, `|y| <= width / 2` and moves along +x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Belt {
    /// Speed along +x [m/s].
    pub speed: f64,
    /// Length along x [m].
    pub length: f64,
    /// Width along y [m].
    pub width: f64,
}
