//! What a line still does with one of its robots halted, for each robot.

use super::method::{Method, MethodRun};
use crate::decision::{Figures, picked_shares};
use crate::error::{Error, Result};
use crate::optimize::Environment;
use crate::pattern::Pattern;
use crate::sim::{Conditions, Outage, Scene};
use crate::station::Station;
use crate::stats::{self, Interval};
use crate::throughput::{Steadiness, Throughput};
use rayon::prelude::*;

/// How this sweep is called beside those of an [`Axis`](super::Axis).
pub const ROBOTS_DOWN: &str = "robots-down";

/// One method with one robot halted, or with none.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct HaltedPoint {
    /// The method's name in files: [`Method::id`].
    pub method: String,
    /// Its name in tables.
    pub title: String,
    /// Mean share of the items picked.
    pub picked_share: f64,
    /// 95 % interval of that mean; `None` for a single pattern, as for the others.
    pub picked_share_interval: Option<Interval>,
    /// Picks per minute in the steady state.
    pub throughput: Throughput,
    /// Mean picking rate [1/min].
    pub picking_rate: f64,
    /// 95 % interval of that mean [1/min].
    pub picking_rate_interval: Option<Interval>,
    /// Mean weighted rate [1/min].
    pub weighted_rate: f64,
    /// How many fewer items the method picks than with no robot halted, in total over all patterns
    /// and as a share of those; `None` with no robot halted, or if nothing is picked then.
    pub loss: Option<f64>,
    /// 95 % interval of that loss, at most 1, by the ratio estimator over patterns (Cochran 1977, Sampling
    /// Techniques, ISBN 0-471-16240-X, section 6.3).
    pub loss_interval: Option<Interval>,
}

/// All methods with one robot halted, or with none.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct HaltedRobot {
    /// Name of the robot that is down for the whole run; `None` if all work.
    pub robot: Option<String>,
    /// The methods, in the same order everywhere.
    pub methods: Vec<HaltedPoint>,
}

/// All methods with no robot halted, and with each.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct RobotsDown {
    /// With no robot halted, then with each, upstream first; fewer after a stop request.
    pub halted: Vec<HaltedRobot>,
    /// Number of entries that were asked for.
    pub planned: usize,
    /// Number of patterns.
    pub patterns: usize,
    /// Whether items have attributes, so that weight differs from the count.
    pub weighs: bool,
}

/// Runs `methods` on `patterns` with no robot of `station` halted, then with each of them down for
/// the whole run. Pattern i draws its random events from the conditions' seed + i every time. The
/// same input gives the same result on any number of threads. A stop request takes effect after a
/// whole entry.
///
/// # Errors
/// A pattern that does not fit on the belt, an illegal action, or
/// [`Interrupted`](crate::error::ErrorKind) before the first entry is complete.
pub fn halt_each_robot(
    station: &Station,
    methods: &[Method],
    patterns: &[Pattern],
    conditions: &Conditions,
    environment: &Environment,
) -> Result<RobotsDown> {
    let robots = station.robots().iter().map(|robot| Some(&robot.name));
    let all: Vec<Option<&String>> = [None].into_iter().chain(robots).collect();
    let progress = environment.progress;
    progress.begin("halting robots", all.len() as u64, "robots");
    let mut halted: Vec<HaltedRobot> = Vec::with_capacity(all.len());
    let mut runs: Vec<Vec<Vec<MethodRun>>> = Vec::with_capacity(all.len());
    for robot in &all {
        let conditions = match robot {
            None => conditions.clone(),
            Some(name) => {
                let outage = Outage::new(name.as_str(), 0.0, f64::INFINITY);
                conditions.clone().with_outage(outage)
            }
        };
        let by_pattern = match run_all(station, methods, patterns, &conditions, environment) {
            Err(error) if error.is_interrupted() && !halted.is_empty() => break,
            by_pattern => by_pattern?,
        };
        let whole = runs.first().unwrap_or(&by_pattern);
        let point = |(i, method): (usize, &Method)| {
            let of = |all: &[Vec<MethodRun>]| all.iter().map(|run| run[i].clone()).collect();
            let (own, whole): (Vec<MethodRun>, Vec<MethodRun>) = (of(&by_pattern), of(whole));
            summarise(method, &own, robot.is_some().then_some(&whole))
        };
        halted.push(HaltedRobot {
            robot: robot.cloned(),
            methods: methods.iter().enumerate().map(point).collect(),
        });
        runs.push(by_pattern);
        progress.advance(1);
    }
    progress.end();
    add_throughputs(&mut halted, &runs);
    Ok(RobotsDown {
        halted,
        planned: all.len(),
        patterns: patterns.len(),
        weighs: patterns.iter().any(Pattern::has_attributes),
    })
}

