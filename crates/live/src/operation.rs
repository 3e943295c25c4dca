//! What the operator wants: the line, or one robot, at work, paused, drained or stopped.

use serde::{Deserialize, Serialize};

/// What the operator wants of the line or of a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Tasks are given.
    #[default]
    Running,
    /// No new task is given; open ones are carried out.
    Paused,
    /// Items that are known are picked; those that come are let pass.
    Draining,
    /// No new task is given, and open ones are cancelled.
    Stopped,
}

/// What the operator wants of the line and of each robot.
///
/// Invariant: a robot does not drain; what its own mode allows, that of the line has to
/// allow too.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Operation {
    line: Mode,
    /// Robots that are not at work, by index.
    robots: Vec<(usize, Mode)>,
}

impl Operation {
    /// What is wanted of the line.
    pub fn line(&self) -> Mode {
        self.line
    }

    /// What is wanted of a robot by itself.
    pub fn robot(&self, robot: usize) -> Mode {
        let found = self.robots.iter().find(|(index, _)| *index == robot);
        found.map_or(Mode::Running, |(_, mode)| *mode)
    }

    /// The operator wants `mode` of the line, or of one robot. The line at work again does
    /// not put a robot back to work that was paused by itself.
    pub fn order(&mut self, robot: Option<usize>, mode: Mode) {
        let Some(robot) = robot else {
            self.line = mode;
            return;
        };
        self.robots.retain(|(index, _)| *index != robot);
        if mode != Mode::Running {
            // One that drains gets no task of its own: its items are the line's.
            let mode = match mode {
                Mode::Draining => Mode::Paused,
                mode => mode,
            };
            self.robots.push((robot, mode));
            self.robots.sort_unstable_by_key(|(index, _)| *index);
        }
    }

    /// Whether a robot may be given tasks.
    pub fn allows(&self, robot: usize) -> bool {
        let line = matches!(self.line, Mode::Running | Mode::Draining);
        line && self.robot(robot) == Mode::Running
    }

    /// The robots that it names.
    pub fn robots(&self) -> impl Iterator<Item = usize> + '_ {
        self.robots.iter().map(|(index, _)| *index)
    }
}

impl Mode {
    /// As a status names it; a line that drains is drained once nothing is `left`.
    pub fn name(self, left: bool) -> &'static str {
        match self {
            Self::Running => "running",
            Self::Paused => "paused",
            Self::Draining if left => "draining",
            Self::Draining => "drained",
            Self::Stopped => "stopped",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_works_where_both_orders_allow_it() {
        let mut operation = Operation::default();
        assert!(operation.allows(1));
        operation.order(Some(1), Mode::Draining);
        assert_eq!(operation.robot(1), Mode::Paused);
        assert!(!operation.allows(1) && operation.allows(0));
        operation.order(None, Mode::Stopped);
        operation.order(Some(1), Mode::Running);
        assert!(!operation.allows(0) && !operation.allows(1));
        operation.order(None, Mode::Draining);
        assert!(operation.allows(0) && operation.allows(1));
        assert_eq!(operation.robots().count(), 0);
    }
}
