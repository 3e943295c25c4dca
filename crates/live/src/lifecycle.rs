//! The life of a task as a state machine: one table of stages and events.
//!
//! `docs/protocol.md` shows the same table; a test checks that the two are equal. `Sent`,
//! `Acknowledged` and `Cancelling` reserve the item, so that no other robot is sent to it;
//! `Recalled` does not.

use serde::{Deserialize, Serialize};

/// The stage of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Stage {
    /// Sent, but perhaps not received.
    Sent,
    /// The robot has confirmed that it sets out.
    Acknowledged,
    /// The robot was asked to drop it and has not answered. The item stays reserved, because the
    /// robot may have met it already.
    Cancelling,
    /// The robot was asked to drop it and has not answered. The item is free, picked or written
    /// off.
    Recalled,
}

impl Stage {
    /// The name of the stage, as displayed.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Sent => "sent",
            Self::Acknowledged => "acknowledged",
            Self::Cancelling => "cancelling",
            Self::Recalled => "recalled",
        }
    }

    /// Whether the item is reserved for this task.
    pub(crate) fn holds_item(self) -> bool {
        self != Self::Recalled
    }

    /// Whether a `cancel` is repeated until the robot answers.
    pub(crate) fn is_cancelled(self) -> bool {
        matches!(self, Self::Cancelling | Self::Recalled)
    }
}

/// An event of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TaskEvent {
    /// The robot has acknowledged it.
    Ack,
    /// The robot has the item in the bin.
    Picked,
    /// The grasp has failed.
    GraspFailed,
    /// The robot came too late or did not find the item.
    NotFound,
    /// The robot has refused the task.
    Refused,
    /// The robot has dropped the task.
    Dropped,
    /// No acknowledgement came within the timeout, but the task can still be done.
    Unheard,
    /// The task can no longer be done, or was stopped.
    Impossible,
    /// The task was acknowledged, and its result is overdue.
    NoResult,
    /// The task was never acknowledged, and its answer is overdue.
    NoAnswer,
    /// The robot is out of service, and cannot have reached the item.
    FaultBefore,
    /// The robot is out of service, and may have the item in its gripper.
    FaultAfter,
    /// Another robot has picked the item.
    TakenByOther,
    /// Nothing can come of the task any more.
    Moot,
}

/// The effect of a step on the item.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Effect {
    /// Nothing.
    Keep,
    /// The item is picked.
    Pick,
    /// The item is free again.
    Return,
    /// An attempt has failed; the item is free again, or given up after too many attempts.
    Attempt,
    /// The item is free again, but not for this robot.
    Refuse,
    /// The item is free again, for this robot only after a while.
    Withhold,
    /// The item's fate is unknown; no robot is sent to it any more.
    WriteOff,
}

/// The stage after an event, none when the task is over, and the effect on the item.
pub(crate) type Transition = (Option<Stage>, Effect);

