//! What line software ships, tuned: the best of its strategies on training patterns.

use super::robust::RobustTraining;
use crate::dispatch::Rule;
use crate::error::{Error, Result, counted};
use crate::optimize::Environment;
use crate::pattern::TrainingSet;
use crate::sim::{Conditions, Scene, simulate_while};
use crate::station::{Belt, Station};
use crate::strategies::{Blueprint, read_alone};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Its name among the methods.
pub(super) const RIVAL: &str = "rival";
/// Maximum number of training patterns that it is tuned on: the order of parameters that differ by
/// several percent does not need more.
const PATTERNS: usize = 24;
/// Maximum number of settings of each strategy that are tried.
const SETTINGS: usize = 120;
/// Weights of a robot before any is moved to another: as many as the steps below can halve.
const WEIGHT: u32 = 8;
/// Borders are moved in these parts of the belt's width.
const PARTS: i32 = 64;
/// How far settings are moved, coarse to fine.
const STEPS: [u32; 3] = [4, 2, 1];

/// The best strategy that was found.
#[derive(Serialize, Deserialize)]
pub(super) struct TunedRival {
    /// How it is written, with its parameters.
    pub text: String,
    /// What it is, and how it compares with the others on the training patterns.
    pub remark: String,
}

/// One of the strategies with one setting of its parameters.
#[derive(Debug, Clone, PartialEq)]
enum Setting {
    /// FIFO for all of this number of robots, which see everything.
    Fifo(usize),
    /// One rule for all of them.
    Everyone(usize, Rule),
    Share(Vec<u32>, bool, Rule),
    Every(Vec<u32>, Rule),
    /// Borders in parts of the belt's width.
    Zones(Vec<i32>, Rule),
}

impl Setting {
    /// Where the search begins on a line of `robots` robots.
    fn starts(robots: usize) -> Vec<Self> {
        let equal = || vec![WEIGHT; robots];
        let borders = 1..robots as i32;
        let border = |i: i32| i * PARTS / robots as i32 - PARTS / 2;
        vec![
            Self::Fifo(robots),
            Self::Everyone(robots, Rule::FIFO),
            Self::Share(equal(), false, Rule::FIFO),
            Self::Share(equal(), true, Rule::FIFO),
            Self::Every((1..=robots as u32).rev().collect(), Rule::FIFO),
            Self::Zones(borders.map(border).collect(), Rule::FIFO),
        ]
    }

    /// How it is written as a strategy.
    fn text(&self, belt: &Belt) -> String {
        fn list<T: ToString>(values: &[T]) -> String {
            let values: Vec<_> = values.iter().map(T::to_string).collect();
            values.join(",")
        }
        match self {
            Self::Fifo(robots) => format!("rules:{}", list(&vec!["FIFO"; *robots])),
            Self::Everyone(robots, rule) => format!("rules:{}", list(&vec![*rule; *robots])),
            Self::Share(weights, feedback, rule) => {
                let feedback = if *feedback { ",feedback=yes" } else { "" };
                format!("share:{}{feedback},rule={rule}", list(weights))
            }
            Self::Every(intervals, rule) => format!("every:{},rule={rule}", list(intervals)),
            // One robot has no border.
            Self::Zones(borders, rule) if borders.is_empty() => format!("zones:rule={rule}"),
            Self::Zones(borders, rule) => {
                let metres = |&border: &i32| {
                    let metres = f64::from(border) / f64::from(PARTS) * belt.width;
                    // No digits beyond micrometres.
                    (metres * 1e6).round() / 1e6
                };
                let metres = borders.iter().map(metres);
                format!("zones:{},rule={rule}", list(&metres.collect::<Vec<_>>()))
            }
        }
    }

    /// The same with every other rule.
    fn with_other_rules(&self) -> Vec<Self> {
        let own = match self {
            Self::Fifo(_) => return Vec::new(),
            Self::Everyone(_, rule)
            | Self::Share(_, _, rule)
            | Self::Every(_, rule)
            | Self::Zones(_, rule) => *rule,
        };
        let with = |rule| match self.clone() {
            Self::Fifo(robots) | Self::Everyone(robots, _) => Self::Everyone(robots, rule),
            Self::Share(weights, feedback, _) => Self::Share(weights, feedback, rule),
            Self::Every(intervals, _) => Self::Every(intervals, rule),
            Self::Zones(borders, _) => Self::Zones(borders, rule),
        };
        Rule::all().filter(|rule| *rule != own).map(with).collect()
    }

