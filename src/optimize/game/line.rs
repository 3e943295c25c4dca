//! The game that a station plays on a set of patterns.

use super::normal_form::{Game, Player};
use super::payoff::Payoff;
use crate::dispatch::RULES;
use crate::error::{Error, Result};
use crate::optimize::Environment;
use crate::pattern::{Pattern, random_stream};
use crate::sim::{AssignmentTree, Conditions, Scene, check_offered};
use crate::station::Station;
use crate::stats::{Interval, interval_of};
use rand::seq::SliceRandom;
use rayon::prelude::*;

/// The longest line whose game is solved: 6^4 assignments.
pub const MOST_ROBOTS: usize = 4;

/// Number of patterns that are simulated before their figures are added up: enough to keep all
/// threads busy, few enough to limit memory.
const BATCH: usize = 256;

/// What a robot gains from an assignment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, strum::IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum PayoffKind {
    /// Its own picks per minute, `60 k_i / T`.
    Own,
    /// The line's picks per minute, `60 k / T`: all robots have the same interest.
    Total,
}

impl PayoffKind {
    /// The name in files: `own` or `total`.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// A station's game, with the data needed for confidence intervals of differences.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct LineGame {
    /// The game: payoffs are means over the patterns; welfare is the sum of the robots' own
    /// rates.
    pub game: Game,
    /// Number of patterns; all of them unless the work was stopped.
    pub patterns: usize,
    /// Number of those on which the robots are independent, so that the cascade was used.
    pub independent: usize,
    /// Each robot's own rate [1/min], profile by profile.
    rates: Vec<Payoff>,
    sums: Sums,
}

/// Checks that the game of `station` is small enough to be solved.
///
/// # Errors
/// More than [`MOST_ROBOTS`] robots.
pub fn check_size(station: &Station) -> Result<()> {
    let robots = station.robots().len();
    if robots <= MOST_ROBOTS {
        return Ok(());
    }
    Err(Error::usage(
        "'station', 'robots'",
        format!(
            "a game of {robots} robots has {}^{robots} rule assignments; games are solved \
             exhaustively, up to {MOST_ROBOTS} robots",
            RULES.len()
        ),
        format!(
            "give a line of {MOST_ROBOTS} robots or fewer, or search a longer line with \
             `pickline optimize`"
        ),
    ))
}

impl LineGame {
    /// Simulates all assignments of `station` on `patterns` under `conditions`; pattern i draws
    /// its random events from their seed + i. Sums are always computed in the same order of patterns, so
    /// no figure depends on the number of threads.
    ///
    /// # Errors
    /// Too many robots, a pattern that does not fit on the belt, no item that is to be picked, invalid
    /// conditions, or interrupted before the first pattern was done.
    pub fn new(
        station: &Station,
        patterns: &[Pattern],
        payoff: PayoffKind,
        conditions: &Conditions,
        environment: &Environment,
    ) -> Result<Self> {
        check_size(station)?;
        check_offered(station, patterns)?;
        let tree = AssignmentTree::all(station.robots().len());
        let mut sums = Sums::new(station.robots().len(), tree.assignments().len(), payoff);
        let (mut done, mut independent) = (0, 0);
        let total = patterns.len() as u64;
        environment.progress.begin("playing", total, "patterns");
        // In random order, so that an interrupted run has a sample of the set rather than its
        // first part.
        let mut order: Vec<usize> = (0..patterns.len()).collect();
        order.shuffle(&mut random_stream(0, 0));
        for batch in order.chunks(BATCH) {
            let runs: Vec<Option<(Vec<f64>, bool)>> = batch
                .par_iter()
                .map(|&place| {
                    let own = conditions.of_place(place);
                    let scene = Scene::under(station, &patterns[place], own)?;
                    let rates = own_rates(&scene, &tree, environment)?;
                    Ok(rates.map(|rates| (rates, scene.is_independent())))
                })
                .collect::<Result<_>>()?;
            for (rates, cascaded) in runs.into_iter().flatten() {
                sums.add(&rates);
                done += 1;
                independent += usize::from(cascaded);
            }
        }
        environment.progress.end();
        if done == 0 {
            return Err(Error::interrupted());
        }
        let rates = sums.means();
        Ok(Self {
            game: game_of(station, &rates, payoff)?,
            patterns: done,
            independent,
            rates,
            sums,
        })
    }

    /// Each robot's own picks per minute in `profile`.
    pub fn rates(&self, profile: usize) -> &[Payoff] {
        let n = self.game.players().len();
        &self.rates[profile * n..(profile + 1) * n]
    }

