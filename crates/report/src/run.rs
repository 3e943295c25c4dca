//! One simulated run.

use super::bound::CertifiedReport;
use super::classes::class_title;
use super::clearance::ClearanceReport;
use super::columns::TableColumns;
use super::csv_rows::{CsvRows, Displayed};
use super::presentation::Presentation;
use super::provenance::Provenance;
use super::purity::RunPurityReport;
use super::table::fixed;
use super::throughput::ThroughputReport;
use super::verb_report::{ResultFile, VerbReport};
use pickline::decision::{MissReason, Outcome, Pick, RobotFigures};
use pickline::experiment::ClassBound;
use pickline::planning::bound::certified_percent;
use pickline::purity::bin_contents;
use pickline::sim::{ClassRun, Scene, class_runs};
use pickline::station::Robot;
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
    /// Share of the items picked.
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

/// The number of missed items for each reason.
fn missed_by_reason(outcome: &Outcome) -> BTreeMap<&'static str, usize> {
    let all = MissReason::ALL.iter();
    let mut counts: BTreeMap<_, _> = all.map(|reason| (reason.name(), 0)).collect();
    for miss in &outcome.missed {
        *counts.entry(miss.reason.name()).or_default() += 1;
    }
    counts
}

/// The name of the bin of a pick, unless the robot has one bin for everything.
fn bin_name(robot: &Robot, pick: &Pick) -> Option<String> {
    let bin = &robot.bins[usize::from(pick.bin)];
    (!robot.has_only_bin()).then(|| bin.name.clone())
}

