//! `pickline pattern`.

mod describe;
mod generate;
mod import;
mod target;

use super::args::{ImportCommand, PatternCommand};
use super::session::Session;
use pickline::error::Result;

pub(crate) fn run(command: PatternCommand, session: &Session) -> Result<()> {
    match command {
        PatternCommand::Generate(args) => generate::run(*args, session),
        PatternCommand::Describe(args) => describe::run(args, session),
        PatternCommand::Import(ImportCommand::Tracks(args)) => import::run(*args, session),
    }
}
