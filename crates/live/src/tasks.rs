//! The tasks: those whose result is not known, and those that are over.
//!
//! Invariant: a task is open or over, never both, and its number is below the next one. A
//! task that is over is remembered as long as its item is known, and a while longer, so
//! that a late result still reaches the figures.

use super::claims::Claim;
use super::fate::Fate;
use super::items::Tracked;
use super::protocol::Verdict;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// For so long after its item the result of a task is still accepted [s]: what is older is
/// refused for its stamp.
const REMEMBERED: f64 = super::clock::OLDEST;

/// A task that is over.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Over {
    /// Number of the item.
    pub item: u32,
    /// Index of the robot.
    pub robot: usize,
    /// What the robot has said of it last; none when it has said nothing.
    pub verdict: Option<Verdict>,
}

/// An item that is forgotten, but for its tasks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Gone {
    /// How it is counted.
    pub fate: Fate,
    tasks: Vec<u64>,
    /// Until when they are remembered [s].
    until: f64,
}

/// The tasks that are over, and their items that are forgotten.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PastTasks {
    over: BTreeMap<u64, Over>,
    gone: BTreeMap<u32, Gone>,
}

/// How past tasks differ from what they were.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PastChange {
    /// Tasks by number; nothing for those that are forgotten.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    over: Vec<(u64, Option<Over>)>,
    /// Forgotten items by number; nothing for those whose tasks are forgotten too.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    gone: Vec<(u32, Option<Gone>)>,
}

impl PastChange {
    /// Whether nothing has changed.
    pub fn is_empty(&self) -> bool {
        self.over.is_empty() && self.gone.is_empty()
    }
}

impl PastTasks {
    /// Changes as another has.
    pub fn apply(&mut self, change: PastChange) {
        for (task, over) in change.over {
            match over {
                Some(over) => self.over.insert(task, over),
                None => self.over.remove(&task),
            };
        }
        for (item, gone) in change.gone {
            match gone {
                Some(gone) => self.gone.insert(item, gone),
                None => self.gone.remove(&item),
            };
        }
    }

    /// The robots that it names.
    pub fn robots(&self) -> impl Iterator<Item = usize> + '_ {
        self.over.values().map(|over| over.robot)
    }
}

/// All tasks that are remembered.
#[derive(Debug)]
pub struct Tasks {
    /// Tasks whose result is not known.
    open: BTreeMap<u64, Claim>,
    past: PastTasks,
    next: u64,
    /// What is over or gone and has changed since it was last asked for; none while nobody
    /// asks.
    changed: Option<(BTreeSet<u64>, BTreeSet<u32>)>,
}

impl Default for Tasks {
    fn default() -> Self {
        Self {
            open: BTreeMap::new(),
            past: PastTasks::default(),
            next: 1,
            changed: None,
        }
    }
}

impl Tasks {
    /// The tasks as they were left.
    pub fn restore(open: BTreeMap<u64, Claim>, past: PastTasks, next: u64) -> Self {
        Self {
            open,
            past,
            next,
            changed: None,
        }
    }

    /// The number of a new task.
    pub fn next_number(&mut self) -> u64 {
        self.next += 1;
        self.next - 1
    }

    /// The number that the next task will have.
    pub fn next(&self) -> u64 {
        self.next
    }

    /// Puts a task among the open ones, new or changed.
    pub fn put(&mut self, claim: Claim) {
        self.open.insert(claim.task, claim);
    }

    /// Takes an open task out, to put it back or to close it.
    pub fn take(&mut self, task: u64) -> Option<Claim> {
        self.open.remove(&task)
    }

    /// The open task of this number.
    pub fn get(&self, task: u64) -> Option<&Claim> {
        self.open.get(&task)
    }

    /// The open task of this number, to be changed.
    pub fn get_mut(&mut self, task: u64) -> Option<&mut Claim> {
        self.open.get_mut(&task)
    }

    /// The open tasks by number.
    pub fn iter(&self) -> impl Iterator<Item = &Claim> {
        self.open.values()
    }

