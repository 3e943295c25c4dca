//! The paper's figures: Jermann et al., Tables 2 and 3.

/// One method on one case, as printed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Printed {
    /// Items picked [%], Table 2.
    pub picked: f64,
    /// Time taken [s], Table 2.
    pub time: f64,
    /// Picks per minute, Table 3.
    pub rate: f64,
}

/// One of the paper's four cases.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperCase {
    /// Robust game theory (GT): one assignment of rules for all patterns.
    pub robust: Printed,
    /// The policy of reinforcement learning (RL).
    pub rl: Printed,
    /// Greedy game theory (GT): the best assignment of rules for each pattern.
    pub greedy: Printed,
    /// Benefit of RL over robust GT [%], Table 3.
    pub benefit: f64,
}

const fn printed(picked: f64, time: f64, rate: f64) -> Printed {
    Printed { picked, time, rate }
}

/// The paper's four cases in the order of [`super::PAPER`].
pub const CASES: [PaperCase; 4] = [
    PaperCase {
        robust: printed(92.0, 96.3, 28.0),
        rl: printed(96.0, 92.8, 31.1),
        greedy: printed(92.0, 95.6, 28.8),
        benefit: 11.1,
    },
    PaperCase {
        robust: printed(100.0, 113.5, 26.4),
        // Table 3 has 27.8 for RL and 29.4 for greedy here, but Table 2's times give 29.3 and
        // 27.9: the paper has swapped the two. Kept as printed.
        rl: printed(100.0, 102.3, 27.8),
        greedy: printed(100.0, 107.6, 29.4),
        benefit: 5.3,
    },
    PaperCase {
        // The paper's rate counts all items although 96 % were picked.
        robust: printed(96.0, 81.5, 21.3),
        rl: printed(100.0, 70.3, 24.8),
        greedy: printed(100.0, 74.4, 23.3),
        benefit: 16.4,
    },
    PaperCase {
        robust: printed(100.0, 114.8, 18.7),
        rl: printed(100.0, 110.5, 19.1),
        greedy: printed(100.0, 114.8, 18.7),
        benefit: 2.1,
    },
];

/// Highest belt speed at which the grid of 0.15 m is picked completely [m/s]
/// (discussion of the belt speed): robust GT and RL.
pub const SPEED_LIMITS: (f64, f64) = (0.042, 0.047);

/// Remarks for readers of the paper's figures.
pub const REMARKS: [&str; 2] = [
    "the paper's Table 3 has RL and greedy GT swapped for the grid of 0.3 m: 50 picks in 102.3 s are 29.3/min",
    "its robust rate for Poisson 0.2 counts all items though 96 % were picked",
];