    /// 95 % interval of `player`'s gain if it does `action` instead in `profile` [1/min]:
    /// Student's t, paired over the patterns; `None` for a single pattern.
    pub fn gain_interval(&self, profile: usize, player: usize, action: usize) -> Option<Interval> {
        let other = self.game.with(profile, player, action);
        let n = self.sums.patterns as f64;
        let value = |p: usize| self.sums.payoff(&self.sums.values, p, player);
        let mean = (value(other) - value(profile)) / n;
        let squares = self.sums.squares[self.sums.place(profile, player, action)];
        // Negative only by rounding, which `interval_of` treats as 0.
        interval_of(self.sums.patterns, mean, squares - n * mean * mean)
    }

    /// Number of runs for the game: one assignment on one pattern each.
    pub fn runs(&self) -> u64 {
        self.game.profiles() as u64 * self.patterns as u64
    }
}

/// Each robot's own rate [1/min] under every assignment, assignment by assignment; `None` if
/// stopped.
fn own_rates(
    scene: &Scene,
    tree: &AssignmentTree,
    environment: &Environment,
) -> Result<Option<Vec<f64>>> {
    let robots = scene.station().robots().len();
    let mut rates = vec![0.0; tree.assignments().len() * robots];
    let go_on = || !environment.stopped();
    let whole = tree.evaluate_robots(scene, go_on, |place, figures, picks| {
        let of_one = &mut rates[place * robots..];
        for (rate, &picked) in of_one.iter_mut().zip(picks) {
            *rate = figures.rate_of(picked);
        }
    })?;
    environment.progress.advance(1);
    Ok(whole.then_some(rates))
}

fn game_of(station: &Station, rates: &[Payoff], payoff: PayoffKind) -> Result<Game> {
    let robots = station.robots();
    let rules: Vec<String> = RULES.iter().map(|rule| rule.name().to_owned()).collect();
    let players = robots
        .iter()
        .map(|robot| Player {
            name: robot.name.clone(),
            actions: rules.clone(),
        })
        .collect();
    let profiles = rates.chunks(robots.len());
    let welfare: Vec<Payoff> = profiles.map(|p| p.iter().copied().sum()).collect();
    let payoffs = match payoff {
        PayoffKind::Own => rates.to_vec(),
        PayoffKind::Total => welfare
            .iter()
            .flat_map(|&total| std::iter::repeat_n(total, robots.len()))
            .collect(),
    };
    Game::new(players, payoffs, welfare)
}

/// Sums over patterns.
#[derive(Debug, Clone)]
struct Sums {
    robots: usize,
    payoff: PayoffKind,
    patterns: usize,
    /// Own rates, profile by profile.
    values: Vec<f64>,
    /// Squared gains of every change of one rule, indexed by profile, robot and new rule.
    squares: Vec<f64>,
}

impl Sums {
    fn new(robots: usize, profiles: usize, payoff: PayoffKind) -> Self {
        Self {
            robots,
            payoff,
            patterns: 0,
            values: vec![0.0; profiles * robots],
            squares: vec![0.0; profiles * robots * RULES.len()],
        }
    }

    fn place(&self, profile: usize, robot: usize, rule: usize) -> usize {
        (profile * self.robots + robot) * RULES.len() + rule
    }

    /// The payoff of `robot` in `profile` if the own rates are `values`.
    fn payoff(&self, values: &[f64], profile: usize, robot: usize) -> f64 {
        let of_profile = &values[profile * self.robots..(profile + 1) * self.robots];
        match self.payoff {
            PayoffKind::Own => of_profile[robot],
            PayoffKind::Total => of_profile.iter().sum(),
        }
    }

    fn add(&mut self, rates: &[f64]) {
        self.patterns += 1;
        for (sum, rate) in self.values.iter_mut().zip(rates) {
            *sum += rate;
        }
        let profiles = rates.len() / self.robots;
        for profile in 0..profiles {
            // Distance between two profiles that differ by one in the robot's rule.
            let mut stride = profiles;
            for robot in 0..self.robots {
                stride /= RULES.len();
                let rule = profile / stride % RULES.len();
                let own = self.payoff(rates, profile, robot);
                for other in 0..RULES.len() {
                    let changed = profile - rule * stride + other * stride;
                    let gain = self.payoff(rates, changed, robot) - own;
                    let place = self.place(profile, robot, other);
                    self.squares[place] += gain * gain;
                }
            }
        }
    }

    fn means(&self) -> Vec<Payoff> {
        let mean = |sum: &f64| Payoff::rounded(sum / self.patterns as f64);
        self.values.iter().map(mean).collect()
    }
}
