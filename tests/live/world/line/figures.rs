//! What came of it.

use super::{Line, Pace};
use crate::world::robot::Finds;
use crate::world::truth::Fate;
use pickline_live::protocol::Status;
use std::fmt;

/// What came of it.
pub struct Figures {
    pub clock: &'static str,
    pub items: usize,
    pub kills: usize,
    pub breaks: usize,
    pub tasks: usize,
    pub grasped: usize,
    pub failed: usize,
    pub beside: Vec<f64>,
    pub taken: usize,
    pub nothing: usize,
    pub second: usize,
    pub refused: usize,
    pub two_after_one: usize,
    pub in_bins: Vec<usize>,
    pub dropped: usize,
    pub statuses: usize,
    pub picked: u64,
    pub status: Status,
    pub seconds: f64,
}

impl Line {
    pub(super) fn finish(mut self, seconds: f64) -> Figures {
        let by_clock = self.settings.pace == Pace::Clock;
        let (said, remarks) = self.node.finish(by_clock);
        self.hear(said);
        let status = self.status.take().expect("a status");
        assert!(status.last, "{status:?} {remarks}");
        let all = self.robots.iter().fold(Finds::default(), |mut all, robot| {
            let finds = &robot.finds;
            all.grasped += finds.grasped;
            all.failed += finds.failed;
            all.beside.extend(&finds.beside);
            all.taken += finds.taken;
            all.nothing += finds.nothing;
            all.second += finds.second;
            all.refused += finds.refused;
            all
        });
        let fates = &self.truth.fates;
        Figures {
            clock: if by_clock { "system" } else { "messages" },
            items: fates.len(),
            kills: self.figures.kills,
            breaks: self.figures.breaks,
            tasks: self.tasks.len(),
            grasped: all.grasped,
            failed: all.failed,
            beside: all.beside,
            taken: all.taken,
            nothing: all.nothing,
            second: all.second,
            refused: all.refused,
            two_after_one: self.figures.two_after_one,
            in_bins: (0..self.robots.len())
                .map(|robot| self.truth.in_bin(robot))
                .collect(),
            dropped: fates.iter().filter(|fate| **fate == Fate::Dropped).count(),
            statuses: self.figures.statuses,
            picked: status.picked,
            status,
            seconds,
        }
    }
}

impl Figures {
    /// Robots were sent to where nothing is, per 1,000 items.
    fn ghosts(&self) -> f64 {
        1e3 * (self.taken + self.nothing) as f64 / self.items as f64
    }

    /// What has to hold.
    pub fn check(&self) {
        let status = &self.status;
        let in_bins: usize = self.in_bins.iter().sum();
        // What is in the bins was counted, but for what nobody ever said.
        let doubtful = status.missed.no_result;
        let picked = status.picked..=status.picked + doubtful;
        assert!(picked.contains(&(in_bins as u64)), "{self}");
        for (in_bin, robot) in self.in_bins.iter().zip(&status.robots) {
            let picked = robot.picked..=robot.picked + doubtful;
            assert!(picked.contains(&(*in_bin as u64)), "{self}");
        }
        assert_eq!(status.seen, status.picked + status.missed.total(), "{self}");
        assert!(status.open_tasks.is_empty(), "{self}");
        assert_eq!(status.noted.get("picked_twice"), None, "{self}");
        assert_eq!(self.grasped, in_bins + self.dropped, "{self}");
        assert_eq!(self.second, 0, "{self}");
        // What the camera makes up is 5 items in 1,000, and three attempts at each.
        let few = 0.02 * self.items as f64 + 2.0;
        assert!((self.taken + self.nothing) as f64 <= 1.5 * few, "{self}");
        assert!((self.two_after_one as f64) < few, "{self}");
        assert!(
            (status.seen as f64 - self.items as f64).abs() <= few,
            "{self}"
        );
    }
}

impl fmt::Display for Figures {
    /// A row of the table in docs/live.md, and the rest below it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (status, missed) = (&self.status, &self.status.missed);
        let others = missed.total() - missed.not_found - missed.no_result;
        writeln!(
            f,
            "| {} | {} | {}, {} | {} | {} | {} | {}, {}, {} | {} | {} | {} ({:.0} per 1,000 items) |",
            self.clock,
            self.items,
            self.kills,
            self.breaks,
            status.seen,
            status.picked,
            self.in_bins.iter().sum::<usize>(),
            missed.not_found,
            missed.no_result,
            others,
            self.tasks,
            self.beside.len(),
            self.taken + self.nothing,
            self.ghosts(),
        )?;
        let worst = self.beside.iter().fold(0.0, |a: f64, b| a.max(*b));
        writeln!(
            f,
            "{:.0} s, {} statuses; {} grasped, {} slipped, at most {:.0} mm beside, {} taken before, \
             {} never there, {} too late, {} second tasks, {} after the item of another",
            self.seconds,
            self.statuses,
            self.grasped,
            self.failed,
            1e3 * worst,
            self.taken,
            self.nothing,
            self.refused,
            self.second,
            self.two_after_one
        )?;
        write!(
            f,
            "in the bins {:?}, {} dropped; {missed:?}, noted {:?}, refused {:?}, {:?}",
            self.in_bins, self.dropped, status.noted, status.rejected, status.robots
        )
    }
}
