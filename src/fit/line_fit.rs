//! The fit of a whole line.

use super::arm_fit::fit_arm;
use super::arm_result::ArmFit;
use super::bench::LEAST_MOVES;
use super::options::FitOptions;
use super::places::check_places;
use super::timed_move::{TimedMove, check_units, without_copies};
use crate::error::{Error, Result};
use crate::station::Station;

/// The fit of a whole line.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct LineFit {
    /// For each robot of the station its fit; `None` for one that has too few moves.
    pub arms: Vec<Option<ArmFit>>,
}

/// Fits the law of every robot of `station` that `moves` are of. What they do not tell is taken from
/// the station, and so is all of a robot with too few moves.
///
/// # Errors
/// Invalid options; no moves; too few moves of every robot; times or places that no arm has; places
/// none of which the station has.
pub fn fit_line(station: &Station, moves: &[TimedMove], options: &FitOptions) -> Result<LineFit> {
    options.check()?;
    if moves.is_empty() {
        return Err(Error::input(
            "moves",
            "there is none with a time",
            "give rows with depart_s and grasp_s, or with release_s and the bin",
        ));
    }
    check_units(moves)?;
    let count = |index: usize| moves.iter().filter(|m| m.robot == index).count();
    let robots = 0..station.robots().len();
    // If no robot has enough, the fit of any says what is missing.
    let least = match robots.clone().any(|index| count(index) >= LEAST_MOVES) {
        true => LEAST_MOVES,
        false => 1,
    };
    let fit = |index: usize| {
        let own: Vec<TimedMove> = moves.iter().filter(|m| m.robot == index).cloned().collect();
        let all = own.len();
        let own = without_copies(own);
        if own.len() < least {
            return Ok(None);
        }
        let robot = &station.robots()[index];
        let mut notes = check_places(robot, station.belt(), &own)?;
        if own.len() < all {
            notes.push(format!(
                "{} of {all} moves are copies of others, with the same times and places, and do not count",
                all - own.len()
            ));
        }
        let mut fit = fit_arm(robot, index, &own, options)?;
        notes.append(&mut fit.notes);
        Ok(Some(ArmFit { notes, ..fit }))
    };
    let arms: Result<Vec<_>> = robots.map(fit).collect();
    Ok(LineFit { arms: arms? })
}