impl Stage {
    /// The step that `event` causes at this stage; none if it changes nothing.
    pub(crate) fn after(self, event: TaskEvent) -> Option<Transition> {
        use Effect::{Attempt, Keep, Pick, Refuse, Return, Withhold, WriteOff};
        use Stage::{Acknowledged, Cancelling, Recalled, Sent};
        let over = |effect| Some((None, effect));
        let to = |stage, effect| Some((Some(stage), effect));
        match (event, self) {
            (TaskEvent::Ack, Sent) => to(Acknowledged, Keep),
            (TaskEvent::Ack, Acknowledged | Cancelling | Recalled) => None,

            (TaskEvent::Picked, _) => over(Pick),
            (TaskEvent::GraspFailed | TaskEvent::NotFound, Sent | Acknowledged | Cancelling) => {
                over(Attempt)
            }
            (TaskEvent::Refused, Sent | Acknowledged | Cancelling) => over(Refuse),
            (TaskEvent::Dropped, Sent | Acknowledged) => over(Withhold),
            (TaskEvent::Dropped, Cancelling) => over(Return),
            (
                TaskEvent::GraspFailed
                | TaskEvent::NotFound
                | TaskEvent::Refused
                | TaskEvent::Dropped,
                Recalled,
            ) => over(Keep),

            (TaskEvent::Unheard, Sent) => to(Sent, Keep),
            (TaskEvent::Unheard, Acknowledged | Cancelling | Recalled) => None,
            (TaskEvent::Impossible, Sent | Acknowledged) => to(Cancelling, Keep),
            (TaskEvent::Impossible, Cancelling | Recalled) => None,

            (TaskEvent::NoResult, Acknowledged | Cancelling) => over(WriteOff),
            (TaskEvent::NoResult, Sent | Recalled) => None,
            (TaskEvent::NoAnswer, Sent | Cancelling) => to(Recalled, Return),
            (TaskEvent::NoAnswer, Acknowledged | Recalled) => None,

            (TaskEvent::FaultBefore, Sent | Acknowledged | Cancelling) => to(Recalled, Return),
            (TaskEvent::FaultAfter, Acknowledged | Cancelling) => to(Recalled, WriteOff),
            (TaskEvent::FaultBefore, Recalled) | (TaskEvent::FaultAfter, Sent | Recalled) => None,
            (TaskEvent::TakenByOther, Sent | Acknowledged | Cancelling) => to(Recalled, Keep),
            (TaskEvent::TakenByOther, Recalled) => None,
            (TaskEvent::Moot, Recalled) => over(Keep),
            (TaskEvent::Moot, Sent | Acknowledged | Cancelling) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Stage {
        /// All of them.
        pub(crate) const ALL: [Self; 4] = [
            Self::Sent,
            Self::Acknowledged,
            Self::Cancelling,
            Self::Recalled,
        ];
    }

    impl TaskEvent {
        /// All of them, in the order of the table.
        pub(crate) const ALL: [Self; 14] = [
            Self::Ack,
            Self::Picked,
            Self::GraspFailed,
            Self::NotFound,
            Self::Refused,
            Self::Dropped,
            Self::Unheard,
            Self::Impossible,
            Self::NoResult,
            Self::NoAnswer,
            Self::FaultBefore,
            Self::FaultAfter,
            Self::TakenByOther,
            Self::Moot,
        ];

        /// The text in the table in the docs.
        pub(crate) fn describe(self) -> &'static str {
            match self {
                Self::Ack => "`ack`",
                Self::Picked => "`PICKED`",
                Self::GraspFailed => "`GRASP_FAIL`",
                Self::NotFound => "`MISSED`",
                Self::Refused => "`REJECTED`",
                Self::Dropped => "`CANCELLED`",
                Self::Unheard => "no `ack` in time, can still be done",
                Self::Impossible => "cannot be done any more, or was stopped",
                Self::NoResult => "acknowledged, result overdue",
                Self::NoAnswer => "never acknowledged, answer overdue",
                Self::FaultBefore => "`fault` before `meet_at`, or never acknowledged",
                Self::FaultAfter => "`fault` from `meet_at` on",
                Self::TakenByOther => "`PICKED` by another robot",
                Self::Moot => "no result is possible any more",
            }
        }
    }

    impl Effect {
        /// The text in the table in the docs.
        pub(crate) fn describe(self) -> &'static str {
            match self {
                Self::Keep => "",
                Self::Pick => "picked",
                Self::Return => "returns",
                Self::Attempt => "returns, one attempt less",
                Self::Refuse => "returns, not to this robot",
                Self::Withhold => "returns, to this robot later",
                Self::WriteOff => "`no_result`",
            }
        }
    }

    fn table() -> String {
        let mut lines = vec![
            "| event | sent | acknowledged | cancelling | recalled |".to_owned(),
            "|---|---|---|---|---|".to_owned(),
        ];
        for event in TaskEvent::ALL {
            let cells = Stage::ALL.map(|stage| match stage.after(event) {
                None => "-".to_owned(),
                Some((next, effect)) => {
                    let next = next.map_or("over", Stage::name);
                    match effect.describe() {
                        "" => next.to_owned(),
                        effect => format!("{next}; {effect}"),
                    }
                }
            });
            lines.push(format!("| {} | {} |", event.describe(), cells.join(" | ")));
        }
        lines.join("\n")
    }

    #[test]
    fn the_docs_show_the_table() {
        let docs = include_str!("../../../docs/protocol.md");
        let table = table();
        assert!(docs.contains(&table), "docs/protocol.md lacks:\n{table}");
    }

    #[test]
    fn the_item_is_never_given_away_twice() {
        for event in TaskEvent::ALL {
            for stage in Stage::ALL {
                let Some((next, effect)) = stage.after(event) else {
                    continue;
                };
                let keeps = next.is_some_and(Stage::holds_item);
                match effect {
                    // A task that still reserves the item has not returned it.
                    Effect::Keep => {}
                    Effect::Pick => assert_eq!(next, None),
                    _ => assert!(stage.holds_item() && !keeps, "{stage:?} {event:?}"),
                }
                // A recalled task never reserves the item again.
                assert!(stage.holds_item() || !keeps);
            }
        }
    }

    #[test]
    fn every_task_comes_to_an_end() {
        for stage in Stage::ALL {
            let results = [
                TaskEvent::Picked,
                TaskEvent::GraspFailed,
                TaskEvent::NotFound,
                TaskEvent::Refused,
                TaskEvent::Dropped,
            ];
            for event in results {
                assert!(matches!(stage.after(event), Some((None, _))));
            }
        }
        // If the robot never answers: unheard, cancelled, recalled, moot.
        let steps = [TaskEvent::Impossible, TaskEvent::NoAnswer, TaskEvent::Moot];
        let end = steps.iter().try_fold(Stage::Sent, |stage, event| {
            stage.after(*event).and_then(|(next, _)| next)
        });
        assert_eq!(end, None);
    }
}