    /// The settings at distance `step`: weight moved from one robot to another, a longer or shorter
    /// interval, or a border moved to either side.
    fn moved(&self, step: u32) -> Vec<Self> {
        let mut all = Vec::new();
        match self {
            Self::Fifo(_) | Self::Everyone(..) => {}
            Self::Share(weights, feedback, rule) => {
                for from in 0..weights.len() {
                    for to in 0..weights.len() {
                        if from != to && weights[from] >= step {
                            let mut moved = weights.clone();
                            moved[from] -= step;
                            moved[to] += step;
                            all.push(Self::Share(moved, *feedback, *rule));
                        }
                    }
                }
            }
            Self::Every(intervals, rule) => {
                for robot in 0..intervals.len() {
                    let own = intervals[robot];
                    for other in [own.saturating_add(step), own.saturating_sub(step)] {
                        let mut moved = intervals.clone();
                        moved[robot] = other;
                        // With 1 for all, everyone sees everything.
                        if other > 0 && moved.iter().any(|interval| *interval > 1) {
                            all.push(Self::Every(moved, *rule));
                        }
                    }
                }
            }
            Self::Zones(borders, rule) => {
                for place in 0..borders.len() {
                    for by in [-(step as i32), step as i32] {
                        let mut moved = borders.clone();
                        moved[place] += 2 * by;
                        let on_belt = moved.iter().all(|border| 2 * border.abs() < PARTS);
                        if on_belt && moved.windows(2).all(|pair| pair[0] < pair[1]) {
                            all.push(Self::Zones(moved, *rule));
                        }
                    }
                }
            }
        }
        all
    }
}

/// What a setting achieves on all training patterns.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
struct Score {
    picked: usize,
    /// The sum of the picking rates, where as much is picked.
    rates: f64,
}

/// The line and the patterns on which settings are tried.
struct Trials<'a> {
    station: &'a Station,
    scenes: Vec<Scene<'a>>,
    environment: &'a Environment<'a>,
}

impl Trials<'_> {
    fn score(&self, setting: &Setting) -> Result<Score> {
        let text = setting.text(self.station.belt());
        let blueprint = read_alone(&text, self.station.robots().len())?;
        let run = |scene: &Scene| {
            let go_on = || !self.environment.stopped();
            Ok(simulate_while(scene, blueprint.make().as_mut(), go_on)?.figures)
        };
        let figures: Result<Vec<_>> = self.scenes.par_iter().map(run).collect();
        let figures = figures?;
        Ok(Score {
            picked: figures.iter().map(|figures| figures.picked).sum(),
            // In the order of the patterns, so that the sum does not depend on the threads.
            rates: figures.iter().map(|figures| figures.picking_rate()).sum(),
        })
    }

    /// The best setting that is found from `start`: the rule is chosen first, then the parameters, each
    /// change that is better being taken at once, then the rule again.
    fn climb(&self, start: Setting) -> Result<(Setting, Score)> {
        let score = self.score(&start)?;
        let mut best = (start, score);
        let mut left = SETTINGS;
        self.take_better(&mut best, |best| best.with_other_rules(), &mut left)?;
        for step in STEPS {
            while self.take_better(&mut best, |best| best.moved(step), &mut left)? {}
        }
        self.take_better(&mut best, |best| best.with_other_rules(), &mut left)?;
        Ok(best)
    }

    /// Tries what `others` makes of `best`, and says whether any of it was better. `left` is the number
    /// of settings that may still be tried.
    fn take_better(
        &self,
        best: &mut (Setting, Score),
        others: impl Fn(&Setting) -> Vec<Setting>,
        left: &mut usize,
    ) -> Result<bool> {
        let mut found = false;
        for other in others(&best.0) {
            if *left == 0 {
                return Ok(false);
            }
            *left -= 1;
            let score = self.score(&other)?;
            if score > best.1 {
                *best = (other, score);
                found = true;
            }
        }
        Ok(found)
    }
}

/// The patterns on which it is tuned: those of robust GT (game theory) if `training` names a set, otherwise
/// what `like_scored` makes of about the given number of items a pattern.
///
/// # Errors
/// As for `like_scored`.
pub(super) fn tuning_set(
    training: &RobustTraining,
    like_scored: impl FnOnce(Option<usize>) -> Result<TrainingSet>,
) -> Result<TrainingSet> {
    match training {
        RobustTraining::On(set) => Ok(TrainingSet {
            set: set.clone(),
            seen: false,
        }),
        RobustTraining::LikeScored { items } | RobustTraining::Paper { items } => {
            like_scored(*items)
        }
        RobustTraining::Given(_) => like_scored(None),
    }
}

