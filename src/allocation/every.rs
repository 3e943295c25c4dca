//! Every n-th item: each robot counts the items that reach it.

use super::items::KnownItems;
use super::own_rules::{OwnRules, RULE_OPTION};
use super::written::{Written, check_count};
use crate::decision::{Action, Snapshot, Strategy};
use crate::dispatch::Rule;
use crate::error::{Error, Result, shown};

/// Its name among the strategies.
const KIND: &str = "every";

/// Every n-th item that reaches a robot is its own; it leaves the others on the belt.
///
/// Each robot counts for itself, as a controller with a sensor before its own workspace does: the items
/// that it has a bin for, when they come within its reach and nobody has claimed them. With 3, 2 and 1,
/// three robots get a third each. Nobody is told what another robot missed; a robot with 1 takes
/// whatever reaches it. `docs/rivals.md` names the line software that works like this.
#[derive(Debug, Clone)]
pub struct Every {
    intervals: Vec<u32>,
    rules: OwnRules,
    items: KnownItems<Vec<Counted>>,
    /// How many items have reached each robot.
    reached: Vec<u64>,
}

/// What a robot made of an item.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Counted {
    /// It has not reached the robot.
    No,
    Own,
    Left,
}

impl Every {
    /// Options and their meanings, for help texts.
    pub(crate) const KEYS: [(&'static str, &'static str); 1] = [RULE_OPTION];

    const MOST: f64 = 1e6;
    const CURE: &str = "give one whole number from 1 to 1000000 for each robot, upstream first, such \
                        as every:2,1";

    /// One interval n for each robot, upstream first: it takes its n-th, 2n-th, ... item, by FIFO.
    ///
    /// # Errors
    /// No interval, or one that is 0.
    pub fn new(intervals: Vec<u32>) -> Result<Self> {
        if intervals.is_empty() || intervals.contains(&0) {
            let problem = match intervals.is_empty() {
                true => "it has no interval",
                false => "an interval is 0",
            };
            return Err(Error::usage(
                format!("'strategy' {KIND}"),
                problem,
                Self::CURE,
            ));
        }
        Ok(Self {
            reached: vec![0; intervals.len()],
            intervals,
            rules: OwnRules::default(),
            items: KnownItems::default(),
        })
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
        let numbers = written.numbers(1.0..=Self::MOST, Self::CURE)?;
        if let Some(place) = numbers.iter().position(|number| number.fract() != 0.0) {
            return Err(Error::usage(
                format!("'strategy' {KIND}"),
                format!("`{}` is not a whole number", shown(written.values[place])),
                Self::CURE,
            ));
        }
        // All are whole and at most a million.
        let mut every = Self::new(numbers.into_iter().map(|number| number as u32).collect())?;
        for (_, rules) in &written.options {
            every.rules = OwnRules::read(&written, rules)?;
        }
        Ok(every)
    }

    /// Counts the items that have reached robots by `time` [s].
    fn count(&mut self, time: f64) {
        let (intervals, reached) = (&self.intervals, &mut self.reached);
        self.items.for_each_free(|item| {
            item.state.resize(intervals.len(), Counted::No);
            for (robot, interval) in intervals.iter().enumerate() {
                let within_reach = item.windows[robot].is_some_and(|(open, _)| open <= time);
                if within_reach && item.state[robot] == Counted::No {
                    reached[robot] += 1;
                    let own = reached[robot].is_multiple_of(u64::from(*interval));
                    item.state[robot] = if own { Counted::Own } else { Counted::Left };
                }
            }
        });
    }
}

impl Strategy for Every {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        self.items.update(snapshot);
        self.count(snapshot.time);
        let items = &self.items;
        let own = |item: u32| {
            let known = items.get(item);
            known.is_some_and(|known| known.state.get(snapshot.robot) == Some(&Counted::Own))
        };
        let pick = self.rules.pick(snapshot, |candidate| own(candidate.item));
        // An item is counted when its window opens, which wakes the robot.
        pick.unwrap_or(Action::WaitForNextWindow)
    }

    fn name(&self) -> String {
        let intervals: Vec<_> = self.intervals.iter().map(u32::to_string).collect();
        let mut name = format!("{KIND}:{}", intervals.join(","));
        if let Some(rules) = self.rules.written() {
            name += &format!(",{rules}");
        }
        name
    }

    fn check_robots(&self, robots: usize) -> Result<()> {
        let given = (self.intervals.len(), "interval");
        check_count(KIND, given, robots, robots, Self::CURE)?;
        self.rules.check_robots(KIND, robots)
    }
}
