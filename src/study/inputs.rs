//! What a study is made on, so that shards of different files are not put together.

use super::robust::RobustTraining;
use crate::error::{Error, Result};
use crate::files;
use crate::optimize::Environment;
use crate::pattern::Pattern;
use crate::strategies::{policy_file, weight_files};

/// A hash of `patterns`, to the last bit of every figure.
pub(super) fn patterns_hash<'p>(patterns: impl IntoIterator<Item = &'p Pattern>) -> String {
    let mut text = String::new();
    for pattern in patterns {
        // All fields of the items; figures are written so that they are read back exactly.
        text += &format!("{:?}\n", pattern.items());
    }
    files::fingerprint(text)
}

/// Checks that all shards use the same named patterns for training.
///
/// # Errors
/// Others than those of other shards.
pub(super) fn check_same_training(
    training: &RobustTraining,
    environment: &Environment,
) -> Result<()> {
    match training {
        RobustTraining::On(set) => environment
            .ledger
            .check_input("the training patterns", || Ok(patterns_hash(&set.patterns))),
        _ => Ok(()),
    }
}

/// Checks that all shards use the same strategies, of which a station file may name one, and the same
/// policy files.
///
/// # Errors
/// A file that cannot be read, or is another one.
pub(crate) fn check_strategies<'s>(
    strategies: impl IntoIterator<Item = &'s str>,
    environment: &Environment,
) -> Result<()> {
    let strategies: Vec<&str> = strategies.into_iter().collect();
    environment
        .ledger
        .check_input("the list of strategies", || Ok(strategies.join(" ")))?;
    for file in strategies.into_iter().filter_map(policy_file) {
        let name = format!("the policy {}", file.display());
        environment.ledger.check_input(&name, || {
            let mut content = Vec::new();
            for part in [file.to_owned()].iter().chain(&weight_files(file)) {
                content.extend(std::fs::read(part).map_err(|error| Error::read(part, error))?);
            }
            Ok(files::fingerprint(content))
        })?;
    }
    Ok(())
}
