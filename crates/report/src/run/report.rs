//! The figures of a run, as printed and written.

use crate::bound::CertifiedReport;
use crate::clearance::ClearanceReport;
use crate::downtime::DowntimeReport;
use crate::provenance::Provenance;
use crate::purity::RunPurityReport;
use crate::throughput::ThroughputReport;
use pickline::decision::{MissReason, Outcome, Pick, RobotFigures};
use pickline::experiment::ClassBound;
use pickline::planning::bound::certified_percent;
use pickline::purity::bin_contents;
use pickline::sim::{ClassRun, Scene, class_runs};
use pickline::station::{Robot, Station};
use pickline::throughput::{Throughput, steady_state};
use serde::Serialize;
use std::collections::BTreeMap;

/// A run as printed and written; the JSON field names are the product's format.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct RunReport {
    /// The strategy as written on the command line.
    pub strategy: String,
    /// Picks per minute in the steady state.
    #[serde(flatten)]
    pub throughput: ThroughputReport,
    /// Number of items that are to be picked.
    pub items: usize,
    /// Number of items picked.
    pub picked: usize,
    /// Share of the items picked; not a number, `null` in JSON, if none is to be picked.
    pub picked_share: f64,
    /// End of the run [s].
    pub end_s: f64,
    /// Picks per minute over the whole run.
    pub picking_rate_per_min: f64,
    /// Reward-weighted picks per minute.
    pub weighted_rate_per_min: f64,
    /// Each robot, upstream first.
    pub robots: Vec<RobotRunReport>,
    /// Picks in order of decision.
    pub picks: Vec<PickReport>,
    /// Failed attempts, in order of decision.
    pub failures: Vec<FailureReport>,
    /// Items that were not picked, downstream first.
    pub missed: Vec<MissReport>,
    /// Items that were left on the belt on purpose, downstream first, with the reason; omitted if
    /// there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unwanted: Vec<MissReport>,
    /// The items of each class; omitted on a station where neither bins nor values depend on it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub classes: Vec<ClassRunReport>,
    /// The times in which robots were down, in order; omitted if no robot can be down.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub downtimes: Option<Vec<DowntimeReport>>,
    /// Purity and recovery of the bins; omitted unless detections may be wrong.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sorting: Option<RunPurityReport>,
    /// Number of items missed for each reason.
    pub missed_by_reason: BTreeMap<&'static str, usize>,
    /// Whether the independent checker confirmed the run; omitted if not requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub checked: Option<bool>,
    /// How far the run is at most from the best of any strategy; omitted if not requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound: Option<CertifiedReport>,
    /// The smallest distance between two arms; omitted if not requested and for a single robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearance: Option<ClearanceReport>,
    /// Where the result comes from.
    pub made: Provenance,
    /// Whether items have attributes or classes of different value, so that weight differs from the
    /// count.
    #[serde(rename = "items_have_attributes")]
    pub weighs: bool,
}

/// What one robot did in the run.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct RobotRunReport {
    /// Name of the robot.
    pub name: String,
    /// Number of items that it picked.
    pub picked: usize,
    /// Sum of the rewards of the items it picked.
    pub weight: f64,
    /// Number of attempts that took time but picked nothing.
    pub failed: usize,
    /// Sum of its processing times, including those of failed attempts [s].
    pub busy_s: f64,
    /// Busy time over the end of the run.
    pub utilisation: f64,
    /// Share of the time it is busy while the items of the steady state pass it; `None` without
    /// a steady state.
    pub utilisation_steady: Option<f64>,
    /// How long it was down during the run [s]; omitted if no robot can be down.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub down_s: Option<f64>,
    /// What went into each of its bins; omitted for a robot with one bin for everything.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bins: Vec<BinRunReport>,
}

/// What went into one bin.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct BinRunReport {
    /// Name of the bin.
    pub name: String,
    /// Number of items that were put into it.
    pub picked: usize,
}

/// The items of one class.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct ClassRunReport {
    /// Name of the class; `None` for the items without one.
    pub name: Option<String>,
    /// Number of items of this class in the pattern.
    pub items: usize,
    /// How many of them were picked.
    pub picked: usize,
    /// The share of them that was picked; `None` if they are not to be picked.
    pub recovery: Option<f64>,
    /// Upper bound on the picks of every strategy, whatever else it picks; omitted if not
    /// requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picks_upper_bound: Option<usize>,
    /// The picks as a proven share of the optimum for this class alone [%], rounded down.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certified_percent: Option<f64>,
}

/// One pick, with its times [s].
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct PickReport {
    /// Index of the robot, upstream first.
    pub robot: usize,
    /// Id of the item.
    pub item: String,
    /// Name of the bin that it goes into; omitted for a robot with one bin for everything.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bin: Option<String>,
    /// When the robot left for it [s].
    pub decide_s: f64,
    /// Start of the grasp [s].
    pub grasp_s: f64,
    /// When the robot was free again [s].
    pub release_s: f64,
    /// Where the robot meets the item: x and y [m].
    pub meet: [f64; 2],
}

/// One attempt that picked nothing.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct FailureReport {
    /// The attempt; `release_s` is when the robot was free again.
    #[serde(flatten)]
    pub attempt: PickReport,
    /// Why the attempt failed, in snake case.
    pub cause: &'static str,
}

/// One item that was not picked.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct MissReport {
    /// Id of the item.
    pub item: String,
    /// Why no robot picked the item, in snake case.
    pub reason: &'static str,
}