/// What went into each bin of robot number `index`, unless it has one bin for everything.
fn bins_of(index: usize, robot: &Robot, outcome: &Outcome) -> Vec<BinRunReport> {
    if robot.has_only_bin() {
        return Vec::new();
    }
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
        let id = |item: u32| pattern.items()[item as usize].id.clone();
        let robots = station.robots().iter().zip(&outcome.robots);
        let pick = |pick: &Pick| PickReport {
            robot: pick.robot,
            item: id(pick.item),
            bin: bin_name(&station.robots()[pick.robot], pick),
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
            picked_share: figures.picked_share(),
            end_s: figures.end,
            picking_rate_per_min: figures.picking_rate(),
            weighted_rate_per_min: figures.weighted_rate(),
            robots: robots
                .enumerate()
                .map(|(place, (robot, did))| {
                    let busy_share = steady.utilisation.get(place).copied();
                    let mut report = RobotRunReport::new(robot, did, figures.end, busy_share);
                    report.bins = bins_of(place, robot, outcome);
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
            sorting: purity_of(scene, outcome),
            missed_by_reason: missed_by_reason(outcome),
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

    /// The run as text for the terminal.
    fn text(&self, shown: &Presentation) -> String {
        let steady = self.throughput.throughput_per_min.is_some();
        let robots = TableColumns::new()
            .with("<robot", |robot: &&RobotRunReport| robot.name.clone())
            .with("picked", |robot| robot.picked.to_string())
            .with("busy [s]", |robot| fixed(robot.busy_s, 1))
            .with("utilisation [%]", |robot| {
                fixed(100.0 * robot.utilisation, 1)
            })
            .with_if(steady, "in the steady state [%]", |robot| {
                let share = robot.utilisation_steady;
                share.map_or(String::new(), |share| fixed(100.0 * share, 1))
            })
            .table(&self.robots);
        let checked = match self.checked {
            Some(true) => "checked   confirmed by the independent checker\n",
            _ => "",
        };
        let weighted = match self.weighs {
            true => format!(", weighted {} /min", fixed(self.weighted_rate_per_min, 2)),
            false => String::new(),
        };
        format!(
            "{}{}{}strategy  {}\npicked    {} of {} ({} %) in {} s\n\
             rate      {} picks/min over the whole run{weighted}\n\
             {}{}{}{}{checked}{}{}{}",
            self.throughput.line(),
            robots,
            self.classes_table(),
            self.strategy,
            self.picked,
            self.items,
            fixed(100.0 * self.picked_share, 1),
            fixed(self.end_s, 1),
            fixed(self.picking_rate_per_min, 2),
            self.missed_line(),
            self.unwanted_line(),
            self.sorting
                .as_ref()
                .map_or(String::new(), RunPurityReport::text),
            self.failed_line(),
            self.clearance
                .as_ref()
                .map_or(String::new(), ClearanceReport::line),
            self.bound
                .as_ref()
                .map_or(String::new(), |bound| bound.line(shown)),
            self.made.lines(),
        )
    }

    /// How many items were missed for which reason.
    fn missed_line(&self) -> String {
        let reasons = self.missed_by_reason.iter();
        let reasons = reasons.filter(|(_, count)| **count > 0);
        let reasons: Vec<String> = reasons
            .map(|(reason, count)| format!("{count} {reason}"))
            .collect();
        match reasons.len() {
            0 => "missed    nothing\n".to_owned(),
            _ => format!("missed    {}\n", reasons.join(", ")),
        }
    }

    /// How many items were left on purpose for which reason, if any were.
    fn unwanted_line(&self) -> String {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for left in &self.unwanted {
            *counts.entry(left.reason).or_default() += 1;
        }
        let counts: Vec<String> = counts
            .iter()
            .map(|(reason, count)| format!("{count} {reason}"))
            .collect();
        match counts.len() {
            0 => String::new(),
            _ => format!("left      {}\n", counts.join(", ")),
        }
    }

    /// The items of each class and the bins that they went into, if the station sorts.
    fn classes_table(&self) -> String {
        if self.classes.is_empty() {
            return String::new();
        }
        let mut certified = self.classes.iter();
        let bounded = certified.any(|class| class.picks_upper_bound.is_some());
        let classes = TableColumns::new()
            .with("<class", |class: &&ClassRunReport| {
                class_title(class.name.as_deref())
            })
            .with("items", |class| class.items.to_string())
            .with("picked", |class| class.picked.to_string())
            .with("recovery [%]", |class| {
                class
                    .recovery
                    .map_or("-".to_owned(), |share| fixed(100.0 * share, 1))
            })
            .with_if(bounded, "bound: picked", |class| {
                let most = class.picks_upper_bound;
                most.map_or("-".to_owned(), |most| most.to_string())
            })
            .with_if(bounded, "certified [%]", |class| {
                let certified = class.certified_percent;
                certified.map_or("-".to_owned(), |percent| fixed(percent, 1))
            })
            .table(&self.classes);
        let bins = self.robots.iter().flat_map(|robot| {
            let bins = robot.bins.iter();
            bins.map(move |bin| (robot.name.as_str(), bin))
        });
        let bins: Vec<(&str, &BinRunReport)> = bins.collect();
        let bins = TableColumns::new()
            .with("<robot", |(robot, _): &&(&str, &BinRunReport)| {
                (*robot).to_owned()
            })
            .with("<bin", |(_, bin)| bin.name.clone())
            .with("picked", |(_, bin)| bin.picked.to_string())
            .table(&bins);
        format!("{classes}{bins}")
    }

    /// How many attempts of which robot failed, if any did.
    fn failed_line(&self) -> String {
        let robots = self.robots.iter();
        let robots: Vec<String> = robots.map(|r| format!("{} {}", r.name, r.failed)).collect();
        match self.failures.len() {
            0 => String::new(),
            count => format!("failed    {count} attempts ({})\n", robots.join(", ")),
        }
    }

    /// The picks and failed attempts, one per line, in order of decision.
    fn picks_csv(&self) -> String {
        let failures = self.failures.iter().map(|f| (&f.attempt, f.cause));
        let mut attempts: Vec<_> = self.picks.iter().map(|pick| (pick, "")).collect();
        attempts.extend(failures);
        attempts.sort_by(|(a, _), (b, _)| {
            let times = a.decide_s.total_cmp(&b.decide_s);
            times.then(a.robot.cmp(&b.robot))
        });
        let rows = attempts.into_iter().map(|(pick, failure)| AttemptRow {
            robot: &self.robots[pick.robot].name,
            item: &pick.item,
            decide_s: Displayed(pick.decide_s),
            grasp_s: Displayed(pick.grasp_s),
            release_s: Displayed(pick.release_s),
            bin: pick.bin.as_deref(),
            meet_x_m: Displayed(pick.meet[0]),
            meet_y_m: Displayed(pick.meet[1]),
            failure,
        });
        let rows = CsvRows::of(rows);
        match self.robots.iter().all(|robot| robot.bins.is_empty()) {
            true => rows.without(&["bin"]).text(&self.made),
            false => rows.text(&self.made),
        }
    }
}

#[derive(Default, Serialize)]
struct AttemptRow<'r> {
    robot: &'r str,
    item: &'r str,
    decide_s: Displayed<f64>,
    grasp_s: Displayed<f64>,
    release_s: Displayed<f64>,
    /// Name of the bin; the column is left out if every robot has one bin for everything.
    bin: Option<&'r str>,
    meet_x_m: Displayed<f64>,
    meet_y_m: Displayed<f64>,
    /// Why the attempt failed; empty for a pick.
    failure: &'static str,
}

impl VerbReport for RunReport {
    const FILES: &'static [ResultFile<Self>] = &[
        ResultFile::json("run.json"),
        ResultFile::text("picks.csv", Self::picks_csv),
    ];

    fn provenance(&self) -> Option<&Provenance> {
        Some(&self.made)
    }

    fn to_table(&self, shown: &Presentation) -> String {
        self.text(shown)
    }

    fn to_csv(&self) -> String {
        self.picks_csv()
    }
}
