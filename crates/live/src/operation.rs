//! The operator's orders: the line or a robot is running, paused, draining or stopped.

use serde::{Deserialize, Serialize};

/// The operator's order for the line or for a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Mode {
    /// Tasks are given.
    #[default]
    Running,
    /// No new task is given; open ones are carried out.
    Paused,
    /// Known items are picked; later ones are let pass.
    Draining,
    /// No new task is given; open ones are cancelled.
    Stopped,
}

/// The operator's orders for the line and for each robot.
///
/// Invariant: a robot's own mode is never `Draining`. A robot works if both its own mode and the
/// line's allow it.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub(crate) struct Operation {
    line: Mode,
    /// Robots whose own mode is not `Running`, by index.
    robots: Vec<(usize, Mode)>,
}

impl Operation {
    /// The mode that the operator ordered for the whole line.
    pub(crate) fn line(&self) -> Mode {
        self.line
    }

    /// A robot's own mode.
    pub(crate) fn robot(&self, robot: usize) -> Mode {
        let found = self.robots.iter().find(|(index, _)| *index == robot);
        found.map_or(Mode::Running, |(_, mode)| *mode)
    }

    /// Sets the mode of the line or of one robot. Resuming the line does not resume a robot that
    /// was paused individually.
    pub(crate) fn order(&mut self, robot: Option<usize>, mode: Mode) {
        let Some(robot) = robot else {
            self.line = mode;
            return;
        };
        self.robots.retain(|(index, _)| *index != robot);
        if mode != Mode::Running {
            // For a single robot, draining means pausing, because items belong to the line.
            let mode = match mode {
                Mode::Draining => Mode::Paused,
                mode => mode,
            };
            self.robots.push((robot, mode));
            self.robots.sort_unstable_by_key(|(index, _)| *index);
        }
    }

    /// Whether a robot may get tasks.
    pub(crate) fn allows(&self, robot: usize) -> bool {
        let line = matches!(self.line, Mode::Running | Mode::Draining);
        line && self.robot(robot) == Mode::Running
    }

    /// The robots that have an order of their own.
    pub(crate) fn robots(&self) -> impl Iterator<Item = usize> + '_ {
        self.robots.iter().map(|(index, _)| *index)
    }
}

impl Mode {
    /// The `mode` of a status. A draining line is drained once nothing is `left`.
    pub(crate) fn name(self, left: bool) -> &'static str {
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