impl RobotRunReport {
    /// The report of what `robot` `did` in a run that ended at `end` [s].
    fn new(robot: &Robot, did: &RobotFigures, end: f64, utilisation_steady: Option<f64>) -> Self {
        Self {
            name: robot.name.clone(),
            down_s: None,
            bins: Vec::new(),
            picked: did.picked,
            weight: did.weight,
            failed: did.failed,
            busy_s: did.busy,
            utilisation: if end > 0.0 { did.busy / end } else { 0.0 },
            utilisation_steady,
        }
    }
}

/// The number of missed items for each reason that is possible on `scene`.
fn missed_by_reason(scene: &Scene, outcome: &Outcome) -> BTreeMap<&'static str, usize> {
    let outages = scene.conditions().has_outages();
    let possible = |reason: &&MissReason| outages || **reason != MissReason::RobotDown;
    let all = MissReason::ALL.iter().filter(possible);
    let mut counts: BTreeMap<_, _> = all.map(|reason| (reason.name(), 0)).collect();
    for miss in &outcome.missed {
        *counts.entry(miss.reason.name()).or_default() += 1;
    }
    counts
}

/// The name of the bin of a pick, unless every robot has one bin for everything.
fn bin_name(station: &Station, pick: &Pick) -> Option<String> {
    let bin = &station.robots()[pick.robot].bins[usize::from(pick.bin)];
    has_bins(station).then(|| bin.name.clone())
}

/// Whether it matters into which bin something goes.
fn has_bins(station: &Station) -> bool {
    !station.robots().iter().all(Robot::has_only_bin)
}

/// What went into each bin of robot number `index`, unless every robot has one bin for everything.
fn bins_of(index: usize, station: &Station, outcome: &Outcome) -> Vec<BinRunReport> {
    if !has_bins(station) {
        return Vec::new();
    }
    let robot = &station.robots()[index];
    let own = || outcome.picks.iter().filter(|pick| pick.robot == index);
    let bins = robot.bins.iter().enumerate();
    bins.map(|(number, bin)| BinRunReport {
        name: bin.name.clone(),
        picked: own().filter(|pick| usize::from(pick.bin) == number).count(),
    })
    .collect()
}

/// The items of each class, by name, on a station that treats classes differently.
fn classes_of(scene: &Scene, outcome: &Outcome) -> Vec<ClassRunReport> {
    let report = |run: ClassRun| ClassRunReport {
        recovery: run.recovery(),
        name: run.class,
        items: run.items,
        picked: run.picked,
        picks_upper_bound: None,
        certified_percent: None,
    };
    class_runs(scene, outcome).into_iter().map(report).collect()
}

/// What truly went into the bins, if detections may be wrong.
fn purity_of(scene: &Scene, outcome: &Outcome) -> Option<RunPurityReport> {
    let chance = &scene.conditions().disturbances;
    let wrong = chance.misdetections;
    wrong.then(|| RunPurityReport::new(&bin_contents(scene, &outcome.picks)))
}

impl RunReport {
    /// The report of `outcome`, a run on `scene`.
    pub fn new(strategy: String, scene: &Scene, outcome: &Outcome, made: Provenance) -> Self {
        let (station, pattern) = (scene.station(), scene.pattern());
        let steady = Throughput::of([&steady_state(scene, outcome)]);
        let figures = &outcome.figures;
        let outages = scene.conditions().has_outages();
        let id = |item: u32| pattern.items()[item as usize].id.clone();
        let robots = station.robots().iter().zip(&outcome.robots);
        let pick = |pick: &Pick| PickReport {
            robot: pick.robot,
            item: id(pick.item),
            bin: bin_name(station, pick),
            decide_s: pick.decide,
            grasp_s: pick.grasp,
            release_s: pick.release,
            meet: [pick.meet.x, pick.meet.y],
        };
        Self {
            strategy,
            throughput: ThroughputReport::new(&steady),
            items: figures.items,
            picked: figures.picked,
            picked_share: match figures.items {
                0 => f64::NAN,
                _ => figures.picked_share(),
            },
            end_s: figures.end,
            picking_rate_per_min: figures.picking_rate(),
            weighted_rate_per_min: figures.weighted_rate(),
            robots: robots
                .enumerate()
                .map(|(place, (robot, did))| {
                    let busy_share = steady.utilisation.get(place).copied();
                    let mut report = RobotRunReport::new(robot, did, figures.end, busy_share);
                    report.bins = bins_of(place, station, outcome);
                    report.down_s = outages.then(|| outcome.time_down(place));
                    report
                })
                .collect(),
            picks: outcome.picks.iter().map(pick).collect(),
            failures: outcome
                .failures
                .iter()
                .map(|failure| FailureReport {
                    attempt: pick(&failure.attempt),
                    cause: failure.cause.name(),
                })
                .collect(),
            missed: outcome
                .missed
                .iter()
                .map(|miss| MissReport {
                    item: id(miss.item),
                    reason: miss.reason.name(),
                })
                .collect(),
            unwanted: outcome
                .left
                .iter()
                .map(|left| MissReport {
                    item: id(left.item),
                    reason: left.reason.name(),
                })
                .collect(),
            classes: classes_of(scene, outcome),
            downtimes: outages.then(|| DowntimeReport::all(outcome)),
            sorting: purity_of(scene, outcome),
            missed_by_reason: missed_by_reason(scene, outcome),
            checked: None,
            bound: None,
            clearance: None,
            made,
            weighs: pattern.weighs_on(station),
        }
    }

    /// Compares the picks of each class with its bound.
    pub fn certify_classes(&mut self, bounds: &[ClassBound]) {
        for class in &mut self.classes {
            let bound = bounds.iter().find(|bound| bound.class == class.name);
            let most = bound.map(|bound| bound.picks);
            class.picks_upper_bound = most;
            class.certified_percent =
                most.map(|most| certified_percent(class.picked as f64, most as f64));
        }
    }
}
