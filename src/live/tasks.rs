//! The tasks: those whose result is not known, and those that are over.
//!
//! Invariant: a task is open or over, never both, and its number is below the next one.
//! Of those that are over none is kept whose item is forgotten.

use super::claims::Claim;
use super::items::Tracked;
use std::collections::BTreeMap;

/// All tasks that are remembered.
#[derive(Debug)]
pub struct Tasks {
    /// Tasks whose result is not known.
    open: BTreeMap<u64, Claim>,
    /// Tasks that are over, with their item, until that is forgotten.
    over: BTreeMap<u64, u32>,
    next: u64,
}

impl Default for Tasks {
    fn default() -> Self {
        Self {
            open: BTreeMap::new(),
            over: BTreeMap::new(),
            next: 1,
        }
    }
}

impl Tasks {
    /// The tasks of these items as they were left.
    pub fn restore(open: BTreeMap<u64, Claim>, items: &BTreeMap<u32, Tracked>, next: u64) -> Self {
        let tasks = items.iter().flat_map(|(item, tracked)| {
            let over = tracked.tasks.iter();
            let over = over.filter(|task| !open.contains_key(task));
            over.map(|task| (*task, *item))
        });
        Self {
            over: tasks.collect(),
            open,
            next,
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

    /// Takes an open task out, to put it back.
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

    /// How many are open.
    pub fn len(&self) -> usize {
        self.open.len()
    }

    /// A task is over. It is remembered with its item, if that is still `known`.
    pub fn close(&mut self, task: u64, known: impl FnOnce(u32) -> bool) -> Option<Claim> {
        let claim = self.open.remove(&task)?;
        if known(claim.item) {
            self.over.insert(task, claim.item);
        }
        Some(claim)
    }

    /// The item of a task that is over.
    pub fn over(&self, task: u64) -> Option<u32> {
        self.over.get(&task).copied()
    }

    /// Forgets tasks that are over.
    pub fn forget(&mut self, tasks: &[u64]) {
        for task in tasks {
            self.over.remove(task);
        }
    }

    /// The next time that something has to be done about an open task that `fits` [s], and
    /// which.
    pub fn next_deadline(&self, fits: impl Fn(&Claim) -> bool) -> Option<(f64, u64)> {
        let due = self.open.values().filter(|claim| fits(claim));
        due.map(|claim| (claim.deadline, claim.task))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
    }
}