    /// The open tasks by number, to be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Claim> {
        self.open.values_mut()
    }

    /// The open tasks as a table.
    pub fn table(&self) -> &BTreeMap<u64, Claim> {
        &self.open
    }

    /// The numbers of the open tasks.
    pub fn numbers(&self) -> Vec<u64> {
        self.open.keys().copied().collect()
    }

    /// The open tasks that keep their item.
    pub fn holding(&self) -> impl Iterator<Item = &Claim> {
        self.open.values().filter(|claim| claim.stage.holds_item())
    }

    /// A task that was taken out is over; `verdict` is what the robot has said of it.
    pub fn close(&mut self, claim: &Claim, verdict: Option<Verdict>) {
        let over = Over {
            item: claim.item,
            robot: claim.robot,
            verdict,
        };
        self.past.over.insert(claim.task, over);
        self.note_change(Some(claim.task), None);
    }

    /// A task that is over.
    pub fn over(&self, task: u64) -> Option<Over> {
        self.past.over.get(&task).copied()
    }

    /// The robot has said of a task that is over what came of it.
    pub fn conclude(&mut self, task: u64, verdict: Verdict) {
        if let Some(over) = self.past.over.get_mut(&task) {
            over.verdict = Some(verdict);
            self.note_change(Some(task), None);
        }
    }

    /// An item that is forgotten was picked after all; how it was counted.
    pub fn picked_after_all(&mut self, item: u32) -> Option<Fate> {
        let gone = self.past.gone.get_mut(&item)?;
        let before = std::mem::replace(&mut gone.fate, Fate::Picked);
        self.note_change(None, Some(item));
        Some(before)
    }

    /// An item is forgotten at `now` [s], with this fate.
    pub fn lose_item(&mut self, item: u32, tracked: &Tracked, fate: Fate, now: f64) {
        if tracked.tasks.is_empty() {
            return;
        }
        let gone = Gone {
            fate,
            tasks: tracked.tasks.clone(),
            until: now + REMEMBERED,
        };
        self.past.gone.insert(item, gone);
        self.note_change(None, Some(item));
    }

    /// Forgets tasks that nobody will report on any more.
    pub fn forget_past(&mut self, now: f64) {
        // Of an item with an open task nothing is forgotten: it ends first.
        let open = &self.open;
        let is_past = |gone: &Gone| {
            gone.until <= now && !gone.tasks.iter().any(|task| open.contains_key(task))
        };
        if !self.past.gone.values().any(is_past) {
            return;
        }
        let past = self.past.gone.iter().filter(|(_, gone)| is_past(gone));
        let past: Vec<u32> = past.map(|(item, _)| *item).collect();
        for item in past {
            for task in self
                .past
                .gone
                .remove(&item)
                .into_iter()
                .flat_map(|g| g.tasks)
            {
                self.past.over.remove(&task);
                self.note_change(Some(task), None);
            }
            self.note_change(None, Some(item));
        }
    }

    /// The next time that something has to be done about an open task [s], and which.
    /// `unreachable` says of a robot whether nothing can be sent to it.
    pub fn next_deadline(&self, unreachable: impl Fn(usize) -> bool) -> Option<(f64, u64)> {
        let due = self.open.values();
        due.filter_map(|claim| Some((claim.due(unreachable(claim.robot))?, claim.task)))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
    }

    /// Takes note of changes of what is over from now on; returns all of it.
    pub fn watch(&mut self) -> PastChange {
        let over = self.past.over.keys().copied().collect();
        let gone = self.past.gone.keys().copied().collect();
        self.changed = Some((over, gone));
        self.take_changed()
    }

    /// What is over or gone and has changed since the last call.
    pub fn take_changed(&mut self) -> PastChange {
        let changed = self.changed.as_mut().map(std::mem::take);
        let (over, gone) = changed.unwrap_or_default();
        let over = over.into_iter();
        let gone = gone.into_iter();
        PastChange {
            over: over.map(|n| (n, self.past.over.get(&n).copied())).collect(),
            gone: gone.map(|n| (n, self.past.gone.get(&n).cloned())).collect(),
        }
    }

    fn note_change(&mut self, task: Option<u64>, item: Option<u32>) {
        if let Some((tasks, items)) = &mut self.changed {
            tasks.extend(task);
            items.extend(item);
        }
    }
}
