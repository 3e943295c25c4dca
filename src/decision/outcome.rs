//! What came of a run.

use nalgebra::Point2;

/// One pick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pick {
    /// Index of the robot, upstream first.
    pub robot: usize,
    /// Index of the item in its pattern.
    pub item: u32,
    /// When the robot left for it, the moment of the claim [s].
    pub decide: f64,
    /// When the item leaves the belt, the start of the grasp [s].
    pub grasp: f64,
    /// When it is in the bin and the robot free [s].
    pub release: f64,
    /// Where the item was met [m].
    pub meet: Point2<f64>,
}

/// Why an attempt came to nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum FailureCause {
    /// The gripper did not get hold of the item.
    Grasp,
    /// The item was not where it was reported to be, and where it was the robot could
    /// not meet it.
    OutOfReach,
}

impl FailureCause {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Grasp => "grasp",
            Self::OutOfReach => "out_of_reach",
        }
    }
}

/// An attempt at an item that stayed on the belt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Failure {
    /// What would have been the pick: it takes the robot as long, until `release`, and
    /// claims the item until the grasp is over.
    pub attempt: Pick,
    /// Why it failed.
    pub cause: FailureCause,
}

impl Failure {
    /// When the failed grasp of a robot with this grasp time [s] is over, and with it the
    /// claim on the item [s].
    pub fn claim_ends(&self, grasp_time: f64) -> f64 {
        self.attempt.grasp + grasp_time
    }
}

/// Why an item was not picked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum MissReason {
    /// No robot has a departure window for it.
    Unreachable,
    /// It was attempted, and no attempt succeeded.
    GraspFailed,
    /// Some robot could have picked it at some decision and chose another action.
    PassedOver,
    /// No robot has a window for it where and from when on the camera reports it.
    Unseen,
    /// Whenever it was in a window, the robot was busy.
    Busy,
}

impl MissReason {
    /// All reasons, the first that fits first.
    pub const ALL: [Self; 5] = [
        Self::Unreachable,
        Self::GraspFailed,
        Self::PassedOver,
        Self::Unseen,
        Self::Busy,
    ];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unreachable => "unreachable",
            Self::GraspFailed => "grasp_failed",
            Self::PassedOver => "passed_over",
            Self::Unseen => "unseen",
            Self::Busy => "busy",
        }
    }
}

/// An item that was not picked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Miss {
    /// Index of the item in its pattern.
    pub item: u32,
    /// Why.
    pub reason: MissReason,
}

/// What one robot did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RobotFigures {
    /// Number of picks.
    pub picked: usize,
    /// Sum of the rewards of its items.
    pub weight: f64,
    /// Number of attempts that failed.
    pub failed: usize,
    /// Sum of its processing times, those of failed attempts included [s].
    pub busy: f64,
}

/// The figures of a run that everything is judged by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// Items of the pattern, n.
    pub items: usize,
    /// Items picked, k.
    pub picked: usize,
    /// Sum of the rewards of the picked items.
    pub weight: f64,
    /// End of the run, T [s].
    pub end: f64,
}

impl Figures {
    /// k / n.
    pub fn picked_share(&self) -> f64 {
        self.picked as f64 / self.items as f64
    }

    /// 60 k / T [1/min]; 0 for a run that ends at once.
    pub fn picking_rate(&self) -> f64 {
        self.rate_of(self.picked)
    }

    /// 60 k_i / T [1/min] of a part k_i of the picks: one robot's.
    pub fn rate_of(&self, picked: usize) -> f64 {
        self.per_minute(picked as f64)
    }

    /// 60 sum(r) / T [1/min].
    pub fn weighted_rate(&self) -> f64 {
        self.per_minute(self.weight)
    }

    /// Whether everything was picked.
    pub fn complete(&self) -> bool {
        self.picked == self.items
    }

    fn per_minute(&self, amount: f64) -> f64 {
        if self.end > 0.0 {
            60.0 * amount / self.end
        } else {
            0.0
        }
    }
}

/// A whole run.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// What it is judged by.
    pub figures: Figures,
    /// What each robot did, upstream first.
    pub robots: Vec<RobotFigures>,
    /// All picks in order of decision, ties in robot order.
    pub picks: Vec<Pick>,
    /// All attempts that failed, in the same order; none without disturbances.
    pub failures: Vec<Failure>,
    /// All items that were not picked, downstream first.
    pub missed: Vec<Miss>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of unlike numbers, so that none can stand in for another.
    const FIGURES: Figures = Figures {
        items: 200,
        picked: 150,
        weight: 90.0,
        end: 120.0,
    };

    #[test]
    fn figures_are_per_item_and_per_minute() {
        assert_eq!(FIGURES.picked_share(), 0.75);
        assert_eq!(FIGURES.picking_rate(), 75.0);
        assert_eq!(FIGURES.weighted_rate(), 45.0);
        assert_eq!(FIGURES.rate_of(30), 15.0);
        let at_once = Figures {
            end: 0.0,
            ..FIGURES
        };
        assert_eq!(at_once.picking_rate(), 0.0);
        assert_eq!(at_once.weighted_rate(), 0.0);
        assert_eq!(at_once.rate_of(30), 0.0);
    }

    #[test]
    fn complete_is_every_item() {
        for (picked, complete) in [(0, false), (198, false), (199, false), (200, true)] {
            let figures = Figures { picked, ..FIGURES };
            assert_eq!(figures.complete(), complete, "{picked} of 200");
        }
    }

    #[test]
    fn a_failed_attempt_claims_its_item_until_the_grasp_is_over() {
        let failure = Failure {
            attempt: Pick {
                robot: 1,
                item: 2,
                decide: 3.0,
                grasp: 4.0,
                release: 6.5,
                meet: Point2::new(7.0, 8.0),
            },
            cause: FailureCause::Grasp,
        };
        assert_eq!(failure.claim_ends(0.5), 4.5);
    }

    #[test]
    fn causes_and_reasons_have_their_names() {
        assert_eq!(FailureCause::Grasp.name(), "grasp");
        assert_eq!(FailureCause::OutOfReach.name(), "out_of_reach");
        let names = [
            "unreachable",
            "grasp_failed",
            "passed_over",
            "unseen",
            "busy",
        ];
        assert_eq!(MissReason::ALL.map(MissReason::name), names);
    }
}