/// For every pattern, the runs of all methods.
fn run_all(
    station: &Station,
    methods: &[Method],
    patterns: &[Pattern],
    conditions: &Conditions,
    environment: &Environment,
) -> Result<Vec<Vec<MethodRun>>> {
    let run = |(place, pattern): (usize, &Pattern)| -> Result<Vec<MethodRun>> {
        let scene = Scene::under(station, pattern, conditions.of_place(place))?;
        let runs = methods.iter().map(|method| {
            if environment.stopped() {
                return Err(Error::interrupted());
            }
            method.run(&scene, environment)
        });
        runs.collect()
    };
    patterns.par_iter().enumerate().map(run).collect()
}

/// The figures of `method` in `runs`, in comparison with those of the `whole` line.
fn summarise(method: &Method, runs: &[MethodRun], whole: Option<&Vec<MethodRun>>) -> HaltedPoint {
    let all = |of: &dyn Fn(&MethodRun) -> f64| -> Vec<f64> { runs.iter().map(of).collect() };
    let figures: Vec<Figures> = runs.iter().map(|run| run.figures).collect();
    let shares = picked_shares(&figures);
    let rates = all(&|run| run.figures.picking_rate());
    let loss = whole.and_then(|whole| {
        let pairs = whole.iter().zip(runs);
        let picked = |run: &MethodRun| run.figures.picked;
        let pairs: Vec<(usize, usize)> =
            pairs.map(|(all, run)| (picked(run), picked(all))).collect();
        let [kept, before] = [0, 1].map(|place| {
            let counts = pairs.iter().map(|pair| [pair.0, pair.1][place]);
            counts.sum::<usize>() as f64
        });
        // What is left is nothing at least.
        let left = stats::ratio_interval(&pairs).map(|ends| ends.within(0.0, f64::INFINITY));
        let interval = left.map(|left| Interval {
            low: 1.0 - left.high,
            high: 1.0 - left.low,
        });
        (before > 0.0).then(|| (1.0 - kept / before, interval))
    });
    HaltedPoint {
        method: method.id().to_owned(),
        title: method.title(),
        picked_share: stats::mean(&shares),
        picked_share_interval: stats::share_mean_interval(&shares),
        throughput: Throughput::of(runs.iter().map(|run| &run.steady)),
        picking_rate: stats::mean(&rates),
        picking_rate_interval: stats::rate_mean_interval(&rates),
        weighted_rate: stats::mean(&all(&|run| run.figures.weighted_rate())),
        loss: loss.map(|(loss, _)| loss),
        loss_interval: loss.and_then(|(_, interval)| interval),
    }
}

/// Throughputs over those patterns on which all runs are steady, so that they can be compared.
fn add_throughputs(halted: &mut [HaltedRobot], runs: &[Vec<Vec<MethodRun>>]) {
    let mut steadiness: Vec<Vec<&Steadiness>> = Vec::new();
    for (by_pattern, entry) in runs.iter().zip(&*halted) {
        let of_method = |i: usize| by_pattern.iter().map(|run| &run[i].steady).collect();
        steadiness.extend((0..entry.methods.len()).map(of_method));
    }
    let points = halted.iter_mut().flat_map(|entry| &mut entry.methods);
    for (point, throughput) in points.zip(Throughput::beside(&steadiness)) {
        point.throughput = throughput;
    }
}
