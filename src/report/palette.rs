//! The colours that pictures share.

/// Robots' colours in turn: Okabe and Ito's palette, told apart by colour-blind eyes.
pub(super) const ROBOT_COLOURS: [&str; 6] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9",
];
