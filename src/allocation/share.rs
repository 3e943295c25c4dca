//! Shares: a weighted round robin over the items gives each robot its own.

use super::items::{KnownItem, KnownItems};
use super::own_rules::{OwnRules, RULE, RULE_OPTION};
use super::round_robin::RoundRobin;
use super::written::{Written, check_count};
use crate::decision::{Action, Snapshot, Strategy};
use crate::dispatch::Rule;
use crate::error::{Error, Result, shown};

/// Its name among the strategies.
const KIND: &str = "share";

/// Who an item belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
enum Owner {
    /// It has just arrived.
    #[default]
    New,
    Robot(usize),
    /// Nobody can take it, or takes it.
    Nobody,
}

/// Shares of the items in order of arrival: a weighted round robin gives each item to a robot, which
/// alone may take it.
///
/// Only robots take part that have a bin for the item and whose workspace it passes. With feedback, an
/// item that its robot can no longer reach goes to one of the robots further downstream that can take
/// it, by a round robin of its own with the same weights. `docs/rivals.md` names the line software that
/// works like this.
#[derive(Debug, Clone)]
pub struct Share {
    weights: Vec<f64>,
    feedback: bool,
    rules: OwnRules,
    items: KnownItems<Owner>,
    turns: RoundRobin,
    /// For each robot, the turns of those downstream of it with the items that it missed.
    missed: Vec<RoundRobin>,
}

impl Share {
    /// Options and their meanings, for help texts.
    pub(crate) const KEYS: [(&'static str, &'static str); 2] = [
        (
            "feedback",
            "yes or no: items that their robot missed go to those downstream [no]",
        ),
        RULE_OPTION,
    ];

    /// One weight for each robot, upstream first; each robot takes its own items by FIFO.
    ///
    /// # Errors
    /// No weight, one that is negative, infinite or not a number, or no positive one.
    pub fn new(weights: Vec<f64>) -> Result<Self> {
        let place = format!("'strategy' {KIND}");
        let valid = weights.iter().all(|w| (0.0..=Self::MOST).contains(w));
        if weights.is_empty() || !valid {
            let problem = match valid {
                true => "it has no weight",
                false => "a weight is out of range",
            };
            return Err(Error::usage(place, problem, Self::CURE));
        }
        if weights.iter().all(|weight| *weight == 0.0) {
            let cure = "give at least one robot a weight above 0";
            return Err(Error::usage(place, "every weight is 0", cure));
        }
        Ok(Self {
            missed: vec![RoundRobin::default(); weights.len()],
            weights,
            feedback: false,
            rules: OwnRules::default(),
            items: KnownItems::default(),
            turns: RoundRobin::default(),
        })
    }

    const MOST: f64 = 1e9;
    const CURE: &str = "give one weight from 0 to 1e9 for each robot, upstream first, such as \
                        share:40,60";

    /// With items that their robot missed given to the robots downstream of it, or lost to it.
    #[must_use]
    pub fn with_feedback(mut self, feedback: bool) -> Self {
        self.feedback = feedback;
        self
    }

    /// With these rules by which robots choose among their own items: one for all, or one for each.
    #[must_use]
    pub fn with_rules(mut self, rules: Vec<Rule>) -> Self {
        self.rules = OwnRules::new(rules);
        self
    }

    /// Reads what stands after the colon.
    pub(crate) fn read(text: &str) -> Result<Self> {
        let written = Written::read(KIND, text, &Self::KEYS)?;
        let mut share = Self::new(written.numbers(0.0..=Self::MOST, Self::CURE)?)?;
        for &(key, value) in &written.options {
            match (key, value) {
                (RULE, rules) => share.rules = OwnRules::read(&written, rules)?,
                (_, "yes") => share.feedback = true,
                (_, "no") => share.feedback = false,
                (key, value) => {
                    let problem = format!("`{}` is not a valid value", shown(value));
                    return Err(written.wrong(key, &problem, "give yes or no"));
                }
            }
        }
        Ok(share)
    }

    /// Gives new items to robots, and missed ones to robots further downstream.
    fn allocate(&mut self, time: f64) {
        let (weights, turns, missed) = (&self.weights, &mut self.turns, &mut self.missed);
        let feedback = self.feedback;
        self.items.for_each_free(|item| {
            let given = match item.state {
                Owner::New => turns.next(weights, |robot| item.can_be_taken(robot, time)),
                Owner::Robot(owner) if feedback && !item.can_be_taken(owner, time) => {
                    let below = |robot| robot > owner && item.can_be_taken(robot, time);
                    missed[owner].next(weights, below)
                }
                _ => return,
            };
            item.state = given.map_or(Owner::Nobody, Owner::Robot);
        });
    }

    /// The answer of `robot`, which has no item of its own to leave for at `time` [s].
    fn wait(&self, robot: usize, time: f64) -> Action {
        // A window that opens wakes the robot. An item that is handed over while the window is open
        // does not: then the robot has to know the time.
        let mut handed_over = false;
        let comes = |item: &KnownItem<Owner>| {
            let (open, close) = item.windows[robot]?;
            match item.state {
                Owner::Robot(owner) if owner == robot => Some(open),
                Owner::Robot(owner) if self.feedback && owner < robot => {
                    let (_, missed) = item.windows[owner]?;
                    handed_over |= open <= missed && missed < close;
                    Some(open.max(missed.next_up()))
                }
                _ => None,
            }
        };
        let times = self.items.free().filter_map(comes);
        let next = times
            .filter(|&next| next > time)
            .fold(f64::INFINITY, f64::min);
        match handed_over && next.is_finite() {
            true => Action::WaitUntil(next),
            false => Action::WaitForNextWindow,
        }
    }
}

impl Strategy for Share {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        self.items.update(snapshot);
        self.allocate(snapshot.time);
        let items = &self.items;
        let is_own = |item: u32| {
            let known = items.get(item);
            known.is_some_and(|known| known.state == Owner::Robot(snapshot.robot))
        };
        let pick = self
            .rules
            .pick(snapshot, |candidate| is_own(candidate.item));
        pick.unwrap_or_else(|| self.wait(snapshot.robot, snapshot.time))
    }

    fn name(&self) -> String {
        let weights: Vec<_> = self.weights.iter().map(f64::to_string).collect();
        let mut name = format!("{KIND}:{}", weights.join(","));
        if self.feedback {
            name += ",feedback=yes";
        }
        if let Some(rules) = self.rules.written() {
            name += &format!(",{rules}");
        }
        name
    }

    fn check_robots(&self, robots: usize) -> Result<()> {
        let given = (self.weights.len(), "weight");
        check_count(KIND, given, robots, robots, Self::CURE)?;
        self.rules.check_robots(KIND, robots)
    }
}
