//! A station with a pattern on its belt, made ready to simulate.

use crate::decision::{Candidate, Figures};
use crate::error::{Error, Result, shown_number};
use crate::pattern::Pattern;
use crate::station::Station;

/// A pattern on a station, with every departure window computed once. All runs of
/// the pattern share it, whatever the strategy.
#[derive(Debug, Clone)]
pub struct Scene<'a> {
    station: &'a Station,
    pattern: &'a Pattern,
    /// Per robot, the items that it has a window for, by opening time, then index.
    queues: Vec<Vec<Candidate>>,
    independent: bool,
    update_hz: f64,
}

impl<'a> Scene<'a> {
    /// Puts `pattern` on `station`. Takes O(N n log n) for N robots and n items.
    ///
    /// # Errors
    /// An item beside the belt.
    pub fn new(station: &'a Station, pattern: &'a Pattern) -> Result<Self> {
        pattern.check_on(station)?;
        let belt = station.belt();
        let mut queues = vec![Vec::new(); station.robots().len()];
        let mut independent = true;
        for (index, item) in pattern.items().iter().enumerate() {
            let weight = item.reward();
            let mut upstream_close = f64::NEG_INFINITY;
            for (robot, queue) in station.robots().iter().zip(&mut queues) {
                let Some((open, close)) = robot.departure_window(belt, item.x0, item.y) else {
                    continue;
                };
                independent &= upstream_close < open;
                upstream_close = upstream_close.max(close);
                queue.push(Candidate {
                    // Patterns hold at most ten million items.
                    item: index as u32,
                    x0: item.x0,
                    y: item.y,
                    weight,
                    open,
                    close,
                });
            }
        }
        for queue in &mut queues {
            queue.sort_by(|a, b| a.open.total_cmp(&b.open));
        }
        Ok(Self {
            station,
            pattern,
            queues,
            independent,
            update_hz: 0.0,
        })
    }

    /// The same scene with decisions at multiples of `1 / hz` seconds only (the
    /// paper's system updates at 10 Hz); 0 is exact.
    ///
    /// # Errors
    /// A frequency that is negative or not a number, or past 1 MHz.
    pub fn with_update_hz(mut self, hz: f64) -> Result<Self> {
        if !(hz == 0.0 || (1e-6..=1e6).contains(&hz)) {
            return Err(Error::input(
                "--update-hz",
                format!("{} is not an update frequency", shown_number(hz)),
                "give Hz, from 1e-6 to 1e6, or 0 for exact decisions",
            ));
        }
        self.update_hz = hz;
        Ok(self)
    }

    /// The station.
    pub fn station(&self) -> &'a Station {
        self.station
    }

    /// The pattern.
    pub fn pattern(&self) -> &'a Pattern {
        self.pattern
    }

    /// The items that robot `index` has a window for, by opening time, then index.
    pub fn queue(&self, index: usize) -> &[Candidate] {
        &self.queues[index]
    }

    /// Whether downstream decisions can never change upstream ones: for every item
    /// and every pair of robots that have a window for it, the upstream one's closes
    /// strictly before the downstream one's opens.
    pub fn is_independent(&self) -> bool {
        self.independent
    }

    /// `time` [s] rounded up to the next update; a value within 1e-9 ticks of one
    /// stays as it is.
    pub(super) fn tick(&self, time: f64) -> f64 {
        if self.update_hz == 0.0 || !time.is_finite() {
            return time;
        }
        let ticks = time * self.update_hz;
        if (ticks - ticks.round()).abs() <= 1e-9 {
            time
        } else {
            // The quotient may fall a rounding short of the value it rounds up.
            (ticks.ceil() / self.update_hz).max(time)
        }
    }

    /// The figures of a run whose last release is at `last_release` [s] and in which
    /// `last_missing` was the last unpicked item.
    pub(super) fn figures(
        &self,
        picked: usize,
        weight: f64,
        last_release: f64,
        last_missing: Option<usize>,
    ) -> Figures {
        Figures {
            items: self.pattern.len(),
            picked,
            weight,
            end: match last_missing {
                None => last_release,
                Some(item) => last_release.max(self.leaves_belt(item)),
            },
        }
    }

    /// When item `index` would leave the belt [s].
    pub(super) fn leaves_belt(&self, index: usize) -> f64 {
        let belt = self.station.belt();
        (belt.length - self.pattern.items()[index].x0) / belt.speed
    }
}
