//! The tasks: the open ones, and those that are over.
//!
//! Invariant: a task is either open or over, and its number is below the next one. A task that is
//! over is kept while its item is known and for a while longer, so that a late result still reaches
//! the figures.

use super::claims::Claim;
use super::fate::Fate;
use super::items::Tracked;
use super::protocol::Verdict;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// How long after its item has left the belt a task's result is still accepted [s]. Later ones are
/// refused for their timestamp.
const REMEMBERED: f64 = super::clock::OLDEST;

/// A task that is over.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct ClosedTask {
    /// Number of the item.
    pub item: u32,
    /// Index of the robot.
    pub robot: usize,
    /// The robot's last result for it; none if there was none.
    pub verdict: Option<Verdict>,
}

/// A forgotten item whose tasks are still kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ForgottenItem {
    /// The fate that it was counted as.
    pub fate: Fate,
    tasks: Vec<u64>,
    /// Until when its tasks are kept [s].
    until: f64,
}

/// The tasks that are over, and their forgotten items.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct PastTasks {
    over: BTreeMap<u64, ClosedTask>,
    gone: BTreeMap<u32, ForgottenItem>,
}

/// A change of the past tasks.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct PastChange {
    /// Changed tasks by number; none for those that are forgotten.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    over: Vec<(u64, Option<ClosedTask>)>,
    /// Forgotten items by number; none for those whose tasks are forgotten too.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    gone: Vec<(u32, Option<ForgottenItem>)>,
}

impl PastChange {
    /// Whether nothing has changed.
    pub(crate) fn is_empty(&self) -> bool {
        self.over.is_empty() && self.gone.is_empty()
    }
}

impl PastTasks {
    /// Applies a change.
    pub(crate) fn apply(&mut self, change: PastChange) {
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

    /// The indices of the robots in it.
    pub(crate) fn robots(&self) -> impl Iterator<Item = usize> + '_ {
        self.over.values().map(|over| over.robot)
    }
}

/// All tasks that are kept.
#[derive(Debug)]
pub(crate) struct Tasks {
    /// The tasks without a result, by number.
    open: BTreeMap<u64, Claim>,
    past: PastTasks,
    next: u64,
    /// Numbers of past tasks and forgotten items changed since the last [`Tasks::take_changed`];
    /// none while changes are not tracked.
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
    /// Restores the tasks; `next` is the next number.
    pub(crate) fn restore(open: BTreeMap<u64, Claim>, past: PastTasks, next: u64) -> Self {
        Self {
            open,
            past,
            next,
            changed: None,
        }
    }

    /// Takes the number for a new task.
    pub(crate) fn next_number(&mut self) -> u64 {
        self.next += 1;
        self.next - 1
    }

    /// The number that the next task will have.
    pub(crate) fn next(&self) -> u64 {
        self.next
    }

    /// Inserts an open task, or replaces it.
    pub(crate) fn put(&mut self, claim: Claim) {
        self.open.insert(claim.task, claim);
    }

    /// Removes an open task, to be put back or closed.
    pub(crate) fn take(&mut self, task: u64) -> Option<Claim> {
        self.open.remove(&task)
    }

    /// The open task with this number.
    pub(crate) fn get(&self, task: u64) -> Option<&Claim> {
        self.open.get(&task)
    }

    /// The open task with this number, to be changed.
    pub(crate) fn get_mut(&mut self, task: u64) -> Option<&mut Claim> {
        self.open.get_mut(&task)
    }

    /// The open tasks by number.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Claim> {
        self.open.values()
    }

    /// The open tasks by number, to be changed.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Claim> {
        self.open.values_mut()
    }

    /// The open tasks as a table.
    pub(crate) fn table(&self) -> &BTreeMap<u64, Claim> {
        &self.open
    }

    /// The numbers of the open tasks.
    pub(crate) fn numbers(&self) -> Vec<u64> {
        self.open.keys().copied().collect()
    }

    /// The open tasks that reserve their item.
    pub(crate) fn holding(&self) -> impl Iterator<Item = &Claim> {
        self.open.values().filter(|claim| claim.stage.holds_item())
    }

    /// Closes a task that was taken out; `verdict` is the robot's result, if any.
    pub(crate) fn close(&mut self, claim: &Claim, verdict: Option<Verdict>) {
        let over = ClosedTask {
            item: claim.item,
            robot: claim.robot,
            verdict,
        };
        self.past.over.insert(claim.task, over);
        self.note_change(Some(claim.task), None);
    }

    /// The task with this number, if it is over.
    pub(crate) fn over(&self, task: u64) -> Option<ClosedTask> {
        self.past.over.get(&task).copied()
    }

    /// Notes a result for a task that is over.
    pub(crate) fn conclude(&mut self, task: u64, verdict: Verdict) {
        if let Some(over) = self.past.over.get_mut(&task) {
            over.verdict = Some(verdict);
            self.note_change(Some(task), None);
        }
    }

    /// Notes that a forgotten item was picked after all. Returns the fate that it was counted as.
    pub(crate) fn picked_after_all(&mut self, item: u32) -> Option<Fate> {
        let gone = self.past.gone.get_mut(&item)?;
        let before = std::mem::replace(&mut gone.fate, Fate::Picked);
        self.note_change(None, Some(item));
        Some(before)
    }

    /// Notes that an item is forgotten at `now` [s], with this fate.
    pub(crate) fn lose_item(&mut self, item: u32, tracked: &Tracked, fate: Fate, now: f64) {
        if tracked.tasks.is_empty() {
            return;
        }
        let gone = ForgottenItem {
            fate,
            tasks: tracked.tasks.clone(),
            until: now + REMEMBERED,
        };
        self.past.gone.insert(item, gone);
        self.note_change(None, Some(item));
    }

    /// Forgets past tasks whose results can no longer be accepted.
    pub(crate) fn forget_past(&mut self, now: f64) {
        // An item with an open task is kept until that task ends.
        let open = &self.open;
        let is_past = |gone: &ForgottenItem| {
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

    /// Time [s] and number of the next deadline of an open task. `unreachable` tells whether
    /// nothing can be sent to a robot.
    pub(crate) fn next_deadline(&self, unreachable: impl Fn(usize) -> bool) -> Option<(f64, u64)> {
        let due = self.open.values();
        due.filter_map(|claim| Some((claim.due(unreachable(claim.robot))?, claim.task)))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
    }

    /// Tracks changes of the past tasks from now on, and returns all of them.
    pub(crate) fn watch(&mut self) -> PastChange {
        let over = self.past.over.keys().copied().collect();
        let gone = self.past.gone.keys().copied().collect();
        self.changed = Some((over, gone));
        self.take_changed()
    }

    /// Takes the changes of the past tasks since the last call.
    pub(crate) fn take_changed(&mut self) -> PastChange {
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