/// The strategy of line software that picks the most on patterns of a training set, under `conditions`.
///
/// # Errors
/// A pattern that does not fit on the belt, or
/// [`Interrupted`](crate::error::ErrorKind::Interrupted).
pub(super) fn tune(
    station: &Station,
    TrainingSet { set, seen }: &TrainingSet,
    conditions: &Conditions,
    environment: &Environment,
) -> Result<TunedRival> {
    let apart = set.patterns.len().div_ceil(PATTERNS).max(1);
    let patterns = set.patterns.iter().enumerate().step_by(apart);
    let scene = |(place, pattern)| Scene::under(station, pattern, conditions.of_place(place));
    let trials = Trials {
        station,
        scenes: patterns.map(scene).collect::<Result<_>>()?,
        environment,
    };
    let starts = Setting::starts(station.robots().len());
    let progress = environment.progress;
    progress.begin("tuning", starts.len() as u64, "rivals");
    let mut found = Vec::with_capacity(starts.len());
    for start in starts {
        found.push(trials.climb(start)?);
        progress.advance(1);
    }
    progress.end();
    // The sort is stable, so of equals the simpler one is first.
    found.sort_by(|(_, a), (_, b)| b.partial_cmp(a).unwrap_or(std::cmp::Ordering::Equal));
    let items: usize = trials.scenes.iter().map(|s| s.pattern().len()).sum();
    let robots = station.robots().len();
    let mut lines = Vec::with_capacity(found.len());
    let mut best = None;
    for (setting, score) in &found {
        let blueprint = read_alone(&setting.text(station.belt()), robots)?;
        let share = 100.0 * score.picked as f64 / items.max(1) as f64;
        let line = format!("{} {share:.1} %", blueprint.name());
        // On a line of one robot, FIFO for all is a rule for all.
        if !lines.contains(&line) {
            lines.push(line);
        }
        best.get_or_insert(blueprint);
    }
    // There is always FIFO for all.
    let best = best.ok_or(Error::interrupted())?;
    let remark = format!(
        "{RIVAL} is {}, the best of what line software ships on {}{}; picked there: {}",
        best.name(),
        counted(trials.scenes.len(), "training pattern"),
        match *seen {
            true => ", which are the very patterns used here and favour it",
            false => "",
        },
        lines.join(", ")
    );
    Ok(TunedRival {
        text: best.name().to_owned(),
        remark,
    })
}

impl TunedRival {
    /// The strategy, called [`RIVAL`], for a line of `robots` robots.
    ///
    /// # Errors
    /// None, as its text was read before.
    pub(super) fn blueprint(&self, robots: usize) -> Result<Blueprint> {
        Ok(read_alone(&self.text, robots)?.called(RIVAL))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{PatternSource, Recipe};
    use crate::sim::simulate;
    use crate::station::built_in;
    use crate::strategies::parse;

    fn line() -> (Station, TrainingSet) {
        let station = built_in("paper").unwrap().station(Some(3)).unwrap();
        let recipe = Recipe {
            belt: *station.belt(),
            items: 40,
            shape: Default::default(),
            attributes: Default::default(),
            seed: 3,
        };
        let set = PatternSource::Balanced(2).build(&recipe).unwrap();
        (station, TrainingSet { set, seen: false })
    }

    /// Weight is moved, not made; intervals and borders stay valid; everything can be written.
    #[test]
    fn settings_stay_valid() {
        for robots in 1..=4 {
            let station = built_in("paper").unwrap().station(Some(robots)).unwrap();
            for start in Setting::starts(robots) {
                let mut tried = vec![start.clone()];
                tried.extend(start.with_other_rules());
                for step in STEPS {
                    tried.extend(start.moved(step));
                }
                for setting in &tried {
                    let text = setting.text(station.belt());
                    parse(&text).unwrap().check_on(&station).unwrap();
                    match setting {
                        Setting::Share(weights, ..) => {
                            assert_eq!(weights.iter().sum::<u32>(), WEIGHT * robots as u32);
                        }
                        Setting::Every(intervals, _) => {
                            assert!(robots == 1 || intervals.iter().any(|n| *n > 1), "{text}");
                        }
                        _ => {}
                    }
                }
                let others = tried.iter().skip(1).filter(|other| **other == start);
                assert_eq!(others.count(), 0, "{start:?}");
            }
        }
    }

    /// It is at least as good as every start, and the same each time.
    #[test]
    fn the_rival_is_the_best_that_was_found() {
        let (station, set) = line();
        let conditions = Conditions::default();
        let environment = Environment::QUIET;
        let robots = station.robots().len();
        let rival = tune(&station, &set, &conditions, &environment).unwrap();
        let again = tune(&station, &set, &conditions, &environment).unwrap();
        assert_eq!(rival.remark, again.remark);
        assert_eq!(rival.blueprint(robots).unwrap().name(), RIVAL);
        let name = rival.blueprint(robots).unwrap().make().name();
        let begins = format!("rival is {name}, the best of what line software ships on 4 training");
        assert!(rival.remark.starts_with(&begins), "{}", rival.remark);

        let patterns = set.set.patterns.iter();
        let trials = Trials {
            station: &station,
            scenes: patterns.map(|p| Scene::new(&station, p).unwrap()).collect(),
            environment: &environment,
        };
        let picked = |make: &dyn Fn() -> Box<dyn crate::decision::Strategy>| -> usize {
            let runs = trials.scenes.iter();
            runs.map(|scene| simulate(scene, make().as_mut()).unwrap().figures.picked)
                .sum()
        };
        let best = picked(&|| rival.blueprint(robots).unwrap().make());
        for start in Setting::starts(3) {
            let score = trials.score(&start).unwrap();
            let blueprint = read_alone(&start.text(station.belt()), 3).unwrap();
            assert_eq!(score.picked, picked(&|| blueprint.make()));
            assert!(best >= score.picked, "{start:?}");
        }
    }
}
