//! The outcome of a run.

use nalgebra::Point2;
use strum::VariantArray as _;

/// A successful pick.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Pick {
    /// Index of the robot, upstream first.
    pub robot: usize,
    /// Index of the item in its pattern.
    pub item: u32,
    /// Index of the robot's bin that the item goes into.
    pub bin: u16,
    /// When the robot left for the item, which is also when it claimed it [s].
    pub decide: f64,
    /// When the item leaves the belt, the start of the grasp [s].
    pub grasp: f64,
    /// When the item is in the bin and the robot is free [s].
    pub release: f64,
    /// Where the item was met [m].
    pub meet: Point2<f64>,
}

/// Why an attempt failed.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    strum::IntoStaticStr,
    serde::Serialize,
    serde::Deserialize,
)]
#[strum(serialize_all = "snake_case")]
pub enum FailureCause {
    /// The gripper did not hold the item.
    Grasp,
    /// The item was not at its reported position, and the robot could not meet it at its true
    /// position.
    OutOfReach,
}

impl FailureCause {
    /// The name in files, in snake case.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// The cause with this name, if there is one.
    pub fn named(name: &str) -> Option<Self> {
        let mut causes = [Self::Grasp, Self::OutOfReach].into_iter();
        causes.find(|cause| cause.name() == name)
    }
}

/// A failed attempt, after which the item stayed on the belt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Failure {
    /// The intended pick. The attempt occupies the robot just as long, until `release`, and claims
    /// the item until the end of the grasp.
    pub attempt: Pick,
    /// Why the attempt failed.
    pub cause: FailureCause,
}

impl Failure {
    /// End of the failed grasp, and thus of the claim on the item [s], for a robot with this grasp
    /// time [s].
    pub fn claim_ends(&self, grasp_time: f64) -> f64 {
        self.attempt.grasp + grasp_time
    }
}

/// Why an item was not picked.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, strum::IntoStaticStr, strum::VariantArray,
)]
#[strum(serialize_all = "snake_case")]
pub enum MissReason {
    /// No robot has a departure window for it.
    Unreachable,
    /// It was attempted, and no attempt succeeded.
    GraspFailed,
    /// At some decision a robot could have picked it, but chose another action.
    PassedOver,
    /// No robot has a window for its reported position after the camera has seen it.
    Unseen,
    /// The robots were busy or down during all of its windows, and one of them was down during one.
    RobotDown,
    /// The robots were busy during all of its windows.
    Busy,
}

impl MissReason {
    /// All reasons; the first that applies is reported.
    pub const ALL: &'static [Self] = Self::VARIANTS;

    /// The name in files, in snake case.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// An item that was not picked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Miss {
    /// Index of the item in its pattern.
    pub item: u32,
    /// Why no robot picked the item.
    pub reason: MissReason,
}

/// Why an item was not to be picked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, strum::IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum LeftReason {
    /// Its class is not wanted.
    Unwanted,
    /// No robot has a bin for its class.
    NoBin,
    /// Its `p_detection` is below the threshold for picking.
    LowDetection,
}

impl LeftReason {
    /// The name used in files.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// An item that was left on the belt on purpose. It counts neither as picked nor as missed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LeftItem {
    /// Index of the item in its pattern.
    pub item: u32,
    /// Why it was left.
    pub reason: LeftReason,
}

/// A time in which a robot was down: it made no decision from `from` on, and before `to`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Downtime {
    /// Index of the robot.
    pub robot: usize,
    /// When it began [s].
    pub from: f64,
    /// When the robot was ready again, at the latest the end of the run [s].
    pub to: f64,
}

/// The figures of one robot.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RobotFigures {
    /// Number of items that the robot picked.
    pub picked: usize,
    /// Sum of the rewards of the picked items.
    pub weight: f64,
    /// Number of attempts that took time but picked nothing.
    pub failed: usize,
    /// Sum of the processing times, including failed attempts [s].
    pub busy: f64,
}

/// The figures by which a run is judged.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Figures {
    /// Number of items that are to be picked, n; items that are left on purpose do not count.
    pub items: usize,
    /// Number of items picked, k.
    pub picked: usize,
    /// Sum of the rewards of the picked items.
    pub weight: f64,
    /// End of the run, T [s].
    pub end: f64,
}

impl Figures {
    /// The picked share k / n; 1 if no item is to be picked, because none is missed.
    pub fn picked_share(&self) -> f64 {
        self.share_of(self.picked as f64)
    }

    /// The share `picked` / n; 1 if no item is to be picked.
    pub(crate) fn share_of(&self, picked: f64) -> f64 {
        match self.items {
            0 => 1.0,
            items => picked / items as f64,
        }
    }

    /// The picking rate 60 k / T [1/min]; 0 if the run ends at time 0.
    pub fn picking_rate(&self) -> f64 {
        self.rate_of(self.picked)
    }

    /// The rate 60 k_i / T [1/min] for a part k_i of the picks, such as those of one robot.
    pub(crate) fn rate_of(&self, picked: usize) -> f64 {
        self.per_minute(picked as f64)
    }

    /// The weighted rate 60 sum(r) / T [1/min].
    pub fn weighted_rate(&self) -> f64 {
        self.per_minute(self.weight)
    }

    /// Whether every item was picked.
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

/// The picked share of every run; none if nothing is to be picked in any, because then their mean says
/// nothing.
pub(crate) fn picked_shares(runs: &[Figures]) -> Vec<f64> {
    match runs.iter().all(|run| run.items == 0) {
        true => Vec::new(),
        false => runs.iter().map(Figures::picked_share).collect(),
    }
}

/// The complete outcome of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The figures by which the run is judged.
    pub figures: Figures,
    /// The figures of each robot, upstream first.
    pub robots: Vec<RobotFigures>,
    /// All picks in order of decision, ties in robot order.
    pub picks: Vec<Pick>,
    /// All failed attempts, in the same order; empty without disturbances.
    pub failures: Vec<Failure>,
    /// All items that were to be picked and were not, downstream first.
    pub missed: Vec<Miss>,
    /// All items that were left on purpose, downstream first; none on a station where every item is
    /// wanted.
    pub left: Vec<LeftItem>,
    /// All times in which robots were down during the run, in order of beginning, then of robots; none
    /// without outages.
    pub downtimes: Vec<Downtime>,
}

impl Outcome {
    /// How long robot `robot` was down during the run [s].
    pub fn time_down(&self, robot: usize) -> f64 {
        let own = self.downtimes.iter().filter(|down| down.robot == robot);
        own.map(|down| down.to - down.from).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All numbers differ, so that none can be confused with another.
    const FIGURES: Figures = Figures {
        items: 200,
        picked: 150,
        weight: 90.0,
        end: 120.0,
    };

    #[test]
    fn figures_are_per_item_and_per_minute() {
        assert_eq!(FIGURES.picked_share(), 0.75);
        let nothing = Figures {
            items: 0,
            picked: 0,
            ..FIGURES
        };
        assert_eq!((nothing.picked_share(), nothing.complete()), (1.0, true));
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
                bin: 0,
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
            "robot_down",
            "busy",
        ];
        let all: Vec<_> = MissReason::ALL.iter().map(|r| r.name()).collect();
        assert_eq!(all, names);
    }
}
