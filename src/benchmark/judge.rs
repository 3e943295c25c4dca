//! Whose picks count: the independent checker decides.

use super::instance::Instance;
use crate::checker::{self, Terms, Violation, read_picks, violations};
use crate::decision::{FailureCause, Figures, Pick};
use crate::error::{Error, Result, rounded, shown};
use crate::files::csv_text;

/// Picks and failed attempts, the latter with their cause.
pub type Attempts = Vec<(Pick, Option<FailureCause>)>;

/// A run without violations.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct Solution {
    /// Its attempts.
    pub attempts: Attempts,
    /// Its figures, computed from the attempts.
    pub figures: Figures,
}

/// The solution that `attempts` are, under `terms`.
///
/// # Errors
/// [`Refuted`](crate::error::ErrorKind::Refuted): the first violation.
pub fn judge(instance: &Instance, attempts: Attempts, terms: Terms) -> Result<Solution> {
    let (station, pattern) = (&instance.station, &instance.pattern);
    let found = violations(station, pattern, &attempts, terms);
    if let Some(first) = found.first() {
        return Err(Error::refuted(in_words(first, instance)));
    }
    let figures = checker::figures(station, pattern, &attempts);
    Ok(Solution { attempts, figures })
}

/// A violation with the names of robot and item; where they do not exist, with the place in the list.
fn in_words(violation: &Violation, instance: &Instance) -> String {
    let robot = instance.station.robots().get(violation.robot);
    let item = instance.pattern.items().get(violation.item as usize);
    let who = match (robot, item) {
        (Some(robot), Some(item)) => {
            format!("robot `{}`, item `{}`", shown(&robot.name), shown(&item.id))
        }
        _ => format!("pick number {}", violation.attempt + 1),
    };
    let time = rounded(violation.time, 9);
    format!("{who}, at t = {time} s: {}", violation.problem)
}

/// The attempts in the text of a file of picks; messages call it `name`.
///
/// # Errors
/// As for [`read_picks`].
pub(super) fn read(instance: &Instance, text: &str, name: &str) -> Result<Attempts> {
    let read = read_picks(text, name, &instance.station, &instance.pattern)?;
    Ok(read.attempts)
}

/// `attempts` as a file of picks, in order of decision and robot. Times are written to the last bit; where an
/// item was met follows from them.
pub fn picks_csv(instance: &Instance, attempts: &Attempts) -> String {
    let robots = instance.station.robots();
    let items = instance.pattern.items();
    let mut attempts: Vec<_> = attempts
        .iter()
        .filter(|(_, cause)| cause.is_none())
        .collect();
    attempts.sort_by(|(a, _), (b, _)| {
        let times = a.decide.total_cmp(&b.decide);
        times.then(a.robot.cmp(&b.robot))
    });
    let header = ["robot", "item", "decide_s", "grasp_s", "release_s"].map(str::to_owned);
    let row = |(pick, _): &(Pick, Option<FailureCause>)| {
        [
            robots[pick.robot].name.clone(),
            items[pick.item as usize].id.clone(),
            pick.decide.to_string(),
            pick.grasp.to_string(),
            pick.release.to_string(),
        ]
    };
    csv_text(std::iter::once(header).chain(attempts.into_iter().map(row)))
}
