//! What an error holds, and the message that it makes of it.

use super::kind::ErrorKind;
use super::path_cure::io_cure;
use super::wording::shown;
use std::error::Error as StdError;
use std::fmt;
use std::io;
use std::path::PathBuf;

/// What happened, and the error that caused it.
#[derive(Debug)]
pub(super) struct ErrorContent {
    pub(super) details: Details,
    pub(super) cause: Option<Box<dyn StdError + Send + Sync>>,
}

/// What a message is made of.
#[derive(Debug)]
pub(super) enum Details {
    Described {
        kind: ErrorKind,
        place: String,
        problem: String,
        cure: String,
    },
    File {
        /// `read` or `write`.
        action: &'static str,
        /// The path as the user gave it.
        path: PathBuf,
        source: io::Error,
    },
    IllegalAction {
        /// Time of the decision [s].
        time: f64,
        /// Name of the deciding robot.
        robot: String,
        problem: String,
        cure: String,
    },
    Refuted(String),
    Interrupted,
    Sharded,
    Internal(String),
}

impl fmt::Display for Details {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Details::Described {
                place,
                problem,
                cure,
                ..
            } => write!(f, "{place}: {problem}\n  cure: {cure}"),
            Details::File {
                action,
                path,
                source,
            } => {
                let cure = io_cure(action, path, source);
                let path = path.display();
                write!(f, "cannot {action} {path}: {source}\n  cure: {cure}")
            }
            Details::IllegalAction {
                time,
                robot,
                problem,
                cure,
            } => {
                let robot = shown(robot);
                write!(
                    f,
                    "illegal action at t = {time} s by robot `{robot}`: {problem}\n  cure: {cure}"
                )
            }
            Details::Refuted(problem) => write!(f, "the checker rejects this run: {problem}"),
            Details::Interrupted => f.write_str("interrupted before the first result"),
            Details::Sharded => f.write_str("only one shard of the work is done"),
            Details::Internal(problem) => write!(
                f,
                "{problem}\n  cure: this is a defect of pickline; please report it with the command \
                 line and the files"
            ),
        }
    }
}
